"""Drilling along Z on lathes: G83 G84 G85 of FANUC (B-64304EN-1, 5.1), and G81 G82 G86 of Haas's lathes.

Words stay in force until G80. The tool goes back to the level where the first hole of a row began. FANUC counts R as a distance
from that level, Haas as a place in Z. The reading between the level and the bottom is taken; if both are, FANUC's is taken with a
warning. G83 leaves the hole after each step of Q.
"""

from __future__ import annotations

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.codes.canned_cycles import Hole, Sticky
from cncgen.gcode.codes.canned_cycles_fanuc import HOLES
from cncgen.gcode.codes.dwell import seconds_of
from cncgen.gcode.codes.lathe_fanuc import ONLY, increments
from cncgen.gcode.codes.lathe_words import X, Z
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.table import Code, Handler
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import ARMED, IN_ROW, PLAIN_MOTIONS, Stage

_NUMBERS = (810, 820, 830, 840, 850, 860)
_KEPT = "zrpq"
#: A step of G83 below this, in mm, is meant as a length and not in least increments.
_LEAST_STEP_MM = 0.05
_TINY = 1e-9
#: Stands among the remarks of a run once R was doubtful.
_SAID = -83


def _words_in_force(ip: Interpreter, block: Block, number: int) -> Sticky:
    """Return the words of this block and those kept since the first hole of the row."""
    state = ip.state
    sticky = state.cycle if isinstance(state.cycle, Sticky) and state.motion in _NUMBERS else None
    if sticky is None:
        state.under = state.motion if state.motion in PLAIN_MOTIONS else 0
        state.rigid = IN_ROW if state.rigid == ARMED else 0
        sticky = Sticky(level=state.position[Z])
    given = {letter: value for letter, value in block.words.items() if letter in _KEPT}
    if "q" in given:
        given["q"] = _step(ip, block)
    if "p" in given:
        given["p"] = seconds_of(ip, block)
    state.cycle = Sticky(number, {**sticky.words, **given}, sticky.level)
    state.motion = number
    return state.cycle


def _step(ip: Interpreter, block: Block) -> float:
    """Return the step Q: whole numbers count in least increments where that makes a step that can be meant."""
    value = block.words["q"]
    step = increments(ip, block, "q")
    if step == value or step * (25.4 if ip.state.inches else 1.0) >= _LEAST_STEP_MM:
        return step
    message = f"Q{value:g} of G83 is read as {value:g}, not as {step:g} (least increments)"
    ip.warn(
        BlockError("cycle-peck", message, "Q", hint="FANUC's Q5000 is 5 mm, Haas's Q5. too"), Severity.WARNING
    )
    return value


def _retract(ip: Interpreter, sticky: Sticky, bottom: float) -> float:
    """Return the height R of a hole."""
    if "r" not in sticky.words:
        return sticky.level
    r = sticky.words["r"]
    places = [r, sticky.level + r]
    low, high = sorted((bottom, sticky.level))
    within = [place for place in places if low - _TINY <= place <= high + _TINY]
    if not within:
        message = f"R{r:g} lies between Z{sticky.level:g} and the bottom Z{bottom:g} neither as a place nor as a distance"
        raise BlockError(
            "cycle-depth", message, "R", hint="R-3. from Z5. drills from Z2. on FANUC's controls"
        )
    if len(within) == 2 and abs(within[0] - within[1]) > _TINY and _SAID not in ip.remarked:
        ip.remarked.add(_SAID)
        message = f"R{r:g} is read as the distance to Z{places[1]:g}; on Haas's lathes it is the place Z{r:g}"
        ip.warn(
            BlockError("cycle-level", message, "R", hint="R0 with the tool at that place is both"),
            Severity.WARNING,
        )
    return within[-1]


def _cycle(number: int) -> Handler:
    run_hole, needs_step, _ = HOLES[number]

    def run(ip: Interpreter, block: Block) -> None:
        state, name = ip.state, f"G{number // 10}"
        sticky = _words_in_force(ip, block, number)
        if block.words.keys().isdisjoint("xzrc"):
            return
        if "k" in block.words and whole(block, "k", name) != 1:
            message = f"K{block.words['k']:g} of {name}, how often the hole is repeated, is not read"
            raise BlockError("cycle-repeats", message, "K", hint="write a block for each hole; K1 is read")
        check_feed(ip, block, name)
        if "z" not in sticky.words:
            raise BlockError("cycle-words", f"{name} has no Z", name, hint="Z is the bottom of the hole")
        bottom = sticky.words["z"]
        if bottom > sticky.level:
            message = f"the bottom Z{bottom:g} lies above Z{sticky.level:g}, where the cycle began"
            raise BlockError("cycle-depth", message, "Z", hint="the cycle drills towards smaller Z")
        retract = _retract(ip, sticky, bottom)
        words = {**sticky.words, "p": sticky.words.get("p", 0.0)}
        if needs_step and words.setdefault("q", retract - bottom or 1.0) <= 0.0:
            raise BlockError("cycle-peck", f"Q{words['q']:g} of {name} must be greater than 0", "Q")
        end = ip.end_point(Block({k: v for k, v in block.words.items() if k in "xyc"}, block.g))
        hole = Hole(ip, block, Z, retract, bottom, sticky.level, words, 0)
        hole.across({X: end[X], 1: end[1], 5: end[5]})
        hole.traverse(retract)
        run_hole(hole)
        state.moved = True

    return run


CODES = tuple(
    Code("G", number, "motion", Stage.MOTION, _cycle(number), f"{HOLES[number][2]}, along Z", "xyzuvwcrpqk", "motion", summons="xyzuvwcr",
        dialects=ONLY, moves="Z")
    for number in _NUMBERS
)  # fmt: skip
