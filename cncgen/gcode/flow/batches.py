"""Runs of plain motions in columns: the interpreter's state into the kernel `gcode_motion`, its rows to the sink."""

from __future__ import annotations

from array import array

from cncgen.gcode.codes.arcs import CENTRE_FACTOR, CENTRE_RELATIVE, CENTRE_TOLERANCE, RADIUS_TOLERANCE
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import MotionBatch
from cncgen.gcode.text.lanes import BLOCKS, PlainBlocks, column
from cncgen.kernels import gcode_motion

#: Motions that the kernel takes, in tenths, and what it calls them.
_MOTIONS = {0: 0, 10: 1, 20: 2, 30: 3}


class Batches:
    """The kernel on the columns of plain blocks, and work columns of its own, used again for each run."""

    def __init__(self, ip: Interpreter, plain: PlainBlocks) -> None:
        self._ip = ip
        self._plain = plain
        self._position = array("d", [0.0] * 9)
        self._modes = array("q", [0] * gcode_motion.MODES)
        self._levels = array("d", [0.0] * gcode_motion.LEVELS)
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
        self._kernel = gcode_motion.Advance(
            plain.columns(), self._position, self._modes, self._levels, motions
        )

    def run(self, index: int, count: int) -> int:
        """Run plain motions from a block on; return the first block that was not taken."""
        if not self._ip.batchable():
            return index
        state = self._ip.state
        self._position[:] = array("d", state.position)
        self._give_modes()
        done, rows = self._kernel.run(index, count)
        self._take_modes()
        if rows:
            self._hand_on(rows, self._plain.source)
            state.position = self._position.tolist()
            state.motion = 10 * self._modes[gcode_motion.MOTION]
            state.moved = True
        return int(done)

    def _give_modes(self) -> None:
        """Say what the kernel begins with: modes, feed and the tolerances of arcs."""
        state, inches = self._ip.state, self._ip.state.inches
        self._modes[:] = array(
            "q",
            (
                _MOTIONS.get(state.motion, -1),
                state.absolute,
                state.arc_absolute,
                state.plane,
                state.feed_mode == 93,
                self._ip.options.block_delete,
                not self._ip.sink.wants_comments,
            ),
        )
        self._levels[:] = array(
            "d",
            (
                state.feed,
                RADIUS_TOLERANCE[inches],
                CENTRE_TOLERANCE[inches],
                CENTRE_RELATIVE,
                CENTRE_FACTOR * CENTRE_TOLERANCE[inches],
            ),
        )

    def _take_modes(self) -> None:
        """Take over what blocks without motion may have changed too."""
        state, sink = self._ip.state, self._ip.sink
        state.absolute = bool(self._modes[gcode_motion.ABSOLUTE])
        feed = self._levels[gcode_motion.FEED]
        if feed != state.feed:
            state.feed = feed
            if not sink.wants_comments:
                sink.set_feed_rate(feed)

    def _hand_on(self, rows: int, source: int) -> None:
        """Give the rows to the sink."""
        self._ip.sink.motions(
            MotionBatch(
                motion=self._motion[:rows],
                end=self._end[:rows],
                feed=self._feed[:rows],
                feed_set=self._feed_set[:rows],
                centre=self._centre[:rows],
                turns=self._turns[:rows],
                line=self._line[:rows],
                offset=self._offset[:rows],
                source=source,
            )
        )
