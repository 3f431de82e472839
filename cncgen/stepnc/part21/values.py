"""The values of an exchange structure as Python values.

An integer is an `int`, a real a `float`, a string a `str` with its control directives resolved, an aggregate a
`tuple`, ``$`` gives None, ``*`` gives `DERIVED`; the rest are the small types of this module.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, TypeAlias


class Ref(int):
    """The name of an entity instance, ``#12``."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"#{int(self)}"

    __str__ = __repr__


class ValueRef(int):
    """The name of a value instance, ``@12`` (edition 3)."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"@{int(self)}"


class Enumeration(str):
    """The name of an enumeration item in capitals, without its points: ``.CARTESIAN.``, ``.T.``."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f".{self}."


class Constant(str):
    """A constant of the schema, ``#PI`` or ``@PI``, with its sign."""

    __slots__ = ()


class Resource(str):
    """A URI between angle brackets, of the ANCHOR and REFERENCE sections, without them."""

    __slots__ = ()


class Binary(str):
    """The hexadecimal digits of a binary value, the first telling how many leading bits are unused."""

    __slots__ = ()


class Typed(NamedTuple):
    """A value with the name of its type, ``RATIO_MEASURE(0.5)``: a member of a SELECT."""

    type: str
    value: Value


class _Derived:
    """The only value of its kind: ``*``, an attribute that a subtype derives."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "*"


DERIVED: Final = _Derived()

Value: TypeAlias = Any


class Record(NamedTuple):
    """A keyword in capitals with its parameters."""

    keyword: str
    parameters: tuple[Value, ...]


class Instance(NamedTuple):
    """An entity instance: one part, or the several of a complex instance.

    Attributes:
        id: Its number.
        parts: In the order of the text.
    """

    id: int
    parts: tuple[Record, ...]

    @property
    def keyword(self) -> str:
        """Return the type of a simple instance, the types joined by ``+`` of a complex one."""
        return self.parts[0].keyword if len(self.parts) == 1 else "+".join(p.keyword for p in self.parts)

    @property
    def parameters(self) -> tuple[Value, ...]:
        """Return the parameters of a simple instance, those of the first part of a complex one."""
        return self.parts[0].parameters

    def part(self, keyword: str) -> Record | None:
        """Return the part of that type, or None."""
        for part in self.parts:
            if part.keyword == keyword:
                return part
        return None
