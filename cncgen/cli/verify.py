"""`cncgen verify`: judges setpoints against a program and a machine."""

from __future__ import annotations

import json
from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.options import machine_option, message_options, program_options, setpoint_options
from cncgen.cli.types import FILE, FiniteRange
from cncgen.ranges import RESOLUTION, TOLERANCE_MM


@click.command("verify")
@click.argument("setpoints", metavar="SETPOINTS", type=FILE)
@click.option(
    "-p",
    "--program",
    metavar="PROGRAM",
    type=FILE,
    required=True,
    help="The program that they are to follow.",
)
@machine_option
@setpoint_options
@click.option(
    "--path-tolerance",
    metavar="MM",
    type=FiniteRange(min=0, max=TOLERANCE_MM, min_open=True),
    help="Tolerance of continuous motion [default: the program's, else the machine's].",
)
@click.option(
    "--resolution",
    metavar="MM",
    type=FiniteRange(min=0, max=RESOLUTION, min_open=True),
    default=1e-9,
    show_default=True,
    help="Unit, mm and degrees, to which positions are rounded: differences may exceed a limit by the effect of that.",
)
@click.option("--report", metavar="FILE", type=FILE, help="Write the verdict as JSON.")
@program_options
@message_options
def command(
    setpoints: str,
    program: str,
    machine: str,
    format: str | None,
    axes: str | None,
    period: float | None,
    path_tolerance: float | None,
    resolution: float,
    report: str | None,
    reading: dict[str, Any],
) -> int:
    """Judge setpoints against program and machine.

    The setpoints may be of any origin. Judged are finite differences up to jerk, travel, the distance between setpoints
    and path (both ways, and in order), dwells, and rest at both ends. Exit 1 if a limit is broken; the messages say where.
    """
    from cncgen import pipeline
    from cncgen.cli.reading import opened
    from cncgen.diagnostics import json_values
    from cncgen.files import STANDARD, write_text
    from cncgen.report.verdict import as_text
    from cncgen.setpoints.readers import open_setpoints

    if setpoints == program == STANDARD:
        raise click.UsageError("SETPOINTS and --program cannot both come from standard input.")
    where = pipeline.machine_of(machine)
    with (
        opened(program, reading, machine=machine) as read,
        open_setpoints(
            setpoints,
            format=format,
            axes=axes,
            unnamed_axes=pipeline.output_axes(read),
            period_s=period,
            default_period_s=where.period_s,
        ) as stream,
    ):
        verdict = pipeline.judge(stream, read, where, tolerance_mm=path_tolerance, resolution=resolution)
    if report:
        write_text(report, json.dumps(json_values(verdict.as_json()), indent=2) + "\n")
    messages.show(verdict.breaches)
    messages.note(as_text(verdict))
    return 0 if verdict.holds else 1
