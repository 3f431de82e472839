"""Cycles of Heidenhain's plain language: their values are the Q parameters that follow CYCL DEF.

Q200 set-up clearance, Q201 depth (its sign is the direction), Q203 surface, Q204 second clearance, Q206 feed downwards, Q202 infeed.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block, evaluate
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.places import in_rows, on_circle
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.steps import MOST, steps_of
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import (
    contour_cycles,
    engraving,
    finishing,
    polygon_stud,
    programs,
    slots,
    studs,
    threads,
)
from cncgen.gcode.klartext.hole_cycle import FASTEST, HoleCycle, Z
from cncgen.gcode.text.plain_language import Raw, words_of

#: How far cycle 202 steps off the wall without Q357, mm, and by Q214 where to.
_OFF = 0.2
#: The angle of the point of a centring tool, degrees, where its diameter says how deep it goes.
_POINT_DEG = 90.0
#: Cycles whose Q395 = 1 counts the depth from where the drill is as wide as it gets.
_TO_THE_TIP = (200, 203, 205, 241)
_WAYS = {0: 0j, 1: -1 + 0j, 2: -1j, 3: 1 + 0j, 4: 1j}


def _drill(cycle: HoleCycle) -> None:
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
    cycle.end()


def _ream(cycle: HoleCycle) -> None:
    """201: in at Q206, wait Q211, out at Q208."""
    cycle.drill()
    cycle.out()
    cycle.end()


def _bore(cycle: HoleCycle) -> None:
    """202: in, off the wall by Q357 (0.2 mm on controls that lack it) where Q214 says so, out at Q208."""
    number = cycle.q[214]
    message, hint = f"Q214 = {number:g} of cycle 202 is not within 0 to 4", "0 stays, 1 to 4 are X- Y- X+ Y+"
    refuse("CYCL", (round(number) not in _WAYS, "cycle-words", message, hint))
    cycle.drill()
    place = cycle.place()
    off = cycle.q[357] if cycle.q[357] >= 0.0 else _OFF / cycle.unit_mm
    cycle.to(place + off * _WAYS[round(number)], rapid=True)
    cycle.out()
    cycle.end()
    cycle.to(place, rapid=True)


def _steps(cycle: HoleCycle, begin: float | None = None) -> list[float]:
    """Return the depths of 203 and 205 from the surface, or a start, on: Q202, less by Q212 each time, at least Q205."""
    q, depths, at = cycle.q, list[float](), cycle.q[203] if begin is None else begin
    step, many = abs(q[202]) or abs(q[201]), f"Q202 = {q[202]:g} makes more than {MOST} infeeds"
    while at > cycle.bottom:
        refuse("CYCL", (len(depths) >= MOST, "cycle-infeed", many, "Q202 is the depth of one infeed"))
        at = max(cycle.bottom, at - step)
        depths.append(at)
        step = max(step - abs(q[212]), abs(q[205]) or 1e-3) if q[212] else step
    return depths


def _universal(cycle: HoleCycle) -> None:
    """203: as 200, with smaller and smaller infeeds, Q213 chip breaks of Q256 before the tool goes out, out at Q208 (0: at Q206)."""
    q = cycle.q
    cycle.go(cycle.start, rapid=True)
    breaks = round(q[213])
    for depth in _steps(cycle):
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
    cycle.end()


def _peck(cycle: HoleCycle) -> None:
    """205: out after each infeed, back to Q258 (to Q259 at the end) above; every Q257 a chip break of Q256. Below a deepened start Q379,
    before which the tool goes at Q253 to a fifth of that, at most Q200, above it, infeeds count from there (TNC 640, "Position behavior
    when working with Q379"); the way out is the same, at
    Q208 (0: at Q206; at full speed on controls that lack it)."""
    q = cycle.q
    cycle.go(cycle.start, rapid=True)
    depths, at = _steps(cycle), q[203]
    if q[379]:
        at = q[203] - q[379]
        message = f"the start Q379 = {q[379]:g} of cycle 205 is not between the surface and the depth Q201 = {q[201]:g}"
        hint = "Q379 is how deep the hole is already"
        refuse("CYCL", (not cycle.bottom < at < q[203], "cycle-words", message, hint))
        depths = _steps(cycle, at)
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
    cycle.end()


def _tap(cycle: HoleCycle) -> None:
    """207: in and out in step with the spindle, Q239 a revolution (below 0: left)."""
    pitch, speed = cycle.q[239], cycle.ip.state.speed
    refuse(
        "CYCL",
        (not pitch, "pitch-missing", "cycle 207 has no pitch: Q239 = 0", "Q239 is the pitch"),
        (speed <= 0.0, "spindle-stopped", "cycle 207 has no speed of the spindle", "TOOL CALL 5 Z S500"),
    )
    cycle.go(cycle.start, rapid=True)
    cycle.feed(abs(pitch) * speed, "Q239 S")
    cycle.go(cycle.bottom, rapid=False)
    cycle.go(cycle.start, rapid=False)
    cycle.end()


def _bore_milling(cycle: HoleCycle) -> None:
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
    cycle.end()


def _rectangle(cycle: HoleCycle) -> None:
    """251: Q218 by Q219, corners Q220, turned by Q224 about the tool's place, which Q367 names."""
    q = cycle.q
    middle = slots.middle_of(cycle, (q[218], q[219]), q[224])
    slots.pocket(cycle, q[218], q[219], q[220], q[224], middle)


def _round(cycle: HoleCycle) -> None:
    """252: the diameter Q223."""
    slots.pocket(cycle, cycle.q[223], cycle.q[223], cycle.q[223] / 2.0, 0.0)


def _slot(cycle: HoleCycle) -> None:
    """253: a slot of length Q218 and width Q219, turned by Q374 about the tool's place, which Q367 names."""
    q = cycle.q
    middle = slots.middle_of_slot(cycle, q[218], q[219], q[374])
    slots.pocket(cycle, q[218], q[219], q[219] / 2.0, q[374], middle)


def _centre(cycle: HoleCycle) -> None:
    """240: in at Q206 to the depth Q201, or to that of the diameter Q344, wait Q211, out."""
    if round(cycle.q[343]):
        depth = cycle.q[203] - cycle.bottom
        message = f"cycle 240 takes the depth {depth:g} from the diameter Q344 = {cycle.q[344]:g} for a point of {_POINT_DEG:g} degrees"
        hint = "Q343=0 with the depth Q201 leaves no doubt: the tool table has no angle of a point"
        cycle.ip.warn_once(BlockError("tool-assumed", message, "CYCL", hint=hint), Severity.WARNING)
    cycle.drill()
    cycle.go(cycle.start, rapid=True)
    cycle.end()


def _levels(number: int, q: Sequence[float]) -> tuple[float, float] | None:
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


def _tap_floating(cycle: HoleCycle) -> None:
    """206: in at Q206, wait Q211, out at Q206 with the spindle turning back."""
    ip = cycle.ip
    cycle.drill()
    ip.sink.set_spindle(ip.state.speed, -ip.state.direction)
    cycle.go(cycle.start, rapid=False)
    ip.sink.set_spindle(ip.state.speed, ip.state.direction)
    cycle.end()


def _tap_breaking(cycle: HoleCycle) -> None:
    """209: as 207, back by Q256 (all the way out where that is 0) after each Q257; out of the hole Q403 times as fast, if it is given."""
    ip, q, pitch = cycle.ip, cycle.q, cycle.q[239]
    if not pitch or ip.state.speed <= 0.0 or q[257] <= 0.0:
        _tap(cycle)
        return
    cycle.go(cycle.start, rapid=True)
    cycle.feed(abs(pitch) * ip.state.speed, "Q239 S")
    cycle.down(q[203], cycle.bottom, cycle.start if q[256] == 0.0 else None)
    if q[403] > 0.0:
        cycle.feed(abs(pitch) * ip.state.speed * q[403], "Q239 S Q403")
    cycle.go(cycle.start, rapid=False)
    cycle.end()


#: Cycles of TNC 155 to 426 whose values stand in parts: set-up clearance, depth, then those of each.
_OLD: dict[int, tuple[str, ...]] = {
    1: ("SETUP", "DEPTH", "PECKG", "DWELL", "F"),
    2: ("SETUP", "DEPTH", "DWELL", "F"),
    3: ("SETUP", "DEPTH", "PECKG", "X", "Y", "F"),
    4: ("SETUP", "DEPTH", "PECKG", "X", "Y", "F"),
    5: ("SETUP", "DEPTH", "PECKG", "RADIUS", "F"),
    17: ("SETUP", "DEPTH", "PITCH"),
    18: ("DEPTH", "PITCH"),
}
_THREAD = 18
_OLD_POCKETS = {3: slots.slot, 4: slots.rectangle, 5: slots.circle}
#: Cycles that move nothing that is planned: orientation of the spindle; weighing the load, tuning by the machine's builder.
_IDLE = (13, 239, 332, 392)


def take_part(ip: Interpreter, number: int, part: int, text: str) -> None:
    """CYCL DEF n.p: take the values of an old cycle; part 0 begins it."""
    plain = Plain.of(ip)
    if part == 0:
        define(ip, number)
        plain.parts = {}
        return
    if plain.cycle == number and 1 <= part <= len(_OLD.get(number, ())):
        take_value(ip, number, part, words_of(text))


def take_value(ip: Interpreter, number: int, part: int, raw: Sequence[Raw]) -> None:
    """Take the words of one of its values."""
    plain, names = Plain.of(ip), _OLD[number]
    given = {name: evaluate(value, ip.parameters) for name, value in raw if value == value}
    sense = given.pop("DR±", None)
    words = list(given.items())
    if words:
        plain.parts[names[part - 1]] = words[0][1]
    if names[part - 1] == "X":
        plain.parts["FIRST"] = float(words[0][0] == "Y") if words else 0.0
    # The feed downwards stands behind the infeed, the sense and the corners behind the feed.
    for name, found in words[1:]:
        plain.parts["RADIUS" if name.startswith("R") else "PLUNGE"] = found
    if sense is not None:
        plain.parts["SENSE"] = sense


def _old(ip: Interpreter, number: int) -> None:
    """1 pecks, 2 taps with a floating chuck, 17 taps in step with the spindle, 3 to 5 clear a slot or a pocket: from where the tool is,
    the set-up clearance above. 18 cuts a thread from there on."""
    parts = Plain.of(ip).parts
    for k, name in enumerate(_OLD[number], 1):
        part = f"{number}.{k} {name}"
        refuse(
            "CYCL",
            (name not in parts, "cycle-words", f"cycle {number} has no {part}", f"CYCL DEF {part} gives it"),
        )
    values = {"RADIUS": 0.0, "FIRST": 0.0, **parts}
    if number == _THREAD:
        _cut_thread(ip, values["DEPTH"], values["PITCH"])
        return
    top = ip.state.position[Z]
    surface = top - abs(values["SETUP"])
    q, feed = ip.parameters.numbers, values.get("F", 0.0)
    given = {200: abs(values["SETUP"]), 201: -abs(values["DEPTH"]), 203: surface, 204: 0.0, 202: abs(values.get("PECKG", 0.0)), 210: 0.0,
             206: values.get("PLUNGE", feed), 207: feed, 211: values.get("DWELL", 0.0), 239: values.get("PITCH", 0.0), 215: 0.0, 368: 0.0, 369: 0.0, 370: 1.0,
             351: values.get("SENSE", 1.0)}  # fmt: skip
    kept = {key: q[key] for key in given}
    for key, value in given.items():
        q[key] = value
    try:
        cycle = HoleCycle(ip, f"cycle {number}")
        if number in _OLD_POCKETS:
            _OLD_POCKETS[number](cycle, values)
        else:
            {1: _peck_old, 2: _tap_floating, 17: _tap}[number](cycle)
    finally:
        for key, value in kept.items():
            q[key] = value


def _cut_thread(ip: Interpreter, depth: float, pitch: float) -> None:
    """18: to a depth from where the tool is, in step with the spindle, which then stands; ways to and from it are the program's."""
    wrong = not depth or not pitch or ip.state.speed <= 0.0
    message = f"cycle 18 has DEPTH = {depth:g}, PITCH = {pitch:g} and a spindle of S{ip.state.speed:g}"
    refuse("CYCL", (wrong, "cycle-words", message, "DEPTH below 0 leads downwards; TOOL CALL gives S"))
    end = ip.state.position.copy()
    end[Z] += depth
    turn = 1 if (depth < 0.0) == (pitch > 0.0) else -1
    ip.sink.set_spindle(ip.state.speed, turn)
    ip.sink.set_feed_rate(abs(pitch) * ip.state.speed)
    ip.go(end)
    ip.state.direction = 0
    ip.sink.set_spindle(ip.state.speed, 0)
    ip.sink.set_feed_rate(ip.state.feed)


def _peck_old(cycle: HoleCycle) -> None:
    """1: out after each infeed, and back to 0.6 mm above (depth / 50, at most 7 mm, in holes deeper than 30 mm)."""
    depth, mm = abs(cycle.q[201]), 1.0 / cycle.unit_mm
    ahead = 0.6 * mm if depth <= 30.0 * mm else min(depth / 50.0, 7.0 * mm)
    cycle.feed(cycle.q[206], "F")
    for level in _steps(cycle):
        cycle.go(level, rapid=False)
        if level == cycle.bottom:
            break
        cycle.go(cycle.start, rapid=True)
        cycle.go(level + ahead, rapid=True)
    cycle.dwell(cycle.q[211])
    cycle.end()


def _back_bore(cycle: HoleCycle) -> None:
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
    cycle.end()


def _single_lip(cycle: HoleCycle) -> None:
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
        ip.warn_once(
            BlockError("cycle-peck", message, "CYCL", hint="cycle 205 drills in infeeds"), Severity.WARNING
        )
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
    cycle.end()


_RUN: dict[int, Callable[[HoleCycle], None]] = {
    200: _drill, 201: _ream, 202: _bore, 203: _universal, 204: _back_bore, 205: _peck, 206: _tap_floating, 207: _tap, 208: _bore_milling,
    209: _tap_breaking, 240: _centre, 241: _single_lip, 251: _rectangle, 252: _round, 253: _slot, 225: engraving.engrave, 254: slots.bows, **threads.RUN, **finishing.RUN,
}  # fmt: skip
_FROM_OUTSIDE = {**studs.RUN, **polygon_stud.RUN}
#: Patterns, which run at once.
PATTERNS = (220, 221)
#: By number, what parameters are on a control whose cycle lacks them: a face is counted from the tool's place, the tool goes from place to
#: place at the second clearance, straight, begins to the right of a stud, and drills to the depth with its tip.
_LACKING = {
    studs.FACE: {367.0: -1.0}, 220: {301.0: 1.0, 365.0: 0.0}, 221: {301.0: 1.0}, 256: {437.0: 0.0}, 257: {376.0: 0.0}, **{number: {395.0: 0.0} for number in _TO_THE_TIP},
    202: {357.0: -1.0}, 205: {208.0: FASTEST, 395.0: 0.0}, 225: {202.0: 0.0, 367.0: 0.0, 574.0: 0.0}, 241: {202.0: 0.0, 395.0: 0.0, 435.0: 0.0},
}  # fmt: skip
_CONTOURS = (*contour_cycles.RUN, contour_cycles.TRAIN)
READ = tuple(
    sorted((*_OLD, *_RUN, programs.CYCLE, *_FROM_OUTSIDE, *PATTERNS, *contour_cycles.DATA, *_CONTOURS))
)


#: Cycles that do nothing without a depth Q201.
_NO_DEPTH = (200, 201, 202, 203, 205, 206, 207, 208, 209, 210, 211, 212, 213, 214, 215, 225, 240, 241, 251, 252, 253, 254, 256, 257, 258, 262, 265, 267)  # fmt: skip


#: The cycle in force after one that is not read, whose calls tell nothing more.
_NOT_READ = -1
#: By number, the task of each cycle that is not read.
_UNREAD: tuple[tuple[Sequence[int], str], ...] = (

    ((271, 272, 273, 274, 277, *range(1271, 1283)), "contours in trochoids, OCM"), ((275,), "a slot in trochoids"), ((276,), "a contour train in space"),
    ((27, 28, 29, 39), "contours on the surface of a cylinder"), ((30,), "points of digitising"), ((285, 286, 287, 880), "gears"), ((291, 292), "turning by interpolation"),
    (range(400, 500), "probing, which TCH PROBE has"), (range(800, 900), "turning"), (range(1000, 1100), "grinding"),
)  # fmt: skip


def define(ip: Interpreter, number: int) -> None:
    """CYCL DEF: take the cycle that the calls run."""
    if number in _IDLE:
        message = f"cycle {number} moves no tool: passed over"
        hint = "is it a cycle of the machine's builder?"
        ip.warn(BlockError("cycle-idle", message, "CYCL", hint=hint), Severity.NOTE)
        return
    if number in contour_cycles.DATA:
        Plain.of(ip).train_ways |= number == contour_cycles.WAYS
        return
    Plain.of(ip).cycle = 0
    for parameter, value in _LACKING.get(number, {}).items():
        ip.parameters.set_number(parameter, value)
    if number not in READ:
        Plain.of(ip).cycle = _NOT_READ
        what = next((f" ({what})" for numbers, what in _UNREAD if number in numbers), "")
        hint = "write its moves as L blocks, or another cycle: docs/heidenhain.md lists those that are read"
        raise BlockError("unsupported-block", f"cycle {number}{what} is not read", "CYCL", hint=hint)
    Plain.of(ip).cycle = number


def call(ip: Interpreter, here: Block) -> None:
    """Run the cycle at the tool's place."""
    plain = Plain.of(ip)
    number, q = plain.cycle, ip.parameters.numbers
    ip.sink.block = here
    if number == _NOT_READ:
        return
    if number == programs.CYCLE:
        message = "cycle 12 calls a program at the points of a pattern, or under M89: not read"
        raise BlockError("unsupported-block", message, "CYCL", hint="CYCL CALL and M99 call it")
    if number in _CONTOURS:
        read = plain.contour or (lambda label: ([], 0))
        if number == contour_cycles.TRAIN:
            contour_cycles.train(ip, f"cycle {number}", plain.labels, read)
        else:
            contour_cycles.RUN[number](contour_cycles.Contours(ip, f"cycle {number}", plain.labels, read))
    elif number in _OLD:
        _old(ip, number)
    elif (levels := _levels(number, q)) is None and number in _NO_DEPTH and q[201] == 0.0:
        # "If you program the depth = 0, the cycle will not be executed."
        message = f"cycle {number} has the depth Q201 = 0: it is not made"
        ip.warn(BlockError("cycle-depth", message, "CYCL", hint="Q201 is below 0"), Severity.WARNING)
    elif number in _RUN:
        if number in _TO_THE_TIP and round(q[395]):
            message = f"Q395 = 1 of cycle {number} counts the depth from the width of the drill on: the tip goes there"
            hint = "the tool table has no angle of a point: Q395=0 and a depth Q201 with the point leave no doubt"
            ip.warn_once(BlockError("tool-assumed", message, "CYCL", hint=hint), Severity.WARNING)
        _RUN[number](HoleCycle(ip, f"cycle {number}", levels))
    elif number in _FROM_OUTSIDE:
        _FROM_OUTSIDE[number](ip, f"cycle {number}")
    else:
        hint = "CYCL DEF gives it before"
        raise BlockError("cycle-missing", "no cycle to call", "M99", hint=hint)


def pattern(ip: Interpreter, number: int, cycle: int, here: Block) -> None:
    """220 on a circle, 221 on lines: run the cycle that was defined before at each place.

    From one place to the next the tool goes at the set-up clearance (Q301 = 0) or at the second one (1), straight (Q365 = 0 of 220) or along
    the circle (1).
    """
    q = ip.parameters.numbers
    columns, lines = (q[241], 1.0) if number == 220 else (q[242], q[243])
    counted = columns >= 0.5 and lines >= 0.5 and columns * lines <= MOST
    refuse(
        "CYCL",
        (not cycle, "cycle-missing", f"cycle {number} has no cycle that it calls", "CYCL DEF 200 stands before"),
        (not counted, "cycle-repeats", f"cycle {number} has {columns * lines:g} places", "Q241, or Q242 and Q243, count them"),
    )  # fmt: skip
    across, down, centre, step = round(columns), round(lines), complex(q[216], q[217]), 0.0
    if number == 220:
        # The stopping angle is that of the last place, but of a whole circle.
        whole = abs(q[246] - q[245]) >= 360.0
        step = q[247] or (q[246] - q[245]) / max(1, across if whole else across - 1)
        places = on_circle(centre, q[244] / 2.0, q[245], step, across)
    else:
        way = cmath.rect(1.0, math.radians(q[224]))
        places = in_rows(complex(q[225], q[226]), way * q[237], way * 1j * q[238], across, down)
    Plain.of(ip).cycle = cycle
    second, cutter = q[204], FlatCutter(ip)
    for k, place in enumerate(places):
        ip.sink.block = here
        if k and number == 220 and round(q[365]) and q[244]:
            cutter.feed(FASTEST)
            cutter.arc(place, centre, 1 if step > 0.0 else -1)
            cutter.feed(ip.state.feed)
        else:
            ip.go([place.real, place.imag, *ip.state.position[2:]], rapid=True)
        q[204] = 0.0 if round(q[301]) == 0 and k < len(places) - 1 else second
        try:
            call(ip, here)
        finally:
            q[204] = second
