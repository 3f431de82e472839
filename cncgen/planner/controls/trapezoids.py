"""Speeds at the ends of blocks under a bounded look-ahead, and the trapezoids of speed between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.controls.control_blocks import Blocks
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]


def entry_speeds(blocks: Blocks, depth: int, first_mm_s: float) -> Floats:
    """Return the speed where each block begins, and 0 at the end, shape (n + 1,).

    The control knows `depth` blocks ahead, so a block is entered no faster than the motion can stop within them. Nor is it entered
    faster than the blocks before it can accelerate to.

    Args:
        blocks: The blocks.
        depth: Blocks that the control looks ahead.
        first_mm_s: Speed at which the first one is entered.
    """
    n = len(blocks)
    gain = 2.0 * blocks.acceleration * blocks.length
    squared = np.zeros(n + 1)
    entry = np.append(blocks.entry**2, 0.0)
    reach = min(depth, n)
    for ahead in range(reach - 1, -1, -1):
        # squared[k] bounds the speed that block k + ahead is entered with.
        at = np.minimum(np.arange(n + 1) + ahead, n)
        squared = np.minimum(entry[at], squared + np.append(gain, 0.0)[at])
    squared[0] = min(squared[0], first_mm_s**2)
    gained = np.concatenate([[0.0], np.cumsum(gain)])
    # v² may grow by `gain` a block: the running minimum of v² minus the gain so far.
    speeds: Floats = np.sqrt(np.maximum(gained + np.minimum.accumulate(squared - gained), 0.0))
    return speeds


def trapezoids(
    blocks: Blocks, speed: Floats, slowing_s: float
) -> tuple[tuple[Floats, Floats, Floats], Floats, NDArray[np.int8]]:
    """Return duration, speed at the start and acceleration of each piece; its end; and the limit that binds.

    A block has up to three pieces: it accelerates, holds its speed, decelerates. The way of the block along the path is
    shared among them as the control's own way is.

    Args:
        blocks: The blocks.
        speed: Shape (n + 1,), from `entry_speeds`.
        slowing_s: Time that a deceleration takes beyond its trapezoid, where the trapezoid is longer than this time.
    """
    v0, v1, a = speed[:-1], speed[1:], blocks.acceleration
    peak = np.sqrt(np.minimum(blocks.top**2, 0.5 * (v0**2 + v1**2) + a * blocks.length))
    peak = np.maximum(peak, np.maximum(v0, v1))
    up, down = (peak**2 - v0**2) / (2.0 * a), (peak**2 - v1**2) / (2.0 * a)
    held = np.maximum(blocks.length - up - down, 0.0)
    zero = np.zeros(len(blocks))
    duration = np.stack([(peak - v0) / a, held / np.maximum(peak, 1e-300), (peak - v1) / a], axis=1)
    start = np.stack([v0, peak, peak], axis=1)
    change = np.stack([a, zero, -a], axis=1)
    way = np.stack([up, held, down], axis=1)
    total = np.maximum(way.sum(axis=1), 1e-300)
    ends = blocks.start[:, None] + np.cumsum(way, axis=1) * ((blocks.end - blocks.start) / total)[:, None]
    ends[:, 2] = blocks.end
    # Where the control cuts a corner its way is shorter than the path: the speed along the path is higher.
    stretch = ((blocks.end - blocks.start) / total)[:, None]
    limit = np.full(start.shape, Limit.ACCELERATION, np.int8)
    limit[:, 1] = np.where(blocks.top < blocks.feed, Limit.CORNER, Limit.FEED)
    kept = (duration > 0.0).ravel()
    slower = np.ones(start.shape)
    falls = duration[:, 2] > slowing_s
    # A fall that goes on in the next block is one with it.
    goes_on = np.append(way[1:, :2].sum(axis=1) <= 1e-9 * blocks.length[1:], False)
    last = falls & ~goes_on
    slower[last, 2] = duration[last, 2] / (duration[last, 2] + slowing_s)
    scaled = (duration / slower, start * stretch * slower, change * stretch * slower**2)
    flat = [column.ravel()[kept] for column in scaled]
    return (flat[0], flat[1], flat[2]), ends.ravel()[kept], limit.ravel()[kept]


def cut_at(
    places: Floats, moves: tuple[Floats, Floats, Floats], ends: Floats, limit: NDArray[np.int8], start: float
) -> tuple[tuple[Floats, Floats, Floats], Floats, NDArray[np.int8]]:
    """Cut pieces of constant acceleration where the path reaches some places; return them as `trapezoids` does.

    Args:
        places: Path coordinates, ascending.
        moves, ends, limit: From `trapezoids`.
        start: Where the first piece begins.
    """
    if not len(ends):
        return moves, ends, limit
    duration, v, a = moves
    begins = np.append(start, ends[:-1])
    inside = places[(places > start) & (places < ends[-1])]
    at = np.union1d(inside, np.append(start, ends))
    piece = np.clip(np.searchsorted(ends, at[:-1], side="right"), 0, len(ends) - 1)
    way = at[:-1] - begins[piece]
    # v t + a t²/2 = way, in the form that no cancellation spoils.
    root = np.sqrt(np.maximum(v[piece] ** 2 + 2.0 * a[piece] * way, 0.0))
    into = np.minimum(2.0 * way / np.maximum(v[piece] + root, 1e-300), duration[piece])
    following = np.append(piece[1:] != piece[:-1], True)
    until = np.where(following, duration[piece], np.append(into[1:], 0.0))
    return (until - into, v[piece] + a[piece] * into, a[piece]), at[1:], limit[piece]
