"""Planning a program on a machine, and sampling the plan. Planning itself is `cncgen.planner`, sampling `cncgen.setpoints`."""

from __future__ import annotations

import math
import os
import warnings
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from cncgen.arguments import declared, expect, expect_fields, expect_path, undrawn
from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, RemarkWarning
from cncgen.pipeline.reading import PLANNED, PREDICTED, read, sound
from cncgen.shown import html_of
from cncgen.toolpath.reading import ReadOptions

if TYPE_CHECKING:
    from typing import Unpack

    from cncgen.machine import Drive, Machine
    from cncgen.planner import PlanOptions, Trajectory
    from cncgen.planner.options import PlanWords
    from cncgen.report.line_times import LineTimes
    from cncgen.report.summary import Summary
    from cncgen.setpoints.stream import SetpointStream
    from cncgen.toolpath.record import Program, Toolpath

#: Pieces of motion that a plan may have where the options do not say, of 5 to 20 µs each. Each line beyond a number of them allows more,
#: as a long program is not an endless one, and so does each step that the options allow. Last, how many setpoints take as long as a
#: piece. Of real programs of a hundred lines, two hours of facing are a million pieces, and four hours of thread milling 15 million
#: setpoints.
MOST_PIECES, PIECES_OF_A_LINE, FREE_LINES, PIECES_OF_A_STEP, SETPOINTS_OF_A_PIECE = (
    1_800_000,
    800,
    500,
    1000,
    11,
)


@dataclass(frozen=True, slots=True)
class Plan:
    """A plan, computed on demand: iterate over it for its trajectories, once.

    Attributes:
        program: The program that is planned.
        machine: The machine on which it is planned.
        trajectories: The motion, stretch by stretch.
        promised: Whether the plan promises the limits of all axes, so that its setpoints are held to them.
        options: How it is planned.
    """

    program: Program
    machine: Machine
    trajectories: Iterator[Trajectory]
    promised: bool = False
    options: PlanOptions | None = None

    def __iter__(self) -> Iterator[Trajectory]:
        return undrawn(self.trajectories, repr(self))

    def __repr__(self) -> str:
        return f"Plan({self.program!r}, {self.machine!r})"

    def _repr_html_(self) -> str | None:
        return html_of(self)


def machine_of(machine: Machine | str | os.PathLike[str]) -> Machine:
    """Return a machine; the name of a profile or of a TOML file is loaded.

    Raises:
        UsageError: It cannot be loaded, or one of its numbers is impossible for a machine.
    """
    from cncgen.machine import Machine, load

    if isinstance(machine, Machine):
        from cncgen.machine.checking import check_machine

        check_machine(machine)
        return machine
    return load(expect_path(machine, "the machine", "a profile's name, a TOML file, or a Machine"))


def options_on(machine: Machine, options: ReadOptions | None = None) -> ReadOptions:
    """Return options of reading, completed by a machine's tables ``[interpreter]``, ``[kinematics]`` and ``[times]``.

    Of the first, ``least_increment_mm`` is the unit of numbers without a decimal point, and ``dialect`` the control's language
    (an option that names one has precedence); the second is read by `cncgen.machine.kinematics`; of the third, ``spindle_max_rpm`` bounds
    the spindle under a constant surface speed. The travel of the axes is for programs that ask for it.

    Raises:
        UsageError: A setting is wrong.
    """
    how = options or ReadOptions()
    bounded = [(axis.letter, *axis.travel) for axis in machine.axes.values() if axis.travel is not None]
    if bounded:
        travel = [
            (letter, low, high) if letter not in "ABC" else (letter, math.degrees(low), math.degrees(high))
            for letter, low, high in bounded
        ]
        how = replace(how, travel=tuple(travel))
    if "kinematics" in machine.settings:
        from cncgen.machine.kinematics import mechanism_of

        how = replace(how, kinematics=mechanism_of(machine))
    if "interpreter" in machine.settings:
        from cncgen.gcode.state.settings import interpreter_settings

        how = interpreter_settings(machine.settings["interpreter"], how)
    fastest = machine.settings.get("times", {}).get("spindle_max_rpm")
    if fastest is not None and how.fastest_spindle is None:
        how = replace(how, fastest_spindle=float(fastest))
    return how


