"""The table ``[axes.x.drive]`` of a machine file: its keys, the check of their values, and the `Drive` that they give.

The objects are those of CiA 402-2 (cyclic synchronous position mode): 607Ah target position, 60B1h velocity offset,
60B2h torque offset.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from cncgen.arguments import is_number
from cncgen.machine.record import Drive
from cncgen.units import file_unit, to_file

#: Largest value of an INT32.
INT32 = 2**31 - 1


@dataclass(frozen=True, slots=True)
class DriveKey:
    """One key of the table.

    Attributes:
        name: Key; ``{l}`` stands for the axis's unit, mm or deg.
        field: Field of `Drive` that it sets.
        about: Meaning.
        kind: ``number``, ``integer`` or ``flag``.
        low, high: Range of a number.
        per_unit: Whether the value is per mm or deg, so that it changes with the unit.
        required: Whether the file must have it.
        default: What counts where it has not, in words.
    """

    name: str
    field: str
    about: str
    kind: str = "number"
    low: float = 0.0
    high: float = 1e12
    per_unit: bool = False
    required: bool = False
    default: str = "0"

    def key(self, letter: str) -> str:
        """Return the key of an axis."""
        return self.name.replace("{l}", file_unit(letter))

    @property
    def wanted(self) -> str:
        """Return the allowed values in words."""
        if self.kind == "flag":
            return "true or false"
        return f"{'an integer' if self.kind == 'integer' else 'a number'} from {self.low:g} to {self.high:g}"

    def holds(self, value: object) -> bool:
        """Return whether a value is allowed."""
        if self.kind == "flag":
            return isinstance(value, bool)
        if self.kind == "integer" and not (isinstance(value, int) and not isinstance(value, bool)):
            return False
        return is_number(value) and self.low <= value <= self.high


KEYS = (
    DriveKey(
        "counts_per_{l}",
        "counts",
        "increments of 607Ah a mm (a degree)",
        low=1e-6,
        per_unit=True,
        required=True,
    ),
    DriveKey("offset_counts", "offset", "607Ah at machine zero", "integer", -INT32, INT32),
    DriveKey("reversed", "reversed", "whether counts fall as the position grows", "flag", default="false"),
    DriveKey(
        "velocity_units_per_{l}_s",
        "velocity_scale",
        "units of 60B1h a mm/s",
        low=1e-6,
        per_unit=True,
        default="counts a second",
    ),
    DriveKey(
        "torque_permille_per_{l}_s2",
        "torque_inertia",
        "60B2h a mm/s² of acceleration, thousandths of the rated torque",
        per_unit=True,
    ),
    DriveKey(
        "torque_permille_per_{l}_s",
        "torque_viscous",
        "60B2h a mm/s of velocity, thousandths of the rated torque",
        per_unit=True,
    ),
    DriveKey(
        "torque_permille_friction",
        "torque_friction",
        "60B2h against dry friction, thousandths of the rated torque",
        high=1e4,
    ),
)


def drive_faults(table: Mapping[str, Any], letter: str) -> Iterator[tuple[str, str, str, str]]:
    """Yield code, key, message and hint for each fault of a table."""
    known = {key.key(letter): key for key in KEYS}
    for name, value in table.items():
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"
            yield "machine-key", name, "unknown key", hint
        elif not known[name].holds(value):
            yield "machine-value", name, f"must be {known[name].wanted}, is {value!r}", ""
    for name, key in known.items():
        if key.required and name not in table:
            yield "machine-missing", name, "missing", ""


def faults_of_record(drive: object, letter: str) -> Iterator[str]:
    """Yield each fault of the drive of an axis that a script made, by the key that files have."""
    if not isinstance(drive, Drive):
        yield f"is of type {type(drive).__name__}; it is to be a cncgen.machine.Drive, or None"
        return
    factor = to_file(letter)
    for key in KEYS:
        value = getattr(drive, key.field)
        if value is None and key.field == "velocity_scale":
            continue
        scaled = _short(value / factor, value, factor) if key.per_unit and is_number(value) else value
        if not key.holds(scaled):
            yield f"{key.key(letter)}: must be {key.wanted}, is {scaled!r}"


def drive_of(table: Mapping[str, Any], letter: str) -> Drive:
    """Return the drive of a table without faults, its scales in mm or rad."""
    factor = to_file(letter)
    values = {}
    for key in KEYS:
        if key.key(letter) in table:
            value = table[key.key(letter)]
            values[key.field] = value * factor if key.per_unit else value
    return Drive(**values)


def drive_table(drive: Drive, letter: str) -> dict[str, Any]:
    """Return the table of a drive as files have it: keys with the default left out."""
    factor, usual, table = to_file(letter), Drive(counts=math.nan), {}
    for key in KEYS:
        value = getattr(drive, key.field)
        if key.kind == "number" and value is not None:
            value = float(value)  # of numpy, JSON could not hold it
        if value != getattr(usual, key.field):
            table[key.key(letter)] = _short(value / factor, value, factor) if key.per_unit else value
    return table


def _short(value: float, inside: float, factor: float) -> float:
    """Return the short decimal number that reads back as the same scale, where there is one."""
    short = float(f"{value:.14g}")
    return short if short * factor == inside else value
