"""The lines of a text that jumps may lead to: O-words by label, program numbers, loops of macros, N words.

There is no nesting: the target of a jump is the next or the last line with the same label and a fitting keyword, as in LinuxCNC ("O
Codes"). Labels are local to their subroutine.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property

from cncgen.gcode.block import Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text import grammar
from cncgen.gcode.text.labels import Cursor, Label
from cncgen.gcode.text.macro_loops import Loops
from cncgen.gcode.text.normal_text import normalise
from cncgen.gcode.text.parsers import parser
from cncgen.grammars.terminals import LINUXCNC
from cncgen.kernels import gcode_codes
from cncgen.kernels.gcode_names import marked
from cncgen.records import dataclass

#: Kinds of marks that lead elsewhere and that nothing leads to.
_LEAVING = ("call", "return", "break", "continue", "goto", "then")
#: Digits of an N word beyond which nothing names it.
_MOST_DIGITS = 99
_KEYWORDS = {number: name for name, number in gcode_codes.LITERALS.items()}
#: Tells the number of a computed label now.
Resolve = Callable[[Value | str], Value | str]


@dataclass(frozen=True, slots=True)
class Marked:
    """A line with an O-word."""

    label: Value | str
    keyword: str
    cursor: Cursor
    after: Cursor


class Labels:
    """The marked lines of one source.

    Attributes:
        marks: All of them, in order.
        computes: Whether the label of one is computed, so that it changes as the program runs.
    """

    def __init__(self, source: Source, index: int, dialect: str) -> None:
        self._source, self._index, self._dialect = source, index, dialect
        self.marks = list(_find_marks(source, index, dialect))
        self._computed: dict[str, list[Marked]] = {}
        self._written: dict[tuple[Label, str], list[Marked]] = {}
        for mark in self.marks:
            if callable(mark.label):
                self._computed.setdefault(mark.keyword, []).append(mark)
            else:
                self._written.setdefault((mark.label, mark.keyword), []).append(mark)
        self.computes = bool(self._computed)
        self._programs = [mark.cursor.offset for mark in self.marks if mark.keyword == "program"]
        self._subs = [mark.cursor.offset for mark in self.marks if mark.keyword == "sub"]
        self._border_marks = [mark for mark in self.marks if mark.keyword in ("sub", "endsub")]
        self._borders = [mark.cursor.offset for mark in self._border_marks]

    def first(self, label: Label, keywords: tuple[str, ...], resolve: Resolve) -> Marked | None:
        """Return the first line with a label and one of the keywords."""
        return self.next(-1, label, keywords, resolve, over_borders=True)

    def next(
        self, offset: int, label: Label, keywords: tuple[str, ...], resolve: Resolve, *, over_borders: bool
    ) -> Marked | None:
        """Return the first such line behind an offset; within its subroutine, unless `over_borders`."""
        border = len(self._borders) if over_borders else bisect_right(self._borders, offset)
        last: float = self._borders[border] if border < len(self._borders) else math.inf
        behind = lambda row: range(bisect_right(row, offset, key=_offset), len(row))  # noqa: E731
        return self._nearest(label, keywords, resolve, behind, 1, last)

    def previous(
        self, offset: int, label: Label, keywords: tuple[str, ...], resolve: Resolve
    ) -> Marked | None:
        """Return the last such line before an offset, within its subroutine."""
        border = bisect_left(self._borders, offset)
        first = self._borders[border - 1] if border else -1
        before = lambda row: range(bisect_left(row, offset, key=_offset) - 1, -1, -1)  # noqa: E731
        return self._nearest(label, keywords, resolve, before, -1, -first)

    def _nearest(
        self,
        label: Label,
        keywords: tuple[str, ...],
        resolve: Resolve,
        among: Callable[[list[Marked]], Iterable[int]],
        way: int,
        most: float,
    ) -> Marked | None:
        """Return the first such line `among` those of a row, looked through one `way` (1 forward, -1 back) to the offset `most` times that."""
        written = [self._written.get((label, keyword), []) for keyword in keywords]
        nearest = None
        for row in (*written, *(self._computed.get(keyword, []) for keyword in keywords)):
            for index in among(row):
                mark = row[index]
                if way * mark.cursor.offset > most:
                    break
                if resolve(mark.label) == label:
                    nearest, most = mark, way * mark.cursor.offset
                    break
        return nearest

    def border(self, offset: int) -> Marked | None:
        """Return the first SUB or ENDSUB behind an offset."""
        index = bisect_right(self._borders, offset)
        return self._border_marks[index] if index < len(self._borders) else None

    def program_range(self, offset: int) -> tuple[int, int]:
        """Return the offsets between which the program of a line stands in its file."""
        index = bisect_right(self._programs, offset)
        begin = self._programs[index - 1] if index else 0
        return begin, self._programs[index] if index < len(self._programs) else len(self._source)

    @cached_property
    def loops(self) -> Loops:
        """The loops of FANUC's macros."""
        return Loops(self.marks)

    @cached_property
    def numbered(self) -> dict[int, list[Cursor]]:
        """Lines by their N word."""
        found: dict[int, list[Cursor]] = {}
        for offset, line, begin, end in marked(parser(self._dialect, False), self._source.bytes, True):
            number = normalise(self._source.data[begin:end].decode())[1:].partition(".")[0]
            if len(number) <= _MOST_DIGITS:
                found.setdefault(int(number), []).append(Cursor(self._index, offset, line))
        return found

    def has_sub_between(self, begin: int, end: int) -> bool:
        """Tell whether a subroutine begins between two offsets."""
        return bisect_right(self._subs, begin) < bisect_left(self._subs, end)


def _offset(mark: Marked) -> int:
    return mark.cursor.offset


def _find_marks(source: Source, index: int, dialect: str) -> Iterator[Marked]:
    """Yield the lines that something may lead to, as far as the grammar reads them."""
    for begin, line, number, label in marked(parser(dialect, False), source.bytes):
        keyword = _KEYWORDS.get(number, "")
        if keyword not in _LEAVING and label is None:
            text = source.text_at(begin)
            label, keyword = _opening(text) if not number and dialect == "linuxcnc" else _flow(text, dialect)
        if label is not None and keyword not in _LEAVING:
            after = Cursor(index, source.line_end(begin) + 1, line + 1)
            yield Marked(label, keyword, Cursor(index, begin, line), after)


def _flow(text: str, dialect: str) -> tuple[Value | str | None, str]:
    """Return label and keyword of a line; without a label where it is no block."""
    try:
        flow = grammar.parse(text, dialect).flow
    except BlockError:
        return None, ""
    return (None, "") if flow is None else (flow.label, flow.keyword)


def _opening(text: str) -> tuple[Value | str | None, str]:
    """Return label and keyword of an O-word with a fault behind them: it is reported where the line runs, and jumps lead to it all the same."""
    import re

    number, label, keyword = (
        LINUXCNC["LINE_NUMBER"],
        f"{LINUXCNC['O_NUMBER']}|{LINUXCNC['O_NAME']}",
        LINUXCNC["KEYWORD"],
    )
    form = rf"{LINUXCNC['DELETE']}?(?:{number})?(?P<label>{label})(?P<keyword>{keyword})"
    opening = re.match(form, normalise(text))
    if opening is None:
        return None, ""
    name = opening["label"][1:].strip("<>")
    return (float(name) if name.isdecimal() else name), opening["keyword"]
