"""Plans that leave room under the limits for a compensation of the servo's errors.

A motion that is planned to its limits leaves none: the command has to add what the loop smooths away. Here a
program is planned, compensated, and where the command breaks a limit planned again with that limit lowered by the ratio
that was found; the correction falls nearly in proportion, so two or three rounds are enough.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.machine.record import Axis, Machine, Servo
from cncgen.planner import PlanOptions, plan
from cncgen.servo.mirror import LIMIT_KEYS, ROOM, Compensation
from cncgen.setpoints import sample
from cncgen.setpoints.record import Setpoints
from cncgen.toolpath.record import Toolpath
from cncgen.units import ORDER_NAMES

#: Rounds of lowering limits before it is given up.
ROUNDS = 12
#: Share of a limit below which no plan is made: more passes than the loops bear multiply the command without end.
LEAST_SHARE = 0.01


@dataclass(frozen=True, slots=True)
class Reserved:
    """A compensated command with the plan that left room for it.

    Attributes:
        command: Setpoints to send to the machine.
        shares: Of the limits that the plan was allowed, by axis letter: (velocity, acceleration, jerk).
        time_s, full_time_s: Of this plan, and of one to the full limits.
        gained: Errors before and after, as `Compensation.gained`; with ``full_before`` those of the full plan.
    """

    command: tuple[Setpoints, ...]
    shares: Mapping[str, tuple[float, float, float]]
    time_s: float
    full_time_s: float
    gained: dict[str, Any]


def compensated_plan(
    toolpaths: Sequence[Toolpath],
    machine: Machine,
    servos: Mapping[str, Servo],
    *,
    axes: str,
    options: PlanOptions | None = None,
    passes: int = 1,
    settle_s: float = 0.1,
) -> Reserved:
    """Plan a program with as much room under the limits as its compensated command needs.

    Args:
        toolpaths: The program.
        machine: Machine with the limits that the command keeps.
        servos: Servo data by axis.
        axes: Columns of the setpoints.
        options: How it is planned.
        passes, settle_s: As of `cncgen.servo.mirror.Compensation`.

    Raises:
        NoPlanError: There is no plan, or the command leaves the travel, or breaks limits after all rounds, or so far that
            less than `LEAST_SHARE` of one would be left to the plan.
        UsageError: An axis has no servo data.
    """
    shares = {letter: [1.0, 1.0, 1.0] for letter in machine.axes}
    full: tuple[float, dict[str, float | None]] | None = None
    for remaining in range(ROUNDS - 1, -1, -1):
        lowered = _lowered(machine, shares)
        setpoints = tuple(sample(plan(iter(toolpaths), lowered, options), lowered, axes=axes))
        work = Compensation(setpoints, servos, passes=passes, limits=machine.axes, settle_s=settle_s)
        time_s = (setpoints[-1].first + len(setpoints[-1]) - 1) * setpoints[-1].period_s if setpoints else 0.0
        try:
            command, fault = tuple(work.chunks()), None
        except NoPlanError as error:
            command, fault = (), error
        gained = work.gained()
        full = full or (time_s, gained["before"])
        if fault is None:
            kept = {k: (v[0], v[1], v[2]) for k, v in shares.items() if k in axes}
            return Reserved(command, kept, time_s, full[0], {**gained, "full_before": full[1]})
        if not remaining or any("ratio" not in d.values for d in fault.diagnostics):
            raise fault
        for found in fault.diagnostics:
            order = ORDER_NAMES.index(found.values["limit"])
            shares[found.values["axis"]][order] *= ROOM / found.values["ratio"]
        _check_room(shares, fault)
    raise AssertionError("the last round returns or raises")


def _check_room(shares: Mapping[str, Sequence[float]], fault: NoPlanError) -> None:
    """Raise NoPlanError (``compensate-room``), with what the last command broke, where a limit has no room left."""
    share, axis, limit = min(
        (share, axis, limit)
        for axis, of_axis in shares.items()
        for share, limit in zip(of_axis, ORDER_NAMES, strict=True)
    )
    if share < LEAST_SHARE:
        room = Diagnostic(
            "compensate-room",
            f"axis {axis}: {share:.2g} of its {limit} would be left to the plan; the command grows faster than the motion slows",
            hint="use fewer passes",
        )
        raise NoPlanError([room, *fault.diagnostics])


def _lowered(machine: Machine, shares: Mapping[str, Sequence[float]]) -> Machine:
    axes: dict[str, Axis] = {}
    for letter, axis in machine.axes.items():
        limits: dict[str, Any] = {
            key: getattr(axis, key) * share for key, share in zip(LIMIT_KEYS, shares[letter], strict=True)
        }
        axes[letter] = replace(axis, **limits)
    return replace(machine, axes=MappingProxyType(axes))
