"""Tilted planes of Heidenhain's plain language as frames: PLANE SPATIAL, EULER, RELATIV, POINTS, VECTOR, AXIAL, RESET, cycle 19 (TNC 640,
"PLANE function").

Spatial angles turn about the machine's X (SPA), then its Y (SPB), then its Z (SPC). `tilting` turns the machine's rotary axes.
"""

from __future__ import annotations

from collections.abc import Mapping

from cncgen.gcode.codes import affine
from cncgen.gcode.errors import BlockError
from cncgen.machine.kinematics import Kinematics

#: The kinematics of a machine, and where its rotary axes stand, degrees, the carrying one first.
Machine = tuple[Kinematics, tuple[float, float]]
WORDS: dict[str, tuple[str, ...]] = {
    "SPATIAL": ("SPA", "SPB", "SPC"),
    "EULER": ("EULPR", "EULNU", "EULROT"),
    "RELATIV": ("SPA", "SPB", "SPC"),
    "RELATIVE": ("SPA", "SPB", "SPC"),
    "POINTS": tuple(f"P{number}{axis}" for number in "123" for axis in "XYZ"),
    "VECTOR": ("BX", "BY", "BZ", "NX", "NY", "NZ"),
    "AXIAL": ("A", "B", "C"),
}


def dwell_s(unit: str, value: float, speed: float) -> float:
    """Return the seconds of FUNCTION DWELL, of whose revolutions the spindle makes `speed` a minute."""
    if unit == "TIME":
        return value
    if speed <= 0.0:
        message = "FUNCTION DWELL REV waits for a spindle that has no speed"
        raise BlockError("spindle-stopped", message, "FUNCTION", hint="TOOL CALL 5 Z S500")
    return value * 60.0 / speed


def matrix(
    name: str, words: Mapping[str, float], before: affine.Matrix, machine: Machine | None = None
) -> affine.Matrix | None:
    """Return the rotation of a PLANE block, None where it turns nothing; raise where the plane is defined otherwise.

    SPATIAL turns about the fixed X, Y, Z; EULER about Z, the new X, the new Z; RELATIV about an axis of the plane in force; POINTS has
    X from its first to its second point and Y towards the third; VECTOR has the direction B of X, and N of Z square to it; AXIAL names positions
    of the machine's rotary axes, of which one that is not named stays where `machine` has it. The origin stays.
    """
    if name == "RESET":
        return None
    if name == "SPATIAL":
        return spatial(_angles(words, ("SPA", "SPB", "SPC")))
    if name == "EULER":
        first, nutation, last = _angles(words, ("EULPR", "EULNU", "EULROT"))
        turned = affine.product(affine.turn(0, nutation), affine.turn(2, last))
        return affine.product(affine.turn(2, first), turned)
    if name in ("RELATIV", "RELATIVE"):
        turned = before
        for axis, angle in enumerate(_angles(words, ("SPA", "SPB", "SPC"))):
            turned = affine.product(turned, affine.turn(axis, angle))
        return turned
    if name == "POINTS":
        return _through(words)
    if name == "VECTOR":
        base, normal = _angles(words, ("BX", "BY", "BZ")), _angles(words, ("NX", "NY", "NZ"))
        return _axes(base, normal)
    if name == "AXIAL":
        return _of_axes(named_axes(words), machine)
    hint = "PLANE SPATIAL, EULER, RELATIV, POINTS, VECTOR, AXIAL and RESET are"
    raise BlockError("unsupported-block", f"PLANE {name} is not read", "PLANE", hint=hint)


def _through(words: Mapping[str, float]) -> affine.Matrix:
    """Return the rotation of three points."""
    first, *points = (_angles(words, (f"P{number}X", f"P{number}Y", f"P{number}Z")) for number in "123")
    along, aside = ((p[0] - first[0], p[1] - first[1], p[2] - first[2]) for p in points)
    return _axes(along, affine.cross(along, aside))


def _axes(along: affine.Vector, normal: affine.Vector) -> affine.Matrix:
    """Return the rotation with Z along a normal, and X along the part of a direction that is orthogonal to it."""
    message = "the points or vectors of PLANE have no plane between them"
    hint = "points on no line, vectors that are not parallel"
    fault = BlockError("plane-points", message, "PLANE", hint=hint)
    z = affine.unit(normal, fault)
    y = affine.unit(affine.cross(z, along), fault)
    return affine.of_columns(affine.cross(y, z), y, z)


def named_axes(words: Mapping[str, float]) -> dict[int, float]:
    """Return the columns of rotary axes (3 is A) and their positions that PLANE AXIAL names."""
    return {column: words[letter] for column, letter in enumerate("ABC", 3) if letter in words}


_SPIN = 5


def is_guessed(words: Mapping[str, float]) -> bool:
    """Tell whether PLANE AXIAL turns C and another axis, whose plane depends on which of them carries the other."""
    turned = {column for column, angle in named_axes(words).items() if angle}
    return len(turned) > 1 and _SPIN in turned


def _of_axes(named: Mapping[int, float], machine: Machine | None) -> affine.Matrix | None:
    """Return the rotation of the plane square to the tool while rotary axes stand at these positions.

    Without a machine A or B tilts, and C turns: a table C on A or B, or a head A or B on C, which have the same plane.

    Raises:
        BlockError: Two of them turn, and no machine says which carries the other; or the machine does not have them.
    """
    if machine is not None:
        kinematics, now = machine
        if not set(named) <= set(kinematics.axes):
            message = "PLANE AXIAL names an axis that [kinematics] of the machine does not have"
            raise BlockError("plane-kind", message, "PLANE", hint="its two axes are those of the machine")
        outer, inner = (named.get(column, at) for column, at in zip(kinematics.axes, now, strict=True))
        return kinematics.turned_plane((outer, inner)) if outer or inner else None
    turned = {column: angle for column, angle in named.items() if angle}
    spin = turned.pop(_SPIN, 0.0)
    if len(turned) > 1:
        message = "PLANE AXIAL turns axes of which the machine does not say how they carry each other"
        raise BlockError("plane-kind", message, "PLANE", hint="[kinematics] of the machine's file says it")
    tilted = next((affine.turn(column - 3, angle) for column, angle in turned.items()), None)
    return affine.product(affine.turn(2, spin), tilted or affine.UNIT) if spin else tilted


def of_cycle(words: Mapping[str, float]) -> tuple[float, float, float]:
    """Return the angles A B C of cycle 19; an angle that is left out is 0."""
    return _angles(words, ("A", "B", "C"))


def _angles(words: Mapping[str, float], names: tuple[str, str, str]) -> tuple[float, float, float]:
    a, b, c = (words.get(name, 0.0) for name in names)
    return a, b, c


def spatial(angles: tuple[float, float, float]) -> affine.Matrix | None:
    """Return the rotation of spatial angles, None where they turn nothing."""
    if not any(angles):
        return None
    a, b, c = angles
    return affine.product(affine.turn(2, c), affine.product(affine.turn(1, b), affine.turn(0, a)))
