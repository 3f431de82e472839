"""The lines of a program, of which most may be plain motions: those stand as runs, and become entries where they are asked for."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from importlib import import_module
from typing import Any, Generic, Protocol, TypeVar

from cncgen.gcode.source import Source
from cncgen.gcode.text import expressions
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import PlainBlocks
from cncgen.kernels import gcode_codes as codes
from cncgen.kernels.language_code import LanguageCode
from cncgen.kernels.plain_lines import PlainReader
from cncgen.records import dataclass


class _Entry(Protocol):
    """What stands for a line."""

    @property
    def here(self) -> Cursor:
        """Its place."""


T = TypeVar("T", bound=_Entry)

#: Lines of a run, at least: a shorter one takes as long in arrays as line by line.
LEAST = 6
#: The same of lines with parameters and arithmetic.
LEAST_COMPUTED = 2
#: By the name of a grammar's tables, what `PlainReader` takes: the roles of terminals, rules, letters of words and of names, and whether
#: numbers and comments are not of the grammar.
_PLAIN: dict[str, tuple[dict[str, str], set[str], str, str, bool]] = {
    "sinumerik": (
        {
            "BLOCK_NUMBER": "between", "ADDRESS": "word", "PLAIN": "word", "NAME": "name", "EQUAL": "between", "SIGN": "sign",
            "PLAIN_NUMBER": "number",
        },
        {"line", "block", "word", "setting", "target", "number", "signed"},
        "xyzabcuvwijkfg",
        "xyzabcuvwijkf",
        False,
    ),
    "heidenhain": (
        {
            "MOTION": "line", "AXIS": "name", "FEED": "name", "R": "name", "M": "name", "SIGNED": "number", "FAST": "fast",
            "AUTO": "auto",
        },
        {"start", "motion", "word", "radius", "m_function", "setting", "number"},
        "",
        "xyzabcuvwfrm",
        True,
    ),
}  # fmt: skip


def _named(numbers: dict[str, int]) -> dict[bytes, int]:
    """Return numbers by the bytes of their names."""
    return {name.encode(): number for name, number in numbers.items()}


#: By language, the arguments of `LanguageCode`: terminals, those of jumps and labels, what rules do, letters of words, letter and numbers
#: of parameters. Then follow operators, functions and constants by their names, and whether lines begin with L and a number.
_COMPUTED: dict[str, tuple[Any, ...]] = {
    "sinumerik": (
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
        {"TRUE": 1.0, "FALSE": 0.0, "PI": math.pi, "$PI": math.pi},
        False,
    ),
    "heidenhain": (
        {
            "MOTION", "AXIS", "FEED", "R", "M", "SIGNED", "FAST", "NUMBER", "Q", "SIGN", "TIMES", "POWER", "DIVISION", "FUNCTION", "PI",
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

#: The least number of a parameter.
PARAMETERS = {"sinumerik": 0, "heidenhain": 1}


def tables_of(name: str) -> tuple[Any, ...]:
    """Return what `PlainReader` takes, by the name of a grammar's tables."""
    return import_module(f"cncgen.grammars.tables_{name}"), *_PLAIN[name]


@cache
def _reader(name: str) -> PlainReader:
    """Return the kernel that reads plain lines by the tables of a grammar."""
    return PlainReader(*tables_of(name))


def code_of(name: str) -> LanguageCode:
    """Return what reads lines with parameters and arithmetic into instructions."""
    code = LanguageCode(import_module(f"cncgen.grammars.tables_{name}"), *_COMPUTED[name])
    code.follow()
    return code


@cache
def _code(name: str) -> LanguageCode:
    """Return what reads runs of such lines, which have no jumps."""
    return LanguageCode(import_module(f"cncgen.grammars.tables_{name}"), *_COMPUTED[name])


