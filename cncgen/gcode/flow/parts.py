"""The objects that one run of a program consists of, connected to each other in one place."""

from __future__ import annotations

import os
from functools import cache, partial

from cncgen.gcode.codes.table import language_of
from cncgen.gcode.flow.executing import Executor
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.flow.pending import PendingBlocks
from cncgen.gcode.flow.reading import LineReader, Percent
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.toolpath.reading import ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.line_by_line import LineRunner
    from cncgen.gcode.flow.profile_lines import Take
    from cncgen.gcode.text.labels import Cursor, Label


class Parts:
    """The parts of a run, which begins with the first of the texts; the arguments are those of `running.Runner`.

    Attributes:
        sources: The texts: the main program, then files in the order in which they were called.
        by_line: Whether the scanner cannot read the dialect's plain blocks, so that every line is parsed.
        line_runner: Gives what runs lines one by one.
    """

    def __init__(
        self,
        sources: list[Source],
        dialect: str,
        options: ReadOptions,
        sink: Sink,
        faults: Faults,
        *,
        path: str | os.PathLike[str] | None,
        batches: bool,
        plain: bool,
    ) -> None:
        # The scanner does not tell 10 from 10. where the former counts in least increments.
        language = language_of(dialect)
        increments = language == "fanuc" and options.least_increment is not None
        self.by_line = increments or dialect == "heidenhain"
        self.sources, self.faults = sources, faults
        self.ip = ip = Interpreter(sink, options, faults.remark, dialect, plain=plain)
        self.control = ip.flow = FlowControl(ip, sources, path)
        self.executor = Executor(ip, self.control.calls, faults)
        self.line_runner = cache(self._line_runner)
        self.pending = PendingBlocks(
            self.control,
            sources,
            self.line_runner,
            self.executor,
            faults,
            batches=batches,
            computes=not self.by_line,
        )
        self.lines = self.control.lines = LineReader(sources, language, increments=increments)
        self.percent = Percent(ip, sources[0])
        self.control.calls.flush = faults.flush = self.pending.flush
        self.control.execute = self.executor.execute
        self.control.run_profile = partial(_run_profile, self.control)
        faults.recover = partial(_recover, ip, self.lines)

    def _line_runner(self) -> LineRunner:
        """Return what runs lines one by one; programs whose lines are all plain or computed do not import the module."""
        from cncgen.gcode.flow.line_by_line import LineRunner

        return LineRunner(self.control, self.executor.execute)


def _run_profile(control: FlowControl, take: Take, first: Cursor, end: Cursor | Label, word: str) -> None:
    """Run the lines of a profile; only programs of turning cycles import the module."""
    from cncgen.gcode.flow.profile_lines import run_profile

    run_profile(control, take, first, end, word)


def _recover(ip: Interpreter, lines: LineReader, text: str) -> None:
    """Put the modes of a faulty line in force; a program without faults does not import the module."""
    from cncgen.gcode.flow.recovery import recover

    recover(ip, lines.parse, text)
