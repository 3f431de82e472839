"""The table of codes: every G and M code with its modal group, place in the order of execution, words and meaning.

A concern (arcs, offsets, tools …) is a module with a tuple `CODES` of `Code` records; `table` merges them for a
dialect. To add a code, write its handler in such a module and name the module in `_MODULES`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from cncgen.gcode.block import Block
from cncgen.gcode.modal import Stage

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

Handler = Callable[["Interpreter", Block], None]

#: Modules with `CODES`, in no particular order.
_MODULES = (
    "arcs",
    "bsplines",
    "canned_cycles",
    "comments",
    "coolant",
    "cutter_compensation",
    "dwell",
    "feeds",
    "frames",
    "homing",
    "lathe_cycles",
    "lines",
    "macros",
    "modes",
    "nurbs",
    "offsets",
    "overrides",
    "pins",
    "probing",
    "program_end",
    "saved",
    "spindle",
    "splines",
    "subprograms",
    "synchronised",
    "tools",
    "turning_cycles",
)
BOTH = ("linuxcnc", "fanuc")
AXES = "xyzabcuvw"


@dataclass(frozen=True, slots=True)
class Code:
    """One code.

    Attributes:
        letter: ``G`` or ``M``; another letter for a word that acts by itself (F, S, T).
        number: Ten times the code's number (``G5.1`` is 51); 0 for words that act by themselves.
        group: Name of the modal group: two codes of one group cannot stand in one block.
        stage: When in the block it is executed.
        run: What it does; None where the plan knows (modal motions name `run` of their own).
        words: Letters that it uses, lower case.
        help: One line.
        axes: ``none``, ``motion`` (a modal motion), ``own`` (uses axis words itself).
        summons: Letters that bring this modal motion into a block that does not name it.
        dialects: Where it means this.
        title: How it is written, where that is not letter and number.
        named: Words of several letters that it uses.
        asks: Whether the machine is asked where it stands when the block is done.
    """

    letter: str
    number: int
    group: str
    stage: Stage
    run: Handler
    help: str
    words: str = ""
    axes: str = "none"
    summons: str = AXES + "@^"
    dialects: tuple[str, ...] = BOTH
    title: str = ""
    named: tuple[str, ...] = ()
    asks: bool = False

    @property
    def name(self) -> str:
        """Return how the code is written: ``G5.1``."""
        if self.title:
            return self.title
        whole, tenth = divmod(self.number, 10)
        return (
            self.letter
            if self.letter not in "GM"
            else f"{self.letter}{whole}" + (f".{tenth}" if tenth else "")
        )


@cache
def table(dialect: str) -> dict[tuple[str, int], Code]:
    """Return the codes of a dialect by letter and number in tenths."""
    found: dict[tuple[str, int], Code] = {}
    for module in _MODULES:
        for code in import_module(f"cncgen.gcode.{module}").CODES:
            if dialect in code.dialects:
                found[code.letter, code.number] = code
    return found
