"""Runs of blocks in columns: the interpreter's state into the kernel `gcode_motion`, its motions and asides to the sink."""

from __future__ import annotations

from array import array
from collections.abc import Callable

from cncgen.gcode.block import AXES
from cncgen.gcode.budget import BATCH, CALL, MOTION
from cncgen.gcode.codes.feeds import feeds_meant
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.counting import CountingSink
from cncgen.gcode.sinks.sink import (
    CENTRE_FACTOR,
    CENTRE_RELATIVE,
    CENTRE_TOLERANCE,
    RADIUS_TOLERANCE,
    MotionBatch,
)
from cncgen.gcode.state.modal import NO_MOTION, SYSTEM_CODES
from cncgen.gcode.text.lanes import BLOCKS, PlainBlocks, column, empty_block
from cncgen.kernels import gcode_codes, gcode_motion
from cncgen.toolpath.record import PathMode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.codes.canned_cycles import Sticky

_BITS = {"r": gcode_codes.GIVEN_R, "p": gcode_codes.GIVEN_P, "q": gcode_codes.GIVEN_Q}

#: Asides that are a word, and the code whose handler takes it.
_OF_A_WORD = {
    gcode_codes.ASIDE_SPEED: ("s", ("S", 0)),
    gcode_codes.ASIDE_TOOL: ("t", ("T", 0)),
    gcode_codes.ASIDE_DWELL: ("p", ("G", 40)),
}
#: Called with motions that were made: where they began, and their columns of motions, ends and centres.
Made = Callable[[list[float], memoryview, memoryview, memoryview], None]


