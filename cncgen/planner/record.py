"""Records that the planner hands on to `cncgen.setpoints`: the place along the path at each time, and the limit that binds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.toolpath.record import Event, Toolpath

Floats = NDArray[np.float64]

#: Setpoints that a motion may have: at a period of 1 ms, eleven days.
MOST_ROWS = 1_000_000_000
#: Sharp corners that are handed on, and listed, one by one; beyond them they are counted.
MAX_CORNERS = 10_000


class Limit(IntEnum):
    """Which limit holds the speed back on a piece of a trajectory."""

    NONE = 0
    FEED = 1
    CHORD = 2
    VELOCITY = 3
    ACCELERATION = 4
    JERK = 5
    CENTRIPETAL = 6
    CONTOUR_ERROR = 7
    SATURATION = 8
    STOP = 9
    CORNER = 10
    CURVATURE = 11


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Motion along the path as pieces in time, each the exact solution of s''' = j + c s' (`cncgen.kernels.profile`).

    Constant-jerk profiles (seven phases; Biagiotti and Melchiorri (2008), section 3.4) have c = 0. Profiles whose v² is a
    quadratic of s have j = 0 and c = d²(v²)/ds²/2, so that a is linear in s: since v dv/ds = a, dv/dt = a and da/dt = c v.
    A piece with v = a = j = c = 0 is a wait. Velocity steps from piece to piece only in the papers' baselines, which say so.

    Attributes:
        t: Shape (k + 1,), s: start of each piece and, last, the end of the last one; non-decreasing.
        s: Shape (k + 1,), mm along the chunk's path (see `Trajectory.row_s`): start of each piece, and the end.
        v, a: Shape (k,), mm/s and mm/s²: speed and acceleration along the path at the start of the piece.
        j, c: Shape (k,), mm/s³ and 1/s²: the constants of the piece.
        limit: Shape (k,), int8, the `Limit` that binds on the piece.
    """

    t: Floats
    s: Floats
    v: Floats
    a: Floats
    j: Floats
    c: Floats
    limit: NDArray[np.int8]

    @classmethod
    def standing(cls, s: float, begin: float, end: float, limit: Limit) -> Profile:
        """Return a wait at a place from one time to another."""
        zero = np.zeros(1)
        return cls(
            np.array([begin, end]), np.array([s, s]), zero, zero, zero, zero, np.array([limit], np.int8)
        )

    def __len__(self) -> int:
        return len(self.v)

    @property
    def waits(self) -> NDArray[np.bool_]:
        """Shape (k,): the pieces on which the motion stands."""
        return (self.v == 0) & (self.a == 0) & (self.j == 0) & (self.c == 0)

    def __repr__(self) -> str:
        return f"Profile({len(self)} pieces, {self.t[0]:.6g} to {self.t[-1]:.6g} s, {self.s[0]:.6g} to {self.s[-1]:.6g} mm)"


@dataclass(frozen=True, slots=True, eq=False)
class Cubics:
    """Positions of all axes as cubics in time, `k` pieces, each with constant jerk.

    Attributes:
        t: Shape (k + 1,), s: start of each piece and, last, the end of the last one; non-decreasing.
        position, velocity, acceleration, jerk: Shape (k, axes), mm or rad and s: the state at the start of each piece, and its jerk.
    """

    t: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats

    def at(self, t: Floats, order: int = 0) -> Floats:
        """Return positions and derivatives by time up to an order (0 to 3), shape (order + 1, n, axes); outside those at the ends."""
        piece = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.jerk) - 1)
        h = np.clip(t - self.t[piece], 0.0, self.t[piece + 1] - self.t[piece])[:, None]
        x, v, a, j = (each[piece] for each in (self.position, self.velocity, self.acceleration, self.jerk))
        found = [x + h * (v + h * (a / 2.0 + h * j / 6.0)), v + h * (a + h * j / 2.0), a + h * j, j]
        return np.stack(found[: order + 1])


@dataclass(frozen=True, slots=True)
class SharpCorner:
    """A place where the planner slows for a corner.

    Attributes:
        line: Source line.
        position: Of all axes, mm or rad.
        feed_mm_s: Speed along the path there.
        limit: The binding limit.
        t_s: When the motion is there.
    """

    line: int
    position: tuple[float, ...]
    feed_mm_s: float
    limit: Limit
    t_s: float


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A stretch of planned motion; chunks follow each other without a gap in time or position.

    Attributes:
        toolpath: The rows that are travelled (after smoothing), with their geometry.
        row_s: Shape (rows + 1,): path coordinate at the start of each row and at the end. EVENT rows have length 0.
            The coordinate is arc length in X Y Z where a row moves them, else in U V W, else the rotary axes' norm.
        profile: s(t); its `t` continues from chunk to chunk, its `s` starts at ``row_s[0]`` of this chunk or later.
        events: Pairs of time and `Event` with the source line, in order.
        corners: Sharp corners found in this stretch.
        values: Further results of a strategy for the summary, as plain values; ``diagnostics`` holds remarks for the user.
        cubics: The motion itself, where it leaves the rows within their tolerance; the profile is then the length of its path,
            over the axes that measure the rows, by time, exact where pieces begin, and rows stand for the programmed ones. None: the motion is the profile on the rows.
    """

    toolpath: Toolpath
    row_s: Floats
    profile: Profile
    events: tuple[tuple[float, int, Event], ...] = ()
    corners: tuple[SharpCorner, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    cubics: Cubics | None = None

    def retimed(self, profile: Profile, at: Callable[[float], float]) -> Trajectory:
        """Return the same motion with another profile; `at` gives the new times of its events and corners."""
        return replace(
            self,
            profile=profile,
            events=tuple((float(at(t)), line, event) for t, line, event in self.events),
            corners=tuple(replace(corner, t_s=float(at(corner.t_s))) for corner in self.corners),
        )

    def __repr__(self) -> str:
        return f"Trajectory({self.toolpath!r}, {self.profile!r})"
