"""The strategy: blocks of the toolpath become tracks, a window of tracks becomes trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.optimal.ahead import ahead
from cncgen.planner.optimal.blocks import blocks, joined
from cncgen.planner.optimal.limits import Bounds
from cncgen.planner.optimal.track import Track, end_derivatives, track_of
from cncgen.planner.optimal.window import Window
from cncgen.planner.options import PlanOptions
from cncgen.planner.paths import path_of
from cncgen.planner.record import Trajectory
from cncgen.planner.smoothing import smooth
from cncgen.toolpath.record import Kind, Toolpath

#: Rows of a block.
ROWS = 2048
#: Blocks that are made ready while the window is solved.
AHEAD = 2


def plan_optimal(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Plan the least time within the limits of every axis.

    Args:
        chunks: Consecutive stretches of one program; drawn in another thread.
        machine: Limits, period, chord tolerance.
        options: `effort`: density of the nodes.

    Yields:
        Trajectories, from rest to rest, as their speeds become final.

    Raises:
        NoPlanError: No motion within the limits was found.
    """
    window: Window | None = None
    with closing(ahead(_tracks(chunks, machine, options.effort), AHEAD)) as tracks:
        for track, last in tracks:
            if isinstance(track, Toolpath):
                yield _standing(track, window.t_s if window else 0.0)
                continue
            if window is None:
                window = Window(Bounds.of(machine, track.toolpath.axes))
            window.tracks.append(track)
            yield from window.advance(last)


def _tracks(
    chunks: Iterable[Toolpath], machine: Machine, effort: str
) -> Iterator[tuple[Track | Toolpath, bool]]:
    """Yield the tracks of a program and whether each is the last one; after it, maybe, a toolpath that stands still."""
    held: tuple[Toolpath, Path] | None = None
    before: NDArray[np.float64] | None = None
    still: list[Toolpath] = []
    bounds: Bounds | None = None
    for block in blocks(smooth(chunks, machine.chord_tolerance_mm), ROWS):
        still.append(block)
        if not _moves(block):
            continue
        toolpath = joined(still)
        still = []
        path = path_of(toolpath)
        bounds = bounds or Bounds.of(machine, toolpath.axes)
        if held is not None:
            yield track_of(*held, bounds, before, end_derivatives(path)[0], effort), False
            before = end_derivatives(held[1])[1]
        held = toolpath, path
    if held is not None and bounds is not None:
        yield track_of(*held, bounds, before, None, effort), True
    if still:
        yield joined(still), True


def _moves(toolpath: Toolpath) -> bool:
    return bool(np.any(toolpath.kind != Kind.EVENT)) and path_of(toolpath).length > 0.0


def _standing(toolpath: Toolpath, t_s: float) -> Trajectory:
    """Return the trajectory of a toolpath that does not move: its events and their dwells."""
    path = path_of(toolpath)
    rows = np.flatnonzero(toolpath.kind == Kind.EVENT)
    events = [(0, int(toolpath.line[row]), toolpath.events[toolpath.curve[row]]) for row in rows]
    nothing = np.zeros(0)
    profile, arrival = assemble(
        t_s,
        path.row_s[:1],
        (nothing,) * 5,
        np.zeros(0, np.int8),
        np.zeros(1, np.int64),
        waits_of(events, 1),
    )
    return Trajectory(toolpath, np.asarray(path.row_s), profile, timed(events, arrival))
