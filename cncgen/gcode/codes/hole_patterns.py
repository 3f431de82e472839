"""Codes that repeat the cycle in force in a row of places: G70 to G72 of Haas's mills, G34 to G37.1 of Mitsubishi's and Mazak's.

Sources: Haas mill operator's manual, "G70 Bolt Hole Circle", "G71 Bolt Hole Arc", "G72 Bolt Holes Along an Angle"; Mitsubishi
M700V/M70V programming manual (machining centre), "Special fixed cycle", of which Mazak's EIA has the same, G34.1 for G34.
"""

from __future__ import annotations

import cmath
import math
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.canned_cycles import MAX_REPEATS, Sticky
from cncgen.gcode.codes.canned_cycles_fanuc import HOLES, PATTERN, check_words, make_holes
from cncgen.gcode.codes.modes import is_unit
from cncgen.gcode.codes.places import in_rows, on_circle
from cncgen.gcode.codes.probing import tell
from cncgen.gcode.codes.table import IS_CYCLE, Code
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage


def _count(words: dict[str, float], letter: str, name: str, hint: str) -> int:
    """Return a number of holes, whose sign says which way they go; raise where it is missing, no whole number, 0 or too large."""
    value = words.get(letter, 0.0)
    if value != round(value) or not 1 <= abs(value) <= MAX_REPEATS:
        message = (
            f"{letter.upper()}{value:g} of {name} says how many holes: a whole number, 1 to {MAX_REPEATS}"
        )
        raise BlockError("cycle-words", message, name, hint=hint)
    return round(value)


def _circle(words: dict[str, float], count: int) -> list[complex]:
    step = math.copysign(360.0 / count, words["i"] * count)
    return on_circle(0j, abs(words["i"]), words.get("j", 0.0), step, abs(count))


def _arc(words: dict[str, float], count: int) -> list[complex]:
    step = words["k"] if "l" in words else words["p"]
    return on_circle(0j, abs(words["i"]), words.get("j", 0.0), math.copysign(1.0, count) * step, abs(count))


def _line(words: dict[str, float], count: int) -> list[complex]:
    return in_rows(0j, cmath.rect(1.0, math.radians(words.get("j", 0.0))) * words["i"], 0j, abs(count), 1)


def _grid(words: dict[str, float], count: int) -> list[complex]:
    """Return rows along X, one back and the next forth."""
    return in_rows(0j, complex(words["i"]), 1j * words["j"], abs(count), abs(round(words["k"])))


#: Of each code: its letters, those that must be there, the letter of the count, its places, help and an example.
_PATTERNS = {
    700: ("ijl", "il", "l", _circle, "on a circle (Haas)", "G70 I5. J15. L12"),
    710: ("ijkl", "ikl", "l", _arc, "on an arc (Haas)", "G71 I5. J30. K15. L4"),
    720: ("ijl", "il", "l", _line, "on a line (Haas)", "G72 I5. J30. L4"),
    340: ("ijk", "ik", "k", _circle, "on a circle (Mitsubishi)", "G34 X20. Y10. I10. J20. K6"),
    341: ("ijk", "ik", "k", _circle, "on a circle (Mazak)", "G34.1 X20. Y10. I10. J20. K6"),
    350: ("ijk", "ik", "k", _line, "on a line (Mitsubishi, Mazak)", "G35 X20. Y10. I10. J30. K5"),
    360: ("ijkp", "ikp", "k", _arc, "on an arc (Mitsubishi, Mazak)", "G36 X30. Y-10. I30. J10. P15. K8"),
    371: ("ijkp", "ijkp", "p", _grid, "on a grid (Mitsubishi, Mazak)", "G37.1 X30. Y-10. I5. P10 J10. K8"),
}  # fmt: skip
#: Units that codes with these numbers are without words, where no cycle is in force (Hurco, DIN 66025).
_UNITS = {700: 200, 710: 210}
#: Values that codes of Haas with these numbers measure and set, outside of cycles ("G35", "G36").
_MEASURES = {350: "the tool's diameter", 360: "the origin"}


def _pattern(ip: Interpreter, block: Block, number: int) -> None:
    letters, needs, counts, places, _, example = _PATTERNS[number]
    name = f"G{number / 10:g}"
    state, words = ip.state, block.words
    turning = counts == "l" and {"p", "q"} <= words.keys()
    if state.motion not in HOLES or not isinstance(state.cycle, Sticky) or turning:
        if number in _UNITS and is_unit(ip, block, name, _UNITS[number]):
            return
        if number in _MEASURES and state.motion == 10 and not words.keys().isdisjoint("xyz"):
            # The line in force has gone to the place.
            tell(ip, name, _MEASURES[number])
            return
        hint = "G81 stands before it or in its block; turning cycles are of --dialect fanuc-lathe"
        if number in _MEASURES:
            hint = f"G81 stands before it or in its block; {name} of Haas, which measures with a probe, has G1 before it"
        raise BlockError("cycle-missing", f"{name} has no cycle in force that it repeats", name, hint=hint)
    taken = letters + ("pq" if counts == "l" else "")
    strange = [c.upper() for c in words if c in "ijklpq" and c not in taken]
    missing = [c.upper() for c in needs if c not in words] + ["I"] * (words.get("i") == 0.0)
    refuse(
        name,
        (bool(missing), "cycle-words", f"{name} has no {' and no '.join(missing)}", example),
        (bool(strange), "cycle-words", f"{name} has a word {''.join(strange[:1])}", example),
        (state.plane != 17, "cycle-words", f"{name} has no G17", example),
    )
    count = _count(words, counts, name, example)
    if places is _grid:
        _count(words, "k", name, example)
    check_words(ip, block, state.motion, state.cycle.words)
    centre = ip.end_point(Block(block.only("xy"), block.g))
    for at in places(words, count):
        place = [centre[0] + at.real, centre[1] + at.imag]
        if not state.absolute:
            place = [at - here for at, here in zip(place, state.position, strict=False)]
        here = block.beside({"x": place[0], "y": place[1]})
        make_holes(ip, here, state.motion, state.cycle)


CODES = tuple(
    Code("G", number, PATTERN, Stage.STOP, partial(_pattern, number=number), f"cycle in force {text}",
        "ijklpq" if counts == "l" else letters, dialects=("fanuc",), takes="ijkl" if counts == "l" else letters, moves="XYZ",
        refused=IS_CYCLE, without="lathes")
    for number, (letters, _, counts, _, text, _) in _PATTERNS.items()
)  # fmt: skip
