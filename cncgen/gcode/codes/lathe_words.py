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
#: Words of distances: the axis and its column.
_DISTANCES = {"u": ("x", X), "v": ("y", 1), "w": ("z", Z), "h": ("c", 5)}
_G10 = 100
#: Columns of the words that are distances under G91, and the codes, in tenths, whose X and Z are no motion: G50, G53.
_PLACES = {"x": X, "y": 1, "z": Z, "c": 5}
_AS_WRITTEN = frozenset((500, 530))
#: Codes, in tenths, whose X U W do not place the tool: G4, and the cycles whose U and W are depths or allowances.
_OTHER_WORDS = frozenset((40, 700, 710, 720, 730))
_LINE = 10
_MOTIONS = frozenset((0, 10, 20, 30, 320, 800, 900, 920, 940))
#: Cycles along Z and along X, whose W and U are counted from R.
_DRILLING = {**dict.fromkeys((810, 820, 830, 840, 850, 860), "w"), **dict.fromkeys((870, 880, 890), "u")}
#: Codes, in tenths, beside which a block makes no line even while G1 is in force.
_NO_LINES = frozenset(
    (
        0,
        20,
        30,
        71,
        1070,
        280,
        290,
        300,
        310,
        320,
        500,
        520,
        650,
        660,
        740,
        750,
        760,
        *range(800, 900, 10),
        900,
        920,
        940,
    )
)
#: Words of a line for the corner at its end, and those of mills.
_CORNERS = {"r": ",r", "i": ",c", "k": ",c"}


def turned(ip: Interpreter, block: Block) -> Block:
    """Return a block with X as a radius, distances as the place where they lead, and the corner of a line as ,R or ,C.

    Raises:
        BlockError: A place and a distance along the same axis, or an angle that does not lead to its end.
    """
    renamed = LATHES[ip.system]
    if renamed and block.g:
        block = _in_system_a(ip, block, renamed)
    words = block.words
    if not words.keys() & {"x", "z", "u", "v", "w", "a", "c", "h", ",a"} or not _OTHER_WORDS.isdisjoint(
        block.g
    ):
        return block
    found = dict(words)
    if "x" in found:
        found["x"] *= 0.5
    if _G10 in block.g:
        return replace(block, words=found)
    if ip.steps and _AS_WRITTEN.isdisjoint(block.g):
        for letter, column in _PLACES.items():
            if letter in found:
                found[letter] += ip.state.position[column]
    depth = next((_DRILLING[number] for number in block.g if number in _DRILLING), "")
    if not depth and _MOTIONS.isdisjoint(block.g):
        depth = _DRILLING.get(ip.state.motion, "")
    if "h" in found:
        ip.c_moves = True
    for letter, (axis, column) in _DISTANCES.items():
        if letter in found:
            if axis in found:
                message = f"{axis.upper()} and {letter.upper()} both say where {axis.upper()} goes"
                raise BlockError("axis-words-twice", message, letter.upper(), hint="write one of them")
            distance = found.pop(letter) * (0.5 if column == X else 1.0)
            if letter == depth:
                found[letter] = distance
            else:
                found[axis] = ip.state.position[column] + distance
    if _LINE in block.g or (ip.state.motion == _LINE and _NO_LINES.isdisjoint(block.g)):
        _corner(ip, block, found)
    elif "c" in found:
        ip.c_moves = True
    return replace(block, words=found)


def _in_system_a(ip: Interpreter, block: Block, renamed: dict[int, int]) -> Block:
    """Return a block with the numbers that system A has for its codes, and take up G90 and G91.

    Raises:
        BlockError: A code that the control's system has under another number.
    """
    for number in block.g:
        if number in displaced(ip.system):
            own = next(own for own, of_a in renamed.items() if of_a == number)
            message = f"G{number / 10:g} is a code of system A; {ip.system} has it as G{own / 10:g}"
            raise BlockError(
                "unknown-code", message, f"G{number / 10:g}", hint="--dialect fanuc-lathe reads system A"
            )
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
        if letter in words:
            words[corner] = abs(words.pop(letter))


def _is_axis(ip: Interpreter, block: Block, words: dict[str, float]) -> bool:
    """Tell whether C of a line is the axis C, and say so once; a chamfer stands beside X or Z alone, where C was not moved before."""
    size = words["c"]
    axis = ip.c_moves or ("x" in words) == ("z" in words)
    ip.base.block = block
    if axis:
        ip.c_moves = True
        message, hint = f"C{size:g} of a line is the axis C", "a chamfer is ,C"
    else:
        message = f"C{size:g} of a line is taken as a chamfer, since the program has not moved an axis C"
        hint = "a chamfer is ,C beyond doubt; the axis C moves in a block of its own"
    ip.warn_once(BlockError("other-control", message, "C", hint=hint))
    return axis
