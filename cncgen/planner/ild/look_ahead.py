"""Look-ahead and speed profiles over joints: the arrays around `cncgen.kernels.seven_phase`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import seven_phase as kernel
from cncgen.planner.options import PROFILES
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]

#: Limit that a phase of the kernel stands for: 0 is the top speed's own.
_PHASE_LIMIT = np.array([Limit.NONE, Limit.ACCELERATION, Limit.JERK], dtype=np.int8)


@dataclass(frozen=True, slots=True)
class Segments:
    """Stretches of path between joints, `n` of them, with n + 1 joints.

    Attributes:
        length: Shape (n,), mm.
        top: Shape (n,), mm/s.
        top_limit: Shape (n,), int8, the `Limit` behind `top`.
        acceleration, jerk: Shape (n,), along the path.
        cap: Shape (n + 1,), mm/s: highest speed at each joint.
    """

    length: Floats
    top: Floats
    top_limit: NDArray[np.int8]
    acceleration: Floats
    jerk: Floats
    cap: Floats

    def __len__(self) -> int:
        return len(self.length)


def joint_caps(cap: Floats, top: Floats) -> Floats:
    """Lower the speeds of joints, shape (n + 1,), to the tops of the segments on their two sides, shape (n,); mm/s."""
    lowered = cap.copy()
    np.minimum(lowered[:-1], top, out=lowered[:-1])
    np.minimum(lowered[1:], top, out=lowered[1:])
    return lowered


def joint_speeds(segments: Segments, start_mm_s: float, end_mm_s: float, profile: str) -> Floats:
    """Return the speeds at the joints: a backward and a forward pass (Tsai 2010, section 5.3).

    Args:
        segments: The stretches.
        start_mm_s: Given speed at the first joint.
        end_mm_s: Highest speed at the last joint.
        profile: One of `PROFILES`.

    Returns:
        Shape (n + 1,), mm/s: the largest speeds under the caps from which every segment is long enough to reach the
        next joint's.
    """
    cap = joint_caps(segments.cap, segments.top)
    cap[-1] = min(cap[-1], end_mm_s)
    speeds = np.empty(len(cap))
    speeds[0] = start_mm_s
    kernel.look_ahead(
        PROFILES.index(profile), segments.length, segments.acceleration, segments.jerk, cap, speeds
    )
    return speeds


def settled(segments: Segments, start_mm_s: float, profile: str) -> int:
    """Return how many joints have speeds that nothing after the last segment can change.

    The speed at the last joint lies between rest and its cap, and the backward pass never falls when that speed
    rises; so where both extremes give the same, it is final.
    """
    rest = joint_speeds(segments, start_mm_s, 0.0, profile)
    free = joint_speeds(segments, start_mm_s, np.inf, profile)
    differ = np.flatnonzero(rest != free)
    return int(differ[0]) if len(differ) else len(rest)


@dataclass(frozen=True, slots=True)
class SegmentPieces:
    """Pieces of constant jerk (or of an exponential ramp) of consecutive segments, `k` of them.

    Attributes:
        duration: Shape (k,), s.
        length: Shape (k,), mm.
        v, a, j, c: Shape (k,), at the start of the piece (see `Profile`).
        limit: Shape (k,), int8.
        offset: Shape (n + 1,), first piece of each segment, and how many there are.
    """

    duration: Floats
    length: Floats
    v: Floats
    a: Floats
    j: Floats
    c: Floats
    limit: NDArray[np.int8]
    offset: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.duration)


def build(segments: Segments, speeds: Floats, profile: str) -> SegmentPieces:
    """Lay out the speed profile of every segment between joint speeds that `joint_speeds` gave (Tsai 2010, section 5.3).

    Long segments accelerate, cruise at their top speed and decelerate (seven phases); medium ones only reach the
    speed at which both ramps just fill them, found by bisection; short ones are a single ramp.
    """
    n = len(segments)
    table = np.empty((7 * n, 7))
    offset = np.zeros(n + 1, dtype=np.int64)
    count = kernel.build(
        PROFILES.index(profile),
        segments.length,
        segments.acceleration,
        segments.jerk,
        segments.top,
        speeds,
        table,
        offset,
    )
    owner = np.repeat(np.arange(n), np.diff(offset))
    duration, v, a, j, c, phase, length = table[:count].T.copy()
    cruise = phase == 0.0
    limit = np.where(cruise, segments.top_limit[owner], _PHASE_LIMIT[phase.astype(np.int64)])
    return SegmentPieces(duration, length, v, a, j, c, limit.astype(np.int8), offset)
