"""mf4: a sorted group of an ASAM MDF 4 file, its channels named as the CSV's columns, its master channel the time.

Files are read here and not by the library that writes them, whose reader is made for files that are trusted.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.mf4_blocks import HEADER, Channel, MdfFile, channel_of
from cncgen.setpoints.readers.tables import seekable, sliced


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of the first group with positions.

    Raises:
        UsageError: It is not a finished MDF 4 file with positions in a sorted group.
    """
    with reading_faults(name):
        try:
            columns = _columns(MdfFile(seekable(file)))
        except (ValueError, struct.error, zlib.error) as error:
            raise UsageError(
                Diagnostic("setpoints-header", f"{name} is not an MDF 4 file: {error}")
            ) from error
    lengths = [len(column) for column in columns.values()]
    yield from sliced([*columns], lengths, lambda key, where: columns[key][where], name, None)


def _columns(file: MdfFile) -> dict[str, NDArray[np.float64]]:
    """Return time and positions of the first group that has both, {} where no group has."""
    for group in file.chain(file.block(HEADER, "HD").link(0), "DG"):
        for channels in file.chain(group.link(1), "CG"):
            _, cycles, _, _, _, size, invalid = channels.numbers("QQHHIII")
            found = [channel_of(file, block) for block in file.chain(channels.link(1), "CN")]
            wanted = [c for c in found if c and (c.master or c.name in POSITION_COLUMNS)]
            if any(c.master for c in wanted) and not all(c.master for c in wanted):
                if group.numbers("B")[0]:
                    raise ValueError("the records of its groups are mixed (unsorted)")
                return _table(file.records(group.link(2)), cycles, size + invalid, wanted)
    return {}


def _table(
    data: bytes, cycles: int, size: int, channels: Sequence[Channel]
) -> dict[str, NDArray[np.float64]]:
    """Return the columns of records of `size` bytes."""
    if not size or len(data) < cycles * size:
        raise ValueError(f"{len(data)} bytes hold no {cycles} records of {size}")
    columns = {}
    for channel in channels:
        kind = np.dtype(channel.kind)
        if channel.offset + kind.itemsize > size:
            raise ValueError(f"channel {channel.name} lies outside of its record")
        record = np.dtype({"names": ["v"], "formats": [kind], "offsets": [channel.offset], "itemsize": size})
        values = np.frombuffer(data, record, cycles)["v"].astype(np.float64)
        if (channel.first, channel.factor) != (0.0, 1.0):
            values = channel.first + channel.factor * values
        columns["t_s" if channel.master else channel.name] = values
    return columns
