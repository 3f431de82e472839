"""`cncgen compensate`: a command file that makes the servo axes follow the wanted motion better."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import (
    format_option,
    message_options,
    output_option,
    perturb_options,
    planning_options,
    program_options,
    settle_option,
    summary_option,
    unnamed_options,
)
from cncgen.cli.types import FILE, MACHINE, MODES, Share, WholeRange

if TYPE_CHECKING:
    from cncgen.machine import Machine
    from cncgen.servo.compensation import Compensated
    from cncgen.servo.uncertainty import Perturbation


#: Room that a program is planned with until its command is good enough: shares of acceleration and jerk.
ROOMS = (1.0, 0.8, 0.64, 0.5)
#: As `cncgen.servo.shaping` has them, whose import takes numpy.
SHAPERS = ("zv", "zvd", "ei", "mzv")


@dataclass(frozen=True, slots=True)
class _Task:
    """The input, the method and the output, whether setpoints or a program are given; the names are those of options."""

    source: str
    passes: int
    settle: float
    perturbation: Perturbation | None
    format: str | None
    output: str | None
    wanted: str | None

    def write(self, found: Compensated, machine: Machine | str | None) -> None:
        """Write the command, and on request the wanted setpoints."""
        from cncgen.cli.writing import write_setpoints

        write_setpoints(iter((found.command,)), self.output, self.format, machine)
        if self.wanted is not None:
            write_setpoints(
                iter((replace(found.command, position=found.learnt.wanted),)), self.wanted, None, machine
            )


@click.command("compensate")
@click.argument("source", metavar="[SETPOINTS|PROGRAM]", type=FILE, default="-")
@click.option(
    "-m",
    "--machine",
    metavar="NAME|FILE",
    type=MACHINE,
    help="Machine whose limits the command must keep, and that a program is planned for "
    "[default: that of --axis-params, if it has limits].",
)
@click.option(
    "--passes",
    metavar="N",
    type=WholeRange(1, 100),
    default=6,
    show_default=True,
    help="How many times the remaining error is learnt, at most.",
)
@click.option(
    "--room",
    metavar="SHARE",
    type=Share(0.05, 1.0),
    help="Plan a program with this share of the axes' acceleration and jerk, which leaves room for the command "
    "[default: the largest of 100%, 80%, 64%, 50% with which the contour error falls to a fifth].",
)
@click.option(
    "--shaper",
    type=click.Choice(SHAPERS),
    help="Shape the motion for vibrations instead, whose frequencies and dampings --modes gives; no servo data are needed.",
)
@click.option(
    "--modes",
    metavar="HZ:DAMPING,…",
    type=MODES,
    help="Vibrations of --shaper, as 38:0.05,71:0.03; all axes have them.",
)
@click.option("--limits/--no-limits", default=True, show_default=True, help="Keep the machine's limits.")
@settle_option(0.1, "Hold the last position so long at least, for the command to come to rest there.")
@unnamed_options
@format_option
@output_option
@click.option(
    "--wanted",
    metavar="FILE",
    type=FILE,
    help="Write the setpoints here that the axes are to follow under the command, row by row: for simulate --reference.",
)
@summary_option
@perturb_options
@planning_options
@program_options
@message_options
def command(
    source: str,
    machine: str | None,
    passes: int,
    room: float | None,
    shaper: str | None,
    modes: tuple[tuple[float, float], ...] | None,
    limits: bool,
    settle: float,
    axes: str | None,
    period: float | None,
    format: str | None,
    output: str | None,
    wanted: str | None,
    summary: str | None,
    uncertainty: dict[str, Any],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Shape setpoints so that the axes follow better.

    The axes are as the model knows them, friction, backlash and delay included. Writes the command for the machine and shows its gain,
    also on machines whose parameters are 10 % off (--perturb). The command keeps the machine's limits; where none follows better, or
    most of those machines follow worse, nothing is written (exit 3). It may begin before the motion, and end after it.
    """
    from cncgen.cli.reading import is_setpoint_file, perturbation_of, tell_of_unused
    from cncgen.cli.writing import setpoint_format
    from cncgen.report.compensated import gain_lines

    setpoint_format(output, format)
    setpoint_format(wanted, None)
    if (shaper is None) != (modes is None):
        raise click.UsageError("--shaper and --modes go together")
    if shaper is not None and wanted is not None:
        raise click.UsageError(
            "--wanted goes with a command that is learnt; --shaper leaves the path that its source has"
        )
    if shaper is not None and modes is not None:
        _shape(
            (source, format, output, summary),
            (shaper, modes),
            (machine, limits),
            (axes, period),
            planning,
            reading,
        )
        return
    if machine is None and planning["axis_params"] is None:
        raise click.UsageError("give the servo data: -m MACHINE, or --axis-params NAME|FILE")
    drawn = perturbation_of(uncertainty, usual=0.1)
    task = _Task(source, passes, settle, drawn, format, output, wanted)
    if source == "-" or is_setpoint_file(source):
        if room is not None:
            raise click.UsageError("--room is how a program is planned; setpoints are planned already")
        tell_of_unused(source, planning, reading)
        gained = _of_setpoints(task, machine, planning["axis_params"], (axes, period), limits)
    elif machine is None:
        raise click.UsageError("a program is planned for a machine: give it with -m")
    else:
        gained = _of_program(task, machine, limits, room, planning, reading)
    for text in gain_lines(gained, drawn):
        messages.note(text)
    write_summary(summary, {"schema_version": 1, "setpoints": source, **gained})


