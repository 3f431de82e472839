"""Runs of lines of SINUMERIK and of Heidenhain's plain language: the kernel `gcode_run` computes them, and `Batches` makes the motions."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Container
from typing import Any

from cncgen.gcode.budget import PAUSE
from cncgen.gcode.flow.batches import Batches, Made
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import PlainBlocks, empty_block
from cncgen.gcode.text.line_runs import PARAMETERS, ProgramLines, code_of
from cncgen.kernels.gcode_run import Computer
from cncgen.kernels.language_store import LanguageStore

TYPE_CHECKING = False
if TYPE_CHECKING:
    _Runs = ProgramLines[Any]


#: M codes that precede the motion of their block, by the language: M5 and M9 follow it in Heidenhain's.
_M_CODES = {"heidenhain": (3, 4, 7, 8), "sinumerik": (3, 4, 5, 7, 8, 9)}
NO_CYCLES: frozenset[int] = frozenset()
#: Returns the line to which a line leads, None where that is not certain; and what `LanguageStore.lead` takes.
Lead = Callable[[int], int | None]
Leads = Callable[[int], tuple[int, int, int, int] | None]
Call = Callable[[int, int], dict[int, float] | None]
Leave = Callable[[], tuple[tuple[int, int, int, int], dict[int, float]] | None]


class PlainLane:
    """Runs of lines, and the columns that they are read into.

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
        self.blocks = PlainBlocks()
        self._batches = Batches(ip, self.blocks, made)
        #: The program whose blocks stand in the columns.
        self._lines: _Runs | None = None
        self.taken = 0

    def run(self, lines: _Runs, at: int, most: int) -> int:
        """Run lines of a run from one on, whose blocks wait then; return the first that was not run.

        Args:
            lines: The program.
            at: The line.
            most: Lines that are run at most.
        """
        found = lines.run_at(at)
        count = self._compute(lines, found[0], min(found[1], most)) if found is not None else 0
        self.ran, self._open = at + count - 1, 0
        return at + count

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
            self.ran = lines.index_of(computer.ran_line)
            at = lines.index_of(computer.line)
            self._open = self._hangs
        computer.language.lead(None, None, {})
        self.reached = lines.index_of(computer.reached_line) if computer.reached_line else reached
        return at

    def _computer(self, source: int) -> Computer:
        computer = self._computers.get(source)
        if computer is None:
            code = code_of(self._name)
            code.follow()
            computer = self._computers[source] = Computer(
                self._sources[source].bytes, code, LanguageStore(self._numbers, PARAMETERS[self._name], self._scopes),
                self.blocks.columns(), _waiting(_M_CODES[self._name]), PAUSE,
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


def _waiting(m_codes: tuple[int, ...]) -> Callable[[str, int], bool]:
    """Return what tells whether a block with a code may wait: motions, spindle and coolant."""
    return lambda letter, number: number in ((0, 1, 2, 3) if letter == "G" else m_codes)
