"""Directions of the tool in LN: TX TY TZ, or the normal of the surface NX NY NZ, to positions of the rotary axes.

"If M128 is active, the TNC maintains the tool perpendicular to the workpiece contour if no tool orientation is programmed in the LN block. If
there is a tool orientation T and M128 (or TCPM) is active, the TNC will position the rotary axes automatically. If you have not activated
M128, the TNC ignores the direction vector T" (iTNC 530, "Face milling: 3-D compensation with and without tool orientation").
"""

from __future__ import annotations

import math

from cncgen.gcode.block import TIP, Block
from cncgen.gcode.codes import affine, carried_planes
from cncgen.gcode.codes.plain_language import TIP_MODE
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter

TOOL, NORMAL = ("tx", "ty", "tz"), ("nx", "ny", "nz")


def take(ip: Interpreter, block: Block) -> None:
    """Take the direction of a block as positions of the rotary axes: the nearer of the two pairs.

    Raises:
        BlockError: The direction has no length, stands beside a rotary axis, or the machine's axes do not reach it.
    """
    given = {name: block.words.pop(name) for name in (*TOOL, *NORMAL) if name in block.words}
    if not given or (ip.state.length_code != TIP_MODE and TIP not in block.g):
        return
    names = TOOL if given.keys() & {*TOOL} else NORMAL
    x, y, z = (given.get(name, 0.0) for name in names)
    if math.hypot(x, y, z) == 0.0:
        message = f"the direction of the tool, {names[0].upper()}, has no length"
        raise BlockError("orientation-vector", message, names[0].upper(), hint="TX+0 TY+0 TZ+1 is along Z")
    if (x or y) and (ip.state.compensation != 40 or {410, 420} & {*block.g}) and 400 not in block.g:
        message = "RL and RR of LN shift the tool square to its direction (peripheral milling in space), which is not read"
        raise BlockError(
            "tcp-refused", message, names[0].upper(), hint="R0, and the points of the tool's centre"
        )
    kinematics = ip.options.kinematics
    if kinematics is None:
        # M128 has said that no kinematics are known.
        return
    direction = (x, y, z)
    if isinstance(ip.sink, affine.AffineSink):
        direction = affine.applied(ip.sink.program.matrix, direction)
    axes = kinematics.angles_of(direction, carried_planes.positions(ip, kinematics))
    if axes is None:
        raise carried_planes.unreached(kinematics, names[0].upper())
    block.words |= carried_planes.words(ip, kinematics, axes)
