"""Paths that a linear and a rotary axis make together: polar coordinate interpolation G12.1 (G112), cylindrical interpolation G7.1 (G107).

While one is in force, the interpreter works in a plane of the part, in X Y Z. In G12.1 Y is the hypothetical axis that the word C
names; in G7.1 the plane is the unrolled surface of the cylinder. A `RotarySink` before the sink turns motions into those of the axes,
in lines, as many as the tolerance needs; F is the speed on the part (B-64304EN-1, "Polar coordinate interpolation", "Cylindrical
interpolation"). Blocks of G112 with words of Y have Haas's form: X is then a radius (Haas lathe operator's manual, "G112").
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Iterator

from cncgen.gcode.block import Block
from cncgen.gcode.budget import MOTION
from cncgen.gcode.codes.followed_paths import LOOK_DEGREES, FollowedSink, Path
from cncgen.gcode.codes.table import LATHE, ROTARY_PATH, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Point, Sink
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.text.dialects import bare
from cncgen.records import replace

_X, _Y = 0, 1
#: How far lines of the axes may be from the path, mm, and halvings of a step until they are.
_TOLERANCE_MM = 0.001
_MAX_DEPTH = 20
#: Turn of the rotary axis by which the lever is found, degrees.
_TURN = 0.1
#: Codes with a sense of turning and the ones of the other sense: on the cylinder of G18 the second axis of the plane comes first here.
_TURNED = {20: 30, 30: 20, 410: 420, 420: 410}
_OWN_Y = re.compile(rb"Y[-+.\d#\[]")
_OFF = re.compile(rb"G1(?:13|3\.1)(?!\d)")

#: Program coordinates of the axes for a point of the plane, the rotary axis next to an angle.
Shown = Callable[[Point, float], Point]


class RotarySink(FollowedSink):
    """Passes motions in the part's plane on as motions of the axes.

    Attributes:
        rotary: Column of the rotary axis.
        rewritten: Takes the words of a block as those of the plane.
    """

    fault, remedy, under = "rotary-refused", "end it before", ROTARY_PATH

    def __init__(
        self,
        inner: Sink,
        ip: Interpreter,
        name: str,
        rotary: int,
        shown: Shown,
        seen: Callable[[Point], Point],
    ) -> None:
        super().__init__(inner, ip, name)
        self.rotary = rotary
        self.plane_before = ip.state.plane
        self._shown, self._seen = shown, seen
        self._angle = self._at[rotary]

    def axes(self) -> Point:
        """Return program coordinates of where the axes stand."""
        return self.shown(self._at)

    def stand(self, position: Point, angle: float) -> None:
        """Begin at a point of the part with the rotary axis at an angle."""
        self._at, self._angle = list(position), angle

    def shown(self, point: Point) -> Point:
        """Return the axes for a point of the part, the rotary one next to where it stands."""
        return self._shown(point, self._angle)

    def lever(self, point: Point) -> float:
        """Return how far the tip goes as the rotary axis turns, in length units a radian, at a point of the part."""
        axes = self.shown(point)
        turned = [*axes]
        turned[self.rotary] += _TURN
        return math.dist(self._seen(axes)[:3], self._seen(turned)[:3]) / math.radians(_TURN)

    def _led(self, point: Point) -> Point:
        """Return the axes for a point of the part, and stand there."""
        axes = super()._led(point)
        self._angle = axes[self.rotary]
        return axes

    def _rate_of(self, path: Path, length: float) -> float:
        """Return how often a minute the motion could be made at F."""
        state = self.ip.state
        return state.feed * (state.speed if state.feed_mode == 95 else 1.0) / length if length else 0.0

    def _pieces(self, path: Path, begin: Point, length: float, sweep: float) -> Iterator[tuple[float, Point]]:
        """Yield place on the path (0 to 1) and program coordinates of the ends of the axes' lines."""
        done, count = 0.0, max(1, math.ceil(sweep / LOOK_DEGREES))
        for k in range(1, count + 1):
            for t, point in self._halved(path, done, begin, k / count, _MAX_DEPTH):
                self.ip.budget.spend(MOTION)
                yield t, point
                done, begin = t, point
                self._angle = point[self.rotary]

    def _halved(
        self, path: Path, t0: float, before: Point, t1: float, depth: int
    ) -> Iterator[tuple[float, Point]]:
        """Yield a step, or its halves where the middle of the axes' line is farther from the path than the tolerance."""
        after = self._shown(path(t1), before[self.rotary])
        middle = (t0 + t1) / 2.0
        there = self._seen([(p + q) / 2.0 for p, q in zip(before, after, strict=True)])
        off = math.dist(there[:3], path(middle)[:3]) * self.ip.state.unit_mm
        if depth and off > _TOLERANCE_MM:
            left = before
            for t, point in self._halved(path, t0, before, middle, depth - 1):
                yield t, point
                left = point
            yield from self._halved(path, middle, left, t1, depth - 1)
        else:
            yield t1, after