def program_of(program: Program | str | os.PathLike[str], machine: Machine) -> Program:
    """Return a program as the machine's control would read it; the name of a file is opened.

    A program that was read for no machine, or for another one, is read again where the machine's tables say how (`options_on`).

    Raises:
        UsageError: It is neither, or cannot be read.
    """
    from cncgen.toolpath.record import Program

    if isinstance(program, str | os.PathLike):
        return read(program, options=options_on(machine))
    found: Program = expect(
        program, Program, "the program", "a program of cncgen.read, or the name of a file"
    )
    options = options_on(machine, found.options)
    if options == found.options and not found.diagnostics.has_errors:
        return found
    return found.reread(options)


def plan(
    program: Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str] = "generic-mill",
    options: PlanOptions | None = None,
    **asked: Unpack[PlanWords],
) -> Plan:
    """Plan a program on a machine.

    Args:
        program: From `read`, or a file.
        machine: A profile's name, a TOML file, or a machine.
        options: How; or its fields as keywords (``feedrate="ild"``).

    Returns:
        The plan, which `sample`, `simulate`, `judge` and `write` take. It is computed on demand, once; the program may be
        planned again.

    Raises:
        UsageError: The program or the machine cannot be had, or an option is wrong.
        ProgramError: The program has errors, or moves an axis that the machine does not have.
        NoPlanError: No plan exists within the limits; travel is one of them. Raised, as the one before it, as the plan
            is drawn.
    """
    where, how = machine_of(machine), asked_for(options, asked)
    program = program_of(program, where)
    how = as_read(how, program)
    return Plan(program, where, trajectories_of(sound_for(program, how), where, how), how.keeps_limits, how)


def asked_for(options: PlanOptions | None, asked: Mapping[str, Any]) -> PlanOptions:
    """Return options in which the fields that are given as keywords are replaced.

    Raises:
        UsageError: They are not options, or a field is unknown or wrong.
    """
    from cncgen.planner import PlanOptions

    if options is not None:
        expect(options, PlanOptions, "options", "cncgen.PlanOptions (or its fields as keywords)")
    expect_fields(PlanOptions, asked)
    how = replace(options or PlanOptions(), **asked)
    how.check()
    for remark in how.unused():
        warnings.warn(RemarkWarning(remark), stacklevel=3)
    return how


def as_read(options: PlanOptions, program: Program) -> PlanOptions:
    """Return options that allow as many steps as those that the program is read with, where they say nothing themselves."""
    return options if options.max_steps is not None else replace(options, max_steps=program.options.max_steps)


def sound_for(program: Program, options: PlanOptions) -> Iterator[Toolpath]:
    """Yield the toolpaths of a program, as many as these options can plan in a bounded time (`cncgen.pipeline.reading.sound`)."""
    return sound(program, PREDICTED if options.feedrate == "ild" else PLANNED)


