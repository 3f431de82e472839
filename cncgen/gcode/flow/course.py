"""The course of a run: line after line from the first one on, wherever O-words, jumps and calls lead.

Lines of the main program that are reached for the first time are scanned into columns where they are plain. Lines of LinuxCNC's
dialect and FANUC's are computed while they are read, again each time. Any other line is parsed, and runs by itself.
"""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.gcode.block import Parsed
from cncgen.gcode.budget import LINE, PAUSE
from cncgen.gcode.errors import Astray, BlockError
from cncgen.gcode.flow.parts import Parts
from cncgen.gcode.flow.reading import first_line
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import BLOCKS, FEW_BLOCKS, empty_block
from cncgen.kernels import gcode_scan

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.recurrence import Recurrence


class Course:
    """Runs the lines of a program.

    Attributes:
        reached: The first line of the main program that was not run.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._frames = parts.control.calls.frames
        self._recurrence: Recurrence | None = None
        self.reached = self._here = first_line(parts.ip, parts.sources[0])
        #: Lines run, and blocks counted before them, since a line was reached for the first time.
        self._since = self._begun = 0
        self._looked = False
        #: Whether the last line was an O-word: few plain blocks are likely to follow.
        self._branched = False
        #: Blocks of the next scan, at most.
        self._ahead = BLOCKS

    def resume(self) -> None:
        """Go on at the first line that was not run."""
        self._parts.control.calls.give_up()
        self._here = self.reached

    def run(self) -> Iterator[None]:
        """Run until the program or its text ends; yields now and then, so that rows can be taken away.

        Raises:
            Astray: The program can never go on: a round has changed nothing, or a fault keeps a loop from ending.
        """
        parts, ip, pending = self._parts, self._parts.ip, self._parts.pending
        while not ip.state.ended:
            here = self._here
            forward = self._is_forward(here)
            if forward:
                self.reached = here
            if here.offset >= len(parts.sources[here.source]):
                self._end_text(here)
                return
            if forward and not (pending.count or self._branched or parts.by_line):
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

    def _is_forward(self, here: Cursor) -> bool:
        """Tell whether a line of the main program is reached for the first time."""
        return here.source == 0 and here.offset >= self.reached.offset and not self._frames

    def _end_text(self, here: Cursor) -> None:
        """End the main program at the end of its text; a subroutine is not finished there."""
        self._parts.pending.flush()
        if self._frames:
            name = self._parts.sources[here.source].name
            message = f"{name} ends within a subroutine"
            raise Astray(BlockError("sub-unfinished", message, hint="ENDSUB or M99?"))
        if here.source:
            self._parts.ip.state.ended = True

    def _scan(self, here: Cursor) -> int:
        """Run plain blocks; return why the scanner stopped, FULL where they lead elsewhere."""
        parts = self._parts
        self.reached, why = parts.pending.scan(here, self._ahead)
        parts.ip.budget.forward = self.reached.line
        self._since = 0
        if parts.pending.has_words():
            parts.percent.seen = True
        place = parts.pending.run()
        self._ahead = min(2 * self._ahead, BLOCKS) if place is None else FEW_BLOCKS
        if place is not None:
            # The text goes on behind the jump, wherever the scanner was.
            self.reached = parts.lines.after(place)
            why = gcode_scan.FULL
        self._here = self.reached
        if place is not None:
            try:
                self._here = parts.control.follow_jump(place, self.reached) or self.reached
            except BlockError as error:
                parts.faults.fail(place, error)
        return why

    def _compute(self, here: Cursor) -> bool:
        """Read on lines that are computed while they are read; tell whether there was one."""
        # A line of % is left at once: many programs have no other one that is not plain.
        percent = self._parts.sources[here.source].data[here.offset] == ord("%")
        found = None if percent else self._parts.pending.compute(here, self.reached, self._since)
        if found is None:
            return False
        if found.reached != self.reached:
            self._begun = self._parts.ip.budget.steps
            self._parts.percent.seen = True
        self.reached, self._since, self._here = found.reached, found.since, found.end
        if found.back is not None:
            self._look(found.back, found.end)
        return True

    def _run_line(self, here: Cursor) -> None:
        """Run a line that is neither plain nor computed; the line that it leads to is next."""
        parts = self._parts
        following = here
        try:
            if parts.pending.count and self._is_forward(here) and "o" not in parts.lines.text(here).lower():
                # No O-word: from here on the scanner may go on, and it writes over blocks that wait.
                parts.pending.flush()
                self._branched = False
                return
            following, text = parts.lines.after(here), parts.lines.text(here)
            parsed = self._read(text)
            self._branched = parsed.is_o_word
            if self._is_forward(here):
                self.reached = following
                self._since, self._begun = 0, parts.ip.budget.steps
                parts.ip.budget.forward = following.line
                parts.ip.base.block = empty_block(here)
            else:
                self._since += 1
            parts.ip.budget.count(1, LINE)
            target = following
            if not text.lstrip().startswith("%"):
                target = parts.line_runner().run(parsed, here, following) or following
            elif here.source == 0:
                parts.percent.line(text, self.reached.offset)
        except BlockError as error:
            following = target = parts.lines.after(here)
            parts.faults.fail(here, error)
        self._here = target
        if self._since >= PAUSE and target <= here:
            self._look(here, target)

    def _look(self, here: Cursor, back: Cursor) -> None:
        """Raise where a jump back finds everything as it was at the last one: the loop is endless."""
        parts = self._parts
        self._since, self._looked = 0, True
        parts.pending.flush()
        if self._recurrence is None:
            from cncgen.gcode.flow.recurrence import Recurrence

            self._recurrence = Recurrence(parts.ip, parts.faults, lambda: parts.control.calls.records)
        self._recurrence.look(here, back, self._begun)

    def _read(self, text: str) -> Parsed:
        """Return the block of a line; none of a line of % or an empty one."""
        parts, bare = self._parts, text.strip()
        if bare.startswith("%"):
            return Parsed()
        parts.percent.seen = True
        return parts.lines.parse(text) if bare else Parsed()
