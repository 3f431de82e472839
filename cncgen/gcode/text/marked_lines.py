"""The lines of a text that jumps may lead to: O-words by label, program numbers, loops of macros, N words.

There is no nesting: the target of a jump is the next or the last line with the same label and a fitting keyword, as in LinuxCNC ("O
Codes"). Labels are local to their subroutine.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from functools import cached_property

from cncgen.gcode.block import Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor, Label
from cncgen.gcode.text.macro_loops import Loops
from cncgen.records import dataclass

#: O-words that lead elsewhere and that nothing leads to.
_LEAVING = ("call", "return", "break", "continue")
#: Lines that a jump may lead to.
_LINE = (
    rb"(?:\A|\n)[ \t]*(?:/[1-9]?[ \t]*)?(?:[nN][ \t\d.]*)?"
    rb"((?:[oO:<](?![ \t]*(?:\d+|<[^>\n]*>)[ \t]*(?i:%s)\b)|(?i:wh|do[ \t]*\d|end?[ \t]*\d))[^\n]*)"
    % "|".join(_LEAVING).encode()
)
#: Lines with an N word.
_NUMBERED = rb"(?:\A|\n)[ \t]*(?:/[1-9]?[ \t]*)?[nN][ \t]*(\d{1,99})"
#: An O-word that a jump may lead to, its label and its keyword.
_OPENING = (
    rb"(?i)o[ \t]*(\d+|<[^>\n]*>)[ \t]*"
    rb"(endsub|sub|elseif|else|endif|if|endwhile|while|do|endrepeat|repeat)"
)
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
        self._source, self._index = source, index
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
        nearest = None
        for keyword in keywords:
            written = self._written.get((label, keyword), [])
            index = bisect_right(written, offset, key=_offset)
            if index < len(written) and written[index].cursor.offset <= last:
                nearest, last = written[index], written[index].cursor.offset
        for keyword in keywords:
            computed = self._computed.get(keyword, [])
            for index in range(bisect_right(computed, offset, key=_offset), len(computed)):
                mark = computed[index]
                if mark.cursor.offset > last:
                    break
                if resolve(mark.label) == label:
                    nearest, last = mark, mark.cursor.offset
                    break
        return nearest

    def previous(
        self, offset: int, label: Label, keywords: tuple[str, ...], resolve: Resolve
    ) -> Marked | None:
        """Return the last such line before an offset, within its subroutine."""
        border = bisect_left(self._borders, offset)
        first = self._borders[border - 1] if border else -1
        nearest = None
        for keyword in keywords:
            written = self._written.get((label, keyword), [])
            index = bisect_left(written, offset, key=_offset) - 1
            if index >= 0 and written[index].cursor.offset >= first:
                nearest, first = written[index], written[index].cursor.offset
        for keyword in keywords:
            computed = self._computed.get(keyword, [])
            for index in range(bisect_left(computed, offset, key=_offset) - 1, -1, -1):
                mark = computed[index]
                if mark.cursor.offset < first:
                    break
                if resolve(mark.label) == label:
                    nearest, first = mark, mark.cursor.offset
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
        lines: dict[int, list[Cursor]] = {}
        for begin, line, match in _line_matches(self._source, _NUMBERED):
            lines.setdefault(int(match.group(1)), []).append(Cursor(self._index, begin, line))
        return lines

    def has_sub_between(self, begin: int, end: int) -> bool:
        """Tell whether a subroutine begins between two offsets."""
        return bisect_right(self._subs, begin) < bisect_left(self._subs, end)


def _label(written: str) -> Label:
    """Return the label of an O-word; ``o<100>`` is ``o100``."""
    from cncgen.gcode.text.normal_text import normalise

    name = (normalise(written) if written[0] == "<" else written).strip("<>")
    return float(name) if name.isdecimal() else name


def _offset(mark: Marked) -> int:
    return mark.cursor.offset


def _line_matches(source: Source, pattern: bytes) -> Iterator[tuple[int, int, re.Match[bytes]]]:
    """Yield offset, number and match of the lines that a pattern (which may take the newline before) fits."""
    line, counted = 1, 0
    for match in re.finditer(pattern, source.data):
        begin = match.start() + (1 if source.data[match.start() : match.start() + 1] == b"\n" else 0)
        line += source.data[counted:begin].count(b"\n")
        counted = begin
        yield begin, line, match


def _find_marks(source: Source, index: int, dialect: str) -> Iterator[Marked]:
    from cncgen.gcode.text import grammar

    for begin, line, match in _line_matches(source, _LINE):
        opening = re.match(_OPENING, match[1]) if dialect == "linuxcnc" else None
        if opening:
            # A fault behind the keyword is reported where the line runs; jumps lead to the line in any case.
            written = opening[1].decode("utf-8", "replace")
            label: Value | str = _label(written)
            keyword = opening[2].decode("ascii").lower()
        else:
            try:
                flow = grammar.parse(source.text_at(begin), dialect).flow
            except BlockError:
                continue
            if flow is None or flow.label is None or flow.keyword in _LEAVING:
                continue
            label, keyword = flow.label, flow.keyword
        after = Cursor(index, source.line_end(begin) + 1, line + 1)
        yield Marked(label, keyword, Cursor(index, begin, line), after)
