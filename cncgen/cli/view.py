"""`cncgen view`: the page on a program's plan, opened in the browser."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.options import (
    machine_option,
    message_options,
    page_options,
    planning_options,
    program_options,
)
from cncgen.cli.types import FILE


@click.command("view")
@click.argument("program", metavar="PROGRAM", type=FILE)
@machine_option
@page_options
@planning_options
@program_options
@message_options
def command(
    program: str,
    machine: str,
    shown: dict[str, Any],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Open the page on a plan in the browser.

    It is the page that report writes, in a temporary file that stays until the system clears it. Where no browser can
    be started its name is printed.
    """
    from cncgen.cli.reading import page_of
    from cncgen.files import open_in_browser

    name, opened = open_in_browser(page_of(program, machine, shown, planning, reading))
    messages.note(f"{name}{'' if opened else ': no browser can be started here; open this file in one'}")
