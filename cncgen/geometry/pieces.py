"""Rows of lines and arcs as cubic pieces by arc length: what a smooth spline is fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cncgen.geometry.path import ARC, LINE, Path
from cncgen.geometry.tables import Floats, Ints

#: Part of the tolerance that cubic pieces of an arc may miss it by.
ARC_SHARE = 1e-3


@dataclass(frozen=True, slots=True)
class Pieces:
    """Cubic pieces y(t), n of them, t being the path coordinate from the first one's start.

    Attributes:
        t: Shape (n + 1,).
        y: Shape (n, 4, axes): power coefficients in t − t[k], columns multiplied by their scale (all mm).
        bend: Shape (n,): bound of |y''|, 1/mm.
        tolerance: Shape (n,), mm: what is left of the tolerance after the pieces' own error.
        row: Shape (n,): the row that each came from.
    """

    t: Floats
    y: Floats
    bend: Floats
    tolerance: Floats
    row: Ints


def pieces_of(path: Path, tolerance: Floats, scale: Floats) -> Pieces:
    """Cut the rows of a path, LINE and ARC only, each of them longer than 0, into cubic pieces.

    A line is one piece. An arc is cut so that the cubic Hermite interpolant by its points and tangents misses it by at
    most `ARC_SHARE` of the tolerance: |x − y| ≤ h⁴ max|x''''| / 384 (C. de Boor, A Practical Guide to Splines, IV).

    Args:
        tolerance: Shape (rows,), mm.
        scale: Shape (axes,): mm an axis unit, 1 for linear axes.
    """
    length = np.diff(path.row_s)
    count, bend = np.ones(len(path), np.int64), np.zeros(len(path))
    arcs = np.flatnonzero(path.kind == ARC)
    if arcs.size:
        middle = 0.5 * (path.row_s[arcs] + path.row_s[arcs + 1])
        # A spiral bends more at its inner end; radii differ by a tolerance, tiny arcs by more.
        ends = [path.curvature(path.row_s[arcs], 1), path.curvature(path.row_s[arcs + 1], -1)]
        kappa = np.maximum(np.maximum(*ends), path.curvature(middle))
        widest = (384.0 * ARC_SHARE * tolerance[arcs] / np.maximum(kappa, 1e-12) ** 3) ** 0.25
        # At least eight to a turn, for the bound is one of small angles.
        widest = np.minimum(widest, 0.8 / np.maximum(kappa, 1e-12))
        count[arcs] = np.ceil(length[arcs] / widest).astype(np.int64).clip(1, 1_000_000)
        bend[arcs] = 1.05 * kappa
    row = np.repeat(np.arange(len(path)), count)
    inner = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    h = (length / count)[row]
    s = path.row_s[row] + inner * h
    y = np.zeros((len(row), 4, len(path.axes)))
    y[:, 0] = path.starts[row]
    straight = path.kind == LINE
    y[straight[row], 1] = ((path.end - path.starts) / length[:, None])[straight]
    curved = np.flatnonzero(~straight[row])
    if curved.size:
        y[curved] = _hermite(path, row[curved], s[curved], h[curved])
    bounds = np.append(s, path.row_s[-1]) - path.row_s[0]
    left = np.where(straight, tolerance, (1.0 - ARC_SHARE) * tolerance)
    return Pieces(bounds, y * scale, bend[row], left[row], row)


def _hermite(path: Path, row: Ints, s: Floats, h: Floats) -> Floats:
    """Cubic coefficients by point and tangent at both ends of s … s + h on rows."""
    ends = []
    for at in (s, s + h):
        u = path.parameter(row, at)
        x, x1 = path.evaluate_parameter(row, u, 1)
        ends.append((x, x1 / np.linalg.norm(x1[:, :3], axis=1)[:, None]))
    (x0, d0), (x1, d1) = ends
    h = h[:, None]
    return np.stack(
        [x0, d0, 3 * (x1 - x0) / h**2 - (2 * d0 + d1) / h, 2 * (x0 - x1) / h**3 + (d0 + d1) / h**2], 1
    )


def first_scales(pieces: Pieces) -> Floats:
    """Guess the smoothing length at the ends of pieces, shape (n + 1,), mm.

    A smoothing spline of order 3 and length L rounds a turn by Δx' off by L |Δx'| / 3, and a step of curvature Δx'' by
    about 0.14 L² |Δx''| (docs/smoothing.md). L is half as much again as what makes that the tolerance, for turns and
    steps in a row to and fro round each other off; where they do not, the fit shrinks it.
    """
    y, h = pieces.y, np.diff(pieces.t)[:, None]
    turn = y[1:, 1] - (y[:-1, 1] + h[:-1] * (2 * y[:-1, 2] + 3 * h[:-1] * y[:-1, 3]))
    step = 2 * y[1:, 2] - (2 * y[:-1, 2] + 6 * h[:-1] * y[:-1, 3])
    within = np.minimum(pieces.tolerance[1:], pieces.tolerance[:-1])
    out = np.full(len(pieces.t), 1e9)
    by_turn = 4.0 * within / np.maximum(np.linalg.norm(turn, axis=1), 1e-9 * within)
    by_step = np.sqrt(within / (0.067 * np.linalg.norm(step, axis=1) + 1e-18 * within))
    out[1:-1] = np.minimum(by_turn, by_step)
    return out
