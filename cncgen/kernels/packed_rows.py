# cython: infer_types=True
"""Rows of the page: the predictor of each block of rows, and the range code of the residuals.

The code is the one of J. Duda, "Asymmetric numeral systems" (2013), with a state of 31 bits that gives and takes bytes, and
frequencies that add up to 4096.
"""

import cython
from cython.cimports.libc.math import fabs, floor

#: Rows that share a predictor and a table.
BLOCK = 64
_BLOCK = cython.declare(cython.Py_ssize_t, BLOCK)
#: Differences at and beyond this are left to the first predictor, so that all sums are exact in doubles.
_LARGEST = cython.declare(cython.double, 67108864.0)
#: Parts of which the weights of predictors are whole numbers.
PARTS = 1 << 20
_PARTS = cython.declare(cython.double, float(PARTS))
#: The lowest state between two symbols.
_LOWEST = cython.declare(cython.longlong, 8388608)


def predicted(
    differences: cython.double[::1],
    count: cython.Py_ssize_t,
    weights: cython.double[:, ::1],
    lengths: cython.int[::1],
    choice: cython.uchar[::1],
    rest: cython.double[::1],
    cost: cython.double[::1],
) -> cython.void:
    """Choose the predictor of each block whose rests are smallest in sum.

    A predictor takes the difference of two rows to be ⌊(Σ w_j d_j + P/2) / P⌋ of the differences d_j before it, the last one
    first, with P = `PARTS`; the one without weights takes it to be 0.

    Args:
        differences: Whole numbers: as many from before the rows as the longest predictor has weights, those of the rows, and
            `BLOCK` more of any value.
        count: Rows.
        weights: Whole numbers, shape (predictors, most weights); the first row counts for nothing.
        lengths: Weights of each predictor; the first has none.
        choice: Out: predictor of each block.
        rest: Out, shape (blocks × BLOCK,): differences less what was predicted.
        cost: Out: sum of the absolute rests of each block.
    """
    lead: cython.Py_ssize_t = weights.shape[1]
    predictors: cython.Py_ssize_t = weights.shape[0]
    j: cython.Py_ssize_t
    sums = cython.declare(cython.double[64])
    with cython.nogil:
        for b in range((count + _BLOCK - 1) // _BLOCK):
            at = lead + b * _BLOCK
            size = min(_BLOCK, count - b * _BLOCK)
            most = 0.0
            for i in range(at - lead, at + size):
                most = max(most, fabs(differences[i]))
            total = 0.0
            for i in range(size):
                rest[b * _BLOCK + i] = differences[at + i]
                total += fabs(differences[at + i])
            choice[b] = 0
            cost[b] = total
            if most >= _LARGEST:
                continue
            for p in range(1, predictors):
                if cost[b] == 0.0:
                    break
                for i in range(64):
                    sums[i] = 0.0
                for j in range(lengths[p]):
                    w = weights[p, j]
                    for i in range(64):
                        sums[i] += w * differences[at + i - 1 - j]
                total = 0.0
                for i in range(64):
                    sums[i] = differences[at + i] - floor((sums[i] + 0.5 * _PARTS) / _PARTS)
                for i in range(size):
                    total += fabs(sums[i])
                if total < cost[b]:
                    cost[b] = total
                    choice[b] = p
                    for i in range(size):
                        rest[b * _BLOCK + i] = sums[i]


def coded(
    symbols: cython.uchar[::1],
    tables: cython.uchar[::1],
    frequencies: cython.int[:, ::1],
    out: cython.uchar[::1],
) -> cython.Py_ssize_t:
    """Code symbols, the last one first, so that a reader has them from the first on.

    Args:
        symbols: Shape (n,).
        tables: The table of each block of symbols.
        frequencies: Shape (tables, 256), whole numbers that add up to 4096 in each table; of each symbol that comes at least 1.
        out: Out: the code, to be read from its last byte back; 2 n + 4 bytes of room.

    Returns:
        The bytes of the code.
    """
    n: cython.Py_ssize_t = symbols.shape[0]
    at: cython.Py_ssize_t = 0
    state: cython.longlong = _LOWEST
    below = cython.declare(cython.int[4096])
    with cython.nogil:
        for t in range(frequencies.shape[0]):
            below[t * 256] = 0
            for s in range(1, 256):
                below[t * 256 + s] = below[t * 256 + s - 1] + cython.cast(cython.int, frequencies[t, s - 1])
        for k in range(n - 1, -1, -1):
            s = cython.cast(cython.Py_ssize_t, symbols[k])
            t = cython.cast(cython.Py_ssize_t, tables[k // _BLOCK])
            f = cython.cast(cython.longlong, frequencies[t, s])
            while state >= 524288 * f:
                out[at] = state & 255
                at += 1
                state >>= 8
            state = (state // f) * 4096 + state % f + below[t * 256 + s]
        for k in range(4):
            out[at] = state & 255
            at += 1
            state >>= 8
    return at
