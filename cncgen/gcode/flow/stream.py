"""The main program in the order of its text, as long as it goes forward.

Runs of plain blocks are scanned into columns, lines with expressions are computed while they are read, and any other line is
parsed and run by itself. Where a line leads back or into a subroutine, `walking` takes over.
"""

from __future__ import annotations

from cncgen.gcode.block import Block, Flow
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow import sub_words
from cncgen.gcode.flow.parts import Parts
from cncgen.gcode.flow.reading import behind_leader
from cncgen.gcode.text.labels import Cursor
from cncgen.kernels import gcode_scan


class Stream:
    """The main program from its first line on.

    Attributes:
        reached: The first line that was not run.
        exhausted: Whether the text has ended.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._source = parts.sources[0]
        self.reached = behind_leader(parts.ip, self._source)
        self.exhausted = False
        #: Whether the last line was an O-word: few plain blocks are likely to follow.
        self._branched = False

    def advance(self) -> Cursor | None:
        """Run some lines; return where they lead back or away, None where the stream goes on at `reached`."""
        ip, pending = self._parts.ip, self._parts.pending
        while pending.count or self._branched:
            # The scanner would write over the pending blocks.
            target = self._go_on()
            if target is not None or ip.state.ended:
                return target
        why, target = self._scan()
        if target is not None or ip.state.ended:
            return target
        self.exhausted = why == gcode_scan.END
        if why == gcode_scan.OTHER and not self._compute():
            return self._run_line()
        return None

    def _scan(self) -> tuple[int, Cursor | None]:
        """Run plain blocks; return why the scanner stopped, and where they lead, None for the line where it did."""
        parts = self._parts
        if parts.by_line:
            return (gcode_scan.OTHER if self.reached.offset < len(self._source) else gcode_scan.END), None
        self.reached, why = parts.pending.scan(self.reached)
        parts.ip.budget.forward = self.reached.line
        if parts.pending.has_words():
            parts.percent.seen = True
        here = parts.pending.run()
        if here is None:
            return why, None
        # The text goes on behind the jump, wherever the scanner was.
        self.reached = parts.lines.after(here)
        try:
            return gcode_scan.FULL, sub_words.follow_jump(parts.control, here, self.reached)
        except BlockError as error:
            parts.faults.fail(here, error)
            return gcode_scan.FULL, None

    def _compute(self) -> bool:
        """Read on lines that are computed while they are read; tell whether there was one."""
        parts, here = self._parts, self.reached
        self.reached, blocks = parts.pending.compute(here)
        if self.reached is here:
            return False
        parts.ip.budget.forward = self.reached.line
        parts.percent.seen = True
        parts.ip.budget.count(self.reached.line - here.line - blocks)
        return True

    def _go_on(self) -> Cursor | None:
        """Read on lines that are computed, and run the O-word that ends them; if none does, run the pending blocks."""
        self._compute()
        found = self._parts.pending.flow(self.reached)
        if found is not None:
            return self._run_o_word(*found, self.reached)
        self._parts.pending.flush()
        self._branched = False
        return None

    def _run_line(self) -> Cursor | None:
        """Run a line that is neither plain nor computed while it is read; return where it leads, None for the next line."""
        parts, here = self._parts, self.reached
        found = parts.pending.flow(here)
        if found is not None:
            return self._run_o_word(*found, here)
        self.reached = after = parts.lines.after(here)
        parts.ip.budget.forward = after.line
        parts.ip.base.block = Block({}, line=here.line, offset=here.offset)
        try:
            text = parts.lines.text(here)
            if text.lstrip().startswith("%"):
                parts.percent.line(text, after.offset)
                return None
            parts.percent.seen = True
            parts.ip.budget.count(1)
            parsed = parts.lines.parse(text)
            if parsed.deletable and parts.ip.options.block_delete:
                return None
            if parsed.flow is not None:
                return self._run_flow(parsed.flow, here, after)
            parts.compiler.action(parsed, here)()
            if parts.ip.jump is not None:
                return sub_words.follow_jump(parts.control, here, after)
        except BlockError as error:
            parts.faults.fail(here, error)
        return None

    def _run_o_word(self, flow: Flow, after: Cursor, here: Cursor) -> Cursor | None:
        """Run an O-word whose values are computed; as `_run_line`."""
        parts = self._parts
        self.reached = after
        parts.ip.budget.forward = after.line
        parts.percent.seen = self._branched = True
        parts.ip.base.block = Block({}, line=here.line, offset=here.offset)
        try:
            parts.ip.budget.count(1)
            return self._run_flow(flow, here, after)
        except BlockError as error:
            parts.faults.fail(here, error)
        return None

    def _run_flow(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Run an O-word, or IF [...] THEN ...; return where it leads, None for the next line."""
        parts = self._parts
        if flow.then is not None:
            parts.compiler.then(flow, here)()
            return sub_words.follow_jump(parts.control, here, after) if parts.ip.jump is not None else None
        target = parts.control.run(flow, here, after)
        if (
            target is not None
            and not parts.control.calls.frames
            and target.source == 0
            and target.offset >= after.offset
        ):
            # Forward within the main program: go on as a stream from there.
            self.reached = target
            return None
        return target
