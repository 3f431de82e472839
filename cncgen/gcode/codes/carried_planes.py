"""Positions of the machine's rotary axes at which the tool is square to a tilted plane, and blocks that turn them there.

`affine` carries the plane along with the table or head that they turn.
"""

from __future__ import annotations

import math

from cncgen.gcode.block import AXES
from cncgen.gcode.codes import affine
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.machine.kinematics import Kinematics


def normal_of(matrix: affine.Matrix) -> affine.Vector:
    """Return the direction of a plane's Z."""
    return matrix[0][2], matrix[1][2], matrix[2][2]


def turn_in_plane(matrix: affine.Matrix) -> float:
    """Return the angle, degrees, by which a plane square to Z is turned."""
    return math.degrees(math.atan2(matrix[1][0], matrix[0][0]))


def unreached(kinematics: Kinematics, word: str) -> BlockError:
    """Return the fault of a direction to which the rotary axes do not turn the tool."""
    names = " and ".join(AXES[k].upper() for k in kinematics.axes)
    message = f"{names} of the machine do not turn the tool to any direction"
    hint = "the axis next to the tool is A or B, or that of the table's frame"
    return BlockError("orientation-vector", message, word, hint=hint)


def positions(ip: Interpreter, kinematics: Kinematics) -> affine.Positions:
    """Return where the machine's rotary axes stand."""
    machine = ip.machine_position()
    outer, inner = kinematics.axes
    return machine[outer], machine[inner]


def words(ip: Interpreter, kinematics: Kinematics, axes: affine.Positions) -> dict[str, float]:
    """Return the words of a block that turns the rotary axes to positions of the machine."""
    now, position = positions(ip, kinematics), ip.state.position
    turns = zip(kinematics.axes, axes, now, strict=True)
    return {AXES[column]: position[column] + goal - at for column, goal, at in turns}


def toward(ip: Interpreter, kinematics: Kinematics, direction: affine.Vector, word: str) -> dict[str, float]:
    """Return the words of a block that turns the tool to a direction: the nearer of the two pairs of positions.

    Raises:
        BlockError: The axes do not reach it.
    """
    axes = kinematics.angles_of(direction, positions(ip, kinematics))
    if axes is None:
        raise unreached(kinematics, word)
    return words(ip, kinematics, axes)
