"""JSON lines: an object a row with the keys of the CSV's columns."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, Span, excerpt_of
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers.blocks import FileBlock, RowFaults, warn_of_columns
from cncgen.setpoints.readers.csv import line_blocks


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a JSON lines file. The first object says which axes there are.

    Raises:
        UsageError: A line is not an object, or lacks a number (`RowFaults`), or the first one names an axis otherwise than
            `POSITION_COLUMNS`.
    """
    faults, number = RowFaults(name), 0
    keys: tuple[str, ...] = ()
    for text in line_blocks(file, name):
        rows: list[list[float]] = []
        for line in text.splitlines():
            number += 1
            if not line.strip():
                continue
            record = _record(line)
            if not keys and record is not None:
                keys = _keys(record)
                warn_of_columns([*map(str.lower, record)] if keys else (), name)
            values = _values(record, keys) if record is not None else None
            if values is None:
                faults.add(_fault(line, name, number))
            else:
                rows.append(values)
        if rows and not faults:
            matrix = np.array(rows, np.float64)
            yield FileBlock(
                "".join(POSITION_COLUMNS[k] for k in keys[1:]), matrix[:, 0].copy(), matrix[:, 1:]
            )
    faults.raise_any()


def _record(line: bytes) -> dict[str, Any] | None:
    try:
        record = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) else None


def _keys(record: dict[str, Any]) -> tuple[str, ...]:
    positions = [k for k in record if k in POSITION_COLUMNS]
    return ("t_s", *positions) if positions and "t_s" in record else ()


def _values(record: dict[str, Any], keys: tuple[str, ...]) -> list[float] | None:
    """Return the numbers under some keys, or None if a number is missing or not finite."""
    values = []
    for key in keys:
        value = record.get(key)
        # Integers of any length are JSON; those beyond a double are refused with the rest.
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e300:
            return None
        values.append(float(value))
    return values or None


def _fault(line: bytes, name: str, number: int) -> Diagnostic:
    excerpt, cut = excerpt_of(line[:1000].decode("utf-8", "replace"), 1)
    return Diagnostic(
        "setpoints-number",
        "not a JSON object with t_s and the axes' positions as finite numbers",
        span=Span(name, number),
        excerpt=excerpt,
        excerpt_offset=cut,
    )
