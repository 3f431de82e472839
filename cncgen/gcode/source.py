"""A program's text: bytes in memory without copying them, lines found when they are asked for."""

from __future__ import annotations

import codecs
import mmap
import os
from collections.abc import Iterator
from contextlib import contextmanager

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import (
    STANDARD,
    STANDARD_INPUT,
    WIDE_MARK,
    as_utf8,
    file_fault,
    is_wide,
    note_read,
    reading_faults,
)
from cncgen.records import replace

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import BinaryIO

    from cncgen.gcode.errors import BlockError
    from cncgen.gcode.text.labels import Cursor

#: Bytes of a line that are read at all; a longer line is an error.
MAX_LINE = 65_536
#: Bytes of a stream that are read at all: some hundred million lines. A file may be larger.
MAX_STREAM = 4 * 1024**3
#: Bytes looked at to tell text from binary.
_HEAD = 4096
_BLOCK = 1 << 20
#: Bytes of the leader and trailer of a tape: blank places, and the codes DC1 to DC4 that start and stop its reader and punch; and the
#: Control-Z that ends a text of CP/M and MS-DOS, with which XMODEM fills its last block.
_TAPE = b"\0\x11\x12\x13\x14\x1a"
#: Fillers of a tape: places without a hole, and those that were punched out, which readers pass over (from memory); and what stands
#: beside them in a text.
_FILLERS = b"\0\x7f"
_TEXT = bytes(range(32, 127)) + b"\t\n\v\f\r" + _TAPE


class Source:
    """The bytes of one file, mapped, not read; `name` is how diagnostics call it.

    Attributes:
        different: The result of `dialects.different`, once it was asked.
        main: That of `main_program.main_behind`, in a tuple.
        filled: Where in the text the first filler of a tape stood amid a line, and was left out; −1 for none.
    """

    def __init__(self, data: bytes | mmap.mmap, name: str) -> None:
        self.name = name
        self.data, self.filled = _with_newlines(data)
        self.bytes = memoryview(self.data)
        self.different: tuple[bytes, list[int], list[int]] | None = None
        self.main: tuple[tuple[Cursor, BlockError] | None] | None = None

    def __len__(self) -> int:
        return len(self.data)

    def line_end(self, offset: int) -> int:
        """Return the offset of the newline that ends the line at `offset`, or the text's length."""
        end = self.data.find(b"\n", offset)
        return len(self.data) if end < 0 else end

    def line_begin(self, offset: int) -> int:
        """Return where the line begins that the byte at `offset` ends or is of."""
        return self.data.rfind(b"\n", 0, offset) + 1

    def text_at(self, offset: int) -> str:
        """Return the line that begins at `offset` without its end, cut to `MAX_LINE` bytes."""
        end = self.data.find(b"\n", offset, offset + MAX_LINE + 1)
        stop = end if end >= 0 else min(len(self.data), offset + MAX_LINE)
        line = self.data[offset:stop]
        try:
            return line.decode("utf-8").rstrip("\r")
        except UnicodeDecodeError:
            # An editor of Western Windows wrote it (a superset of Latin-1).
            return line.decode("cp1252", "replace").rstrip("\r")

    def written(self, offset: int, line: int, column: int) -> tuple[str, int, int]:
        """Return the line that a place is in as the file has it, its number and the column there, of a column of the line at `offset`."""
        return self.text_at(offset), line, column

    def count_lines(self) -> int:
        """Return how many lines the text has."""
        blocks = range(0, len(self.data), _BLOCK)
        return sum(self.data[start : start + _BLOCK].count(b"\n") for start in blocks) + 1

    def is_binary(self) -> bool:
        """Tell whether the head of the text holds bytes that no program has (NUL)."""
        return b"\0" in self.data[:_HEAD]

    def is_wide(self) -> bool:
        """Tell whether each second byte of the head is NUL, as in UTF-16 without its mark."""
        head = self.data[:_HEAD]
        return not (head[::2].strip(b"\0") and head[1::2].strip(b"\0"))


