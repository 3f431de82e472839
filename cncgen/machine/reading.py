"""From TOML to `Machine`: every fault of a file is named in one run, by its key path and its line."""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Mapping
from datetime import date, datetime, time
from types import MappingProxyType
from typing import Any, NamedTuple

from cncgen.diagnostics import Diagnostic, Diagnostics, Span, UsageError, excerpt_of
from cncgen.machine.drives import drive_faults, drive_of
from cncgen.machine.record import Axis, Drive, Machine, Servo
from cncgen.machine.servo_schema import faults as servo_faults
from cncgen.machine.settings_schema import TABLES as SETTINGS
from cncgen.machine.settings_schema import faults as settings_faults
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
        """Return what a value must be, in words."""
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


class _File:
    """The text of a machine file and the faults found in it."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.lines = text.splitlines()
        self.places = key_places(self.lines)
        self.faults = Diagnostics()

    def fault(self, code: str, path: str, message: str, hint: str = "", **values: Any) -> None:
        """Note a fault at a key path, with the line of the key or of the nearest table above it."""
        # A table that stands only in the headers of those below it is shown at the first of them.
        near = next((place for place in self.places if place == path or place.startswith(f"{path}.")), path)
        while near and near not in self.places:
            near = near.rpartition(".")[0]
        span, excerpt, cut = None, "", 0
        if near:
            line, column, length = self.places[near]
            excerpt, cut = excerpt_of(self.lines[line - 1], column)
            span = Span(self.name, line, column, length)
        elif self.name:
            message = f"{self.name}: {message}"
        self.faults.add(
            Diagnostic(
                code,
                message,
                span=span,
                excerpt=excerpt,
                excerpt_offset=cut,
                hint=hint,
                values={"key": path, **values},
            )
        )

    def raise_faults(self) -> None:
        """Raise what was found, in the order of the file."""
        if self.faults.has_errors:
            raise UsageError(sorted(self.faults, key=lambda fault: fault.span.line if fault.span else 0))


def key_places(lines: list[str]) -> dict[str, tuple[int, int, int]]:
    """Find where keys stand in a TOML text: key path to line and column (from 1) and length.

    It knows ``[table]`` headers and ``key = value`` lines, which is what machine files are written in; a key that
    it misses is only shown without its line.
    """
    places: dict[str, tuple[int, int, int]] = {}
    table = ""
    for number, line in enumerate(lines, start=1):
        header = re.match(r"\s*\[\s*([^\[\]]+?)\s*\]", line)
        key = re.match(r"\s*([A-Za-z0-9_.\"-]+)\s*=", line)
        if header:
            table = re.sub(r"[\s\"]", "", header[1])
            places.setdefault(table, (number, header.start(1) + 1, len(header[1])))
        elif key:
            path = f"{table}.{key[1]}" if table else key[1]
            places.setdefault(path.replace('"', ""), (number, key.start(1) + 1, len(key[1])))
    return places


def parse_toml(content: bytes, name: str) -> tuple[dict[str, Any], str]:
    """Return the tables of a TOML file, and its text.

    Raises:
        UsageError: It is not UTF-8, not TOML, or nested beyond reason.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"{name} is not a TOML file: byte {error.start} is not UTF-8"
        raise UsageError(Diagnostic("machine-syntax", message)) from error
    try:
        return tomllib.loads(text), text
    except tomllib.TOMLDecodeError as error:
        raise UsageError(_syntax_fault(text, name, str(error))) from error
    except ValueError as error:  # an integer of more digits than Python converts
        raise UsageError(Diagnostic("machine-syntax", f"{name}: an integer has too many digits")) from error
    except RecursionError as error:
        message = f"{name}: tables or arrays are nested too deeply"
        raise UsageError(Diagnostic("machine-syntax", message)) from error


def _syntax_fault(text: str, name: str, message: str) -> Diagnostic:
    """Turn tomllib's message, which ends in ``(at line 3, column 5)``, into a diagnostic with its place."""
    place = re.search(r"\s*\(at line (\d+), column (\d+)\)$", message)
    if not place:
        return Diagnostic("machine-syntax", f"{name}: {message}")
    line, column = int(place[1]), int(place[2])
    lines = text.split("\n")
    row = lines[line - 1] if line <= len(lines) else ""
    excerpt, cut = excerpt_of(row, column)
    said = message[: place.start()]
    twice = re.fullmatch(r"Cannot declare \((.*?),?\) twice", said)
    if twice:
        path = ".".join(re.findall("'([^']*)'", twice[1]))
        said = f"the table [{path}] stands twice"
    before, there = row[: column - 1], row[column - 1 :]
    return Diagnostic(
        "machine-syntax",
        said,
        span=Span(name, line, column),
        excerpt=excerpt,
        excerpt_offset=cut,
        hint=next((help for a, b, help in _SYNTAX_HINTS if re.search(a, before) and re.match(b, there)), ""),
    )


