"""Affine frames of X Y Z, and the sink that takes motions through them: TRANS ROT SCALE MIRROR of SINUMERIK, cycles 7, 8, 10, 11 of Heidenhain.

A frame takes a programmed point to a point of the work coordinates: ``work = matrix point + shift``. Rotations by X Y Z are about Z,
the new Y and the new X (RPY, the usual setting of MD10600); RPL turns in the plane in force (840D sl, Fundamentals, "Frames").

While a tilted plane is milled the rotary axes that have turned to it stand still, so that a table or head carries the plane by a rigid
motion (`cncgen.machine.kinematics`): one more frame around those of the program. Arcs stay arcs, and the tool's radius is compensated as
in any plane. That frame depends on the origin and, of heads, on the tool's length, and is made anew where these change.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Curve, PassingSink, Point, Sink
from cncgen.gcode.state.modal import PLANE_AXES, in_plane, swept, to_machine, to_program, zeros
from cncgen.ranges import FACTORS
from cncgen.records import dataclass, field, replace

Matrix = tuple[tuple[float, float, float], ...]
Vector = tuple[float, float, float]
#: Positions of the machine's rotary axes, degrees, the carrying one first.
Positions = tuple[float, float]
#: The code of tool lengths under which the tip is followed, whatever the rotary axes do.
FOLLOWED = 43.4
UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
NO_SHIFT: Vector = (0.0, 0.0, 0.0)
#: Rounding moves an element of a matrix by less than this.
_TINY = 1e-12
#: The largest piece of a helix as a cubic, rad.
_HELIX_PIECE = math.radians(10.0)
#: A vector shorter than this has no direction, mm.
_SHORTEST = 1e-9


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product of two matrices."""
    # Written out, as below: loops that turn a frame in each round spent most of their time in sums over generators.
    x, y, z = (applied(a, column) for column in transposed(b))
    return of_columns(x, y, z)


def applied(a: Matrix, v: Vector) -> Vector:
    """Return a matrix times a vector."""
    x, y, z = v
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = a
    # The 0 makes a sum of zeros below 0 a plain one.
    return 0.0 + ax * x + ay * y + az * z, 0.0 + bx * x + by * y + bz * z, 0.0 + cx * x + cy * y + cz * z


def transposed(a: Matrix) -> Matrix:
    """Return a matrix with rows and columns exchanged: the inverse of a rotation."""
    return of_columns(*a)


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector that is square to two others."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit(vector: Vector, fault: BlockError) -> Vector:
    """Return a vector of length 1 in a direction; raise a fault where the vector has none."""
    length = math.hypot(*vector)
    if length < _SHORTEST:
        raise fault
    return vector[0] / length, vector[1] / length, vector[2] / length


def of_columns(x: Vector, y: Vector, z: Vector) -> Matrix:
    """Return the rotation that takes the axes to three directions."""
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


def turn(axis: int, degrees: float) -> Matrix:
    """Return the rotation about an axis (0 to 2), exact for right angles."""
    quarter = degrees / 90.0
    if quarter == round(quarter):
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
    else:
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    rows = [list(row) for row in UNIT]
    a, b = (axis + 1) % 3, (axis + 2) % 3
    rows[a][a], rows[a][b], rows[b][a], rows[b][b] = c, -s, s, c
    return tuple((r[0], r[1], r[2]) for r in rows)


def turn_about(axis: Vector, degrees: float) -> Matrix:
    """Return the rotation about a direction of length 1: ``c 1 + (1 - c) n n^T + s [n]x`` (Rodrigues), exact for right angles."""
    (c, _, _), (s, _, _), _ = turn(2, degrees)
    columns = []
    for k, unit_vector in enumerate(UNIT):
        around, along = cross(axis, unit_vector), (1.0 - c) * axis[k]
        x, y, z = (c * e + s * a + along * n for e, a, n in zip(unit_vector, around, axis, strict=True))
        columns.append((x, y, z))
    return of_columns(*columns)


def diagonal(a: float, b: float, c: float) -> Matrix:
    """Return the scaling of the axes by factors."""
    return (a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c)


