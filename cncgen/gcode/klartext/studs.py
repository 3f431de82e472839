"""Cycles of Heidenhain's plain language that mill from outside: 256 and 257 studs, 232 and 233 faces (TNC 640, user's manual for cycles),
230 faces and 231 ruled surfaces (TNC 410, 426 and 430, user's manual, 8.8).

The finished wall, the blank, levels, feeds, and the way to them, 2 mm to the right of the blank or off its corner that Q437 names (TNC 320,
user's manual for cycles, 9/2016, p. 154), are the cycle's; loops and rows are our own.
"""

from __future__ import annotations

import math

from cncgen.gcode.codes.pockets import Clearing, Pocket, PocketPath
from cncgen.gcode.codes.steps import MOST, levels_of, steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import slots
from cncgen.gcode.klartext.hole_cycle import HoleCycle

#: The cycle that mills a face from the tool's place on.
FACE = 233
_TINY = 1e-9
#: How far beside the blank cycles 256 and 257 go down, mm.
_BESIDE = 2.0
#: Where they do, along X and Y, by Q437: to the right, or at a corner, from the lower left one on.
_APPROACHES = ((1, 0), (-1, -1), (1, -1), (1, 1), (-1, 1))


def _radius(ip: Interpreter, name: str) -> float:
    radius, message = ip.cutting_radius(name), f"{name} goes around at the radius of the tool, which has none"
    refuse("CYCL", (radius <= 0.0, "cycle-tool", message, "--tool-table gives the diameter of the tool"))
    return radius


def _count(way: float, step: float, name: str) -> int:
    """Return how many steps a way takes, one at least."""
    makes, hint = f"{name} makes {{}} loops or rows", "Q370 is the step aside in radii of the tool"
    refuse("CYCL", (step <= 0.0, "cycle-infeed", f"{name} steps aside by {step:g}", hint))
    return steps_of(way, step, "CYCL", makes, hint)


def _stud(
    cycle: HoleCycle,
    place: complex,
    size: complex,
    blank: complex,
    corner: float,
    angle: float,
    approach: int = 0,
) -> None:
    """Mill a stud free about its middle: loops from the blank in to the finished wall, at each level; back to where the tool was.

    Roughing (Q215 = 0 or 1) leaves Q368 on the wall and Q369 on the floor, finishing (0 or 2) takes them at Q385, the wall in infeeds Q338.
    """
    ip, name, q = cycle.ip, cycle.name, cycle.q
    radius, before = _radius(ip, name), cycle.place()
    excess = max(blank.real - size.real, blank.imag - size.imag) / 2.0
    wrong = min(size.real, size.imag) <= 0.0 or excess < -_TINY
    message = (
        f"{name} has a blank of {blank.real:g} by {blank.imag:g} and a stud of {size.real:g} by {size.imag:g}"
    )
    refuse("CYCL", (wrong, "cycle-words", message, "the blank is not smaller than the stud"))
    roughs, finishes, side, floor = slots.works(cycle)
    step = (q[370] or 1.0) * radius
    count = _count(excess - side, step, name)
    # Seen with its length along Y, so that loops begin at the side to the right.
    pocket = Pocket(place, size.imag / 2.0, size.real / 2.0, corner, angle + 90.0)
    off = radius + _BESIDE / cycle.ip.state.unit_mm
    x, y = _APPROACHES[approach]
    beside = complex(y * (blank.imag / 2.0 + off), -x * (blank.real / 2.0 + off))

    def mill(levels: tuple[float, ...], feed: float, left: float, loops: int) -> None:
        sense = 1 if q[351] < 0.0 else -1
        path = PocketPath(ip, pocket, Clearing(-radius, step, levels, cycle.start, feed, q[206], sense))
        path.fastest = cycle.fastest
        path.free(beside, left, loops, (approach + 1) % 4 if approach else None)

    if roughs:
        mill(cycle.infeeds(202, floor), q[207], side, count)
    if finishes and floor > 0.0:
        mill((cycle.bottom,), q[385] or q[207], side, count)
    if finishes and side > 0.0:
        mill(cycle.infeeds(338), q[385] or q[207], 0.0, 1)
    cycle.end()
    cycle.to(before, rapid=True)


def rectangle(ip: Interpreter, name: str) -> None:
    """256: Q218 by Q219 out of Q424 by Q425, corners Q220, turned by Q224 about the tool's place, which Q367 names; from Q437 on."""
    q = ip.parameters.numbers
    cycle, approach = HoleCycle(ip, name), round(q[437])
    message = f"Q437 = {q[437]:g} of {name} names no place to begin at"
    hint = "0 is to the right of the stud, 1 to 4 are its corners from the lower left one on"
    chamfer = f"chamfers of {name} (Q220 = {q[220]:g}) are not read"
    refuse(
        "CYCL",
        (not 0 <= approach < len(_APPROACHES), "cycle-words", message, hint),
        (q[220] < 0.0, "unsupported-block", chamfer, "Q220 above 0 rounds the corners"),
    )
    middle = slots.middle_of(cycle, (q[218], q[219]), q[224])
    _stud(cycle, middle, complex(q[218], q[219]), complex(q[424], q[425]), q[220], q[224], approach)


