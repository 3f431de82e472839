"""Cycles of Heidenhain's plain language that finish a wall, 212 to 215, and slots with a reciprocating plunge, 210 and 211.

The manual (iTNC 530, user's manual, 8.4, and "Old cycles" of later ones) has the places, the feeds and the order. How far an arc leads to the
wall of a pocket is ours; beside a stud it begins 3.5 radii of the tool from the wall.
"""

from __future__ import annotations

import cmath
import math

from cncgen.gcode.codes.pockets import Bow, Clearing, Pocket, PocketPath
from cncgen.gcode.errors import refuse
from cncgen.gcode.klartext.hole_cycle import HoleCycle, check_feeds, infeeds

_TINY = 1e-9
#: How far beside a stud the way to its wall begins, in radii of the tool.
_BESIDE = 3.5


def _radius(cycle: HoleCycle, half: float = math.inf) -> float:
    radius = cycle.ip.cutting_radius(cycle.name, half)
    message = f"{cycle.name} is {2.0 * half:g} wide, and the tool has the diameter {2.0 * radius:g}"
    if half == math.inf:
        message = f"{cycle.name} goes along a wall at the radius of the tool, which has none"
    wrong, hint = not 0.0 < radius <= half + _TINY, "--tool-table gives the diameter of the tool"
    refuse("CYCL", (wrong, "cycle-tool", message, hint))
    return radius


def _finish(cycle: HoleCycle, wall: Pocket, allowance: float, outside: bool) -> None:
    """Go once around within or beside a wall at each level, on and off it on half a circle, in climb milling.

    An allowance says how far from the wall of a pocket the tool goes down; below 0 that is its middle.
    """
    q, radius = cycle.q, _radius(cycle, math.inf if outside else min(wall.length, wall.width))
    levels = cycle.infeeds(202)
    check_feeds(cycle)
    reach, sense = (-radius, -1) if outside else (radius, 1)
    how = Clearing(reach, 1.0, levels, cycle.start, q[207], q[206], sense)
    path = PocketPath(cycle.ip, wall, how)
    edge = path.begin(0.0)
    if outside:
        place = edge - complex(0.0, (_BESIDE - 1.0) * radius)
    else:
        reach = min(wall.length, wall.width) - radius
        place = edge + complex(0.0, reach if allowance < 0.0 else min(reach, allowance + radius))
    cycle.go(cycle.back, rapid=True)
    path.to(0j, rapid=True)
    path.to(place, rapid=True)
    cycle.go(cycle.start, rapid=True)
    _around(cycle, path, place, edge, 1)
    cycle.home = path.origin


def _around(cycle: HoleCycle, path: PocketPath, place: complex, edge: complex, sense: int) -> None:
    """Go down at a place, on the wall in half a circle, once around, and off it, at each level."""
    for level in path.how.levels:
        cycle.feed(path.how.plunge, "Q206")
        cycle.go(level, rapid=False)
        cycle.feed(path.how.feed, "Q207")
        _half_turn(cycle, path, place, edge, sense)
        path.loop(0.0)
        _half_turn(cycle, path, edge, place, sense)


def wall_of_pocket(cycle: HoleCycle, wall: Pocket, how: Clearing, allowance: float) -> None:
    """Finish the wall of a pocket at each level, from its allowance and the tool's radius away; end at the start's height."""
    path = PocketPath(cycle.ip, wall, how)
    edge = path.begin(0.0)
    reach = min(wall.length, wall.width) - how.radius
    place = edge + complex(0.0, min(reach, allowance + how.radius))
    path.to(place, rapid=True)
    cycle.go(cycle.start, rapid=True)
    _around(cycle, path, place, edge, how.sense)
    cycle.go(cycle.start, rapid=True)


def _half_turn(cycle: HoleCycle, path: PocketPath, begin: complex, end: complex, sense: int) -> None:
    _arc(cycle, path.origin + end * path.turn, path.origin + (begin + end) / 2.0 * path.turn, sense)


