"""Writing setpoints to a file or standard output, for the commands that make them."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING

from cncgen.extensions import FORMATS, SUFFIXES, is_binary
from cncgen.setpoints.record import Setpoints

if TYPE_CHECKING:
    from cncgen.machine import Machine


def setpoint_format(output: str | None, asked: str | None) -> str:
    """Return the format that setpoints are written in: the requested one, else that of the suffix, else csv.

    Raises:
        UsageError: Binary output would go to a terminal, which is named as the output; the format needs a package that is missing.
    """
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.files import STANDARD, is_terminal
    from cncgen.setpoints.packages import check_installed
    from cncgen.setpoints.writers import format_of

    kind = format_of(output, asked)
    check_installed(kind)
    if output == STANDARD and is_terminal(sys.stdout) and is_binary(kind):
        raise UsageError(
            Diagnostic("binary-to-terminal", f"{kind} is binary and is not written to a terminal")
        )
    return kind


def check_response_name(output: str | None) -> None:
    """Refuse a file for a response, which is CSV, whose suffix names another format.

    Raises:
        UsageError: It does.
    """
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.setpoints.writers import suffix_of

    suffix = suffix_of(output)
    if suffix in (*FORMATS, *SUFFIXES) and suffix != "csv":
        message = f"{output}: a response is written as csv, and the suffix .{suffix} names another format"
        raise UsageError(Diagnostic("setpoint-format", message, hint="give the file the suffix .csv"))


def write_setpoints(
    chunks: Iterable[Setpoints], output: str | None, format: str | None, machine: Machine | str | None = None
) -> int:
    """Write a stream whole or not at all; return its rows.

    Without ``--output`` they go to standard output, unless that is a terminal: then they are drawn and not written.

    Raises:
        UsageError: As `setpoint_format`, and what drawing the stream raises.
    """
    from cncgen.files import STANDARD, is_terminal
    from cncgen.pipeline import write

    kind = setpoint_format(output, format)
    if output is None and is_terminal(sys.stdout):
        return sum(len(chunk) for chunk in chunks)
    return write(chunks, STANDARD if output is None else output, format=kind, machine=machine)
