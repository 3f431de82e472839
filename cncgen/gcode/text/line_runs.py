"""The lines of a program, of which most may be motions and arithmetic: those stand as runs, and become entries where they are asked for."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from typing import Any, Generic, Protocol, TypeVar

from cncgen.gcode.source import Source
from cncgen.gcode.text import expressions
from cncgen.gcode.text.labels import Cursor
from cncgen.kernels import gcode_codes as codes
from cncgen.kernels.gcode_lines import Lines
from cncgen.kernels.language_code import LanguageCode
from cncgen.records import dataclass


class _Entry(Protocol):
    @property
    def here(self) -> Cursor:
        """Its place."""


T = TypeVar("T", bound=_Entry)

_LEAST = 2


def _named(numbers: dict[str, int]) -> dict[bytes, int]:
    """Return numbers by the bytes of their names."""
    return {name.encode(): number for name, number in numbers.items()}


#: By language, the arguments of `LanguageCode` beside the grammar's tables: letters behind which digits are of the shape of a line, terminals, those
#: of jumps and labels, the work of rules, letters of words, letter and numbers of parameters, operators, functions and constants by their
#: names, and whether lines begin with L and a number.
_TAKEN: dict[str, tuple[Any, ...]] = {
    "sinumerik": (
        b"gr",
        {
            "BLOCK_NUMBER", "ADDRESS", "PLAIN", "NAME", "EQUAL", "SIGN", "PLAIN_NUMBER", "TIMES", "RELATION", "LPAR", "RPAR", "LSQB",
            "RSQB", "COMMA", "AND", "OR", "XOR", "NOT", "B_AND", "B_OR", "B_XOR", "B_NOT",
        },
        {
            "LABEL", "IF", "ELSE", "ENDIF", "LOOP", "ENDLOOP", "FOR", "TO", "ENDFOR", "WHILE", "ENDWHILE", "REPEAT", "UNTIL", "GOTO",
        },
        {
            **dict.fromkeys(("line", "block", "endif", "loop", "repeat"), "alone"), "for_": "counts", "jump": "goes", "if_jump": "when",
            **dict.fromkeys(("if_", "while_", "until"), "unless"),
            **dict.fromkeys(("else_", "endloop", "endfor", "endwhile"), "turns"), "negation": "function",
            **dict.fromkeys(("binary", "compare", "both", "or_", "xor", "bit_and", "bit_or", "bit_xor"), "operator"), "bit_not": "function", "number": "number", "parameter": "parameter",
            "variable": "element", "signed": "sign", "function": "call", "arguments": "arguments", "word": "word", "target": "target",
            "setting": "setting",
        },
        "xyzabcuvwijkfg", "r", 0, 32_767,
        _named(expressions.OF_SINUMERIK),
        {
            **{(name.encode(), 1): number for name, number in expressions.FUNCTIONS_OF_SINUMERIK.items()}, (b"NOT", 1): codes.NEGATED,
            **{(name.encode(), 2): number for name, number in expressions.PAIRS_OF_SINUMERIK.items()},
        },
        expressions.CONSTANTS_OF_SINUMERIK,
        False,
    ),
    "heidenhain": (
        b"mnqr",
        {
            "MOTION", "AXIS", "FEED", "R", "M", "SIGNED", "FAST", "AUTO", "NUMBER", "Q", "SIGN", "TIMES", "POWER", "DIVISION", "FUNCTION", "PI",
            "LPAR", "RPAR", "EQUAL", "COLON", "ROOT", "SINE", "COSINE", "LENGTH", "ANGLE", "FN_13", *(f"FN_{n}" for n in range(9)),
        },
        {
            *(f"FN_{n}" for n in range(9, 13)), "IF", "GOTO", "EQUALS", "DIFFERS", "GREATER", "LESS", "_LBL", "CALL", "REP", "IDENTIFIER", "STRING",
        },
        {
            "jump": "when", "call": "repeats", "label_here": "label", "label": "label", "repeats": "alone",
            "start": "alone", "motion": "motion", "word": "named", "m_function": "named", "radius": "radius", "setting": "fast",
            "number": "number", **dict.fromkeys(("parameter", "signed_parameter"), "parameter"), "pi": "pi", "unary": "sign",
            "function": "function", "binary": "operator", **dict.fromkeys(("assignment", "fn_assignment"), "setting"),
            **dict.fromkeys(("operation", "one_operand"), "operation"),
        },
        "xyzabcuvwfm", "q", 1, 4_999,
        _named(expressions.OF_HEIDENHAIN),
        {(name.encode(), 1): number for name, number in expressions.FUNCTIONS_OF_HEIDENHAIN.items()},
        {},
        True,
    ),
}  # fmt: skip

#: The least number of a parameter, by language.
PARAMETERS: dict[str, int] = {name: taken[6] for name, taken in _TAKEN.items()}


def arguments_of(name: str) -> tuple[Any, ...]:
    """Return what `LanguageCode` takes, by the name of a grammar's tables."""
    fixed, *others = _TAKEN[name]
    return fixed, import_module(f"cncgen.grammars.tables_{name}"), *others


def code_of(name: str) -> LanguageCode:
    """Return what reads lines into instructions, by the name of a grammar's tables."""
    return LanguageCode(*arguments_of(name))


