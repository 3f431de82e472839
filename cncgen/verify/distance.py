"""Distance between the setpoints and the programmed path, in both directions, place by place in their order.

Setpoints to path: every sample, and three places on the chord between two samples. Path to setpoints: every vertex
of the flattened path and places between them, against the chords of the setpoints: what was left out shows here.
Both go block by block, so that what is looked at is never in memory as a whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import nearest_ahead as kernel
from cncgen.verify.flatten import CHORD_MM, Polyline

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A distance is over its tolerance beyond this part of it (and beyond what flattening adds).
MARGIN = 1.001

#: Places on the chord between two samples (its start included).
_PER_CHORD = 4

#: Longest step along the path between two places that are looked at, as a multiple of the longest chord.
_PATH_STEPS = 4

#: Chords, or segments of the path, that are looked at together.
_BLOCK = 65_536


@dataclass(frozen=True, slots=True)
class Distances:
    """Distances of places on one polyline from another.

    Attributes:
        largest: mm.
        worst: The distance that is most over its tolerance (or least within it), mm.
        tolerance: The tolerance there, mm.
        worst_place: Index of the sample, or of the path's segment, that it belongs to.
        worst_segment: The segment of the other polyline that it was matched with.
        over: Number of samples (or segments) with a distance over its tolerance.
        segment: Shape (places,): the segment that each sample (or segment) was matched with.
    """

    largest: float
    worst: float
    tolerance: float
    worst_place: int
    worst_segment: int
    over: int
    segment: Ints

    @property
    def broken(self) -> bool:
        """Tell whether a tolerance is broken."""
        return self.over > 0


@dataclass(slots=True)
class _Block:
    """Places that are looked at together: points, tolerance of each, and the index that each belongs to."""

    points: Floats
    tolerance: Floats
    place: Ints


def setpoints_to_path(setpoints: Floats, path: Polyline) -> Distances:
    """Return the distances of samples and chords from the path; places are samples."""
    widest = float(path.tolerance.max())
    blocks = _chord_blocks(setpoints)
    return _follow(blocks, len(setpoints), path.points, path.tolerance, widest)


def path_to_setpoints(setpoints: Floats, path: Polyline) -> Distances:
    """Return the distances of places on the path from the chords of the setpoints; places are segments."""
    line = setpoints if len(setpoints) > 1 else np.repeat(setpoints, 2, axis=0)
    chords = np.linalg.norm(np.diff(line, axis=0), axis=1)
    longest = max(float(chords.max()) * _PATH_STEPS, float(path.tolerance.min()))
    unlimited = np.full(len(line) - 1, np.inf)
    return _follow(_path_blocks(path, longest), len(path), line, unlimited, float(path.tolerance.max()))


def _chord_blocks(setpoints: Floats) -> Iterator[_Block]:
    """Divide each chord into equal parts; the last sample ends the last block."""
    f = (np.arange(_PER_CHORD) / _PER_CHORD)[None, :, None]
    for first in range(0, len(setpoints), _BLOCK):
        part = setpoints[first : first + _BLOCK + 1]
        inner = (part[:-1, None] + f * (part[1:, None] - part[:-1, None])).reshape(-1, part.shape[1])
        place = np.repeat(np.arange(first, first + len(part) - 1), _PER_CHORD)
        if first + _BLOCK >= len(setpoints):
            inner = np.concatenate([inner, setpoints[-1:]])
            place = np.append(place, len(setpoints) - 1)
        yield _Block(inner, np.full(len(inner), np.inf), place)


def _path_blocks(path: Polyline, longest: float) -> Iterator[_Block]:
    """Divide each segment of the path into parts of at most `longest`; the first block begins with the path's start.

    A vertex has the wider tolerance of its two segments.
    """
    for first in range(0, len(path), _BLOCK):
        stop = min(first + _BLOCK, len(path))
        vertices = path.points[first : stop + 1]
        parts = np.maximum(np.ceil(np.linalg.norm(np.diff(vertices, axis=0), axis=1) / longest), 1).astype(
            np.int64
        )
        index = np.repeat(np.arange(len(parts)), parts)
        within = np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts) + 1
        f = (within / parts[index])[:, None]
        points = vertices[index] + f * (vertices[index + 1] - vertices[index])
        place = index + first
        following = path.tolerance[np.minimum(place + 1, len(path) - 1)]
        own = path.tolerance[place]
        tolerance = np.where(within == parts[index], np.maximum(own, following), own)
        if first == 0:
            points = np.concatenate([vertices[:1], points])
            tolerance, place = np.concatenate([own[:1], tolerance]), np.concatenate([[0], place])
        yield _Block(points, tolerance, place)


def _follow(
    blocks: Iterator[_Block], places: int, line: Floats, segment_tolerance: Floats, widest: float
) -> Distances:
    """Match blocks of points with a polyline; a window is some steps and tolerances long."""
    line = np.ascontiguousarray(line)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    state = np.array([0.0, 0.0, 0.0, 1.0])
    found = np.zeros(places, np.int64)
    largest, worst_excess, over = 0.0, -np.inf, 0
    worst = (0.0, 0.0, 0, 0)
    before: Floats | None = None
    for block in blocks:
        points = np.ascontiguousarray(block.points)
        step = np.linalg.norm(
            np.diff(points, axis=0, prepend=points[:1] if before is None else before), axis=1
        )
        before = points[-1:]
        count = len(points)
        segment, fraction, distance = np.zeros(count, np.int64), np.zeros(count), np.zeros(count)
        reach = 4.0 * step + 20.0 * widest
        tolerance = np.ascontiguousarray(block.tolerance)
        kernel.follow(
            points, line, along, tolerance, segment_tolerance, reach, segment, fraction, distance, state
        )
        allowed = np.minimum(tolerance, segment_tolerance[segment])
        excess = distance - (allowed * MARGIN + 2.0 * CHORD_MM)
        found[block.place[::-1]] = segment[::-1]
        over += len(np.unique(block.place[excess > 0]))
        largest = max(largest, float(distance.max()))
        at = int(np.argmax(excess))
        if excess[at] > worst_excess:
            worst_excess = float(excess[at])
            worst = float(distance[at]), float(allowed[at]), int(block.place[at]), int(segment[at])
    return Distances(largest, *worst, over, found)
