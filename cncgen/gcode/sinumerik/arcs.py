"""Arcs of SINUMERIK: by centre, radius (CR), angle (AR), intermediate point (CIP), tangent (CT) or pole, with turns (TURN)."""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES
from cncgen.gcode.codes.arcs import tangent_centre
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinks.sink import RADIUS_TOLERANCE
from cncgen.gcode.sinumerik import curves
from cncgen.kernels.arc_centres import centre_from_radius

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words


def follow(
    motions: Motions,
    end: complex,
    centre: complex | None = None,
    spin: int = 1,
    height: float | None = None,
    *,
    rapid: bool = False,
) -> None:
    """Go to a place of the plane, and to a height above it: in a line, or on an arc about a centre, counter-clockwise where `spin` is 1."""
    first, second, normal = motions.plane()
    words = {AXES[first]: end.real, AXES[second]: end.imag}
    if height is not None:
        words[AXES[normal]] = height
    if centre is None:
        motions.emit(words, (0 if rapid else 10,))
        return
    here = motions.ip.state.position
    words["ijk"[first]], words["ijk"[second]] = centre.real - here[first], centre.imag - here[second]
    motions.emit(words, (30 if spin > 0 else 20,))


def make(motions: Motions, words: Words, given: dict[str, float], end: list[float], polar: bool) -> None:
    """Make an arc: about a centre, by radius, angle, intermediate point or tangent; in the plane of its end where I J K are of that."""
    plane = _plane_of_end(motions, words, given)
    if plane is not None:
        before = motions.ip.state.plane
        motions.emit({}, (10 * plane,))
        try:
            make(motions, words, given, end, polar)
        finally:
            motions.emit({}, (10 * before,))
        return
    first, second, _ = motions.plane()
    start = motions.ip.state.position
    begin, finish = complex(start[first], start[second]), complex(end[first], end[second])
    corner = motions.corner(words)
    if motions.motion == "CIP":
        curves.through(motions, words, {**given, **corner}, end)
        return
    turns = words.named.pop("TURN", ("", 0.0))[1]
    spoke, radius = None, 0.0
    clockwise = motions.motion == "G2"
    if motions.motion == "CT":
        way = complex(motions.heading[first], motions.heading[second]) if motions.heading else None
        hints = ("a line or arc of the plane comes before it", "use G1")
        centre, sense = tangent_centre(begin, way, finish, "motion", hints)
        clockwise = sense < 0
    elif "CR" in words.named:
        radius = words.named.pop("CR")[1]
        centre = _radius_centre(motions, begin, finish, radius, clockwise)
    elif "AR" in words.named:
        centre, finish = _angle_arc(motions, words, begin, finish, clockwise, bool(given))
    elif polar and not {"I", "J", "K"} & words.named.keys():
        centre = motions.pole
    else:
        spoke = _spoke(motions, words, begin)
    if turns != round(turns) or turns < 0:
        message = f"TURN={turns:g} does not count full circles"
        raise BlockError("arc-turns", message, "TURN", hint="TURN is 0 or more, whole")
    out = {**given, **corner, AXES[first]: finish.real, AXES[second]: finish.imag}
    if spoke is None:
        spoke = centre - begin
    if turns:
        out["p"] = turns + 1.0
    if radius and not turns:
        out["r"] = radius
    else:
        out["ijk"[first % 3]], out["ijk"[second % 3]] = spoke.real, spoke.imag
    motions.emit(out, (20 if clockwise else 30,))
    head(motions, finish - (begin + spoke), clockwise=clockwise)


