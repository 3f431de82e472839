"""CYCLE93 of SINUMERIK: grooves along Z, outside or inside, from the left or the right (840D, turning cycles, "CYCLE93"), and CYCLE92: cutting off.

The shape is the cycle's. The plunges are ours, after the sister cycle CYCLE930 (840D sl, Operating Manual Turning 05/2017, 10.2.3): a groove
wider than the tool is cut in several plunges, each at most four fifths of its width beside the last. The left corner of the tool is where
the program's Z is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cncgen.gcode.codes.steps import steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.arcs import follow
from cncgen.gcode.sinumerik.contour_cycles import at_feed
from cncgen.gcode.sinumerik.cycles import Values, check_mode_plane, doubt_order, filled, given

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

#: The width of a tool that no table gives, and how far it lifts off where VRT does not say, mm; the part of its width between plunges.
_WIDTH, _LIFT, _ASIDE = 3.0, 1.0, 0.8
_TINY = 1e-9


@dataclass(slots=True)
class _Groove:
    """A groove seen from outside: Z along it, the height above the axis, negative for grooves inside; `side` is -1 there.

    Attributes:
        left, right: Its walls along Z.
        top, base: The heights of its edge and base.
        inner: The corners of the base, left and right: above 0 a radius, below 0 the leg of a chamfer.
        width: Of the tool.
        lift: How far the tool lifts off.
    """

    motions: Motions
    side: int
    left: float
    right: float
    top: float
    base: float
    inner: tuple[float, float]
    width: float
    lift: float

    @property
    def middle(self) -> float:
        """Where the two halves of the base meet, between its corners."""
        left, right = map(abs, self.inner)
        return (self.left + left + self.right - right - self.width) / 2.0

    def floor(self, z: float) -> float:
        """Return the height down to which the tool may go at a place without cutting into the corners of the base."""
        lows = [0.0]
        for size, away in zip(self.inner, (z - self.left, self.right - self.width - z), strict=True):
            short = abs(size) - away
            if short > 0.0:
                lows.append(size - math.sqrt(max(size * size - short * short, 0.0)) if size > 0.0 else short)
        return self.base + max(lows)

    def to(self, z: float, height: float, *, rapid: bool = False) -> None:
        """Go to a place of the left corner of the tool."""
        follow(self.motions, complex(z, self.side * height), rapid=rapid)

    def begin(self, z: float) -> None:
        """Traverse above a place: outside the part along Z, else out of it first."""
        above, now = self.top + self.lift, self.motions.ip.state.position
        height = max(self.side * now[0], above)
        if self.side * now[0] < above:
            self.to(now[2], above, rapid=True)
        self.to(z, height, rapid=True)
        if height > above:
            self.to(z, above, rapid=True)

    def plunge(self, z: float, floor: float, count: int, dwell: float) -> None:
        """Cut down to a height in equal steps, lift off between them, wait at the end: seconds, or revolutions where negative."""
        self.begin(z)
        for k in range(1, count + 1):
            height = self.top - (self.top - floor) * k / count
            self.to(z, height)
            if k < count:
                self.to(z, height + self.lift, rapid=True)
        self.motions.dwell(dwell)
        self.to(z, self.top + self.lift, rapid=True)

    def finish(self, edge: float, to_right: bool) -> None:
        """Cut one wall from its edge down, with its corners, and the base to its middle."""
        way = 1 if to_right else -1
        wall = self.left if to_right else self.right - self.width
        corner = self.inner[0 if to_right else 1]
        outer, inner = abs(edge), abs(corner)
        self.begin(wall - way * outer)
        self.to(wall - way * outer, self.top)
        self._corner(wall, self.top - outer, complex(-way * outer, 0.0), edge, -way)
        self.to(wall, self.base + inner)
        self._corner(wall + way * inner, self.base, complex(0.0, inner), corner, way)
        self.to(self.middle, self.base)
        self.to(self.middle, self.top + self.lift, rapid=True)

    def _corner(self, z: float, height: float, centre: complex, size: float, spin: int) -> None:
        """Go to the end of a corner, whose centre is seen from there."""
        if size > 0.0:
            middle = complex(z + centre.real, self.side * (height + centre.imag))
            follow(self.motions, complex(z, self.side * height), middle, spin * self.side)
        elif size < 0.0:
            self.to(z, height)


_Fault = tuple[bool, str, str, str]


def _refuse(motions: Motions, name: str, *faults: _Fault) -> None:
    common = (
        (motions.ip.state.plane != 18, "cycle-words", "works in the plane G18", "G18 stands before it"),
        (motions.diameter == "none", "not-read", "with DIAMOF, where SPD may be a radius, is not read", "DIAMON before it says that X is a diameter"),
    )  # fmt: skip
    refuse(name, *((wrong, code, f"{name} {what}", hint) for wrong, code, what, hint in (*common, *faults)))


def _check(motions: Motions, name: str, v: list[float]) -> None:
    kind, corners = round(v[15]), max(map(abs, v[7:9])) + max(map(abs, v[9:11]))
    _refuse(
        motions,
        name,
        (kind not in (1, 3, 5, 7, 11, 13, 15, 17), "not-read", f"with VARI = {kind} (a groove of a face) is not read", "1, 3, 5, 7, or 10 more are along Z"),
        (any(v[4:7]), "not-read", "with slanting walls or on a slope (STA1, ANG1, ANG2) is not read", "they are 0 for a groove at right angles"),
        (v[2] <= 0.0 or v[3] <= 0.0 or min(v[11:14]) < 0.0 or v[11] >= v[3], "cycle-words",
         f"has the width {v[2]:g}, the depth {v[3]:g}, the allowances {v[11]:g} and {v[12]:g}", "WIDG, DIAG, FAL1, FAL2"),
        (corners > v[3], "cycle-words", "has corners larger than it is deep", "RCO1, RCO2, RCI1, RCI2"),
    )  # fmt: skip


def _width(motions: Motions, name: str, base: float) -> float:
    """Return the width of the tool, for a base of that width between its corners, and say how the groove is cut with it."""
    ip = motions.ip
    known = 2.0 * ip.tool_radius()
    width = known or min(_WIDTH / ip.state.unit_mm, base)
    message = (
        f"the tool, {width:g} wide, does not go into {name}, whose base is {base:g} wide between its corners"
    )
    refuse(name, (not 0.0 < width <= base + _TINY, "cycle-tool", message, "WIDG is the width of the groove"))
    whence = "the diameter of the tool table" if known else "which no tool table gives"
    message = f"{name} plunges with a tool {width:g} wide, {whence}, whose left corner the program's Z is: its passes are cncgen's own"
    hint = "--tool-table gives the width as the diameter; walls and base are the cycle's"
    ip.warn_once("tool-assumed", message, name, hint)
    return width


def groove(motions: Motions, name: str, values: Values) -> None:
    """CYCLE93(SPD, SPL, WIDG, DIAG, STA1, ANG1, ANG2, RCO1, RCO2, RCI1, RCI2, FAL1, FAL2, IDEP, DTB, VARI, VRT), SPD a diameter.

    VARI 1 and 5 are outside, 3 and 7 inside; SPL is the left edge of 1 and 3, the right one of 5 and 7. RCO and RCI round the edge and the
    base above 0 and chamfer them below 0, by their length (CHF) or with 10 more by their leg (CHR).
    """
    v = [filled(values, k) for k in range(17)]
    _check(motions, name, v)
    kind, leg = round(v[15]) % 10, 1.0 if round(v[15]) > 10 else math.sqrt(0.5)
    from_left, side = kind in (1, 3), -1 if kind in (3, 7) else 1
    sizes = [size if size >= 0.0 else size * leg for size in v[7:11]]
    edges, inner = (sizes[:2], sizes[2:]) if from_left else (sizes[1::-1], sizes[:1:-1])
    left, top = v[1] if from_left else v[1] - v[2], side * v[0] / 2.0
    width = _width(motions, name, v[2] - sum(map(abs, inner)))
    lift = abs(v[16]) or _LIFT / motions.ip.state.unit_mm
    job = _Groove(motions, side, left, left + v[2], top, top - v[3], (inner[0], inner[1]), width, lift)
    _rough(job, name, v, from_left)
    if v[11] or v[12] or any(sizes):
        job.finish(edges[not from_left], from_left)
        job.finish(edges[from_left], not from_left)


def _rough(job: _Groove, name: str, v: list[float], from_left: bool) -> None:
    """Plunge from the side of the start on, down to the allowances."""
    first, last = job.left + v[12], job.right - job.width - v[12]
    message = (
        f"{name}, {v[2]:g} wide, has no room for its allowances {v[12]:g} beside a tool {job.width:g} wide"
    )
    refuse(name, (last < first - _TINY, "cycle-tool", message, "FAL2 is left on both walls"))
    count = steps_of(last - first, _ASIDE * job.width, name, f"{name} makes {{}} plunges", least=0)
    down = steps_of(v[3] - v[11], v[13], name, f"{name} plunges in {{}} steps", "is IDEP too small?")
    places = [first + (last - first) * k / max(count, 1) for k in range(count + 1)]
    for place in places if from_left else reversed(places):
        job.plunge(place, job.floor(place) + v[11], down, v[14])


def cut_off(motions: Motions, name: str, values: Values) -> None:
    """CYCLE92(SPD, SPL, DIAG1, DIAG2, RC, SDIS, SV1, SV2, SDAC, FF1, FF2, SS2, DIAGM, VARI, DN), then DMODE AMODE; SPD, DIAG1, DIAG2 are diameters.

    Down to DIAG1 at FF1 and SV1, from there to DIAG2 at FF2 and the constant speed SS2, and out to SDIS above SPD in traverse (840D sl, Operating
    Manual Turning 02/2012, 8.2.8). SV1 is a cutting speed where SV2 bounds the speed of the spindle, else the speed itself.
    """
    v = [filled(values, k) for k in range(17)]
    final, mode, sense = v[3], round(v[16]), round(v[8])
    slower = final if given(values, 2) is None else v[2]
    _refuse(
        motions,
        name,
        (v[4] != 0.0, "not-read", f"with RC = {v[4]:g} (a radius, or a chamfer, at the edge) is not read", "write the edge as blocks of its own before it, and RC = 0"),
        (round(v[13]) != 0, "not-read", f"with VARI = {v[13]:g} (a part catcher, or no retraction) is not read", "VARI = 0 goes out to SDIS above SPD"),
        (not 0 <= mode < 10_000 or mode % 100 != 0, "not-read", f"with AMODE = {mode} (depths as increments) is not read", "its ones and tens are 0: DIAG1 and DIAG2 are diameters"),
        (sense not in (0, 3, 4), "cycle-spindle", f"has SDAC = {v[8]:g}", "3 turns as M3, 4 as M4"),
        (not final <= slower <= v[0] or final >= v[0] or v[5] < 0.0, "cycle-words",
         f"goes from {v[0]:g} over {slower:g} to {final:g}, {v[5]:g} above the part", "SPD, DIAG1, DIAG2 are diameters that get smaller, SDIS is not below 0"),
        (min(v[6:8]) < 0.0 or v[11] < 0.0, "cycle-words", f"has the speeds {v[6]:g}, {v[7]:g} and {v[11]:g}", "SV1, SV2, SS2 are not below 0"),
    )  # fmt: skip
    check_mode_plane(motions, name, round(v[15]))
    what = "a cutting speed, bounded by SV2" if v[7] else "the speed of the spindle, since SV2 is 0"
    doubt_order(
        motions,
        name,
        f"SPD SPL DIAG1 DIAG2 RC SDIS SV1 SV2 SDAC FF1 FF2 SS2: are the values these? SV1 is {what}",
    )
    state = motions.ip.state
    feed, surface = state.feed, None if state.constant_surface is None else state.speed
    job = _Groove(motions, 1, v[1], v[1], v[0] / 2.0, final / 2.0, (0.0, 0.0), 0.0, v[5])
    job.begin(v[1])
    if v[6]:
        motions.emit({"s": v[6], "d": v[7]} if v[7] else {"s": v[6]}, (960 if v[7] else 970,))
    if sense:
        motions.emit({}, (), (10 * sense,))
    at_feed(motions, v[9] or feed, name)
    job.to(v[1], slower / 2.0)
    if slower > final:
        motions.emit({"s": v[11]} if v[11] else {}, (970,))
        at_feed(motions, v[10] or v[9] or feed, name)
        job.to(v[1], final / 2.0)
    job.to(v[1], v[0] / 2.0 + v[5], rapid=True)
    if surface is not None:
        motions.emit({"s": surface}, (960,))
    if feed:
        motions.emit({"f": feed})
