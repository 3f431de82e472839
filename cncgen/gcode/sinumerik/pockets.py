"""Milling cycles of SINUMERIK: POCKET3 and POCKET1 (rectangle), POCKET4 and POCKET2 (circle), SLOT1, SLOT2 and LONGHOLE (slots on a circle).

The wall, the levels, allowances and feeds are the cycle's; the loops that clear it are our own (`cncgen.gcode.codes.pockets`).
"""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from cncgen.gcode.codes.pockets import Bow, Clearing, Pocket, clear, clear_bow
from cncgen.gcode.codes.steps import MOST, levels_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.cycle_modes import CORNERS, MillingModes, milled
from cncgen.gcode.sinumerik.cycles import (
    Hole,
    Values,
    check_plane,
    count_of,
    depth_of,
    filled,
    given,
    milling_feed,
)

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

#: Part of the tool's diameter by which loops step aside where MIDA is left out (ibid.: 80 %).
_USUAL_STEP = 0.8
#: The reference point of slots on a circle: they begin at RAD.
_FROM_RAD = CORNERS[:1]


def _levels(name: str, motions: Motions, values: Values, modes: MillingModes) -> Hole:
    """Return the heights of a pocket, whose depth is its fourth parameter."""
    depth = depth_of(name, values)
    check_plane(motions, name)
    return modes.hole_to(motions, name, values[:3], depth)


def _cleared(motions: Motions, name: str, hole: Hole, pocket: Pocket, how: dict[str, float]) -> None:
    """Clear a pocket from the reference plane down, roughing or finishing as VARI says, and go to the retraction plane."""
    radius = motions.ip.cutting_radius(name, min(pocket.length, pocket.width))
    message = f"VARI = {how['vari']:g} of {name} (finishing an edge, or chamfering) is not read"
    hint = "VARI = 1 roughs, 2 finishes"
    refuse(name, (how["vari"] % 10 not in (0.0, 1.0, 2.0), "not-read", message, hint))
    rough = how["vari"] % 10 != 2
    side, floor = (how["fal"], how["fald"]) if rough else (0.0, 0.0)
    pocket = pocket.within(side)
    levels = levels_of(hole.reference, hole.depth + floor, how["mid"], name)
    feed = milling_feed(motions, name, how["feed"])
    plunge = how["plunge"] or feed
    motions.move({"Z": hole.back}, rapid=True)
    motions.ip.state.motion = 10
    step = how["step"] or _USUAL_STEP * 2.0 * radius
    climb = how["cdir"] in (0.0, 3.0) if motions.ip.state.direction >= 0 else how["cdir"] == 3.0
    sense = 1 if climb or how["cdir"] == 3.0 else -1
    work = Clearing(radius, step, levels, hole.start, feed, plunge, sense, finish=not rough)
    clear(motions.ip, pocket, work, name)
    motions.ip.sink.set_feed_rate(motions.ip.state.feed)
    motions.move({"Z": hole.back}, rapid=True)


def _place(motions: Motions, values: Values, index: int) -> complex:
    """Return the reference point of a cycle: two parameters, or where the motion that called it (MCALL) has led, where both are left out."""
    if motions.in_modal and given(values, index) is None and given(values, index + 1) is None:
        return motions.here_in_plane()
    return complex(filled(values, index), filled(values, index + 1))


def rectangle(motions: Motions, name: str, values: Values) -> None:
    """POCKET3(RTP, RFP, SDIS, DP, LENG, WID, CRAD, PA, PO, STA, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, MIDA).

    Then AP1 AP2 AD RAD1 DP1 UMODE FS ZFS GMODE DMODE AMODE. The thousands of GMODE choose the reference point: 0 and 1 the centre, 2 to 5 a
    corner, from which the pocket lies towards +LENG +WID, -LENG +WID, +LENG -WID, -LENG -WID.
    """
    v = [filled(values, k) for k in range(18)]
    modes = MillingModes.of(motions, name, values, 26, CORNERS)
    hole = _levels(name, motions, values, modes)
    modes.check_whole(name, values, (18, 19, 20))
    half, turn = complex(abs(v[4]), abs(v[5])) / 2.0, cmath.rect(1.0, math.radians(v[9]))
    x, y = modes.corner
    middle = _place(motions, values, 7) + complex(x * half.real, y * half.imag) * turn
    how = milled(v, 10)
    how["step"] = modes.step(how["step"], motions, name, min(half.real, half.imag))
    _cleared(motions, name, hole, Pocket(middle, half.real, half.imag, v[6], v[9]), how)


def circle(motions: Motions, name: str, values: Values) -> None:
    """POCKET4(RTP, RFP, SDIS, DP, PRAD, PA, PO, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, MIDA), then AP1 AD RAD1 DP1 UMODE FS ZFS GMODE DMODE AMODE.

    The hundreds of DMODE choose what PRAD is: 0 the radius, 1 the diameter.
    """
    v = [filled(values, k) for k in range(15)]
    modes = MillingModes.of(motions, name, values, 22)
    hole = _levels(name, motions, values, modes)
    modes.check_whole(name, values, (15, 16))
    radius = v[4] / 2.0 if modes.diameter else v[4]
    how = milled(v, 7)
    how["step"] = modes.step(how["step"], motions, name, radius)
    _cleared(motions, name, hole, Pocket(_place(motions, values, 5), radius, radius, radius), how)


