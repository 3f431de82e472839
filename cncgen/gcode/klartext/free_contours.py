"""Free contours (FK) of Heidenhain's plain language: FPOL, FL, FLT, FC, FCT, CLSD, FSELECT (iTNC 530, "Path contours - FK free contour
programming").

Each element is a directed line or circle. Its own words, its start and the element before it give the lines or circles that it may be, and
where it may end. The next elements decide what is left open: where both meet or touch, or the line or arc of a given radius that touches
both. All solutions are followed from element to element. One must be left at the end, or the one that FSELECT chooses.

The order by which FSELECT counts is not published. Here lines on the right side of what they are given by come before those on the left,
and so do places on the right of the way from one circle to another. A line leaves a circle before it enters it. So counted are the
solutions of the manual's second and third example.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

from cncgen.gcode.block import Value
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text.plain_language import Raw

#: Words of an element of its own, those that count from the end of another block, and those of its sense and closing.
_OWN = frozenset(
    (
        *("CCA", "LEN", "AN", "IAN", "PR", "PA", "IPR", "IPA", "P1X", "P1Y", "P2X", "P2Y", "P3X", "P3Y", "PDX", "PDY", "DP", "R", "D"),
        *("X", "Y", "IX", "IY", "CCX", "CCY", "CCPR", "CCPA", "ICCX", "ICCY", "ICCPR", "ICCPA"),
    )
)  # fmt: skip
_REFERENCES = frozenset(("RX", "RY", "RPR", "RPA", "RAN", "RCCX", "RCCY"))
_TINY = 1e-9
#: Places nearer to each other than this are one, and how far a place may lie beside what it is given to be on, mm.
_SAME, _BESIDE = 1e-6, 1e-3
#: How far data of one element, which a drawing rounds, may be apart.
_DATA = 0.01
_MOST = 256
_HINT = "the end, the angle AN, the centre CCX CCY, the radius R, or FLT and FCT between known elements"


@dataclass(slots=True)
class Element:
    """One element: its words by name, blocks to which words refer, whether it is an arc and goes on tangentially, its line and number in the
    program, and the solution that FSELECT chooses (0: none)."""

    arc: bool
    tangential: bool
    at: int
    values: dict[str, float] = field(default_factory=dict)
    relative: dict[str, int] = field(default_factory=dict)
    rest: list[Raw] = field(default_factory=list)
    pole: complex | None = None
    number: int = 0
    select: int = 0

    @property
    def name(self) -> str:
        return "F" + ("C" if self.arc else "L") + ("T" if self.tangential else "")


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

    def beside(self, at: complex) -> float:
        """Return how far a point lies from it."""
        if self.radius:
            return abs(abs(at - self.point) - self.radius)
        return abs(((at - self.point) * self.way.conjugate()).imag)


#: End and direction there of a block to which words refer.
Known = tuple[complex, complex | None]


def element_of(
    head: str, words: Sequence[Raw], at: int, now: Callable[[Value], float], number: int = 0
) -> Element:
    """Return the element of a line, the words that L has as well in its `rest`; `now` gives the present value of a word."""
    found = Element(head in ("FC", "FCT"), head in ("FLT", "FCT"), at, number=number)
    for name, value in words:
        if name == "PAR" or name in _REFERENCES:
            found.relative[name if name == "PAR" else name[1:]] = round(now(value))
        elif name in _OWN or name in ("DR±", "CLSD±"):
            found.values[name.rstrip("±")] = now(value)
        else:
            found.rest.append((name, value))
    return found


def _open(element: Element, count: int = 0) -> BlockError:
    what = f"{count} solutions" if count else "more than one solution, or none"
    return BlockError("free-contour", f"the data of {element.name} leave {what}", element.name, hint=_HINT)


@dataclass(frozen=True, slots=True)
class _Part:
    """A solution as far as it goes: the solved elements, where and in which direction it goes on, and the elements whose ends are open, with
    their curves where these are known."""

    done: tuple[Segment, ...]
    start: complex | None
    heading: complex | None
    open: tuple[tuple[Element, Curve | None], ...] = ()
    closing: complex | None = None
    #: An arc goes all around to where it begins, which FSELECT alone chooses.
    whole: bool = False

    def closed(self, curve: Curve, end: complex) -> _Part:
        """Return this with the first open element ended."""
        assert self.start is not None
        segment = Segment(self.start, end, curve.point if curve.radius else None, curve.spin)
        whole = self.whole or (curve.radius > 0.0 and abs(end - self.start) < _SAME)
        return replace(
            self, done=(*self.done, segment), start=end, heading=curve.heading(end), open=(), whole=whole
        )


class Chain:
    """A row of elements, solved from its start.

    Args:
        elements: The elements.
        start: Where the first begins.
        heading: The direction before it.
        before: End and direction of a block before them, by its number.
    """

    def __init__(
        self,
        elements: Sequence[Element],
        start: complex,
        heading: complex | None,
        before: Callable[[int], Known | None] = lambda number: None,
    ) -> None:
        self._elements, self._before = elements, before
        self._first = _Part((), start, heading)
        #: Elements that have one solution whatever follows, and that the parts no longer hold: a long row was copied for each of them.
        self._settled: list[Segment] = []
        #: Elements whose solution FSELECT chose, and of how many.
        self.chosen: list[tuple[Element, int]] = []

    def solve(self) -> list[Segment]:
        """Return the elements as lines and arcs; raise where data are missing, contradict each other or leave a choice."""
        if not self._elements:
            return []
        parts, element = [self._first], self._elements[0]
        try:
            for element in self._elements:
                parts = self._next(parts, element)
            parts = [part for part in parts if not part.open]
            if not parts:
                raise _open(element)
            for k, element in enumerate(self._elements[len(self._settled) :]):
                count = len({_key(part.done[k]) for part in parts})
                if count > 1:
                    raise _open(element, count)
        except BlockError as error:
            error.at = element.at
            raise
        return [*self._settled, *parts[0].done]

    def _next(self, parts: Sequence[_Part], element: Element) -> list[_Part]:
        groups = [_apart(self._on(part, element), len(part.done)) for part in parts]
        if element.select:
            most = max(map(len, groups))
            if element.select > most:
                message = f"FSELECT {element.select} chooses of {most} solutions"
                raise BlockError("free-contour", message, "FSELECT", hint="1 is the first solution")
            if most > 1:
                self.chosen.append((element, most))
            groups = [group[element.select - 1 : element.select] for group in groups]
        else:
            groups = [[part for part in group if not part.whole] for group in groups]
        found = [replace(part, whole=False) for group in groups for part in group]
        if not found or len(found) > _MOST:
            raise _open(element, len(found))
        if len(found) == 1:
            self._settled += found[0].done
            found = [replace(found[0], done=())]
        return found

    def _on(self, part: _Part, element: Element) -> Iterator[_Part]:
        if not part.open:
            if element.values.get("CLSD") == 1.0 and part.start is not None:
                part = replace(part, closing=part.start)
            yield from self._from_known(part, element)
            return
        assert part.start is not None
        before, curve = part.open[0]
        if len(part.open) == 1:
            if curve is not None:
                yield from self._from_curve(part, curve, element)
            elif element.tangential and not before.arc:
                yield from self._from_line(part, part.start, element)
        elif len(part.open) == 2 and curve is not None and element.tangential:
            yield from self._over_middle(part, part.start, curve, element)

    def _from_known(self, part: _Part, element: Element) -> Iterator[_Part]:
        """Yield the solutions with an element whose begin is known; where its curve is not, it stays open."""
        words = self._words(element, part, part.start, part.heading)
        curves = words.curves(part.start, part.heading)
        for curve in curves:
            yield from words.ended(part, curve)
        if not curves:
            yield replace(part, open=((element, None),))

    def _from_line(self, part: _Part, start: complex, element: Element) -> Iterator[_Part]:
        """Yield the solutions with the element after a line in an unknown direction, which touches it."""
        words = self._words(element, part, None, None)
        for own in words.curves(None, None):
            line = _tangent_line(Curve(start), own)
            place = _touching(line, own) if line is not None else None
            if line is not None and place is not None and _leads(line, start, place):
                yield from words.ended(part.closed(line, place), own)

    def _from_curve(self, part: _Part, curve: Curve, element: Element) -> Iterator[_Part]:
        """Yield the solutions with the element after one whose end alone is open; where its curve touches and is not known, it is open too."""
        assert part.start is not None
        # An arc has its direction at its end alone, a line has it everywhere.
        heading = None if curve.radius else curve.way
        words = self._words(element, part, None, heading)
        found = words.curves(None, heading if not element.tangential else None)
        if not found and element.tangential:
            found = words.touching(curve)
        for one in found:
            for place in self._junctions(curve, one, element.tangential, part.start):
                yield from words.ended(part.closed(curve, place), one)
        if not found and element.tangential:
            yield replace(part, open=(*part.open, (element, None)))

    def _over_middle(self, part: _Part, start: complex, curve: Curve, element: Element) -> Iterator[_Part]:
        """Yield the solutions with the element after two open ones, of which the second touches both others."""
        words = self._words(element, part, None, None)
        for own in words.curves(None, None):
            for between in _between(curve, own, part.open[1][0]):
                begin, touched = _touching(curve, between), _touching(between, own)
                if begin is None or touched is None or not _leads(curve, start, begin):
                    continue
                if between.radius or _leads(between, begin, touched):
                    yield from words.ended(part.closed(curve, begin).closed(between, touched), own)

    @staticmethod
    def _junctions(one: Curve, two: Curve, tangential: bool, start: complex) -> list[complex]:
        """Return where an element may go over into the next one."""
        if tangential:
            place = _touching(one, two)
            return [place] if place is not None and _leads(one, start, place) else []
        return [p for p in _crossings(one, two) if _leads(one, start, p)]

    def _words(self, element: Element, part: _Part, start: complex | None, heading: complex | None) -> _Words:
        """Return the words of an element in absolute coordinates, as far as these are known."""
        v = dict(element.values)

        def count(name: str, base: float | None, block: str) -> None:
            number = element.relative.get(block)
            if number is not None:
                base = self._reference(element, part, number, block)
            if "I" + name in v and base is not None:
                v[name] = v["I" + name] + base
            elif number is not None:
                message = f"R{block} {number} of {element.name} has no I{name} that counts from there"
                raise BlockError("free-contour", message, element.name, hint=f"I{name}+20 R{block} {number}")

        count("X", start.real if start is not None else None, "X")
        count("Y", start.imag if start is not None else None, "Y")
        count("CCX", start.real if start is not None else None, "CCX")
        count("CCY", start.imag if start is not None else None, "CCY")
        spoke = start - element.pole if start is not None and element.pole is not None else None
        count("PR", abs(spoke) if spoke is not None else None, "PR")
        count("PA", math.degrees(cmath.phase(spoke)) if spoke else None, "PA")
        count("AN", math.degrees(cmath.phase(heading)) if heading is not None else None, "AN")
        parallel = None
        if "PAR" in element.relative:
            parallel = self._known(element, part, element.relative["PAR"])
        return _Words(element, v, parallel, part.closing)

    def _known(self, element: Element, part: _Part, number: int) -> Known:
        """Return end and direction of a block."""
        for own, segment in zip(self._elements, chain(self._settled, part.done), strict=False):
            if own.number == number:
                return segment.end, segment.heading(segment.end)
        known = self._before(number)
        if known is None:
            message = f"{element.name} refers to block {number}, whose end is not known before it"
            hint = "it refers to a motion before it, by its block number"
            raise BlockError("free-contour", message, element.name, hint=hint)
        return known

    def _reference(self, element: Element, part: _Part, number: int, block: str) -> float:
        """Return the coordinate or angle of a block from which a word counts."""
        end, heading = self._known(element, part, number)
        if block == "AN":
            if heading is None:
                raise _open(element)
            return math.degrees(cmath.phase(heading))
        if block in ("PR", "PA"):
            spoke = end - _pole(element.pole)
            return abs(spoke) if block == "PR" else math.degrees(cmath.phase(spoke))
        return end.real if block in ("X", "CCX") else end.imag


@dataclass(slots=True)
class _Words:
    """The words of an element: values, end and direction of the block that PAR names, the place where CLSD began."""

    element: Element
    v: dict[str, float]
    parallel: Known | None
    closing: complex | None

    def end(self) -> complex | None:
        """Return the end where words give both of its coordinates."""
        v = self.v
        if v.get("CLSD") == -1.0 and self.closing is not None:
            return self.closing
        if "PR" in v and "PA" in v:
            return _polar(self.element.pole, v["PR"], v["PA"])
        return _point(v, "X", "Y")

    def curves(self, start: complex | None, heading: complex | None) -> list[Curve]:
        """Return the lines or circles that the element may be."""
        found = self._circles(start, heading) if self.element.arc else self._lines(start, heading)
        return [curve for curve in found if start is None or curve.beside(start) < _BESIDE]

    def _ways(self, start: complex | None, heading: complex | None) -> list[complex]:
        v, end, on = self.v, self.end(), _point(self.v, "P1X", "P1Y")
        if "AN" in v:
            return [cmath.rect(1.0, math.radians(v["AN"]))]
        if self.element.tangential and heading is not None:
            return [heading]
        if start is not None and end is not None:
            return [(end - start) / abs(end - start)] if abs(end - start) > _TINY else []
        if self.parallel is not None and self.parallel[1] is not None:
            return [self.parallel[1], -self.parallel[1]]
        if start is not None and on is not None and abs(on - start) > _TINY:
            return [(on - start) / abs(on - start), (start - on) / abs(on - start)]
        return (
            _ways_of_length(v, start)
            if start is not None and "LEN" in v and (("X" in v) != ("Y" in v))
            else []
        )

    def _lines(self, start: complex | None, heading: complex | None) -> list[Curve]:
        v, ways, beside = self.v, self._ways(start, heading), self._beside()
        if start is not None:
            found = [Curve(start, way) for way in ways]
            return [
                one for one in found if beside is None or abs(one.beside(beside[0]) - beside[1]) < _BESIDE
            ]
        place = self.end()
        if place is None:
            place = _point(v, "P1X", "P1Y")
        if place is None and len(ways) == 1:
            # A line along an axis lies where one coordinate of its end does.
            name, part = ("X", ways[0].real) if "X" in v else ("Y", ways[0].imag)
            if name in v and abs(part) < _TINY:
                place = complex(v[name], 0.0) if name == "X" else complex(0.0, v[name])
        if place is not None:
            return [Curve(place, way) for way in ways]
        if beside is None:
            return []
        about, far = beside
        sides = (0.0,) if far == 0.0 else (-far, far)
        return [Curve(about + 1j * way * side, way) for way in ways for side in sides]

    def _beside(self) -> tuple[complex, float] | None:
        """Return a place beside which a line lies, and how far."""
        place = _point(self.v, "PDX", "PDY")
        if place is not None and "D" in self.v:
            return place, abs(self.v["D"])
        if self.parallel is not None and "DP" in self.v:
            return self.parallel[0], abs(self.v["DP"])
        return None

    def spin(self) -> int:
        """Return the sense of an arc."""
        if "DR" not in self.v:
            message = "an arc of a free contour has no sense of rotation"
            raise BlockError("arc-sense", message, "DR", hint="DR+ or DR-")
        return 1 if self.v["DR"] > 0.0 else -1

    def centre(self) -> complex | None:
        """Return the centre where words give both of its coordinates."""
        v = self.v
        if "CCPR" in v and "CCPA" in v:
            return _polar(self.element.pole, v["CCPR"], v["CCPA"])
        return _point(v, "CCX", "CCY")

    def _circles(self, start: complex | None, heading: complex | None) -> list[Curve]:
        v, spin, radius = self.v, self.spin(), abs(self.v.get("R", 0.0))
        centre, end = self.centre(), self.end()
        if centre is not None:
            reach = radius
            if start is not None:
                reach = abs(start - centre)
                if radius and abs(reach - radius) > _BESIDE:
                    return []
            elif not radius and end is not None:
                reach = abs(end - centre)
            return [Curve(centre, radius=reach, spin=spin)] if reach > _TINY else []
        if start is None:
            return []
        way = heading if self.element.tangential else None
        if "AN" in v:
            way = cmath.rect(1.0, math.radians(v["AN"]))
        if way is not None:
            side = 1j * way * spin
            if end is not None:
                # The centre is beside the start and as far from the end.
                chord = end - start
                aside = (chord * side.conjugate()).real
                radius = abs(chord) ** 2 / (2.0 * aside) if aside > _TINY else 0.0
            elif not radius:
                for name, here, part in (("CCX", start.real, side.real), ("CCY", start.imag, side.imag)):
                    if name in v and abs(part) > _TINY:
                        radius = (v[name] - here) / part
            return [Curve(start + side * radius, radius=radius, spin=spin)] if radius > _TINY else []
        if not radius:
            return []
        about = Curve(start, radius=radius, spin=1)
        places: list[complex] = []
        if end is not None:
            places = _crossings(about, Curve(end, radius=radius, spin=1))
        elif "CCX" in v:
            places = _crossings(Curve(complex(v["CCX"], 0.0), 1j), about)
        elif "CCY" in v:
            places = _crossings(Curve(complex(0.0, v["CCY"]), 1.0 + 0j), about)
        return [Curve(place, radius=radius, spin=spin) for place in places]

    def touching(self, before: Curve) -> list[Curve]:
        """Return the lines or circles that the element may be as it touches the one before it, whose end is open."""
        v, end = self.v, self.end()
        if not self.element.arc:
            if "AN" in v and before.radius:
                way = cmath.rect(1.0, math.radians(v["AN"]))
                return [Curve(before.point - 1j * way * before.spin * before.radius, way)]
            line = _tangent_line(before, Curve(end)) if end is not None else None
            return [line] if line is not None else []
        spin, radius, centre = self.spin(), abs(v.get("R", 0.0)), self.centre()
        if centre is not None:
            far = abs(centre - before.point)
            reach = (
                (far - before.radius, before.radius - far, before.radius + far)
                if before.radius
                else (before.beside(centre),)
            )
            return [Curve(centre, radius=r, spin=spin) for r in reach if r > _TINY]
        if not radius or end is None:
            return []
        places = _crossings(_inside(before, radius, spin), Curve(end, radius=radius, spin=1))
        return [Curve(place, radius=radius, spin=spin) for place in places]

    def ended(self, part: _Part, curve: Curve) -> Iterator[_Part]:
        """Yield the solutions in which the element is a curve from the part's start on, its end open where the words do not give it."""
        start = part.start
        assert start is not None
        if self.v.get("CLSD") == 1.0:
            part = replace(part, closing=start)
        ends = self._ends(curve, start)
        if ends is None:
            yield replace(part, open=((self.element, curve),))
            return
        for end in ends:
            if _leads(curve, start, end):
                ended = part.closed(curve, end)
                # An end that is given in full may be that of a whole circle.
                yield replace(ended, whole=part.whole) if self.end() is not None else ended

    def _ends(self, curve: Curve, start: complex) -> list[complex] | None:
        v, end = self.v, self.end()
        if end is not None:
            return [end]
        if curve.radius and "CCA" in v:
            turn = cmath.rect(1.0, curve.spin * math.radians(abs(v["CCA"])))
            return [curve.point + (start - curve.point) * turn]
        if curve.radius and 0.0 < v.get("LEN", 0.0) <= 2.0 * curve.radius:
            sweep = 2.0 * math.asin(v["LEN"] / 2.0 / curve.radius) * curve.spin
            return [curve.point + (start - curve.point) * cmath.rect(1.0, turn) for turn in (sweep, -sweep)]
        if "LEN" in v:
            return [start + curve.way * v["LEN"]] if not curve.radius else []
        across = Curve(complex(v.get("X", 0.0), 0.0), 1j)
        along = Curve(complex(0.0, v.get("Y", 0.0)), 1.0 + 0j)
        if "X" in v and (curve.radius or abs(curve.way.real) > _TINY):
            return _crossings(across, curve)
        if "Y" in v and (curve.radius or abs(curve.way.imag) > _TINY):
            return _crossings(along, curve)
        if "PA" in v:
            return _crossings(Curve(_pole(self.element.pole), cmath.rect(1.0, math.radians(v["PA"]))), curve)
        if "PR" in v:
            return _crossings(Curve(_pole(self.element.pole), radius=abs(v["PR"]), spin=1), curve)
        return None


