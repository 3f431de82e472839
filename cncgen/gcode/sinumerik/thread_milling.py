"""CYCLE90 and CYCLE70 of SINUMERIK: a thread inside or outside, milled in one helix (840D/840Di/810D, Programming Guide, Cycles, 3.2).

The order of the moves, which circle leads on and off the thread in which sense, and how far below the thread and before it that is, are the
manual's. The size of these circles, and the angle at which the thread begins, X+ of its middle, are ours.
"""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.steps import MOST
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.cycle_modes import MillingModes
from cncgen.gcode.sinumerik.cycles import Hole, Values, check_plane, doubt_order, filled, given, milling_feed

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

_TINY = 1e-9


def thread(motions: Motions, name: str, values: Values) -> None:
    """CYCLE90(RTP, RFP, SDIS, DP, DPR, DIATH, KDIAM, PIT, FFR, CDIR, TYPTH, CPA, CPO).

    From SDIS above RFP to DP: CDIR 2 clockwise, 3 counter-clockwise, TYPTH 0 inside, at the nominal diameter DIATH, 1 outside, at the core's
    KDIAM. The tool gets as far beyond the thread as PIT / 4 (2 WR + RDIFF) / DIATH, with its radius WR and RDIFF = DIATH / 2 ∓ WR.
    """
    v = [filled(values, k) for k in range(13)]
    outer, core, pitch, sense, kind = v[5], v[6], v[7], round(v[9]), round(v[10])
    check_plane(motions, name)
    hole = Hole.of(motions, name, values)
    half = core / 2.0 if kind == 1 else outer / 2.0
    tool = motions.ip.cutting_radius(name, math.inf if kind == 1 else half)
    radius = half + tool if kind == 1 else half - tool
    hint = "DIATH and KDIAM are the diameters, PIT the lead, CDIR 2 or 3, TYPTH 0 inside or 1 outside"
    faults = (
        (sense not in (2, 3) or kind not in (0, 1), f"CDIR = {v[9]:g} or TYPTH = {v[10]:g} of {name} has no meaning"),
        (pitch <= 0.0 or min(outer, half) <= 0.0 or 0.0 < outer < core, f"{name} has the diameters {outer:g} and {core:g} and the lead {pitch:g}"),
        (radius <= 0.0 or tool <= 0.0, f"{name} is {2.0 * half:g} wide, and the tool has the diameter {2.0 * tool:g}"),
        (kind == 0 and 0.0 < core < 2.0 * tool - _TINY, f"the tool, {2.0 * tool:g} wide, does not go into the core of {name}, {core:g}"),
        ((hole.start - hole.depth) / max(pitch, _TINY) > MOST, f"PIT = {pitch:g} of {name} makes more than {MOST} turns"),
    )  # fmt: skip
    refuse(name, *((wrong, "cycle-tool", message, hint) for wrong, message in faults))
    beyond = pitch / 4.0 * (2.0 * tool + (outer / 2.0 + tool if kind == 1 else outer / 2.0 - tool)) / outer
    middle, before = complex(v[11], v[12]), motions.ip.state.feed
    hole.go(hole.back, rapid=True)
    path = _Path(motions, middle, radius, -1 if sense == 2 else 1, tool if kind == 1 else 0.0)
    path.lead_begins()
    hole.go(hole.start, rapid=True)
    hole.feed(milling_feed(motions, name, v[8]))
    path.lead(1.0 + 0j, hole.start - beyond, on=True)
    end = path.helix(hole.start - beyond, hole.depth, pitch)
    path.lead(end, hole.depth - beyond, on=False)
    hole.feed(before)
    if kind == 0:
        motions.move({"X": middle.real, "Y": middle.imag}, rapid=True)
    hole.go(hole.back, rapid=True)


