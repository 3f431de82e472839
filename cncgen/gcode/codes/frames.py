"""FANUC's frames within a program: scaling G51, mirror images G51.1, rotation G68; polar coordinates G16.

The interpreter goes on in programmed coordinates; an `affine.FramedSink` between it and the sink turns its calls into work coordinates: ``work
= rotation (scaling (mirror (programmed)))``, the order of the manuals (B-63324EN, 14.6-14.9).
"""

from __future__ import annotations

import math

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.codes import affine, tilted_planes
from cncgen.gcode.codes.dwell import has_point
from cncgen.gcode.codes.lines import need_axis
from cncgen.gcode.codes.polar import polar_from
from cncgen.gcode.codes.table import OF_FANUC, ROTARY_PATH, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Point, Sink
from cncgen.gcode.state.modal import PLANE_AXES, Stage
from cncgen.gcode.text.dialects import bare
from cncgen.records import dataclass, field, replace

#: Factors of scaling from here on are in thousandths.
_THOUSANDTHS = 100.0
#: Codes of origins: G52, G54 to G59, G54.1, G92.
_ORIGINS = frozenset((520, 920, 541, *range(540, 600, 10)))


@dataclass(slots=True)
class CoordinateFrame:
    """The frame in force, in programmed coordinates of X Y Z.

    Attributes:
        mirror: Coordinate of the mirror by column.
        scale: Factor by column, about `scale_centre`.
        angle: Degrees, about `turn_centre`, in the plane of `plane`; both as they are behind mirror and scaling.
    """

    mirror: dict[int, float] = field(default_factory=dict)
    scale: list[float] = field(default_factory=lambda: [1.0, 1.0, 1.0])
    scale_centre: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    angle: float = 0.0
    turn_centre: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    plane: int = 17

    def whole(self) -> affine.Frame:
        """Return it as one affine map."""
        turned = affine.Frame()
        if self.angle:
            turn = affine.turn(PLANE_AXES[self.plane][2], self.angle)
            turned = affine.Frame.about(_vector(self.turn_centre), turn)
        return turned.then(self.unturned())

    def unturned(self) -> affine.Frame:
        """Return mirror and scaling as one affine map."""
        mirrored = affine.Frame()
        for axis, at in self.mirror.items():
            sides, centre = [1.0] * 3, [0.0] * 3
            sides[axis], centre[axis] = -1.0, at
            mirrored = affine.Frame.about(_vector(centre), affine.diagonal(*sides)).then(mirrored)
        scaled = affine.Frame.about(_vector(self.scale_centre), affine.diagonal(*self.scale))
        return scaled.then(mirrored)

    def check_arc(self, plane: int) -> None:
        """Raise where arcs of a plane stop being arcs."""
        first, second, normal = PLANE_AXES[plane]
        if abs(self.scale[first]) != abs(self.scale[second]):
            message = f"unequal scaling ({self.scale[first]:g}, {self.scale[second]:g}) turns an arc into an ellipse"
            hint = "scale both axes of the plane alike, or write lines"
            raise BlockError("arc-scaled", message, "", hint=hint)
        if self.angle and normal != PLANE_AXES[self.plane][2]:
            message = f"an arc of G{plane} under a rotation in G{self.plane} leaves its plane"
            raise BlockError("arc-turned", message, "", hint="G69 ends the rotation")


def _vector(point: list[float]) -> affine.Vector:
    return point[0], point[1], point[2]


