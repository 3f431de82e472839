"""Compensation of setpoints for the axes that follow them: learnt, judged, and refused without a gain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import wrong
from cncgen.diagnostics import Diagnostic, NoPlanError, UsageError
from cncgen.machine.record import Axis, Machine, Servo
from cncgen.planner import PlanOptions, plan
from cncgen.servo.command_limits import Break, breaks, hold
from cncgen.servo.learning import NO_CONTOUR_MM, Axes, Figures, Learnt, WorkBudget, figures_of, follow, learn
from cncgen.servo.norm_optimal import REGULARISATION
from cncgen.servo.simulate import RUNAWAY_MM, contour_axes, own_scheme
from cncgen.servo.uncertainty import Perturbation, perturbed, quantile
from cncgen.setpoints import sample
from cncgen.setpoints.record import Setpoints
from cncgen.toolpath.record import Toolpath
from cncgen.units import file_unit, to_file

Floats = NDArray[np.float64]

#: Passes of learning, at most.
PASSES = 6
#: Most setpoints of a program to learn on: by default, beside them for each of its lines, and for a step that the options allow.
MOST_ROWS, MOST_ROWS_OF_A_LINE, ROWS_OF_A_STEP = 100_000, 2_000, 100
#: A command is good enough where it divides the judged error by this.
ENOUGH = 5.0


@dataclass(frozen=True, slots=True)
class Spread:
    """The judged error on drawn machines, mm (rad of rotary axes alone), shape (draws,) each; inf where a loop is unstable."""

    before: Floats
    after: Floats

    @property
    def worse(self) -> int:
        """Return the number of machines on which the command is worse than the uncompensated motion."""
        return int((self.after > self.before).sum())

    @property
    def fragile(self) -> bool:
        """Tell whether the command does harm on most machines."""
        return 2 * self.worse > len(self.after)


@dataclass(frozen=True, slots=True)
class Compensated:
    """A compensated command.

    Attributes:
        command: Setpoints to send to the machine.
        learnt: How it was found, with its errors.
        spread: The judged error on machines whose parameters are not quite the model's; None: not looked at.
    """

    command: Setpoints
    learnt: Learnt
    spread: Spread | None

    def gained(self) -> dict[str, Any]:
        """Return errors, effort and gain as plain values, in the units of files."""
        axes, period = self.command.axes, self.command.period_s
        before, after = (_in_files(f, axes) for f in (self.learnt.before, self.learnt.after))
        was, now = before["contour_max_mm"], after["contour_max_mm"]
        return {
            "samples": len(self.command),
            "passes": self.learnt.passes,
            "before": before,
            "after": after,
            "contour_max_ratio": was / now if was is not None and now else None,
            "lead_s": self.learnt.lead * period,
            "settle_s": self.learnt.tail * period,
            "perturbed": None if self.spread is None else _spread_values(self.spread, axes),
        }


@dataclass(frozen=True, slots=True)
class CompensatedPlan:
    """A compensated command with the plan that left room for it.

    Attributes:
        compensated: The command.
        room: Share of acceleration and jerk that the plan was allowed.
        time_s, full_time_s: Of this plan, and of one to the whole limits.
        full_error: The judged error of the latter without compensation, mm (rad of rotary axes alone).
    """

    compensated: Compensated
    room: float
    time_s: float
    full_time_s: float
    full_error: float

    def gained(self) -> dict[str, Any]:
        """Return `Compensated.gained` with room and times."""
        more = {"room": self.room, "time_s": self.time_s, "full_time_s": self.full_time_s}
        return {**self.compensated.gained(), **more}


def compensated_plan(
    toolpaths: Sequence[Toolpath],
    machine: Machine,
    servos: Mapping[str, Servo],
    *,
    axes: str,
    options: PlanOptions | None = None,
    rooms: Sequence[float] = (1.0,),
    enough: float = ENOUGH,
    limits: bool = True,
    passes: int = PASSES,
    settle_s: float = 0.1,
    perturbation: Perturbation | None = None,
) -> CompensatedPlan:
    """Plan a program and compensate its setpoints, with more room under the limits until that is good enough.

    Args:
        toolpaths: The program.
        machine: Machine with the limits that the command keeps.
        servos: Servo data by axis.
        axes: Columns of the setpoints.
        options: How it is planned.
        rooms: Shares of acceleration and jerk that plans are made with, one after the other.
        enough: Factor by which the largest error of the first plan is to fall; if no room reaches it, the best one counts.
        limits: Whether the command keeps the limits.
        passes, settle_s, perturbation: As of `compensate`.

    Raises:
        NoPlanError: The program cannot be planned, or as `compensate` for every room.
        UsageError: An axis has no servo data.
    """
    lines = max(int(chunk.line.max(initial=0)) for chunk in toolpaths)
    best: CompensatedPlan | None = None
    work: WorkBudget | None = None
    refusal: NoPlanError | None = None
    full_time = full_error = 0.0
    for room in rooms:
        lowered = _lowered(machine, room)
        setpoints = _sampled(toolpaths, lowered, options, axes, lines)
        time_s = (sum(map(len, setpoints)) - 1) * machine.period_s
        full_time = full_time or time_s
        work = work or WorkBudget.of(_joined(setpoints)[1], lines)
        try:
            found = compensate(setpoints, servos, limits=machine.axes if limits else None, passes=passes,
                               settle_s=settle_s, enough=enough, work=work)  # fmt: skip
        except NoPlanError as error:
            refusal = refusal or error
            if work.over:
                break
            continue
        full_error = full_error or found.learnt.before.judged
        if best is None or found.learnt.after.judged < best.compensated.learnt.after.judged:
            best = CompensatedPlan(found, room, time_s, full_time, full_error)
        if found.learnt.after.judged * enough <= full_error or work.over:
            break
    if best is None:
        assert refusal is not None
        raise refusal
    if perturbation is None:
        return best
    command = best.compensated
    spread = _sound(command.learnt, servos, axes, machine.period_s, perturbation)
    return replace(best, compensated=replace(command, spread=spread))


def _sampled(
    toolpaths: Sequence[Toolpath], machine: Machine, options: PlanOptions | None, axes: str, lines: int
) -> tuple[Setpoints, ...]:
    """Return the setpoints of a plan.

    Raises:
        NoPlanError: They are more than are learnt on (``compensate-long``).
    """
    most = (
        max(MOST_ROWS, ROWS_OF_A_STEP * ((options and options.max_steps) or 0)) + MOST_ROWS_OF_A_LINE * lines
    )
    found, count = [], 0
    for chunk in sample(plan(iter(toolpaths), machine, options), machine, axes=axes):
        found.append(chunk)
        count += len(chunk)
        if count > most:
            message = f"the motion of {lines} lines takes longer than the {most * machine.period_s:.6g} s that are learnt on"
            hint = (
                "--max-steps sets the bound; setpoints of cncgen plan are compensated however many they are"
            )
            raise NoPlanError(Diagnostic("compensate-long", message, hint=hint))
    return tuple(found)


def _lowered(machine: Machine, room: float) -> Machine:
    axes = {
        letter: replace(axis, max_acceleration=axis.max_acceleration * room, max_jerk=axis.max_jerk * room)
        for letter, axis in machine.axes.items()
    }
    return replace(machine, axes=MappingProxyType(axes))


def limits_of(source: str, *, required: bool = False) -> Mapping[str, Axis] | None:
    """Return the axis limits of a machine profile or file; None where it holds servo data alone.

    Raises:
        UsageError: It cannot be read, or has no limits and `required`.
    """
    from cncgen.machine import load_machine, load_servos

    try:
        return load_machine(source).axes
    except UsageError:
        if required:
            raise
        load_servos(source)
        return None


def compensate(
    setpoints: Iterable[Setpoints],
    servos: Mapping[str, Servo],
    *,
    limits: Mapping[str, Axis] | None = None,
    passes: int = PASSES,
    settle_s: float = 0.1,
    enough: float = ENOUGH,
    perturbation: Perturbation | None = None,
    work: WorkBudget | None = None,
) -> Compensated:
    """Return a command under which the axes follow setpoints better, as their model knows them.

    The whole motion is held in memory.

    Args:
        setpoints: The wanted positions, at rest at their first and last row.
        servos: Servo data by axis.
        limits: Axis limits that the command keeps (`cncgen.servo.command_limits`); None keeps none.
        passes: Of learning (`cncgen.servo.learning`), at most.
        settle_s: Least rest at the end.
        enough: As of `cncgen.servo.learning.learn`.
        perturbation: Machines that the command is tried on beside the nominal one.
        work: As of `cncgen.servo.learning.learn`.

    Raises:
        UsageError: `passes` is not positive, the setpoints are empty, or as `cncgen.servo.simulate`.
        NoPlanError: No command follows better (``compensate-no-gain``), or the one that does leaves the travel
            (``compensate-limit``), or it does harm on most of the drawn machines (``compensate-fragile``).
    """
    if passes < 1:
        raise wrong(f"passes = {passes}: at least one is needed")
    head, wanted = _joined(setpoints)
    scheme = own_scheme(servos, head.axes, head.period_s)
    columns = contour_axes(head.axes)
    axes = Axes(scheme.loops, head.period_s, columns, REGULARISATION, head.axes)
    kept = [(limits or {}).get(letter) for letter in head.axes]
    work = work or WorkBudget.of(wanted)
    learnt = learn(wanted, axes, kept, passes=passes, settle_s=settle_s, enough=enough, work=work)
    if learnt.passes == 0 and learnt.before.judged > NO_CONTOUR_MM:
        free = (
            None
            if limits is None or work.over
            else learn(wanted, axes, [None] * len(kept), passes=passes, settle_s=settle_s)
        )
        over = breaks(limits or {}, head.axes, learnt.wanted, head.period_s)
        raise _no_gain(learnt, free, head.axes, work, over)
    command = Setpoints(head.axes, head.period_s, 0, learnt.command)
    hold(command, limits or {})
    spread = None if perturbation is None else _sound(learnt, servos, head.axes, head.period_s, perturbation)
    return Compensated(command, learnt, spread)


def _joined(setpoints: Iterable[Setpoints]) -> tuple[Setpoints, Floats]:
    chunks = [chunk for chunk in setpoints if len(chunk)]
    if not chunks:
        raise UsageError(Diagnostic("setpoints-empty", "there are no setpoints"))
    return chunks[0], np.concatenate([np.asarray(chunk.position, float) for chunk in chunks])


def _sound(
    learnt: Learnt, servos: Mapping[str, Servo], axes: str, period_s: float, perturbation: Perturbation
) -> Spread:
    """Return `spread_of`; refuse a command that does harm on most machines."""
    spread = spread_of(learnt, servos, axes, period_s, perturbation)
    if spread.fragile:
        raise NoPlanError(_fragile(learnt, spread, axes, perturbation))
    return spread


def _fragile(learnt: Learnt, spread: Spread, letters: str, perturbation: Perturbation) -> Diagnostic:
    unit, factor = _shown(letters)
    drawn = [float(np.quantile(errors, 0.5, method="higher")) for errors in (spread.before, spread.after)]
    (was, now), (before, after) = (
        tuple(factor * error for error in pair)
        for pair in (drawn, (learnt.before.judged, learnt.after.judged))
    )
    found = (
        "makes loops unstable"
        if np.isinf(now)
        else f"takes the median of the largest error from {was:.4g} to {now:.4g} {unit}"
    )
    return Diagnostic(
        "compensate-fragile",
        f"the command does harm on {spread.worse} of {len(spread.after)} machines with {perturbation}, and {found};"
        f" on the model itself it goes from {before:.4g} to {after:.4g} {unit}",
        hint="say how well the model is known: --perturb takes a smaller share, or the summary of cncgen identify, which fits it"
        " to a log; or make fewer --passes",
        values={
            "worse": spread.worse,
            "draws": len(spread.after),
            "unit": unit,
            "before": before,
            "after": after,
        },
    )


def spread_of(
    learnt: Learnt, servos: Mapping[str, Servo], axes: str, period_s: float, perturbation: Perturbation
) -> Spread:
    """Return the judged error before and after on machines with drawn parameters."""
    columns = contour_axes(axes)
    found: list[list[float]] = [[], []]
    for drawn in perturbed(servos, axes, perturbation):
        loops = own_scheme(drawn, axes, period_s).loops
        for values, command in zip(found, (learnt.wanted, learnt.command), strict=True):
            followed = follow(loops, period_s, command)
            away = not (np.abs(followed[0]) < RUNAWAY_MM).all()
            by_contour = learnt.before.by_contour
            values.append(np.inf if away else figures_of(learnt.wanted, followed, columns, by_contour).judged)
    return Spread(np.array(found[0]), np.array(found[1]))


def _no_gain(
    learnt: Learnt, free: Learnt | None, letters: str, work: WorkBudget, over: Sequence[Break]
) -> NoPlanError:
    """Return the refusal; `free` is what was learnt without limits where there are some, `over` those that the motion breaks."""
    unit, factor = _shown(letters)
    now = learnt.before.judged * factor
    best = learnt.tried.judged * factor if learnt.tried else None
    message = f"no command follows better: the largest error is {now:.4g} {unit} as it is"
    if best is not None:
        message += f", and {best:.4g} {unit} with the best command" + (" within the limits" if free else "")
    if work.over:
        message += "; the search ended at its bound of work, since the loops remember so many periods"
    hint = "the rest cannot be foreseen by the model: encoder steps and noise"
    if over:
        names = ", ".join(f"{each.letter} {each.name} {each.ratio:.4g} times" for each in over)
        message += f"; the motion itself is over the limits ({names})"
        hint = "plan it with --feedrate optimal, which keeps every limit; --no-limits compensates it as it is"
    elif learnt.before.saturated:
        message += f"; drives are at their bound at {learnt.before.saturated} setpoints"
        hint = "plan the motion so that the drives keep out of their bounds: --saturation predictive, or a lower feed"
    elif free is not None and free.passes:
        message += f"; without limits {free.after.judged * factor:.4g} {unit} would be possible"
        hint = (
            "plan the motion with lower acceleration, jerk and feed, so that there is room for the correction"
        )
    values = {"before": now, "best": best, "unit": unit}
    return NoPlanError(Diagnostic("compensate-no-gain", message, hint=hint, values=values))


def _shown(letters: str) -> tuple[str, float]:
    """Return unit and factor of the judged error in messages."""
    return ("µm", 1e3) if contour_axes(letters) else ("mdeg", 1e3 * to_file(letters[0]))


def _in_files(figures: Figures, axes: str) -> dict[str, Any]:
    contour = not np.isnan(figures.contour_max)
    unit, factor = ("mm", 1.0) if contour else (file_unit(axes[0]), to_file(axes[0]))
    return {
        f"tracking_rms_{unit}": figures.tracking_rms * factor,
        f"tracking_max_{unit}": figures.tracking_max * factor,
        "contour_rms_mm": figures.contour_rms if contour else None,
        "contour_max_mm": figures.contour_max if contour else None,
        "force_max": dict(zip(axes.lower(), figures.effort, strict=True)),
        "saturated_samples": figures.saturated,
    }


def _spread_values(spread: Spread, axes: str) -> dict[str, Any]:
    linear = bool(contour_axes(axes))
    unit, factor = ("mm", 1.0) if linear else (file_unit(axes[0]), to_file(axes[0]))
    result: dict[str, Any] = {"draws": len(spread.after), "worse": spread.worse}
    for name, values in (("before", spread.before), ("after", spread.after)):
        finite = np.where(np.isfinite(values), values, np.nan) * factor
        for share, label in ((0.05, "q05"), (0.5, "median"), (0.95, "q95"), (1.0, "worst")):
            value = quantile(finite, share) if share < 1.0 else float(np.max(finite))
            result[f"{name}_{label}_{unit}"] = value if np.isfinite(value) else None
    return result
