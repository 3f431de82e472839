"""`cncgen machines`: the profiles that ship."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from cncgen.cli.once import OnceGroup
from cncgen.cli.options import message_options
from cncgen.cli.types import MACHINE

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from cncgen.machine import Machine


class _ShowByName(OnceGroup):
    """A group in which a name that is not a command's is a machine to show: ``machines xy-table``."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            args = ["show", *args]
        return super().resolve_command(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the commands and the profiles that begin so."""
        from click.shell_completion import CompletionItem

        from cncgen.machine import profile_names

        names = [CompletionItem(name) for name in profile_names() if name.startswith(incomplete)]
        return super().shell_complete(ctx, incomplete) + names


@click.group("machines", cls=_ShowByName, invoke_without_command=True)
@message_options
@click.pass_context
def command(context: click.Context) -> None:
    """List machine profiles, show one, or list the keys.

    A profile is shown as TOML to copy and edit, by "show NAME" or its name alone; keys are those of such a file.
    """
    if context.invoked_subcommand is None:
        from cncgen.files import write_text
        from cncgen.machine import load, profile_names

        rows = [(name, load(name)) for name in profile_names()]
        width = max(len(name) for name, _ in rows)
        write_text(None, "".join(f"{name:{width}}  {_described(machine)}\n" for name, machine in rows))


def _described(machine: Machine) -> str:
    """Return a line on a machine: axes, period, largest velocity."""
    from cncgen.units import file_unit, to_file

    axes = [
        f"{letter} {axis.max_velocity * to_file(letter):g} {file_unit(letter)}/s"
        for letter, axis in machine.axes.items()
    ]
    return f"{machine.period_s * 1000:g} ms; " + ", ".join(axes)


@command.command("show")
@click.argument("name", metavar="NAME|FILE", type=MACHINE)
@message_options
def show(name: str) -> None:
    """Print a machine as TOML to copy and edit.

    A profile, or a machine file as cncgen reads it.
    """
    from cncgen.files import write_text
    from cncgen.machine import load, profile_names, to_toml
    from cncgen.machine.shipped import profile_text

    write_text(None, profile_text(name) if name in profile_names() else to_toml(load(name)))


@command.command("keys")
@message_options
def keys() -> None:
    """List the keys of machine files.

    Of an axis x; a rotary one has deg where they have mm.
    """
    from cncgen.files import write_text
    from cncgen.machine.keys import rows
    from cncgen.report.tables import left_table

    write_text(None, left_table(("key", "value", "default", "meaning"), list(rows())))
