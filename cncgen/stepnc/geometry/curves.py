"""Curves of an exchange structure as pieces, in the curve's own frame, mm.

Polylines (via-arc points too), lines, circles, ellipses, helices, B-splines of every form, trimmed and composite
curves. B-splines stay NURBS. Sources: ISO 10303-42 for the geometry; for HELIX, whose turns no attribute gives, the
rule that NIST's interpreter follows (as many turns as the rise over the pitch, rounded up).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry import splines
from cncgen.stepnc.geometry.frames import MAX_COORDINATE, Placements
from cncgen.stepnc.geometry.pieces import Arc, Nurbs, Piece, Polyline, reverse
from cncgen.stepnc.geometry.trimming import Trim, read_trims
from cncgen.stepnc.geometry.via_points import polyline_with_via_points

Floats = NDArray[np.float64]

#: How far from its circle an arc's end may lie, mm: real files are off by 1.3e-4 mm.
RADIUS_TOLERANCE = 2e-3
#: Gap between the segments of a composite curve that counts as none, mm.
GAP_TOLERANCE = 2e-3
#: Composite and trimmed curves within each other.
MAX_NESTING = 20
MAX_TURNS = 100_000
#: Pieces of one curve: segments may hold each other, and their number then grows with the power of the depth.
MAX_PIECES = 2_000_000

_SPLINES = (
    "B_SPLINE_CURVE",
    "RATIONAL_B_SPLINE_CURVE",
    "BEZIER_CURVE",
    "UNIFORM_CURVE",
    "QUASI_UNIFORM_CURVE",
)


class CurveReader:
    """Reads curves; lengths become mm by `scale`, plane angles rad by `angle`."""

    def __init__(self, entities: Entities, scale: float = 1.0, angle: float = math.pi / 180.0) -> None:
        self.entities = entities
        self.placements = Placements(entities, scale)
        self.scale = scale
        self.angle = angle
        self._open: list[int] = []
        self._reads = 0
        self._readers: dict[str, Callable[[Entity], list[Piece]]] = {
            "POLYLINE": self._polyline,
            "TRIMMED_CURVE": self._trimmed,
            "COMPOSITE_CURVE": self._composite,
            "CIRCLE": self._circle,
            "ELLIPSE": self._ellipse,
            "BOUNDED_PCURVE": self._unsupported,
        }

    def read(self, ident: int, owner: int | None = None) -> list[Piece]:
        """Return the pieces of a curve, end to end.

        Raises:
            Skip: where it cannot be made; why is reported.
        """
        entity = self.entities.get(ident, owner=owner)
        if ident in self._open:
            cycle = " → ".join(f"#{i}" for i in [*self._open, ident])
            raise entity.fault("part21-cycle", f"the curve contains itself: {cycle}")
        self._reads = self._reads + 1 if self._open else 0
        if len(self._open) >= MAX_NESTING or self._reads > MAX_PIECES // 10:
            self._reads = 0
            raise entity.fault(
                "stepnc-geometry", f"curves are nested more than {MAX_NESTING} deep, or too many"
            )
        self._open.append(ident)
        try:
            if any(entity.instance.part(k) or k in entity.keyword for k in _SPLINES):
                return [self._spline(entity)]
            return self._readers.get(entity.keyword, self._unsupported)(entity)
        finally:
            self._open.pop()

    def leans(self, ident: int) -> bool:
        """Tell whether a curve of directions leaves Z anywhere; of other curves than polylines it is not looked up."""
        exchange = self.entities.exchange
        if self.entities.keyword(ident) != "POLYLINE":
            return True
        points, plain = exchange.coordinates_of(exchange.links_of(exchange.row_of(ident)))
        length = np.linalg.norm(points, axis=1)
        return not plain.all() or bool((points[:, 2] < length * (1.0 - 1e-12)).any())

    def _unsupported(self, entity: Entity) -> list[Piece]:
        kind = (
            "is not bounded: it needs a TRIMMED_CURVE"
            if entity.keyword in ("LINE", "HELIX")
            else "cannot be read"
        )
        raise entity.fault("stepnc-unsupported", f"this curve {kind}")

    # Polylines

    def _polyline(self, entity: Entity) -> list[Piece]:
        exchange = self.entities.exchange
        ids = exchange.links_of(exchange.row_of(entity.id))
        points, plain = exchange.coordinates_of(ids)
        if len(ids) < 2:
            raise entity.fault("stepnc-geometry", f"a polyline needs two points or more, and has {len(ids)}")
        if np.abs(points).max() > MAX_COORDINATE:
            raise entity.fault("stepnc-range", f"a coordinate is beyond ±{MAX_COORDINATE:g}")
        if not plain.all():
            return self._slow_polyline(entity, ids.tolist())
        return [Polyline(points * self.scale if self.scale != 1.0 else points)]

    def _slow_polyline(self, entity: Entity, ids: list[int]) -> list[Piece]:
        kinds = [self.entities.keyword(i) for i in ids]
        points = np.stack([self.placements.point(i, entity.id) for i in ids])
        if "VIA_HELIX_POINT" in kinds:
            raise entity.fault("stepnc-unsupported", "via points of helices cannot be read")
        via = np.array([k == "VIA_ARC_POINT" for k in kinds])
        return polyline_with_via_points(entity, points, via)

    # Conics

    def _frame(self, entity: Entity) -> tuple[Floats, Floats, Floats, Floats]:
        """Return origin and axes of the position of a conic."""
        frame = self.placements.placement(entity.entity("position").id, entity.id)
        return frame[:3, 3], frame[:3, 0], frame[:3, 1], frame[:3, 2]

    def _radius(self, entity: Entity, name: str = "radius") -> float:
        radius = entity.number(name) * self.scale
        if not 0 < radius <= MAX_COORDINATE:
            raise entity.fault(
                "stepnc-geometry", f"{name} is {radius:g}, not positive and below {MAX_COORDINATE:g}"
            )
        return radius

    def _circle(self, entity: Entity) -> list[Piece]:
        origin, x, _, z = self._frame(entity)
        start = origin + self._radius(entity) * x
        return [Arc(start, start, origin, z, 2 * math.pi)]

    def _ellipse(self, entity: Entity) -> list[Piece]:
        origin, x, y, _ = self._frame(entity)
        a, b = self._radius(entity, "semi_axis_1"), self._radius(entity, "semi_axis_2")
        return [splines.ellipse_arc(origin, a * x, b * y, 0.0, 2 * math.pi)]

    # Trimmed curves

    def _trimmed(self, entity: Entity) -> list[Piece]:
        basis = entity.entity("basis_curve")
        trims = read_trims(entity, self.placements)
        forward = entity.flag("sense_agreement") is not False
        kind = basis.keyword
        if any(basis.instance.part(k) or k in kind for k in _SPLINES):
            return self._trimmed_spline(entity, basis, trims, forward)
        if kind == "LINE":
            return [self._trimmed_line(entity, basis, trims)]
        if kind == "CIRCLE":
            return [self._trimmed_circle(entity, basis, trims, forward)]
        if kind == "ELLIPSE":
            return [self._trimmed_ellipse(entity, basis, trims, forward)]
        if kind == "HELIX":
            return [self._trimmed_helix(entity, basis, trims)]
        if kind == "POLYLINE":
            return self._trimmed_polyline(entity, basis, trims, forward)
        raise entity.fault("stepnc-unsupported", f"a trimmed {kind} cannot be read")

    def _trimmed_line(self, entity: Entity, basis: Entity, trims: tuple[Trim, Trim]) -> Piece:
        """Return the line from trim to trim; sense_agreement is not asked, since real files have it wrong."""
        origin = self.placements.point(basis.entity("pnt").id, basis.id)
        vector = basis.entity("dir", "VECTOR")
        direction = self.placements.direction(vector.entity("orientation").id, vector.id)
        length = vector.number("magnitude") * self.scale
        ends = [
            t.point if t.point is not None else origin + (t.parameter or 0.0) * length * direction
            for t in trims
        ]
        return Polyline(np.stack(ends))

    def _trimmed_circle(
        self, entity: Entity, basis: Entity, trims: tuple[Trim, Trim], forward: bool
    ) -> Piece:
        origin, x, y, z = self._frame(basis)
        radius = self._radius(basis)
        ends = []
        for trim in trims:
            if trim.point is None:
                angle = (trim.parameter or 0.0) * self.angle
                ends.append(origin + radius * (math.cos(angle) * x + math.sin(angle) * y))
            else:
                self._on_circle(entity, trim.point, origin, z, radius)
                ends.append(trim.point)
        begin, end = (
            math.atan2(elementary.product(e - origin, y), elementary.product(e - origin, x)) for e in ends
        )
        sweep = _sweep(begin, end, forward, full=bool(elementary.length(ends[1] - ends[0]) < 1e-6))
        height = elementary.product(ends[0] - origin, z)
        return Arc(ends[0], ends[1], origin + height * z, z if forward else -z, sweep)

    def _on_circle(self, entity: Entity, point: Floats, origin: Floats, z: Floats, radius: float) -> None:
        arm = point - origin
        height = elementary.product(arm, z)
        found = float(elementary.length(arm - height * z))
        if abs(found - radius) > RADIUS_TOLERANCE:
            text = f"a trimming point lies {found:.4f} mm from the centre, the radius is {radius:.4f} mm: "
            raise entity.fault(
                "arc-radius", f"{text}difference {abs(found - radius):.4f} > {RADIUS_TOLERANCE} mm"
            )

    def _trimmed_ellipse(
        self, entity: Entity, basis: Entity, trims: tuple[Trim, Trim], forward: bool
    ) -> Piece:
        origin, x, y, _ = self._frame(basis)
        a, b = self._radius(basis, "semi_axis_1"), self._radius(basis, "semi_axis_2")
        angles = []
        for trim in trims:
            if trim.point is None:
                angles.append((trim.parameter or 0.0) * self.angle)
                continue
            u, v = (
                elementary.product(trim.point - origin, x) / a,
                elementary.product(trim.point - origin, y) / b,
            )
            if abs(math.hypot(u, v) - 1.0) * min(a, b) > RADIUS_TOLERANCE:
                off = abs(math.hypot(u, v) - 1.0) * min(a, b)
                raise entity.fault("arc-radius", f"a trimming point lies {off:.4f} mm off the ellipse")
            angles.append(math.atan2(v, u))
        sweep = _sweep(angles[0], angles[1], forward, full=_same_angle(angles[0], angles[1]))
        return splines.ellipse_arc(origin, a * x, b * y, angles[0], sweep if forward else -sweep)

    def _trimmed_helix(self, entity: Entity, basis: Entity, trims: tuple[Trim, Trim]) -> Piece:
        """Return a helix: turns and their sense follow from the rise between the trimming points and the pitch."""
        origin, x, y, z = self._frame(basis)
        radius, pitch = self._radius(basis), basis.number("pitch") * self.scale
        if trims[0].point is None or trims[1].point is None:
            raise entity.fault("stepnc-unsupported", "a helix is trimmed by points alone")
        start, end = trims[0].point, trims[1].point
        for point in (start, end):
            self._on_circle(entity, point, origin, z, radius)
        rise = float(elementary.product(end - start, z))
        turns = math.ceil(abs(rise / pitch) - 1e-9) if pitch else 0
        if not 1 <= turns <= MAX_TURNS:
            text = (
                f"a rise of {rise:g} mm with a pitch of {pitch:g} mm are {turns} turns, not 1 to {MAX_TURNS}"
            )
            raise entity.fault("stepnc-geometry", text)
        forward = rise * pitch > 0
        begin, stop = (
            math.atan2(elementary.product(e - origin, y), elementary.product(e - origin, x))
            for e in (start, end)
        )
        sweep = _sweep(begin, stop, forward, full=_same_angle(begin, stop)) + 2 * math.pi * (turns - 1)
        height = elementary.product(start - origin, z)
        return Arc(start, end, origin + height * z, z if forward else -z, sweep)

    def _trimmed_polyline(
        self, entity: Entity, basis: Entity, trims: tuple[Trim, Trim], forward: bool
    ) -> list[Piece]:
        """Return the part of a polyline between trims; sense_agreement is asked only where both ways lead there."""
        line = self._polyline(basis)[0]
        if not isinstance(line, Polyline):
            raise entity.fault("stepnc-unsupported", "a trimmed polyline with via points cannot be read")
        places = [_place_on(line.points, t) for t in trims]
        last = len(line.points) - 1
        closed = _closes(line)
        if not all(0 <= p <= last + 1e-9 for p in places) or (
            not closed and abs(places[0] - places[1]) < 1e-12
        ):
            text = (
                f"the trims {places[0]:g} and {places[1]:g} must be two places from 0 to {last}, one a line"
            )
            raise entity.fault("stepnc-geometry", text)
        begin, end = (min(p, float(last)) for p in places)
        if not closed:
            forward = begin < end
        begin, end = (begin, end) if forward else (end, begin)
        parts: list[Piece] = [_part_of(line, *s) for s in _stretches(begin, end, 0.0, last)]
        return parts if forward else reverse(parts)

    def _trimmed_spline(
        self, entity: Entity, basis: Entity, trims: tuple[Trim, Trim], forward: bool
    ) -> list[Piece]:
        curve = self._spline(basis)
        low, high = float(curve.knots[0]), float(curve.knots[-1])
        at = []
        for trim in trims:
            u, off = (
                (trim.parameter, 0.0) if trim.point is None else splines.nearest_parameter(curve, trim.point)
            )
            u = low if u is None else u
            if off > RADIUS_TOLERANCE or not low - 1e-9 <= u <= high + 1e-9:
                text = (
                    f"a trim lies {off:.4f} mm off the curve"
                    if off
                    else f"a trim at {u:g} lies outside the curve, {low:g} to {high:g}"
                )
                raise entity.fault("stepnc-geometry", text)
            at.append(min(max(u, low), high))
        begin, end = at if forward else at[::-1]
        if not begin < end and not _closes(curve):
            raise entity.fault(
                "stepnc-geometry", f"the curve is trimmed from {begin:g} to {end:g}: nothing is left"
            )
        parts: list[Piece] = [splines.cut(curve, *s) for s in _stretches(begin, end, low, high)]
        return parts if forward else reverse(parts)

    # Composite curves and splines

    def _composite(self, entity: Entity) -> list[Piece]:
        pieces: list[Piece] = []
        segments = entity.refs("segments")
        if not segments:
            raise entity.fault("stepnc-geometry", "a composite curve needs one segment or more, and has none")
        for ident in segments:
            segment = self.entities.get(ident, "COMPOSITE_CURVE_SEGMENT", owner=entity.id)
            part = self.read(segment.entity("parent_curve").id, segment.id)
            if segment.flag("same_sense") is False:
                part = reverse(part)
            if pieces:
                gap = float(elementary.length(part[0].start - pieces[-1].end))
                if gap > GAP_TOLERANCE:
                    text = f"the segment begins {gap:.4f} mm from the end of the one before it"
                    raise segment.fault("curve-gap", text)
            pieces.extend(part)
            if len(pieces) > MAX_PIECES:
                raise entity.fault("stepnc-geometry", f"the curve has more than {MAX_PIECES} pieces")
        return pieces

    def _spline(self, entity: Entity) -> Nurbs:
        """Return a B-spline of any form: knots given, or uniform, quasi-uniform, Bézier; with weights or without."""
        base = self._part(entity, *_SPLINES, "B_SPLINE_CURVE_WITH_KNOTS")
        ids = base.refs("control_points_list")
        degree = int(base.number("degree"))
        coordinates, plain = self.entities.exchange.coordinates_of(np.array(ids, np.int64))
        if len(ids) and np.abs(coordinates).max() > MAX_COORDINATE:
            raise entity.fault("stepnc-range", f"a coordinate is beyond ±{MAX_COORDINATE:g}")
        control = coordinates * self.scale
        for k in np.flatnonzero(~plain).tolist():
            control[k] = self.placements.point(ids[k], entity.id)
        if degree < 1 or degree > 25 or len(ids) <= degree:
            raise entity.fault(
                "stepnc-geometry",
                f"degree {degree} with {len(ids)} control points: a degree from 1 to 25 needs one point more than that",
            )
        knots = self._knots(entity, len(ids), degree)
        weights = self._weights(entity, len(ids))
        return splines.clamped(Nurbs(degree, control, weights, knots))

    def _part(self, entity: Entity, *kinds: str) -> Entity:
        found = [k for k in (*kinds,) if entity.instance.part(k)]
        return self.entities.get(entity.id, *found) if found else entity

    def _knots(self, entity: Entity, points: int, degree: int) -> Floats:
        if entity.instance.part("B_SPLINE_CURVE_WITH_KNOTS"):
            return self._given_knots(entity, points, degree)
        if entity.instance.part("UNIFORM_CURVE"):
            return splines.uniform_knots(points, degree)
        if entity.instance.part("BEZIER_CURVE") or (entity.instance.part("QUASI_UNIFORM_CURVE") is None):
            if (points - 1) % degree == 0:
                return splines.bezier_knots(points, degree)
            if entity.instance.part("BEZIER_CURVE"):
                text = (
                    f"{points} control points do not make a whole number of Bézier curves of degree {degree}"
                )
                raise entity.fault("stepnc-geometry", text)
            entity.warn("spline-knots", "no knots are given: they are taken as quasi-uniform")
        return splines.quasi_uniform_knots(points, degree)

    def _given_knots(self, entity: Entity, points: int, degree: int) -> Floats:
        part = self._part(entity, "B_SPLINE_CURVE_WITH_KNOTS")
        values = np.array(part.numbers("knots"))
        multiplicities = np.array(part.numbers("knot_multiplicities"), np.int64)
        if (
            len(values) != len(multiplicities)
            or (multiplicities < 1).any()
            or multiplicities.sum() > 10_000_000
        ):
            text = f"{len(values)} knots with {len(multiplicities)} multiplicities, which must be positive"
            raise entity.fault("spline-knots", text)
        knots = np.repeat(values, multiplicities)
        if len(knots) != points + degree + 1:
            text = (
                f"{len(knots)} knots; degree {degree} and {points} control points need {points + degree + 1}"
            )
            raise entity.fault("spline-knots", text)
        if (np.diff(values) <= 0).any() or knots[degree] >= knots[-degree - 1]:
            raise entity.fault("spline-knots", "the knots must increase")
        return knots

    def _weights(self, entity: Entity, points: int) -> Floats:
        record = entity.instance.part("RATIONAL_B_SPLINE_CURVE")
        if record is None:
            return np.ones(points)
        data = record.parameters[-1] if record.parameters else None
        weights = np.array(
            [float(w) for w in data if isinstance(w, int | float)] if isinstance(data, tuple) else []
        )
        if len(weights) != points or not (weights > 0).all():
            text = f"{len(weights)} weights of {points} control points; all must be positive"
            raise entity.fault("spline-weights", text)
        return weights


def _same_angle(one: float, other: float) -> bool:
    """Tell whether two angles, rad, are equal except for rounding and whole turns: an angle of π may be read as −π."""
    return abs(math.remainder(one - other, 2 * math.pi)) < 1e-7


def _sweep(begin: float, end: float, forward: bool, full: bool) -> float:
    """Return the angle, rad, from `begin` to `end` against the clock (else with it); 2π where they are the same."""
    if full:
        return 2 * math.pi
    return (end - begin if forward else begin - end) % (2 * math.pi) or 2 * math.pi


def _closes(curve: Polyline | Nurbs) -> bool:
    """Tell whether a curve ends where it begins."""
    return float(elementary.length(curve.end - curve.start)) <= GAP_TOLERANCE


def _stretches(begin: float, end: float, low: float, high: float) -> list[tuple[float, float]]:
    """Return the stretches of parameters from `begin` to `end` of a curve from `low` to `high`, in order.

    Where `end` is not after `begin` the curve is a closed one, whose parameters go round: it is gone along by way of the
    place where it closes (ISO 10303-42, trimmed_curve).
    """
    least = 1e-9 * (high - low)
    if end > begin:
        return [(begin, end)]
    return [(a, b) for a, b in ((begin, high), (low, end)) if b - a > least]


def _part_of(line: Polyline, begin: float, end: float) -> Polyline:
    """Return a polyline from one place to another, both in lines from its start, begin < end."""
    last = len(line.points) - 1
    at = np.concatenate([[begin], np.arange(math.floor(begin) + 1, math.ceil(end)), [end]])
    k = np.minimum(at.astype(int), last - 1)
    return Polyline(line.points[k] + (at - k)[:, None] * (line.points[k + 1] - line.points[k]))


def _place_on(points: Floats, trim: Trim) -> float:
    """Return where a trim is on a polyline, in lines from its start."""
    if trim.point is None:
        return trim.parameter or 0.0
    first, along = points[:-1], np.diff(points, axis=0)
    length2 = np.maximum((along**2).sum(axis=1), 1e-300)
    t = np.clip(((trim.point - first) * along).sum(axis=1) / length2, 0.0, 1.0)
    k = int(np.argmin(np.linalg.norm(first + t[:, None] * along - trim.point, axis=1)))
    return k + float(t[k])
