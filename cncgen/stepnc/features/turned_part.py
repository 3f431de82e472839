"""The profile of the part after all turned features of a program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.entities import Skip
from cncgen.stepnc.features.turned_bar import FAR
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.model import TURNING, Workingstep
from cncgen.stepnc.part21 import Exchange
from cncgen.stepnc.turned_shapes import feed_sense

Floats = NDArray[np.float64]

#: Distance of chords from arcs, mm.
CHORD = 1e-4


@dataclass(frozen=True, slots=True)
class _Cut:
    """A profile that one feature allows to cut, seen from the machine.

    Attributes:
        points: (z, r), z rising, shape (n, 2).
        below, above: Radius down to which everything before and behind it may be cut, mm, or infinite.
        demands: The profile as far as the nose of the tool reaches into its corners, or None where less may be cut.
        owner: The workingstep that cuts it, by name, and its source line.
    """

    points: Floats
    below: float
    above: float
    demands: Floats | None
    owner: tuple[str, int] = ("", 1)

    def floor(self, z: Floats) -> Floats:
        """Return the smallest radius that may be cut at places, mm; infinite where none may be."""
        return np.interp(z, self.points[:, 0], self.points[:, 1], left=self.below, right=self.above)

    def demanded(self, z: Floats) -> Floats:
        """Return the radius outside of which nothing may be left, mm; infinite where this feature says nothing."""
        if self.demands is None:
            return np.full(z.shape, np.inf)
        return np.interp(z, self.demands[:, 0], self.demands[:, 1], left=np.inf, right=np.inf)


@dataclass(frozen=True, slots=True)
class TurnedPart:
    """The material that all turned features of a program leave standing together."""

    cuts: tuple[_Cut, ...]

    @classmethod
    def of(cls, steps: Sequence[Workingstep], exchange: Exchange) -> TurnedPart | None:
        """Return what the features of workingsteps leave, None where one has no turned profile."""
        cuts = []
        for step in steps:
            if step.rapid or step.operation.kind == "probing":
                continue
            if step.feature is None or not step.operation.kind.startswith(TURNING):
                return None
            try:
                cut = _cut_of(step)
            except Skip:
                return None
            if cut is None:
                return None
            name = step.label or step.operation.label
            cuts.append(replace(cut, owner=(name, exchange.line(step.operation.ident))))
        return cls(tuple(cuts)) if cuts else None

    def floor(self, z: Floats) -> Floats:
        """Return the smallest radius that may be cut at places, mm; infinite where none may be."""
        return np.asarray(np.min([cut.floor(z) for cut in self.cuts], axis=0))

    def demanded(self, z: Floats) -> Floats:
        """Return the radius outside of which nothing may remain, mm; infinite without such a feature."""
        each = [cut.demanded(z) for cut in self.cuts]
        return np.asarray(np.min([np.full(z.shape, np.inf), *each], axis=0))

    def owner(self, z: float) -> tuple[str, int]:
        """Return the name and the source line of the workingstep that demands the smallest radius at a place."""
        return min(self.cuts, key=lambda cut: float(cut.demanded(np.array([z]))[0])).owner


def _cut_of(step: Workingstep) -> _Cut | None:
    """Return what a workingstep allows to cut; None without a profile outside of the work."""
    shape = step.feature.shape() if step.feature is not None else None
    if shape is None or shape.contour is None or shape.inside:
        return None
    chains = [polyline_of(p.moved(step.frame), CHORD).points[:, [2, 0]] for p in shape.contour]
    points = np.concatenate([chains[0][:1], *(c[1:] for c in chains)])
    points = points if points[0, 0] <= points[-1, 0] else points[::-1]
    kind, tool = step.operation.kind, step.operation.tool
    if kind.startswith("threading"):
        # The ridges of a thread stand on the core that is cut for it.
        return _Cut(points, np.inf, np.inf, None)
    left = step.operation.values.get("allowance", 0.0) > 0
    nose = (tool.nose or 0.0) if tool is not None else 0.0
    if kind.startswith("grooving"):
        return _Cut(points, np.inf, np.inf, None if left else _reached(points, nose, FAR, FAR))
    if np.ptp(points[:, 0]) < 1e-6:
        return _face(points, step, feed_sense(step, shape) > 0)
    backwards = feed_sense(step, shape) < 0
    low, high = (points[0, 1], np.inf) if backwards else (np.inf, points[-1, 1])
    demands = None if left else _reached(points, nose, min(low, FAR), min(high, FAR))
    return _Cut(points, low, high, demands)


def _face(points: Floats, step: Workingstep, front: bool) -> _Cut:
    """Return the region that facing may cut: everything before a face (behind it at the rear end of the bar), as far as its hub."""
    z, hub = float(points[0, 0]), float(points[:, 1].min())
    hair = 1e-9
    ends = np.array([[z - hair, FAR], [z, hub]]) if front else np.array([[z, hub], [z + hair, FAR]])
    below, above = (np.inf, hub) if front else (hub, np.inf)
    beside = 1e4 * (1 if above < np.inf else -1)
    demands = np.array([[z, hub], [z + beside, hub]])
    left = step.operation.values.get("allowance", 0.0) > 0 or step.operation.kind.startswith("contouring")
    return _Cut(ends, below, above, None if left or hub > 0 else demands[np.argsort(demands[:, 0])])


def _reached(points: Floats, nose: float, before: float, behind: float) -> Floats:
    """Return a profile with its corners as round as a nose leaves them, z rising, shape (n, 2).

    Before and behind it the work has the radii given, mm.
    """
    if nose <= 0:
        return points
    from shapely import Polygon

    low, high = float(points[0, 0]), float(points[-1, 0])
    far_low, far_high = low - FAR, high + FAR
    ring = [
        (far_low, -FAR),
        (far_low, before),
        (low, before),
        *points.tolist(),
        (high, behind),
        (far_high, behind),
        (far_high, -FAR),
    ]
    opened = Polygon(ring).buffer(nose, quad_segs=64).buffer(-nose, quad_segs=64)
    edge = np.array(opened.exterior.coords)
    inside = (edge[:, 0] > low - 1e-6) & (edge[:, 0] < high + 1e-6) & (edge[:, 1] > -FAR / 2)
    edge = edge[inside]
    return np.asarray(edge[np.argsort(edge[:, 0], kind="stable")])
