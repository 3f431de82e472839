"""The axes that a program moves, itself or in the files that it calls, known before its first block is run.

An axis moves where a word names it, or where a code moves it without a word of its own: the rows of the table of codes name these axes
(`Code.moves`, `Code.plane`) and the codes that call other programs (`Code.calls`).
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import compress
from pathlib import Path

from cncgen.diagnostics import UsageError
from cncgen.gcode.codes.lathe_words import DISTANCES
from cncgen.gcode.codes.probing import POSITIONING
from cncgen.gcode.codes.table import LATHES, Code, language_of, table
from cncgen.gcode.source import Source, open_source
from cncgen.gcode.state.modal import PLANE_AXES
from cncgen.gcode.text.parsers import parser
from cncgen.gcode.text.search import candidates, leaves_path, parted
from cncgen.grammars.terminals import FANUC
from cncgen.kernels import gcode_codes
from cncgen.kernels.gcode_names import named
from cncgen.records import dataclass
from cncgen.units import AXIS_LETTERS

MAX_FILES = 1000

#: Words of distances on a lathe of FANUC, and their axes.
_DISTANCES = str.maketrans({word.upper(): axis.upper() for word, (axis, _) in DISTANCES.items()})


@dataclass(slots=True)
class _Text:
    """The names in a text.

    Attributes:
        bits: Letters of words, A in bit 0, and whether a code is computed.
        codes: Its codes with the line on which each stands first.
        first_call: The line of the first call of another program, or 0.
        alone: Codes that stand in a block without an axis word somewhere.
        programs: Numbers and names of the programs that it calls.
    """

    bits: int
    codes: dict[Code, int]
    first_call: int
    alone: set[Code]
    programs: set[float | str]


def moving_axes(
    text: Source,
    dialect: str,
    folders: Sequence[Path] = (),
    rotary: Callable[[], set[str]] = lambda: {"a", "c"},
    turning: str = "",
) -> str:
    """Return the letters of the axes that a program moves, in the order of ``XYZABCUVW``.

    Subprograms in files count where the call says their name or number. The file of a computed number is not known before it runs.

    Args:
        text: The program.
        dialect: Its language.
        folders: Where files of subprograms are looked for.
        rotary: Runs a lathe's program that has words A or C, and returns those that named axes (small letters): only the run tells
            them from angles and chamfers.
        turning: The rotary axes of the machine, which codes turn without a word.
    """
    main = _named(text, dialect)
    texts = [main, *_called(main, dialect, folders)]
    letters = {chr(65 + k) for found in texts for k in range(26) if found.bits >> k & 1}
    named = "".join(letters)
    if dialect in LATHES:
        named = named.translate(_DISTANCES)
        if "A" in named or "C" in named:
            named = named.translate(
                {ord(letter): None for letter in {"A", "C"} - {one.upper() for one in rotary()}}
            )
    if any(POSITIONING in found.programs for found in texts):
        named += "XYZ"
    moved = {*named, *_moved(texts, "".join(letters).lower(), 18 if dialect in LATHES else 17, turning)}
    return "".join(letter for letter in AXIS_LETTERS if letter in moved)


def _moved(texts: list[_Text], letters: str, plane: int, turning: str) -> Iterator[str]:
    """Yield the axes that codes move without their words; `plane` is in force where no code has chosen another one."""
    codes = {
        code
        for found in texts
        for code in found.codes
        if (
            code in found.alone
            if code.moves_alone
            else not code.moves_with or not {*code.moves_with}.isdisjoint(letters)
        )
    }
    for code in codes:
        if code.moves != "plane":
            yield from code.moves.replace("rotary", turning)
    if any(found.bits & gcode_codes.COMPUTED for found in texts):
        yield from "XYZ"
    if not any(code.moves == "plane" for code in codes):
        return
    planes = {code.plane for code in codes if code.plane}
    if not planes or _begins_without(texts[0]):
        planes.add(plane)
    for number in planes:
        for column in PLANE_AXES[number][:2]:
            yield AXIS_LETTERS[column]


def _begins_without(main: _Text) -> bool:
    """Tell whether the program moves in a plane, or calls another program, before it chooses a plane."""
    chosen = min((line for code, line in main.codes.items() if code.plane), default=0)
    moved = [line for code, line in main.codes.items() if code.moves == "plane"]
    moved += [main.first_call] if main.first_call else []
    return bool(moved) and not 0 < chosen <= min(moved)


def _named(text: Source, dialect: str) -> _Text:
    count = 2 * gcode_codes.CODE_NUMBERS
    first, calls = array("i", bytes(8 * count)), bytearray(count)
    language = language_of(dialect)
    read = partial(named, parser(language, False), text.bytes, first, calls, language == "fanuc")
    bits, line, programs = read()
    rows, renamed = table(dialect), LATHES.get(dialect, {})
    codes: dict[Code, int] = {}
    alone: set[Code] = set()
    for place in compress(range(count), first):
        letter, number = divmod(place, gcode_codes.CODE_NUMBERS)
        code = rows.get(("GM"[letter], renamed.get(number, number) if letter == 0 else number))
        if code is not None:
            codes[code] = first[place]
            if first[place + count]:
                alone.add(code)
            if code.calls:
                calls[place] = ord(code.calls) + (0 if code.words else gcode_codes.ARGUMENTS)
    if any(calls):
        bits, line, programs = read()
    callers = [rf"{code.letter}[ \t]*0*{code.number // 10}" for code in codes if code.calls]
    if callers and language == "fanuc":
        # A program stands behind its caller by name, or its file in a comment (Haas).
        call = re.compile(rf"(?i)(?:{'|'.join(callers)})[ \t]*(?:<([^>\n]*)>|({FANUC['COMMENT']}))".encode())
        for found in call.finditer(text.data):
            name = (found[1] or found[2]).decode("utf-8", "replace")
            programs.add("".join((name if found[1] else parted(name)[1]).split()).lower())
    return _Text(bits, codes, line, alone, programs)


def _called(main: _Text, dialect: str, folders: Sequence[Path]) -> Iterator[_Text]:
    """Yield the axes in the files that a program calls, and in the files that these call."""
    seen: set[Path] = set()
    waiting = [main] if folders else []
    while waiting and len(seen) < MAX_FILES:
        for name in dict.fromkeys(_names(waiting.pop().programs)):
            path = next((path for folder in folders for path in candidates(folder, name)), None)
            if path is None or path in seen:
                continue
            seen.add(path)
            try:
                source = open_source(path, str(path))
            except UsageError:
                continue
            waiting.append(_named(source, dialect))
            yield waiting[-1]


def _names(programs: set[float | str]) -> Iterator[str]:
    """Yield the names of files, without suffix, that may hold programs of these numbers and names."""
    for program in sorted(programs, key=str):
        if isinstance(program, str):
            if not leaves_path(program):
                yield program
        elif program >= 0.0 and program.is_integer():
            yield f"{program:.0f}"
            # FANUC: eight digits are four of repeats and four of the number; files are named O and four digits.
            yield f"O{int(program) % 10_000:04d}"
            yield f"O{int(program):04d}"
