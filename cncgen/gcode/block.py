"""The records that readers of the text hand to the interpreter: a parsed block, and a block with its values."""

from __future__ import annotations

from collections.abc import Callable, Container

from cncgen.gcode.errors import BlockError
from cncgen.ranges import POSITION
from cncgen.records import dataclass, field, replace

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters

#: A value: known when the text is read, or computed from the parameters when the block runs. None is vacant.
Computed = Callable[["Parameters"], float]
Value = float | Computed

AXES = "xyzabcuvw"
AXIS_INDEX = {letter: index for index, letter in enumerate(AXES)}
#: Number, in tenths, that BSPLINE of Siemens has among the G codes (no control has a G1060).
BSPLINE = 10_600
#: The first character of an output command of FANUC's macros, which is kept like a comment; no comment begins so.
OUTPUT = "\x1f"
#: The second tool of a block that changes it, T1 T2 M6: Mazak's controls make it ready.
NEXT_TOOL = "t next"
#: The word that a program's name behind M98 or G65 becomes, and the names by its number.
PROGRAM = "program"
program_names: list[str] = []


def named_program(name: str) -> int:
    """Return the number of a program's name."""
    if name not in program_names:
        program_names.append(name)
    return program_names.index(name)


#: Largest number of a word, mm or inch: machines have their places within it.
LARGEST = POSITION


class Own:
    """Numbers, in tenths, of Heidenhain's own: SPL, CC, C, CR, CP, LP, CYCL CALL, M140, oversizes, remarks, the feed of TOOL CALL, M128, M129, TOOL DEF."""

    SPL, POLE, CIRCLE, RADIUS_ARC, POLAR_ARC, POLAR_LINE, CYCLE_CALL, RETRACT = range(10_610, 10_690, 10)
    OVERSIZE, REMARK, TOOL_FEED, TIP, TIP_OFF, TOOL_SIZES = range(10_690, 10_750, 10)


@dataclass(slots=True)
class Block:
    """One block, all values known.

    Attributes:
        words: Value by lower-case letter (``@`` and ``^`` too), without G, M and N.
        g, m: Ten times the numbers of its G and M words, in the order of the text.
        comment: The last comment, without its parentheses, or None; the others are not used (Kramer et al. (2000), 3.3.5).
        source, line, offset: Where it stands: number of the text, line from 1, and byte at which that begins.
    """

    words: dict[str, float]
    g: tuple[int, ...] = ()
    m: tuple[int, ...] = ()
    comment: str | None = None
    source: int = 0
    line: int = 0
    offset: int = 0

    def axes(self) -> list[tuple[int, float]]:
        """Return columns and values of its axis words."""
        return [(AXIS_INDEX[letter], value) for letter, value in self.words.items() if letter in AXIS_INDEX]

    def only(self, letters: Container[str]) -> dict[str, float]:
        """Return the words of some letters."""
        return {letter: value for letter, value in self.words.items() if letter in letters}

    def without(self, letters: Container[str]) -> Block:
        """Return the block without the words of some letters."""
        return replace(self, words={k: value for k, value in self.words.items() if k not in letters})

    def beside(self, words: dict[str, float], g: tuple[int, ...] = (), m: tuple[int, ...] = ()) -> Block:
        """Return another block that stands where this one does."""
        return Block(words, g, m, None, self.source, self.line, self.offset)


@dataclass(slots=True)
class Flow:
    """A step in the order of execution: an O-word of LinuxCNC, or a jump or loop of a macro.

    Attributes:
        keyword: ``sub``, ``while``, ``goto`` …
        label: Number or name, or a function that computes it.
        arguments: Values in brackets.
    """

    keyword: str
    label: Value | str | None = None
    arguments: tuple[Value, ...] = ()
    then: Parsed | None = None


@dataclass(frozen=True, slots=True)
class Jump:
    """Where a block leads that calls, returns or passes lines (M96, M97, M98, M99, G65, G66, a cycle of lathes).

    Attributes:
        kind: ``call``, ``macro``, ``modal``, ``line``, ``lines``, ``return`` or ``past``.
        number: Number of the program, below 0 that of its name; of ``line``, ``lines``, ``return`` and ``past`` that of an N word, -1 for none.
        times: How often it runs.
        line: N of the line at which the program of a call begins, -1 for its first.
    """

    kind: str
    number: int = -1
    times: int = 1
    line: int = -1


@dataclass(slots=True)
class Parsed:
    """One block as the grammar reads it, before its values are known.

    Attributes:
        words: Lower-case letter and value, in the order of the text.
        settings: Parameter (number, name or a function that computes the number) and its new value.
        comments: Comments without their parentheses.
        flow: Its step in the order of execution, or None.
        deletable: Whether it begins with ``/``.
        number: Text of the N word, or None.
    """

    words: list[tuple[str, Value]] = field(default_factory=list)
    settings: list[tuple[Value | str, Value]] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    flow: Flow | None = None
    deletable: bool = False
    number: str | None = None

    @property
    def is_o_word(self) -> bool:
        """Tell whether it is an O-word, or a jump or loop of a macro, alone."""
        return self.flow is not None and self.flow.then is None and not (self.words or self.settings)


def evaluate(value: Value, parameters: Parameters) -> float:
    """Return the number that a value is now."""
    return value if isinstance(value, float) else value(parameters)


def tenths(letter: str, value: float) -> int:
    """Return ten times a G or M number, exactly; raise where it has more digits than codes have."""
    scaled = value * 10.0
    if not abs(scaled) <= LARGEST:
        raise BlockError("unknown-code", f"{letter}{value:g} is not a code", letter)
    whole = round(scaled)
    if abs(scaled - whole) > 1e-6 or whole < 0 or (letter == "M" and whole % 10):
        raise BlockError("unknown-code", f"{letter}{value:g} is not a code", f"{letter}{value:g}")
    return whole


def nearest(value: float, what: str) -> int:
    """Return the whole number next to a value; raise where it is vacant or too large to be one."""
    if value != value:
        raise BlockError("number-range", f"{what} has no value", hint="set its parameter before")
    if not -LARGEST <= value <= LARGEST:
        raise BlockError("number-range", f"{what} is not within ±{LARGEST:g}")
    return round(value)


def repeated(letter: str) -> BlockError:
    """Return the fault of a letter that stands twice in a block."""
    message = f"{letter.upper()} stands twice in one block"
    return BlockError("repeated-word", message, letter.upper(), hint="write it once")


def gather(pairs: list[tuple[str, float]], twice: list[str] | None = None) -> Block:
    """Make a block of letters and known values; raise where a letter stands twice or a number is out of range.

    Args:
        pairs: Letters and values, in the order of the text.
        twice: Takes the letters that stand twice, whose last word counts then; T stays a fault.
    """
    words: dict[str, float] = {}
    g: list[int] = []
    m: list[int] = []
    for letter, value in pairs:
        if letter == "g":
            g.append(tenths("G", value))
        elif letter == "m":
            m.append(tenths("M", value))
        elif letter == "t" and letter in words and NEXT_TOOL not in words and ("m", 6.0) in pairs:
            words[NEXT_TOOL] = value
        elif letter in words and (twice is None or letter == "t"):
            raise repeated(letter)
        else:
            if letter in words and twice is not None:
                twice.append(letter)
            if not -LARGEST <= value <= LARGEST:
                message = f"{letter.upper()}{value:.15g} is not a finite number within ±{LARGEST:g}"
                raise BlockError("number-range", message, letter.upper(), values={"value": str(value)})
            words[letter] = value
    return Block(words, tuple(g), tuple(m))
