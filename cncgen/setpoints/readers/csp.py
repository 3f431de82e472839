"""csp: CiA 402 cyclic synchronous position as CSV, whose first line describes axes, period and scaling."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.machine.drives import drive_faults, drive_of
from cncgen.machine.record import Drive
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.drive_units import frame_type, positions
from cncgen.setpoints.readers.blocks import FileBlock, warn_of_end
from cncgen.setpoints.readers.f64 import check_rows
from cncgen.setpoints.readers.tables import stated_period
from cncgen.units import AXIS_LETTERS

#: Bytes read at a time, and of the first line at most.
_BYTES = 1 << 22


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a file, positions in mm and degrees.

    Raises:
        UsageError: The first line does not describe the columns, or a row holds something else than integers.
    """
    with reading_faults(name):
        head = file.readline(_BYTES)
        letters, drives, period = described(head.lstrip(b"# "), name)
        wanted = ["t_s", *(frame_type(letters).names or ())]
        names = file.readline(_BYTES).decode("utf-8", "replace").strip().split(",")
    if names != wanted:
        message = f"{name}: the columns are {','.join(names)[:200]}; they are to be {','.join(wanted)}"
        raise UsageError(Diagnostic("setpoints-header", message))
    row = 0
    while True:
        with reading_faults(name):
            lines = file.readlines(_BYTES)
        if not lines:
            return
        warn_of_end(lines[-1], name)
        matrix = _numbers(lines, len(wanted), name, row)
        row += len(matrix)
        frames = dict(zip(wanted, matrix.T, strict=True))
        rows = file_units(positions(frames, letters, drives), letters)
        yield FileBlock(letters, matrix[:, 0].copy(), rows, period)


def _numbers(lines: list[bytes], columns: int, name: str, row: int) -> np.ndarray:
    try:
        matrix = np.loadtxt(io.BytesIO(b"".join(lines)), delimiter=",", ndmin=2, comments=None)
        if matrix.shape[1] != columns:
            raise ValueError(f"{matrix.shape[1]} columns instead of {columns}")
    except (ValueError, UnicodeDecodeError) as error:
        message = f"{name}, rows {row + 1} and on: {error}"
        raise UsageError(Diagnostic("setpoints-number", message)) from error
    check_rows(matrix, name, row)
    return matrix


def described(text: bytes, name: str) -> tuple[str, Mapping[str, Drive], float | None]:
    """Return axes, drives and period of a description.

    Raises:
        UsageError: It is none.
    """
    try:
        about: Any = json.loads(text)
        letters, tables = str(about["axes"]), dict(about["drives"])
        faults = [
            f"axis {axis}, {key}: {message}"
            for axis in letters
            for _, key, message, _ in drive_faults(dict(tables[axis]), axis)
        ]
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        message = f"{name}: its description of axes and drives cannot be read: {error!r}"
        raise UsageError(Diagnostic("setpoints-header", message)) from error
    if not letters or not set(letters) <= set(AXIS_LETTERS) or len(set(letters)) != len(letters):
        faults.append(f"axes {letters!r}; they are letters of {AXIS_LETTERS}, each once")
    if faults:
        raise UsageError([Diagnostic("setpoints-header", f"{name}: {fault}") for fault in faults])
    return letters, {a: drive_of(tables[a], a) for a in letters}, stated_period(about.get("period_s"))
