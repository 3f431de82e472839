"""Programs that CALL PGM, SEL PGM and cycle 12 of Heidenhain's plain language name: their files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from cncgen.gcode.source import Source
from cncgen.gcode.text.search import opened
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
#: Suffixes of files with programs, the best first.
SUFFIXES = ("", ".h", ".nc")


def bare(name: str) -> str:
    """Return a name without quotes and the folders of the control."""
    return name.strip("\"' ").replace("\\", "/").rsplit("/", 1)[-1]


def of_cycle(rest: str) -> str:
    """Return the name of CYCL DEF 12.1 PGM NAME, empty where there is none."""
    match = _OF_CYCLE.match(rest)
    return bare(match["name"]) if match else ""


def called(text: bytes, folders: Sequence[Path]) -> Iterator[Source]:
    """Yield the programs of files that a text calls."""
    for match in _CALLS.finditer(text):
        found = opened(folders, bare(match[1].decode("utf-8", "replace")), SUFFIXES)
        if found is not None:
            yield found
