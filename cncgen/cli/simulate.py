"""`cncgen simulate`: what the servo axes make of setpoints, or of a program that is planned first."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.options import (
    machine_option,
    message_options,
    output_option,
    planning_options,
    program_options,
    summary_option,
)

if TYPE_CHECKING:
    from cncgen.setpoints.stream import SetpointStream

#: Suffixes of setpoint files; any other name is a program.
SETPOINT_SUFFIXES = (".csv", ".jsonl", ".npy", ".npz", ".f64", ".hal", ".arrow")


@click.command("simulate")
@click.argument("source", metavar="[SETPOINTS|PROGRAM]", default="-")
@machine_option
@output_option
@planning_options
@click.option("--axes", metavar="LETTERS", help="Axes of setpoints in a format that does not name them.")
@click.option(
    "--period",
    metavar="SECONDS",
    type=click.FloatRange(min=0, min_open=True),
    help="Period of the setpoints [default: from their times].",
)
@click.option(
    "--settle",
    metavar="SECONDS",
    type=click.FloatRange(min=0),
    default=0.0,
    show_default=True,
    help="Hold the last setpoint so long at the end.",
)
@summary_option
@program_options
@message_options
def command(
    source: str,
    machine: str,
    output: str | None,
    planning: dict[str, Any],
    axes: str | None,
    period: float | None,
    settle: float,
    summary: str | None,
    reading: dict[str, Any],
) -> None:
    """Simulate the servo axes in closed loop.

    The argument is a setpoint file (standard input where it is - or missing), or a program, which is planned first.
    The response goes to the file of -o, else to standard output unless that is a terminal.
    """
    from cncgen.files import STANDARD, is_terminal, write_text
    from cncgen.pipeline import simulate
    from cncgen.report.response import ResponseSummary, as_text, write_responses

    servos = planning["axis_params"] or machine
    with _setpoints(source, machine, planning, axes, period, reading) as stream:
        watch = ResponseSummary(source, servos, stream.axes, stream.period_s)
        responses = watch.over(simulate(stream, servos, settle_s=settle))
        if output is None and is_terminal(sys.stdout):
            for _ in responses:
                pass
        else:
            write_responses(responses, output if output != STANDARD else None)
    result = watch.as_json()
    messages.note(as_text(result))
    if summary:
        text = json.dumps(result, indent=2) + "\n"
        if summary == "-":
            sys.stderr.write(text)
        else:
            write_text(summary, text)


@contextmanager
def _setpoints(
    source: str,
    machine: str,
    planning: dict[str, Any],
    axes: str | None,
    period: float | None,
    reading: dict[str, Any],
) -> Iterator[SetpointStream]:
    """Open setpoints, or plan the program that `source` names."""
    from cncgen import pipeline
    from cncgen.cli.reading import opened, plan_options
    from cncgen.setpoints.readers import open_setpoints

    if source == "-" or source.lower().endswith(SETPOINT_SUFFIXES):
        with open_setpoints(source, axes=axes, period_s=period) as stream:
            yield stream
        return
    with opened(source, reading, planning["path_tolerance"]) as program:
        yield pipeline.sample(pipeline.plan(program, machine, plan_options(planning)))
