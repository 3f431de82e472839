"""Tilted working planes of FANUC: G68.2 turns the coordinates, G53.1 points the tool along their Z, G69 ends them (B-64484EN-2, 7.8).

Angles are Euler's, about Z, the new X, the new Z (I J K); with P1 they are those about the axes X Y Z of the workpiece, in the order of
Q. The rotary axes of the machine are not turned here, which a warning says.
"""

from __future__ import annotations

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.codes import affine
from cncgen.gcode.codes.table import Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

#: Orders of Q, digits of the axes.
_ORDERS = (123, 132, 213, 231, 312, 321)
#: Stands among the remarks of a run once it was said that the rotary axes do not turn.
_SAID = -682


def _matrix(block: Block) -> affine.Matrix:
    """Return the rotation.

    Raises:
        BlockError: The plane is given by points or vectors.
    """
    i, j, k = (block.words.get(letter, 0.0) for letter in "ijk")
    kind = whole(block, "p", "G68.2") if "p" in block.words else 0
    if kind == 0:
        steps = (affine.turn(2, i), affine.turn(0, j), affine.turn(2, k))
    elif kind == 1:
        order = whole(block, "q", "G68.2") if "q" in block.words else 0
        if order not in _ORDERS:
            message = f"Q{order} of G68.2 P1 is no order of the axes 1 2 3"
            raise BlockError(
                "plane-kind", message, "Q" if order else "P", hint="Q123 turns about X, then Y, then Z"
            )
        turns = [affine.turn(int(axis) - 1, (i, j, k)[int(axis) - 1]) for axis in str(order)]
        steps = (turns[2], turns[1], turns[0])
    else:
        hint = "P0 takes Euler's angles, P1 those about X, Y and Z"
        raise BlockError(
            "plane-kind",
            f"P{kind} of G68.2, a plane by points, vectors or projections, is not read",
            "P",
            hint=hint,
        )
    return affine.product(steps[0], affine.product(steps[1], steps[2]))


def tilt(ip: Interpreter, block: Block) -> None:
    """G68.2 X Y Z I J K."""
    if not isinstance(ip.sink, affine.AffineSink) and ip.sink is not ip.base:
        message = "G68.2 does not go with G68, G51, G51.1, G43.4, or cutter compensation"
        raise BlockError("frame-compensation", message, "G68.2", hint="end them before")
    x, y, z = (block.words.get(letter, 0.0) for letter in "xyz")
    matrix = _matrix(block)
    if matrix != affine.UNIT and _SAID not in ip.remarked:
        ip.remarked.add(_SAID)
        message = "G68.2 turns the coordinates; the rotary axes of the machine are not turned here"
        hint = "write A B C where the machine has them, or use G43.4 on a machine with [kinematics]"
        ip.warn(BlockError("swivel-frame", message, "G68.2", hint=hint), Severity.WARNING)
    affine.change(ip, affine.Frame(matrix, (x, y, z)))


def align(ip: Interpreter, block: Block) -> None:
    """G53.1: turn the rotary axes until the tool stands along Z of the tilted plane."""
    if not isinstance(ip.sink, affine.AffineSink):
        raise BlockError("plane-missing", "G53.1 has no tilted plane", "G53.1", hint="G68.2 stands before it")


CODES = (
    Code("G", 682, "rotation", Stage.REFERENCE, tilt, "tilted plane: origin X Y Z, angles I J K", "xyzijkpq", "own",
         dialects=("fanuc",), moves="XYZ"),
    Code("G", 531, "tool along plane", Stage.COORDINATES, align, "tool along Z of the tilted plane", "p", dialects=("fanuc",)),
)  # fmt: skip
