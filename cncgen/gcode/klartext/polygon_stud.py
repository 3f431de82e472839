"""Cycle 258 of Heidenhain's plain language: studs with 3 sides and more, roughed and finished (TNC 640, user's manual for cycles, "POLYGON STUD").

The wall, the blank, levels, allowances and feeds are the cycle's; loops, and the straight way to them along the first corner, are our own.
"""

from __future__ import annotations

import cmath
import math

from cncgen.gcode.codes.steps import steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext.hole_cycle import HoleCycle, check_feeds

#: The least and the greatest number of corners, and how far beside the blank the tool goes down, mm.
_FEWEST, _MOST, _BESIDE = 3, 99, 2.0
_TINY = 1e-9


class _Polygon(HoleCycle):
    """The polygon about the tool's place: its distance from the middle to a side, and its corners."""

    def __init__(self, ip: Interpreter, name: str) -> None:
        super().__init__(ip, name)
        q = self.q
        self.origin, self.turn = self.place(), cmath.rect(1.0, math.radians(q[224]))
        self.corners, self.round = round(q[572]), q[220]
        reference, mode = round(q[573]), round(q[215])
        wrong = not _FEWEST <= self.corners <= _MOST or reference not in (0, 1) or mode not in (0, 1, 2)
        hint = f"{_FEWEST} to {_MOST} corners; Q573 is 0 (circle within) or 1 (around), Q215 0 (all), 1 (rough) or 2 (finish)"
        message = f"Q572 = {q[572]:g}, Q573 = {q[573]:g} and Q215 = {q[215]:g} do not make {name}"
        chamfer = f"chamfers of {name} (Q220 = {q[220]:g}) are not read"
        refuse(
            "CYCL",
            (wrong, "cycle-words", message, hint),
            (q[220] < 0.0, "unsupported-block", chamfer, "Q220 above 0 rounds the corners"),
        )
        self.half = math.pi / self.corners
        self.side = q[571] / 2.0 * (math.cos(self.half) if reference else 1.0)
        blank, outside = q[222] / 2.0, "Q222 is the diameter of the blank, Q571 that of the circle"
        sizes = f"{name} has a blank of {q[222]:g}, a circle of {q[571]:g} and corners of {q[220]:g}"
        refuse("CYCL", (not max(q[220], _TINY) < self.side <= blank + _TINY, "cycle-words", sizes, outside))
        self.tool = ip.cutting_radius(name)
        check_feeds(self)
        #: Where the corner's rounding has its middle, from that of the stud.
        self.middle = (self.side - self.round) / math.cos(self.half)
        reach = max(blank, self.middle + self.round)
        self.beside = reach + self.tool + _BESIDE / ip.state.unit_mm

    def loop(self, distance: float) -> None:
        """Go in along the first corner to a distance from the wall, and once around, rolling about the corners."""
        sense, about = 1 if self.q[351] < 0.0 else -1, self.round + distance
        self.to(complex(self.middle + about, 0.0))
        for k in range(self.corners + 1):
            towards = cmath.rect(1.0, 2.0 * self.half * k * sense)
            centre = towards * self.middle
            if k:
                self.to(centre + towards * cmath.rect(about, -self.half * sense))
            whole = k < self.corners
            self.arc(
                centre + towards * (cmath.rect(about, self.half * sense) if whole else about), centre, sense
            )

    def level(self, level: float, distances: list[float], feed: float) -> None:
        """Go down beside the blank, around at each distance, and out."""
        out = complex(self.beside, 0.0)
        self.to(out, rapid=True)
        self.go(self.start, rapid=True)
        self.plunge(level, self.q[206], feed)
        for distance in distances:
            self.loop(distance)
        self.to(out)
        self.go(self.start, rapid=True)


def polygon(ip: Interpreter, name: str) -> None:
    """258: Q572 corners, the first at the angle Q224, about a circle of Q571 (Q573) out of the round blank Q222, corners rounded by Q220.

    Roughing (Q215 = 0 or 1) leaves Q368 on the wall and Q369 on the floor, finishing (0 or 2) takes them at Q385, the wall in infeeds Q338.
    """
    q, before = ip.parameters.numbers, complex(*ip.state.position[:2])
    stud, mode = _Polygon(ip, name), round(q[215])
    step, excess = (q[370] or 1.0) * stud.tool, q[222] / 2.0 - stud.side
    hint = "Q370 is the step aside in radii of the tool"
    refuse("CYCL", (step <= 0.0, "cycle-infeed", f"{name} steps aside by {step:g}", hint))

    def loops(allowance: float) -> list[float]:
        count = steps_of(max(excess - allowance, 0.0), step, "CYCL", f"{name} makes {{}} loops", hint)
        return [stud.tool + allowance + k * step for k in range(max(count, 1) - 1, -1, -1)]

    if mode != 2:
        for level in stud.infeeds(202, q[369]):
            stud.level(level, loops(q[368]), q[207])
    if mode != 1 and (q[368] or q[369]):
        feed = q[385] or q[207]
        if q[369]:
            stud.level(stud.bottom, loops(q[368]), feed)
        for level in stud.infeeds(338):
            stud.level(level, [stud.tool], feed)
    stud.end()
    stud.to(stud.turn.conjugate() * (before - stud.origin), rapid=True)
