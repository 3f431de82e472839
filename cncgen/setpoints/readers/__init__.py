"""Setpoint files of any origin, read as a stream: in every format that `cncgen plan` writes.

`open_setpoints` finds out the format, the axes and the period, and gives the rows chunk by chunk. A faulty
file raises `UsageError` with a diagnostic for each faulty row.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.extensions import (
    FORMAT_GROUP,
    FORMATS,
    SUFFIXES,
    foreign_module,
    is_format,
    part_of,
    unknown_format,
)
from cncgen.files import STANDARD, STANDARD_INPUT, open_input, peeked
from cncgen.setpoints.readers.blocks import FileBlock, only, stream_of
from cncgen.setpoints.stream import SetpointStream

__all__ = ["SetpointStream", "open_setpoints"]

#: First bytes of the formats that have a signature.
_SIGNATURES = (
    (b"\x93NUMPY", "npy"),
    (b"PK\x03\x04", "npz"),
    (b"ARROW1", "arrow"),
    (b"PAR1", "parquet"),
    (b"\x89HDF\r\n\x1a\n", "hdf5"),
    (b"\x89MCAP0\r\n", "mcap"),
    (b"MATLAB 5", "mat"),
    (b"MDF     ", "mf4"),
    (b"CSP1", "csp-raw"),
    (b'# {"form', "csp"),
    (b"{", "jsonl"),
)


@contextmanager
def open_setpoints(
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    axes: str | None = None,
    unnamed_axes: str | None = None,
    period_s: float | None = None,
    default_period_s: float | None = None,
) -> Iterator[SetpointStream]:
    """Open a setpoint file, or standard input for ``-``, for the length of a with block.

    Args:
        path: The file.
        format: One of the formats of `cncgen plan`; None: by the file's first bytes and its suffix, else csv.
        axes: Letters of the wanted columns of a file that names its columns; letters of all columns of a file that does
            not (npy and f64: columns after the time; hal: all columns). None: all.
        unnamed_axes: The axes where neither the file nor `axes` names them.
        period_s: Time between rows; None: as the file's times say. Needed for hal that does not state it.
        default_period_s: The period of a file that has a single row and does not state it.

    Raises:
        UsageError: The file cannot be read, is not a setpoint file of that format, or lacks an axis that is wanted.
    """
    name = os.fspath(path)
    with open_input(path) as file:
        head = peeked(file, 8, name)
        kind = format or _format_of(name, head)
        if not is_format(kind):
            raise UsageError(Diagnostic("option-value", unknown_format(kind)))
        if kind in FORMATS:
            module = importlib.import_module(f"cncgen.setpoints.readers.{kind.replace('-', '_')}")
        else:
            module = foreign_module(FORMAT_GROUP, kind)
            part_of(module, "blocks", f"read {kind}")
        if name == STANDARD:
            name = STANDARD_INPUT
        blocks: Iterator[FileBlock] = module.blocks(file, name, axes or unnamed_axes or None, period_s)
        stream = stream_of(blocks, name, period_s, default_period_s)
        yield only(stream, axes.upper()) if axes else stream


def _format_of(name: str, head: bytes) -> str:
    for signature, kind in _SIGNATURES:
        if head.startswith(signature):
            return kind
    suffix = os.path.splitext(name)[1].lower().lstrip(".")
    kind = SUFFIXES.get(suffix, suffix)
    return kind if kind and is_format(kind) else "csv"


def letters_or_fault(axes: Sequence[str] | None, name: str, kind: str) -> str:
    """Return the axes given for a format without names, or raise `UsageError`."""
    if not axes:
        raise UsageError(
            Diagnostic("setpoints-axes", f"{name}: {kind} does not name its axes", hint="say --axes XYZ")
        )
    return "".join(axes).upper()