class Batches:
    """The kernel on the columns of plain blocks, and work columns of its own, used again for each run; `made` hears of motions."""

    def __init__(self, ip: Interpreter, plain: PlainBlocks, made: Made | None = None) -> None:
        self._ip = ip
        self._made = made
        self._plain = plain
        self._position = array("d", [0.0] * 9)
        self._modes = array("q", [0] * gcode_codes.MODES)
        self._levels = array("d", [0.0] * gcode_codes.LEVELS)
        # No cycle is taken before the words of the one in force are known.
        self._modes[gcode_codes.CYCLE] = -1
        self._line = column("q", BLOCKS)
        self._offset = column("q", BLOCKS)
        self._motion = column("b", BLOCKS)
        self._end = column("d", BLOCKS, 9)
        self._feed = column("d", BLOCKS)
        self._feed_set = column("B", BLOCKS)
        self._centre = column("d", BLOCKS, 2)
        self._turns = column("q", BLOCKS)
        motions = (
            *(self._line, self._offset, self._motion, self._end),
            *(self._feed, self._feed_set, self._centre, self._turns),
        )
        self._asides = tuple(column(kind, BLOCKS) for kind in "qqdq")
        self._kernel = gcode_motion.Advance(
            plain.columns(), self._position, self._modes, self._levels, motions, self._asides
        )
        #: The cycle in force that the kernel knows of, and plane and units then; the numbers of the cycles that it takes.
        self._cycle: Sticky | None = None
        self._under = 17, False
        self._cycles: frozenset[int] = frozenset()

    def run(self, index: int, count: int) -> int:
        """Run blocks from one on; return the first block that was not taken."""
        ip, state, kernel = self._ip, self._ip.state, self._kernel
        while index < count and ip.batchable(self._cycles):
            self._position[:] = array("d", state.position)
            self._give_modes()
            index = kernel.run(index, count)
            if kernel.rows or kernel.asides:
                ip.budget.spend(BATCH + MOTION * kernel.drilled)
                self._hand_on()
                if self._made is not None and kernel.rows:
                    rows = kernel.rows
                    self._made(state.position, self._motion[:rows], self._end[:rows], self._centre[:rows])
                state.position = self._position.tolist()
                state.moved = state.moved or kernel.rows > 0
            self._take_modes()
            if not kernel.full:
                break
        return index

    def _give_modes(self) -> None:
        """Return the initial state for the kernel: modes, feed and the tolerances of arcs."""
        ip, state, inches = self._ip, self._ip.state, self._ip.state.inches
        if state.cycle is not self._cycle or (self._cycles and self._under != (state.plane, inches)):
            self._give_cycle()
        modes = (
            -1 if state.motion == NO_MOTION else state.motion // 10,
            state.absolute,
            state.arc_absolute,
            state.plane,
            state.feed_mode == 93,
            ip.options.block_delete,
            not ip.sink.wants_comments,
            state.feed_mode != 95 and state.constant_surface is None,
            ip.dialect == "linuxcnc",
            state.cycle is not None,
            state.direction,
            state.mist,
            state.flood,
            state.retract_old,
            state.path_mode is PathMode.EXACT_PATH,
            ip.dialect == "linuxcnc" and not ip.tools_given,
        )
        self._modes[: gcode_codes.CYCLE] = array("q", modes)
        levels = (
            state.feed,
            RADIUS_TOLERANCE[inches],
            CENTRE_TOLERANCE[inches],
            CENTRE_RELATIVE,
            CENTRE_FACTOR * CENTRE_TOLERANCE[inches],
            *feeds_meant(ip),
            state.speed,
            SYSTEM_CODES[state.system - 1] / 10 if state.system <= len(SYSTEM_CODES) else -1.0,
            state.selected,
        )
        self._levels[: gcode_codes.PECK_CLEARANCE] = array("d", levels)

    def _give_cycle(self) -> None:
        """Tell the kernel the words of the cycle in force; the first one of a run tells it which cycles there are."""
        from cncgen.gcode.codes.canned_cycles import CYCLES, PECK_CLEARANCE, HoleMoves, Sticky

        state, levels = self._ip.state, self._levels
        if self._ip.dialect == "linuxcnc" and not self._cycles:
            made = {
                n: (sum(_BITS[x] for x in cycle.needs), cycle.run.between, cycle.run.last)
                for n, cycle in CYCLES.items()
                if isinstance(cycle.run, HoleMoves)
            }
            self._kernel.take_cycles({n // 10: moves for n, moves in made.items()})
            self._cycles = frozenset(made)
        sticky = state.cycle if isinstance(state.cycle, Sticky) else Sticky()
        depth = AXES[state.plane_axes()[2]]
        taken = sticky.words.keys() <= {"r", "p", "q", depth}
        bits = {**_BITS, depth: gcode_codes.GIVEN_DEPTH}
        self._modes[gcode_codes.CYCLE] = sticky.number // 10 if taken else -1
        self._modes[gcode_codes.GIVEN] = sum(bits[letter] for letter in sticky.words) if taken else 0
        words = (sticky.words.get(letter, 0.0) for letter in ("r", "p", "q", depth))
        clearance = PECK_CLEARANCE[state.inches]
        levels[gcode_codes.PECK_CLEARANCE :] = array("d", (clearance, sticky.level, sticky.dwell, *words))
        self._cycle, self._under = state.cycle, (state.plane, state.inches)

    def _take_modes(self) -> None:
        state, sink, modes, levels = self._ip.state, self._ip.sink, self._modes, self._levels
        motion = modes[gcode_codes.MOTION]
        state.motion = NO_MOTION if motion < 0 else 10 * motion
        state.absolute = bool(modes[gcode_codes.ABSOLUTE])
        if self._kernel.drilled:
            self._take_cycle()
        if self._kernel.changed >= 0.0:
            from cncgen.gcode.codes.tools import put_in

            put_in(self._ip, int(self._kernel.changed))
            state.position = sink.where(state.position)
        if self._kernel.asides:
            state.plane = modes[gcode_codes.PLANE]
            state.speed, state.direction = levels[gcode_codes.SPEED], modes[gcode_codes.DIRECTION]
            state.selected = int(levels[gcode_codes.TOOL])
            state.mist, state.flood = bool(modes[gcode_codes.MIST]), bool(modes[gcode_codes.FLOOD])
        state.retract_old = bool(modes[gcode_codes.OLD_LEVEL])
        feed = levels[gcode_codes.FEED]
        if feed != state.feed:
            state.feed = feed
            if not sink.wants_comments:
                sink.set_feed_rate(feed)

    def _take_cycle(self) -> None:
        from cncgen.gcode.codes.canned_cycles import Sticky

        state, given = self._ip.state, self._modes[gcode_codes.GIVEN]
        level, dwell, *values = self._levels[gcode_codes.LEVEL :]
        letters = ("r", "p", "q", AXES[state.plane_axes()[2]])
        words = {
            letter: v for k, (letter, v) in enumerate(zip(letters, values, strict=True)) if given >> k & 1
        }
        state.cycle = Sticky(10 * self._modes[gcode_codes.CYCLE], words, level, dwell)
        self._cycle = state.cycle

    def _hand_on(self) -> None:
        """Give motions and asides to the sink, in their order."""
        kernel, sink = self._kernel, self._ip.sink
        if isinstance(sink, CountingSink):
            # The calls of events are not made.
            sink.budget.spend(CALL * kernel.events)
            sink.count += kernel.events
            sink.waited += kernel.waited
            self._hand_rows(0, kernel.rows)
            return
        begin = 0
        for k in range(kernel.asides):
            row = self._asides[0][k]
            self._hand_rows(begin, row)
            begin = row
            self._tell(k)
        self._hand_rows(begin, kernel.rows)

    def _tell(self, k: int) -> None:
        """Execute an aside, as the handler of its code does."""
        ip, sink = self._ip, self._ip.sink
        kind, value, index = self._asides[1][k], self._asides[2][k], self._asides[3][k]
        here = self._plain.cursor(index)
        block = sink.block = empty_block(here)
        if kind == gcode_codes.ASIDE_EXACT:
            sink.set_motion_control_mode(PathMode.EXACT_PATH, None, None)
        elif kind == gcode_codes.ASIDE_PATH:
            from cncgen.gcode.codes.canned_cycles import path_again

            path_again(ip)
        elif kind == gcode_codes.ASIDE_PAUSE:
            from cncgen.gcode.codes.canned_cycles import wait

            wait(ip, value)
        elif kind in _OF_A_WORD:
            letter, code = _OF_A_WORD[kind]
            block.words[letter] = value
            ip.codes[code].run(ip, block)
        else:
            ip.codes["M" if kind < 10 else "G", 10 * kind].run(ip, block)

    def _hand_rows(self, begin: int, end: int) -> None:
        if end > begin:
            self._ip.sink.motions(
                MotionBatch(
                    motion=self._motion[begin:end],
                    end=self._end[begin:end],
                    feed=self._feed[begin:end],
                    feed_set=self._feed_set[begin:end],
                    centre=self._centre[begin:end],
                    turns=self._turns[begin:end],
                    line=self._line[begin:end],
                    offset=self._offset[begin:end],
                    source=self._plain.source,
                    reach=self._kernel.reach,
                    turn=self._kernel.turn,
                    creeps=self._kernel.creeps,
                )
            )
