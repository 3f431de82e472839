"""Outlines and paths of fixed form at height 0, and where the copies of a pattern stand.

The forms are those of ISO 14649-10 (profiles, travel paths, patterns); ISO 10303-238 has the same under other names.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry.frames import Matrix, translation
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline, reverse

Floats = NDArray[np.float64]


def polygon(corners: Iterable[Floats]) -> Polyline:
    """Return the closed polyline of corners, each with X and Y first, mm."""
    points = [np.array([c[0], c[1], 0.0]) for c in corners]
    return Polyline(np.stack([*points, points[0]]))


def rectangle(length: float, width: float) -> Polyline:
    """Return a rectangle about the origin against the clock, `length` along X and `width` along Y, mm.

    As rectangular_closed_profile of ISO 14649-10 stands.
    """
    half = np.array([length, width]) / 2
    return polygon(half * np.array(c) for c in ([-1, -1], [1, -1], [1, 1], [-1, 1]))


def circle(diameter: float) -> Arc:
    """Return the circle about the origin against the clock, mm."""
    return circular_path(diameter / 2, 2 * math.pi)


def regular_polygon(sides: int, diameter: float, across_flats: bool) -> Polyline:
    """Return a regular polygon about the origin against the clock; its first side is parallel to X, at negative Y.

    So ngon_profile of ISO 14649-10 stands.

    Args:
        sides: Three or more.
        diameter: mm: of the circumscribed or of the inscribed circle.
        across_flats: Which of the two.
    """
    radius = diameter / 2 / (math.cos(math.pi / sides) if across_flats else 1.0)
    angles = 2 * math.pi * (np.arange(sides) - 0.5) / sides - math.pi / 2
    return polygon(radius * np.column_stack([np.cos(angles), np.sin(angles)]))


def circular_path(radius: float, sweep: float) -> Arc:
    """Return the arc about the origin that begins on X, `sweep` rad against the clock (negative: with it), mm."""
    start = np.array([radius, 0.0, 0.0])
    end = start if abs(sweep) == 2 * math.pi else radius * np.array([math.cos(sweep), math.sin(sweep), 0.0])
    return Arc(start, end, np.zeros(3), np.array([0.0, 0.0, math.copysign(1.0, sweep)]), abs(sweep))


def swept(entity: Entity, profile: Piece, course: list[Piece]) -> Polyline:
    """Return the outline of the area that a straight profile sweeps along the chord of a course (ISO 14649-10, planar_face).

    Raises:
        Skip: where it has no area.
    """
    begin = course[0].start + profile.start
    side, along = profile.end - profile.start, course[-1].end - course[0].start
    area = abs(float(side[0] * along[1] - side[1] * along[0]))
    if not area > 1e-9 * float(elementary.length(side)) * float(elementary.length(along)):
        text = (
            f"the profile goes X{side[0]:g} Y{side[1]:g} and the course of travel X{along[0]:g} Y{along[1]:g} mm: "
            "they enclose no area; a linear profile lies along its own X, and the course goes across it"
        )
        raise entity.fault("stepnc-geometry", text)
    return polygon([begin, begin + side, begin + side + along, begin + along])


def arc_path(entity: Entity, radius: float, sweep: float) -> Arc:
    """Return `circular_path` of an entity's radius (mm) and angle (rad).

    Raises:
        Skip: where no arc has this radius and angle.
    """
    if not (radius > 0 and 0 < abs(sweep) <= 2 * math.pi + 1e-9):
        text = f"an arc has a radius of {radius:g} mm and {math.degrees(sweep):g} degrees; the radius must be above 0, the angle within a turn and not 0"
        raise entity.fault("stepnc-geometry", text)
    return circular_path(radius, sweep)


def linear_path(vector: Floats) -> Polyline:
    """Return the straight line from the origin along a vector, shape (3,), mm."""
    return Polyline(np.stack([np.zeros(3), vector]))


def about_z(angle: float) -> Matrix:
    """Return the frame turned by an angle, rad, about Z."""
    frame = np.eye(4)
    frame[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return frame


def circular_places(
    owner: Entity, base: Matrix, angles: Floats, turns: Floats, diameter: float | None
) -> list[Matrix]:
    """Return the placements of copies round the pattern's Z axis (circular_pattern, ISO 14649-10).

    Args:
        owner: The pattern, for diagnostics.
        base: Placement of the base feature in the pattern; where it stands on the axis, `diameter` says how far from it along
            X the first copy is.
        angles: Shape (n,), rad: how far round the axis each copy is from the base.
        turns: Shape (n,), rad: how far each is turned about itself.
        diameter: Of the circle that they stand on, mm, or None.

    Raises:
        Skip: where an angle is more than a turn from copy to copy, or the base is not on the circle.
    """
    steps = np.abs(np.concatenate([np.diff(angles), np.diff(turns)]))
    if not steps.max(initial=0.0) <= 2 * math.pi + 1e-9:
        text = (
            f"angles of the pattern are up to {math.degrees(float(steps.max())):g} degrees, more than a turn"
        )
        raise owner.fault("stepnc-geometry", text)
    reach = math.hypot(base[0, 3], base[1, 3])
    if reach < 1e-9 and diameter is not None:
        base = elementary.product(translation(diameter / 2, 0.0, 0.0), base)
    elif diameter is not None and abs(2 * reach - diameter) > 0.002:
        text = f"the circle has a diameter of {diameter:g} mm, and the base feature stands on one of {2 * reach:g} mm"
        raise owner.fault("stepnc-geometry", text)
    out = []
    for angle, turn in zip(angles.tolist(), turns.tolist(), strict=True):
        frame = elementary.product(about_z(turn), base)
        frame[:3, 3] = (elementary.product(about_z(angle), base))[:3, 3]
        out.append(frame)
    return out


def rectangular_places(rows: int, columns: int, row_step: Floats, column_step: Floats) -> list[Matrix]:
    """Return the frames of copies row by row; `row_step` and `column_step`, shape (3,), lead to the next one, mm."""
    return [translation(*(c * column_step + r * row_step)) for r in range(rows) for c in range(columns)]


def closed_outline(
    owner: Entity, wall: list[Piece], opening: list[Piece] | None = None
) -> tuple[list[Piece], tuple[int, ...]]:
    """Return the closed outline of an open pocket, and which of its pieces are open, by index.

    Args:
        owner: The boundary, for diagnostics.
        wall: Where material stands, end to end.
        opening: From one end of the wall to the other, either way; None: a straight line.

    Raises:
        Skip: where the opening does not begin where the wall ends.
    """
    if opening is None:
        opening = [Polyline(np.stack([wall[-1].end, wall[0].start]))]
    if elementary.length(opening[0].start - wall[-1].end) > 1e-6:
        opening = reverse(opening)
    if elementary.length(opening[0].start - wall[-1].end) > 1e-6:
        raise owner.fault("stepnc-geometry", "the open boundary does not begin where the wall ends")
    return [*wall, *opening], tuple(range(len(wall), len(wall) + len(opening)))


def section(
    entity: Entity, kind: str, angle: float, radius: float, tilt: float | None = None
) -> dict[str, Any]:
    """Return the values of `Shape` of a slot whose section is a vee or an arc.

    Args:
        entity: The profile, for diagnostics.
        kind: ``vee`` or ``arc``.
        angle: Between the walls, or of the arc, rad.
        radius: Of the bottom, mm.
        tilt: Of a vee's first wall from X, rad.

    Raises:
        Skip: where the section is closed above, or leans.
    """
    if not 0 < angle <= math.pi + 1e-9 or not radius >= 0 or (kind == "arc" and not radius > 0):
        raise entity.fault(
            "stepnc-geometry",
            f"a {kind} of {math.degrees(angle):g} degrees and {radius:g} mm cannot be made: the angle must lie between 0 and 180, the radius not below 0",
        )
    if tilt is not None and abs(tilt - (math.pi - angle) / 2) > math.radians(0.1):
        upright = math.degrees((math.pi - angle) / 2)
        text = f"a vee that leans cannot be made: tilt_angle is {math.degrees(tilt):g} degrees, {upright:g} stands upright"
        raise entity.fault("stepnc-unsupported", text)
    return {"section": kind, "section_angle": angle, "section_radius": radius}


def wall_slope(entity: Entity, first: float, second: float) -> float:
    """Return how far the walls of a square U lean from the vertical, rad, of the angles of both.

    ISO 14649-10 measures them from the profile's Z axis; files that measure from the floor have a right angle for upright
    walls. A square U is as wide at its top as at its floor, or wider.

    Raises:
        Skip: where the walls lean differently, or over the slot.
    """
    slopes = [0.0 if abs(angle - math.pi / 2) < 1e-6 else angle for angle in (first, second)]
    if abs(slopes[0] - slopes[1]) > 1e-6:
        text = f"walls of a slot that lean differently ({_degrees(slopes[0])} and {_degrees(slopes[1])}) cannot be made"
        raise entity.fault("stepnc-unsupported", text)
    slope = slopes[0]
    if slope < -1e-6:
        text = f"walls of a slot at {_degrees(slope)} from the vertical hang over it"
        raise entity.fault("stepnc-geometry", text)
    if 0 < slope < math.radians(1.0):
        text = f"the walls lean by {_degrees(slope)}; is {_degrees(math.degrees(slope))} meant, in radians?"
        entity.warn("stepnc-angle", text)
    elif slope > math.pi / 4:
        text = f"the walls lean by {_degrees(slope)} from the vertical; is {_degrees(math.pi / 2 - slope)} meant, from the floor?"
        entity.warn("stepnc-angle", text)
    return max(slope, 0.0)


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.4g}°"
