"""SPL, the cubic splines of Heidenhain's plain language.

```
7 L X+28.338 Y+19.385 Z-0.5 FMAX
8 SPL X24.875 Y15.924 Z-0.5 K3X-4.688E-002 K2X2.459E-002 K1X3.486E+000 K3Y… K2Y… K1Y… F10000
```

SPL is a cubic polynomial in each axis, ``X(t) = K3X t³ + K2X t² + K1X t + X`` with t from 1 to 0, so that the end is at
t = 0 (iTNC 530, "Spline interpolation"). It is a Bézier curve exactly, which becomes a B-spline. Its start may differ by 1 µm an axis
from where the tool is, its direction by 0.1 degrees from the spline before it.
"""

from __future__ import annotations

import math

from cncgen.gcode.block import AXES, AXIS_INDEX, Block, Own
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Curve
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass

DIALECT = "heidenhain"
#: The start of a spline may differ by this much from the last end, mm, and its direction by this, degrees.
START_TOLERANCE_MM = 0.001
KINK_DEGREES = 0.1

_COEFFICIENTS = tuple(f"k{power}{axis}" for axis in AXES for power in "123")


@dataclass(frozen=True, slots=True)
class Ended:
    """Where a spline ended, and in which direction."""

    place: list[float]
    heading: list[float]


def spline(ip: Interpreter, block: Block) -> None:
    """SPL: a cubic curve from where the tool is."""
    state, words = ip.state, block.words
    state.motion = 10
    check_feed(ip, block, "SPL")
    start, end = state.position, ip.end_point(block)
    points = [end.copy() for _ in range(4)]
    for axis, index in AXIS_INDEX.items():
        if axis not in words:
            if any(f"k{power}{axis}" in words for power in "123"):
                raise BlockError("spline-words", f"SPL has K of {axis.upper()}, but no {axis.upper()}", "SPL")
            continue
        k1, k2, k3 = (words.get(f"k{power}{axis}", 0.0) for power in "123")
        # Bézier points from t = 1 to t = 0.
        points[0][index] += k1 + k2 + k3
        points[1][index] += (2.0 * k1 + k2) / 3.0
        points[2][index] += k1 / 3.0
    gap = max(abs(p - q) for p, q in zip(points[0], start, strict=True)) * state.unit_mm
    if gap > START_TOLERANCE_MM * (1.0 + 1e-6):
        message = f"the spline begins {gap:.4f} mm from where the tool is, more than {START_TOLERANCE_MM} mm"
        hint = "K1 + K2 + K3 of an axis is the way from its end to its start"
        raise BlockError("spline-start", message, "SPL", hint=hint, values={"gap_mm": gap})
    points[0] = start.copy()
    _check_kink(ip, points)
    ip.sink.nurbs_feed(Curve(3, points, (1.0,) * 4, (0.0,) * 4 + (1.0,) * 4))
    state.position, state.moved = end, True
    state.cubic = None
    ip.last_spline_end = Ended(end, _heading(points[::-1]))


def _heading(points: list[list[float]]) -> list[float]:
    """Return the direction of a curve at its first point, backward where `points` are."""
    for point in points[1:]:
        way = [q - p for p, q in zip(points[0][:3], point[:3], strict=True)]
        if any(way):
            return way
    return [0.0, 0.0, 0.0]


def _check_kink(ip: Interpreter, points: list[list[float]]) -> None:
    """Remark where a spline does not go on in the direction of the one before it."""
    before = ip.last_spline_end
    if not isinstance(before, Ended) or before.place != ip.state.position:
        return
    a, b = [-v for v in before.heading], _heading(points)
    lengths = math.hypot(*a) * math.hypot(*b)
    if lengths == 0.0:
        return
    cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    angle = math.degrees(math.atan2(math.hypot(*cross), sum(p * q for p, q in zip(a, b, strict=True))))
    if angle > KINK_DEGREES:
        message = f"the spline turns by {angle:.3f} degrees from the one before it, more than {KINK_DEGREES}"
        ip.warn("spline-kink", message, "SPL")


CODES = (
    Code("G", Own.SPL, "motion", Stage.MOTION, spline, "cubic spline of Heidenhain: K3 K2 K1 of each axis, t from 1 to 0", AXES,
        "motion", title="SPL", named=_COEFFICIENTS, dialects=(DIALECT,)),
)  # fmt: skip
