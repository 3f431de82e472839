"""npy: one array of doubles, shape (rows, columns): time, then the axes."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from tokenize import TokenError
from types import SimpleNamespace
from typing import IO, Any, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.readers import letters_or_fault
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.f64 import matrices

#: Columns of a table, and bytes that are read of its header at a time.
MAX_COLUMNS, _PIECE = 10_000, 65_536


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of an npy file, whose columns after the time are those of `axes` (and signals after them).

    Raises:
        UsageError: `axes` is missing, the array is not a table of doubles with as many columns, or the file ends early.
    """
    letters = letters_or_fault(axes, name, "npy")
    shape = table_shape(file, name)
    if shape[1] < 1 + len(letters):
        message = f"{name}: the array has {shape[1]} columns, the time and {len(letters)} axes need more"
        raise UsageError(Diagnostic("setpoints-columns", message))
    rows = 0
    for matrix in matrices(file, name, shape[1]):
        rows += len(matrix)
        yield FileBlock(letters, matrix[:, 0].copy(), matrix[:, 1 : 1 + len(letters)])
    if rows != shape[0]:
        message = f"{name} has {rows} rows, and its header says {shape[0]}: it is cut off or damaged"
        raise UsageError(Diagnostic("setpoints-length", message))


def reason(error: Exception) -> str:
    """Return numpy's message about a header, without nodes of Python's syntax."""
    return re.sub(r":? <ast\.\w+ object at 0x[0-9a-f]+>", "", str(error))


def array_header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Read the header of an npy file: shape, whether it is in Fortran's order, kind of numbers.

    Raises:
        ValueError, TypeError, EOFError, SyntaxError, TokenError: It is none.
    """
    # It may claim 4 GB of itself, for which room would be made before they are read.
    start: Any = SimpleNamespace(read=lambda count: file.read(min(count, _PIECE)))
    version = np.lib.format.read_magic(start)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    return read(start)


def table_shape(file: BinaryIO, name: str) -> tuple[int, int]:
    """Read the header of an npy file of little-endian doubles in C order with two dimensions; return its shape."""
    try:
        with reading_faults(name), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a header as Python 2 wrote it
            shape, fortran, dtype = array_header(file)
    except (ValueError, TypeError, EOFError, SyntaxError, TokenError) as error:
        raise UsageError(
            Diagnostic("setpoints-header", f"{name} is not an npy file: {reason(error)}")
        ) from error
    if len(shape) != 2 or shape[1] > MAX_COLUMNS or fortran or dtype != np.dtype("<f8"):
        message = f"{name}: an array of {dtype} with shape {shape}; a table of float64 in C order is wanted"
        raise UsageError(Diagnostic("setpoints-header", message))
    return shape[0], shape[1]