#: Text before the place of a fault of syntax, text at the place, and the text that is meant.
_SYNTAX_HINTS = (
    (r"[0-9]$", r",\s*[0-9]", "the decimal sign is a point: 250.0"),
    (r"=\s*$", r"[“”„‘’«]", 'texts stand in straight quotes: name = "mine"'),
    (r"=\s*$", r"[A-Za-z_./\\]", 'texts stand in quotes: name = "mine"; a machine file is TOML, not INI'),
    (r"^[\w.-]+\s*$", r":", 'this is YAML; a machine file is TOML: name = "mine", tables as [axes.x]'),
    (r"^\s*$", r"[{<]", 'this is JSON or XML; a machine file is TOML: name = "mine", tables as [axes.x]'),
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
    table, text = parse_toml(content, name)
    file = _File(name, text)
    known = ("name", "axes", *TOP_NUMBERS, *SETTINGS)
    _unknown_keys(file, table, "", known)
    numbers = {
        key: _quantity(file, table, key, key, what) for key, what in TOP_NUMBERS.items() if key in table
    }
    axes = _axes(file, table)
    given = table.get("name", name)
    if not isinstance(given, str) or not given.strip():
        file.fault("machine-type", "name", f"name: must be a text that is not empty, is {_shown(given)}")
    settings = {key: _settings(file, table, key) for key in SETTINGS if key in table}
    file.raise_faults()
    values = {key: value for key, value in numbers.items() if value is not None}
    return Machine(name=given, axes=MappingProxyType(axes), settings=MappingProxyType(settings), **values)


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
        file = _File(name, text)
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
    file = _File(name, text)
    found = _settings(file, table, "coupling") if "coupling" in table else {}
    file.raise_faults()
    return found


def _axes(file: _File, table: Mapping[str, Any]) -> dict[str, Axis]:
    axes = {}
    for letter, (path, content) in _by_letter(file, table).items():
        axis = _axis(file, letter, path, content)
        if axis is not None:
            axes[letter] = axis
    return {letter: axes[letter] for letter in AXIS_LETTERS if letter in axes}


def _by_letter(file: _File, table: Mapping[str, Any]) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return key path and table of each axis by upper-case letter; note what is not an axis."""
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
            file.fault("machine-type", path, f"{path}: must be a table, is {_shown(content)}")
        elif letter in found:
            file.fault("machine-key", path, f"{path}: the axis stands twice, as {key} and as the other case")
        else:
            found[letter] = path, content
    return found


def _axis(file: _File, letter: str, prefix: str, table: dict[str, Any]) -> Axis | None:
    unit, factor = file_unit(letter), to_file(letter)
    keys = {field: f"{field}_{unit}_s{power}" for field, (power, _) in AXIS_LIMITS.items()}
    travel_key = f"travel_{unit}"
    _unknown_keys(file, table, prefix, (*keys.values(), travel_key, "servo", "drive"), letter)
    limits = {
        field: _quantity(file, table, key, f"{prefix}.{key}", AXIS_LIMITS[field][1])
        for field, key in keys.items()
    }
    travel = _travel(file, table, travel_key, prefix) if travel_key in table else None
    servo = _servo(file, table["servo"], letter, prefix) if "servo" in table else None
    drive = _drive(file, table["drive"], letter, prefix) if "drive" in table else None
    velocity, acceleration, jerk = (limits[field] for field in AXIS_LIMITS)
    if velocity is None or acceleration is None or jerk is None:
        return None
    if travel is not None:
        travel = (travel[0] / factor, travel[1] / factor)
    return Axis(letter, velocity / factor, acceleration / factor, jerk / factor, travel, servo, drive)


def _quantity(file: _File, table: Mapping[str, Any], key: str, path: str, what: NumberKey) -> float | None:
    """Return a number within the range of a quantity, or note its fault."""
    if key not in table:
        file.fault("machine-missing", path, f"{path}: missing")
        return None
    value = table[key]
    if not _is_number(value):
        file.fault("machine-type", path, f"{path}: must be a number, is {_shown(value)}")
        return None
    number = _as_float(value)
    if not (math.isfinite(number) and number > 0):
        file.fault(
            "machine-value",
            path,
            f"{path}: must be positive and finite, is {_shown(value)}",
            value=str(number),
        )
        return None
    if not what.low <= number <= what.high:
        message = f"{path}: must be {what.wanted}, is {number:g}"
        file.fault("machine-value", path, message, "is it in the unit that its key says?", value=str(number))
        return None
    return number


def _travel(file: _File, table: Mapping[str, Any], key: str, prefix: str) -> tuple[float, float] | None:
    value, path = table[key], f"{prefix}.{key}"
    if not (isinstance(value, list) and len(value) == 2 and all(_is_number(v) for v in value)):
        file.fault("machine-type", path, f"{path}: must be two numbers [lowest, highest], is {_shown(value)}")
        return None
    low, high = (_as_float(v) for v in value)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        file.fault("machine-value", path, f"{path}: lowest {low} must be below highest {high}, both finite")
        return None
    return low, high


def _servo(file: _File, table: Any, letter: str, prefix: str) -> Servo | None:
    path = f"{prefix}.servo"
    if not isinstance(table, dict):
        file.fault("machine-type", path, f"{path}: must be a table, is {_shown(table)}")
        return None
    model = table.get("model")
    if not isinstance(model, str):
        what = "missing" if model is None else f"must be a text, is {_shown(model)}"
        code = "machine-missing" if model is None else "machine-type"
        near = difflib.get_close_matches("model", table, 1)
        file.fault(
            code, f"{path}.model", f"{path}.model: {what}", f"is {near[0]} meant for it?" if near else ""
        )
        return None
    for code, key, message in servo_faults(table, letter):
        file.fault(code, f"{path}.{key}", f"{path}.{key}: {message}")
    return Servo(model, MappingProxyType({k: v for k, v in table.items() if k != "model"}))


def _drive(file: _File, table: Any, letter: str, prefix: str) -> Drive | None:
    path = f"{prefix}.drive"
    if not isinstance(table, dict):
        file.fault("machine-type", path, f"{path}: must be a table, is {_shown(table)}")
        return None
    faults = list(drive_faults(table, letter))
    for code, key, message, hint in faults:
        file.fault(code, f"{path}.{key}", f"{path}.{key}: {message}", hint)
    return None if faults else drive_of(table, letter)


def _settings(file: _File, table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = table[key]
    if not isinstance(value, dict):
        file.fault("machine-type", key, f"{key}: must be a table, is {_shown(value)}")
        return {}
    for code, inner, message, hint in settings_faults(key, value):
        file.fault(code, f"{key}.{inner}", f"{key}.{inner}: {message}", hint)
    return MappingProxyType(value)


def _unknown_keys(
    file: _File, table: Mapping[str, Any], prefix: str, known: tuple[str, ...], letter: str = ""
) -> None:
    for key in table:
        if key in known:
            continue
        path = f"{prefix}.{key}" if prefix else key
        file.fault("machine-key", path, f"{path}: unknown key", _hint_for(key, known, letter))


def _hint_for(key: str, known: tuple[str, ...], letter: str) -> str:
    """Say what an unknown key was meant to be: the unit of a rotary axis, or the nearest spelling."""
    if letter:
        wrong, right = ("mm", "deg") if is_rotary(letter) else ("deg", "mm")
        meant = re.sub(rf"_{wrong}(_|$)", rf"_{right}\1", key)
        if meant != key and meant in known:
            kind = "turns" if is_rotary(letter) else "is linear"
            return f"axis {letter} {kind}: the key is {meant}"
    near = difflib.get_close_matches(key, known, 1)
    return f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"


def _is_number(value: Any) -> bool:
    """Tell a number from everything else, truth values included."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _as_float(value: float) -> float:
    """Return a float; an integer too large for one is infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _shown(value: Any) -> str:
    """Return a value as it is shown in a message: short."""
    kinds: dict[type, str] = {
        bool: "a truth value",
        str: "a text",
        dict: "a table",
        list: "an array",
        date: "a date",
        datetime: "a date",
        time: "a time of day",
    }
    text = value.isoformat() if isinstance(value, date | time) else repr(value)
    text = text if len(text) <= 40 else text[:37] + "..."
    return f"{kinds[type(value)]} ({text})" if type(value) in kinds else text
