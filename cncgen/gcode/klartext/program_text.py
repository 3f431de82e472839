"""The text of a program in plain language: its lines, their labels, and what each says."""

from __future__ import annotations

import re

from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.language_run import LanguageRun
from cncgen.gcode.klartext import lines
from cncgen.gcode.source import Source
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.line_runs import PlainScan, ProgramLines, run_of
from cncgen.gcode.text.plain_language import Statement

#: The number of a block in the text.
_NUMBER = re.compile(r"\s*/?\s*(\d{1,9})\s")
#: What stands for a block that is not read, where it is looked at from another one.
UNREAD = Statement("unread")
#: How words of free contours begin.
_FREE = ("FP", "FL", "FC")
#: Statements kept.
_MOST_KEPT = 4096


class ProgramText(LanguageRun):
    """A run, as far as it reads."""

    #: The grammar of lines that are plain in every state; none where lines hang on what stands before them.
    plain: str = "heidenhain"

    def _prepare(self) -> None:
        self._begin_text(self.sources[0])
        #: Whether a free contour is among the lines, which may name blocks before it.
        self._is_free = False
        self._labels: dict[str, int] = {}
        #: Statements of late by their text.
        self._parsed: dict[str, Statement] = {}

    def _begin_text(self, source: Source) -> None:
        """Have no lines, of another text from now on."""
        self._lines: ProgramLines[Cursor] = ProgramLines(source, lambda here: here)
        self._bodies: ProgramLines[str] = ProgramLines(
            source, lambda here: lines.bare(source.text_at(here.offset))
        )

    def _read(self, source: Source, index: int = 0) -> None:
        """Take the lines, their text without numbers and comments, and the labels."""
        scan = PlainScan(self.plain) if self.plain and self.batches else None

        def passed(offset: int, number: int) -> tuple[int, int]:
            run = run_of(scan, source, Cursor(index, offset, number), whole=False) if scan else None
            if run is None:
                return offset, number
            self._lines.add_run(run)
            self._bodies.add_run(run)
            return run.after, number + run.count

        block_delete = self._options.block_delete
        for offset, number, bare, below in lines.bodies(source, block_delete=block_delete, passed=passed):
            if below:
                self._bodies.replace_last(f"{self._bodies[-1]} {bare}")
            for own in () if below else self._said(bare):
                head = own[:3].upper()
                self._is_free = self._is_free or head.startswith(_FREE)
                if head == "LBL":
                    label = self._ahead(len(self._lines), own)
                    if label.kind == "label" and label.data[0] != "0":
                        self._labels.setdefault(label.data[0], len(self._lines))
                self._lines.append(Cursor(index, offset, number))
                self._bodies.append(own)

    def _said(self, bare: str) -> list[str]:
        """Return a line as blocks, its parameters of a cycle apart."""
        return lines.apart(bare)

    def _following(self, at: int) -> int | None:
        """Return the next line that is not a comment."""
        return next(
            (
                k
                for k in range(at + 1, len(self._bodies))
                if self._bodies[k] and not self._bodies[k].startswith("*")
            ),
            None,
        )

    def _number(self, at: int) -> int:
        """Return the number of a block in the text, 0 where it has none."""
        here = self._lines[at]
        digits = _NUMBER.match(self.sources[here.source].text_at(here.offset))
        return int(digits[1]) if digits else 0

    def _parse(self, body: str) -> Statement:
        """Return what a block says; those of late are kept."""
        found = self._parsed.get(body)
        if found is None:
            found = plain_language.parse(body)
            if len(self._parsed) >= _MOST_KEPT:
                self._parsed.clear()
            self._parsed[body] = found
        return found

    def _statement(self, at: int, body: str) -> Statement:
        """Return what a line says that is run; its faults point into the text."""
        try:
            return self._parse(body)
        except BlockError as error:
            self._point(at, body, error)
            raise

    def _point(self, at: int, said: str, error: BlockError) -> None:
        """Let a fault point into the text of a line, whose column is that of a part of it."""
        if error.column:
            here = self._lines[at]
            before = self.sources[here.source].text_at(here.offset).find(said[: error.column - 1] or said)
            error.column = error.column + before if before >= 0 else 0

    def _ahead(self, at: int, body: str | None = None) -> Statement:
        """Return what a line says that is not run now, whose faults it will tell by itself."""
        try:
            return self._parse(self._bodies[at] if body is None else body)
        except BlockError:
            return UNREAD
