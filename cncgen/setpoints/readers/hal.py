"""HAL: the text that `halstreamer` reads and `halsampler` prints. A line a period, a number a pin, ``#`` comments.

The first line of a file that cncgen wrote names its axes and its period; for others the caller gives them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from typing import BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, Span, excerpt_of
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers import letters_or_fault
from cncgen.setpoints.readers.blocks import FileBlock, RowFaults, check_period
from cncgen.setpoints.readers.csv import line_blocks


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a HAL stream; their times follow from the period in the first line, or from `period_s`.

    Raises:
        UsageError: The axes are unknown, or a line does not hold as many numbers (`RowFaults`).
    """
    lines = line_blocks(file, name)
    first = next(lines, b"")
    letters, stated = _stated(first)
    period_s = period_s or stated
    if period_s is not None:
        check_period(period_s, name)
    letters = letters or letters_or_fault(axes, name, "hal")
    faults, number, row = RowFaults(name), 0, 0
    for text in chain([first], lines):
        rows = []
        for line in text.splitlines():
            number += 1
            if line.strip() and not line.lstrip().startswith(b"#"):
                values = _numbers(line, len(letters))
                if values is None:
                    faults.add(_fault(line, name, number, len(letters)))
                else:
                    rows.append(values)
        if rows and not faults:
            time_s = (
                None if period_s is None else np.arange(row, row + len(rows), dtype=np.float64) * period_s
            )
            row += len(rows)
            yield FileBlock(letters, time_s, np.array(rows, np.float64), period_s)
    faults.raise_any()


def _stated(line: bytes) -> tuple[str, float | None]:
    """Return the axes and the period that the comment of a file of ours names; no axes for other lines."""
    named = re.match(rb"# ([a-z_ ]+) every ([0-9]*\.?[0-9]+(?:e[+-]?[0-9]+)?) s\r?\n", line)
    words = named[1].decode().split() if named else []
    period = float(named[2]) if named else 0.0
    if not 0.0 < period < np.inf or not all(word in POSITION_COLUMNS for word in words):
        return "", None
    return "".join(POSITION_COLUMNS[word] for word in words), period


def _numbers(line: bytes, count: int) -> list[float] | None:
    """Return the numbers of a line, or None where they are not `count` finite ones."""
    try:
        values = [float(word) for word in line.split()]
    except ValueError:
        return None
    return values if len(values) == count and np.isfinite(values).all() else None


def _fault(line: bytes, name: str, number: int, count: int) -> Diagnostic:
    excerpt, cut = excerpt_of(line[:1000].decode("utf-8", "replace"), 1)
    message = f"not a row of {count} finite numbers"
    span = Span(name, number)
    return Diagnostic("setpoints-number", message, span=span, excerpt=excerpt, excerpt_offset=cut)
