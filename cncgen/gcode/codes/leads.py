"""Ways to the first point of a contour and away from its last one: lines and arcs that touch it in its direction, in all languages."""

from __future__ import annotations

import cmath

from cncgen.gcode.codes.turning_profiles import Segment


def lead_line(point: complex, way: complex, length: float, *, leaving: bool) -> Segment:
    """Return the line of a length that leads to a point of a contour in a direction, or away from there."""
    return Segment(point, point + way * length) if leaving else Segment(point - way * length, point)


def lead_arc(point: complex, heading: complex, aside: float, angle: float, *, leaving: bool) -> Segment:
    """Return the arc of an angle, rad, that leads to a point of a contour in its direction, or away from there.

    Its centre lies `aside` of the contour: above 0 to the left, where it goes counter-clockwise, else to the right.
    """
    centre, spin = point + 1j * heading * aside, 1 if aside > 0.0 else -1
    far = centre + (point - centre) * cmath.rect(1.0, angle * spin * (1 if leaving else -1))
    return Segment(point, far, centre, spin) if leaving else Segment(far, point, centre, spin)
