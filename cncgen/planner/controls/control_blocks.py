"""A toolpath as the blocks that a control plans: lines, and curves in parts that are nearly straight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.tables import ranges
from cncgen.machine.record import Machine
from cncgen.planner.limits.row_limits import RowLimits, row_limits_of
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: Parts that a curve is cut into at most.
_MOST = 20_000
#: Points of a curve at which its curvature is looked at, to cut it.
_PROBES = 33
#: Distance from the ends of a row at which its own derivatives are taken, as a part of its length.
_INSIDE = 1e-9


@dataclass(frozen=True, slots=True)
class Blocks:
    """`n` blocks one after the other; everything along the path.

    Attributes:
        row: Shape (n,): number of the moving row that each is a part of.
        start, end: Shape (n,): path coordinates, mm.
        length: Shape (n,), mm: the way that the control travels; the path's own unless it cuts a corner.
        feed: Shape (n,), mm/s: the programmed one, or the velocity of the axes where that is lower.
        top: Shape (n,), mm/s: the speed that the rules of the control allow on it, at most the feed.
        entry: Shape (n,), mm/s: what they allow where it begins, at most `top` of it and of the block before.
        acceleration: Shape (n,), mm/s²: of the weakest axis on curves, until rules change it.
        radius: Shape (n,), mm: least radius of curvature; infinite on lines.
        way_in, way_out: Shape (n, axes): unit vectors of the motion at both ends.
        rapid: Shape (n,): traverses.
        exact: Shape (n,): the program asks for the exact path (G61).
        exact_stop: Shape (n,): the program asks for a rest at the end (G61.1, G9).
        tolerance: Shape (n,), mm: of continuous motion.
        inner: Shape (n,): the block begins inside a row.
        stopped: Shape (n,): the motion rests before the block: an event, or the start.
        leads: Shape (n,): the first block of a chunk, which is never made one with the block before.
    """

    row: Ints
    start: Floats
    end: Floats
    length: Floats
    feed: Floats
    top: Floats
    entry: Floats
    acceleration: Floats
    radius: Floats
    way_in: Floats
    way_out: Floats
    rapid: Bools
    exact: Bools
    exact_stop: Bools
    tolerance: Floats
    inner: Bools
    stopped: Bools
    leads: Bools

    def __len__(self) -> int:
        return len(self.row)

    def part(self, rows: slice | Ints) -> Blocks:
        """Return some of the blocks."""
        return Blocks(*(getattr(self, name)[rows] for name in self.__slots__))

    def followed(self, other: Blocks) -> Blocks:
        """Return these blocks and others after them."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in self.__slots__)
        return Blocks(*(np.concatenate(pair) for pair in pairs))


def blocks_of(toolpath: Toolpath, machine: Machine, chord_mm: float) -> tuple[Blocks, RowLimits]:
    """Cut the moving rows of a toolpath; curves into parts whose chords are at most `chord_mm` from them.

    Raises:
        ProgramError: A row has no feed.
    """
    path = toolpath.path
    rows = row_limits_of(toolpath, path, machine, bends=False)
    count = _parts(toolpath, rows, chord_mm)
    row, part = ranges(np.zeros_like(count), count)
    step = rows.length[row] / count[row]
    start = rows.start[row] + part * step
    end = np.where(part + 1 == count[row], rows.end[row], start + step)
    way_in, way_out, radius = _ways(toolpath, rows, row, start, end)
    index = rows.index[row]
    mode = toolpath.path_mode[index]
    return Blocks(
        row=row,
        start=start,
        end=end,
        length=end - start,
        feed=rows.top[row],
        top=rows.top[row],
        entry=np.zeros(len(row)),
        acceleration=rows.acceleration[row],
        radius=radius,
        way_in=way_in,
        way_out=way_out,
        rapid=toolpath.feed_mode[index] == FeedMode.RAPID,
        exact=mode != PathMode.CONTINUOUS,
        exact_stop=mode == PathMode.EXACT_STOP,
        tolerance=np.nan_to_num(toolpath.tolerance[index]),
        inner=part > 0,
        stopped=(part == 0) & _after_event(toolpath, rows)[row],
        leads=np.arange(len(row)) == 0,
    ), rows


def _parts(toolpath: Toolpath, rows: RowLimits, chord_mm: float) -> Ints:
    """Return the number of parts that each row is cut into: a chord of length h over curvature κ is κ h²/8 from its curve."""
    count = np.ones(len(rows), np.int64)
    curved = np.flatnonzero(toolpath.kind[rows.index] != Kind.LINE)
    if len(curved):
        fraction = np.linspace(_INSIDE, 1.0 - _INSIDE, _PROBES)
        at = rows.start[curved, None] + fraction * rows.length[curved, None]
        bend = np.linalg.norm(toolpath.path.evaluate(at.ravel(), 2)[2][:, :3], axis=1).reshape(at.shape)
        parts = rows.length[curved] * np.sqrt(bend.max(axis=1) / (8.0 * chord_mm))
        count[curved] = np.clip(np.ceil(parts), 1, _MOST).astype(np.int64)
    return count


def _ways(
    toolpath: Toolpath, rows: RowLimits, row: Ints, start: Floats, end: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return unit vectors at both ends of each part, and the least radius there."""
    way_in, way_out = rows.tangent_in[row].copy(), rows.tangent_out[row].copy()
    radius = np.full(len(row), np.inf)
    curved = np.flatnonzero(toolpath.kind[rows.index[row]] != Kind.LINE)
    if len(curved):
        margin = _INSIDE * (end - start)[curved]
        first = toolpath.path.evaluate(start[curved] + margin, 2)
        last = toolpath.path.evaluate(end[curved] - margin, 2)
        way_in[curved], way_out[curved] = first[1], last[1]
        bend = np.maximum(*(np.linalg.norm(each[2][:, :3], axis=1) for each in (first, last)))
        radius[curved] = 1.0 / np.maximum(bend, 1e-12)
    return _unit(way_in), _unit(way_out), radius


def _unit(ways: Floats) -> Floats:
    return ways / np.maximum(np.linalg.norm(ways, axis=1), 1e-300)[:, None]


def _after_event(toolpath: Toolpath, rows: RowLimits) -> Bools:
    """Tell the moving rows before which an event stands in the program."""
    events = np.flatnonzero(toolpath.kind == Kind.EVENT)
    found = np.zeros(len(rows) + 1, np.bool_)
    found[np.searchsorted(rows.index, events)] = True
    return found[: len(rows)]
