"""`cncgen check`: reads and interprets programs, writes nothing."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.options import message_options, program_options
from cncgen.cli.types import FILE


@click.command("check")
@click.argument("programs", metavar="PROGRAM...", type=FILE, nargs=-1, required=True)
@click.option(
    "--tree", is_flag=True, help="Print the workplan of STEP-NC programs with tools, feeds and times."
)
@program_options
@message_options
def command(programs: tuple[str, ...], tree: bool, reading: dict[str, Any]) -> int:
    """Read programs and name what is wrong with them.

    Nothing is planned or written. With --json the diagnostics go to standard output.
    """
    from cncgen.diagnostics import CncgenError
    from cncgen.files import read_bytes, together

    messages.json_to_standard_output()
    code = 0
    for name in programs:
        try:
            with together():
                # A tree is made from the text again, which standard input has once.
                content = read_bytes(name) if tree else None
                _check(name, reading, content)
                if content is not None:
                    _show_tree(name, content, reading)
        except CncgenError as error:
            messages.show(error.diagnostics)
            code = max(code, error.exit_code)
    return code


def _check(name: str, reading: dict[str, Any], content: bytes | None) -> None:
    from cncgen.cli.reading import read_options
    from cncgen.diagnostics import CncgenError, Diagnostics, ProgramError
    from cncgen.kernels import warn_if_uncompiled
    from cncgen.pipeline import check

    warn_if_uncompiled()
    language, options = read_options(reading)
    found = Diagnostics()
    try:
        count = check(name, found, language=language, options=options, content=content)
    except CncgenError as error:
        raised = {id(item) for item in error.diagnostics}
        messages.show(item for item in found if id(item) not in raised)
        raise
    if found.has_errors:
        raise ProgramError(found)
    messages.show(found)
    messages.note(f"{name}: no errors, {count} motions and events")


def _show_tree(name: str, content: bytes, reading: dict[str, Any]) -> None:
    from cncgen.cli.reading import read_options
    from cncgen.files import write_text
    from cncgen.pipeline import language_of

    language, options = read_options(reading)
    if (language or language_of(name, content)) != "stepnc":
        return
    from cncgen.stepnc import tree

    write_text(None, "".join(f"{line}\n" for line in tree(content, name, options)))
