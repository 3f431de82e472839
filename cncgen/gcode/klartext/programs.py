"""Programs that CALL PGM, SEL PGM and cycle 12 of Heidenhain's plain language name: their files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from cncgen.grammars.terminals import HEIDENHAIN as TERMINALS

#: The cycle whose calls run a program.
CYCLE = 12
#: The name may be a path of the control.
_OF_CYCLE = re.compile(r"\s*(?:PGM\b)?\s*(?P<name>\S[^;\n]*?)\s*\Z", re.IGNORECASE)
_CALLS = re.compile(
    rf"^[ \t]*(?:{TERMINALS['BLOCK_NUMBER']}[ \t]+)?(?:(?:CALL|SEL)[ \t]+PGM|CYCL[ \t]+DEF[ \t]*12[ \t]*\.[ \t]*1(?:[ \t]+PGM)?)[ \t]*"
    rf"(\S[^;\r\n]*?)[ \t]*(?:{TERMINALS['COMMENT']})?\r?$".encode(),
    re.MULTILINE | re.IGNORECASE,
)
_SUFFIXES = ("", ".h", ".nc")


def bare(name: str) -> str:
    """Return a name without quotes and the folders of the control."""
    return name.strip("\"' ").replace("\\", "/").rsplit("/", 1)[-1]


def of_cycle(rest: str) -> str:
    """Return the name of CYCL DEF 12.1 PGM NAME, empty where there is none."""
    match = _OF_CYCLE.match(rest)
    return bare(match["name"]) if match else ""


def file_of(name: str, folders: Sequence[Path]) -> Path | None:
    """Return the file of a program, the first that stands in one of the folders; small letters and capitals are one to the control."""
    wanted = [f"{name}{suffix}".lower() for suffix in _SUFFIXES]
    for folder in folders:
        found = (
            [p for p in folder.iterdir() if p.name.lower() in wanted and p.is_file()]
            if folder.is_dir()
            else []
        )
        if found:
            return min(found, key=lambda p: (wanted.index(p.name.lower()), p.name))
    return None


def called(text: bytes, folders: Sequence[Path]) -> Iterator[Path]:
    """Yield the files of the programs that a text calls."""
    for match in _CALLS.finditer(text):
        found = file_of(bare(match[1].decode("utf-8", "replace")), folders)
        if found is not None:
            yield found
