"""Plans planned again: the speed of one plan along the path becomes the largest speed of the next one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic
from cncgen.machine.record import Machine
from cncgen.planner.least_time.block_planning import plan_blocks
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.motion import joined, motion_at, time_at
from cncgen.planner.record import Limit, Profile, Trajectory
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]

#: Least speed of a plan that counts as a cap, by the step of speed that setpoints may show.
_SLOWEST = 0.01


@dataclass(frozen=True, slots=True)
class PlannedBlock:
    """A toolpath with all of its plan, and its diagnostics."""

    toolpath: Toolpath
    profile: Profile
    remarks: tuple[Diagnostic, ...]


def by_block(trajectories: Iterable[Trajectory]) -> Iterator[PlannedBlock]:
    """Join the consecutive trajectories that share a toolpath."""
    parts: list[Trajectory] = []
    for trajectory in trajectories:
        if parts and trajectory.toolpath is not parts[0].toolpath:
            yield _joined(parts)
            parts = []
        parts.append(trajectory)
    if parts:
        yield _joined(parts)


def _joined(parts: list[Trajectory]) -> PlannedBlock:
    remarks = tuple(remark for part in parts for remark in part.values.get("diagnostics", ()))
    return PlannedBlock(parts[0].toolpath, joined([part.profile for part in parts]), remarks)


def replan(trajectories: Iterable[Trajectory], machine: Machine) -> Iterator[Trajectory]:
    """Plan the paths of trajectories again with the limits of a machine, nowhere faster than they are; remarks of the first plan go on.

    Speeds below a hundredth of J T² and A T, which a plan has beside its stops alone, do not count as caps.

    Raises:
        NoPlanError: No motion within the limits was found.
    """
    slowest = _SLOWEST * AxisLimits.of(machine, "".join(machine.axes)).speed_step.min()
    remarks: deque[Diagnostic] = deque()

    def blocks() -> Iterator[tuple[Toolpath, SpeedCap]]:
        for block in by_block(trajectories):
            remarks.extend(block.remarks)
            yield block.toolpath, SpeedCap(speed_along(block.profile, slowest), Limit.FEED)

    for trajectory in plan_blocks(blocks(), machine):
        said = tuple(remarks.popleft() for _ in range(len(remarks)))
        yield with_remarks(trajectory, said)


def with_remarks(trajectory: Trajectory, remarks: tuple[Diagnostic, ...]) -> Trajectory:
    """Return the trajectory with further remarks."""
    if not remarks:
        return trajectory
    known = tuple(trajectory.values.get("diagnostics", ()))
    return replace(trajectory, values={**trajectory.values, "diagnostics": known + remarks})


def speed_along(profile: Profile, slowest: float) -> Callable[[Floats, Floats | None], Floats]:
    """Return the function that gives the speed of a profile at ascending path coordinates, mm/s, at least `slowest`."""

    def speed(s: Floats, _x: Floats | None = None) -> Floats:
        return np.maximum(motion_at(profile, time_at(profile, s)).v, slowest)

    return speed
