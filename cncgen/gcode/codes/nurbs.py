"""G6.2 (G06.2): FANUC's NURBS interpolation (Series 15i/150i manual B-63324EN, section 4.9).

``G6.2 [P] K X… [R] [F]``, then a control point a block ``K X… [R]``, then as many blocks of K alone as the rank P.
The i-th block holds the i-th control point and the i-th knot; the curve ends with the last knot.
"""

from __future__ import annotations

from cncgen.gcode.block import AXES, AXIS_INDEX, Block
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Curve
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass, field

#: Distance of the first control point from where the tool is that still counts as the same place.
START_TOLERANCE = 1e-4
_RANKS = (2, 3, 4)


@dataclass(slots=True)
class OpenCurve:
    """A curve whose last knot has not come yet; `broken` where an error was found in it already."""

    rank: int
    axes: frozenset[str]
    points: list[list[float]] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)
    knots: list[float] = field(default_factory=list)
    line: int = 0
    broken: bool = False


def curve(ip: Interpreter, block: Block) -> None:
    """Take one block of the curve."""
    state = ip.state
    state.motion = 62
    opening = 62 in block.g
    spline = state.spline
    if opening and isinstance(spline, OpenCurve):
        state.spline = None
        curve(ip, block)  # The block begins a curve of its own, whatever is wrong with the one before it.
        raise _unfinished(spline, "G6.2")
    if not isinstance(spline, OpenCurve):
        if not opening:
            message = "the curve has all its knots: a new one begins with G6.2"
            raise BlockError("nurbs-closed", message, next(iter(block.words)).upper())
        spline = state.spline = _open(ip, block)
    try:
        _take(ip, block, spline, opening)
    except BlockError:
        spline.broken = True
        raise


def _open(ip: Interpreter, block: Block) -> OpenCurve:
    """Begin a curve; a wrong first block begins one too, so that its other blocks are not faults of their own."""
    state = ip.state
    axes = frozenset(letter for letter in block.words if letter in AXES)
    rank = block.words.get("p", 4.0)
    counted = round(rank) if rank == round(rank) and rank > 0 else 4
    spline = OpenCurve(counted, axes, line=block.line)
    state.spline = spline
    ip.guard = check_finished
    try:
        if rank not in _RANKS:
            raise BlockError("nurbs-rank", f"P{rank:g} of G6.2: the rank is 2, 3 or 4 (degree + 1)", "P")
        if state.feed_mode != 94:
            message = f"G6.2 does not go with G{state.feed_mode}"
            raise BlockError("nurbs-mode", message, "G6.2", hint="use G94")
        if state.compensation != 40:
            message = "G6.2 does not go with cutter compensation"
            raise BlockError("nurbs-mode", message, "G6.2", hint="use G40")
        check_feed(ip, block, "G6.2")
    except BlockError:
        spline.broken = True
        raise
    return spline


def _take(ip: Interpreter, block: Block, spline: OpenCurve, opening: bool) -> None:
    words = block.words
    if "p" in words and not opening:
        raise BlockError("nurbs-rank", "P stands in the first block of G6.2 only", "P")
    if "k" not in words:
        raise BlockError("nurbs-knot", "no knot K in a block of G6.2", "G6.2" if opening else "")
    knot = words["k"]
    has_point = any(letter in AXIS_INDEX for letter in words)
    if spline.knots and knot < spline.knots[-1]:
        message = f"knot K{knot:g} is less than the one before it, K{spline.knots[-1]:g}"
        raise BlockError("nurbs-knot", message, "K")
    if has_point:
        _take_point(ip, block, spline, opening)
    elif opening:
        raise BlockError("nurbs-first-point", "the first block of G6.2 has no control point", "G6.2")
    elif "r" in words:
        raise BlockError("nurbs-weight", "a weight R in a block with no control point", "R")
    spline.knots.append(knot)
    if len(spline.knots) == len(spline.points) + spline.rank:
        _close(ip, spline)


def _take_point(ip: Interpreter, block: Block, spline: OpenCurve, opening: bool) -> None:
    state = ip.state
    words = block.words
    if len(spline.knots) > len(spline.points):
        message = f"a control point after {len(spline.knots) - len(spline.points)} of {spline.rank} knots that end the curve"
        raise BlockError(
            "nurbs-knots", message, next(letter for letter in words if letter in AXIS_INDEX).upper()
        )
    for letter in words:
        if letter in AXIS_INDEX and letter not in spline.axes and not spline.broken:
            message = f"{letter.upper()} does not stand in the first block of this G6.2"
            raise BlockError("nurbs-axes", message, letter.upper())
    weight = words.get("r", 1.0)
    if weight <= 0.0:
        raise BlockError("nurbs-weight", f"weight R{weight:g} must be above 0", "R")
    here = spline.points[-1] if spline.points else state.position
    point = list(here)
    for index, value in block.axes():
        point[index] = value if state.absolute else here[index] + value
    spline.points.append(point)
    spline.weights.append(weight)
    if opening:
        _check_first_point(point, state.position, spline.axes)


