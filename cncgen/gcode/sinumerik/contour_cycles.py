"""Cycles along a contour of SINUMERIK: CYCLE72 mills beside it, CYCLE95 turns it (840D, "Programming Guide Cycles").

The contour is a subprogram, or the lines between two labels, "BEGIN:END". It is run once, and its motions in the plane are kept.
Levels, ways on and off, and wall of CYCLE72 are those of the cycle, and so are the levels of CYCLE95. Its way back from a cut is our
own choice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from cncgen.gcode.codes.lathe_fanuc import Turning
from cncgen.gcode.codes.leads import lead_arc, lead_line
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.steps import levels_of
from cncgen.gcode.codes.turning_cycles import Lathe
from cncgen.gcode.codes.turning_cycles_fanuc import levels
from cncgen.gcode.codes.turning_profiles import ROUNDED, Segment, backwards, check_cuts, moved_aside
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.sinumerik.arcs import follow
from cncgen.gcode.sinumerik.cycle_modes import MillingModes
from cncgen.gcode.sinumerik.cycles import Values, filled, given

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


class _Variant(NamedTuple):
    """VARI of CYCLE72 by its digits: roughs or finishes, how the tool goes to the next level and how far up between, and backwards."""

    rough: bool
    between_at_feed: bool
    up: int
    reverse: bool

    @classmethod
    def of(cls, name: str, vari: float, side: int, more: bool) -> _Variant:
        """Return what a value says; raise where one of them is not read.

        Args:
            name: Of the cycle.
            vari, side: VARI and RL.
            more: Whether the cycle has a parameter behind LP2.
        """
        digits, kind, between = round(vari), round(vari) % 10, round(vari) // 10 % 10
        up, reverse = round(vari) % 10_000 // 100, round(vari) // 10_000
        wrong = more or kind not in (1, 2) or between not in (0, 1) or not 0 <= up <= 3 or digits < 0
        # Whether the side of a contour that is milled backwards is that of its own direction, no text says.
        wrong |= side not in (40, 41, 42) or reverse not in (0, 1) or (reverse == 1 and side != 40)
        message = f"VARI = {vari:g}, RL = {side} or a parameter behind LP2 of {name} is not read"
        hint = "VARI is 1 or 2, 10 more for G1 between, 0 to 300 more for the way up, 10000 more for backwards with RL = 40; RL is 40, 41 or 42"
        refuse(name, (wrong, "not-read", message, hint))
        return cls(kind == 1, between == 1, up, reverse == 1)


def mill(motions: Motions, name: str, values: Values) -> None:
    """CYCLE72(KNAME, RTP, RFP, SDIS, DP, MID, FAL, FALD, FFP1, FFD, VARI, RL, AS1, LP1, FF3, AS2, LP2), then UMODE FS ZFS GMODE DMODE AMODE."""
    v = [0.0, *(filled(values, k) for k in range(1, 17))]
    modes, side = MillingModes.of(motions, name, values, 20), round(v[11])
    variant = _Variant.of(name, v[10], side, filled(values, 17) != 0.0)
    hole = modes.hole_to(motions, name, values[1:4], given(values, 4))
    ip = motions.ip
    radius = ip.cutting_radius(name) if side != 40 else 0.0
    before = ip.state.feed
    feed, plunge, between = v[8] or before, v[9] or v[8] or before, v[14] or v[8] or before
    if (side != 40 and radius <= 0.0) or feed <= 0.0:
        message = f"{name} has no feed FFP1, or with RL = {side} a tool without a radius"
        raise BlockError("cycle-tool", message, name, hint="--tool-table gives the diameter of the tool")
    contour = _contour(motions, name, values, 1)[1:]
    contour = backwards(contour) if variant.reverse else contour
    aside, deep = (v[6], v[7]) if variant.rough else (0.0, 0.0)
    path = contour if side == 40 else moved_aside(contour, radius + aside, side == 41)
    spin = 1 if side != 42 else -1
    on = _way(path[0], v[12] or 1.0, spin * abs(v[13]), name, leaving=False)
    off = _way(path[-1], v[15] or 1.0, spin * abs(v[16]), name, leaving=True)
    hole.go(max(hole.back, ip.state.position[motions.plane()[2]]), rapid=True)
    steps = levels_of(hole.reference, hole.depth + deep, v[5], name)
    for k, level in enumerate(steps):
        rapid = k == 0 or not variant.between_at_feed
        hole.feed(None if rapid else between)
        follow(motions, on.start, rapid=rapid)
        if k == 0 or variant.up < 2:
            hole.go(hole.start, rapid=True)
        hole.feed(plunge)
        hole.go(level, rapid=False)
        hole.feed(feed)
        for segment in (on, *path):
            follow(motions, segment.end, segment.centre, segment.spin)
        hole.feed(between)
        follow(motions, off.end, off.centre, off.spin)
        if level != steps[-1] and variant.up < 3:
            hole.go((hole.back, hole.start, level + abs(v[3]))[variant.up], rapid=True)
    hole.go(hole.back, rapid=True)
    hole.feed(before)


def turn(motions: Motions, name: str, values: Values) -> None:
    """CYCLE95(NPP, MID, FALZ, FALX, FAL, FF1, FF2, FF3, VARI, DT, DAM, VRT): roughs (VARI 1 to 4), finishes (5 to 8), or both (9 to 12).

    Each four are along Z outside, along X outside, along Z inside, along X inside; 200 more leave the corners of the levels.
    """
    v = [0.0, *(filled(values, k) for k in range(1, 12))]
    vari, ip = round(v[8]) % 200, motions.ip
    kinds = 1 <= vari <= 12 and round(v[8]) // 200 <= 1
    roughs, finishes = not 5 <= vari <= 8, vari > 4
    faults = (
        (not kinds, f"has VARI = {v[8]:g}", "VARI is 1 to 12, or 200 more"),
        (ip.state.plane != 18, "works in the plane G18", "G18 stands before it"),
        (roughs and v[1] <= 0.0, "has no infeed MID", "MID is the depth of a cut"),
        (min(v[2:5]) < 0.0, "has an allowance below 0", "FALZ, FALX and FAL are without a sign"),
    )
    refuse(name, *((wrong, "cycle-words", f"{name} {what}", hint) for wrong, what, hint in faults))
    cuts = Cuts.of(motions, name, _contour(motions, name, values, 1)[1:], vari, v[11])
    before = ip.state.feed
    tell_nose(motions, name)
    if roughs:
        at_feed(motions, v[5] or before, name)
        cuts.rough(v[1], v[2], v[3], v[4])
    if finishes:
        at_feed(motions, v[7] or before, name)
        cuts.finish()
    ip.state.moved = True
    if before:
        motions.emit({"f": before})


@dataclass(frozen=True, slots=True)
class Cuts:
    """The cuts of CYCLE95 and CYCLE951 along a path: its first coordinate is that of the cuts, its second leads away from the material.

    Attributes:
        swap: Whether cuts are along X.
        lift: How far the tool lifts off.
    """

    lathe: Lathe
    path: list[Segment]
    swap: bool
    lift: float
    name: str

    @classmethod
    def of(cls, motions: Motions, name: str, contour: list[Segment], vari: int, lift: float) -> Cuts:
        """Return the cuts along a contour from where it is nearest to the material's middle on; raise where the contour goes back along the cuts."""
        inside, swap = (vari - 1) // 2 % 2 == 1, vari % 2 == 0
        ends, outwards = (contour[0].start, contour[-1].end), -1.0 if inside and not swap else 1.0
        low, high = sorted(ends, key=lambda p: (p.real if swap else p.imag) * outwards)
        contour = contour if ends[0] == low else backwards(contour)
        travel = (high - low).imag if swap else (high - low).real
        across = complex(math.copysign(1.0, travel), outwards)
        path = [segment.seen(across, swap) for segment in contour]
        returns = not all(segment.advances(ROUNDED) for segment in path)
        message = f"the contour of {name} goes back along {'X' if swap else 'Z'}"
        hint = "cut what lies behind in a cycle of its own"
        refuse(name, (returns, "profile-not-monotonic", message, hint))
        return cls(
            Lathe(motions.ip, across, swap), path, swap, lift or _LIFT / motions.ip.state.unit_mm, name
        )

    def rough(self, infeed: float, along_z: float, along_x: float, aside: float) -> None:
        """Cut in levels, and leave allowances: FAL moves the contour aside, FALZ and FALX back and up."""
        back, up = (along_x, along_z) if self.swap else (along_z, along_x)
        rough = [segment.shifted(complex(-back, up)) for segment in moved_aside(self.path, aside, True)]
        heights = [p.imag for segment in rough for p in segment.extremes()]
        top, height = max(heights), max(heights) - min(heights)
        check_cuts(top, min(heights), infeed, self.name)
        count = math.ceil(height / infeed - 1e-9)
        kept = Turning(depth=height / max(count, 1), escape=self.lift)
        levels(self.lathe, rough, complex(rough[0].start.real - self.lift, top), kept, False, self.name)
        self._leave(rough, top)

    def finish(self) -> None:
        """Cut once along the contour."""
        path, lathe, before = self.path, self.lathe, self.path[0].start.real - self.lift
        top = max(p.imag for segment in path for p in segment.extremes())
        lathe.rapid(complex(before, top + self.lift))
        lathe.rapid(complex(before, path[0].start.imag))
        lathe.feed(path[0].start)
        for segment in path:
            lathe.follow(segment, segment.end)
        lathe.rapid(complex(path[-1].end.real, path[-1].end.imag + self.lift))
        self._leave(path, top)

    def _leave(self, path: list[Segment], top: float) -> None:
        """Go above all of a path, and back to before it."""
        self.lathe.rapid(complex(path[-1].end.real, top + self.lift))
        self.lathe.rapid(complex(path[0].start.real - self.lift, top + self.lift))


def tell_nose(motions: Motions, name: str) -> None:
    """Warn that the radius of the tool's nose is not taken into account."""
    tool = motions.ip.tools.find(motions.ip.state.tool)
    if motions.edge and tool and tool.diameter:
        message = f"{name} turns without the radius of the tool's nose"
        motions.ip.warn("comp-roughing", message, name, "G42 and the contour itself finish with it")


def at_feed(motions: Motions, feed: float, name: str) -> None:
    """Put the feed of a cycle in force; raise where there is none."""
    if feed <= 0.0:
        raise BlockError("feed-missing", f"{name} has no feed", name, hint="FF1 roughs, FF3 finishes")
    motions.emit({"f": feed})
    check_feed(motions.ip, motions.ip.base.block, name)


CYCLES = {"CYCLE62": call, "CYCLE72": mill, "CYCLE95": turn}