def _start(
    ip: Interpreter, name: str, rotary: int, plane: int, shown: Shown, seen: Callable[[Point], Point]
) -> None:
    """Put the sink in force; raise where another one, a frame or cutter compensation is on."""
    if ip.sink is not ip.base or ip.state.compensation != 40:
        hint = "G40, G69, G49 or the code that ends the other one before it"
        message = f"{name} does not go with cutter compensation, frames, G43.4, or another interpolation of its kind"
        raise BlockError("rotary-refused", message, name, hint=hint)
    sink = RotarySink(ip.base, ip, name, rotary, shown, seen)
    ip.sink = sink
    ip.state.position[_Y] = 0.0
    sink.place(ip.state.position)
    ip.state.plane = plane
    ip.base.select_plane(plane)


def face(ip: Interpreter, name: str) -> None:
    """Put X and Y of the face of the part in force where X stands for the radius and C for the angle from 0, as TRANSMIT has it."""
    begin, other = ip.state.position.copy(), ip.state.position[_Y]

    def shown(point: Point, near: float) -> Point:
        return _on_face(point, near, 0.0, math.copysign(1.0, begin[_X]), other)

    def seen(axes: Point) -> Point:
        spoke = cmath.rect(axes[_X], math.radians(axes[5]))
        return [spoke.real, spoke.imag, *axes[2:]]

    _start(ip, name, 5, 17, shown, seen)
    assert isinstance(ip.sink, RotarySink)
    ip.state.position = seen(begin)
    ip.sink.stand(ip.state.position, begin[5])


def _on_face(point: Point, near: float, begin: float, side: float, other: float) -> Point:
    """Return the axes for a point of the face, C next to an angle; X keeps its side."""
    spoke = side * complex(point[_X], point[_Y])
    angle = begin + math.degrees(cmath.phase(spoke)) if spoke else near
    out = [side * abs(spoke), other, *point[2:]]
    out[5] = angle + 360.0 * round((near - angle) / 360.0)
    return out


def end(ip: Interpreter, name: str) -> bool:
    """End such a path; tell whether one was in force."""
    if not isinstance(ip.sink, RotarySink) and ip.state.compensation == 40:
        return False
    _end(ip, name)
    return True


def _end(ip: Interpreter, name: str) -> None:
    """Take the sink away; the axes stay where they are."""
    if ip.state.compensation != 40:
        message = f"{name} does not go with cutter compensation"
        raise BlockError("rotary-refused", message, name, hint="use G40")
    sink = ip.sink
    if not isinstance(sink, RotarySink):
        return
    ip.state.position = sink.axes()
    sink.inner.set_lever(0.0)
    ip.sink, ip.rewrite = sink.inner, None
    ip.state.plane = sink.plane_before
    ip.sink.select_plane(sink.plane_before)


def _has_own_y(ip: Interpreter, block: Block) -> bool:
    """Tell whether words of Y stand between G112 and G113: the form of Haas."""
    if ip.flow is None:
        return False
    text = bare(ip.flow.subroutines.sources[block.source].data[block.offset :])
    off = _OFF.search(text)
    return _OWN_Y.search(text, 0, off.start() if off else len(text)) is not None


def polar_on(ip: Interpreter, block: Block) -> None:
    """G12.1, G112: X and the hypothetical axis C (Haas: Y) are the plane that the tool sees on the face of the part."""
    state, name = ip.state, "G12.1" if 121 in block.g else "G112"
    begin, side, other = state.position[5], math.copysign(1.0, state.position[_X]), state.position[_Y]
    by_y = _has_own_y(ip, block)

    def shown(point: Point, near: float) -> Point:
        return _on_face(point, near, begin, side, other)

    def seen(axes: Point) -> Point:
        spoke = cmath.rect(axes[_X], math.radians(axes[5] - begin))
        return [spoke.real, spoke.imag, *axes[2:]]

    def rewrite(ip: Interpreter, block: Block) -> Block:
        if not {71, 1070}.isdisjoint(block.g):
            return block
        words = dict(block.words)
        if not {180, 190}.isdisjoint(block.g):
            message = f"{name} has a plane of its own"
            hint = "end it before"
            raise BlockError("rotary-refused", message, "G18" if 180 in block.g else "G19", hint=hint)
        for letter, virtual in (("c", "y"), ("h", "v")):
            if letter in words and not by_y and (letter == "c" or ip.lathe):
                words[virtual] = words.pop(letter)
        if by_y and ip.lathe:
            # A distance U is one of the diameter on other blocks of a lathe.
            words.update({letter: 2.0 * words[letter] for letter in "xu" if letter in words})
        return replace(block, words=words)

    _start(ip, name, 5, 17, shown, seen)
    ip.rewrite = rewrite


