"""Free contours (FK) of Heidenhain's plain language: FPOL, FL, FLT, FC, FCT, CLSD (iTNC 530, "Path contours - FK free contour programming").

Each element is a directed line or circle. Data that its own words and its start leave open follow from the next elements that are
determined: where both meet or touch, or the line or arc of a given radius that touches both. Data that leave more than one solution
are refused: the numbers by which FSELECT chooses one are known only to the control.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError

BEGINS = re.compile(r"F(?:POL|LT|L|CT|C|SELECT)\b", re.IGNORECASE)
_VALUE = r"\s*(?P<value>(?:[-+]\s*)?(?:Q\d+|\d++[.,]?+\d*+|[.,]\d+))"
_WORD = re.compile(
    rf"(?<![A-Z])(?:(?P<name>I?(?:CCX|CCY|CCPR|CCPA)|CCA|LEN|I?AN|I?P[RA]|P[123][XY]|PD[XY]|PAR|DP|R(?![LR0])|D|I?[XY]){_VALUE}"
    r"|(?P<sense>DR)\s*(?P<sign>[-+])|(?P<closed>CLSD)\s*(?P<which>[-+])|(?P<relative>R(?:X|Y|PR|PA|AN|CC[A-Z]*)\s*\d+))",
    re.IGNORECASE,
)
_TINY = 1e-9
#: Places nearer to each other than this are one, mm.
_SAME = 1e-6
_HINT = "the end, the angle AN, the centre CCX CCY, the radius R, or FLT and FCT between known elements"


@dataclass(slots=True)
class Element:
    """One element: its words by name, whether it is an arc and goes on tangentially, and its line of the program."""

    arc: bool
    tangential: bool
    at: int
    values: dict[str, float] = field(default_factory=dict)
    rest: str = ""
    pole: complex | None = None


@dataclass(frozen=True, slots=True)
class Curve:
    """A directed line through a point, or a circle (`radius` above 0) about it with a sense (1 counter-clockwise)."""

    point: complex
    way: complex = 0j
    radius: float = 0.0
    spin: int = 0

    def heading(self, at: complex) -> complex:
        """Return the direction at a point."""
        if not self.radius:
            return self.way
        return 1j * self.spin * (at - self.point) / abs(at - self.point)


def element_of(body: str, at: int, value: Callable[[str], float]) -> Element:
    """Return the element of a line, the words that L has as well left in its `rest`.

    Raises:
        BlockError: It refers to another block, or FSELECT chooses a solution.
    """
    match = BEGINS.match(body)
    assert match
    head = match[0].upper()
    if head == "FSELECT":
        message = "FSELECT chooses a solution by a number of the control's own: it is not read"
        raise BlockError(
            "unsupported-block",
            message,
            "FSELECT",
            hint="give the end, the centre or the angle of the element",
        )
    found = Element(head in ("FC", "FCT"), head in ("FLT", "FCT"), at)

    def take(word: re.Match[str]) -> str:
        if word["relative"] or (word["name"] or "").upper() in ("PAR", "DP"):
            message = f"{word[0].upper()} of {head}, which refers to another block, is not read"
            raise BlockError("unsupported-block", message, head, hint="give coordinates")
        if word["name"]:
            found.values[word["name"].upper()] = value(word["value"])
        else:
            found.values["DR" if word["sense"] else "CLSD"] = (
                -1.0 if (word["sign"] or word["which"]) == "-" else 1.0
            )
        return " "

    found.rest = _WORD.sub(take, body[match.end() :])
    return found


def _open(element: Element) -> BlockError:
    name = "F" + ("C" if element.arc else "L") + ("T" if element.tangential else "")
    return BlockError(
        "free-contour", f"the data of {name} leave more than one solution, or none", name, hint=_HINT
    )


class Chain:
    """A row of elements, solved from its start."""

    def __init__(self, elements: Sequence[Element], start: complex, heading: complex | None) -> None:
        self._elements, self._start, self._heading = elements, start, heading
        self._closing: complex | None = None
        self.solved: list[Segment] = []

    def solve(self) -> list[Segment]:
        """Return the elements as lines and arcs.

        Raises:
            BlockError: Data are missing or leave a choice.
        """
        for index, element in enumerate(self._elements):
            if element.values.get("CLSD") == 1.0:
                self._closing = self._start
            end = self._end(element)
            curve = self._curve(element, self._start, self._heading, end) or self._towards(index)
            if curve is None:
                raise _open(element)
            if end is None:
                end = self._on(element, curve) or self._meeting(curve, index)
            if end is None or not self._holds(curve, end):
                raise _open(element)
            centre = curve.point if element.arc else None
            self.solved.append(Segment(self._start, end, centre, curve.spin))
            self._start, self._heading = end, curve.heading(end)
        return self.solved

    def _holds(self, curve: Curve, end: complex) -> bool:
        """Tell whether an end lies on its element, ahead of the start."""
        if curve.radius:
            return all(abs(abs(p - curve.point) - curve.radius) < 1e-3 for p in (self._start, end))
        ahead = (end - self._start) * curve.way.conjugate()
        return ahead.real > _TINY and abs(ahead.imag) < 1e-3

    def _end(self, element: Element) -> complex | None:
        """Return the end where words give both of its coordinates."""
        v = element.values
        if v.get("CLSD") == -1.0 and self._closing is not None:
            return self._closing
        if "PR" in v and "PA" in v:
            return _polar(element.pole, v["PR"], v["PA"])
        x, y = (
            v.get(c, v["I" + c] + part if "I" + c in v else None)
            for c, part in (("X", self._start.real), ("Y", self._start.imag))
        )
        return complex(x, y) if x is not None and y is not None else None

    def _curve(
        self, element: Element, start: complex | None, heading: complex | None, end: complex | None = None
    ) -> Curve | None:
        """Return the line or circle that an element's own words and its start say, None where they leave it open."""
        return (self._circle if element.arc else self._line)(element, start, heading, end)

    def _line(
        self, element: Element, start: complex | None, heading: complex | None, end: complex | None
    ) -> Curve | None:
        v = element.values
        way = heading if element.tangential else None
        if "AN" in v:
            way = cmath.rect(1.0, math.radians(v["AN"]))
        elif "IAN" in v and heading is not None:
            way = heading * cmath.rect(1.0, math.radians(v["IAN"]))
        elif start is not None and end is not None and abs(end - start) > _TINY:
            way = (end - start) / abs(end - start)
        point = start
        if point is None:
            if "X" in v and "Y" in v:
                point = complex(v["X"], v["Y"])
            elif "P1X" in v and "P1Y" in v:
                point = complex(v["P1X"], v["P1Y"])
            elif "PDX" in v and "PDY" in v and v.get("D") == 0.0:
                point = complex(v["PDX"], v["PDY"])
        return Curve(point, way) if point is not None and way is not None else None

    def _circle(
        self, element: Element, start: complex | None, heading: complex | None, end: complex | None
    ) -> Curve | None:
        v, radius = element.values, abs(element.values.get("R", 0.0))
        if "DR" not in v:
            raise BlockError(
                "arc-sense", "an arc of a free contour has no sense of rotation", "DR", hint="DR+ or DR-"
            )
        spin, centre = (1 if v["DR"] > 0.0 else -1), _centre(element, start)
        if centre is not None:
            reach = abs(start - centre) if start is not None else radius
            if start is not None and radius and abs(reach - radius) > 1e-3:
                return None
            return Curve(centre, radius=reach, spin=spin) if reach > _TINY else None
        way = heading if element.tangential else None
        if "AN" in v:
            way = cmath.rect(1.0, math.radians(v["AN"]))
        if start is None or way is None:
            return None
        side = 1j * way * spin
        if end is not None:
            # The centre is beside the start and as far from the end.
            chord = end - start
            aside = (chord * side.conjugate()).real
            radius = abs(chord) ** 2 / (2.0 * aside) if aside > _TINY else 0.0
        return Curve(start + side * radius, radius=radius, spin=spin) if radius > _TINY else None

    def _on(self, element: Element, curve: Curve) -> complex | None:
        """Return the end on a known curve by LEN, CCA, or one coordinate."""
        v = element.values
        if curve.radius:
            if "CCA" in v:
                return curve.point + (self._start - curve.point) * cmath.rect(
                    1.0, curve.spin * math.radians(abs(v["CCA"]))
                )
            return None
        if "LEN" in v:
            return self._start + curve.way * v["LEN"]
        for name, part in (("X", curve.way.real), ("Y", curve.way.imag)):
            here = self._start.real if name == "X" else self._start.imag
            want = v.get(name, here + v["I" + name] if "I" + name in v else None)
            if want is not None and abs(part) > _TINY:
                return self._start + curve.way * ((want - here) / part)
        return None

    def _own(self, index: int) -> Curve | None:
        """Return the curve of an element that its own words give, whatever comes before it."""
        return self._curve(self._elements[index], None, None) if index < len(self._elements) else None

    def _towards(self, index: int) -> Curve | None:
        """Return the line from the start that touches the next element."""
        following = self._own(index + 1)
        if (
            following is None
            or self._elements[index].arc
            or not following.radius
            or not self._elements[index + 1].tangential
        ):
            return None
        return _tangent_line(Curve(self._start), following)

    def _meeting(self, curve: Curve, index: int) -> complex | None:
        """Return where a curve ends: at the next element, or at the one that touches it and the element behind it."""
        if index + 1 >= len(self._elements):
            return None
        following, element = self._own(index + 1), self._elements[index + 1]
        if following is None and element.tangential:
            third = self._own(index + 2)
            if third is None or not self._elements[index + 2].tangential:
                return None
            if not element.arc:
                following = _tangent_line(curve, third)
            elif "R" in element.values:
                following = self._between(curve, third, element.values)
        if following is None:
            return None
        if element.tangential:
            return _touching(curve, following)
        places = [
            p for p in _crossings(curve, following) if abs(p - self._start) > _SAME and self._holds(curve, p)
        ]
        return places[0] if len(places) == 1 else None

    def _between(self, one: Curve, two: Curve, values: dict[str, float]) -> Curve | None:
        """Return the circle of a radius that touches two curves in their senses, where there is one alone."""
        spin, radius = (1 if values["DR"] > 0.0 else -1), abs(values["R"])
        found = []
        for place in _crossings(_inside(one, radius, spin), _inside(two, radius, spin)):
            circle = Curve(place, radius=radius, spin=spin)
            begin = _touching(one, circle)
            if begin is not None and self._holds(one, begin) and _touching(circle, two) is not None:
                found.append(circle)
        return found[0] if len(found) == 1 else None


