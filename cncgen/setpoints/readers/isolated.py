"""Columns of a file by a library in C that is made for files one trusts: it runs in a process of its own.

A damaged file may end or stall such a library. The process has bounded memory and time, and its end is a fault of the file.
The two speak over pipes: the process sends the columns of the file as a line of JSON, is sent the wanted ones, and
sends their rows as raw doubles, `ROWS` at a time, each part behind its number of rows.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import resource
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import IO, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.f64 import ROWS
from cncgen.setpoints.readers.tables import block_of, columns_of, seekable, stated_period

#: Address space of the process, bytes.
MAX_MEMORY = 8 << 30
#: Processor time of the process: s, and s a MB of the file.
_SECONDS, _SECONDS_A_MB = 20, 1
_COUNT = struct.Struct("<I")


@dataclass(frozen=True, slots=True)
class FileColumns:
    """Columns of an open file.

    Attributes:
        lengths: Rows by name, of those that hold plain numbers.
        period_s: Period that the file states, or None.
        part: Returns some rows of a column.
    """

    lengths: dict[str, int]
    period_s: float | None
    part: Callable[[str, slice], NDArray]


def isolated_blocks(file: BinaryIO, name: str, kind: str) -> Iterator[FileBlock]:
    """Yield the rows of a file that the module `kind` of this package reads by its function ``columns(path)``.

    Raises:
        UsageError: The file has no setpoints, or the library cannot read it.
    """
    with (
        reading_faults(name),
        seekable(file) as source,
        # The handle of standard input is another file in the process.
        os.fdopen(os.dup(source.fileno()), "rb") as own,
        started(kind, own.fileno()) as (asks, tells),
    ):
        yield from _received(asks, tells, name, kind)


@contextlib.contextmanager
def started(kind: str, handle: int) -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    """Start the process for an open file; give its request and reply streams, and end it afterwards."""
    with subprocess.Popen(
        [sys.executable, "-m", __name__, kind, f"/dev/fd/{handle}"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        pass_fds=[handle],
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            yield process.stdin, process.stdout
        finally:
            process.kill()


def _received(asks: IO[bytes], tells: IO[bytes], name: str, kind: str) -> Iterator[FileBlock]:
    line = tells.readline()
    if not line.endswith(b"\n"):
        raise _ended(name, kind)
    about = json.loads(line)
    if "fault" in about:
        raise UsageError(Diagnostic("setpoints-header", f"{name} cannot be read as {kind}: {about['fault']}"))
    found, period = columns_of(list(about["lengths"]), name), stated_period(about["period_s"])
    wanted = {n: about["lengths"][n] for n in ("t_s", *found)}
    if len(set(wanted.values())) != 1:
        told = ", ".join(f"{n} has {count}" for n, count in wanted.items())
        raise UsageError(Diagnostic("setpoints-columns", f"{name}: numbers of rows differ: {told}"))
    asks.write(json.dumps(list(wanted)).encode() + b"\n")
    asks.flush()
    row, columns = 0, len(wanted)
    while row < wanted["t_s"]:
        head = tells.read(_COUNT.size)
        count = _COUNT.unpack(head)[0] if len(head) == _COUNT.size else 0
        data = tells.read(8 * count * columns)
        if not count or len(data) < 8 * count * columns:
            raise _ended(name, kind)
        matrix = np.frombuffer(data, np.float64).reshape(columns, count).T
        yield block_of(matrix, found, name, row, period)
        row += count


def _ended(name: str, kind: str) -> UsageError:
    message = f"{name} is not a sound {kind} file: its reader ended before the rows did"
    return UsageError(Diagnostic("setpoints-header", message))


def serve(kind: str, path: str, asked_by: IO[bytes], out: IO[bytes]) -> None:
    """Read a file in this process, which is bounded, and send the requested columns, or the fault."""
    seconds = _SECONDS + _SECONDS_A_MB * os.path.getsize(path) // 1_000_000
    for what, bound in ((resource.RLIMIT_AS, MAX_MEMORY), (resource.RLIMIT_CPU, seconds)):
        resource.setrlimit(what, (bound, bound))
    try:
        found: FileColumns = importlib.import_module(f"cncgen.setpoints.readers.{kind}").columns(path)
    except Exception as error:  # whatever a library raises for a damaged file
        out.write(
            json.dumps({"fault": " ".join(str(error).split())[:300] or type(error).__name__}).encode() + b"\n"
        )
        out.flush()
        return
    out.write(json.dumps({"lengths": found.lengths, "period_s": found.period_s}).encode() + b"\n")
    out.flush()
    asked = json.loads(asked_by.readline() or b"[]")
    for first in range(0, found.lengths[asked[0]] if asked else 0, ROWS):
        where = slice(first, first + ROWS)
        rows = np.stack([np.asarray(found.part(n, where), np.float64) for n in asked])
        out.write(_COUNT.pack(rows.shape[1]) + rows.tobytes())
    out.flush()


if __name__ == "__main__":
    serve(sys.argv[1], sys.argv[2], sys.stdin.buffer, sys.stdout.buffer)