def _arc(cycle: HoleCycle, end: complex, centre: complex, sense: int, z: float | None = None) -> None:
    if abs(end - cycle.place()) > _TINY:
        cycle.arc(end, centre, sense, z)


def _middle(cycle: HoleCycle) -> complex:
    return complex(cycle.q[216], cycle.q[217])


def rectangular_pocket(cycle: HoleCycle) -> None:
    """212: Q218 by Q219 about Q216 Q217, corners Q220 (the tool's radius, where it is 0); Q221 is left in front of the wall."""
    q = cycle.q
    half = (abs(q[218]) / 2.0, abs(q[219]) / 2.0)
    corner = q[220] or _radius(cycle, min(half))
    _finish(cycle, Pocket(_middle(cycle), *half, corner), abs(q[221]), False)


def rectangular_stud(cycle: HoleCycle) -> None:
    """213: as 212, from outside."""
    q = cycle.q
    # Seen with its length along Y, so that the way begins to the right.
    wall = Pocket(_middle(cycle), abs(q[219]) / 2.0, abs(q[218]) / 2.0, q[220], 90.0)
    _finish(cycle, wall, 0.0, True)


def round_pocket(cycle: HoleCycle) -> None:
    """214: the diameter Q223 out of Q222 about Q216 Q217; without Q222 the tool goes down in the middle."""
    q = cycle.q
    half = abs(q[223]) / 2.0
    allowance = max(0.0, half - abs(q[222]) / 2.0) if q[222] else -1.0
    _finish(cycle, Pocket(_middle(cycle), half, half, half), allowance, False)


def round_stud(cycle: HoleCycle) -> None:
    """215: as 214, from outside."""
    half = abs(cycle.q[223]) / 2.0
    _finish(cycle, Pocket(_middle(cycle), half, half, half, 90.0), 0.0, True)


def _slot_width(cycle: HoleCycle) -> tuple[float, float]:
    """Return half the width Q219 of a slot and the radius of the tool, which is a third of it or more.

    Raises:
        BlockError: The tool does not fit, or Q215 or the feed has no meaning.
    """
    q = cycle.q
    half = abs(q[219]) / 2.0
    radius = _radius(cycle, half)
    wrong = half > 3.0 * radius + _TINY or round(q[215]) not in (0, 1, 2)
    message = f"{cycle.name} has Q215 = {q[215]:g} and the width {2.0 * half:g} for a tool of diameter {2.0 * radius:g}"
    refuse(
        "CYCL",
        (wrong, "cycle-tool", message, "Q215 is 0, 1 or 2; the tool is a third of the width or more"),
        (q[207] <= 0.0, "feed-missing", f"{cycle.name} has no feed: Q207 = 0", "Q207 mills"),
    )
    return half, radius


def _plunge(cycle: HoleCycle, begin: complex, end: complex, along: Bow | None) -> None:
    """Go to and fro along the middle of a slot, deeper by half of Q202 each way; at the depth to the other end, and half the way back."""
    q = cycle.q
    ends = (begin, end)

    def to(k: int, level: float) -> None:
        if along is None:
            cycle.to(ends[k], level)
        else:
            _arc(cycle, ends[k], along.centre, 1 if k else -1, level)

    cycle.feed(q[207], "Q207")
    cycle.go(q[203], rapid=False)
    levels = infeeds(q[203], cycle.bottom, abs(q[202]) / 2.0, cycle.name)
    for k, level in enumerate(levels):
        to((k + 1) % 2, level)
    to((len(levels) + 1) % 2, cycle.bottom)
    if along is None:
        cycle.to((begin + end) / 2.0)
    else:
        back = -1 if len(levels) % 2 == 0 else 1
        _arc(cycle, along.place(along.radius, (along.begin + along.end) / 2.0), along.centre, back)


