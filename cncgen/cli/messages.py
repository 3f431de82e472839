"""All messages of a command, on standard error: diagnostics (as text or as JSON lines), warnings, and lines of the summary."""

from __future__ import annotations

import errno
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from cncgen.diagnostics import CONTROLS, CncgenError, Diagnostic, Diagnostics, Severity, json_values, more
from cncgen.files import STANDARD, file_fault, open_output, silence

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, ClassVar, TextIO

    import click


class _Style:
    """How messages are printed in this run."""

    json = False
    quiet = False
    #: Where JSON diagnostics go; None: standard error.
    json_stream: TextIO | None = None
    #: Diagnostics that are kept for the end of the run, in place of being printed; None: none are.
    kept: list[Diagnostic] | None = None
    #: Codes of the diagnostics that were printed as text, each once, in order.
    codes: ClassVar[dict[str, None]] = {}
    #: Remarks that were told in this run.
    told: ClassVar[set[tuple[str, str]]] = set()


#: Characters that control a terminal, as they are shown; lines end as they do.
_SHOWN = {code: shown for code, shown in CONTROLS.items() if code not in (0x09, 0x0A)}


def reset() -> None:
    """Go back to the style that a run starts with."""
    _Style.json = _Style.quiet = False
    _Style.json_stream = _Style.kept = None
    _Style.codes = {}
    _Style.told = set()


def keep() -> list[Diagnostic]:
    """Keep the diagnostics of this run in the list that is returned, in place of printing them."""
    _Style.kept = []
    return _Style.kept


def set_json(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    """Print diagnostics as JSON lines (the callback of ``--json``)."""
    _Style.json = value


def print_json() -> None:
    """Print diagnostics as JSON lines from here on."""
    _Style.json = True


def set_quiet(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    """Print diagnostics alone (the callback of ``--quiet``)."""
    _Style.quiet = value


def json_to_standard_output() -> None:
    """Send JSON diagnostics to standard output: of a command that has nothing else to print there."""
    _Style.json_stream = sys.stdout


def is_quiet() -> bool:
    """Tell whether summaries and progress are unwanted: with ``--quiet``, and among the JSON lines of ``--json``."""
    return _Style.quiet or _Style.json


def show_error(fault: CncgenError) -> None:
    """Print the fault that ended the work."""
    show(fault.diagnostics)
    _show_suppressed(fault.suppressed)


def show(diagnostics: Iterable[Diagnostic] | Diagnostics, *, as_json: bool = False) -> None:
    """Print diagnostics, once each; `as_json` where ``--json`` stands in arguments that could not be read."""
    for diagnostic in diagnostics:
        if _Style.kept is not None:
            _Style.kept.append(diagnostic)
        elif _Style.json or as_json:
            import json

            text = json.dumps(diagnostic.as_json())
            if _Style.json_stream:
                _to_json_stream(_Style.json_stream, text)
            else:
                plain(text)
        else:
            plain(diagnostic.render())
            _Style.codes[diagnostic.code] = None
    if isinstance(diagnostics, Diagnostics):
        _show_suppressed(diagnostics.suppressed)


def show_once(remark: Diagnostic) -> None:
    """Print a remark unless this run has told it: a comparison makes the same loop for each of its rows."""
    said = (remark.code, remark.render())
    if said not in _Style.told:
        _Style.told.add(said)
        show([remark])


def say_where_more_is_said() -> None:
    """Name the page that explains the reported codes, if a person reads at a terminal."""
    if _Style.codes and not is_quiet() and sys.stderr is not None and sys.stderr.isatty():
        first = next(iter(_Style.codes))
        name = first if len(_Style.codes) == 1 else "CODE"
        example = "" if name == first else f" of each, as cncgen explain {first}"
        plain(f"cncgen explain {name} has cause, cure and an example{example}")


def _to_json_stream(stream: TextIO, text: str) -> None:
    """Print a JSON line to the stream of a command's data; if it cannot be written, later messages go elsewhere."""
    try:
        print(text, file=stream, flush=True)
    except BrokenPipeError:
        raise
    except OSError as error:
        _Style.json_stream = None
        silence(stream)
        raise file_fault("standard output", "write", error) from error


def _show_suppressed(count: int) -> None:
    """Say how many diagnostics were counted and not kept, if any."""
    if count and _Style.json:
        show([Diagnostic("suppressed", more(count), Severity.NOTE, values={"count": count})])
    elif count:
        plain(more(count))


def error(code: str, message: str, hint: str = "") -> None:
    """Print an error outside any file."""
    show([Diagnostic(code, message, hint=hint)])


def warning(code: str, message: str) -> None:
    """Print a warning outside any file."""
    show([Diagnostic(code, message, Severity.WARNING)])


def note(message: str) -> None:
    """Print a line of the summary, unless it `is_quiet`."""
    if not is_quiet():
        plain(message)


def plain(message: str) -> None:
    """Print a line on standard error; if it cannot be written (closed pipe, full disk), the command goes on.

    Names of files and machines may hold control characters; these are shown, not executed.
    """
    if sys.stderr is None:
        return
    try:
        print(message.translate(_SHOWN), file=sys.stderr)
    except OSError:
        silence(sys.stderr)


def write_summary(path: str | None, values: dict[str, Any]) -> None:
    """Write a summary as JSON where ``--summary`` says: a file, ``-`` for standard error, None for nowhere."""
    with open_summary(path) as write:
        write(values)


@contextmanager
def open_summary(path: str | None) -> Iterator[Callable[[dict[str, Any]], None]]:
    """Open the file of ``--summary`` before the work begins, so that a wrong name is found at once; yield its writer."""
    if path is None:
        yield lambda values: None
        return
    if path == STANDARD:
        if sys.stderr is None:  # the process was started with it closed
            raise file_fault("standard error", "write", OSError(errno.EBADF, "it is closed"))
        yield lambda values: _to_standard_error(_as_json(values))
        return
    with open_output(path) as file:

        def write(values: dict[str, Any]) -> None:
            file.write(_as_json(values).encode() + b"\n")
            file.flush()

        yield write


def _as_json(values: dict[str, Any]) -> str:
    import json

    return json.dumps(json_values(values), indent=2)


def _to_standard_error(text: str) -> None:
    """Print the requested output, unlike `plain`: a full disk is a fault, as with a file."""
    try:
        print(text, file=sys.stderr, flush=True)
    except BrokenPipeError:  # the reader went away; other files may wait for the end
        silence(sys.stderr)
    except OSError as error:
        raise file_fault("standard error", "write", error) from error
