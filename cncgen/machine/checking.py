"""Machines made by a script, with the same checks as those from files (`cncgen.machine.reading`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from cncgen.arguments import is_number
from cncgen.diagnostics import Diagnostic, Severity, UsageError
from cncgen.machine.drives import faults_of_record
from cncgen.machine.plausible import new_doubts, tell
from cncgen.machine.reading import AXIS_LIMITS, TOP_NUMBERS, NumberKey
from cncgen.machine.record import Axis, Machine, Servo
from cncgen.machine.settings_schema import TABLES, without_axis
from cncgen.machine.settings_schema import faults as table_faults
from cncgen.units import AXIS_LETTERS, file_unit, to_file

#: Numbers that a machine need not have.
_OPTIONAL = ("max_contour_error_mm", "max_centripetal_mm_s2")


def check_machine(machine: Machine) -> None:
    """Raise `UsageError` that names every wrong field of a machine, or else of its servo data."""
    faults = [
        Diagnostic("machine-value", f"machine {machine.name}: {message}") for message in _faults(machine)
    ]
    if faults:
        raise UsageError(faults)
    for axis in machine.axes.values():
        for field, message, hint in new_doubts(axis, machine.period_s):
            where = f"{field} of axis {axis.letter}" if field in AXIS_LIMITS else field
            text = f"machine {machine.name}, {where}: {message}"
            tell(Diagnostic("machine-doubt", text, severity=Severity.WARNING, hint=hint))
    check_servos({k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None})


def check_servos(servos: Mapping[str, Servo]) -> None:
    """Raise `UsageError` that names every wrong key of servo data by axis letter."""
    faults = []
    for letter, servo in servos.items():
        if letter not in tuple(AXIS_LETTERS):
            hint = f"axes are {' '.join(AXIS_LETTERS)}, in capitals"
            faults.append(Diagnostic("machine-key", f"servo data of {letter!r}: not an axis", hint=hint))
            continue
        if not isinstance(servo, Servo) or not isinstance(servo.parameters, Mapping):
            wanted = "a cncgen.machine.Servo, its parameters a mapping"
            message = f"servo data of axis {letter} are {servo!r}; they are to be {wanted}"
            faults.append(Diagnostic("machine-type", message))
            continue
        faults += [
            Diagnostic(code, f"servo data of axis {letter}, {key}: {message}")
            for code, key, message in _of_servo(servo, letter)
        ]
    if faults:
        raise UsageError(faults)


def _of_servo(servo: Servo, letter: str) -> Iterator[tuple[str, str, str]]:
    """Yield code, key and message of each fault of servo data, those that its controller was designed on among them."""
    from cncgen.machine.servo_schema import faults

    yield from faults({**servo.parameters, "model": servo.model}, letter)
    known = servo.knows
    if known is None:
        return
    if (
        not isinstance(known, Servo)
        or not isinstance(known.parameters, Mapping)
        or known.model != servo.model
    ):
        yield (
            "machine-type",
            "knows",
            f"is {known!r}; it is to be a cncgen.machine.Servo of the same model, or None",
        )
        return
    for code, key, message in _of_servo(known, letter):
        yield code, f"knows, {key}", message


def _faults(machine: Machine) -> Iterator[str]:
    for name, what in TOP_NUMBERS.items():
        value = getattr(machine, name)
        if value is not None or name not in _OPTIONAL:
            yield from _of_number(name, value, 1.0, what, "")
    if not isinstance(machine.name, str):
        yield f"name is {machine.name!r}; it is to be a text"
    if not isinstance(machine.settings, Mapping):
        yield f"settings is a {type(machine.settings).__name__}; it is to be a mapping of names to tables"
        return
    if not isinstance(machine.axes, Mapping):
        yield f"axes is a {type(machine.axes).__name__}; it is to be a mapping of letters to cncgen.machine.Axis"
        return
    if not machine.axes:
        yield "it has no axis; it needs one at least"
    for letter, axis in machine.axes.items():
        if not isinstance(axis, Axis):
            yield f"axis {letter!r} is a {type(axis).__name__}; it is to be a cncgen.machine.Axis"
        elif letter not in tuple(AXIS_LETTERS) or not isinstance(axis.letter, str) or letter != axis.letter:
            yield f"axis {axis.letter!r} stands under {letter!r}; axes are {' '.join(AXIS_LETTERS)}"
        else:
            yield from _of_axis(axis)
    for name, table in machine.settings.items():
        if name not in TABLES or not isinstance(table, Mapping):
            yield f"settings {name!r}: {table!r}; they are to be tables, by names of {', '.join(TABLES)}"
            continue
        for _, key, message, hint in table_faults(name, table):
            yield f"settings {name}.{key}: {message}{hint and f'; {hint}'}"
        if name == "kinematics":
            for message in without_axis(machine.settings, machine.axes):
                yield f"settings kinematics.axes: {message}"


def _of_axis(axis: Axis) -> Iterator[str]:
    unit, factor = file_unit(axis.letter), to_file(axis.letter)
    for name, (power, what) in AXIS_LIMITS.items():
        yield from _of_number(
            f"{name} of axis {axis.letter}", getattr(axis, name), factor, what, f" {unit}/s{power}"
        )
    if axis.travel is not None:
        ends = tuple(axis.travel) if isinstance(axis.travel, (tuple, list)) else ()
        if not (len(ends) == 2 and all(map(is_number, ends)) and ends[0] < ends[1]):
            yield f"travel of axis {axis.letter} is {axis.travel!r}; it is to be (lowest, highest), or None"
    if axis.drive is not None:
        for message in faults_of_record(axis.drive, axis.letter):
            yield f"drive of axis {axis.letter}, {message}"


def _of_number(name: str, value: Any, factor: float, what: NumberKey, unit: str) -> Iterator[str]:
    """Yield the fault of a number; `factor` converts it to the unit of the ranges."""
    # A limit that was converted once may be an ulp beyond the end of its range.
    if not is_number(value) or not what.low * (1 - 1e-9) <= value * factor <= what.high * (1 + 1e-9):
        yield f"{name} is {value!r}; it is to be {what.wanted}{unit}{' (given in rad)' if factor != 1.0 else ''}"