def _plane_of_end(motions: Motions, words: Words, given: dict[str, float]) -> int | None:
    """Return the number of another plane, in which the two axes of the end and the centre of an arc lie.

    840D sl, Fundamentals, "Circular interpolation": circles outside the working plane, not with AR and helices, are those whose end
    names two axes of another one. Only a centre of these axes makes that sure here.
    """
    axes = "".join(sorted(given))
    plane = {"xy": 17, "xz": 18, "yz": 19}.get(axes)
    centre = {"XYZ"["IJK".index(word)].lower() for word in words.named if word in "IJK"}
    if plane in (None, motions.ip.state.plane) or not centre or not centre <= set(axes):
        return None
    first, second, _ = motions.plane()
    if (
        centre <= {AXES[first], AXES[second]}
        or {"AR", "TURN", "CR"} & words.named.keys()
        or motions.ip.state.compensation != 40
    ):
        return None
    return plane


def head(motions: Motions, spoke: complex, *, clockwise: bool) -> None:
    """Keep the direction in which an arc ends, whose end is so far from its centre."""
    first, second, _ = motions.plane()
    way = (-1j if clockwise else 1j) * spoke
    motions.heading = [0.0] * 9
    motions.heading[first], motions.heading[second] = way.real, way.imag


def _spoke(motions: Motions, words: Words, begin: complex) -> complex:
    """Return the way from the start to the centre, which I J K give, or where AC() says so the coordinates of the centre."""
    first, second, _ = motions.plane()
    found = []
    for column, place in ((first, begin.real), (second, begin.imag)):
        mode, value = words.named.pop("IJK"[column % 3], ("", 0.0))
        found.append(value * motions.scale(AXES[column].upper()) - place if mode == "AC" else value)
    wrong = next((n for n in "IJK" if n in words.named), None)
    if wrong:
        message = f"{wrong} is not of the plane G{motions.ip.state.plane}"
        raise BlockError("arc-plane", message, wrong, hint="G17 has I J, G18 I K, G19 J K")
    spoke = complex(*found)
    if begin + spoke == begin:
        message = f"{motions.motion} has no centre: neither I J K nor CR nor AR"
        raise BlockError("arc-centre", message, motions.motion, hint="G2 X10 Y0 CR=10, or I5 J0")
    return spoke


def _radius_centre(
    motions: Motions, begin: complex, finish: complex, radius: float, clockwise: bool
) -> complex:
    """Return the centre of an arc of a radius; more than half a turn where it is negative."""
    chord = abs(finish - begin)
    if chord == 0.0:
        message = f"CR={radius:g} ends where it starts: every circle of that radius would do"
        raise BlockError("arc-radius", message, "CR", hint="a full circle needs I J K")
    tolerance = RADIUS_TOLERANCE[motions.ip.state.inches]
    ends = begin.real, begin.imag, finish.real, finish.imag
    centre: complex = centre_from_radius(*ends, radius, clockwise, tolerance)
    if math.isnan(centre.real):
        message = f"CR={radius:g} is too small: the end is {chord:.4f} away"
        raise BlockError("arc-radius", message, "CR", hint=f"CR is at least {chord / 2.0:.4f}")
    return centre


def _angle_arc(
    motions: Motions, words: Words, begin: complex, finish: complex, clockwise: bool, ended: bool
) -> tuple[complex, complex]:
    """Return centre and end of an arc of the angle AR, whose end or centre is given."""
    angle = math.radians(words.named.pop("AR")[1])
    if not 0.0 < angle < 2.0 * math.pi:
        message = f"AR={math.degrees(angle):g} is not the angle of an arc"
        raise BlockError("arc-angle", message, "AR", hint="AR is above 0 and below 360")
    turn = cmath.rect(1.0, -angle if clockwise else angle)
    if {"I", "J", "K"} & words.named.keys():
        if ended and finish != begin:
            raise BlockError("arc-end", "AR has both an end and a centre", "AR", hint="leave one out")
        centre = begin + _spoke(motions, words, begin)
        return centre, centre + (begin - centre) * turn
    if finish == begin:
        raise BlockError("arc-end", "AR has neither an end nor a centre", "AR", hint="X Y or I J beside AR")
    return (finish - begin * turn) / (1.0 - turn), finish