def choice_of(element: Element, segment: Segment, count: int) -> BlockError:
    """Return what is said of a solution that FSELECT chose of so many."""
    start, end = segment.start, segment.end
    message = (
        f"FSELECT {element.select} chooses one of {count} solutions by an order that is not published: {element.name} goes from"
        f" X{start.real:.4g} Y{start.imag:.4g} to X{end.real:.4g} Y{end.imag:.4g}"
    )
    hint = "compare it with the drawing, or give the end, the centre or the angle"
    return BlockError("free-contour-choice", message, element.name, hint=hint)


def check_data(element: Element, segment: Segment) -> None:
    """Raise where the element has more data than it needs, and they do not agree with its solution."""
    given, end, centre = element.values, segment.end, segment.centre
    found = {"X": end.real, "Y": end.imag, "LEN": abs(end - segment.start)}
    if centre is not None:
        found |= {"CCX": centre.real, "CCY": centre.imag, "R": abs(end - centre)}
    for name, value in found.items():
        wanted = given.get(name, value)
        if abs((abs(wanted) if name in ("LEN", "R") else wanted) - value) > _DATA:
            message = (
                f"{name}{wanted:g} of {element.name} contradicts its other data, by which it is {value:.6g}"
            )
            raise BlockError(
                "free-contour", message, element.name, hint=f"leave {name} out, or what it contradicts"
            )


