"""Improves a streamed plan within the tolerance, window by window."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator
from contextlib import closing
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity, Span
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.record import Trajectory
from cncgen.planner.tube.handing import Hand
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.reference_path import REST, Grid, Reference
from cncgen.planner.tube.row_runs import RowRun, RowRuns
from cncgen.planner.tube.scales import Bounds, Scales
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_problem import Solved
from cncgen.planner.tube.window_rounds import Window, moving
from cncgen.planner.tube.window_search import AHEAD, WindowSearch

Floats = NDArray[np.float64]

#: Nodes of a window, of the first one, for which the first setpoints wait, and those over which the end of one is felt, at most.
WINDOW, FIRST, OVERLAP = 1300, 450, 300
#: A run is one window up to so many times of its nodes. Rows without a run after one, beyond which no other is waited for.
_ONE, _BETWEEN = 1.3, 256
#: Nodes to which a window is shortened where none of its motions holds, a quarter of them each time. Of the tolerance, parts that such a
#: short one tries as its room before the plan stands, and how many times closer its nodes are: the motion for less is one for more as
#: well. Without less room three of twenty stars as large as P take 27 to 45 % longer, without closer nodes a parabola that turns back 0.5 %.
_SMALLEST, _ATTEMPTS = 100, ((1.0, 1.0), (1.0, 2.0), (0.4, 1.0), (0.1, 1.0))
#: Runs of fewer nodes have closer nodes, at most by this factor: a few nodes lose time that closer nodes of a narrower tolerance do
#: not. Without this bound of it a parabola that turns back takes 3 % longer, and none of 130 random programs any longer.
_CLOSEST = 8.0
#: A motion that is not faster by this part stays as it was.
_LESS = 1e-5
#: Units of 10 µs that a plan has by default, more for each line of the program beyond a number of them (a long program is not an endless
#: one), and units that a step of --max-steps allows.
_MOST, _OF_A_LINE, _LINES, _OF_A_STEP = 200_000, 1000, 500, 400
#: More units for each second of the motion, of which computing may take a quarter, up to a number of them.
_OF_A_SECOND, _OF_SECONDS = 25_000, 300_000


class Tube:
    """The work under way: the programmed rows, the plan, the runs of both, and the one whose windows are planned."""

    def __init__(self, program: Programmed, machine: Machine, max_steps: int | None) -> None:
        self.program = program
        self.most = max(_MOST, _OF_A_STEP * (max_steps or 0))
        self.last_line = 0
        program.draw()
        limits = AxisLimits.of(machine, program.axes)
        velocity, acceleration, jerk = (
            each * program.scale for each in (limits.velocity, limits.acceleration, limits.jerk)
        )
        bounds = Bounds(velocity, acceleration, jerk, machine.period_s, machine.chord_tolerance_mm)
        # On a machine that has none of the axes nothing moves, and there is nothing to search.
        self.ended = not np.isfinite(bounds.jerk).any()
        scales = Scales(bounds)
        usual, near = (float(each) for each in scales.spacing(machine.path_tolerance_mm))
        self.reference = Reference(program.scale, near, 5.0 * machine.period_s)
        self.hand = Hand(self.reference, program, bounds)
        self.runs = RowRuns(program, self.reference, self.hand, scales, usual)
        self.run: RowRun | None = None
        self.later: deque[RowRun] = deque()
        self.size = FIRST
        self.search = WindowSearch(program, self.reference, self.hand, bounds)

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
        self.runs.places.match(last)
        while not self.ended:
            if self.run is None:
                self.run = self.later.popleft() if self.later else self.runs.opened()
            if self.run is None:
                break
            self.runs.extend(self.run, last)
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
        return float(grid.t[np.searchsorted(grid.s, self._place(grid), side="left")])

    def _place(self, grid: Grid) -> float:
        """Return where on the reference the run begins that is planned, or looked for."""
        if self.run is not None:
            return self.run.s
        known = self.runs.row < self.runs.places.stop
        return self.runs.places.at(self.runs.row) if known else float(grid.s[0])

    def _waits(self, run: RowRun, last: bool) -> bool:
        """Begin the searches of a run and of those after it that nothing before them changes; tell whether more of these are awaited."""
        if self.size < WINDOW or not self._begin(run):
            return False
        while len(self.later) < AHEAD:
            before = self.later[-1] if self.later else run
            if before.closed:
                self.runs.row = max(self.runs.row, before.row)
                following = self.runs.opened(resting=True)
                if following is None:
                    known = self.runs.row + 1 < self.runs.places.stop or self.runs.row - before.row > _BETWEEN
                    return not (known or last)
                self.later.append(following)
            following = self.later[-1]
            self.runs.extend(following, last)
            if not following.closed:
                return not last and (following.nodes is None or len(following.nodes) < WINDOW)
            self._begin(following)
        return False

    def _begin(self, run: RowRun) -> bool:
        """Begin the search of a run that is one window from rest to rest; return whether it is one."""
        nodes = run.nodes
        if run.alone is None and run.closed:
            run.alone = False
            if nodes is not None and _SMALLEST <= len(nodes) <= _ONE * WINDOW:
                speed = np.abs([run.state[1], self.runs.end(nodes)[1]])
                run.alone = bool((speed <= REST).all()) and _has_room(run.state, nodes)
            if run.alone and nodes is not None:
                window = self._planned(run, nodes, len(nodes))
                if window.goals is not None:
                    self.search.begin(window)
        return bool(run.alone)

    def _windows(self, run: RowRun) -> Iterator[Trajectory]:
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
            self.runs.row, self.run = max(self.runs.row, run.row), None

    def _next(self, run: RowRun, nodes: Nodes, size: int) -> tuple[int, bool] | None:
        """Return how many of the nodes of a run are those of a window, and whether it ends the run; None where there are too few."""
        if run.closed and len(nodes) <= _ONE * size:
            return len(nodes), True
        return (_stop(nodes, size), False) if len(nodes) >= size else None

    def _following(self, run: RowRun, begin: int, planned: int) -> tuple[Nodes, int] | None:
        """Return the nodes of a window that is expected, and its final ones; see `window_search.Following`."""
        assert run.nodes is not None
        rest = run.nodes.nodes(begin, len(run.nodes))
        window = self._next(run, rest, min(2 * max(self.size, planned), WINDOW))
        if window is None:
            return None
        nodes = rest.nodes(0, window[0])
        return nodes, len(nodes) if window[1] else self._final(nodes)

    def _window(self, run: RowRun, count: int, whole: bool) -> Iterator[Trajectory]:
        """Plan over the first nodes of a run; yield the motion up to where the next window begins."""
        assert run.nodes is not None
        nodes, tail = run.nodes.nodes(0, count), run.tail
        # The times of its setpoints depend on all the motion before it.
        yield from self.hand.plain(run.t)
        final = count if whole else self._final(nodes)
        window, free = self._planned(run, nodes, final), _has_room(run.state, nodes)
        # Without goals it cannot be told whether a motion is within the tolerance. Where rows before an event are so short that they are one
        # place, the plan may rest for it amid the window.
        tried = free and window.goals is not None and self._searches(nodes)
        tried &= not self.hand.stops_between(run.t, float(nodes.t[-1]))
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
            self.hand.kept += free and found is None
        nodes = window.nodes
        until = float(nodes.t[final - 1])
        if held is None:
            # The plan goes on to a place where the next window may begin.
            yield from self.hand.plain(until)
            run.entry = self.runs.followed(window.path, run.entry, run.t, until)
        else:
            # Handing it on moves its setpoints in time.
            entry = self.runs.reached(window.path, run.entry, run.t, held, final)
            yield from self.hand.improved(run.t, (run.at, run.part), nodes, held, final)
            run.entry = entry
        self._go_on(run, nodes, final, found if better else None)

    def _planned(self, run: RowRun, nodes: Nodes, final: int) -> Window:
        """Return the window over nodes of a run of which some are final."""
        rows = self.runs.rows(run, nodes, final == len(nodes))
        return Window(nodes, final, run.state, run.t, run.tail is None, *rows)

    def _final(self, nodes: Nodes) -> int:
        """Return the number of nodes of a window after which its end is not felt."""
        count, end = len(nodes), float(nodes.t[-1])
        feed = float(nodes.feed[-OVERLAP:].max())
        bounds = self.search.bounds.within(float(nodes.allowed.max()), feed)
        felt = np.searchsorted(nodes.t, end - bounds.felt(feed))
        return int(np.clip(felt, max(count - OVERLAP, count // 3), count - 1))

    def _fastest(self, run: RowRun, window: Window) -> tuple[Solved | None, bool]:
        """Return a motion over a window, and whether it is faster than what is known; None where none is found.

        Where the window is a run of its own, or as short as they get, others of its nodes are tried as well, which it has then; where nothing is
        found, nodes twice as close: of a window cut in parts, each ends in a state of the plan. Among many local optima the parts are better.
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
                again = self.runs.nodes_again(
                    run, window.nodes, whole, replace(self.runs.scales, part=part, close=near)
                )
                # What is known behind the final nodes of a window is counted by the run's own nodes, so all of these are final.
                window.nodes, window.final = again, len(again)
                self.search.forget()
            # The windows after this one are of the run's own nodes.
            found = self.search.solved(
                window, partial(self._following, run) if window.nodes is nodes else None
            )
            if found is not None:
                took = float(found.step.sum()) + self.hand.standing(run.t, found)
                better = took < (1.0 - _LESS) * before
            short = count <= _SMALLEST or (not number and not window.tangled)
            if tail is not None or better or not (alone if found is not None else short):
                break
        return found, better

    def _go_on(self, run: RowRun, nodes: Nodes, final: int, found: Solved | None) -> None:
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

    def _searches(self, nodes: Nodes) -> bool:
        """Tell whether units are left for a window; report once if they are used up, from there on the plan is kept."""
        rows = nodes.row - self.program.base
        line = self.program.column("line")[rows]
        self.last_line = max(self.last_line, int(line.max()))
        self.search.bound = self.most + _OF_A_LINE * max(self.last_line - _LINES, 0)
        self.search.bound += min(int(_OF_A_SECOND * nodes.t[-1]), _OF_SECONDS)
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
                hint="the rest is planned along the path, much as by --effort fast; --max-steps sets the bound",
            )
        )
        return False

    def _forget(self) -> None:
        """Drop everything before the end of the handed-on motion."""
        grid = self.reference.grid
        if grid is None:
            return
        place, run = self._place(grid), self.run
        row = (
            self.runs.row if run is None or run.nodes is None or not len(run.nodes) else int(run.nodes.row[0])
        )
        keep = max(min(row, run.row if run else row) - 6, self.program.base)
        keep = min(keep, max(self.runs.places.stop - 2, self.program.base))
        if run is not None:
            keep = min(keep, run.row, run.at, *([int(run.entry.line)] if run.entry is not None else []))
            run.first = max(run.first, keep)
        self.runs.places.forget(keep)
        place = min(place, self.runs.places.reached) if self.runs.places.stop > self.program.base else place
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
