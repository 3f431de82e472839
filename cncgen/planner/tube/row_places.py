"""Where on a plan the rows of the program begin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import tube_places
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.reference_path import EXACT, REST, Reference

Floats = NDArray[np.float64]

#: A row takes at least this part of its length on the plan, except for some tolerances.
_AS_LONG = 0.8
#: A row that takes less than this part of its length on the plan is not found.
_HARDLY = 0.1
#: The plan is within this part of the tolerance that is planned with of where rows begin, in order. With more, it would come near a corner
#: of rows that fold, and leave it, before it comes near the one before.
_NEAR = 1.02
#: The turns of an arc are counted from a turn of so many tolerances on, which has a radius of two.
_TURN = 4.0 * np.pi
#: Rows that are dropped at once, at least.
_DROPPED = 256


class RowPlaces:
    """The places of rows on the reference, found in order, as far as nothing that follows can change them.

    Attributes:
        stop: Number of the first row that has no place yet; the end of the last row counts as the start of one.
        reached: Where the reference came near the last point that has a place.
    """

    def __init__(self, program: Programmed, reference: Reference) -> None:
        self.program, self.reference = program, reference
        self.stop = program.base
        self.reached = -np.inf
        self._places: list[Floats] = []
        self._lost = False

    def at(self, row: int) -> float:
        """Return where a row begins."""
        return float(self.between(row, row + 1)[0])

    def between(self, first: int, stop: int) -> Floats:
        """Return where rows `first` … stop − 1 begin."""
        if len(self._places) > 1:
            self._places[:] = [np.concatenate(self._places)]
        return self._places[0][first - self.program.base : stop - self.program.base]

    def forget(self, keep: int) -> None:
        """Drop the rows before one, of the program as well, once they are many."""
        drop = keep - self.program.base
        if drop > _DROPPED and self._places:
            self._places[:] = [self.between(keep, self.stop).copy()]
            self.program.forget(keep)

    def _mistaken(self, points: Floats, s: Floats, length: Floats) -> bool:
        """Tell whether the last of some points, a rest, may be where the path has been before; from there on the plan is kept.

        It may where the rows begin at that very place, and take hardly any of their length from there on the plan.
        """
        known = self.program.column("start")[: self.stop - self.program.base]
        if len(known):
            points = np.concatenate([known, points])
            s = np.concatenate([self.between(self.program.base, self.stop), s])
            length = np.concatenate([[0.0], self.program.column("length")[: len(known)], length[1:]])
        upto = np.cumsum(length)
        same = np.abs(points[:-1] - points[-1]).max(axis=1, initial=0.0) <= 4.0 * EXACT
        short = s[-1] - s[:-1] < _HARDLY * (upto[-1] - upto[:-1] - 2.0 * EXACT)
        return bool((same & short).any())

    def match(self, last: bool) -> None:
        """Find where more rows begin; `last` tells that program and reference end."""
        grid, program = self.reference.grid, self.program
        count = len(program)
        if grid is None or not count or self._lost:
            return
        have = self.stop - program.base
        tolerance = program.column("tolerance")
        points = np.concatenate([program.column("start")[have:], program.column("end")[-1:]])
        # Where rows meet the plan is within the tolerance of either.
        both = np.minimum(np.append(tolerance, np.inf), np.concatenate([[np.inf], tolerance]))[have:]
        # The plan is hardly shorter than the rows; it cuts off corners within the tolerance of either row.
        length = np.concatenate([[0.0], program.column("length")])[have:]
        least = np.maximum(_AS_LONG * length - 8.0 * np.append(np.inf, tolerance)[have:], 0.0)
        # An arc of several turns comes back to where it ends; half a turn is more than the plan cuts off, unless a turn is hardly larger
        # than the tolerance.
        turn = np.append(np.inf, program.column("turn"))[have:]
        seen = turn > _TURN * np.append(np.inf, tolerance)[have:]
        least[seen] = np.maximum(least[seen], (length - 0.5 * turn)[seen])
        if not have:
            least[0] = 0.0
            self.reached = float(grid.s[0])
        start = self.at(self.stop - 1) if have else float(grid.s[0])
        begin = max(int(np.searchsorted(grid.s, self.reached, side="right")) - 1, 0)
        entry, place = np.zeros(len(points)), np.zeros(len(points))
        leaving = np.zeros(len(points), np.int64)
        # The plan meets some places exactly: in a room that is larger than the path any other place would be near as well.
        rest, met = (np.append(program.column(name), last)[have:].astype(np.int8) for name in ("rest", "met"))
        within = np.where(met > 0, EXACT + 8.0 * np.spacing(np.abs(points).max()), _NEAR * both + 1e-6)
        still = (grid.v[begin:] <= REST).astype(np.int8)
        if last:
            # The end is no other rest: a circle within the tolerance begins at that place.
            rest[-1] = still[-1] = 2
        found = tube_places.match(
            grid.x[begin:], grid.s[begin:], points, within, least, rest, still, self.reached, start, last,
            entry, leaving, place, np.zeros(1),
        )  # fmt: skip
        place += begin
        if have + found > count:
            # The end of the last row: whether more rows follow is not known before the end.
            found = count - have + (1 if last else 0)
        if found:
            self.reached = float(entry[found - 1])
        at = np.minimum(place[:found].astype(np.int64), len(grid) - 2)
        s = grid.s[at] + (place[:found] - at) * (grid.s[np.minimum(at + 1, len(grid) - 1)] - grid.s[at])
        # Places that the plan meets exactly are samples of it: there it may rest, and time be no function of the place.
        for i in (at, np.minimum(at + 1, len(grid) - 1)):
            exact = np.abs(grid.x[i] - points[:found]).max(axis=1, initial=0.0) < EXACT
            s = np.where(exact, grid.s[i], s)
        # So are the ends of runs.
        free = np.concatenate([[False], program.column("free"), [False]]).astype(bool)
        ends = (free[1:] != free[:-1]) | np.append(program.column("stop"), True).astype(bool)
        ends = ends[have : have + found]
        s[ends] = grid.s[at[ends] + (place[:found][ends] - at[ends] > 0.5)]
        s = np.maximum.accumulate(np.maximum(s, start))
        short = np.diff(s, prepend=start) < _HARDLY * (length[:found] - 2.0 * EXACT)
        for i in np.flatnonzero((rest[:found] == 1) & short):
            if self._mistaken(points[: i + 1], s[: i + 1], length[: i + 1]):
                found, self._lost = int(i), True
                s = s[:found]
                break
        self._places.append(s)
        self.stop += found
