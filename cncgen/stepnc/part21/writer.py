"""Writing exchange structures: values, instances, whole files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TextIO

from cncgen.stepnc.part21.strings import encode
from cncgen.stepnc.part21.values import (
    DERIVED,
    Binary,
    Constant,
    Enumeration,
    Instance,
    Record,
    Ref,
    Resource,
    Typed,
    Value,
    ValueRef,
)


def format_real(value: float) -> str:
    """Return the shortest text of a real that reads back as the same double, with the point that Part 21 wants.

    Raises:
        ValueError: for what is not finite; Part 21 has no text for it.
    """
    if not math.isfinite(value):
        raise ValueError(f"Part 21 has no text for {value}")
    mantissa, _, exponent = repr(value).partition("e")
    if "." not in mantissa:
        mantissa += "."
    elif mantissa.endswith(".0"):
        mantissa = mantissa[:-1]
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


def format_value(value: Value) -> str:
    """Return the text of a value of `cncgen.stepnc.part21.values`; a bool is written ``.T.`` or ``.F.``.

    Raises:
        ValueError: for a real that is not finite.
        TypeError: for an object of another type.
    """
    if value is None:
        return "$"
    if value is DERIVED:
        return "*"
    kind = type(value)
    if kind is float:
        return format_real(value)
    if kind is bool:
        return ".T." if value else ".F."
    if kind is int:
        return str(value)
    return _format_other(value)


def _format_other(value: Value) -> str:
    if isinstance(value, Ref | ValueRef):
        return repr(value)
    if isinstance(value, Enumeration):
        return f".{value}."
    if isinstance(value, Binary):
        return f'"{value}"'
    if isinstance(value, Resource):
        return f"<{value}>"
    if isinstance(value, Constant):
        return str(value)
    if isinstance(value, str):
        return f"'{encode(value)}'"
    if isinstance(value, Typed):
        return f"{value.type}({format_value(value.value)})"
    if isinstance(value, list | tuple):
        return f"({','.join(map(format_value, value))})"
    raise TypeError(f"no value of an exchange structure: {value!r}")


def format_record(record: Record) -> str:
    """Return ``KEYWORD(parameters)``."""
    return f"{record.keyword}({','.join(map(format_value, record.parameters))})"


def format_instance(instance: Instance) -> str:
    """Return ``#id=…;``, with the parts of a complex instance between parentheses."""
    body = "".join(map(format_record, instance.parts))
    return f"#{instance.id}={f'({body})' if len(instance.parts) > 1 else body};"


def write(
    stream: TextIO,
    instances: Iterable[Instance],
    schemas: Sequence[str],
    name: str = "",
    description: Sequence[str] = ("",),
    comments: Sequence[str] = (),
    time_stamp: str = "",
) -> None:
    """Write a whole file with one DATA section.

    Args:
        stream: Text stream, ASCII suffices.
        instances: Written in this order.
        schemas: For FILE_SCHEMA.
        name: For FILE_NAME.
        description: For FILE_DESCRIPTION.
        comments: Each becomes a comment before the header (``*/`` in it is broken up).
        time_stamp: ISO 8601, for FILE_NAME; empty keeps the file the same from run to run.
    """
    stream.write("ISO-10303-21;\n")
    for comment in comments:
        stream.write(f"/* {comment.replace('*/', '* /')} */\n")
    header = (
        Record("FILE_DESCRIPTION", (tuple(description), "2;1")),
        Record("FILE_NAME", (name, time_stamp, ("",), ("",), "cncgen", "cncgen", "")),
        Record("FILE_SCHEMA", (tuple(schemas),)),
    )
    stream.write("HEADER;\n" + "".join(f"{format_record(r)};\n" for r in header) + "ENDSEC;\nDATA;\n")
    for instance in instances:
        stream.write(format_instance(instance) + "\n")
    stream.write("ENDSEC;\nEND-ISO-10303-21;\n")
