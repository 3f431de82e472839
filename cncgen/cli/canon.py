"""`cncgen canon`: the canonical motions of a program as text."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli.options import control_option, message_options, output_option, program_options
from cncgen.cli.types import FILE


@click.command("canon")
@click.argument("program", metavar="PROGRAM", type=FILE)
@output_option
@control_option
@program_options
@message_options
def command(program: str, output: str | None, machine: str | None, reading: dict[str, Any]) -> None:
    """Print the canonical motions of a program, one call a line.

    The notation is that of NIST's canonical machining functions (NISTIR 6556) as LinuxCNC's rs274 -g prints them, and
    the machine is the imaginary one of rs274: without options, `cncgen canon FILE --tool-table TABLE` prints what
    `rs274 -g -t TABLE FILE` does. As there, the calls end at the first error; all errors are named.
    """
    from cncgen.cli import messages
    from cncgen.cli.reading import read_options
    from cncgen.diagnostics import Diagnostics, ProgramError
    from cncgen.files import open_output
    from cncgen.pipeline import canon

    language, options = read_options(reading, machine=machine, as_rs274=True, tips_alone=True)
    found = Diagnostics()
    lines = canon(program, language=language, options=options, diagnostics=found)
    head = next(lines, None)
    with open_output(output) as sink:
        if head is not None:
            sink.write(f"{head}\n".encode())
        for line in lines:
            sink.write(f"{line}\n".encode())
        if found.has_errors:
            raise ProgramError(found)
    messages.show(found)
