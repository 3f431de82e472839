"""Units inside cncgen: mm, s, rad, rev/s. Text is converted once, where it is read.

Constants to multiply by: ``inch * INCH`` is mm, ``degrees * DEGREE`` is rad, ``per_minute * PER_MINUTE`` is per second.
"""

import math

INCH = 25.4
DEGREE = math.pi / 180.0
PER_MINUTE = 1.0 / 60.0

#: Order of the axes wherever several of them stand together (columns, headers, arrays).
AXIS_LETTERS = "XYZABCUVW"
#: The axes that turn: rad inside, degrees in files.
ROTARY_LETTERS = "ABC"

#: Quantities that an axis limits, by the order of the derivative, with the power of the second in their unit.
ORDERS = (("velocity", ""), ("acceleration", "²"), ("jerk", "³"))
#: Their names.
ORDER_NAMES = tuple(name for name, _ in ORDERS)


def is_rotary(axis: str) -> bool:
    """Tell whether the axis of that letter turns (A, B, C)."""
    return axis.upper() in ROTARY_LETTERS


def file_unit(axis: str) -> str:
    """Return the unit that stands in a column name or a key of that axis: ``mm`` or ``deg``."""
    return "deg" if is_rotary(axis) else "mm"


def to_file(axis: str) -> float:
    """Return the factor from the inside unit of an axis (mm, rad) to that of files (mm, deg)."""
    return 1.0 / DEGREE if is_rotary(axis) else 1.0