def first_heading(elements: Sequence[Element], start: Sequence[float]) -> complex:
    """Return the direction in which a row of elements leaves a point."""
    segment = Chain(elements, complex(start[0], start[1]), None).solve()[0]
    return segment.heading(segment.start)


def _key(segment: Segment) -> tuple[float, ...]:
    centre, end = segment.centre or 0j, segment.end
    return (*(round(value, 5) for value in (end.real, end.imag, centre.real, centre.imag)), segment.spin)


def _apart(parts: Iterator[_Part], known: int) -> list[_Part]:
    """Return solutions without those that are the same; they share as many elements as were known."""
    found: dict[object, _Part] = {}
    for part in parts:
        curves = tuple((c.point, c.way, c.radius, c.spin) if c is not None else None for _, c in part.open)
        found.setdefault((tuple(map(_key, part.done[known:])), curves), part)
    return list(found.values())


def _point(v: dict[str, float], first: str, second: str) -> complex | None:
    return complex(v[first], v[second]) if first in v and second in v else None


def _ways_of_length(v: dict[str, float], start: complex) -> list[complex]:
    """Return the directions of a line of a length that ends at one coordinate."""
    along = v["X"] - start.real if "X" in v else v["Y"] - start.imag
    length = abs(v["LEN"])
    if length <= 0.0 or abs(along) > length:
        return []
    across = math.sqrt(length**2 - along**2)
    ways = [complex(along, side * across) if "X" in v else complex(side * across, along) for side in (-1, 1)]
    return [way / length for way in (ways if across > _SAME else ways[:1])]


