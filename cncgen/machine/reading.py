"""From TOML to `Machine`: every fault of a file is named in one run, by its key path and its line."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

from cncgen.diagnostics import Diagnostic, Severity, UsageError
from cncgen.machine.drives import drive_faults, drive_of
from cncgen.machine.plausible import new_doubts, tell
from cncgen.machine.record import Axis, Drive, Machine, Servo
from cncgen.machine.servo_schema import faults as servo_faults
from cncgen.machine.settings_schema import TABLES as SETTINGS
from cncgen.machine.settings_schema import faults as settings_faults
from cncgen.machine.settings_schema import without_axis
from cncgen.machine.toml_file import TomlFile, is_toml_number, parse_toml, toml_value_shown
from cncgen.units import AXIS_LETTERS, file_unit, is_rotary, to_file

#: A machine file is a page of text; more than this is something else.
MAX_BYTES = 1_000_000


class NumberKey(NamedTuple):
    """A positive number of a machine file: its meaning, and the range that computing with it is meant for.

    The ranges hold every machine with room to spare, numbers that stand for "no limit" too, and keep powers and
    quotients of them within doubles, and the time of a motion within what can be waited for.
    """

    about: str
    low: float
    high: float

    @property
    def wanted(self) -> str:
        """Return the allowed values in words."""
        return f"a number from {self.low:g} to {self.high:g}"


#: Numbers at the top of a file, the fields of `Machine` by the same name. Setpoint files count time in nanoseconds, and
#: a thousandth of a period has to be seen in them.
TOP_NUMBERS = MappingProxyType(
    {
        "period_s": NumberKey("time between two setpoints", 1e-6, 10.0),
        "chord_tolerance_mm": NumberKey(
            "largest distance of the chord between two setpoints from the path", 1e-9, 1e6
        ),
        "path_tolerance_mm": NumberKey(
            "how far G64 may leave the programmed path where the program gives no P", 1e-9, 1e6
        ),
        "max_contour_error_mm": NumberKey("bound of the predicted contour error", 1e-6, 1e6),
        "max_centripetal_mm_s2": NumberKey("limit of the acceleration across the path", 1e-6, 1e12),
    }
)
#: Limits of an axis, the fields of `Axis` by the same name, in the unit of files (mm or degrees); each with the power
#: of the second in its unit.
AXIS_LIMITS = MappingProxyType(
    {
        "max_velocity": ("", NumberKey("velocity limit", 1e-3, 1e9)),
        "max_acceleration": ("2", NumberKey("acceleration limit", 1e-6, 1e12)),
        "max_jerk": ("3", NumberKey("jerk limit", 1e-6, 1e15)),
    }
)


def machine_from_toml(content: bytes, name: str) -> Machine:
    """Return the machine that a TOML text describes (keys: README, Machines).

    Args:
        content: UTF-8 text.
        name: Name of the file in messages.

    Raises:
        UsageError: With a diagnostic for each fault: ``machine-syntax``, ``machine-key`` (unknown), ``machine-missing``,
            ``machine-type``, ``machine-value``.
    """
    return machine_from_tables(*parse_toml(content, name), name)


def machine_from_tables(table: Mapping[str, Any], text: str, name: str) -> Machine:
    """Return the machine that the tables of a TOML text describe; see `machine_from_toml`.

    Args:
        table: The tables as tomllib gives them.
        text: The text, for the places of faults; "" without one.
        name: Name of the file in messages.

    Raises:
        UsageError: With a diagnostic for each fault.
    """
    file = TomlFile(name, text)
    known = ("name", "axes", *TOP_NUMBERS, *SETTINGS)
    _unknown_keys(file, table, "", known)
    numbers = {
        key: _quantity(file, table, key, key, what) for key, what in TOP_NUMBERS.items() if key in table
    }
    axes = _axes(file, table)
    given = table.get("name", name)
    if not isinstance(given, str) or not given.strip():
        file.fault(
            "machine-type", "name", f"name: must be a text that is not empty, is {toml_value_shown(given)}"
        )
    settings = {key: _settings(file, table, key) for key in SETTINGS if key in table}
    if isinstance(named := table.get("axes"), dict):
        for message in without_axis(settings, "".join(named).upper()):
            file.fault("machine-missing", "kinematics.axes", f"kinematics.axes: {message}")
    file.raise_faults()
    values = {key: value for key, value in numbers.items() if value is not None}
    machine = Machine(name=given, axes=MappingProxyType(axes), settings=MappingProxyType(settings), **values)
    for letter, (path, _) in _by_letter(file, table).items():
        for field, message, hint in new_doubts(axes[letter], machine.period_s):
            key = f"{path}.{_limit_key(field, letter)}" if field in AXIS_LIMITS else field
            said = file.placed("machine-doubt", key, f"{key}: {message}", hint)
            tell(replace(said, severity=Severity.WARNING))
    return machine


def servos_from_toml(content: bytes, name: str) -> dict[str, Servo]:
    """Return the servo data by axis letter of a machine file, or of a file with ``[axes.*.servo]`` alone.

    Raises:
        UsageError: As `machine_from_toml`; also where no axis has servo data.
    """
    table, text = parse_toml(content, name)
    axes = table.get("axes")
    alone = isinstance(axes, dict) and all(isinstance(a, dict) and set(a) <= {"servo"} for a in axes.values())
    if not alone or set(table) - {"name", "axes", "coupling"}:
        machine = machine_from_toml(content, name)
        servos = {letter: axis.servo for letter, axis in machine.axes.items() if axis.servo is not None}
    else:
        file = TomlFile(name, text)
        found = {
            letter: _servo(file, content["servo"], letter, path)
            for letter, (path, content) in _by_letter(file, table).items()
            if "servo" in content
        }
        file.raise_faults()
        servos = {letter: servo for letter, servo in found.items() if servo is not None}
    if not servos:
        raise UsageError(
            Diagnostic(
                "machine-missing",
                f"{name}: no axis has servo data",
                hint="give each axis a table [axes.x.servo] with its model and parameters",
            )
        )
    return servos


def coupling_from_toml(content: bytes, name: str) -> Mapping[str, Any]:
    """Return the ``[coupling]`` table of a machine file or of a file of servo data, empty if missing.

    Raises:
        UsageError: It is not TOML, or not a table.
    """
    table, text = parse_toml(content, name)
    file = TomlFile(name, text)
    found = _settings(file, table, "coupling") if "coupling" in table else {}
    file.raise_faults()
    return found


def _axes(file: TomlFile, table: Mapping[str, Any]) -> dict[str, Axis]:
    axes = {}
    for letter, (path, content) in _by_letter(file, table).items():
        axis = _axis(file, letter, path, content)
        if axis is not None:
            axes[letter] = axis
    return {letter: axes[letter] for letter in AXIS_LETTERS if letter in axes}


def _by_letter(file: TomlFile, table: Mapping[str, Any]) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return key path and table of each axis by upper-case letter; report other keys."""
    tables = table.get("axes")
    if not isinstance(tables, dict) or not tables:
        code = "machine-missing" if tables is None or tables == {} else "machine-type"
        file.fault(code, "axes", "axes: a machine needs at least one table [axes.x]")
        return {}
    found: dict[str, tuple[str, dict[str, Any]]] = {}
    for key, content in tables.items():
        letter, path = key.upper(), f"axes.{key}"
        if len(letter) != 1 or letter not in AXIS_LETTERS:
            file.fault("machine-key", path, f"{path}: not an axis", "axes are x y z a b c u v w")
        elif not isinstance(content, dict):
            file.fault("machine-type", path, f"{path}: must be a table, is {toml_value_shown(content)}")
        elif letter in found:
            file.fault(
                "machine-key", path, f"{path}: the axis stands twice, as {key.lower()} and as {key.upper()}"
            )
        else:
            found[letter] = path, content
    return found


