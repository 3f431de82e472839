"""Texts of SINUMERIK as programs: their lines, labels, and where loops and branches lead."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow import language_run
from cncgen.gcode.sinumerik.commands import RETURNS
from cncgen.gcode.sinumerik.feeds_and_tools import ENDS
from cncgen.gcode.sinumerik.reading import Item, Statement, parse
from cncgen.gcode.sinumerik.said import Said
from cncgen.gcode.source import MAX_LINE, Source
from cncgen.gcode.text import search
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.line_runs import ProgramLines, RunScan, numbers_found
from cncgen.grammars.terminals import SINUMERIK as TERMINALS

_CLOSES = {"endif": "if", "else": "if", "endloop": "loop", "endfor": "for", "endwhile": "while", "until": "repeat"}  # fmt: skip
#: The ends of what opens, as programs write them.
_OPENS = {"if": "ENDIF", "loop": "ENDLOOP", "for": "ENDFOR", "while": "ENDWHILE", "repeat": "UNTIL"}
#: Lines of a loop that may wait for a signal, and how many it has at most.
_LONGEST_WAIT = 100
_WAITING = ("block", "if-jump", "while", "endwhile", "repeat", "until")
#: Lines that lead to others, apart from loops and branches.
_LEADING = ("jump", "if-jump", "case")
#: Suffixes of files with subprograms, the best first.
SUFFIXES = (".spf", ".mpf", *search.SUFFIXES)
#: Characters of a block, and of a macro's text, beyond which neither is expanded (840D: 512).
_MOST_EXPANDED = 512
#: A macro: a name for a text (840D, Programming Guide Job Planning, "Macro technique").
_DEFINE = re.compile(
    rf"\s*(?:(?:{TERMINALS['BLOCK_NUMBER']})\s*)?DEFINE\s+(?P<name>\w+)\s+AS\b(?P<text>.*)\Z", re.IGNORECASE
)
#: Parts of a line that macros leave as they are, and names.
_NAMES = re.compile(
    rf"{TERMINALS['STRING']}|(?<![\w$])(?:{TERMINALS['ADDRESS']}|{TERMINALS['NAME']})", re.IGNORECASE
)
#: What a line with a fault begins with, where it opens, parts or closes a branch or loop: this still leads where it leads.
_BEGINS = re.compile(
    rf"\s*(?:{TERMINALS['DELETE']})?\s*(?:(?:{TERMINALS['BLOCK_NUMBER']})\s*)?(?:(?:{TERMINALS['LABEL']})\s*)?"
    rf"(?P<kind>{'|'.join(TERMINALS[kind.upper()] for kind in (*_OPENS, *_CLOSES))})(?![A-Z0-9_])",
    re.IGNORECASE,
)
_GOES = re.compile(rf"(?<![A-Z0-9_])(?:{TERMINALS['GOTO']}|{TERMINALS['GOTOS']})", re.IGNORECASE)
#: Lines of a text with a word each are often alike.
_MAX_TEXTS = 4096
Faults = list[tuple[Cursor, BlockError]]


@dataclass(slots=True)
class Line(language_run.Line):
    """A line: its place, and its statement or its fault."""

    statement: Statement
    fault: BlockError | None = None

    def says(self) -> bool:
        """Tell whether it has words or a fault."""
        return bool(self.statement.items or self.fault)


class _Texts:
    """Lines by their texts: those of late are kept, as lines with a word each are often alike."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._known: dict[str, Statement] = {}

    def statement(self, text: str) -> tuple[Statement, bool]:
        """Return the statement of a line, and whether its text is a new one; raise where the line does not belong to the language."""
        found = self._known.get(text)
        if found is not None:
            return found, False
        if len(self._known) >= _MAX_TEXTS:
            self._known.clear()
        found = self._known[text] = parse(text)
        return found, True

    def plain(self, here: Cursor) -> Line:
        """Return a plain line."""
        return Line(here, self.statement(self._source.text_at(here.offset))[0])


