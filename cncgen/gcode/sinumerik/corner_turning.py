"""CYCLE951 of SINUMERIK: stock removed at a corner of a turned part (840D sl, Operating Manual Turning 05/2017 and 06/2019, "Stock removal").

The corner lies between the reference point (SPD, SPL) of the blank and the end point (EPD, EPL): a line along Z at EPD, and one along X
at EPL. The order of the parameters is that of public listings of them and of programs, of which a warning reminds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.contour_cycles import Cuts, at_feed, tell_nose
from cncgen.gcode.sinumerik.cycles import Values, doubt_order, filled

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

_TINY = 1e-9


def _check(motions: Motions, name: str, v: list[float]) -> None:
    vari, place, modes = round(v[10]), round(v[6]), round(v[18])
    along_x, finishes = vari % 10 == 2, vari // 10 % 10 == 2
    outside, front = place < 2, place % 2 == 1
    shape = f"X{v[0]:g} Z{v[1]:g} to X{v[2]:g} Z{v[3]:g}"
    faults = (
        (motions.ip.state.plane != 18 or round(v[17]) % 10 not in (0, 2), "cycle-words", "works in the plane G18", "G18 stands before it, and DMODE is 0 or 2"),
        (round(v[16]) not in (0, 1) or any(v[11:14]), "not-read", "with slanting edges, radii or chamfers (NR, RF1 to RF3) is not read", "NR = 0 is a corner of two edges"),
        (modes % 10 != 0, "not-read", "with an end point in X as an increment (AMODE) is not read", "EPD is a diameter"),
        (modes // 10 % 10 > 1, "not-read", f"with AMODE = {modes} is not read", "its tens are 0, EPL a coordinate, or 1, a distance"),
        (vari % 10 not in (1, 2) or vari // 10 % 10 not in (1, 2), "not-read", f"with VARI = {vari} is not read", "11 roughs and 21 finishes along Z, 12 and 22 along X"),
        (place not in range(4), "cycle-words", f"has the position LAGE = {place}", "0 is outside and behind, 1 outside in front, 2 and 3 inside"),
        (along_x and not front, "not-read", "along X behind the part is not read", "VARI = 11 is along Z"),
        (not finishes and v[7] <= 0.0, "cycle-words", "has no infeed MID", "MID is the depth of a cut"),
        (min(v[8:10]) < 0.0 or v[14] < 0.0, "cycle-words", "has an allowance or a clearance below 0", "FALX, FALZ, SDIS"),
        (abs(v[0] - v[2]) < _TINY or abs(v[1] - v[3]) < _TINY, "cycle-words", f"removes nothing: {shape}", "SPD, SPL, EPD, EPL"),
        ((v[0] > v[2]) != outside or (v[1] > v[3]) != front, "cycle-words",
         f"goes from {shape}, and LAGE = {place} is {'outside' if outside else 'inside'}, {'in front' if front else 'behind'}", "the end point lies below the reference point outside, and behind it in front"),
    )  # fmt: skip
    refuse(name, *((wrong, code, f"{name} {what}", hint) for wrong, code, what, hint in faults))


def corner(motions: Motions, name: str, values: Values) -> None:
    """CYCLE951(SPD, SPL, EPD, EPL, ZPD, ZPL, LAGE, MID, FALX, FALZ, VARI, RF1, RF2, RF3, SDIS, FF1, NR, DMODE, AMODE), SPD and EPD diameters."""
    v = [filled(values, k) for k in range(19)]
    if round(v[18]) // 10 % 10 == 1:
        v[3] += v[1]
    _check(motions, name, v)
    doubt_order(
        motions,
        name,
        "SPD, SPL, EPD, EPL, ZPD, ZPL, LAGE, MID, FALX, FALZ, VARI, RF1 to RF3, SDIS, FF1: compare the motions with what is meant",
    )
    vari, inside = round(v[10]), round(v[6]) > 1
    points = complex(v[1], v[2] / 2.0), complex(v[3], v[2] / 2.0), complex(v[3], v[0] / 2.0)
    contour = [Segment(points[0], points[1]), Segment(points[1], points[2])]
    cuts = Cuts.of(motions, name, contour, vari % 10 + 2 * inside, v[14])
    before = motions.ip.state.feed
    tell_nose(motions, name)
    at_feed(motions, v[15] or before, name)
    if vari // 10 % 10 == 1:
        cuts.rough(v[7], v[9], v[8], 0.0)
    else:
        cuts.finish()
    motions.ip.state.moved = True
    if before:
        motions.emit({"f": before})


CYCLES = {"CYCLE951": corner}
