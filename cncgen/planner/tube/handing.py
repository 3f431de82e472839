"""Handing on the final part: unchanged stretches of the plan, and motions that replace others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic
from cncgen.geometry.columns import norm
from cncgen.geometry.tables import empty_arcs, empty_nurbs
from cncgen.planner.motion import cut
from cncgen.planner.record import Cubics, Limit, Profile, SharpCorner, Trajectory
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.reference_path import Reference
from cncgen.planner.tube.scales import Bounds
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_problem import Solved
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]

#: A limit binds where this part of it is used.
_BINDS = 0.985
#: Rounding within which a time counts as reached, s.
_ROUNDING = 1e-12
#: An event is between two times if it is so much later than the first one, and earlier than the second, s: rounding of hours is less.
_INSIDE = 1e-9


class Hand:
    """Hands on trajectories in order; `time` is how far in the plan, `later` how much later (earlier, below 0) that is now."""

    def __init__(self, reference: Reference, program: Programmed, bounds: Bounds) -> None:
        self.reference, self.program, self.bounds, self.period_s = reference, program, bounds, bounds.period_s
        # Of a period over a rest, one half at least is on one side of it. If the way of that is too short to show, rests wait for no
        # setpoint, and the plan does not depend on its phase.
        jerk = bounds.jerk[np.isfinite(bounds.jerk)]
        way = float(np.sqrt((jerk**2).sum())) * self.period_s**3 / 48.0
        self.phased = way > 0.999 * bounds.chord_mm
        self.time = -np.inf
        self.later = 0.0
        self.windows = self.kept = 0
        self._events: list[tuple[float, int, Event]] = []
        self._corners: list[SharpCorner] = []
        self._values: dict[str, Any] = {}
        self._taken = 0

    def remark(self, said: Diagnostic) -> None:
        """Attach a diagnostic to the next motion."""
        self._values["diagnostics"] = (*self._values.get("diagnostics", ()), said)

    def _draw(self) -> None:
        """Take events, corners and values off the trajectories of the plan."""
        for trajectory in self.reference.trajectories[self._taken :]:
            self._events.extend(trajectory.events)
            self._corners.extend(trajectory.corners)
            values = dict(trajectory.values)
            remarks = (*self._values.get("diagnostics", ()), *values.pop("diagnostics", ()))
            self._values.update(values)
            if remarks:
                self._values["diagnostics"] = remarks
        self._taken = len(self.reference.trajectories)

    def _due(self, until: float, moved: tuple[Floats, Floats, Floats] | None = None) -> dict[str, Any]:
        """Return events and corners up to a time of the plan, at their time now, and the values so far.

        Args:
            until: The time.
            moved: If another motion stands in the place of the plan, times of the plan, its own, and its speeds then.
        """
        self._draw()

        def now(t: float) -> float:
            return t + self.later if moved is None else float(np.interp(t, moved[0], moved[1]))

        events = [(now(t), line, event) for t, line, event in self._events if t <= until]
        corners = [replace(corner, t_s=now(corner.t_s)) for corner in self._corners if corner.t_s <= until]
        if moved is not None:
            corners = [replace(each, feed_mm_s=float(np.interp(each.t_s, *moved[1:]))) for each in corners]
        self._events = [each for each in self._events if each[0] > until]
        self._corners = [each for each in self._corners if each.t_s > until]
        values, self._values = self._values, {}
        if self.windows:
            values["tolerance_windows"], values["tolerance_windows_kept"] = self.windows, self.kept
        return {"events": tuple(events), "corners": tuple(corners), "values": values}

    def stops_between(self, begin: float, end: float) -> bool:
        """Tell whether the plan rests for an event between two of its times."""
        self._draw()
        return any(begin + _INSIDE < t < end - _INSIDE and event.stands for t, _, event in self._events)

    def until(self, time: float) -> Iterator[Trajectory]:
        """Hand on trajectories of the unchanged plan that end before a time."""
        held = self.reference.trajectories
        while held and held[0].profile.t[-1] <= time - _ROUNDING:
            yield from self.plain(float(held[0].profile.t[-1]))

    def rest(self) -> Iterator[Trajectory]:
        """Hand on all that is left of the plan."""
        yield from self.plain(np.inf)

    def plain(self, until: float) -> Iterator[Trajectory]:
        """Hand on the unchanged plan up to a time."""
        self._draw()
        held = self.reference.trajectories
        while held:
            trajectory = held[0]
            p = trajectory.profile
            begin, end = max(self.time, float(p.t[0])), min(until, float(p.t[-1]))
            if p.t[0] > until or (len(p) and end < begin):
                break
            short = False
            if len(p) and self._wait:
                rest = self._rest(trajectory, begin)
                if rest <= begin + _ROUNDING and end > begin + _ROUNDING:
                    self.time = begin
                    yield self._stand(trajectory, self._wait)
                elif rest < end:
                    end, short = rest, True
            whole = end >= p.t[-1] - _ROUNDING
            part = trajectory
            if len(p) and not (whole and begin <= p.t[0] + _ROUNDING):
                if end - begin <= _ROUNDING:
                    if whole:
                        self._drop()
                        continue
                    break
                part = Trajectory(trajectory.toolpath, trajectory.row_s, cut(p, begin, end))
            due = self._due(float(p.t[-1]) if whole else end)
            yield replace(part, profile=replace(part.profile, t=part.profile.t + self.later), **due)
            self.time = end
            if short and not whole:
                continue
            if not whole:
                break
            self._drop()

    def _drop(self) -> None:
        self.reference.trajectories.pop(0)
        self._taken -= 1

    def improved(
        self, begin: float, place: tuple[int, float], nodes: Nodes, found: Solved, count: int
    ) -> Iterator[Trajectory]:
        """Hand on the first `count` intervals of a motion in the place of the plan, from a row and the part of it that is behind."""
        yield from self.plain(begin)
        held = self.reference.trajectories
        wait = self.standing(begin, found)
        if wait > 1e-12:
            self.time = begin
            yield self._stand(held[0], wait)
        t = begin + self.later + np.concatenate([[0.0], np.cumsum(found.step[:count])])
        old = np.concatenate([[begin], nodes.t[:count]])
        due = self._due(old[-1], (old, t, norm(found.velocity[: count + 1, :3])))
        self.time = float(old[-1])
        self.later = float(t[-1] - old[-1])
        template = held[0].toolpath
        while held and held[0].profile.t[-1] <= self.time + _ROUNDING and len(held) > 1:
            self._drop()
        yield self._trajectory(template, place, nodes, found, count, t, due)

    def _rest(self, trajectory: Trajectory, begin: float) -> float:
        """Return when a trajectory first rests from a time on, before it moves; infinite if it does not."""
        p = trajectory.profile
        at = np.flatnonzero((p.v == 0.0) & (p.a == 0.0) & (p.t[:-1] >= begin - _ROUNDING))
        moving = np.flatnonzero(~p.waits & (p.t[1:] > begin + _ROUNDING))
        if not len(at) or not len(moving) or moving[-1] < at[0]:
            return np.inf
        return float(p.t[at[0]])

    def _stand(self, trajectory: Trajectory, wait: float) -> Trajectory:
        """Return a wait at the place where the motion is: how long the plan rests in corners depends on its phase."""
        p = trajectory.profile
        place, now = float(np.interp(self.time, p.t, p.s)), self.time + self.later
        self.later += wait
        profile = Profile.standing(place, now, now + wait, Limit.CHORD)
        return Trajectory(trajectory.toolpath, trajectory.row_s, profile)

    def standing(self, begin: float, found: Solved) -> float:
        """Return how long a motion that leaves a rest waits for a setpoint there: the plan's wait is for its own way off, s."""
        if not self.phased or (found.velocity[0] != 0.0).any() or (found.acceleration[0] != 0.0).any():
            return 0.0
        return self.until_setpoint(begin)

    def first_setpoint(self, begin: float, found: Solved) -> float:
        """Return how long after the start of a motion in the place of the plan its first setpoint is, s."""
        return self.until_setpoint(begin + self.standing(begin, found))

    def until_setpoint(self, time: float) -> float:
        """Return how long after a time of the plan the next setpoint is, s."""
        periods = (time + self.later) / self.period_s
        return float(np.ceil(periods - 1e-9) - periods) * self.period_s

    @property
    def _wait(self) -> float:
        """The time missing to a whole number of periods that the motion is earlier than the plan, s; 0 where that does not matter."""
        if not self.phased:
            return 0.0
        wait = self.until_setpoint(0.0)
        return wait if wait > 1e-12 else 0.0

    def _trajectory(
        self,
        template: Toolpath,
        begin: tuple[int, float],
        nodes: Nodes,
        found: Solved,
        count: int,
        t: Floats,
        due: dict[str, Any],
    ) -> Trajectory:
        program, scale = self.program, self.program.scale
        x, v, a = (each[: count + 1] / scale for each in (found.position, found.velocity, found.acceleration))
        jerk = found.jerk[:count] / scale
        cubics = Cubics(t, x[:-1], v[:-1], a[:-1], jerk)
        h = np.diff(t)
        # The length is over the axes that measure the row, as its own is.
        over = nodes.weight[:count]
        over = np.where(over.any(axis=1, keepdims=True), over, 1.0)
        speed, rate = _along(v[:-1] * over, a[:-1] * over)
        middle = norm((v[:-1] + 0.5 * h[:, None] * (a[:-1] + 0.25 * h[:, None] * jerk)) * over)
        length = h * (speed + 4.0 * middle + norm(v[1:] * over)) / 6.0
        s = np.concatenate([[0.0], np.cumsum(length)])
        j = 6.0 * (length - h * (speed + 0.5 * h * rate)) / (h * h * h)
        profile = Profile(t, s, speed, rate, j, np.zeros(count), self._limits(nodes, found, count))
        first, stop, row_s = self._rows(begin, nodes, count, s)
        own = slice(first - program.base, stop - program.base)
        n = stop - first
        end = np.stack([np.interp(row_s[1:], s, column) for column in x.T], axis=1)
        toolpath = Toolpath(
            axes=template.axes, start=x[0], kind=np.full(n, Kind.LINE, np.int8), end=end, feed=program.column("feed")[own],
            feed_mode=np.where(program.column("rapid")[own], FeedMode.RAPID, FeedMode.SPEED).astype(np.int8), path_mode=np.full(n, PathMode.CONTINUOUS, np.int8),
            tolerance=program.column("tolerance")[own], curve=np.full(n, -1, np.int64), line=program.column("line")[own],
            source=program.column("source")[own].astype(np.int16), arcs=empty_arcs(), nurbs=empty_nurbs(len(template.axes)), events=(), sources=template.sources,
            degree_mm=template.degree_mm,
        )  # fmt: skip
        return Trajectory(toolpath, row_s, profile, cubics=cubics, **due)

    def _rows(self, begin: tuple[int, float], nodes: Nodes, count: int, s: Floats) -> tuple[int, int, Floats]:
        """Return the first row of a motion, the one after its last, and where on the motion each begins and the last one ends.

        Between nodes, rows have their part of the way by their lengths.
        """
        base = self.program.base
        upto = np.concatenate([[0.0], np.cumsum(self.program.column("length"))])
        row = np.concatenate([[begin[0]], nodes.row[:count]])
        part = np.concatenate([[begin[1]], nodes.part[:count]])
        reached = np.maximum.accumulate(upto[row - base] + part * (upto[row + 1 - base] - upto[row - base]))
        first, stop = int(row[0]), int(row.max()) + 1
        row_s = np.interp(upto[first - base : stop + 1 - base], reached, s)
        row_s[0], row_s[-1] = s[0], s[-1]
        return first, stop, row_s

    def _limits(self, nodes: Nodes, found: Solved, count: int) -> NDArray[np.int8]:
        """Return the binding limit of each interval."""
        out = np.full(count, Limit.NONE, np.int8)

        def use(values: Floats, limit: Floats) -> NDArray[np.bool_]:
            out: NDArray[np.bool_] = (np.abs(values) / limit).max(axis=1) > _BINDS
            return out

        def both(there: NDArray[np.bool_]) -> NDArray[np.bool_]:
            return there[:-1] & there[1:]

        out[use(found.jerk[:count], self.bounds.jerk)] = Limit.JERK
        out[both(use(found.acceleration[: count + 1], self.bounds.acceleration))] = Limit.ACCELERATION
        out[both(use(found.velocity[: count + 1], self.bounds.velocity))] = Limit.VELOCITY
        weight = np.concatenate([nodes.weight[:1], nodes.weight[:count]])
        speed = norm(found.velocity[: count + 1] * weight)
        out[both(speed > _BINDS * np.append(nodes.feed[:1], nodes.feed[:count]))] = Limit.FEED
        out[nodes.least[:count] > _BINDS * found.step[:count]] = Limit.FEED
        return out


def _along(v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Return speed and acceleration along the path, shape (k,)."""
    speed = norm(v)
    rate = (v * a).sum(axis=1) / np.maximum(speed, 1e-12)
    return speed, np.where(speed > 1e-9, rate, 0.0)
