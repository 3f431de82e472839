"""Rows of decimal text by the kernel, for all text formats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.kernels import decimal_rows as kernel


class RowText:
    """Formats matrices as text: number `k` of a row stands after ``literals[k]``, the last literal ends the row."""

    def __init__(self, literals: Sequence[str], decimals: Sequence[int]) -> None:
        encoded = [literal.encode() for literal in literals]
        self._literals = np.frombuffer(b"".join(encoded), np.uint8).copy()
        self._ends = np.cumsum([len(literal) for literal in encoded]).astype(np.int64)
        self._decimals = np.array(decimals, np.int32)

    def format(self, matrix: NDArray[np.float64]) -> memoryview:
        """Return the text of a matrix, shape (n, columns), as bytes.

        Raises:
            UsageError: A number is 2⁵³ or more (the jerk signal near a cusp can be).
        """
        largest = float(np.abs(matrix).max(initial=0.0))
        if largest >= kernel.MAX_VALUE:
            message = f"a number of {largest:g} cannot be written with decimals"
            raise UsageError(
                Diagnostic("setpoint-range", message, hint="--format npy, npz or f64 can hold it")
            )
        n, columns = matrix.shape
        out = np.empty(n * (columns * kernel.MAX_WIDTH + len(self._literals)), np.uint8)
        size = kernel.write_rows(matrix, self._decimals, self._literals, self._ends, out)
        return out[:size].data
