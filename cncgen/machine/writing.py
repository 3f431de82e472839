"""From `Machine` back to TOML: reading it back gives the same machine."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from cncgen.machine.drives import drive_table
from cncgen.machine.reading import AXIS_LIMITS, TOP_NUMBERS
from cncgen.machine.record import Axis, Machine
from cncgen.units import file_unit, to_file


def to_toml(machine: Machine) -> str:
    """Return the TOML text of a machine, in the keys that `cncgen.machine.load` reads."""
    lines = [f"name = {_value(machine.name)}"]
    numbers = ((key, getattr(machine, key)) for key in TOP_NUMBERS)
    lines += [f"{key} = {_value(number)}" for key, number in numbers if number is not None]
    for axis in machine.axes.values():
        lines += _axis_lines(axis)
    for name, table in machine.settings.items():
        lines += _table_lines(name, table)
    return "\n".join(lines) + "\n"


def table_text(name: str, table: Mapping[str, Any]) -> str:
    """Return one table as TOML text."""
    return "\n".join(_table_lines(name, table)[1:]) + "\n"


def _axis_lines(axis: Axis) -> list[str]:
    name, unit, factor = f"axes.{axis.letter.lower()}", file_unit(axis.letter), to_file(axis.letter)
    lines = ["", f"[{name}]"]
    lines += [
        f"{field}_{unit}_s{power} = {_value(_in_file_unit(getattr(axis, field), factor))}"
        for field, (power, _) in AXIS_LIMITS.items()
    ]
    if axis.travel is not None:
        ends = [_in_file_unit(end, factor) for end in axis.travel]
        lines.append(f"travel_{unit} = {_value(ends)}")
    if axis.servo is not None:
        lines += _table_lines(f"{name}.servo", {"model": axis.servo.model, **axis.servo.parameters})
    if axis.drive is not None:
        lines += _table_lines(f"{name}.drive", drive_table(axis.drive, axis.letter))
    return lines


def _in_file_unit(value: float, factor: float) -> float:
    """Convert to the unit of files; a value that came from a short number of degrees becomes that number again."""
    converted = value * factor
    short = float(f"{converted:.14g}")
    return short if short / factor == value else converted


def _table_lines(name: str, table: Mapping[str, Any]) -> list[str]:
    plain = {key: value for key, value in table.items() if not isinstance(value, Mapping)}
    lines = ["", f"[{name}]", *(f"{_key(key)} = {_value(value)}" for key, value in plain.items())]
    for key, value in table.items():
        if isinstance(value, Mapping):
            lines += _table_lines(f"{name}.{_key(key)}", value)
    return lines


def _key(key: str) -> str:
    bare = key.replace("_", "").replace("-", "")
    return key if bare.isascii() and bare.isalnum() else json.dumps(key)


def _value(value: Any) -> str:
    """Return a TOML value. Texts and numbers of JSON are valid in TOML, except DEL, which TOML demands escaped."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return repr(value) if isinstance(value, (int, float)) else str(value)
