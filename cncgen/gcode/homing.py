"""G28 and G30: to the reference points, by way of the point in the block; G28.1 and G30.1 set them."""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes import Code, Handler
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.lines import has_axis
from cncgen.gcode.modal import Stage, to_program
from cncgen.gcode.offsets import given_axes
from cncgen.gcode.parameters import HOME_28, HOME_30

_AXES = "xyzabcuvw"


def _go(first: int) -> Handler:
    def run(ip: Interpreter, block: Block) -> None:
        state = ip.state
        end = ip.end_point(block)
        ip.sink.straight_traverse(end)
        state.position = end
        home = ip.parameters.offset(first, ip.table_scale())
        target = to_program(home, *state.offsets())
        axes = {index for index, _ in given_axes(block)} if has_axis(block) else set(range(9))
        end = [target[k] if k in axes else end[k] for k in range(9)]
        ip.sink.straight_traverse(end)
        state.position, state.moved = end, True

    return run


def _set(first: int) -> Handler:
    def run(ip: Interpreter, block: Block) -> None:
        ip.parameters.set_offset(first, ip.machine_position(), ip.table_scale())

    return run


CODES = (
    Code("G", 280, "non-modal", Stage.REFERENCE, _go(HOME_28), "to reference point 1", _AXES, "own"),
    Code("G", 281, "non-modal", Stage.REFERENCE, _set(HOME_28), "set reference point 1"),
    Code("G", 300, "non-modal", Stage.REFERENCE, _go(HOME_30), "to reference point 2", _AXES, "own"),
    Code("G", 301, "non-modal", Stage.REFERENCE, _set(HOME_30), "set reference point 2"),
)
