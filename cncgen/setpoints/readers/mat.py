"""mat: vectors of a MATLAB 5 file under the names of the CSV's columns, read by scipy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.isolated import FileColumns, isolated_blocks
from cncgen.setpoints.readers.tables import stated_period
from cncgen.setpoints.writers.mat import COLUMNS

#: Values of a column: 2 GiB of doubles, the most that the format holds.
MAX_VALUES = 2**28
#: Kinds of variables that hold plain numbers.
_NUMBERS = ("double", "single", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64")


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a MATLAB file.

    Raises:
        UsageError: It is not a MATLAB 5 file with ``t_s`` and positions (version 7.3 is HDF5).
    """
    yield from isolated_blocks(file, name, "mat")


def columns(path: str) -> FileColumns:
    """Open a file: its vectors of plain numbers. A column is loaded whole, when a part of it is asked for first."""
    from scipy.io import loadmat, whosmat

    lengths = {
        key: max(shape)
        for key, shape, kind in whosmat(path)
        if kind in _NUMBERS and len(shape) == 2 and 1 in shape and max(shape) <= MAX_VALUES
    }
    named = loadmat(path, variable_names=[COLUMNS]).get(COLUMNS)
    missing = set(str(named[0]).split(",")) - set(lengths) if named is not None else set()
    if missing:
        raise ValueError(f"it is cut off before {', '.join(sorted(missing))}")
    loaded: dict[str, np.ndarray] = {}

    def part(key: str, where: slice) -> np.ndarray:
        if key not in loaded:
            loaded[key] = np.asarray(loadmat(path, variable_names=[key])[key]).ravel()
        return loaded[key][where]

    period = stated_period(part("period_s", slice(1))[0]) if lengths.get("period_s") == 1 else None
    return FileColumns(lengths, period, part)