def old_rectangle(motions: Motions, name: str, values: Values) -> None:
    """POCKET1(RTP, RFP, SDIS, DP, DPR, LENG, WID, CRAD, CPA, CPO, STA1, FFD, FFP1, MID, CDIR, FAL, VARI), of older controls."""
    v = [filled(values, k) for k in range(17)]
    pocket = Pocket(complex(v[8], v[9]), abs(v[5]) / 2.0, abs(v[6]) / 2.0, v[7], v[10])
    _cleared(motions, name, Hole.of(motions, name, values), pocket, _old_how(v, 11))


def old_circle(motions: Motions, name: str, values: Values) -> None:
    """POCKET2(RTP, RFP, SDIS, DP, DPR, PRAD, CPA, CPO, FFD, FFP1, MID, CDIR, FAL, VARI), of older controls."""
    v = [filled(values, k) for k in range(14)]
    hole = Hole.of(motions, name, values)
    _cleared(motions, name, hole, Pocket(complex(v[6], v[7]), v[5], v[5], v[5]), _old_how(v, 8))


def _old_how(v: list[float], first: int) -> dict[str, float]:
    """Return FFD, FFP1, MID, CDIR, FAL, VARI from a parameter on; VARI 0 roughs and finishes in one go here."""
    plunge, feed, mid, cdir, fal, vari = v[first : first + 6]
    return milled((mid, fal if round(vari) == 1 else 0.0, 0.0, feed, plunge, cdir, vari), 0)


def bows(motions: Motions, name: str, values: Values) -> None:
    """SLOT2(RTP, RFP, SDIS, DP, DPR, NUM, AFSL, WID, CPA, CPO, RAD, STA1, INDA, FFD, FFP1, MID, CDIR, FAL, VARI).

    The middle lines of the slots lie on the circle RAD about CPA CPO, each over the angle AFSL from STA1 on, INDA apart.
    """
    v = [filled(values, k) for k in range(19)]
    ip, hole, count = motions.ip, Hole.of(motions, name, values), round(v[5])
    wrong = not 1 <= count <= MOST or not 0.0 < v[6] < 360.0 or round(v[18]) not in (0, 1, 2)
    message = f"{name} has NUM = {count}, AFSL = {v[6]:g} and VARI = {v[18]:g}, in G{ip.state.plane}"
    hint = "NUM counts the slots, AFSL is the angle of one, VARI is 0 to 2; in G17"
    refuse(name, (wrong or ip.state.plane != 17, "cycle-words", message, hint))
    radius, sense = ip.cutting_radius(name, v[7] / 2.0), 1 if v[16] == 3.0 else -1
    feed = milling_feed(motions, name, v[14])
    levels, step = levels_of(hole.reference, hole.depth, v[15], name), _USUAL_STEP * 2.0 * radius
    how = Clearing(radius, step, levels, hole.start, feed, v[13] or feed, sense)
    half = v[7] / 2.0 - (v[17] if round(v[18]) == 1 else 0.0)
    motions.move({"Z": hole.back}, rapid=True)
    for k in range(count):
        begin = v[11] + k * (v[12] or 360.0 / count)
        clear_bow(ip, Bow(complex(v[8], v[9]), v[10], begin, begin + v[6]), half, how, name)
    ip.sink.set_feed_rate(ip.state.feed)
    motions.move({"Z": hole.back}, rapid=True)


def slots(motions: Motions, name: str, values: Values) -> None:
    """SLOT1(RTP, RFP, SDIS, DP, DPR, NUM, LENG, WID, CPA, CPO, RAD, STA1, INDA, FFD, FFP1, MID, CDIR, FAL, VARI).

    Then MIDF FFP2 SSF FALD STA2 DP1 UMODE FS ZFS GMODE DMODE AMODE; FFP2 is the feed of finishing, FALD the allowance of the floor.
    Slots lie along rays from the centre, beginning at the distance RAD.
    """
    v = [filled(values, k) for k in range(25)]
    modes = MillingModes.of(motions, name, values, 28, _FROM_RAD)
    feed = v[20] or v[14] if v[18] % 10 == 2.0 else v[14]
    how = milled((v[15], v[17], v[22], feed, v[13], v[16], v[18]), 0)
    _rays(motions, name, values, modes, v, v[7] / 2.0, how)


def long_holes(motions: Motions, name: str, values: Values) -> None:
    """LONGHOLE(RTP, RFP, SDIS, DP, DPR, NUM, LENG, CPA, CPO, RAD, STA1, INDA, FFD, FFP1, MID): slots as wide as the tool.

    Then VARI UMODE GMODE DMODE AMODE; the way in that VARI chooses is our own.
    """
    v = [filled(values, k) for k in range(16)]
    modes = MillingModes.of(motions, name, values, 17, _FROM_RAD)
    radius = motions.ip.cutting_radius(name)
    how = milled((v[14], 0.0, 0.0, v[13], v[12], 0.0, 0.0), 0)
    _rays(motions, name, values, modes, [*v[:7], 2.0 * radius, *v[7:12]], radius, how)


def _rays(
    motions: Motions,
    name: str,
    values: Values,
    modes: MillingModes,
    v: list[float],
    half: float,
    how: dict[str, float],
) -> None:
    """Clear NUM slots (v[5]) of LENG (v[6]) and half a width about CPA CPO (v[8:10]), from RAD (v[10]) on at STA1 (v[11]) and INDA (v[12])."""
    check_plane(motions, name)
    hole, count = modes.hole(motions, name, values), count_of(name, v[5], "slots")
    step = v[12] or 360.0 / count
    for k in range(count):
        angle = v[11] + k * step
        middle = complex(v[8], v[9]) + cmath.rect(v[10] + v[6] / 2.0, math.radians(angle))
        _cleared(motions, name, hole, Pocket(middle, v[6] / 2.0, half, half, angle), how)
