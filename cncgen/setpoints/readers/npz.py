"""npz: an array a column under the names of the CSV's columns."""

from __future__ import annotations

import math
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from tokenize import TokenError
from typing import IO, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers.blocks import Block, warn_of_columns
from cncgen.setpoints.readers.f64 import check_rows

#: What zipfile and numpy raise of a damaged archive: RuntimeError of one that is encrypted (NotImplementedError of a
#: method they do not know), MemoryError of an array whose header says more than there can be.
_FAULTS = (
    ValueError,
    TypeError,
    EOFError,
    KeyError,
    RuntimeError,
    MemoryError,
    SyntaxError,
    TokenError,
    zipfile.BadZipFile,
    zlib.error,
)


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[Block]:
    """Yield the rows of an npz file in one block.

    Raises:
        UsageError: It is no npz archive, lacks ``t_s`` or a position, columns differ in length, or one is
            an axis in another unit.
    """
    try:
        with reading_faults(name), np.load(_seekable(file), allow_pickle=False) as archive:
            names = [n for n in POSITION_COLUMNS if n in archive.files]
            if "t_s" not in archive.files or not names:
                message = f"{name} is no setpoint file: it has no array t_s, or none of an axis position"
                raise UsageError(Diagnostic("setpoints-header", message))
            warn_of_columns([*map(str.lower, archive.files)], name)
            columns = [np.asarray(archive[n], np.float64) for n in ("t_s", *names)]
            stated = float(archive["period_s"]) if "period_s" in archive.files else math.nan
    except _FAULTS as error:
        # What is no archive is taken for a pickle, whose message is about trust.
        why = "" if "pickle" in str(error) else f": {error}"
        raise UsageError(Diagnostic("setpoints-header", f"{name} is no npz file{why}")) from error
    if len({column.shape for column in columns}) != 1 or columns[0].ndim != 1:
        shapes = ", ".join(f"{n} {c.shape}" for n, c in zip(("t_s", *names), columns, strict=True))
        raise UsageError(Diagnostic("setpoints-columns", f"{name}: columns differ in shape: {shapes}"))
    matrix = np.stack(columns, axis=1)
    check_rows(matrix, name, 0)
    period = stated if 0.0 < stated < math.inf else None
    letters = "".join(POSITION_COLUMNS[n] for n in names)
    yield Block(letters, matrix[:, 0].copy(), matrix[:, 1:], period)


def _seekable(file: BinaryIO) -> IO[bytes]:
    """Return a file that can be gone back in, as an archive needs: what comes through a pipe waits in a temporary one."""
    if file.seekable():
        return file
    copy = tempfile.TemporaryFile()  # noqa: SIM115 - removed when the archive lets go of it
    shutil.copyfileobj(file, copy, 1 << 20)
    copy.seek(0)
    return copy
