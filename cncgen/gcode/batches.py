"""Runs of plain motions in arrays: the interpreter's state into the kernel `gcode_motion`, its rows to the sink."""

from __future__ import annotations

import numpy as np

from cncgen.gcode.arcs import CENTRE_FACTOR, CENTRE_RELATIVE, CENTRE_TOLERANCE, RADIUS_TOLERANCE
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.lanes import BLOCKS, PlainBlocks
from cncgen.gcode.sink import MotionBatch
from cncgen.kernels import gcode_motion

#: Motions that the kernel takes, in tenths, and what it calls them.
_MOTIONS = {0: 0, 10: 1, 20: 2, 30: 3}


class Batches:
    """Work arrays of `gcode_motion.advance`, used again for each run."""

    def __init__(self, ip: Interpreter) -> None:
        self._ip = ip
        self._position = np.zeros(9)
        self._modes = np.zeros(gcode_motion.MODES, np.int64)
        self._levels = np.zeros(gcode_motion.LEVELS)
        self._block = np.zeros(BLOCKS, np.int64)
        self._motion = np.zeros(BLOCKS, np.int8)
        self._end = np.zeros((BLOCKS, 9))
        self._feed = np.zeros(BLOCKS)
        self._feed_set = np.zeros(BLOCKS, np.uint8)
        self._centre = np.zeros((BLOCKS, 2))
        self._turns = np.zeros(BLOCKS, np.int64)

    def run(self, plain: PlainBlocks, index: int, count: int) -> int:
        """Run plain motions from a block on; return the first block that was not taken."""
        if not self._ip.batchable():
            return index
        self._load()
        done, rows = gcode_motion.advance(
            index,
            count,
            plain.flags,
            plain.word_end,
            plain.letters,
            plain.values,
            self._position,
            self._modes,
            self._levels,
            self._block,
            self._motion,
            self._end,
            self._feed,
            self._feed_set,
            self._centre,
            self._turns,
        )
        self._store_modes()
        if rows:
            self._hand_on(plain, rows)
        return int(done)

    def _load(self) -> None:
        """Copy the state to the kernel's arrays."""
        state, inches = self._ip.state, self._ip.state.inches
        self._position[:] = state.position
        self._modes[:] = (
            _MOTIONS.get(state.motion, -1),
            state.absolute,
            state.arc_absolute,
            state.plane,
            state.feed_mode == 93,
            self._ip.options.block_delete,
            not self._ip.sink.wants_comments,
        )
        self._levels[:] = (
            state.feed,
            RADIUS_TOLERANCE[inches],
            CENTRE_TOLERANCE[inches],
            CENTRE_RELATIVE,
            CENTRE_FACTOR * CENTRE_TOLERANCE[inches],
        )

    def _store_modes(self) -> None:
        """Copy back what blocks without motion may have changed too."""
        state, sink = self._ip.state, self._ip.sink
        state.absolute = bool(self._modes[gcode_motion.ABSOLUTE])
        feed = float(self._levels[gcode_motion.FEED])
        if feed != state.feed:
            state.feed = feed
            if not sink.wants_comments:
                sink.set_feed_rate(feed)

    def _hand_on(self, plain: PlainBlocks, rows: int) -> None:
        """Give the rows to the sink, and take over where they end."""
        block = self._block[:rows]
        self._ip.sink.motions(
            MotionBatch(
                self._motion[:rows],
                self._end[:rows],
                self._feed[:rows],
                self._feed_set[:rows],
                self._centre[:rows],
                self._turns[:rows],
                plain.line[block],
                plain.offset[block],
                0,
            )
        )
        state = self._ip.state
        state.position = self._position.tolist()
        state.motion = 10 * int(self._modes[gcode_motion.MOTION])
        state.moved = True
