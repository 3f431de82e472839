"""`cncgen check`: reads and interprets programs, writes nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.checking import JSON, TEXT, check_all
from cncgen.cli.options import control_option, message_options, program_options
from cncgen.cli.reading import read_options
from cncgen.cli.types import FILE
from cncgen.diagnostics import CncgenError

if TYPE_CHECKING:
    from cncgen.diagnostics import Diagnostic


@click.command("check")
@click.argument("programs", metavar="PROGRAM...", type=FILE, nargs=-1, required=True)
@click.option(
    "--tree", is_flag=True, help="Print the workplan of STEP-NC programs with tools, feeds and times."
)
@click.option(
    "--json-tree", is_flag=True, help="Print it as JSON: a line a program, with the work of each workingstep."
)
@click.option(
    "--output-format",
    type=click.Choice(["text", "json", "sarif", "github"]),
    default="text",
    show_default=True,
    help="How diagnostics are written: sarif as one log (SARIF 2.1.0), github as commands of its workflows; all but text to "
    "standard output.",
)
@control_option
@program_options
@message_options
def command(
    programs: tuple[str, ...],
    tree: bool,
    json_tree: bool,
    output_format: str,
    machine: str | None,
    reading: dict[str, Any],
) -> int:
    """Read programs and report their faults.

    Nothing is planned or written. With --json the diagnostics go to standard output.
    """
    from cncgen.files import write_text

    if tree and json_tree:
        raise click.UsageError(
            "--tree and --json-tree ask for the same as text and as JSON: give one of them"
        )
    shape = JSON if json_tree else TEXT if tree else None
    messages.json_to_standard_output()
    if output_format == "json":
        messages.print_json()
    if output_format in ("text", "json"):
        return check_all(programs, shape, *read_options(reading, machine=machine, tips_alone=True))
    kept = messages.keep()
    try:
        code = check_all(programs, shape, *read_options(reading, machine=machine, tips_alone=True))
    except CncgenError as error:  # of the options
        messages.show_error(error)
        code = error.exit_code
    write_text(None, _written(kept, output_format))
    return code


def _written(found: list[Diagnostic], output_format: str) -> str:
    """Return diagnostics as a SARIF log or as commands of GitHub's workflows."""
    from cncgen import __version__
    from cncgen.report.annotations import github, sarif

    return sarif(found, __version__) if output_format == "sarif" else github(found)
