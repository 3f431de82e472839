"""NURBS rows that meet a neighbour in a corner: cut a little way from it, so that their ends alone are rounded with it.

The rest of such a row is followed exactly, as the programmer meant it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.columns import max_over_axes
from cncgen.geometry.path import STANDSTILL, Path
from cncgen.geometry.splitting import split
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.smoothing.runs import LEAST_TOLERANCE, rapid, rests
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import between, join

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: A turn, and a step of curvature by the tolerance, up to which rows meet smoothly: an axis hardly slows down for it.
_TURN, _STEP = 2e-4, 1e-5
#: Length of the end that is cut off to be rounded, in smoothing lengths of the corner.
_REACH = 20.0
#: Largest smoothing length, in tolerances, however small the turn is.
_WIDEST = 100.0
#: |dC/du| as a part of its mean below which a curve has a cusp, and is not changed.
_CUSP = 1e-4


@dataclass(frozen=True, slots=True)
class _CurveEnds:
    """Before each row and after the last one: whether rows meet in a corner there, and the smoothing length that it takes.

    Attributes:
        rough: Shape (n + 1,).
        reach: Shape (n + 1,), mm: how far from it the path is rounded.
    """

    rough: Bools
    reach: Floats


def opened(chunks: Iterable[Toolpath]) -> Iterator[tuple[Toolpath, Bools]]:
    """Cut the NURBS rows that make corners.

    A row is held back until the one after it is known, so what comes out does not depend on the chunks.

    Args:
        chunks: Consecutive stretches of one program, tolerances filled in.

    Yields:
        Consecutive stretches, and which of their rows are ends of NURBS that may be rounded.
    """
    held: Toolpath | None = None
    before = (False, 0.0)
    for chunk in chunks:
        rows = chunk if held is None else join([held, chunk])
        moving = np.flatnonzero(_moves(rows))
        last = int(moving[-1]) if moving.size else len(rows)
        done, free, before = _cut(rows, last, before)
        if len(done):
            yield done, free
        held = between(rows, last, len(rows)) if last < len(rows) else None
    if held is not None:
        done, free, _ = _cut(held, len(held), before)
        yield done, free


def _moves(rows: Toolpath) -> Bools:
    """Tell which rows move, shape (n,): of lines that are no longer than a standstill the first of those that make a longer one.

    A move that is cut in parts must not vanish with them.
    """
    out: Bools = rows.kind != Kind.EVENT
    starts = rows.starts
    still = (rows.kind == Kind.LINE) & (max_over_axes(np.abs(rows.end - starts)) <= STANDSTILL)
    out[still] = False
    border = np.diff(still.astype(np.int8), prepend=0, append=0)
    first, last = np.flatnonzero(border > 0), np.flatnonzero(border < 0) - 1
    out[first[max_over_axes(np.abs(rows.end[last] - starts[first])) > STANDSTILL]] = True
    return out


def _cut(rows: Toolpath, stop: int, before: tuple[bool, float]) -> tuple[Toolpath, Bools, tuple[bool, float]]:
    """Cut the NURBS among the rows 0 … stop; return them, which ones are free, and the corner before row `stop`.

    Args:
        rows: The stretch, with the row at `stop` that follows, where there is one.
        stop: Rows to hand on.
        before: Whether a corner stands before the first row, and its reach.
    """
    if not np.any(rows.kind == Kind.NURBS):
        return between(rows, 0, stop), np.zeros(stop, bool), (False, 0.0)
    path = rows.path
    corners = _curve_ends(rows, path, before)
    parts: list[Toolpath] = []
    free: list[Bools] = []
    at = 0
    curves = np.flatnonzero((rows.kind == Kind.NURBS) & (corners.rough[:-1] | corners.rough[1:]))
    for k in curves[curves < stop].tolist():
        row, ends = _row(rows, path, k, corners)
        parts += [between(rows, at, k), row]
        free += [np.zeros(k - at, bool), ends]
        at = k + 1
    parts.append(between(rows, at, stop))
    free.append(np.zeros(stop - at, bool))
    return join(parts), np.concatenate(free), (bool(corners.rough[stop]), float(corners.reach[stop]))


def _curve_ends(rows: Toolpath, path: Path, before: tuple[bool, float]) -> _CurveEnds:
    """Look at the corners of rows that may both be rounded, with no rest between."""
    n = len(rows)
    rough, reach = np.zeros(n + 1, bool), np.zeros(n + 1)
    rough[0], reach[0] = before
    moving = np.flatnonzero(_moves(rows) & ((rows.kind == Kind.LINE) | (path.row_length > STANDSTILL)))
    one, two = moving[:-1], moving[1:]
    may = _roundable(rows, path)
    stops = np.concatenate([[0], np.cumsum(rests(rows))])
    swift = rapid(rows)
    pair = may[one] & may[two] & (stops[one] == stops[two])
    pair &= swift[one] == swift[two]
    pair &= (rows.kind[one] == Kind.NURBS) | (rows.kind[two] == Kind.NURBS)
    one, two = one[pair], two[pair]
    if not one.size:
        return _CurveEnds(rough, reach)
    scale = axis_scale(rows.axes, rows.degree_mm)
    left = path.evaluate(path.row_s[one + 1], 2, -1) * scale
    right = path.evaluate(path.row_s[two], 2, 1) * scale
    turn, step = (np.linalg.norm(right[k] - left[k], axis=1) for k in (1, 2))
    allowed = np.minimum(rows.tolerance[one], rows.tolerance[two])
    corner = (turn > _TURN) | (step * allowed > _STEP)
    with np.errstate(divide="ignore"):
        # In tolerances, and in steps of a sixteenth of an octave: rounding must not tell.
        length = np.minimum(4.0 / turn, 1.0 / np.sqrt(0.067 * step * allowed)).clip(None, _WIDEST)
        away = _REACH * allowed * elementary.exp2(np.round(16.0 * elementary.log2(length)) / 16.0)
    # The corner belongs to the row that follows it and to the one before; rows between do not move.
    for where in (two, one + 1):
        rough[where] |= corner
        reach[where] = np.where(corner, away, 0.0)
    return _CurveEnds(rough, reach)


def _roundable(rows: Toolpath, path: Path) -> Bools:
    may = (rows.path_mode == PathMode.CONTINUOUS) & (rows.tolerance >= LEAST_TOLERANCE)
    may &= (rows.kind != Kind.EVENT) & path.moves_xyz
    return may & regular(rows, path)


def regular(rows: Toolpath, path: Path) -> Bools:
    """Tell which rows have no cusp at the borders of their cells."""
    out = np.ones(len(rows), bool)
    curves = np.flatnonzero(rows.kind == Kind.NURBS)
    of, begin, width = path.panels(curves)
    row = curves[of]
    speeds = []
    for at, side in ((begin, 1), (begin + width, -1)):
        u = path.parameter_after(row, at, side)
        speeds.append(np.linalg.norm(path.evaluate_parameter(row, u, 1, side)[1][:, :3], axis=1))
    # Over both ends of the panels: one that reaches from a cusp to the other end of the curve is a curve of its own.
    total = np.bincount(of, 0.5 * (speeds[0] + speeds[1]), len(curves))
    mean = total / np.maximum(np.bincount(of, minlength=len(curves)), 1)
    out[row[np.minimum(*speeds) <= _CUSP * mean[of]]] = False
    return out


def _row(rows: Toolpath, path: Path, k: int, corners: _CurveEnds) -> tuple[Toolpath, Bools]:
    """Return row `k` cut where its corners reach, and which parts are free: its ends at corners, or all of it."""
    row = between(rows, k, k + 1)
    length = float(path.row_length[k])
    head, tail = (bool(corners.rough[j]) for j in (k, k + 1))
    reach = corners.reach[k : k + 2]
    if np.sum(reach, where=[head, tail]) > 0.75 * length:
        return row, np.ones(1, bool)
    at = np.array([reach[0]] * head + [length - reach[1]] * tail)
    u = path.parameter_after(np.full(len(at), k), at)
    n = len(at) + 1
    ends = np.concatenate([path.evaluate_parameter(np.full(len(at), k), u)[0], row.end])
    share = np.diff(np.concatenate([[0.0], at, [length]])) / length
    inverse = row.feed_mode[0] == FeedMode.INVERSE_TIME
    columns = row.columns(np.zeros(n, np.int64)) | {"end": ends, "curve": np.arange(n)}
    columns["feed"] = columns["feed"] / (share if inverse else 1.0)
    parts = replace(row, nurbs=split(row.nurbs, 0, u), **columns)
    free = np.zeros(n, bool)
    free[0], free[-1] = head, tail
    return parts, free
