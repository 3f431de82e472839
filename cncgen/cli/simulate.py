"""`cncgen simulate`: the response of the servo axes to setpoints, or to a program that is planned first."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import (
    machine_option,
    message_options,
    output_option,
    planning_options,
    program_options,
    setpoint_options,
    summary_option,
)
from cncgen.cli.types import FILE, FiniteRange

if TYPE_CHECKING:
    from cncgen.servo.record import Response
    from cncgen.setpoints.stream import SetpointStream


@click.command("simulate")
@click.argument("source", metavar="[SETPOINTS|PROGRAM]", type=FILE, default="-")
@machine_option
@output_option
@planning_options
@click.option(
    "--controller",
    metavar="NAME",
    default="p",
    show_default=True,
    help="Each axis's own controller (p), or plain, feedforward, zpetc, ccc, zpetc+ccc, tcf, mirror, h-infinity.",
)
@setpoint_options
@click.option(
    "--settle",
    metavar="SECONDS",
    type=FiniteRange(0, 3600),
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
    controller: str,
    format: str | None,
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
    from cncgen.cli.writing import check_response_name
    from cncgen.files import is_terminal, open_output
    from cncgen.pipeline import simulate
    from cncgen.report.response import as_text
    from cncgen.servo.response_csv import written
    from cncgen.servo.summary import ResponseSummary, watched

    check_response_name(output)
    servos = planning["axis_params"] or machine
    watch = ResponseSummary()
    with _setpoints(source, machine, planning, (format, axes, period), reading) as stream:
        responses = watched(simulate(stream, servos, controller=controller, settle_s=settle), watch)
        if output is None and is_terminal(sys.stdout):
            _draw(responses)
        else:
            # The first rows are drawn before anything is opened: a failed simulation leaves no file.
            head = next(responses, None)
            with open_output(output, outlives_reader=bool(summary)) as sink:
                _draw(written(sink, chain(() if head is None else (head,), responses)))
    result = {
        "schema_version": 1,
        "setpoints": source,
        "axis_params": servos,
        "controller": controller,
        **watch.as_dict(),
    }
    write_summary(summary, result)
    messages.note(as_text(result))


def _draw(chunks: Iterable[Response]) -> None:
    for _ in chunks:
        pass


@contextmanager
def _setpoints(
    source: str,
    machine: str,
    planning: dict[str, Any],
    given: tuple[str | None, str | None, float | None],
    reading: dict[str, Any],
) -> Iterator[SetpointStream]:
    """Open setpoints, whose format, axes and period may be `given`, or plan the program that `source` names."""
    from cncgen.cli.reading import is_setpoint_file, planned, planning_machine
    from cncgen.pipeline import machine_of, sample
    from cncgen.setpoints.readers import open_setpoints

    format, axes, period = given
    if format or source == "-" or is_setpoint_file(source):
        usual = machine_of(machine).period_s
        with open_setpoints(
            source, format=format, axes=axes, period_s=period, default_period_s=usual
        ) as stream:
            yield stream
        return
    with planned(source, reading, planning, planning_machine(machine, planning)) as plan:
        yield sample(plan)
