"""Plain lines of SINUMERIK and of Heidenhain's plain language in arrays: as the blocks of G-code, they go through `Batches`."""

from __future__ import annotations

from bisect import bisect_left

from cncgen.gcode.flow.batches import Batches, Made
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block
from cncgen.gcode.text.line_runs import PlainScan

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    class _Runs(Protocol):
        """The lines of a program, as far as they tell of runs of plain ones."""

        def plain_at(self, at: int) -> tuple[Cursor, int] | None:
            """Return the place of a plain line, and how many begin with it."""


_NO_CYCLES: frozenset[int] = frozenset()


class PlainLane:
    """Runs of plain lines, and the columns that they are read into.

    Args:
        ip: The interpreter.
        sources: The texts of the run.
        name: The grammar's.
        made: Takes the motions that were made.

    Attributes:
        taken: How many lines with words went through arrays.
    """

    def __init__(self, ip: Interpreter, sources: list[Source], name: str, made: Made) -> None:
        self._ip, self._sources = ip, sources
        self._scan = PlainScan(name)
        self._batches = Batches(ip, self._scan.blocks, made)
        #: The columns: of which program, up to which line, the next block, where the run of the first line begins, the tool's feed.
        self._lines: _Runs | None = None
        self._next = self._after = self._index = self._first = 0
        self._auto = 0.0
        self.taken = 0

    def run(self, lines: _Runs, at: int, most: int, auto: float = 0.0) -> int:
        """Run plain lines from one on; return the first that was not run.

        Args:
            lines: The program.
            at: The line.
            most: Lines that are run at most.
            auto: The feed of the tool in force.
        """
        ip, blocks = self._ip, self._scan.blocks
        known = self._lines is lines and self._next <= at < self._after and self._auto == auto
        if not known and not self._read(lines, at, auto):
            return at
        if most < 1 or not ip.batchable(_NO_CYCLES):
            return at
        # The number of the line as the columns have it.
        count, number = blocks.count, self._first + at
        index = bisect_left(blocks.line, number, self._index, count)
        if at + most < self._after:
            count = bisect_left(blocks.line, number + most, index, count)
        done = self._batches.run(index, count) if index < count else index
        self._index = done
        self.taken += done - index
        if done < count:
            self._next = blocks.line[done] - self._first
        else:
            self._next = min(self._after, at + most)
        if self._next > at:
            ip.base.block = empty_block(blocks.cursor(done - 1)) if done else ip.base.block
            ip.budget.count(self._next - at)
        return self._next

    def _read(self, lines: _Runs, at: int, auto: float) -> bool:
        """Read the columns from a line on; tell whether it is one of a run."""
        found = lines.plain_at(at)
        if found is None:
            return False
        here, left = found
        read, _ = self._scan.read(self._sources[here.source], here, left, auto)
        self._lines, self._auto = lines, auto
        self._next, self._after, self._index, self._first = at, at + read, 0, here.line - at
        return read > 0