def thread_of_profile(motions: Motions, name: str, values: Values) -> None:
    """CYCLE70(RTP, RFP, SDIS, DP, DIATH, H1, FAL, PIT, NT, MID, FFR, TYPTH, PA, PO, NSP, VARI, PITA), then PITM PTAB PTABA GMODE DMODE AMODE.

    The root of the thread lies at DIATH inside, and H1 within it outside. VARI roughs in passes of MID down to the allowance FAL (ones 1) or
    finishes (2), downwards (tens 1) or upwards (2), a thread to the right (hundreds 0) or left (1), which begins at NSP. Passes are of equal
    depth, the helix reaches from SDIS above RFP to DP, and the ways on and off it are those of CYCLE90: they are our own.
    """
    v = [filled(values, k) for k in range(17)]
    modes = MillingModes.of(motions, name, values, 20)
    check_plane(motions, name)
    hole = modes.hole_to(motions, name, values[:3], given(values, 3))
    outer, depth, left, pitch, kind, vari = v[4], v[5], v[6], v[7], round(v[11]), round(v[15])
    how, way, hand = vari % 10, vari // 10 % 10, vari // 100 % 10
    root = outer / 2.0 - depth if kind == 1 else outer / 2.0
    tool = motions.ip.cutting_radius(name, math.inf if kind == 1 else root - depth)
    height = abs(hole.start - hole.depth)
    hint = "DIATH is the nominal diameter, H1 the depth of the thread, PIT its lead, TYPTH 0 inside or 1 outside, VARI as 11 or 122"
    faults = (
        (how not in (1, 2) or way not in (1, 2) or hand > 1 or vari > 199 or kind not in (0, 1), f"VARI = {vari} or TYPTH = {kind} of {name} has no meaning"),
        (round(v[8]) > 1 or round(v[16]) > 1, f"NT = {v[8]:g} (a tool of several teeth) or PITA = {v[16]:g} (another unit of the lead) of {name} is not read"),
        (pitch <= 0.0 or height / max(pitch, _TINY) > MOST, f"{name} has the lead {pitch:g}"),
        (depth <= 0.0 or not 0.0 <= left < depth or depth / (v[9] or depth) > MOST, f"{name} has the depth {depth:g}, the allowance {left:g} and passes of {v[9]:g}"),
        (tool <= 0.0 or root <= 0.0 or (kind == 0 and tool > root - depth + _TINY), f"the tool, {2.0 * tool:g} wide, does not go into {name} of {outer:g}"),
    )  # fmt: skip
    refuse(name, *((wrong, "cycle-tool", message, hint) for wrong, message in faults))
    doubt_order(
        motions,
        name,
        "RTP RFP SDIS DP DIATH H1 FAL PIT NT MID FFR TYPTH PA PO NSP VARI: are the values these?",
    )
    aim = depth - (left if how == 1 else 0.0)
    count = math.ceil(aim / v[9] - _TINY) if how == 1 and v[9] > 0.0 else 1
    # Seen from above a thread to the right goes up counter-clockwise.
    sense = (1 if way == 2 else -1) * (-1 if hand else 1)
    ends = (hole.start, hole.depth) if way == 1 else (hole.depth, hole.start)
    beyond = math.copysign(pitch / 4.0, ends[1] - ends[0])
    middle, before = complex(v[12], v[13]), motions.ip.state.feed
    spoke = cmath.rect(1.0, math.radians(v[14]))
    hole.go(hole.back, rapid=True)
    for k in range(1, count + 1):
        short = depth - aim * k / count
        radius = root + tool + short if kind == 1 else root - tool - short
        path = _Path(motions, middle, radius, sense, tool if kind == 1 else 0.0)
        path.lead_begins(spoke)
        hole.go(max(ends[0] - beyond, hole.start) if way == 1 else hole.start, rapid=True)
        hole.feed(milling_feed(motions, name, v[10]))
        hole.go(ends[0] - beyond, rapid=False)
        path.lead(spoke, ends[0], on=True)
        end = path.helix(*ends, pitch, spoke)
        path.lead(end, ends[1] + beyond, on=False)
        hole.go(hole.start, rapid=True)
    hole.feed(before)
    hole.go(hole.back, rapid=True)


class _Path(FlatCutter):
    """The tool's path about the middle of a thread: places are relative to it, in units of the radius of the path.

    Outside, a quarter of a circle of the tool's radius leads to the path and away from it, against its sense; inside, half a circle from the
    middle, in its sense.
    """

    def __init__(self, motions: Motions, middle: complex, radius: float, sense: int, lead: float) -> None:
        super().__init__(motions.ip, middle)
        self.radius, self.sense, self._lead = radius, sense, lead

    def _aside(self, spoke: complex, *, on: bool) -> tuple[complex, complex, int]:
        """Return where the way to or from a place of the path is farthest from it, the centre of its arc and its sense."""
        if not self._lead:
            return 0j, spoke * self.radius / 2.0, self.sense
        centre = spoke * (self.radius + self._lead)
        # Clockwise, the way comes from the first quadrant to X+, and leads on into the fourth.
        back = 1.0 if on else -1.0
        return centre - back * self.sense * 1j * spoke * self._lead, centre, -self.sense

    def lead_begins(self, spoke: complex = 1.0 + 0j) -> None:
        """Go to where the way to the thread begins, which starts at a direction from its middle."""
        self.to(self._aside(spoke, on=True)[0], rapid=True)

    def lead(self, spoke: complex, level: float, *, on: bool) -> None:
        """Go on the thread at a direction from its middle, or off it."""
        aside, centre, sense = self._aside(spoke, on=on)
        self.arc(spoke * self.radius if on else aside, centre, sense, level)

    def helix(self, top: float, bottom: float, pitch: float, begin: complex = 1.0 + 0j) -> complex:
        """Go down the thread, or up, from a direction on; return the direction in which it ends."""
        turn = 2.0 * math.pi * abs(top - bottom) / pitch
        count = math.ceil(turn / (2.0 * math.pi) - _TINY)
        spoke = begin * cmath.rect(1.0, self.sense * turn)
        if abs(spoke - begin) < _TINY:
            spoke = begin
        self.arc(spoke * self.radius, 0j, self.sense * count, bottom)
        return spoke