class _FanucSink(affine.FramedSink):
    """Passes calls on in work coordinates; arcs that leave their plane are refused."""

    def __init__(self, inner: Sink, parts: CoordinateFrame, at: Point) -> None:
        super().__init__(inner, parts.whole(), at)
        self.parts = parts

    def snapshot(self) -> CoordinateFrame:
        """Return a key of this state."""
        return self.parts

    def factor(self, column: int) -> float:
        """Return by how much lengths along an axis are scaled."""
        return abs(self.parts.scale[column])

    def renew(self, ip: Interpreter) -> None:
        """Take another origin, which the frame goes along with.

        FANUC's manuals refuse these codes in a frame (B-63534EN, 14.6 to 14.9, "Limitation"); Mitsubishi's carry the centre along
        (M700V, 13.21), and Rockwell's 9/Series leaves the new system unturned.
        """
        number = next((n for n in ip.sink.block.g if n in _ORIGINS), 0)
        if number:
            name = f"G{number / 10:g}"
            message = f"{name} within a rotation, scaling or mirror image carries its centre along; FANUC's manuals forbid it there"
            hint = f"end the frame by G69, G50 or G50.1 before {name}, and begin it again behind it"
            ip.warn_once("frame-origin", message, name, hint)

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        self.parts.check_arc(plane)
        super().arc_feed(end, first, second, turns, plane)


def _change(ip: Interpreter, parts: CoordinateFrame) -> None:
    """Put another frame in force; the tool stays where it is in work coordinates."""
    frame = parts.whole()
    affine.stand(ip, frame, None if frame.idle() else lambda inner, at: _FanucSink(inner, parts, at))


def _current(ip: Interpreter) -> CoordinateFrame:
    if not isinstance(ip.sink, affine.FramedSink):
        return CoordinateFrame()
    if not isinstance(ip.sink, _FanucSink):
        message = "G50 to G51.1 and G68 do not go with a tilted plane"
        raise BlockError("frame-compensation", message, "", hint="G69 ends it")
    f = ip.sink.parts
    return CoordinateFrame(
        dict(f.mirror), list(f.scale), list(f.scale_centre), f.angle, list(f.turn_centre), f.plane
    )


def _factor(ip: Interpreter, letter: str, value: float) -> float:
    """Return a factor of G51: from 100 on it is in thousandths, as controls count that take no decimal point in it."""
    if abs(value) < _THOUSANDTHS:
        return value
    message = f"{letter.upper()}{value:g} of G51 is read as thousandths: a factor of {value / 1000.0:g}"
    ip.note_once("scale-thousandths", message, letter.upper(), "factors below 100 are as written")
    return value / 1000.0


def _angle(ip: Interpreter, block: Block) -> float:
    """Return the angle of G68; whole turns and more without a decimal point are thousandths of a degree, as R45000."""
    angle = block.words["r"]
    if (
        abs(angle) <= 360.0
        or ip.options.least_increment is not None
        or has_point(ip, block, "r") is not False
    ):
        return angle
    message = f"R{angle:g} of G68 is read as thousandths of a degree: {angle / 1000.0:g} degrees"
    ip.warn_once("scale-thousandths", message, "R", "an angle has a decimal point: R45.")
    return angle / 1000.0


def _added_to(ip: Interpreter, block: Block, angle: float, of_mach3: bool) -> float:
    """Return the angle that R of G68 is added to: under G91 it may be the angle in effect.

    FANUC's parameter 5400 bit 0 (B-63503EN, 11) and Haas's setting 73 tell whether G91 adds. A program that writes G91
    beside G68 counts on it (Haas 96-8000, O60684); a G91 from before may be there for the motions. Mach3 has I for it.
    """
    if ip.state.absolute or not angle:
        return 0.0
    if of_mach3:
        return angle if "i" in block.words else 0.0
    adds = 910 in block.g
    done = "added to" if adds else "taken in place of"
    message = f"R{block.words['r']:g} of G68 in G91 is {done} the {angle:g} degrees in effect"
    hint = "parameter 5400 bit 0 of FANUC and setting 73 of Haas decide it; G69 before G68 makes both alike"
    ip.warn_once("rotation-incremental", message, "R", hint)
    return angle if adds else 0.0


