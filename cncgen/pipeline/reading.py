"""Opening programs: which language a file is in, and the package that reads it (`cncgen.gcode` or `cncgen.stepnc`)."""

from __future__ import annotations

import importlib
import io
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from types import ModuleType

from cncgen.arguments import declared, expect, expect_fields, expect_path, wrong
from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, UsageError
from cncgen.extensions import DIALECT_GROUP, foreign_module, is_brought, part_of
from cncgen.files import STANDARD, open_input, peeked
from cncgen.pipeline.file_kinds import SUFFIXES, holds_setpoints, language_of, other_kind
from cncgen.records import replace
from cncgen.toolpath.reading import DIALECTS, ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, BinaryIO, Unpack

    from cncgen.toolpath.reading import ReadWords
    from cncgen.toolpath.record import Program, Toolpath

#: The package that reads each language.
_READERS = {"gcode": "cncgen.gcode", "stepnc": "cncgen.stepnc"}
#: Motions and events that a program may hand on by default, and those that each of its lines may hand on beside them: to a plan, which
#: takes from 40 µs to 1 ms for each; to a plan that predicts the axes, some 2 ms; to a command that plans it many times.
PLANNED, PREDICTED, REPEATED = (100_000, 100), (5_000, 100), (1_000, 50)
#: Motions of a step that the options allow.
MOTIONS_OF_A_STEP = 10
#: Number of bytes at the start of a file that decide its kind.
_HEAD_BYTES = 4096


@declared
def read(
    source: str | os.PathLike[str],
    *,
    language: str | None = None,
    options: ReadOptions | None = None,
    **asked: Unpack[ReadWords],
) -> Program:
    """Open a program; its toolpath is read on demand (`Program.chunks`).

    Args:
        source: A file, or ``-`` for standard input.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read; or its fields as keywords (``dialect="fanuc"``).

    Returns:
        The program, of which only the axes are known yet. Its errors are found, and raised, when it is planned.

    Raises:
        UsageError: The file cannot be read, or a language or option is unknown.
    """
    options = _asked_for(options, asked)
    with _opened(source, language) as (reader, file, name):
        file, how = _in_own_dialect(reader, file, name, options)
        program: Program = reader.read(file, name, how)
    return program


def check(
    source: str | os.PathLike[str],
    diagnostics: Diagnostics,
    *,
    language: str | None = None,
    options: ReadOptions | None = None,
    content: bytes | None = None,
) -> int:
    """Read and interpret a program only to find its faults; return how many motions and events it has.

    Args:
        source: A file, or ``-`` for standard input.
        diagnostics: Takes all that is found.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read.
        content: Content of the file, if the caller has read it already.

    Raises:
        UsageError: The file cannot be read.
    """
    with _opened(source, language, content) as (reader, file, name):
        file, how = _in_own_dialect(reader, file, name, options)
        if hasattr(reader, "check"):
            found: int = reader.check(file, name, how, diagnostics)
            return found
        program = reader.read(file, name, how)
    from cncgen.toolpath.gate import beyond_numbers

    count = 0
    try:
        for chunk in program.chunks():
            count += len(chunk)
            if not program.diagnostics.has_errors:
                program.diagnostics.extend(beyond_numbers(chunk))
        return count
    finally:
        diagnostics.extend(program.diagnostics)


@declared
def read_text(
    text: str | bytes,
    name: str = "program",
    *,
    language: str | None = None,
    options: ReadOptions | None = None,
    **asked: Unpack[ReadWords],
) -> Program:
    """Read a program from memory; see `read`.

    Args:
        text: The program; bytes as a file has them.
        name: How diagnostics call it; its suffix may tell the language.
        language: ``gcode`` or ``stepnc``; None: by content and the name's suffix.
        options, asked: As for `read`.

    Raises:
        UsageError: `text` is not a text, or a language or option is unknown.
    """
    options = _asked_for(options, asked)
    given = expect(text, (str, bytes, bytearray, memoryview), "text", "str or bytes")
    content = given.encode(errors="replace") if isinstance(given, str) else bytes(given)
    reader = _reader(language, name, content[:_HEAD_BYTES])
    file, how = _in_own_dialect(reader, io.BytesIO(content), name, options)
    program: Program = reader.read(file, name, how)
    return program


def _asked_for(options: ReadOptions | None, asked: Mapping[str, Any]) -> ReadOptions | None:
    """Return options in which the fields that are given as keywords are replaced.

    Raises:
        UsageError: A field is unknown, or the options are not `ReadOptions`.
    """
    if not asked:
        return options
    expect_fields(ReadOptions, asked)
    how = ReadOptions() if options is None else expect(options, ReadOptions, "options", "cncgen.ReadOptions")
    return replace(how, **asked)


def _reading(options: ReadOptions | None) -> ReadOptions:
    """Return the options, or the usual ones for None.

    Raises:
        UsageError: They are not `ReadOptions`, or a value is wrong.
    """
    if options is None:
        return ReadOptions()
    how: ReadOptions = expect(options, ReadOptions, "options", "cncgen.ReadOptions")
    how.check()
    return how


