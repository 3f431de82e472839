"""A plan as another control would make it: its times, not its setpoints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.machine.record import Machine
from cncgen.planner.assembly import assemble, events_before, timed, waits_of
from cncgen.planner.controls.control_blocks import Blocks, blocks_of
from cncgen.planner.controls.rules import CONTROLS, Control
from cncgen.planner.controls.trapezoids import cut_at, entry_speeds, trapezoids
from cncgen.planner.limits.row_limits import RowLimits
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]


def plan_as(chunks: Iterable[Toolpath], machine: Machine, name: str) -> Iterator[Trajectory]:
    """Plan chunks of a toolpath by the rules of a control.

    The look-ahead and the rules of corners reach over the borders of chunks.

    Args:
        chunks: Consecutive stretches of one program.
        machine: Velocity and acceleration of its axes; jerk is not limited.
        name: One of `cncgen.planner.controls.rules.CONTROLS`.

    Yields:
        Trajectories whose positions are on the programmed path. Where the control cuts a corner, the time is that of its
        shorter way. The first one has a remark that names the control.

    Raises:
        ProgramError: A row has no feed.
    """
    control = CONTROLS[name]
    waiting: tuple[Toolpath, Blocks, RowLimits] | None = None
    state = _State()
    remark = Diagnostic(
        "plan-estimate",
        f"an estimate of {control.title}: trapezoids of speed by its rules, with the velocities and accelerations of {machine.name}",
        severity=Severity.NOTE,
        hint="docs/times.md compares it with the control itself where that can be run",
    )
    for chunk in chunks:
        blocks, rows = blocks_of(chunk, machine, control.chord_mm)
        if waiting is not None:
            yield _planned(waiting, blocks, control, machine, state, remark)
        waiting = (chunk, blocks, rows)
    if waiting is not None:
        yield _planned(waiting, None, control, machine, state, remark)


class _State:
    """The state of a plan at the end of a chunk: time, speed, and whether a trajectory was handed on."""

    def __init__(self) -> None:
        self.t_s = self.speed_mm_s = 0.0
        self.begun = False


def _planned(
    waiting: tuple[Toolpath, Blocks, RowLimits],
    following: Blocks | None,
    control: Control,
    machine: Machine,
    state: _State,
    remark: Diagnostic,
) -> Trajectory:
    """Plan the blocks of a chunk, with those that follow as look-ahead; move `state` to its end."""
    chunk, own, rows = waiting
    joined = own if following is None else own.followed(_marked(following, control.depth, len(rows)))
    blocks = control.rules(joined, chunk.axes, machine)
    speed = entry_speeds(blocks, control.depth, state.speed_mm_s)
    count = int(np.searchsorted(blocks.row, len(rows)))
    first = float(rows.start[0]) if len(rows) else float(np.asarray(chunk.path.row_s)[0])
    mine, slowing_s = blocks.part(slice(0, count)), control.slowing_periods * machine.period_s
    pieces = trapezoids(mine, speed[: count + 1], slowing_s)
    (duration, v, a), ends, limit = cut_at(rows.start, *pieces, first)
    owner = np.searchsorted(rows.end, ends - 0.5 * np.diff(ends, prepend=first), side="left")
    offset = np.searchsorted(owner, np.arange(len(rows) + 1))
    events = events_before(chunk, rows.index)
    waits, why = waits_of(events, len(rows) + 1), np.full(len(rows) + 1, Limit.STOP, np.int8)
    stops = _rests(blocks, speed, len(rows)) & (waits == 0.0)
    waits[stops] = control.stop_periods * machine.period_s
    why[stops] = Limit.CORNER
    place = np.append(first, ends)
    zero = np.zeros(len(a))
    profile, arrival = assemble(state.t_s, place, (duration, v, a, zero, zero), limit, offset, waits, why)
    state.t_s, state.speed_mm_s = float(profile.t[-1]), float(speed[count])
    values = {} if state.begun else {"diagnostics": (remark,)}
    state.begun = True
    return Trajectory(chunk, np.asarray(chunk.path.row_s), profile, timed(events, arrival), values=values)


def _rests(blocks: Blocks, speed: Floats, rows: int) -> NDArray[np.bool_]:
    """Tell the joints of moving rows at which the motion comes to rest, the start of the chunk left out, shape (rows + 1,)."""
    found = np.zeros(rows + 1, np.bool_)
    begins = np.append(blocks.row, rows)
    at = np.flatnonzero((speed == 0.0) & (begins <= rows))
    found[begins[at]] = True
    found[0] = False
    return found


def _marked(following: Blocks, depth: int, first: int) -> Blocks:
    """Return the first blocks of the next chunk, their rows numbered from `first` on."""
    part = following.part(slice(0, depth))
    return replace(part, row=part.row + first)
