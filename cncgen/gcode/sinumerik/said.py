"""The names in the blocks of a text of SINUMERIK, collected while they are read, before the program runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cncgen.gcode.sinumerik.expressions import Quoted, Value, Variable
from cncgen.gcode.sinumerik.reading import Item

#: Names of a lathe's program beside G96: the bound of its speed, and cycles that turn.
_TURNING = {"LIMS", *(f"CYCLE{n}" for n in (92, 93, 94, 95, 96, 97, 98, 99, 930, 940, 951, 952))}


class Said:
    """The names in the blocks of a text.

    Attributes:
        codes: G and M words: letter and number.
        names: Letters of words, names of settings, commands and calls; ``CYCLE800(`` is a call with values.
        brackets: Names that stand alone in brackets behind the name of a setting: ``POS[X]``.
        files: Names of what may be subprograms.
        computed: Whether a word's axis is the value of a variable: AX[WHICH]=5.
        unstated: Whether X is named before a command says how it is meant.
    """

    def __init__(self) -> None:
        self.codes: set[tuple[str, float]] = set()
        self.names: set[str] = set()
        self.brackets: set[str] = set()
        self.files: set[str] = set()
        self.computed = self.unstated = False

    def take(self, items: Sequence[Item]) -> None:
        """Take what the items of a block name."""
        for kind, *said in items:
            if kind == "word":
                self._word(*said)
            elif kind == "set":
                self.names.add(said[0])
                self._indices(said[1])
                self.computed |= said[0] == "AX" and not self._letter(said[1])
            elif kind == "poly":
                self._indices(said[0][1])
            elif kind == "call":
                self._call(*said)
            elif kind == "name":
                self._name(said[0])
            elif kind == "text":
                self.files.add(file_name(said[0]))
        self._note_x()

    def take_letters(self, letters: Iterable[str]) -> None:
        """Take the letters of the words of a run (R is CR)."""
        self.names |= {"CR" if letter == "r" else letter.upper() for letter in letters} - {"G"}
        self._note_x()

    def named(self, letter: str) -> bool:
        """Tell whether an axis is named, with a number or without."""
        return any(name[0] == letter and (len(name) == 1 or name[1:].isdigit()) for name in self.names)

    def turns(self) -> bool:
        """Tell whether the program turns and does not say how its first X is meant, nor names a plane or an axis of mills."""
        says = {"TRACYL", "TRANSMIT"} & self.names or {("G", 17.0), ("G", 19.0)} & self.codes
        turning = bool({("G", 96.0), ("G", 961.0)} & self.codes or _TURNING & self.names)
        return turning and (self.unstated or not self._stated()) and not (says or self.named("Y"))

    def _note_x(self) -> None:
        """Note whether X is named, and no command of diameters up to here."""
        if not self.unstated and "X" in self.names:
            self.unstated = not self._stated()

    def _stated(self) -> bool:
        return any(name.startswith("DIAM") for name in self.names)

    def _word(self, letter: str, value: float) -> None:
        if letter in "GM":
            self.codes.add((letter, value))
        elif letter == "L":
            self.files.add(f"L{value:.0f}")
        else:
            self.names.add(letter)

    def _indices(self, indices: Sequence[Value]) -> None:
        if len(indices) == 1 and isinstance(indices[0], Variable):
            self.brackets.add(indices[0].name)

    @staticmethod
    def _letter(indices: Sequence[Value]) -> bool:
        """Tell whether an index is the letter of an axis."""
        return len(indices) == 1 and isinstance(indices[0], Variable) and len(indices[0].name) == 1

    def _call(self, name: str, arguments: Sequence[Value | None]) -> None:
        self._name(name)
        given = [argument for argument in arguments if argument is not None]
        if given:
            self.names.add(f"{name}(")
        if name == "EXTCALL":
            self.files |= {file_name(argument.text) for argument in given if isinstance(argument, Quoted)}

    def _name(self, name: str) -> None:
        self.names.add(name)
        self.files.add(file_name(name))


def file_name(text: str) -> str:
    """Return the name of a subprogram whose file a text names, with folders, prefix _N_ and suffix _SPF or .SPF, or without any."""
    file = text.replace("\\", "/").rsplit("/", 1)[-1].upper()
    bare = file.removeprefix("_N_")
    return next((bare[:-4] for suffix in ("_SPF", "_MPF", ".SPF", ".MPF") if bare.endswith(suffix)), bare)
