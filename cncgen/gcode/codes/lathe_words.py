"""Words of FANUC's lathes: diameters, distances U V W, and angles A, roundings and chamfers R C I K of lines (B-64304EN-1, 8 and 4.5).

`turned` converts them once to the words of the interpreter, before any other use of the block.
"""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import LATHE_ABSOLUTE, LATHE_STEPS, LATHES, displaced
from cncgen.gcode.errors import BlockError
from cncgen.records import replace

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

X, Z = 0, 2
_TURNED = frozenset(("x", "z", "u", "v", "w", "a", "c", "h", ",a"))
#: Words of distances: the axis and its column.
DISTANCES = {"u": ("x", X), "v": ("y", 1), "w": ("z", Z), "h": ("c", 5)}
#: Columns of the words that are distances under G91.
_PLACES = {"x": X, "y": 1, "z": Z, "c": 5}
_G10, _LINE = 100, 10
#: I K beside it are a direction.
_G40 = 400
#: Axes whose letters are also those of angles and chamfers.
_ROTARY = frozenset("ac")
#: Words of a line for the corner at its end, and those of mills.
_CORNERS = {"r": ",r", "i": ",c", "k": ",c"}


def turned(ip: Interpreter, block: Block) -> Block:
    """Return a block with X as a radius, distances as the place where they lead, and the corner of a line as ,R or ,C.

    Raises:
        BlockError: A place and a distance along the same axis, or an angle that does not lead to its end.
    """
    renamed, ip.distances = LATHES[ip.system], frozenset()
    if renamed and block.g:
        block = _in_system_a(ip, block, renamed)
    if block.words.keys().isdisjoint(_TURNED):
        return block
    rows = [row for number in block.g if (row := ip.codes.row("G", number)) is not None]
    if any(row.axis_words == "sizes" for row in rows):
        return block
    found = {letter: 0.5 * value if letter == "x" else value for letter, value in block.words.items()}
    if _G10 in block.g:
        return replace(block, words=found)
    # G80 ends a cycle, and makes no line of its block.
    motions = [row for row in rows if row.axes == "motion" or row.group == "canned cycle"]
    motion = motions[0] if motions else ip.codes.row("G", ip.state.motion)
    depth = motion.depth if motion is not None else ""
    if ip.steps and all(row.axis_words != "absolute" for row in rows):
        _step(ip, found, depth)
    _lead(ip, block, found, depth)
    in_force = ip.state.motion == _LINE and not motions and all(row.axes == "none" for row in rows)
    if _LINE in block.g or in_force:
        _corner(ip, block, found)
    ip.rotary |= found.keys() & _ROTARY
    return replace(block, words=found)


def _step(ip: Interpreter, words: dict[str, float], depth: str) -> None:
    """Turn words of places, which are distances under G91, into places; the bottom of a hole is a distance from R."""
    places = {letter: column for letter, column in _PLACES.items() if letter in words}
    ip.distances = frozenset(places.values())
    if depth and depth not in words and (axis := DISTANCES[depth][0]) in words:
        words[depth] = words.pop(axis) * (2.0 if depth == "u" else 1.0)
        places.pop(axis)
    for letter, column in places.items():
        words[letter] += ip.state.position[column]


def _lead(ip: Interpreter, block: Block, words: dict[str, float], depth: str) -> None:
    """Turn words of distances into places, but for the depth of a hole."""
    for letter in words.keys() & DISTANCES:
        axis, column = DISTANCES[letter]
        if axis in words:
            message = f"{axis.upper()} and {letter.upper()} both say where {axis.upper()} goes"
            of_mach3 = axis == "c" and 760 in block.g
            hint = "G76 with H and C is of Mach3 Turn, and not read" if of_mach3 else "write one of them"
            raise BlockError("axis-words-twice", message, letter.upper(), hint=hint)
        distance = words.pop(letter) * (0.5 if column == X else 1.0)
        if letter == depth:
            words[letter] = distance
        else:
            words[axis] = ip.state.position[column] + distance
            ip.distances |= {column}


def _in_system_a(ip: Interpreter, block: Block, renamed: dict[int, int]) -> Block:
    """Return a block with the numbers that system A has for its codes, and take up G90 and G91.

    Raises:
        BlockError: A code that the control's system has under another number.
    """
    for number in block.g:
        if number in displaced(ip.system):
            own = next(own for own, of_a in renamed.items() if of_a == number)
            message = f"G{number / 10:g} is a code of system A; {ip.system} has it as G{own / 10:g}"
            hint = "--dialect fanuc-lathe reads system A"
            raise BlockError("unknown-code", message, f"G{number / 10:g}", hint=hint)
    codes = tuple(renamed.get(number, number) for number in block.g)
    if LATHE_ABSOLUTE in codes or LATHE_STEPS in codes:
        ip.steps = LATHE_STEPS in codes
    return replace(block, g=codes)


def _corner(ip: Interpreter, block: Block, words: dict[str, float]) -> None:
    """Put the angle A of a line as its end, and R, I, K and C as the rounding or chamfer; a sign tells only the way."""
    angle = words.pop("a", words.pop(",a", None))
    if angle is not None:
        from cncgen.gcode.codes.drawing_dimensions import complete

        complete(ip, block, words, angle)
    if "c" in words and (angle is not None or not _is_axis(ip, block, words)):
        words[",c"] = abs(words.pop("c"))
    for letter, corner in _CORNERS.items():
        if letter in words and not (_G40 in block.g and corner == ",c"):
            words[corner] = abs(words.pop(letter))


def _is_axis(ip: Interpreter, block: Block, words: dict[str, float]) -> bool:
    """Tell whether C of a line is the axis C, and say so once; a chamfer stands beside X or Z alone, where C was not moved before."""
    size = words["c"]
    if "h" in block.words:
        return True
    axis = "c" in ip.rotary or ("x" in words) == ("z" in words)
    ip.base.block = block
    if axis:
        message, hint = f"C{size:g} of a line is the axis C", "a chamfer is ,C"
    else:
        message = f"C{size:g} of a line is taken as a chamfer, since the program has not moved an axis C"
        hint = "a chamfer is ,C beyond doubt; the axis C moves in a block of its own"
    ip.warn_once("other-control", message, "C", hint)
    return axis
