"""`--saturation predictive`: accelerations and jerks for which the force of the PD+ law never exceeds the bound of a drive.

From setpoint to force a PD+ axis is linear and time-invariant, so its force is a sum. One part is the steady-state force of speed and
acceleration. The other is the response h to the third differences of the setpoints, which a plan holds under a limit J:

    |u[k]| ≤ |c_v| V + |c_a| A + J Σ|h|          or          |u[k]| ≤ |c_v| V + A Σ|g|

with g the response to the second differences. On any path, a plan within A and J stays within the drive's bound if the smaller
right-hand side does. Derivation: docs/saturation.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.machine.record import Axis, Machine
from cncgen.planner.limits.speeds import change_time
from cncgen.planner.motion import axes_at
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Trajectory
from cncgen.planner.saturation import PdPlusAxis, pd_plus_axes

Floats = NDArray[np.float64]

#: Part of an answer that may lie beyond the samples that are summed.
_REST = 1e-10
#: Samples after which a response that has not died away counts as unstable.
_LONGEST = 1 << 17
#: Ways to share the force between acceleration and jerk that are looked at.
_SHARES = 99
#: Part of the force that speed alone may take.
_CRUISE = 0.75
#: Part of the bound left for the third differences' 0.1 % and for setpoints being rounded.
_PLAY = 0.998


@dataclass(frozen=True, slots=True)
class ForceGains:
    """The force that a PD+ axis asks of its drive, V per mm/s, mm/s² and mm/s³.

    Attributes:
        velocity, acceleration: |c_v|, |c_a|: in the steady state.
        jerk: Σ|h|, answer to third differences with the steady state taken off.
        pulse: Σ|g|, answer to second differences with the part of the speed taken off.
        friction: Σ|f|, V of control per V of Coulomb friction.
    """

    velocity: float
    acceleration: float
    jerk: float
    pulse: float
    friction: float

    @classmethod
    def of(cls, axis: PdPlusAxis, period_s: float) -> ForceGains:
        """Run the law and the motor (Yeh and Sun 2008, eqs 3.3 to 3.5) for unit pulses, until they have died away.

        Raises:
            ValueError: They do not: the loop is unstable.
        """
        n = 4096
        while n <= _LONGEST:
            pulse, rest = np.zeros(n), np.zeros(n)
            pulse[0] = 1.0
            with np.errstate(over="ignore", invalid="ignore"):
                u, f = _forces(axis, period_s, pulse, rest), _forces(axis, period_s, rest, pulse)
            if all(np.abs(x[n // 2 :]).sum() <= _REST * np.abs(x).sum() for x in (u, f)):
                return cls._summed(u, f, period_s)
            n *= 2
        raise ValueError("the answer of its loop to a pulse does not die away")

    @classmethod
    def _summed(cls, u: Floats, f: Floats, period_s: float) -> ForceGains:
        """Sum the answer to a pulse of position once for its speed, acceleration and jerk.

        Before the next sum the steady state, the sum of an answer, is taken off its first sample, so that what is summed
        dies away.
        """
        answer, steady = u, [0.0]
        answers = [u]
        for _ in range(3):
            rest = answer.copy()
            rest[0] -= steady[-1]
            answer = period_s * np.cumsum(rest)
            steady.append(float(answer.sum()))
            answers.append(answer)
        sums = [float(np.abs(x).sum()) for x in (answers[3], answers[2], f)]
        return cls(abs(steady[1]), abs(steady[2]), *sums)

    def asked(self, velocity: float, acceleration: float, jerk: float) -> float:
        """Return the largest force that a motion within these limits can ask for, V."""
        steady = self.acceleration * acceleration + self.jerk * jerk
        return self.velocity * velocity + min(steady, self.pulse * acceleration)

    def within(self, force: float, velocity: float, acceleration: float, jerk: float) -> tuple[float, float]:
        """Return the acceleration and jerk, at most those given, that keep what they ask for under a force.

        Of the pairs that use all of it, this pair reaches the largest velocity from rest soonest.
        """
        if self.asked(0.0, acceleration, jerk) <= force:
            return acceleration, jerk
        share = np.linspace(0.0, 1.0, _SHARES + 2)[1:-1]
        a = np.minimum(acceleration, share * force / self.acceleration)
        j = np.minimum(jerk, (force - self.acceleration * a) / self.jerk)
        a = np.append(a, min(acceleration, force / self.pulse))
        j = np.append(j, jerk)
        best = int(change_time(np.full(len(a), velocity), a, j).argmin())
        return float(a[best]), float(j[best])


def _forces(axis: PdPlusAxis, period_s: float, position: Floats, push: Floats) -> Floats:
    """Return the force of each period for setpoints (mm) and a disturbance at the drive's input (V), from rest.

    Shape (n,) each; overflow to infinity where the loop is unstable.
    """
    theta = position * axis.counts_per_mm
    per_step = 1.0 / (period_s * axis.counts_per_rad)
    u = np.empty(len(theta))
    actual = before = w = wanted = command = 0.0
    for k in range(len(theta)):
        v = axis.position * (command - actual) - axis.derivative * (actual - before) * per_step
        v -= axis.feedforward * wanted
        wanted = (theta[k] - command) * per_step
        u[k] = axis.gain * wanted + v
        drive = u[k] + push[k]
        before, command = actual, theta[k]
        actual += axis.travel_speed * w + axis.travel_drive * drive
        w = axis.decay * w + axis.drive * drive
    return u


def drivable(machine: Machine, options: PlanOptions) -> Machine:
    """Return the machine with its speeds, accelerations and jerks lowered to the abilities of its drives.

    Raises:
        UsageError: An axis has no `pd-plus` servo data with a `saturation_volt`.
        NoPlanError: Friction takes all that a drive has, or its loop is unstable.
    """
    axes = dict(machine.axes)
    for letter, model in pd_plus_axes(machine, options).items():
        axes[letter] = _drivable(letter, axes[letter], model, machine.period_s)
    return replace(machine, axes=MappingProxyType(axes))


def _drivable(letter: str, axis: Axis, model: PdPlusAxis, period_s: float) -> Axis:
    try:
        gains = ForceGains.of(model, period_s)
    except ValueError as problem:
        raise NoPlanError(
            Diagnostic("saturation-limit", f"the force of axis {letter} cannot be bounded: {problem}")
        ) from None
    force = _PLAY * (model.bound - gains.friction * model.coulomb)
    if force <= 0.0:
        raise NoPlanError(
            Diagnostic(
                "saturation-limit",
                f"friction of axis {letter} takes {gains.friction * model.coulomb:.4g} V, and nothing is left of the "
                f"{model.bound:.4g} V that its drive has",
                hint="give the drive more voltage, or servo data with less friction",
            )
        )
    # A speed that takes nearly all of the force would leave nothing to reach it with.
    velocity = min(axis.max_velocity, _CRUISE * force / gains.velocity)
    left = force - _PLAY * gains.velocity * velocity
    acceleration, jerk = gains.within(left, velocity, axis.max_acceleration, axis.max_jerk)
    return replace(axis, max_velocity=velocity, max_acceleration=acceleration, max_jerk=jerk)


def named(trajectories: Iterator[Trajectory], machine: Machine, lowered: Machine) -> Iterator[Trajectory]:
    """Say `SATURATION` where the limit that binds is one that the drives lowered.

    Args:
        trajectories: Of a plan on `lowered`.
        machine, lowered: Before and after `drivable`.
    """
    for trajectory in trajectories:
        profile = trajectory.profile
        limit = profile.limit.copy()
        letters = trajectory.toolpath.axes
        for order, kind in enumerate((Limit.VELOCITY, Limit.ACCELERATION, Limit.JERK)):
            at = np.flatnonzero(limit == kind)
            if not len(at):
                continue
            limits = _limits(lowered, letters, order)
            own = limits < _limits(machine, letters, order)
            middle = 0.5 * (profile.t[at] + profile.t[at + 1])
            axis = (np.abs(axes_at(trajectory, middle, order + 1)) / limits).argmax(axis=1)
            limit[at[own[axis]]] = Limit.SATURATION
        yield replace(trajectory, profile=replace(profile, limit=limit))


def _limits(machine: Machine, letters: str, order: int) -> Floats:
    """Return speeds, accelerations or jerks of the axes, infinite for those that the machine does not have."""
    name = ("max_velocity", "max_acceleration", "max_jerk")[order]
    return np.array([getattr(machine.axes.get(letter), name, None) or np.inf for letter in letters])
