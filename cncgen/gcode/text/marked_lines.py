"""The lines of a text that jumps may lead to: O-words by label, program numbers, loops of macros, N words.

There is no nesting: the target of a jump is the next or the last line with the same label and a fitting keyword, as in LinuxCNC ("O
Codes"). Labels are local to their subroutine.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from functools import cached_property

from cncgen.gcode.block import Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor, Label
from cncgen.gcode.text.macro_loops import Loops
from cncgen.gcode.text.parsers import parser
from cncgen.grammars.terminals import FANUC, LINUXCNC
from cncgen.kernels import gcode_codes
from cncgen.kernels.gcode_lines import Lines
from cncgen.kernels.gcode_marks import Marks, bits_of
from cncgen.kernels.gcode_names import numbered
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
        lines: All of them, in order.
        computes: Whether the label of one is computed, so that it changes as the program runs.
    """

    def __init__(self, source: Source, index: int, dialect: str) -> None:
        self._source, self._index, self._dialect = source, index, dialect
        self.lines = Marks(_find_marks(source, dialect))
        self.computes: bool = self.lines.computes

    @cached_property
    def marks(self) -> list[Marked]:
        """All of them as records."""
        return [self._mark(m) for m in range(self.lines.count)]

    def _mark(self, m: int) -> Marked:
        label, keyword, offset, line, after = self.lines.mark(m)
        return Marked(
            label, _KEYWORDS[keyword], Cursor(self._index, offset, line), Cursor(self._index, after, line + 1)
        )

    @cached_property
    def by_offset(self) -> dict[int, Marked]:
        """The marked lines by their offsets."""
        return {mark.cursor.offset: mark for mark in self.marks}

    def first(self, label: Label, keywords: tuple[str, ...], resolve: Resolve) -> Marked | None:
        """Return the first line with a label and one of the keywords."""
        return self.next(-1, label, keywords, resolve, over_borders=True)

    def next(
        self, offset: int, label: Label, keywords: tuple[str, ...], resolve: Resolve, *, over_borders: bool
    ) -> Marked | None:
        """Return the first such line behind an offset; within its subroutine, unless `over_borders`."""
        m = self.lines.nearest(offset, 1, label, bits_of(keywords), over_borders, resolve)
        return None if m < 0 else self._mark(m)

    def previous(
        self, offset: int, label: Label, keywords: tuple[str, ...], resolve: Resolve
    ) -> Marked | None:
        """Return the last such line before an offset, within its subroutine."""
        m = self.lines.nearest(offset, -1, label, bits_of(keywords), False, resolve)
        return None if m < 0 else self._mark(m)

    def border(self, offset: int) -> Marked | None:
        """Return the first SUB or ENDSUB behind an offset."""
        m = self.lines.border(self.lines.behind(offset + 1), 1)
        return None if m < 0 else self._mark(m)

    def program_range(self, offset: int) -> tuple[int, int]:
        """Return the offsets between which the program of a line stands in its file."""
        index = bisect_right(self._programs, offset)
        begin = self._programs[index - 1] if index else 0
        return begin, self._programs[index] if index < len(self._programs) else len(self._source)

    @cached_property
    def _programs(self) -> list[int]:
        return [mark.cursor.offset for mark in self.marks if mark.keyword == "program"]

    @cached_property
    def _subs(self) -> list[int]:
        return [mark.cursor.offset for mark in self.marks if mark.keyword == "sub"]

    @cached_property
    def loops(self) -> Loops:
        """The loops of FANUC's macros."""
        return Loops(self.marks)

    @cached_property
    def numbered(self) -> dict[int, list[Cursor]]:
        """Lines by their N word."""
        from cncgen.gcode.text.normal_text import normalise

        found: dict[int, list[Cursor]] = {}
        for offset, line, begin, end in numbered(parser(self._dialect, False), self._source.bytes):
            number = normalise(self._source.data[begin:end].decode())[1:].partition(".")[0]
            if len(number) <= _MOST_DIGITS:
                found.setdefault(int(number), []).append(Cursor(self._index, offset, line))
        return found

    def has_sub_between(self, begin: int, end: int) -> bool:
        """Tell whether a subroutine begins between two offsets."""
        return bisect_right(self._subs, begin) < bisect_left(self._subs, end)


def _find_marks(source: Source, dialect: str) -> list[tuple[int, int, int, Value | str, int]]:
    """Return the lines that something may lead to, as far as the grammar reads them, as `Marks` takes them."""
    found = Lines(parser(dialect, False), source.bytes).marked(dialect == "linuxcnc")
    for k, (begin, line, number, label, after) in enumerate(found):
        if label is None:
            label, keyword = _read(source.text_at(begin), dialect, refused=not number)
            found[k] = begin, line, gcode_codes.LITERALS[keyword] if keyword else 0, label, after
    return [mark for mark in found if mark[2]]


def _read(text: str, dialect: str, *, refused: bool) -> tuple[Value | str | None, str]:
    """Return label and keyword of a line by the parser or its opening; no keyword where nothing leads to it."""
    opening = {"linuxcnc": _opening, "fanuc": _loop_opening}.get(dialect) if refused else None
    label, keyword = opening(text) if opening else _flow(text, dialect)
    return (None, "") if label is None or keyword in _LEAVING else (label, keyword)


def _flow(text: str, dialect: str) -> tuple[Value | str | None, str]:
    """Return label and keyword of a line; without a label where it is no block."""
    from cncgen.gcode.text import grammar

    try:
        flow = grammar.parse(text, dialect).flow
    except BlockError:
        return None, ""
    return (None, "") if flow is None else (flow.label, flow.keyword)


def _loop_opening(text: str) -> tuple[Value | str | None, str]:
    """Return number and keyword of a loop of a macro whose condition has a fault: its END belongs to it all the same."""
    import re

    from cncgen.gcode.text.normal_text import normalise

    head = rf"(?:{FANUC['DELETE']})?(?:{FANUC['LINE_NUMBER']})?(?:{FANUC['WHILE']}|{FANUC['WH']})"
    loop = re.match(rf"{head}.*{FANUC['DO']}(?P<number>{FANUC['NUMBER']})", normalise(text))
    return (float(loop["number"]), "while-do") if loop else (None, "")


def _opening(text: str) -> tuple[Value | str | None, str]:
    """Return label and keyword of an O-word with a fault behind them: it is reported where the line runs, and jumps lead to it all the same."""
    import re

    from cncgen.gcode.text.normal_text import normalise

    number = LINUXCNC["LINE_NUMBER"]
    label = f"{LINUXCNC['O_NUMBER']}|{LINUXCNC['O_NAME']}"
    keyword = LINUXCNC["KEYWORD"]
    form = rf"{LINUXCNC['DELETE']}?(?:{number})?(?P<label>{label})(?P<keyword>{keyword})"
    opening = re.match(form, normalise(text))
    if opening is None:
        return None, ""
    name = opening["label"][1:].strip("<>")
    return (float(name) if name.isdecimal() else name), opening["keyword"]