def _axis(file: TomlFile, letter: str, prefix: str, table: dict[str, Any]) -> Axis | None:
    factor = to_file(letter)
    keys = {field: _limit_key(field, letter) for field in AXIS_LIMITS}
    travel_key = f"travel_{file_unit(letter)}"
    _unknown_keys(file, table, prefix, (*keys.values(), travel_key, "servo", "drive"), letter)
    limits: dict[str, float | None] = {}
    if "servo" in table and not set(keys.values()) & set(table):
        hint = "servo data alone, as cncgen tune writes them, are for --axis-params"
        file.fault("machine-missing", prefix, f"{prefix}: {', '.join(keys.values())} are missing", hint)
    else:
        limits = {
            field: _quantity(file, table, key, f"{prefix}.{key}", AXIS_LIMITS[field][1])
            for field, key in keys.items()
        }
    travel = _travel(file, table, travel_key, prefix) if travel_key in table else None
    servo = _servo(file, table["servo"], letter, prefix) if "servo" in table else None
    drive = _drive(file, table["drive"], letter, prefix) if "drive" in table else None
    velocity, acceleration, jerk = (limits.get(field) for field in AXIS_LIMITS)
    if velocity is None or acceleration is None or jerk is None:
        return None
    if travel is not None:
        travel = (travel[0] / factor, travel[1] / factor)
    return Axis(letter, velocity / factor, acceleration / factor, jerk / factor, travel, servo, drive)


