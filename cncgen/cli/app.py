"""The group of commands, and the one place where what went wrong becomes a message and an exit code."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import click

from cncgen.cli import memory, messages
from cncgen.diagnostics import CncgenError, Diagnostic, RemarkWarning
from cncgen.files import remove_temporaries, silence, together

#: Commands in the order of ``--help``, each a module of this package with a click command `command`.
COMMANDS = (
    "check",
    "canon",
    "plan",
    "simulate",
    "verify",
    "cut",
    "convert",
    "compare",
    "sweep",
    "why",
    "compensate",
    "identify",
    "excite",
    "tune",
    "reproduce",
    "plot",
    "report",
    "view",
    "codes",
    "explain",
    "machines",
)

#: Exit code of what is our fault (EX_SOFTWARE of sysexits.h).
INTERNAL_ERROR = 70


class Commands(click.Group):
    """A group that imports a command's module when the command is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command by its name."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(f"cncgen.cli.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the arguments name; name the nearest one for an unknown name."""
        if args[0] not in COMMANDS and (near := _near(args[0])):
            ctx.fail(f"No such command {args[0]!r}; did you mean {near}?")
        return super().resolve_command(ctx, args)


def _near(name: str) -> str:
    """Return the command whose name is nearest to one that is unknown, or ""."""
    import difflib

    return next(iter(difflib.get_close_matches(name, COMMANDS, 1)), "")


@click.group(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="cncgen")
def cli() -> None:
    """NC programs to servo setpoints: as fast as the machine's limits allow, and never over them.

    PROGRAM is a file, or - for standard input. Exit codes: 0 done, 1 the program has errors (or verify found a limit
    broken), 2 wrong usage or an unreadable file, 3 no plan exists within the limits.
    """


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a command; print what went wrong; return the exit code."""
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
        messages.error(f"{error.filename or _nameless()}: {error.strerror or error}")
        code = 2
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
        if "_CNCGEN_COMPLETE" in os.environ:  # click's completion in the shell
            cli.main(prog_name="cncgen")
        # Not `cli.main`, which would turn a broken pipe into exit code 1.
        with cli.make_context("cncgen", list(words)) as context, together():
            outcome: Any = cli.invoke(context)
        return outcome if isinstance(outcome, int) else 0
    except click.exceptions.Exit as error:
        return error.exit_code
    except click.ClickException as error:
        if "--json" in words:
            messages.show([Diagnostic("usage", error.format_message())], as_json=True)
        else:
            error.show()
        return 2
    except (click.Abort, KeyboardInterrupt):
        messages.error("interrupted")
        return 130
    except CncgenError as error:
        messages.show_error(error)
        return error.exit_code
    except (OSError, SystemExit):
        raise
    except MemoryError:
        memory.lift()
        fault = memory.exhausted()
        messages.show_error(fault)
        return fault.exit_code
    except Exception as error:
        help = "this is a fault of cncgen; CNCGEN_TRACEBACK=1 in the environment shows the whole trace"
        messages.error(f"internal error: {_origin(error)}{type(error).__name__}: {error}", help)
        if os.environ.get("CNCGEN_TRACEBACK"):
            import traceback

            traceback.print_exc()
        return INTERNAL_ERROR


def _origin(error: Exception) -> str:
    """Return file and line of our innermost frame, for a report of the fault."""
    import traceback

    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "cncgen" in frame.filename]
    if not frames:
        return ""
    return f"{os.path.basename(frames[-1].filename)}:{frames[-1].lineno}: "


def last_words(number: int) -> None:
    """Remove half-written files, and say what happened, where a signal ends the process amid an import."""
    remove_temporaries()
    if number == signal.SIGINT:
        messages.error("interrupted")


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Show a remark of ours, or that kernels are slow; warnings of libraries say nothing to a user (tests make errors of them)."""
    from cncgen.kernels import UncompiledWarning

    if isinstance(message, RemarkWarning):
        messages.show([message.diagnostic])
    elif isinstance(message, UncompiledWarning):
        messages.warning(str(message))


def _silence_closed_streams() -> None:
    """Point streams that nobody reads any more at nothing, so that closing them at exit says nothing."""
    for stream in (sys.stdout, sys.stderr):
        if stream is None:
            continue
        try:
            stream.flush()
        except (OSError, ValueError):
            silence(stream)
