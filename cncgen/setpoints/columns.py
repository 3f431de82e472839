"""The columns of a setpoint file: names, order, units, and the matrix of numbers that a chunk gives."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.machine.record import Drive
from cncgen.setpoints.record import AXIS_SIGNALS, PATH_SIGNALS, Setpoints
from cncgen.units import AXIS_LETTERS, DEGREE, file_unit, is_rotary

Floats = NDArray[np.float64]

#: Columns of whole numbers.
INTEGERS = tuple(column for column, unit in PATH_SIGNALS.values() if not unit)


def position_column(axis: str) -> str:
    """Return the column of an axis position: ``x_mm``, ``a_deg``."""
    return f"{axis.lower()}_{file_unit(axis)}"


#: Axis letter by the name of its position column.
POSITION_COLUMNS = {position_column(axis): axis for axis in AXIS_LETTERS}


#: A letter with a unit that positions are given in; X, Y and Z alone too (a, u and v are as often no axes).
_POSITION_LIKE = re.compile(r"[a-z]_(?:mm|cm|m|um|µm|nm|in|inch|deg|rad|rev)|[xyz]")


def unread_positions(names: Sequence[str], name: str) -> list[Diagnostic]:
    """Return the remark on columns that look like positions but are not read.

    Where it is an axis that would be missed (``x_deg``, ``y``) that is an error; another letter (``q_mm``) is a warning.

    Args:
        names: Of the columns, in lower case.
        name: The file.
    """
    found = []
    have = {POSITION_COLUMNS[n] for n in names if n in POSITION_COLUMNS}
    for column in names:
        match = _POSITION_LIKE.fullmatch(column)
        letter = column[:1].upper()
        if not match or column in POSITION_COLUMNS or letter in have:
            continue
        if letter in AXIS_LETTERS:
            message = f"{name}: the column {column} is not the position of axis {letter} in its unit"
            found.append(
                Diagnostic("setpoints-header", message, hint=f"it is called {position_column(letter)}")
            )
        else:
            message = f"{name}: the column {column} names no axis and is passed over"
            hint = f"axes are {' '.join(AXIS_LETTERS)}: {', '.join(map(position_column, 'XA'))} …"
            found.append(Diagnostic("setpoints-header", message, Severity.WARNING, hint=hint))
    return found


def file_units(values: Floats, axes: str) -> Floats:
    """Convert positions, shape (n, axes), from mm and rad to mm and degrees."""
    turning = np.array([is_rotary(axis) for axis in axes])
    # Dividing by the factor that reading multiplies with lets a whole number of degrees come back as it was.
    return np.where(turning, values / DEGREE, values) if turning.any() else values


def inside_units(values: Floats, axes: str) -> Floats:
    """Convert positions, shape (n, axes), from mm and degrees to mm and rad."""
    return values * np.array([DEGREE if is_rotary(axis) else 1.0 for axis in axes])


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a file (time, axes, then signals), and the facts that a format may state about them.

    Attributes:
        axes: Letters of the columns.
        period_s: Time between rows.
        signals: Names of further columns.
        metadata: Text by key (program, machine, version) for formats that have a place for it.
        drives: Scaling of each axis's drive, for formats in drive units.
    """

    axes: str
    period_s: float
    signals: tuple[str, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    drives: Mapping[str, Drive] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """Names of all columns."""
        names = ["t_s", *map(position_column, self.axes)]
        for signal in self.signals:
            if signal in AXIS_SIGNALS:
                power = AXIS_SIGNALS[signal]
                names += [f"{axis.lower()}_{signal}_{file_unit(axis)}{power}" for axis in self.axes]
            else:
                names.append(PATH_SIGNALS[signal][0])
        return names

    @property
    def units(self) -> list[str]:
        """Units of all columns, ``mm/s^2``; "" for whole numbers."""
        positions = [file_unit(axis) for axis in self.axes]
        units = ["s", *positions]
        for signal in self.signals:
            if signal in AXIS_SIGNALS:
                power = AXIS_SIGNALS[signal].removeprefix("_s")
                units += [f"{unit}/s^{power}" if power else f"{unit}/s" for unit in positions]
            else:
                units.append(PATH_SIGNALS[signal][1])
        return units

    def matrix(self, chunk: Setpoints) -> Floats:
        """Return the columns of a chunk as numbers in the units of files, shape (n, columns), C order."""
        parts: list[NDArray] = [chunk.time_s[:, None], file_units(chunk.position, self.axes)]
        for signal in self.signals:
            values = chunk.signals[signal]
            parts.append(file_units(values, self.axes) if signal in AXIS_SIGNALS else values[:, None])
        return np.ascontiguousarray(np.concatenate(parts, axis=1), dtype=np.float64)


def check_finite(matrix: Floats, names: Sequence[str], first: int) -> None:
    """Raise FloatingPointError for a number that no machine may be sent, naming its column and row."""
    finite = np.isfinite(matrix)
    if not finite.all():
        row, column = np.argwhere(~finite)[0]
        raise FloatingPointError(
            f"setpoint {first + row}: {names[column]} is {matrix[row, column]}, not a finite number"
        )
