"""LinuxCNC's splines: G5 (cubic), G5.1 (quadratic), G5.2 … G5.3 (NURBS). All become B-splines, without lines.

G5 and G5.1 are not modal: as in LinuxCNC's interpreter, a later block of axis words alone has the previous motion mode.
"""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lines import check_feed, inverse_rate
from cncgen.gcode.codes.table import COMPENSATION, OF_LINUXCNC, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Curve
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass, field


@dataclass(slots=True)
class OpenNurbs:
    """Control points of a G5.2 block that has not ended yet.

    A `broken` one has its error already and makes no curve; where the first block is wrong (`lost`), the others are passed over.
    """

    order: int
    points: list[list[float]] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)
    broken: bool = False
    lost: bool = False


def _check_plane(ip: Interpreter, block: Block, name: str) -> None:
    if ip.state.plane != 17:
        raise BlockError("spline-plane", f"{name} works in the XY plane (G17) only", name)
    for letter in "zabcuvw":
        if letter in block.words:
            message = f"{name} moves X and Y only, not {letter.upper()}"
            raise BlockError("spline-axes", message, letter.upper())


def _pair(block: Block, letters: str, name: str) -> tuple[float, float]:
    given = [letter for letter in letters if letter in block.words]
    if len(given) < 2:
        both = " and ".join(letters.upper())
        raise BlockError("spline-words", f"{name} needs both {both}", given[0].upper() if given else name)
    return block.words[letters[0]], block.words[letters[1]]


def cubic(ip: Interpreter, block: Block) -> None:
    """G5 X Y I J P Q: I J from the start to its control point, P Q from the end to its own."""
    state = ip.state
    _check_plane(ip, block, "G5")
    check_feed(ip, block, "G5")
    if not block.words.keys().isdisjoint("ij"):
        first = _pair(block, "ij", "G5")
    elif state.cubic is not None and state.cubic[2] == state.position:
        # Without I J the curve goes on in the direction in which the last G5 ended.
        first = (-state.cubic[0], -state.cubic[1])
    else:
        ip.warn("spline-words", "G5 has no I and J, and no G5 comes before it: taken as 0", "G5")
        first = (0.0, 0.0)
    second = _pair(block, "pq", "G5")
    end = ip.end_point(block)
    start = state.position
    state.cubic = (*second, end)
    points = [
        start,
        [start[0] + first[0], start[1] + first[1], *start[2:]],
        [end[0] + second[0], end[1] + second[1], *end[2:]],
        end,
    ]
    ip.sink.nurbs_feed(Curve(3, points, (1.0,) * 4, (0.0,) * 4 + (1.0,) * 4, inverse_rate(ip)))
    state.position, state.moved = end, True


def quadratic(ip: Interpreter, block: Block) -> None:
    """G5.1 X Y I J: I J from the start to the control point."""
    state = ip.state
    _check_plane(ip, block, "G5.1")
    check_feed(ip, block, "G5.1")
    offset = _pair(block, "ij", "G5.1")
    end, start = ip.end_point(block), state.position
    middle = [start[0] + offset[0], start[1] + offset[1], *start[2:]]
    points = [start, middle, end]
    ip.sink.nurbs_feed(Curve(2, points, (1.0,) * 3, (0.0,) * 3 + (1.0,) * 3, inverse_rate(ip)))
    state.position, state.moved = end, True


def nurbs(ip: Interpreter, block: Block) -> None:
    """G5.2 P L X Y, then X Y P a control point: collected until G5.3."""
    state, spline = ip.state, ip.state.spline
    opening = 52 in block.g or not isinstance(spline, OpenNurbs)
    if opening or not isinstance(spline, OpenNurbs):
        # A wrong first block begins a curve too, so that its other blocks are not faults of their own.
        spline = state.spline = OpenNurbs(3, [state.position.copy()], [block.words.get("p", 1.0)])
        state.motion = 52
    if spline.lost:
        return
    try:
        _take(ip, block, spline, opening)
    except BlockError:
        spline.broken, spline.lost = True, opening
        raise


def _take(ip: Interpreter, block: Block, spline: OpenNurbs, opening: bool) -> None:
    _check_plane(ip, block, "G5.2")
    check_feed(ip, block, "G5.2")
    words, explicit = block.words, 52 in block.g
    if opening:
        if ip.state.compensation != 40:
            message = "G5.2 does not go with cutter compensation"
            raise BlockError("comp-refused", message, "G5.2", hint="use G40 before")
        order = words.get("l", 3.0)
        if order != round(order) or order < 2:
            message = f"L{order:g} of G5.2: the order of a curve is 2 or more, whole"
            raise BlockError("spline-order", message, "L")
        spline.order = round(order)
        if "x" not in words and "y" not in words:
            return
    _pair(block, "xy", "G5.2")
    weight = words.get("p", 1.0 if explicit else 0.0)
    if weight <= 0.0:
        message = (
            f"P{weight:g}: a weight must be above 0" if "p" in words else "a control point has no weight P"
        )
        hint = "write P1 where all control points weigh the same"
        raise BlockError("nurbs-weight", message, "P" if "p" in words else "X", hint=hint)
    spline.points.append(ip.end_point(block))
    spline.weights.append(weight)


def end_nurbs(ip: Interpreter, block: Block) -> None:
    """G5.3: the curve through G5.2 is complete."""
    state = ip.state
    spline = state.spline
    if not isinstance(spline, OpenNurbs):
        raise BlockError("spline-closed", "G5.3 ends a G5.2, and none is open", "G5.3")
    state.spline = None
    state.motion = 10
    if spline.broken:
        return
    count, order = len(spline.points), spline.order
    if count < order:
        message = f"{count} control points are too few for a curve of order {order}"
        raise BlockError("nurbs-points", message, "G5.3")
    inner = count - order
    knots = [0.0] * order + [float(k) for k in range(1, inner + 1)] + [float(inner + 1)] * order
    ip.sink.nurbs_feed(Curve(order - 1, spline.points, spline.weights, knots, inverse_rate(ip)))
    state.position, state.moved = spline.points[-1], True


# G5.2 and G6.2 (`nurbs`) refuse by themselves, and pass over the other blocks of their curve.
_SPLINE = ("is a spline", COMPENSATION)
CODES = (
    Code("G", 50, "motion", Stage.MOTION, cubic, "cubic spline in XY", "xyzabcuvwijpq", "motion", dialects=OF_LINUXCNC, moves="XY",
        refused=_SPLINE),
    Code("G", 51, "motion", Stage.MOTION, quadratic, "parabola in XY", "xyzabcuvwij", "motion", dialects=OF_LINUXCNC, moves="XY",
        refused=_SPLINE),
    Code("G", 52, "motion", Stage.MOTION, nurbs, "NURBS in XY, to G5.3", "xyzabcuvwpl", "motion", dialects=OF_LINUXCNC, moves="XY"),
    Code("G", 53, "motion", Stage.MOTION, end_nurbs, "end of G5.2", "", "motion", dialects=OF_LINUXCNC),
)  # fmt: skip