def made(kind: str, values: dict[str, float]) -> Frame:
    """Return the frame that TRANS, ROT, SCALE or MIRROR of SINUMERIK makes of values of X Y Z; raise where a factor is 0."""
    x, y, z = (values.get(axis, 0.0) for axis in "XYZ")
    if kind == "TRANS":
        return Frame(shift=(x, y, z))
    if kind == "ROT":
        return Frame(product(product(turn(2, z), turn(1, y)), turn(0, x)))
    mirrored = kind == "MIRROR"
    a, b, c = ((-1.0 if axis in values else 1.0) if mirrored else values.get(axis, 1.0) for axis in "XYZ")
    if min(abs(a), abs(b), abs(c)) == 0.0:
        message = "SCALE has a factor of 0, which leaves nothing"
        raise BlockError("scale-missing", message, "SCALE", hint="SCALE alone ends the scaling")
    return Frame(diagonal(a, b, c))


@dataclass(frozen=True, slots=True)
class Frame:
    """An affine map of X Y Z; other axes stay."""

    matrix: Matrix = UNIT
    shift: Vector = NO_SHIFT

    @classmethod
    def about(cls, centre: Vector, matrix: Matrix) -> Frame:
        """Return a matrix about a centre, which stays where it is."""
        x, y, z = applied(matrix, centre)
        return cls(matrix, (centre[0] - x, centre[1] - y, centre[2] - z))

    def then(self, inner: Frame) -> Frame:
        """Return this frame with another within it."""
        x, y, z = applied(self.matrix, inner.shift)
        return Frame(
            product(self.matrix, inner.matrix), (x + self.shift[0], y + self.shift[1], z + self.shift[2])
        )

    def idle(self) -> bool:
        """Tell whether nothing is changed."""
        return self == Frame()

    def inverse(self) -> Frame:
        """Return the map back: rows of the matrix are orthogonal except for scaling, so the cofactors suffice."""
        m, det = self.matrix, self._determinant()
        rows = [
            [
                (
                    m[(j + 1) % 3][(i + 1) % 3] * m[(j + 2) % 3][(i + 2) % 3]
                    - m[(j + 1) % 3][(i + 2) % 3] * m[(j + 2) % 3][(i + 1) % 3]
                )
                / det
                for j in range(3)
            ]
            for i in range(3)
        ]
        back: Matrix = tuple((r[0], r[1], r[2]) for r in rows)
        x, y, z = applied(back, self.shift)
        return Frame(back, (-x, -y, -z))

    def factors(self) -> list[float]:
        """Return by how much the axes are scaled, and by how much the volume beside that: frames in frames may be flat."""
        m = self.matrix
        lengths = [math.hypot(*(row[k] for row in m)) for k in range(3)]
        return [*lengths, self._determinant() / math.prod(lengths) if all(lengths) else 0.0]

    def _determinant(self) -> float:
        m = self.matrix
        return sum(
            m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3])
            for i in range(3)
        )

    def to_work(self, point: Point) -> Point:
        """Return work coordinates of a programmed point."""
        x, y, z = applied(self.matrix, (point[0], point[1], point[2]))
        return [x + self.shift[0], y + self.shift[1], z + self.shift[2], *point[3:]]

    def to_programmed(self, point: Point) -> Point:
        """Return the programmed point of work coordinates."""
        return self.inverse().to_work(point)

    def in_plane(self, plane: int) -> float:
        """Return the factor by which an arc of a plane is scaled in that plane, negative where it turns the other way.

        It is 0 where the arc leaves its plane, or stops being an arc.
        """
        a, b, n = PLANE_AXES[plane]
        m = self.matrix
        if max(abs(m[n][a]), abs(m[n][b]), abs(m[a][n]), abs(m[b][n])) > _TINY:
            return 0.0
        det = m[a][a] * m[b][b] - m[a][b] * m[b][a]
        lengths = [math.hypot(m[a][k], m[b][k]) for k in (a, b)]
        if abs(lengths[0] - lengths[1]) > _TINY or abs(abs(det) - lengths[0] ** 2) > _TINY * lengths[0] ** 2:
            return 0.0
        return math.copysign(lengths[0], det)


@dataclass(frozen=True, slots=True)
class Frames:
    """The frames in force: that of CYCLE800, and the programmable one within it, of whose shift ATRANS and G59 made `added`.

    `axes` are the positions, degrees, to which CYCLE800 has turned the machine's rotary axes, the carrying one first; None where it has not.
    """

    swivelled: Frame = field(default_factory=Frame)
    programmable: Frame = field(default_factory=Frame)
    added: Vector = NO_SHIFT
    axes: Positions | None = None

    def whole(self) -> Frame:
        """Return both as one."""
        return self.swivelled.then(self.programmable)

    def shifted(self, column: int, value: float, *, added: bool) -> Frames:
        """Return frames with another shift of one axis: of the part that is added, or of the other one."""
        shift, parts = list(self.programmable.shift), list(self.added)
        shift[column] = value + (shift[column] - parts[column] if added else parts[column])
        if added:
            parts[column] = value
        frame = Frame(self.programmable.matrix, (shift[0], shift[1], shift[2]))
        return replace(self, programmable=frame, added=(parts[0], parts[1], parts[2]))


