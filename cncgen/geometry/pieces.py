"""Rows of lines and arcs as cubic pieces by arc length: what a smooth spline is fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cncgen.geometry.path import LINE, Path
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
        row: Shape (n,): the row that each came from, counted among those chosen.
        row_t: Shape (rows + 1,): t at the ends of these rows.
    """

    t: Floats
    y: Floats
    bend: Floats
    tolerance: Floats
    row: Ints
    row_t: Floats


def pieces_of(path: Path, tolerance: Floats, scale: Floats, rows: Ints | None = None) -> Pieces:
    """Cut rows of a path, LINE and ARC only, each of them longer than 0, into cubic pieces.

    A line is one piece. An arc is cut so that the cubic Hermite interpolant by its points and tangents misses it by at
    most `ARC_SHARE` of the tolerance: |x − y| ≤ h⁴ max|x''''| / 384 (C. de Boor, A Practical Guide to Splines, IV).

    Args:
        tolerance: Shape (rows,), mm, of the chosen rows.
        scale: Shape (axes,): mm an axis unit, 1 for linear axes.
        rows: The rows, each starting where the one before it ends; all where None.
    """
    chosen = np.arange(len(path)) if rows is None else rows
    length = path.row_length[chosen]
    straight = path.kind[chosen] == LINE
    count, bend = np.ones(len(chosen), np.int64), np.zeros(len(chosen))
    arcs = np.flatnonzero(~straight)
    if arcs.size:
        count[arcs], bend[arcs] = _arc_counts(path, chosen[arcs], tolerance[arcs])
    row_t = np.concatenate([[0.0], np.cumsum(length)])
    row = np.repeat(np.arange(len(chosen)), count)
    inner = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    h = (length / count)[row]
    y = np.zeros((len(row), 4, len(path.axes)))
    start = path.starts[chosen]
    y[:, 0] = start[row]
    y[:, 1] = ((path.end[chosen] - start) / length[:, None])[row]
    curved = np.flatnonzero(~straight[row])
    if curved.size:
        of = row[curved]
        y[curved] = _hermite(path, chosen[of], inner[curved] * h[curved], h[curved])
    bounds = np.append(row_t[row] + inner * h, row_t[-1])
    left = np.where(straight, tolerance, (1.0 - ARC_SHARE) * tolerance)
    return Pieces(bounds, y * scale, bend[row], left[row], row, row_t)


def _arc_counts(path: Path, arcs: Ints, tolerance: Floats) -> tuple[Ints, Floats]:
    """Return into how many pieces to cut arcs, and a bound of their curvature."""
    length = path.row_length[arcs]
    # A spiral bends more at its inner end; radii differ by a tolerance, tiny arcs by more.
    looks = [path.curvature_after(arcs, share * length) for share in (0.0, 0.5, 1.0)]
    kappa = np.maximum(np.max(looks, axis=0), 1e-12)
    widest = (384.0 * ARC_SHARE * tolerance / kappa**3) ** 0.25
    # At least eight to a turn, for the bound is one of small angles.
    widest = np.minimum(widest, 0.8 / kappa)
    return np.ceil(length / widest).astype(np.int64).clip(1, 1_000_000), 1.05 * kappa


def _hermite(path: Path, row: Ints, s: Floats, h: Floats) -> Floats:
    """Cubic coefficients by point and tangent at both ends of s … s + h on rows, s from the start of each."""
    ends = []
    for at in (s, s + h):
        u = path.parameter_after(row, at)
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
