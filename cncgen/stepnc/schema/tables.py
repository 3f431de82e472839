"""Entities with their attributes, by name.

Kinds of attributes: ``s`` string, ``n`` number, ``e`` enumeration or truth value, ``l`` aggregate, ``r`` reference to
an instance (``r=TYPE``: of that type), ``*`` anything, ``+``
any number of further attributes. Every attribute may be ``$`` or ``*`` here; the code that needs it decides whether it may be missing.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from cncgen.stepnc.schema import ap238, iso14649, turning


class Attribute(NamedTuple):
    """Name, kind (see the module) and, of a reference, the type that it must have or ""."""

    name: str
    kind: str
    target: str = ""


Table = dict[str, tuple[Attribute, ...]]


def _expand(text: str, heads: dict[str, str]) -> tuple[Attribute, ...]:
    attributes: list[Attribute] = []
    for word in text.split():
        if word.startswith("&"):
            attributes.extend(_expand(heads[word[1:]], heads))
        else:
            name, kind = word.split(":")
            kind, _, target = kind.partition("=")
            attributes.append(Attribute(name, kind, target))
    return tuple(attributes)


def _table(entities: str, heads: dict[str, str]) -> Table:
    pairs = (line.partition(" ") for line in entities.splitlines() if line)
    return {name: _expand(rest, heads) for name, _, rest in pairs}


@cache
def iso14649_table() -> Table:
    """Return the entities of ISO 14649."""
    return _table(iso14649.ENTITIES + turning.ENTITIES, iso14649.HEADS | turning.HEADS)


@cache
def ap238_table() -> Table:
    """Return the entities of the AP238 AIM, with the geometry that ISO 14649 shares."""
    geometry = (
        "BEZIER_CURVE",
        "UNIFORM_CURVE",
        "HELIX",
        "CURVE",
        "AXIS1_PLACEMENT",
        "BLOCK",
        "RIGHT_CIRCULAR_CYLINDER",
    )
    shared = iso14649_table()
    return {k: shared[k] for k in geometry if k in shared} | _table(ap238.ENTITIES, ap238.HEADS)


@cache
def positions(entity: str, iso: bool) -> dict[str, int]:
    """Return the position of each attribute of an entity of ISO 14649 (else of AP238), empty where it is unknown."""
    table = iso14649_table() if iso else ap238_table()
    return {a.name: k for k, a in enumerate(table.get(entity, ()))}


@cache
def supertypes() -> dict[str, tuple[str, ...]]:
    """Return the direct supertypes of every entity of both schemas, those of the AIM first."""
    found: dict[str, dict[str, None]] = {name: {} for name in iso14649_table() | ap238_table()}
    for line in (ap238.SUBTYPES + iso14649.SUBTYPES).split("\n"):
        supertype, _, subtypes = line.partition(" ")
        for name in subtypes.split():
            found.setdefault(name, {})[supertype] = None
    return {name: tuple(above) for name, above in found.items()}