def _in_own_dialect(
    reader: ModuleType, file: str | BinaryIO, name: str, options: ReadOptions | None
) -> tuple[str | BinaryIO, ReadOptions]:
    """Return a program and its options; G-code of a dialect that another package brings is translated line by line.

    Raises:
        UsageError: The options are wrong, no package brings the dialect, or its translation has other lines than the program.
    """
    if (
        not isinstance(options, ReadOptions)
        or not isinstance(options.dialect, str)
        or options.dialect in DIALECTS
        or reader.__name__ != _READERS["gcode"]
    ):
        return file, _reading(options)
    if not is_brought(DIALECT_GROUP, options.dialect):
        return file, _reading(options)
    module = foreign_module(DIALECT_GROUP, options.dialect)
    base = part_of(module, "BASE", "say which dialect it translates to")
    if base not in DIALECTS:
        said = f"{module.__name__}: BASE = {base!r} is not one of {', '.join(DIALECTS)}"
        raise UsageError(Diagnostic("extension", said))
    translated = part_of(module, "translated", "translate programs")
    how = _reading(replace(options, dialect=str(base)))
    with open(file, "rb") if isinstance(file, str) else nullcontext(file) as stream:
        content = stream.read()
    text = content.decode(errors="surrogateescape")
    found = translated(text) if callable(translated) else None
    if not isinstance(found, str) or found.count("\n") != text.count("\n"):
        said = f"{module.__name__}: the translation of {name} must have the lines of the program, one for one"
        raise UsageError(Diagnostic("extension", said))
    return io.BytesIO(found.encode(errors="surrogateescape")), how


def reader_of(language: str) -> ModuleType:
    """Return the package that reads a language: it has `read`, and maybe `check` and `canon`.

    Raises:
        UsageError: The language is unknown.
    """
    if language not in SUFFIXES:
        raise wrong(f"language = {language!r} is not one of {', '.join(SUFFIXES)}")
    return importlib.import_module(_READERS[language])


@contextmanager
def _opened(
    source: str | os.PathLike[str], language: str | None, content: bytes | None = None
) -> Iterator[tuple[ModuleType, str | BinaryIO, str]]:
    """Open a program; yield the package that reads it, its input (a path that can be mapped, or a stream), and its name.

    If its `content` is given the file itself is not opened.
    """
    name = expect_path(source, "the program", "the name of a file (cncgen.read_text reads a text)")
    if "\n" in name and not os.path.exists(name):
        raise wrong("the program is a text, not the name of a file", "cncgen.read_text reads a text")
    if content is not None:
        yield _reader(language, name, content[:_HEAD_BYTES]), io.BytesIO(content), name
        return
    with open_input(name) as file:
        reader = _reader(language, name, peeked(file, _HEAD_BYTES, name))
        regular = name != STANDARD and stat.S_ISREG(os.fstat(file.fileno()).st_mode)
        yield reader, name if regular else file, name


def _reader(language: str | None, name: str, head: bytes) -> ModuleType:
    """Return the package that reads a program.

    Args:
        language: ``gcode`` or ``stepnc``; None: by name and first bytes.
        name: Of the file.
        head: Its first bytes.

    Raises:
        UsageError: The language is unknown, or the file is not a program.
    """
    if language is None and holds_setpoints(head):
        text = f"{name} holds setpoints or a response, not a program"
        hint = "cncgen simulate, verify, compensate and plot take setpoints; cncgen.read_setpoints reads them"
        raise UsageError(Diagnostic("setpoints-as-program", text, hint=hint))
    if language is None and (other := other_kind(head)) is not None:
        raise UsageError(Diagnostic("not-a-program", f"{name} is {other[0]}, not a program", hint=other[1]))
    return reader_of(language_of(name, head) if language is None else language)


def canon(
    source: str | os.PathLike[str],
    *,
    language: str | None = None,
    options: ReadOptions | None = None,
    diagnostics: Diagnostics | None = None,
) -> Iterator[str]:
    """Yield the canonical motions of a program as text, a call a line; see `canon` of `cncgen.gcode` and `cncgen.stepnc`.

    Args:
        source: A file, or ``-`` for standard input.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read.
        diagnostics: Takes all that is found, errors too; complete when all calls are drawn.

    Raises:
        UsageError: The file cannot be read.
        ProgramError: The program has errors, and `diagnostics` is not given; raised when all calls are drawn.
    """
    with _opened(source, language) as (reader, file, name):
        file, how = _in_own_dialect(reader, file, name, options)
        yield from reader.canon(file, name, how, diagnostics)


def sound(program: Program, most: tuple[int, int] = PLANNED, spindle: float = 1.0) -> Iterator[Toolpath]:
    """Yield the toolpaths of a program as long as it has no error; after one, read the rest only to find the other errors.

    Args:
        program: The program.
        most: How many motions it may hand on where its options do not say, and how many more for each line.
        spindle: See `Program.chunks`.

    Raises:
        ProgramError: With all that was found; or the program hands on more motions.
    """
    count = last = 0
    anyway, of_a_line = max(most[0], MOTIONS_OF_A_STEP * (program.options.max_steps or 0)), most[1]
    for chunk in program.chunks(spindle):
        if program.diagnostics.has_errors:
            continue
        count, last = count + len(chunk), max(int(chunk.line.max(initial=0)), last)
        bound = anyway + of_a_line * last
        if count > bound:
            row = len(chunk) - (count - bound)
            program.diagnostics.add(
                Diagnostic(
                    "too-many-steps",
                    f"more than {bound} motions and events come of {last} lines: the program counts as endless",
                    span=chunk.span(row),
                    hint="--max-steps sets the bound",
                )
            )
            break
        yield chunk
    if program.diagnostics.has_errors:
        raise ProgramError(program.diagnostics)
