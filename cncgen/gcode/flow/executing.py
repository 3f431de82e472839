"""Executing one block after another, with the effects of an open curve, a comment or a modal macro."""

from __future__ import annotations

from cncgen.gcode.block import AXIS_INDEX, Block, Jump
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.calls import Calls
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.text.labels import Cursor

_G11 = 110


class Executor:
    """Has blocks executed."""

    def __init__(self, ip: Interpreter, calls: Calls, faults: Faults) -> None:
        self._ip = ip
        self._calls = calls
        self._faults = faults

    def execute(self, block: Block) -> None:
        ip = self._ip
        if ip.skipping and not block.m:
            ip.skipping = _G11 not in block.g
            return
        if ip.rewrite is not None:
            block = ip.rewrite(ip, block)
        if ip.lathe:
            from cncgen.gcode.codes.lathe_words import turned

            block = turned(ip, block)
        if ip.guard is not None:
            self.guarded(block)
        if block.comment is not None:
            from cncgen.gcode.codes.comments import comment

            comment(ip, block, block.comment)
        if not (block.words or block.g or block.m):
            return
        if ip.modal_macros:
            self._execute_under_macros(block)
        else:
            ip.execute(block)

    def guarded(self, block: Block) -> None:
        """Let an open curve say that a block does not belong to it; the block still runs."""
        assert self._ip.guard is not None
        self._ip.base.block = block
        try:
            self._ip.guard(self._ip, block)
        except BlockError as error:
            self._faults.at(Cursor(block.source, block.offset, block.line), error)

    def _execute_under_macros(self, block: Block) -> None:
        """Execute a block, and ask for the macro of the last G66 after a motion; motions of that macro ask for the one before it.

        Codes that use axis words themselves need not move: G4 X, G10, G52.
        """
        ip, state = self._ip, self._ip.state
        own = any(row.axes == "own" for row in ip.codes.of(block))
        before, state.moved = state.moved, state.moved and not own
        try:
            ip.execute(block)
            moves = state.moved if own else not AXIS_INDEX.keys().isdisjoint(block.words)
        finally:
            state.moved = state.moved or before
        running = sum(frame.modal for frame in self._calls.frames)
        if moves and ip.jump is None and running < len(ip.modal_macros):
            number, times, ip.macro_values = ip.modal_macros[-1 - running]
            ip.jump = Jump("modal", number, times)
