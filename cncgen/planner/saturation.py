"""`--saturation reactive`: steps limited tick by tick so that the drives stay out of saturation (Yeh and Sun 2008).

With the discrete PD+ law the force of an axis is linear in its commanded speed (eq. 3.5),

    u[k] = S w_d[k] + v[k],   S = k_p T K_e + k_d + 1/K_c + τ/(K_c T),
    v[k] = k_p (θ_d[k−1] − θ_a[k]) − k_d w_a[k] − τ/(K_c T) w_d[k−1],

so −U <= u <= U bounds w_d (eq. 3.6), and with the direction of the path the speed along it. The motor model runs along
to know v[k]. docs/saturation.md has corrections of the paper, and the reach of a limiter without look-ahead.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import astuple, dataclass, field, replace
from math import exp

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError, Severity, UsageError
from cncgen.kernels import step_limit as kernel
from cncgen.machine.record import Machine
from cncgen.machine.servo_schema import resolve
from cncgen.planner.contour_prediction import servo_of
from cncgen.planner.motion import motion_at, stepped
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Profile, Trajectory
from cncgen.units import to_file

Floats = NDArray[np.float64]

#: Table entries a period, and periods a table.
_PARTS = 16
_PERIODS = 2048
#: Part of the drive's bound that steps may use: setpoints are rounded, and a drive at its bound is saturated.
_USABLE = 0.999
#: Ticks without progress after which the limiter is stuck: no step is feasible, and none becomes so.
_STALL = 20_000
#: Progress, as a part of the plan's: with less a second of the plan takes days.
_STANDING = 1e-5


@dataclass(frozen=True, slots=True)
class PdPlusAxis:
    """The numbers of one PD+ axis that the limiter needs (Yeh and Sun 2008, Table 1 and section 3.2).

    Attributes:
        gain: S, V s/rad.
        position: k_p, V/count.
        derivative: k_d, V s/rad.
        feedforward: τ/(K_c T), V s/rad.
        bound: Force of the U that steps may use, V.
        coulomb: Coulomb friction, as input, V.
        counts_per_mm: Encoder counts a unit of travel.
        counts_per_rad: K_e.
        decay, drive: w⁺ = decay · w + drive · u: the motor over a period, u held.
        travel_speed, travel_drive: θ⁺ = θ + travel_speed · w + travel_drive · u, in counts.
    """

    gain: float
    position: float
    derivative: float
    feedforward: float
    bound: float
    counts_per_mm: float
    counts_per_rad: float
    decay: float
    drive: float
    travel_speed: float
    travel_drive: float
    coulomb: float = 0.0

    @classmethod
    def of(cls, values: dict[str, float], period_s: float) -> PdPlusAxis:
        """Compute them from the parameters of the servo model ``pd-plus`` in inside units."""
        tau, kc = values["time_constant_s"], values["velocity_gain_rad_s_volt"]
        ke = values["counts_per_rad"]
        kp, kd = values["position_gain_volt_count"], values["derivative_gain_volt_s_rad"]
        ahead = values["feedforward"]
        ka = tau / (kc * period_s) if ahead else 0.0
        kv = 1.0 / kc if ahead else 0.0
        decay = exp(-period_s / tau)
        lag = tau * (1.0 - decay)
        return cls(
            gain=kp * ke * period_s + kd + kv + ka,
            position=kp,
            derivative=kd,
            feedforward=ka,
            bound=_USABLE * values["saturation_volt"],
            counts_per_mm=values["counts_per_mm"],
            counts_per_rad=ke,
            decay=decay,
            drive=(1.0 - decay) * kc,
            travel_speed=ke * lag,
            travel_drive=ke * kc * (period_s - lag),
            coulomb=values["coulomb_volt"],
        )

    @property
    def row(self) -> list[float]:
        """Return the numbers in the order of the kernel's columns, which is theirs; friction has none."""
        return list(astuple(self)[:-1])


