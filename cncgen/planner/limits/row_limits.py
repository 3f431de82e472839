"""The limits along the path of each row of a toolpath, from its feed and from the limits of the axes.

The strategies of the papers plan with speeds and accelerations along the path. A line divides them among the axes in a fixed ratio, so
its limits are exact. On a curve the path may point along any of its axes, so the weakest moved axis counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError
from cncgen.geometry import elementary
from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import AxisLimits, along_path
from cncgen.planner.limits.speeds import Feeds, chord_speed
from cncgen.planner.record import Limit
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Points of a curved row at which the ratios of its axes are looked at.
_PROBES = 17


@dataclass(frozen=True, slots=True)
class RowLimits:
    """The moving rows of a chunk, `m` of them; everything along the path.

    Attributes:
        index: Shape (m,), their row numbers in the toolpath.
        start, end: Shape (m,), path coordinates, mm.
        top: Shape (m,), highest speed, mm/s: feed, axis velocities, and on arcs what curvature and chord allow.
        top_limit: Shape (m,), int8, the `Limit` behind `top`.
        acceleration, jerk: Shape (m,), mm/s² and mm/s³.
        centripetal: Shape (m,), mm/s²: limit of v²κ.
        tangent_in, tangent_out: Shape (m, axes), dx/ds at both ends.
        bend_in, bend_out: Shape (m, axes), d²x/ds² at both ends.
    """

    index: Ints
    start: Floats
    end: Floats
    top: Floats
    top_limit: NDArray[np.int8]
    acceleration: Floats
    jerk: Floats
    centripetal: Floats
    tangent_in: Floats
    tangent_out: Floats
    bend_in: Floats
    bend_out: Floats

    def __len__(self) -> int:
        return len(self.index)

    @property
    def length(self) -> Floats:
        """Shape (m,): length of each row, mm."""
        return self.end - self.start


def row_limits_of(toolpath: Toolpath, path: Path, machine: Machine, bends: bool = True) -> RowLimits:
    """Compute the limits of the moving rows of a chunk.

    Args:
        toolpath: The chunk.
        path: Its geometry.
        machine: Limits, period and chord tolerance.
        bends: Whether the curvature of arcs lowers their top speed.

    Raises:
        ProgramError: A row has no feed greater than 0; every such row is named.
    """
    row_s = np.asarray(path.row_s)
    index = np.flatnonzero((np.diff(row_s) > 0.0) & (toolpath.kind != Kind.EVENT))
    start, end = row_s[index], row_s[index + 1]
    limits = AxisLimits.of(machine, toolpath.axes)
    share, ends = _shares(toolpath, path, index, start, end)
    velocity, acceleration, jerk = (
        along_path(limit, share) for limit in (limits.velocity, limits.acceleration, limits.jerk)
    )
    centripetal = np.minimum(acceleration, machine.max_centripetal_mm_s2 or np.inf)
    top, top_limit = _feeds(toolpath, path, index)
    top, top_limit = _lower(top, top_limit, velocity, Limit.VELOCITY)
    arcs = (toolpath.kind[index] == Kind.ARC) & bends
    curvature = np.where(arcs, np.linalg.norm(ends[2][:, :3], axis=1), 0.0)
    with np.errstate(divide="ignore"):
        top, top_limit = _lower(top, top_limit, np.sqrt(centripetal / curvature), Limit.CENTRIPETAL)
        top, top_limit = _lower(top, top_limit, elementary.cbrt(jerk / curvature**2), Limit.JERK)
    chord = chord_speed(curvature, machine.chord_tolerance_mm, machine.period_s)
    top, top_limit = _lower(top, top_limit, chord, Limit.CHORD)
    return RowLimits(index, start, end, top, top_limit, acceleration, jerk, centripetal, *ends)


def _lower(
    top: Floats, which: NDArray[np.int8], other: Floats, limit: Limit
) -> tuple[Floats, NDArray[np.int8]]:
    binds = other < top
    return np.where(binds, other, top), np.where(binds, np.int8(limit), which)


def _feeds(toolpath: Toolpath, path: Path, index: Ints) -> tuple[Floats, NDArray[np.int8]]:
    """Return the speed that the program asks of each row and the `Limit` behind it; raise where a row has none."""
    feed, rapid = toolpath.feed[index], toolpath.feed_mode[index] == FeedMode.RAPID
    wrong = np.flatnonzero(~rapid & ~(np.isfinite(feed) & (feed > 0.0)))
    if len(wrong):
        faults = (
            Diagnostic(
                "feed-missing",
                f"a cutting motion needs a feed greater than 0, and has {toolpath.feed[row]:g}",
                span=toolpath.span(row),
                hint="give F before the motion",
            )
            for row in index[wrong]
        )
        raise ProgramError(Diagnostics(faults))
    feeds = Feeds.of(toolpath)
    return feeds.speed[index], feeds.limit[index]


def _shares(
    toolpath: Toolpath, path: Path, index: Ints, start: Floats, end: Floats
) -> tuple[Floats, tuple[Floats, Floats, Floats, Floats]]:
    """Return the largest |dx/ds| of each axis in each row, and tangents and bends at both ends."""
    length = end - start
    lines = toolpath.kind[index] == Kind.LINE
    step = (toolpath.end[index] - toolpath.starts[index]) / np.where(length > 0.0, length, 1.0)[:, None]
    share = np.abs(step)
    tangent_in, tangent_out = step.copy(), step.copy()
    bend_in, bend_out = np.zeros_like(step), np.zeros_like(step)
    curved = np.flatnonzero(~lines)
    if len(curved):
        fraction = np.linspace(0.0, 1.0, _PROBES)
        fraction[0], fraction[-1] = 1e-9, 1.0 - 1e-9  # inside the row, where the derivatives are its own
        at = start[curved, None] + fraction * length[curved, None]
        x = path.evaluate(at.ravel(), 2)
        first = x[1].reshape(len(curved), _PROBES, -1)
        second = x[2].reshape(len(curved), _PROBES, -1)
        most = np.abs(first).max(axis=1)
        most[:, :3] = np.where(most[:, :3] > 1e-9, 1.0, 0.0)
        share[curved] = most
        tangent_in[curved], tangent_out[curved] = first[:, 0], first[:, -1]
        bend_in[curved], bend_out[curved] = second[:, 0], second[:, -1]
    return share, (tangent_in, tangent_out, bend_in, bend_out)
