"""Interpolators that step a NURBS by its parameter, as the papers do: `taylor1`, `taylor2`, `uniform`.

The exact one, `arclength`, needs no code here: the sampler goes to u(s(t)). The others retime a trajectory. On a
NURBS, the piece of motion between two ticks becomes a step at constant speed from the place that one parameter gives
to the place that the next one gives; lines and arcs stay as they are. The steps, and measured fluctuations: docs/interpolators.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.motion import arrival_at, cut, joined, motion_at, stepped, time_at
from cncgen.planner.options import TWO_STAGE, PlanOptions
from cncgen.planner.record import Profile, Trajectory
from cncgen.planner.stateline_interpolation import hold_together
from cncgen.toolpath.record import Kind

Floats = NDArray[np.float64]

#: Samples that are solved for together.
_BLOCK = 1024
#: Sweeps over a block before its final part is kept and a smaller block begun.
_SWEEPS = 32
#: Part of a period by which a tick may miss a time through rounding.
_ROUNDING = 1e-9
#: |C'| below this part of its mean: the Taylor step has no meaning, and the exact one is taken.
_SINGULAR = 1e-7


@dataclass(frozen=True, slots=True)
class Steps:
    """Places reached at times of the retimed motion, and the time of the plan at each; each of shape (n,).

    The first entry is the start, the last the end; those between are ticks.
    """

    t: Floats
    s: Floats
    planned: Floats


@dataclass(frozen=True, slots=True)
class Passage:
    """A curve that a plan passes: the row of a path, the profile, and its times at both ends."""

    path: Path
    row: int
    plan: Profile
    start: float
    end: float

    @property
    def goal(self) -> float:
        """Where on the path it ends."""
        return float(motion_at(self.plan, np.array([self.end])).s[0])


#: (passage, time at its start, period) -> steps.
Stepper = Callable[[Passage, float, float], Steps]


def retime(
    trajectories: Iterator[Trajectory], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Return the trajectories as the interpolator of the options would travel them; `arclength` changes nothing,
    nor does two-stage interpolation, which changes the setpoints instead.

    `taylor1` and `taylor2` are Yeh and Sun 2008, eqs 3.2 and 3.1; `stateline` is `cncgen.planner.stateline_interpolation`.
    """
    if options.interpolator in ("arclength", *TWO_STAGE):
        return trajectories
    if options.interpolator == "stateline":
        return hold_together(trajectories, machine, options)
    return _retimed(trajectories, STEPPERS[options.interpolator], machine.period_s)


def _retimed(trajectories: Iterator[Trajectory], stepper: Stepper, period_s: float) -> Iterator[Trajectory]:
    late = 0.0
    for trajectory in trajectories:
        done = retime_one(trajectory, stepper, period_s, late)
        late = float(done.profile.t[-1] - trajectory.profile.t[-1])
        yield done


def retime_one(trajectory: Trajectory, stepper: Stepper, period_s: float, late_s: float) -> Trajectory:
    """Retime the NURBS rows of one trajectory that begins `late_s` after its plan."""
    path, plan = trajectory.toolpath.path, trajectory.profile
    rows = np.flatnonzero(trajectory.toolpath.kind == Kind.NURBS)
    starts = np.clip(path.row_s[rows], plan.s[0], plan.s[-1])
    ends = np.clip(path.row_s[rows + 1], plan.s[0], plan.s[-1])
    leave, arrive = time_at(plan, starts), arrival_at(plan, ends)
    parts: list[Profile] = []
    known: list[tuple[Floats, Floats]] = []
    now, planned = plan.t[0] + late_s, plan.t[0]
    for row, start, end in zip(rows, leave, arrive, strict=True):
        if end <= start:
            continue
        parts.append(cut(plan, planned, start, now - planned))
        now = parts[-1].t[-1]
        steps = stepper(Passage(path, int(row), plan, start, end), now, period_s)
        parts.append(stepped(plan, steps.t, steps.s, steps.planned))
        known.append((steps.planned, steps.t))
        now, planned = steps.t[-1], end
    parts.append(cut(plan, planned, plan.t[-1], now - planned))
    profile = joined(parts)
    times = np.concatenate([plan.t[:1], *(p for p, _ in known), plan.t[-1:]])
    real = np.concatenate([plan.t[:1] + late_s, *(r for _, r in known), profile.t[-1:]])
    return trajectory.retimed(profile, lambda t: float(np.interp(t, times, real)))


def ticks_between(start: float, end: float, period_s: float) -> Floats:
    """Return the multiples of the period strictly between two times."""
    first = np.floor(start / period_s + _ROUNDING) + 1.0
    last = np.ceil(end / period_s - _ROUNDING)
    return np.arange(first, last) * period_s


def uniform_steps(curve: Passage, now: float, period_s: float) -> Steps:
    """Step through a curve by equal amounts of its parameter in the time that the plan takes for it (Bedi et al. 1993)."""
    start, end = curve.start, curve.end
    ticks = ticks_between(now, now + end - start, period_s)
    t = np.concatenate([[now], ticks, [now + end - start]])
    planned = start + (t - now)
    planned[-1] = end
    ends = motion_at(curve.plan, np.array([start, end])).s
    first, last = curve.path.parameter(curve.row, ends)
    u = first + (last - first) * (planned - start) / (end - start)
    s = curve.path.coordinate(curve.row, u)
    s[0], s[-1] = ends
    return Steps(t, s, planned)


