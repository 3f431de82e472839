"""Canned cycles with FANUC's words: G73, G74, G76, G81 to G89 (B-63324EN, 13.1), and G77 of Haas.

They differ from LinuxCNC's: P is milliseconds and may be left out; K counts the repeats (K0 keeps the words and makes
no hole; L is taken too); the words of a hole stay in force from cycle to cycle until G80 or a motion code; the tool goes
across at the height where it is, with all axes but that of the hole, and then to R; G76 and G87 move away from the wall by Q, in the direction of the
plane's first axis (parameter 5148 of the control), or without Q by I and J (Haas mill operator's manual, "G76"). A block without
X, Y, Z, R or any other axis makes no hole.
"""

from __future__ import annotations

import math
from collections.abc import Container
from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.canned_cycles import (
    CYCLES,
    MAX_REPEATS,
    Cycle,
    Hole,
    HoleMoves,
    Sticky,
    check_cut,
    repeats,
)
from cncgen.gcode.codes.dwell import has_point, seconds_of
from cncgen.gcode.codes.lathe_fanuc import increments
from cncgen.gcode.codes.lines import check_cycle_feed, need_axis
from cncgen.gcode.codes.spindle import turn_to
from cncgen.gcode.codes.table import IS_CYCLE, LATHE, Code, table
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import ARMED, IN_ROW, PLAIN_MOTIONS, Stage

_LETTERS = "rpq"
#: The group of codes that repeat the cycle in force (`hole_patterns`).
PATTERN = "hole pattern"
#: How far steps may add up to less than a length by rounding.
_ROUNDING = 1e-9
#: The way off the wall of a bore that Q cannot mean, in mm.
_FAR = 5.0
#: Pitches of taps, mm: the finest (0.08, S0.3 of NIHS) and the coarsest (6, M64), with room for another speed than the tap was made for.
LEAST_PITCH, GREATEST_PITCH = 0.04, 12.0


def _pecks(hole: Hole) -> list[float]:
    """Return the depths of G73 and G83 of Haas: I J K are the first step, what each next one is less, the least one; else Q is each step."""
    step, less, least, same = (hole.unscaled(hole.words.get(k, 0.0), hole.normal) for k in "ijkq")
    if "i" not in hole.words:
        step, less, least = same, 0.0, 0.0
    if (
        step <= 0.0
        or less < 0.0
        or least < 0.0
        or (hole.retract - hole.bottom) / (least or step) > MAX_REPEATS
    ):
        message = f"I{step:g} J{less:g} K{least:g} of a cycle: the first step, what each next one is less, the least one"
        raise BlockError("cycle-peck", message, "I", hint="G83 Z-2. R0.1 I0.5 J0.1 K0.2")
    depths = [hole.retract]
    while depths[-1] > hole.bottom:
        level = depths[-1] - step
        depths.append(level if level > hole.bottom + _ROUNDING else hole.bottom)
        step = max(step - less, least) or step
    return depths[1:]


def _haas_peck(hole: Hole, out: float) -> None:
    """G83 or G73 of Haas: out of the hole when the steps since the last time add up to `out`."""
    since = hole.retract
    for level in _pecks(hole):
        hole.feed(level)
        if level == hole.bottom:
            break
        if since - level >= out - _ROUNDING:
            hole.traverse(hole.retract)
            since = level
        hole.traverse(level + hole.clearance)
    hole.wait()
    hole.traverse(hole.clear)


def _pecking(hole: Hole, number: int) -> None:
    """G73 or G83."""
    if "i" in hole.words:
        _haas_peck(hole, 0.0 if number == 830 else math.inf)
    elif "k" in hole.words:
        _haas_peck(hole, hole.unscaled(hole.words["k"], hole.normal))
    else:
        CYCLES[number].run(hole)


def _beside(hole: Hole, beside: dict[int, float], within: dict[int, float], level: float) -> None:
    """Stop the spindle at its angle, go to a level beside the hole, and back within it start the spindle."""
    hole.turn(0)
    turn_to(hole.ip, hole.spindle, 0.0, 0)
    hole.across(beside)
    hole.traverse(level)
    hole.across(within)
    hole.turn(1)


