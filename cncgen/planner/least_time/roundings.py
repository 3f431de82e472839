"""Short programs are planned with other roundings of their corners too, and the fastest is taken.

Estimates of two rows at a time decide which corners of G64 are rounded, and how far
(`cncgen.planner.smoothing.rounding_decision`, docs/rounding.md). Where chords hold the speed these are some per cent off, for what a fit makes of short rows, and of arcs beside
them, is known once it is made. A program of a few rows is planned as they have it, and with no corner rounded: so it takes no longer than with
its corners as they are. Where chords hold the first motion for more than a trifle of its time, it is planned with all corners rounded as
well. Longer programs are planned once: their first setpoints do not wait for their end.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import replace
from itertools import chain

import numpy as np

from cncgen.diagnostics import NoPlanError
from cncgen.machine.record import Machine
from cncgen.planner.least_time.block_planning import plan_blocks, smooth_blocks
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.limits.axis_limits import chord_reserve
from cncgen.planner.record import Limit, Trajectory
from cncgen.planner.smoothing.stretches import Stretches
from cncgen.toolpath.record import PathMode, Toolpath
from cncgen.toolpath.slicing import between, join

Blocks = list[tuple[Toolpath, SpeedCap | None]]

#: Rows up to which a program is short, of at most so many parts each on average: lines and arcs that go on are one row.
SHORT, _PARTS = 64, 8
#: Part of the time of a motion that chords hold, up to which its roundings stay; and part by which another must be faster.
_HELD, _LESS = 0.02, 1e-4


def plan_roundings(chunks: Iterable[Toolpath], machine: Machine) -> Generator[Trajectory, None, None]:
    """Plan the least time of a program, of a short one with the rounding of its corners that takes the least.

    Args:
        chunks: Consecutive stretches of one program.
        machine: Limits, period, chord tolerance.

    Yields:
        Trajectories, from rest to rest, as their speeds become final.

    Raises:
        NoPlanError: No motion within the limits was found.
    """
    source = (chunk for chunk in chunks if len(chunk))
    held: list[Toolpath] = []
    rows = parts = 0
    while max(rows, parts / _PARTS) <= SHORT and (chunk := next(source, None)) is not None:
        rows += _more_rows(held, chunk)
        parts += len(chunk)
        held.append(chunk)
    rounded = any(np.any(chunk.path_mode == PathMode.CONTINUOUS) for chunk in held)
    if max(rows, parts / _PARTS) > SHORT or not rounded:
        yield from plan_blocks(smooth_blocks(chain(held, source), machine), machine)
        return
    blocks = list(smooth_blocks(held, machine))
    best = list(plan_blocks(blocks, machine))
    moving, by_chord = plan_times(best)
    others: list[Callable[[list[Toolpath], Machine], Blocks]] = [_none_rounded]
    if by_chord > _HELD * moving:
        others.insert(0, _all_rounded)
    for other in others:
        other_blocks = other(held, machine)
        if _same(other_blocks, blocks):
            continue
        try:
            found = list(plan_blocks(other_blocks, machine))
        except NoPlanError:
            continue
        seconds = plan_times(found)[0]
        if seconds < (1.0 - _LESS) * moving:
            best, moving = found, seconds
    yield from best


def _more_rows(before: list[Toolpath], chunk: Toolpath) -> int:
    """Return how many rows a chunk adds to those before it; in how many parts a line is written makes no more of it."""
    last = [between(each, len(each) - 1, len(each)) for each in before[-1:]]
    return len(Stretches.of(join([*last, chunk])).rows) - len(last)


def _all_rounded(chunks: list[Toolpath], machine: Machine) -> Blocks:
    """Return the blocks of a program with all corners rounded."""
    return list(smooth_blocks(chunks, machine, chord_reserve(machine, chunks[0].axes)))


def _none_rounded(chunks: list[Toolpath], machine: Machine) -> Blocks:
    """Return the blocks of a program with no corner rounded, as G61 has it."""
    met = [
        np.where(chunk.path_mode == PathMode.CONTINUOUS, PathMode.EXACT_PATH, chunk.path_mode)
        for chunk in chunks
    ]
    exact = [replace(chunk, path_mode=mode.astype(np.int8)) for chunk, mode in zip(chunks, met, strict=True)]
    return list(smooth_blocks(exact, machine))


def _same(one: Blocks, other: Blocks) -> bool:
    """Tell whether two roundings made the same rows: corners rounded another way have other ends."""
    return len(one) == len(other) and all(
        np.array_equal(a.kind, b.kind) and np.array_equal(a.end, b.end)
        for (a, _), (b, _) in zip(one, other, strict=True)
    )


def plan_times(plan: list[Trajectory]) -> tuple[float, float]:
    """Return how long the axes move or wait for setpoints on the way, and how long chords hold the speed meanwhile, s."""
    moving = by_chord = 0.0
    for number, trajectory in enumerate(plan):
        profile = trajectory.profile
        time, stands = np.diff(profile.t), profile.waits
        by_chord += float(time[~stands & (profile.limit == Limit.CHORD)].sum())
        counted = ~stands | (profile.limit != Limit.STOP)
        # Standing before the first motion does not count.
        counted[:1] &= (number > 0) | ~stands[:1]
        moving += float(time[counted].sum())
    return moving, by_chord