def polar_off(ip: Interpreter, block: Block) -> None:
    """G13.1, G113."""
    _end(ip, "G13.1" if 131 in block.g else "G113")


def _radius(name: str, words: dict[str, float]) -> tuple[str, float, bool]:
    """Return the letter of the rotary axis, the radius of the cylinder, and whether Y is the way on it, as Haas's mills have it: G107 A0 Y0
    R2. (Q: the diameter).
    """
    of_haas = name == "G107" and "y" in words
    letters = [letter for letter in "ac" if letter in words]
    if len(letters) != 1:
        message = f"{name} names the rotary axis, A or C, with the radius of the cylinder"
        raise BlockError("axis-missing", message, name, hint=f"{name} C20. begins it, {name} C0 ends it")
    if of_haas and words.keys().isdisjoint("rq"):
        hint = "without them it is setting 34 of the control"
        raise BlockError("axis-missing", "G107 A Y has no radius R and no diameter Q", name, hint=hint)
    letter = letters[0]
    radius = words.get("r", words.get("q", 0.0) / 2.0) if of_haas else words[letter]
    if radius < 0.0 or (of_haas and not radius):
        raise BlockError("axis-missing", f"the radius {radius:g} of {name} is not above 0", letter.upper())
    return letter, radius, of_haas


def cylinder(ip: Interpreter, block: Block) -> None:
    """G7.1 C, G107 C: the surface of a cylinder of that radius, unrolled; a radius of 0, or G107 alone, ends it."""
    name = "G7.1" if 71 in block.g else "G107"
    if name == "G107" and isinstance(ip.sink, RotarySink) and block.words.keys().isdisjoint("acyrq"):
        _end(ip, name)
        return
    letter, radius, of_haas = _radius(name, block.words)
    rotary = "abc".index(letter) + 3
    if radius == 0.0:
        _end(ip, name)
        return
    a_degree = math.radians(radius)
    other, plane = ip.state.position[_Y], ip.state.plane
    # In G18 the plane is that of Z and C, whose order and sense are those of Y and Z the other way round.
    mirrored = letter == "c" and plane == 18

    def shown(point: Point, near: float) -> Point:
        out = list(point)
        out[_Y], out[rotary] = other, point[_Y] / a_degree
        return out

    def seen(axes: Point) -> Point:
        out = list(axes)
        out[_Y] = axes[rotary] * a_degree
        return out

    def rewrite(ip: Interpreter, block: Block) -> Block:
        if not {71, 1070}.isdisjoint(block.g):
            return block
        words = dict(block.words)
        if not {170, 180, 190}.difference((10 * plane,)).isdisjoint(block.g):
            message = f"the plane changes under {name}"
            raise BlockError("rotary-refused", message, "", hint=f"choose it before {name}")
        if of_haas and letter in words:
            message = f"{letter.upper()} turns the cylinder on which Y is the way"
            raise BlockError("rotary-refused", message, letter.upper(), hint="end it by G107 before")
        if letter in words:
            words["y"] = words.pop(letter) * a_degree
        if "h" in words and ip.lathe:
            words["v"] = words.pop("h") * a_degree
        g = [number for number in block.g if number != 10 * plane]
        return replace(
            block, words=words, g=tuple(_TURNED.get(number, number) for number in g) if mirrored else tuple(g)
        )

    angle = ip.state.position[rotary]
    _start(ip, name, rotary, 19 if letter == "c" else 17, shown, seen)
    ip.state.position[_Y] = angle * a_degree
    assert isinstance(ip.sink, RotarySink)
    ip.sink.place(ip.state.position)
    ip.rewrite = rewrite


_POLAR = "polar coordinate interpolation in X and C (Haas: X and Y)"
_UNROLLED = "the unrolled surface of a cylinder of radius C (or A); 0 ends it"
#: G112 and G113 are those of lathes: on Haas's mills they are coordinate systems (`offsets_fanuc`).
CODES = tuple(
    Code("G", number, "rotary path", Stage.COORDINATES, run, text, words, axes, dialects=dialects, moves=moves)
    for number, run, text, words, axes, dialects, moves in (
        (121, polar_on, _POLAR, "", "none", ("fanuc",), "XC"),
        (1120, polar_on, _POLAR, "", "none", (LATHE,), "XC"),
        (131, polar_off, "end of G12.1", "", "none", ("fanuc",), ""),
        (1130, polar_off, "end of G12.1", "", "none", (LATHE,), ""),
        (71, cylinder, _UNROLLED, "ac", "own", ("fanuc",), ""),
        (1070, cylinder, f"{_UNROLLED} (Haas: A Y R; alone)", "acyrq", "own", ("fanuc",), ""),
    )
)  # fmt: skip
