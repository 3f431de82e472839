"""Tools for material removal: from the values of a tool event, and from options as ``3=bull:10,2``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.ranges import POSITION
from cncgen.removal.record import Cutter, Insert

#: How an option names a tool.
FORMS = "flat:D, ball:D, bull:D,R, drill:D,POINT, chamfer:D,ANGLE[,TIP]; of a lathe turn:NOSE[,TRAILING], groove:WIDTH[,NOSE]"
_SIZES = {
    "flat": (1, 1),
    "ball": (1, 1),
    "bull": (2, 2),
    "drill": (1, 2),
    "chamfer": (2, 3),
    "turn": (1, 2),
    "groove": (1, 2),
}
#: Point angle of a drill where none is given, degrees.
POINT = 118.0
#: Angle of a turning tool's trailing edge where none is given, rad: that of a slender one.
TRAILING = math.radians(60.0)


def insert_of_event(values: Mapping[str, Any]) -> Insert | None:
    """Return the turning tool of a ``tool`` event, None of another tool, and of one for grooves whose width is not known.

    The event's values are `tool`, `form` (``turning tool``, ``grooving tool``, ``threading tool``), and where they are known
    `nose_radius_mm`, `width_mm`, `trailing_angle_deg`, `left_handed`.
    """
    if values.get("form") not in ("turning tool", "grooving tool", "threading tool"):
        return None
    angle = values.get("trailing_angle_deg")
    trailing = math.radians(float(angle)) if angle and 0 < angle < 90 else TRAILING
    width = float(values.get("width_mm") or 0.0)
    if values["form"] == "grooving tool" and not width > 0:
        return None
    left = bool(values.get("left_handed")) and not width
    nose = float(values.get("nose_radius_mm") or 0.0)
    return Insert(str(values.get("tool", "")), nose, width, trailing, left)


def cutter_of_event(values: Mapping[str, Any]) -> Cutter | None:
    """Return the tool of a ``tool`` event, None where its diameter is not known.

    The event's values are `tool`, `diameter_mm`, and where they are known `edge_radius_mm`, `point_angle_deg` (between the
    sides of the cone), `tip_diameter_mm`, `cutting_length_mm`, `left_handed`, `steepest_deg`.
    """
    diameter = values.get("diameter_mm")
    if not diameter or not diameter > 0:
        return None
    name, radius = str(values.get("tool", "")), float(diameter) / 2
    length = values.get("cutting_length_mm") or math.inf
    left = bool(values.get("left_handed"))
    point = values.get("point_angle_deg")
    if point is not None and 0 < point < 180:
        flat = min(float(values.get("tip_diameter_mm") or 0.0) / 2, radius)
        return Cutter(name, radius, flat, 0.0, 1 / math.tan(math.radians(point) / 2), length, left)
    edge = min(float(values.get("edge_radius_mm") or 0.0), radius)
    steepest = math.radians(float(values.get("steepest_deg", 90.0)))
    return Cutter(name, radius, radius - edge, edge, 0.0, length, left, steepest=steepest)


def cutter_of_option(text: str) -> Cutter | Insert:
    """Return the tool of an option ``NAME=FORM:SIZES[;length=L][;shank=D][;holder=D,H]``, mm and degrees.

    Raises:
        UsageError: The text does not describe a tool; the hint says how to write one.
    """
    name, _, rest = text.partition("=")
    form, *extras = rest.split(";")
    kind, _, sizes = form.partition(":")
    numbers = _numbers(sizes, text)
    least, most = _SIZES.get(kind.strip().lower(), (99, 0))
    if not name.strip() or not least <= len(numbers) <= most or min(numbers) < 0:
        raise _wrong(text)
    if kind in ("turn", "groove") and extras:
        raise _wrong(text)
    if kind == "turn":
        angle = numbers[1] if len(numbers) > 1 else math.degrees(TRAILING)
        if not 0 < angle < 90:
            raise _wrong(text)
        return Insert(name.strip(), numbers[0], trailing=math.radians(angle))
    if not numbers[0] > 0:
        raise _wrong(text)
    if kind == "groove":
        return Insert(name.strip(), numbers[1] if len(numbers) > 1 else 0.0, numbers[0])
    values: dict[str, Any] = {"tool": name.strip(), "diameter_mm": numbers[0]}
    if kind == "ball":
        values["edge_radius_mm"] = numbers[0] / 2
    elif kind == "bull":
        if numbers[1] > numbers[0] / 2:
            raise _wrong(text, f"the corner's radius is more than half of the diameter of {numbers[0]:g} mm")
        values["edge_radius_mm"] = numbers[1]
    elif kind == "drill":
        values["point_angle_deg"] = numbers[1] if len(numbers) > 1 else POINT
    elif kind == "chamfer":
        values |= {"point_angle_deg": numbers[1], "tip_diameter_mm": numbers[2] if len(numbers) > 2 else 0.0}
    if not 0 < values.get("point_angle_deg", 90.0) <= 180:
        raise _wrong(text, "the angle is not above 0 and at most 180 degrees")
    if values.get("tip_diameter_mm", 0.0) > numbers[0]:
        raise _wrong(text, f"the tip is wider than the diameter of {numbers[0]:g} mm")
    shank, holder = None, None
    for extra in extras:
        key, _, value = extra.partition("=")
        given = _numbers(value, text)
        if key == "length" and len(given) == 1:
            values["cutting_length_mm"] = given[0]
        elif key == "shank" and len(given) == 1:
            shank = given[0] / 2
        elif key == "holder" and len(given) == 2:
            holder = (given[0] / 2, given[1])
        else:
            raise _wrong(text)
    made = cutter_of_event(values)
    if made is None:
        raise _wrong(text)
    return Cutter(
        made.name, made.radius, made.flat, made.edge, made.slope, made.cutting_length, False, shank, holder
    )


def _numbers(text: str, whole: str) -> list[float]:
    try:
        numbers = [float(v) for v in text.split(",")]
    except ValueError:
        raise _wrong(whole) from None
    if not all(abs(value) <= POSITION for value in numbers):
        raise UsageError(Diagnostic("cut-tool", f"{whole!r} has a size beyond {POSITION:g} mm"))
    return numbers


def _wrong(text: str, why: str = "") -> UsageError:
    hint = f"NAME=FORM with a form of {FORMS}; then ;length=L ;shank=D ;holder=D,HEIGHT as far as they are known, mm and degrees"
    return UsageError(Diagnostic("cut-tool", f"{text!r} names no tool{why and f': {why}'}", hint=hint))