def scaling(ip: Interpreter, block: Block) -> None:
    """G51 X Y Z P, or I J K: scale about a point, in all axes or each by its own factor."""
    words = {letter: _factor(ip, letter, value) for letter, value in block.words.items() if letter in "pijk"}
    factors = [words.get(letter, words.get("p", 1.0)) for letter in "ijk"]
    if not words:
        message = "G51 has no factor P (or I J K)"
        raise BlockError("scale-missing", message, "G51", hint="G51 X0 Y0 P2 doubles")
    if 0.0 in factors:
        zero = next(letter for letter in "pijk" if words.get(letter) == 0.0)
        message = "G51 has a factor of 0, which leaves nothing"
        raise BlockError("scale-missing", message, zero.upper(), hint="G50 ends the scaling")
    affine.check_factors(factors, "G51")
    frame = _current(ip)
    frame.scale = factors
    frame.scale_centre = [block.words.get(letter, ip.state.position[k]) for k, letter in enumerate("xyz")]
    _change(ip, frame)


def no_scaling(ip: Interpreter, block: Block) -> None:
    """G50."""
    frame = _current(ip)
    frame.scale, frame.scale_centre = [1.0] * 3, [0.0] * 3
    _change(ip, frame)


def mirror(ip: Interpreter, block: Block) -> None:
    """G51.1 X Y Z: mirror about these coordinates."""
    frame = _current(ip)
    need_axis(block, "G51.1", "G51.1 X0 mirrors X about 0")
    frame.mirror.update(block.axes())
    _change(ip, frame)


def mirror_of_haas(ip: Interpreter, block: Block) -> None:
    """G101 X0 Y0 Z0: mirror these axes about zero, until G100 names them; raise where a word is not 0."""
    for letter in "xyz":
        if block.words.get(letter, 0.0) != 0.0:
            message = f"{letter.upper()}{block.words[letter]:g} of G101 is not 0: a mirror elsewhere than at zero is not read"
            raise BlockError("not-read", message, letter.upper(), hint="G51.1 mirrors about any place")
    mirror(ip, block)


def no_mirror(ip: Interpreter, block: Block) -> None:
    """G50.1 X Y Z: end the mirror images of these axes, or all of them; raise where T stands beside G100, a tool change on Brother's controls."""
    if 1000 in block.g and "t" in block.words:
        message = (
            "G100 T changes the tool on Brother's controls, and is not read; G100 of Haas ends mirror images"
        )
        hint = "T1 M6 changes the tool, and the next block goes on"
        raise BlockError("not-read", message, "G100", hint=hint)
    frame = _current(ip)
    axes = [AXIS_INDEX[letter] for letter in block.words if letter in "xyz"] or list(frame.mirror)
    for axis in axes:
        frame.mirror.pop(axis, None)
    _change(ip, frame)


def _has_vacant_angle(ip: Interpreter, block: Block) -> bool:
    """Tell whether R stands in the text of a block that has none: its parameter is vacant."""
    if ip.flow is None:
        return False
    source = ip.flow.subroutines.sources[block.source]
    return b"R" in bare(source.data[block.offset : source.line_end(block.offset)])


