"""`cncgen codes`: the G-code that is understood, from the interpreter's own tables."""

from __future__ import annotations

import click

from cncgen.cli.options import message_options


@click.command("codes")
@click.option(
    "--dialect",
    type=click.Choice(("linuxcnc", "fanuc")),
    help="Codes of this dialect alone [default: all, with the dialects that have each].",
)
@message_options
def command(dialect: str | None) -> None:
    """List the G and M codes that are understood."""
    from cncgen.files import write_text
    from cncgen.gcode.codes import BOTH, Code, table
    from cncgen.report.tables import left_table

    found: dict[tuple[str, int], list[Code]] = {}
    for name in (dialect,) if dialect else BOTH:
        for key, code in table(name).items():
            alike = found.setdefault(key, [])
            if code not in alike:
                alike.append(code)
    rows = [
        (code.name, ", ".join(code.dialects), code.group, " ".join(code.words.upper()), code.help)
        for key in sorted(found)
        for code in found[key]
    ]
    write_text(None, left_table(("code", "dialects", "group", "words", "meaning"), rows))
