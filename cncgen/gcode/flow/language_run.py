"""The common parts of the runs of all languages, and of SINUMERIK's and Heidenhain's plain language."""

from __future__ import annotations

import os

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.gcode.block import Block
from cncgen.gcode.doubts import tell
from cncgen.gcode.errors import Astray, BlockError, Reporter, Stop
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.gcode.text.dialects import Choice, chosen
from cncgen.gcode.text.labels import Cursor
from cncgen.toolpath.reading import ReadOptions


class Run:
    """One run of a program on a sink.

    Args:
        source: The text of the main program.
        options: How it is read.
        sink: Takes the canonical calls.
        diagnostics: Receives the faults.
        path: Where the program stands; subprograms are looked for beside it.
        choice: The dialect, if it was chosen before.

    Attributes:
        reporter: Takes the faults.
        sources: The texts: the main program, then files in the order in which they were called.
        ip: The interpreter.
    """

    ip: Interpreter

    def __init__(
        self,
        source: Source,
        options: ReadOptions,
        sink: Sink,
        diagnostics: Diagnostics,
        *,
        path: str | os.PathLike[str] | None = None,
        choice: Choice | None = None,
    ) -> None:
        self.reporter = Reporter(diagnostics)
        self.sources = [source]
        self._options, self._path = options, path
        self._choice = choice or chosen(source, options.dialect)
        self._faults = Faults(self.sources, sink, self.reporter)
        self._assemble(sink)

    def _assemble(self, sink: Sink) -> None:
        """Make the interpreter, and what leads it through the program."""
        raise NotImplementedError


class LanguageRun(Run):
    """A run of a language that leads through a program by itself."""

    #: The dialect of the interpreter, and how a program ends.
    dialect, ends_with = "", ""
    #: Whether plain lines are interpreted in arrays, which gives the same sooner.
    batches = True

    def _assemble(self, sink: Sink) -> None:
        """Make the interpreter."""
        self.ip = Interpreter(sink, self._options, self._faults.remark, self.dialect)
        self._prepare()

    def _prepare(self) -> None:
        """Make what the language needs."""

    def _open(self) -> bool:
        """Tell of the dialect and of doubts; tell whether the program is text."""
        source = self.sources[0]
        if self._faults.refuses(source):
            return False
        tell(self.reporter, source, self._choice)
        return True

    def _enter(self, here: Cursor) -> None:
        """Begin with a line: remarks and motions are of it."""
        self.ip.base.block = Block({}, source=here.source, line=here.line, offset=here.offset)

    def _fail(self, here: Cursor, error: BlockError) -> None:
        """Report that a line failed; end the program where lines fail again and again."""
        try:
            self._faults.fail(here, error)
        except Astray:
            message = "lines fail again and again: the program counts as endless"
            raise Stop(BlockError("too-many-steps", message, hint="mend the faults above")) from None

    def _check_end(self, last: Cursor) -> None:
        """Warn of a program that its last line does not end."""
        if not self.ip.state.ended and not self._faults.found:
            self.ip.base.block = Block({}, line=last.line, offset=last.offset)
            names = self.ends_with
            error = BlockError(
                "no-program-end", f"the program ends without {names}", hint=f"{names.split()[0]} ends it"
            )
            self._faults.remark(error, Severity.WARNING)
