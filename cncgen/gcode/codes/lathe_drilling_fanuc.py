"""Drilling on lathes: G83 G84 G85 along Z and G87 G88 G89 along X of FANUC (B-64304EN-1, 5.1), and of Haas's lathes G81 G82 G86 and G184
along Z, and G241 to G249 along X.

Words stay in force until G80. The tool goes back to the level where the first hole of a row began. FANUC counts R as a distance
from that level, Haas as a place. The reading between the level and the bottom is taken; if both are, FANUC's is taken with a
warning. W (U of holes along X) is the distance from R to the bottom. G83 and G87 leave the hole after each step of Q. K repeats the
hole, each time by the distances of its block (C by H) farther; K0 keeps the words. A bottom above that level drills upwards, with a warning.
"""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.codes.canned_cycles import Hole, Sticky, repeats
from cncgen.gcode.codes.canned_cycles_fanuc import HOLES, row_of_holes
from cncgen.gcode.codes.dwell import seconds_of
from cncgen.gcode.codes.lathe_fanuc import ONLY, increments
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.table import IS_CYCLE, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

#: The cycle of mills whose moves a cycle makes, and the axis along which it drills.
_MOVES = {
    **{number: (number, "z") for number in (810, 820, 830, 840, 850, 860)},
    870: (830, "x"),
    880: (840, "x"),
    890: (850, "x"),
    1840: (740, "z"),
    **{2400 + number: (800 + number, "x") for number in (10, 20, 30, 50, 60, 80, 90)},
}
#: The distance from R to the bottom, and the words of the places of holes.
_DEPTHS = {"z": "w", "x": "u"}
_PLACES = {"z": "xyc", "x": "zyc"}
_KEPT = "rpq"
#: A step of G83 below this, in mm, is meant as a length and not in least increments.
_LEAST_STEP_MM = 0.05
_TINY = 1e-9


def _words_in_force(ip: Interpreter, block: Block, number: int) -> Sticky:
    """Return the words of this block and those kept since the first hole of the row."""
    state = ip.state
    axis = _MOVES[number][1]
    bottom = (axis, _DEPTHS[axis])
    sticky = row_of_holes(ip, _MOVES, AXIS_INDEX[axis])
    given = block.only((*bottom, *_KEPT))
    if "q" in given:
        given["q"] = _step(ip, block)
    if "p" in given:
        given["p"] = seconds_of(ip, block)
    kept = sticky.words
    if any(letter in given for letter in bottom):
        kept = {letter: value for letter, value in kept.items() if letter not in bottom}
    state.cycle = Sticky(number, {**kept, **given}, sticky.level)
    state.motion = number
    return state.cycle


def _step(ip: Interpreter, block: Block) -> float:
    """Return the step Q: whole numbers count in least increments where that makes a step that can be meant."""
    value = block.words["q"]
    step = increments(ip, block, "q")
    if step == value or step * ip.state.unit_mm >= _LEAST_STEP_MM:
        return step
    message = f"Q{value:g} of G83 is read as {value:g}, not as {step:g} (least increments)"
    ip.warn_once("cycle-peck", message, "Q", "FANUC's Q5000 is 5 mm, Haas's Q5. too")
    return value


def _levels(ip: Interpreter, sticky: Sticky, axis: str) -> tuple[float, float]:
    """Return R and the bottom of a hole as places; along X in radius, in which FANUC counts R too."""
    words, level = sticky.words, sticky.level
    if _DEPTHS[axis] in words:
        retract = level + words.get("r", 0.0)
        return retract, retract + words[_DEPTHS[axis]]
    return _retract(ip, sticky, words[axis], axis.upper()), words[axis]


def _retract(ip: Interpreter, sticky: Sticky, bottom: float, axis: str) -> float:
    """Return the place of R where the bottom is given as a place."""
    if "r" not in sticky.words:
        return sticky.level
    r = sticky.words["r"]
    # A place along X is a diameter.
    places = [0.5 * r if axis == "X" else r, sticky.level + r]
    low, high = sorted((bottom, sticky.level))
    within = [place for place in places if low - _TINY <= place <= high + _TINY]
    if not within:
        message = f"R{r:g} lies between {axis} {sticky.level:g} and the bottom {bottom:g} neither as a place nor as a distance"
        hint = "R-3. from Z5. drills from Z2. on FANUC's controls"
        raise BlockError("cycle-depth", message, "R", hint=hint)
    if len(within) == 2 and abs(within[0] - within[1]) > _TINY:
        message = f"R{r:g} is read as the distance to {axis} {places[1]:g}; on Haas's lathes it is the place {axis}{r:g}"
        ip.warn_once("cycle-level", message, "R", "R0 with the tool at that place is both")
    return within[-1]


def _cycle(ip: Interpreter, block: Block, number: int) -> None:
    moves, axis = _MOVES[number]
    cycle = HOLES[moves]
    normal = AXIS_INDEX[axis]
    state, name = ip.state, f"G{number // 10}"
    sticky = _words_in_force(ip, block, number)
    if block.words.keys().isdisjoint("xzrcuw"):
        return
    count = repeats(block, "k", 0)
    check_feed(ip, block, name)
    if sticky.words.keys().isdisjoint((axis, _DEPTHS[axis])):
        message = f"{name} has no {axis.upper()}"
        raise BlockError("cycle-words", message, name, hint=f"{axis.upper()} is the bottom of the hole")
    retract, bottom = _levels(ip, sticky, axis)
    up = -1.0 if bottom > sticky.level else 1.0
    if up < 0.0:
        letter, hint = (
            axis.upper(),
            "holes on a second spindle do, and on lathes whose Z points into the part",
        )
        message = (
            f"the hole leads from {letter}{sticky.level:g} up to {letter}{bottom:g}, towards greater {letter}"
        )
        ip.warn_once("cycle-depth", message, letter, hint)
    words = {**sticky.words, "p": sticky.words.get("p", 0.0)}
    if cycle.needs and words.setdefault("q", abs(retract - bottom) or 1.0) <= 0.0:
        raise BlockError("cycle-peck", f"Q{words['q']:g} of {name} must be greater than 0", "Q")
    end = ip.end_point(Block(block.only(_PLACES[axis]), block.g))
    clear = sticky.level if state.retract_old else retract
    hole = Hole(ip, block, normal, up * retract, up * bottom, up * clear, words, 0, up)
    place = {AXIS_INDEX[letter]: end[AXIS_INDEX[letter]] for letter in _PLACES[axis]}
    step = {column: place[column] - state.position[column] for column in ip.distances & place.keys()}
    for again in range(count):
        hole.across({column: at + again * step.get(column, 0.0) for column, at in place.items()})
        hole.traverse(hole.retract)
        cycle.run(hole)
    state.moved = True


CODES = tuple(
    Code("G", number, "motion", Stage.MOTION, partial(_cycle, number=number), f"{HOLES[moves].help}, along {axis.upper()}",
        "xyzuvwcrpqk", "motion", summons="xyzuvwcr", dialects=ONLY, depth=_DEPTHS[axis], pitched=HOLES[moves].taps,
        moves=axis.upper(), refused=IS_CYCLE)
    for number, (moves, axis) in _MOVES.items()
)  # fmt: skip
