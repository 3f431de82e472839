"""The strategy: blocks of the toolpath become tracks, a window of tracks becomes trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.optimal.blocks import blocks, joined
from cncgen.planner.optimal.limits import Bounds
from cncgen.planner.optimal.track import end_derivatives, track_of
from cncgen.planner.optimal.window import Window
from cncgen.planner.options import PlanOptions
from cncgen.planner.paths import path_of
from cncgen.planner.record import Trajectory
from cncgen.planner.smoothing import smooth
from cncgen.toolpath.record import Kind, Toolpath

#: Rows of a block.
ROWS = 2048


@dataclass(frozen=True, slots=True)
class _Block:
    toolpath: Toolpath
    path: Path


def plan_optimal(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Plan the least time within the limits of every axis.

    Args:
        chunks: Consecutive stretches of one program.
        machine: Limits, period, chord tolerance.
        options: `effort`: density of the nodes.

    Yields:
        Trajectories, from rest to rest, as their speeds become final.

    Raises:
        NoPlanError: No motion within the limits was found.
    """
    window: Window | None = None
    before: np.ndarray | None = None
    held: _Block | None = None
    still: list[Toolpath] = []
    for block in blocks(smooth(chunks, machine.chord_tolerance_mm), ROWS):
        still.append(block)
        if not _moves(block):
            continue
        toolpath = joined(still)
        still = []
        path = path_of(toolpath)
        now = _Block(toolpath, path)
        if held is not None:
            if window is None:
                window = Window(Bounds.of(machine, held.toolpath.axes))
            window.tracks.append(
                track_of(
                    held.toolpath, held.path, window.bounds, before, end_derivatives(path)[0], options.effort
                )
            )
            before = end_derivatives(held.path)[1]
            yield from window.advance(last=False)
        held = now
    if held is not None:
        if window is None:
            window = Window(Bounds.of(machine, held.toolpath.axes))
        window.tracks.append(track_of(held.toolpath, held.path, window.bounds, before, None, options.effort))
        yield from window.advance(last=True)
    if still:
        yield _standing(joined(still), window.t_s if window else 0.0)


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
