"""Polar words: @ is the distance from the origin, ^ the angle (degrees from the first axis) of a point in XY."""

from __future__ import annotations

import math

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import PLANE_CODES, Polar, State

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter


def polar_end(state: State, block: Block, end: list[float]) -> None:
    """Put the point that @ and ^ name into X and Y of `end`; a missing one keeps its value at the position.

    They go with the plane XY alone; LinuxCNC looks at the plane that is in force before the block.
    """
    words = block.words
    if state.plane != 17 and PLANE_CODES.keys().isdisjoint(block.g):
        letter = "@" if "@" in words else "^"
        raise BlockError("polar-plane", "@ and ^ go with the plane XY (G17) only", letter, hint="use G17")
    if "x" in words or "y" in words:
        message = "X or Y stands beside @ or ^, which give the same point"
        raise BlockError("polar-words", message, "X" if "x" in words else "Y")
    x, y = state.position[0], state.position[1]
    radius = math.hypot(x, y)
    if "@" in words and radius == 0.0 and "^" not in words:
        raise BlockError("polar-angle", "@ at the origin needs an angle ^", "@")
    angle = math.atan2(y, x)
    if state.absolute:
        radius = words.get("@", radius)
        angle = math.radians(words["^"]) if "^" in words else angle
    else:
        if radius == 0.0 and "^" in words:
            raise BlockError("polar-angle", "an incremental angle ^ at the origin has no meaning", "^")
        radius += words.get("@", 0.0)
        angle += math.radians(words.get("^", 0.0))
    end[0], end[1] = radius * math.cos(angle), radius * math.sin(angle)


def polar_from(state: State) -> Polar:
    """Return the polar coordinates, about the origin, of where the tool is (G16 of FANUC)."""
    first, second, _ = state.plane_axes()
    x, y = state.position[first], state.position[second]
    return Polar((0.0, 0.0), math.hypot(x, y), math.degrees(math.atan2(y, x)))


def plane_polar_end(ip: Interpreter, words: dict[str, float], end: list[float]) -> None:
    """Take the words of the plane's first and second axis as radius and angle (G16 of FANUC).

    A radius in G90 is about the origin, in G91 about where the tool is; an angle in G91 is added to the last one. A
    missing word stays. An angle without a radius, which leads nowhere, is warned of.
    """
    state = ip.state
    assert state.polar is not None
    first, second, _ = state.plane_axes()
    radius, angle = words.get(AXES[first]), words.get(AXES[second])
    if radius is None and angle is None:
        return
    polar = state.polar
    if radius is not None:
        polar.radius = radius
        polar.centre = (0.0, 0.0) if state.absolute else (state.position[first], state.position[second])
    if angle is not None:
        if not polar.radius and radius is None:
            letter = AXES[second].upper()
            message = f"{letter}{angle:g} is an angle in G16, and the radius is 0: the tool stays where it is"
            hint = f"{AXES[first].upper()} gives the radius; a cycle with K0 or L0 keeps its own words and no place"
            ip.warn_once("polar-angle", message, letter, hint)
        polar.angle = angle if state.absolute else polar.angle + angle
    end[first] = polar.centre[0] + polar.radius * math.cos(math.radians(polar.angle))
    end[second] = polar.centre[1] + polar.radius * math.sin(math.radians(polar.angle))
