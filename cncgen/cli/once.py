"""Options of one value that a call gives several times: click silently takes the last one; here the call is refused."""

from __future__ import annotations

from contextlib import suppress

import click


class OnceGroup(click.Group):
    """A group whose commands take each option once, except flags and options of many values."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the arguments name, and look at its options."""
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None and not ctx.resilient_parsing and (again := _given_again(command, rest)):
            raise click.UsageError(f"{again} is given more than once.", click.Context(command, ctx, name))
        return name, command, rest


def _given_again(command: click.Command, words: list[str]) -> str:
    """Return an option of one value that words give several times, or ""."""
    with suppress(click.UsageError):  # other faults of the words are reported when they are used
        _, _, order = command.make_parser(click.Context(command)).parse_args(list(words))
        for option in order:
            single = isinstance(option, click.Option) and not (
                option.multiple or option.is_flag or option.count
            )
            if single and order.count(option) > 1:
                return max(option.opts, key=len)
    return ""
