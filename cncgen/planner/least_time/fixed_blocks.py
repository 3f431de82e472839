"""A toolpath cut into blocks of about the same work: the plan then does not depend on how the input was cut into chunks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.toolpath.record import Kind, Toolpath
from cncgen.toolpath.slicing import between, join

#: A row counts as much as this many control points of a NURBS: nodes stand about its ends, and about the knots of a curve.
_ROW = 4


def blocks(chunks: Iterable[Toolpath], size: int, most: int) -> Iterator[Toolpath]:
    """Yield toolpaths of `size` control points, then half as many again each time up to `most`, the last one smaller.

    A row between short ones has up to `_ROW` control points and counts as these, a rounded corner some twenty, a curve of a thousand as a
    thousand. So memory, and the time until the first block is there, depend on the work that rows make, not on their number.
    """
    held: list[Toolpath] = []
    done = 0
    for chunk in chunks:
        upto = done + np.cumsum(_sizes(chunk))
        first = 0
        while first < len(chunk) and upto[-1] >= size:
            last = int(np.searchsorted(upto, size)) + 1
            yield join([*held, between(chunk, first, last)])
            upto -= upto[last - 1]
            held, first, size = [], last, min(3 * size // 2, most)
        if first < len(chunk):
            held.append(between(chunk, first, len(chunk)))
        done = int(upto[-1]) if len(chunk) else done
    if held:
        yield join(held)


def _sizes(toolpath: Toolpath) -> NDArray[np.int64]:
    """Return the work of rows, shape (n,)."""
    out = np.full(len(toolpath), _ROW, np.int64)
    curves = np.flatnonzero(toolpath.kind == Kind.NURBS)
    points = np.diff(toolpath.nurbs.point_offset)
    out[curves] = np.maximum(points[toolpath.curve[curves]], _ROW)
    return out
