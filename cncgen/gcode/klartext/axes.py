"""The axes that a program in plain language names, known before it runs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

from cncgen.gcode.klartext import programs
from cncgen.gcode.source import Source
from cncgen.grammars.terminals import HEIDENHAIN as TERMINALS
from cncgen.units import AXIS_LETTERS

_Q, _NUMBER = (TERMINALS[name].encode() for name in ("Q", "SIGNED"))
_COMMENTS = re.compile(
    rf"{TERMINALS['COMMENT']}|^[ \t]*(?:{TERMINALS['BLOCK_NUMBER']}[ \t]+)?"
    rf"(?:{TERMINALS['HEADING']}|(?:BLK[ \t]+FORM|BEGIN|END|FN[ \t]*(?:1[56]|20|29|3[78]))\b[^\n]*)".encode(),
    re.MULTILINE | re.IGNORECASE,
)
#: Names of files, tools and labels, and titles of cycles, in which no axis is named.
_TITLES = re.compile(
    rb"\"[^\"\n]*\"|\bPGM\b[^\n]*|\bCYCL[ \t]+DEF[ \t]+(?:[^ \t\n]*\.0|[1-9]\d\d)\b[^\n]*", re.IGNORECASE
)
#: Further characters that are blanks to who runs the program.
_BLANKS = bytes.maketrans(b"\v\f\x1c\x1d\x1e\x1f", 6 * b" ")
_VALUE = rb"[ \t]*(?:(?:[-+][ \t]*)?" + _Q + rb"|" + _NUMBER + rb")"
#: Words with values, maybe without a blank between them, and in them an axis and its value: ``X+10``, ``IY-2,5``, ``X18Y+Q1``.
_WORDS = re.compile(
    rb"(?<![A-Z0-9])(?:L[ \t]*)?(?:(?:F[ \t]*(?:MAX|AUTO)|R[LR]|[A-Z]{1,2}" + _VALUE + rb")[ \t]*)+",
    re.IGNORECASE,
)
_AXIS = re.compile(
    rb"(?:(?<![A-Z])|(?<=\bL)|(?<=MAX)|(?<=AUTO)|(?<=R[LR]))"
    + TERMINALS["AXIS"].encode()
    + rb"(?="
    + _VALUE
    + rb")",
    re.IGNORECASE,
)
_PLANE = re.compile(
    rb"(?<![A-Z])(?:I?P[RA][ \t]*[-+\dQ]|(?:APPR|DEP|RND|CTP|CP|LP|FPOL|FLT?|FCT?|G1[0-6]|G2[67])\b)",
    re.IGNORECASE,
)
_CYCLES = re.compile(
    rb"(?<![A-Z])(?:CYCL\b|PLANE[ \t]+(?!RESET\b)[A-Z]|M99\b|M89\b|M140\b|M128\b|TCPM\b|TRANS\b|G79\b|G2\d\d\b)",
    re.IGNORECASE,
)
#: A plane to which the rotary axes of the machine turn by themselves.
_TURNED = re.compile(
    rb"(?<![A-Z])PLANE[ \t][^\n]*?\b(?:TURN|MOVE)\b|CYCL[ \t]+DEF[ \t]+19\.1[^\n]*F", re.IGNORECASE
)
#: A direction of the tool, to which they turn under M128.
_DIRECTION = re.compile(rb"(?<![A-Z])LN\b[^\n]*?[TN][XYZ][ \t]*[-+\dQ.,]", re.IGNORECASE)
_TIP = re.compile(rb"(?<![A-Z])(?:M128|TCPM)\b", re.IGNORECASE)
#: Rotary words that are spatial angles, to which the machine's axes turn, and what stands for them among the axes.
_ANGLES = "SPAT"
_SPATIAL = re.compile(rb"TCPM\b[^\n]*\bAXIS[ \t]+SPAT\b", re.IGNORECASE)
#: Programs that call each other deeper than this are not looked at.
_DEEPEST = 20


def moving_axes(text: Source, folders: Sequence[Path], rotary: str, run: Callable[[], set[str]]) -> str:
    """Return the letters of the axes that a program and those that it calls name, in the order of ``XYZABCUVW``.

    Cycles name X, Y and Z, and a plane to which the machine's rotary axes turn names these.

    Args:
        text: The program.
        folders: Where files of programs that it calls are looked for.
        rotary: The rotary axes of the machine.
        run: Runs a program with spatial angles that are called as axes which the machine lacks, and returns the axes that moved: only the
            run tells these angles from positions.
    """
    named = _named(bytes(text.data[:]), folders, _DEEPEST, set(), rotary)
    if _ANGLES in named:
        named.remove(_ANGLES)
        if not named & set("ABC") <= set(rotary):
            named = named - set("ABC") | run()
    return "".join(letter for letter in AXIS_LETTERS if letter in named)


def _named(text: bytes, folders: Sequence[Path], deep: int, seen: set[str], rotary: str) -> set[str]:
    code = _COMMENTS.sub(b"", text.translate(_BLANKS))
    named = {
        axis[0][-1:].decode().upper()
        for words in _WORDS.finditer(_TITLES.sub(b"", code))
        for axis in _AXIS.finditer(words[0])
    }
    if _PLANE.search(code):
        named |= set("XY")
    if _CYCLES.search(code):
        named |= set("XYZ")
    if _TURNED.search(code) or (_DIRECTION.search(code) and _TIP.search(code)):
        named |= set(rotary)
    if _SPATIAL.search(code):
        named |= {*rotary, _ANGLES}
    for source in programs.called(code, folders) if deep and b"PGM" in code.upper() else ():
        if source.name not in seen:
            seen.add(source.name)
            named |= _named(bytes(source.data[:]), folders, deep - 1, seen, rotary)
    return named
