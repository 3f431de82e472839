"""The table of codes: every G and M code with its modal group, place in the order of execution, words and meaning.

A concern (arcs, offsets, tools …) is a module of `_MODULES` with a tuple `CODES` of `Code` records; `table` merges them for a
dialect, as far as a program needs them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib import import_module

from cncgen.gcode.block import AXES, Block
from cncgen.records import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

Handler = Callable[["Interpreter", Block], None]

#: Modules with `CODES`; a code is searched in this order, codes of every program first.
_MODULES = (
    "codes.lines", "codes.modes", "codes.feeds", "codes.program_end", "codes.arcs", "codes.spindle", "codes.tools", "codes.coolant",
    "codes.cutter_compensation", "codes.canned_cycles", "codes.corners", "codes.offsets", "codes.offsets_fanuc", "codes.dwell",
    "codes.dynamic_offsets", "flow.macros", "codes.accepted", "codes.comments", "codes.overrides", "codes.homing", "codes.subprograms",
    "codes.pins", "codes.canned_cycles_fanuc", "codes.hole_patterns", "codes.nurbs", "codes.frames", "codes.probing",
    "codes.synchronised", "codes.splines", "codes.bsplines", "codes.saved", "codes.lathe_cycles", "codes.turning_cycles",
    "codes.lathe_fanuc", "codes.simple_cycles_fanuc", "codes.turning_cycles_fanuc", "codes.pecking_cycles_fanuc",
    "codes.thread_cycles_fanuc", "codes.lathe_drilling_fanuc", "codes.haas_pockets", "codes.general_pocket", "codes.offset_motions",
    "codes.tool_point", "codes.rotary_paths", "codes.tilted_planes", "codes.heidenhain", "codes.plain_language",
)  # fmt: skip
#: Words that act by themselves; the numbers of offsets on FANUC's mills alone.
ALONE = ("F", "S", "T", ",C", ",R", ",M", ",H", ",I", ",J", ",S")
OFFSET_NUMBERS = ("D", "H")
_LONE = frozenset(letter.lower() for letter in ALONE)
OF_LINUXCNC, OF_FANUC = ("linuxcnc",), ("fanuc",)
BOTH = (*OF_LINUXCNC, *OF_FANUC)
#: FANUC's lathes, system A of G codes: the language of its mills, with other meanings of some codes.
LATHE = "fanuc-lathe"
#: G90, G91, and G98, G99 of cycles on lathes that have them: their numbers in system A, in tenths, which no control has.
LATHE_ABSOLUTE, LATHE_STEPS, LATHE_TO_START, LATHE_TO_R = 9000, 9100, 9800, 9900
_SYSTEM_B = {
    330: 320, 770: 900, 780: 920, 790: 940, 920: 500, 940: 980, 950: 990,
    900: LATHE_ABSOLUTE, 910: LATHE_STEPS, 980: LATHE_TO_START, 990: LATHE_TO_R,
}  # fmt: skip
#: Dialects of FANUC's lathes, and of each the numbers of G codes, in tenths, that system A writes otherwise (B-64304EN-1, 3).
LATHES: dict[str, dict[int, int]] = {
    LATHE: {},
    "fanuc-lathe-b": _SYSTEM_B,
    "fanuc-lathe-c": {
        **{number: own for number, own in _SYSTEM_B.items() if number not in (770, 780, 790)},
        200: 900, 210: 920, 240: 940, 700: 200, 710: 210, **{number: number - 20 for number in range(720, 790, 10)},
    },
}  # fmt: skip
#: What may be in force while a code is refused (`Code.refused`), in bits: cutter compensation, that of LinuxCNC alone, and that of other
#: controls where the block moves in its plane too; paths of a linear and a rotary axis (G12.1); tool centre point control (G43.4); the
#: profile of a turning cycle of FANUC. `INTERRUPTS`: FANUC's controls cancel compensation for it instead, until the next move.
COMPENSATION, STRICT_COMPENSATION, COMPENSATION_PLANE, ROTARY_PATH, TOOL_POINT, PROFILE, INTERRUPTS = (1 << bit for bit in range(7))  # fmt: skip
_FOLLOWED = ROTARY_PATH | TOOL_POINT
#: An effect that codes of several modules have and that is refused under these.
CHANGES_SYSTEM = ("changes the coordinate system", COMPENSATION | INTERRUPTS | _FOLLOWED)
CHANGES_ORIGIN = ("changes the origin", COMPENSATION | INTERRUPTS | _FOLLOWED)
CHANGES_OFFSETS = ("changes offsets", _FOLLOWED)
CHANGES_UNITS = ("changes the units", _FOLLOWED)
CHANGES_TOOL = ("changes the tool", COMPENSATION | INTERRUPTS | TOOL_POINT)
CHANGES_TOOL_OFFSET = ("changes the tool's offset", STRICT_COMPENSATION | TOOL_POINT)
CHANGES_PATH_MODE = ("changes the path mode", STRICT_COMPENSATION)
GOES_HOME = ("goes by way of a reference point", COMPENSATION_PLANE | INTERRUPTS | _FOLLOWED | PROFILE)
IN_MACHINE = ("moves in machine coordinates", COMPENSATION | INTERRUPTS | _FOLLOWED | PROFILE)
SYNCHRONISED = ("is synchronised with the spindle", COMPENSATION | INTERRUPTS | _FOLLOWED | PROFILE)
IS_CYCLE = ("is a canned cycle", COMPENSATION | INTERRUPTS | PROFILE)
IS_TURNING = ("is a turning cycle", PROFILE)
LEADS_ELSEWHERE = ("calls a program or returns from one", PROFILE)


def language_of(dialect: str) -> str:
    """Return whose words, jumps and arithmetic a dialect has."""
    return "fanuc" if dialect in LATHES else dialect


@cache
def displaced(dialect: str) -> frozenset[int]:
    """Return the numbers of G codes that a system of lathes has under another number."""
    return frozenset(LATHES[dialect].values()) - LATHES[dialect].keys()


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Code:
    """One code.

    Attributes:
        letter: ``G`` or ``M``; another letter for a word that acts by itself (F, S, T, and D, H of FANUC).
        number: Ten times the code's number (``G5.1`` is 51); 0 for words that act by themselves.
        group: Name of the modal group: two codes of one group cannot stand in one block.
        stage: When in the block it is executed.
        run: Its handler; None if the plan has it (modal motions name their own `run`).
        words: Letters that it uses, lower case.
        help: One line.
        axes: ``none``, ``motion`` (a modal motion), ``own`` (uses axis words itself).
        summons: Letters that bring this modal motion into a block that does not name it.
        dialects: Where it means this; dialects that build on these have it too, FANUC's lathes on its mills, others on LinuxCNC.
        title: How it is written, where that is not letter and number.
        named: Words of several letters that it uses.
        after: Its handler for the time when all else of the block is done, or None.
        takes: Letters that it uses itself, which otherwise act by themselves.
        moves: Axes that it may move without a word of them: letters, ``rotary`` for the machine's rotary ones, or ``plane`` for both of the plane in force.
        moves_with: Letters one of which a program must have for that; empty where it always may.
        moves_alone: Whether that holds in blocks without an axis word only.
        plane: The plane that it chooses, a key of `modal.PLANE_AXES`, or 0.
        waits: Whether blocks with it may wait while lines behind them are computed: it reads and sets no parameter, and leads nowhere.
        calls: Letter whose number names the program that it calls; where it has no `words`, all others are arguments.
        refused: The effect that does not go with other codes: ``changes the units``; and under which it is refused, in bits.
        without: Which of those have it not, or have another one: ``lathes``, or ``others``, which leave an M code to the machine's builder.
        axis_words: The meaning of axis words beside it: ``places``, places also under G91 (``absolute``), or ``sizes``.
        depth: Letter of the distance of a lathe that is the depth from R, not from where the tool stands.
        pitched: Whether F may be a pitch beside it.
        ends: What it ends: ``program`` or ``subprogram``.
        restores: The field of `saved.Saved` that it brings back, and to which value (None: that of P).
    """

    letter: str
    number: int
    group: str
    stage: int
    run: Handler
    help: str
    words: str = ""
    axes: str = "none"
    summons: str = AXES + "@^"
    dialects: tuple[str, ...] = BOTH
    title: str = ""
    named: tuple[str, ...] = ()
    after: Handler | None = None
    takes: str = ""
    moves: str = ""
    moves_with: str = ""
    moves_alone: bool = False
    plane: int = 0
    calls: str = ""
    waits: bool = False
    refused: tuple[str, int] = ("", 0)
    without: str = ""
    axis_words: str = "places"
    depth: str = ""
    pitched: bool = False
    ends: str = ""
    restores: tuple[str, int | None] = ("", None)

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


class Codes(Mapping[tuple[str, int], Code]):
    """The codes of a dialect by letter and number in tenths.

    A module is imported when a code is asked for that none before it has: most programs need less than half of them.
    """

    def __init__(self, dialect: str) -> None:
        self._dialect = dialect
        self.family = LATHE if dialect in LATHES else dialect
        # Plain language has the M functions and modes of LinuxCNC, and motions of its own.
        self._base = language_of(dialect) if language_of(dialect) in BOTH else BOTH[0]
        self._heir = "lathes" if dialect in LATHES else "" if dialect in BOTH else "others"
        self._found: dict[tuple[str, int], Code] = {}
        self._waiting = list(reversed(_MODULES))

    def _import_next(self) -> None:
        for code in import_module(f"cncgen.gcode.{self._waiting.pop()}").CODES:
            named = not {self._dialect, self.family}.isdisjoint(code.dialects)
            if named or (self._base in code.dialects and not (self._heir and code.without == self._heir)):
                self._found[code.letter, code.number] = code

    def __getitem__(self, key: tuple[str, int]) -> Code:
        while key not in self._found and self._waiting:
            self._import_next()
        return self._found[key]

    def row(self, letter: str, number: int) -> Code | None:
        """Return a row, or None."""
        return self._found.get((letter, number)) or self.get((letter, number))

    def of(self, block: Block) -> list[Code]:
        """Return the rows of the G and M codes of a block, and of its words that act by themselves."""
        alone = not _LONE.isdisjoint(block.words)
        if not (alone or block.g or block.m):
            return []
        rows = [self.row("G", number) for number in block.g] + [self.row("M", number) for number in block.m]
        if alone:
            rows += [self.row(letter, 0) for letter in ALONE if letter.lower() in block.words]
        return [row for row in rows if row is not None]

    def __iter__(self) -> Iterator[tuple[str, int]]:
        while self._waiting:
            self._import_next()
        return iter(self._found)

    def __len__(self) -> int:
        return sum(1 for _ in self)


@cache
def table(dialect: str) -> Codes:
    """Return the codes of a dialect."""
    return Codes(dialect)
