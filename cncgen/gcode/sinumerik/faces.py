"""Faces and spigots of SINUMERIK: CYCLE61 and CYCLE71 (a rectangle is faced), CYCLE76 and CYCLE77 (a spigot is milled free).

The faced rectangle, the wall, levels, allowances and feeds are the cycle's; rows, loops and the way to them are our own.
"""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.pockets import Clearing, Pocket, PocketPath
from cncgen.gcode.codes.steps import MOST, levels_of, steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.cycle_modes import CORNERS, MillingModes, milled
from cncgen.gcode.sinumerik.cycles import Hole, Values, check_plane, depth_of, filled, milling_feed

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

#: Part of the tool's diameter by which rows and loops step aside where the cycle does not say it.
_USUAL_STEP = 0.8


class _Mill(FlatCutter):
    """A flat cutter over a rectangle: places are turned about its origin."""

    def __init__(
        self,
        motions: Motions,
        name: str,
        hole: Hole,
        feeds: tuple[float, float],
        origin: complex,
        angle: float,
        aside: float = 0.0,
    ) -> None:
        """Take the cutter in the spindle, for rows so far `aside`; raise where it has no radius or no feed, or the plane is not G17."""
        check_plane(motions, name)
        super().__init__(motions.ip, origin, cmath.rect(1.0, math.radians(angle)))
        self.name, self.hole, self.angle = name, hole, angle
        self.radius = motions.ip.cutting_radius(name, least=aside / 2.0 / _USUAL_STEP)
        message = f"{name} steps aside by a part of the tool, which has no radius"
        hint = "--tool-table gives the diameter of the tool"
        refuse(name, (self.radius <= 0.0, "cycle-tool", message, hint))
        self.cutting = milling_feed(motions, name, feeds[0])
        self.feed_down = feeds[1] or motions.ip.state.feed
        motions.ip.state.motion = 10
        self.to(z=hole.back, rapid=True)

    def levels(self, floor: float, infeed: float, rough: bool) -> tuple[float, ...]:
        """Return the levels down to an allowance above the floor, or the floor alone to finish it."""
        hole = self.hole
        return levels_of(hole.reference, hole.depth + floor, infeed, self.name) if rough else (hole.depth,)

    def down(self, place: complex, level: float) -> None:
        """Go to a place beside the part, and down to a level."""
        self.to(place, rapid=True)
        self.to(z=self.hole.start, rapid=True)
        self.plunge(level, self.feed_down, self.cutting)

    def end(self) -> None:
        """Go to the retraction plane, with the program's feed in force again."""
        self.feed(self.ip.state.feed)
        self.to(z=self.hole.back, rapid=True)


def _kind(name: str, vari: float) -> tuple[bool, int]:
    message = f"VARI = {vari:g} of {name} neither roughs nor finishes"
    hint = "VARI ends in 1 to rough, in 2 to finish"
    refuse(name, (vari % 10 not in (1.0, 2.0), "not-read", message, hint))
    return vari % 10 == 1.0, round(vari) // 10 % 10


def _face(
    mill: _Mill, size: tuple[float, float], step: float, levels: tuple[float, ...], way: int, over: float
) -> None:
    """Mill rows over a rectangle from its corner on, along its first axis (way 1, 3) or second (2, 4), in one sense (1, 2) or both."""
    along, across = size if way in (1, 3) else size[::-1]
    makes = f"{mill.name} makes {{}} rows of {abs(along):g}"
    hint = f"1 to {MOST} rows are made: LENG, WID and MIDA say how many"
    count = steps_of(abs(across), step, mill.name, makes, hint, least=0)
    refuse(
        mill.name,
        (way not in (1, 2, 3, 4), "not-read", f"the tens of VARI of {mill.name} are {way}", "31 goes to and fro along X"),
        (count < 1 or along == 0.0, "cycle-tool", makes.format(count), hint),
    )  # fmt: skip
    if abs(across) / count > 2.0 * mill.radius * (1.0 + 1e-9):
        message = f"rows of {mill.name} lie {abs(across) / count:g} apart, and the tool is {2.0 * mill.radius:g} wide: strips stay between them"
        mill.ip.warn_once("cycle-tool", message, hint="take a smaller MIDA, or a wider tool")
    sense = math.copysign(1.0, along)
    ends = (-sense * (mill.radius + over), along + sense * (mill.radius + over))

    def place(k: int, end: float) -> complex:
        # Of rows narrower than the tool's radius, the first lie before the corner: only so their edge cuts no more than a row.
        aside = math.copysign(1.0, across) * (abs(across) * (k + 1) / count - mill.radius)
        return complex(end, aside) if way in (1, 3) else complex(aside, end)

    for level in levels:
        mill.to(z=mill.hole.start, rapid=True)
        mill.down(place(0, ends[0]), level)
        for k in range(count):
            first, last = ends if way < 3 or k % 2 == 0 else ends[::-1]
            if k and way < 3:
                mill.to(z=mill.hole.start, rapid=True)
                mill.down(place(k, first), level)
            elif k:
                mill.to(place(k, first))
            mill.to(place(k, last))
    mill.end()


def face(motions: Motions, name: str, values: Values) -> None:
    """CYCLE71(RTP, RFP, SDIS, DP, PA, PO, LENG, WID, STA, MID, MIDA, FDP, FALD, FFP1, VARI, FDP1)."""
    v = [filled(values, k) for k in range(16)]
    rough, way = _kind(name, v[14])
    hole = Hole.of(motions, name, [*values[:3], depth_of(name, values)])
    mill = _Mill(motions, name, hole, (v[13], v[13]), complex(v[4], v[5]), v[8], v[10])
    step = v[10] or _USUAL_STEP * 2.0 * mill.radius
    _face(mill, (v[6], v[7]), step, mill.levels(v[12], v[9], rough), way, abs(v[11]))


