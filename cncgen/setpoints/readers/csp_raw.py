"""csp-raw: packed frames of CiA 402 objects behind a description (`cncgen.setpoints.writers.csp_raw`)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.drive_units import frame_type, positions
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.csp import described
from cncgen.setpoints.readers.f64 import ROWS

#: Longest description, bytes.
_MAX_TEXT = 1 << 22


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the frames of a file, positions in mm and degrees.

    Raises:
        UsageError: The description cannot be read or states no period, or the file ends within a frame.
    """
    with reading_faults(name):
        head = file.read(8)
        size = struct.unpack("<I", head[4:])[0] if len(head) == 8 else 0
        text = file.read(size) if size <= _MAX_TEXT else b""
    if len(text) != size or not size:
        raise UsageError(Diagnostic("setpoints-header", f"{name}: its description is cut off or missing"))
    letters, drives, period = described(text, name)
    if period is None:
        raise UsageError(Diagnostic("setpoints-period", f"{name}: its description states no period"))
    kind, row = frame_type(letters), 0
    while True:
        with reading_faults(name):
            data = file.read(kind.itemsize * ROWS)
        if not data:
            return
        if len(data) % kind.itemsize:
            message = f"{name}: ends within a frame of {kind.itemsize} bytes"
            raise UsageError(Diagnostic("setpoints-columns", message))
        frames = np.frombuffer(data, kind)
        times = np.asarray((row + np.arange(len(frames))) * period, np.float64)
        row += len(frames)
        columns = {n: frames[n] for n in kind.names or ()}
        yield FileBlock(letters, times, file_units(positions(columns, letters, drives), letters), period)
