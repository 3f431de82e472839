"""BSPLINE of Siemens, as far as its format is published: a modal motion whose blocks give control points.

``BSPLINE X… Y… [PW=weight] [PL=interval] [SD=degree]``, then a control point a block, until another motion code. The
start point is the first control point. Weights are 0 to 3 (default 1), the degree is 2 or 3 (default 3). The curve
begins and ends tangentially to its polygon, so its end knots are of full multiplicity. It is not published how PL maps to the knots at
the ends. Here PL of the (degree + 1)-th and every later point is the length of the parameter interval that ends with it, 1 by default.
"""

from __future__ import annotations

from cncgen.gcode.block import AXES, BSPLINE, Block
from cncgen.gcode.codes.lines import check_feed, has_axis, inverse_rate
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Curve
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass, field

_MAX_WEIGHT = 3.0


@dataclass(slots=True)
class OpenSpline:
    """A curve whose end has not come yet."""

    degree: int
    points: list[list[float]]
    block: Block
    weights: list[float] = field(default_factory=lambda: [1.0])
    intervals: list[float] = field(default_factory=lambda: [1.0])


def point(ip: Interpreter, block: Block) -> None:
    """Take one control point."""
    state, words = ip.state, block.words
    state.motion = BSPLINE
    spline = state.spline
    if not isinstance(spline, OpenSpline):
        check_feed(ip, block, "BSPLINE")
        degree = words.get("sd", 3.0)
        if degree not in (2.0, 3.0):
            raise BlockError("spline-order", f"SD={degree:g} of BSPLINE: the degree is 2 or 3", "BSPLINE")
        spline = state.spline = OpenSpline(round(degree), [state.position.copy()], block)
        ip.guard = close
    if not has_axis(block):
        return
    weight, interval = words.get("pw", 1.0), words.get("pl", 1.0)
    if not 0.0 < weight <= _MAX_WEIGHT:
        message = f"PW={weight:g}: a weight is above 0 and at most {_MAX_WEIGHT:g}"
        raise BlockError("nurbs-weight", message, "PW")
    if interval < 0.0:
        raise BlockError("nurbs-knot", f"PL={interval:g} is negative", "PL")
    spline.block = block
    spline.points.append(ip.end_point(block))
    spline.weights.append(weight)
    spline.intervals.append(interval)
    state.position, state.moved = spline.points[-1], True


def close(ip: Interpreter, block: Block) -> None:
    """Hand the curve on where a block with another code begins."""
    spline = ip.state.spline
    if not isinstance(spline, OpenSpline) or not (block.g or block.m) or BSPLINE in block.g:
        return
    ip.state.spline = ip.guard = None
    degree, count = spline.degree, len(spline.points)
    if count <= degree:
        message = f"BSPLINE has {count} control points with its start; degree {degree} needs {degree + 1}"
        raise BlockError("nurbs-points", message)
    knots = [0.0] * (degree + 1)
    for interval in spline.intervals[degree:]:
        knots.append(knots[-1] + interval)
    knots += [knots[-1]] * degree
    ip.sink.block = spline.block
    ip.sink.nurbs_feed(Curve(degree, spline.points, spline.weights, knots, inverse_rate(ip)))


CODES = (
    Code("G", BSPLINE, "motion", Stage.MOTION, point, "B-spline of Siemens: a control point a block", AXES, "motion", summons=AXES,
        title="BSPLINE", named=("pw", "pl", "sd")),
)  # fmt: skip