class PlainScan:
    """Reads plain lines of sources into columns.

    Args:
        name: The grammar's.
    """

    def __init__(self, name: str) -> None:
        self.blocks = PlainBlocks()
        #: Names of variables that hold one number each.
        self.variables: set[str] = set()
        #: The offset behind plain lines that were too few for a run.
        self.few = 0
        self._reader = _reader(name)
        self._code = _code(name)
        self._seen = 0

    def read(self, source: Source, here: Cursor, most: int = 1 << 62, auto: float = 1.0) -> tuple[int, int]:
        """Fill the columns with plain lines from a line on; return how many lines they are, and the offset behind them.

        Args:
            source: The text.
            here: The first line.
            most: Lines that are read at most.
            auto: The feed of the tool in force; where there is none, lines that take it are not plain.
        """
        blocks = self.blocks
        blocks.count, lines, offset = self._reader.scan(
            source.bytes, here.offset, here.line, most, auto, *blocks.columns()
        )
        blocks.source = here.source
        self._seen = self._reader.seen
        return lines, offset

    def computed(self, source: Source, here: Cursor, *, whole: bool) -> LineRun | None:
        """Return the run of lines with parameters and arithmetic that begins at a line, None where they are few; `whole` as `run_of`."""
        self._code.define(self.variables)
        lines, after, blocks, last, last_at = self._code.run_from(source.bytes, here.offset)
        self._seen = self._code.seen
        if blocks and not whole:
            lines, after = last, last_at
        return LineRun(here, lines, after, computed=True) if lines >= LEAST_COMPUTED else None

    @property
    def letters(self) -> set[str]:
        """Letters of the words of the lines that were read last."""
        return {chr(97 + k) for k in range(26) if self._seen >> k & 1}

    @property
    def codes(self) -> list[int]:
        """Numbers of their G words."""
        return [k for k in range(4) if self._seen >> 26 + k & 1]


@dataclass(frozen=True, slots=True)
class LineRun:
    """Lines that follow one another: the place of the first one, how many they are, the offset behind them, and whether they compute."""

    here: Cursor
    count: int
    after: int
    computed: bool = False


class ProgramLines(Generic[T]):
    """A row of entries, one a line, in which runs of plain lines stand for theirs.

    Args:
        source: The text of the runs.
        made: Gives the entry of a plain line.
    """

    def __init__(self, source: Source, made: Callable[[Cursor], T]) -> None:
        self._source, self._made = source, made
        self._starts: list[int] = []
        #: Numbers of the first lines of the parts.
        self._numbers: list[int] = []
        self._parts: list[list[T] | LineRun] = []
        self._count = 0
        #: The entries that were asked for last: where they begin and end.
        self._low = self._high = 0
        self._entries: list[T] = []
        #: A line of a run that was found last.
        self._near, self._near_here = -1, Cursor(0, 0, 1)

    def append(self, entry: T) -> None:
        """Add an entry."""
        last = self._parts[-1] if self._parts else None
        if isinstance(last, list):
            last.append(entry)
        else:
            self._starts.append(self._count)
            self._numbers.append(entry.here.line)
            self._parts.append([entry])
        self._count += 1

    def add_run(self, run: LineRun) -> None:
        """Add plain lines."""
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

    def plain_at(self, at: int) -> tuple[Cursor, int, bool] | None:
        """Return the place of a line, how many lines begin with it in its run, and whether these compute; None where it is of no run."""
        if self._low <= at < self._high:
            return None
        k = bisect_right(self._starts, at) - 1
        part = self._parts[k]
        if isinstance(part, list):
            return None
        return self._place(k, part, at), self._starts[k] + part.count - at, part.computed

    def place(self, at: int) -> Cursor:
        """Return the place of a line."""
        found = self.plain_at(at)
        return self[at].here if found is None else found[0]

    def index_of(self, number: int) -> int:
        """Return the first line from a number in the text on."""
        k = bisect_right(self._numbers, number) - 1
        part = self._parts[k]
        if isinstance(part, list):
            return self._starts[k] + bisect_left(part, number, key=lambda entry: entry.here.line)
        return self._starts[k] + min(number - part.here.line, part.count)

    def _place(self, k: int, run: LineRun, at: int) -> Cursor:
        """Return the place of a line of a run."""
        near, here = self._near, self._near_here
        if not self._starts[k] <= near <= at:
            near, here = self._starts[k], run.here
        offset = here.offset
        for _ in range(at - near):
            offset = self._source.line_end(offset) + 1
        found = Cursor(run.here.source, offset, run.here.line + at - self._starts[k])
        self._near, self._near_here = at, found
        return found


def run_of(scan: PlainScan, source: Source, here: Cursor, *, whole: bool) -> LineRun | None:
    """Return the run of plain lines that begins at a line, None where they are few.

    Args:
        scan: Reads them; it serves one text from its begin on.
        source: The text.
        here: The line.
        whole: Whether the last line with a word is one of them, and what is behind it; it is none where its effect hangs on later lines.
    """
    if here.offset < scan.few:
        return scan.computed(source, here, whole=whole)
    lines, after = scan.read(source, here)
    blocks = scan.blocks
    if blocks.count < LEAST:
        scan.few = after
        return scan.computed(source, here, whole=whole)
    if not whole:
        lines, after = blocks.line[blocks.count - 1] - here.line, blocks.offset[blocks.count - 1]
    return LineRun(here, lines, after)


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
