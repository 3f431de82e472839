"""Sinks for setpoints, one file a format; each is imported when it is used.

A format's module has a class `Writer(sink, layout)` with `write(chunk)` and `close()`.
"""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Protocol

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.extensions import (
    FORMAT_GROUP,
    FORMATS,
    SUFFIXES,
    foreign_module,
    foreign_names,
    is_format,
    part_of,
    unknown_format,
)
from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.record import Setpoints


class Writer(Protocol):
    """The interface of every format."""

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""

    def close(self) -> None:
        """Write the data after the last row."""


def format_of(path: str | os.PathLike[str] | None, asked: str | None = None) -> str:
    """Return the format that is asked for, else that of the suffix, else ``csv`` for a name without suffix.

    Raises:
        UsageError: The suffix belongs to no format.
    """
    if asked:
        return asked
    suffix = suffix_of(path)
    if suffix is None:
        return "csv"
    kind = SUFFIXES.get(suffix, suffix)
    if not is_format(kind):
        known = ", ".join(f".{name}" for name in (*FORMATS, *SUFFIXES, *foreign_names(FORMAT_GROUP)))
        message = f"{os.fspath(path or '')}: no format of setpoints has the suffix .{suffix}"
        hint = f"use one of {known}, or name the format with --format"
        raise UsageError(Diagnostic("setpoint-format", message, hint=hint))
    return kind


def suffix_of(path: str | os.PathLike[str] | None) -> str | None:
    """Return the suffix of a file's name in lower case without its dot; None for devices, pipes and bare names."""
    if not path or os.fspath(path).startswith("/dev/"):
        return None
    return Path(path).suffix.lower().lstrip(".") or None


def open_writer(name: str, sink: Sink, layout: Layout) -> Writer:
    """Return the writer of a format.

    Raises:
        UsageError: The format is unknown, needs a package that is missing, or data that the machine lacks.
    """
    if not is_format(name):
        raise UsageError(Diagnostic("option-value", unknown_format(name)))
    if name in FORMATS:
        module = importlib.import_module(f"cncgen.setpoints.writers.{name.replace('-', '_')}")
    else:
        module = foreign_module(FORMAT_GROUP, name)
        part_of(module, "Writer", f"write {name}")
    writer: Writer = module.Writer(sink, layout)
    return writer
