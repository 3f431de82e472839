"""Rational B-splines cut at parameters, without a change of their shape."""

from __future__ import annotations

import numpy as np

from cncgen.geometry import nurbs
from cncgen.geometry.tables import Floats, NurbsTable


def split(table: NurbsTable, curve: int, at: Floats) -> NurbsTable:
    """Return a curve of a table cut at parameters, as a table of ``len(at) + 1`` curves in order.

    Each parameter is made a knot of full multiplicity by inserting it (W. Boehm (1980); The NURBS Book, section 5.2); there
    the control polygon meets the curve and comes apart.

    Args:
        table: Curves.
        curve: Which one.
        at: Parameters strictly inside its range, ascending, no two the same.
    """
    one = nurbs.take(table, [curve])
    p = int(one.degree[0])
    knots, points = one.knots, np.column_stack([one.control_points * one.weights[:, None], one.weights])
    for u in at:
        for _ in range(p - int(np.count_nonzero(knots == u))):
            knots, points = _inserted(knots, points, p, float(u))
    ends = [int(np.searchsorted(knots, u, side="right")) - 1 for u in at]
    parts = []
    for first, last in zip([None, *ends], [*ends, None], strict=True):
        own_points = points[0 if first is None else first - p : None if last is None else last - p + 1]
        own_knots = [knots[0 if first is None else first - p + 1 : None if last is None else last + 1]]
        if first is not None:
            own_knots.insert(0, knots[first : first + 1])
        if last is not None:
            own_knots.append(knots[last : last + 1])
        weights = own_points[:, -1]
        parts.append(
            nurbs.single(p, np.concatenate(own_knots), own_points[:, :-1] / weights[:, None], weights)
        )
    return nurbs.concatenate(parts)


def _inserted(knots: Floats, points: Floats, p: int, u: float) -> tuple[Floats, Floats]:
    """Insert a knot once; points are homogeneous (The NURBS Book, eq. 5.15)."""
    k = int(np.searchsorted(knots, u, side="right")) - 1
    i = np.arange(k - p + 1, k + 1)
    width = knots[i + p] - knots[i]
    share = np.divide(u - knots[i], width, out=np.zeros(p), where=width > 0)[:, None]
    fresh = (1.0 - share) * points[i - 1] + share * points[i]
    return np.insert(knots, k + 1, u), np.concatenate([points[: k - p + 1], fresh, points[k:]])