class Labels:
    """Lines of a program by label and by block number, in the order of the text; those of plain lines are looked for when they are asked for."""

    def __init__(self, source: Source, lines: ProgramLines[Line]) -> None:
        self._source, self._lines = source, lines
        self._named: dict[str, list[int]] = {}
        self._found: dict[str, list[int]] = {}

    def add(self, name: str, at: int) -> None:
        self._named.setdefault(name, []).append(at)

    def __bool__(self) -> bool:
        return bool(self._named) or any(True for _ in self._lines.runs())

    def of(self, name: str) -> list[int]:
        """Return the lines of a name, in capitals."""
        found = self._found.get(name)
        if found is None:
            found = self._named.get(name, [])
            if name[:1] == "N" and name[1:].isdigit():
                # A main block has : for N.
                forms = (name, f":{name[1:]}")
                runs = [at for form in forms for at in numbers_found(self._source, self._lines.runs(), form)]
                found = sorted([*found, *runs])
            self._found[name] = found
        return found


@dataclass(slots=True)
class Program(language_run.Program[Line]):
    """The lines of a program.

    Attributes:
        name: In capitals, "" of a main program without one.
        labels: Lines by label and by block number.
        other: For a line that opens or closes a loop or branch, the line that it leads to: ELSE or ENDIF of an IF, ENDIF of an
            ELSE, the end of a loop, and the beginning of the loop that an end closes.
        formals: Parameters of PROC: type, name, whether by reference, usual value, the bounds of an array or None.
        saves: Whether PROC says SAVE.
        said: The names in the blocks of its text.
    """

    name: str
    labels: Labels
    other: dict[int, int] = field(default_factory=dict)
    formals: tuple[tuple[object, ...], ...] = ()
    saves: bool = False
    said: Said = field(default_factory=Said)

    def labelled(self, name: str) -> list[int]:
        """Return the lines of a label or block number."""
        return self.labels.of(name)

    def waits(self, first: int, last: int) -> bool:
        """Tell whether the lines of a loop say only words, so that nothing in them changes what ends it."""
        if last - first > _LONGEST_WAIT:
            return False
        return not any(
            line.fault or not all(map(_is_word, line.statement.items)) or line.statement.kind not in _WAITING
            for line in (self.lines[at] for at in range(first, min(last + 1, len(self.lines))))
        )

    def passed_by(self, at: int) -> range:
        """Return the lines of both branches of an IF, or of a loop, whose condition cannot be read: a run passes them by."""
        if self.lines[at].statement.kind not in ("if", "while", "for"):
            return range(0)
        end = self.other[at]
        if end < len(self.lines) and self.lines[end].statement.kind == "else":
            end = self.other[end]
        return range(at + 1, min(end + 1, len(self.lines)))

    def never_left(self, first: int, last: int) -> bool:
        """Tell whether nothing from a line to a jump back to it leads elsewhere or ends the program."""
        if any(first <= begin < last < end for begin, end in self.other.items()):
            return False
        return not any(
            line.fault or line.statement.kind in _LEADING or any(map(_may_end, line.statement.items))
            for at, line in self.lines.entries()
            if first <= at < last
        )


def _is_word(item: Item) -> bool:
    """Tell whether a part of a block sets no variable and calls nothing."""
    return (item[0] == "word" and item[1] != "L") or item[:2] in (("name", "STOPRE"), ("call", "MSG"))


def _may_end(item: Item) -> bool:
    """Tell whether a part of a block ends the program, or may do so."""
    if item[0] == "name":
        return item[1] in RETURNS
    return item[:2] == ("set", "M") or (item[:2] == ("word", "M") and item[2] in ENDS)


_ahead: WeakKeyDictionary[Source, tuple[list[Program], Faults]] = WeakKeyDictionary()


def programs_ahead(source: Source) -> list[Program]:
    """Return the programs of a text that is run afterwards; the run takes what was read here."""
    _ahead[source] = found = programs_of(source, 0)
    return found[0]


def programs_of(source: Source, index: int, name: str = "") -> tuple[list[Program], Faults]:
    """Return the programs of a text, the main one first, and the faults of their loops and branches."""
    known_ahead = _ahead.pop(source, None)
    if known_ahead is not None:
        return known_ahead
    texts = _Texts(source)
    found = [_program(name, source, texts)]
    scan = RunScan("sinumerik", source)
    faults: Faults = []
    macros: dict[str, str] = {}
    offset, number = 0, 1
    while offset < len(source):
        here = Cursor(index, offset, number)
        # A macro may stand for any word.
        run = None if macros else scan.run_at(here, whole=True)
        if run is not None:
            found[-1].lines.add_run(run)
            found[0].said.take_letters(scan.letters)
            offset, number = run.after, number + run.count
            continue
        end = source.line_end(offset)
        text = source.text_at(offset) if end - offset <= MAX_LINE else ""
        line = _line(_expanded(text, macros), here, texts, found[0].said, end - offset)
        if line.statement.kind in ("header", "proc") and line.statement.data[0]:
            if _is_begun(found[-1]):
                found.append(_program("", source, texts))
            found[-1].name = line.statement.data[0]
        if line.statement.kind == "proc":
            found[-1].formals, found[-1].saves = line.statement.data[1], "SAVE" in line.statement.data[2]
        _add(found[-1], line)
        scan.variables |= _variables(line.statement)
        offset, number = end + 1, number + 1
    for program in found:
        faults += _connect(program)
    return found, faults


