"""hdf5: data sets of one dimension under the names of the CSV's columns, read some rows at a time (needs h5py)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

from cncgen.setpoints.packages import needed
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.isolated import FileColumns, isolated_blocks
from cncgen.setpoints.readers.tables import stated_period


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of an HDF5 file.

    Raises:
        UsageError: h5py is missing, or it is not an HDF5 file with ``t_s`` and positions.
    """
    needed("hdf5")
    yield from isolated_blocks(file, name, "hdf5")


def columns(path: str) -> FileColumns:
    """Open a file: its data sets of plain numbers in one dimension that lie in the file itself."""
    h5py: Any = needed("hdf5")
    # The library opens no file that has lost its name, as a copy of a pipe has.
    tables = h5py.File(open(path, "rb"), "r")  # noqa: SIM115 - closed with the process
    found = {
        key: item
        for key in tables
        # A link to another file would be read from outside of this one.
        if isinstance(tables.get(key, getlink=True), h5py.HardLink)
        and isinstance(item := tables[key], h5py.Dataset)
        and item.ndim == 1
        and item.dtype.kind in "fiu"
        and not item.external
        and not item.is_virtual
    }
    lengths = {key: int(item.shape[0]) for key, item in found.items()}
    period = stated_period(tables.attrs.get("period_s"))
    return FileColumns(lengths, period, lambda key, where: found[key][where])