def face_of_blank(motions: Motions, name: str, values: Values) -> None:
    """CYCLE61(RTP, RFP, SDIS, DP, PA, PO, LENG, WID, MID, MIDA, FALD, FFP1, VARI, LIM, DMODE, AMODE).

    The ones of AMODE tell whether DP is a distance (1), the tens whether MIDA is a part of the tool's diameter in percent (1). Thousands and
    ten thousands tell whether LENG and WID are coordinates (1), which is read where PA and PO are 0: then they are distances as well.
    """
    v = [filled(values, k) for k in range(16)]
    mode, corners = round(v[15]) % 1000, round(v[15]) // 1000
    beside = (corners % 10 == 1 and v[4] != 0.0) or (corners // 10 == 1 and v[5] != 0.0)
    unread = (
        mode // 100 or v[13] or mode % 10 > 1 or mode // 10 > 1 or corners not in (0, 1, 10, 11) or beside
    )
    message = f"AMODE = {v[15]:g} or LIM = {v[13]:g} of {name} (corners as coordinates, sides that bound the face) is not read"
    hint = "AMODE = 10 has the depth as a coordinate and the infeed in percent"
    refuse(name, (bool(unread), "not-read", message, hint))
    depth = v[1] - abs(v[3]) if mode % 10 == 1 else depth_of(name, values)
    hole = Hole.of(motions, name, [*values[:3], depth])
    mill = _Mill(
        motions, name, hole, (v[11], v[11]), complex(v[4], v[5]), 0.0, 0.0 if mode // 10 == 1 else v[9]
    )
    rough, way = _kind(name, v[12])
    step = v[9] * (2.0 * mill.radius / 100.0 if mode // 10 == 1 else 1.0) or _USUAL_STEP * 2.0 * mill.radius
    _face(mill, (v[6], v[7]), step, mill.levels(v[10], v[8], rough), way, 0.0)


def _round(mill: _Mill, half: complex, corner: float, excess: float, values: dict[str, float]) -> None:
    """Mill a spigot of half a length and half a width free, whose blank is wider by an excess: loops from the outside in, at each level."""
    rough, _ = _kind(mill.name, values["vari"] or 1.0)
    side, floor = (values["fal"], values["fald"]) if rough else (0.0, 0.0)
    step = _USUAL_STEP * 2.0 * mill.radius
    count = steps_of(excess - side, step, mill.name, f"{mill.name} makes {{}} loops")
    wrong = min(half.real, half.imag) <= 0.0 or values["cdir"] not in (0.0, 1.0, 2.0, 3.0)
    message = f"the size or sense (CDIR = {values['cdir']:g}) of {mill.name} has no meaning"
    refuse(mill.name, (wrong, "cycle-tool", message, "LENG, WID or the diameter are above 0; CDIR is 0 to 3"))
    # Climb milling beside an outer wall goes clockwise where the spindle does.
    turns_right = mill.ip.state.direction >= 0
    clockwise = {0.0: turns_right, 1.0: not turns_right, 2.0: True, 3.0: False}[values["cdir"]]
    levels = mill.levels(floor, values["mid"], rough)
    away = half.real + max(excess, side) + 2.0 * mill.radius + abs(mill.hole.start - mill.hole.reference)
    # Seen with its length along Y, so that loops begin at the side towards X+.
    wall = Pocket(mill.origin, half.imag, half.real, corner, mill.angle + 90.0)
    sense = -1 if clockwise else 1
    how = Clearing(-mill.radius, step, levels, mill.hole.start, mill.cutting, mill.feed_down, sense)
    PocketPath(mill.ip, wall, how).free(complex(0.0, -away), side, count)
    mill.end()


def rectangle(motions: Motions, name: str, values: Values) -> None:
    """CYCLE76(RTP, RFP, SDIS, DP, DPR, LENG, WID, CRAD, PA, PO, STA, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, AP1, AP2), then FS ZFS GMODE DMODE AMODE."""
    v = [filled(values, k) for k in range(20)]
    how = milled(v[:18], 11)
    modes = MillingModes.of(motions, name, values, 22, CORNERS)
    (x, y) = modes.corner
    half = complex(abs(v[5]), abs(v[6])) / 2.0
    feeds = (how["feed"], how["plunge"] or how["feed"])
    middle = complex(v[8], v[9]) + complex(x * half.real, y * half.imag) * cmath.rect(
        1.0, math.radians(v[10])
    )
    mill = _Mill(motions, name, modes.hole(motions, name, values), feeds, middle, v[10])
    _round(mill, half, abs(v[7]), max(0.0, v[18] - v[5], v[19] - v[6]) / 2.0, how)


def circle(motions: Motions, name: str, values: Values) -> None:
    """CYCLE77(RTP, RFP, SDIS, DP, DPR, PRAD, PA, PO, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, AP1), then FS ZFS GMODE DMODE AMODE; PRAD and AP1 are diameters."""
    v = [filled(values, k) for k in range(16)]
    how, radius = milled(v[:15], 8), abs(v[5]) / 2.0
    modes = MillingModes.of(motions, name, values, 18)
    feeds = how["feed"], how["plunge"] or how["feed"]
    mill = _Mill(motions, name, modes.hole(motions, name, values), feeds, complex(v[6], v[7]), 0.0)
    _round(mill, complex(radius, radius), radius, max(0.0, v[15] / 2.0 - radius), how)