def _variables(statement: Statement) -> set[str]:
    """Return the names of variables that a line defines, each of one number."""
    if statement.kind == "def" and statement.data[0] in ("REAL", "INT", "BOOL"):
        return {name for name, bounds, _ in statement.data[1] if not bounds}
    return set()


def _expanded(text: str, macros: dict[str, str]) -> str:
    """Take a macro that a line defines, or return the line with the texts of its macros; a macro calls no macro."""
    code, mark, remark = text.partition(";")
    defined = _DEFINE.match(code)
    if defined and len(defined["text"]) <= _MOST_EXPANDED:
        macros[defined["name"].upper()] = defined["text"].strip()
        return ""
    if not macros or len(code) > _MOST_EXPANDED:
        return text
    return _NAMES.sub(lambda m: macros.get(m[0].upper(), m[0]), code) + mark + remark


def _program(name: str, source: Source, texts: _Texts) -> Program:
    lines = ProgramLines(source, texts.plain)
    return Program(lines, name, Labels(source, lines))


def _is_begun(program: Program) -> bool:
    """Tell whether a program has a line that does something, so that a name begins the next one."""
    return bool(program.labels) or any(
        line.statement.kind not in ("block", "header") or line.statement.items
        for _, line in program.lines.entries()
    )


def _line(text: str, here: Cursor, texts: _Texts, said: Said, length: int) -> Line:
    if length > MAX_LINE:
        error = BlockError("line-too-long", f"a line of {length} bytes; the longest is {MAX_LINE}", column=1)
        return Line(here, Statement(), error)
    try:
        statement, is_new = texts.statement(text)
    except BlockError as error:
        return Line(here, Statement(_kind_begun(text)), error)
    if is_new:
        said.take(statement.items)
    return Line(here, statement)


def _kind_begun(text: str) -> str:
    """Return what a line with a fault opens, parts or closes, "block" where that is nothing; IF with a jump has no branch."""
    code = text.partition(";")[0]
    begun = _BEGINS.match(code)
    kind = begun["kind"].lower() if begun else "block"
    jumps = kind == "if" and _GOES.search(code)
    # REPEAT with words repeats a part of the program.
    return "block" if jumps or kind == "repeat" else kind


def _add(program: Program, line: Line) -> None:
    at = len(program.lines)
    for name in (line.statement.label, line.statement.number):
        if name:
            program.labels.add(name, at)
    program.lines.append(line)


def _connect(program: Program) -> Faults:
    """Find the other end of each loop and branch; return those without an end."""
    faults: Faults = []
    open_lines: list[tuple[str, int]] = []
    for at, line in program.lines.entries():
        kind = line.statement.kind
        if kind in _OPENS and not (kind == "if" and line.statement.data and len(line.statement.data) > 1):
            open_lines.append((kind, at))
        elif kind in _CLOSES:
            if not open_lines or open_lines[-1][0] != _CLOSES[kind]:
                inner = f"; {open_lines[-1][0].upper()} is open" if open_lines else ""
                message = f"{kind.upper()} has no {_CLOSES[kind].upper()} that it belongs to{inner}"
                hint = f"{_CLOSES[kind].upper()} stands above, and what it holds is closed"
                # The control meets it where a run does: builders' programs have some that a jump passes by.
                line.fault = line.fault or BlockError("flow-unmatched", message, kind.upper(), hint=hint)
                continue
            _, begin = open_lines.pop()
            program.other[begin] = at
            if kind == "else":
                open_lines.append(("if", at))
            else:
                program.other.setdefault(at, begin)
    for kind, at in open_lines:
        program.other[at] = len(program.lines)
        name, end = kind.upper(), _OPENS[kind]
        error = BlockError("flow-unmatched", f"{name} has no {end}", name, hint=f"{end} closes it, below")
        faults.append((program.lines[at].here, error))
    return faults