def rotation(ip: Interpreter, block: Block) -> None:
    """G68 X Y R: turn the plane about a point; Mach3 calls X and Y of the point A and B. With I J K it turns space (`tilted_planes`).

    The tool's place is the centre where X and Y are not given. Scaling carries the centre (B-63944EN-2, 6; Haas 96-8000, G68). In a mirror image of one axis of the plane the rotation is the other way
    round (SINUMERIK, ISO Milling, table 3-6).
    """
    of_mach3, direction = bool({"a", "b"} & block.words.keys()), {"i", "j", "k"} & block.words.keys()
    if "r" not in block.words and _has_vacant_angle(ip, block):
        hint = "what sets it was passed over, or never was; a control takes its parameter 5410, on Haas's mills setting 72"
        ip.warn("rotation-angle", "R of G68 has no value: the angle is taken as 0", "R", hint)
        block = replace(block, words={**block.words, "r": 0.0})
    if "r" not in block.words:
        raise BlockError("rotation-angle", "G68 has no angle R", "G68", hint="G68 X0 Y0 R30, in degrees")
    if direction and not of_mach3:
        tilted_planes.convert(ip, block, _angle(ip, block))
        return
    if of_mach3:
        words = {{"a": "x", "b": "y"}.get(letter, letter): value for letter, value in block.words.items()}
        if ip.state.plane != 17 or len(words) < len(block.words) or direction - {"i"}:
            message = "A and B of G68 are X and Y of the centre in G17 (Mach3)"
            hint = "write X and Y"
            raise BlockError("rotation-plane", message, "A" if "a" in block.words else "B", hint=hint)
        block = replace(block, words={"x": 0.0, "y": 0.0, **words})
    if max(PLANE_AXES[ip.state.plane]) > 2:
        plane = f"G{ip.state.plane / 10:g}"
        message = f"G68 turns X, Y and Z, and the plane is {plane}"
        raise BlockError("rotation-plane", message, "G68", hint="choose G17, G18 or G19")
    frame = _current(ip)
    inner, angle = frame.unturned(), _angle(ip, block)
    tool = inner.to_programmed(frame.whole().to_work(ip.state.position))
    centre = [block.words.get(letter, at) for letter, at in zip("xyz", tool, strict=False)]
    mirrored = math.prod(inner.matrix[axis][axis] for axis in PLANE_AXES[ip.state.plane][:2]) < 0.0
    if mirrored and any(inner.to_work(centre)[axis] != centre[axis] for axis in frame.mirror):
        message = "the centre of G68 is taken as programmed in the mirror image"
        hint = "G68 before G51.1, or a centre on the mirror's axis, leaves no choice"
        ip.warn_once("rotation-mirrored", message, "G68", hint)
    frame.angle = (-angle if mirrored else angle) + _added_to(ip, block, frame.angle, of_mach3)
    frame.turn_centre, frame.plane = inner.to_work(centre), ip.state.plane
    _change(ip, frame)


def no_rotation(ip: Interpreter, block: Block) -> None:
    """G69: no rotation, no tilted plane."""
    if isinstance(ip.sink, affine.AffineSink):
        _change(ip, CoordinateFrame())
        return
    frame = _current(ip)
    frame.angle, frame.turn_centre = 0.0, [0.0] * 3
    _change(ip, frame)


def polar_on(ip: Interpreter, block: Block) -> None:
    """G16: the plane's first axis word is a radius, the second an angle."""
    ip.state.polar = polar_from(ip.state)


def polar_off(ip: Interpreter, block: Block) -> None:
    """G15."""
    ip.state.polar = None


CODES = (
    Code("G", 500, "scaling", Stage.COORDINATES, no_scaling, "no scaling", dialects=OF_FANUC,
        refused=("changes the frame", ROTARY_PATH), without="lathes"),
    Code("G", 510, "scaling", Stage.REFERENCE, scaling, "scaling by P, or I J K", "xyzpijk", "own", dialects=OF_FANUC,
        without="lathes"),
    Code("G", 501, "mirror", Stage.REFERENCE, no_mirror, "no mirror image", "xyz", "own", dialects=OF_FANUC, without="lathes"),
    Code("G", 1000, "mirror", Stage.REFERENCE, no_mirror, "no mirror image (Haas)", "xyz", "own", dialects=OF_FANUC,
        without="lathes"),
    Code("G", 1010, "mirror", Stage.REFERENCE, mirror_of_haas, "mirror image about 0 (Haas)", "xyz", "own", dialects=OF_FANUC,
        without="lathes"),
    Code("G", 511, "mirror", Stage.REFERENCE, mirror, "mirror image", "xyz", "own", dialects=OF_FANUC, without="lathes"),
    Code("G", 680, "rotation", Stage.REFERENCE, rotation, "rotation by R degrees", "xyzabijkr", "own", dialects=OF_FANUC,
        moves="plane", without="lathes"),
    Code("G", 690, "rotation", Stage.COORDINATES, no_rotation, "no rotation", dialects=OF_FANUC, without="lathes"),
    Code("G", 2690, "rotation", Stage.COORDINATES, no_rotation, "end of G268 (Haas)", dialects=OF_FANUC, without="lathes"),
    Code("G", 160, "polar", Stage.DISTANCE, polar_on, "polar coordinates", dialects=OF_FANUC, moves="plane", without="lathes"),
    Code("G", 150, "polar", Stage.DISTANCE, polar_off, "no polar coordinates", dialects=OF_FANUC, without="lathes"),
)  # fmt: skip
