"""Places of SINUMERIK by an angle: AP and RP about the pole, and ANG, a line at an angle up to one coordinate."""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES
from cncgen.gcode.errors import BlockError

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words

#: Part of a line's length that it must lead along the axis whose coordinate bounds it (ANG).
_STEEP = 1e-9


def angle_end(motions: Motions, words: Words, end: list[float]) -> None:
    """Put in the end of a line at the angle ANG from the first axis of the plane, which one of its two coordinates bounds."""
    first, second, _ = motions.plane()
    way = cmath.rect(1.0, math.radians(words.named.pop("ANG")[1]))
    given = [column for column in (first, second) if AXES[column].upper() in words.axes]
    along, across = (way.real, way.imag) if given == [first] else (way.imag, way.real)
    if len(given) != 1 or motions.motion not in ("G0", "G1") or abs(along) < _STEEP:
        names = f"{AXES[first]} or {AXES[second]}".upper()
        message = (
            f"ANG does not lead to a point: a line at an angle has {names}, one of them, that it comes to"
        )
        hint = "ANG=135 X40; two lines by their angles alone are not read"
        raise BlockError("drawing-angle", message, "ANG", hint=hint)
    column, other = (first, second) if given == [first] else (second, first)
    start = motions.ip.state.position
    end[other] = start[other] + (end[column] - start[column]) * across / along
    words.axes[AXES[other].upper()] = "AC", end[other]


def polar_end(motions: Motions, words: Words, end: list[float]) -> None:
    """Put in the end of AP (angle) and RP (radius) about the pole; a missing one keeps its last value."""
    first, second, _ = motions.plane()
    if {AXES[first].upper(), AXES[second].upper()} & words.axes.keys():
        message = "polar words AP RP stand beside an axis of their plane"
        raise BlockError("polar-words", message, "AP", hint="a point is either X Y or AP RP")
    spoke = complex(end[first], end[second]) - motions.pole
    here = (abs(spoke), math.degrees(cmath.phase(spoke)) if spoke else motions.polar[1])
    radius, angle = here[0], here[1]
    if "RP" in words.named:
        mode, value = words.named.pop("RP")
        radius = value + (here[0] if mode == "IC" else 0.0)
    if "AP" in words.named:
        mode, value = words.named.pop("AP")
        incremental = mode == "IC" or (mode == "" and not motions.absolute)
        angle = value + (here[1] if incremental else 0.0)
    if radius < 0.0:
        raise BlockError("polar-words", f"RP={radius:g} is negative", "RP", hint="a radius is 0 or more")
    motions.polar = (radius, angle)
    place = motions.pole + cmath.rect(radius, math.radians(angle))
    end[first], end[second] = place.real, place.imag
    words.axes[AXES[first].upper()] = words.axes[AXES[second].upper()] = ("AC", 0.0)
    words.named["_POLAR"] = ("", 1.0)