class FramedSink(PassingSink):
    """Passes calls on to `inner` with their positions in work coordinates; `at` is where the tool stands, in programmed ones."""

    def __init__(self, inner: Sink, frame: Frame, at: Point) -> None:
        super().__init__(inner)
        self.frame, self.at = frame, at

    def snapshot(self) -> object:
        """Return a key of this state."""
        return self.frame

    def _led(self, end: Point) -> Point:
        """Return work coordinates of where a motion leads, and stand there."""
        self.at = list(end)
        return self.frame.to_work(end)

    def straight_traverse(self, end: Point) -> None:
        self.inner.straight_traverse(self._led(end))

    def straight_feed(self, end: Point) -> None:
        self.inner.straight_feed(self._led(end))

    def straight_probe(self, end: Point) -> None:
        self.inner.straight_probe(self._led(end))

    def rigid_tap(self, end: Point, pitch: float) -> None:
        self.inner.rigid_tap(self.frame.to_work(end), pitch)

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Move; a mirrored arc turns the other way, one out of its plane becomes a spline through the same points."""
        scale = self.frame.in_plane(plane)
        a, b, n = PLANE_AXES[plane]
        if scale:
            centre = list(end)
            centre[a], centre[b] = first, second
            centre = self.frame.to_work(centre)
            turns = turns if scale > 0.0 else -turns
            self.inner.arc_feed(self._led(end), centre[a], centre[b], turns, plane)
            return
        made = self._spline if end[n] == self.at[n] else self._helix
        self.nurbs_feed(made(end, complex(first, second), turns, plane))

    def nurbs_feed(self, curve: Curve) -> None:
        """Move: control points are carried along, weights and knots stay."""
        self.at = list(curve.points[-1])
        self.inner.nurbs_feed(
            replace(curve, points=[self.frame.to_work(list(point)) for point in curve.points])
        )

    def place(self, position: Point) -> None:
        self.inner.place(self._led(position))

    def offsets_changed(self, position: Point) -> None:
        """Take a change of offsets: the tool has not moved, and its programmed position is another."""
        self.at = list(position)

    def _swept(self, end: Point, centre: complex, turns: int, plane: int) -> tuple[complex, float, float]:
        """Return the way from the centre of an arc to its start, the sense of turning, 1 or -1, and the angle that is swept."""
        spoke = in_plane(self.at, plane) - centre
        if spoke == 0.0:  # behind an error, which left the tool in the centre
            message = "the arc begins in its centre"
            raise BlockError("arc-centre", message, hint="I J K lead from the start to the centre")
        return spoke, *swept(spoke, in_plane(end, plane) - centre, turns)

    def _helix(self, end: Point, centre: complex, turns: int, plane: int) -> Curve:
        """Return a helix as a B-spline of degree 3, 10 degrees a piece at most, off its cylinder by 5e-10 of the radius and off its height by 2e-6 of the pitch.

        No rational spline is a helix. A cubic that is tangent to the circle at its ends, and passes through it half way, is off by
        2.7e-4 (sweep / 90 degrees)^6 of the radius (Goldapp, "Approximation of circular arcs by cubic polynomials", 1991).
        """
        a, b, _ = PLANE_AXES[plane]
        spoke, spin, sweep = self._swept(end, centre, turns, plane)
        count = max(1, math.ceil(sweep / _HELIX_PIECE - 1e-9))
        step, start = sweep / count, self.at
        grip = 4.0 / 3.0 * math.tan(step / 4.0) * spin * 1j
        points, knots, here = [list(start)], [0.0] * 4, complex(start[a], start[b])
        for k in range(1, count + 1):
            on = centre + spoke * cmath.rect(1.0, spin * k * step)
            tip = complex(end[a], end[b]) if k == count else on
            places = (here + grip * (here - centre), tip - grip * (tip - centre), tip)
            for third, place in enumerate(places, -2):
                part = (k + third / 3.0) / count
                point = [s + part * (e - s) for s, e in zip(start, end, strict=True)]
                point[a], point[b] = place.real, place.imag
                points.append(point)
            knots += [float(k)] * (3 if k < count else 4)
            here = tip
        points[-1] = list(end)
        return Curve(3, points, (1.0,) * len(points), tuple(knots))

    def _spline(self, end: Point, centre: complex, turns: int, plane: int) -> Curve:
        """Return an arc as a rational B-spline of degree 2, a piece a third of a turn at most (Piegl and Tiller, "The NURBS Book", 7.3)."""
        a, b, _ = PLANE_AXES[plane]
        spoke, spin, sweep = self._swept(end, centre, turns, plane)
        count = max(1, math.ceil(sweep / (2.0 * math.pi / 3.0) - 1e-9))
        half = sweep / count / 2.0
        points, weights, knots = [list(self.at)], [1.0], [0.0] * 3
        for k in range(1, count + 1):
            middle = centre + spoke * cmath.rect(1.0 / math.cos(half), spin * (2 * k - 1) * half)
            tip = (
                complex(end[a], end[b])
                if k == count
                else centre + spoke * cmath.rect(1.0, spin * 2 * k * half)
            )
            for place, weight in ((middle, math.cos(half)), (tip, 1.0)):
                point = list(end)
                point[a], point[b] = place.real, place.imag
                points.append(point)
                weights.append(weight)
            knots += [float(k)] * (2 if k < count else 3)
        return Curve(2, points, tuple(weights), tuple(knots))


class AffineSink(FramedSink):
    """A frame whose plane a table or head may carry; `program` is that of the program alone."""

    def __init__(self, inner: Sink, frame: Frame, at: Point, axes: Positions | None, whole: Frame) -> None:
        super().__init__(inner, whole, at)
        self.program, self._axes = frame, axes

    def renew(self, ip: Interpreter) -> None:
        """Carry the plane as the origin and the tool's length in force have it."""
        if self._axes is not None:
            self.frame = carried(ip, self._axes).then(self.program)


