"""Frames of Heidenhain's plain language: cycles 7, 8, 10, 11, 19 and 26, TRANS of TNC 7, and tilted planes.

They apply in the order in which the program gives them; one that is given again keeps its place. A datum shift that is given again in a
tilted plane shifts the tilted coordinates, and the one before the plane stays (iTNC 530, cycle 19, "Combining coordinate transformation
cycles": shifts, tilt and rotation are reset in the reverse order).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from cncgen.gcode.block import AXES, Value
from cncgen.gcode.codes import affine, carried_planes
from cncgen.gcode.codes.offsets import set_g92
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import planes, tables, tilting, unread
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.plain_language import Raw
from cncgen.records import replace

_NUMBERS = {"DATUM": 7, "MIRROR": 8, "ROTATION": 10, "SCALE": 11}
#: The word of TRANS DATUM TABLE for the row of a table of datums; cycle 7 has # for it.
_ROW = "TABLINE"
#: The words of each frame; values that change nothing may stand beside them, and names without a value.
_WORDS = {
    7: {"X", "Y", "Z", "IX", "IY", "IZ", _ROW}, 8: {"X", "Y", "Z"}, 10: {"ROT", "IROT"}, 11: {"SCL"},
    26: {"X", "Y", "Z", "CCX", "CCY", "CCZ"},
}  # fmt: skip
#: What a value is that changes nothing: of factors 1.
_NEUTRAL = {26: 1.0}
#: The number of a tilted plane among the frames, and of a shift within it where another one stands before it.
_TILTED, _SHIFT_WITHIN = 19, 107


class Datums:
    """The frames in force, by the numbers of their cycles.

    Args:
        ip: The interpreter whose coordinates they change.
        now: Gives the present value of a word.
    """

    def __init__(self, ip: Interpreter, now: Callable[[Value], float]) -> None:
        self._ip, self._now = ip, now
        self._frames: dict[int, affine.Frame] = {}
        #: The table of datums that SEL TABLE has chosen: its name, and its rows by their numbers.
        self._table = ""
        self._rows: dict[int, dict[str, float]] = {}
        #: Shifts of the other axes, by their columns.
        self._of_axes: dict[int, float] = {}
        #: Positions of the rotary axes for which the tilted plane is meant.
        self._axes: affine.Positions | None = None
        self._angle = 0.0

    def choose(self, text: str, name: str) -> None:
        """SEL TABLE: take the rows of a table of datums (.D), by their numbers NR (D on newer controls)."""
        found = tables.rows(text, name, "table of datums")
        self._table = name
        self._rows = {round(row.get("NR", row.get("D", k))): row for k, row in enumerate(found)}

    def take(self, number: int, frame: affine.Frame | None) -> None:
        """Put a frame in force, or end it."""
        wanted = dict(self._frames)
        if frame is None:
            wanted.pop(number, None)
        else:
            wanted[number] = frame
        whole, before = _joined(wanted), _joined(self._frames)
        affine.change(self._ip, whole, self._axes)
        self._frames = wanted
        if whole.matrix != before.matrix:
            # The direction in which the last motion ended was one of the frame before.
            Plain.of(self._ip).heading = None

    def untransform(self) -> None:
        """End every frame but the tilted plane, as a preset does (iTNC 530, "Datum setting (cycle 247)": shift, mirroring, rotation and
        scaling factors)."""
        self._angle = 0.0
        self._end_axes()
        for number in [*self._frames]:
            if number != _TILTED:
                self.take(number, None)

    def of_cycle(self, number: int, rest: str) -> None:
        """Take the words of a cycle's frame; raise where an angle or factor is missing, or cannot be."""
        self.set(number, plain_language.words_of(rest.replace("#", f"{_ROW} ")))

    def set(self, number: int, given: Sequence[Raw]) -> None:
        """Do the same with words that are read."""
        words = {name: self._now(value) for name, value in given if value == value}
        self._refuse_others(number, given, words)
        if number == 7 and _ROW in words:
            self._shift_by_table(round(words[_ROW]))
        elif number == 7:
            self._shift_axes({name: value for name, value in words.items() if name not in _WORDS[7]})
            self._shift(words)
        elif number == 8:
            named = "".join(name for name, _ in given)
            sides = (-1.0 if axis in named else 1.0 for axis in "XYZ")
            self.take(8, affine.Frame(affine.diagonal(*sides)) if named else None)
        elif number == 10:
            if not words.keys() & {"ROT", "IROT"}:
                message = "cycle 10 has no angle ROT"
                raise BlockError("rotation-angle", message, "CYCL", hint="CYCL DEF 10.1 ROT+35")
            self._angle = words["ROT"] if "ROT" in words else self._angle + words["IROT"]
            self.take(10, affine.Frame(affine.turn(2, self._angle)) if self._angle else None)
        elif number == 11:
            factor = words.get("SCL", 0.0)
            self.take(11, _scaled(11, [factor] * 3, [0.0] * 3, "CYCL DEF 11.1 SCL 0.75; SCL 1 ends it"))
        elif number == 26:
            factors = [words.get(axis, 1.0) for axis in "XYZ"]
            centre = [words.get(f"CC{axis}", 0.0) for axis in "XYZ"]
            self.take(26, _scaled(26, factors, centre, "CYCL DEF 26.1 X1.2 Y0.8; 1 ends it"))
        else:
            unread.tell(self._ip, "cycle 19", given, {"A", "B", "C"} | tilting.WORDS)
            wanted = tilting.words_of(given, self._now)
            how = "TURN" if wanted.feed or wanted.below else "STAY"
            self._tilt(planes.spatial(planes.of_cycle(words)), replace(wanted, how=how))

    def _refuse_others(self, number: int, given: Sequence[Raw], words: Mapping[str, float]) -> None:
        """Raise where a frame has a word that is not read, as mirror images and factors of rotary axes."""
        known = _WORDS.get(number)
        for name, _ in given:
            axis = name.removeprefix("I") in AXES.upper()
            if name in words:
                idle = words[name] == _NEUTRAL.get(number, 0.0) or (axis and number == 7)
            else:
                idle = not (axis and number == 8)
            if known is not None and name not in known and not idle:
                message = f"{name} of cycle {number} is not read"
                raise BlockError("not-read", message, "CYCL", hint=f"{', '.join(sorted(known))} are")

    def transform(self, kind: str, words: Sequence[Raw]) -> None:
        """Do TRANS DATUM, MIRROR, ROTATION or SCALE; raise where it is another transformation."""
        if kind not in _NUMBERS:
            hint = f"{', '.join(_NUMBERS)} are"
            raise BlockError("unsupported-block", f"TRANS {kind} is not read", "TRANS", hint=hint)
        number, flags = _NUMBERS[kind], {name for name, value in words if value != value}
        if "RESET" in flags:
            self._angle = 0.0 if number == 10 else self._angle
            self.take(number, None)
            if number == 7:
                self._end_axes()
                self.take(_SHIFT_WITHIN, None)
        else:
            self.set(number, [word for word in words if word[0] != "AXIS"])

    def plane(self, kind: str, words: Sequence[Raw]) -> None:
        """PLANE: a tilted plane, or the end of it (`planes.matrix`)."""
        unread.tell(self._ip, f"PLANE {kind}", words, tilting.WORDS.union(planes.WORDS.get(kind, ())))
        before = self._frames.get(_TILTED, affine.Frame()).matrix
        kinematics = self._ip.options.kinematics
        machine = None if kinematics is None else (kinematics, carried_planes.positions(self._ip, kinematics))
        given = {name: self._now(value) for name, value in words if value == value}
        matrix, wanted = planes.matrix(kind, given, before, machine), tilting.words_of(words, self._now)
        if kind == "AXIAL" and machine is None and planes.is_guessed(given):
            message = "without a machine, C of PLANE AXIAL is taken as a table on the other axis, or as what carries it in a head"
            hint = "[kinematics] of the machine's file says which axis carries the other"
            self._ip.warn_once("plane-axes", message, "PLANE", hint)
        axes = None
        if machine and kind == "AXIAL":
            named = planes.named_axes(given)
            outer, inner = (named.get(k, at) for k, at in zip(machine[0].axes, machine[1], strict=True))
            axes = outer, inner
        self._tilt(matrix, wanted, axes, ends=kind == "RESET")

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
            self._ip.warn_once("swivel-frame", message, "PLANE", hint)
        found = dict(zip(kinematics.axes, axes, strict=True)) if kinematics and axes else {}
        for column, number in ((3, 120), (4, 121), (5, 122)):
            turns = Plain.of(self._ip).turns.get(column, 0)
            self._ip.parameters.set_number(float(number), found.get(column, 360.0 * turns) - 360.0 * turns)
        self._axes = None if ends else axes
        self.take(_TILTED, None if matrix is None else affine.Frame(matrix))

    def _shift(self, words: Mapping[str, float]) -> None:
        number = self._place_of_shift()
        old = self._frames.get(number, affine.Frame()).shift
        x, y, z = (
            words.get(axis, words[f"I{axis}"] + before if f"I{axis}" in words else before)
            for axis, before in zip("XYZ", old, strict=True)
        )
        self._take_shift(number, x, y, z)

    def _shift_axes(self, words: Mapping[str, float]) -> None:
        """Shift the datum of axes beside X, Y and Z; raise where a machine's kinematics or a plane hang on where rotary axes stand."""
        for name, value in words.items():
            axis = name.removeprefix("I")
            if axis not in AXES.upper():
                continue
            column = AXES.index(axis.lower())
            before = self._of_axes.get(column, 0.0)
            shift = value + before if name != axis else value
            if shift == before:
                continue
            if self._ip.options.kinematics is not None or _TILTED in self._frames:
                message = f"a datum shift of {axis} beside [kinematics] or a tilted plane is not read"
                hint = "positions of rotary axes that are written with the shift are read"
                raise BlockError("not-read", message, "CYCL", hint=hint)
            offset = self._ip.state.g92.copy()
            offset[column] += shift - before
            self._of_axes[column] = shift
            set_g92(self._ip, offset)

    def _end_axes(self) -> None:
        """End the shifts of axes beside X, Y and Z."""
        self._shift_axes({AXES[column].upper(): 0.0 for column in self._of_axes})

    def _place_of_shift(self) -> int:
        """Return which of two shifts is meant: that within a tilted plane where one stands before it."""
        places = [*self._frames]
        before = {7, _TILTED}.issubset(places) and places.index(7) < places.index(_TILTED)
        return _SHIFT_WITHIN if before else 7

    def _take_shift(self, number: int, x: float, y: float, z: float) -> None:
        if number == _SHIFT_WITHIN:
            message = "a datum shift within a tilted plane shifts the tilted coordinates, and the shift before the plane stays"
            hint = "PLANE RESET before the shift leaves no doubt"
            self._ip.warn_once("shift-tilted", message, "CYCL", hint)
        else:
            # Without a plane there is one shift.
            self.take(_SHIFT_WITHIN, None)
        self.take(number, affine.Frame(shift=(x, y, z)) if x or y or z else None)

    def _shift_by_table(self, number: int) -> None:
        """Shift by a row of the table of datums: X Y Z from the preset.

        Raises:
            BlockError: No table is chosen, it has no such row, or the row shifts another axis.
        """
        row = self._rows.get(number)
        if row is None:
            where = f"{self._table} has no row" if self._table else "no SEL TABLE names the table of row"
            message = f"{where} {number} that the datum shift takes"
            hint = 'SEL TABLE "NAME.D" before it, the file beside the program'
            raise BlockError("datum-missing", message, "CYCL", hint=hint)
        turned = next((axis for axis in "ABCUVW" if row.get(axis)), None)
        if turned:
            message = f"row {number} of {self._table} shifts {turned}, which is not read"
            raise BlockError("not-read", message, "CYCL", hint="X, Y and Z are")
        x, y, z = (row.get(axis, 0.0) for axis in "XYZ")
        self._take_shift(self._place_of_shift(), x, y, z)


def _scaled(number: int, factors: list[float], centre: list[float], hint: str) -> affine.Frame | None:
    """Return the frame of factors about a centre; None where they change nothing; raise where a factor is 0 or less."""
    if min(factors) <= 0.0:
        message = f"cycle {number} has the factor {min(factors):g}"
        raise BlockError("scale-missing", message, "CYCL", hint=hint)
    if factors == [1.0, 1.0, 1.0]:
        return None
    return affine.Frame.about((centre[0], centre[1], centre[2]), affine.diagonal(*factors))


def _joined(frames: Mapping[int, affine.Frame]) -> affine.Frame:
    """Return frames, each within those before it, as one."""
    whole = affine.Frame()
    for part in frames.values():
        whole = whole.then(part)
    return whole