def first_heading(elements: Sequence[Element], start: Sequence[float]) -> complex:
    """Return the direction in which a row of elements leaves a point."""
    segment = Chain(elements, complex(start[0], start[1]), None).solve()[0]
    return segment.heading(segment.start)


def _polar(pole: complex | None, radius: float, angle: float) -> complex:
    if pole is None:
        message = "a free contour in polar coordinates has no pole"
        raise BlockError("pole-missing", message, "FPOL", hint="FPOL X+0 Y+0 stands before")
    return pole + cmath.rect(radius, math.radians(angle))


def _centre(element: Element, start: complex | None) -> complex | None:
    v = element.values
    if "CCPR" in v and "CCPA" in v:
        return _polar(element.pole, v["CCPR"], v["CCPA"])
    if start is not None and "ICCX" in v and "ICCY" in v:
        return start + complex(v["ICCX"], v["ICCY"])
    return complex(v["CCX"], v["CCY"]) if "CCX" in v and "CCY" in v else None


def _inside(curve: Curve, radius: float, spin: int) -> Curve:
    """Return where centres of circles of a radius and sense lie that touch a curve in its sense."""
    if not curve.radius:
        return Curve(curve.point + 1j * curve.way * radius * spin, curve.way)
    return Curve(curve.point, radius=abs(curve.radius - radius * spin * curve.spin), spin=curve.spin)


