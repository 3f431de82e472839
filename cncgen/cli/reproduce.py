"""`cncgen reproduce`: the papers' tables and figures from our own data."""

from __future__ import annotations

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import message_options, output_option, summary_option
from cncgen.cli.types import FOLDER


@click.command("reproduce")
@click.argument("name", metavar="[NAME]", required=False)
@click.option(
    "--plots", metavar="DIR", type=FOLDER, help="Draw the papers' figures into this folder instead."
)
@click.option(
    "--programs",
    metavar="DIR",
    type=FOLDER,
    help="Folder of the example programs [default: those that ship].",
)
@output_option
@summary_option
@message_options
def command(
    name: str | None, plots: str | None, programs: str | None, output: str | None, summary: str | None
) -> int:
    """Compute the printed values of the papers.

    Each row has the printed value, ours, the tolerance, how ours came about, and whether the item is reproduced, not reproduced
    (with the reason) or not reproducible. NAME is 000 (Yeh and Sun 2008), 001 (Chen and Hsu), 002 (Jung and Choi), 003 (Tsai 2010)
    or 004 (Hsu 1999); without it all are computed. An output that ends in .md is a page of Markdown. Exit 1 where a tolerance is
    missed without a stated reason, or a check of ours does not hold.
    """
    from cncgen.files import write_text
    from cncgen.papers.reproduction import as_markdown, as_text, as_values, draw_papers, explained, reproduce

    if plots is not None:
        for path in draw_papers(plots, name, programs):
            messages.note(path)
        return 0
    found = reproduce(name, programs)
    page = output is not None and output.lower().endswith(".md")
    write_text(output, as_markdown(found) if page else as_text(found))
    write_summary(summary, as_values(found))
    return 0 if explained(found) else 1
