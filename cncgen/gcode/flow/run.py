"""The common part of the runs of all languages."""

from __future__ import annotations

import os

from cncgen.diagnostics import Diagnostics
from cncgen.gcode.errors import Reporter
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.gcode.text.dialects import Choice, chosen
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
        dialect, deletes = self._choice.dialect, options.block_delete
        self._faults = Faults(self.sources, sink, self.reporter, dialect, deletes=deletes)
        self._assemble(sink)

    def _assemble(self, sink: Sink) -> None:
        """Make the interpreter, and what leads it through the program."""
        raise NotImplementedError
