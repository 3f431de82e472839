"""The plan that is improved, sampled: a reference path, and a motion along it that holds all limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.path import Path
from cncgen.planner.motion import motion_at, time_at
from cncgen.planner.record import Profile, Trajectory
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Growth of the way between samples from the ends of a piece of constant jerk inwards.
_GROWTH = 0.05
#: Rounding within which the plan meets a place exactly, mm.
EXACT = 1e-7
#: A speed of rest, mm/s.
REST = 1e-9
#: Half of the chord that stands for a tangent, mm.
_BESIDE = 1e-4


@dataclass(slots=True)
class Grid:
    """Samples of a plan, `m` of them, ascending.

    Attributes:
        t: Shape (m,), time.
        free: Shape (m,), time without waits.
        s: Shape (m,), length along the paths.
        x, tangent: Shape (m, n), position and unit tangent over all axes, scaled.
        bend: Shape (m,), curvature over all axes.
        v: Shape (m,), speed over all axes, scaled.
        rate: Shape (m,), length over all axes a length of `s`.
    """

    t: Floats
    free: Floats
    s: Floats
    x: Floats
    tangent: Floats
    bend: Floats
    v: Floats
    rate: Floats

    def __len__(self) -> int:
        return len(self.t)

    def rows(self, at: slice) -> Grid:
        """Return some of the samples."""
        return Grid(*(getattr(self, name)[at] for name in self.__slots__))

    def within(self, room: int) -> Grid:
        """Return a copy at the front of arrays of `room` samples."""
        grown = Grid(*(np.empty((room, *getattr(self, name).shape[1:])) for name in self.__slots__))
        grown.put(0, self)
        return grown

    def put(self, at: int, other: Grid) -> None:
        """Write others over the samples from one on."""
        for name in self.__slots__:
            getattr(self, name)[at : at + len(other)] = getattr(other, name)


class Reference:
    """A plan as it streams: trajectories not yet handed on, and their samples."""

    def __init__(self, scale: Floats, spacing_s: float, kept_s: float) -> None:
        self.scale = scale
        self.spacing_s = spacing_s
        self.kept_s = kept_s
        self.trajectories: list[Trajectory] = []
        self._paths: list[tuple[float, float, float, Path, Profile]] = []
        self.grid: Grid | None = None
        # A row may take hours, and its samples stay to its end: they grow within arrays that have room for as many again.
        self._room: Grid | None = None
        self._end = 0
        self._free = self._s = 0.0

    def take(self, trajectory: Trajectory) -> None:
        """Add a trajectory."""
        self.trajectories.append(trajectory)
        profile = trajectory.profile
        if not len(profile) or profile.s[-1] <= profile.s[0]:
            return
        path = trajectory.toolpath.path
        found = self._samples(profile, trajectory.toolpath)
        self._free, self._s = float(found.free[-1]), float(found.s[-1])
        self._paths.append((float(found.s[0]), float(found.s[-1]), float(profile.s[0]), path, profile))
        held = self.grid if self.grid is not None else found.rows(slice(0))
        if self._room is None or self._end + len(found) > len(self._room):
            self._room, self._end = held.within(2 * (len(held) + len(found))), len(held)
        self._room.put(self._end, found)
        self._end += len(found)
        self.grid = self._room.rows(slice(self._end - len(held) - len(found), self._end))

    def forget(self, index: int) -> None:
        """Forget samples before one."""
        if self.grid is None or index <= 0:
            return
        self.grid = self.grid.rows(slice(index, None))
        # Setpoints before a place have a part in differences after it.
        while len(self._paths) > 1 and self._paths[0][4].t[-1] < self.grid.t[0] - self.kept_s:
            self._paths.pop(0)

    def _samples(self, profile: Profile, toolpath: Toolpath) -> Grid:
        """Return the samples of a trajectory, sharp corners among them."""
        t, piece = self._times(profile)
        grid = self._sampled(profile, toolpath.path, t, piece)
        corners = self._missed(grid, profile, toolpath)
        if not len(corners):
            return grid
        more = time_at(profile, corners)
        t = np.concatenate([t, more])
        piece = np.concatenate([piece, np.searchsorted(profile.t, more, side="right") - 1])
        order = np.lexsort((t, piece))
        return self._sampled(profile, toolpath.path, t[order], piece[order])

    def _missed(self, grid: Grid, profile: Profile, toolpath: Toolpath) -> Floats:
        """Return where on their path joints of rows lie further off the chords between samples than the bend there explains.

        A corner that setpoints do not show is passed without a rest, a way to its tip and back as well.
        """
        s, points = np.asarray(toolpath.path.row_s)[1:-1], toolpath.end[:-1] * self.scale
        at = grid.s - self._s + profile.s[0]
        i = np.clip(np.searchsorted(at, s, side="right") - 1, 0, len(at) - 2)
        way = at[i + 1] - at[i]
        inside = (s > at[i]) & (s < at[i + 1])
        part = np.where(inside, (s - at[i]) / np.where(inside, way, 1.0), 0.0)[:, None]
        off = np.abs(points - grid.x[i] - part * (grid.x[i + 1] - grid.x[i])).max(axis=1, initial=0.0)
        bent = (
            np.maximum(grid.bend[i], grid.bend[i + 1])
            * (np.maximum(grid.rate[i], grid.rate[i + 1]) * way) ** 2
        )
        out: Floats = np.unique(s[inside & (off > np.maximum(EXACT, bent))])
        return out

    def _times(self, profile: Profile) -> tuple[Floats, Ints]:
        """Return times at which a trajectory is sampled, and the piece of its profile that each belongs to."""
        piece = np.diff(profile.t)
        waits = profile.waits
        half = 0.5 * piece
        count = np.ceil(
            elementary.log1p(_GROWTH * half / (0.5 * self.spacing_s)) / elementary.log1p(_GROWTH)
        ).astype(np.int64)
        count = np.where(waits | (piece <= 0.0), 0, np.maximum(count, 1))
        index = np.repeat(np.arange(len(piece)), 2 * count)
        step = np.arange(len(index)) - np.repeat(np.cumsum(2 * count) - 2 * count, 2 * count)
        c = count[index]
        mirrored = np.minimum(step, 2 * c - step)
        d = (
            half[index]
            * elementary.expm1(elementary.log1p(_GROWTH) * mirrored)
            / elementary.expm1(elementary.log1p(_GROWTH) * c)
        )
        t = profile.t[index] + np.where(step <= c, d, piece[index] - d)
        # A wait has a sample at its start and the next piece one at its end; the last sample ends it all.
        t = np.concatenate([t, profile.t[:-1][waits], profile.t[-1:]])
        which = np.concatenate([index, np.flatnonzero(waits), [len(piece)]])
        order = np.lexsort((t, which))
        return t[order], which[order]

    def _sampled(self, profile: Profile, path: Path, t: Floats, which: Ints) -> Grid:
        """Return the samples at times in pieces of a profile."""
        piece, waits = np.diff(profile.t), profile.waits
        at = motion_at(profile, t)
        waited = np.concatenate([[0.0], np.cumsum(np.where(waits, piece, 0.0))])
        free = t - waited[which] - profile.t[0]
        x = path.evaluate(at.s, 2, 1)
        ends = path.evaluate(at.s[-1:], 2, -1)
        x[1:, -1] = ends[1:, 0]
        x0, x1, x2 = x * self.scale
        rate = np.sqrt((x1**2).sum(axis=1))
        safe = np.where(rate > 0, rate, 1.0)
        unit = x1 / safe[:, None]
        along = (x2 * unit).sum(axis=1)
        bend = np.sqrt(np.maximum((x2**2).sum(axis=1) - along**2, 0.0)) / safe**2
        return Grid(t, self._free + free, self._s + (at.s - profile.s[0]), x0, unit, bend, at.v * rate, rate)

    def at(self, s: Floats, side: int) -> tuple[Floats, Floats]:
        """Return position and unit tangent over all axes at places of the path, shape (k, n) each, scaled."""
        starts = np.array([first for first, *_ in self._paths])
        owner = np.clip(
            np.searchsorted(starts, s, side="right" if side > 0 else "left") - 1, 0, len(starts) - 1
        )
        x, tangent = np.empty((len(s), len(self.scale))), np.empty((len(s), len(self.scale)))
        for k in np.unique(owner):
            pick = np.flatnonzero(owner == k)
            first, _, begin, path, _ = self._paths[k]
            found = path.evaluate(s[pick] - first + begin, 1, side)
            x[pick], x1 = found[0] * self.scale, found[1] * self.scale
            still = np.flatnonzero(~(np.abs(x1).max(axis=1) > 0.0))
            if len(still):
                # A curve may stand where its control points are one: the chord about the place, within the path, has its direction.
                place, ends = s[pick[still]] - first + begin, path.row_s[[0, -1]]
                low, high = (path.evaluate(np.clip(place + d, *ends))[0] for d in (-_BESIDE, _BESIDE))
                x1[still] = (high - low) * self.scale
            tangent[pick] = x1 / np.sqrt((x1**2).sum(axis=1))[:, None]
        return x, tangent

    def positions(self, t: Floats) -> Floats:
        """Return positions at times, shape (k, n), scaled; before and after what is known those of its ends."""
        ends = np.array([profile.t[-1] for *_, profile in self._paths])
        owner = np.minimum(np.searchsorted(ends, t), len(ends) - 1)
        out = np.empty((len(t), len(self.scale)))
        for k in np.unique(owner):
            *_, path, profile = self._paths[k]
            pick = np.flatnonzero(owner == k)
            at = motion_at(profile, np.clip(t[pick], profile.t[0], profile.t[-1]))
            out[pick] = path.evaluate(at.s, 0)[0] * self.scale
        return out

    def state(self, s: float, t: float) -> Floats:
        """Return position, velocity and acceleration at a place and time, shape (3, n), scaled."""
        for first, last, _, path, profile in self._paths:
            if first <= s <= last and profile.t[0] - 1e-12 <= t <= profile.t[-1] + 1e-12:
                m = motion_at(profile, np.array([t]))
                x = path.evaluate(m.s, 2, 1)[:, 0] * self.scale
                return np.stack([x[0], x[1] * m.v, x[2] * m.v**2 + x[1] * m.a])
        raise ValueError("the place is not in the plan")