def _slot_begins(cycle: HoleCycle, begin: complex) -> None:
    """Go to the second clearance, above the middle of the first end, and down to the set-up clearance."""
    cycle.go(cycle.back, rapid=True)
    cycle.to(begin, rapid=True)
    cycle.go(cycle.start, rapid=True)


def _to_begin(cycle: HoleCycle, begin: complex, along: Bow | None) -> None:
    """Go along the middle of a slot to its first end."""
    if along is not None:
        _arc(cycle, begin, along.centre, -1)
    elif abs(begin - cycle.place()) > _TINY:
        cycle.to(begin, rapid=False)


def _finish_slot(
    cycle: HoleCycle, begin: complex, loop: list[tuple[complex, complex | None, int]], along: Bow | None
) -> None:
    """Go around at each infeed of Q338: from the middle of the first end on half a circle to the first place of a loop, and so back.

    A loop has an end, a centre (none of a line) and a sense each, and its first entry is where it begins.
    """
    q = cycle.q
    edge = loop[0][0]
    for level in cycle.infeeds(338):
        cycle.feed(q[207], "Q207")
        _to_begin(cycle, begin, along)
        cycle.feed(q[206] or q[207], "Q206")
        cycle.go(level, rapid=False)
        cycle.feed(q[207], "Q207")
        _arc(cycle, edge, (begin + edge) / 2.0, 1)
        for end, centre, sense in loop[1:]:
            if centre is None:
                cycle.to(end, rapid=False)
            else:
                _arc(cycle, end, centre, sense)
        _arc(cycle, begin, (begin + edge) / 2.0, 1)


def slot(cycle: HoleCycle) -> None:
    """210: Q218 by Q219 about Q216 Q217, turned by Q224: roughed along its middle (Q215 = 0, 1), then finished all around (0, 2)."""
    q = cycle.q
    half, radius = _slot_width(cycle)
    turn, side = cmath.rect(1.0, math.radians(q[224])), half - radius
    reach = abs(q[218]) / 2.0 - half
    message = f"{cycle.name} is {abs(q[218]):g} long and {2.0 * half:g} wide"
    refuse("CYCL", (reach < 0.0, "cycle-words", message, "Q218 is the length, Q219 the width"))
    begin, end = _middle(cycle) - reach * turn, _middle(cycle) + reach * turn
    _slot_begins(cycle, begin)
    if round(q[215]) != 2:
        _plunge(cycle, begin, end, None)
    if round(q[215]) != 1 and side > _TINY:
        across = 1j * turn * side
        loop = [(begin - side * turn, None, 1), (begin - across, begin, 1), (end - across, None, 1), (end + across, end, 1),
                (begin + across, None, 1), (begin - side * turn, begin, 1)]  # fmt: skip
        _finish_slot(cycle, begin, loop, None)


def bow(cycle: HoleCycle) -> None:
    """211: Q219 wide along the circle Q244 about Q216 Q217, from Q245 over Q248; as 210."""
    q = cycle.q
    half, radius = _slot_width(cycle)
    side, ring = half - radius, abs(q[244]) / 2.0
    wrong = ring < half or not 0.0 < abs(q[248]) < 360.0
    message = f"{cycle.name} is {2.0 * half:g} wide on a circle of {2.0 * ring:g}, over {q[248]:g} degrees"
    refuse("CYCL", (wrong, "cycle-words", message, "Q244 is the diameter of the middle line, Q248 the angle"))
    along = Bow(_middle(cycle), ring, *sorted((q[245], q[245] + q[248])))
    begin, end = along.place(ring, along.begin), along.place(ring, along.end)
    _slot_begins(cycle, begin)
    if round(q[215]) != 2:
        _plunge(cycle, begin, end, along)
    if round(q[215]) != 1 and side > _TINY:
        edge = along.place(ring + side, along.begin)
        _finish_slot(cycle, begin, [(edge, None, 1), *along.loop(side, 1)], along)