def circle(ip: Interpreter, name: str) -> None:
    """257: the diameter Q223 out of Q222, begun at the angle Q376, which is -1 for the right."""
    q = ip.parameters.numbers
    cycle, middle = HoleCycle(ip, name), complex(*ip.state.position[:2])
    _stud(cycle, middle, complex(q[223], q[223]), complex(q[222], q[222]), q[223] / 2.0, max(q[376], 0.0))


def face(ip: Interpreter, name: str) -> None:
    """232: Q218 by Q219 from Q225 Q226 on, from Q227 down to Q386 in steps of Q202, the last one Q369.

    Q389: rows to and fro with steps aside outside, at Q253 (0), or at the edge, at Q207 (1), or all in one direction (2).
    """
    q = ip.parameters.numbers
    _face(ip, name, (q[225], q[226]), 0, round(q[389]))


def face_from_here(ip: Interpreter, name: str) -> None:
    """233: as 232 from the tool's place on, which Q367 = 1 to 4 name a corner of the face and 0 its middle; Q350 = 2: rows along Y.

    Roughing (Q215 = 0 or 1) leaves Q369, finishing (0 or 2) takes it. Q389 = 3 has rows in one direction that end at the edge. 4, from outside to inside, is milled in rows to and fro.
    """
    q = ip.parameters.numbers
    way, place = round(q[389]), round(q[367])
    unread = way not in range(5) or place not in range(-1, 5) or any(q[limit] for limit in (347, 348, 349))
    message = f"Q389 = {way}, Q367 = {place} or walls of {name} (Q347, Q348, Q349) are not read"
    hint = "Q389 is 0 to 4, Q367 -1 to 4, and Q347 to Q349 are 0"
    refuse("CYCL", (unread, "unsupported-block", message, hint))
    back = {0: (0.5, 0.5), 2: (1.0, 0.0), 3: (1.0, 1.0), 4: (0.0, 1.0)}.get(place, (0.0, 0.0))
    x, y = ip.state.position[:2]
    corner = (x - back[0] * q[218], y - back[1] * q[219])
    _face(ip, name, corner, 1 if round(q[350]) == 2 else 0, 0 if way == 4 else way)


def _face(ip: Interpreter, name: str, corner: tuple[float, float], along: int, way: int) -> None:
    """Mill a face in rows along X (0) or Y (1)."""
    q, radius = ip.parameters.numbers, _radius(ip, name)
    wrong = way not in (0, 1, 2, *((3,) if name == f"cycle {FACE}" else ())) or q[227] < q[386]
    message = f"Q389 = {q[389]:g}, Q227 = {q[227]:g} and Q386 = {q[386]:g} do not make {name}"
    refuse("CYCL", (wrong, "cycle-words", message, "Q389 is 0, 1 or 2; Q386 lies below Q227"))
    cycle = HoleCycle(ip, name, (q[227], q[386] - q[227]))
    length, width = (q[218], q[219]) if along == 0 else (q[219], q[218])
    count = _count(abs(width), (q[370] or 1.0) * radius, name)
    sense, across = math.copysign(1.0, length), math.copysign(1.0, width)
    over = radius + q[357] if way in (0, 2) else 0.0
    ends = (corner[along] - sense * over, corner[along] + length + sense * over)
    passes, one_way = _passes(cycle), way in (2, 3)

    def to(at: float, k: int, *, rapid: bool) -> None:
        aside = corner[1 - along] + across * (abs(width) * (k + 1) / count - radius)
        cycle.to(complex(aside, at) if along else complex(at, aside), rapid=rapid)

    cycle.go(cycle.back, rapid=True)
    for level, cutting in passes:
        if level == passes[0][0] or not one_way:
            to(ends[0], 0, rapid=True)
            cycle.go(max(cycle.start, level), rapid=True)
        for k in range(count):
            first, last = ends if one_way or k % 2 == 0 else ends[::-1]
            cycle.feed(q[253] or q[207], "Q253")
            if one_way and (k or level != passes[0][0]):
                cycle.go(level + q[200], rapid=False)
                to(first, k, rapid=False)
            if k == 0 or one_way:
                cycle.go(level, rapid=False)
            elif way == 0:
                to(first, k, rapid=False)
            cycle.feed(cutting, "Q207")
            if k and way == 1:
                to(first, k, rapid=False)
            to(last, k, rapid=False)
        if not one_way:
            cycle.go(cycle.start, rapid=True)
    cycle.end()


