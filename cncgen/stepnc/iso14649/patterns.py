"""Replicated features: the base feature once a place, in the order of ISO 14649-10."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.frames import Vector, translation
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

    def _changes(self, entity: Entity, name: str, *kinds: str) -> list[Entity]:
        """Return the CIRCULAR_OMITs of a pattern, say, in the order of the file."""
        return [self.entities.get(ident, *kinds, owner=entity.id) for ident in entity.refs(name)]

    def _number(self, change: Entity, name: str, count: int) -> int:
        """Return a copy's, row's or column's number, from 0.

        In the file they count from 1: the maximum index of a circle is number_of_feature and the omitted ones together, and
        times the angle it may be a whole turn (ISO 14649-10, circular_pattern).
        """
        number = change.number(name)
        if not 1 <= number <= count or number != int(number):
            raise change.fault(
                "stepnc-geometry", f"{name} is {number:g}; the pattern's count from 1 to {count}"
            )
        return int(number) - 1

    def circular(self, entity: Entity) -> Shape:
        """Return copies about the pattern's Z axis, `angle_increment` apart.

        Each is turned by `base_feature_rotation` from the one before it; without one it turns as it goes round.
        """
        base = self._base(entity)
        omitted = self._changes(entity, "missing_base_feature", "CIRCULAR_OMIT")
        moved = self._changes(entity, "relocated_base_feature", "CIRCULAR_OFFSET")
        count = self._count(entity, "number_of_feature") + len(omitted)
        step = entity.number("angle_increment") * self.features.curves.angle
        turn = entity.optional("base_feature_rotation")
        if count * abs(step) > 2 * math.pi + 1e-9:
            text = f"{count} copies {math.degrees(step):g} degrees apart are more than a turn"
            entity.warn("stepnc-geometry", text)
        left = {self._number(change, "index", count) for change in omitted}
        if len(left) < len(omitted):
            raise entity.fault("stepnc-geometry", "missing_base_feature names a copy twice")
        around: Vector = np.arange(count, dtype=float)
        angles = around * step
        turns = angles.copy() if turn is None else around * (turn * self.features.curves.angle)
        for change in moved:
            k = self._number(change, "index", count)
            offset = change.number("angular_offset") * self.features.curves.angle
            angles[k] += offset
            turns[k] += offset if turn is None else 0.0
        kept = [k for k in range(count) if k not in left]
        diameter = self.features.profiles.optional_length(entity, "base_feature_diameter")
        places = profile_shapes.circular_places(entity, base.placement, angles[kept], turns[kept], diameter)
        return Shape(elements=tuple(replace(base, placement=p) for p in places))

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
        places = profile_shapes.rectangular_places(rows, columns, row_spacing, spacing)

        def place(change: Entity) -> int:
            row = self._number(change, "row_index", rows)
            return row * columns + self._number(change, "column_index", columns)

        for change in self._changes(entity, "relocated_base_feature", "RECTANGULAR_OFFSET"):
            way = change.entity("offset_direction").id
            offset = self.features.placements.direction(way, change.id) * change.number("offset_distance")
            places[place(change)] = elementary.product(translation(*offset), places[place(change)])
        left = {place(c) for c in self._changes(entity, "missing_base_feature", "RECTANGULAR_OMIT")}
        base = self._base(entity)
        kept = (elementary.product(p, base.placement) for k, p in enumerate(places) if k not in left)
        return Shape(elements=tuple(replace(base, placement=p) for p in kept))

    def general(self, entity: Entity) -> Shape:
        """Return a copy at every given placement, which stands for the base feature's own."""
        base = self._base(entity)
        places = (
            self.features.placements.placement(i, entity.id) for i in entity.refs("replicate_locations")
        )
        return Shape(elements=tuple(replace(base, placement=p) for p in places))

    def _direction(self, entity: Entity, name: str, default: np.ndarray) -> np.ndarray:
        ident = entity.ref(name)
        return default if ident is None else self.features.placements.direction(ident, entity.id)
