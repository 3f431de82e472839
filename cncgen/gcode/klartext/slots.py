"""Cycles of Heidenhain's plain language: 251 to 254, pockets and slots, and 3, 4, 5, those of TNC 155 to 426 whose values stand in parts.

Walls, levels and feeds are the cycle's (iTNC 530, user's manual for cycles; TNC 426 pilot), the loops that clear them our own.
"""

from __future__ import annotations

import cmath
import math

from cncgen.gcode.codes.pockets import Bow, Clearing, Pocket, clear, clear_bow
from cncgen.gcode.codes.steps import MOST
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import finishing
from cncgen.gcode.klartext.hole_cycle import HoleCycle, check_feeds


def pocket(
    cycle: HoleCycle, length: float, width: float, corner: float, angle: float, middle: complex | None = None
) -> None:
    """Rough and finish a pocket at the tool's place, or about a middle that lies elsewhere."""
    ip, q, tool = cycle.ip, cycle.q, cycle.ip.cutting_radius(cycle.name, min(length, width) / 2.0)
    roughs, finishes, side, floor = works(cycle)
    place = cycle.place()
    middle = place if middle is None else middle
    step, sense = (q[370] or 1.0) * tool, -1 if q[351] < 0.0 else 1
    wall = Pocket(middle, length / 2.0, width / 2.0, corner, angle)
    if roughs:
        levels = cycle.infeeds(202, floor)
        how = Clearing(tool, step, levels, cycle.start, q[207], q[206], sense)
        clear(ip, wall.within(side), how, cycle.name)
    if finishes and side > 0.0:
        levels = cycle.infeeds(338)
        how = Clearing(tool, step, levels, cycle.start, q[385] or q[207], q[206], sense)
        finishing.wall_of_pocket(cycle, wall, how, side)
    if finishes and floor > 0.0:
        how = Clearing(tool, step, (cycle.bottom,), cycle.start, q[385] or q[207], q[206], sense)
        clear(ip, wall, how, cycle.name)
    cycle.home = place


def _turned(cycle: HoleCycle, way: complex, angle: float) -> complex:
    """Return the place that lies a way, turned by an angle, from the tool."""
    return cycle.place() + way * cmath.rect(1.0, math.radians(angle))


def _refuse(cycle: HoleCycle) -> BlockError:
    message = f"Q367 = {cycle.q[367]:g} of {cycle.name} names no place: it is 0 to 4"
    return BlockError("cycle-words", message, "CYCL", hint="Q367=0 has the tool in the middle")


def middle_of(cycle: HoleCycle, size: tuple[float, float], angle: float) -> complex:
    """Return the middle of a rectangle, in which the tool stands (Q367 = 0), or of which it is a corner: 1 to 4 from the lower left one on."""
    sides = {0: (0, 0), 1: (1, 1), 2: (-1, 1), 3: (-1, -1), 4: (1, -1)}.get(round(cycle.q[367]))
    if sides is None:
        raise _refuse(cycle)
    return _turned(cycle, complex(sides[0] * size[0], sides[1] * size[1]) / 2.0, angle)


def middle_of_slot(cycle: HoleCycle, length: float, width: float, angle: float) -> complex:
    """Return the middle of a slot, in which the tool stands (Q367 = 0), or at its left end (1), in the middle of the left (2) or right circle
    (3), or at its right end (4)."""
    ways = (0.0, length / 2.0, (length - width) / 2.0, (width - length) / 2.0, -length / 2.0)
    kind = round(cycle.q[367])
    if not 0 <= kind < len(ways):
        raise _refuse(cycle)
    return _turned(cycle, complex(ways[kind], 0.0), angle)


def works(cycle: HoleCycle) -> tuple[bool, bool, float, float]:
    """Return whether the cycle roughs and finishes (Q215), and the allowances between the two, Q368 at the side and Q369 at the floor.

    Finishing makes the wall or the floor that has an allowance (iTNC 530, cycle 251).
    """
    q, kind = cycle.q, round(cycle.q[215])
    check_feeds(cycle)
    message = f"Q215 = {q[215]:g} of {cycle.name} is not 0, 1 or 2"
    hint = "0 roughs and finishes, 1 roughs, 2 finishes"
    refuse("CYCL", (kind not in (0, 1, 2), "cycle-words", message, hint))
    side, floor = max(q[368], 0.0), max(q[369], 0.0)
    if kind == 2 and not side and not floor:
        message = f"{cycle.name} finishes (Q215 = 2) and has no allowance Q368 or Q369: it is not made"
        cycle.ip.warn("cycle-idle", message, "CYCL", "allowances say what is left")
    return kind != 2, kind != 1, side, floor


