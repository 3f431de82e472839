"""Cycle 275 of Heidenhain's plain language: a slot of the width Q219 along the open contour of cycle 14, cleared in circles (from memory of TNC 640,
user's manual for cycles, "TROCHOIDAL SLOT"; names of Q parameters as in public programs), as a warning says.

Width, levels, allowances, feeds, and Q436 from circle to circle are the cycle's. The straight way down (Q366 = 0), the circles that open the slot at
its first point, its round ends, and the pass along its walls at each level are our own.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator

from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.steps import steps_of
from cncgen.gcode.codes.turning_profiles import Segment, backwards, moved_aside
from cncgen.gcode.errors import refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext.hole_cycle import HoleCycle, check_feeds

_TINY = 1e-9
#: Circles below this part of the tool's radius are left out: the pass along the walls clears the slot.
_LEAST_CIRCLE = 0.01


class _Slot(HoleCycle):
    """The slot along a path; `half` is half its width."""

    def __init__(self, ip: Interpreter, name: str) -> None:
        """Read the contour and the tool; raise where a parameter has no meaning, or the tool does not go into the slot."""
        super().__init__(ip, name)
        plain, q = Plain.of(ip), self.q
        labels, read = plain.labels, plain.contour
        self.path = read(labels[0])[0] if read is not None and len(labels) == 1 else []
        self.half = q[219] / 2.0
        self.tool = ip.cutting_radius(name, self.half)
        #: Climb milling along an inner wall goes counter-clockwise.
        self.sense = -1 if q[351] < 0.0 else 1
        check_feeds(self)
        where = "CYCL DEF 14.1 CONTOUR LABEL 1 names it, and LBL 1 has its moves"
        infeed = (
            f"Q436 = {q[436]:g} of {name} is not above 0, or more than the tool is wide, {2.0 * self.tool:g}"
        )
        narrow = f"{name} is Q219 = {q[219]:g} wide, with Q368 = {q[368]:g} left on its walls, and the tool {2.0 * self.tool:g}"
        refuse(
            "CYCL",
            (not self.path, "cycle-missing", f"{name} has {len(labels)} contours, and needs one", where),
            (round(q[215]) not in (0, 1, 2), "cycle-words", f"Q215 = {q[215]:g} of {name} is not 0 to 2", "0 roughs and finishes, 1 roughs, 2 finishes"),
            (not 0.0 < self.tool <= self.half - q[368] + _TINY or min(q[368], q[369]) < 0.0, "cycle-tool", narrow, "take a smaller tool"),
            (not 0.0 < q[436] <= 2.0 * self.tool + _TINY, "cycle-infeed", infeed, "Q436 is the way from circle to circle, in mm"),
        )  # fmt: skip

    def places(self, radius: float) -> Iterator[tuple[complex, complex]]:
        """Yield places along the path, Q436 apart at most, and the headings there; in bends so near that the straight way between two circles of
        a radius keeps off the wall.
        """
        first = self.path[0]
        yield first.start, first.heading(first.start)
        for segment in self.path:
            along = segment.end - segment.start
            length = abs(along) if segment.centre is None else segment.sweep() * segment.radius()
            makes = f"Q436 = {self.q[436]:g} makes {{}} circles of {self.name}"
            bend = math.inf if segment.centre is None else math.sqrt(8.0 * segment.radius() * radius)
            for k in range(1, (count := steps_of(length, min(self.q[436], bend), "CYCL", makes)) + 1):
                part = k / count
                if segment.centre is None:
                    place = segment.start + along * part
                else:
                    turn = cmath.rect(1.0, segment.spin * segment.sweep() * part)
                    place = segment.centre + (segment.start - segment.centre) * turn
                yield place, segment.heading(place)

    def level(self, level: float, radius: float, feed: float) -> None:
        """Clear a level in circles of a radius of the tool's centre, and go along the walls."""
        self.enter(level, feed)
        circles = radius > _LEAST_CIRCLE * self.tool
        opening = math.ceil(radius / self.tool - _TINY)
        for k, (place, heading) in enumerate(self.places(radius) if circles else ()):
            for ring in range(1, opening + 1) if k == 0 else (opening,):
                # Behind the middle, where the way from the circle before is clear in bends too.
                begin = place - heading * radius * ring / opening
                self.to(begin)
                self.arc(begin, place, self.sense)
        self.walls(radius, at_end=circles)

    def enter(self, level: float, feed: float) -> None:
        """Go down at the first point."""
        self.go(max(self.start, self.ip.state.position[2]), rapid=True)
        self.to(self.path[0].start, rapid=True)
        self.go(self.start, rapid=True)
        self.plunge(level, self.q[206], feed)

    def walls(self, radius: float, *, at_end: bool = False) -> None:
        """Go around the slot, the centre of the tool at a distance from its path, from the end of the path on that is near, and up."""
        ring = self.path
        if radius > _TINY:
            left = self.sense < 0
            on, back = moved_aside(ring, radius, left), backwards(moved_aside(ring, radius, not left))
            turns = (
                Segment(on[-1].end, back[0].start, ring[-1].end, self.sense),
                Segment(back[-1].end, on[0].start, ring[0].start, self.sense),
            )
            ring = [*back, turns[1], *on, turns[0]] if at_end else [*on, turns[0], *back, turns[1]]
        self.to(ring[0].start)
        for segment in ring:
            self.follow(segment)
        self.go(self.start, rapid=True)


def slot(ip: Interpreter, name: str) -> None:
    """275: roughing (Q215 = 0 or 1) leaves Q368 on the walls and Q369 on the floor, finishing (0 or 2) takes them at Q385, the walls in infeeds Q338."""
    job = _Slot(ip, name)
    message = f"what the parameters of {name} mean has not been compared with a printed manual"
    hint = "Q219 is the width, Q368 left on the walls, Q436 the way from circle to circle, Q351 = 1 climb milling"
    ip.warn_once("cycle-parameters", message, "CYCL", hint)
    q, mode = job.q, round(job.q[215])
    radius = job.half - job.tool
    if mode != 2:
        for level in job.infeeds(202, q[369]):
            job.level(level, radius - q[368], q[207])
    if mode != 1 and (q[368] or q[369]):
        feed = q[385] or q[207]
        if q[369]:
            job.level(job.bottom, radius - q[368], feed)
        for level in job.infeeds(338):
            job.enter(level, feed)
            job.walls(radius)
    job.end()