class RunScan:
    """Finds the runs of a text.

    Args:
        name: The grammar's.
        source: The text.

    Attributes:
        variables: Names of variables that hold one number each.
        letters: Letters of the words of the run that was found last.
    """

    def __init__(self, name: str, source: Source) -> None:
        self.variables: set[str] = set()
        self.letters: set[str] = set()
        code = code_of(name)
        code.define(self.variables)
        self._lines = Lines(code, source.bytes)

    def run_at(self, here: Cursor, *, whole: bool) -> LineRun | None:
        """Return the run that begins at a line, None where its lines are few.

        Args:
            here: The line.
            whole: Whether the last line with a word is one of them, and what is behind it; it is none where its effect hangs on later lines.
        """
        lines, after, blocks, last, last_at, seen = self._lines.taken_from(here.offset)
        self.letters = {chr(97 + k) for k in range(26) if seen >> k & 1}
        if blocks and not whole:
            lines, after = last, last_at
        return LineRun(here, lines, after) if lines >= _LEAST else None


@dataclass(frozen=True, slots=True)
class LineRun:
    """Lines that follow one another: the place of the first one, how many they are, and the offset behind them."""

    here: Cursor
    count: int
    after: int


class ProgramLines(Generic[T]):
    """A row of entries, one a line, in which runs stand for theirs.

    Args:
        source: The text of the runs.
        made: Gives the entry of a line of a run.
    """

    def __init__(self, source: Source, made: Callable[[Cursor], T]) -> None:
        self._source, self._made = source, made
        self._starts: list[int] = []
        self._numbers: list[int] = []
        self._parts: list[list[T] | LineRun] = []
        self._count = 0
        #: The entries that were asked for last: where they begin and end.
        self._low = self._high = 0
        self._entries: list[T] = []
        #: A line of a run that was found last.
        self._near, self._near_here = -1, Cursor(0, 0, 1)

    def append(self, entry: T) -> None:
        last = self._parts[-1] if self._parts else None
        if isinstance(last, list):
            last.append(entry)
        else:
            self._starts.append(self._count)
            self._numbers.append(entry.here.line)
            self._parts.append([entry])
        self._count += 1

    def add_run(self, run: LineRun) -> None:
        """Add the lines of a run."""
        self._starts.append(self._count)
        self._numbers.append(run.here.line)
        self._parts.append(run)
        self._count += run.count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, at: int) -> T:
        if self._low <= at < self._high:
            return self._entries[at - self._low]
        at += self._count if at < 0 else 0
        if not 0 <= at < self._count:
            raise IndexError(at)
        k = bisect_right(self._starts, at) - 1
        part = self._parts[k]
        if not isinstance(part, list):
            return self._made(self._place(k, part, at))
        self._low, self._entries = self._starts[k], part
        self._high = self._low + len(part)
        return part[at - self._low]

    def entries(self) -> Iterator[tuple[int, T]]:
        """Yield the entries that are of no run, and their places."""
        for start, part in zip(self._starts, self._parts, strict=True):
            if isinstance(part, list):
                yield from enumerate(part, start)

    def runs(self) -> Iterator[tuple[int, LineRun]]:
        """Yield the runs, and the places of their first lines."""
        for start, part in zip(self._starts, self._parts, strict=True):
            if isinstance(part, LineRun):
                yield start, part

    def run_at(self, at: int) -> tuple[Cursor, int] | None:
        """Return the place of a line, and how many lines begin with it in its run; None where it is of no run."""
        if self._low <= at < self._high:
            return None
        k = bisect_right(self._starts, at) - 1
        part = self._parts[k]
        if isinstance(part, list):
            return None
        return self._place(k, part, at), self._starts[k] + part.count - at

    def place(self, at: int) -> Cursor:
        found = self.run_at(at)
        return self[at].here if found is None else found[0]

    def index_of(self, number: int) -> int:
        """Return the first line from a number in the text on."""
        k = bisect_right(self._numbers, number) - 1
        part = self._parts[k]
        if isinstance(part, list):
            return self._starts[k] + bisect_left(part, number, key=lambda entry: entry.here.line)
        return self._starts[k] + min(number - part.here.line, part.count)

    def _place(self, k: int, run: LineRun, at: int) -> Cursor:
        near, here, first = self._near, self._near_here, self._starts[k]
        if not first <= near < first + run.count or at - first < near - at:
            near, here = first, run.here
        offset = here.offset
        for _ in range(at - near):
            offset = self._source.line_end(offset) + 1
        for _ in range(near - at):
            offset = self._source.line_begin(offset - 1)
        found = Cursor(run.here.source, offset, run.here.line + at - self._starts[k])
        self._near, self._near_here = at, found
        return found


def numbers_found(source: Source, runs: Iterable[tuple[int, LineRun]], name: str) -> list[int]:
    """Return the lines of runs that begin with a block number as it is written; `runs` have the numbers of their first lines."""
    import re

    found = []
    pattern = re.compile(
        rb"^[ \t\r]*" + re.escape(name.encode()) + rb"(?![0-9._])", re.MULTILINE | re.IGNORECASE
    )
    for start, run in runs:
        for match in pattern.finditer(source.data, run.here.offset, run.after):
            found.append(start + source.data[run.here.offset : match.start()].count(b"\n"))
    return found
