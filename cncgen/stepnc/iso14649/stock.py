"""The raw piece of a workpiece, as its outline across the axis of a feature."""

from __future__ import annotations

import math

import numpy as np

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.frames import Matrix, Placements, apply
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.geometry.solids import Solid, solid_of

#: Workpieces, each made of the next.
_MOST_MADE = 50


class RawPieces:
    """Reads bounding geometries: BLOCK, RIGHT_CIRCULAR_CYLINDER and B-reps (ISO 14649-10, WORKPIECE)."""

    def __init__(self, entities: Entities, placements: Placements) -> None:
        self.entities = entities
        self.placements = placements
        self._solids: dict[int, Solid | None] = {}

    def solid(self, workpiece_id: int | None) -> Solid | None:
        """Return the raw piece of a workpiece, in the workpiece's frame; None if not given, or of another shape.

        Raises:
            Skip: where the geometry has a fault.
        """
        workpiece = self.entities.optional(workpiece_id)
        if workpiece is None or workpiece.keyword != "WORKPIECE":
            return None
        if workpiece.id not in self._solids:
            self._solids[workpiece.id] = self._solid(workpiece)
        return self._solids[workpiece.id]

    def _solid(self, workpiece: Entity) -> Solid | None:
        """Return the bounding geometry of a workpiece's raw piece, else its shape, else the bounding geometry of the workpiece.

        The shape of the finished part does not count: the raw piece is larger.
        """
        raw = self.entities.optional(workpiece.ref("its_rawpiece"))
        given = [raw.ref(n) for n in ("its_bounding_geometry", "its_geometry")] if raw is not None else []
        for bounds in (*given, workpiece.ref("its_bounding_geometry")):
            solid = self._bounds(bounds, workpiece)
            if solid is not None:
                return solid
        return None

    def piece(self, workpiece_id: int | None, raw: bool = False, depth: int = 0) -> tuple[int, Solid] | None:
        """Return the first of the workpieces that one is made of, and its shape; None if it is not given.

        Args:
            workpiece_id: A workpiece.
            raw: Whether it is the raw piece of another: then its shape counts, not its bounding geometry alone.
            depth: Raw pieces before it.

        Raises:
            Skip: where the geometry has a fault.
        """
        workpiece = self.entities.optional(workpiece_id)
        if workpiece is None or workpiece.keyword != "WORKPIECE":
            return None
        if depth > _MOST_MADE:
            raise workpiece.fault("part21-cycle", "the workpiece is its own raw piece")
        found = self.piece(workpiece.ref("its_rawpiece"), True, depth + 1)
        if found is not None:
            return found
        for name in ("its_bounding_geometry", "its_geometry")[: 1 + raw]:
            solid = self._bounds(workpiece.ref(name), workpiece)
            if solid is not None:
                return workpiece.id, solid
        return None

    def _bounds(self, ident: int | None, workpiece: Entity) -> Solid | None:
        return (
            None if ident is None else solid_of(self.entities.get(ident, owner=workpiece.id), self.placements)
        )

    def parts(self) -> list[Solid]:
        """Return what bounds the finished parts whose shape the file has."""
        pieces = [self.entities.get(i.id) for i in self.entities.exchange.instances("WORKPIECE")]
        raws = {piece.ref("its_rawpiece") for piece in pieces}
        found = [self._bounds(p.ref("its_geometry"), p) for p in pieces if p.id not in raws]
        return [solid for solid in found if solid is not None]

    def outline(self, feature: Entity, placement: Matrix) -> list[Piece] | None:
        """Return the closed outline of a feature's raw piece in the feature's frame; None if not given.

        Args:
            feature: Has its_workpiece.
            placement: The feature's frame seen from the workpiece.

        Raises:
            Skip: where the geometry has a fault.
        """
        solid = self.solid(feature.ref("its_workpiece"))
        return None if solid is None else _seen(solid.moved(np.asarray(np.linalg.inv(placement), np.float64)))


def _seen(solid: Solid) -> list[Piece] | None:
    """Return the outline of a solid across Z; None for a cylinder that leans."""
    if solid.kind == "block":
        corners = apply(solid.frame, np.array(solid.size) * np.indices((2, 2, 2)).reshape(3, 8).T)
        return [_hull(corners[:, :2])]
    if abs(abs(solid.frame[2, 2]) - 1.0) > 1e-9:
        return None
    centre = np.array([solid.frame[0, 3], solid.frame[1, 3], 0.0])
    start = centre + np.array([solid.size[0], 0.0, 0.0])
    return [Arc(start, start, centre, np.array([0.0, 0.0, 1.0]), 2 * math.pi)]


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
