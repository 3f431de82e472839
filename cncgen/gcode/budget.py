"""The work that one run of a program may do: blocks, calls and canonical motions are counted where they are made.

A unit is the cost of a plain block of LinuxCNC's dialect in a loop, about a microsecond. More expensive work counts more, by measured
times, so the bound is one of time in every dialect.
"""

from __future__ import annotations

from cncgen.gcode.errors import BlockError, Stop

#: Lines after which a jump back ends a run, so that rows are taken away and endless loops seen.
PAUSE = 1024

#: Units that a run may do where the options do not say, beside those of its lines.
MOST_WORK = 5_000_000
#: Units that each line of the main program may do beside them: a long program is not an endless one.
WORK_OF_A_LINE = 200
#: Units that each line of SINUMERIK or Heidenhain that moves may do beside them, run by itself, and of how many such lines: a curve that
#: a loop computes has hundreds of thousands of points, each with lines of arithmetic and calls.
WORK_OF_A_MOVE, MOST_MOVES = 60, 250_000
#: Units of a step that the options allow.
WORK_OF_A_STEP = 40
#: Units of a call of a subprogram, of a canonical call that is made by itself, of a block that goes through its handlers (all of
#: SINUMERIK and Heidenhain), and of a run of plain motions, however short, that goes on in arrays.
CALL, MOTION, LINE, BATCH = 4, 8, 12, 36
#: Units of handing motions on as arrays, however few (arcs among them take four times as long), and of an event between motions.
ARRAYS, EVENT = 70, 20
#: Units of a frame that turns, and of each try of a corner that does not fit.
FRAME, CORNER = 30, 8


class Budget:
    """Counts blocks and work, and stops the run that does more than it may.

    Args:
        most: Blocks that may be executed, or None where work alone is bounded.

    Attributes:
        steps: Blocks executed so far.
        work: Units done so far.
        forward: Lines of the main program that were reached.
        moves: Lines of SINUMERIK or Heidenhain, run by themselves, that moved.
    """

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._most_work = max(MOST_WORK, WORK_OF_A_STEP * (most or 0))
        self.steps = 0
        self.work = 0
        self.forward = 0
        self.moves = 0

    def left(self) -> int:
        """Return how many blocks the run may execute from now on."""
        return (1 << 62) if self._most is None else max(self._most - self.steps, 0)

    def count(self, blocks: int, units: int = 1) -> None:
        """Count blocks, each of so many units; raise Stop where they are more than the run may execute."""
        self.steps += blocks
        if self._most is not None and self.steps > self._most:
            raise _endless(f"more than {self._most} blocks were executed")
        self.spend(blocks * units)

    def add(self, units: int) -> None:
        """Count work where a run cannot stop; the next that is counted before it is done stops it."""
        self.work += units

    def spend(self, units: int) -> None:
        """Count work before it is done; raise Stop where it is more than the run may do."""
        self.work += units
        bound = self._most_work + WORK_OF_A_LINE * self.forward + WORK_OF_A_MOVE * min(self.moves, MOST_MOVES)
        if self.work > bound:
            raise _endless(
                f"more than {bound} units of work (a plain block is 1, a motion of a cycle {MOTION})"
            )


def _endless(message: str) -> Stop:
    fault = f"{message}: the program counts as endless"
    return Stop(BlockError("too-many-steps", fault, hint="--max-steps sets the bound"))
