"""The stateline as an interpolator of any plan: all axes hold together while one of them would fall behind.

Source: B. K. Jung and W. C. Choi, eq. 7, after Yellowley and Pottier (1994). At each setpoint every axis checks |E| ≤ |Kve V⁺| + δ,
with its following error E, its error for unit speed Kve, and its speed to the next setpoint V⁺. While one axis breaks the rule, all
references stand still and the loops go on: a hold is a wait in the plan at a setpoint. E comes from the axes' closed loops by the
bilinear transform (Tsai 2010, eqs 10 and 11). While the reference stands still, the error of a stable loop decays below any δ > 0, so
each hold ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic
from cncgen.machine.record import Machine
from cncgen.machine.servo_schema import TransferFunction
from cncgen.planner.contour_prediction import ErrorFilters, increment_filter, predictions
from cncgen.planner.motion import cut, joined, motion_at
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Profile, Trajectory
from cncgen.units import is_rotary

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Setpoints that are checked together, at least and at most.
_LEAST, _MOST = 16, 4096


@dataclass(slots=True)
class Stateline:
    """The loops of the axes on one line.

    Attributes:
        loops: From increments of the reference to the following error, with their running states.
        per_speed_s: Shape (axes,): Kve, s.
        bound_mm: δ.
        period_s: Time between setpoints.
    """

    loops: ErrorFilters
    per_speed_s: Floats
    bound_mm: float
    period_s: float

    @classmethod
    def of(cls, machine: Machine, options: PlanOptions, letters: str) -> Stateline:
        """Set up the line for some axes.

        Raises:
            UsageError: An axis has no servo data, or a loop that is not stable or whose error cannot be predicted; each is named.
        """

        def made(loop: TransferFunction) -> tuple[Floats, Floats]:
            b, a = increment_filter(loop.numerator, loop.denominator, machine.period_s)
            if len(a) > 1 and np.abs(np.roots(a)).max() >= 1.0:
                raise ValueError("its loop is not stable")
            return b, a

        fault = Diagnostic(
            "stateline", "axis {} cannot be on a stateline", hint="give servo data with --axis-params"
        )
        loops, gains = predictions(machine, options, letters, made, fault)
        lags = np.array([abs(lag) for lag, _ in gains])
        return cls(loops, lags, options.stateline_bound_mm, machine.period_s)

    def holds(self, steps: Floats, ahead: Floats) -> Ints:
        """Return for how many periods the line is low at each setpoint, shape (n,); the loops move on.

        Args:
            steps: Shape (n, axes), mm: increments of the references to each setpoint.
            ahead: Shape (n, axes), mm: increments from each setpoint to the next.
        """
        allowed = np.abs(ahead) / self.period_s * self.per_speed_s + self.bound_mm
        held = np.zeros(len(steps), np.int64)
        at, block = 0, _LEAST
        while at < len(steps):
            here = slice(at, at + block)
            broken = self._first(steps[here], allowed[here], breaks=True)
            if broken is None:
                at, block = at + block, min(2 * block, _MOST)
                continue
            at += broken
            held[at] = self._wait(allowed[at])
            at, block = at + 1, _LEAST
        return held

    def _wait(self, allowed: Floats) -> int:
        """Let the loops go on under references that stand until no axis breaks the rule; return after how many periods."""
        still = np.zeros((_LEAST, len(self.loops.states)))
        count = 0
        while True:
            kept = self._first(still, allowed, breaks=False)
            if kept is not None:
                return count + kept + 1
            count += _LEAST

    def _first(self, steps: Floats, allowed: Floats, breaks: bool) -> int | None:
        """Run the loops to the first setpoint at which an axis breaks the rule, or none does; or over all of them (None)."""
        before = self.loops.snapshot()
        broken = np.any(np.abs(self.loops.run(steps)) > allowed, axis=1)
        found = np.flatnonzero(broken == breaks)
        if not len(found):
            return None
        self.loops.restore(before)
        self.loops.run(steps[: found[0] + 1])
        return int(found[0])


def hold_together(
    trajectories: Iterator[Trajectory], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Return a plan with the waits of a stateline (Jung and Choi, eq. 7); δ is ``options.stateline_bound_mm``.

    Raises:
        UsageError: As the trajectories are drawn; see `Stateline.of`.
    """
    line: Stateline | None = None
    late, first, before = 0.0, 0.0, np.zeros(0)
    for trajectory in trajectories:
        axes = trajectory.toolpath.axes
        letters = "".join(c for c in axes if c in machine.axes and not is_rotary(c))
        columns = [axes.index(c) for c in letters]
        if line is None:
            line = Stateline.of(machine, options, letters)
            before = trajectory.toolpath.path.evaluate(trajectory.profile.s[:1], 0)[0][0, columns]
        end = float(trajectory.profile.t[-1])
        last = float(np.ceil(end / machine.period_s - 1e-9))
        ticks = np.arange(first, last) * machine.period_s
        s = motion_at(trajectory.profile, np.append(ticks, min(last * machine.period_s, end))).s
        place = trajectory.toolpath.path.evaluate(s, 0)[0][:, columns]
        held = line.holds(np.diff(place[:-1], axis=0, prepend=before[None]), np.diff(place, axis=0))
        before, first = (place[-2] if len(ticks) else before), last
        waits: Floats = held.astype(np.float64) * machine.period_s
        yield _with_waits(trajectory, ticks, waits, late)
        late += float(held.sum()) * machine.period_s


def _with_waits(trajectory: Trajectory, ticks: Floats, waits: Floats, late_s: float) -> Trajectory:
    """Return a trajectory that begins `late_s` after its plan and stands for `waits` at times of the plan."""
    plan = trajectory.profile
    at, length = ticks[waits > 0.0], waits[waits > 0.0]
    parts: list[Profile] = []
    start, late = float(plan.t[0]), late_s
    for tick, wait in zip(at.tolist(), length.tolist(), strict=True):
        parts.append(cut(plan, start, tick, late))
        parts.append(
            Profile.standing(float(parts[-1].s[-1]), tick + late, tick + late + wait, Limit.CONTOUR_ERROR)
        )
        start, late = tick, late + wait
    parts.append(cut(plan, start, float(plan.t[-1]), late))
    total = np.concatenate([[late_s], late_s + np.cumsum(length)])

    def real(t: float) -> float:
        return t + float(total[np.searchsorted(at, t, side="left")])

    return trajectory.retimed(joined(parts), real)