def trajectories_of(
    toolpaths: Iterable[Toolpath], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Plan the toolpaths of a program, as long as its plan is no longer than its lines and the options let it be.

    Raises:
        ProgramError: It is: the program loops, or something is in a wrong unit. Else as `cncgen.planner.plan`.
    """
    from cncgen import planner

    return _bounded(planner.plan(toolpaths, machine, options), machine.period_s, options.max_steps or 0)


def _bounded(plan: Iterator[Trajectory], period_s: float, steps: int) -> Iterator[Trajectory]:
    """Yield a plan as far as it is not too long for its program; see `trajectories_of`."""
    anyway, pieces, last = max(MOST_PIECES, PIECES_OF_A_STEP * steps), 0, 0
    for trajectory in plan:
        profile, rows = trajectory.profile, trajectory.toolpath
        last = max(int(rows.line.max(initial=0)), last)
        pieces += len(profile.v)
        setpoints = float(profile.t[-1]) / period_s
        bound = anyway + PIECES_OF_A_LINE * max(last - FREE_LINES, 0)
        if pieces + setpoints / SETPOINTS_OF_A_PIECE > bound:
            row = min(bisect_left(trajectory.row_s, float(profile.s[-1]), 1), len(rows)) - 1
            raise ProgramError(
                Diagnostic(
                    "long-plan",
                    f"{pieces} pieces of motion and {setpoints:.0f} setpoints come of {last} lines: the plan counts as endless",
                    span=rows.span(row),
                    hint="look for a long loop, and a feed or dwell in the wrong unit; --max-steps allows more",
                    values={"pieces": pieces, "setpoints": setpoints},
                )
            )
        yield trajectory


def output_axes(program: Program) -> str:
    """Return the axes of a program's setpoints: the axes that it names, or X Y Z if it names none."""
    return program.moving_axes or program.axes


def driven_axes(program: Program, machine: Machine) -> str:
    """Return the axes of a program's setpoints that a machine has. Axes that it lacks stand still: a plan cannot move them.

    Where the program names none of the machine's axes, all of the machine's.
    """
    return "".join(axis for axis in output_axes(program) if axis in machine.axes) or "".join(machine.axes)


def sample(planned: Plan, signals: Sequence[str] = ()) -> SetpointStream:
    """Sample a plan once a period of its machine.

    Args:
        planned: From `plan`.
        signals: Further columns: ``vel``, ``acc``, ``jerk``, ``feed``, ``line``, ``limit`` (or their names by commas).

    Returns:
        A stream of `Setpoints`, to be drawn once: chunks in a loop, or all rows as one by its ``collect()``. The first
        row is the start at t = 0, the last one the end, at rest.

    Raises:
        UsageError: A signal is unknown, or `planned` is not a plan.
    """
    return _sampled(expect(planned, Plan, "what is sampled", "what cncgen.plan returns"), signals)


def _sampled(planned: Plan, signals: Sequence[str], remarks: Diagnostics | None = None) -> SetpointStream:
    """Sample a plan as `sample` does; `remarks` takes what there is to say of the setpoints once they are drawn."""
    if isinstance(signals, str):
        signals = [name.strip() for name in signals.split(",") if name.strip()]
    wanted = "names of signals, as a list or by commas"
    signals = [
        expect(name, str, "a signal", "its name") for name in expect(signals, Iterable, "signals", wanted)
    ]
    from cncgen import setpoints
    from cncgen.setpoints.stream import SetpointStream

    axes, machine = output_axes(planned.program), planned.machine
    chunks = setpoints.sample(iter(planned), machine, axes=axes, signals=signals)
    if planned.options is not None and planned.options.interpolator.startswith("two-stage"):
        from cncgen.setpoints.two_stage import two_stage

        chunks = two_stage(chunks, planned.options.interpolator, planned.options.master_period_s, remarks)
    if planned.promised:
        from cncgen.setpoints.holding import held

        chunks = held(chunks, machine)
    name = planned.program.name
    return SetpointStream(
        name, axes, machine.period_s, chunks, metadata_of(name, machine), drives_of(machine)
    )


def metadata_of(program: str, machine: Machine) -> dict[str, str]:
    """Return the texts that files of setpoints carry along: program, machine with all its limits, version."""
    import cncgen
    from cncgen.machine import to_toml

    return {
        "program": program,
        "machine": machine.name,
        "machine_toml": to_toml(machine),
        "cncgen_version": cncgen.__version__,
    }


def drives_of(machine: Machine) -> dict[str, Drive]:
    """Return the scaling of the drives of a machine by axis letter."""
    return {letter: axis.drive for letter, axis in machine.axes.items() if axis.drive is not None}


def summary_of(
    program: Program, machine: Machine, options: PlanOptions, line_times: LineTimes | None = None
) -> Summary:
    """Return the summary that a plan with these options fills; for another control's times it is an estimate."""
    from cncgen.planner.strategies import FEEDRATES
    from cncgen.report.summary import Summary

    how, estimate = options.control or options.feedrate or FEEDRATES[0], options.control is not None
    return Summary(program, machine, how, line_times, interpolator=options.interpolator, estimate=estimate)


@declared
def plan_with_summary(
    program: Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str] = "generic-mill",
    options: PlanOptions | None = None,
    signals: Sequence[str] = (),
    line_times: LineTimes | None = None,
    **asked: Unpack[PlanWords],
) -> tuple[SetpointStream, Summary]:
    """Plan and sample a program, and gather a summary on the way: times, lengths, peaks, corners, the slowest places.

    Args:
        program, machine, options, asked: As for `plan`.
        signals: As for `sample`.
        line_times: If given, gathers the time that each line takes.

    Returns:
        The setpoints, and the summary: its ``as_json()`` is what ``cncgen plan --summary`` writes, once the stream has
        been drawn to its end.

    Raises:
        UsageError, ProgramError, NoPlanError: As `plan` and `sample`.
    """
    where, how = machine_of(machine), asked_for(options, asked)
    program = program_of(program, where)
    how = as_read(how, program)
    summary = summary_of(program, where, how, line_times)
    trajectories = trajectories_of(summary.over_toolpaths(sound_for(program, how)), where, how)
    planned = Plan(program, where, summary.over_trajectories(trajectories), how.keeps_limits, how)
    stream = _sampled(planned, signals, summary.remarks)
    watched = replace(stream, chunks=summary.over_setpoints(stream.chunks))
    return watched, summary
