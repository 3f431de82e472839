"""The axes that a program of SINUMERIK names, itself or in the subprograms that it calls, known before it runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cncgen.diagnostics import UsageError
from cncgen.gcode.sinumerik import soft_approach
from cncgen.gcode.sinumerik.expressions import Quoted, Value, Variable
from cncgen.gcode.sinumerik.programs import file_name, programs_ahead, turns
from cncgen.gcode.sinumerik.reading import Item
from cncgen.gcode.source import Source, open_source
from cncgen.gcode.text.search import candidates, leaves_path
from cncgen.units import AXIS_LETTERS

_AXES = frozenset(AXIS_LETTERS)
#: Components of the tool's direction, and what turns a plane: the machine's rotary axes follow them together.
_DIRECTIONS = frozenset(("A3", "B3", "C3"))
#: Words of an arc or of polar coordinates, in the plane in force; those along Z tell of another plane than G17.
_IN_PLANE = frozenset(("I", "J", "K", "I1", "J1", "K1", "AP", "RP", "CR", "AR", "ANG"))
_ALONG_Z = frozenset(("K", "K1"))
#: Names, or their beginnings, of what moves in space by values of its own.
_SPATIAL = ("CYCLE", "POCKET", "SLOT", "LONGHOLE", "HOLES", "TRAORI")
_TURNS_SPACE = ("ROT", "AROT")
#: Transformations that move X and C.
_ROTARY = ("TRANSMIT", "TRACYL")
_MOST_FILES = 1000


class _Named:
    """What a program names.

    Attributes:
        axes: Letters.
        calls: Names of what may be subprograms.
        turns: Whether it names directions.
        plane: Whether it names words of the plane. upright: Whether another plane than G17.
        space: Whether it names what moves in space.
    """

    def __init__(self) -> None:
        self.axes: set[str] = set()
        self.calls: set[str] = set()
        self.turns = self.plane = self.upright = self.space = False

    def take(self, items: Sequence[Item]) -> None:
        """Take what the items of a block name."""
        for kind, *said in items:
            if kind == "word":
                self._word(*said)
            elif kind == "set":
                self._address(said[0])
                self._indices(said[1])
            elif kind == "poly":
                self._indices(said[0][1])
            elif kind == "call":
                self._call(*said)
            elif kind == "name":
                self._name(said[0])
            elif kind == "text":
                self.calls.add(file_name(said[0]))

    def _word(self, letter: str, value: float) -> None:
        if letter == "G":
            self.upright = self.upright or value in (18.0, 19.0)
            self.space = self.space or value in soft_approach.CODES
        elif letter == "L":
            self.calls.add(f"L{value:.0f}")
        else:
            self._address(letter)

    def _address(self, name: str) -> None:
        """Take the name of a word or of a setting: an axis may have a number."""
        if name in _DIRECTIONS:
            self.turns = True
        elif name[0] in _AXES and (len(name) == 1 or name[1:].isdigit()):
            self.axes.add(name[0])
        elif name in _IN_PLANE:
            self.plane = True
            self.upright = self.upright or name in _ALONG_Z

    def _indices(self, indices: Sequence[Value]) -> None:
        """Take the axis in brackets: POS[X]=5."""
        if len(indices) == 1 and isinstance(indices[0], Variable) and indices[0].name in _AXES:
            self.axes.add(indices[0].name)

    def _call(self, name: str, arguments: Sequence[Value | None]) -> None:
        self._name(name)
        given = [argument for argument in arguments if argument is not None]
        self.turns = self.turns or (name == "CYCLE800" and bool(given))
        if name == "EXTCALL":
            self.calls |= {file_name(argument.text) for argument in given if isinstance(argument, Quoted)}

    def _name(self, name: str) -> None:
        self.space = self.space or name.startswith(_SPATIAL) or name in _TURNS_SPACE
        self.axes |= set("XC" if name in _ROTARY else "")
        self.calls.add(name)


def moving_axes(text: Source, folders: Sequence[Path] = (), rotary: str = "") -> str:
    """Return the letters of the axes that a program and its subprograms name, in the order of ``XYZABCUVW``; directions and swivelled planes move `rotary`."""
    found = _Named()
    seen: set[str] = set()
    sources = [text]
    files = 0
    while sources:
        for program in programs_ahead(sources.pop()):
            for line in program.lines:
                found.take(line.statement.items)
        for name in sorted(found.calls - seen) if folders else ():
            source = _file(name, folders) if files < _MOST_FILES else None
            if source is not None:
                files += 1
                sources.append(source)
        seen |= found.calls
    named = found.axes | set(rotary if found.turns else "")
    if found.space or (found.plane and found.upright):
        named |= set("XYZ")
    elif found.plane:
        named |= set("XZ" if turns(text.data) else "XY")
    return "".join(letter for letter in AXIS_LETTERS if letter in named)


def _file(name: str, folders: Sequence[Path]) -> Source | None:
    """Return the subprogram of a name, None where no folder has one."""
    if leaves_path(name) or len(name) < 2:
        return None
    for folder in folders:
        for suffix in (".spf", ".mpf"):
            for path in candidates(folder, f"{name}{suffix}"):
                try:
                    return open_source(path, str(path))
                except UsageError:
                    continue
    return None
