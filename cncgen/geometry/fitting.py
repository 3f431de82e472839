"""One cubic B-spline for a run of short lines and arcs, as G6.2 can write it (degree 3, clamped, weights 1)."""

from __future__ import annotations

import numpy as np

from cncgen.geometry import elementary, nurbs
from cncgen.geometry.corridor import END_POINT, Spline, fit
from cncgen.geometry.path import Path
from cncgen.geometry.pieces import pieces_of
from cncgen.geometry.tables import Floats, NurbsTable

#: Part of the tolerance left to the step from degree 4 to degree 3.
_CUBIC_SHARE = 0.2
#: Largest smoothing length, in tolerances: the fewer knots, the shorter the program that is written.
_WIDEST = 250.0


def fit_run(path: Path, tolerance_mm: float, scale: Floats | None = None) -> NurbsTable:
    """Fit one cubic B-spline to a path of LINE and ARC rows, each longer than 0.

    The smooth curve of degree 4 within the corridor (`cncgen.geometry.corridor`) is met by a cubic spline in points
    close enough for the rest of the tolerance: |x − cubic| ≤ 5/384 h⁴ max|x''''| (C. A. Hall and W. W. Meyer,
    J. Approx. Theory 16 (1976) 105).

    Args:
        path: The run; memory grows with its rows, so a long one is better cut.
        tolerance_mm: Largest distance between run and curve, over all axes multiplied by `scale` (1 where None).
        scale: Shape (axes,), mm an axis unit.

    Returns:
        A table of one curve from the start to the end of the path; parameter: arc length of the run, mm.

    Raises:
        ValueError: If the tolerance is not positive.
        CorridorError: If no curve is found within it.
    """
    if not tolerance_mm > 0:
        raise ValueError(f"the tolerance must be positive, not {tolerance_mm}")
    from scipy.interpolate import BSpline, make_interp_spline

    factor = np.ones(len(path.axes)) if scale is None else scale
    near = np.full(len(path), (1.0 - _CUBIC_SHARE) * tolerance_mm)
    spline = fit(pieces_of(path, near, factor).joined(), np.zeros(0), END_POINT, END_POINT, widest=_WIDEST)
    smooth = BSpline(spline.knots, spline.points, 4)
    at = _places(spline, _CUBIC_SHARE * tolerance_mm)
    ends = [(1, smooth(at[k], 1)) for k in (0, -1)]
    cubic = make_interp_spline(at, smooth(at), k=3, bc_type=([ends[0]], [ends[1]]))
    return nurbs.single(3, cubic.t, cubic.c / factor)


def _places(spline: Spline, tolerance: float) -> Floats:
    """Return where the cubic is to meet the spline: the knots, and equal parts of spans where x'''' is large."""
    from scipy.interpolate import BSpline

    borders = spline.knots[4:-4]
    middle = 0.5 * (borders[1:] + borders[:-1])
    fourth = np.linalg.norm(BSpline(spline.knots, spline.points, 4)(middle, 4), axis=1)
    # Twice the bound: knots of uneven distance carry a part of their neighbours' error.
    parts = (
        np.ceil(np.diff(borders) * elementary.power(2.0 * 5.0 / 384.0 * fourth / tolerance, 0.25))
        .clip(1)
        .astype(np.int64)
    )
    start = np.repeat(borders[:-1], parts)
    inner = np.arange(len(start)) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(start + inner * np.repeat(np.diff(borders) / parts, parts), borders[-1])
