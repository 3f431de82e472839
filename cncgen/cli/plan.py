"""`cncgen plan`: a program becomes setpoints."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.options import (
    CONTROLS,
    format_option,
    machine_option,
    message_options,
    output_option,
    planning_options,
    program_options,
    summary_option,
)
from cncgen.cli.types import FILE

if TYPE_CHECKING:
    from cncgen.setpoints.columns import Layout
    from cncgen.setpoints.writers import Writer


@click.command("plan")
@click.argument("program", metavar="PROGRAM", type=FILE)
@machine_option
@output_option
@format_option
@planning_options
@click.option(
    "--as",
    "control",
    type=click.Choice(CONTROLS),
    help="Estimate what this control would take by its own rules: a summary and events, no setpoints.",
)
@click.option(
    "--signals",
    metavar="LIST",
    default="",
    help="Further columns: of vel,acc,jerk,feed,line,limit,programmed,source,tool_length, by commas.",
)
@click.option(
    "--events", metavar="FILE", type=FILE, help="Write events (spindle, tool, dwell ...) as JSON lines."
)
@summary_option
@program_options
@message_options
def command(
    program: str,
    machine: str,
    output: str | None,
    format: str | None,
    planning: dict[str, Any],
    control: str | None,
    signals: str,
    events: str | None,
    summary: str | None,
    reading: dict[str, Any],
) -> None:
    """Turn a program into setpoints.

    With --feedrate optimal the plan keeps every limit of the machine; ild and the baselines do as their papers say, and the summary
    shows their demands on each axis. Setpoints go to standard output, or to the file of -o (whole or not at all); all else goes to
    standard error. Without -o only the summary is printed on a terminal.
    """
    from cncgen.cli.progress import with_progress
    from cncgen.cli.reading import opened, plan_options
    from cncgen.cli.writing import setpoint_format
    from cncgen.pipeline import plan_with_summary
    from cncgen.report.summary import as_text

    if control is not None and (output is not None or format is not None or signals):
        raise click.UsageError(
            f"--as {control} estimates times; it has no setpoints to write with -o, --format or --signals"
        )
    names = tuple(name.strip() for name in signals.split(",") if name.strip())
    if signals and not names:
        raise click.UsageError("--signals names nothing: names go here, separated by commas")
    kind = setpoint_format(output, format)
    with opened(program, reading, planning["path_tolerance"], machine) as read:
        options = replace(plan_options(planning), control=control)
        stream, watch = plan_with_summary(read, machine, options, names)
        chunks = with_progress(stream.chunks, stream.name, stream.period_s, watch.done)
        # The first rows are drawn before anything is opened: a program that has no plan leaves no trace.
        head = next(chunks, None)
        with ExitStack() as files:
            write_summary = files.enter_context(messages.open_summary(summary))
            layout = stream.layout(names)
            writers = _writers(
                files,
                layout,
                output,
                kind,
                events,
                wanted=control is None,
                outlives_reader=bool(summary or events),
            )
            for chunk in chain(() if head is None else (head,), chunks):
                for writer in writers:
                    writer.write(chunk)
            for writer in writers:
                writer.close()
            result = watch.as_json()
            write_summary(result)
        messages.show(watch.remarks)
    messages.note(as_text(result))


def _writers(
    files: ExitStack,
    layout: Layout,
    output: str | None,
    kind: str,
    events: str | None,
    *,
    wanted: bool,
    outlives_reader: bool,
) -> list[Writer]:
    """Open where setpoints and events go; nothing for setpoints that are not `wanted`, or would go to a terminal unasked.

    With `outlives_reader` the work goes on where a reader of standard output goes away: other files wait for the end.
    """
    from cncgen.files import is_terminal, open_output
    from cncgen.setpoints.events import EventWriter
    from cncgen.setpoints.writers import open_writer

    writers: list[Writer] = []
    if events:
        writers.append(EventWriter(files.enter_context(open_output(events))))
    if wanted and (output is not None or not is_terminal(sys.stdout)):
        sink = files.enter_context(open_output(output, outlives_reader=outlives_reader))
        writers.append(open_writer(kind, sink, layout))
    return writers
