"""CYCLE800 of SINUMERIK: a swivelled plane as a frame, and the rotary axes that bring it square to the tool.

Its parameters are FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, DIR, FR_I, DMODE. The origin goes to X0 Y0 Z0, turns by A B C as MODE
says, and goes to X1 Y1 Z1 in the turned plane (840D sl, Programming cycles externally, CYCLE800; Operating Manual, "Swiveling").

MODE is a number of bits. 6 and 7 tell what the angles are: 0 turns one after the other, 1 a solid angle, 2 projections, 3 positions of the
rotary axes. Each two from bit 0 on are the axis of A, B and C: 1 is X, 2 is Y, 3 is Z. So 57 turns about X, the new Y, the new Z, and 27
about Z, the new Y, the new X.

On a machine with kinematics the rotary axes turn, and a frame around the others carries the plane (`codes.affine`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from cncgen.gcode.budget import FRAME
from cncgen.gcode.codes import affine
from cncgen.gcode.codes.carried_planes import normal_of, positions, unreached, words
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik.expressions import Scalar
from cncgen.records import replace

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions
    from cncgen.machine.kinematics import Kinematics

_NAME = "CYCLE800"
#: Kinds of MODE.
_IN_TURN, _SOLID, _PROJECTED, _DIRECT = range(4)
#: Solid angles turn about Z, then about the new Y.
_SOLID_AXES = (2, 1)
#: The additive plane (ones of ST); a tool that is turned instead of a plane (hundreds).
_ADDED = 1
#: Rounding moves a factor of a frame by less than this.
_TINY = 1e-9


class _Call:
    """The parameters of one call; texts and parameters that are left out are 0."""

    def __init__(self, values: list[Scalar | None]) -> None:
        self.numbers = [value if isinstance(value, (int, float)) else 0.0 for value in values]
        self.record = next((value for value in values[1:2] if isinstance(value, str)), "")

    def number(self, index: int) -> float:
        """Return one of them."""
        return self.numbers[index] if index < len(self.numbers) else 0.0

    def vector(self, index: int) -> affine.Vector:
        """Return three of them."""
        return self.number(index), self.number(index + 1), self.number(index + 2)

    def ends(self) -> bool:
        """Tell whether the plane ends: no parameters beyond the name of the swivel data, or that name is 0."""
        return self.record == "0" or not any(self.numbers[3:13])


def swivel(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """Turn the plane, and the rotary axes of a machine with kinematics where DIR is not 0.

    Raises:
        BlockError: The angles cannot be read, or the machine does not reach the direction.
    """
    call = _Call(values)
    motions.settle()
    if call.ends():
        _end(motions)
        return
    if round(call.number(2)) // 100 % 100:
        message = f"ST = {call.number(2):g} of {name} turns the tool to the workpiece, which is not read"
        raise BlockError("not-read", message, name, hint="ST = 0 is a new plane, 1 one within that in force")
    kinematics = motions.ip.options.kinematics
    if kinematics is not None:
        motions.refuse_turned_origin(_NAME)
    turned = affine.Frame(_matrix(call, kinematics), call.vector(4)).then(affine.Frame(shift=call.vector(10)))
    if round(call.number(2)) % 10 == _ADDED:
        turned = motions.frames.swivelled.then(turned)
    axes = _axes(motions, call, turned, kinematics)
    if axes is None or not call.number(13):
        _tell_idle(motions, turned)
    if axes is not None:
        _turn(motions, call, axes)
    take_frames(motions, replace(motions.frames, swivelled=turned, axes=axes))


def _end(motions: Motions) -> None:
    """End the plane; the rotary axes stay."""
    if motions.frames.swivelled != affine.Frame() or motions.frames.axes is not None:
        take_frames(motions, replace(motions.frames, swivelled=affine.Frame(), axes=None))


def _tell_idle(motions: Motions, turned: affine.Frame) -> None:
    if turned.matrix == affine.UNIT:
        return
    message = f"{_NAME} turns the coordinates; the rotary axes of the machine are not swivelled here"
    hint = "--machine with a table [kinematics], and DIR = -1 or 1, turns them; or write A B C"
    motions.ip.warn_once("swivel-frame", message, _NAME, hint)


# Angles.


def _matrix(call: _Call, kinematics: Kinematics | None) -> affine.Matrix:
    """Return the rotation that MODE makes of A B C.

    Raises:
        BlockError: MODE names no three axes, or positions of rotary axes without a machine that has them.
    """
    mode, angles = round(call.number(3)), call.vector(7)
    kind, order = mode >> 6, [(mode >> shift & 3) - 1 for shift in (0, 2, 4)]
    if not any(angles):
        return affine.UNIT
    if kind == _SOLID:
        return affine.product(*(affine.turn(*each) for each in zip(_SOLID_AXES, angles, strict=False)))
    if kind == _DIRECT:
        if kinematics is None:
            message = (
                f"MODE = {mode} of {_NAME} gives positions of rotary axes, and no machine says how they turn"
            )
            hint = "--machine names a file with a table [kinematics]"
            raise BlockError("tcp-machine", message, _NAME, hint=hint)
        return kinematics.turned_plane((angles[0], angles[1]))
    if kind not in (_IN_TURN, _PROJECTED) or sorted(order) != [0, 1, 2]:
        hint = "57 turns about X Y Z, 27 about Z Y X, 39 about Z X Y, 45 about X Z Y, 54 about Y X Z, 30 about Y Z X"
        raise BlockError("not-read", f"{_NAME} with MODE = {mode} is not read", _NAME, hint=hint)
    if kind == _PROJECTED:
        return _projected(_NAME, dict(zip(order, angles, strict=True)), order)
    first, second, third = (affine.turn(*each) for each in zip(order, angles, strict=True))
    return affine.product(affine.product(first, second), third)


def of_solid_angles(values: Mapping[str, float]) -> affine.Matrix:
    """Return the rotation of ROTS and AROTS, which has two angles at most: of the edges of the plane in two planes of the coordinates. With
    X and Y the new X axis is in the plane Z X, with Y and Z the new Y in X Y, with Z and X the new Z in Y Z (840D sl, Job planning, "ROTS").

    Raises:
        BlockError: It has three.
    """
    if len(values) > 2:
        hint = "ROT X10 Y20 Z30 turns about one axis after the other"
        raise BlockError("not-read", "ROTS turns a plane by two solid angles at most", "ROTS", hint=hint)
    if len(values) < 2:
        return affine.made("ROT", dict(values)).matrix
    order = sorted("XYZ".index(axis) for axis in values)
    return _projected(
        "ROTS", {k: values.get(axis, 0.0) for k, axis in enumerate("XYZ")}, [*order, 3 - sum(order)]
    )


def _projected(name: str, angles: dict[int, float], order: list[int]) -> affine.Matrix:
    """Return the rotation of a plane whose edges in two planes of the coordinates have two angles, and of the third about its normal.

    The axes a, b are in cyclic order: X Y, Y Z or Z X. The new one of a is that turned about b. The plane's line in the plane beside a is
    b turned about a.
    """
    a, b = order[:2] if (order[1] - order[0]) % 3 == 1 else order[1::-1]
    along, aside = (_column(affine.turn(k, angles[k]), j) for k, j in ((b, a), (a, b)))
    message = f"the projected angles of {name} leave no plane: both are 90 degrees"
    fault = BlockError("plane-points", message, _NAME, hint="MODE = 57 turns about X, then Y, then Z")
    normal = affine.unit(affine.cross(along, aside), fault)
    columns = {a: along, b: affine.cross(normal, along), order[2]: normal}
    plane = affine.of_columns(*(columns[k] for k in range(3)))
    return affine.product(plane, affine.turn(order[2], angles[order[2]]))


def _column(matrix: affine.Matrix, k: int) -> affine.Vector:
    return matrix[0][k], matrix[1][k], matrix[2][k]


# Rotary axes.


def _axes(
    motions: Motions, call: _Call, turned: affine.Frame, kinematics: Kinematics | None
) -> tuple[float, float] | None:
    """Return the positions of the rotary axes at which the tool is square to the plane, None without kinematics or under TRAORI.

    Of the two pairs DIR = 1 takes the one where the axis that tilts the tool has the larger position, else the smaller one counts. An axis
    along the tool goes to 0.
    """
    if kinematics is None or motions.ip.state.length_code == affine.FOLLOWED:
        return None
    if round(call.number(3)) >> 6 == _DIRECT:
        return call.number(7), call.number(8)
    pairs = kinematics.pairs_of(normal_of(turned.matrix), positions(motions.ip, kinematics), 0.0)
    if not pairs:
        raise unreached(kinematics, _NAME)
    pick = max if call.number(13) > 0.0 else min
    return pick(pairs, key=lambda pair: round(pair[kinematics.tilting], 6))


def _turn(motions: Motions, call: _Call, axes: tuple[float, float]) -> None:
    """Retract along the tool where FR says how far, and traverse the rotary axes.

    The other retractions of FR go to positions that machine data hold.
    """
    kinematics = motions.ip.options.kinematics
    if kinematics is None or not call.number(13):
        return
    retract, position = round(call.number(0)), motions.ip.state.position
    if retract == 5:
        motions.move({"Z": position[2] + abs(call.number(14))}, rapid=True)
    elif retract:
        message = f"FR = {retract} of {_NAME} is passed over: where it retracts to is machine data"
        motions.ip.note_once("retract-unknown", message, _NAME, "write the retraction before it, or FR = 5")
    motions.move(words(motions.ip, kinematics, axes), rapid=True)


# Frames.


def along_tool(name: str) -> Callable[[Motions], None]:
    """Return what TOROT and its kin do under TRAORI: the axis of the last letter, Z without one, is along the tool, and the next one in the order
    X Y Z X lies in the plane of both of before (840D sl, Fundamentals 09/2011, 12.8; Function Manual Axis Types 08/2005, 2.4, p. 104).

    TOROT sets the rotation of the programmed frame alone, TOFRAME makes a rotation of the whole frame.
    """
    tool = "XYZ".find(name[-1]) % 3
    first, second, whole = (tool + 1) % 3, (tool + 2) % 3, name.startswith("TOFRAME")

    def turn(motions: Motions) -> None:
        kinematics = motions.ip.options.kinematics
        if kinematics is None or motions.ip.state.length_code != affine.FOLLOWED:
            message = f"{name} turns the coordinates to the tool, and nothing says where that points: TRAORI on a machine with a table [kinematics] does"
            raise BlockError("tcp-machine", message, name, hint="CYCLE800 or ROT turns a plane by angles")
        now = motions.frames
        motions.refuse_turned_origin(name)
        direction = kinematics.direction(positions(motions.ip, kinematics))
        if not whole and any(abs(factor - 1.0) > _TINY for factor in now.programmable.factors()):
            message = f"{name} within a frame that scales or mirrors is not read"
            raise BlockError("not-read", message, name, hint="TRANS before it ends SCALE and MIRROR")
        normal = affine.applied(affine.transposed(now.swivelled.matrix), direction)
        message = f"{name}: the tool lies along {'XYZ'[second]}, which leaves the new {'XYZ'[first]} open"
        aside = [0.0, 0.0, 0.0]
        aside[first], aside[tool] = normal[tool], -normal[first]
        along = affine.unit((aside[0], aside[1], aside[2]), BlockError("plane-points", message, name))
        columns = {tool: normal, first: along, second: affine.cross(normal, along)}
        matrix = affine.of_columns(*(columns[k] for k in range(3)))
        message = f"{name}: the new {'XYZ'[first]} axis is taken to lie in the plane {'XYZ'[tool]} {'XYZ'[first]} of before"
        ends = ", and the shift of TRANS ends" if whole else ""
        hint = f"machine data 21110 of the control decides; a ROT before it is replaced{ends}"
        motions.ip.warn_once("swivel-frame", message, name, hint)
        shift, added = (affine.NO_SHIFT,) * 2 if whole else (now.programmable.shift, now.added)
        take_frames(motions, replace(now, programmable=affine.Frame(matrix, shift), added=added))

    return turn


def turn_back(motions: Motions) -> None:
    """TOROTOF: end the rotation that TOROT or TOFRAME has put into the programmed frame."""
    now = motions.frames
    take_frames(motions, replace(now, programmable=replace(now.programmable, matrix=affine.UNIT)))


def take_frames(motions: Motions, wanted: affine.Frames) -> None:
    """Put frames in force, within that of a turned table or head."""
    motions.ip.budget.spend(FRAME)
    with motions.shifting():
        affine.change(motions.ip, wanted.whole(), wanted.axes)
    if wanted.whole().matrix != motions.frames.whole().matrix:
        # The direction in which the last motion ended was one of the frames before.
        motions.heading = None
    motions.frames = wanted
