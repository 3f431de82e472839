"""Solids by their boundary (B-rep, ISO 10303-42 and -511): the box around them, or their cylinder.

The box holds vertices and edges, and the whole extent of spheres, tori and free-form surfaces, because these may bulge out between
edges. So it is never too small.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.frames import Matrix, Placements, apply
from cncgen.stepnc.part21 import Enumeration, Ref, Value

Floats = NDArray[np.float64]

#: Entities of a solid that is given by its boundary.
SOLIDS = (
    "MANIFOLD_SOLID_BREP",
    "BREP_WITH_VOIDS",
    "FACETED_BREP",
    "ADVANCED_BREP_SHAPE_REPRESENTATION",
    "FACETED_BREP_SHAPE_REPRESENTATION",
    "MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
    "SHELL_BASED_SURFACE_MODEL",
)
#: Entities without an extent of their own: placements, and surfaces that end at edges.
_FLAT = frozenset(
    [
        "AXIS2_PLACEMENT_3D",
        "PLANE",
        "CONICAL_SURFACE",
        "CYLINDRICAL_SURFACE",
        "SURFACE_OF_LINEAR_EXTRUSION",
        "SURFACE_OF_REVOLUTION",
    ]
)
#: Points of an edge that is a whole turn, and the coordinates that count as alike, mm.
TURN = 720
SAME = 1e-4


def bounds_of(solid: Entity, placements: Placements) -> tuple[Floats, Floats, float] | None:
    """Return the lowest and highest coordinates of a solid, shape (3,) each, mm, and its radius if it is round about Z, else 0.

    None where it has no extent.

    Raises:
        Skip: where a point of it is at fault.
    """
    chunks: list[Floats] = []
    round_ones: list[tuple[Matrix, float]] = []
    waiting, seen = [solid.id], set[int]()
    while waiting:
        ident = waiting.pop()
        instance = placements.entities.exchange.instance(ident)
        if ident in seen or instance is None:
            continue
        seen.add(ident)
        keywords = {part.keyword for part in instance.parts}
        values = instance.parts[0].parameters
        if "VERTEX_POINT" in keywords or "POLY_LOOP" in keywords:
            chunks.append(_points(placements, values))
        elif "EDGE_CURVE" in keywords:
            chunks.extend(_edge(placements, values))
        elif keywords & {"SPHERICAL_SURFACE", "TOROIDAL_SURFACE"}:
            chunks.append(_bulge(placements, values))
        elif any(k.startswith("B_SPLINE_SURFACE") or k == "BEZIER_SURFACE" for k in keywords):
            chunks += [_points(placements, part.parameters) for part in instance.parts]
        elif "CYLINDRICAL_SURFACE" in keywords:
            round_ones.append(
                (placements.placement(_refs(values)[0], ident), _number(values) * placements.scale)
            )
        elif not keywords & _FLAT and "CONTEXT" not in "".join(keywords):
            waiting += [r for part in instance.parts for r in _refs(part.parameters)]
    points = np.concatenate([np.zeros((0, 3)), *chunks])
    if not len(points) or not (np.ptp(points, axis=0) > 0).all():
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    return low, high, _radius(low, high, round_ones)


def _radius(low: Floats, high: Floats, cylinders: list[tuple[Matrix, float]]) -> float:
    """Return the radius of the cylinder along Z that fills a box, 0 where none does."""
    middle, half = (low + high) / 2, (high - low) / 2
    for frame, radius in cylinders:
        upright = abs(abs(float(frame[2, 2])) - 1.0) < 1e-9
        if (
            upright
            and np.abs(frame[:2, 3] - middle[:2]).max() < SAME
            and np.abs(half[:2] - radius).max() < SAME
        ):
            return radius
    return 0.0


def _refs(value: Value) -> list[int]:
    """Return all references in a value."""
    if isinstance(value, Ref):
        return [int(value)]
    return [r for v in value for r in _refs(v)] if isinstance(value, tuple) else []


def _number(values: Value) -> float:
    """Return the first number among values, 0 without one."""
    plain = [v for v in values if type(v) in (int, float)] if isinstance(values, tuple) else []
    return float(plain[0]) if plain and isinstance(plain[0], int | float) else 0.0


def _points(placements: Placements, values: Value) -> Floats:
    """Return the points that values refer to, shape (n, 3)."""
    entities: Entities = placements.entities
    idents = [r for r in _refs(values) if entities.keyword(r) == "CARTESIAN_POINT"]
    return np.array([placements.point(r) for r in idents]).reshape(-1, 3)


def _bulge(placements: Placements, values: tuple[Value, ...]) -> Floats:
    """Return the corners of the box round a sphere or torus."""
    frame = placements.placement(_refs(values)[0])
    reach = (
        sum(float(v) for v in values if type(v) in (int, float) and isinstance(v, int | float))
        * placements.scale
    )
    return np.stack([frame[:3, 3] - reach, frame[:3, 3] + reach])


def _edge(placements: Placements, values: tuple[Value, ...]) -> Iterator[Floats]:
    """Give the ends of an edge, and points along it where it is curved."""
    refs = _refs(values)
    entities = placements.entities
    vertices = [entities.get(r) for r in refs[:2]]
    ends = np.concatenate([_points(placements, v.parameters) for v in vertices])
    yield ends
    curve = entities.optional(refs[2]) if len(refs) > 2 else None
    while curve is not None and curve.keyword in ("SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE"):
        curve = entities.optional(next(iter(_refs(curve.parameters[1:2])), None))
    if curve is None or curve.keyword == "LINE":
        return
    if curve.keyword in ("CIRCLE", "ELLIPSE") and len(ends) == 2:
        forward = not any(isinstance(v, Enumeration) and v == "F" for v in values)
        yield _arc(placements, curve, ends if forward else ends[::-1])
    else:
        for part in curve.instance.parts:
            yield _points(placements, part.parameters)


def _arc(placements: Placements, curve: Entity, ends: Floats) -> Floats:
    """Return points of a circle or ellipse from one point to another against the clock; all round where they are one."""
    frame = placements.placement(_refs(curve.parameters)[0], curve.id)
    sizes = [
        float(v) * placements.scale
        for v in curve.parameters
        if type(v) in (int, float) and isinstance(v, int | float)
    ]
    across, up = sizes[0], sizes[-1]
    local = apply(np.asarray(np.linalg.inv(frame), np.float64), ends)
    begin, end = elementary.arctan2(local[:, 1] / up, local[:, 0] / across).tolist()
    sweep = (end - begin) % (2 * math.pi)
    if np.abs(ends[0] - ends[1]).max() < 1e-9:
        sweep = 2 * math.pi
    # The quarters have the extremes of a circle that is not turned.
    quarters = (
        math.pi
        / 2
        * np.arange(math.ceil(begin / (math.pi / 2)), math.floor((begin + sweep) / (math.pi / 2)) + 1)
    )
    angles = np.concatenate(
        [begin + np.linspace(0.0, sweep, max(int(TURN * sweep / (2 * math.pi)), 2)), quarters]
    )
    flat = np.column_stack([across * np.cos(angles), up * np.sin(angles), np.zeros(len(angles))])
    return apply(frame, flat)
