"""The main program of a text of FANUC's that begins with a subprogram, or with the number of a program alone."""

from __future__ import annotations

from contextlib import suppress

from cncgen.gcode.block import tenths
from cncgen.gcode.codes.table import table
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text import grammar
from cncgen.gcode.text.dialects import bare
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.parsers import parser
from cncgen.kernels import gcode_codes
from cncgen.kernels.gcode_lines import Lines

_HEAD = 65_536
#: Letters without which a line ends no program and calls none.
_TELLING = frozenset("MP")


def main_behind(source: Source) -> tuple[Cursor, BlockError] | None:
    """Return where the main program of a text stands that begins with another, and a remark on it, looking once.

    A control registers the programs of a text one by one, and the operator starts the main one, not a subprogram and none without blocks.
    """
    if source.main is None:
        source.main = (_found(source),)
    return source.main[0]


def _found(source: Source) -> tuple[Cursor, BlockError] | None:
    head = source.bytes[:_HEAD]
    number = gcode_codes.LITERALS["program"]
    marks = Lines(parser("fanuc", False), head).marked(False)
    begins = [(begin, line) for begin, line, keyword, *_ in marks if keyword == number]
    if len(begins) < 2:
        return None
    ends = [*(begin for begin, _ in begins[1:]), len(head)]
    # The last one is taken to have blocks: they may go on behind the head.
    last = len(begins) - 1
    filled = next((k for k in range(last) if not _is_empty(source.data[begins[k][0] : ends[k]])), last)
    empty = _Listed(source, begins[0][0], ends[0]).name
    begins, ends = begins[filled:], ends[filled:]
    first = _Listed(source, begins[0][0], ends[0])
    for (begin, line), end in zip(begins[1:], ends[1:], strict=True):
        if first.main:
            break
        program = _Listed(source, begin, end)
        # M99 P goes to a line of the program that called this one, or repeats it where none did.
        if program.main and (first.returns or (first.leads_back and first.number in program.calls)):
            message = (
                f"the program begins with {program.name}, a main program behind the subprogram {first.name}"
            )
            hint = "put the main program first"
            return Cursor(0, begin, line), BlockError("main-behind", message, hint=hint)
    if not filled:
        return None
    message = f"the program begins with {first.name}: {empty} before it has no blocks"
    hint = "leave the number out that is not the program's"
    return Cursor(0, *begins[0]), BlockError("main-behind", message, hint=hint)


def _is_empty(text: bytes) -> bool:
    """Tell whether a program is its number alone, with comments."""
    number = bare(text).strip(b"\r\n;%")
    return number[1:].isdigit() or (number[1:2] == b"<" and number.find(b">") == len(number) - 1)


class _Listed:
    """The facts of a program within a text: its number, which ones it calls, and whether it ends as a main program or returns."""

    def __init__(self, source: Source, at: int, end: int) -> None:
        begin = grammar.parse(source.text_at(at), "fanuc")
        self.number = begin.flow.label if begin.flow else None
        self.name = f"O{self.number:g}" if isinstance(self.number, float) else f"<{self.number}>"
        self.calls: set[float] = set()
        self.main = self.returns = self.leads_back = False
        rows = table("fanuc")
        while at < end:
            text = source.text_at(at)
            at = source.line_end(at) + 1
            if _TELLING.isdisjoint(text.upper()):
                continue
            with suppress(BlockError):
                words = [
                    (letter, v) for letter, v in grammar.parse(text, "fanuc").words if isinstance(v, float)
                ]
                given = dict(words)
                for row in (
                    rows.row(letter.upper(), tenths(letter, v)) for letter, v in words if letter in "gm"
                ):
                    if row is not None:
                        self.calls |= {given[row.calls]} if row.calls in given else set()
                        self.main = self.main or row.ends == "program"
                        self.returns = self.returns or (row.ends == "subprogram" and "p" not in given)
                        self.leads_back = self.leads_back or (row.ends == "subprogram" and "p" in given)
