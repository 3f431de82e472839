"""The pieces of curves: polylines, arcs (helices too) and NURBS, that can be turned round and moved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.geometry.frames import Matrix, apply

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Polyline:
    """Straight lines through points, shape (n, 3), mm, n ≥ 2.

    `axes`, shape (n, 3), are unit vectors of the tool axis at the points, or None where it does not change.
    """

    points: Floats
    axes: Floats | None = None

    @property
    def start(self) -> Floats:
        """Return the first point."""
        return self.points[0]

    @property
    def end(self) -> Floats:
        """Return the last point."""
        return self.points[-1]

    def reversed(self) -> Polyline:
        """Return the same points the other way."""
        return Polyline(self.points[::-1], None if self.axes is None else self.axes[::-1])

    def moved(self, frame: Matrix) -> Polyline:
        """Return it as seen from outside a frame."""
        axes = None if self.axes is None else elementary.product(self.axes, frame[:3, :3].T)
        return Polyline(apply(frame, self.points), axes)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular arc or helix: from `start` by `sweep` rad about `normal` through `centre`, see `ArcTable`."""

    start: Floats
    end: Floats
    centre: Floats
    normal: Floats
    sweep: float

    def reversed(self) -> Arc:
        """Return the same arc the other way; the centre goes to the height of the new start."""
        rise = elementary.product(self.end - self.start, self.normal)
        return Arc(self.end, self.start, self.centre + rise * self.normal, -self.normal, self.sweep)

    def moved(self, frame: Matrix) -> Arc:
        """Return it as seen from outside a frame."""
        start, end, centre = apply(frame, np.stack([self.start, self.end, self.centre]))
        return Arc(start, end, centre, elementary.product(frame[:3, :3], self.normal), self.sweep)

    def points(self, fractions: Floats) -> Floats:
        """Return points, shape (n, 3), at fractions 0 to 1 of the sweep."""
        u = self.start - self.centre
        rise = elementary.product(self.end - self.start, self.normal)
        v = np.cross(self.normal, u)
        end_radius = elementary.length(self.end - rise * self.normal - self.centre)
        radius = elementary.length(u)
        growth = 1.0 + fractions * ((end_radius / radius if radius else 1.0) - 1.0)
        angle = fractions * self.sweep
        flat = np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v
        return self.centre + growth[:, None] * flat + (fractions * rise)[:, None] * self.normal


@dataclass(frozen=True, slots=True)
class Nurbs:
    """A rational B-spline, clamped: control points (n, 3) mm, weights (n,), knots (n + degree + 1,)."""

    degree: int
    control: Floats
    weights: Floats
    knots: Floats

    @property
    def start(self) -> Floats:
        """Return the first point."""
        return self.control[0]

    @property
    def end(self) -> Floats:
        """Return the last point."""
        return self.control[-1]

    def reversed(self) -> Nurbs:
        """Return the same curve the other way."""
        knots = (self.knots[0] + self.knots[-1]) - self.knots[::-1]
        return Nurbs(self.degree, self.control[::-1], self.weights[::-1], knots)

    def moved(self, frame: Matrix) -> Nurbs:
        """Return it as seen from outside a frame."""
        return replace(self, control=apply(frame, self.control))


Piece: TypeAlias = Polyline | Arc | Nurbs


def reverse(pieces: list[Piece]) -> list[Piece]:
    """Return a path of pieces the other way."""
    return [p.reversed() for p in reversed(pieces)]