def _tap(hole: Hole, direction: int) -> None:
    """The tapping cycle: down turning one way, out turning the other way."""
    _doubt_pitch(hole)
    state, faster = hole.ip.state, hole.words.get("j", 1.0)
    if state.rigid:
        _tap_in_step(hole, direction)
        return
    if hole.block.words.get("q"):
        text = f"Q{hole.block.words['q']:g} of G{state.motion // 10} is passed over: the tap goes in once"
        _doubt(hole.ip, text, "a control that is set to tap in steps comes out after each of them")
    hole.feed(hole.bottom)
    hole.wait()
    hole.turn(-direction)
    if faster != 1.0:
        # J of Haas: how many times as fast the tap comes out.
        hole.ip.sink.set_feed_rate(state.feed * faster)
    hole.feed(hole.retract)
    if faster != 1.0:
        hole.ip.sink.set_feed_rate(state.feed)
    hole.wait()
    hole.turn(direction)
    hole.traverse(hole.clear)


def _doubt_pitch(hole: Hole) -> None:
    """Warn of a pitch that no tap has, which F under G94 makes with the speed."""
    state = hole.ip.state
    if state.feed_mode != 94 or not state.speed:
        return
    pitch = state.feed / state.speed * state.unit_mm
    if not LEAST_PITCH <= pitch <= GREATEST_PITCH:
        message = f"F{state.feed:g} of a tap at S{state.speed:g} is a pitch of {pitch:.3g} mm"
        hint = "under G94, F is the pitch by S; G95 takes F as the pitch"
        hole.ip.warn_once(
            "tap-pitch", message, "F" if "f" in hole.block.words else f"G{state.motion // 10}", hint
        )


def _tap_in_step(hole: Hole, direction: int) -> None:
    """The tap after M29, which turns the spindle in step with the feed (B-64304EN-2, rigid tapping); raise where the speed is 0.

    The pitch is F a turn under G95, and F by S under G94. The spindle starts by M29 alone. P is waited for once the tap is out, for a
    tap in step has no dwell of its own.
    """
    ip, state = hole.ip, hole.ip.state
    name = f"G{state.motion // 10}"
    for letter, neutral in (("q", 0.0), ("j", 1.0)):
        if hole.words.get(letter, neutral) != neutral:
            text = f"{letter.upper()}{hole.words[letter]:g} of {name} after M29 changes nothing: the tap goes in once, and out as fast"
            _doubt(ip, text, "Q are steps of a deep thread, J a factor of the way out")
    if state.speed <= 0.0:
        raise BlockError("spindle-stopped", f"{name} after M29 has no speed S", name, hint="M29 S500")
    pitch = state.feed if state.feed_mode == 95 else state.feed / state.speed
    if state.direction != direction:
        hole.turn(direction)
    bottom = state.position.copy()
    bottom[hole.normal] = hole.up * hole.bottom
    ip.sink.call(f"START_SPEED_FEED_SYNC({pitch:f},0)")
    ip.sink.rigid_tap(bottom, pitch)
    ip.sink.call("STOP_SPEED_FEED_SYNCH()")
    hole.wait()
    hole.wait()
    hole.traverse(hole.clear)


def _shift(hole: Hole) -> tuple[dict[int, float], dict[int, float]]:
    """Return the places across of the tool beside the hole and in it; say which way is taken to be away from the wall."""
    ip, words = hole.ip, hole.words
    first, second, _ = ip.state.plane_axes()
    middle = ip.state.position[first]
    if "q" not in words:
        within = {first: middle, second: ip.state.position[second]}
        pairs = zip(within.items(), "ij", strict=True)
        return {k: v + hole.unscaled(words.get(letter, 0.0), k) for (k, v), letter in pairs}, within
    message = f"the tool is taken to leave the wall along {AXES[first].upper()}+; the control has the direction in a parameter"
    hint = "it is parameter 5148 of FANUC, 5101 of its older controls, setting 27 of Haas"
    ip.note_once("cycle-shift", message, "Q", hint)
    return {first: middle + hole.unscaled(words["q"], first)}, {first: middle}


