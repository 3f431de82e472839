"""A signal with a value for each row, packed: predicted from earlier rows, with the residuals coded by their frequency.

Positions of a smooth motion are rounded to their step, so third differences are mostly rounding errors. A least-squares polynomial
through several rows smooths them. docs/page.md describes the format.
"""

from __future__ import annotations

import zlib
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import packed_rows
from cncgen.kernels.packed_rows import BLOCK, PARTS
from cncgen.report.page.streams import ESCAPE, LARGEST, Blob, Integers

#: Degree of each predictor's polynomial, and the rows that it is fitted to; the first holds the last row's value.
_PREDICTORS = ((0, 1), (2, 6), (2, 14), (3, 10), (3, 24), (4, 16))
#: Rows of a segment, which has frequencies of its own.
SEGMENT = 1 << 16
#: Mean of the residuals in a block, in steps, from which on the next table holds.
_BOUNDS = (0.005, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1, 1.5, 2.5, 5, 10, 20, 40)
_TABLES, _WHOLE = len(_BOUNDS) + 1, 4096


@cache
def predictors() -> tuple[tuple[int, ...], ...]:
    """Return the weights of each predictor, those of the last difference first, in `PARTS`.

    The polynomial of least squares through n values has at the next row the value Σ w_i v_i. In differences of neighbours that is
    the last value and Σ c_j d_j, with c_j the negative sum of the weights of values before the difference j.
    """
    found = []
    for degree, rows in _PREDICTORS:
        powers = np.vander(np.arange(-rows, 0) / rows, degree + 1)
        weights = np.linalg.pinv(powers)[-1]
        parts = np.rint(-PARTS * np.cumsum(weights)[:-1][::-1]).astype(np.int64)
        if len(parts):
            # A motion at a constant speed is predicted exactly.
            parts[0] += PARTS - parts.sum()
        found.append(tuple(parts.tolist()))
    return tuple(found)


@cache
def _weights() -> tuple[NDArray[np.float64], NDArray[np.intc]]:
    lengths = np.array([len(parts) for parts in predictors()], np.intc)
    weights = np.zeros((len(lengths), int(lengths.max())))
    for row, parts in zip(weights, predictors(), strict=True):
        row[: len(parts)] = parts
    return weights, lengths


class PackedStream:
    """One signal as integers, in segments of `SEGMENT` rows."""

    def __init__(self) -> None:
        weights, _ = _weights()
        self._lead = weights.shape[1]
        #: Differences before the rows that wait, and of those.
        self._differences = np.zeros(self._lead + SEGMENT + BLOCK)
        self._waiting = 0
        self._last = 0
        self._blocks, self._tables, self._escapes = (
            zlib.compressobj(9),
            zlib.compressobj(9),
            zlib.compressobj(6),
        )
        self._out: dict[str, list[bytes]] = {"blocks": [], "tables": [], "escapes": [], "code": []}
        self.size = self.count = 0
        self._wide = False

    def add(self, values: Integers) -> None:
        """Take the next values, shape (n,)."""
        if not len(values):
            return
        self._wide |= bool(np.abs(values).max() > LARGEST)
        differences = np.diff(values, prepend=self._last)
        self._last = int(values[-1])
        self.count += len(values)
        while len(differences):
            room = differences[: SEGMENT - self._waiting]
            start = self._lead + self._waiting
            self._differences[start : start + len(room)] = room
            self._waiting += len(room)
            differences = differences[len(room) :]
            if self._waiting == SEGMENT:
                self._pack()

    def _pack(self) -> None:
        """Code the rows that wait."""
        count, blocks = self._waiting, -(-self._waiting // BLOCK)
        weights, lengths = _weights()
        choice, cost, rest = np.zeros(blocks, np.uint8), np.zeros(blocks), np.zeros(blocks * BLOCK)
        packed_rows.predicted(self._differences, count, weights, lengths, choice, rest, cost)
        rest = rest[:count]
        folded = np.where(rest < 0, -2 * rest - 1, 2 * rest)
        symbols = np.minimum(folded, ESCAPE).astype(np.uint8)
        sizes = np.minimum(BLOCK, count - BLOCK * np.arange(blocks))
        tables = np.searchsorted(_BOUNDS, cost / sizes, side="right").astype(np.uint8)
        pairs = np.repeat(tables.astype(np.int64) * 256, sizes) + symbols
        frequencies = _frequencies(np.bincount(pairs, minlength=_TABLES * 256).reshape(_TABLES, 256))
        code = np.empty(2 * count + 4, np.uint8)
        length = packed_rows.coded(symbols, tables, frequencies, code)

        self._keep("code", code[:length][::-1].tobytes())
        self._keep("blocks", self._blocks.compress((choice * _TABLES + tables).tobytes()))
        self._keep("tables", self._tables.compress(_listed(frequencies)))
        self._keep("escapes", self._escapes.compress(folded[folded >= ESCAPE].astype("<f8").tobytes()))
        self._differences[: self._lead] = self._differences[count : count + self._lead].copy()
        self._waiting = 0

    def _keep(self, name: str, data: bytes) -> None:
        self._out[name].append(data)
        self.size += len(data)

    def finish(self, blob: Blob) -> dict[str, Any]:
        """Put the bytes into a blob; return the data for a reader."""
        if self._waiting:
            self._pack()
        for name, squeezed in {
            "blocks": self._blocks,
            "tables": self._tables,
            "escapes": self._escapes,
        }.items():
            self._keep(name, squeezed.flush())
        found: dict[str, Any] = {name: blob.put(b"".join(parts)) for name, parts in self._out.items()}
        return found | {"count": self.count} | ({"wide": True} if self._wide else {})


def _frequencies(counts: NDArray[np.int64]) -> NDArray[np.intc]:
    """Return how often symbols come, shape (tables, 256), in 4096ths; none that comes has 0."""
    found = np.zeros(counts.shape, np.int64)
    for row, table in zip(found, counts, strict=True):
        if not table.any():
            continue
        row[:] = np.maximum(table * _WHOLE // table.sum(), table > 0)
        while row.sum() != _WHOLE:
            most = int(row.argmax())
            row[most] += max(_WHOLE - row.sum(), -(row[most] // 2))
    return found.astype(np.intc)


def _listed(frequencies: NDArray[np.intc]) -> bytes:
    """Return tables as numbers of two bytes: of each its length, and frequencies up to the last symbol that comes."""
    parts = []
    for row in frequencies:
        length = int(np.flatnonzero(row)[-1]) + 1 if row.any() else 0
        parts.append(np.concatenate([[length], row[:length]]))
    return np.concatenate(parts).astype("<u2").tobytes()
