"""Sinks for setpoints, one file a format; each is imported when it is used.

A format's module has a class `Writer(sink, layout)` with `write(chunk)` and `close()`.
"""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Protocol

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.record import Setpoints

#: Formats in the order that messages name them.
FORMATS = ("csv", "jsonl", "npy", "npz", "f64", "hal", "arrow")
#: Formats that a terminal is never sent.
BINARY = ("npy", "npz", "f64", "arrow")


class Writer(Protocol):
    """What every format offers."""

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""

    def close(self) -> None:
        """Write what comes after the last row."""


def format_of(path: str | os.PathLike[str] | None, asked: str | None = None) -> str:
    """Return the format that is asked for, else that of the suffix, else ``csv``."""
    if asked:
        return asked
    suffix = Path(path).suffix.lower().lstrip(".") if path else ""
    return suffix if suffix in FORMATS else "csv"


def open_writer(name: str, sink: Sink, layout: Layout) -> Writer:
    """Return the writer of a format.

    Raises:
        UsageError: The format is unknown.
    """
    if name not in FORMATS:
        raise UsageError(Diagnostic("option-value", f"format {name!r} is not one of {', '.join(FORMATS)}"))
    module = importlib.import_module(f"cncgen.setpoints.writers.{name}")
    writer: Writer = module.Writer(sink, layout)
    return writer
