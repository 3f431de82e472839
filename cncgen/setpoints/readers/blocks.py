"""Blocks of times and positions, which every reader hands on, checked for a constant period."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, RemarkWarning, Severity, UsageError
from cncgen.ranges import PERIOD_S, TIME_S
from cncgen.setpoints.columns import inside_units, unread_positions
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.stream import SetpointStream

Floats = NDArray[np.float64]

#: Part of the period by which the time between two rows may differ from it (times may be rounded).
_JITTER = 0.01

#: Rows that determine the period, if there are as many: times of nine decimals then give it to 1e-12 s.
_PERIOD_ROWS = 1000

#: Faulty rows of a kind that are shown.
SHOWN_ROWS = 10


@dataclass(frozen=True, slots=True)
class FileBlock:
    """Rows as a file has them.

    Attributes:
        axes: Letters of the columns of `position`.
        time_s: Shape (n,), or None where the format has no times.
        position: Shape (n, axes), mm and degrees.
        period_s: Time between rows where the file states it, or None.
    """

    axes: str
    time_s: Floats | None
    position: Floats
    period_s: float | None = None


class RowFaults:
    """Faults in the rows of a file: the first ones of each kind, and the number of the others.

    A file of another kind, or of one that goes wrong half-way, has the same fault in a million rows.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._kept: list[Diagnostic] = []
        self._count: Counter[str] = Counter()
        self._last: dict[str, Diagnostic] = {}

    def __bool__(self) -> bool:
        return bool(self._kept)

    def add(self, fault: Diagnostic) -> None:
        """Keep a fault, or count it where there are `SHOWN_ROWS` of its code."""
        self._count[fault.code] += 1
        self._last[fault.code] = fault
        if self._count[fault.code] <= SHOWN_ROWS:
            self._kept.append(fault)

    def raise_any(self) -> None:
        """Raise `UsageError` where there is a fault: with those kept, and one more for all others of a code."""
        if not self:
            return
        for code, count in self._count.items():
            if count > SHOWN_ROWS:
                last = self._last[code].span
                message = f"{self._name}: {count - SHOWN_ROWS} more rows like these"
                message += f", the last on line {last.line}" if last else ""
                self._kept.append(Diagnostic(code, message, span=last, values={"rows": count}))
        raise UsageError(self._kept)


def warn_of_columns(names: Sequence[str], name: str) -> None:
    """Say of columns that look like positions why they are read as none; see `unread_positions`.

    Raises:
        UsageError: An axis would be missed.
    """
    found = unread_positions(names, name)
    errors = [remark for remark in found if remark.severity == Severity.ERROR]
    if errors:
        raise UsageError(errors)
    for remark in found:
        warnings.warn(RemarkWarning(remark), stacklevel=2)


def warn_of_end(last: bytes, name: str) -> None:
    """Warn of the last line of a text that ends amid a number (``setpoints-end``): more digits may be missing, which nothing else shows.

    Some programs end no file with a line end, so it is no error. An object of JSON ends with its bracket.
    """
    if not last[-1:].isdigit() and last[-1:] != b".":
        return
    number = re.split(rb"[,\s]", last)[-1][-40:].decode("ascii", "replace")
    found = Diagnostic(
        "setpoints-end",
        f"{name} has no line end behind its last number, {number}: digits or rows may be missing",
        severity=Severity.WARNING,
        hint="get the whole file, unless the program that wrote it ends no file with a line end",
    )
    warnings.warn(RemarkWarning(found), stacklevel=2)


def stream_of(
    blocks: Iterator[FileBlock], name: str, period_s: float | None, default_period_s: float | None = None
) -> SetpointStream:
    """Take the axes and the period from the first block, and check each later block against them.

    Args:
        blocks: The file's rows.
        name: The file, for messages.
        period_s: The period; None: by the times, or as the file states it where it has a single row.
        default_period_s: The period of a single row in a file that states none.

    Raises:
        UsageError: The file has no rows, no period, or one that is not constant.
    """
    first = _first(blocks)
    if first is None:
        raise UsageError(Diagnostic("setpoints-empty", f"{name} holds no setpoints"))
    if period_s is None and len(first.position) == 1:
        period_s = first.period_s or default_period_s
    period = period_s if period_s is not None else _period(first, name)
    check_period(period, name)
    begin = 0.0 if first.time_s is None else float(first.time_s[0])
    if not abs(begin) <= TIME_S:
        message = f"{name}: the first time, {begin:g} s, is not within ±{TIME_S:g} s"
        raise UsageError(Diagnostic("setpoints-time", message, hint="are the times in seconds?"))
    return SetpointStream(name, first.axes, period, _chunks(first, blocks, name, period))


