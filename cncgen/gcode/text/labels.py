"""Places in the texts of a run, and labels."""

from __future__ import annotations

from operator import itemgetter

Label = float | str


class Cursor(tuple[int, int, int]):
    """A line: source, byte offset, line number."""

    __slots__ = ()
    source = property(itemgetter(0))
    offset = property(itemgetter(1))
    line = property(itemgetter(2))

    def __new__(cls, source: int, offset: int, line: int) -> Cursor:
        return tuple.__new__(cls, (source, offset, line))

    def __getnewargs__(self) -> tuple[int, int, int]:
        return self.source, self.offset, self.line


def shown(label: Label) -> str:
    """Return how a label is written."""
    return f"<{label}>" if isinstance(label, str) else f"{label:g}"
