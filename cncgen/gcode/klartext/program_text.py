"""The text of a program in plain language: its lines, their labels, and what each says."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow import language_run
from cncgen.gcode.flow.language_run import LanguageRun
from cncgen.gcode.klartext import lines
from cncgen.gcode.klartext.free_contours import Known
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.line_runs import ProgramLines, RunScan
from cncgen.gcode.text.plain_language import Statement

#: The number of a block in the text.
_NUMBER = re.compile(r"\s*/?\s*(\d{1,9})\s")
#: It stands for an unread block when another block looks at it.
UNREAD = Statement("unread")
_FREE = ("FP", "FL", "FC")
_ROTARY = frozenset("abc")


@dataclass(slots=True)
class Line(language_run.Line):
    """A line: its place, and its text without number and comment."""

    body: str

    def says(self) -> bool:
        """Tell whether it is more than a comment."""
        return bool(self.body) and not self.body.startswith("*")


@dataclass(slots=True)
class Program(language_run.Program[Line]):
    """The lines of a program.

    Attributes:
        labels: Lines by label.
        head: The line with the first % of DIN/ISO, -1 without one.
        ends: End and direction of the motion of each line that has made one.
        turning: Of the runs that turn rotary axes, the first line behind each.
    """

    labels: dict[str, list[int]] = field(default_factory=dict)
    head: int = -1
    ends: dict[int, Known] = field(default_factory=dict)
    turning: set[int] = field(default_factory=set)

    def labelled(self, name: str) -> list[int]:
        """Return the lines of a label."""
        return self.labels.get(name, [])


Frame = language_run.Frame[Program]


class ProgramText(LanguageRun[Program]):
    """A run, as far as it reads."""

    plain, hangs = "heidenhain", True
    #: The statement of a block; recent ones are kept. How blocks of labels begin.
    parse: Callable[[str], Statement] = staticmethod(lru_cache(4096)(plain_language.parse))
    label_heads: tuple[str, ...] = ("LBL",)

    def _prepare(self) -> None:
        #: Whether a free contour is among the lines, which may name blocks before it.
        self._is_free = False

    def _load(self, index: int, name: str) -> Program:
        source = self.sources[index] = lines.joined(self.sources[index])
        program = Program(
            ProgramLines(source, lambda here: Line(here, lines.bare(source.text_at(here.offset))))
        )
        scan = RunScan(self.plain, source) if self.plain and self.batches else None

        def passed(offset: int, number: int) -> tuple[int, int]:
            run = scan.run_at(Cursor(index, offset, number), whole=False) if scan else None
            if scan is None or run is None:
                return offset, number
            program.lines.add_run(run)
            if scan.letters & _ROTARY:
                program.turning.add(len(program.lines))
            return run.after, number + run.count

        block_delete = self._options.block_delete
        texts = lines.bodies(source, block_delete=block_delete, passed=passed)
        for offset, number, bare, below, behind in texts:
            if behind:
                program.apart.add(len(program.lines))
            if below:
                program.lines[-1].body += f" {bare}"
                program.alone = False
            for own in () if below else self._said(bare):
                self._note(program, own)
                program.lines.append(Line(Cursor(index, offset, number), own))
        return program

    def _said(self, bare: str) -> list[str]:
        """Return a line as blocks, its parameters of a cycle apart."""
        return lines.apart(bare)

    def _note(self, program: Program, own: str) -> None:
        """Keep what is asked of the next block of a program before it runs: its label, and whether it is of a free contour."""
        head = own[:3].upper()
        self._is_free = self._is_free or head.startswith(_FREE)
        if head in self.label_heads:
            label = self._unread(own)
            if label.kind == "label" and label.data[0] != "0":
                program.labels.setdefault(label.data[0], []).append(len(program.lines))

    @property
    def _lines(self) -> ProgramLines[Line]:
        return self.frames[-1].program.lines

    def _following(self, at: int) -> int | None:
        """Return the next line that is not a comment."""
        found = self._lines
        for k in range(at + 1, len(found)):
            if found[k].says():
                return k
        return None

    def _number(self, at: int) -> int:
        """Return the number of a block in the text, 0 where it has none."""
        here = self._lines[at].here
        digits = _NUMBER.match(self.sources[here.source].text_at(here.offset))
        return int(digits[1]) if digits else 0

    def _statement(self, at: int, body: str) -> Statement:
        """Return what a line says that is run; its faults point into the text."""
        try:
            return self.parse(body)
        except BlockError as error:
            self._point(self._lines[at].here, body, error)
            raise

    def _fault_of(self, program: Program, at: int) -> BlockError | None:
        line = program.lines[at]
        try:
            if line.says():
                self.parse(line.body)
        except BlockError as error:
            self._point(line.here, line.body, error)
            return error
        return None

    def _point(self, here: Cursor, said: str, error: BlockError) -> None:
        """Let a fault point into the text of a line, whose column is that of a part of it."""
        if error.column:
            before = self.sources[here.source].text_at(here.offset).find(said[: error.column - 1] or said)
            error.column = error.column + before if before >= 0 else 0

    def _ahead(self, at: int) -> Statement:
        """Return what a line says that is not run now, whose faults it will tell by itself."""
        return self._ahead_in(self.frames[-1].program, at)

    def _ahead_in(self, program: Program, at: int) -> Statement:
        """Return the same of a line of a program."""
        return self._unread(program.lines[at].body)

    def _unread(self, body: str) -> Statement:
        try:
            return self.parse(body)
        except BlockError:
            return UNREAD