def bows(cycle: HoleCycle) -> None:
    """254: Q377 slots of width Q219 along the circle Q375, each over the angle Q248, Q378 from one to the next.

    They lie about Q216 Q217 from Q376 on (Q367 = 0), or the tool is in the first one at the angle Q376: in its middle (2), in its left (1) or
    right end (3), as they are seen from the middle of the circle outwards, which no text says.
    """
    q, ip, tool = cycle.q, cycle.ip, cycle.ip.cutting_radius(cycle.name, cycle.q[219] / 2.0)
    roughs, finishes, side, floor = works(cycle)
    count = round(q[377] or 1.0)
    wrong = not 1 <= count <= MOST or not 0.0 < abs(q[248]) <= 360.0
    message = f"Q377 = {q[377]:g} or Q248 = {q[248]:g} of {cycle.name} makes no slot"
    refuse("CYCL", (wrong, "cycle-words", message, "Q377 counts the slots, Q248 is the angle of one"))
    middle, start = complex(q[216], q[217]), q[376]
    if kind := round(q[367]):
        middle = cycle.place() - cmath.rect(q[375] / 2.0, math.radians(q[376]))
        parts = {1: 1.0, 2: 0.5, 3: 0.0}
        if kind not in parts:
            raise _refuse(cycle)
        start -= parts[kind] * q[248]
    if kind in (1, 3):
        message = f"Q367 = {kind} of {cycle.name}: the slot goes from the tool on {('counter-' if (kind == 3) == (q[248] > 0.0) else '')}clockwise"
        hint = "which end is the left one the manual shows in a figure alone; Q367=0 with Q216 Q217 or Q367=2 leave no doubt"
        cycle.ip.warn_once("slot-place", message, "CYCL", hint)
    sense, feed = -1 if q[351] < 0.0 else 1, q[385] or q[207]
    runs = []
    if roughs:
        levels = cycle.infeeds(202, floor)
        runs.append((side, Clearing(tool, tool, levels, cycle.start, q[207], q[206], sense)))
    if finishes and side > 0.0:
        levels = cycle.infeeds(338)
        runs.append((0.0, Clearing(tool, q[219], levels, cycle.start, feed, q[206], sense)))
    if finishes and floor > 0.0:
        runs.append((0.0, Clearing(tool, tool, (cycle.bottom,), cycle.start, feed, q[206], sense)))
    for k in range(count):
        begin = start + k * q[378]
        cycle.go(cycle.back if k else cycle.start, rapid=True)
        bow = Bow(middle, q[375] / 2.0, *sorted((begin, begin + q[248])))
        for left, how in runs:
            clear_bow(ip, bow, q[219] / 2.0 - left, how, cycle.name)


def rectangular_pocket(cycle: HoleCycle) -> None:
    """251: Q218 by Q219, corners Q220, turned by Q224 about the tool's place, which Q367 names."""
    q = cycle.q
    middle = middle_of(cycle, (q[218], q[219]), q[224])
    pocket(cycle, q[218], q[219], q[220], q[224], middle)


def round_pocket(cycle: HoleCycle) -> None:
    """252: the diameter Q223."""
    pocket(cycle, cycle.q[223], cycle.q[223], cycle.q[223] / 2.0, 0.0)


def straight_slot(cycle: HoleCycle) -> None:
    """253: a slot of length Q218 and width Q219, turned by Q374 about the tool's place, which Q367 names."""
    q = cycle.q
    middle = middle_of_slot(cycle, q[218], q[219], q[374])
    pocket(cycle, q[218], q[219], q[219] / 2.0, q[374], middle)


def rectangle(cycle: HoleCycle, values: dict[str, float]) -> None:
    """4: X by Y about the tool's place, corners of RADIUS (the tool's, where it is left out); the length may lie along Y."""
    tool = cycle.ip.cutting_radius(cycle.name, min(abs(values["X"]), abs(values["Y"])) / 2.0)
    corner, angle = max(values["RADIUS"], tool), 90.0 * values["FIRST"]
    pocket(cycle, abs(values["X"]), abs(values["Y"]), corner, angle)


def circle(cycle: HoleCycle, values: dict[str, float]) -> None:
    """5: RADIUS about the tool's place."""
    pocket(cycle, 2.0 * values["RADIUS"], 2.0 * values["RADIUS"], values["RADIUS"], 0.0)


def slot(cycle: HoleCycle, values: dict[str, float]) -> None:
    """3: from one end of the slot, where the tool stands within it, along the first side, whose sign says which way."""
    ip: Interpreter = cycle.ip
    along = 1.0 + 0j if values["FIRST"] == 0.0 else 1j
    length, width = values["X"], values["Y"]
    tool = ip.cutting_radius(cycle.name, min(abs(length), abs(width)) / 2.0)
    way = along * (math.copysign(abs(length) / 2.0 - tool, length))
    middle = cycle.place() + way
    pocket(cycle, abs(length), abs(width), abs(width) / 2.0, 0.0 if along == 1.0 else 90.0, middle)
