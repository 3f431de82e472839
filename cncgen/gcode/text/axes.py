"""The axes that a program names, itself or in the files that it calls, known before its first block is run."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from cncgen.diagnostics import UsageError
from cncgen.gcode.source import Source, open_source
from cncgen.gcode.text.search import candidates, leaves_path
from cncgen.kernels import gcode_scan
from cncgen.units import AXIS_LETTERS

#: Bit of the letter O, which stands before a number in O-words.
_O = 1 << ord("O") - ord("A")
#: Files that are looked into at most.
MAX_FILES = 1000

_ON_LATHES = {"I": "X", "U": "X", "V": "Y", "K": "Z", "W": "Z"}

#: G18 and G19.
_PLANE = re.compile(rb"g[\s0]*1\s*([89])(?!\s*[0-9.])", re.IGNORECASE)
_O_CALL = re.compile(rb"o\s*(?:<([^>\n]*)>|(\d+))\s*call", re.IGNORECASE)
_P_CALL = re.compile(rb"(?:m\s*0*98|g\s*0*6[56])(?![0-9.])[^\n]{0,200}?p\s*0*(\d+)", re.IGNORECASE)


def moving_axes(text: Source, folders: Sequence[Path] = (), *, lathe: bool = False) -> str:
    """Return the letters of the axes that a program names, in the order of ``XYZABCUVW``.

    I and J name X and Y, and with K the axes of the planes that G18 and G19 choose (a full circle may name no axis at all); on a
    lathe of FANUC I names X, and U V W are distances along X Y Z. Subprograms in files count where the call says their name
    or number; what a computed number leads to is seen when it is called.

    Args:
        text: The program.
        folders: Where files of subprograms are looked for.
    """
    texts, bits = [text], gcode_scan.axis_letters(text.bytes)
    if folders and bits & (gcode_scan.CALLS | _O):
        for file in _called(text, folders):
            bits |= gcode_scan.axis_letters(file.bytes)
            texts.append(file)
    named = {chr(65 + k) for k in range(26) if bits >> k & 1}
    if lathe:
        named = {_ON_LATHES.get(letter, letter) for letter in named}
    else:
        named |= {"X", "Y"} if named & {"I", "J"} else set()
        if named & {"I", "J", "K"} and not named >= set("XYZ"):
            named |= set().union(*map(_planes, texts))
    return "".join(letter for letter in AXIS_LETTERS if letter in named)


def _planes(text: Source) -> set[str]:
    """Return the axes of the planes other than X Y that a text chooses."""
    return {axis for match in _PLANE.finditer(text.data) for axis in ("XZ" if match[1] == b"8" else "YZ")}


def _called(text: Source, folders: Sequence[Path]) -> Iterator[Source]:
    """Yield the files that a program calls, and those that they call."""
    seen: set[Path] = set()
    waiting = [text]
    while waiting and len(seen) < MAX_FILES:
        for name in dict.fromkeys(_names(waiting.pop())):
            path = next((path for folder in folders for path in candidates(folder, name)), None)
            if path is None or path in seen:
                continue
            seen.add(path)
            try:
                waiting.append(open_source(path, str(path)))
            except UsageError:
                continue
            yield waiting[-1]


def _names(text: Source) -> Iterator[str]:
    """Yield the names of files, without suffix, that the calls of a text may mean."""
    for match in _O_CALL.finditer(text.data):
        label = match[1] if match[1] is not None else match[2].lstrip(b"0") or b"0"
        name = "".join(label.decode("utf-8", "replace").split()).lower()
        if not leaves_path(name):
            yield name
    for match in _P_CALL.finditer(text.data):
        digits = match[1].decode()
        yield digits
        # FANUC: eight digits are four of repeats and four of the number; files are named O and four digits.
        yield f"O{int(digits) % 10_000:04d}"
        yield f"O{int(digits):04d}"
