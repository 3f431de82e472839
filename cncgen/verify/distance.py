"""Distance between the setpoints and the programmed path, in both directions, place by place in their order.

Setpoints to path: every sample, and three places on the chord between two samples. Path to setpoints: every vertex
of the flattened path and places between them, against the chords of the setpoints: what was left out shows here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import nearest_ahead as kernel
from cncgen.verify.flatten import CHORD_MM, Polyline

Floats = NDArray[np.float64]

#: A distance is over its tolerance beyond this part of it (and beyond what flattening adds).
MARGIN = 1.001

#: Places on the chord between two samples (its start included).
_PER_CHORD = 4

#: Longest step along the path between two places that are looked at, as a multiple of the longest chord.
_PATH_STEPS = 4


@dataclass(frozen=True, slots=True)
class Distances:
    """Distances of places on one polyline from another, and what they are judged by.

    Attributes:
        distance: Shape (n,), mm.
        tolerance: Shape (n,), mm.
        segment: Shape (n,), the segment of the other polyline.
        place: Shape (n,), where on the first polyline: index of its vertex (setpoints: the sample).
    """

    distance: Floats
    tolerance: Floats
    segment: NDArray[np.int64]
    place: NDArray[np.int64]

    @property
    def excess(self) -> Floats:
        """Shape (n,): how far each distance is over its tolerance with the margin (negative: within)."""
        return self.distance - (self.tolerance * MARGIN + 2.0 * CHORD_MM)


def setpoints_to_path(setpoints: Floats, path: Polyline) -> Distances:
    """Return the distances of samples and chords, shape ((n - 1) `_PER_CHORD` + 1,), from the path."""
    points, place = _subdivided(setpoints, _PER_CHORD)
    step = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1)])
    unlimited = np.full(len(points), np.inf)
    found = _follow(points, path.points, unlimited, path.tolerance, step, float(path.tolerance.max()))
    return Distances(found[1], path.tolerance[found[0]], found[0], place)


def path_to_setpoints(setpoints: Floats, path: Polyline) -> Distances:
    """Return the distances of places on the path, in their order, from the chords of the setpoints."""
    points, place = _refined(path, setpoints)
    tolerance = np.maximum(
        path.tolerance[np.maximum(place - 1, 0)], path.tolerance[np.minimum(place, len(path) - 1)]
    )
    line = setpoints if len(setpoints) > 1 else np.repeat(setpoints, 2, axis=0)
    step = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1)])
    unlimited = np.full(len(line) - 1, np.inf)
    found = _follow(points, line, tolerance, unlimited, step, float(tolerance.max()))
    return Distances(found[1], tolerance, found[0], place)


def _follow(
    points: Floats,
    line: Floats,
    point_tolerance: Floats,
    segment_tolerance: Floats,
    step: Floats,
    widest: float,
) -> tuple[NDArray[np.int64], Floats]:
    """Run the kernel; the window is a few steps and tolerances long. Return segments and distances."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    segment, fraction, distance = (
        np.zeros(len(points), np.int64),
        np.zeros(len(points)),
        np.zeros(len(points)),
    )
    kernel.follow(
        np.ascontiguousarray(points),
        np.ascontiguousarray(line),
        along,
        np.ascontiguousarray(point_tolerance),
        np.ascontiguousarray(segment_tolerance),
        4.0 * step + 20.0 * widest,
        segment,
        fraction,
        distance,
    )
    return segment, distance


def _subdivided(points: Floats, parts: int) -> tuple[Floats, NDArray[np.int64]]:
    """Divide each chord into equal parts; return the points and the index of the chord's start."""
    if len(points) < 2:
        return points, np.zeros(len(points), np.int64)
    f = (np.arange(parts) / parts)[None, :, None]
    inner = (points[:-1, None] + f * (points[1:, None] - points[:-1, None])).reshape(-1, points.shape[1])
    place = np.concatenate([np.repeat(np.arange(len(points) - 1), parts), [len(points) - 1]])
    return np.concatenate([inner, points[-1:]]), place


def _refined(path: Polyline, setpoints: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return the path's vertices with places between, no farther apart than the longest chord allows.

    The index of each place is that of the vertex at the end of its segment.
    """
    chords = np.linalg.norm(np.diff(setpoints, axis=0), axis=1) if len(setpoints) > 1 else np.zeros(1)
    longest = max(float(chords.max()) * _PATH_STEPS, float(path.tolerance.min()))
    lengths = np.diff(path.lengths)
    parts = np.maximum(np.ceil(lengths / longest), 1).astype(np.int64)
    index = np.repeat(np.arange(len(parts)), parts)
    within = np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts) + 1
    f = (within / parts[index])[:, None]
    points = path.points[index] + f * (path.points[index + 1] - path.points[index])
    return np.concatenate([path.points[:1], points]), np.concatenate([[0], index + 1])
