"""Plain lines of SINUMERIK and of Heidenhain's plain language in arrays: as the blocks of G-code, they go through `Batches`."""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Callable, Container
from typing import Any

from cncgen.gcode.budget import PAUSE
from cncgen.gcode.flow.batches import Batches, Made
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block
from cncgen.gcode.text.line_runs import PARAMETERS, PlainScan, code_of
from cncgen.kernels.gcode_run import Computer
from cncgen.kernels.language_store import LanguageStore

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    class _Runs(Protocol):
        """The lines of a program, as far as they tell of runs of plain ones."""

        def __len__(self) -> int:
            """Return how many they are."""

        def plain_at(self, at: int) -> tuple[Cursor, int, bool] | None:
            """Return the place of a line of a run, how many begin with it, and whether these compute."""

        def place(self, at: int) -> Cursor:
            """Return the place of a line."""

        def index_of(self, number: int) -> int:
            """Return the line of a number in the text."""


NO_CYCLES: frozenset[int] = frozenset()
#: Returns the line to which a line leads, None where that is not certain; and what `LanguageStore.lead` takes.
Lead = Callable[[int], int | None]
Leads = Callable[[int], tuple[int, int, int, int] | None]
Call = Callable[[int, int], dict[int, float] | None]
Leave = Callable[[], tuple[tuple[int, int, int, int], dict[int, float]] | None]


class PlainLane:
    """Runs of plain lines, and the columns that they are read into.

    Args:
        ip: The interpreter.
        sources: The texts of the run.
        name: The grammar's.
        made: Takes the motions that were made.
        numbers: The values of R or Q parameters.
        scopes: The variables of the programs in progress.
        hangs: Whether the end of a motion may hang on the line behind it.

    Attributes:
        taken: How many lines with words went through arrays.
        blocks: The blocks of lines that were computed and wait, from `waiting` on.
        waiting: The next of them, -1 for none.
        last: The last line that was computed, and its index, `ran`.
        reached: The first line that was never reached, behind those that were computed.
    """

    def __init__(
        self,
        ip: Interpreter,
        sources: list[Source],
        name: str,
        made: Made,
        numbers: array[float],
        scopes: list[dict[str, Any]],
        *,
        hangs: bool,
    ) -> None:
        self._ip, self._sources = ip, sources
        self._name, self._numbers = name, numbers
        self._scopes, self._hangs = scopes, hangs
        self._computers: dict[int, Computer] = {}
        self._leads: dict[int, Leads] = {}
        self.ran = self.reached = 0
        #: How many of the last blocks hang on the lines behind them.
        self._open = 0
        self.waiting = -1
        self.last = Cursor(0, 0, 1)
        self._scan = PlainScan(name)
        self.blocks = self._scan.blocks
        self._batches = Batches(ip, self.blocks, made)
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
        ip, blocks = self._ip, self.blocks
        found = lines.plain_at(at)
        if found is not None and found[2]:
            count = self._compute(lines, found[0], min(found[1], most))
            self.ran, self._open = at + count - 1, 0
            return at + count
        known = self._lines is lines and self._next <= at < self._after and self._auto == auto
        if not known and not self._read(lines, at, auto):
            return at
        if most < 1 or not ip.batchable(NO_CYCLES):
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
        here, left, _ = found
        read, _ = self._scan.read(self._sources[here.source], here, left, auto)
        self._lines, self._auto = lines, auto
        self._next, self._after, self._index, self._first = at, at + read, 0, here.line - at
        return read > 0

    # Lines with parameters and arithmetic.

    def follow(
        self,
        lines: _Runs,
        at: int,
        apart: Container[int],
        lead: Lead,
        enters: Callable[[int], None],
        loops: dict[int, float],
        calls: tuple[Call, Leave],
        reached: int,
        since: int,
    ) -> int:
        """Run lines from one on that was run before, wherever their jumps lead; return the first that was not run.

        Args:
            lines: The program.
            at: The line.
            apart: Lines that are run by themselves, whatever leads to them.
            lead: Returns the line to which a line leads, None where that is not certain.
            enters: Takes a line that was jumped to.
            loops: The loops in progress.
            calls: Begin and end a call of lines of the program.
            reached: The first line that was never reached.
            since: Lines that were run since a look at the state.
        """
        here = lines.place(at)
        leads = self._leads.get(id(lines))
        if leads is None:
            leads = self._leads[id(lines)] = _leads(lines, lead, apart)
        computer = self._computer(here.source)
        computer.language.lead(leads, enters, loops, *calls)
        computer.reached = lines.place(reached).offset if reached < len(lines) else 1 << 60
        computer.reached_line, computer.since = 0, since
        if self._compute(lines, here, self._ip.budget.left()):
            self.ran, at, self._open = (
                lines.index_of(computer.ran_line),
                lines.index_of(computer.line),
                self._hangs,
            )
        computer.language.lead(None, None, {})
        self.reached = lines.index_of(computer.reached_line) if computer.reached_line else reached
        return at

    def _computer(self, source: int) -> Computer:
        computer = self._computers.get(source)
        if computer is None:
            computer = self._computers[source] = Computer(
                self._sources[source].bytes, code_of(self._name), self._numbers, {}, frozenset(), self.blocks.columns(), _waits,
                PAUSE, LanguageStore(self._numbers, PARAMETERS[self._name], self._scopes),
            )  # fmt: skip
        return computer

    def _compute(self, lines: _Runs, here: Cursor, most: int) -> int:
        """Run so many lines at most, whose blocks wait then; return how many were run."""
        if most < 1 or not self._ip.batchable(NO_CYCLES):
            return 0
        computer = self._computer(here.source)
        computer.blocks = 0
        computer.run(here.offset, here.line, {}, most)
        self._lines = lines
        # The columns are no longer those of plain lines.
        self._next = self._after = 0
        self.blocks.count, self.blocks.source = computer.blocks, here.source
        self.waiting = 0 if computer.blocks else -1
        if computer.lines:
            self.last = Cursor(here.source, computer.ran, computer.ran_line)
            self._ip.base.block = empty_block(self.last)
            self._ip.budget.count(computer.lines)
        return int(computer.lines)

    def go_on(self) -> int:
        """Run blocks that wait; return the first that arrays do not take, whose place is no longer one that waits, -1 for none."""
        begin, count = self.waiting, self.blocks.count
        last = count - self._open
        index = self._batches.run(begin, last) if begin < last and self._ip.batchable(NO_CYCLES) else begin
        self.taken += index - begin
        # Behind the last one nothing waits, but where the run ended is still to be taken up.
        self.waiting = index + 1 if index < count else -1
        return index if index < count else -1

    def line_of(self, index: int) -> int:
        """Return the line of a block that waits."""
        assert self._lines is not None
        return self._lines.index_of(self.blocks.line[index])


def _leads(lines: _Runs, lead: Lead, apart: Container[int]) -> Leads:
    """Return what tells, by the number of a line with a jump, its index, and index, offset and number of the line that it leads to.

    Lines that stand `apart` are none that it may lead to.
    """

    def leads(number: int) -> tuple[int, int, int, int] | None:
        at = lines.index_of(number)
        target = lead(at)
        if target is None or target >= len(lines) or target in apart:
            return None
        place = lines.place(target)
        return at, target, place.offset, place.line

    return leads


def _waits(letter: str, number: int) -> bool:
    """Tell whether a block with a code may wait: motions, spindle and coolant."""
    return number in ((0, 1, 2, 3) if letter == "G" else (3, 4, 5, 7, 8, 9))