def _limit_key(field: str, letter: str) -> str:
    """Return the key of a limit of an axis."""
    return f"{field}_{file_unit(letter)}_s{AXIS_LIMITS[field][0]}"


def _quantity(file: TomlFile, table: Mapping[str, Any], key: str, path: str, what: NumberKey) -> float | None:
    """Return a number within the range of a quantity, or note its fault."""
    if key not in table:
        file.fault("machine-missing", path, f"{path}: missing")
        return None
    value = table[key]
    if not is_toml_number(value):
        file.fault("machine-type", path, f"{path}: must be a number, is {toml_value_shown(value)}")
        return None
    number = _as_float(value)
    if not (math.isfinite(number) and number > 0):
        file.fault(
            "machine-value",
            path,
            f"{path}: must be positive and finite, is {toml_value_shown(value)}",
            value=str(number),
        )
        return None
    if not what.low <= number <= what.high:
        message = f"{path}: must be {what.wanted}, is {number:g}"
        file.fault("machine-value", path, message, "is it in the unit that its key says?", value=str(number))
        return None
    return number


def _travel(file: TomlFile, table: Mapping[str, Any], key: str, prefix: str) -> tuple[float, float] | None:
    value, path = table[key], f"{prefix}.{key}"
    if not (isinstance(value, list) and len(value) == 2 and all(is_toml_number(v) for v in value)):
        file.fault(
            "machine-type",
            path,
            f"{path}: must be two numbers [lowest, highest], is {toml_value_shown(value)}",
        )
        return None
    low, high = (_as_float(v) for v in value)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        file.fault("machine-value", path, f"{path}: lowest {low} must be below highest {high}, both finite")
        return None
    return low, high


def _servo(file: TomlFile, table: Any, letter: str, prefix: str) -> Servo | None:
    path = f"{prefix}.servo"
    if not isinstance(table, dict):
        file.fault("machine-type", path, f"{path}: must be a table, is {toml_value_shown(table)}")
        return None
    model = table.get("model")
    if not isinstance(model, str):
        what = "missing" if model is None else f"must be a text, is {toml_value_shown(model)}"
        code = "machine-missing" if model is None else "machine-type"
        near = difflib.get_close_matches("model", table, 1)
        file.fault(
            code, f"{path}.model", f"{path}.model: {what}", f"is {near[0]} meant for it?" if near else ""
        )
        return None
    for code, key, message in servo_faults(table, letter):
        file.fault(code, f"{path}.{key}", f"{path}.{key}: {message}")
    return Servo(model, MappingProxyType({k: v for k, v in table.items() if k != "model"}))


def _drive(file: TomlFile, table: Any, letter: str, prefix: str) -> Drive | None:
    path = f"{prefix}.drive"
    if not isinstance(table, dict):
        file.fault("machine-type", path, f"{path}: must be a table, is {toml_value_shown(table)}")
        return None
    faults = list(drive_faults(table, letter))
    for code, key, message, hint in faults:
        file.fault(code, f"{path}.{key}", f"{path}.{key}: {message}", hint)
    return None if faults else drive_of(table, letter)


def _settings(file: TomlFile, table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = table[key]
    if not isinstance(value, dict):
        file.fault("machine-type", key, f"{key}: must be a table, is {toml_value_shown(value)}")
        return {}
    for code, inner, message, hint in settings_faults(key, value):
        file.fault(code, f"{key}.{inner}", f"{key}.{inner}: {message}", hint)
    return MappingProxyType(value)


def _unknown_keys(
    file: TomlFile, table: Mapping[str, Any], prefix: str, known: tuple[str, ...], letter: str = ""
) -> None:
    for key in table:
        if key in known:
            continue
        path = f"{prefix}.{key}" if prefix else key
        file.fault("machine-key", path, f"{path}: unknown key", _hint_for(key, known, letter))


def _hint_for(key: str, known: tuple[str, ...], letter: str) -> str:
    """Suggest the intended key for an unknown one: the unit of a rotary axis, or the nearest spelling."""
    if letter:
        wrong, right = ("mm", "deg") if is_rotary(letter) else ("deg", "mm")
        meant = re.sub(rf"_{wrong}(_|$)", rf"_{right}\1", key)
        if meant != key and meant in known:
            kind = "turns" if is_rotary(letter) else "is linear"
            return f"axis {letter} {kind}: the key is {meant}"
    near = difflib.get_close_matches(key, known, 1)
    return f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"


def _as_float(value: float) -> float:
    """Return a float; an integer too large for one is infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf
