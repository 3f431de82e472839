"""Cycles of Heidenhain's plain language that mill threads: 262, 263 countersunk, 264 drilled before, 265 downwards in one helix, 267 outside.

Half a turn leads to the wall and away from it, as the manual has it (TNC 640, user's manual for cycles); its height, half a pitch, is ours.
"""

from __future__ import annotations

import math

from cncgen.gcode.codes.steps import steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.klartext.hole_cycle import HoleCycle, Z, infeeds
from cncgen.records import dataclass


@dataclass(frozen=True, slots=True)
class _Way:
    """The middle of the thread, where the tool stands in it or beside it along X, and on which side of the wall it mills."""

    middle: complex
    place: complex
    outside: bool = False

    def half_turn(self, cycle: HoleCycle, end: complex, z: float, sense: int) -> None:
        """Go half a turn from the place out to a circle about the middle, which runs tangentially into its sense, or back from there."""
        here = cycle.place()
        edge = end if here == self.place else here
        cycle.arc(end, (here + end) / 2.0, -sense if self.place.real > edge.real else sense, z)


def _helix(cycle: HoleCycle, way: _Way, climb: bool, threads: int) -> None:
    """Mill the thread of diameter Q335 and pitch Q239 (below 0: left-hand) in one turn (0), in all (1), or in turns some threads apart.

    Q207 is the feed of the tooth at the thread's diameter, the middle of the tool is slower inside and faster outside (ibid., "Fundamentals
    of thread milling"); Q512 is the feed of the way to the wall.
    """
    q, pitch, wall = cycle.q, abs(cycle.q[239]), cycle.q[335] / 2.0
    tool = cycle.ip.cutting_radius(cycle.name, wall)
    radius = wall + tool if way.outside else wall - tool
    wrong = min(wall, radius) <= 0.0 or pitch == 0.0 or threads < 0
    message = f"Q335 = {q[335]:g}, Q239 = {q[239]:g} and Q355 = {threads} do not make a thread for a tool of diameter {2.0 * tool:g}"
    hint = "Q335 is wider than the tool, Q239 the pitch, Q355 the threads of one step"
    refuse("CYCL", (wrong, "cycle-tool", message, hint))
    anticlockwise = climb != way.outside
    upwards, sense = (q[239] > 0.0) == anticlockwise, 1 if anticlockwise else -1
    step = pitch if upwards else -pitch
    parts = steps_of(
        -q[201], threads * pitch, "CYCL", f"Q239 = {q[239]:g} makes {{}} turns", "Q239 is the pitch"
    )
    turns, count = (parts, 1) if threads == 1 else (1, parts)
    bottom = q[203] + q[201]
    first = bottom if upwards else bottom + pitch * turns + (count - 1) * threads * pitch
    for k in range(count):
        begin = first + k * math.copysign(threads * pitch, step)
        cycle.feed(q[253] or q[206] or q[207], "Q253")
        cycle.go(begin - step / 2.0, rapid=False)
        cycle.feed(q[512] or q[207] * radius / wall, "Q207")
        way.half_turn(cycle, way.middle + radius, begin, sense)
        cycle.feed(q[207] * radius / wall, "Q207")
        cycle.arc(way.middle + radius, way.middle, sense * turns, begin + turns * step)
        way.half_turn(cycle, way.place, begin + (turns + 0.5) * step, sense)


def _circle(cycle: HoleCycle, way: _Way, radius: float) -> None:
    """Go half a turn out to a circle about the middle, once around, and back."""
    z, sense = cycle.ip.state.position[Z], -1 if way.outside else 1
    way.half_turn(cycle, way.middle + radius, z, sense)
    cycle.arc(way.middle + radius, way.middle, sense, z)
    way.half_turn(cycle, way.place, z, sense)


def _front(cycle: HoleCycle, way: _Way, feed: float, what: str) -> None:
    """Countersink with the tool's front at Q358: half a turn out to Q359 beside the middle, a turn, half a turn back."""
    q = cycle.q
    if not q[358]:
        return
    cycle.feed(q[253] or feed, "Q253")
    cycle.go(q[203] + q[358], rapid=False)
    if q[359] > 0.0 and way.middle + q[359] != way.place:
        cycle.feed(feed, what)
        _circle(cycle, way, q[359])


def _drill(cycle: HoleCycle) -> None:
    """Drill to Q356 in infeeds of Q202: out after each and back to Q258 above it, or back by Q256 after each Q257."""
    q = cycle.q
    bottom, at = q[203] + q[356], q[203]
    cycle.feed(q[206], "Q206")
    for depth in infeeds(at, bottom, abs(q[202]), cycle.name) if bottom < at else ():
        cycle.down(at, depth)
        at = depth
        cycle.go(cycle.start, rapid=True)
        if at > bottom:
            cycle.go(at + q[258], rapid=True)


def _inside(cycle: HoleCycle) -> _Way:
    """Go to the set-up clearance above the hole, whose middle is the tool's place."""
    cycle.go(cycle.start, rapid=True)
    return _Way(cycle.place(), cycle.place())


def mill(cycle: HoleCycle) -> None:
    """262."""
    _helix(cycle, _inside(cycle), cycle.q[351] >= 0.0, round(cycle.q[355]))


def countersink_and_mill(cycle: HoleCycle) -> None:
    """263: countersink at Q356, slowly from Q200 above it on, or, Q357 from the wall, once around; at the front; mill the thread in one turn."""
    q, way = cycle.q, _inside(cycle)
    if q[356]:
        cycle.feed(q[253] or q[254], "Q253")
        if q[357] <= 0.0:
            cycle.go(q[203] + q[356] + q[200], rapid=False)
            cycle.feed(q[254], "Q254")
        cycle.go(q[203] + q[356], rapid=False)
        if q[357] > 0.0:
            cycle.feed(q[254], "Q254")
            _circle(cycle, way, q[357])
    _front(cycle, way, q[254], "Q254")
    _helix(cycle, way, q[351] >= 0.0, 0)


def drill_and_mill(cycle: HoleCycle) -> None:
    """264: drill, countersink at the front, mill the thread in one turn."""
    way = _inside(cycle)
    _drill(cycle)
    _front(cycle, way, cycle.q[207], "Q207")
    _helix(cycle, way, cycle.q[351] >= 0.0, 0)


def downwards(cycle: HoleCycle) -> None:
    """265: mill the thread downwards in one helix; countersink at the front before it (Q360 = 0) or after it (1)."""
    way = _inside(cycle)
    if not round(cycle.q[360]):
        _front(cycle, way, cycle.q[254], "Q254")
    _helix(cycle, way, cycle.q[239] < 0.0, 1)
    if round(cycle.q[360]):
        _front(cycle, way, cycle.q[254], "Q254")


def mill_outside(cycle: HoleCycle) -> None:
    """267: a thread on a stud about the tool's place, from a place along X that the radii and the pitch give; countersink at the front first."""
    ip, q = cycle.ip, cycle.q
    cycle.go(cycle.start, rapid=True)
    middle, tool = cycle.place(), ip.cutting_radius(cycle.name)
    way = _Way(middle, middle + q[335] / 2.0 + tool + abs(q[239]), outside=True)
    cycle.to(way.place, rapid=True)
    _front(cycle, way, q[254], "Q254")
    _helix(cycle, way, q[351] >= 0.0, round(q[355]))
