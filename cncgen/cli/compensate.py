"""`cncgen compensate`: a command file that makes the servo axes follow the wanted motion better."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import (
    format_option,
    message_options,
    output_option,
    planning_options,
    program_options,
    summary_option,
    unnamed_options,
)
from cncgen.cli.types import FILE, MACHINE, FiniteRange
from cncgen.units import ORDER_NAMES

if TYPE_CHECKING:
    from cncgen.servo.reserve import Reserved


@dataclass(frozen=True, slots=True)
class _Task:
    """The input, the method and the output, whether setpoints or a program are given; the names are those of options."""

    source: str
    passes: int
    settle: float
    format: str | None
    output: str | None


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
    type=click.IntRange(1, 20),
    default=1,
    show_default=True,
    help="How many times the remaining error is added.",
)
@click.option(
    "--limits/--no-limits", default=True, show_default=True, help="Refuse a command that breaks limits."
)
@click.option(
    "--settle",
    metavar="SECONDS",
    type=FiniteRange(0, 3600),
    default=0.1,
    show_default=True,
    help="Hold the last position so long, for the command to come to rest there.",
)
@unnamed_options
@format_option
@output_option
@summary_option
@planning_options
@program_options
@message_options
def command(
    source: str,
    machine: str | None,
    passes: int,
    limits: bool,
    settle: float,
    axes: str | None,
    period: float | None,
    format: str | None,
    output: str | None,
    summary: str | None,
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Shape setpoints so that the axes follow better.

    The axes are as the model knows them. Writes the command to send to the machine and says what it gains. A command that
    would break a limit which the setpoints keep is refused with the place and the figure (exit 3), and nothing is written.
    A PROGRAM is planned first, with as much room under the machine's limits as its command needs.
    """
    from cncgen.cli.reading import is_setpoint_file

    if machine is None and planning["axis_params"] is None:
        raise click.UsageError("give the servo data: -m MACHINE, or --axis-params NAME|FILE")
    task = _Task(source, passes, settle, format, output)
    if source == "-" or is_setpoint_file(source):
        gained = _of_setpoints(task, machine, planning["axis_params"], (axes, period), limits)
    elif machine is None:
        raise click.UsageError("a program is planned for a machine: give it with -m")
    elif not limits:
        raise click.UsageError(
            "plan the program first where no limits are to be kept, and give its setpoints"
        )
    else:
        gained = _of_program(task, machine, planning, reading)
    before, after = gained["before"], gained["after"]
    messages.note(_gained_text(before, after))
    advice = _advice(before, after)
    if advice:
        messages.note(advice)
    write_summary(summary, {"schema_version": 1, "setpoints": source, **gained})


def _advice(before: dict[str, float | None], after: dict[str, float | None]) -> str:
    """Return what to do where the command makes the error larger that it is judged by, else ""."""
    grew = {key for key, value in after.items() if value is not None and value > (before[key] or 0.0)}
    if not grew & {"contour_max_mm", "tracking_max_deg"}:
        return ""
    if grew & {"tracking_max_mm", "tracking_max_deg"}:
        return "the command makes it worse: use fewer passes, or a plan with lower jerk"
    return "the axes lag less but are farther from the path: use more passes, or a plan with lower jerk"


def _of_setpoints(
    task: _Task,
    machine: str | None,
    axis_params: str | None,
    given: tuple[str | None, float | None],
    limits: bool,
) -> dict[str, Any]:
    """Shape setpoints, whose axes and period may be `given`; return what it gains."""
    from cncgen import pipeline
    from cncgen.cli.writing import write_setpoints
    from cncgen.machine import load_servos
    from cncgen.servo.mirror import Compensation, limits_of
    from cncgen.setpoints.readers import open_setpoints

    servos = axis_params or machine or ""
    bounds = limits_of(machine or servos, required=machine is not None) if limits else None
    if limits and bounds is None:
        messages.note(f"{servos} has no limits: none are checked; give the machine with -m")
    letters, period = given
    usual = pipeline.machine_of(machine).period_s if machine and limits else None
    with open_setpoints(task.source, axes=letters, period_s=period, default_period_s=usual) as stream:
        work = Compensation(
            stream.chunks, load_servos(servos), passes=task.passes, limits=bounds, settle_s=task.settle
        )
        rows = write_setpoints(work.chunks(), task.output, task.format, machine if limits else None)
    messages.note(_written_text(rows, task.passes))
    return work.gained()


def _of_program(
    task: _Task, machine: str, planning: dict[str, Any], reading: dict[str, Any]
) -> dict[str, Any]:
    """Plan a program with room for its command, and shape that; return what it gains."""
    from cncgen import pipeline
    from cncgen.cli.reading import opened, plan_options
    from cncgen.cli.writing import write_setpoints
    from cncgen.servo.reserve import compensated_plan

    where = pipeline.machine_of(machine)
    servos = pipeline.servos_of(planning["axis_params"] or machine)
    with opened(task.source, reading, planning["path_tolerance"], machine) as read:
        toolpaths = list(pipeline.sound(read))
        found = compensated_plan(
            toolpaths, where, servos, axes=pipeline.output_axes(read), options=plan_options(planning),
            passes=task.passes, settle_s=task.settle,
        )  # fmt: skip
    rows = write_setpoints(found.command, task.output, task.format, where)
    messages.note(f"{_written_text(rows, task.passes)}{_room_text(found)}")
    shares = {k.lower(): dict(zip(ORDER_NAMES, v, strict=True)) for k, v in found.shares.items()}
    return {**found.gained, "time_s": found.time_s, "full_time_s": found.full_time_s, "limit_shares": shares}


def _gained_text(before: dict[str, Any], after: dict[str, Any]) -> str:
    """Say what the errors were and are, in thousandths."""
    names = (
        ("contour error max", "contour_max_mm", "µm"),
        ("contour error rms", "contour_rms_mm", "µm"),
        ("tracking error max", "tracking_max_mm", "µm"),
        ("tracking error max", "tracking_max_deg", "mdeg"),
    )
    return "; ".join(
        f"{name} {1e3 * before[key]:.3f} -> {1e3 * after[key]:.3f} {unit}"
        for name, key, unit in names
        if after.get(key) is not None
    )


def _written_text(rows: int, passes: int) -> str:
    """Say what was written."""
    return f"{rows} setpoints after {passes} {'pass' if passes == 1 else 'passes'}"


def _room_text(found: Reserved) -> str:
    """Say what the plan left room for, if it had to."""
    lowered = [
        f"{letter} {name} {share:.2f}"
        for letter, shares in found.shares.items()
        for name, share in zip(ORDER_NAMES, shares, strict=True)
        if share < 1.0
    ]
    if not lowered:
        return ""
    contour = found.gained["full_before"]["contour_max_mm"]
    return (
        f"; planned with these shares of the limits, to leave room: {', '.join(lowered)}: {found.time_s:.3f} s instead of"
        f" {found.full_time_s:.3f} s"
        + ("" if contour is None else f", where the contour error was at most {1e3 * contour:.3f} µm")
    )
