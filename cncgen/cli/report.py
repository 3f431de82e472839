"""`cncgen report`: one self-contained HTML page on a program's plan."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from cncgen.cli.options import (
    machine_option,
    message_options,
    output_option,
    page_options,
    planning_options,
    program_options,
)
from cncgen.cli.types import FILE
from cncgen.diagnostics import Diagnostic, UsageError

#: Of the names of pages; standard output has none.
_SUFFIXES = ("", ".html", ".htm")


@click.command("report")
@click.argument("program", metavar="PROGRAM", type=FILE)
@machine_option
@output_option
@page_options
@planning_options
@program_options
@message_options
def command(
    program: str,
    machine: str,
    output: str | None,
    shown: dict[str, Any],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Write an HTML page on a plan.

    The path in three dimensions, curves over time with their limits, the program with the time of each line, the verdict of verify,
    and the places where time is lost. The page needs nothing else to be opened.
    """
    from cncgen.cli.reading import page_of
    from cncgen.files import write_text

    if output is not None and Path(output).suffix.lower() not in _SUFFIXES:
        raise UsageError(
            Diagnostic(
                "page-format",
                f"{output}: a page is written as .html",
                hint="cncgen plot writes pictures, cncgen plan setpoints",
            )
        )
    write_text(output, page_of(program, machine, shown, planning, reading))
