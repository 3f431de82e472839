"""Direct drawing dimensions of FANUC's lathes: a line by its angle A and X or Z of its end (B-64304EN-1, 5.3).

The angle is counted from +Z towards +X, X as a radius. A line with A alone ends where it meets the line of the next block, which
has X, Z and its own A.
"""

from __future__ import annotations

import math

from cncgen.gcode.block import Block, evaluate, gather
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text.labels import Cursor

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

_X, _Z = 0, 2
#: Directions that differ by less than this are parallel; coordinates that differ by less are equal.
_TINY = 1e-9
#: How far beside its end a line may lead that has X, Z and A, in program units.
_BESIDE = 0.01
#: Lines without words that may stand before the next block.
_MOST_LINES = 50
_HINT = "give X and Z of its end"


def complete(ip: Interpreter, block: Block, words: dict[str, float], angle: float) -> None:
    """Put X (a radius) and Z of the end of a line into its words.

    Args:
        ip: The run; the line begins at its position.
        block: The block as it stands in the text.
        words: Its words, X as a radius, without A.
        angle: A, degrees.

    Raises:
        BlockError: The line does not reach X or Z, or the next block does not say where it ends.
    """
    z, x = ip.state.position[_Z], ip.state.position[_X]
    way = _direction(angle)
    if "x" in words and "z" in words:
        _check_both(ip, block, words, angle, (words["z"] - z) * way.imag - (words["x"] - x) * way.real)
    elif "x" in words:
        words["z"] = z + _share(words["x"] - x, way.imag, angle, "X") * way.real
    elif "z" in words:
        words["x"] = x + _share(words["z"] - z, way.real, angle, "Z") * way.imag
    else:
        words["z"], words["x"] = _meeting(ip, block, complex(z, x), way, angle)


def _direction(angle: float) -> complex:
    """Return the direction of an angle, exact for right angles."""
    quarter = angle / 90.0
    if quarter == round(quarter):
        return (1 + 0j, 1j, -1 + 0j, -1j)[round(quarter) % 4]
    return complex(math.cos(math.radians(angle)), math.sin(math.radians(angle)))


def _share(wanted: float, along: float, angle: float, axis: str) -> float:
    """Return how far a line goes until it has moved an axis as far as wanted."""
    if abs(along) > _TINY:
        return wanted / along
    if abs(wanted) <= _TINY:
        return 0.0
    message = f"a line at A{angle:g} does not change {axis}, and {axis} of its end is {wanted:g} away"
    raise BlockError("drawing-angle", message, "A", hint=_HINT)


def _check_both(ip: Interpreter, block: Block, words: dict[str, float], angle: float, beside: float) -> None:
    """Say where X, Z and A of one line do not go together; X and Z count."""
    if abs(beside) > _BESIDE:
        message = f"A{angle:g} leads {abs(beside):.3f} beside the end X{2.0 * words['x']:g} Z{words['z']:g}: the end counts"
        ip.base.block = block
        ip.warn("drawing-angle", message, "A", "leave A or one of X and Z out")


def _meeting(
    ip: Interpreter, block: Block, start: complex, way: complex, angle: float
) -> tuple[float, float]:
    """Return Z and X of where a line with A alone meets the line of the next block."""
    following = _following(ip, block)
    words = {} if following is None else following.words
    other = words.get("a", words.get(",a"))
    if other is None or "x" not in words or "z" not in words:
        message = f"a line at A{angle:g} without X and Z, and the next block has no X, Z and A of the line that it meets"
        raise BlockError("drawing-angle", message, "A", hint=_HINT)
    end, there = complex(words["z"], 0.5 * words["x"]), _direction(other)
    across = (way.conjugate() * there).imag
    if abs(across) <= _TINY:
        message = f"the lines at A{angle:g} and A{other:g} of two blocks are parallel: they do not meet"
        raise BlockError("drawing-angle", message, "A", hint=_HINT)
    place = start + way * (((end - start).conjugate() * there).imag / across)
    return place.real, place.imag


def _following(ip: Interpreter, block: Block) -> Block | None:
    """Return the next block of the text that has words, values computed."""
    if ip.flow is None:
        return None
    lines, here = ip.flow.lines, Cursor(block.source, block.offset, block.line)
    for _ in range(_MOST_LINES):
        here = lines.after(here)
        if here.offset >= len(ip.flow.subroutines.sources[here.source]):
            return None
        try:
            parsed = lines.parse(lines.text(here))
        except BlockError:
            return None
        if parsed.deletable and ip.options.block_delete:
            continue
        if parsed.words:
            return gather([(letter, evaluate(value, ip.parameters)) for letter, value in parsed.words])
        if parsed.flow is not None or parsed.settings:
            return None
    return None
