"""A toolpath cut into blocks of a fixed number of rows: the plan then does not depend on how the input was cut into chunks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.toolpath.record import Toolpath
from cncgen.toolpath.slicing import between, join


def blocks(chunks: Iterable[Toolpath], rows: int) -> Iterator[Toolpath]:
    """Yield toolpaths of `rows` rows each, the last one shorter; chunks without rows vanish."""
    held: list[Toolpath] = []
    count = 0
    for chunk in chunks:
        first = 0
        while count + len(chunk) - first >= rows:
            last = first + rows - count
            yield join([*held, between(chunk, first, last)])
            held, count, first = [], 0, last
        if first < len(chunk):
            held.append(between(chunk, first, len(chunk)))
            count += len(chunk) - first
    if held:
        yield join(held)
