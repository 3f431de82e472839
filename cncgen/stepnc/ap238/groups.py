"""Features made of features: patterns, compound features, counterbored and countersunk holes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.ap238.shapes import Shapes
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.frames import Matrix, Vector
from cncgen.stepnc.model import Feature, Shape

MAX_COPIES = 10_000
_HOLES = {"counterbore": "counterbore hole", "countersunk": "countersunk hole"}


class Groups:
    """Reads the features that belong to another one into a shape with elements.

    Args:
        shapes: Of the file.
        read: Returns a feature by its number; raises `Skip`.
    """

    def __init__(self, shapes: Shapes, read: Callable[[int], Feature]) -> None:
        self.shapes = shapes
        self._read = read

    def hole_kind(self, entity: Entity) -> str:
        """Return ``counterbore hole`` or ``countersunk hole`` of a COMPOSITE_HOLE."""
        part = entity.instance.part("CHARACTERIZED_OBJECT")
        words = str(part.parameters[-1] or "").strip().lower() if part and part.parameters else ""
        return _HOLES.get(words, "compound feature")

    def shape(self, entity: Entity, kind: str) -> Shape:
        """Return a shape whose elements are placed within the group.

        Raises:
            Skip: where something is missing, or there are too many.
        """
        if kind in ("COMPOUND_FEATURE", "COMPOSITE_HOLE"):
            members = dict.fromkeys(ident for _, _, ident in self.shapes.members(entity.id))
            if not members:
                raise entity.fault("stepnc-missing", "the compound feature has no elements")
            return Shape(elements=tuple(self._read(i) for i in members))
        self._refuse_changes(entity)
        bases = [i for name, _, i in self.shapes.members(entity.id) if name == "pattern basis"]
        base = self.shapes.entities.only("basis of a pattern", bases)
        if base is None:
            raise entity.fault(
                "stepnc-missing", "no relationship 'pattern basis' leads to the pattern's feature"
            )
        feature = self._read(base)
        return Shape(
            elements=tuple(
                replace(feature, placement=p) for p in self._placements(entity, kind, feature.placement)
            )
        )

    def _refuse_changes(self, entity: Entity) -> None:
        """Refuse patterns some of whose copies are left out or moved: their indexes' first number is not known."""
        for aspect in (entity.id, *(a.id for a in self.shapes.aspects(entity.id))):
            for keyword in ("PATTERN_OFFSET_MEMBERSHIP", "PATTERN_OMIT_MEMBERSHIP"):
                if self.shapes.graph.index(keyword, 0).of(aspect):
                    text = "copies that are moved or left out cannot be read; give the features one by one"
                    raise entity.fault("stepnc-unsupported", text)

    def _placements(self, entity: Entity, kind: str, base: Matrix) -> list[Matrix]:
        size = self.shapes.measures(entity.id)
        if kind == "CIRCULAR_PATTERN":
            step = self._needed(entity, size, "angular spacing")
            k: Vector = np.arange(self._count(entity, size, "number of features"), dtype=float)
            turn = size.get("base feature rotation", step)
            return profile_shapes.circular_places(entity, base, k * step, k * turn, size.get("diameter"))
        if kind == "FEATURE_PATTERN":
            return self.shapes.frames(entity.id, "base feature placement")
        return [elementary.product(p, base) for p in self._rows(entity, size)]

    def _rows(self, entity: Entity, size: dict[str, float]) -> list[Matrix]:
        rows, columns = (self._count(entity, size, f"number of {n}") for n in ("rows", "columns"))
        if rows * columns > MAX_COPIES:
            raise entity.fault("stepnc-geometry", f"{rows} x {columns} copies, more than {MAX_COPIES}")
        along = self.shapes.direction(entity.id, "column layout direction")
        across = self.shapes.direction(entity.id, "row layout direction")
        x, y = np.eye(3)[:2]
        column = (self._needed(entity, size, "column spacing") if columns > 1 else 0.0) * (
            x if along is None else along
        )
        row = (self._needed(entity, size, "row spacing") if rows > 1 else 0.0) * (
            y if across is None else across
        )
        return profile_shapes.rectangular_places(rows, columns, row, column)

    def _needed(self, entity: Entity, size: dict[str, float], name: str) -> float:
        if name not in size:
            raise entity.fault("stepnc-missing", f"the pattern has no {name!r}")
        return size[name]

    def _count(self, entity: Entity, size: dict[str, float], name: str) -> int:
        count = size.get(name, 1.0)
        if not 1 <= count <= MAX_COPIES:
            raise entity.fault("stepnc-geometry", f"{name} is {count:g}, not 1 to {MAX_COPIES}")
        return round(count)
