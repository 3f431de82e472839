"""`cncgen report`: one self-contained HTML page on a program's plan."""

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
)
from cncgen.cli.types import FILE


@click.command("report")
@click.argument("program", metavar="PROGRAM", type=FILE)
@machine_option
@output_option
@planning_options
@program_options
@message_options
def command(
    program: str, machine: str, output: str | None, planning: dict[str, Any], reading: dict[str, Any]
) -> None:
    """Write an HTML page on a plan.

    Figures, the path coloured by speed, the axes' velocity, acceleration and jerk with their limits, what verify
    says, and where time is lost. The page needs nothing else to be opened.
    """
    from cncgen.cli.reading import opened, plan_options, read_options
    from cncgen.files import write_text
    from cncgen.pipeline import report_page

    tolerance = planning["path_tolerance"]
    with opened(program, reading, tolerance, machine) as read:
        language, options = read_options(reading, tolerance)
        page = report_page(read, machine, plan_options(planning), language=language, reading=options)
        messages.show(page.remarks)
    write_text(output, page.html)