def open_source(source: str | os.PathLike[str] | BinaryIO, name: str) -> Source:
    """Map a file, or spool a stream to a temporary file and map that.

    Raises:
        UsageError: Where the file cannot be read, or the stream does not end.
    """
    with reading_faults(name):
        if isinstance(source, str | os.PathLike):
            with open(source, "rb") as file:
                note_read(file)
                return Source(_mapped(file), name)
        import tempfile

        with _spool_faults(name), tempfile.TemporaryFile() as spool:
            _spool(source, spool, name)
            spool.flush()
            return Source(_mapped(spool), name)


@contextmanager
def _spool_faults(name: str) -> Iterator[None]:
    """Turn an OSError of the temporary file that keeps a stream into a `UsageError` that names the cause."""
    try:
        yield
    except OSError as error:
        import tempfile

        try:
            folder = tempfile.gettempdir()
        except FileNotFoundError:
            folder = "any folder for temporary files"
        what = STANDARD_INPUT if name == STANDARD else name
        found = file_fault(folder, "write", error).diagnostics[0]
        message = f"{found.message} ({what} is kept in a temporary file while it is read)"
        hint = "give the program as a file, or name another folder in the environment: TMPDIR"
        raise UsageError(replace(found, message=message, hint=hint)) from error


def _spool(source: BinaryIO, spool: BinaryIO, name: str) -> None:
    """Copy a stream, up to `MAX_STREAM` bytes; of a binary one only its head, which shows that."""
    block = _read(source, name)
    head = block[:_HEAD]
    if b"\0" in (head.strip(_TAPE) or head) and not is_wide(block) and not _is_filled(head):
        spool.write(block[:_HEAD])
        return
    while block:
        spool.write(block)
        if spool.tell() > MAX_STREAM:
            raise UsageError(
                Diagnostic("file-size", f"{name} is larger than {MAX_STREAM} bytes; does it end?")
            )
        block = _read(source, name)


def _read(source: BinaryIO, name: str) -> bytes:
    with reading_faults(name):
        return source.read(_BLOCK)


def _with_newlines(data: bytes | mmap.mmap) -> tuple[bytes | mmap.mmap, int]:
    """Return a text of UTF-16 in UTF-8, without marks or what leads, fills and trails a tape, and with newlines where CR alone ends its lines;
    with `Source.filled`.
    """
    filled = -1
    if is_wide(data[:WIDE_MARK]):
        data = as_utf8(data[:])
    elif data[:1] + data[-1:] and (data[:1] in _TAPE or data[-1:] in _TAPE):
        text = data[:].strip(_TAPE)
        data = text if text[:1] not in (b"", b"\x7f") else data
    if _is_filled(data[:_HEAD]):
        filled = _amid_a_line(data[:])
        data = data[:].translate(None, _FILLERS)
    if data[: len(codecs.BOM_UTF8)] == codecs.BOM_UTF8:
        data = data[len(codecs.BOM_UTF8) :]
    if b"\r" in data[:_HEAD] and data.find(b"\n") < 0:
        data = data[:].replace(b"\r", b"\n")
    return data, filled


def _is_filled(head: bytes) -> bool:
    """Tell whether fillers of a tape stand in a text of ASCII; of a code of two or four bytes, they are half of it and more."""
    rest = head.translate(None, _FILLERS)
    return 3 * len(head) < 5 * len(rest) < 5 * len(head) and not rest.translate(None, _TEXT)


def _amid_a_line(data: bytes) -> int:
    """Return where in a text without its fillers the first one is missing that stood amid a line, −1 for none."""
    begin = 0
    for line in data.split(b"\n"):
        text = line.strip(_FILLERS + b" \t\r")
        left = text.translate(None, _FILLERS)
        if left != text:
            first = min(at for at in map(text.find, (b"\0", b"\x7f")) if at >= 0)
            return begin + line.translate(None, _FILLERS).find(left) + first
        begin += len(line.translate(None, _FILLERS)) + 1
    return -1


def _mapped(file: BinaryIO) -> bytes | mmap.mmap:
    """Map an open file, or read it where it cannot be mapped (empty, a pipe)."""
    try:
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except (ValueError, OSError):
        file.seek(0) if file.seekable() else None
        return file.read()
