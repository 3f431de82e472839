"""The method of `optimal`: blocks of the toolpath become meshes, a window of meshes becomes trajectories."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing

import numpy as np

from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.least_time.corners import BlockEnd, ends_of
from cncgen.planner.least_time.crawling import paced
from cncgen.planner.least_time.fixed_blocks import blocks
from cncgen.planner.least_time.mesh import Mesh, mesh_of
from cncgen.planner.least_time.prefetch import prefetch
from cncgen.planner.least_time.rolling_window import RollingWindow
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.least_time.timeline import SolvedWindow, Timeline
from cncgen.planner.limits.axis_limits import AxisLimits, chord_reserve
from cncgen.planner.record import Limit, Trajectory
from cncgen.planner.smoothing import chord_speed_within, smooth
from cncgen.toolpath.record import Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import join

#: Control points of the first block, for which the first setpoints wait, and of a block at most (`fixed_blocks`): 128 and 2048 rows that
#: are straight.
FIRST, MOST = 512, 8192
#: Results that wait while another is made and this one is worked on, and meshes that do: their times differ more, as some windows need
#: more runs. With two in wait solving and reading together take 5 % less time.
PREFETCHED, MESHES = 1, 2


def smooth_blocks(
    chunks: Iterable[Toolpath],
    machine: Machine,
    seen: Callable[[Iterable[Toolpath]], Iterable[Toolpath]] = iter,
) -> Iterator[tuple[Toolpath, SpeedCap | None]]:
    """Yield consecutive stretches of a program, smoothed within their tolerances, in blocks.

    They have a cap only where the tolerance is so narrow that smoothing and chords have to share it. `seen` is handed speeds in place
    of the times of G93.
    """
    steady = seen(paced(chunks, lambda axes: AxisLimits.of(machine, axes)))
    for block in blocks(smooth(steady, machine), FIRST, MOST):
        speed = chord_speed_within(block, chord_reserve(machine, block.axes), machine.period_s)
        yield block, SpeedCap(speed, Limit.CHORD, straight=False) if speed else None


def plan_blocks(
    source: Iterable[tuple[Toolpath, SpeedCap | None]],
    machine: Machine,
    contour_centripetal: float = np.inf,
    coarse: bool = False,
) -> Generator[Trajectory, None, None]:
    """Plan the least time of blocks as they are, each maybe under a cap of its speed.

    Args:
        source: Blocks and their caps; drawn in a thread of its own, as windows are solved in another.
        machine: Limits, period, chord tolerance.
        contour_centripetal: See `AxisLimits.of`.
        coarse: The plan is where the search for a better path within the tolerance starts, and has few nodes where there is one.

    Yields:
        Trajectories, from rest to rest, as their speeds become final. A block that moves is the toolpath of its
        trajectories, or ends it.

    Raises:
        NoPlanError: No motion within the limits was found.
    """

    def bounds_of(axes: str) -> AxisLimits:
        return AxisLimits.of(machine, axes, contour_centripetal)

    timeline = Timeline()
    solved = _solved(source, bounds_of, coarse)
    # The next window beside sampling and writing this one; a coarse plan is in a thread of its own as a whole.
    with closing(solved if coarse else prefetch(solved, PREFETCHED)) as windows:
        for each in windows:
            if isinstance(each, Toolpath):
                yield _standing(each, timeline.t_s)
            else:
                yield from timeline.trajectories(each)


def _solved(
    source: Iterable[tuple[Toolpath, SpeedCap | None]], bounds_of: Callable[[str], AxisLimits], coarse: bool
) -> Generator[SolvedWindow | Toolpath, None, None]:
    """Yield the final parts, window by window, and toolpaths that stand still."""
    window: RollingWindow | None = None
    with closing(prefetch(_meshes(source, bounds_of, coarse), MESHES)) as meshes:
        for mesh, last in meshes:
            if isinstance(mesh, Toolpath):
                yield mesh
                continue
            if window is None:
                window = RollingWindow(bounds_of(mesh.toolpath.axes))
                if coarse and np.any(mesh.toolpath.path_mode == PathMode.CONTINUOUS):
                    # The search that starts from it ends at 10⁻⁶ of the time.
                    window.unsettled = 0
            window.meshes.append(mesh)
            yield from window.advance(last)


def _meshes(
    source: Iterable[tuple[Toolpath, SpeedCap | None]], bounds_of: Callable[[str], AxisLimits], coarse: bool
) -> Iterator[tuple[Mesh | Toolpath, bool]]:
    """Yield the meshes of a program and whether each is the last one; after it, maybe, a toolpath that stands still."""
    held: tuple[Toolpath, Path, SpeedCap | None, tuple[BlockEnd, BlockEnd]] | None = None
    before: BlockEnd | None = None
    still: list[Toolpath] = []
    bounds: AxisLimits | None = None

    for block, cap in source:
        still.append(block)
        if not _moves(block):
            continue
        toolpath = join(still)
        still = []
        path = toolpath.path
        bounds = bounds or bounds_of(toolpath.axes)
        ends = ends_of(toolpath, path, bounds)
        if held is not None:
            yield mesh_of(*held[:2], bounds, before, ends[0], held[2], coarse), False
            before = held[3][1]
        held = toolpath, path, cap, ends
    if held is not None and bounds is not None:
        yield mesh_of(*held[:2], bounds, before, None, held[2], coarse), True
    if still:
        yield join(still), True


def _moves(toolpath: Toolpath) -> bool:
    return bool(np.any(toolpath.kind != Kind.EVENT)) and toolpath.path.length > 0.0


def _standing(toolpath: Toolpath, t_s: float) -> Trajectory:
    """Return the trajectory of a toolpath that does not move: its events and their dwells."""
    path = toolpath.path
    events = [(0, line, event) for _, line, event in toolpath.event_rows]
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
