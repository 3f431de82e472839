"""The faults of lines in a run: each is reported once, and a loop in which lines fail again and again is ended."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice

from cncgen.diagnostics import Severity
from cncgen.gcode.codes.table import language_of
from cncgen.gcode.errors import Astray, BlockError, Reporter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor

#: Faults of lines that failed before, after which the loops they stand in count as endless.
_MAX_FAILURES = 1000
#: Lines that a run has led past, so many of which are read at most: a jump to the middle of a long program leads past all before it.
_MOST_PASSED = 4096


class Faults:
    """Hands the faults of lines to the reporter.

    Attributes:
        flush: Runs pending blocks before a fault is reported, so that their faults come first.
        recover: Takes the text of a faulty line, and puts the modes that it sets in force (`recovery`).
        found: Whether anything was wrong so far.
    """

    def __init__(
        self, sources: list[Source], sink: Sink, reporter: Reporter, dialect: str, *, deletes: bool
    ) -> None:
        """Begin without faults; `deletes` tells that blocks with a slash are left out."""
        self._sources = sources
        self._deletes, self._behind_numbers = deletes, language_of(dialect) == "fanuc"
        self._sink = sink
        self._reporter = reporter
        self.flush: Callable[[], None] = lambda: None
        self.recover: Callable[[str], None] = lambda text: None
        self.found = False
        #: Line and code of the faults that are reported.
        self._said: set[tuple[Cursor, str]] = set()
        self._failures = 0

    def at(self, here: Cursor, error: BlockError) -> None:
        """Report the fault of a line."""
        self.found = True
        self._reporter.report(self._sources[here.source], here.line, here.offset, error)

    def refuses(self, source: Source) -> bool:
        """Report a binary source; tell whether it is one."""
        if not source.is_binary():
            return False
        hint = (
            "is it UTF-16 without its mark, or UTF-32? save it as UTF-8 or ASCII" if source.is_wide() else ""
        )
        message = f"{source.name} is not text: it holds NUL bytes"
        self.at(Cursor(0, 0, 1), BlockError("binary-file", message, hint=hint))
        return True

    def here(self, error: BlockError) -> None:
        """Report the fault of the executed block."""
        block = self._sink.block
        self.at(Cursor(block.source, block.offset, max(block.line, 1)), error)

    def fail(self, here: Cursor, error: BlockError) -> None:
        """Report that a line failed, once for each kind of fault; the rest of the line is not executed.

        Raises:
            Astray: Lines failed so often that a loop, whose condition their effects would have ended, counts as endless.
        """
        self.flush()
        text = self._sources[here.source].text_at(here.offset)
        if error.code == "syntax" and self._deletes and self._is_left_out(text):
            return
        if (here, error.code) not in self._said:
            self._said.add((here, error.code))
            self.at(here, error)
            self.recover(text)
            return
        self._failures += 1
        if self._failures % _MAX_FAILURES == 0:
            raise Astray

    def passed(self, lines: Iterable[tuple[Cursor, BlockError | None]]) -> None:
        """Warn of lines that cannot be read where the run has led past them: other values would lead to them."""
        found = [
            (here, error)
            for here, error in islice(lines, _MOST_PASSED)
            if error is not None and error.code == "syntax" and not self._is_known(here)
        ]
        if found:
            here, error = found[0]
            more = f" and past {len(found) - 1} more that cannot be read" if len(found) > 1 else ""
            error.message += f"; the run leads past this line{more}"
            source = self._sources[here.source]
            self._reporter.report(source, here.line, here.offset, error, Severity.WARNING)

    def _is_known(self, here: Cursor) -> bool:
        """Tell whether the syntax of a line is a fault that was reported, or none as its block is left out."""
        text = self._sources[here.source].text_at(here.offset)
        return (here, "syntax") in self._said or (self._deletes and self._is_left_out(text))

    def remark(self, error: BlockError, severity: Severity) -> None:
        """Add a remark on a word of the block that is executed, once for each kind of remark; the block runs."""
        block = self._sink.block
        self.flush()
        here = Cursor(block.source, block.offset, max(block.line, 1))
        what = f"{error.code} {error.word}"
        if (here, what) not in self._said:
            self._said.add((here, what))
            self._reporter.report(self._sources[here.source], here.line, here.offset, error, severity)

    def _is_left_out(self, text: str) -> bool:
        """Tell whether a block begins with a slash, on FANUC's controls maybe behind its number; two are a comment of other languages."""
        head = text.lstrip()
        if self._behind_numbers and head[:1] in ("N", "n"):
            head = head[1:].lstrip(" \t0123456789")
        return head.startswith("/") and not head.startswith("//")
