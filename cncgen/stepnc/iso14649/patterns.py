"""Replicated features: the base feature once a place, in the order of ISO 14649-10."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry import profiles
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.model import Feature, Shape

if TYPE_CHECKING:
    from cncgen.stepnc.iso14649.features import Features

MAX_COPIES = 10_000


class Patterns:
    """Reads patterns into a shape whose elements are placed copies."""

    def __init__(self, entities: Entities, features: Features) -> None:
        self.entities = entities
        self.features = features

    def _base(self, entity: Entity) -> Feature:
        return self.features.read(entity.entity("replicate_base_feature").id)

    def _count(self, entity: Entity, name: str) -> int:
        count = int(entity.number(name, 1))
        if not 1 <= count <= MAX_COPIES:
            raise entity.fault("stepnc-geometry", f"{name} is {count}, not 1 to {MAX_COPIES}")
        return count

    def _copies(self, entity: Entity, places: list[Matrix]) -> Shape:
        base = self._base(entity)
        for name in ("relocated_base_feature", "missing_base_feature"):
            if entity.refs(name):
                raise entity.fault(
                    "stepnc-unsupported", f"{name} cannot be read; give the features one by one"
                )
        return Shape(elements=tuple(replace(base, placement=p @ base.placement) for p in places))

    def circular(self, entity: Entity) -> Shape:
        """Return copies about the pattern's Z axis, `angle_increment` apart."""
        step = entity.number("angle_increment") * self.features.curves.angle
        diameter = self.features.profiles.optional_length(entity, "base_feature_diameter")
        turn = entity.number("base_feature_rotation", 0.0) * self.features.curves.angle
        count = self._count(entity, "number_of_feature")
        return self._copies(entity, profiles.circular_places(entity, count, step, diameter or 0.0, turn))

    def rectangular(self, entity: Entity) -> Shape:
        """Return copies in rows: within a row along its_direction, row after row along row_layout_direction."""
        length = self.features.profiles.length
        columns = self._count(entity, "number_of_columns")
        rows = self._count(entity, "number_of_rows")
        if rows * columns > MAX_COPIES:
            raise entity.fault("stepnc-geometry", f"{rows} x {columns} copies, more than {MAX_COPIES}")
        along = self._direction(entity, "its_direction", np.array([1.0, 0.0, 0.0]))
        across = self._direction(entity, "row_layout_direction", np.array([0.0, 1.0, 0.0]))
        spacing = length(entity, "spacing") * along
        row_spacing = (length(entity, "row_spacing") if rows > 1 else 0.0) * across
        return self._copies(entity, profiles.rectangular_places(rows, columns, row_spacing, spacing))

    def general(self, entity: Entity) -> Shape:
        """Return a copy at every given placement."""
        ids = entity.refs("replicate_locations")
        return self._copies(entity, [self.features.placements.placement(i, entity.id) for i in ids])

    def _direction(self, entity: Entity, name: str, default: np.ndarray) -> np.ndarray:
        ident = entity.ref(name)
        return default if ident is None else self.features.placements.direction(ident, entity.id)
