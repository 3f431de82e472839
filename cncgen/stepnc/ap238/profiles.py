"""Profiles and paths of the AIM as pieces, in the frame of their feature (ISO 10303-238, 5.1.4)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.ap238.graph import Item
from cncgen.stepnc.ap238.shapes import Component, Shapes
from cncgen.stepnc.entities import Entity, only
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.curves import CurveReader
from cncgen.stepnc.geometry.frames import identity, is_identity
from cncgen.stepnc.geometry.pieces import Piece, Polyline

CLOSED = (
    "CIRCULAR_CLOSED_PROFILE",
    "CLOSED_PATH_PROFILE",
    "NGON_CLOSED_PROFILE",
    "RECTANGULAR_CLOSED_PROFILE",
)
OPEN = (
    "LINEAR_PROFILE",
    "OPEN_PATH_PROFILE",
    "PARTIAL_CIRCULAR_PROFILE",
    "ROUNDED_U_PROFILE",
    "SQUARE_U_PROFILE",
    "TEE_PROFILE",
    "VEE_PROFILE",
)


def find(components: list[Component], *roles: str) -> Entity | None:
    """Return the component with the first of some roles that there is (relationship or occurrence), None without."""
    for role in roles:
        found = only(
            role,
            [c for c in components if role in (c.role, c.usage, c.occurrence.removesuffix(" occurrence"))],
        )
        if found is not None:
            return found.entity
    return None


def path_of(components: list[Component]) -> Entity | None:
    """Return the path that a feature is swept along, or None."""
    named = find(components, "course of travel", "profile swept shape", "boss height")
    return named or component_of(components, "path", ("PATH_FEATURE_COMPONENT",))


def component_of(components: list[Component], name: str, kinds: tuple[str, ...]) -> Entity | None:
    """Return the component of one of these kinds, or None; raises `Skip` where there are several."""
    found = only(name, [c for c in components if c.entity.keyword in kinds])
    return None if found is None else found.entity


def profile_of(components: list[Component], kinds: tuple[str, ...]) -> Entity | None:
    """Return the profile of one of these kinds, or None; raises `Skip` where there are several."""
    return component_of(components, "profile", kinds)


class Profiles:
    """Reads profiles and paths."""

    def __init__(self, shapes: Shapes) -> None:
        self.shapes = shapes
        self.feature_placement = identity()  # of the feature that profiles are read for

    def length(self, path: Entity | None) -> float | None:
        """Return the length of a straight path, mm, or None."""
        measures = {} if path is None else self.shapes.measures(path.id)
        return measures.get("distance", measures.get("length"))

    def closed(self, entity: Entity) -> list[Piece]:
        """Return a closed profile, end to end.

        Raises:
            Skip: where the entity does not describe one.
        """
        values, kind = self.shapes.measures(entity.id), entity.keyword
        length = values.get("length", values.get("profile length"))
        width = values.get("width", values.get("profile width"))
        for name in ("diameter", "length", "profile length", "width", "profile width"):
            if not values.get(name, 1.0) > 0:
                raise entity.fault("stepnc-geometry", f"{name} is {values[name]:g} mm; it must be positive")
        pieces: list[Piece]
        if kind == "CIRCULAR_CLOSED_PROFILE" and "diameter" in values:
            pieces = [profile_shapes.circle(values["diameter"])]
        elif kind == "RECTANGULAR_CLOSED_PROFILE" and length is not None and width is not None:
            pieces = [profile_shapes.rectangle(length, width)]
        elif kind == "NGON_CLOSED_PROFILE" and "number of sides" in values:
            pieces = [self._ngon(entity, values)]
        else:
            pieces = self._curve(entity)
            if elementary.length(pieces[0].start - pieces[-1].end) > 1e-6:
                pieces = [*pieces, Polyline(np.stack([pieces[-1].end, pieces[0].start]))]
        return self.placed(entity, pieces)

    def _ngon(self, entity: Entity, values: dict[str, float]) -> Piece:
        sides = round(values["number of sides"])
        across = values.get("diameter across flats")
        diameter = values.get("circumscribed diameter", across)
        if not 3 <= sides <= 10_000 or diameter is None:
            raise entity.fault(
                "stepnc-geometry",
                f"a polygon needs 3 to 10000 sides and a diameter; it has {sides} sides and {diameter} mm",
            )
        return profile_shapes.regular_polygon(
            sides, diameter, across_flats="circumscribed diameter" not in values
        )

    def placed(self, entity: Entity, pieces: list[Piece]) -> list[Piece]:
        """Return a profile's pieces where it stands in its feature."""
        place = self.shapes.frame(entity.id, "orientation")
        if place is None or is_identity(place):
            return pieces
        if np.allclose(place, self.feature_placement, atol=1e-9):
            entity.warn("stepnc-placement", "the placement repeats that of the feature; it is taken as none")
            return pieces
        return [p.moved(place) for p in pieces]

    def _curve(self, entity: Entity) -> list[Piece]:
        items = self.shapes.items(entity.id)
        curves = [i for i in items if "CURVE" in i.entity.keyword or i.entity.keyword == "POLYLINE"]
        item = only("curve of a profile or path", curves, "a COMPOSITE_CURVE whose segments they are")
        if item is not None:
            return self._read(item, entity)
        raise entity.fault(
            "stepnc-unsupported", "it has no sizes and no bounded curve that a profile can be made of"
        )

    def _read(self, item: Item, entity: Entity) -> list[Piece]:
        context = self.shapes.units.context(item.context)
        return CurveReader(self.shapes.entities, *context).read(item.entity.id, entity.id)

    def open(self, entity: Entity) -> list[Piece]:
        """Return an open profile in its plane: a straight line along X, or a curve.

        Raises:
            Skip: where the profile does not lie in the plane of the feature.
        """
        if entity.keyword == "LINEAR_PROFILE":
            values = self.shapes.measures(entity.id)
            named = (value for name, value in values.items() if name.endswith("length"))
            length = values.get("profile length", next(named, None))
            if length is None:
                raise entity.fault("stepnc-missing", "the profile has no length")
            pieces: list[Piece] = [profile_shapes.linear_path(np.array([length, 0.0, 0.0]))]
        elif entity.keyword == "OPEN_PATH_PROFILE":
            pieces = self._curve(entity)
        else:
            raise entity.fault("stepnc-unsupported", "a pocket with this open boundary cannot be made")
        return self.placed(entity, pieces)

    def path(self, entity: Entity, along: np.ndarray) -> list[Piece]:
        """Return a travel path.

        Args:
            entity: PATH_FEATURE_COMPONENT.
            along: Shape (3,): where a straight one goes that has no direction.

        Raises:
            Skip: where the entity does not describe one.
        """
        values, kind = self.shapes.measures(entity.id), entity.text("description").strip().lower()
        if "circular" in kind and "radius" in values:
            sweep = values.get("sweep angle", 2 * math.pi) if kind.startswith("partial") else 2 * math.pi
            pieces: list[Piece] = [profile_shapes.arc_path(entity, values["radius"], sweep)]
        elif kind == "complex":
            pieces = self._curve(entity)
        else:
            distance = self.length(entity)
            if distance is None:
                raise entity.fault(
                    "stepnc-unsupported", "the path has no distance, and its kind is not known"
                )
            direction = self.shapes.direction(entity.id)
            pieces = [profile_shapes.linear_path(distance * (along if direction is None else direction))]
        return self.placed(entity, pieces)

    def across(self, profile: Entity) -> dict[str, Any]:
        """Return the values of `Shape` that the section of a slot or groove gives.

        Raises:
            Skip: where passes from above cannot make it.
        """
        size, kind = self.shapes.measures(profile.id), profile.keyword
        if kind == "VEE_PROFILE" and "profile angle" in size:
            radius, tilt = size.get("profile radius", size.get("radius", 0.0)), size.get("tilt angle", 0.0)
            return profile_shapes.section(profile, "vee", size["profile angle"], radius, tilt)
        if kind == "PARTIAL_CIRCULAR_PROFILE" and {"radius", "sweep angle"} <= set(size):
            return profile_shapes.section(profile, "arc", size["sweep angle"], size["radius"])
        width = size.get("width", size.get("profile width"))
        if kind not in ("SQUARE_U_PROFILE", "ROUNDED_U_PROFILE") or width is None:
            raise profile.fault("stepnc-unsupported", "a slot of this profile cannot be made")
        if kind == "ROUNDED_U_PROFILE":
            return {"width": width, "floor_radius": width / 2}
        angles = [size.get(f"{name} angle", 0.0) for name in ("first", "second")]
        slope = profile_shapes.wall_slope(profile, *angles)
        return {"width": width, "floor_radius": size.get("first radius"), "slope": slope}
