"""The turned features of ISO 14649-12."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cncgen.stepnc import turned_shapes
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.iso14649.profiles import Profiles
from cncgen.stepnc.model import Shape


class TurnedProfiles:
    """Reads turned features."""

    def __init__(self, entities: Entities, profiles: Profiles) -> None:
        self.entities = entities
        self.profiles = profiles
        self.shapes = {
            "OUTER_DIAMETER": self._outer_diameter,
            "REVOLVED_FLAT": lambda e: self._revolved(e, "flat_edge_shape"),
            "REVOLVED_ROUND": lambda e: self._revolved(e, "rounded_edge_shape"),
            "GENERAL_REVOLUTION": lambda e: self._revolved(e, "outer_edge_profile"),
            "GROOVE": self._groove,
        }

    def _outer_diameter(self, entity: Entity) -> Shape:
        first = self.profiles.size(entity, "diameter_at_placement")
        length = self.profiles.size(entity, "feature_length")
        last, ident = first, entity.ref("reduced_size")
        if ident is not None:
            taper = self.entities.get(ident, "DIAMETER_TAPER", "ANGLE_TAPER", owner=entity.id)
            if taper.keyword == "DIAMETER_TAPER":
                last = self.profiles.length(taper, "final_diameter")
            else:
                last -= 2 * length * math.tan(taper.number("angle") * self.profiles.curves.angle)
        return Shape(contour=turned_shapes.diameter(entity, (first, last), length))

    def _revolved(self, entity: Entity, name: str) -> Shape:
        profile = entity.entity(name)
        kind = profile.keyword
        if kind == "LINEAR_PROFILE":
            reach = np.array([self.profiles.length(profile, "profile_length"), 0.0, 0.0])
            pieces: list[Piece] = [profile_shapes.linear_path(reach)]
        elif kind == "PARTIAL_CIRCULAR_PROFILE":
            sweep = profile.number("sweep_angle") * self.profiles.curves.angle
            pieces = [profile_shapes.arc_path(profile, self.profiles.length(profile, "radius"), sweep)]
        elif kind == "GENERAL_PROFILE":
            pieces = self.profiles.curves.read(profile.entity("its_profile").id, profile.id)
        else:
            raise profile.fault("stepnc-unsupported", "nothing can be turned by this profile")
        pieces = self.profiles.placed(profile, pieces)
        radius = self.profiles.optional_length(entity, "radius") or 0.0
        contour = turned_shapes.in_plane(profile, pieces, radius)
        return Shape(contour=contour, material=self._material(entity))

    def _material(self, entity: Entity) -> np.ndarray | None:
        """Return the direction from a profile into the material, None where the file does not say."""
        side = entity.ref("material_side")
        return None if side is None else self.profiles.curves.placements.direction(side, entity.id)

    def _groove(self, entity: Entity) -> Shape:
        profile = entity.entity("sweep")
        if profile.keyword == "GENERAL_PROFILE":
            return self._revolved(entity, "sweep")
        place = self.profiles.curves.placements.optional(profile, "placement")
        radius = self.profiles.optional_length(entity, "radius") or 0.0
        section = self.profiles.slot_profile(profile)
        made = turned_shapes.groove(profile, section, place, radius)
        return replace(made, material=self._material(entity))
