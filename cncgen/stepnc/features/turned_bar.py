"""A turning operation in the plane of u and r, and the material left on the bar.

r is the radius, u runs along the axis of the work against the feed, so that the tool goes towards lower u. A position is that of the
tool's corner, the point where its two edges would meet without rounding: the lowest r and the lowest u that it touches. Of a tool for
grooves it is its corner at the lowest u.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cncgen.stepnc.features.job import Floats, Job, Moves
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Piece, Polyline
from cncgen.stepnc.geometry.solids import Solid

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

#: Distance from the bar at which the tool moves in rapid, mm, and by which it is lifted off where no lift_height is given.
CLEAR = 2.0
LIFT = 0.5
#: Chords of arcs, mm; they become arcs again.
CHORD = 2e-5
#: Beyond everything, mm.
FAR = 1e4
#: Coordinates alike, mm.
SAME = 1e-6
#: Passes of one operation.
MAX_PASSES = 5000


@dataclass(slots=True)
class Bar:
    """The half section of a bar: a shapely region of Z and radius, seen from the machine."""

    region: BaseGeometry

    @classmethod
    def of(cls, raw: Solid) -> Bar:
        """Return the section of a raw piece; a block counts as the cylinder round it."""
        from shapely import box

        low, high = raw.reach(np.zeros(3), np.array([0.0, 0.0, 1.0]))
        if raw.kind == "cylinder" and abs(abs(raw.frame[2, 2]) - 1.0) < 1e-9:
            radius = raw.size[0] + math.hypot(raw.frame[0, 3], raw.frame[1, 3])
        else:
            reach = [raw.reach(np.zeros(3), np.eye(3)[k]) for k in (0, 1)]
            radius = math.hypot(*(max(abs(a), abs(b)) for a, b in reach))
        return cls(box(low, 0.0, high, radius))


@dataclass(frozen=True, slots=True)
class BarJob:
    """A turning operation in the plane of u and r.

    Attributes:
        job: The work.
        bar: The material before it, None if unknown.
        sense: u = sense · z of the machine.
        contour: Profile of the feature, in (u, r, 0), from the highest u down.
        nose: Radius of the tool's corner, mm.
    """

    job: Job
    bar: Bar | None
    sense: float
    contour: list[Piece]
    nose: float

    @property
    def points(self) -> Floats:
        """The profile as chords, shape (n, 2)."""
        chains = [polyline_of(p, CHORD).points[:, :2] for p in self.contour]
        return np.concatenate([chains[0][:1], *(c[1:] for c in chains)])

    def bounds(self) -> tuple[float, float, float]:
        """Return lowest u, highest u and largest r of bar and contour, mm."""
        points = self.points[self.points[:, 1] < FAR / 2]
        low, high, top = float(points[:, 0].min()), float(points[:, 0].max()), float(points[:, 1].max())
        if self.bar is None or self.bar.region.is_empty:
            return low, high, top
        a, _, b, r = self.bar.region.bounds
        ends = a * self.sense, b * self.sense
        return min(low, *ends), max(high, *ends), max(top, r)

    def known_bar(self, what: str) -> Bar:
        """Return the material before the operation; raises `Skip` if it is unknown."""
        if self.bar is None:
            text = f"{what} needs the raw piece: its_rawpiece with its_bounding_geometry (ISO 14649-10, workpiece); --stock is cut, and makes no toolpath"
            raise self.job.fault("stepnc-missing", text)
        return self.bar

    def taken(self, region: BaseGeometry) -> None:
        """Note that a region of (u, r) is no longer there."""
        if self.bar is not None:
            from shapely import affinity

            self.bar.region = self.bar.region.difference(
                affinity.scale(region, self.sense, 1.0, origin=(0, 0))
            )

    def begin(self, u: float, r: float) -> Moves:
        """Return moves that begin at a place."""
        return Moves(self.job.operation.ident, np.array([u, r, 0.0]))

    @property
    def allowance(self) -> float:
        """Material that is to stay on the profile, mm; raises `Skip` below 0."""
        given = self.job.value("allowance", 0.0)
        if given < 0:
            raise self.job.fault("stepnc-range", f"allowance is {given:g} mm; it must not be negative")
        return given

    @property
    def rough(self) -> bool:
        """Whether the operation roughs."""
        return self.job.operation.kind.endswith("rough")

    @property
    def lift(self) -> float:
        """How far the tool is lifted off, mm."""
        return self.job.strategy_value("lift_height", 0.0) or LIFT

    @property
    def overcut(self) -> float:
        """How far the tool goes beyond the end of a feature, mm."""
        return max(self.job.strategy_value("overcut_length", 0.0), 0.0)

    def depths(self, whole: float) -> list[float]:
        """Return how deep each pass lies below the first surface, mm: the cutting depths, the last of them repeated.

        Raises:
            Skip: where no depth is given, or there are too many.
        """
        strategy = self.job.operation.strategy
        given = strategy.values.get("cutting_depth", ()) if strategy else ()
        if not isinstance(given, tuple):
            given = (given,)
        if not given or not min(given) > 0:
            text = "roughing needs a strategy with cutting_depth, each of them above 0"
            raise self.job.fault("stepnc-missing", text, hint="UNIDIRECTIONAL_TURNING($,.T.,(2.0),$,…)")
        once = strategy is not None and strategy.values.get("allow_multiple_passes") is False
        if once and given[0] < whole - SAME:
            text = f"{whole:g} mm are to be cut {given[0]:g} mm deep, and allow_multiple_passes is false"
            raise self.job.fault("stepnc-depth", text)
        if (whole - sum(given)) / given[-1] > MAX_PASSES:
            raise self.job.fault(
                "stepnc-depth", f"passes {given[-1]:g} mm deep are too many; at most {MAX_PASSES}"
            )
        out: list[float] = []
        at, k = 0.0, 0
        while at < whole - SAME:
            at = min(at + given[min(k, len(given) - 1)], whole)
            out.append(at)
            k += 1
        return out


def segments(piece: Piece) -> list[Piece]:
    """Return the lines of a polyline one by one; other pieces as they are."""
    if not isinstance(piece, Polyline):
        return [piece]
    return [Polyline(piece.points[k : k + 2]) for k in range(len(piece.points) - 1)]
