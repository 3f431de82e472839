"""Loops of FANUC's macros: WHILE […] DO n … END n, each within its program, nested and not overlapping (B-63324EN, 15.6).

The text alone, and not the run, decides which DO an END closes: a jump may leave a loop at any time.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable

from cncgen.gcode.errors import BlockError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.block import Value
    from cncgen.gcode.flow.o_words import FlowControl
    from cncgen.gcode.text.labels import Cursor
    from cncgen.gcode.text.marked_lines import Marked


class Loops:
    """The loops of a source.

    Attributes:
        partner: The other end of a loop, by the offset of its DO or END.
        faults: Fault of a DO or END, by offset.
    """

    def __init__(self, marks: Iterable[Marked]) -> None:
        self.partner: dict[int, Marked] = {}
        self.faults: dict[int, BlockError] = {}
        self._open: list[Marked] = []
        #: All DO of a number, in order.
        self._begins: dict[Value | str, list[Marked]] = {}
        #: Loops that an outer END went past.
        self._left: dict[object, tuple[Marked, Marked]] = {}
        for mark in marks:
            if mark.keyword == "program":
                self._open, self._left = [], {}
            elif mark.keyword == "while-do":
                self._begin(mark)
            elif mark.keyword == "end-do":
                self._end(mark)

    def _begin(self, mark: Marked) -> None:
        self._left.pop(mark.label, None)
        outer = next((loop for loop in self._open if loop.label == mark.label), None)
        if outer is not None:
            number = _number(mark.label)
            message = f"DO {number} stands within the loop DO {number} of line {outer.cursor.line}"
            hint = f"give the inner loop another number, or close the outer one before it by END {number}"
            self.faults[mark.cursor.offset] = BlockError("loop-nested", message, "DO", hint=hint)
        self._open.append(mark)
        self._begins.setdefault(mark.label, []).append(mark)

    def entered(self, here: int, there: int) -> Marked | None:
        """Return the DO of a loop around the line at `there` and not around the one at `here`, which leads there; None without one."""
        for begins in self._begins.values():
            # Loops of one number do not stand within one another.
            k = bisect_left(begins, there, key=lambda mark: mark.cursor.offset) - 1
            end = self.partner.get(begins[k].cursor.offset) if k >= 0 else None
            last = end.cursor.offset if end is not None else -1
            if there <= last and not begins[k].cursor.offset < here <= last:
                return begins[k]
        return None

    def _end(self, mark: Marked) -> None:
        place = next((k for k in reversed(range(len(self._open))) if self._open[k].label == mark.label), None)
        if place is not None:
            self._join(self._open[place], mark)
            self._left.update({loop.label: (loop, mark) for loop in self._open[place + 1 :]})
            del self._open[place:]
        elif mark.label in self._left:
            begin, between = self._left.pop(mark.label)
            self._join(begin, mark)
            number, other = _number(mark.label), _number(between.label)
            self.faults[mark.cursor.offset] = BlockError(
                "loop-overlap",
                f"END {number} stands behind the END {other} of line {between.cursor.line}, but DO {number} of line"
                f" {begin.cursor.line} within that loop: the loops overlap",
                "END",
                hint=f"END {number} comes before END {other}",
            )

    def _join(self, begin: Marked, end: Marked) -> None:
        self.partner[begin.cursor.offset], self.partner[end.cursor.offset] = end, begin


def end_of(control: FlowControl, value: float, here: Cursor) -> Cursor:
    """Return the line behind the END of a DO; raise where it has none, or stands in a loop of its own number."""
    return _partner(control, value, here, "DO", "END", "ends with a block END {} in the same program").after


def begin_of(control: FlowControl, value: float, here: Cursor) -> Cursor:
    """Return the line of the DO of an END; raise where it has none, or their loop overlaps with another one."""
    return _partner(control, value, here, "END", "DO", "begins with WHILE[…] DO {0}, or DO {0}").cursor


def _partner(control: FlowControl, value: float, here: Cursor, word: str, other: str, how: str) -> Marked:
    """Return the other end of the loop whose DO or END, the word, stands here."""
    number = _checked(value, word)
    loops = control.subroutines.labels(here.source).loops
    if here.offset in loops.faults:
        raise loops.faults[here.offset]
    if here.offset not in loops.partner:
        message = f"{word} {number} has no {other} {number}"
        raise BlockError("loop-unmatched", message, word, hint=f"a loop {how.format(number)}")
    return loops.partner[here.offset]


def _checked(number: float, keyword: str) -> str:
    """Return the written number of a DO or END; raise unless it is 1, 2 or 3."""
    if number not in (1.0, 2.0, 3.0):
        hint = "a number may be used again where its loop has ended"
        raise BlockError("loop-number", f"DO and END take 1, 2 or 3, not {number:g}", keyword, hint=hint)
    return _number(number)


def _number(label: object) -> str:
    """Return the written number of a loop."""
    return f"{label:g}" if isinstance(label, float) else str(label)