def _leads(curve: Curve, start: complex, end: complex) -> bool:
    """Tell whether an end lies on a curve, on a line ahead of the start."""
    ahead = curve.radius or ((end - start) * curve.way.conjugate()).real > _TINY
    return bool(ahead) and curve.beside(end) < _BESIDE and curve.beside(start) < _BESIDE


def _pole(pole: complex | None) -> complex:
    if pole is None:
        message = "a free contour in polar coordinates has no pole"
        raise BlockError("pole-missing", message, "FPOL", hint="FPOL X+0 Y+0 stands before")
    return pole


def _polar(pole: complex | None, radius: float, angle: float) -> complex:
    return _pole(pole) + cmath.rect(radius, math.radians(angle))


def _between(one: Curve, two: Curve, element: Element) -> list[Curve]:
    """Return the lines, or circles of a radius, that touch two curves in their senses."""
    if not element.arc:
        line = _tangent_line(one, two)
        return [line] if line is not None else []
    if "R" not in element.values or "DR" not in element.values:
        return []
    spin, radius = (1 if element.values["DR"] > 0.0 else -1), abs(element.values["R"])
    places = _crossings(_inside(one, radius, spin), _inside(two, radius, spin))
    return [Curve(place, radius=radius, spin=spin) for place in places]


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
    """Return where two curves meet: a line leaves a circle before it enters it, and the right side of the way between circles comes first."""
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
        foot, way, radius = one.point + apart / abs(apart) * along, -1j * apart / abs(apart), one.radius
        half = radius**2 - along**2
    else:
        line, circle = (two, one) if one.radius else (one, two)
        foot = line.point + ((circle.point - line.point) * line.way.conjugate()).real * line.way
        way, half = line.way, circle.radius**2 - abs(foot - circle.point) ** 2
    if half < -_SAME:
        return []
    if half < _SAME:
        return [foot]
    return [foot + math.sqrt(half) * way, foot - math.sqrt(half) * way]