def limit_reactive(
    trajectories: Iterator[Trajectory], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Return the trajectories with their steps limited so that the drives' forces are (Yeh and Sun 2008, eqs 3.5 and 3.6).

    Yields:
        Trajectories whose profiles are steps of constant speed, one a period. ``values["saturation"]`` counts the
        ticks at which no step kept every drive within its bound, and those at which a drive saturated.

    Raises:
        UsageError: An axis of the machine has no `pd-plus` servo data with a `saturation_volt`.
        NoPlanError: The drives hold the axes back for good.
    """
    return _limited(trajectories, Limiter(pd_plus_axes(machine, options), machine.period_s))


def pd_plus_axes(machine: Machine, options: PlanOptions) -> dict[str, PdPlusAxis]:
    """Return the axes of a machine by letter; raise `UsageError` that names all others."""
    axes: dict[str, PdPlusAxis] = {}
    faults: list[Diagnostic] = []
    for letter in machine.axes:
        servo = servo_of(machine, options, letter)
        values = resolve(servo, letter) if servo is not None and servo.model == "pd-plus" else None
        if values is None or values["saturation_volt"] is None:
            faults.append(
                Diagnostic(
                    "saturation-model",
                    f"saturation {options.saturation} predicts the drive of axis {letter} with the model pd-plus and its "
                    "saturation_volt, and its servo data do not have them",
                    hint="give servo data with --axis-params, such as the profile die-bonder's",
                )
            )
            continue
        axes[letter] = PdPlusAxis.of(values, machine.period_s)
    if faults:
        raise UsageError(faults)
    return axes


def _limited(trajectories: Iterator[Trajectory], limiter: Limiter) -> Iterator[Trajectory]:
    """Limit each trajectory once those after it cover the period that its last step may reach into."""
    open_: deque[Trajectory] = deque()
    tail = np.zeros((1, 4))
    for trajectory in trajectories:
        open_.append(trajectory)
        while open_[-1].profile.t[-1] - open_[0].profile.t[-1] > 2.0 * limiter.period_s:
            done, tail = _limit_first(list(open_), limiter, tail)
            yield done
            open_.popleft()
    while open_:
        done, tail = _limit_first(list(open_), limiter, tail)
        yield done
        open_.popleft()


def _limit_first(open_: list[Trajectory], limiter: Limiter, tail: Floats) -> tuple[Trajectory, Floats]:
    """Limit the first of some consecutive trajectories, of which the others may be run into by its last step.

    `tail` are knots (see `Limiter.advance`) from its start on; returned are the limited trajectory, and the knots from its end on.
    """
    trajectory = open_[0]
    before = (limiter.infeasible, limiter.saturated)
    knots = np.concatenate([tail, limiter.advance(open_)])
    inside, tail = _cut(knots, trajectory.profile, float(tail[0, 2]))
    limited = _with_knots(trajectory, inside)
    counts = {
        "infeasible_ticks": limiter.infeasible - before[0],
        "saturated_ticks": limiter.saturated - before[1],
    }
    remarks = tuple(trajectory.values.get("diagnostics", ()))
    if any(counts.values()):
        remarks += (_remark(trajectory, inside, counts),)
    values = {**trajectory.values, "saturation": counts, "diagnostics": remarks}
    return replace(limited, values=values), tail


@dataclass(slots=True)
class Limiter:
    """The motors and the tool, from tick to tick.

    Attributes:
        axes: The PD+ axes by letter.
        period_s: T.
        tick: The last tick that is planned; the next one is planned from its measurements.
        planned: Time of the plan at that tick.
        travel: Length travelled until then, mm.
        infeasible, saturated: Ticks so far without a feasible step, and with a drive at its bound.
        forces: Lower and upper bound of w_d, w_d and u of each tick and axis, shape (ticks, axes, 4), where kept.
    """

    axes: dict[str, PdPlusAxis]
    period_s: float
    tick: int = 0
    planned: float = 0.0
    travel: float = 0.0
    infeasible: int = 0
    saturated: int = 0
    keep_forces: bool = False
    forces: list[Floats] = field(default_factory=list)
    _state: Floats | None = None

    def advance(self, open_: list[Trajectory]) -> Floats:
        """Step on until the plan's time reaches the end of the first of some consecutive trajectories.

        Returns:
            Knots, shape (n, 4): time, time of the plan, length travelled, and 1 where no step was feasible.
        """
        end = float(open_[0].profile.t[-1])
        part = self.period_s / _PARTS
        knots = [np.zeros((0, 4))]
        standing = 0
        while self.planned < end - 1e-9 * self.period_s:
            ahead = min(int(np.ceil((end - self.planned) / part)), _PERIODS * _PARTS)
            times: Floats = self.planned + part * np.arange(ahead + _PARTS + 1.0)
            place, x, direction = self._table(open_, times)
            stop = min((end - self.planned) / part - 1e-9 * _PARTS, float(ahead))
            knots.append(self._steps(place, x, direction, stop, part))
            real_s, planned_s = knots[-1][-1, :2] - knots[-1][0, :2]
            standing = 0 if planned_s > _STANDING * real_s else standing + len(knots[-1])
            if standing > _STALL:
                raise NoPlanError(_stalled(open_[0], float(knots[-1][-1, 1])))
        return np.concatenate(knots)

    def _steps(self, place: Floats, x: Floats, direction: Floats, stop: float, part: float) -> Floats:
        """Run the kernel over one table and advance by its result."""
        table = np.array([axis.row for axis in self.axes.values()])
        if self._state is None:
            rest = x[0] * table[:, 5]
            zero = np.zeros(len(table))
            self._state = np.stack([rest, rest, zero, rest, zero], axis=1)
        steps = np.zeros((_PERIODS, 3))
        forces = np.zeros((_PERIODS, len(table), 4))
        count = kernel.limit_steps(
            place,
            x,
            direction,
            float(_PARTS),
            0.0,
            stop,
            self.period_s,
            table,
            self._state,
            np.zeros((len(table), 2)),
            steps,
            forces,
        )
        done, used = steps[:count], forces[:count]
        over = np.abs(used[:, :, 3]) > table[:, 4] / _USABLE
        self.infeasible += int(np.count_nonzero(done[:, 2]))
        self.saturated += int(np.count_nonzero(over.any(axis=1)))
        if self.keep_forces:
            self.forces.append(used)
        times = (self.tick + 1 + np.arange(count)) * self.period_s
        planned = self.planned + done[:, 0] * part
        self.tick += count
        self.planned, self.travel = float(planned[-1]), float(done[-1, 1])
        return np.stack([times, planned, done[:, 1], done[:, 2]], axis=1)

    def _table(self, open_: list[Trajectory], times: Floats) -> tuple[Floats, Floats, Floats]:
        """Tabulate travel, positions and directions of the axes at times of the plan."""
        n, letters = len(times), list(self.axes)
        place, x = np.zeros(n), np.zeros((n, len(letters)))
        direction = np.zeros((n, len(letters)))
        begin, length = 0, None
        for i, trajectory in enumerate(open_):
            profile = trajectory.profile
            last = i == len(open_) - 1
            stop = n if last else int(np.searchsorted(times, profile.t[-1], side="left"))
            s = motion_at(profile, times[begin:stop]).s
            if length is None:
                # The travel at the first time is known; the rest is counted from there.
                first = s[0] if len(s) else motion_at(profile, times[:1]).s[0]
                length = self.travel - first
            place[begin:stop] = length + s
            columns = [trajectory.toolpath.axes.index(letter) for letter in letters]
            found = trajectory.toolpath.path.evaluate(s, 1)
            x[begin:stop] = found[0][:, columns]
            direction[begin:stop] = found[1][:, columns]
            if not last:
                length += float(profile.s[-1] - open_[i + 1].profile.s[0])
            begin = stop
        return np.maximum.accumulate(place), x, direction


def _cut(knots: Floats, plan: Profile, start: float) -> tuple[Floats, Floats]:
    """Cut knots where the plan's time reaches the end of a trajectory that begins at the travel `start`."""
    end, goal = float(plan.t[-1]), start + float(plan.s[-1] - plan.s[0])
    after = int(np.searchsorted(knots[:, 1], end - 1e-12 - 1e-15 * end, side="left"))
    after = min(after, len(knots) - 1)
    if after == 0:
        return knots[:1], knots
    one, other = knots[after - 1], knots[after]
    by_travel = other[2] > one[2]
    column, value = (2, goal) if by_travel else (1, end)
    span = other[column] - one[column]
    share = min(1.0, max(0.0, (value - one[column]) / span)) if span > 0.0 else 1.0
    edge = np.array([one[0] + share * (other[0] - one[0]), end, goal, other[3]])
    rest = knots[after:] if share < 1.0 else knots[after + 1 :]
    return np.concatenate([knots[:after], edge[None]]), np.concatenate([edge[None], rest])


def _with_knots(trajectory: Trajectory, knots: Floats) -> Trajectory:
    """Give a trajectory the profile of steps between knots, and its events and corners their new times."""
    plan = trajectory.profile
    t, planned = knots[:, 0], knots[:, 1]
    s = np.clip(knots[:, 2] - knots[0, 2] + plan.s[0], plan.s[0], plan.s[-1])
    s[-1] = plan.s[-1]
    profile = stepped(plan, t, s, planned)
    held = np.diff(planned) < np.diff(t) * (1.0 - 1e-9)
    profile = replace(profile, limit=np.where(held, np.int8(Limit.SATURATION), profile.limit))
    return trajectory.retimed(profile, lambda time: float(np.interp(time, planned, t)))


def _remark(trajectory: Trajectory, knots: Floats, counts: dict[str, int]) -> Diagnostic:
    """Say how often the drives still saturate, and where first."""
    first = int(np.argmax(knots[1:, 3] > 0.0))
    return Diagnostic(
        "drive-saturates",
        f"{counts['infeasible_ticks']} ticks had no step that keeps every drive within its bound, and "
        f"{counts['saturated_ticks']} saturate; the first near {_where(trajectory, knots[first, 2] - knots[0, 2])}",
        severity=Severity.WARNING,
        hint="a limiter without look-ahead cannot brake ahead of a corner: lower the feed, or plan within the axes' "
        "accelerations",
        values=dict(counts),
    )


def _stalled(trajectory: Trajectory, planned: float) -> Diagnostic:
    s = motion_at(trajectory.profile, np.array([planned])).s[0]
    return Diagnostic(
        "saturation-stall",
        f"the drives hold the motion back for {_STALL} periods near "
        f"{_where(trajectory, s - trajectory.profile.s[0])}, and only steps that are nearly 0 stay feasible",
    )


def _where(trajectory: Trajectory, travelled: float) -> str:
    """Name a place by its source line and position."""
    s = trajectory.profile.s[0] + travelled
    position = trajectory.toolpath.path.evaluate([s])[0, 0]
    row = min(int(np.searchsorted(trajectory.row_s[1:], s)), len(trajectory.toolpath) - 1)
    letters = trajectory.toolpath.axes
    point = " ".join(f"{c}{x * to_file(c):.3f}" for c, x in zip(letters, position, strict=True))
    return f"line {trajectory.toolpath.line[row]}, {point}"
