"""Signals as small streams of bytes: integers, differenced, deflated; docs/page.md describes the format.

A stream of integers is differenced some times (positions three times, as third differences of a motion with a bounded jerk
are small), folded to non-negative numbers (zigzag), and deflated: one byte a number, 255 standing for a number that follows in
a second stream of doubles. Everything is computed chunk by chunk.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

#: Numbers of bands beyond this (in steps) are held there: they are those of strategies without a bound on the jerk.
LARGEST = 2**30
#: A byte that stands for a number of its own.
ESCAPE = 255
#: Rows of a long plan.
LONG = 500_000

#: Digits of base 85: printable ASCII without what ends or escapes a text in HTML, JSON or JavaScript.
DIGITS = "!#%()*+,./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[]^_abcdefghijklmnopqrstuvwxyz{|}~"


class Blob:
    """Bytes of many streams, one after the other."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self.size = 0

    def put(self, data: bytes) -> list[int]:
        """Append bytes; return where they are: offset and length."""
        place = [self.size, len(data)]
        self._parts.append(data)
        self.size += len(data)
        return place

    def text(self) -> str:
        """Return all bytes in base 85."""
        return base85(b"".join(self._parts))


def base85(data: bytes) -> str:
    """Return bytes as text, five digits of `DIGITS` for four bytes, the first the largest; the end is filled with zeros."""
    words = np.frombuffer(data + bytes(-len(data) % 4), ">u4").astype(np.uint32)
    digits = np.empty((len(words), 5), np.uint8)
    for place in range(4, -1, -1):
        words, digits[:, place] = np.divmod(words, np.uint32(85))
    return np.frombuffer(DIGITS.encode(), np.uint8)[digits].tobytes().decode("ascii")


class IntegerStream:
    """One signal as integers, `order` times differenced."""

    def __init__(self, order: int) -> None:
        self._order = order
        self._tail = np.zeros(order, np.int64)
        # Small numbers that seldom repeat: the slowest search for repetitions saves 7 % of level 6.
        self._bytes = zlib.compressobj(9, zlib.DEFLATED, 15, 9, zlib.Z_FILTERED)
        self._escapes = zlib.compressobj(6)
        self._out: list[bytes] = []
        self._more: list[bytes] = []
        self.count = 0
        self._wide = False

    @property
    def size(self) -> int:
        """Return the bytes that have come out so far."""
        return sum(map(len, self._out)) + sum(map(len, self._more))

    def add(self, values: Integers) -> None:
        """Take the next values, shape (n,)."""
        self._wide |= bool(len(values)) and bool(np.abs(values).max() > LARGEST)
        joined = np.concatenate([self._tail, values])
        if self._order:
            self._tail = joined[-self._order :].copy()
        rest = np.diff(joined, n=self._order)
        folded = np.where(rest < 0, -2 * rest - 1, 2 * rest)
        self._out.append(self._bytes.compress(np.minimum(folded, ESCAPE).astype(np.uint8).tobytes()))
        large = folded[folded >= ESCAPE]
        if len(large):
            self._more.append(self._escapes.compress(large.astype("<f8").tobytes()))
        self.count += len(values)

    def finish(self, blob: Blob) -> dict[str, Any]:
        """Put the bytes into a blob; return the data for a reader."""
        out = b"".join(self._out) + self._bytes.flush()
        more = b"".join(self._more) + self._escapes.flush()
        place = {"order": self._order, "count": self.count, "at": blob.put(out), "escapes": blob.put(more)}
        return place | {"wide": True} if self._wide else place


def integers(values: Sequence[int] | NDArray[np.integer], order: int, blob: Blob) -> dict[str, Any]:
    """Put integers, shape (n,), into a blob at once."""
    stream = IntegerStream(order)
    stream.add(np.asarray(values, np.int64))
    return stream.finish(blob)


class RunStream:
    """A signal that stays the same for many rows: its values, and how long each of them lasts."""

    def __init__(self) -> None:
        self._values, self._lengths = IntegerStream(1), IntegerStream(0)
        self._open: tuple[int, int] | None = None

    def add(self, values: NDArray[np.integer]) -> None:
        """Take the next values, shape (n,)."""
        if not len(values):
            return
        starts = np.flatnonzero(values[1:] != values[:-1]) + 1
        edges = np.concatenate([[0], starts, [len(values)]])
        heads, lengths = values[edges[:-1]].astype(np.int64), np.diff(edges)
        if self._open is not None:
            if self._open[0] == heads[0]:
                lengths[0] += self._open[1]
            else:
                heads, lengths = np.append(self._open[0], heads), np.append(self._open[1], lengths)
        self._open = (int(heads[-1]), int(lengths[-1]))
        self._values.add(heads[:-1])
        self._lengths.add(lengths[:-1].astype(np.int64))

    def finish(self, blob: Blob) -> dict[str, Any]:
        """Put the runs into a blob."""
        if self._open is not None:
            self._values.add(np.array(self._open[:1], np.int64))
            self._lengths.add(np.array(self._open[1:], np.int64))
            self._open = None
        return {"values": self._values.finish(blob), "lengths": self._lengths.finish(blob)}


