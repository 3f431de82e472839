"""Make files of the commands and the diagnostics: pages of the site, the manual page, completions of shells.

python docs/generate.py        # writes docs/shell again (a test holds it), and docs/generated, which the site takes
"""

from __future__ import annotations

import inspect
import re
import shutil
from collections.abc import Iterable
from pathlib import Path

import click
from click.shell_completion import get_completion_class

import cncgen
from cncgen.cli.commands import cli
from cncgen.explanations import ROOMS, codes, explanation

DOCS = Path(__file__).resolve().parent
#: Headings of rooms that their names do not make.
_TITLES = {
    "gcode": "G-code",
    "stepnc": "STEP-NC",
    "servo": "Servo axes",
    "removal": "Material removal",
    "report": "Reports, plots, identification",
    "pipeline": "Calls",
    "cli": "Commands",
}
#: Files of `docs/shell` and the shell of each.
COMPLETIONS = {"cncgen.bash": "bash", "_cncgen": "zsh", "cncgen.fish": "fish"}


def commands(
    group: click.Group = cli, parents: tuple[str, ...] = ("cncgen",)
) -> list[tuple[str, click.Command]]:
    """Return every command with its whole name, subcommands after the command that holds them."""
    found: list[tuple[str, click.Command]] = []
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        found.append((" ".join([*parents, name]), command))
        if isinstance(command, click.Group):
            found += commands(command, (*parents, name))
    return found


def _plain(text: str) -> str:
    """Return a text for Markdown: its signs as themselves, and what stands between backticks as code."""
    return re.sub(
        r"`[^`]*`|[\\*_{}\[\]<>#|~$]", lambda found: found[0] if found[0][0] == "`" else f"\\{found[0]}", text
    )


def _defined(rows: Iterable[tuple[str, str]]) -> list[str]:
    """Return names with what they mean as a definition list."""
    return [f"`{name}`\n: {_plain(' '.join(meaning.split()))}" for name, meaning in rows]


def reference_of(name: str, command: click.Command) -> str:
    """Return what ``--help`` of a command says, as Markdown."""
    context = click.Context(command, info_name=name, help_option_names=["-h", "--help"])
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    paragraphs = re.split(r"\n\s*\n", inspect.cleandoc(command.help or "").strip())
    options = (one for one in command.get_params(context) if isinstance(one, click.Option))
    records = (option.get_help_record(context) for option in options)
    parts = [f"Usage: `{usage}`", *(_plain(" ".join(part.split())) for part in paragraphs), "Options:"]
    parts += _defined(record for record in records if record)
    if isinstance(command, click.Group):
        inner = ((one, command.get_command(context, one)) for one in command.list_commands(context))
        parts += [
            "Commands:",
            *_defined((one, found.get_short_help_str(200)) for one, found in inner if found),
        ]
    return "\n\n".join(parts)


def command_page() -> str:
    """Return the page of all commands, with what ``--help`` of each says."""
    parts = ["# Commands\n\nThis page is what `--help` prints of each command.\n"]
    for name, command in [("cncgen", cli), *commands()]:
        level = "#" * (1 + len(name.split()))
        parts.append(f"{level} {name}\n\n{reference_of(name, command)}\n")
    return "\n".join(parts)


def code_pages() -> dict[str, str]:
    """Return the pages of the diagnostics: one of all codes by room, and one each."""
    rows = [
        "# Diagnostics\n\nThe code of a message stands in brackets: `arc-radius` of `error[arc-radius]`. Each code has a page with "
        "its cause, its cure and, of most, an example; `cncgen explain CODE` prints it.\n"
    ]
    pages = {}
    for room in ROOMS:
        mine = [found for code in codes() if (found := explanation(code)) is not None and found.room == room]
        entries = "\n".join(found.code for found in mine)
        table = "\n".join(f"| [{found.code}]({found.code}.md) | {_plain(found.cause)} |" for found in mine)
        rows.append(
            f"## {_TITLES.get(room, room.capitalize())}\n\n| code | cause |\n| --- | --- |\n{table}\n"
        )
        rows.append(f"```{{toctree}}\n:hidden:\n\n{entries}\n```\n")
        for found in mine:
            pages[f"codes/{found.code}.md"] = found.markdown()
    return {"codes/index.md": "\n".join(rows), **pages}


def _roff(text: str) -> str:
    """Return a text for troff: backslashes, hyphens and leading dots as themselves."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("\b", "")
    return "\n".join(f"\\&{line}" if line[:1] in (".", "'") else line for line in text.splitlines())


def _paragraphs(help_text: str | None) -> str:
    """Return the help of a command as paragraphs."""
    parts = [" ".join(part.split()) for part in re.split(r"\n\s*\n", (help_text or "").strip())]
    return "\n.PP\n".join(_roff(part) for part in parts)


def _options(command: click.Command) -> str:
    """Return the options of a command as a tagged list."""
    context = click.Context(command)
    lines = []
    # Without --help, which click gives every command.
    for parameter in command.params:
        record = parameter.get_help_record(context)
        if isinstance(parameter, click.Option) and record:
            lines.append(f".TP\n.B {_roff(record[0])}\n{_roff(' '.join(record[1].split()))}")
    return "\n".join(lines)


def manual_page() -> str:
    """Return the manual page (man(7)), section 1."""
    parts = [
        f'.TH CNCGEN 1 "" "cncgen {cncgen.__version__}" "User Commands"',
        ".SH NAME\ncncgen \\- NC programs to servo setpoints",
        ".SH SYNOPSIS\n.B cncgen\n.I COMMAND\n[\\fIOPTIONS\\fR] [\\fIARGUMENTS\\fR]",
        f".SH DESCRIPTION\n{_paragraphs(cli.help)}",
        ".SH COMMANDS",
    ]
    for name, command in commands():
        words = name.removeprefix("cncgen ")
        usage = " ".join(command.collect_usage_pieces(click.Context(command)))
        parts.append(f".SS {_roff(words)} {_roff(usage)}\n{_paragraphs(command.help)}\n{_options(command)}")
    parts.append(
        ".SH EXIT STATUS\n0: done. 1: the program has errors, or verify or cut found faults. 2: wrong usage or an "
        "unreadable file. 3: no plan exists within the limits.\n.SH SEE ALSO\n.B cncgen explain\n.I CODE\n"
        "prints what a diagnostic means."
    )
    return "\n".join(part.rstrip() for part in parts) + "\n"


def completion(shell: str) -> str:
    """Return the completion script of a shell, as click makes it."""
    kind = get_completion_class(shell)
    assert kind is not None
    # click asks a bash that is installed for its version, and only for that needs one.
    made = kind(cli, {}, "cncgen", "_CNCGEN_COMPLETE")
    return made.source_template % made.source_vars() + "\n"


def shell_files() -> dict[str, str]:
    """Return the files of `docs/shell` by name."""
    return {"cncgen.1": manual_page()} | {name: completion(shell) for name, shell in COMPLETIONS.items()}


def write_generated() -> None:
    """Write the pages that the site takes."""
    folder = DOCS / "generated"
    shutil.rmtree(folder, ignore_errors=True)
    for name, text in {"commands.md": command_page(), **code_pages()}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    for file, text in shell_files().items():
        (DOCS / "shell" / file).write_text(text, encoding="utf-8")
    write_generated()