def _shape(
    files: tuple[str, str | None, str | None, str | None],
    how: tuple[str, tuple[tuple[float, float], ...]],
    where: tuple[str | None, bool],
    given: tuple[str | None, float | None],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Shape setpoints, or the plan of a program, for vibrations, and describe the resulting path.

    `files` are source, format, output and summary, `where` is the machine and whether its limits are kept; axes and period of
    setpoints may be `given`.
    """
    from cncgen import pipeline
    from cncgen.cli.reading import is_setpoint_file, planned, tell_of_unused
    from cncgen.cli.writing import write_setpoints
    from cncgen.report.compensated import shaping_lines
    from cncgen.servo.command_limits import hold
    from cncgen.servo.shaping import Mode, shaped_setpoints
    from cncgen.setpoints.readers import open_setpoints

    source, format, output, summary = files
    machine, limits = where
    shaper, modes = how[0], [Mode(*pair) for pair in how[1]]
    if source == "-" or is_setpoint_file(source):
        tell_of_unused(source, planning, reading)
        letters, period = given
        usual = pipeline.machine_of(machine).period_s if machine else None
        with open_setpoints(source, axes=letters, period_s=period, default_period_s=usual) as stream:
            command, found = shaped_setpoints(stream.chunks, shaper, modes)
    elif machine is None:
        raise click.UsageError("a program is planned for a machine: give it with -m")
    else:
        with planned(source, reading, planning, machine) as plan:
            command, found = shaped_setpoints(pipeline.sample(plan).chunks, shaper, modes)
    if machine is not None and limits:
        hold(command, pipeline.machine_of(machine).axes)
    write_setpoints(iter((command,)), output, format, machine)
    for text in shaping_lines(found, shaper, command.period_s):
        messages.note(text)
    result = {"schema_version": 1, "setpoints": source, "shaper": shaper, "samples": len(command)}
    write_summary(summary, {**result, **found.as_dict(modes, command.period_s)})


def _of_setpoints(
    task: _Task,
    machine: str | None,
    axis_params: str | None,
    given: tuple[str | None, float | None],
    limits: bool,
) -> dict[str, Any]:
    """Shape setpoints, whose axes and period may be `given`; return the gain."""
    from cncgen import pipeline
    from cncgen.machine import load_servos
    from cncgen.servo.compensation import compensate, limits_of
    from cncgen.servo.stream import driven
    from cncgen.setpoints.readers import open_setpoints

    servos = axis_params or machine or ""
    known, bounds = load_servos(servos), limits_of(machine or servos, required=machine is not None)
    bounds = bounds if limits else None
    if limits and bounds is None:
        messages.note(f"{servos} has no limits: none are kept; give the machine with -m")
    letters, period = given
    usual = pipeline.machine_of(machine).period_s if machine and limits else None
    with open_setpoints(task.source, axes=letters, period_s=period, default_period_s=usual) as stream:
        found = compensate(
            driven(stream.chunks, {**known, **(bounds or {})}), known, limits=bounds, passes=task.passes, settle_s=task.settle,
            perturbation=task.perturbation,
        )  # fmt: skip
    task.write(found, machine if limits else None)
    return found.gained()


def _of_program(
    task: _Task,
    machine: str,
    limits: bool,
    room: float | None,
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> dict[str, Any]:
    """Plan a program with room for its command, and shape this plan; return the gain."""
    from cncgen import pipeline
    from cncgen.cli.reading import opened, plan_options
    from cncgen.pipeline.reading import REPEATED
    from cncgen.servo.compensation import compensated_plan

    where = pipeline.machine_of(machine)
    servos = pipeline.servos_of(planning["axis_params"] or machine)
    with opened(task.source, reading, planning["path_tolerance"], machine) as read:
        toolpaths = list(pipeline.sound(read, REPEATED))
        found = compensated_plan(
            toolpaths, where, servos, axes=pipeline.driven_axes(read, where), options=plan_options(planning),
            rooms=ROOMS if room is None else (room,), limits=limits, passes=task.passes,
            settle_s=task.settle, perturbation=task.perturbation,
        )  # fmt: skip
    task.write(found.compensated, where)
    return found.gained()
