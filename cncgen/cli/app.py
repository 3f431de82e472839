"""The only place where faults become a message and an exit code."""

from __future__ import annotations

# As in `cncgen.cli`: `signal` itself takes time to import.
import _signal  # type: ignore[import-not-found]
import os
import sys
import warnings
from collections.abc import Sequence

from cncgen.cli import memory, messages
from cncgen.diagnostics import CncgenError, RemarkWarning
from cncgen.files import remove_temporaries, silence, together

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

#: Exit code of a fault of cncgen itself (EX_SOFTWARE of sysexits.h).
INTERNAL_ERROR = 70


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a command, print its faults, and return the exit code."""
    messages.reset()
    warnings.showwarning = _show_warning
    warnings.simplefilter("always", RemarkWarning)
    try:
        try:
            code = _run(arguments)
        finally:
            memory.lift()
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        code = 0
    except OSError as error:
        messages.error("system", f"{error.filename or _nameless()}: {error.strerror or error}")
        code = 2
    messages.say_where_more_is_said()
    _silence_closed_streams()
    return code


def _nameless() -> str:
    """Return what an error of the system is about that names no file: the working directory, if it is gone."""
    try:
        os.getcwd()
    except OSError:
        return "the working directory"
    return "output"


def _run(arguments: Sequence[str] | None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        if words[:1] == ["check"] and words[1:] and not any(word.startswith("-") for word in words):
            return _check(words[1:])
        from cncgen.cli.commands import invoke

        return invoke(words)
    except KeyboardInterrupt:
        messages.error("interrupted", "the command was interrupted")
        return 130
    except CncgenError as error:
        messages.show_error(error)
        return error.exit_code
    except (OSError, SystemExit):
        raise
    except Exception as error:
        if memory.is_lack(error):
            memory.lift()
            fault = memory.exhausted(error)
            messages.show_error(fault)
            return fault.exit_code
        help = "this is a fault of cncgen; CNCGEN_TRACEBACK=1 in the environment shows the whole trace"
        messages.error("internal", f"internal error: {_origin(error)}{type(error).__name__}: {error}", help)
        if os.environ.get("CNCGEN_TRACEBACK"):
            import traceback

            traceback.print_exc()
        return INTERNAL_ERROR


def _check(programs: list[str]) -> int:
    """Check files where no option is to be parsed: click and the options take longer than a program of thousands of lines."""
    from cncgen.cli.checking import check_all
    from cncgen.toolpath.reading import ReadOptions

    memory.bound(memory.DEFAULT_MIB)
    messages.json_to_standard_output()
    with together():
        return check_all(programs, None, None, ReadOptions(tips_alone=True))


def _origin(error: Exception) -> str:
    """Return file and line of our innermost frame, for a report of the fault."""
    import traceback

    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "cncgen" in frame.filename]
    if not frames:
        return ""
    return f"{os.path.basename(frames[-1].filename)}:{frames[-1].lineno}: "


def last_words(number: int) -> None:
    """Remove half-written files and print a message if a signal ends the process during an import."""
    remove_temporaries()
    if number == _signal.SIGINT:
        messages.error("interrupted", "the command was interrupted")


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Show a remark of ours, or that kernels are slow; warnings of libraries say nothing to a user (tests make errors of them)."""
    from cncgen.kernels import UncompiledWarning

    if isinstance(message, RemarkWarning):
        messages.show_once(message.diagnostic)
    elif isinstance(message, UncompiledWarning):
        messages.warning("kernels-uncompiled", str(message))


def _silence_closed_streams() -> None:
    """Point streams that nobody reads any more at nothing, so that closing them at exit says nothing."""
    for stream in (sys.stdout, sys.stderr):
        if stream is None:
            continue
        try:
            stream.flush()
        except (OSError, ValueError):
            silence(stream)
