"""Profiles and paths of ISO 14649-10 as pieces, in the frame of their feature."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.curves import CurveReader
from cncgen.stepnc.geometry.frames import Matrix, identity, is_identity
from cncgen.stepnc.geometry.pieces import Piece, Polyline, reverse
from cncgen.stepnc.part21 import Ref, Typed


class Profiles:
    """Reads profiles and paths.

    Attributes:
        feature_placement: Of the feature that is being read: some files repeat it as the profile's placement.
    """

    def __init__(self, entities: Entities, curves: CurveReader) -> None:
        self.entities = entities
        self.curves = curves
        self.feature_placement: Matrix = identity()

    # Values

    def length(self, entity: Entity, name: str) -> float:
        """Return a TOLERANCED_LENGTH_MEASURE, NUMERIC_PARAMETER or plain number, mm.

        Raises:
            Skip: where it is missing.
        """
        found = self.optional_length(entity, name)
        if found is None:
            raise entity.fault("stepnc-missing", f"{name} must be given")
        return found

    def size(self, entity: Entity, name: str) -> float:
        """Return a length as `length` does; raises `Skip` if it is not positive."""
        found = self.length(entity, name)
        if not found > 0:
            raise entity.fault("stepnc-geometry", f"{name} is {found:g} mm; it must be positive")
        return found

    def optional_length(self, entity: Entity, name: str) -> float | None:
        """Return a length as `length` does, None where it is missing."""
        value = entity.get(name)
        if isinstance(value, Typed):
            value = value.value
        if value is None:
            return None
        if isinstance(value, Ref):
            measure = self.entities.get(int(value), owner=entity.id)
            if measure.keyword == "NUMERIC_PARAMETER":
                unit = measure.text("its_parameter_unit").strip().upper()
                factor = {"MM": 1.0, "": 1.0, "M": 1000.0, "CM": 10.0, "INCH": 25.4, "IN": 25.4}.get(unit)
                if factor is None:
                    raise measure.fault("stepnc-unit", f"{unit!r} is not a known unit of length")
                return measure.number("its_parameter_value") * factor
            return measure.number("theoretical_size")
        return entity.number(name)

    # Placements

    def placed(self, entity: Entity, pieces: list[Piece]) -> list[Piece]:
        place = self.curves.placements.optional(entity, "placement")
        if place is None or is_identity(place):
            return pieces
        if not is_identity(self.feature_placement) and np.allclose(place, self.feature_placement, atol=1e-9):
            text = "the placement repeats that of the feature; it is taken as none"
            entity.warn("stepnc-placement", text)
            return pieces
        return [p.moved(place) for p in pieces]

    # Closed profiles

    def closed(self, ident: int, owner: Entity) -> list[Piece]:
        """Return a closed profile counter-clockwise or clockwise, as given, end to end.

        Raises:
            Skip: where the entity does not describe one.
        """
        entity = self.entities.get(ident, owner=owner.id)
        kind = entity.keyword
        if kind == "RECTANGULAR_CLOSED_PROFILE":
            size = self.size(entity, "profile_length"), self.size(entity, "profile_width")
            pieces: list[Piece] = [profile_shapes.rectangle(*size)]
        elif kind == "CIRCULAR_CLOSED_PROFILE":
            pieces = [profile_shapes.circle(self.size(entity, "diameter"))]
        elif kind in ("NGON_PROFILE", "NGON_CLOSED_PROFILE"):
            pieces = [self._ngon(entity)]
        elif kind == "GENERAL_CLOSED_PROFILE":
            pieces = self._general(entity, "closed_profile_shape")
            if elementary.length(pieces[0].start - pieces[-1].end) > 1e-6:
                pieces = [*pieces, Polyline(np.stack([pieces[-1].end, pieces[0].start]))]
        else:
            raise entity.fault("stepnc-unsupported", "a closed profile cannot be made of this entity")
        return self.placed(entity, pieces)

    def _general(self, entity: Entity, name: str) -> list[Piece]:
        return self.curves.read(entity.entity(name).id, entity.id)

    def _ngon(self, entity: Entity) -> Polyline:
        """Return an n-gon; ISO 14649-10: where the flag is false a circle of that diameter surrounds it, else it surrounds one."""
        count = int(entity.number("number_of_sides"))
        if not 3 <= count <= 10_000:
            raise entity.fault("stepnc-geometry", f"a polygon has 3 to 10000 sides, not {count}")
        across = entity.flag("circumscribed_or_across_flats") is True
        return profile_shapes.regular_polygon(count, self.size(entity, "diameter"), across)

    # Paths

    def path(self, entity: Entity) -> list[Piece]:
        """Return a travel path.

        Raises:
            Skip: where the entity does not describe one.
        """
        kind = entity.keyword
        if kind == "LINEAR_PATH":
            direction = entity.ref("its_direction")
            along = np.array([1.0, 0.0, 0.0])
            if direction is not None:
                along = self.curves.placements.direction(direction, entity.id)
            pieces: list[Piece] = [profile_shapes.linear_path(self.length(entity, "distance") * along)]
        elif kind == "GENERAL_PATH":
            pieces = self._general(entity, "swept_path")
        elif kind in ("PARTIAL_CIRCULAR_PATH", "COMPLETE_CIRCULAR_PATH", "CIRCULAR_PATH"):
            radius = self.length(entity, "radius")
            sweep = 2 * math.pi
            if kind == "PARTIAL_CIRCULAR_PATH":
                sweep = entity.number("sweep_angle") * self.curves.angle
            pieces = [profile_shapes.arc_path(entity, radius, sweep)]
        else:
            raise entity.fault("stepnc-unsupported", "a path cannot be made of this entity")
        return self.placed(entity, pieces)

    # Profiles across a path

    def slot_profile(self, entity: Entity) -> dict[str, Any]:
        """Return the values of `Shape` that a slot's profile gives: its width, the radius of its floor, or its section.

        Raises:
            Skip: where passes from above cannot make it.
        """
        if entity.keyword == "ROUNDED_U_PROFILE":
            width = self.length(entity, "width")
            return {"width": width, "floor_radius": width / 2}
        if entity.keyword == "VEE_PROFILE":
            angle = entity.number("profile_angle") * self.curves.angle
            tilt = entity.number("tilt_angle", 0.0) * self.curves.angle
            return profile_shapes.section(
                entity, "vee", angle, self.optional_length(entity, "profile_radius") or 0.0, tilt
            )
        if entity.keyword == "PARTIAL_CIRCULAR_PROFILE":
            angle = entity.number("sweep_angle") * self.curves.angle
            return profile_shapes.section(entity, "arc", angle, self.length(entity, "radius"))
        if entity.keyword != "SQUARE_U_PROFILE":
            raise entity.fault("stepnc-unsupported", "a slot of this profile cannot be made")
        angles = [entity.number(f"{name}_angle", 0.0) * self.curves.angle for name in ("first", "second")]
        return {
            "width": self.length(entity, "width"),
            "floor_radius": self.optional_length(entity, "first_radius"),
            "slope": profile_shapes.wall_slope(entity, *angles),
        }

    def step_wall(self, course: list[Piece], vee: Entity | None) -> tuple[list[Piece], float]:
        """Return the foot of a step's wall with what is removed on its right, and the draft of the wall, rad.

        The profile lies in the X-Z plane of the feature, the path along Y (ISO 10303-238, 5.2.2.3.6); its arms stand
        at tilt_angle and tilt_angle + profile_angle from X, and what is removed lies between them. One of the arms is
        the floor. Without a profile it is a right angle between X and Z.

        Raises:
            Skip: where neither arm is level.
        """
        tilt = vee.number("tilt_angle", 0.0) * self.curves.angle if vee is not None else 0.0
        opening = vee.number("profile_angle", 90.0) * self.curves.angle if vee is not None else math.pi / 2
        if abs(tilt) < 1e-9:
            side, slope = 1.0, opening - math.pi / 2
        elif vee is not None and abs(tilt + opening - math.pi) > 1e-9:
            raise vee.fault("stepnc-unsupported", "no arm of the step's profile is level")
        else:
            side, slope = -1.0, math.pi / 2 - tilt
        place = self.curves.placements.optional(vee, "placement") if vee is not None else None
        across = side * (np.array([1.0, 0.0, 0.0]) if place is None else place[:3, 0])
        along = course[-1].end - course[0].start
        to_right = float(across[0] * along[1] - across[1] * along[0])
        if abs(to_right) < 1e-9 * float(elementary.length(along)):  # along X: the right hand of the way
            to_right = side
        return (course if to_right > 0 else reverse(course)), (slope if abs(slope) > 1e-9 else 0.0)

    def face_sweep(self, entity: Entity) -> tuple[list[Piece], list[Piece]]:
        """Return the course of travel of a planar face, and the outline of what its profile sweeps along it.

        Raises:
            Skip: where they are not straight, or enclose no area.
        """
        course = self.path(entity.entity("course_of_travel", "LINEAR_PATH"))
        boundary = entity.entity("removal_boundary", "LINEAR_PROFILE")
        width = np.array([self.size(boundary, "profile_length"), 0.0, 0.0])
        (profile,) = self.placed(boundary, [profile_shapes.linear_path(width)])
        return course, [profile_shapes.swept(entity, profile, course)]

    def open_outline(
        self, boundary: Entity, wall: int | None, owner: Entity
    ) -> tuple[list[Piece], tuple[int, ...]]:
        """Return the closed outline of an open pocket, and which of its pieces are open.

        The wall is `wall_boundary` where it is given, else `open_boundary`; the straight line between its ends is open.

        Raises:
            Skip: where they cannot be made.
        """
        entity = boundary if wall is None else self.entities.get(wall, owner=owner.id)
        kind = entity.keyword
        if kind == "GENERAL_PROFILE":
            pieces = self.placed(entity, self._general(entity, "its_profile"))
        elif kind == "LINEAR_PROFILE":
            line = profile_shapes.linear_path(np.array([self.length(entity, "profile_length"), 0.0, 0.0]))
            pieces = self.placed(entity, [line])
        else:
            raise entity.fault("stepnc-unsupported", "an open pocket of this boundary cannot be made")
        opening = None
        if wall is not None and boundary.keyword == "GENERAL_PROFILE":
            opening = self.placed(boundary, self._general(boundary, "its_profile"))
        return profile_shapes.closed_outline(boundary, pieces, opening)