def carried(ip: Interpreter, axes: Positions | None) -> Frame:
    """Return the frame of a table or head whose axes stand there; none without kinematics, and where the tip is followed anyway."""
    kinematics = ip.options.kinematics
    if axes is None or kinematics is None or ip.state.length_code == FOLLOWED:
        return Frame()
    origin, rotation, g92, offset = ip.state.offsets()
    unit = ip.state.unit_mm
    x, y, z, *rest = to_machine(zeros(), origin, rotation, g92, zeros())
    place = kinematics.machine((x * unit, y * unit, z * unit), axes, offset[2] * unit)
    x, y, z, *_ = to_program([*(value / unit for value in place), *rest], origin, rotation, g92, offset)
    return Frame(transposed(kinematics.table_plane(axes)), (x, y, z))


def check_factors(factors: list[float], word: str) -> None:
    """Raise where a frame scales by more, or by less, than leaves digits on the way there and back.

    Raises:
        BlockError: A factor is not within `cncgen.ranges.FACTORS`.
    """
    least, most = FACTORS
    wrong = next((factor for factor in factors if not least <= abs(factor) <= most), None)
    if wrong is not None:
        message = f"the frame scales by {wrong:g}, which is not within {least:g} to {most:g}"
        raise BlockError("number-range", message, word, hint="factors of frames in frames multiply")


def stand(ip: Interpreter, frame: Frame, sink: Callable[[Sink, Point], FramedSink] | None) -> None:
    """Put a frame in force by a sink before that of the run, or none; the tool stays where it is in work coordinates.

    Raises:
        BlockError: Cutter compensation is on.
    """
    if ip.state.compensation != 40:
        message = "a frame cannot change under cutter compensation"
        raise BlockError("frame-compensation", message, "", hint="use G40")
    framed = ip.sink if isinstance(ip.sink, FramedSink) else None
    work = framed.frame.to_work(ip.state.position) if framed else ip.state.position
    inner = framed.inner if framed else ip.sink
    ip.state.position = frame.to_programmed(work)
    ip.sink = sink(inner, list(ip.state.position)) if sink else inner


def change(ip: Interpreter, frame: Frame, axes: Positions | None = None, *, stays: bool = False) -> None:
    """Put another frame in force, carried by rotary axes at positions; one that changes nothing counts as none, unless it stays.

    Raises:
        BlockError: Cutter compensation is on, or the frame scales by more or less than it may.
    """
    whole = carried(ip, axes).then(frame)
    idle = frame.idle() and axes is None and not stays
    check_factors(frame.factors(), "")
    stand(ip, whole, None if idle else lambda inner, at: AffineSink(inner, frame, at, axes, whole))
