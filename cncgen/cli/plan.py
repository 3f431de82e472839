"""`cncgen plan`: a program becomes setpoints."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import chain
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import (
    format_option,
    machine_option,
    message_options,
    output_option,
    planning_options,
    program_options,
    summary_option,
)

if TYPE_CHECKING:
    from cncgen.setpoints.record import Setpoints
    from cncgen.setpoints.stream import SetpointStream


@click.command("plan")
@click.argument("program", metavar="PROGRAM")
@machine_option
@output_option
@format_option
@planning_options
@click.option(
    "--signals",
    metavar="LIST",
    default="",
    help="Further columns: of vel,acc,jerk,feed,line,limit, by commas.",
)
@click.option("--events", metavar="FILE", help="Write events (spindle, tool, dwell ...) as JSON lines.")
@summary_option
@program_options
@message_options
def command(
    program: str,
    machine: str,
    output: str | None,
    format: str | None,
    planning: dict[str, Any],
    signals: str,
    events: str | None,
    summary: str | None,
    reading: dict[str, Any],
) -> None:
    """Turn a program into setpoints.

    The plan keeps every limit of the machine. Setpoints go to standard output, or to the file of -o (whole or not at all); all else goes to standard error.
    Where standard output is a terminal and there is no -o, only the summary is printed.
    """
    from cncgen.cli.reading import opened, plan_options
    from cncgen.pipeline import plan_with_summary

    names = tuple(name.strip() for name in signals.split(",") if name.strip())
    with opened(program, reading, planning["path_tolerance"]) as read:
        stream, watch = plan_with_summary(read, machine, plan_options(planning), names)
        _write(stream, output, format, names, events, outlives_reader=bool(summary or events))
        messages.show(watch.remarks)
        result = watch.as_json()
    write_summary(summary, result)
    _show_summary(result)


def _write(
    stream: SetpointStream,
    output: str | None,
    format: str | None,
    signals: tuple[str, ...],
    events: str | None,
    outlives_reader: bool,
) -> None:
    """Send the setpoints and events where they go; draw them all in any case.

    With `outlives_reader`, also where a reader of standard output goes away: other files wait for the last row.
    """
    from cncgen.cli.progress import with_progress
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.files import STANDARD, is_terminal, open_output
    from cncgen.setpoints.columns import Layout
    from cncgen.setpoints.events import EventWriter
    from cncgen.setpoints.writers import BINARY, format_of, open_writer

    kind = format_of(output, format)
    terminal = output in (None, STANDARD) and is_terminal(sys.stdout)
    if terminal and output == STANDARD and kind in BINARY:
        raise UsageError(
            Diagnostic("binary-to-terminal", f"{kind} is binary and is not written to a terminal")
        )
    chunks: Iterator[Setpoints] = with_progress(stream.chunks, stream.name, stream.period_s)
    # The first rows are drawn before anything is opened: a program that has no plan leaves no trace.
    head = next(chunks, None)
    with ExitStack() as files:
        writers: list[Any] = []
        if events:
            writers.append(EventWriter(files.enter_context(open_output(events))))
        writer = None
        if not (terminal and output is None):
            layout = Layout(stream.axes, stream.period_s, signals)
            sink = files.enter_context(open_output(output, outlives_reader=outlives_reader))
            writer = open_writer(kind, sink, layout)
            writers.append(writer)
        for chunk in chain(() if head is None else (head,), chunks):
            for each in writers:
                each.write(chunk)
        if writer is not None:
            writer.close()


def _show_summary(result: dict[str, Any]) -> None:
    from cncgen.report.summary import as_text

    messages.note(as_text(result))