def _passes(cycle: HoleCycle) -> list[tuple[float, float]]:
    """Return the levels of a face and the feed at each: those of roughing leave Q369, that of finishing takes it; raise where Q215 has neither."""
    q, kind = cycle.q, round(cycle.q[215])
    message = f"Q215 = {q[215]:g} and Q369 = {q[369]:g} do not make {cycle.name}"
    wrong = kind not in (0, 1, 2) or (kind == 2 and q[369] <= 0.0)
    refuse(
        "CYCL",
        (wrong, "cycle-words", message, "0 roughs and finishes, 1 roughs, 2 finishes what Q369 leaves"),
    )
    levels = levels_of(q[227], q[386] + q[369], abs(q[202]), cycle.name) if kind != 2 else ()
    finish = [(q[386], q[385] or q[207])] if kind != 1 and q[369] > 0.0 else []
    return [*((level, q[207]) for level in levels), *finish]


def multipass(ip: Interpreter, name: str) -> None:
    """230: Q218 by Q219 from Q225 Q226 on at the height Q227, in Q240 rows to and fro, the tool's radius beyond both ends.

    Down at Q206, along the rows at Q207, from one to the next at Q209. The first and the last row end at the edges of the face.
    """
    q, radius = ip.parameters.numbers, _radius(ip, name)
    count, length, width = round(q[240]), q[218], q[219]
    wrong = not 1 <= count <= MOST or length == 0.0 or width == 0.0
    message = f"{name} has Q240 = {q[240]:g} rows on a face of {length:g} by {width:g}"
    refuse("CYCL", (wrong, "cycle-infeed", message, f"1 to {MOST} rows; Q218 and Q219 are the sides"))
    over, across = math.copysign(radius, length), math.copysign(1.0, width)
    ends = (q[225] - over, q[225] + length + over)
    reach = max(abs(width) - 2.0 * radius, 0.0)
    cycle = HoleCycle(ip, name, (q[227], 0.0))

    def to(x: float, k: int, *, rapid: bool = False) -> None:
        aside = (abs(width) - reach) / 2.0 + (k * reach / (count - 1) if count > 1 else reach / 2.0)
        cycle.to(complex(x, q[226] + across * aside), rapid=rapid)

    to(ends[0], 0, rapid=True)
    cycle.go(cycle.start, rapid=True)
    cycle.feed(q[206], "Q206")
    cycle.go(q[227], rapid=False)
    for k in range(count):
        first, last = ends if k % 2 == 0 else ends[::-1]
        if k:
            cycle.feed(q[209], "Q209")
            to(first, k)
        cycle.feed(q[207], "Q207")
        to(last, k)
    cycle.go(cycle.start, rapid=True)
    ip.sink.set_feed_rate(ip.state.feed)


def ruled(ip: Interpreter, name: str) -> None:
    """231: Q240 lines from the side between points 1 and 4 to that between 2 and 3, the first at half of Q207.

    The points are Q225 to Q236, X Y Z of each. After a line the tool goes up by its diameter, back to where the line began, down there,
    and on to the next line; at the end, that far above the highest point.
    """
    q, lift = ip.parameters.numbers, 2.0 * _radius(ip, name)
    first, second, third, fourth = ([q[225 + 3 * k + axis] for axis in range(3)] for k in range(4))
    count = round(q[240])
    message = f"Q240 = {q[240]:g} of {name} is not a number of lines from 2 to {MOST}"
    hint = "the first line joins points 1 and 2, the last one 4 and 3"
    refuse("CYCL", (not 2 <= count <= MOST, "cycle-infeed", message, hint))
    cycle = HoleCycle(ip, name, (0.0, 0.0))

    def to(place: list[float], *, up: float = 0.0, rapid: bool = False) -> None:
        cycle.to(complex(*place[:2]), place[2] + up, rapid=rapid)

    to(first, rapid=True)
    for k in range(count):
        begin, end = (
            [a + (b - a) * k / (count - 1) for a, b in zip(*side, strict=True)]
            for side in ((first, fourth), (second, third))
        )
        cycle.feed(q[207] * (1.0 if k else 0.5), "Q207")
        if k:
            to(begin)
        to(end)
        to(end, up=lift, rapid=True)
        if k < count - 1:
            to(begin, up=lift, rapid=True)
            to(begin, rapid=True)
    cycle.go(max(point[2] for point in (first, second, third, fourth)) + lift, rapid=True)
    ip.sink.set_feed_rate(ip.state.feed)
