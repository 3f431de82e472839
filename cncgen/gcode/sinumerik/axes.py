"""The axes that a program of SINUMERIK names, itself or in the subprograms that it calls, known before it runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cncgen.gcode.sinumerik import soft_approach
from cncgen.gcode.sinumerik.programs import SUFFIXES, programs_ahead
from cncgen.gcode.sinumerik.said import Said
from cncgen.gcode.source import Source
from cncgen.gcode.text.search import opened
from cncgen.units import AXIS_LETTERS

#: Components of the tool's direction, and what turns a plane: the machine's rotary axes follow them together.
_DIRECTIONS = frozenset(("A3", "B3", "C3", "A2", "B2", "C2"))
_TURNED = "CYCLE800("
#: Words of an arc or of polar coordinates, in the plane in force; those along Z tell of another plane than G17.
_IN_PLANE = frozenset(("I", "J", "K", "I1", "J1", "K1", "AP", "RP", "CR", "AR", "ANG"))
_ALONG_Z = frozenset(("K", "K1"))
_UPRIGHT = frozenset((("G", 18.0), ("G", 19.0)))
#: Names, or their beginnings, of what moves in space by values of its own.
_SPATIAL = ("CYCLE", "POCKET", "SLOT", "LONGHOLE", "HOLES", "TRAORI")
_TURNS_SPACE = frozenset(("ROT", "AROT", "ROTS", "AROTS"))
_SOFT = frozenset(("G", float(code)) for code in soft_approach.CODES)
#: Transformations that move X and C.
_ROTARY = frozenset(("TRANSMIT", "TRACYL"))
_MOST_FILES = 1000


def moving_axes(text: Source, folders: Sequence[Path] = (), rotary: str = "") -> str:
    """Return the letters of the axes that a program and its subprograms name, in the order of ``XYZABCUVW``; directions and swivelled planes move `rotary`."""
    main = programs_ahead(text)[0].said
    found: set[str] = set()
    seen: set[str] = set()
    waiting, files = [main], 0
    plane = "XZ" if main.turns() else "XY"
    while waiting:
        said = waiting.pop()
        found |= _axes(said, plane, rotary)
        for name in sorted(said.files - seen) if folders else ():
            source = _file(name, folders) if files < _MOST_FILES else None
            if source is not None:
                files += 1
                waiting.append(programs_ahead(source)[0].said)
        seen |= said.files
    return "".join(letter for letter in AXIS_LETTERS if letter in found)


def _axes(said: Said, plane: str, rotary: str) -> set[str]:
    names, codes = said.names, said.codes
    axes = {name[0] for name in names - _DIRECTIONS if len(name) == 1 or name[1:].isdigit()} | said.brackets
    if names & _DIRECTIONS or _TURNED in names:
        axes |= set(rotary)
    if names & _ROTARY:
        axes |= set("XC")
    if said.computed:
        axes |= {*plane, "Z"}
    spatial = names & _TURNS_SPACE or codes & _SOFT or any(name.startswith(_SPATIAL) for name in names)
    if spatial or (names & _IN_PLANE and (names & _ALONG_Z or codes & _UPRIGHT)):
        axes |= set("XYZ")
    elif names & _IN_PLANE:
        axes |= set(plane)
    return axes


def _file(name: str, folders: Sequence[Path]) -> Source | None:
    """Return the subprogram of a name, None where no folder has one."""
    return opened(folders, name, SUFFIXES[:2]) if len(name) > 1 else None
