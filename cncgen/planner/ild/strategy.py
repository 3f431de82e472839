"""`ild`: look-ahead dynamics-based interpolation (Tsai 2010).

Three modules, as in the paper: sharp corners (`sharp_corners`), jerk-limited profiles between them with a backward
and a forward pass over the corner speeds (`look_ahead`), and the dynamics that hold the predicted contour error under
the machine's bound (`dynamics`). Limits hold along the path, not for every axis; `optimal` holds the limits of the axes. docs/ild.md
has the method, figures and our own additions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.machine.record import Machine
from cncgen.planner.ild.dynamics import Dynamics
from cncgen.planner.ild.look_ahead import build, joint_speeds, settled
from cncgen.planner.ild.open_stretches import OpenStretches
from cncgen.planner.ild.sharp_corners import CornerRule
from cncgen.planner.ild.stretch import RowEnd, Stretch, stretch_of
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory
from cncgen.planner.smoothing import smooth
from cncgen.toolpath.record import Toolpath
from cncgen.toolpath.slicing import between

#: Samples of the predicted contour error that a window of the look-ahead takes up, where its rows let it be cut there.
WINDOW_SAMPLES = 1 << 19


def plan_ild(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Plan by sharp corners, jerk-limited segments and servo dynamics, after the smoothing that `optimal` has (G64).

    Args:
        chunks: Consecutive stretches of one program.
        machine: A_max and J_max are its weakest moving axis's (A_max of the corner rule also its
            `max_centripetal_mm_s2`); δ is its chord tolerance, ε_max its `max_contour_error_mm`.
        options: `profile`, `kbar_per_mm`, `corner_distance_mm`, `max_contour_error_mm`, `servos`, `lookahead_rows`.

    Yields:
        Trajectories, from rest to rest; a chunk's may come in several parts, as its speeds become final.

    Raises:
        UsageError: A contour error is asked for and an axis has no servo data to predict it with.
        ProgramError: A cutting motion has no feed.
        NoPlanError: A window of the look-ahead takes so long that its contour error cannot be predicted.
    """
    rule = CornerRule(
        machine.chord_tolerance_mm, machine.period_s, options.kbar_per_mm, options.corner_distance_mm
    )
    dynamics = Dynamics.of(machine, options)
    centripetal = dynamics.centripetal if dynamics else np.inf
    window = OpenStretches()
    longest = WINDOW_SAMPLES * machine.period_s if dynamics else np.inf

    def stretches() -> Iterator[Stretch]:
        end: RowEnd | None = None
        for chunk in smooth(chunks, machine=machine):
            whole = stretch_of(chunk, machine, rule, end, centripetal)
            parts = _parts(whole, longest)
            for part in parts:
                stretch = whole if len(parts) == 1 else stretch_of(part, machine, rule, end, centripetal)
                end = stretch.end
                yield stretch

    for stretch in stretches():
        window.stretches.append(stretch)
        if len(window) >= options.lookahead_rows or window.least_time_s() >= longest:
            yield from _advance(window, options, dynamics, last=False)
    yield from _advance(window, options, dynamics, last=True)


def _parts(stretch: Stretch, longest_s: float) -> list[Toolpath]:
    """Cut the toolpath of a stretch between rows into parts that take about `longest_s` at their top speeds."""
    arrival = np.concatenate([[0.0], np.cumsum(np.diff(stretch.s) / stretch.top)])
    if not arrival[-1] > longest_s:
        return [stretch.toolpath]
    part = np.interp(stretch.path.row_s, stretch.s, arrival) // longest_s
    cuts = np.flatnonzero(np.diff(part[:-1])) + 1
    bounds = [0, *cuts.tolist(), len(stretch.toolpath)]
    return [between(stretch.toolpath, a, b) for a, b in pairwise(bounds)]


def _advance(
    window: OpenStretches, options: PlanOptions, dynamics: Dynamics | None, last: bool
) -> Iterator[Trajectory]:
    """Plan the window and hand on the final part: all of it at the end of the program."""
    if not window.stretches:
        return
    open_path = window.open_path()
    segments = open_path.segments
    n = len(segments)
    joint = np.arange(n + 1)
    remarks: tuple[Diagnostic, ...] = ()
    if dynamics is not None:
        segments, joint, worst = dynamics.refine(window, open_path, options.profile, last)
        if worst > dynamics.bound_mm * 1.001:
            remarks = (_not_held(worst, dynamics.bound_mm),)
    speeds = joint_speeds(segments, window.speed_mm_s, 0.0, options.profile)
    upto = n if last else _final(settled(segments, window.speed_mm_s, options.profile), joint)
    if not last and upto < n // 2:
        # No stop is found within the window: the rest is planned as if the program ended with it.
        upto = max(upto, n // 2)
    pieces = build(segments, speeds, options.profile)
    if dynamics is not None:
        dynamics.commit(window, segments, joint, pieces, upto)
    for trajectory in window.hand_on(open_path, pieces, joint, speeds, upto):
        yield replace(trajectory, values={**trajectory.values, "diagnostics": remarks})
        remarks = ()


def _final(joints: int, joint: np.ndarray) -> int:
    """Return how many of the window's own segments end among the first `joints` joints of the finer cut."""
    return max(0, int(np.searchsorted(joint, joints)) - 1)


def _not_held(worst: float, bound: float) -> Diagnostic:
    return Diagnostic(
        "contour-error",
        f"the predicted contour error reaches {worst * 1000:.4g} µm, above {bound * 1000:.4g} µm, "
        "and lower speeds do not bring it down",
        severity=Severity.WARNING,
        hint="the axes' loops differ, or lag even at low speed; see docs/ild.md",
    )
