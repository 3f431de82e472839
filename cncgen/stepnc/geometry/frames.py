"""Placements as homogeneous matrices: column vectors, ``point_outside = M @ point_inside``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity

#: Largest coordinate, in the file's unit.
MAX_COORDINATE = 1e12

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]


def identity() -> Matrix:
    """Return the frame that changes nothing."""
    return np.eye(4)


def from_axes(origin: Vector, axis: Vector | None, reference: Vector | None) -> Matrix:
    """Return the frame of an AXIS2_PLACEMENT_3D (ISO 10303-42, clause 4.4.19).

    Z is `axis` (default (0, 0, 1)); X is the projection of `reference` onto the plane across it (default: of (1, 0, 0),
    or of (0, 1, 0) where Z is parallel to that); Y completes them.
    """
    z = np.array([0.0, 0.0, 1.0]) if axis is None else axis / elementary.length(axis)
    x = np.array([1.0, 0.0, 0.0]) if reference is None else reference / elementary.length(reference)
    x = x - (elementary.product(x, z)) * z
    if elementary.length(x) < 1e-9:
        x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
        x = x - (elementary.product(x, z)) * z
    x /= elementary.length(x)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, np.cross(z, x), z, origin
    return frame


def translation(x: float, y: float, z: float) -> Matrix:
    """Return the frame moved by (x, y, z) mm."""
    frame = np.eye(4)
    frame[:3, 3] = x, y, z
    return frame


def apply(frame: Matrix, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points, shape (n, 3), seen from outside the frame."""
    if np.array_equal(frame, np.eye(4)):
        return points
    return elementary.product(points, frame[:3, :3].T) + frame[:3, 3]


def is_identity(frame: Matrix, tolerance: float = 1e-9) -> bool:
    """Tell whether a frame changes nothing (mm, and components of unit vectors)."""
    return bool(np.abs(frame - np.eye(4)).max() <= tolerance)


class Placements:
    """Reads points, directions and placements; lengths become mm by `scale`."""

    def __init__(self, entities: Entities, scale: float = 1.0) -> None:
        self.entities = entities
        self.scale = scale

    def point(self, ident: int, owner: int | None = None) -> Vector:
        """Return a point, shape (3,), mm (a missing third coordinate is 0).

        Raises:
            Skip: where the entity is not a valid point.
        """
        entity = self.entities.get(ident, "CARTESIAN_POINT", "VIA_ARC_POINT", "VIA_HELIX_POINT", owner=owner)
        numbers = entity.numbers("coordinates")
        if not 1 <= len(numbers) <= 3:
            raise entity.fault("stepnc-geometry", f"a point has 1 to 3 coordinates, not {len(numbers)}")
        if max(map(abs, numbers)) > MAX_COORDINATE:
            raise entity.fault("stepnc-range", f"a coordinate is beyond ±{MAX_COORDINATE:g}")
        return np.array(numbers + [0.0] * (3 - len(numbers))) * self.scale

    def direction(self, ident: int, owner: int | None = None) -> Vector:
        """Return a unit vector, shape (3,).

        Raises:
            Skip: where the entity is not a direction, or its length is 0.
        """
        entity = self.entities.get(ident, "DIRECTION", owner=owner)
        numbers = entity.numbers("direction_ratios")
        vector = np.array((numbers + [0.0] * 3)[:3])
        vector = vector / max(float(np.abs(vector).max()), 1e-300)  # the square of a large ratio overflows
        length = elementary.length(vector)
        if not 2 <= len(numbers) <= 3 or not length > 1e-12 or not np.isfinite(length):
            raise entity.fault(
                "stepnc-geometry", f"a direction needs 2 or 3 ratios that are not all 0: {numbers}"
            )
        return vector / length

    def placement(self, ident: int, owner: int | None = None) -> Matrix:
        """Return the frame of an AXIS2_PLACEMENT_3D.

        Raises:
            Skip: where the entity is not a placement, or its directions are parallel.
        """
        entity = self.entities.get(ident, "AXIS2_PLACEMENT_3D", owner=owner)
        location = entity.ref("location")
        if location is None:
            raise entity.fault("stepnc-missing", "location must be given")
        axis, reference = entity.ref("axis"), entity.ref("ref_direction")
        z = self.direction(axis, entity.id) if axis is not None else None
        x = self.direction(reference, entity.id) if reference is not None else None
        if x is not None and elementary.length(np.cross(x, [0, 0, 1] if z is None else z)) < 1e-9:
            raise entity.fault("stepnc-geometry", "axis and ref_direction are parallel")
        return from_axes(self.point(location, entity.id), z, x)

    def optional(self, entity: Entity, name: str) -> Matrix | None:
        """Return the frame that an attribute refers to, None where it is missing.

        Raises:
            Skip: as `placement` raises it.
        """
        ident = entity.ref(name)
        return None if ident is None else self.placement(ident, entity.id)

    def plane(self, ident: int | None, owner: int | None = None) -> Matrix | None:
        """Return the frame of a PLANE (its Z is the normal), None where no id is given.

        Raises:
            Skip: where the entity is not a valid plane.
        """
        if ident is None:
            return None
        surface = self.entities.get(ident, "PLANE", "ELEMENTARY_SURFACE", owner=owner)
        return self.placement(surface.entity("position", "AXIS2_PLACEMENT_3D").id, surface.id)