def _tangent_line(one: Curve, two: Curve) -> Curve | None:
    """Return the directed line that leaves one circle (or point) and runs into another, both in their senses."""
    if two.radius == 0.0 and two.way:
        return None
    # Seen from a line in direction u, the centre of a circle lies by spin * radius to its left.
    apart, lift = two.point - one.point, two.spin * two.radius - one.spin * one.radius
    if abs(apart) <= abs(lift) or (not one.radius and one.way):
        return None
    way = apart / abs(apart) * cmath.rect(1.0, -math.asin(lift / abs(apart)))
    return Curve(one.point - 1j * way * one.spin * one.radius, way)


def _touching(one: Curve, two: Curve) -> complex | None:
    """Return where two curves touch in the same direction, None where they do not."""
    if not one.radius and not two.radius:
        return None
    if not (one.radius and two.radius):
        line, circle = (two, one) if one.radius else (one, two)
        foot = line.point + ((circle.point - line.point) * line.way.conjugate()).real * line.way
        place = foot if abs(foot - circle.point) > _TINY else None
    else:
        apart = two.point - one.point
        if abs(apart) < _TINY:
            return None
        outward = 1.0 if one.radius > two.radius or one.spin != two.spin else -1.0
        place = one.point + apart / abs(apart) * one.radius * outward
    if place is None or any(c.radius and abs(abs(place - c.point) - c.radius) > 1e-3 for c in (one, two)):
        return None
    return place if (one.heading(place) * two.heading(place).conjugate()).real > 0.9 else None


def _crossings(one: Curve, two: Curve) -> list[complex]:
    """Return where two curves meet."""
    if not one.radius and not two.radius:
        across = (one.way.conjugate() * two.way).imag
        if abs(across) < _TINY:
            return []
        part = ((two.point - one.point).conjugate() * two.way).imag / across
        return [one.point + part * one.way]
    if one.radius and two.radius:
        apart = two.point - one.point
        if abs(apart) < _TINY:
            return []
        along = (abs(apart) ** 2 + one.radius**2 - two.radius**2) / (2.0 * abs(apart))
        foot, way, radius = one.point + apart / abs(apart) * along, 1j * apart / abs(apart), one.radius
        half = radius**2 - along**2
    else:
        line, circle = (two, one) if one.radius else (one, two)
        foot = line.point + ((circle.point - line.point) * line.way.conjugate()).real * line.way
        way, half = line.way, circle.radius**2 - abs(foot - circle.point) ** 2
    if half < -_SAME:
        return []
    if half < _SAME:
        return [foot]
    return [foot - math.sqrt(half) * way, foot + math.sqrt(half) * way]
