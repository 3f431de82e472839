"""GMODE, DMODE and AMODE of milling cycles, whose digits say what other parameters mean (840D sl, "Programming cycles externally").

Programs that are made at the control (programGUIDE) have them all; where they are left out, all digits are 0, as on older controls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik.cycles import Hole, Values, check_mode_plane, filled, of_two

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

#: From the reference point to the middle, in halves of length and width, by the thousands of GMODE: of rectangles, and of circles.
CORNERS = ((0, 0), (0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
MIDDLE = CORNERS[:2]
#: Parameters of milling cycles that stand in this order: infeed, allowances of wall and floor, feeds, sense, kind, step aside.
_PARAMETERS = ("mid", "fal", "fald", "feed", "plunge", "cdir", "vari", "step")


def milled(v: Sequence[float], first: int) -> dict[str, float]:
    """Return MID, FAL, FALD, FFP1, FFD, CDIR, VARI, MIDA from a parameter on; MIDA is 0 where a cycle ends before it."""
    return {"step": 0.0, **dict(zip(_PARAMETERS, v[first:], strict=False))}


@dataclass(frozen=True, slots=True)
class MillingModes:
    """The choices of the digits.

    Attributes:
        depth: 1 where the depth is a distance from RFP, 2 where it is a coordinate, 0 as without AMODE.
        percent: Whether the step aside is in percent of the tool's diameter.
        corner: From the reference point to the middle, in halves of length and width.
        whole: Whether GMODE says that the whole is cut, whatever the sizes of a blank say.
        diameter: Whether the hundreds of DMODE are 1.
    """

    depth: int
    percent: bool
    corner: tuple[int, int]
    whole: bool
    diameter: bool

    @classmethod
    def of(
        cls,
        motions: Motions,
        name: str,
        values: Values,
        index: int,
        points: Sequence[tuple[int, int]] = MIDDLE,
    ) -> MillingModes:
        """Return those of GMODE, a parameter of that index, and the two behind it; `points` are those that its thousands may choose.

        Raises:
            BlockError: A digit has a meaning that is not read.
        """
        shape, plane, mode = (round(filled(values, index + k)) for k in range(3))
        check_mode_plane(motions, name, plane)
        what, hint = "", "0 is the usual value of each digit"
        point = shape // 1000 % 10
        if shape // 100 % 10 > 1:
            what = f"GMODE = {shape} (the place of the start alone is worked out)"
        elif point >= len(points):
            what = f"GMODE = {shape} (another reference point)"
        elif shape // 10_000 > 1:
            what = f"GMODE = {shape} (what another tool left is cut)"
        elif mode % 10 > 2 or mode // 10 % 10 > 1 or min(shape, plane, mode) < 0:
            what = f"AMODE = {mode}"
        if what:
            raise BlockError("not-read", f"{what} of {name} is not read", name, hint=hint)
        diameter = plane // 100 % 10 == 1
        return cls(mode % 10, mode // 10 % 10 == 1, points[point], shape // 10_000 == 1, diameter)

    def hole_to(self, motions: Motions, name: str, heights: Values, depth: float | None) -> Hole:
        """Return the heights of RTP, RFP, SDIS, and a depth, which is a coordinate or a distance from RFP."""
        if depth is not None and self.depth == 1:
            depth = filled(heights, 1) - abs(depth)
        return Hole.of(motions, name, [*heights, depth])

    def hole(self, motions: Motions, name: str, values: Values) -> Hole:
        """Return the heights of RTP, RFP, SDIS, and DP or DPR."""
        return Hole.of(motions, name, [*values[:3], *of_two(name, values, 3, self.depth)])

    def step(self, step: float, motions: Motions, name: str, half: float) -> float:
        """Return the step aside as a length."""
        return step * 2.0 * motions.ip.cutting_radius(name, half) / 100.0 if self.percent else step

    def check_whole(self, name: str, values: Values, sizes: tuple[int, ...]) -> None:
        """Raise where parameters say that the shape is cut in part already (AP1, AP2, AD)."""
        if not self.whole and any(filled(values, k) for k in sizes):
            message = f"{name} of a pocket that is cut already in part (AP1, AP2, AD) is not read"
            hint = "leave AP1, AP2 and AD out, or write GMODE = 10000: the whole pocket is cleared"
            raise BlockError("not-read", message, name, hint=hint)