def _fine_bore(hole: Hole) -> None:
    """G76: stop at the bottom, step off the wall by Q, come out without a mark."""
    beside, within = _shift(hole)
    hole.feed(hole.bottom)
    hole.wait()
    _beside(hole, beside, within, hole.clear)


def _back_bore(hole: Hole) -> None:
    """G87: go down beside the hole to R, bore upward to Z, come out beside it."""
    beside, within = _shift(hole)
    _beside(hole, beside, within, hole.retract)
    hole.feed(hole.bottom)
    hole.wait()
    _beside(hole, beside, within, hole.clear)


#: The moves of each cycle from R on (G87: from the start); I J of Haas are steps of drilling, J the speed of a tap on its way out.
HOLES = {
    730: Cycle(partial(_pecking, number=730), "q", "drill, breaking chips every Q", "ij"),
    740: Cycle(partial(_tap, direction=-1), "", "tap, left-hand", "j", taps=True),
    760: Cycle(_fine_bore, "q", "bore, step off the wall by Q, traverse out", "ij", aside=True),
    770: Cycle(_back_bore, "q", "back bore from R up to Z, as G87 (Haas)", "ij", aside=True),
    810: Cycle(CYCLES[810].run, "", "drill", "e"),
    820: Cycle(HoleMoves("Bwc"), "", "drill, dwell for P", "e"),
    830: Cycle(partial(_pecking, number=830), "q", "drill, out of the hole every Q", "ije"),
    840: Cycle(partial(_tap, direction=1), "", "tap, right-hand", "je", taps=True),
    # Of Mazak's controls and FANUC's FS15 format: rigid without M29.
    842: Cycle(lambda hole: _tap_in_step(hole, 1), "", "tap in step with the spindle, right-hand", taps=True),
    843: Cycle(lambda hole: _tap_in_step(hole, -1), "", "tap in step with the spindle, left-hand", taps=True),
    850: Cycle(CYCLES[850].run, "", "bore, feed out"),
    860: Cycle(HoleMoves("B0c1"), "", "bore, stop the spindle, traverse out"),
    870: Cycle(_back_bore, "q", "back bore from R up to Z, Q beside the hole on the way", "ij", aside=True),
    880: Cycle(HoleMoves("Bw0!c1"), "", "bore, dwell for P, stop for the operator"),
    890: Cycle(HoleMoves("BwRc"), "", "bore, dwell for P, feed out"),
}
_BACK = (770, 870)


def _cycle(ip: Interpreter, block: Block, number: int) -> None:
    pattern = next((row for row in ip.codes.of(block) if row.group == PATTERN), None)
    if pattern is not None:
        # The words of the pattern are its own, and its places take the holes.
        own = block.without(pattern.takes)
        idle = next((letter.upper() for letter in own.words if letter in AXES[3:]), "")
        if idle:
            message = f"{idle} stands beside {pattern.name}, whose holes lie in the plane"
            raise BlockError("unused-word", message, idle, hint=f"{idle} in a block before it leads there")
        _words_in_force(ip, own, number)
        return
    sticky = _words_in_force(ip, block, number)
    if not block.words.keys().isdisjoint(AXES + "r"):
        try:
            check_words(ip, block, number, sticky.words)
            make_holes(ip, block, number, sticky)
        except BlockError as error:
            turning = table(LATHE).get(("G", number))
            if turning and turning.axes == "own" and error.code == "cycle-words":
                error.hint += f"; G{number // 10} of lathes is read by --dialect fanuc-lathe"
            raise


