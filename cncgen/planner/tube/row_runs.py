"""Runs of rows that are planned together: where on the plan each begins, its nodes, and where on its rows a motion is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.tube.deviation import Reached, followed, reached
from cncgen.planner.tube.handing import Hand
from cncgen.planner.tube.programmed import Programmed, RowLines
from cncgen.planner.tube.reference_path import REST, Reference
from cncgen.planner.tube.row_places import RowPlaces
from cncgen.planner.tube.scales import Scales
from cncgen.planner.tube.tube_nodes import Nodes, borders_of, nodes_of
from cncgen.planner.tube.window_problem import Solved
from cncgen.planner.tube.window_rounds import PASSED

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A way on which nothing moves, mm.
_SAME_PLACE = 1e-9
#: Periods by which a run is planned from inside of its ends where the plan is moving.
_INSIDE = 5.0
#: Time without a border, in times between nodes, after which one is made.
_WAITED = 256
#: Borders are apart by this part of the narrower tolerance at least.
_APART = 0.05
#: Corners that the plan passes in one place are borders each if they are apart by this part of it.
_MATTERS = 0.1


@dataclass(slots=True)
class RowRun:
    """A run that is being planned: rows from `first` on.

    Attributes:
        first: Its first row.
        row: The first row without nodes.
        nodes: Those not yet handed on, without the one where the motion is.
        state: Shape (3, axes), the state there.
        s, t: Its place and time on the reference.
        at, part: The row there, and the part of it that is behind.
        closed: Whether all nodes of the run are there.
        entry: Where on the rows the motion may be there; None where the plan is too far from them to tell.
        tail: A motion from there on to the reference that is known: solved intervals, and how many nodes they reach over.
        alone: Whether it is one window from rest to rest; None before that is known.
    """

    first: int
    row: int
    nodes: Nodes | None
    state: Floats
    s: float
    t: float
    at: int
    part: float = 0.0
    closed: bool = False
    entry: Reached | None = None
    tail: tuple[Solved, int] | None = None
    alone: bool | None = None


class RowRuns:
    """The runs of a program, in order.

    Attributes:
        places: Where on the plan rows begin.
        row: The first row that no run has been looked for from.
    """

    def __init__(
        self, program: Programmed, reference: Reference, hand: Hand, scales: Scales, spacing_s: float
    ) -> None:
        """Begin with none, of the rows and the plan; `hand` knows when setpoints are, `spacing_s` is the usual time between nodes."""
        self.program, self.reference, self.hand = program, reference, hand
        self.scales, self.bounds, self.spacing_s = scales, scales.bounds, spacing_s
        self.places = RowPlaces(program, reference)
        self.row = 0

    def opened(self, resting: bool = False) -> RowRun | None:
        """Return the next run if its start is known; with `resting`, if it begins at rest."""
        program = self.program
        free = program.column("free")
        while self.row + 1 < self.places.stop:
            if free[self.row - program.base] and not self._drills():
                s = self.places.at(self.row)
                grid = self.reference.grid
                assert grid is not None
                # After a rest, if there is one.
                i = self._smooth(int(np.searchsorted(grid.s, s, side="right") - 1), 1)
                if resting and grid.v[i] > REST:
                    return None
                s, t = float(grid.s[i]), float(grid.t[i])
                state = self.reference.state(s, t)
                run = RowRun(self.row, self.row, None, state, s, t, self.row)
                begin = Reached.at(program.column("start")[self.row - program.base], float(self.row))
                since = float(grid.t[np.searchsorted(grid.s, self.places.at(self.row), side="right") - 1])
                # Rows may be shorter than what the plan goes meanwhile.
                begun = int(np.searchsorted(self.places.between(self.row, self.places.stop), s, side="right"))
                path = program.lines(self.row, min(self.row + begun + 1, self.places.stop - 1))
                run.entry = self.followed(path, begin, since, t)
                return run
            self.row += 1
        return None

    def _drills(self) -> bool:
        """Tell whether a run would be one line along one axis, which has no room that matters."""
        program, at = self.program, self.row - self.program.base
        goes_on = (program.column("free") & ~program.column("stop").astype(bool))[at + 1 : at + 2].any()
        way = program.column("end")[at] != program.column("start")[at]
        return not (goes_on or program.column("curved")[at]) and int(way.sum()) == 1

    def _smooth(self, index: int, way: int) -> int:
        """Return the sample from which on (to which) a run is planned: some periods inside it where the plan is moving.

        There the plan may jump within what the period allows, and it counts on its own motion beside that.
        """
        grid = self.reference.grid
        assert grid is not None
        if grid.v[index] <= 1e-9:
            return index
        t = grid.t[index] + way * _INSIDE * self.bounds.period_s
        i = int(np.searchsorted(grid.t, t, side="left" if way > 0 else "right")) - (way < 0)
        while 1 <= i < len(grid) - 1 and abs(i - index) < 2000:
            straight = (grid.tangent[i - 1 : i + 2] * grid.tangent[i]).sum(axis=1).min() > 0.9998
            if straight and grid.v[i] > 1e-9:
                break
            i += way
        return int(np.clip(i, 0, len(grid) - 1))

    def extend(self, run: RowRun, last: bool) -> None:
        """Add the nodes of the known part of a run."""
        program = self.program
        if run.closed:
            return
        base = program.base
        free, stop = program.column("free"), program.column("stop")
        breaks = np.flatnonzero(~free[run.first - base + 1 :] | stop[run.first - base + 1 :].astype(bool))
        end = int(breaks[0]) + run.first + 1 if len(breaks) else base + len(program)
        known = bool(len(breaks)) or last
        # Rows whose ends are matched.
        until = min(end, self.places.stop - 1)
        if until <= run.row:
            run.closed = known and run.row == end
            return
        places = self.places.between(run.row, until + 1)
        grid = self.reference.grid
        assert grid is not None
        if run.row == run.first:
            places = np.maximum(places, run.s)
        if known and until == end:
            i = self._smooth(int(np.searchsorted(grid.s, places[-1], side="left")), -1)
            places = np.minimum(places, max(float(grid.s[i]), float(places[0])))
        speed = np.interp(places, grid.s, grid.v)
        border = np.ones(until - run.row + 1, bool)
        border[1:-1] = borders_of(program, run.row, places, speed, self.scales)
        closed = known and until == end
        stopping = until - run.row
        if not closed:
            inner = np.flatnonzero(border[1:-1]) + 1
            if len(inner):
                stopping = int(inner[-1])
            elif stopping < 2 or np.ptp(np.interp(places, grid.s, grid.t)) < _WAITED * self.spacing_s:
                return
            else:
                stopping -= 1
        places, border = places[: stopping + 1], border[: stopping + 1].copy()
        border[-1] = True
        if places[-1] - places[0] <= _SAME_PLACE:
            run.row += stopping if closed else 0
            run.closed = closed
            return
        found = self._nodes(run.row, places, border, (run.row == run.first, closed), self.scales)
        run.nodes = found if run.nodes is None else run.nodes.joined(found)
        run.row += stopping
        run.closed = closed

    def rows(self, run: RowRun, nodes: Nodes, whole: bool) -> tuple[RowLines, tuple[Reached, Reached] | None]:
        """Return the rows from where a run is to where it is at the last one of its nodes, as lines, and both places.

        At the end, these are all places where the motion that is known may be, since the plan goes on from one of them.
        """
        program, entry = self.program, run.entry
        stop, known = int(nodes.row[-1]) + 1, program.base + len(program)
        end = self.end(nodes)
        while True:
            first = run.at if entry is None else int(entry.line)
            path = program.lines(min(first, stop - 1), stop)
            if entry is None:
                return path, None
            if whole and float(np.abs(end[1]).max()) <= REST:
                return path, (entry, Reached.at(end[0], float(stop), float(path.key[-2])))
            goal: Reached | None = entry
            t = run.t
            if run.tail is not None:
                goal = self.reached(path, entry, t, *run.tail)
                t = float(nodes.t[run.tail[1] - 1])
            goal = self.followed(path, goal, t, float(nodes.t[-1]), whole=True)
            if stop >= known or (goal is not None and goal.high[-1] < path.key[-1]):
                return path, None if goal is None else (entry, goal)
            stop = min(stop + max(stop - first, 1), known)

    def end(self, nodes: Nodes) -> Floats:
        """Return the state of the plan at the last one of nodes, shape (3, axes)."""
        return self.reference.state(float(nodes.s[-1]), float(nodes.t[-1]))

    def reached(
        self, path: RowLines, entry: Reached | None, t: float, motion: Solved, count: int
    ) -> Reached | None:
        """Return where the first intervals of a motion in the place of the plan end on the rows."""
        first = self.hand.first_setpoint(t, motion)
        return entry and reached(path, entry, motion, first, self.bounds.period_s, PASSED, count)

    def followed(
        self, path: RowLines, entry: Reached | None, begin: float, end: float, whole: bool = False
    ) -> Reached | None:
        """Return where the plan between two times ends on the rows if `whole`, else where its last setpoint is."""
        grid, reference = self.reference.grid, self.reference
        assert grid is not None
        if entry is None or end <= begin:
            return entry
        first, stop = np.searchsorted(grid.t, begin, side="right"), np.searchsorted(grid.t, end, side="left")
        at = grid.rows(slice(max(int(first) - 1, 0), int(stop) + 1))
        t = np.clip(at.t, begin, end) - begin
        t[0], t[-1] = 0.0, end - begin
        plan = at.v[:, None] * at.tangent, t, lambda times: reference.positions(begin + times)
        period = self.bounds.period_s
        first_s = self.hand.until_setpoint(begin)
        return followed(path, entry, plan, first_s, period, PASSED, self.bounds.chord_mm, whole)

    def nodes_again(self, run: RowRun, nodes: Nodes, whole: bool, scales: Scales) -> Nodes:
        """Return nodes from where a run is up to the last one of others, of other scales.

        Within a tolerance as wide as the path many rows may have one place, and are laid out from there on (`_apart`) when nodes of
        all of them are made. Part of such rows can't be laid out anew: the nodes stay.
        """
        program, grid, first = self.program, self.reference.grid, run.at + (run.part >= 1.0)
        assert grid is not None
        stop = int(nodes.row[-1]) + 1
        places = np.clip(self.places.between(first, stop + 1), run.s, nodes.s[-1])
        if not places[-1] > places[0]:
            return nodes
        border = np.ones(len(places), bool)
        border[1:-1] = borders_of(program, first, places, np.interp(places, grid.s, grid.v), scales)
        within = 0.0 if run.part >= 1.0 else run.part, float(nodes.part[-1])
        return self._nodes(first, places, border, (run.part == 0.0, whole), scales, within)

    def _nodes(
        self,
        first: int,
        places: Floats,
        border: NDArray[np.bool_],
        ends: tuple[bool, bool],
        scales: Scales,
        within: tuple[float, float] = (0.0, 1.0),
    ) -> Nodes:
        """Return the nodes of rows `first` …; the arguments are those of `nodes_of`."""
        program, grid = self.program, self.reference.grid
        assert grid is not None
        own = slice(first - program.base, first - program.base + len(places) - 1)
        tolerance = scales.part * program.column("tolerance")[own]
        border, places = _apart(border, places, tolerance, program.joints(own), program.turns(own))
        return nodes_of(program, self.reference, grid, first, places, border, ends, scales, within)


def _apart(
    border: NDArray[np.bool_], places: Floats, tolerance: Floats, points: Floats, turn: Floats
) -> tuple[NDArray[np.bool_], Floats]:
    """Return borders and places so that no border is nearer to the one before it than a part of the tolerance of either: nodes have to be
    apart.

    Where the plan passes several corners in one place, those that are apart themselves move on; the others are no borders.

    Args:
        border: Shape (rows + 1,).
        places: Shape (rows + 1,), ascending.
        tolerance: Shape (rows,); at a border the narrower one of its rows counts.
        points: Shape (rows + 1, axes), the joints.
        turn: Shape (rows + 1,), how far the rows turn there.
    """
    narrow = np.minimum(np.append(tolerance[:1], tolerance), np.append(tolerance, tolerance[-1:]))
    least = _APART * narrow
    at = np.flatnonzero(border)
    if not (np.diff(places[at]) < np.minimum(least[at[1:]], least[at[:-1]])).any():
        return border, places
    for matters in (_MATTERS, np.inf):
        kept = _kept(at, places, least, points, turn, matters * narrow)
        moved, gap = places[kept].tolist(), np.minimum(least[kept[1:]], least[kept[:-1]]).tolist()
        for k in range(1, len(kept)):
            moved[k] = max(moved[k], moved[k - 1] + gap[k - 1])
        moved[-1] = float(places[-1])
        for k in range(len(kept) - 2, 0, -1):
            moved[k] = min(moved[k], moved[k + 1] - gap[k])
        if len(kept) == 2 or moved[1] >= moved[0] + gap[0]:
            break
    out = np.zeros(len(border), bool)
    out[kept] = True
    before = np.clip(np.searchsorted(kept, np.arange(len(places)), side="right") - 1, 0, len(kept) - 2)
    places = np.clip(places, np.take(moved, before), np.take(moved, before + 1))
    places[kept] = moved
    return out, places


def _kept(at: Ints, places: Floats, least: Floats, points: Floats, turn: Floats, matters: Floats) -> Ints:
    """Return those of borders `at` that are apart from the one before on the plan, or themselves; of those that are not, the sharpest.

    The arguments are those of `_apart`.
    """
    kept, end = [0], len(places) - 1
    for k in at[1:].tolist():
        last = kept[-1]
        near = places[k] - places[last] < min(least[k], least[last])
        if near and ((points[k] - points[last]) ** 2).sum() <= matters[k] ** 2:
            if k < end:
                if last and turn[k] > turn[last]:
                    kept[-1] = k
                continue
            if last:
                kept.pop()
        kept.append(k)
    return np.array(kept)
