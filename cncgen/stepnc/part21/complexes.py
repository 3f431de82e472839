"""Instances in the external mapping that have a simple form (ISO 10303-21, 12.2.5).

``#1=(CARTESIAN_POINT((0.,0.,0.))GEOMETRIC_REPRESENTATION_ITEM()POINT()REPRESENTATION_ITEM(''))`` is an entity with its
supertypes, each with the attributes of its own, and means ``#1=CARTESIAN_POINT('',(0.,0.,0.))``. Conformance class 2 demands this
form of every instance. The schema tells which partial entity is a supertype of which, and so the order of the attributes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cncgen.kernels import part21_scan as scan
from cncgen.stepnc.part21.statements import Ints, Statements
from cncgen.stepnc.part21.values import Record

Supertypes = Mapping[str, tuple[str, ...]]
#: Supertypes that writers leave out, with attributes that say nothing: the name of an item.
_OMITTED: Mapping[str, tuple[None, ...]] = {"REPRESENTATION_ITEM": (None,)}


class Complexes:
    """The instances of a file in the external mapping that are one entity with its supertypes; their `types` become its type.

    Args:
        data: The file.
        rows: Its statements.
        supertypes: The direct supertypes of entities, in the order of the schema.
        aliases: Other names of entities, short to long.

    Attributes:
        orders: By row: the partial entities in the order of the attributes of the simple form, supertypes first.
    """

    def __init__(
        self, data: bytes, rows: Statements, supertypes: Supertypes, aliases: Mapping[str, str]
    ) -> None:
        self.orders: dict[int, tuple[str, ...]] = {}
        self._buffer = np.frombuffer(data, np.uint8)
        untyped = np.flatnonzero((rows.types == 0) & (rows.ids >= 0) & (rows.bodies < rows.ends))
        found = untyped[self._buffer[rows.bodies[untyped]] == ord("(")]
        bodies, ends = rows.bodies[found], rows.ends[found]
        most = min(int((ends - bodies).sum()) // 3, data.count(b"(")) + 1  # each has a parenthesis
        columns = [np.empty(most, np.int64) for _ in range(4)]
        count = scan.partials(self._buffer, bodies, ends, *columns)
        owners, types, begins, stops = (c[:count] for c in columns)
        if not count:
            self._parts = [np.zeros(0, np.int64)] * 3
            return
        names = {scan.keyword_hash(n.encode()): n for pair in supertypes.items() for n in (pair[0], *pair[1])}
        names |= {scan.keyword_hash(short.encode()): long for short, long in aliases.items()}
        known: dict[tuple[int, ...], tuple[str, ...]] = {}
        ranks = np.full(count, -1)
        limits = np.searchsorted(owners, np.arange(len(found) + 1)).tolist()
        for k, row in enumerate(found.tolist()):
            inside = slice(limits[k], limits[k + 1])
            signature = tuple(types[inside].tolist())
            if signature not in known:
                known[signature] = _order([names.get(t, "") for t in signature], supertypes)
            order = known[signature]
            if order:
                self.orders[row] = order
                rows.types[row] = scan.keyword_hash(order[-1].encode())
                ranks[inside] = [order.index(names[t]) for t in signature]
        places = np.lexsort((ranks, owners))
        self._parts = [a[places[ranks[places] >= 0]] for a in (found[owners], begins, stops)]

    def merged(self, row: int, parts: tuple[Record, ...]) -> tuple[Record, ...]:
        """Return the one part of the simple form of an instance; its parts as they are if it has none."""
        order = self.orders.get(row)
        if order is None:
            return parts
        held = {part.keyword: part.parameters for part in parts}
        return (Record(order[-1], tuple(v for n in order for v in held.get(n, _OMITTED.get(n, ())))),)

    def reorder(self, targets: Ints, offsets: Ints) -> None:
        """Bring the references of the instances into the order of the simple form, in place.

        Args:
            targets: References of all statements.
            offsets: Shape (n + 1,): where those of each statement begin.
        """
        rows, begins, stops = self._parts
        limits, counts = np.zeros(len(rows) + 1, np.int64), np.diff(offsets)
        own = np.empty(int(counts[list(self.orders)].sum()), np.int64)
        scan.references(self._buffer, begins, stops, own, limits)
        # Text outside of the partial entities is a fault that parsing reports.
        whole = np.bincount(rows, np.diff(limits), len(counts)) == counts
        kept = np.repeat(whole[rows], np.diff(limits))
        goal = np.flatnonzero(np.repeat(whole & np.isin(np.arange(len(counts)), rows), counts))
        targets[goal] = own[: limits[-1]][kept]


def _order(names: Sequence[str], supertypes: Supertypes) -> tuple[str, ...]:
    """Return partial entities in the order of the attributes, supertypes first; none if they are not one entity with its supertypes."""
    inner = [n for n in names if not any(n in _above(other, supertypes) for other in names)]
    if len(inner) != 1 or "" in names or len(set(names)) < len(names):
        return ()
    return tuple(n for n in (*_above(inner[0], supertypes), inner[0]) if n in names or n in _OMITTED)


def _above(name: str, supertypes: Supertypes) -> dict[str, None]:
    """Return the supertypes of an entity, each behind its own ones and once."""
    found: dict[str, None] = {}
    for supertype in supertypes.get(name, ()):
        found |= dict.fromkeys([*_above(supertype, supertypes), supertype])
    return found
