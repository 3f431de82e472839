"""Running a program from its first line to its end."""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.diagnostics import Severity
from cncgen.gcode.assumed_units import assumed_units
from cncgen.gcode.block import Block
from cncgen.gcode.doubts import tell
from cncgen.gcode.errors import Astray, BlockError, Stop
from cncgen.gcode.flow.course import Course
from cncgen.gcode.flow.reading import tell_of_rest
from cncgen.gcode.flow.run import Run
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.gcode.state.parameters import write_parameters
from cncgen.gcode.text.labels import Cursor


class Runner(Run):
    """A run from line to line, wherever O-words, jumps and calls lead.

    Attributes:
        batches: Whether plain motions are interpreted in arrays. Without that every block goes through its handlers one by one, which is
            slower and gives the same.
    """

    batches = True

    def _assemble(self, sink: Sink) -> None:
        choice, options = self._choice, self._options
        self._course = Course(
            self.sources,
            choice.dialect,
            options,
            sink,
            self._faults,
            path=self._path,
            batches=self.batches,
            plain=options.dialect == "auto"
            and not options.stand_alone
            and (choice.dialect, choice.reason) == ("linuxcnc", ""),
        )
        self.ip = self._course.ip

    def run(self) -> Iterator[None]:
        """Run to the end; yields now and then, so that rows can be taken away."""
        source, faults = self.sources[0], self._faults
        if faults.refuses(source):
            return
        try:
            self._say_dialect()
            if self._choice.unread:
                return
            self.ip.begin()
            yield from self._run()
            self._finish()
        except Stop as stop:
            faults.here(stop.error)

    def _run(self) -> Iterator[None]:
        """Run until the program ends; where it leads nowhere, go on at the first line not reached yet."""
        while not self.ip.state.ended:
            try:
                yield from self._course.run()
                return
            except Astray as astray:
                self._course.pending.flush()
                if astray.error is not None:
                    self._faults.here(astray.error)
                self._course.resume()

    def _say_dialect(self) -> None:
        """Note the chosen dialect if the text decided it, and text with another meaning on other controls."""
        source, choice = self.sources[0], self._choice
        tell(self.reporter, source, choice, self._options)
        if not choice.unread:
            for here, doubt, severity in assumed_units(source, choice.dialect, self._options):
                self.reporter.report(source, here.line, here.offset, doubt, severity)

    def _finish(self) -> None:
        """Report missing parts at the end of the text, and save the parameters on request."""
        source, course = self.sources[0], self._course
        last = Cursor(0, _last_line(source), max(course.reached.line - 1, 1))
        try:
            self.ip.end_compensation()
        except BlockError as error:
            self._faults.at(last, error)
        if self.ip.guard is not None:
            course.executor.guarded(Block({}, m=(20,), line=last.line, offset=last.offset))
        if not course.percent.seen:
            self._faults.at(Cursor(0, 0, 1), BlockError("empty-program", "the program has no block"))
        elif not self.ip.state.ended:
            self.ip.base.block = Block({}, line=last.line, offset=last.offset)
            self._faults.remark(
                BlockError("no-program-end", "the program ends without M2, M30 or a closing %"),
                Severity.ERROR if self._options.stand_alone else Severity.WARNING,
            )
        elif (ended := self.ip.ended_in) and ended.source == 0 and not self._options.stand_alone:
            tell_of_rest(self.ip, source, ended)
        course.tell_of_passed()
        if self._options.save_parameters is not None:
            write_parameters(self._options.save_parameters, self.ip.parameters, self._options.parameters)


def _last_line(source: Source) -> int:
    """Return the offset of the last line that holds anything."""
    end = len(source)
    while end and source.data[end - 1 : end] in b"\r\n":
        end -= 1
    return source.data.rfind(b"\n", 0, end) + 1