def check_period(period: float, name: str) -> None:
    """Raise `UsageError` for a period, s, out of range."""
    low, high = PERIOD_S
    if not low <= period <= high:
        message = f"{name}: the period, {period:g} s, is not within {low:g} to {high:g} s"
        hint = "are the times in seconds? --period states it"
        raise UsageError(Diagnostic("setpoints-period", message, hint=hint, values={"period_s": period}))


def only(stream: SetpointStream, letters: str) -> SetpointStream:
    """Return a stream of some of its axes, in its own order.

    Raises:
        UsageError: It has not all of them.
    """
    missing = [letter for letter in letters if letter not in stream.axes]
    if missing:
        message = f"{stream.name} has no axis {', '.join(missing)}; it has {', '.join(stream.axes)}"
        raise UsageError(Diagnostic("setpoints-axes", message))
    columns = [k for k, letter in enumerate(stream.axes) if letter in letters]
    axes = "".join(stream.axes[k] for k in columns)
    chunks = (replace(chunk, axes=axes, position=chunk.position[:, columns]) for chunk in stream.chunks)
    return replace(stream, axes=axes, chunks=chunks)


def _first(blocks: Iterator[FileBlock]) -> FileBlock | None:
    """Join blocks until the period can be told from their times: a pipe may hand on a row at a time."""
    taken: list[FileBlock] = []
    for block in blocks:
        if len(block.position):
            taken.append(block)
        if block.time_s is None or sum(len(b.position) for b in taken) >= _PERIOD_ROWS:
            break
    if len(taken) < 2:
        return taken[0] if taken else None
    times = [block.time_s for block in taken if block.time_s is not None]
    positions = np.concatenate([block.position for block in taken])
    return FileBlock(taken[0].axes, np.concatenate(times), positions, taken[0].period_s)


def _period(block: FileBlock, name: str) -> float:
    """Return the mean time step of a block, as the round number of nanoseconds if it is one."""
    if block.time_s is None or len(block.time_s) < 2:
        message = f"{name}: the period cannot be told from " + (
            "a format without times" if block.time_s is None else "a single row"
        )
        raise UsageError(Diagnostic("setpoints-period", message, hint="say --period SECONDS"))
    steps = len(block.time_s) - 1
    mean = float(block.time_s[-1] - block.time_s[0]) / steps
    if not mean > 0:
        raise UsageError(
            Diagnostic("setpoints-period", f"{name}: time does not grow, its mean step is {mean:g} s")
        )
    usual = float(np.median(np.diff(block.time_s)))
    if abs(mean - usual) > _JITTER * usual:  # a gap, or a row twice: the period is that of the other rows
        return round(usual, 9)
    nanoseconds = round(mean, 9)
    return nanoseconds if abs(nanoseconds - mean) * steps <= 2e-9 else mean


def _chunks(first: FileBlock, blocks: Iterator[FileBlock], name: str, period: float) -> Iterator[Setpoints]:
    row, start, before = 0, None, None
    block: FileBlock | None = first
    while block is not None:
        if block.time_s is not None:
            start = float(block.time_s[0]) if start is None else start
            _check_times(block.time_s, before, row, start, name, period)
            before = float(block.time_s[-1])
        offset = round((start or 0.0) / period)
        yield Setpoints(block.axes, period, offset + row, inside_units(block.position, block.axes))
        row += len(block.position)
        block = next((b for b in blocks if len(b.position)), None)


def _check_times(
    time_s: Floats, before: float | None, row: int, start: float, name: str, period: float
) -> None:
    """Raise `UsageError` at the first row whose time is not one period after the row before it."""
    steps = np.diff(time_s, prepend=time_s[0] - period if before is None else before)
    wrong = np.abs(steps - period) > _JITTER * period + 2e-9
    drift = np.abs(time_s - (start + (row + np.arange(len(time_s))) * period)) > 0.5 * period
    if wrong.any() or drift.any():
        at = int(np.argmax(wrong if wrong.any() else drift))
        raise UsageError(
            Diagnostic(
                "setpoints-period",
                f"{name}: row {row + at + 1} (t = {time_s[at]:.9g} s) comes {steps[at]:.9g} s after the one before it; "
                f"the period is {period:.4g} s",
                values={"row": row + at + 1, "step_s": float(steps[at]), "period_s": period},
            )
        )
