"""Verifying: setpoints, ours or anyone's, judged against the programmed path and the machine's limits.

Nothing here is shared with the planner beyond reading the program: the path is flattened by other means (`flatten`),
speeds are finite differences of the setpoints (`limits`), distances those of the polylines (`distance`).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, UsageError
from cncgen.machine.record import Machine
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.stream import SetpointStream
from cncgen.toolpath.record import Toolpath
from cncgen.units import file_unit
from cncgen.verify.distance import Distances, path_to_setpoints, setpoints_to_path
from cncgen.verify.flatten import Floats, Polyline, flatten
from cncgen.verify.limits import RESOLUTION, judge_limits
from cncgen.verify.verdict import Peak, Verdict, breach

__all__ = ["Peak", "Verdict", "verify"]


def verify(
    setpoints: SetpointStream,
    toolpaths: Iterable[Toolpath],
    machine: Machine,
    *,
    tolerance_mm: float | None = None,
    named: str | None = None,
    resolution: float = RESOLUTION,
) -> Verdict:
    """Judge setpoints against a program and a machine.

    Args:
        setpoints: What is judged; drawn whole (memory: some 100 bytes a sample and axis, and as much a segment of the path).
        toolpaths: The program, as it is read.
        machine: Limits, travel, tolerances.
        tolerance_mm: Tolerance of every continuous motion, over what the program says.
        named: Axes that the program names; None: all of its toolpath's. Where another one stands is not known: it has
            to stand still.
        resolution: What the positions are rounded to, mm and degrees: a difference may be over its limit by what that
            makes of it.

    Returns:
        Peaks of each axis and both distances, with a diagnostic for each limit that is broken.

    Raises:
        ProgramError: The program has neither motions nor events.
        UsageError: The setpoints have none of its axes.
    """
    path = flatten(toolpaths, machine, tolerance_mm)
    if path is None:
        raise ProgramError(
            Diagnostic("no-motion", "the program has nothing to run, so there is no path to verify against")
        )
    given = setpoints.collect()
    axes, position = given.axes, file_units(given.position, given.axes)
    breaches = _missing_axes(path, axes)
    shared = [letter for letter in path.axes if letter in axes and letter in (named or path.axes)]
    if not shared:
        raise UsageError(
            Diagnostic(
                "verify-axes", f"the setpoints have axes {axes}, the program {path.axes}: none is common"
            )
        )
    points = np.ascontiguousarray(position[:, [axes.index(letter) for letter in shared]])
    _moving_unasked(position, axes, shared, machine, breaches)
    there = _restricted(path, [path.axes.index(letter) for letter in shared])
    out, back = setpoints_to_path(points, there), path_to_setpoints(points, there)
    lines = there.line[out.segment]
    peaks, over = judge_limits(position, axes, given.period_s, machine, lines, resolution)
    breaches.extend(over)
    _judge_distance(out, back, there, given.period_s, breaches)
    return Verdict(
        len(points),
        given.period_s,
        tuple(peaks),
        out.largest,
        back.largest,
        breaches,
    )


def _missing_axes(path: Polyline, axes: str) -> Diagnostics:
    """Name the axes that the program moves and the setpoints do not have."""
    found = Diagnostics()
    for column, letter in enumerate(path.axes):
        if letter not in axes and np.ptp(path.points[:, column]) > 0:
            found.add(
                breach(
                    "axis", f"axis {letter} moves in the program, and the setpoints have none", axis=letter
                )
            )
    return found


def _moving_unasked(
    position: Floats, axes: str, shared: list[str], machine: Machine, breaches: Diagnostics
) -> None:
    """Name the axes that the setpoints move and the program does not name."""
    for column, letter in enumerate(axes):
        travelled = float(np.ptp(position[:, column]))
        if letter not in shared and travelled > machine.chord_tolerance_mm:
            message = f"axis {letter} moves by {travelled:.6f} {file_unit(letter)}, and the program does not name it"
            breaches.add(breach("axis", message, axis=letter, value=travelled))


def _restricted(path: Polyline, columns: list[int]) -> Polyline:
    points = np.ascontiguousarray(path.points[:, columns])
    axes = "".join(path.axes[column] for column in columns)
    return Polyline(axes, points, path.line, path.tolerance, path.source, path.sources)


def _judge_distance(
    out: Distances, back: Distances, path: Polyline, period_s: float, breaches: Diagnostics
) -> None:
    if out.broken:
        t_s, line = out.worst_place * period_s, int(path.line[out.worst_segment])
        breaches.add(
            breach(
                "distance",
                f"the setpoints are {out.worst:.6f} mm from the programmed path at t = {t_s:.4f} s "
                f"(line {line}), over the tolerance of {out.tolerance:g} mm; so are {out.over} samples in all",
                value=out.worst,
                limit=out.tolerance,
                t_s=t_s,
                line=line,
                samples=out.over,
            )
        )
    if back.broken:
        line = int(path.line[back.worst_place])
        end = path.points[back.worst_place + 1]
        where = ", ".join(f"{axis}{value:.4f}" for axis, value in zip(path.axes, end, strict=True))
        t_s = back.worst_segment * period_s
        breaches.add(
            breach(
                "coverage",
                f"the setpoints pass {back.worst:.6f} mm from the programmed path near {where} (line {line}), "
                f"over the tolerance of {back.tolerance:g} mm; they are nearest at t = {t_s:.4f} s",
                value=back.worst,
                limit=back.tolerance,
                t_s=t_s,
                line=line,
            )
        )
