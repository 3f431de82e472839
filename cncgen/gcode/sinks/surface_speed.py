"""Constant surface speed (G96): the spindle's speed at each radius, for feeds per revolution.

At the radius r a surface speed v means the spindle speed v/(2π r), bounded by the limit. So a feed per revolution changes along a line
that changes X. Such a line is cut at radii in the ratio `_STEP`, and each part has the feed of its mean radius. Since the time of a
length is proportional to r, every part takes its exact time.

Source: LinuxCNC's manual, "G96, G97 Spindle Control Mode" (X0 of the coordinates in force, with offsets and tool, is the
spindle's axis).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cncgen.gcode.sinks.sink import LEAST_RADIUS_MM
from cncgen.geometry import elementary

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Ratio of the radii of one part.
_STEP = 1.05


def revolutions(surface_mm_min: float, limit: float, radius: Floats) -> Floats:
    """Return the spindle's speed at radii (mm, any sign), rev/min, at most `limit`."""
    around = 2.0 * math.pi * np.maximum(np.abs(radius), LEAST_RADIUS_MM)
    return np.minimum(surface_mm_min / around, limit)


def parted(start: Floats, end: Floats, knee: float) -> tuple[Ints, Floats]:
    """Cut lines where the spindle's speed changes along them.

    Args:
        start, end: Shape (n,): radius at both ends of each line, mm, signed.
        knee: Radius below which the speed is constant, mm.

    Returns:
        Of the parts, shape (m,): the line of each, and where on it it ends (0 to 1).
    """
    knee = max(knee, LEAST_RADIUS_MM)
    owner: list[int] = []
    until: list[float] = []
    for line, (a, b) in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        cuts = _cuts(a, b, knee)
        owner += [line] * (len(cuts) + 1)
        until += [*cuts, 1.0]
    return np.array(owner, np.int64), np.array(until)


def _cuts(a: float, b: float, knee: float) -> list[float]:
    """Return where a line from radius a to b is cut, as parts of it in order."""
    high = max(abs(a), abs(b))
    low = max(knee, 0.0 if a * b < 0.0 else min(abs(a), abs(b)))
    if high <= low * _STEP and not min(abs(a), abs(b)) < knee < high:
        return []
    count = max(1, math.ceil(math.log(high / low) / math.log(_STEP)))
    levels = low * elementary.power(high / low, np.arange(count) / count)
    places = (np.concatenate([levels, -levels]) - a) / (b - a)
    return sorted(float(f) for f in places if 0.0 < f < 1.0)
