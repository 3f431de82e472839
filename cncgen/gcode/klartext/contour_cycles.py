"""SL cycles of Heidenhain's plain language: 14 names the contours, 20 has their data, 21 to 24 drill, rough and finish them, 25 is an open one,
270 has the ways to and from it.

The contours are subprograms; the side of RL or RR tells pockets from islands (iTNC 530, user's manual for cycles, "SL cycles"). Walls,
levels, allowances and feeds are the cycles'; the rows that clear a pocket are our own.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence

from cncgen.gcode.codes.contour_pockets import area, around, check, clear, closed, room, rows, walls
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.pockets import Clearing
from cncgen.gcode.codes.turning_profiles import Segment, backwards, moved_aside
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext.hole_cycle import FASTEST, HoleCycle, infeeds

#: Returns the contour of a label: its segments, and the side of the tool (1 left, -1 right, 0 none).
Read = Callable[[str], tuple[list[Segment], int]]
#: The radii between which a tool without a diameter is tried, mm.
_WIDEST, _NARROWEST = 5.0, 0.4


class Contours:
    """The contours of cycle 14, pockets and islands, with the data of cycle 20."""

    def __init__(self, ip: Interpreter, name: str, labels: list[str], read: Read) -> None:
        """Read the contours; raise where one is missing or open, or has no side."""
        q = ip.parameters.numbers
        self.cycle = HoleCycle(ip, name, (q[5], q[1]))
        self.ip, self.q, self.name = ip, q, name
        self.start = q[5] + q[6]
        self.contours: list[tuple[list[Segment], bool]] = []
        radius = ip.tool_radius()
        wrong = q[1] >= 0.0 or (radius <= 0.0 and ip.tools.given)
        message = f"{name} has the depth Q1 = {q[1]:g} and a tool of diameter {2.0 * radius:g}"
        refuse(
            name,
            (not labels, "cycle-missing", f"{name} has no contour", "CYCL DEF 14.1 CONTOUR LABEL 1 names it"),
            (wrong, "cycle-words", message, "Q1 is below 0; --tool-table gives the diameter of the tool"),
        )
        for label in labels:
            contour, side = read(label)
            contour = closed(contour, f"LBL {label}")
            message = f"the contour LBL {label} of {name} has neither RL nor RR"
            hint = "counter-clockwise with RL, or clockwise with RR, is a pocket"
            refuse(name, (side == 0, "cycle-words", message, hint))
            # The tool is left of RL: inside a contour that goes counter-clockwise.
            self.contours.append((contour, (area(contour) > 0.0) != (side > 0)))
        check(self.contours, name)
        if radius <= 0.0:
            sizes = _WIDEST / ip.state.unit_mm, _NARROWEST / ip.state.unit_mm
            half = room(self.contours, name, *sizes, max(q[3], q[14], 0.0), climb=True) / 0.8
            radius = ip.cutting_radius(name, half)
        self.radius = radius

    def levels(self, floor: float) -> tuple[float, ...]:
        """Return the levels down to an allowance above the floor, Q10 apart."""
        return infeeds(self.q[5], self.q[5] + self.q[1] + floor, abs(self.q[10]), self.name, "Q10")

    def out(self) -> float:
        """Return the feed upwards, Q208, which is Q12 where it is 0."""
        feed = self.q[208] or self.q[12]
        return math.inf if feed >= FASTEST else feed

    def how(self, levels: tuple[float, ...], out: float = math.inf) -> Clearing:
        """Return how the tool goes: feeds Q12 and Q11, and that upwards."""
        q = self.q
        message = f"{self.name} has no feed: Q11 = {q[11]:g}, Q12 = {q[12]:g}"
        refuse(self.name, (min(q[11], q[12]) <= 0.0, "feed-missing", message, "Q11 plunges, Q12 mills"))
        step = (q[2] or 1.0) * self.radius
        return Clearing(self.radius, step, levels, self.start, q[12], q[11], out=out)

    def around(self, allowance: float, levels: tuple[float, ...], out: float = math.inf) -> None:
        """Go around every contour."""
        distance, climb = self.radius + allowance, self.q[9] >= 0.0
        ways = around(self.contours, distance, self.name, climb=climb)
        walls(self.ip, [self._rounded(way, left=climb) for way in ways], self.how(levels, out))

    def _rounded(self, way: list[Segment], *, left: bool) -> list[Segment]:
        """Return a way whose inner corners are arcs of the tool's centre of radius Q8: aside by that and back, which rolls around them.

        It stays sharp, with a warning, where such arcs do not fit.
        """
        radius = self.q[8]
        if radius <= 0.0:
            return way
        try:
            return moved_aside(moved_aside(way, radius, left), radius, not left)
        except BlockError:
            message = f"arcs of Q8 = {radius:g} do not fit into the corners of {self.name}, which stay sharp"
            self.ip.warn_once("corner-size", message, self.name, "a smaller Q8 rounds them")
            return way

    def rows(self, allowance: float, levels: tuple[float, ...], out: float) -> None:
        """Clear the pockets in rows."""
        self.cycle.go(max(self.ip.state.position[2], self.start), rapid=True)
        shapes = [contour for contour, _ in self.contours]
        clear(self.ip, shapes, self.radius + allowance, self.how(levels, out), self.q[6], self.name)

    def end(self) -> None:
        """Go to the clearance height Q7."""
        self.cycle.go(max(self.start, self.q[7]), rapid=True)
        self.ip.sink.set_feed_rate(self.ip.state.feed)


def rough(contours: Contours) -> None:
    """22: rows, then once around, Q3 off the wall and Q4 off the floor; up at Q208."""
    q = contours.q
    levels = contours.levels(q[4])
    contours.rows(q[3], levels, contours.out())
    contours.around(q[3], levels, contours.out())


def floor(contours: Contours) -> None:
    """23: the floor in rows, and once around, Q3 off the wall; up at Q208."""
    bottom = (contours.q[5] + contours.q[1],)
    contours.rows(contours.q[3], bottom, contours.out())
    contours.around(contours.q[3], bottom, contours.out())


def side(contours: Contours) -> None:
    """24: around each wall, Q14 off it, level by level."""
    contours.around(contours.q[14], contours.levels(0.0))


def pilot(contours: Contours) -> None:
    """21: drill where rough-out begins, in steps Q10 at Q11."""
    ip, q = contours.ip, contours.q
    tool = ip.tools.find(round(q[13]))
    radius = tool.diameter * ip.table_scale() / 2.0 if tool else contours.radius
    found = rows([c for c, _ in contours.contours], radius + q[3], (q[2] or 1.0) * radius, contours.name)
    first = next(((spans[0][0], y) for y, spans in found if spans), None)
    if first is None or q[11] <= 0.0:
        message = f"{contours.name} finds no place for tool {q[13]:g}, or no feed Q11"
        raise BlockError("cycle-tool", message, contours.name, hint="Q13 is the tool that roughs")
    way = FlatCutter(ip)
    contours.cycle.go(max(ip.state.position[2], contours.start), rapid=True)
    way.to(complex(*first), rapid=True)
    way.to(z=contours.start, rapid=True)
    contours.cycle.feed(q[11], "Q11")
    for level in contours.levels(q[4]):
        way.to(z=level)
        way.to(z=contours.start, rapid=True)


def _one_of(q: Sequence[float], number: int, count: int) -> int:
    """Return a parameter of cycle 270 that is one of so many kinds."""
    kind, message = round(q[number]), f"Q{number} = {q[number]:g} of cycle 270 is not 0 to {count - 1}"
    hint = "Q390: 1 is an arc, 2 a line, 3 at right angles; Q391: 1 is left (RL), 2 right (RR)"
    refuse("CYCL", (not 0 <= kind < count, "cycle-words", message, hint))
    return kind


def _with_ways(path: list[Segment], q: Sequence[float], side: int) -> list[Segment]:
    """Return a path with ways to its start and from its end, as Q390 says.

    1 is an arc of radius Q392 over the angle Q393, 2 a line straight on, 3 one at right angles, both of length Q394; arcs and right angles
    lie on the tool's side.
    """
    kind = _one_of(q, 390, 4)
    if kind == 0:
        return path
    first, last = path[0], path[-1]
    begin, end = first.heading(first.start), last.heading(last.end)
    size, angle = (q[392], q[393]) if kind == 1 else (q[394], 1.0)
    sizes = f"cycle 270 has the radius Q392 = {q[392]:g}, the angle Q393 = {q[393]:g}, the distance Q394 = {q[394]:g}"
    beside = "an arc and a right angle lie on the side of RL or RR, and Q391 = 0 has none"
    refuse(
        "CYCL",
        (size <= 0.0 or not 0.0 < angle < 360.0, "cycle-words", sizes, "those that Q390 needs are above 0"),
        (side == 0 and kind != 2, "unsupported-block", f"Q390 = {kind} of cycle 270 without a side is not read", beside),
    )  # fmt: skip
    if kind == 1:
        middles = (first.start + 1j * side * size * begin, last.end + 1j * side * size * end)
        turn = cmath.rect(1.0, math.radians(angle) * side)
        on = Segment(middles[0] + (first.start - middles[0]) / turn, first.start, middles[0], side)
        off = Segment(last.end, middles[1] + (last.end - middles[1]) * turn, middles[1], side)
    else:
        away = [-begin, end] if kind == 2 else [1j * side * begin, 1j * side * end]
        on = Segment(first.start + size * away[0], first.start)
        off = Segment(last.end, last.end + size * away[1])
    return [on, *path, off]


def train(ip: Interpreter, name: str, labels: list[str], read: Read) -> None:
    """25: along one open contour, Q3 off it, level by level; Q15 goes to and fro (0) or in one direction; 270 has the side and the ways on and off."""
    q, radius = ip.parameters.numbers, ip.tool_radius()
    wrong = len(labels) != 1 or q[1] >= 0.0 or min(q[11], q[12]) <= 0.0
    message = f"{name} has {len(labels)} contours, the depth Q1 = {q[1]:g}, the feeds Q11 = {q[11]:g} and Q12 = {q[12]:g}"
    refuse(name, (wrong, "cycle-words", message, "one label of cycle 14, Q1 below 0, feeds above 0"))
    contour, where = read(labels[0])
    ways = Plain.of(ip).train_ways
    where = (0, 1, -1)[_one_of(q, 391, 3)] if ways else where
    path = moved_aside(contour, radius + q[3], where > 0) if where else contour
    path = _with_ways(path, q, where) if ways else path
    way = FlatCutter(ip)
    way.to(z=max(ip.state.position[2], q[7]), rapid=True)
    for k, level in enumerate(infeeds(q[5], q[5] + q[1], abs(q[10]), name, "Q10")):
        back = k % 2 == 1 and q[15] == 0.0
        run = backwards(path) if back else path
        if k == 0 or q[15] != 0.0:
            way.to(run[0].start, rapid=True)
        way.plunge(level, q[11], q[12])
        for segment in run:
            way.follow(segment)
        if q[15] != 0.0:
            way.to(z=q[7], rapid=True)
    way.to(z=q[7], rapid=True)
    ip.sink.set_feed_rate(ip.state.feed)


RUN: dict[int, Callable[[Contours], None]] = {21: pilot, 22: rough, 23: floor, 24: side}
DATA, TRAIN, WAYS = (14, 20, 270), 25, 270
