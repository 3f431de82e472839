"""`cncgen why`: which limits, feeds and tolerances would shorten a program, ranked."""

from __future__ import annotations

from typing import Any

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
from cncgen.cli.types import FILE


@click.command("why")
@click.argument("program", metavar="PROGRAM", type=FILE)
@machine_option
@output_option
@summary_option
@planning_options
@program_options
@message_options
def command(
    program: str,
    machine: str,
    output: str | None,
    summary: str | None,
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Rank the limits, feeds and tolerances that would shorten a program.

    For each velocity, acceleration and jerk of an axis, the feed, the tolerances, the period, the rapids and the entries of
    [times]: the seconds that a change of 10 % saves, by the derivative and by planning again, and the lines that save most.
    --summary writes the ranking as JSON.
    """
    from cncgen.cli.progress import counted_progress
    from cncgen.cli.reading import opened, plan_options
    from cncgen.files import write_text
    from cncgen.pipeline import machine_of, why
    from cncgen.report.shortening import as_text

    where = machine_of(machine)
    with (
        opened(program, reading, planning["path_tolerance"], machine) as read,
        counted_progress(f"{program}: plan") as watch,
    ):
        now, found = why(read, where, plan_options(planning), watch=watch)
    write_text(output, as_text(now, found, program) + "\n")
    values = {
        "schema_version": 1,
        "program": program,
        "machine": where.name,
        "cycle_time_s": now.cycle_s,
        "cycle_time_split_s": now.parts,
        "tools": [{"tool": tool, "time_s": seconds} for tool, seconds in now.tools.items()],
        "quantities": [each.as_json() for each in found],
    }
    messages.write_summary(summary, values)
