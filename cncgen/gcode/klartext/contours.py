"""Contours of Heidenhain's plain language: arcs that go on (CT), ways to a contour (APPR) and from it (DEP).

A contour is approached at the point A with the direction t of its first element, the tool on the side n of RL or RR. All ways are
worked out for the tool's centre, so that compensation begins and ends beside A and E without a move of its own (iTNC 530, "Contour
approach and departure"). Radii of arcs are those of the tool's centre: the manual's examples, "Circular movements" among them, have R5
for a tool of radius 10. Below 0, the arc lies on the side of the part.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from cncgen.gcode.block import Block, Own, Value, evaluate
from cncgen.gcode.codes.arcs import tangent_centre
from cncgen.gcode.codes.compensated_sink import CompensatedSink
from cncgen.gcode.codes.feeds import set_feed
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.leads import lead_arc, lead_line
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.plain_language import Plain, polar_place, pole_of, refuse_cartesian
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Point, TryingSink
from cncgen.gcode.text.plain_language import Raw


def plunge(ip: Interpreter, block: Block, part: float) -> float | None:
    """Bound the feed of a line downwards, so that it goes down no faster than a part of the feed (M103); return the feed behind it.

    Returns:
        None where the feed stays as it is.
    """
    feed, place = block.words.get("f", ip.state.feed), ip.state.position
    down = place[2] - block.words.get("z", place[2])
    if part <= 0.0 or down <= 0.0 or 0 in block.g or "fmax" in block.words:
        return None
    if 10 not in block.g or 530 in block.g:
        message = (
            "M103 bounds the feed of lines downwards alone: arcs and lines in polar coordinates keep theirs"
        )
        ip.warn_once("feed-function", message, "M103", "F gives a smaller feed there")
        return None
    ends = [block.words.get(letter, place[k]) for k, letter in enumerate("xyz")]
    bound = feed * part * math.dist(ends, place[:3]) / down
    if bound >= feed:
        return None
    block.words["f"] = bound
    return feed


_CURVES = frozenset((Own.CIRCLE, Own.RADIUS_ARC, Own.POLAR_ARC, Own.POLAR_LINE))


def lengthen(ip: Interpreter, block: Block, marks: Mapping[str, Value]) -> None:
    """Let a line along X or Y end the radius of the tool further (R+, G43) or earlier (R-, G44), until R0, RL or RR.

    (TNC 406, "Electrode radius compensation"; iTNC 530, "DIN/ISO programming", 5.3: G43 and G44 are for movements of a single axis, which
    they lengthen and shorten.)
    """
    plain = Plain.of(ip)
    if "R±" in marks:
        plain.paraxial = evaluate(marks["R±"], ip.parameters)
    elif "R0" in marks or {410, 420} & set(block.g):
        plain.paraxial = 0.0
    along = [letter for letter in "xy" if letter in block.words]
    line = not {0, 10}.isdisjoint(block.g)
    if not plain.paraxial or not (along if line else _CURVES.intersection(block.g)):
        return
    step = "IX" in marks or "IY" in marks
    if len(along) > 1 or not line or step:
        message = f"R{'+' if plain.paraxial > 0.0 else '-'} is in force, and the block {'has an increment' if step else 'moves along more than one axis'}"
        hint = "X+50 R+ goes along one axis; R0, RL or RR ends R+ and R-"
        raise BlockError("paraxial", message, "R", hint=hint)
    tool = ip.tools.find(ip.state.tool)
    radius = tool.diameter / 2.0 * ip.table_scale() if tool else 0.0
    way = block.words[along[0]] - ip.state.position["xy".index(along[0])]
    block.words[along[0]] += math.copysign(radius, way) * plain.paraxial if way else 0.0


_AXES = frozenset("XYZABC")
#: How far two ends of the arc of LCT are apart where there is none.
_SAME = 1e-4
_SIDES = {"R0": 0, "RL": 1, "RR": -1}
#: The words of the line or arc that leads to or from a contour, by its form.
_SHAPES = {"LT": ("LEN",), "LN": ("LEN",), "CT": ("CCA", "R"), "LCT": ("R",)}


@dataclass(slots=True)
class ContourWay:
    """APPR or DEP: form (LT LN CT LCT), values by name, side (1 left, -1 right, 0 none), feed or
    that of TOOL CALL, words of M functions."""

    kind: str
    form: str
    values: dict[str, float]
    side: int | None
    feed: float | None
    called: bool = False
    functions: list[Raw] = field(default_factory=list)

    def value(self, name: str) -> float:
        """Return a value that the way needs."""
        if name not in self.values:
            hint = f"{self.kind} {self.form} needs {name}"
            raise BlockError("approach-words", f"{self.kind} {self.form} has no {name}", self.kind, hint=hint)
        return self.values[name]

    def coordinate(self, axis: str, here: float, absent: float) -> float:
        """Return where the way leads along an axis, which may count from here."""
        return self.values.get(axis, here + self.values["I" + axis] if "I" + axis in self.values else absent)

    def check(self) -> None:
        """Raise where a word is none of this form, or another one says the same."""
        polar = not self.values.keys().isdisjoint(("PR", "PA"))
        taken = set(_SHAPES[self.form])
        if self.kind == "APPR" or self.form == "LCT":
            taken |= {"PR", "PA", *_AXES, *("I" + axis for axis in _AXES)} - (
                {"X", "Y", "IX", "IY"} if polar else set()
            )
        unused = next((name for name in self.values if name not in taken or "I" + name in self.values), "")
        message = f"{unused} of {self.kind} {self.form} says nothing, or what another word says"
        hint = f"{self.kind} {self.form} has {' and '.join(_SHAPES[self.form])}"
        refuse(self.kind, (bool(unused), "approach-words", message, hint))


def way_of(kind: str, form: str, words: Sequence[Raw], now: Callable[[Value], float]) -> ContourWay:
    """Return the way of APPR or DEP; `now` gives the present value of a word."""
    way = ContourWay(kind, form.removeprefix("P"), {}, None, None)
    for name, value in words:
        if name in ("LEN", "CCA", "R", "PR", "PA") or name.removeprefix("I") in _AXES:
            way.values[name] = now(value)
        elif name in _SIDES:
            way.side = _SIDES[name]
        elif name == "FAUTO":
            way.called = True
        elif name == "F":
            way.feed = now(value)
        elif name == "M":
            way.functions.append((name, value))
        elif name not in ("FMAX", ""):
            message = f"{name} does not belong to {kind}"
            raise BlockError("syntax", message, kind, hint=f"{kind} LT X+10 Y+5 LEN15 RL F200")
    way.check()
    return way


class Heading(TryingSink):
    """A sink that keeps the direction in which the first motion begins, and nothing else."""

    first: complex | None = None
    at: Point

    def straight_feed(self, end: Point) -> None:
        way = complex(end[0] - self.at[0], end[1] - self.at[1])
        if self.first is None and way:
            self.first = way / abs(way)

    straight_traverse = straight_feed

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        spoke = complex(self.at[0] - first, self.at[1] - second)
        if self.first is None and spoke:
            self.first = (1j if turns > 0 else -1j) * spoke / abs(spoke)


def first_heading(ip: Interpreter, start: Point, read: Callable[[], Block]) -> complex | None:
    """Return the direction in which a block would leave a point, from which its increments count too."""
    kept, trying = replace(Plain.of(ip)), Heading(ip.sink)
    trying.at = list(start)
    try:
        with ip.on_trial(trying, start, compensation=40):
            block = read()
            codes = tuple(g for g in block.g if g not in (400, 410, 420))
            words = dict(block.words)
            ip.execute(block.beside(words, codes))
    except BlockError:
        return None
    finally:
        ip.plain_language = kept
    return trying.first


def _radius(ip: Interpreter, side: int) -> float:
    return ip.tool_radius() if side else 0.0


def _lead(
    way: ContourWay, beside: complex, tangent: complex, side: int, far: complex, *, leaving: bool
) -> Segment:
    """Return the line or arc of the tool's centre that leads beside a contour, or away from there; R below 0 is on the side of the part.

    Args:
        way: The words.
        beside: Where the centre stands beside the contour's point.
        tangent: The contour's direction there.
        side: On which side the tool is, 1 for left.
        far: Where the tool comes from or goes to.
        leaving: Whether it is a departure.
    """
    sense = -1 if side < 0 else 1
    if way.form in ("LT", "LN"):
        along = tangent if way.form == "LT" else 1j * sense * tangent * (1.0 if leaving else -1.0)
        return lead_line(beside, along, way.value("LEN"), leaving=leaving)
    radius = sense * way.value("R")
    message = f"{way.kind} {way.form} has an arc of R0"
    refuse(way.kind, (radius == 0.0, "comp-radius", message, "R5, or R-5 for the side of the part"))
    if way.form == "CT":
        return lead_arc(beside, tangent, radius, math.radians(way.value("CCA")), leaving=leaving)
    centre, spin = beside + 1j * tangent * radius, 1 if radius > 0.0 else -1
    touched = _touch(far, centre, abs(radius), spin, leaving=leaving)
    if abs(touched - beside) < _SAME:
        # Straight ahead there is no arc; one from a point to itself would be a circle.
        return Segment(beside, beside)
    ends = (beside, touched) if leaving else (touched, beside)
    return Segment(*ends, centre, spin)


def _touch(place: complex, centre: complex, radius: float, sense: int, *, leaving: bool) -> complex:
    """Return where a circle is touched by the tangent to (or with `leaving` from it to) a place, in the sense of the circle."""
    apart = place - centre
    if abs(apart) <= radius:
        message = "APPR LCT or DEP LCT lies within its circle and has no tangent"
        raise BlockError("approach-words", message, "R", hint="take a smaller R, or a place farther away")
    angle = math.acos(radius / abs(apart))
    turn = angle if leaving == (sense < 0) else -angle
    return centre + apart / abs(apart) * radius * cmath.rect(1.0, turn)


def _take_feed(ip: Interpreter, way: ContourWay, here: Block) -> None:
    feed = Plain.of(ip).tool_feed if way.called else way.feed
    if feed is not None:
        set_feed(ip, Block({"f": feed}))
    check_feed(ip, here, way.kind)


def _polar(ip: Interpreter, way: ContourWay) -> complex:
    """Return the place of PR and PA about the pole."""
    pole = Plain.of(ip).pole
    if pole is None:
        message = f"{way.kind} in polar coordinates has no pole"
        raise BlockError("pole-missing", message, way.kind, hint="CC gives it before")
    return pole + cmath.rect(way.value("PR"), math.radians(way.value("PA")))


def approach(
    ip: Interpreter, way: ContourWay, here: Block, leads: Callable[[Point], complex | None] | None
) -> None:
    """APPR: to the first point of a contour, and beside it; `leads` gives the direction in which its first element leaves a point."""
    if ip.state.compensation != 40:
        message = "APPR stands where radius compensation is on"
        raise BlockError("approach-words", message, "APPR", hint="R0, or DEP, ends it before")
    start = ip.state.position.copy()
    for index, axis in enumerate("XYZ"):
        start[index] = way.coordinate(axis, start[index], start[index])
    if "PR" in way.values or "PA" in way.values:
        point = _polar(ip, way)
        start[0], start[1] = point.real, point.imag
    tangent = leads(start) if leads is not None else None
    if tangent is None:
        message = "APPR is not followed by an element of a contour"
        hint = "an L, C or CR block leads along the contour"
        raise BlockError("approach-words", message, "APPR", hint=hint)
    side = way.side or 0
    cutter, tool, a = FlatCutter(ip), _radius(ip, side), complex(start[0], start[1])
    beside = a + tangent * (-1j if side < 0 else 1j) * tool
    ip.sink.block = here
    # LCT has one feed all the way; to where the other forms begin, the tool goes as it went before.
    rapid = ip.state.motion == 0 and way.form != "LCT"
    if way.form == "LCT" or ip.state.feed <= 0.0:
        _take_feed(ip, way, here)
    lead = _lead(way, beside, tangent, side, cutter.place(), leaving=False)
    cutter.to(lead.start, start[2], rapid=rapid)
    if way.form != "LCT":
        _take_feed(ip, way, here)
    cutter.follow(lead)
    if side:
        ip.execute(here.beside({}, (410 if side > 0 else 420,)))
        if isinstance(ip.sink, CompensatedSink):
            ip.sink.centre.stand(a)
        ip.state.position = [a.real, a.imag, *ip.state.position[2:]]


def departure(ip: Interpreter, way: ContourWay, here: Block) -> None:
    """DEP: away from the last point of a contour; compensation ends."""
    heading = Plain.of(ip).heading
    if heading is None:
        message = "DEP has no element of a contour before it"
        raise BlockError("approach-words", message, "DEP", hint="an L, C or CR block comes before")
    tangent = heading / abs(heading)
    side = {41: 1, 42: -1}.get(ip.state.compensation, 0)
    cutter, tool = FlatCutter(ip), _radius(ip, side)
    contour, height = cutter.place(), ip.state.position[2]
    beside = contour + tangent * (-1j if side < 0 else 1j) * tool
    ip.end_compensation()
    ip.sink.block = here
    ip.state.position = [beside.real, beside.imag, *ip.state.position[2:]]
    _take_feed(ip, way, here)
    end = complex(
        way.coordinate("X", contour.real, beside.real), way.coordinate("Y", contour.imag, beside.imag)
    )
    if way.form == "LCT" and way.values.keys() & {"PR", "PA"}:
        end = _polar(ip, way)
    cutter.follow(_lead(way, beside, tangent, side, end, leaving=True))
    if way.form == "LCT":
        cutter.to(end, way.coordinate("Z", height, height))


def take_polar_end(ip: Interpreter, words: dict[str, float]) -> None:
    """Put the place of CTP in polar coordinates into X and Y."""
    refuse_cartesian(words, 17, "CTP")
    end = polar_place(words, pole_of(ip, "CTP")[0], complex(*ip.state.position[:2]))
    for letter in ("pr", "pa", "ipr", "ipa"):
        words.pop(letter, None)
    words["x"], words["y"] = end.real, end.imag


def tangent_arc(ip: Interpreter, words: dict[str, float]) -> tuple[list[float], complex, int]:
    """Return end, centre and sense of CT: the arc to a point in the direction of the element before."""
    end = ip.state.position.copy()
    for index, value in Block(words).axes():
        end[index] = value
    begin, finish = complex(*ip.state.position[:2]), complex(*end[:2])
    hints = ("an L or C block comes before", "write L")
    return end, *tangent_centre(begin, Plain.of(ip).heading, finish, "element", hints)
