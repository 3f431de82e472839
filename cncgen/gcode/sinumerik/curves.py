"""Curves of SINUMERIK: ASPLINE and CSPLINE through points, POLY by polynomials, CIP through an intermediate point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES, AXIS_INDEX
from cncgen.gcode.codes import affine
from cncgen.gcode.codes.lines import check_feed, inverse_rate
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinks.sink import Curve, Point

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words

_MOST_DEGREE = 5
_TINY = 1e-12


@dataclass(slots=True)
class OpenCurve:
    """A spline through points whose end has not come yet.

    Attributes:
        kind: ``ASPLINE`` or ``CSPLINE``.
        points: The first is where the tool was.
        steps: Length of the parameter between points: PL, else their distance.
    """

    kind: str
    points: list[Point]
    steps: list[float] = field(default_factory=list)

    def close(self, motions: Motions) -> None:
        """Hand the curve on, and stand at its end."""
        ip = motions.ip
        if not self.steps:
            return
        slopes = (_akima if self.kind == "ASPLINE" else _natural)(self.points, self.steps)
        ip.sink.nurbs_feed(_hermite(self.points, self.steps, slopes, inverse_rate(ip)))
        ip.state.position, ip.state.moved = list(self.points[-1]), True
        motions.heading = slopes[-1]


def point(motions: Motions, words: Words, end: Point) -> None:
    """Take a point of a spline, or make a polynomial."""
    if motions.motion == "POLY":
        _polynomial(motions, words, end)
        return
    ip = motions.ip
    if motions.curve is None:
        check_feed(ip, ip.sink.block, motions.motion)
        motions.curve = OpenCurve(motions.motion, [list(ip.state.position)])
    curve = motions.curve
    step = words.named.pop("PL", ("", math.dist(curve.points[-1], end)))[1]
    words.named.pop("PW", None)
    if step <= _TINY:
        return
    curve.points.append(list(end))
    curve.steps.append(step)
    # The next block's words count from here.
    ip.state.position = list(end)


def _secants(points: list[Point], steps: list[float]) -> list[Point]:
    return [
        [(b - a) / h for a, b in zip(p, q, strict=True)]
        for p, q, h in zip(points, points[1:], steps, strict=False)
    ]


def _akima(points: list[Point], steps: list[float]) -> list[Point]:
    """Return the slopes at the points by Akima (1970), "A new method of interpolation", JACM 17: weighted by the turns beside."""
    m = _secants(points, steps)
    first = [[2.0 * a - b for a, b in zip(m[0], m[min(1, len(m) - 1)], strict=True)]]
    last = [[2.0 * a - b for a, b in zip(m[-1], m[max(len(m) - 2, 0)], strict=True)]]
    begin = [[2.0 * a - b for a, b in zip(first[0], m[0], strict=True)], first[0]]
    end = [last[0], [2.0 * a - b for a, b in zip(last[0], m[-1], strict=True)]]
    m = [*begin, *m, *end]
    slopes = []
    for k in range(len(points)):
        w1, w2 = math.dist(m[k + 3], m[k + 2]), math.dist(m[k + 1], m[k])
        total = w1 + w2
        share = w1 / total if total > _TINY else 0.5
        slopes.append([share * a + (1.0 - share) * b for a, b in zip(m[k + 1], m[k + 2], strict=True)])
    return slopes


def _natural(points: list[Point], steps: list[float]) -> list[Point]:
    """Return the slopes of the cubic spline with continuous curvature; BNAT and ENAT at its ends: no curvature there.

    The rows are h_k m_(k-1) + 2 (h_(k-1) + h_k) m_k + h_(k-1) m_(k+1) = 3 (h_k s_(k-1) + h_(k-1) s_k) (de Boor, "A Practical
    Guide to Splines", chapter IV).
    """
    s, n = _secants(points, steps), len(points)
    low, mid, high, right = [0.0] * n, [2.0] * n, [0.0] * n, [[0.0] * 9 for _ in range(n)]
    high[0], right[0] = 1.0, [3.0 * v for v in s[0]]
    low[-1], right[-1] = 1.0, [3.0 * v for v in s[-1]]
    for k in range(1, n - 1):
        a, b = steps[k - 1], steps[k]
        low[k], mid[k], high[k] = b, 2.0 * (a + b), a
        right[k] = [3.0 * (b * u + a * v) for u, v in zip(s[k - 1], s[k], strict=True)]
    for k in range(1, n):
        factor = low[k] / mid[k - 1]
        mid[k] -= factor * high[k - 1]
        right[k] = [r - factor * q for r, q in zip(right[k], right[k - 1], strict=True)]
    slopes = [[0.0] * 9 for _ in range(n)]
    slopes[-1] = [r / mid[-1] for r in right[-1]]
    for k in range(n - 2, -1, -1):
        slopes[k] = [(r - high[k] * q) / mid[k] for r, q in zip(right[k], slopes[k + 1], strict=True)]
    return slopes


def _hermite(points: list[Point], steps: list[float], slopes: list[Point], rate: float | None) -> Curve:
    """Return the cubic pieces with these slopes as one B-spline with double knots."""
    control, knots, at = [list(points[0])], [0.0] * 4, 0.0
    for k, h in enumerate(steps):
        p, q = points[k], points[k + 1]
        control.append([a + h / 3.0 * v for a, v in zip(p, slopes[k], strict=True)])
        control.append([b - h / 3.0 * v for b, v in zip(q, slopes[k + 1], strict=True)])
        at += h
        knots += [at] * (2 if k < len(steps) - 1 else 4)
    control.append(list(points[-1]))
    return Curve(3, control, (1.0,) * len(control), tuple(knots), rate)


def _polynomial(motions: Motions, words: Words, end: Point) -> None:
    """POLY: PO[X]=(end, a2, a3 …), f(p) = a0 + a1 p + a2 p² + …, p from 0 to PL; a1 follows from the end."""
    ip = motions.ip
    check_feed(ip, ip.sink.block, "POLY")
    length = words.named.pop("PL", ("", 1.0))[1]
    if length <= 0.0:
        message = f"PL={length:g}, the length of an interval, must be above 0"
        raise BlockError("nurbs-knot", message, "PL", hint="PL is 1 where it is left out")
    start, finish = list(ip.state.position), list(end)
    coefficients: dict[int, list[float]] = {}
    degree = 1
    for axis, values in words.polynomials.items():
        column = AXIS_INDEX.get(axis.lower())
        if column is None:
            message = f"PO[{axis}] is of no axis"
            raise BlockError("axis-missing", message, "PO", hint="axes are X Y Z A B C U V W")
        if len(values) > _MOST_DEGREE:
            message = f"PO[{axis}] has degree {len(values)}; the most is {_MOST_DEGREE}"
            raise BlockError("spline-order", message, "PO", hint="leave the last ones out")
        if finish[column] != start[column]:
            raise BlockError(
                "repeated-word", f"{axis} and PO[{axis}] stand in one block", axis, hint="both give the end"
            )
        finish[column] = values[0] if motions.absolute else start[column] + values[0]
        coefficients[column] = values[1:]
        degree = max(degree, len(values))
    words.polynomials.clear()
    rows = [[0.0] * 9 for _ in range(degree + 1)]
    for column in range(9):
        higher = [c * length ** (k + 2) for k, c in enumerate(coefficients.get(column, []))]
        power = [start[column], finish[column] - start[column] - sum(higher), *higher]
        power += [0.0] * (degree + 1 - len(power))
        for k in range(degree + 1):
            rows[k][column] = sum(math.comb(k, i) / math.comb(degree, i) * power[i] for i in range(k + 1))
    weights = (1.0,) * (degree + 1)
    ip.sink.nurbs_feed(Curve(degree, rows, weights, (0.0,) * (degree + 1) + weights, inverse_rate(ip)))
    ip.state.position, ip.state.moved = finish, True
    motions.heading = [b - a for a, b in zip(rows[-2], rows[-1], strict=True)]


def through(motions: Motions, words: Words, given: dict[str, float], end: Point) -> None:
    """CIP: an arc through the point I1 J1 K1 to the end; in the plane in force, or in space."""
    start, middle = motions.ip.state.position, list(motions.ip.state.position)
    for letter, column in (("I1", 0), ("J1", 1), ("K1", 2)):
        if letter in words.named:
            mode, value = words.named.pop(letter)
            middle[column] = value * motions.scale("XYZ"[column], mode) + (
                start[column] if mode == "IC" or (mode == "" and not motions.absolute) else 0.0
            )
    first, second, normal = motions.plane()
    if not (start[normal] == middle[normal] == end[normal]):
        _in_space(motions, given, *((p[0], p[1], p[2]) for p in (start, middle, end)))
        return
    a, b, c = (complex(p[first], p[second]) for p in (start, middle, end))
    across = ((b - a).conjugate() * (c - a)).imag
    if abs(across) < 1e-9 * max(abs(b - a), abs(c - a), 1e-9) ** 2:
        raise _straight()
    u, v = b - a, c - a
    centre = a + 1j * (u * abs(v) ** 2 - v * abs(u) ** 2) / (2.0 * across)
    out = {**given, AXES[first]: c.real, AXES[second]: c.imag}
    out["ijk"[first % 3]], out["ijk"[second % 3]] = (centre - a).real, (centre - a).imag
    motions.emit(out, (30 if across > 0.0 else 20,))
    way = (1j if across > 0.0 else -1j) * (c - centre)
    motions.heading = [0.0] * 9
    motions.heading[first], motions.heading[second] = way.real, way.imag


def _straight() -> BlockError:
    message = "CIP: start, intermediate point and end lie in a line"
    return BlockError("arc-centre", message, "CIP", hint="I1 J1 K1 is a point of the arc")


def _in_space(
    motions: Motions, given: dict[str, float], a: affine.Vector, b: affine.Vector, c: affine.Vector
) -> None:
    """Make an arc that leaves the plane in force, as one in G17 of a frame whose X leads from the arc's centre to its start."""
    u, v = ((end[0] - a[0], end[1] - a[1], end[2] - a[2]) for end in (b, c))
    normal = affine.cross(u, v)
    square = sum(part * part for part in normal)
    if not 1e-9 * math.hypot(*u) * math.hypot(*v) < math.hypot(*normal) < math.inf > square:
        raise _straight()
    uu, vv = (sum(part * part for part in way) for way in (u, v))
    across, along = affine.cross(v, normal), affine.cross(normal, u)
    # From the centre to the start.
    i, j, k = (-(uu * p + vv * q) / (2.0 * square) for p, q in zip(across, along, strict=True))
    spoke = i, j, k
    x, z = (affine.unit(way, _straight()) for way in (spoke, normal))
    turned = affine.of_columns(x, affine.cross(z, x), z)
    frames = motions.frames
    plane = motions.ip.state.plane
    end_x, end_y, _ = affine.applied(affine.transposed(turned), c)
    # In that frame the spoke of the start lies along X, and Z stays.
    words = {"x": end_x, "y": end_y, "i": -math.hypot(*spoke), "j": 0.0}
    # A corner is of the plane in force, which the arc leaves.
    others = {axis: value for axis, value in given.items() if axis in "abcuvw"}
    size = next((word for word in (",r", ",c", ",h") if word in given), "")
    if size:
        message = "the arc of CIP leaves the plane in force: the corner at its end is left out"
        motions.ip.warn("corner-plane", message, "CIP", "a corner joins two motions in the plane")
    affine.change(motions.ip, frames.whole().then(affine.Frame(turned)), frames.axes)
    try:
        if plane != 17:
            motions.emit({}, (170,))
        motions.emit({**others, **words}, (30,))
    finally:
        if plane != 17:
            motions.emit({}, (10 * plane,))
        affine.change(motions.ip, frames.whole(), frames.axes)
    motions.heading = [*affine.cross(z, (i + v[0], j + v[1], k + v[2])), *[0.0] * 6]
