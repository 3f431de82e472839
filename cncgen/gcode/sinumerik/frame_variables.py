"""Frame variables of SINUMERIK: $P_UIFR[n], the origins of G54 and after, $P_IFRAME, the one in force, and $P_PFRAME, the programmable frame.

A frame is written as a chain of CTRANS, CROT, CSCALE, CMIRROR and CFINE, or part by part: ``$P_UIFR[1,X,TR]=10`` (840D sl, Job planning,
"Frames").
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES, AXIS_INDEX
from cncgen.gcode.codes import affine as frames
from cncgen.gcode.codes.offsets import use_system
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinumerik.expressions import (
    Chain,
    Function,
    Scalar,
    Value,
    Variable,
    evaluate,
    number,
    whole,
)
from cncgen.gcode.sinumerik.swivelling import take_frames
from cncgen.gcode.state.systems import MORE_COUNT, ROTATION, SYSTEM_COUNT, first_parameter, load_system
from cncgen.records import replace

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

MAKERS = ("CTRANS", "CROT", "CSCALE", "CMIRROR", "CFINE")
ORIGINS, PROGRAMMABLE, IN_FORCE = "$P_UIFR", "$P_PFRAME", "$P_IFRAME"
VARIABLES = (ORIGINS, PROGRAMMABLE)
#: Parts of a frame: shift, fine shift, rotation, scale, mirror.
PARTS = ("TR", "FI", "RT", "SC", "MI")
#: Rounding moves an element of a matrix by less than this.
_TINY = 1e-12
#: The origin of G599.
LAST_ORIGIN = 99


def is_frame(value: Value) -> bool:
    """Tell whether an expression is a frame."""
    if isinstance(value, Variable):
        return len(value.indices) == {ORIGINS: 1, PROGRAMMABLE: 0}.get(value.name, -1)
    return isinstance(value, Chain) or (isinstance(value, Function) and value.name in MAKERS)


def _refused(what: str, why: str) -> BlockError:
    message = f"{what} ({why}) is not read"
    return BlockError("not-read", message, what, hint="docs/sinumerik.md lists what is read")


def _frame(motions: Motions, value: Value) -> frames.Frame:
    if isinstance(value, Chain):
        return _frame(motions, value.first).then(_frame(motions, value.second))
    if isinstance(value, Variable) and value.name == PROGRAMMABLE and not value.indices:
        return motions.frames.programmable
    if isinstance(value, Variable) and value.name == ORIGINS and len(value.indices) == 1:
        system = _system(evaluate(value.indices[0], motions.store))
        origin = _origin(motions.ip, system)
        return frames.Frame(frames.turn(2, _turn(motions.ip, system)), (origin[0], origin[1], origin[2]))
    if not isinstance(value, Function) or value.name not in MAKERS:
        raise _refused(getattr(value, "name", "a number"), "no frame")
    kind = {"CTRANS": "TRANS", "CFINE": "TRANS"}.get(value.name, value.name[1:])
    values = [evaluate(argument, motions.store) for argument in value.arguments if argument is not None]
    if kind == "MIRROR":
        return frames.made(kind, {str(axis): 1.0 for axis in values})
    return frames.made(
        kind, {str(axis): number(value) for axis, value in zip(values[::2], values[1::2], strict=False)}
    )


def set_frame(motions: Motions, name: str, at: list[Scalar], value: Value) -> None:
    """Set a frame variable; an origin is a shift, and a rotation about Z within it."""
    motions.settle()
    if name == IN_FORCE and not at and isinstance(value, Variable) and value.name == ORIGINS:
        use_origin(motions, whole(evaluate(value.indices[0], motions.store)), name)
        return
    made = _frame(motions, value)
    if name == PROGRAMMABLE and not at:
        take_frames(motions, replace(motions.frames, programmable=made, added=frames.NO_SHIFT))
        return
    if name != ORIGINS or len(at) != 1:
        raise _refused(name, "a frame variable")
    turned = math.degrees(math.atan2(made.matrix[1][0], made.matrix[0][0]))
    if any(
        abs(a - b) > _TINY
        for row, other in zip(made.matrix, frames.turn(2, turned), strict=True)
        for a, b in zip(row, other, strict=True)
    ):
        raise _refused(ORIGINS, "an origin that scales, mirrors, or turns about X or Y")
    shift = [*made.shift, *([0.0] * 6)]
    given = _axes_of(motions, value)
    _set_origin(motions.ip, _system(at[0]), [given.get(k, place) for k, place in enumerate(shift)], turned)


def _axes_of(motions: Motions, frame: Value) -> dict[int, float]:
    """Return the shifts of the axes beside X Y Z."""
    if not isinstance(frame, Function):
        return {}
    values = [evaluate(argument, motions.store) for argument in frame.arguments if argument is not None]
    found = {
        AXIS_INDEX.get(str(axis).lower(), -1): number(value)
        for axis, value in zip(values[::2], values[1::2], strict=False)
    }
    return {column: value for column, value in found.items() if column > 2}


def _system(index: Scalar) -> int:
    system = whole(index)
    if not 1 <= system <= LAST_ORIGIN:
        message = f"{ORIGINS}[{system}]: origins are 1 to {LAST_ORIGIN}"
        raise BlockError("system-number", message, ORIGINS, hint="1 is G54, 5 is G505")
    return system


def use_origin(motions: Motions, origin: int, word: str) -> None:
    """Put an origin in force: 0 that of G500, 1 to 4 those of G54 to G57, others those of G505 and after."""
    motions.settle()
    if motions.ip.state.compensation != 40:
        message = f"{word} changes the origin, and cutter compensation is on"
        raise BlockError("comp-refused", message, word, hint="turn it off before (G40)")
    with motions.shifting():
        use_system(motions.ip, _system(origin) if origin else SYSTEM_COUNT + MORE_COUNT)
    if motions.frames.axes is not None:
        motions.refuse_turned_origin(word)


def _origin(ip: Interpreter, system: int) -> list[float]:
    return ip.parameters.offset(first_parameter(system), ip.table_scale())


def _turn(ip: Interpreter, system: int) -> float:
    """Return the rotation of an origin about Z, degrees."""
    degrees: float = ip.parameters.numbers[first_parameter(system) + ROTATION]
    return degrees


def _set_origin(ip: Interpreter, system: int, origin: list[float], turned: float) -> None:
    ip.parameters.set_offset(first_parameter(system), origin, ip.table_scale())
    ip.parameters.numbers[first_parameter(system) + ROTATION] = turned
    if ip.state.system == system:
        load_system(ip, system)
        ip.sink.set_g5x_offset(system, ip.state.origin)
        ip.sink.set_xy_rotation(ip.state.rotation)


def _part(name: str, at: list[Scalar]) -> tuple[int, int, str]:
    """Return origin (0: the programmable frame), column and part that indices name."""
    system = _system(at[0]) if name == ORIGINS and len(at) == 3 else 0
    if len(at) != (3 if name == ORIGINS else 2):
        raise _refused(name, "these indices")
    axis, part = str(at[-2]).lower(), str(at[-1]).upper()
    if axis not in AXES or part not in PARTS:
        message = f"{name}[…,{axis.upper()},{part}]: indices are an axis and a part"
        raise BlockError("variable-index", message, name, hint=f"parts are {', '.join(PARTS)}")
    return system, AXIS_INDEX[axis], part


def set_part(motions: Motions, name: str, at: list[Scalar], value: float) -> None:
    """Set one part of a frame variable: a shift of it, the rotation of an origin about Z, or another part to its neutral value."""
    system, column, part = _part(name, at)
    neutral = 1.0 if part == "SC" else 0.0
    if system and part == "RT" and column == 2:
        motions.settle()
        _set_origin(motions.ip, system, _origin(motions.ip, system), value)
        return
    if part != "TR" and (system or part != "FI"):
        if value != neutral:
            raise _refused(f"{name}[…,{part}]", "a part beside the shift, TR")
        return
    motions.settle()
    if system:
        origin = _origin(motions.ip, system)
        origin[column] = value
        _set_origin(motions.ip, system, origin, _turn(motions.ip, system))
        return
    if column > 2:
        raise _refused(f"{name}[{AXES[column].upper()},{part}]", "frames are of X Y Z")
    take_frames(motions, motions.frames.shifted(column, value, added=part == "FI"))


def part(ip: Interpreter, at: list[Scalar]) -> float:
    """Return one part of an origin."""
    system, column, kind = _part(ORIGINS, at)
    if kind == "RT" and column == 2:
        return _turn(ip, system)
    if kind != "TR":
        return 1.0 if kind == "SC" else 0.0
    return _origin(ip, system)[column]
