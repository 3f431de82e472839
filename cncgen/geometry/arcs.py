"""Circular arcs, helices and the slight spirals that rounded radii make: points, derivatives, arc length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.tables import ArcTable, Floats

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = 0.5 + 0.5 * _NODES, 0.5 * _WEIGHTS
#: Part of an axis in the plane of an arc, of 1, below which that axis does not turn.
_FLAT = 1e-9


@dataclass(frozen=True, slots=True)
class Spirals:
    """Arcs with all that an evaluation needs, `m` rows; the angle θ runs from 0 to `sweep`.

    x(θ) = centre + (r + k θ)(cos θ e1 + sin θ e2) + ..., the rest linear in θ.

    Attributes:
        centre, e1, e2: Shape (m, 3): axis point and the frame in the plane of rotation, e1 towards the start.
        radius, growth: Shape (m,): r mm and k mm/rad.
        rise: Shape (m, axes): dx/dθ of the linear part: along the normal, and in the other axes.
        base: Shape (m, axes): the start of the linear part: 0 in X Y Z.
        sweep: Shape (m,), rad, positive.
        pitch: Shape (m,): |rise| in X Y Z, mm/rad.
        length: Shape (m,): arc length in X Y Z, mm.
    """

    centre: Floats
    e1: Floats
    e2: Floats
    radius: Floats
    growth: Floats
    rise: Floats
    base: Floats
    sweep: Floats
    pitch: Floats
    length: Floats

    def evaluate(self, arc: NDArray[np.int64], angle: Floats, order: int) -> Floats:
        """Return x, dx/dθ, … of arcs `arc` at angles; shape (order + 1, n, axes)."""
        cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
        outward = cos * self.e1[arc] + sin * self.e2[arc]
        along = cos * self.e2[arc] - sin * self.e1[arc]
        k = self.growth[arc][:, None]
        r = self.radius[arc][:, None] + k * angle[:, None]
        out = np.zeros((order + 1, len(arc), self.base.shape[1]))
        out[0] = self.base[arc] + angle[:, None] * self.rise[arc]
        out[0, :, :3] += self.centre[arc] + r * outward
        if order > 0:
            out[1] = self.rise[arc]
            out[1, :, :3] += k * outward + r * along
        if order > 1:
            out[2, :, :3] = 2.0 * k * along - r * outward
        if order > 2:
            out[3, :, :3] = -3.0 * k * outward - r * along
        return out

    def turning_points(self) -> tuple[NDArray[np.int64], Floats]:
        """Return where the turning part of x' has no part along X, Y or Z: which arc, and the angle there, shape (n,) each.

        r' = k outward + r along is √(k² + r²) times `along` at the angle θ − atan(k/r), whose component i is
        cos θ e2_i − sin θ e1_i.
        """
        first = elementary.arctan2(self.e2, self.e1) % np.pi
        count = np.maximum(np.ceil((self.sweep[:, None] - first) / np.pi), 0.0).astype(np.int64)
        count[np.hypot(self.e1, self.e2) < _FLAT] = 0
        at = np.repeat(np.arange(count.size), count.ravel())
        step = np.arange(len(at)) - np.repeat(np.cumsum(count) - count.ravel(), count.ravel())
        arc, angle = at // 3, first.ravel()[at] + np.pi * step
        angle += elementary.arctan2(self.growth[arc], self.radius[arc] + self.growth[arc] * angle)
        inside = (angle > 0.0) & (angle < self.sweep[arc])
        return arc[inside], angle[inside]

    def speed(self, arc: NDArray[np.int64], angle: Floats) -> Floats:
        """Return ds/dθ, mm/rad, shape (n,)."""
        return _speed(self.radius[arc], self.growth[arc], self.pitch[arc], angle)

    def length_to(self, arc: NDArray[np.int64], angle: Floats) -> Floats:
        """Return the arc length from the start to angles, shape (n,)."""
        return _length(self.radius[arc], self.growth[arc], self.pitch[arc], angle)

    def angle_at(self, arc: NDArray[np.int64], s: Floats) -> Floats:
        """Return the angles at arc lengths `s` from the start (proportional on a helix, else by Newton), shape (n,)."""
        length = self.length[arc]
        share = np.divide(s, length, out=np.zeros_like(s), where=length > 0)
        angle = self.sweep[arc] * share
        spiral = np.flatnonzero(self.growth[arc] != 0.0)
        if spiral.size:
            which = arc[spiral]
            for _ in range(6):
                miss = self.length_to(which, angle[spiral]) - s[spiral]
                step = miss / np.maximum(self.speed(which, angle[spiral]), 1e-300)
                angle[spiral] = np.clip(angle[spiral] - step, 0.0, self.sweep[which])
        return angle


def _speed(radius: Floats, growth: Floats, pitch: Floats, angle: Floats) -> Floats:
    return np.sqrt((radius + growth * angle) ** 2 + growth**2 + pitch**2)


def _length(radius: Floats, growth: Floats, pitch: Floats, angle: Floats) -> Floats:
    """Gauss-Legendre over the angle; the integrand hardly changes, for radii differ by a tolerance only."""
    total = sum(w * _speed(radius, growth, pitch, angle * x) for x, w in zip(_NODES, _WEIGHTS, strict=True))
    return angle * np.asarray(total)


def spirals(arcs: ArcTable, start: Floats, end: Floats) -> Spirals:
    """Return the arcs of a table between their points.

    Args:
        arcs: Shape m.
        start, end: Shape (m, axes), X Y Z first.
    """
    normal, sweep = arcs.normal, arcs.sweep
    if not len(arcs):
        plane, others = np.zeros((0, 3)), np.zeros((0, start.shape[1]))
        return Spirals(
            centre=plane,
            e1=plane,
            e2=plane,
            radius=sweep,
            growth=sweep,
            rise=others,
            base=others,
            sweep=sweep,
            pitch=sweep,
            length=sweep,
        )
    turn = np.where(sweep > 0, sweep, 1.0)
    inward = start[:, :3] - arcs.centre
    height = np.einsum("ij,ij->i", end[:, :3] - start[:, :3], normal)
    outer = end[:, :3] - arcs.centre - height[:, None] * normal
    radius, last = np.linalg.norm(inward, axis=1), np.linalg.norm(outer, axis=1)
    # Radii that agree to the rounding of the coordinates are one radius: the arc is then exactly a helix.
    reach = np.abs(np.concatenate([start[:, :3], end[:, :3], arcs.centre], axis=1)).max(axis=1)
    alike = np.abs(last - radius) <= 1e-12 * last + 4e-15 * reach
    growth = np.where(alike, 0.0, (last - radius) / turn)
    # An arc that starts on its axis takes its frame from the end, turned back.
    back = np.cos(sweep)[:, None] * outer - np.sin(sweep)[:, None] * np.cross(normal, outer)
    e1 = np.where((radius > 0)[:, None], inward, back)
    size = np.linalg.norm(e1, axis=1)[:, None]
    e1 = np.divide(e1, size, out=np.zeros_like(e1), where=size > 0)
    rise = (end - start) / turn[:, None]
    rise[:, :3] = normal * (height / turn)[:, None]
    base = start.copy()
    base[:, :3] = 0.0
    pitch = np.abs(height / turn)
    exact = sweep * np.sqrt(radius**2 + pitch**2)
    length = np.where(growth == 0.0, exact, _length(radius, growth, pitch, sweep))
    return Spirals(
        centre=arcs.centre,
        e1=e1,
        e2=np.cross(normal, e1),
        radius=radius,
        growth=growth,
        rise=rise,
        base=base,
        sweep=sweep,
        pitch=pitch,
        length=length,
    )
