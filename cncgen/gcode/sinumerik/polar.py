"""Places of SINUMERIK by an angle: AP and RP about the pole, and ANG, a line at an angle up to one coordinate, or up to the next line."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES
from cncgen.gcode.errors import BlockError

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words
    from cncgen.gcode.text.labels import Cursor

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
        hint = "ANG=135 X40; a line by its angle alone ends where the line of the next block, with both and ANG, meets it"
        raise BlockError("drawing-angle", message, "ANG", hint=hint)
    column, other = (first, second) if given == [first] else (second, first)
    start = motions.ip.state.position
    end[other] = start[other] + (end[column] - start[column]) * across / along
    words.axes[AXES[other].upper()] = "AC", end[other]


@dataclass(slots=True)
class Angled:
    """A line by its angle alone, which waits for the line that ends it.

    Attributes:
        angle: From the first axis of the plane, degrees.
        corner: What stands at its end, as words of the interpreter.
        here: Its block.
        motion: G0 or G1. feed: F of the block.
    """

    angle: float
    corner: dict[str, float]
    here: Cursor
    motion: str
    feed: float

    def fault(self, what: str) -> BlockError:
        """Return the error of a line that nothing ends."""
        message = f"ANG={self.angle:g} of line {self.here.line}, a line by its angle alone, {what}"
        hint = "the next block has both coordinates of its plane, and ANG of the line that leads there"
        return BlockError("drawing-angle", message, "ANG", hint=hint)


def wait(motions: Motions, words: Words) -> bool:
    """Keep a line by its angle alone until the next line is known; tell whether the block is one."""
    if (
        words.named.keys().isdisjoint(("ANG",))
        or words.axes
        or motions.motion not in ("G0", "G1")
        or motions.modal
    ):
        return False
    angle = words.named.pop("ANG")[1]
    corner = motions.corner(words) if motions.motion == "G1" else {}
    motions.angled = Angled(angle, corner, motions.here, motions.motion, motions.ip.state.feed)
    return True


def meet(motions: Motions, words: Words) -> None:
    """Make the line that waits, up to where it meets the line of this block: two straight lines, the end and both angles known
    (840D sl, Fundamentals, "Contour definitions: two straight lines")."""
    line, motions.angled = motions.angled, None
    assert line is not None
    first, second, _ = motions.plane()
    names = {AXES[first].upper(), AXES[second].upper()}
    if "ANG" not in words.named or not names <= words.axes.keys() or motions.motion not in ("G0", "G1"):
        raise line.fault("is not followed by a line to a point at an angle")
    if any(mode == "IC" or (mode == "" and not motions.absolute) for mode, _ in words.axes.values()):
        raise line.fault("is followed by increments, which count from where the lines meet: that is not read")
    other = words.named.pop("ANG")[1]
    way, there = (cmath.rect(1.0, math.radians(angle)) for angle in (line.angle, other))
    end = motions.end_of(words)
    start, last = motions.here_in_plane(), complex(end[first], end[second])
    across = (way.conjugate() * there).imag
    if abs(across) < _STEEP:
        raise line.fault(f"and the line at ANG={other:g} behind it are parallel: they do not meet")
    size = ((last - start).conjugate() * there).imag / across
    place = start + way * size
    if size < 0.0 or ((last - place).conjugate() * there).real < 0.0:
        which = f"{AXES[first]}{place.real:.3f} {AXES[second]}{place.imag:.3f}".upper()
        raise line.fault(
            f"meets the line at ANG={other:g} in {which}, against the direction of one of the angles"
        )
    here, feed = motions.here, motions.ip.state.feed
    motions.here = line.here
    own = {"f": line.feed} if line.feed and line.feed != feed else {}
    motions.emit(
        {AXES[first]: place.real, AXES[second]: place.imag, **own, **line.corner},
        (0 if line.motion == "G0" else 10,),
    )
    motions.here = here
    if own:
        motions.emit({"f": feed})


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
