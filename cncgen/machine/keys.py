"""The keys of machine files for people, from the tables of the checks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from cncgen.machine.drives import KEYS as DRIVE_KEYS
from cncgen.machine.reading import AXIS_LIMITS, TOP_NUMBERS
from cncgen.machine.record import Machine
from cncgen.machine.servo_parameters import Parameter
from cncgen.machine.servo_schema import MODELS
from cncgen.machine.settings_schema import TABLES

Row = tuple[str, str, str, str]

_REQUIRED = "required"


def rows() -> Iterator[Row]:
    """Yield key, allowed values, default and description for every key of a machine file.

    Keys stand as those of a linear axis x: a rotary one has ``deg`` where they have ``mm``.
    """
    usual = {field.name: field.default for field in fields(Machine)}
    yield "name", "a text", "the file's name", "what reports call the machine"
    for name, what in TOP_NUMBERS.items():
        yield name, what.wanted, _default(usual[name]), what.about
    for limit, (power, what) in AXIS_LIMITS.items():
        yield f"axes.x.{limit}_mm_s{power}", what.wanted, _REQUIRED, what.about
    yield "axes.x.travel_mm", "[lowest, highest]", "not limited", "positions that the axis can take"
    yield (
        "axes.x.servo.model",
        f"one of {', '.join(MODELS)}",
        _REQUIRED,
        "which keys follow in [axes.x.servo]",
    )
    for model, schema in MODELS.items():
        for parameter in schema.parameters:
            yield _servo_row(model, parameter)
    for drive_key in DRIVE_KEYS:
        default = _REQUIRED if drive_key.required else drive_key.default
        yield f"axes.x.drive.{drive_key.key('X')}", drive_key.wanted, default, drive_key.about
    for table, keys in TABLES.items():
        for key in keys:
            yield f"{table}.{key.name}", key.wanted, key.default or _REQUIRED, key.about


def _servo_row(model: str, parameter: Parameter) -> Row:
    default = _REQUIRED if parameter.required else _default(parameter.default)
    return f"{model}: {parameter.key('X')}", parameter.wanted, default, parameter.about.replace("{l}", "mm")


def _default(value: Any) -> str:
    return "none" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
