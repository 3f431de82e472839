"""Round bottoms of holes that are milled: cones, spheres, flat ones with a rounded corner.

A tool of radius R whose edge is rounded by e touches such a bottom with the circle of its rounding, whose centre is e above
the tip and R - e beside the axis. In a hole of radius H whose wall ends at the depth D its axis may therefore go as far
from the hole's, with the tip at the depth d, as

- cone, φ from the axis:   x = H - (R - e + e / cos φ + (d - D - e) tan φ),
- sphere of radius ρ:      x = √((ρ - e)² - (d - e - D + c)²) - (R - e), its centre c = √(ρ² - H²) above D,
- corner of radius f:      x = H - f + √((f - e)² - (d - e - D + f)²) - (R - e),

and never farther than H - R. Cutting level by level leaves steps; the tool never cuts below the bottom.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from cncgen.stepnc.features.job import MAX_SLOPE, Job

#: Passes into a round bottom, at least.
STEPS = 8
_CONE = "the tip_angle of the conical bottom is {:g} degrees; it must lie between 0 and {:g}"
#: How far from the middle the tool goes on its lowest pass, mm: there it could only plunge.
SMALLEST = 0.05


@dataclass(frozen=True, slots=True)
class Bottom:
    """A round bottom.

    Attributes:
        begins: Depth of the tip from which on the bottom narrows its way, mm.
        lowest: Depth that it can reach, mm.
        reach: Called with the depth of the tip, mm; returns how far from the hole's axis the tool's may be.
    """

    begins: float
    lowest: float
    reach: Callable[[float], float]

    def stops(self) -> list[float]:
        """Return depths between which passes are made, mm."""
        step = (self.lowest - self.begins) / STEPS
        return [self.begins + k * step for k in range(STEPS)]


def bottom_of(job: Job) -> Bottom | None:
    """Return the round bottom of a hole, None where it is flat or goes through, or the tool cannot make it round.

    Raises:
        Skip: where its sizes are missing or of no bottom.
    """
    make = _ROUND.get(job.shape.bottom)
    if make is None or job.shape.diameter is None:
        return None
    if abs(job.shape.slope) > 1e-9:
        raise job.fault("stepnc-unsupported", "a tapered hole with a round bottom cannot be milled")
    return make(job, job.shape.diameter / 2)


def _lowest(high: float, low: float, reach: Callable[[float], float]) -> float:
    """Return the depth between two at which the tool's way is `SMALLEST` (bisection; the way narrows downwards)."""
    if reach(low) >= SMALLEST:
        return low
    for _ in range(60):
        middle = (high + low) / 2
        high, low = (middle, low) if reach(middle) >= SMALLEST else (high, middle)
    return high


def _cone(job: Job, hole: float) -> Bottom:
    angle = job.shape.bottom_angle
    if angle is None:
        raise job.fault("stepnc-missing", "the conical bottom has no tip_angle")
    slope = angle / 2
    if not 0 < slope < MAX_SLOPE:
        raise job.fault("stepnc-geometry", _CONE.format(math.degrees(angle), 2 * math.degrees(MAX_SLOPE)))
    radius, edge, depth = job.radius, job.tool.edge, job.depth
    fixed = radius - edge + edge / math.cos(slope)

    def reach(d: float) -> float:
        return min(hole - radius, hole - fixed - (d - depth - edge) * math.tan(slope))

    return _made(job, depth, depth + hole / math.tan(slope), reach)


def _sphere(job: Job, hole: float) -> Bottom:
    sphere = job.shape.bottom_radius
    if sphere is None or not sphere >= hole - 1e-9:
        given = "no radius" if sphere is None else f"a radius of {sphere:g} mm"
        raise job.fault(
            "stepnc-geometry",
            f"the spherical bottom of a hole of {2 * hole:g} mm has {given}; it needs {hole:g} mm or more",
        )
    radius, edge = job.radius, job.tool.edge
    centre = job.depth - math.sqrt(max(sphere**2 - hole**2, 0.0))

    def reach(d: float) -> float:
        below = max(d - edge - centre, 0.0)
        return min(hole, math.sqrt(max((sphere - edge) ** 2 - below**2, 0.0)) + edge) - radius

    return _made(job, job.depth, centre + sphere, reach)


def _corner(job: Job, hole: float) -> Bottom | None:
    corner, radius, edge = job.shape.floor_radius, job.radius, job.tool.edge
    if corner is None or edge > corner - 1e-9:
        return None
    depth = job.depth

    def reach(d: float) -> float:
        below = max(d - edge - depth + corner, 0.0)
        return hole - corner + math.sqrt(max((corner - edge) ** 2 - below**2, 0.0)) - radius + edge

    return _made(job, depth - corner + edge, depth, reach)


def _made(job: Job, begins: float, floor: float, reach: Callable[[float], float]) -> Bottom:
    """Return a bottom less the allowance; warn of material that stays because the tool is too thick."""
    left = job.value("allowance_bottom", 0.0)
    lowest = _lowest(begins, floor, reach)
    if floor - lowest > 1e-3:
        text = f"the tool reaches {lowest:.3f} mm of the bottom's {floor:.3f}; material stays in the middle"
        job.warn("stepnc-uncut", text)
    return Bottom(begins - left, lowest - left, lambda d: reach(d + left))


_ROUND = {"conical": _cone, "spherical": _sphere, "flat with radius": _corner}


def is_round(job: Job) -> bool:
    """Tell whether the bottom is not entirely flat."""
    return job.shape.bottom in _ROUND
