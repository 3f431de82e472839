"""Feedrate strategies and interpolators side by side on one program: the figures behind ``cncgen compare``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import CncgenError, Diagnostic, UsageError
from cncgen.machine.record import Machine, Servo
from cncgen.planner import PlanOptions, plan
from cncgen.planner.checks import checked
from cncgen.planner.contour_prediction import predicted_errors, servo_of
from cncgen.planner.interpolators import retime
from cncgen.planner.motion import motion_at, time_at
from cncgen.planner.options import INTERPOLATORS
from cncgen.planner.record import Trajectory
from cncgen.planner.strategies import FEEDRATES, strategy
from cncgen.servo.command_limits import breaks, broken_values
from cncgen.servo.contour import contour_error
from cncgen.servo.record import Response
from cncgen.servo.simulate import simulate
from cncgen.servo.summary import summarize
from cncgen.servo.wanted_motion import WantedMotion, distance_from_path
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.sampling import sample
from cncgen.setpoints.two_stage import KINDS, two_stage
from cncgen.toolpath.record import Toolpath
from cncgen.units import AXIS_LETTERS

Floats = NDArray[np.float64]

#: Steps shorter than this part of the longest are left out of the fluctuation: a machine at rest has no feed.
_LEAST_STEP = 1e-6

#: How long the last setpoint is held for the axes to come to rest.
_SETTLE_S = 0.1


@dataclass(frozen=True, slots=True)
class Demand:
    """Demands of setpoints on drives and limits.

    Attributes:
        effort: By axis (lower case), the largest drive input and its unit; None without servo data.
        saturated: Setpoints with a drive at its bound; None without servo data.
        breaks: Axis, limit and ratio of each limit that they break (`cncgen.servo.command_limits.broken_values`).
    """

    effort: Mapping[str, tuple[float, str]] | None
    saturated: int | None
    breaks: Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class StrategyFigures:
    """A program under one strategy; None where the machine's servo data do not allow the figure.

    Attributes:
        feedrate: Name of the strategy.
        time_s: Motion and dwells.
        contour_max_mm, contour_rms_mm: True contour error of the simulated axes: distance from the commanded path. The
            largest one counts while they come to rest as well: strategies that end in motion overshoot there.
        predicted_max_mm: The contour error that Tsai's eqs 15 to 18 predict.
        acceleration, jerk: Largest second and third difference of the setpoints over all axes, rest before and
            after included; mm (or rad) and s.
        acceleration_of_limit, jerk_of_limit: The same, each as a fraction of its axis's limit.
        reference_max_mm: The largest distance of the simulated axes from a reference, where there is one.
        demand: Demands of the setpoints on drives and limits.
        fault: Why the strategy has no figures, where it fails.
    """

    feedrate: str
    time_s: float | None = None
    contour_max_mm: float | None = None
    contour_rms_mm: float | None = None
    predicted_max_mm: float | None = None
    acceleration: float | None = None
    jerk: float | None = None
    acceleration_of_limit: float | None = None
    jerk_of_limit: float | None = None
    reference_max_mm: float | None = None
    demand: Demand | None = None
    fault: Diagnostic | None = None


@dataclass(frozen=True, slots=True)
class Fluctuation:
    """How far an interpolator's steps differ from the steps that the feed commands.

    Attributes:
        interpolator: Its name.
        max_part, rms_part: Largest and root mean square of travelled / commanded − 1.
        time_s: Time of the motion, which the interpolator may change.
        path_error_mm: Largest distance of its setpoints from the path through the setpoints of the exact one.
        contour_max_mm: Largest distance of the simulated axes from that path; None where servo data do not allow it.
        reference_max_mm, demand: As of `StrategyFigures`.
        fault: Why it has no figures, where it fails.
    """

    interpolator: str
    max_part: float
    rms_part: float
    time_s: float
    path_error_mm: float | None = None
    contour_max_mm: float | None = None
    reference_max_mm: float | None = None
    demand: Demand | None = None
    fault: Diagnostic | None = None


def compare_strategies(
    toolpaths: Sequence[Toolpath],
    machine: Machine,
    options: PlanOptions,
    names: Sequence[str] | None = None,
    axes: str | None = None,
    reference: WantedMotion | None = None,
) -> list[StrategyFigures]:
    """Plan, sample and simulate a program with each of several strategies.

    Args:
        toolpaths: The program.
        machine: Limits and servo data.
        options: Everything but the strategy.
        names: Strategies; None: ``adaptive``, ``curvature``, ``ild`` and ``optimal``.
        axes: Columns that are simulated; None: the axes that the program moves.
        reference: Setpoints whose path they are judged by too.

    Returns:
        Figures of each, in that order. A strategy without a plan has the reason in `fault`.

    Raises:
        UsageError: A strategy is unknown.
    """
    check_names("feedrate", names or (), FEEDRATES)
    chosen = names or ("adaptive", "curvature", "ild", "optimal")
    moved = axes or moving_axes(toolpaths)
    figures = []
    for name in chosen:
        asked = replace(options, feedrate=name)
        try:
            figures.append(_figures(toolpaths, machine, asked, moved, reference))
        except CncgenError as problem:
            figures.append(StrategyFigures(name, fault=problem.diagnostics[0]))
    return figures


def check_names(what: str, names: Sequence[str], known: Sequence[str]) -> None:
    """Raise `UsageError` that names every one of the names that is not known."""
    faults = [
        Diagnostic("option-value", f"{what} = {name!r} is not one of {', '.join(known)}")
        for name in names
        if name not in known
    ]
    if faults:
        raise UsageError(faults)


def moving_axes(toolpaths: Iterable[Toolpath]) -> str:
    """Return the letters of the axes that a program moves."""
    letters: list[str] = []
    for toolpath in toolpaths:
        x = np.concatenate([toolpath.start[None], toolpath.end, toolpath.path.evaluate(_probes(toolpath))[0]])
        moves = np.ptp(x, axis=0) > 1e-9
        letters += [c for c, m in zip(toolpath.axes, moves, strict=True) if m and c not in letters]
    return "".join(letter for letter in AXIS_LETTERS if letter in letters)


def _probes(toolpath: Toolpath) -> Floats:
    s = toolpath.path.row_s
    return np.unique(np.concatenate([s, 0.5 * (s[:-1] + s[1:]), s[:-1] + 0.3 * np.diff(s)]))


def _figures(
    toolpaths: Sequence[Toolpath],
    machine: Machine,
    options: PlanOptions,
    axes: str,
    reference: WantedMotion | None,
) -> StrategyFigures:
    trajectories = list(plan(toolpaths, machine, options))
    setpoints = list(sample(trajectories, machine, axes=axes))
    position = np.concatenate([chunk.position for chunk in setpoints])
    second, third = (_peaks(position, order, machine.period_s) for order in (2, 3))
    limits = [machine.axes[letter] for letter in axes]
    responses = _responses(setpoints, machine, options, axes)
    errors = None if responses is None else _contour_errors(responses, axes)
    predicted = predicted_errors(trajectories, machine, options)
    return StrategyFigures(
        feedrate=options.feedrate or FEEDRATES[0],
        time_s=float(trajectories[-1].profile.t[-1]),
        contour_max_mm=None if errors is None else float(errors.max()),
        contour_rms_mm=None if errors is None else float(np.sqrt(np.mean(errors[: len(position)] ** 2))),
        predicted_max_mm=None if predicted is None else float(predicted.max(initial=0.0)),
        acceleration=float(second.max()),
        jerk=float(third.max()),
        acceleration_of_limit=float((second / [a.max_acceleration for a in limits]).max()),
        jerk_of_limit=float((third / [a.max_jerk for a in limits]).max()),
        reference_max_mm=_from_reference(reference, responses),
        demand=_demand(setpoints, responses, machine),
    )


def _peaks(position: Floats, order: int, period_s: float) -> Floats:
    """Return the largest difference of some order of each column, rest before the first and after the last row."""
    padded = np.concatenate(
        [np.repeat(position[:1], order, axis=0), position, np.repeat(position[-1:], order, axis=0)]
    )
    peaks: Floats = np.abs(np.diff(padded, order, axis=0)).max(axis=0) / period_s**order
    return peaks


def _responses(
    setpoints: Sequence[Setpoints], machine: Machine, options: PlanOptions, axes: str
) -> list[Response] | None:
    """Return the response of the axes to setpoints, with the settling after the last one; None if one lacks servo data."""
    servos: dict[str, Servo] = {}
    for letter in axes:
        servo = servo_of(machine, options, letter)
        if servo is None:
            return None
        servos[letter] = servo
    return list(simulate(iter(setpoints), servos, settle_s=_SETTLE_S))


def _demand(setpoints: Sequence[Setpoints], responses: Sequence[Response] | None, machine: Machine) -> Demand:
    """Return the demands of setpoints on drives, which gave this response, and on the machine's limits."""
    head = setpoints[0]
    rows = np.concatenate([chunk.position for chunk in setpoints])
    broken = broken_values(breaks(machine.axes, head.axes, rows, head.period_s))
    if responses is None:
        return Demand(None, None, broken)
    summary = summarize(responses)
    effort = {k: (axis["force_max"], axis["force_unit"]) for k, axis in summary["axes"].items()}
    return Demand(effort, summary["saturated_samples"], broken)


