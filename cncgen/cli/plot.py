"""`cncgen plot`: pictures of a program, a setpoint file or a response."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.options import (
    machine_option,
    message_options,
    planning_options,
    program_options,
    reference_option,
    setpoint_options,
)
from cncgen.cli.types import FILE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from cncgen.pipeline import Plan
    from cncgen.planner.record import SharpCorner, Trajectory
    from cncgen.report.plot_data import PlotData


@click.command("plot")
@click.argument("source", metavar="PROGRAM|SETPOINTS|RESPONSE.csv", type=FILE)
@machine_option
@click.option(
    "--kinds",
    metavar="LIST",
    help="Of path,feed,axes,curvature,force,errors, by commas [default: all that the source allows].",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE|DIR",
    type=FILE,
    required=True,
    help="One picture as .png, .svg or .pdf, or a folder for several.",
)
@reference_option
@planning_options
@setpoint_options
@program_options
@message_options
def command(
    source: str,
    machine: str,
    kinds: str | None,
    output: str,
    format: str | None,
    axes: str | None,
    period: float | None,
    reference: str | None,
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Draw a motion and the response of the axes.

    Its path, feed, axes with their limits, curvature, force and errors. A program is planned and, where the machine has
    servo data, simulated; setpoints are simulated with --axis-params; a response file is drawn directly. With --reference the errors
    are those against the wanted path and plan.
    """
    from cncgen.report.plots import available, check_target, draw

    asked = None if kinds is None else [name.strip() for name in kinds.split(",") if name.strip()]
    check_target(asked, output)
    given = (format, axes, period)
    data = None if reference else _response_file(source, machine)
    data = data or _planned_or_read(source, machine, planning, given, reading, reference)
    for file in draw(data, asked or available(data), output):
        messages.note(file)


def _response_file(source: str, machine: str) -> PlotData | None:
    """Return the data of a response file, or None where the source is something else."""
    if not source.lower().endswith(".csv"):
        return None
    from cncgen.files import head_of
    from cncgen.machine import load_machine
    from cncgen.report.plot_data import of_log
    from cncgen.servo.identification.log import read_log

    if b"_cmd_" not in head_of(source, 4096).partition(b"\n")[0]:
        return None
    where = load_machine(machine)
    return of_log(read_log(source), _title(source, where.name), where.axes)


def _title(source: str, machine: str) -> str:
    """Return the heading of a picture: the file's own name, and the machine whose limits are drawn."""
    import os

    return f"{'standard input' if source == '-' else os.path.basename(source)} on {machine}"


def _planned_or_read(
    source: str,
    machine: str,
    planning: dict[str, Any],
    given: tuple[str | None, str | None, float | None],
    reading: dict[str, Any],
    reference: str | None,
) -> PlotData:
    """Return the data of setpoints, whose format, axes and period may be `given`, or of the plan of a program."""
    from cncgen import pipeline
    from cncgen.cli.reading import is_setpoint_file, planned, planning_machine, reference_of, tell_of_unused
    from cncgen.machine.kinematics import mechanism_of
    from cncgen.report.plot_data import against, of_response, of_setpoints
    from cncgen.servo.stream import driven
    from cncgen.setpoints.readers import open_setpoints

    found = pipeline.machine_of(machine)
    corners: list[SharpCorner] = []
    format, letters, period = given
    if format or is_setpoint_file(source):
        if reference is None:
            tell_of_unused(source, planning, reading)
        servos = pipeline.servos_of(planning["axis_params"]) if planning["axis_params"] else {}
        with open_setpoints(
            source, format=format, axes=letters, period_s=period, default_period_s=found.period_s
        ) as stream:
            chunks = list(driven(stream.chunks, {**found.axes, **servos}) if servos else stream.chunks)
    else:
        machine = planning_machine(machine, planning)
        found = pipeline.machine_of(machine)
        servos = pipeline.servos_of(planning["axis_params"] or found)
        with planned(source, reading, planning, machine) as plan:
            rows = pipeline.sample(_noting(plan, corners), ["tool_length"])
            chunks = list(driven(rows.chunks, found.axes))
    title = _title(source, found.name)
    data = of_setpoints(iter(chunks), title, found.axes, corners)
    if not all(letter in servos for letter in data.axes):
        if reference is not None:
            raise click.UsageError("--reference judges a simulation: give the servo data with --axis-params")
        return data
    responses = list(pipeline.simulate(iter(chunks), servos, kinematics=mechanism_of(found)))
    shown = of_response(iter(responses), title, found.axes, servos, data.corners)
    if reference is None:
        return shown
    return against(shown, reference_of(reference, machine, planning, reading), responses)


def _noting(plan: Plan, corners: list[SharpCorner]) -> Plan:
    """Return the plan, whose sharp corners are gathered while it is computed."""
    from dataclasses import replace

    def over() -> Iterator[Trajectory]:
        for trajectory in plan.trajectories:
            corners.extend(trajectory.corners)
            yield trajectory

    return replace(plan, trajectories=over())