def taylor_steps(order: int, curve: Passage, now: float, period_s: float) -> Steps:
    """Step through a curve by the Taylor expansion of u(t), of order 1 (Yeh and Sun 2008, eq. 3.2) or 2 (eq. 3.1).

    The recurrence is solved by sweeps over blocks of samples (docs/interpolators.md): a sweep makes at least one more sample final.
    """
    goal, begin, end = curve.goal, curve.start, curve.end
    t, planned = [np.array([now])], [np.array([begin])]
    block = _BLOCK
    while True:
        first = np.floor(t[-1][-1] / period_s + _ROUNDING) + 1.0
        ticks = (first + np.arange(block)) * period_s
        wait = np.diff(ticks, prepend=t[-1][-1])
        at = _solve(order, curve, begin, wait, goal)
        ticks, wait = ticks[: len(at)], wait[: len(at)]
        block = min(_BLOCK, max(_SWEEPS, 2 * len(at)))
        over = np.flatnonzero(at >= end - _ROUNDING * period_s)
        if len(over):
            break
        t.append(ticks)
        planned.append(at)
        begin = float(at[-1])
    stop = int(over[0])
    before = np.concatenate([[begin], at[:stop]])[-1]
    t.append(ticks[:stop])
    planned.append(at[:stop])
    # The last step reaches the end of the curve within the period, or (by its error) only at the tick.
    left = end - before
    arrival = np.concatenate([t[-2][-1:], ticks[:stop]])[-1] + min(left, wait[stop])
    t.append(np.array([arrival]))
    planned.append(np.array([end]))
    times, places = np.concatenate(t), np.concatenate(planned)
    s = motion_at(curve.plan, places).s
    s[-1] = goal
    return Steps(times, s, places)


def _solve(order: int, curve: Passage, begin: float, wait: Floats, goal: float) -> Floats:
    """Return the plan's times at the places that steps of the given durations reach; `end` once there.

    Where the curve is so wild that the sweeps do not settle all of them, those that are final.
    """
    end = curve.end
    guess = np.minimum(begin + np.cumsum(wait), end)
    moved = np.zeros(len(wait), dtype=bool)
    for _ in range(_SWEEPS):
        before = np.concatenate([[begin], guess[:-1]])
        after = _stepped_times(order, curve, before, wait, goal)
        found = np.minimum(begin + np.cumsum(after - before), end)
        done = np.maximum.accumulate(found)
        moved = np.abs(done - guess) > 1e-13 + 1e-15 * abs(end)
        guess = done
        if not moved.any():
            return done
    # As many samples as there were sweeps are final whatever the curve.
    final = max(_SWEEPS, int(np.argmax(moved)))
    return guess[:final]


def _stepped_times(order: int, curve: Passage, before: Floats, wait: Floats, goal: float) -> Floats:
    """Take one Taylor step from each place and return the plan's time at the place that it reaches."""
    path, row, plan, end = curve.path, curve.row, curve.plan, curve.end
    place = motion_at(plan, before).s
    aim = motion_at(plan, np.minimum(before + wait, end)).s
    u = path.parameter(row, place)
    speed, growth = _parameter_speed(path, row, place, u)
    regular = speed > 0.0
    x = np.divide(aim - place, speed, out=np.zeros_like(speed), where=regular)
    step = x if order == 1 else x - 0.5 * x**2 * growth
    # At a cusp, or where the second order takes all of the first one back, the Taylor step has no meaning.
    regular &= step > 0.0
    reached = path.coordinate(row, u + np.maximum(step, 0.0))
    # There the exact step is taken; and the last step of a curve ends it exactly.
    reached = np.where(regular & (aim < goal), np.minimum(reached, goal), aim)
    return np.where(reached >= goal, end, time_at(plan, reached))


def _parameter_speed(path: Path, row: int, s: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Return |C'| and ⟨C', C''⟩/|C'|² at places of a row, measured as the path coordinate is.

    With g = ds/du and t = dx/ds: C' = g t and C'' = g² dt/ds + (dg/du) t, so both are projections on t; the second
    value is (dg/du)/g.
    """
    _, tangent, bend = path.evaluate(s, 2)
    _, first, second = path.evaluate_parameter(row, u, 2)
    square = np.maximum(np.einsum("ij,ij->i", tangent, tangent), 1e-300)
    g = np.einsum("ij,ij->i", first, tangent) / square
    slope = np.einsum("ij,ij->i", second - bend * g[:, None] ** 2, tangent) / square
    mean = (path.row_s[row + 1] - path.row_s[row]) / max(
        np.ptp(path.parameter(row, path.row_s[row : row + 2])), 1e-300
    )
    g = np.where(g > _SINGULAR * mean, g, 0.0)
    return g, np.divide(slope, g, out=np.zeros_like(g), where=g > 0.0)


#: The interpolators by name.
STEPPERS: Mapping[str, Stepper] = MappingProxyType(
    {"taylor1": partial(taylor_steps, 1), "taylor2": partial(taylor_steps, 2), "uniform": uniform_steps}
)