def _contour_errors(responses: Sequence[Response], axes: str, path: Floats | None = None) -> Floats | None:
    """Return the contour errors of simulated axes, a row a setpoint and those of coming to rest; None where none is linear.

    They are distances from the path through the setpoints, or through other ones of the same times, `path` of shape (n, axes),
    without those of coming to rest.
    """
    errors = np.concatenate([chunk.contour_error_mm for chunk in responses])
    if path is not None:
        errors = _distances(path, np.concatenate([chunk.position for chunk in responses])[: len(path)], axes)
    return None if np.isnan(errors).all() else errors


def _from_reference(reference: WantedMotion | None, responses: Sequence[Response] | None) -> float | None:
    """Return the largest distance from a reference's path, mm; None without one, or without linear axes."""
    if reference is None or not responses:
        return None
    distances = distance_from_path(reference, responses)
    return None if distances is None else float(distances.max())


def _distances(path: Floats, rows: Floats, axes: str) -> Floats:
    """Return the distance in X Y Z of each row from a path, both of shape (n, axes); zeros without such axes."""
    linear = [k for k, letter in enumerate(axes) if letter in "XYZ"]
    if not linear:
        return np.zeros(len(rows))
    return contour_error(np.ascontiguousarray(path[:, linear]), np.ascontiguousarray(rows[:, linear]))


