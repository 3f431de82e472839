"""Lengths of tools from a tool table in LinuxCNC's format, for files that do not say them.

A STEP-NC tool has a name, a table's tool a number and a remark: ``T3 P3 Z50 D18 ; MILL 18MM``. The name is looked for among
the remarks, then among the numbers.
"""

from __future__ import annotations

import re
from pathlib import Path

from cncgen.diagnostics import Diagnostic, Span, UsageError
from cncgen.files import reading_faults
from cncgen.units import INCH

_WORD = re.compile(r"([A-Z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_LINE = re.compile(r"\s*(?:[A-Z]\s*[+-]?(?:\d+\.?\d*|\.\d+)\s*)*")
#: Bytes of a tool table.
MAX_SIZE = 10_000_000


def tool_lengths(path: Path, inches: bool) -> dict[str, float]:
    """Return length offsets (Z), mm, by what names a tool: the remark in capitals, and the number.

    Args:
        path: The table.
        inches: Whether its lengths are inches.

    Raises:
        UsageError: where it cannot be read, naming every line that is wrong.
    """
    with reading_faults(path), path.open(encoding="utf-8", errors="replace") as file:
        lines = file.read(MAX_SIZE).splitlines()
    found: dict[str, float] = {}
    faults = []
    for k, line in enumerate(lines, 1):
        words, _, remark = line.partition(";")
        if not words.strip():
            continue
        values = dict(_WORD.findall(words.upper()))
        if not _LINE.fullmatch(words.upper()) or not values.get("T", "").isdigit():
            text = (
                "a line of a tool table is T, a number and words like Z12.5, then a remark after a semicolon"
            )
            faults.append(Diagnostic("tool-table", text, span=Span(str(path), k), excerpt=line[:200]))
            continue
        length = float(values.get("Z", 0.0)) * (INCH if inches else 1.0)
        found.setdefault(str(int(values["T"])), length)
        if remark.strip():
            found[remark.strip().upper()] = length
    if faults:
        raise UsageError(faults)
    return found
