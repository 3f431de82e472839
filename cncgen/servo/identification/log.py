"""Logs of an axis: a CSV file with the time and columns such as a response file has.

Other tools write other CSV files: semicolons (with decimal commas) and tabs separate columns too, other units may stand in brackets
(``time [ms]``, ``x_cmd (µm)``), and other columns are ignored.
"""

from __future__ import annotations

import io
import os
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Span, UsageError
from cncgen.files import read_utf8
from cncgen.units import AXIS_LETTERS, DEGREE, is_rotary

#: Rows of a log that a fit needs.
LEAST_ROWS = 16
Floats = NDArray[np.float64]

#: A log is read whole; more than this is not a log of one excitation.
MAX_BYTES = 1_000_000_000
#: No machine has numbers beyond this: their squares are still far from the largest double.
MAX_VALUE = 1e30
USUAL = "a log is a CSV file like the response file of cncgen simulate: t_s,x_cmd_mm,x_mm,x_force"
#: Two sampling intervals may differ by this share.
JITTER = 1e-3


@dataclass(frozen=True, slots=True)
class AxisLog:
    """One axis of a log, sampled evenly.

    Attributes:
        letter: The axis.
        period_s: Time between samples.
        position: Shape (n,), mm or rad: column ``x_mm`` (or ``x_pos``, ``x_act`` … with a unit).
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
        UsageError: The file cannot be read, has no ``t_s`` or no position (``log-columns``), something other than a number
            (``log-row``), fewer than 16 rows, or times that are uneven or go back (``log-time``).
    """
    return parse_log(read_utf8(path, at_most=MAX_BYTES), os.fspath(path))


def parse_log(content: bytes, name: str) -> dict[str, AxisLog]:
    """Return the axes of a log's text; see `read_log`."""
    head, body, separator = _split(content)
    words = head.split(separator)
    places: dict[str, int] = {}
    factors: dict[str, float] = {}
    for i, column in enumerate(map(_column, words)):
        if column is None:
            continue
        if column.name in places:
            raise _fault("log-columns", f"{name}: columns {places[column.name] + 1} and {i + 1} say the same")
        places[column.name], factors[column.name] = i, column.factor
    if "t" not in places:
        shown = ", ".join(word.strip() for word in words)[:120]
        raise _fault(
            "log-columns", f"{name}: the first line names no column of times (t_s); it names {shown}"
        )
    if not any(letter.lower() in places for letter in AXIS_LETTERS):
        raise _fault("log-columns", f"{name}: no column x_mm (or of another axis) with the measured position")
    first_line = content.count(b"\n") - body.count("\n") + 1
    table = _table(body, separator, _Place(name, first_line), list(places.values()))
    found = {key: table[:, i] * factors[key] for i, key in enumerate(places)}
    period = _period(found["t"], name)
    return {
        letter: AxisLog(letter, period, found[low], found.get(f"{low}_cmd"), found.get(f"{low}_force"))
        for letter in AXIS_LETTERS
        if (low := letter.lower()) in found
    }


@dataclass(frozen=True, slots=True)
class _Column:
    """``t``, ``x``, ``x_cmd`` or ``x_force``, and the factor that brings its numbers to s, mm, rad or what they are."""

    name: str
    factor: float


#: Units that a header may name, and what makes them s, mm and rad.
_UNITS = {
    "t": {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6},
    "length": {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "m": 1e3},
    "angle": {"deg": DEGREE, "°": DEGREE, "rad": 1.0},
}
_TIMES = ("t", "time", "timestamp")
_ROLES = {
    "": "", "pos": "", "act": "", "actual": "", "meas": "", "position": "",
    "cmd": "_cmd", "command": "_cmd", "ref": "_cmd", "set": "_cmd", "setpoint": "_cmd",
    "force": "_force", "drive": "_force", "torque": "_force", "input": "_force", "u": "_force",
}  # fmt: skip
_LABEL = re.compile(r"^(?P<words>.*?)[\s_]*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?$")


def _column(text: str) -> _Column | None:
    """Return what a header's word stands for, or None where it is something else.

    The unit stands after an underscore (``x_mm``) or in brackets (``x [mm]``); of a drive's input it may be anything.
    """
    match = _LABEL.match(text.strip().strip("\"'").replace("μ", "µ").lower())
    words = re.split(r"[\s_]+", match["words"]) if match else []
    unit = match["unit"] if match and match["unit"] is not None else None
    if words and words[0] in _TIMES:
        return _with_unit("t", words[1:], unit, _UNITS["t"], default="")
    letters = [w for w in words if len(w) == 1 and w.upper() in AXIS_LETTERS]
    if len(letters) > 1 and letters[-1] == "u":  # the drive's input, and not the axis U
        letters.pop()
    if len(letters) != 1:
        return None
    words.remove(letters[0])
    role = _ROLES.get(words[0] if words else "")
    if words and role is not None:
        words = words[1:]
    elif role is None:
        role = ""
    if role == "_force":
        return _Column(letters[0] + role, 1.0)
    units = _UNITS["angle" if is_rotary(letters[0].upper()) else "length"]
    return _with_unit(letters[0] + role, words, unit, units)


