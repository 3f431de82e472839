"""Cycles of TNC 155 to 426 whose values stand in parts (`CYCL DEF 1.1 SETUP 2`): 1, 2, 17 and 18 make holes, 3 to 5 slots and pockets."""

from __future__ import annotations

from collections.abc import Sequence

from cncgen.gcode.block import evaluate
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.errors import refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import drilling, slots
from cncgen.gcode.klartext.hole_cycle import HoleCycle, Z, lent
from cncgen.gcode.text.plain_language import Raw, words_of

#: Cycles of TNC 155 to 426 whose values stand in parts: set-up clearance, depth, then those of each.
PARTS: dict[int, tuple[str, ...]] = {
    1: ("SETUP", "DEPTH", "PECKG", "DWELL", "F"),
    2: ("SETUP", "DEPTH", "DWELL", "F"),
    3: ("SETUP", "DEPTH", "PECKG", "X", "Y", "F"),
    4: ("SETUP", "DEPTH", "PECKG", "X", "Y", "F"),
    5: ("SETUP", "DEPTH", "PECKG", "RADIUS", "F"),
    17: ("SETUP", "DEPTH", "PITCH"),
    18: ("DEPTH", "PITCH"),
}
_THREAD = 18
_POCKETS = {3: slots.slot, 4: slots.rectangle, 5: slots.circle}


def take_part(ip: Interpreter, number: int, part: int, text: str) -> None:
    """CYCL DEF n.p: take the values of a part; the cycle is defined by part 0."""
    parts = PARTS[number]
    beyond = f"cycle {number} has the parts {number}.1 to {number}.{len(parts)}, and {number}.{part} is none of them"
    refuse("CYCL", (not 1 <= part <= len(parts), "cycle-words", beyond, f"{number}.1 is {parts[0]}"))
    take_value(ip, number, part, words_of(text))


def take_value(ip: Interpreter, number: int, part: int, raw: Sequence[Raw]) -> None:
    """Take the words of one of its values."""
    plain, names = Plain.of(ip), PARTS[number]
    given = {name: evaluate(value, ip.parameters) for name, value in raw if value == value}
    sense = given.pop("DR±", None)
    words = list(given.items())
    if words:
        plain.parts[names[part - 1]] = words[0][1]
    if names[part - 1] == "X":
        plain.parts["FIRST"] = float(words[0][0] == "Y") if words else 0.0
    # The feed downwards stands behind the infeed, the sense and the corners behind the feed.
    for name, found in words[1:]:
        place = (
            "PLUNGE"
            if (names[part - 1], name) == ("PECKG", "F")
            else "RADIUS"
            if names[part - 1] == "F" and name[0] == "R"
            else ""
        )
        message = f"{name} {found:g} of CYCL DEF {number}.{part} {names[part - 1]} is not read"
        hint = "F stands behind the infeed, DR and RADIUS behind F"
        refuse("CYCL", (not place, "unsupported-block", message, hint))
        plain.parts[place] = found
    if sense is not None:
        plain.parts["SENSE"] = sense


def run(ip: Interpreter, number: int) -> None:
    """1 pecks, 2 taps with a floating chuck, 17 taps in step with the spindle, 3 to 5 clear a slot or a pocket: from where the tool is,
    the set-up clearance above. 18 cuts a thread from there on."""
    parts = Plain.of(ip).parts
    for k, name in enumerate(PARTS[number], 1):
        part = f"{number}.{k} {name}"
        message = f"cycle {number} has no {part}"
        refuse("CYCL", (name not in parts, "cycle-words", message, f"CYCL DEF {part} gives it"))
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
    with lent(q, given):
        cycle = HoleCycle(ip, f"cycle {number}")
        if number in _POCKETS:
            _POCKETS[number](cycle, values)
        else:
            {1: _peck_old, 2: drilling.tap_floating, 17: drilling.tap}[number](cycle)
        cycle.end()


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
    depth, mm = abs(cycle.q[201]), 1.0 / cycle.ip.state.unit_mm
    ahead = 0.6 * mm if depth <= 30.0 * mm else min(depth / 50.0, 7.0 * mm)
    cycle.feed(cycle.q[206], "F")
    for level in drilling.steps(cycle):
        cycle.go(level, rapid=False)
        if level == cycle.bottom:
            break
        cycle.go(cycle.start, rapid=True)
        cycle.go(level + ahead, rapid=True)
    cycle.dwell(cycle.q[211])