class Bands:
    """Signals whose lowest and highest value in each block of rows are kept; the blocks grow with the number of rows.

    Up to `most` values together each row keeps its own (blocks of one row). Beyond that blocks are joined two by two to
    `most_joined` values, of a long plan to a quarter of them, so that memory and the size of the page stay bounded.
    """

    def __init__(self, steps: dict[str, float], most: int, most_joined: int) -> None:
        self._names = list(steps)
        self._steps = np.array(list(steps.values()))[:, None]
        self._most, self._most_joined = most, most_joined
        self.block = 1
        self._low: list[NDArray[np.int32]] = []
        self._high: list[NDArray[np.int32]] = []
        self._rest = np.zeros((len(steps), 0))
        self._held = self._rows = 0

    @property
    def _bound(self) -> int:
        """Return how many values may be held now."""
        if self.block == 1:
            return self._most
        return self._most_joined // (4 if self._rows > LONG else 1)

    def add(self, values: Floats) -> None:
        """Take rows of all signals, shape (n, signals)."""
        self._rows += len(values)
        joined = np.concatenate([self._rest, values.T], axis=1)
        whole = joined.shape[1] // self.block * self.block
        self._rest = joined[:, whole:].copy()
        self._keep(joined[:, :whole])
        if self._held * len(self._names) > self._bound:
            self._join()

    def _keep(self, rows: Floats) -> None:
        parts = rows.reshape(len(self._names), -1, self.block)
        self._low.append(self._stepped(parts.min(axis=2)))
        if self.block > 1:
            self._high.append(self._stepped(parts.max(axis=2)))
        self._held += parts.shape[1] * (1 if self.block == 1 else 2)

    def _stepped(self, values: Floats) -> NDArray[np.int32]:
        """Return values in whole steps; the lowest value has the lowest number."""
        return np.clip(np.rint(values / self._steps), -LARGEST, LARGEST).astype(np.int32)

    def _join(self) -> None:
        """Join blocks two by two until they are few enough; a block without a partner goes back to the rest."""
        low = np.concatenate(self._low, axis=1)
        high = np.concatenate(self._high, axis=1) if self._high else low
        while self.block == 1 or self._held * len(self._names) > self._bound:
            if low.shape[1] % 2:
                # Lowest and highest value of the last block stand in its place among the rows that wait.
                last = [low[:, -1:], *[high[:, -1:]] * (self.block - 1)]
                self._rest = np.concatenate([np.concatenate(last, axis=1) * self._steps, self._rest], axis=1)
                low, high = low[:, :-1], high[:, :-1]
            low = np.minimum(low[:, 0::2], low[:, 1::2])
            high = np.maximum(high[:, 0::2], high[:, 1::2])
            self.block *= 2
            self._held = 2 * low.shape[1]
        self._low, self._high = [low], [high]
        whole = self._rest.shape[1] // self.block * self.block
        if whole:
            waiting, self._rest = self._rest[:, :whole], self._rest[:, whole:]
            self._keep(waiting)

    def finish(self, blob: Blob, leave_out: Sequence[str] = ()) -> dict[str, dict[str, Any]]:
        """Put the bands into a blob; return their descriptions by name."""
        if self._rest.shape[1]:
            rest, self._rest = self._rest, self._rest[:, :0]
            self._low.append(self._stepped(rest.min(axis=1, keepdims=True)))
            self._high.append(self._stepped(rest.max(axis=1, keepdims=True)))
        found: dict[str, dict[str, Any]] = {}
        if not self._low:
            return found
        low = np.concatenate(self._low, axis=1)
        high = np.concatenate(self._high, axis=1) if self.block > 1 else low
        for row, (name, step) in enumerate(zip(self._names, self._steps[:, 0].tolist(), strict=True)):
            if name in leave_out:
                continue
            order = 2 if self.block == 1 and "jerk" not in name else 1
            found[name] = {"step": step, "block": self.block, "low": integers(low[row], order, blob)}
            if self.block > 1:
                spread = high[row].astype(np.int64) - low[row]
                found[name]["spread"] = integers(spread, 1, blob)
        return found
