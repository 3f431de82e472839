"""Limits of an axis that are possible, and that no machine has: a unit was mistaken.

Ratios of limits are times, which are alike on machines of all sizes: V/A, in which an axis reaches its full velocity, and A/J, in which it
reaches its full acceleration, are milliseconds to a few seconds from piezo stages to telescopes. A unit that was mistaken changes one of
them by 60 or 1000, or all of them alike, which makes an axis faster than any is. Limits that stand for none (`FREE`) say nothing.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import NamedTuple

from cncgen.diagnostics import Diagnostic, RemarkWarning
from cncgen.machine.record import Axis
from cncgen.units import file_unit, is_rotary, to_file

#: Longest plausible times, s: to full velocity, to full acceleration, and from end to end of the travel.
LONGEST_TO_VELOCITY_S, LONGEST_TO_ACCELERATION_S, LONGEST_TRAVEL_S = 30.0, 10.0, 1000.0
#: Masters and drives take a setpoint every 0.05 to 20 ms.
LONGEST_PERIOD_S = 0.1
#: No feed axis of a machine comes to this velocity, mm/s: linear motors reach a few metres a second.
FASTEST = 20_000.0
#: A velocity or an acceleration from here on stands for none: 1 km/s and 100 g, in mm, or as many degrees.
FREE = 1e6

#: Remarks that were made, since a machine is read several times in a run; and how many of them are kept.
_told: set[Doubt] = set()
_MOST_TOLD = 1000


class Doubt(NamedTuple):
    """What is implausible: the field of `Axis` that it is about, or ``period_s`` of the machine, what is said of it, and the likely unit."""

    field: str
    message: str
    hint: str


def doubts(axis: Axis, period_s: float) -> Iterator[Doubt]:
    """Yield what is implausible of an axis, with setpoints every `period_s`."""
    unit, factor, linear = file_unit(axis.letter), to_file(axis.letter), not is_rotary(axis.letter)
    velocity, acceleration, jerk = (
        v * factor for v in (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
    )
    to_velocity, to_acceleration = velocity / acceleration, acceleration / jerk
    faster = f"is it in m/s? That is {1e3 * velocity:g} mm/s" if linear else ""
    who = f"axis {axis.letter}"
    if to_acceleration > LONGEST_TO_ACCELERATION_S and acceleration < FREE:
        text = f"at {jerk:g} {unit}/s³ {who} needs {_shown(to_acceleration)} to reach its {acceleration:g} {unit}/s²"
        yield Doubt("max_jerk", text, f"is it in m/s³? That is {1e3 * jerk:g} mm/s³" if linear else "")
    if to_velocity > LONGEST_TO_VELOCITY_S and velocity < FREE:
        text = f"at {acceleration:g} {unit}/s² {who} needs {_shown(to_velocity)} to reach its {velocity:g} {unit}/s"
        hint = f"is it in m/s²? That is {1e3 * acceleration:g} mm/s²" if linear else ""
        yield Doubt("max_acceleration", text, hint)
    elif 2.0 * to_velocity < period_s and acceleration < FREE:
        text = f"at {acceleration:g} {unit}/s² {who} reaches its {velocity:g} {unit}/s in {_shown(to_velocity)}, less than half of the period of {_shown(period_s)}"
        slow = period_s > LONGEST_PERIOD_S
        yield Doubt(
            "period_s" if slow else "max_velocity", text, "is it in s? 1 ms is 0.001" if slow else faster
        )
    if linear and FASTEST < velocity < FREE:
        text = f"{velocity:g} mm/s is {velocity / 1e3:g} m/s, and no axis reaches {FASTEST / 1e3:g} m/s"
        yield Doubt("max_velocity", text, f"is it in mm/min? That is {velocity / 60.0:g} mm/s")
    if linear and axis.travel is not None and axis.travel[1] - axis.travel[0] > LONGEST_TRAVEL_S * velocity:
        length = axis.travel[1] - axis.travel[0]
        text = f"at {velocity:g} mm/s {who} needs {_shown(length / velocity)} for its travel of {length:g} mm"
        yield Doubt("max_velocity", text, faster)


def new_doubts(axis: Axis, period_s: float) -> list[Doubt]:
    """Return those of the doubts of an axis that were not told before."""
    found = [doubt for doubt in doubts(axis, period_s) if doubt not in _told]
    if len(_told) < _MOST_TOLD:
        _told.update(found)
    return found


def tell(diagnostic: Diagnostic) -> None:
    """Tell a doubt of a machine, as a Python warning."""
    warnings.warn(RemarkWarning(diagnostic), stacklevel=4)


def _shown(seconds: float) -> str:
    """Return a time in the unit that people read it in."""
    for size, name in ((3600.0, "h"), (60.0, "min"), (1.0, "s")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.3g} {name}"
    return f"{1e3 * seconds:.3g} ms"
