"""Tools for material removal: from the values of a tool event, and from options as ``3=bull:10,2``."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping
from dataclasses import replace
from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.ranges import POSITION
from cncgen.removal.record import Cutter, Insert

#: How an option names a tool.
FORMS = "flat:D, ball:D, bull:D,R, drill:D,POINT, chamfer:D,ANGLE[,TIP]; of a lathe turn:NOSE[,TRAILING], groove:WIDTH[,NOSE]"
#: Point angle of a drill where none is given, degrees.
POINT = 118.0
#: The sizes of each form, as values of a ``tool`` event: required, optional, and implied by the form.
_SIZES: dict[str, tuple[list[str], list[str], dict[str, Any]]] = {
    "flat": (["diameter_mm"], [], {}),
    "ball": (["diameter_mm"], [], {}),
    "bull": (["diameter_mm", "edge_radius_mm"], [], {}),
    "drill": (["diameter_mm"], ["point_angle_deg"], {"point_angle_deg": POINT}),
    "chamfer": (["diameter_mm", "point_angle_deg"], ["tip_diameter_mm"], {}),
    "turn": (["nose_radius_mm"], ["trailing_angle_deg"], {"form": "turning tool"}),
    "groove": (["width_mm"], ["nose_radius_mm"], {"form": "grooving tool"}),
}
#: How many numbers follow what is said of a milling tool beside its form.
_EXTRAS = {"length": 1, "shank": 1, "holder": 2}
#: Angle of a turning tool's trailing edge where none is given, rad: that of a slender one.
TRAILING = math.radians(60.0)


def turns_work(events: Iterable[Mapping[str, Any]], axes: Container[str], for_lathe: bool) -> bool:
    """Tell whether a program turns its work, whatever is known of its tools.

    One of its tools is a lathe's; or it moves X and Z and not Y, and is for a lathe or has a constant surface speed (G96).

    Args:
        events: Values of its events.
        axes: Letters of the axes that it moves.
        for_lathe: Whether its dialect or its machine is a lathe's.
    """
    flat = "X" in axes and "Z" in axes and "Y" not in axes
    speeds = ("surface_m_min", "surface_ft_min")
    return (flat and for_lathe) or any(
        insert_of_event(values) or (flat and any(speed in values for speed in speeds)) for values in events
    )


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
    kind = kind.strip().lower()
    numbers = _numbers(sizes, text)
    must, may, implied = _SIZES.get(kind, ([], [], {}))
    if not name.strip() or not len(must) <= len(numbers) <= len(must + may):
        raise _wrong(text)
    values = {"tool": name.strip(), **implied, **dict(zip(must + may, numbers, strict=False))}
    if kind == "ball":
        values["edge_radius_mm"] = values["diameter_mm"] / 2
    _check_sizes(values, text)
    if "form" in values:
        made: Cutter | Insert | None = insert_of_event(values)
        if made is None or extras:
            raise _wrong(text)
        return made
    parts: dict[str, list[float]] = {}
    for extra in extras:
        key, _, value = extra.partition("=")
        parts[key] = _numbers(value, text)
        if _EXTRAS.get(key) != len(parts[key]):
            raise _wrong(text)
    cutter = cutter_of_event(values | {"cutting_length_mm": parts.get("length", [math.inf])[0]})
    if cutter is None:
        raise _wrong(text)
    if "shank" in parts:
        cutter = replace(cutter, shank=parts["shank"][0] / 2)
    if "holder" in parts:
        cutter = replace(cutter, holder=(parts["holder"][0] / 2, parts["holder"][1]))
    return cutter


def _check_sizes(values: Mapping[str, Any], text: str) -> None:
    """Raise `UsageError` where the sizes of a tool do not fit each other."""
    diameter = values.get("diameter_mm", math.inf)
    if values.get("edge_radius_mm", 0.0) > diameter / 2:
        raise _wrong(text, f"the corner's radius is more than half of the diameter of {diameter:g} mm")
    if values.get("tip_diameter_mm", 0.0) > diameter:
        raise _wrong(text, f"the tip is wider than the diameter of {diameter:g} mm")
    if not 0 < values.get("point_angle_deg", POINT) <= 180:
        raise _wrong(text, "the angle is not above 0 and at most 180 degrees")
    if not 0 < values.get("trailing_angle_deg", 60.0) < 90:
        raise _wrong(text, "the angle is not above 0 and below 90 degrees")


def _numbers(text: str, whole: str) -> list[float]:
    try:
        numbers = [float(v) for v in text.split(",")]
    except ValueError:
        raise _wrong(whole) from None
    if not all(abs(value) <= POSITION for value in numbers):
        raise UsageError(Diagnostic("cut-tool", f"{whole!r} has a size beyond {POSITION:g} mm"))
    if min(numbers) < 0:
        raise _wrong(whole)
    return numbers


def _wrong(text: str, why: str = "") -> UsageError:
    hint = f"NAME=FORM with a form of {FORMS}; then ;length=L ;shank=D ;holder=D,HEIGHT as far as they are known, mm and degrees"
    return UsageError(Diagnostic("cut-tool", f"{text!r} names no tool{why and f': {why}'}", hint=hint))
