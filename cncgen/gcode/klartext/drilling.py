"""Cycles of Heidenhain's plain language that make a hole where the tool is: 200 to 209, 240 and 241."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cncgen.gcode.codes.modes import stopping
from cncgen.gcode.codes.steps import MOST, steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.klartext.hole_cycle import FASTEST, HoleCycle

#: How far cycle 202 steps off the wall without Q357, mm, and by Q214 where to.
_OFF = 0.2
#: The angle of the point of a centring tool, degrees, where its diameter says how deep it goes.
_POINT_DEG = 90.0
_WAYS = {0: 0j, 1: -1 + 0j, 2: -1j, 3: 1 + 0j, 4: 1j}


def drill(cycle: HoleCycle) -> None:
    """200: in infeeds of Q202, out after each for Q210 and back to Q200 above it; upwards where the depth Q201 is above 0."""
    q, way = cycle.q, math.copysign(1.0, cycle.q[201])
    makes, hint = f"Q202 = {q[202]:g} makes {{}} infeeds", "Q202 is the depth of one infeed"
    cycle.begin()
    count = steps_of(abs(q[201]), abs(q[202]), "CYCL", makes, hint)
    for k in range(1, count):
        depth = q[203] + way * abs(q[202]) * k
        cycle.go(depth, rapid=False)
        cycle.go(cycle.start, rapid=True)
        cycle.dwell(q[210])
        cycle.go(depth + q[200], rapid=True)
    cycle.go(cycle.bottom, rapid=False)
    cycle.dwell(q[211])


def ream(cycle: HoleCycle) -> None:
    """201: in at Q206, wait Q211, out at Q208."""
    cycle.drill()
    cycle.out()


def bore(cycle: HoleCycle) -> None:
    """202: in, off the wall by Q357 (0.2 mm on controls that lack it) where Q214 says so, out at Q208."""
    number = cycle.q[214]
    message, hint = f"Q214 = {number:g} of cycle 202 is not within 0 to 4", "0 stays, 1 to 4 are X- Y- X+ Y+"
    refuse("CYCL", (round(number) not in _WAYS, "cycle-words", message, hint))
    cycle.drill()
    place = cycle.place()
    off = cycle.q[357] if cycle.q[357] >= 0.0 else _OFF / cycle.ip.state.unit_mm
    cycle.to(place + off * _WAYS[round(number)], rapid=True)
    cycle.out()
    cycle.home = place


def steps(cycle: HoleCycle, begin: float | None = None) -> list[float]:
    """Return the depths of 203 and 205 from the surface, or a start, on: Q202, less by Q212 each time, at least Q205."""
    q, depths, at = cycle.q, list[float](), cycle.q[203] if begin is None else begin
    step, many = abs(q[202]) or abs(q[201]), f"Q202 = {q[202]:g} makes more than {MOST} infeeds"
    while at > cycle.bottom:
        refuse("CYCL", (len(depths) >= MOST, "cycle-infeed", many, "Q202 is the depth of one infeed"))
        at = max(cycle.bottom, at - step)
        depths.append(at)
        step = max(step - abs(q[212]), abs(q[205]) or 1e-3) if q[212] else step
    return depths


def universal(cycle: HoleCycle) -> None:
    """203: as 200, with smaller and smaller infeeds, Q213 chip breaks of Q256 before the tool goes out, out at Q208 (0: at Q206)."""
    q = cycle.q
    cycle.go(cycle.start, rapid=True)
    breaks = round(q[213])
    for depth in steps(cycle):
        cycle.feed(q[206], "Q206")
        cycle.go(depth, rapid=False)
        if depth == cycle.bottom:
            break
        if breaks > 0:
            breaks -= 1
            cycle.go(depth + abs(q[256]), rapid=False)
            continue
        breaks = round(q[213])
        cycle.out()
        cycle.dwell(q[210])
        cycle.go(depth + q[200], rapid=True)
    cycle.dwell(q[211])
    cycle.out()


def peck(cycle: HoleCycle) -> None:
    """205: out after each infeed, back to Q258 (to Q259 at the end) above; every Q257 a chip break of Q256. Below a deepened start Q379,
    before which the tool goes at Q253 to a fifth of that, at most Q200, above it, infeeds count from there (TNC 640, "Position behavior
    when working with Q379"); the way out is the same, at
    Q208 (0: at Q206; at full speed on controls that lack it)."""
    q = cycle.q
    cycle.go(cycle.start, rapid=True)
    depths, at = steps(cycle), q[203]
    if q[379]:
        at = q[203] - q[379]
        message = f"the start Q379 = {q[379]:g} of cycle 205 is not between the surface and the depth Q201 = {q[201]:g}"
        hint = "Q379 is how deep the hole is already"
        refuse("CYCL", (not cycle.bottom < at < q[203], "cycle-words", message, hint))
        depths = steps(cycle, at)
        cycle.feed(q[253], "Q253")
        cycle.go(at + min(0.2 * q[379], q[200]), rapid=False)
    cycle.feed(q[206], "Q206")
    for k, depth in enumerate(depths):
        cycle.down(at, depth)
        at = depth
        if depth == cycle.bottom:
            break
        part = k / max(1, len(depths) - 1)
        ahead = q[258] + (q[259] - q[258]) * part if q[259] else q[258]
        cycle.go(cycle.start, rapid=True)
        cycle.go(depth + ahead, rapid=True)
    cycle.dwell(q[211])
    if q[208] < FASTEST:
        cycle.out()


def tap(cycle: HoleCycle) -> None:
    """207: in and out in step with the spindle, Q239 a revolution (below 0: left)."""
    pitch, speed = cycle.q[239], cycle.ip.state.speed
    refuse(
        "CYCL",
        (not pitch, "pitch-missing", "cycle 207 has no pitch: Q239 = 0", "Q239 is the pitch"),
        (speed <= 0.0, "spindle-stopped", "cycle 207 has no speed of the spindle", "TOOL CALL 5 Z S500"),
    )
    cycle.go(cycle.start, rapid=True)
    cycle.feed(abs(pitch) * speed, "Q239 S")
    with stopping(cycle.ip):
        cycle.go(cycle.bottom, rapid=False)
        cycle.go(cycle.start, rapid=False)


def bore_milling(cycle: HoleCycle) -> None:
    """208: a helix of Q334 a turn to the diameter Q335, one turn at the bottom, out by the middle."""
    ip, q = cycle.ip, cycle.q
    tool = ip.cutting_radius(cycle.name, q[335] / 2.0)
    radius = q[335] / 2.0 - tool
    narrow = f"Q335 = {q[335]:g} is not above the tool's diameter, {2.0 * tool:g}"
    flat = f"Q334 = {q[334]:g}, the depth of a turn, must be above 0"
    refuse(
        "CYCL",
        (radius <= 0.0, "cycle-tool", narrow, "cycle 200 drills"),
        (q[334] <= 0.0, "cycle-infeed", flat, "each turn of the helix goes deeper by Q334"),
    )
    middle, sense = cycle.place(), -1 if q[351] < 0.0 else 1
    makes, hint = f"Q334 = {q[334]:g} makes {{}} turns", "Q334 is the depth of one turn"
    turns = steps_of(cycle.start - cycle.bottom, q[334], "CYCL", makes, hint)
    cycle.begin()
    cycle.to(middle + radius)
    for count in (turns, 1):
        cycle.arc(middle + radius, middle, sense * count, cycle.bottom)
    cycle.to(middle)


def centre(cycle: HoleCycle) -> None:
    """240: in at Q206 to the depth Q201, or to that of the diameter Q344, wait Q211, out."""
    if round(cycle.q[343]):
        depth = cycle.q[203] - cycle.bottom
        message = f"cycle 240 takes the depth {depth:g} from the diameter Q344 = {cycle.q[344]:g} for a point of {_POINT_DEG:g} degrees"
        hint = "Q343=0 with the depth Q201 leaves no doubt: the tool table has no angle of a point"
        cycle.ip.warn_once("tool-assumed", message, "CYCL", hint)
    cycle.drill()
    cycle.go(cycle.start, rapid=True)


def levels(number: int, q: Sequence[float]) -> tuple[float, float] | None:
    """Return surface and depth of a cycle that has them from other parameters than Q203 and Q201.

    204 has them from the part's thickness, 240 with Q343 = 1 from where the point is as wide as Q344. The angle of the point is T-ANGLE of
    the control's tool table, which the table here does not have. 200 and 201 go upwards too.
    """
    if number == 204:
        return q[203], -q[250]
    if number in (200, 201) and q[201]:
        return q[203], q[201]
    if number != 240 or not round(q[343]):
        return None
    message = "Q343 = 1 of cycle 240 takes the depth from the diameter Q344, which is 0"
    refuse("CYCL", (not q[344], "cycle-words", message, "Q343=0 takes the depth Q201"))
    return q[203], -abs(q[344]) / 2.0 / math.tan(math.radians(_POINT_DEG / 2.0))


def tap_floating(cycle: HoleCycle) -> None:
    """206: in at Q206, wait Q211, out at Q206 with the spindle turning back."""
    ip = cycle.ip
    with stopping(ip):
        cycle.drill()
        ip.sink.set_spindle(ip.state.speed, -ip.state.direction)
        cycle.go(cycle.start, rapid=False)
    ip.sink.set_spindle(ip.state.speed, ip.state.direction)


def tap_breaking(cycle: HoleCycle) -> None:
    """209: as 207, back by Q256 (all the way out where that is 0) after each Q257; out of the hole Q403 times as fast, if it is given."""
    ip, q, pitch = cycle.ip, cycle.q, cycle.q[239]
    if not pitch or ip.state.speed <= 0.0 or q[257] <= 0.0:
        tap(cycle)
        return
    cycle.go(cycle.start, rapid=True)
    cycle.feed(abs(pitch) * ip.state.speed, "Q239 S")
    with stopping(ip):
        cycle.down(q[203], cycle.bottom, cycle.start if q[256] == 0.0 else None)
        if q[403] > 0.0:
            cycle.feed(abs(pitch) * ip.state.speed * q[403], "Q239 S Q403")
        cycle.go(cycle.start, rapid=False)


def back_bore(cycle: HoleCycle) -> None:
    """204: down beside the middle by Q251 until the tooth, Q252 above the tip, is Q200 below the part, which is Q250 thick; then up from
    below by Q249."""
    q = cycle.q
    way = _WAYS.get(round(q[214]))
    message = f"Q214 = {q[214]:g}, Q249 = {q[249]:g} and Q250 = {q[250]:g} do not make cycle 204"
    wrong, hint = not way or min(q[249], q[250]) <= 0.0, "Q214 is 1 to 4: X- Y- X+ Y+; depths are above 0"
    refuse("CYCL", (wrong, "cycle-words", message, hint))
    middle = cycle.place()
    beside = middle + q[251] * (way or 0j)
    below = q[203] - q[250] - q[252]
    cycle.go(cycle.start, rapid=True)
    cycle.to(beside, rapid=True)
    cycle.feed(q[253], "Q253")
    cycle.go(below - q[200], rapid=False)
    cycle.to(middle, rapid=True)
    cycle.feed(q[254], "Q254")
    cycle.go(below + q[249], rapid=False)
    cycle.dwell(q[255])
    cycle.feed(q[253], "Q253")
    cycle.go(below - q[200], rapid=False)
    cycle.to(beside, rapid=True)
    cycle.go(cycle.start, rapid=False)
    cycle.to(middle, rapid=True)


def single_lip(cycle: HoleCycle) -> None:
    """241: to Q200 above the deepened start Q379 at Q253 with the spindle at Q427, down at Q206 with it at Q428, out at Q208.

    Below the dwell depth Q435, where it waits Q211, it goes at Q401 percent of Q206. The control clears chips between infeeds of Q202 at a
    height that its manual gives only for deepened starts; here they are one.
    """
    q, ip = cycle.q, cycle.ip
    turn = {3: 1, 4: -1, 5: 0}.get(round(q[426]), ip.state.direction)
    cycle.go(cycle.start, rapid=True)
    if q[427] > 0.0:
        ip.sink.set_spindle(q[427], turn)
    if q[379] > 0.0:
        cycle.feed(q[253], "Q253")
        cycle.go(q[203] - q[379] + q[200], rapid=False)
    if q[428] > 0.0:
        ip.sink.set_spindle(q[428], turn or 1)
    if 0.0 < q[202] < -q[201]:
        message = f"{cycle.name} drills in one go: how far it comes back between infeeds of Q202 = {q[202]:g} is not read"
        ip.warn_once("cycle-peck", message, "CYCL", "cycle 205 drills in infeeds")
    cycle.feed(q[206], "Q206")
    if q[435]:
        message = f"the dwell depth Q435 = {q[435]:g} of {cycle.name} is not between the surface and the depth Q201 = {q[201]:g}"
        refuse("CYCL", (not 0.0 < abs(q[435]) < -q[201], "cycle-words", message, "0 is none"))
        cycle.go(q[203] - abs(q[435]), rapid=False)
        cycle.dwell(q[211])
        cycle.feed(q[206] * (q[401] or 100.0) / 100.0, "Q401")
    cycle.go(cycle.bottom, rapid=False)
    cycle.dwell(q[211])
    if q[427] > 0.0:
        ip.sink.set_spindle(q[427], turn)
    cycle.out()
