"""Logs of an axis: a CSV file with the time and columns such as a response file has."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import read_bytes
from cncgen.units import AXIS_LETTERS, DEGREE, file_unit, is_rotary

Floats = NDArray[np.float64]

#: A log is read whole; more than this is not a log of one excitation.
MAX_BYTES = 1_000_000_000
#: Two sampling intervals may differ by this share.
JITTER = 1e-3


@dataclass(frozen=True, slots=True)
class AxisLog:
    """One axis of a log, sampled evenly.

    Attributes:
        letter: The axis.
        period_s: Time between samples.
        position: Shape (n,), mm or rad: column ``x_mm``.
        command: Shape (n,), or None: column ``x_cmd_mm``.
        drive: Shape (n,), the drive's input in its own unit, or None: column ``x_force``.
    """

    letter: str
    period_s: float
    position: Floats
    command: Floats | None
    drive: Floats | None


def read_log(path: str | os.PathLike[str]) -> dict[str, AxisLog]:
    """Return the axes of a log by letter.

    Raises:
        UsageError: The file cannot be read, has no ``t_s`` or no position (``log-columns``), something that is no number
            (``log-row``), fewer than 16 rows, or uneven times (``log-time``).
    """
    return parse_log(read_bytes(path, at_most=MAX_BYTES), os.fspath(path))


def parse_log(content: bytes, name: str) -> dict[str, AxisLog]:
    """Return the axes of a log's text; see `read_log`."""
    head, _, body = content.partition(b"\n")
    names = [part.strip() for part in head.decode("utf-8", "replace").strip().split(",")]
    if "t_s" not in names:
        raise _fault(
            "log-columns", f"{name}: the first line names no column t_s; it names {', '.join(names)[:80]}"
        )
    table = _table(body, name, len(names))
    columns = {column: table[:, i] for i, column in enumerate(names)}
    period = _period(columns["t_s"], name)
    axes = {}
    for letter in AXIS_LETTERS:
        low, unit = letter.lower(), file_unit(letter)
        factor = DEGREE if is_rotary(letter) else 1.0
        if f"{low}_{unit}" in columns:
            command = columns.get(f"{low}_cmd_{unit}")
            axes[letter] = AxisLog(
                letter,
                period,
                columns[f"{low}_{unit}"] * factor,
                None if command is None else command * factor,
                columns.get(f"{low}_force"),
            )
    if not axes:
        raise _fault("log-columns", f"{name}: no column x_mm (or of another axis) with the measured position")
    return axes


def _table(body: bytes, name: str, columns: int) -> Floats:
    try:
        table: Floats = np.loadtxt(io.BytesIO(body), delimiter=",", ndmin=2, dtype=np.float64)
    except ValueError as error:
        raise _fault("log-row", f"{name}: {error}") from error
    if len(table) < 16 or table.shape[1] != columns:
        raise _fault(
            "log-row", f"{name}: {len(table)} rows of {table.shape[1]} numbers; 16 of {columns} are needed"
        )
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise _fault("log-row", f"{name}: row {row + 2}, column {column + 1} is {table[row, column]}")
    return table


def _period(times: Floats, name: str) -> float:
    steps = np.diff(times)
    period = float(times[-1] - times[0]) / len(steps)
    if period <= 0.0 or np.abs(steps - period).max() > JITTER * period + 1e-9:
        worst = int(np.abs(steps - period).argmax())
        raise _fault(
            "log-time",
            f"{name}: times are not even: {period:g} s in the mean, {steps[worst]:g} s at row {worst + 2}",
        )
    return period


def _fault(code: str, message: str) -> UsageError:
    return UsageError(
        Diagnostic(code, message, hint="a log is a CSV file like the response file of cncgen simulate")
    )
