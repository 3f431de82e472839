"""The graph from a feature of the AIM to its measures, placement, profiles and parts (ISO 10303-238, 5.1.4).

A feature is described by shape representations; its profiles, paths, ends and bottoms are shape aspects of their own, reached by
relationships through an *occurrence*, a shape aspect of the feature's shape. Features that belong to a feature (elements of a
compound, bosses, the base of a pattern) hang on the other end of a relationship.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.technology import described
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entity, Skip, only
from cncgen.stepnc.geometry.frames import Matrix, Placements, Vector

_RELATIONS = ("SHAPE_DEFINING_RELATIONSHIP", "FEATURE_COMPONENT_RELATIONSHIP")
_ASPECTS = ("SHAPE_ASPECT", "COMPOSITE_SHAPE_ASPECT", "COMPOSITE_GROUP_SHAPE_ASPECT")
#: Sizes alike, mm or rad.
SAME = 1e-9
_PLACED = ("AXIS2_PLACEMENT_3D", "PLANE", "DIRECTION", "CARTESIAN_POINT")


class Component(NamedTuple):
    """A profile, path, bottom, end or taper of a feature.

    Attributes:
        role, usage: Name and description of the relationship, lower case: ``hole depth``, ``profile usage``.
        occurrence: Description of the occurrence, lower case.
        entity: The shape aspect.
    """

    role: str
    usage: str
    occurrence: str
    entity: Entity


class Shapes:
    """Reads what shape representations say of features and shape aspects."""

    def __init__(self, graph: Graph, units: Units) -> None:
        self.graph = graph
        self.entities = graph.entities
        self.units = units

    def placements(self, item: Item) -> Placements:
        """Return the reader of placements in an item's units."""
        return Placements(self.entities, self.units.context(item.context)[0])

    def items(self, ident: int) -> list[Item]:
        """Return the items of the shape representations of a feature or shape aspect."""
        out: list[Item] = []
        owners = [ident]
        for keyword in ("PRODUCT_DEFINITION_SHAPE", "PROPERTY_DEFINITION"):
            owners += self.graph.index(keyword, 0).of(ident)
        for owner in owners:
            for keyword in ("SHAPE_DEFINITION_REPRESENTATION", "PROPERTY_DEFINITION_REPRESENTATION"):
                for link in self.graph.index(keyword, 0).of(owner):
                    representation = self.entities.get(link).ref("used_representation")
                    if representation is not None:
                        out += self.graph.items(representation)
        return out

    def measures(self, ident: int) -> dict[str, float]:
        """Return the measures of a feature or shape aspect by their names, mm and rad.

        Raises:
            Skip: where one has two values.
        """
        out: dict[str, float] = {}
        first: dict[str, Item] = {}
        for item in self.items(ident):
            if described(item) or item.entity.keyword in _PLACED:
                continue
            try:
                measure = self.units.measure(item.entity)
            except Skip:
                continue
            if measure is not None:
                name = item.name or measure.name
                if name and abs(out.get(name, measure.value) - measure.value) > SAME:
                    only(name, [first[name], item])
                out[name] = measure.value
                first.setdefault(name, item)
        return out

    def words(self, ident: int) -> list[str]:
        """Return the texts that describe a feature or shape aspect, lower case."""
        return [text for text in map(described, self.items(ident)) if text]

    def frames(self, ident: int, name: str) -> list[Matrix]:
        """Return the placements of a name, ``orientation`` for instance, in the order of the file.

        Raises:
            Skip: where one has a fault.
        """
        return [
            self.placements(item).placement(item.entity.id)
            for item in self.items(ident)
            if item.name == name and item.entity.keyword == "AXIS2_PLACEMENT_3D"
        ]

    def frame(self, ident: int, name: str) -> Matrix | None:
        """Return the placement of a name, or None; one that is given again at the same place counts once.

        Raises:
            Skip: where it has a fault, or there are several.
        """
        items = [i for i in self.items(ident) if i.name == name and i.entity.keyword == "AXIS2_PLACEMENT_3D"]
        frames = [self.placements(item).placement(item.entity.id) for item in items]
        others = [i for i, f in zip(items, frames, strict=True) if not np.allclose(f, frames[0], atol=1e-9)]
        only(name, [*items[:1], *others])
        return frames[0] if frames else None

    def direction(self, ident: int, representation: str | None = None) -> Vector | None:
        """Return a DIRECTION (of a representation of that name, where one is given), or None.

        Raises:
            Skip: where it has a fault.
        """
        items = [i for i in self.items(ident) if i.entity.keyword == "DIRECTION"]
        if representation is not None:
            items = [i for i in items if i.representation.strip().lower() == representation]
        item = only(representation or "direction", items)
        return None if item is None else self.placements(item).direction(item.entity.id)

    def limit(self, ident: int) -> float | None:
        """Return the height of the plane 'maximum feature limit' in the feature's frame, mm, or None.

        Raises:
            Skip: where it has a fault.
        """
        name = "maximum feature limit"
        planes = [i for i in self.items(ident) if i.entity.keyword == "PLANE"]
        item = only(name, [i for i in planes if i.representation.strip().lower() == name])
        plane = None if item is None else self.placements(item).plane(item.entity.id)
        return None if plane is None else float(plane[2, 3])

    # Parts of a feature

    def aspects(self, feature: int) -> list[Entity]:
        """Return the shape aspects of a feature's shape."""
        index = self.graph.index
        return [
            self.entities.get(aspect)
            for shape in index("PRODUCT_DEFINITION_SHAPE", 0).of(feature)
            for keyword in _ASPECTS
            for aspect in index(keyword, 0).of(shape)
        ]

    def components(self, feature: int) -> list[Component]:
        """Return the profiles, paths, bottoms, ends and tapers of a feature.

        Raises:
            Skip: where a relationship has a fault.
        """
        out = []
        for aspect in self.aspects(feature):
            for keyword in _RELATIONS:
                for link in self.graph.index(keyword, 1).of(aspect.id):
                    relation = self.entities.get(link, keyword)
                    words = (relation.text("name"), relation.text("description"), aspect.text("description"))
                    role, usage, occurrence = (w.strip().lower() for w in words)
                    out.append(Component(role, usage, occurrence, relation.entity("relating_shape_aspect")))
        return out

    def members(self, feature: int) -> Iterator[tuple[str, str, int]]:
        """Yield the features that a feature relates to: name and description of the relationship, and the feature.

        Raises:
            Skip: where a relationship has a fault.
        """
        for owner in (feature, *(a.id for a in self.aspects(feature))):
            for link in self.graph.index("FEATURE_COMPONENT_RELATIONSHIP", 0).of(owner):
                relation = self.entities.get(link, "FEATURE_COMPONENT_RELATIONSHIP")
                related = relation.entity("related_shape_aspect")
                if related.instance.part("INSTANCED_FEATURE") is not None:
                    name, text = relation.text("name"), relation.text("description")
                    yield name.strip().lower(), text.strip().lower(), related.id


def flipped() -> Matrix:
    """Return the frame turned half round X: Z becomes −Z and Y becomes −Y."""
    return np.diag([1.0, -1.0, -1.0, 1.0])
