"""mcap: the points of ROS 2 `JointTrajectory` messages, whose joints are named after the axes (needs mcap)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.joint_trajectory import TYPE, decode, from_metres
from cncgen.setpoints.packages import needed
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.f64 import check_rows
from cncgen.setpoints.readers.tables import SizedFile
from cncgen.units import AXIS_LETTERS

#: Largest chunk that is unpacked, bytes; writers make chunks of some MiB.
MOST_UNPACKED = 256 * 1024**2


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the points of a file, a block a message, in the order of their times.

    Raises:
        UsageError: mcap is missing, or the file has no readable trajectory of axes.
    """
    exceptions: Any = needed("mcap", "mcap.exceptions")
    reading: Any = needed("mcap", "mcap.reader")
    compressed: Any = needed("mcap", "zstandard")
    # RuntimeError is what lz4 raises of damaged data; of channels and schemas that are missing, and of chunks that claim more
    # than there is memory, mcap raises what Python does.
    faults = (
        exceptions.McapError,
        compressed.ZstdError,
        RuntimeError,
        ValueError,
        struct.error,
        EOFError,
        OverflowError,
        LookupError,
        MemoryError,
    )
    try:
        with reading_faults(name):
            whole = SizedFile(file)
            _check_chunks(whole)
            whole.seek(0)
            # CRCs tell a damaged file.
            yield from _messages(reading.make_reader(whole, validate_crcs=True), name)
    except faults as error:
        raise UsageError(Diagnostic("setpoints-header", f"{name} is not an MCAP file: {error}")) from error


def _check_chunks(whole: SizedFile) -> None:
    """Look through a file for chunks that few bytes make huge, before the library unpacks them at once.

    Raises:
        ValueError: There is one.
    """
    streaming: Any = needed("mcap", "mcap.stream_reader")
    records: Any = needed("mcap", "mcap.records")
    for record in streaming.StreamReader(whole, emit_chunks=True, record_size_limit=MOST_UNPACKED).records:
        if isinstance(record, records.Chunk):
            size = max(record.uncompressed_size, _unpacked_size(record.compression, record.data))
            if size > MOST_UNPACKED:
                raise ValueError(f"a chunk of it unpacks to more than {MOST_UNPACKED >> 20} MiB")


def _unpacked_size(compression: str, data: bytes) -> int:
    """Return how many bytes a chunk makes, counted no further than beyond `MOST_UNPACKED`."""
    if compression == "zstd":
        size: int = needed("mcap", "zstandard").frame_content_size(data)
        return size  # below 0 where the frame does not say it: then the library goes by the size that the chunk claims
    if compression == "lz4":
        unpacking: Any = needed("mcap", "lz4.frame").LZ4FrameDecompressor()
        return len(unpacking.decompress(data, max_length=MOST_UNPACKED + 1))
    return len(data)


def _messages(reader: Any, name: str) -> Iterator[FileBlock]:
    row, letters = 0, ""
    for schema, channel, message in reader.iter_messages():
        if schema is None or schema.name != TYPE or channel.message_encoding != "cdr":
            continue
        joints, times, rows = decode(message.data)
        found = "".join(joint.upper() for joint in joints)
        if len(found) != len(joints) or not set(found) <= set(AXIS_LETTERS) or len(set(found)) != len(found):
            told = f"{name}: joints {', '.join(joints)}; each is to be named after an axis ({AXIS_LETTERS})"
            raise UsageError(Diagnostic("setpoints-axes", told))
        if letters and found != letters:
            told = f"{name}: a message has axes {found}, the one before it {letters}"
            raise UsageError(Diagnostic("setpoints-axes", told))
        letters = found
        check_rows(np.column_stack([times, rows]), name, row)
        row += len(rows)
        yield FileBlock(letters, times / 1e9, file_units(from_metres(rows, letters), letters))
    if not letters:
        raise UsageError(Diagnostic("setpoints-header", f"{name}: it has no messages of {TYPE}"))