def _with_unit(
    name: str, words: list[str], unit: str | None, units: dict[str, float], default: str | None = None
) -> _Column | None:
    said = unit if unit is not None else "_".join(words) or default
    factor = units.get(said) if said is not None and (unit is None or not words) else None
    return None if factor is None else _Column(name, factor)


def _split(content: bytes) -> tuple[str, str, str]:
    """Return header, body and separator of a log's text; lines before the header that begin with # are left out."""
    text = content.decode("utf-8-sig", "replace")
    while text.startswith("#") and "," not in text.partition("\n")[0]:
        text = text.partition("\n")[2]
    head, _, body = text.lstrip("# ").partition("\n")
    separator = next((mark for mark in (";", "\t", ",") if mark in head), ",")
    return head.strip("\r\n"), body.replace(",", ".") if separator == ";" else body, separator


@dataclass(frozen=True, slots=True)
class _Place:
    """The file's name, and the line in it where the rows begin."""

    name: str
    first_line: int


def _table(body: str, separator: str, place: _Place, columns: list[int]) -> Floats:
    """Return the numbers of some columns, shape (rows, len(columns)); other columns are not read."""
    table: Floats = np.zeros((0, len(columns)))
    if body.strip():
        try:
            table = np.loadtxt(
                io.StringIO(body), delimiter=separator, ndmin=2, dtype=np.float64, usecols=columns
            )
        except ValueError as error:
            raise UsageError(_first_fault(body, separator, place, columns, str(error))) from error
    if not (np.abs(table) <= MAX_VALUE).all():
        raise UsageError(
            _first_fault(body, separator, place, columns, "a value is not a number within ±1e30")
        )
    if len(table) < LEAST_ROWS:
        raise _fault("log-row", f"{place.name}: {len(table)} rows; {LEAST_ROWS} are needed")
    return table


def _first_fault(body: str, separator: str, place: _Place, columns: list[int], otherwise: str) -> Diagnostic:
    """Return the first fault among the rows at its line and column; `otherwise` says it where none is found."""
    for number, line in enumerate(body.split("\n"), place.first_line):
        words = line.partition("#")[0].rstrip("\r").split(separator)
        if words == [""] or not line.strip():
            continue
        for column in columns:
            text = words[column].strip() if column < len(words) else ""
            at = sum(len(w) + 1 for w in words[:column]) + 1
            span = Span(place.name, number, at, max(len(words[column]), 1) if column < len(words) else 1)
            if column >= len(words):
                message = f"the row has {len(words)} columns, and a value stands in column {column + 1} of the header"
                return Diagnostic(
                    "log-row", message, span=Span(place.name, number), excerpt=line[:200], hint=USUAL
                )
            value = _float(text)
            if value is None or not abs(value) <= MAX_VALUE:
                message = f"column {column + 1} is {text!r}, no finite number up to {MAX_VALUE:g}"
                cut = max(at - 100, 0)
                shown = line[cut : cut + 200]
                return Diagnostic(
                    "log-row", message, span=span, excerpt=shown, excerpt_offset=cut, hint=USUAL
                )
    return Diagnostic("log-row", f"{place.name}: {otherwise}", hint=USUAL)


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _period(times: Floats, name: str) -> float:
    steps = np.diff(times)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        row = int(back[0])
        message = f"{name}: time does not go on at row {row + 3}: {times[row]:g} s, then {times[row + 1]:g} s"
        raise _fault("log-time", message)
    period = float(np.median(steps))
    uneven = np.abs(steps - period) > JITTER * period + 1e-9
    if uneven.any():
        worst = int(np.abs(steps - period).argmax())
        raise _fault(
            "log-time",
            f"{name}: times are not even: {int(uneven.sum())} of {len(steps)} steps differ from {period:g} s, most at row"
            f" {worst + 3}, where it is {steps[worst]:g} s",
            hint="give evenly sampled rows: fill gaps, or interpolate the log to one period",
        )
    return float(times[-1] - times[0]) / len(steps)


def _fault(code: str, message: str, hint: str = USUAL) -> UsageError:
    return UsageError(Diagnostic(code, message, hint=hint))