def _check_first_point(point: list[float], position: list[float], axes: frozenset[str]) -> None:
    gap = max(abs(p - q) for p, q in zip(point, position, strict=True))
    if gap > START_TOLERANCE:
        letter = max(axes, key=lambda a: abs(point[AXIS_INDEX[a]] - position[AXIS_INDEX[a]]))
        raise BlockError(
            "nurbs-first-point",
            f"the first control point must be where the tool is: {letter.upper()}{point[AXIS_INDEX[letter]]:g} "
            f"is {gap:.4f} away from {letter.upper()}{position[AXIS_INDEX[letter]]:g}",
            letter.upper(),
            hint="move there first",
            values={"gap": gap},
        )


def _close(ip: Interpreter, spline: OpenCurve) -> None:
    """Check the knots and hand the curve on."""
    state = ip.state
    state.spline = ip.guard = None
    if not spline.points:
        return
    end = spline.points[-1]
    state.position, state.moved = end, True
    if spline.broken:
        return
    _check_knots(spline)
    ip.sink.nurbs_feed(Curve(spline.rank - 1, spline.points, spline.weights, spline.knots))


def _check_knots(spline: OpenCurve) -> None:
    """Raise where the ends are not `rank`-fold, a knot inside is more than that, or is that and parts the curve."""
    rank, knots = spline.rank, spline.knots
    count = len(spline.points)
    if count < rank:
        raise BlockError("nurbs-points", f"{count} control points are too few for a curve of rank {rank}", "")
    if knots[0] != knots[rank - 1] or knots[-1] != knots[-rank]:
        at_start = knots[0] != knots[rank - 1]
        place = "first" if at_start else "last"
        shown = ", ".join(f"{k:g}" for k in (knots[:rank] if at_start else knots[-rank:]))
        raise BlockError("nurbs-end-knots", f"the {place} {rank} knots must be equal, not {shown}", "K")
    if knots[rank - 1] == knots[-rank]:
        raise BlockError("nurbs-end-knots", f"all knots are {knots[0]:g}: the curve has no length in K", "K")
    for i in range(len(knots) - rank):
        if knots[i] == knots[i + rank]:
            message = f"the knot K{knots[i]:g} stands more than {rank} times, the rank of the curve"
            raise BlockError("nurbs-equal-knots", message, "K")
    for i in range(rank, count):
        # The curve before these knots ends in one control point, the curve after them begins in the next one.
        gap = max(abs(p - q) for p, q in zip(spline.points[i - 1], spline.points[i], strict=True))
        if knots[i] == knots[i + rank - 1] and gap > START_TOLERANCE:
            message = f"{rank} equal knots K{knots[i]:g} part the curve: it goes on {gap:.4f} away"
            raise BlockError("nurbs-equal-knots", message, "K", values={"gap": gap})


def _unfinished(spline: OpenCurve, word: str) -> BlockError:
    missing = len(spline.points) + spline.rank - len(spline.knots)
    message = f"the G6.2 of line {spline.line} is not finished: {missing} of {spline.rank} knots that end it are missing"
    return BlockError("nurbs-unfinished", message, word, hint=f"end it with {spline.rank} blocks of K alone")


def check_finished(ip: Interpreter, block: Block) -> None:
    """Raise (and drop the curve) where a curve is open and the block does not belong to it."""
    spline = ip.state.spline
    if not isinstance(spline, OpenCurve) or 62 in block.g:
        return
    foreign = "G" if block.g else "M" if block.m else ""
    foreign = foreign or next((x.upper() for x in block.words if x not in "kr" and x not in AXIS_INDEX), "")
    if not foreign or foreign == "P":
        return
    ip.state.spline = ip.guard = None
    if spline.points:
        ip.state.position = spline.points[-1]
    ip.state.motion = 10
    if not spline.broken:
        raise _unfinished(spline, foreign)


CODES = (
    Code("G", 62, "motion", Stage.MOTION, curve, "NURBS: control points with knots K and weights R, then knots alone", AXES + "kpr",
        "motion", summons=AXES + "k"),
)  # fmt: skip
