"""A file as columns: one row a statement, found by the kernel, sections told apart, nothing parsed."""

from __future__ import annotations

import codecs
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import part21_scan as scan
from cncgen.stepnc.reporting import Reporter

Ints = NDArray[np.int64]

#: Strings or comments without an end after which the split begins again on the next line.
MAX_RESTARTS = 20
_ROOM = 1 << 16
#: Bytes that may follow the last statement: blanks, the end of a file of DOS, the padding of a tape.
_END_MARKS = b"\x1a\0 \t\r\n"


@dataclass(frozen=True, slots=True)
class Statements:
    """The statements of a file, `n` rows in its order.

    Attributes:
        ids: Shape (n,), the number of ``#id``, −1 elsewhere.
        starts, bodies, ends: Shape (n,), offsets: of the statement, of what follows ``#id =``, of the semicolon.
        types: Shape (n,), `keyword_hash` of the body's keyword, 0 without one.
        flags: Shape (n,), bits of `cncgen.kernels.part21_scan`.
    """

    ids: Ints
    starts: Ints
    bodies: Ints
    ends: Ints
    types: Ints
    flags: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.ids)


def split(data: bytes) -> Statements:
    """Find all statements, behind a byte order mark and before the marks that DOS and tapes have at the end.

    After a string or comment without an end the next line is where it goes on.
    """
    end = len(data.rstrip(_END_MARKS))
    buffer = np.frombuffer(data, np.uint8, end)
    columns: list[list[np.ndarray]] = [[] for _ in range(6)]
    position = len(codecs.BOM_UTF8) if data.startswith(codecs.BOM_UTF8) else 0
    restarts = 0
    while position < end:
        chunk: list[np.ndarray] = [np.empty(_ROOM, np.int64) for _ in range(5)]
        chunk.append(np.empty(_ROOM, np.int32))
        found, position = scan.split(buffer, position, *chunk)
        for column, array in zip(columns, chunk, strict=True):
            column.append(array[:found].copy() if found < _ROOM else array)
        if found and columns[5][-1][-1] & scan.UNTERMINATED and restarts < MAX_RESTARTS:
            restarts += 1
            end_of_line = data.find(b"\n", int(columns[1][-1][-1]))
            position = end if end_of_line < 0 else end_of_line + 1
            # The statement ends where the next one may begin: none overlaps another.
            for offsets in (columns[2], columns[3]):
                offsets[-1][-1] = min(int(offsets[-1][-1]), position)
        elif not found:
            break
    joined = [np.concatenate(c) if c else np.empty(0, np.int64) for c in columns]
    ids, starts, bodies, ends, types = joined[:5]
    return Statements(ids, starts, bodies, ends, types, joined[5].astype(np.int32))


def report_faults(data: bytes, rows: Statements, reporter: Reporter) -> None:
    """Report what the split found: strings, comments and statements without an end, missing semicolons, big ids."""
    for row in np.flatnonzero(rows.flags & ~scan.HAS_COMMENT):
        start, flags = int(rows.starts[row]), int(rows.flags[row])
        name = f"#{rows.ids[row]}" if rows.ids[row] >= 0 else "this statement"
        if flags & scan.UNTERMINATED:
            _report_unterminated(data, rows, int(row), reporter)
        elif flags & scan.NO_SEMICOLON:
            reporter.report(
                "part21-semicolon", f"{name} does not end with a semicolon before #", int(rows.ends[row])
            )
        elif flags & scan.NO_EQUALS:
            reporter.report("part21-syntax", f"{name} is not followed by '='", start)
        elif flags & scan.BIG_ID:
            reporter.report("part21-syntax", "an instance name has more than 18 digits", start)


def _report_unterminated(data: bytes, rows: Statements, row: int, reporter: Reporter) -> None:
    start = int(rows.starts[row])
    text = data[start : start + 4000]
    opened = text.find(b"/*")
    if text.startswith(b"/*") or (opened >= 0 and b"*/" not in text[opened:] and b"'" not in text[:opened]):
        reporter.report("part21-comment", "a comment is not closed by */", start + max(opened, 0))
    elif text.count(b"'") % 2:
        where = start + text.find(b"'")
        reporter.report("part21-string", "a string is not closed by an apostrophe", where)
    else:
        message = "the file ends within a statement: a semicolon is missing, or the file is cut off"
        reporter.report("part21-truncated", message, start)
