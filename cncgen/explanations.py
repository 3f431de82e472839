"""The cause, the cure and an example of each diagnostic, from ``explanations.toml`` of the room that reports it.

The examples of most codes of G-code are the programs of ``programs/bad``, whose first lines name the codes that they give.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from cncgen.records import dataclass, field

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

#: The rooms that report diagnostics, each with a file ``explanations.toml``.
ROOMS = (
    "gcode",
    "stepnc",
    "machine",
    "planner",
    "setpoints",
    "servo",
    "verify",
    "removal",
    "report",
    "papers",
    "pipeline",
    "sweep",
    "cli",
)

#: Where the bad programs are: beside the modules of an installed package, or in the checkout.
_BAD = [Path(__file__).resolve().parents[up] / "programs" / "bad" for up in (0, 1)]


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of one diagnostic.

    Attributes:
        code: Name of the diagnostic.
        room: The room that reports it.
        cause: One or two sentences.
        cure: The remedy.
        file, example: Name and text of a file that gives the diagnostic; "" for none.
        files: Texts of further files that it needs, by name.
        command: Lines of commands; run one after the other on these files, they give the diagnostic. "" where there is no example.
    """

    code: str
    room: str
    cause: str
    cure: str
    file: str = ""
    example: str = ""
    command: str = ""
    files: Mapping[str, str] = field(default_factory=dict)

    def every_file(self) -> dict[str, str]:
        """Return the texts of all files of the example by name."""
        return ({self.file: self.example} if self.file else {}) | dict(self.files)

    def _cured(self) -> str:
        """Return the cure as a sentence."""
        return f"Cure: {self.cure}{'' if self.cure.endswith('?') else '.'}"

    def text(self) -> str:
        """Return the text for a terminal."""
        parts = [f"{self.code}: {self.cause}", self._cured()]
        if self.command:
            parts.append("Example:")
            parts += [f"{name}\n{_indented(text)}" for name, text in self.every_file().items()]
            parts.append(_indented("".join(f"$ {line}\n" for line in self.command.strip().splitlines())))
        return "\n\n".join(parts) + "\n"

    def markdown(self) -> str:
        """Return a page."""
        parts = [f"# {self.code}", self.cause, f"**{self._cured().replace(':', ':**', 1)}"]
        if self.command:
            parts.append("## Example")
            parts += [
                f"`{name}`:\n\n```text\n{text.strip()}\n```" for name, text in self.every_file().items()
            ]
            parts.append(f"```sh\n{self.command.strip()}\n```")
        return "\n\n".join(parts) + "\n"


def _indented(text: str) -> str:
    """Return the lines of a text, moved to the right."""
    return "\n".join(f"    {line}".rstrip() for line in text.strip("\n").splitlines())


@cache
def _room(name: str) -> dict[str, dict[str, Any]]:
    """Return the table of a room."""
    import tomllib

    return tomllib.loads(_text(name))


def _text(room: str) -> str:
    return (Path(__file__).parent / room / "explanations.toml").read_text(encoding="utf-8")


@cache
def _bad_programs() -> dict[str, tuple[str, str]]:
    """Return a program that gives each code of G-code, with the words that check it: the shortest with the fewest other faults."""
    found: dict[str, tuple[int, int, str, str]] = {}
    for file in sorted(file for folder in _BAD for file in folder.glob("*.nc")):
        head, _, text = file.read_text(encoding="utf-8").partition("\n")
        words = head.removeprefix("; expect").split()
        dialect = "" if ":" in words[0] else f" --dialect {words[0]}"
        faults = re.findall(r":\d+:([a-z0-9-]+)", head)
        for code in faults:
            one = len(faults), len(text), text, f"cncgen check example.nc{dialect}"
            found[code] = min(found.get(code, one), one)
    return {code: (text, command) for code, (_, _, text, command) in found.items()}


def codes() -> list[str]:
    """Return the names of all diagnostics, in order."""
    return sorted(code for room in ROOMS for code in _room(room))


@cache
def cure_of(room: str, code: str) -> str:
    """Return the remedy for a diagnostic of a room, "" if unknown."""
    # One cure is asked for while a program is checked: to read the whole file as TOML would take longer than the check.
    found = re.search(rf'(?ms)^\[{re.escape(code)}\]\n(?:(?!^\[).)*?^cure = "([^"\\\n]*)"$', _text(room))
    return found[1] if found else str(_room(room).get(code, {}).get("cure", ""))


def explanation(code: str) -> Explanation | None:
    """Return the meaning of a diagnostic, or None for an unused code."""
    for room in ROOMS:
        if code in _room(room):
            found = Explanation(code, room, **_room(room)[code])
            if found.command or room != "gcode" or code not in _bad_programs():
                return found
            text, command = _bad_programs()[code]
            return Explanation(code, room, found.cause, found.cure, "example.nc", text, command)
    return None
