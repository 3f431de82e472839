"""`cncgen explain`: the cause of a diagnostic, its cure and an example."""

from __future__ import annotations

import click

from cncgen.cli.options import message_options


class CodeName(click.ParamType):
    """The name of a diagnostic, which the shell completes."""

    name = "code"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[click.shell_completion.CompletionItem]:
        """Return the codes that begin so."""
        from click.shell_completion import CompletionItem

        from cncgen.explanations import codes

        return [CompletionItem(code) for code in codes() if code.startswith(incomplete)]


@click.command("explain")
@click.argument("code", metavar="[CODE]", type=CodeName(), required=False)
@message_options
def command(code: str | None) -> None:
    """Print the meaning of a diagnostic: cause, cure and an example.

    CODE is the word in brackets: arc-radius of error[arc-radius]. Without it, all codes are listed.
    """
    import difflib

    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.explanations import codes, explanation
    from cncgen.files import write_text

    if code is None:
        write_text(None, "".join(f"{each}\n" for each in codes()))
        return
    found = explanation(code.strip("[]"))
    if found is None:
        near = difflib.get_close_matches(code, codes(), 3)
        hint = f"is {' or '.join(near)} meant?" if near else "cncgen explain lists all codes"
        raise UsageError(Diagnostic("usage", f"no diagnostic is called {code}", hint=hint))
    write_text(None, found.text())
