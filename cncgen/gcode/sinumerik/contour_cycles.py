"""Cycles along a contour of SINUMERIK: CYCLE72 mills beside it, CYCLE95 turns it (840D, "Programming Guide Cycles").

The contour is a subprogram, or the lines between two labels, "BEGIN:END". It is run once, and its motions in the plane are kept.
Levels, ways on and off, and wall of CYCLE72 are those of the cycle, and so are the levels of CYCLE95. Its way back from a cut is our
own choice.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cncgen.diagnostics import Severity
from cncgen.gcode.codes.lathe_fanuc import Turning
from cncgen.gcode.codes.leads import lead_arc, lead_line
from cncgen.gcode.codes.steps import levels_of
from cncgen.gcode.codes.turning_cycles import Lathe
from cncgen.gcode.codes.turning_cycles_fanuc import levels
from cncgen.gcode.codes.turning_profiles import Segment, backwards, check_cuts, moved_aside
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.sinumerik.arcs import follow
from cncgen.gcode.sinumerik.cycle_modes import MillingModes
from cncgen.gcode.sinumerik.cycles import Hole, Values, filled, given
from cncgen.units import INCH

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

#: How far CYCLE95 lifts off where _VRT does not say, mm.
_LIFT = 1.0


def _contour(motions: Motions, name: str, values: Values, least: int) -> list[Segment]:
    """Return the contour that the first parameter names: its first segment leads to it."""
    text = values[0] if values else None
    if (text is None or text == "") and len(motions.contours) == 1:
        text = motions.contours[0]
    if not isinstance(text, str) or not text.strip():
        message = f"the first parameter of {name} is not the name of a contour"
        hint = f'{name}("CONTOUR", …), {name}("BEGIN:END", …), or CYCLE62 before it'
        raise BlockError("cycle-words", message, name, hint=hint)
    found = motions.contour(text.strip().upper())
    if len(found) < least + 1:
        raise BlockError("profile-length", f"the contour {text} of {name} has fewer than {least} moves", name)
    return found


def _way(segment: Segment, kind: float, aside: float, name: str, *, leaving: bool) -> Segment:
    """Return the way to the first segment of a contour, or away from its last: 1 is a tangential line, 2 a quadrant, 3 a semicircle.

    Its size is that of `aside`, which is above 0 where it lies to the left of the contour.
    """
    message = f"the way on or off {kind:g} of {name} is not read"
    hint = "AS1 and AS2 are 1 (line), 2 (quadrant), 3 (semicircle), in the plane"
    refuse(name, (kind not in (1.0, 2.0, 3.0), "not-read", message, hint))
    point = segment.end if leaving else segment.start
    heading = segment.heading(point)
    if kind == 1.0 or not aside:
        return lead_line(point, heading, abs(aside), leaving=leaving)
    return lead_arc(point, heading, aside, (kind - 1.0) * math.pi / 2.0, leaving=leaving)


def call(motions: Motions, name: str, values: Values) -> None:
    """CYCLE62(KNAME, TYPE, LAB1, LAB2): the contour of the cycles behind it that name none; without parameters, none.

    TYPE 0 is a subprogram, 1 a contour of the editor, between E_LAB_A_KNAME and E_LAB_E_KNAME, 2 what stands between two labels.
    """
    four = (*values, "", "", "", "")[:4]
    texts = [value.strip().upper() if isinstance(value, str) else "" for value in four]
    kind = values[1] if len(values) > 1 else 0.0
    if not any(texts):
        motions.contours.clear()
        return
    names = {0.0: texts[0], 1.0: f"E_LAB_A_{texts[0]}:E_LAB_E_{texts[0]}", 2.0: f"{texts[2]}:{texts[3]}"}
    needed = {0.0: texts[:1], 1.0: texts[:1], 2.0: texts[2:]}
    if kind is not None and not isinstance(kind, str) and kind in names and all(needed[kind]):
        motions.contours.append(names[kind])
        return
    message = f"TYPE = {kind if isinstance(kind, str | None) else f'{kind:g}'} of {name} names no contour that is read"
    hint = (
        '0 is a subprogram, CYCLE62("NAME",0), 1 a contour of the editor, 2 labels, CYCLE62(,2,"BEGIN","END")'
    )
    raise BlockError("cycle-words", message, name, hint=hint)


def mill(motions: Motions, name: str, values: Values) -> None:
    """CYCLE72(KNAME, RTP, RFP, SDIS, DP, MID, FAL, FALD, FFP1, FFD, VARI, RL, AS1, LP1, FF3, AS2, LP2), then UMODE FS ZFS GMODE DMODE AMODE."""
    v = [0.0, *(filled(values, k) for k in range(1, 17))]
    modes = MillingModes.of(motions, name, values, 20)
    vari, side = round(v[10]) % 10_000, round(v[11])
    # Whether the side of a contour that is milled backwards is that of its own direction, no text says.
    reverse = round(v[10]) // 10_000
    wrong = vari % 10 not in (1, 2) or vari // 10 % 10 > 1 or vari >= 400 or side not in (40, 41, 42)
    wrong |= reverse not in (0, 1) or (reverse == 1 and side != 40)
    message = f"VARI = {v[10]:g}, RL = {side} or a parameter behind LP2 of {name} is not read"
    hint = "VARI is 1 or 2, 10 more for G1 between, 0 to 300 more for the way up, 10000 more for backwards with RL = 40; RL is 40, 41 or 42"
    refuse(name, (wrong or filled(values, 17) != 0.0, "not-read", message, hint))
    depth = given(values, 4)
    hole = Hole.of(motions, name, [v[1], v[2], v[3], None if depth is None else modes.depth_of(depth, v[2])])
    ip, rough = motions.ip, vari % 10 == 1
    radius = ip.cutting_radius(name) if side != 40 else 0.0
    before = ip.state.feed
    feed, plunge, between = v[8] or before, v[9] or v[8] or before, v[14] or v[8] or before
    if (side != 40 and radius <= 0.0) or feed <= 0.0:
        message = f"{name} has no feed FFP1, or with RL = {side} a tool without a radius"
        raise BlockError("cycle-tool", message, name, hint="--tool-table gives the diameter of the tool")
    contour = _contour(motions, name, values, 1)[1:]
    contour = backwards(contour) if reverse else contour
    left = side == 41
    path = contour if side == 40 else moved_aside(contour, radius + (v[6] if rough else 0.0), left)
    spin = 1 if side != 42 else -1
    on = _way(path[0], v[12] or 1.0, spin * abs(v[13]), name, leaving=False)
    off = _way(path[-1], v[15] or 1.0, spin * abs(v[16]), name, leaving=True)
    hole.go(max(hole.back, ip.state.position[motions.plane()[2]]), rapid=True)
    steps = levels_of(hole.reference, hole.depth + (v[7] if rough else 0.0), v[5], name)
    for k, level in enumerate(steps):
        rapid = k == 0 or vari // 10 % 10 == 0
        hole.feed(None if rapid else between)
        follow(motions, on.start, rapid=rapid)
        if k == 0 or vari // 100 < 2:
            hole.go(hole.start, rapid=True)
        hole.feed(plunge)
        hole.go(level, rapid=False)
        hole.feed(feed)
        for segment in (on, *path):
            follow(motions, segment.end, segment.centre, segment.spin)
        hole.feed(between)
        follow(motions, off.end, off.centre, off.spin)
        if level != steps[-1] and vari // 100 < 3:
            hole.go((hole.back, hole.start, level + abs(v[3]))[vari // 100], rapid=True)
    hole.go(hole.back, rapid=True)
    hole.feed(before)


def turn(motions: Motions, name: str, values: Values) -> None:
    """CYCLE95(NPP, MID, FALZ, FALX, FAL, FF1, FF2, FF3, VARI, DT, DAM, VRT): roughs (VARI 1 to 4), finishes (5 to 8), or both (9 to 12).

    Each four are along Z outside, along X outside, along Z inside, along X inside; 200 more leave the corners of the levels.
    """
    v = [0.0, *(filled(values, k) for k in range(1, 12))]
    vari, ip = round(v[8]) % 200, motions.ip
    kinds = 1 <= vari <= 12 and round(v[8]) // 200 <= 1
    faults = (
        (not kinds, f"has VARI = {v[8]:g}", "VARI is 1 to 12, or 200 more"),
        (ip.state.plane != 18, "works in the plane G18", "G18 stands before it"),
        (vari not in range(5, 9) and v[1] <= 0.0, "has no infeed MID", "MID is the depth of a cut"),
        (min(v[2:5]) < 0.0, "has an allowance below 0", "FALZ, FALX and FAL are without a sign"),
    )
    refuse(name, *((wrong, "cycle-words", f"{name} {what}", hint) for wrong, what, hint in faults))
    inside, swap = (vari - 1) // 2 % 2 == 1, vari % 2 == 0
    contour = _contour(motions, name, values, 1)[1:]
    ends, outwards = (contour[0].start, contour[-1].end), -1.0 if inside and not swap else 1.0
    low, high = sorted(ends, key=lambda p: (p.real if swap else p.imag) * outwards)
    contour = contour if ends[0] == low else backwards(contour)
    travel = (high - low).imag if swap else (high - low).real
    across = complex(math.copysign(1.0, travel), outwards)
    path = [segment.seen(across, swap) for segment in contour]
    returns = not all(segment.advances() for segment in path)
    message = f"the contour of {name} goes back along {'X' if swap else 'Z'}"
    refuse(name, (returns, "profile-not-monotonic", message, "cut what lies behind in a cycle of its own"))
    lift = v[11] or (_LIFT / INCH if ip.state.inches else _LIFT)
    before, lathe = ip.state.feed, Lathe(ip, across, swap)
    tool = ip.tools.find(ip.state.tool)
    if motions.edge and tool and tool.diameter:
        message = f"{name} turns without the radius of the tool's nose"
        hint = "G42 and the contour itself finish with it"
        ip.warn(BlockError("comp-roughing", message, name, hint=hint), Severity.WARNING)
    if vari < 5 or vari > 8:
        # FAL moves the contour aside, FALZ and FALX back and up.
        back, up = (v[3], v[2]) if swap else (v[2], v[3])
        rough = [segment.shifted(complex(-back, up)) for segment in moved_aside(path, v[4], True)]
        top = max(p.imag for segment in rough for p in segment.extremes())
        bottom = min(p.imag for segment in rough for p in segment.extremes())
        check_cuts(top, bottom, v[1], name)
        count = math.ceil((top - bottom) / v[1] - 1e-9)
        _feed(motions, v[5] or before, name)
        kept = Turning(depth=(top - bottom) / max(count, 1), escape=lift)
        levels(lathe, rough, complex(rough[0].start.real - lift, top), kept, False, name)
        lathe.rapid(complex(rough[-1].end.real, top + lift))
        lathe.rapid(complex(rough[0].start.real - lift, top + lift))
    if vari > 4:
        _feed(motions, v[7] or before, name)
        top = max(p.imag for segment in path for p in segment.extremes())
        lathe.rapid(complex(path[0].start.real - lift, top + lift))
        lathe.rapid(complex(path[0].start.real - lift, path[0].start.imag))
        lathe.feed(path[0].start)
        for segment in path:
            lathe.follow(segment, segment.end)
        lathe.rapid(complex(path[-1].end.real, path[-1].end.imag + lift))
        lathe.rapid(complex(path[-1].end.real, top + lift))
        lathe.rapid(complex(path[0].start.real - lift, top + lift))
    ip.state.moved = True
    if before:
        motions.emit({"f": before})


def _feed(motions: Motions, feed: float, name: str) -> None:
    if feed <= 0.0:
        raise BlockError("feed-missing", f"{name} has no feed", name, hint="FF1 roughs, FF3 finishes")
    motions.emit({"f": feed})


CYCLES = {"CYCLE62": call, "CYCLE72": mill, "CYCLE95": turn}
