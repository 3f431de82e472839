"""Frames of Heidenhain's plain language: cycles 7, 8, 10, 11, 19 and 26, TRANS of TNC 7, and tilted planes.

They apply in the order in which the program gives them; one that is given again keeps its place.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from cncgen.gcode.codes import affine, carried_planes
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import planes, tilting
from cncgen.records import replace

_VALUE = r"\s*((?:[-+]\s*)?(?:Q\d+|\d++[.,]?+\d*+|[.,]\d+))"
_TRANS = re.compile(
    r"TRANS\s+(?P<kind>DATUM|MIRROR|ROTATION|SCALE)\b(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL
)
_NUMBERS = {"DATUM": 7, "MIRROR": 8, "ROTATION": 10, "SCALE": 11}
#: The number of a tilted plane among the frames.
_TILTED = 19


class Datums:
    """The frames in force, by the numbers of their cycles.

    Args:
        ip: The interpreter whose coordinates they change.
        value: What a number or parameter of the text stands for.
    """

    def __init__(self, ip: Interpreter, value: Callable[[str], float]) -> None:
        self._ip, self._value = ip, value
        self._frames: dict[int, affine.Frame] = {}
        #: Positions of the rotary axes for which the tilted plane is meant.
        self._axes: affine.Positions | None = None
        self._angle = 0.0

    def take(self, number: int, frame: affine.Frame | None) -> None:
        """Put a frame in force, or end it."""
        wanted = dict(self._frames)
        if frame is None:
            wanted.pop(number, None)
        else:
            wanted[number] = frame
        whole = affine.Frame()
        for part in wanted.values():
            whole = whole.then(part)
        affine.change(self._ip, whole, self._axes)
        self._frames = wanted

    def set(self, number: int, rest: str) -> None:
        """Take the words of a cycle's frame.

        Raises:
            BlockError: An angle or factor is missing, or cannot be.
        """
        if number == 7:
            self._shift(rest)
        elif number == 8:
            letters = [letter for letter in rest.upper() if letter in "XYZ"]
            self.take(8, _along([-1.0 if axis in letters else 1.0 for axis in "XYZ"]) if letters else None)
        elif number == 10:
            found = re.search(r"(I?)ROT" + _VALUE, rest, re.IGNORECASE)
            if found is None:
                raise BlockError(
                    "rotation-angle", "cycle 10 has no angle ROT", "CYCL", hint="CYCL DEF 10.1 ROT+35"
                )
            self._angle = self._value(found[2]) + (self._angle if found[1] else 0.0)
            self.take(10, affine.Frame(affine.turn(2, self._angle)) if self._angle else None)
        elif number == 11:
            found = re.search(r"SCL" + _VALUE, rest, re.IGNORECASE)
            factor = self._value(found[1]) if found else 0.0
            self.take(11, _scaled(11, [factor] * 3, [0.0] * 3, "CYCL DEF 11.1 SCL 0.75; SCL 1 ends it"))
        elif number == 26:
            factors, centre = [1.0, 1.0, 1.0], [0.0, 0.0, 0.0]
            for word in re.finditer(r"(CC)?([XYZ])" + _VALUE, rest, re.IGNORECASE):
                (centre if word[1] else factors)["XYZ".index(word[2].upper())] = self._value(word[3])
            self.take(26, _scaled(26, factors, centre, "CYCL DEF 26.1 X1.2 Y0.8; 1 ends it"))
        else:
            wanted = tilting.words_of(rest, self._value)
            how = "TURN" if wanted.feed or wanted.below else "STAY"
            self._tilt(planes.spatial(planes.of_cycle(rest, self._value)), replace(wanted, how=how))

    def transform(self, body: str) -> bool:
        """Do TRANS DATUM, MIRROR, ROTATION or SCALE; tell whether the line is one of them."""
        match = _TRANS.match(body)
        if match is None:
            return False
        number, rest = _NUMBERS[match["kind"].upper()], match["rest"]
        if re.match(r"\s*RESET\b", rest, re.IGNORECASE):
            self._angle = 0.0 if number == 10 else self._angle
            self.take(number, None)
        elif number == 7 and re.match(r"\s*TABLE\b", rest, re.IGNORECASE):
            self._shift("#")
        else:
            self.set(number, re.sub(r"^\s*AXIS\b", "", rest, flags=re.IGNORECASE))
        return True

    def plane(self, body: str) -> None:
        """PLANE: a tilted plane, or the end of it (`planes.matrix`)."""
        before = self._frames.get(_TILTED, affine.Frame()).matrix
        kinematics = self._ip.options.kinematics
        machine = None if kinematics is None else (kinematics, carried_planes.positions(self._ip, kinematics))
        matrix, wanted = (
            planes.matrix(body, self._value, before, machine),
            tilting.words_of(body, self._value),
        )
        axes = None
        if machine and re.match(r"PLANE\s+AXIAL\b", body, re.IGNORECASE):
            named = planes.named_axes(body, self._value)
            outer, inner = (named.get(k, at) for k, at in zip(machine[0].axes, machine[1], strict=True))
            axes = outer, inner
        self._tilt(matrix, wanted, axes, ends=bool(planes.RESET.match(body)))

    def _tilt(
        self,
        matrix: affine.Matrix | None,
        wanted: tilting.Turning,
        axes: affine.Positions | None = None,
        *,
        ends: bool = False,
    ) -> None:
        """Put a tilted plane in force, or end it; Q120 to Q122 are where the rotary axes belong, 0 where no machine says so."""
        kinematics = self._ip.options.kinematics
        if kinematics is not None:
            if axes is None:
                axes = (
                    (0.0, 0.0)
                    if ends
                    else tilting.axes_of(self._ip, kinematics, matrix or affine.UNIT, wanted)
                )
            tilting.turn(self._ip, kinematics, axes, wanted)
        elif matrix is not None:
            message = (
                "the tilted plane turns the coordinates; the rotary axes of the machine are not moved here"
            )
            hint = "--machine with a table [kinematics] turns them"
            self._ip.warn_once(BlockError("swivel-frame", message, "PLANE", hint=hint))
        found = dict(zip(kinematics.axes, axes, strict=True)) if kinematics and axes else {}
        for column, number in ((3, 120), (4, 121), (5, 122)):
            self._ip.parameters.set_number(float(number), found.get(column, 0.0))
        self._axes = None if ends else axes
        self.take(_TILTED, None if matrix is None else affine.Frame(matrix))

    def _shift(self, rest: str) -> None:
        if "#" in rest:
            raise BlockError(
                "unsupported-block",
                "a datum shift by a line of a table is not read",
                "CYCL",
                hint="CYCL DEF 7.1 X+10 gives it",
            )
        old = self._frames.get(7, affine.Frame()).shift
        shift = list(old)
        for word in re.finditer(r"(I?)([XYZ])" + _VALUE, rest, re.IGNORECASE):
            column = "XYZ".index(word[2].upper())
            shift[column] = self._value(word[3]) + (old[column] if word[1] else 0.0)
        self.take(7, affine.Frame(shift=(shift[0], shift[1], shift[2])) if any(shift) else None)


def _along(factors: list[float], shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> affine.Frame:
    """Return the frame with a factor for each axis."""
    a, b, c = factors
    return affine.Frame(((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c)), shift)


def _scaled(number: int, factors: list[float], centre: list[float], hint: str) -> affine.Frame | None:
    """Return the frame of factors about a centre; None where they change nothing.

    Raises:
        BlockError: A factor is 0 or less.
    """
    if min(factors) <= 0.0:
        message = f"cycle {number} has the factor {min(factors):g}"
        raise BlockError("scale-missing", message, "CYCL", hint=hint)
    if factors == [1.0, 1.0, 1.0]:
        return None
    x, y, z = (middle * (1.0 - factor) for middle, factor in zip(centre, factors, strict=True))
    return _along(factors, (x, y, z))
