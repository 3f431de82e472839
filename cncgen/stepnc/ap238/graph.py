"""The graph of an AIM file backwards: the properties of each instance, and the instances related to it.

Each index is made of the columns of references once, without parsing a record.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cncgen.stepnc.entities import Entities, Entity, Skip
from cncgen.stepnc.part21 import Exchange


class Index:
    """Instances of some types by one of the instances that they refer to."""

    def __init__(self, exchange: Exchange, position: int | None, *keywords: str) -> None:
        """Index by the reference at `position` (from 0, −1 the last), by all of them where None."""
        rows = exchange.rows_of_type(*keywords)
        targets, offsets = exchange.links
        begin, end = offsets[rows], offsets[rows + 1]
        if position is None:
            counts = end - begin
            owner = np.repeat(rows, counts)
            at = np.repeat(begin - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts) + np.arange(
                counts.sum()
            )
        else:
            at = begin + position if position >= 0 else end + position
            inside = (at >= begin) & (at < end)
            at, owner = at[inside], rows[inside]
        keys = targets[at] if len(at) else np.zeros(0, np.int64)
        order = np.argsort(keys, kind="stable")
        self._keys, self._ids = keys[order], exchange.rows.ids[owner][order]

    def of(self, ident: int) -> list[int]:
        """Return the ids of the instances that refer to `ident`, in the order of the file."""
        low = self._keys.searchsorted(ident)
        if low == len(self._keys) or self._keys[low] != ident:
            return []
        return self._ids[low : self._keys.searchsorted(ident, "right")].tolist()


class Item(NamedTuple):
    """An item of a representation, with the representation's name and context."""

    entity: Entity
    name: str
    representation: str
    context: int | None


class Graph:
    """Properties and relationships of an AIM file."""

    def __init__(self, entities: Entities) -> None:
        self.entities = entities
        exchange = entities.exchange
        self._properties = Index(exchange, 0, "ACTION_PROPERTY", "MACHINING_PROCESS_PROPERTY")
        self._representations = Index(exchange, 0, "ACTION_PROPERTY_REPRESENTATION")
        self._resource_properties = Index(exchange, 0, "RESOURCE_PROPERTY")
        self._resource_representations = Index(exchange, 0, "RESOURCE_PROPERTY_REPRESENTATION")
        self._relations: dict[str, Index] = {}

    def index(self, keyword: str, position: int | None) -> Index:
        """Return the index of a type by one of its references."""
        key = f"{keyword} {position}"
        if key not in self._relations:
            self._relations[key] = Index(self.entities.exchange, position, keyword)
        return self._relations[key]

    def related(self, ident: int, keyword: str) -> list[Entity]:
        """Return the instances that relationships of a type relate to an instance, by sequence position, not by number.

        Raises:
            Skip: where one has a fault.
        """
        return [self.entities.get(i, owner=ident) for i in self.related_ids(ident, keyword)]

    def related_ids(self, ident: int, keyword: str) -> list[int]:
        """Return the ids of the result of `related`.

        Raises:
            Skip: where a relationship has a fault.
        """
        exchange = self.entities.exchange
        out = []
        for k, relation_id in enumerate(self.index(keyword, 0).of(ident)):
            row = exchange.row_of(relation_id)
            links = exchange.links_of(row)
            if len(links) != 2:
                relation = self.entities.get(relation_id, keyword)
                raise relation.fault("stepnc-missing", "relating_method and related_method must be given")
            place = exchange.last_number(row)
            out.append((float(k) if place is None else place, k, int(links[1])))
        return [target for _, _, target in sorted(out)]

    def relation_names(self, ident: int, keyword: str) -> list[tuple[str, Entity]]:
        """Return name and related entity of the relationships of a type.

        Raises:
            Skip: where one has a fault.
        """
        relations = [self.entities.get(i, keyword) for i in self.index(keyword, 0).of(ident)]
        return [(r.text("name"), r.entity("related_method")) for r in relations]

    def properties(self, ident: int) -> dict[str, list[Item]]:
        """Return the items of all properties of an action method by the property's name, lower case."""
        return self._gather(ident, self._properties, self._representations)

    def resource_items(self, ident: int) -> list[tuple[str, Item]]:
        """Return the items of all properties of a resource (a tool), one property or many, with the property's name."""
        found = self._gather(ident, self._resource_properties, self._resource_representations)
        return [(name, item) for name, items in found.items() for item in items]

    def _gather(self, ident: int, properties: Index, representations: Index) -> dict[str, list[Item]]:
        exchange = self.entities.exchange
        out: dict[str, list[Item]] = {}
        for property_id in properties.of(ident):
            try:
                name = self.entities.get(property_id).text("name").strip().lower()
                for link_id in representations.of(property_id):
                    links = exchange.links_of(exchange.row_of(link_id))
                    if len(links) == 2:
                        out.setdefault(name, []).extend(self.items(int(links[1])))
            except Skip:
                continue
        return out

    def items(self, ident: int) -> list[Item]:
        """Return the items of a representation.

        Raises:
            Skip: where one is not in the file.
        """
        instance = self.entities.exchange.instance(ident)
        if instance is None:
            raise Skip
        # Every kind of representation has name, items, context; a complex one keeps them in the part that has three.
        part = next((p for p in instance.parts if len(p.parameters) == 3), instance.parts[0])
        values = (*part.parameters, None, None, None)
        label, members, context = values[0], values[1], values[2]
        ids = [int(m) for m in members if isinstance(m, int)] if isinstance(members, tuple) else []
        name = str(label) if isinstance(label, str) else ""
        where = int(context) if isinstance(context, int) else None
        return [Item(self.entities.get(i, owner=ident), self._name(i), name, where) for i in ids]

    def context(self, ident: int) -> int | None:
        """Return the context of a representation, None where it has none."""
        instance = self.entities.exchange.instance(ident)
        part = next((p for p in instance.parts if len(p.parameters) == 3), None) if instance else None
        value = part.parameters[2] if part else None
        return int(value) if isinstance(value, int) else None

    def _name(self, ident: int) -> str:
        instance = self.entities.exchange.instance(ident)
        if instance is None:
            return ""
        part = instance.part("REPRESENTATION_ITEM") or instance.parts[0]
        value = part.parameters[0] if part.parameters else ""
        return str(value).strip().lower() if isinstance(value, str) else ""
