"""`cncgen codes`: the G-code that is understood, from the interpreter's own tables."""

from __future__ import annotations

import click

from cncgen.cli.options import message_options
from cncgen.toolpath.reading import DIALECTS


@click.command("codes")
@click.option(
    "--dialect",
    type=click.Choice(DIALECTS[1:]),
    help="Codes of this dialect alone [default: all, with the dialects that have each].",
)
@message_options
def command(dialect: str | None) -> None:
    """List the codes that are understood."""
    from cncgen.files import write_text
    from cncgen.gcode.codes.reference import DIALECTS as ALL
    from cncgen.gcode.codes.reference import rows
    from cncgen.report.tables import left_table

    found = list(rows((dialect,) if dialect else ALL))
    write_text(None, left_table(("code", "words", "dialects", "meaning"), found))
