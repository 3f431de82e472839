"""`cncgen check`: reads and interprets programs, writes nothing."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.options import message_options, program_options


@click.command("check")
@click.argument("programs", metavar="PROGRAM...", nargs=-1, required=True)
@program_options
@message_options
def command(programs: tuple[str, ...], reading: dict[str, Any]) -> int:
    """Read programs and name what is wrong with them.

    Nothing is planned or written. With --json the diagnostics go to standard output.
    """
    from cncgen.diagnostics import CncgenError

    messages.json_to_standard_output()
    code = 0
    for name in programs:
        try:
            _check(name, reading)
        except CncgenError as error:
            messages.show(error.diagnostics)
            code = max(code, error.exit_code)
    return code


def _check(name: str, reading: dict[str, Any]) -> None:
    from cncgen.cli.reading import opened
    from cncgen.pipeline import sound

    with opened(name, reading) as program:
        rows = sum(len(chunk) for chunk in sound(program))
    messages.note(f"{name}: no errors, {rows} motions and events")
