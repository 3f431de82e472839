"""Blocks of a setpoint stream with what stands before and after them, so that stages can look both ways."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.setpoints.checking import check_range, checked_setpoints
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

#: Rows of a block, where the stream is long enough.
BLOCK = 8192


@dataclass(frozen=True, slots=True)
class SampleBlock:
    """Rows `first` … of a stream.

    Attributes:
        axes: Letters of the columns.
        period_s: Time between rows.
        first: Index of the block's first row.
        values: Shape (before + n + after, axes). Beyond either end of the stream its first or last row repeats.
        before, after: Rows of margin.
        last: True for the stream's last block.
    """

    axes: str
    period_s: float
    first: int
    values: Floats
    before: int
    after: int
    last: bool

    def __len__(self) -> int:
        return len(self.values) - self.before - self.after

    @property
    def rows(self) -> Floats:
        """Shape (n, axes): the block without its margins."""
        return self.values[self.before : self.before + len(self)]

    def shifted(self, by: int) -> Floats:
        """Shape (n, axes): row k + `by` in the place of row k."""
        return self.values[self.before + by : self.before + by + len(self)]


def blocks(
    chunks: Iterable[Setpoints], before: int, after: int, settle_s: float = 0.0
) -> Iterator[SampleBlock]:
    """Yield blocks of up to `BLOCK` rows (more where chunks are larger) with margins.

    Args:
        chunks: The stream; all chunks have the same axes and period.
        before, after: Rows of margin.
        settle_s: The last row is held so long after the end.

    Raises:
        UsageError: A chunk does not go on where the one before it ends (`checked_setpoints`), or a position is where no
            machine is (``setpoints-range``).
    """
    head: Setpoints | None = None
    waiting: list[Floats] = []
    margin: Floats | None = None
    count, first = 0, 0
    # Loops follow positions alone: a stretch of rest at the end may come without the signals of the plan.
    for chunk in checked_setpoints(replace(chunk, signals={}) for chunk in chunks):
        if not len(chunk):
            continue
        head = head or chunk
        check_range(chunk)
        if margin is None:
            margin, first = np.repeat(chunk.position[:1], before, axis=0), chunk.first
        waiting.append(np.asarray(chunk.position, float))
        count += len(chunk)
        if count < BLOCK + after:
            continue
        values = np.concatenate([margin, *waiting])
        yield SampleBlock(head.axes, head.period_s, first, values, before, after, False)
        first += count - after
        margin, waiting, count = (
            values[len(values) - after - before : len(values) - after],
            [values[len(values) - after :]],
            after,
        )
    if head is None or margin is None:
        return
    end = waiting[-1][-1:] if len(waiting[-1]) else margin[-1:]
    held = round(settle_s / head.period_s)
    values = np.concatenate([margin, *waiting, np.repeat(end, after + held, axis=0)])
    if len(values) > before + after:
        yield SampleBlock(head.axes, head.period_s, first, values, before, after, True)


def driven(setpoints: Iterable[Setpoints], known: Collection[str]) -> Iterator[Setpoints]:
    """Yield setpoints without the axes that a machine does not have, which have to stand.

    Raises:
        UsageError: One of them moves, or no axis has servo data (``servo-missing``).
    """
    stand: dict[str, float] = {}
    for chunk in setpoints:
        kept = [k for k, letter in enumerate(chunk.axes) if letter in known]
        others = [k for k in range(len(chunk.axes)) if k not in kept]
        for k in others if len(chunk) else ():
            column = chunk.position[:, k]
            if not kept or (column != stand.setdefault(chunk.axes[k], float(column[0]))).any():
                raise missing_data([chunk.axes[k]], known)
        if not others:
            yield chunk
            continue
        signals = {name: v[:, kept] if v.ndim == 2 else v for name, v in chunk.signals.items()}
        axes = "".join(chunk.axes[k] for k in kept)
        yield replace(chunk, axes=axes, position=chunk.position[:, kept], signals=signals)


def missing_data(missing: Iterable[str], known: Collection[str]) -> UsageError:
    """Return the error of axes that move without servo data (``servo-missing``)."""
    letters = list(missing)
    which = f"{'axes' if len(letters) > 1 else 'axis'} {', '.join(letters)}"
    others = f"; {', '.join(known) or 'no axis'} {'have' if len(known) > 1 else 'has'} servo data"
    tables = ", ".join(f"[axes.{letter.lower()}.servo]" for letter in letters)
    hint = f"add {tables} to the machine file or to the file of --axis-params, or leave the axis out of the setpoints"
    return UsageError(Diagnostic("servo-missing", f"no servo data for {which}{others}", hint=hint))
