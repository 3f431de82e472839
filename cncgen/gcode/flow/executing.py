"""Executing one block after another, with the effects of an open curve, a comment or a modal macro."""

from __future__ import annotations

from cncgen.gcode.block import AXIS_INDEX, Block
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
        """Execute a block."""
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
        if block.words or block.g or block.m:
            ip.execute(block)
        if ip.modal_macros:
            self._call_modal_macro(block)

    def guarded(self, block: Block) -> None:
        """Let an open curve say that a block does not belong to it; the block still runs."""
        assert self._ip.guard is not None
        self._ip.base.block = block
        try:
            self._ip.guard(self._ip, block)
        except BlockError as error:
            self._faults.at(Cursor(block.source, block.offset, block.line), error)

    def _call_modal_macro(self, block: Block) -> None:
        """Ask for the macro of the last G66 after a motion; motions of that macro ask for the one before it."""
        ip = self._ip
        running = sum(frame.modal for frame in self._calls.frames)
        moves = not AXIS_INDEX.keys().isdisjoint(block.words)
        if moves and ip.jump is None and running < len(ip.modal_macros):
            number, times, ip.macro_values = ip.modal_macros[-1 - running]
            ip.jump = "modal", number, times
