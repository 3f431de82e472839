"""From cutter contact points on a surface to cutter locations of the tip.

A cutter of radius R with an edge rounded by r (a ball: r = R; square: r = 0) turns about the axis a and touches the
surface with normal n at the point p with the circle of its rounding:

    tip = p + r n + (R - r) e - r a,    e = the unit vector of n - (n . a) a

(e is 0 where the normal is the axis: a flat bottom touches with all of it, and its middle is taken).

A tool that leans by a constant tilt θ and yaw ψ (FIVE_AXES_CONST_TILT_YAW, ISO 14649-11) is inclined from n towards the
feed, and then turned about n; with the feed's direction t in the surface's plane

    a = cos θ n + sin θ (cos ψ t + sin ψ n × t)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.geometry.chords import AXIS_STEP, MAX_POINTS, couple, with_axes
from cncgen.stepnc.geometry.pieces import Piece, Polyline

Floats = NDArray[np.float64]

#: Where the path bends by more at a point it has a corner there, and the tool turns in it, rad.
CORNER = math.radians(15.0)


@dataclass(frozen=True, slots=True)
class Lean:
    """How a tool leans against surface and path, the same everywhere.

    Attributes:
        tilt: From the surface's normal towards the feed, rad.
        yaw: Of the tilted tool about the normal by the right hand, from the feed, rad.
        forward: Whether the path is followed in its own direction.
    """

    tilt: float
    yaw: float
    forward: bool = True

    def along(self, points: Floats, normals: Floats) -> tuple[Floats, Floats, Floats]:
        """Return points, normals and tool axes, each of shape (m, 3); in a corner the tool turns about the normal in steps.

        Args:
            points: Of the path, shape (n, 3), mm.
            normals: Of the surface, shape (n, 3), unit vectors.

        Raises:
            ValueError: The path does not move, or goes along a normal, or has too many corners, or a normal has no length.
        """
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        moving = np.flatnonzero(lengths > 1e-9)
        if not len(moving):
            raise ValueError("the path does not move")
        if np.any(np.linalg.norm(normals, axis=1) < 0.5):
            raise ValueError("a normal has no length")
        # A step of no length has the direction of the one before it, the first ones that of the one after.
        last = np.maximum.accumulate(np.where(lengths > 1e-9, np.arange(len(steps)), moving[0]))
        ways = steps[last] / lengths[last, None]
        before = _in_plane(np.concatenate([ways[:1], ways]), normals)
        after = _in_plane(np.concatenate([ways, ways[-1:]]), normals)
        if not self.forward:
            before, after = -before, -after
        across = np.cross(normals, before)
        bend = elementary.arctan2((across * after).sum(axis=1), (before * after).sum(axis=1))
        counts = np.where(np.abs(bend) > CORNER, np.ceil(np.abs(bend) / AXIS_STEP).astype(np.int64) + 1, 1)
        if counts.sum() > MAX_POINTS:
            raise ValueError(
                f"with the tool's turns in its corners the path has more than {MAX_POINTS} points"
            )
        index = np.repeat(np.arange(len(points)), counts)
        place = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
        # Where the path bends little the tool leans along the mean of both directions.
        part = np.where(counts[index] > 1, place / np.maximum(counts[index] - 1, 1), 0.5)
        angle = (part * bend[index] + self.yaw)[:, None]
        way = np.cos(angle) * before[index] + np.sin(angle) * across[index]
        return points[index], normals[index], math.cos(self.tilt) * normals[index] + math.sin(self.tilt) * way


def _in_plane(ways: Floats, normals: Floats) -> Floats:
    """Return the unit vectors, shape (n, 3), of directions in the planes across the normals."""
    flat = ways - (ways * normals).sum(axis=1, keepdims=True) * normals
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    if np.any(size < 1e-6):
        raise ValueError("the path goes along the surface's normal")
    return flat / size


def tips(points: Floats, normals: Floats, axes: Floats, radius: float, edge: float) -> Floats:
    """Return the tips of a cutter, shape (n, 3), mm.

    Args:
        points: Where it touches, shape (n, 3), mm.
        normals: Of the surface there, out of the material, shape (n, 3), unit vectors.
        axes: From the tip to the spindle, shape (n, 3), unit vectors.
        radius: Of the cutter, mm.
        edge: Radius of its rounded edge, mm.
    """
    across = normals - (normals * axes).sum(axis=1, keepdims=True) * axes
    length = np.linalg.norm(across, axis=1, keepdims=True)
    outward = np.where(length > 1e-9, across / np.where(length > 1e-9, length, 1.0), 0.0)
    return points + edge * (normals - axes) + (radius - edge) * outward


def locations(
    contact: list[Piece],
    normals: list[Piece],
    axes: list[Piece] | None,
    upright: Floats | Lean,
    radius: float,
    edge: float,
) -> list[Piece]:
    """Return the path of the tip for a path of the contact point, in chords, on which the normal turns little.

    Args:
        contact: The path of the contact point.
        normals: A curve whose points are the surface's normals along it; see `couple`.
        axes: Likewise of the tool axis, None where it is as `upright` says.
        upright: Shape (3,), the direction of the tool, or how it leans.
        radius, edge: Of the cutter, mm.

    Raises:
        ValueError: See `Lean.along`.
    """
    out: list[Piece] = []
    touching = couple(contact, normals)
    tilted = [] if axes is None else couple(contact, axes)
    if tilted and len(tilted) != len(touching):
        touching, tilted = [_joined(touching)], [_joined(tilted)]
    for k, piece in enumerate(touching):
        assert piece.axes is not None
        if tilted:
            points, directions, tool = _with_both(piece, tilted[k])
            out.append(Polyline(tips(points, directions, tool, radius, edge), tool))
            continue
        points, directions = with_axes(piece.points, piece.axes)
        if isinstance(upright, Lean):
            points, directions, tool = upright.along(points, directions)
            out.append(Polyline(tips(points, directions, tool, radius, edge), tool))
        else:
            tool = np.tile(upright, (len(points), 1))
            out.append(Polyline(tips(points, directions, tool, radius, edge)))
    return out


def _joined(pieces: list[Polyline]) -> Polyline:
    """Return pieces with tool axes as one."""
    axes = [piece.axes for piece in pieces if piece.axes is not None]
    return Polyline(np.concatenate([piece.points for piece in pieces]), np.concatenate(axes))


def _with_both(touching: Polyline, tilted: Polyline) -> tuple[Floats, Floats, Floats]:
    """Return points, normals and tool axes, each of shape (n, 3), so many that neither turns much from one to the next.

    Both go along the same path: `touching` has its normals, `tilted` the axes. Where they are not given at the same points
    they are taken over by the length up to each.
    """
    assert touching.axes is not None
    assert tilted.axes is not None
    points, normals, axes = touching.points, touching.axes, tilted.axes
    if len(points) != len(axes):
        along, other = _way(points), _way(tilted.points)
        other *= along[-1] / max(other[-1], 1e-300)
        at = np.union1d(along, other)
        points, normals = _taken(at, along, points), _unit(_taken(at, along, normals))
        axes = _unit(_taken(at, other, axes))
    turns = [elementary.arccos(np.clip((v[:-1] * v[1:]).sum(axis=1), -1.0, 1.0)) for v in (normals, axes)]
    counts = np.maximum(np.ceil(np.maximum(*turns) / AXIS_STEP).astype(np.int64), 1)
    return (*with_axes(points, normals, counts), with_axes(points, axes, counts)[1])


def _way(points: Floats) -> Floats:
    """Return the length of a path up to each of its points, shape (n,), mm."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _taken(at: Floats, s: Floats, values: Floats) -> Floats:
    """Return values, shape (n, 3), known at lengths `s`, at other ones, linearly between."""
    return np.column_stack([np.interp(at, s, column) for column in values.T])


def _unit(vectors: Floats) -> Floats:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def leaning(path: list[Piece], normals: list[Piece], lean: Lean) -> list[Piece]:
    """Return the path of a tip in chords with the tool axes of a tool that leans; `normals` as for `locations`.

    Raises:
        ValueError: See `Lean.along`.
    """
    out: list[Piece] = []
    for piece in couple(path, normals):
        assert piece.axes is not None
        points, _, axes = lean.along(*with_axes(piece.points, piece.axes))
        out.append(Polyline(points, axes))
    return out
