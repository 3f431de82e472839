"""Lines that are computed while they are read, by the kernel `gcode_run`: values, settings, and O-words that it can follow.

Blocks go to the columns of plain blocks and wait there: motions do not change parameters, so reading goes on, also over loops and
calls, until the position of the machine is needed (then `flow.pending` runs them).
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial

from cncgen.gcode.budget import PAUSE
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.source import Source
from cncgen.gcode.state.predefined import NAMED
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import PlainBlocks
from cncgen.gcode.text.parsers import STORED, new_parser
from cncgen.kernels import gcode_run
from cncgen.kernels.gcode_codes import LITERALS
from cncgen.kernels.gcode_store import Store
from cncgen.records import dataclass

_RESERVED = frozenset(NAMED)


@dataclass(frozen=True, slots=True)
class LinesRead:
    """Lines that were read.

    Attributes:
        end: The first line not read.
        reached, since: As `Computing.read` takes them, afterwards.
        others: How many lines made no block.
        units: Units of work of the calls among them.
        back: The O-word whose jump back was the last of them, where it is time to look at it.
        passed: Lines of the main program that jumps led past when they were reached: the first, and the offset of the one behind them.
    """

    end: Cursor
    reached: Cursor
    since: int
    others: int
    units: int
    back: Cursor | None
    passed: list[tuple[Cursor, int]]


class Computing:
    """The sources' texts under the kernel, all on the columns `plain`."""

    def __init__(self, control: FlowControl, sources: list[Source], plain: PlainBlocks) -> None:
        self._control = control
        self._parameters = control.ip.parameters
        self._sources = sources
        self._plain = plain
        self._computers: dict[int, gcode_run.Computer] = {}

    def _computer(self, source: int) -> gcode_run.Computer:
        computer = self._computers.get(source)
        if computer is None:
            parameters, dialect = self._parameters, self._control.ip.dialect
            meant, leads = None, None
            if dialect == "fanuc":
                from cncgen.gcode.text.expressions import FANUC

                meant = FANUC.replaced
                leads = partial(self._leads, source)
            computer = self._computers[source] = gcode_run.Computer(
                self._sources[source].bytes, new_parser(dialect),
                Store(parameters.numbers, parameters.named, _RESERVED, STORED[dialect]),
                self._plain.columns(), self._waits, PAUSE, meant, self._control.calls.frames, leads,
                partial(self._begins, source),
            )  # fmt: skip
            control = self._control
            # Texts without O-words have no use for the module of subroutines.
            computer.follow(
                (lambda: control.subroutines.labels(source).lines) if dialect == "linuxcnc" else None,
                control.calls.outermost, control.ip.options.max_call_depth, source,
            )  # fmt: skip
        return computer

    def _leads(
        self, source: int, offset: int, line: int, keyword: int, value: float
    ) -> tuple[int, int] | None:
        """Return offset and number of the line that a jump or loop of a macro leads to; None where its line has something to tell."""
        from cncgen.gcode.flow import macros

        with suppress(BlockError):
            here = Cursor(source, offset, line)
            target = macros.target_of(self._control, keyword, value, here)
            if keyword != LITERALS["goto"] or not macros.tells(self._control, here, target):
                return target.offset, target.line
        return None

    def _begins(self, source: int, offset: int, line: int, number: float) -> Cursor | None:
        """Return where the program of a number begins that a line calls; None where its line tells, or looks for it anew each time."""
        subroutines = self._control.subroutines
        with suppress(BlockError):
            found = subroutines.find(number, Cursor(source, offset, line), ("program", "sub"))
            if found.keyword == "program" and not subroutines.labels(source).computes:
                return found.cursor
        return None

    def _waits(self, letter: str, number: int) -> bool:
        """Tell whether a block with a code may wait."""
        code = self._control.ip.codes.get((letter, 10 * number))
        return code is not None and code.waits

    def read(self, here: Cursor, reached: Cursor, since: int) -> LinesRead | None:
        """Read on from a line, its source that of the blocks that wait, if any; None if it is not read here.

        `reached` is the first line of the main program that was not reached, `since` how many lines ago that was.
        """
        computer, plain = self._computer(here.source), self._plain
        before = computer.blocks = plain.count
        computer.since = since
        ip = self._control.ip
        # Calls do not tell what a line hands on to the next one.
        computer.calls = not (ip.lathe or ip.guard or ip.skipping or ip.rewrite)
        if here.source == 0:
            computer.reached, computer.reached_line = reached.offset, reached.line
        offset = computer.run(here.offset, here.line, self._parameters.local)
        self._parameters.local = computer.local
        plain.count, plain.source = computer.blocks, here.source
        if not computer.lines:
            return None
        skipped, computer.skipped = computer.skipped, []
        if here.source == 0:
            reached = Cursor(0, computer.reached, computer.reached_line)
        return LinesRead(
            Cursor(here.source, offset, computer.line) if computer.away is None else Cursor(*computer.away),
            reached,
            computer.since,
            computer.lines - plain.count + before,
            computer.units,
            None if computer.back is None else Cursor(here.source, *computer.back),
            [(Cursor(0, first, line), behind) for first, line, behind in skipped if here.source == 0],
        )
