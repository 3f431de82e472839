"""The method of `optimal`: blocks of the toolpath become meshes, a window of meshes becomes trajectories."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.least_time.breakpoints import Breakpoints, PathBlock, breakpoints_of
from cncgen.planner.least_time.crawling import paced
from cncgen.planner.least_time.mesh import ENTER, ENTER_BACK, LEAVE, LEAVE_BACK, LINE, Mesh, mesh_of
from cncgen.planner.least_time.prefetch import prefetch
from cncgen.planner.least_time.rolling_window import RollingWindow
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.least_time.timeline import SolvedWindow, Timeline
from cncgen.planner.limits.axis_limits import AxisLimits, chord_reserve
from cncgen.planner.record import Limit, Trajectory
from cncgen.planner.smoothing import chord_speed_within, smooth
from cncgen.toolpath.record import Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import between, join

#: Control points of the first block, for which the first setpoints wait, and of a block at most (`blocks`): 128 and 2048 rows that
#: are straight.
FIRST, MOST = 512, 8192
#: Results that wait while another is made and this one is worked on, and meshes that do: their times differ more, as some windows need
#: more runs. With two in wait solving and reading together take 5 % less time.
PREFETCHED, MESHES = 1, 2
#: A row counts as much as this many control points of a NURBS: nodes stand about its ends, and about the knots of a curve.
_ROW = 4
#: Breakpoints of a neighbour that a block is classified with. A difference of setpoints spans three periods; where rows take a
#: twentieth of a period, it spans about 60 of them.
_BESIDE = 64


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


def blocks(chunks: Iterable[Toolpath], size: int, most: int) -> Iterator[Toolpath]:
    """Cut a toolpath into blocks of about the same work: the plan then does not depend on how the input was cut into chunks.

    Yields toolpaths of `size` control points, then half as many again each time up to `most`, the last one smaller.

    A row between short ones has up to `_ROW` control points and counts as these, a rounded corner some twenty, a curve of a thousand as a
    thousand. So memory, and the time until the first block is there, depend on the work that rows make, not on their number.
    """
    held: list[Toolpath] = []
    done = 0
    for chunk in chunks:
        upto = done + np.cumsum(_sizes(chunk))
        first = 0
        while first < len(chunk) and upto[-1] >= size:
            last = int(np.searchsorted(upto, size)) + 1
            yield join([*held, between(chunk, first, last)])
            upto -= upto[last - 1]
            held, first, size = [], last, min(3 * size // 2, most)
        if first < len(chunk):
            held.append(between(chunk, first, len(chunk)))
        done = int(upto[-1]) if len(chunk) else done
    if held:
        yield join(held)


def _sizes(toolpath: Toolpath) -> NDArray[np.int64]:
    """Return the work of rows, shape (n,)."""
    out = np.full(len(toolpath), _ROW, np.int64)
    curves = np.flatnonzero(toolpath.kind == Kind.NURBS)
    points = np.diff(toolpath.nurbs.point_offset)
    out[curves] = np.maximum(points[toolpath.curve[curves]], _ROW)
    return out


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
            if window.meshes:
                _rest_alike(window.meshes[-1], mesh)
            window.meshes.append(mesh)
            yield from window.advance(last)


def _meshes(
    source: Iterable[tuple[Toolpath, SpeedCap | None]], bounds_of: Callable[[str], AxisLimits], coarse: bool
) -> Iterator[tuple[Mesh | Toolpath, bool]]:
    """Yield the meshes of a program and whether each is the last one; after it, maybe, a toolpath that stands still."""
    held: tuple[PathBlock, Breakpoints] | None = None
    before: Breakpoints | None = None
    still: list[Toolpath] = []
    bounds: AxisLimits | None = None

    for toolpath, cap in source:
        still.append(toolpath)
        if not _moves(toolpath):
            continue
        toolpath = join(still)
        still = []
        bounds = bounds or bounds_of(toolpath.axes)
        block = PathBlock.of(toolpath, cap, bounds)
        points = breakpoints_of(block, bounds)
        if held is None:
            points.rest[0] = True
        else:
            yield mesh_of(*held, (before, points.head(_BESIDE)), bounds, coarse), False
            before = (before.followed_by(held[1]) if before else held[1]).tail(_BESIDE)
        held = block, points
    if held is not None and bounds is not None:
        held[1].rest[-1] = True
        yield mesh_of(*held, (before, None), bounds, coarse), True
    if still:
        yield join(still), True


def _rest_alike(one: Mesh, other: Mesh) -> None:
    """Let a motion that rests on one side of the border of two meshes rest on both.

    Either mesh was classified with the corners beside the border, but not with all that are further away.
    """
    if not (one.stop[-1] or other.stop[0]):
        return
    one.stop[-1] = other.stop[0] = True
    if not (one.kind[-1] == ENTER_BACK and other.kind[0] == LEAVE_BACK):
        one.kind[-1] = LINE if one.kind[-1] == LINE else ENTER
        other.kind[0] = LINE if other.kind[0] == LINE else LEAVE


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
