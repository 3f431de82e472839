"""The group of commands, and how click runs it."""

from __future__ import annotations

import importlib
import os
from contextlib import suppress
from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.once import OnceGroup
from cncgen.diagnostics import Diagnostic
from cncgen.files import together

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


class Commands(OnceGroup):
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
        if not ctx.resilient_parsing and args[0] not in COMMANDS and (near := _near(args[0])):
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

    PROGRAM is a file, or - for standard input. Exit codes: 0 done, 1 the program has errors (or verify or cut
    found faults), 2 wrong usage or an unreadable file, 3 no plan exists within the limits.
    """


def _completed() -> int:
    """Tell a shell what may stand where its cursor is, as its variables ask; return the exit code."""
    with suppress(ValueError):  # of a place of the cursor that is no number
        cli.main([], prog_name="cncgen")
    return 1


def invoke(words: list[str]) -> int:
    """Run the command that the arguments name; report their faults; return the exit code."""
    try:
        if "_CNCGEN_COMPLETE" in os.environ:  # click's completion in the shell
            return _completed()
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
    except click.Abort as error:
        raise KeyboardInterrupt from error
