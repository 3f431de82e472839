"""Raw pieces: blocks and cylinders (BLOCK and RIGHT_CIRCULAR_CYLINDER of ISO 10303-42), and those round other solids."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry.breps import SOLIDS, bounds_of
from cncgen.stepnc.geometry.frames import Matrix, Placements, from_axes, translation

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Solid:
    """A raw piece: a block or a cylinder.

    Attributes:
        kind: ``block`` or ``cylinder``.
        frame: Of a block at its corner with the least coordinates, of a cylinder in the middle of its base, Z its axis.
        size: Of a block its lengths along X, Y and Z, mm; of a cylinder radius, radius and height.
    """

    kind: str
    frame: Matrix
    size: tuple[float, float, float]

    def same(self, other: Solid | None) -> bool:
        """Tell whether another solid is of the same kind, size and place."""
        alike = other is not None and (self.kind, self.size) == (other.kind, other.size)
        return alike and other is not None and bool((self.frame == other.frame).all())

    def values(self) -> dict[str, Any]:
        """Return kind, frame and size as plain values, for an event."""
        return {"kind": self.kind, "frame": self.frame.tolist(), "size": list(self.size)}

    def moved(self, frame: Matrix) -> Solid:
        """Return the solid seen from outside a frame."""
        return replace(self, frame=elementary.product(frame, self.frame))

    def reach(self, point: Vector, axis: Vector) -> tuple[float, float]:
        """Return how far it reaches from a point along a unit vector, lowest and highest, mm; both of shape (3,)."""
        along = elementary.product(self.frame[:3, :3].T, axis) * np.array(self.size)
        base = float(elementary.product(self.frame[:3, 3] - point, axis))
        if self.kind == "block":
            return base + float(np.minimum(along, 0.0).sum()), base + float(np.maximum(along, 0.0).sum())
        across = float(np.hypot(along[0], along[1]))
        return base + min(float(along[2]), 0.0) - across, base + max(float(along[2]), 0.0) + across


def solid_of(bounds: Entity, placements: Placements) -> Solid | None:
    """Return a BLOCK or RIGHT_CIRCULAR_CYLINDER, or what bounds a B-rep, None of another shape.

    Raises:
        Skip: where the geometry has a fault.
    """
    scale = placements.scale
    if bounds.keyword == "BLOCK":
        frame = placements.placement(bounds.entity("position").id, bounds.id)
        x, y, z = (bounds.number(n) * scale for n in "xyz")
        return Solid("block", frame, (x, y, z))
    if bounds.keyword == "RIGHT_CIRCULAR_CYLINDER":
        radius = bounds.number("radius") * scale
        base = bounds.entity("position")
        axis = base.ref("axis")  # AXIS1_PLACEMENT, which has a Z alone
        frame = from_axes(
            placements.point(base.entity("location").id, base.id),
            None if axis is None else placements.direction(axis, base.id),
            None,
        )
        return Solid("cylinder", frame, (radius, radius, bounds.number("height") * scale))
    if bounds.keyword in SOLIDS:
        found = bounds_of(bounds, placements)
        if found is None:
            return None
        low, high, radius = found
        x, y, z = (float(v) for v in high - low)
        if radius:
            return Solid("cylinder", translation(low[0] + x / 2, low[1] + y / 2, low[2]), (radius, radius, z))
        return Solid("block", translation(*low.tolist()), (x, y, z))
    return None