def row_of_holes(ip: Interpreter, cycles: Container[int], normal: int) -> Sticky:
    """Return what a row of holes of some cycles keeps; a new one begins where the tool is along the axis of that column."""
    state = ip.state
    if isinstance(state.cycle, Sticky) and state.motion in cycles:
        return state.cycle
    state.under = state.motion if state.motion in PLAIN_MOTIONS else 0
    # M29 is for one row of holes, which any code of motion ends (B-64304EN-2, rigid tapping).
    state.rigid = IN_ROW if state.rigid == ARMED else 0
    return Sticky(level=state.position[normal])


def _words_in_force(ip: Interpreter, block: Block, number: int) -> Sticky:
    """Return the words of this block and those kept since the first cycle of the row."""
    state = ip.state
    normal = state.plane_axes()[2]
    sticky = row_of_holes(ip, HOLES, normal)
    given = block.only(
        _LETTERS + AXES[normal] + HOLES[number].takes + "k" * _takes_k(ip, block, number, sticky)
    )
    if "p" in given:
        given["p"] = seconds_of(ip, block)
    if "e" in given:
        text = f"E{given['e']:g} of G{number // 10} turns the spindle backwards behind each hole to clear chips (Haas): it is not planned"
        _doubt(ip, text, "it takes time, and moves no axis")
    relative = sticky.relative - given.keys() if state.absolute else sticky.relative | given.keys()
    words = {**sticky.words, **given}
    if HOLES[number].aside and not given.keys().isdisjoint("qij"):
        # Q or I J says how far the tool goes aside, not both.
        words = {
            k: v
            for k, v in words.items()
            if k not in "qij" or (k in given and (k == "q" or "q" not in given))
        }
    if HOLES[number].aside and "q" in given:
        words["q"] = _off_wall(ip, block, number)
    elif HOLES[number].needs and "q" in given and AXES[normal] in words:
        level = 0.0 if AXES[normal] in relative else words.get("r", sticky.level)
        words["q"] = _step(ip, block, abs(words[AXES[normal]] - level))
    state.cycle = Sticky(number, words, sticky.level, relative=relative)
    state.motion = number
    return state.cycle


def _takes_k(ip: Interpreter, block: Block, number: int, sticky: Sticky) -> bool:
    """Tell whether K is a word of the hole, and no number of holes: beside I the least step, of G73 how deep the tool goes before it goes
    back (Haas)."""
    if HOLES[number].aside:
        return False
    if "i" in block.words or (sticky.number == number and "i" in sticky.words):
        return True
    depth = number == 730 and "k" in block.words and (block.words["k"] % 1.0 or has_point(ip, block, "k"))
    if depth:
        text = f"K{block.words['k']:g} of G73 is the depth after which the tool goes back to R, as on Haas's mills"
        _doubt(ip, text, "a number of holes has no decimal point")
    return bool(depth)


def _step(ip: Interpreter, block: Block, depth: float) -> float:
    """Return the step Q of a hole: a whole number that is deeper than the hole counts in least increments, as Q2000 of 2 mm."""
    value = block.words["q"]
    step = increments(ip, block, "q")
    if value <= depth or step > depth or has_point(ip, block, "q") is not False:
        return value
    message = f"Q{value:g}, deeper than the hole, is read as {step:g} (least increments)"
    ip.warn_once("cycle-peck", message, "Q", "a length has a decimal point: Q2.0")
    return step


def _off_wall(ip: Interpreter, block: Block, number: int) -> float:
    """Return how far G76 or G87 steps off the wall: a whole number too long for it counts in least increments, as Q100 of 0.1 mm."""
    value = block.words["q"]
    length = increments(ip, block, "q")
    if value * ip.state.unit_mm < _FAR or has_point(ip, block, "q") is not False:
        return value
    message = f"Q{value:g} of G{number // 10}, too far to step off the wall of a bore, is read as {length:g} (least increments)"
    ip.warn_once("cycle-shift", message, "Q", "a length has a decimal point: Q0.5")
    return length


