"""The course of a run: line after line from the first one on, wherever O-words, jumps and calls lead.

Lines of the main program that are reached for the first time are scanned into columns where they are plain. Lines of LinuxCNC's
dialect and FANUC's are computed while they are read, again each time. Any other line is parsed, and runs by itself.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache

from cncgen.gcode.block import Parsed
from cncgen.gcode.budget import LINE, PAUSE
from cncgen.gcode.codes.table import language_of
from cncgen.gcode.errors import Astray, BlockError
from cncgen.gcode.flow.executing import Executor
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.flow.pending import PendingBlocks
from cncgen.gcode.flow.reading import LineReader, Percent, first_line
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import BLOCKS, FEW_BLOCKS
from cncgen.kernels import gcode_scan
from cncgen.toolpath.reading import ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.line_by_line import LineRunner
    from cncgen.gcode.flow.profile_lines import Take
    from cncgen.gcode.flow.recurrence import Recurrence
    from cncgen.gcode.text.labels import Label


class Course:
    """Runs the lines of a program, the first of the texts; the arguments are those of `running.Runner`.

    Attributes:
        ip, executor, pending, percent: The interpreter, what has it execute a block, the blocks that wait, the lines of ``%``.
        reached: The first line of the main program that was not run.
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
        # The scanner does not tell 10 from 10. where the former counts in least increments: every line is parsed.
        language = language_of(dialect)
        increments = language == "fanuc" and options.least_increment is not None
        self._by_line = increments or dialect == "heidenhain"
        self._sources, self._faults = sources, faults
        self.ip = ip = Interpreter(sink, options, faults.remark, dialect, plain=plain)
        self._control = control = ip.flow = FlowControl(ip, sources, path)
        self.executor = Executor(ip, control.calls, faults)
        self._line_runner = cache(self._make_line_runner)
        self.pending = PendingBlocks(
            control,
            sources,
            self._line_runner,
            self.executor,
            faults,
            batches=batches,
            computes=not self._by_line,
        )
        self._lines = control.lines = LineReader(sources, language, increments=increments)
        self.percent = Percent(ip, sources[0])
        control.calls.flush = faults.flush = self.pending.flush
        control.execute = self.executor.execute
        control.run_profile = self._run_profile
        faults.recover = self._recover
        self._frames = control.calls.frames
        self._recurrence: Recurrence | None = None
        self.reached = self._here = first_line(ip, sources[0])
        #: Lines of the main program that jumps led past when they were reached: the first, and the offset of the one behind them.
        self._passed: list[tuple[Cursor, int]] = []
        #: Lines run, and blocks counted before them, since a line was reached for the first time.
        self._since = self._begun = 0
        self._looked = False
        #: Whether the last line was an O-word: few plain blocks are likely to follow.
        self._branched = False
        self._ahead = BLOCKS

    def _make_line_runner(self) -> LineRunner:
        """Return what runs lines one by one; programs whose lines are all plain or computed do not import the module."""
        from cncgen.gcode.flow.line_by_line import LineRunner

        return LineRunner(self._control, self.executor.execute)

    def resume(self) -> None:
        """Go on at the first line that was not run."""
        self._control.calls.give_up()
        self._here = self.reached

    def run(self) -> Iterator[None]:
        """Run until the program or its text ends; yields now and then, so that rows can be taken away.

        Raises:
            Astray: The program can never go on: a round has changed nothing, or a fault keeps a loop from ending.
        """
        ip, pending = self.ip, self.pending
        while not ip.state.ended:
            here = self._here
            forward = self._is_forward(here)
            if forward:
                if here.offset > self.reached.offset:
                    self._passed.append((self.reached, here.offset))
                self.reached = here
            if here.offset >= len(self._sources[here.source]):
                self._end_text(here)
                return
            if forward and not (pending.count or self._branched or self._by_line):
                why = self._scan(here)
                yield
                if why != gcode_scan.OTHER:
                    continue
                here = self._here
                if ip.state.ended:
                    return
            if not self._compute(here):
                self._run_line(here)
            if self._looked:
                self._looked = False
                yield

    def tell_of_passed(self) -> None:
        """Warn of lines that cannot be read and that the run has led past."""
        self._faults.passed((here, self._fault_of(here)) for here in self._lines_passed())

    def _lines_passed(self) -> Iterator[Cursor]:
        for here, behind in self._passed:
            while here.offset < behind:
                yield here
                here = self._lines.after(here)

    def _fault_of(self, here: Cursor) -> BlockError | None:
        """Return why a line cannot be read, None where it can."""
        try:
            self._read(self._lines.text(here))
        except BlockError as error:
            return error
        return None

    def _is_forward(self, here: Cursor) -> bool:
        """Tell whether a line of the main program is reached for the first time."""
        return here.source == 0 and here.offset >= self.reached.offset and not self._frames

    def _end_text(self, here: Cursor) -> None:
        """End the main program at the end of its text; a subroutine is not finished there."""
        self.pending.flush()
        if self._frames:
            name = self._sources[here.source].name
            message = f"{name} ends within a subroutine"
            raise Astray(BlockError("sub-unfinished", message, hint="ENDSUB or M99?"))
        if here.source:
            self.ip.state.ended = True

    def _scan(self, here: Cursor) -> int:
        """Run plain blocks; return why the scanner stopped, FULL where they lead elsewhere."""
        self.reached, why, has_words = self.pending.scan(here, self._ahead)
        self.ip.budget.forward = self.reached.line
        self._since = 0
        self.percent.seen = self.percent.seen or has_words
        place = self.pending.run()
        self._ahead = min(2 * self._ahead, BLOCKS) if place is None else FEW_BLOCKS
        if place is not None:
            # The text goes on behind the jump, wherever the scanner was.
            self.reached = self._lines.after(place)
            why = gcode_scan.FULL
        self._here = self.reached
        if place is not None:
            try:
                self._here = self._control.follow_jump(place, self.reached) or self.reached
            except BlockError as error:
                self._faults.fail(place, error)
        return why

    def _compute(self, here: Cursor) -> bool:
        """Read on lines that are computed while they are read; tell whether there was one."""
        # A line of % is left at once: many programs have no other one that is not plain.
        percent = self._sources[here.source].data[here.offset] == ord("%")
        found = None if percent else self.pending.compute(here, self.reached, self._since)
        if found is None:
            return False
        if found.reached != self.reached:
            self._begun = self.ip.budget.steps
            self.percent.seen = True
        self._passed += found.passed
        self.reached, self._since, self._here = found.reached, found.since, found.end
        if found.back is not None:
            self._look(found.back, found.end)
        return True

    def _run_line(self, here: Cursor) -> None:
        """Run a line that is neither plain nor computed; the line that it leads to is next."""
        following = here
        try:
            if self.pending.count and self._is_forward(here) and "o" not in self._lines.text(here).lower():
                # No O-word: from here on the scanner may go on, and it writes over blocks that wait.
                self.pending.flush()
                self._branched = False
                return
            following, text = self._lines.after(here), self._lines.text(here)
            parsed = self._read(text)
            self._branched = parsed.is_o_word
            if self._is_forward(here):
                self.reached = following
                self._since, self._begun = 0, self.ip.budget.steps
                self.ip.budget.forward = following.line
            else:
                self._since += 1
            self.ip.budget.count(1, LINE)
            target = following
            if not text.lstrip().startswith("%"):
                target = self._line_runner().run(parsed, here, following) or following
            elif here.source == 0:
                self.percent.line(text, self.reached.offset)
        except BlockError as error:
            following = target = self._lines.after(here)
            if error.code == "open-comment":
                from cncgen.gcode.flow.recovery import behind_comment

                target = behind_comment(self._control, here, error) or following
                self.reached = target if self._is_forward(here) else self.reached
            self._faults.fail(error.place or here, error)
            if error.code == "syntax" and self._faults.found:
                from cncgen.gcode.flow.recovery import behind_branch

                target = behind_branch(self._control, self._faults, here) or following
        self._here = target
        if self._since >= PAUSE and target <= here:
            self._look(here, target)

    def _look(self, here: Cursor, back: Cursor) -> None:
        """Raise where a jump back finds everything as it was at the last one: the loop is endless."""
        self._since, self._looked = 0, True
        self.pending.flush()
        if self._recurrence is None:
            from cncgen.gcode.flow.recurrence import Recurrence

            self._recurrence = Recurrence(self.ip, self._faults, lambda: self._control.calls.records)
        self._recurrence.look(here, back, self._begun)

    def _read(self, text: str) -> Parsed:
        """Return the block of a line; none of a line of % or an empty one."""
        bare = text.strip()
        if bare.startswith("%"):
            return Parsed()
        self.percent.seen = True
        return self._lines.parse(text) if bare else Parsed()

    # Only programs of turning cycles import the module of profiles, and only those with faults that of recovery.

    def _run_profile(self, take: Take, first: Cursor, end: Cursor | Label, word: str) -> None:
        from cncgen.gcode.flow.profile_lines import run_profile

        run_profile(self._control, take, first, end, word)

    def _recover(self, text: str) -> None:
        from cncgen.gcode.flow.recovery import recover

        recover(self.ip, self._lines.parse, text)
