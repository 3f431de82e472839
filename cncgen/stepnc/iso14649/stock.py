"""The raw piece of a workpiece, as its outline across the axis of a feature."""

from __future__ import annotations

import math

import numpy as np

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.frames import Matrix, Placements, apply, from_axes
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline


class Stock:
    """Reads bounding geometries: BLOCK and RIGHT_CIRCULAR_CYLINDER (ISO 14649-10, WORKPIECE)."""

    def __init__(self, entities: Entities, placements: Placements) -> None:
        self.entities = entities
        self.placements = placements

    def outline(self, feature: Entity, placement: Matrix) -> list[Piece] | None:
        """Return the closed outline of a feature's raw piece in the feature's frame; None where it is not given.

        Args:
            feature: Has its_workpiece.
            placement: The feature's frame seen from the workpiece.

        Raises:
            Skip: where the geometry has a fault.
        """
        workpiece = self.entities.optional(feature.ref("its_workpiece"))
        if workpiece is None or workpiece.keyword != "WORKPIECE":
            return None
        raw = self.entities.optional(workpiece.ref("its_rawpiece"))
        for piece in (raw, workpiece):
            bounds = piece.ref("its_bounding_geometry") if piece is not None else None
            if bounds is not None:
                return self._seen(
                    self.entities.get(bounds, owner=workpiece.id),
                    np.asarray(np.linalg.inv(placement), np.float64),
                )
        return None

    def _seen(self, solid: Entity, view: Matrix) -> list[Piece] | None:
        if solid.keyword == "BLOCK":
            place = view @ self.placements.placement(solid.entity("position").id, solid.id)
            size = np.array([solid.number(n) * self.placements.scale for n in "xyz"])
            corners = apply(place, size * np.indices((2, 2, 2)).reshape(3, 8).T)
            return [_hull(corners[:, :2])]
        if solid.keyword == "RIGHT_CIRCULAR_CYLINDER":
            base = solid.entity("position")
            axis = base.ref("axis")
            frame = view @ from_axes(
                self.placements.point(base.entity("location").id, base.id),
                None if axis is None else self.placements.direction(axis, base.id),
                None,
            )
            if abs(abs(frame[2, 2]) - 1.0) > 1e-9:
                return None
            radius = solid.number("radius") * self.placements.scale
            centre = np.array([frame[0, 3], frame[1, 3], 0.0])
            start = centre + np.array([radius, 0.0, 0.0])
            return [Arc(start, start, centre, np.array([0.0, 0.0, 1.0]), 2 * math.pi)]
        return None


def _hull(points: np.ndarray) -> Polyline:
    """Return the convex hull of points, shape (n, 2), against the clock and closed (A. M. Andrew, 1979)."""
    ordered = np.unique(np.round(points, 9), axis=0)

    def half(sequence: np.ndarray) -> list[np.ndarray]:
        chain: list[np.ndarray] = []
        for p in sequence:
            while len(chain) > 1:
                a, b = chain[-1] - chain[-2], p - chain[-2]
                if a[0] * b[1] - a[1] * b[0] > 1e-9:
                    break
                chain.pop()
            chain.append(p)
        return chain[:-1]

    ring = [*half(ordered), *half(ordered[::-1])]
    return Polyline(np.column_stack([np.stack([*ring, ring[0]]), np.zeros(len(ring) + 1)]))
