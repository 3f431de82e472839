"""Tilted planes on machines whose rotary axes have turned to them: what a turned table or head makes of a plane, as one more frame.

While a tilted plane is milled the rotary axes stand still, so that the way from the plane to the machine's slides is a rigid motion
(`cncgen.machine.kinematics`). The frame goes around those of the program: arcs stay arcs, and the tool's radius is compensated as in any
plane. It depends on the origin and, on machines with a head, on the tool's length: who changes these puts it in force again.
"""

from __future__ import annotations

import math

from cncgen.gcode.block import AXES
from cncgen.gcode.codes import affine
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import to_machine, to_program, zeros
from cncgen.machine.kinematics import Kinematics
from cncgen.units import INCH

#: The code of tool lengths under which the tip is followed, whatever the rotary axes do.
FOLLOWED = 43.4

#: Positions of the rotary axes, degrees, the carrying one first.
Positions = tuple[float, float]


def carried(ip: Interpreter, axes: Positions | None) -> affine.Frame:
    """Return the frame of a table or head whose axes stand there; none without kinematics, and where the tip is followed anyway."""
    kinematics = ip.options.kinematics
    if axes is None or kinematics is None or ip.state.length_code == FOLLOWED:
        return affine.Frame()
    origin, rotation, g92, offset = ip.state.offsets()
    unit = INCH if ip.state.inches else 1.0
    x, y, z, *rest = to_machine(zeros(), origin, rotation, g92, zeros())
    place = kinematics.machine((x * unit, y * unit, z * unit), axes, offset[2] * unit)
    x, y, z, *_ = to_program([*(value / unit for value in place), *rest], origin, rotation, g92, offset)
    plane = affine.UNIT if kinematics.heads else affine.transposed(kinematics.turned_plane(axes))
    return affine.Frame(plane, (x, y, z))


def normal_of(matrix: affine.Matrix) -> affine.Vector:
    """Return the direction of a plane's Z."""
    return matrix[0][2], matrix[1][2], matrix[2][2]


def turn_in_plane(matrix: affine.Matrix) -> float:
    """Return the angle, degrees, by which a plane square to Z is turned."""
    return math.degrees(math.atan2(matrix[1][0], matrix[0][0]))


def positions(ip: Interpreter, kinematics: Kinematics) -> Positions:
    """Return where the machine's rotary axes stand."""
    machine = ip.machine_position()
    outer, inner = kinematics.axes
    return machine[outer], machine[inner]


def words(ip: Interpreter, kinematics: Kinematics, axes: Positions) -> dict[str, float]:
    """Return the words of a block that turns the rotary axes to positions of the machine."""
    now, position = positions(ip, kinematics), ip.state.position
    turns = zip(kinematics.axes, axes, now, strict=True)
    return {AXES[column]: position[column] + goal - at for column, goal, at in turns}