def compare_interpolators(
    toolpaths: Sequence[Toolpath],
    machine: Machine,
    options: PlanOptions,
    names: Sequence[str] = ("arclength", "taylor1", "taylor2"),
    axes: str | None = None,
    reference: WantedMotion | None = None,
) -> list[Fluctuation]:
    """Measure each interpolator on one plan: its feed, its time, its distance from the path, and that of the simulated axes.

    The feed's fluctuation is travelled against commanded distance of every period. Commanded is what the plan travels in a period
    from the place where the tool is; travelled is the length of the path between two setpoints, measured from the curve's
    parameter at each. Periods that the end of a stretch cuts short are left out, and those that begin in a wait. Two-stage
    interpolation leaves the path, so its feed is that of the plan.

    Raises:
        UsageError: An interpolator is unknown.
    """
    check_names("interpolator", names, INTERPOLATORS)
    exact = replace(options, interpolator="arclength")
    # Interpolators follow a path that is given, so the plan is one of the speed along it.
    along = replace(options, interpolator="uniform")
    planned = list(strategy(options.feedrate)(checked(toolpaths, machine, exact), machine, along))
    moved = axes or moving_axes(toolpaths)
    found = []
    for name in names:
        asked = replace(options, interpolator=name)
        try:
            found.append(_interpolated(planned, machine, asked, moved, reference))
        except UsageError as problem:
            found.append(Fluctuation(name, 0.0, 0.0, 0.0, fault=problem.diagnostics[0]))
    return found


def _interpolated(
    planned: Sequence[Trajectory],
    machine: Machine,
    options: PlanOptions,
    axes: str,
    reference: WantedMotion | None,
) -> Fluctuation:
    """Measure one interpolator of a plan."""
    name, period = options.interpolator, machine.period_s
    found = list(retime(iter(planned), machine, options))
    parts = [part for one, other in zip(planned, found, strict=True) for part in _parts(one, other, period)]
    error = np.concatenate(parts) if parts else np.zeros(0)
    setpoints = list(sample(found, machine, axes=axes))
    off, exact = 0.0, None
    if name in KINDS:
        exact = np.concatenate([chunk.position for chunk in setpoints])
        setpoints = list(two_stage(setpoints, name, options.master_period_s))
        rows = np.concatenate([chunk.position for chunk in setpoints])
        off = float(_distances(exact, rows, axes).max(initial=0.0))
    responses = _responses(setpoints, machine, options, axes)
    contour = None if responses is None else _contour_errors(responses, axes, exact)
    return Fluctuation(
        name,
        float(np.abs(error).max(initial=0.0)),
        float(np.sqrt(np.mean(error**2))) if error.size else 0.0,
        float(found[-1].profile.t[-1]),
        off,
        None if contour is None else float(contour.max()),
        _from_reference(reference, responses),
        _demand(setpoints, responses, machine),
    )


def _parts(planned: Trajectory, moved: Trajectory, period_s: float) -> Iterator[Floats]:
    """Yield travelled / commanded − 1 of the whole periods within one trajectory."""
    p, m = planned.profile, moved.profile
    ticks = np.arange(np.ceil(m.t[0] / period_s), np.floor(m.t[-1] / period_s) + 1.0) * period_s
    if len(ticks) < 2 or not len(p):
        return
    path = planned.toolpath.path
    motion = motion_at(m, ticks)
    s = motion.s
    row = path.row_of(s)
    measured = path.coordinate(row, path.parameter(row, s))
    exact = planned is moved
    then = ticks[:-1] if exact else time_at(p, s[:-1])
    # A period that begins in a wait has no place that the plan leaves at its beginning.
    whole = (then + period_s <= p.t[-1]) & ~m.waits[motion.piece[:-1]]
    aim = motion_at(p, then + period_s).s
    commanded = aim - s[:-1]
    used = whole & (commanded > _LEAST_STEP * commanded.max())
    yield (np.diff(measured)[used] / commanded[used]) - 1.0
