"""Improves a streamed plan within the tolerance, window by window."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity, Span
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.record import Trajectory
from cncgen.planner.tube.deviation import Reached, followed, reached
from cncgen.planner.tube.handing import Hand
from cncgen.planner.tube.programmed import Programmed, RowLines
from cncgen.planner.tube.reference_path import Reference
from cncgen.planner.tube.row_places import RowPlaces
from cncgen.planner.tube.tube_nodes import Nodes, Scales, borders_of, nodes_of
from cncgen.planner.tube.window_judge import REST
from cncgen.planner.tube.window_problem import Solved
from cncgen.planner.tube.window_rounds import PASSED, Window, moving
from cncgen.planner.tube.window_search import AHEAD, WindowSearch

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Nodes of a window, of the first one, for which the first setpoints wait, and those over which the end of one is felt, at most.
WINDOW, FIRST, OVERLAP = 1300, 450, 300
#: A run is one window up to so many times of its nodes. Rows without a run after one, beyond which no other is waited for.
_ONE, _BETWEEN = 1.3, 256
#: Nodes to which a window is shortened where none of its motions holds, a quarter of them each time. Of the tolerance, parts that such a
#: short one tries as its room before the plan stands: the motion for less is one for more as well.
_SMALLEST, _ATTEMPTS = 100, ((1.0, 1.0), (1.0, 2.0), (0.4, 1.0), (0.1, 1.0))
#: Runs of fewer nodes have closer nodes, at most by this factor: a few nodes lose time that closer nodes of a narrower tolerance do
#: not.
_CLOSEST = 8.0
#: A motion that is not faster by this part stays as it was.
_LESS = 1e-5
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
#: Units that a plan has by default, more for each line of the program beyond a number of them (a long program is not an endless one),
#: and units that a step of --max-steps allows.
_MOST, _OF_A_LINE, _LINES, _OF_A_STEP = 200_000, 1000, 500, 400


@dataclass(slots=True)
class _Run:
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


class Tube:
    """The work under way: the programmed rows, the plan, and where on it each row begins."""

    def __init__(self, program: Programmed, machine: Machine, max_steps: int | None) -> None:
        self.program, self.machine = program, machine
        self.most = max(_MOST, _OF_A_STEP * (max_steps or 0))
        self.last_line = 0
        program.draw()
        limits = AxisLimits.of(machine, program.axes)
        self.scale = program.scale
        limited = (each * self.scale for each in (limits.velocity, limits.acceleration, limits.jerk))
        velocity, acceleration, jerk = limited
        finite = np.isfinite(jerk)
        # On a machine that has none of the axes nothing moves, and there is nothing to search.
        self.ended = not finite.any()
        strongest, largest = (float(each[finite | self.ended].max()) for each in (jerk, acceleration))
        self.scales = Scales(strongest, largest, velocity, machine.period_s)
        self.spacing_s, near = (float(each) for each in self.scales.spacing(machine.path_tolerance_mm))
        self.reference = Reference(self.scale, near, 5.0 * machine.period_s)
        self.hand = Hand(self.reference, program, (velocity, acceleration, jerk), machine)
        self.places = RowPlaces(program, self.reference)
        self.row = 0
        self.run: _Run | None = None
        self.later: deque[_Run] = deque()
        self.size = FIRST
        self.search = WindowSearch(
            program, machine, self.reference, self.hand, (velocity, acceleration, jerk)
        )

    def close(self) -> None:
        """End its thread."""
        self.search.close()

    def take(self, trajectory: Trajectory, last: bool) -> Iterator[Trajectory]:
        """Add a trajectory of the plan; yield the final part."""
        if self.ended:
            self.reference.trajectories.append(trajectory)
            self.program.leave()
            yield from self.hand.rest()
            return
        self.reference.take(trajectory)
        self.program.draw()
        yield from self.advance(last)

    def advance(self, last: bool) -> Iterator[Trajectory]:
        """Yield the final part."""
        self.places.match(last)
        while not self.ended:
            if self.run is None:
                self.run = self.later.popleft() if self.later else self._opened()
            if self.run is None:
                break
            self._extend(self.run, last)
            if self._waits(self.run, last):
                break
            yield from self._windows(self.run)
            if self.run is not None:
                break
        if last or self.ended:
            run = self.run
            if run is not None and run.tail is not None and run.nodes is not None:
                # Rows after it are not found on the plan: the known motion leads back to that.
                yield from self.hand.improved(run.t, (run.at, run.part), run.nodes, *run.tail)
            yield from self.hand.rest()
        else:
            yield from self.hand.until(self._safe())
        self._forget()

    def _safe(self) -> float:
        """Return the time up to which the plan is kept."""
        if self.run is not None:
            return self.hand.time
        grid = self.reference.grid
        if grid is None:
            return -np.inf
        s = self.places.at(self.row) if self.row < self.places.stop else grid.s[0]
        return float(grid.t[np.searchsorted(grid.s, s, side="left")])

    def _waits(self, run: _Run, last: bool) -> bool:
        """Begin the searches of a run and of those after it that nothing before them changes; tell whether more of these are awaited."""
        if self.size < WINDOW or not self._begin(run):
            return False
        while len(self.later) < AHEAD:
            before = self.later[-1] if self.later else run
            if before.closed:
                self.row = max(self.row, before.row)
                following = self._opened(resting=True)
                if following is None:
                    known = self.row + 1 < self.places.stop or self.row - before.row > _BETWEEN
                    return not (known or last)
                self.later.append(following)
            following = self.later[-1]
            self._extend(following, last)
            if not following.closed:
                return not last and (following.nodes is None or len(following.nodes) < WINDOW)
            self._begin(following)
        return False

    def _begin(self, run: _Run) -> bool:
        """Begin the search of a run that is one window from rest to rest; return whether it is one."""
        nodes = run.nodes
        if run.alone is None and run.closed:
            run.alone = False
            if nodes is not None and _SMALLEST <= len(nodes) <= _ONE * WINDOW:
                speed = np.abs([run.state[1], self._end(nodes)[1]])
                run.alone = bool((speed <= REST).all()) and _has_room(run.state, nodes)
            if run.alone and nodes is not None:
                window = self._planned(run, nodes, len(nodes))
                if window.goals is not None:
                    self.search.begin(window)
        return bool(run.alone)

    def _opened(self, resting: bool = False) -> _Run | None:
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
                run = _Run(self.row, self.row, None, state, s, t, self.row)
                begin = Reached.at(program.column("start")[self.row - program.base], float(self.row))
                since = float(grid.t[np.searchsorted(grid.s, self.places.at(self.row), side="right") - 1])
                # Rows may be shorter than what the plan goes meanwhile.
                begun = int(np.searchsorted(self.places.between(self.row, self.places.stop), s, side="right"))
                path = program.lines(self.row, min(self.row + begun + 1, self.places.stop - 1))
                run.entry = self._followed(path, begin, since, t)
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
        t = grid.t[index] + way * _INSIDE * self.machine.period_s
        i = int(np.searchsorted(grid.t, t, side="left" if way > 0 else "right")) - (way < 0)
        while 1 <= i < len(grid) - 1 and abs(i - index) < 2000:
            straight = (grid.tangent[i - 1 : i + 2] * grid.tangent[i]).sum(axis=1).min() > 0.9998
            if straight and grid.v[i] > 1e-9:
                break
            i += way
        return int(np.clip(i, 0, len(grid) - 1))

    def _extend(self, run: _Run, last: bool) -> None:
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
        own = slice(run.row - base, run.row - base + stopping)
        border, places = _apart(border, places, program.column("tolerance")[own], program.joints(own))
        found = nodes_of(
            program,
            self.reference,
            grid,
            run.row,
            places,
            border,
            (run.row == run.first, closed),
            self.scales,
        )
        run.nodes = found if run.nodes is None else run.nodes.joined(found)
        run.row += stopping
        run.closed = closed

    def _windows(self, run: _Run) -> Iterator[Trajectory]:
        while run.nodes is not None and len(run.nodes):
            # Those of the next windows as well, so that their search can begin.
            if not run.closed and self.size == WINDOW and len(run.nodes) < (1 + AHEAD) * WINDOW:
                return
            window = self._next(run, run.nodes, self.size)
            if window is None:
                return
            yield from self._window(run, *window)
            if self.ended:
                return
        if run.closed:
            self.row, self.run = max(self.row, run.row), None

    def _next(self, run: _Run, nodes: Nodes, size: int) -> tuple[int, bool] | None:
        """Return how many of the nodes of a run are those of a window, and whether it ends the run; None where there are too few."""
        if run.closed and len(nodes) <= _ONE * size:
            return len(nodes), True
        return (_stop(nodes, size), False) if len(nodes) >= size else None

    def _following(self, run: _Run, begin: int, planned: int) -> tuple[Nodes, int] | None:
        """Return the nodes of a window that is expected, and its final ones; see `window_search.Following`."""
        assert run.nodes is not None
        rest = run.nodes.nodes(begin, len(run.nodes))
        window = self._next(run, rest, min(2 * max(self.size, planned), WINDOW))
        if window is None:
            return None
        nodes = rest.nodes(0, window[0])
        return nodes, len(nodes) if window[1] else self._final(nodes)

    def _window(self, run: _Run, count: int, whole: bool) -> Iterator[Trajectory]:
        """Plan over the first nodes of a run; yield the motion up to where the next window begins."""
        assert run.nodes is not None
        nodes, tail = run.nodes.nodes(0, count), run.tail
        # The times of its setpoints depend on all the motion before it.
        yield from self.hand.plain(run.t)
        final = count if whole else self._final(nodes)
        window, free = self._planned(run, nodes, final), _has_room(run.state, nodes)
        # Without goals it cannot be told whether a motion is within the tolerance.
        tried = free and window.goals is not None and self._searches(nodes)
        found, better = self._fastest(run, window) if tried else (None, False)
        if not better:
            self.search.forget()
        if tried and found is None and count > _SMALLEST:
            self.size = max(count // 4, _SMALLEST // 2)
            if tail is None:
                return
        else:
            self.size = min(2 * max(self.size, count), WINDOW)
        self.hand.windows += free
        held, final = (found, window.final) if better or tail is None else tail
        if not better and tail is None:
            held = None
            self.hand.kept += free
        nodes = window.nodes
        until = float(nodes.t[final - 1])
        if held is None:
            # The plan goes on to a place where the next window may begin.
            yield from self.hand.plain(until)
            run.entry = self._followed(window.path, run.entry, run.t, until)
        else:
            # Handing it on moves its setpoints in time.
            entry = self._reached(window.path, run.entry, run.t, held, final)
            yield from self.hand.improved(run.t, (run.at, run.part), nodes, held, final)
            run.entry = entry
        self._go_on(run, nodes, final, found if better else None)

    def _planned(self, run: _Run, nodes: Nodes, final: int) -> Window:
        """Return the window over nodes of a run of which some are final."""
        rows = self._rows(run, nodes, final == len(nodes))
        return Window(nodes, final, run.state, run.t, run.tail is None, *rows)

    def _final(self, nodes: Nodes) -> int:
        """Return the number of nodes of a window after which its end is not felt."""
        count, end = len(nodes), float(nodes.t[-1])
        bounds = self.search.bounds.within(nodes.allowed.max())
        felt = np.searchsorted(nodes.t, end - bounds.felt(float(nodes.feed[-OVERLAP:].max())))
        return int(np.clip(felt, max(count - OVERLAP, count // 3), count - 1))

    def _fastest(self, run: _Run, window: Window) -> tuple[Solved | None, bool]:
        """Return a motion over a window, and whether it is faster than what is known; None where none is found.

        Where the window is a run of its own, or as short as they get, others of its nodes are tried as well, which it has then.
        """
        nodes, tail = window.nodes, run.tail
        count, whole = len(nodes), window.whole
        before = float(nodes.t[-1]) - run.t
        if tail is not None:
            before = float(tail[0].step.sum()) + float(nodes.t[-1]) - float(nodes.t[tail[1] - 1])
        alone = whole and tail is None and run.part == 0.0
        found, better = None, False
        for number, (part, close) in enumerate(_ATTEMPTS):
            if number and not self._searches(nodes):
                break
            if number or (alone and count < _SMALLEST):
                near = min(max(close, close * _SMALLEST / count), _CLOSEST) if part == 1.0 else 1.0
                again = self._nodes_again(
                    run, window.nodes, whole, replace(self.scales, part=part, close=near)
                )
                window.nodes, window.final = again, len(again)
                self.search.forget()
            found = self.search.solved(window, partial(self._following, run))
            if found is not None:
                took = float(found.step.sum()) + self.hand.standing(run.t, found)
                better = took < (1.0 - _LESS) * before
            if tail is not None or better or not (alone if found is not None else count <= _SMALLEST):
                break
        return found, better

    def _go_on(self, run: _Run, nodes: Nodes, final: int, found: Solved | None) -> None:
        """Move a run to after the final nodes of a window, on a motion that was found or on the plan."""
        last = final - 1
        run.s, run.t = float(nodes.s[last]), float(nodes.t[last])
        run.at, run.part = int(nodes.row[last]), float(nodes.part[last])
        if found is None:
            run.tail, run.state = None, self.reference.state(run.s, run.t)
        else:
            run.tail = (_rest(found, final), len(nodes) - final) if final < len(nodes) else None
            run.state = np.stack([found.position[final], found.velocity[final], found.acceleration[final]])
        assert run.nodes is not None
        # Nodes of less room are others, but they reach as far.
        run.nodes = run.nodes.nodes(int(np.searchsorted(run.nodes.s, run.s, side="right")), len(run.nodes))

    def _rows(self, run: _Run, nodes: Nodes, whole: bool) -> tuple[RowLines, tuple[Reached, Reached] | None]:
        """Return the rows from where a run is to where it is at the last one of its nodes, as lines, and both places.

        At the end, these are all places where the motion that is known may be, since the plan goes on from one of them.
        """
        program, entry = self.program, run.entry
        stop, known = int(nodes.row[-1]) + 1, program.base + len(program)
        end = self._end(nodes)
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
                goal = self._reached(path, entry, t, *run.tail)
                t = float(nodes.t[run.tail[1] - 1])
            goal = self._followed(path, goal, t, float(nodes.t[-1]), whole=True)
            if stop >= known or (goal is not None and goal.high[-1] < path.key[-1]):
                return path, None if goal is None else (entry, goal)
            stop = min(stop + max(stop - first, 1), known)

    def _end(self, nodes: Nodes) -> Floats:
        """Return the state of the plan at the last one of nodes, shape (3, axes)."""
        return self.reference.state(float(nodes.s[-1]), float(nodes.t[-1]))

    def _reached(
        self, path: RowLines, entry: Reached | None, t: float, motion: Solved, count: int
    ) -> Reached | None:
        """Return where the first intervals of a motion in the place of the plan end on the rows."""
        first = self.hand.first_setpoint(t, motion)
        return entry and reached(path, entry, motion, first, self.machine.period_s, PASSED, count)

    def _followed(
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
        period = self.machine.period_s
        first_s = self.hand.until_setpoint(begin)
        return followed(path, entry, plan, first_s, period, PASSED, self.machine.chord_tolerance_mm, whole)

    def _nodes_again(self, run: _Run, nodes: Nodes, whole: bool, scales: Scales) -> Nodes:
        """Return nodes from where a run is up to the last one of others, of other scales."""
        program, grid, first = self.program, self.reference.grid, run.at + (run.part >= 1.0)
        assert grid is not None
        stop = int(nodes.row[-1]) + 1
        places = np.clip(self.places.between(first, stop + 1), run.s, nodes.s[-1])
        border = np.ones(len(places), bool)
        border[1:-1] = borders_of(program, first, places, np.interp(places, grid.s, grid.v), scales)
        own = slice(first - program.base, stop - program.base)
        border, places = _apart(
            border, places, scales.part * program.column("tolerance")[own], program.joints(own)
        )
        begun = 0.0 if run.part >= 1.0 else run.part
        return nodes_of(
            program, self.reference, grid, first, places, border, (run.part == 0.0, whole), scales,
            (begun, float(nodes.part[-1])),
        )  # fmt: skip

    def _searches(self, nodes: Nodes) -> bool:
        """Tell whether units are left for a window; report once if they are used up, from there on the plan is kept."""
        rows = nodes.row - self.program.base
        line = self.program.column("line")[rows]
        self.last_line = max(self.last_line, int(line.max()))
        self.search.bound = self.most + _OF_A_LINE * max(self.last_line - _LINES, 0)
        if self.ended or self.search.units <= self.search.bound:
            return not self.ended
        self.ended = True
        source = self.program.sources[int(self.program.column("source")[rows[0]])]
        self.hand.remark(
            Diagnostic(
                "search-ends",
                f"the search for a faster way within the tolerance ends here, after about {1e-5 * self.search.units:.0f} s of computing",
                Severity.WARNING,
                Span(source, int(line[0])),
                hint="the rest is planned as by --effort fast; --max-steps sets the bound",
            )
        )
        return False

    def _forget(self) -> None:
        """Drop everything before the end of the handed-on motion."""
        grid = self.reference.grid
        if grid is None:
            return
        place = (
            self.run.s
            if self.run is not None
            else self.places.at(self.row)
            if self.row < self.places.stop
            else grid.s[0]
        )
        row = (
            self.row
            if self.run is None or self.run.nodes is None or not len(self.run.nodes)
            else int(self.run.nodes.row[0])
        )
        keep = max(min(row, self.run.row if self.run else row) - 6, self.program.base)
        keep = min(keep, max(self.places.stop - 2, self.program.base))
        if self.run is not None:
            keep = min(keep, self.run.row, self.run.at)
            if self.run.entry is not None:
                keep = min(keep, int(self.run.entry.line))
            self.run.first = max(self.run.first, keep)
        self.places.forget(keep)
        place = min(place, self.places.reached) if self.places.stop > self.program.base else place
        self.reference.forget(int(np.searchsorted(grid.s, place, side="left")) - 2)


def _has_room(start: Floats, nodes: Nodes) -> bool:
    """Tell whether a motion has room that matters: one way along one axis has none."""
    columns = moving(start, nodes)
    # By places: the tangent where a run ends may, by rounding, be that of what follows.
    way = np.diff(np.concatenate([start[:1], nodes.point])[:, columns], axis=0)
    return len(columns) > 1 or bool(np.ptp(np.sign(way), axis=0).any())


def _stop(nodes: Nodes, size: int) -> int:
    """Return how many nodes a window of a size has that does not end the run: up to one far from corners."""
    low = int(0.9 * size)
    corner = np.flatnonzero(nodes.vertex[:size] >= 0)
    if not len(corner):
        return size
    at = np.arange(low, size)
    after = np.searchsorted(corner, at)
    beside = corner[np.clip([after - 1, after], 0, len(corner) - 1)]
    away = np.abs(beside - at).min(axis=0)
    return int(at[np.argmax(away)]) + 1


def _apart(
    border: NDArray[np.bool_], places: Floats, tolerance: Floats, points: Floats
) -> tuple[NDArray[np.bool_], Floats]:
    """Return borders and places so that no border is nearer to the one before it than a part of the tolerance of either: nodes have to be
    apart.

    Where the plan passes several corners in one place, those that are apart themselves move on; the others are no borders.

    Args:
        border: Shape (rows + 1,).
        places: Shape (rows + 1,), ascending.
        tolerance: Shape (rows,); at a border the narrower one of its rows counts.
        points: Shape (rows + 1, axes), the joints.
    """
    narrow = np.minimum(np.append(tolerance[:1], tolerance), np.append(tolerance, tolerance[-1:]))
    least = _APART * narrow
    at = np.flatnonzero(border)
    if not (np.diff(places[at]) < np.minimum(least[at[1:]], least[at[:-1]])).any():
        return border, places
    for matters in (_MATTERS, np.inf):
        kept = _kept(at, places, least, points, matters * narrow)
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


def _kept(at: Ints, places: Floats, least: Floats, points: Floats, matters: Floats) -> Ints:
    """Return those of borders `at` that are apart from the one before on the plan, or themselves; the arguments are those of `_apart`."""
    kept, end = [0], len(places) - 1
    for k in at[1:].tolist():
        last = kept[-1]
        near = places[k] - places[last] < min(least[k], least[last])
        if near and ((points[k] - points[last]) ** 2).sum() <= matters[k] ** 2:
            if k < end:
                continue
            if last:
                kept.pop()
        kept.append(k)
    return np.array(kept)


def _rest(found: Solved, first: int) -> Solved:
    """Return a motion from a node on."""
    names = ("position", "velocity", "acceleration", "jerk", "step")
    return replace(found, **{name: getattr(found, name)[first:] for name in names})


def improve(
    plan: Generator[Trajectory, None, None],
    program: Programmed,
    machine: Machine,
    max_steps: int | None = None,
) -> Iterator[Trajectory]:
    """Plan path and speed together where a plan's rows have a tolerance; the plan itself stands where that finds nothing faster.

    Args:
        plan: Trajectories, in order.
        program: The rows that it is a plan of, taken up as they were handed to it.
        machine: Limits and period.
        max_steps: Steps that the user allows: of more, the search goes on for longer.

    Yields:
        Trajectories without a gap in time or position.
    """
    tube: Tube | None = None
    held: Trajectory | None = None
    with closing(plan):
        try:
            for trajectory in plan:
                if held is not None:
                    tube = tube or Tube(program, machine, max_steps)
                    yield from tube.take(held, False)
                held = trajectory
            if held is not None:
                tube = tube or Tube(program, machine, max_steps)
                program.ended = True
                yield from tube.take(held, True)
        finally:
            if tube is not None:
                tube.close()
