"""`cncgen check`: reads and interprets programs, writes nothing."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.options import control_option, message_options, program_options
from cncgen.cli.types import FILE
from cncgen.diagnostics import CncgenError

if TYPE_CHECKING:
    from cncgen.diagnostics import Diagnostic
    from cncgen.toolpath.reading import ReadOptions

#: Shapes of a workplan that is printed.
_TEXT, _JSON = "text", "json"


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
    """Read programs and name what is wrong with them.

    Nothing is planned or written. With --json the diagnostics go to standard output.
    """
    from cncgen.files import write_text

    if tree and json_tree:
        raise click.UsageError(
            "--tree and --json-tree ask for the same as text and as JSON: give one of them"
        )
    shape = _JSON if json_tree else _TEXT if tree else None
    messages.json_to_standard_output()
    if output_format == "json":
        messages.print_json()
    if output_format in ("text", "json"):
        return _check_all(programs, shape, machine, reading)
    kept = messages.keep()
    try:
        code = _check_all(programs, shape, machine, reading)
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


def _check_all(
    programs: tuple[str, ...], shape: str | None, machine: str | None, reading: dict[str, Any]
) -> int:
    """Check one program after the other, and print their workplans in a `shape`; return the exit code."""
    from cncgen.cli.reading import read_options
    from cncgen.files import read_bytes, together

    code = failed = 0
    language, options = read_options(reading, machine=machine)
    for name in programs:
        try:
            with together():
                # A tree is made from the text again, which standard input has once.
                content = read_bytes(name) if shape else None
                _check(name, language, options, content)
                if content is not None and shape is not None:
                    _show_tree(name, language, options, content, shape)
        except CncgenError as error:
            messages.show_error(error)
            messages.note(f"{name}: {_counts(error.diagnostics, error.suppressed)}")
            code, failed = max(code, error.exit_code), failed + 1
    if len(programs) > 1:
        messages.note(f"{len(programs)} files: {len(programs) - failed} without errors, {failed} with errors")
    return code


def _counts(found: Iterable[Diagnostic], suppressed: int = 0) -> str:
    """Return how many errors and warnings there are; "no errors" without any."""
    from cncgen.diagnostics import Severity
    from cncgen.report.tables import counted

    severities = [item.severity for item in found]
    errors, warnings = (severities.count(each) for each in (Severity.ERROR, Severity.WARNING))
    texts = [counted(errors, "error") if errors else "no errors"]
    if warnings:
        texts.append(counted(warnings, "warning"))
    if suppressed:
        texts.append(f"{suppressed} more of either")
    return ", ".join(texts)


def _check(name: str, language: str | None, options: ReadOptions, content: bytes | None) -> None:
    from cncgen.diagnostics import CncgenError, Diagnostics, ProgramError
    from cncgen.kernels import warn_if_uncompiled
    from cncgen.pipeline import check
    from cncgen.pipeline.removing import coarse_findings

    warn_if_uncompiled()
    found = Diagnostics()
    try:
        count = check(name, found, language=language, options=options, content=content)
    except CncgenError as error:
        raised = {id(item) for item in error.diagnostics}
        messages.show(item for item in found if id(item) not in raised)
        raise
    if not found.has_errors:
        found.extend(coarse_findings(name, language, options, content))
    if found.has_errors:
        raise ProgramError(found)
    messages.show(found)
    counts = _counts(found, found.suppressed)
    messages.note(f"{name}: {counts}, {count} {'motion or event' if count == 1 else 'motions and events'}")


def _show_tree(name: str, language: str | None, options: ReadOptions, content: bytes, shape: str) -> None:
    from cncgen.files import write_text
    from cncgen.pipeline import language_of

    if (language or language_of(name, content)) != "stepnc":
        return
    from cncgen.stepnc import entries, tree

    if shape == _JSON:
        import json

        plans = [entry.as_json() for entry in entries(content, name, options)]
        write_text(None, json.dumps({"schema_version": 1, "program": name, "workplans": plans}) + "\n")
    else:
        write_text(None, "".join(f"{line}\n" for line in tree(content, name, options)))
