"""Plain blocks that were read and have not run yet: those of a scan, and those of lines that are computed while they are read.

The latter are collected, over loops and calls, until the position of the machine is needed (`PendingBlocks.flush`). This is allowed
because motions do not change the parameters of later lines.
"""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.budget import LINE
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.batches import Batches
from cncgen.gcode.flow.executing import Executor
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import BLOCKS, PlainBlocks, comment_of, empty_block
from cncgen.kernels import gcode_scan

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.computing import Computing, LinesRead
    from cncgen.gcode.flow.line_by_line import LineRunner
    from cncgen.gcode.flow.o_words import FlowControl


class PendingBlocks:
    """The columns of plain blocks, and the objects that fill and run them.

    Without `batches` every block goes through its handlers one by one. `computes` tells whether the kernel `gcode_run` knows the dialect.
    """

    def __init__(
        self,
        control: FlowControl,
        sources: list[Source],
        line_runner: Callable[[], LineRunner],
        executor: Executor,
        faults: Faults,
        *,
        batches: bool,
        computes: bool,
    ) -> None:
        self._control, self._ip = control, control.ip
        self._sources = sources
        self._line_runner = line_runner
        self._executor = executor
        self._faults = faults
        self._plain = PlainBlocks()
        self._batches = Batches(self._ip, self._plain) if batches else None
        self._computes = batches and computes
        self._computing: Computing | None = None

    @property
    def count(self) -> int:
        """How many blocks are pending."""
        return self._plain.count

    def scan(self, here: Cursor, most: int) -> tuple[Cursor, int, bool]:
        """Read plain blocks from a line on, in place of those that stand here; as `PlainBlocks.scan`, and whether one has a word."""
        plain = self._plain
        after, why = plain.scan(self._sources[here.source], here, most)
        return after, why, plain.count > 0 and plain.word_end[plain.count - 1] > 0

    def compute(self, here: Cursor, reached: Cursor, since: int) -> LinesRead | None:
        """Read on, from a line, lines that are computed, as `Computing.read`; None for other lines."""
        if not self._computes or self._ip.modal_macros:
            # A macro that a motion calls may set parameters.
            return None
        if self._computing is None:
            # Most programs have no line that is computed.
            from cncgen.gcode.flow.computing import Computing

            self._computing = Computing(self._control, self._sources, self._plain)
        plain = self._plain
        if plain.count and (plain.source != here.source or plain.count == BLOCKS):
            self.flush()
        found = self._computing.read(here, reached, since)
        if found is not None:
            self._ip.budget.forward = found.reached.line
            if found.back is not None:
                self._ip.base.block = empty_block(found.back)
            self._ip.budget.count(found.others)
            self._ip.budget.spend(found.units)
        return found

    def flush(self) -> None:
        """Run the pending blocks."""
        if self._plain.count:
            self.run()

    def run(self) -> Cursor | None:
        """Run the pending blocks: in arrays where they are plain motions, else one by one.

        A block that asks for a jump ends the run: its place is returned, and the pending blocks after it are dropped.
        """
        plain, ip = self._plain, self._ip
        count, plain.count = plain.count, 0
        index = 0
        while index < count and not ip.state.ended:
            done = self._batches.run(index, count) if self._batches else index
            if done == count:
                self._ip.budget.count(count - index)
                break
            here = plain.cursor(done)
            self._run_one(done, here)
            self._ip.budget.count(done - index)
            self._ip.budget.count(1, LINE)
            if ip.jump is not None:
                return here
            index = done + 1
        return None

    def _run_one(self, index: int, here: Cursor) -> None:
        plain, ip = self._plain, self._ip
        flags = plain.flags[index]
        if flags & gcode_scan.SLASH and ip.options.block_delete:
            return
        try:
            comment = None
            if flags & gcode_scan.ACTIVE or (flags & gcode_scan.COMMENT and ip.base.wants_comments):
                comment = comment_of(self._sources[here.source].text_at(here.offset))
            twice: list[str] | None = None
            if ip.dialect == "fanuc":
                if self._line_runner().call_macro(plain.pairs(index), here):
                    return
                twice = []
            block = plain.block(index, twice)
            if twice:
                self._line_runner().tell_twice(block, twice)
            block.comment = comment
            self._executor.execute(block)
        except BlockError as error:
            self._faults.fail(here, error)
