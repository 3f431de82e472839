"""The axes that a program of SINUMERIK names, itself or in the subprograms that it calls, known before it runs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from cncgen.diagnostics import UsageError
from cncgen.gcode.sinumerik.programs import turns
from cncgen.gcode.source import Source, open_source
from cncgen.gcode.text.search import candidates
from cncgen.units import AXIS_LETTERS

_STRINGS = re.compile(r'"[^"\n]*"')
_REMARKS = re.compile(r'("[^"\n]*"?)|;.*')
_AXIS = re.compile(
    r"(?<![A-Z_$0-9.])([XYZABCUVW])(?=[-+]?[.\d]|\s*=(?!=))|(?<=\d)([XYZABCUVW])(?=[-+]?[.\d])|\[([XYZABCUVW])\]"
)
#: A component of the tool's direction, or a plane, which the machine's rotary axes have together.
_VECTOR = re.compile(r"(?<![A-Z_$0-9.])[ABC]3(?=\s*=(?!=))|\bCYCLE800\b(?=\s*\(\s*[^\s)])")
_PLANE = re.compile(r"(?<![A-Z_$])(?:[IJK]1?|AP|RP|CR|AR|ANG)(?=[-+]?[.\d]|\s*=(?!=))")
_CYCLES = re.compile(r"\b(?:CYCLE\d+|POCKET\d|SLOT\d|LONGHOLE|HOLES\d|TRAORI|A?ROT)\b")
_SOFT = re.compile(r"(?<![A-Z_])G[123]4[78](?![\d.])")
_ROTARY = re.compile(r"\b(?:TRANSMIT|TRACYL)\b")
_CALLS = re.compile(r"(?:^|\s)([A-Z_][A-Z0-9_]{2,}|L\d+)\b")
_MOST_FILES = 1000


def moving_axes(text: Source, folders: Sequence[Path] = (), rotary: str = "") -> str:
    """Return the letters of the axes that a program and its subprograms name, in the order of ``XYZABCUVW``; directions and swivelled planes move `rotary`."""
    named: set[str] = set()
    waiting, seen, files = [text], set[str](), 0
    plane = "XZ" if turns(text.data) else "XY"
    while waiting:
        code, vectors = _VECTOR.subn("", _STRINGS.sub("", capitals_of(waiting.pop())))
        named |= set(rotary if vectors else "")
        named |= {next(group for group in match.groups() if group) for match in _AXIS.finditer(code)}
        if _PLANE.search(code):
            named |= (
                set("XYZ") if re.search(r"(?<!\d)G1[89](?!\d)|K1?(?=[-+]?[.\d]|\s*=)", code) else set(plane)
            )
        if _CYCLES.search(code) or _SOFT.search(code):
            named |= set("XYZ")
        if _ROTARY.search(code):
            named |= set("XC")
        for name in set(_CALLS.findall(code)) - seen if folders else ():
            seen.add(name)
            source = _file(name, folders) if files < _MOST_FILES else None
            if source is not None:
                files += 1
                waiting.append(source)
    return "".join(letter for letter in AXIS_LETTERS if letter in named)


def capitals_of(source: Source) -> str:
    """Return a text in capitals without comments."""
    text = bytes(source.data[:]).decode("utf-8", "replace")
    return _REMARKS.sub(lambda match: match[1] or "", text).upper()


def _file(name: str, folders: Sequence[Path]) -> Source | None:
    """Return the subprogram of a name, None where no folder has one."""
    for folder in folders:
        for suffix in (".spf", ".mpf"):
            for path in candidates(folder, f"{name}{suffix}"):
                try:
                    return open_source(path, str(path))
                except UsageError:
                    continue
    return None