def check_words(ip: Interpreter, block: Block, number: int, words: dict[str, float]) -> None:
    """Raise where the words of a hole are missing or wrong."""
    name = f"G{number // 10}"
    needs = "r" + AXES[ip.state.plane_axes()[2]] + HOLES[number].needs
    if "i" in words or (HOLES[number].aside and "j" in words):
        needs = needs.replace("q", "")
    missing = [letter.upper() for letter in needs if letter not in words]
    if missing == ["Q"] and not HOLES[number].aside:
        words["q"] = math.inf
        _doubt(
            ip,
            f"{name} has no Q: it drills to the bottom at once, as some controls do",
            "Q is the depth of a step",
        )
    elif missing == ["R"] and number not in _BACK:
        words["r"] = ip.state.position[ip.state.plane_axes()[2]]
        text = f"{name} has no R: the hole begins where the tool stands, at {words['r']:g}, as on Haas's controls"
        _doubt(ip, text, "R is the height that the hole begins at; other controls take 0, or refuse it")
    check_cut(words, needs, name)
    check_cycle_feed(ip, block, name)


def _doubt(ip: Interpreter, text: str, hint: str) -> None:
    ip.warn_once("cycle-words", text, f"G{ip.state.motion // 10}", hint)


def make_holes(ip: Interpreter, block: Block, number: int, sticky: Sticky) -> None:
    state = ip.state
    normal = state.plane_axes()[2]
    depth = AXES[normal]
    words = {**sticky.words, "p": sticky.words.get("p", 0.0)}
    # R and the depth keep the meaning of their block, whatever mode is in force now.
    retract = words["r"] + (sticky.level if "r" in sticky.relative else 0.0)
    bottom = words[depth] + (retract if depth in sticky.relative else 0.0)
    if (bottom > retract) != (number in _BACK) and bottom != retract:
        message = f"the bottom, {depth.upper()} {bottom:.4f}, is on the wrong side of R {retract:.4f}"
        hint = "G87 bores upwards: R is beneath the hole" if number in _BACK else ""
        raise BlockError("cycle-depth", message, "R" if "r" in block.words else depth.upper(), hint=hint)
    # R of a back bore lies beneath the part: it comes out to the initial level, also under G99.
    clear = max(sticky.level, retract) if state.retract_old or number in _BACK else retract
    hole = Hole(ip, block, normal, retract, bottom, clear, words, 0)
    step = block.without(depth)
    letter = "k" if "k" in block.words and "k" not in sticky.words else "l"
    for _ in range(repeats(block, letter, 0)):
        hole.across({k: place for k, place in enumerate(ip.end_point(step)) if k != normal})
        if number not in _BACK:
            hole.traverse(retract)
        HOLES[number].run(hole)
    state.moved = True


def _tap_to(ip: Interpreter, block: Block, direction: int) -> None:
    """G174 or G184 of Haas's mills: a tap from where the tool stands to a place, along any line, and back."""
    name = f"G{1740 // 10 if direction < 0 else 1840 // 10}"
    need_axis(block, name, "X Y Z are the bottom of the hole")
    check_cycle_feed(ip, block, name)
    start, spindle = ip.state.position.copy(), Hole(ip, block, 2, 0.0, 0.0, 0.0, {}, 0)
    if ip.state.direction != direction:
        spindle.turn(direction)
    ip.go(ip.end_point(block))
    spindle.turn(-direction)
    ip.go(start)
    spindle.turn(ip.state.direction)


CODES = tuple(
    Code("G", number, "motion", Stage.MOTION, partial(_cycle, number=number), cycle.help, AXES + "rpqkl" + cycle.takes, "motion",
        summons=AXES + "r", dialects=("fanuc",), pitched=cycle.taps, moves="plane" if cycle.aside else "", refused=IS_CYCLE,
        without="lathes")
    for number, cycle in HOLES.items()
) + tuple(
    Code("G", number, "non-modal", Stage.MOTION, partial(_tap_to, direction=direction),
        f"tap {hand} to a place along any line, and back (Haas)", AXES, "own", dialects=("fanuc",), pitched=True, refused=IS_CYCLE,
        without="lathes")
    for number, direction, hand in ((1740, -1, "left-hand"), (1840, 1, "right-hand"))
)  # fmt: skip
