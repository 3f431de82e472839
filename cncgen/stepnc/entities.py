"""Instances with their attributes by name, and the handling of faulty ones.

A fault is reported where it is met. It then ends only the smallest unit that needs the faulty instance: `Skip` propagates to the code
that executes this unit, and this code goes on with the next one. So one run names the faults of the whole file.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol, TypeVar

from cncgen.diagnostics import Severity
from cncgen.stepnc.part21 import DERIVED, Enumeration, Exchange, Instance, Ref, Typed, Value
from cncgen.stepnc.schema.tables import positions

#: Largest number, in the file's unit: of products of three a double holds more than nine.
MAX_NUMBER = 1e15


class Skip(Exception):
    """The entity being read has a fault, which is reported."""


class Entity:
    """An instance with its attributes by the names of the schema."""

    __slots__ = ("file", "instance", "keyword", "parameters")

    def __init__(self, file: Entities, instance: Instance, keyword: str) -> None:
        self.file = file
        self.instance = instance
        self.keyword = keyword
        part = instance.part(keyword)
        self.parameters: tuple[Value, ...] = (part or instance.parts[0]).parameters

    @property
    def id(self) -> int:
        """Return the number of the instance."""
        return self.instance.id

    def get(self, name: str) -> Value:
        """Return an attribute; None where it is ``$``, ``*``, or the entity has no such attribute."""
        if len(self.instance.parts) == 1:
            k = positions(self.keyword, self.file.iso).get(name, -1)
            value = self.parameters[k] if 0 <= k < len(self.parameters) else None
        else:
            value = self._of_parts(name)
        return None if value is DERIVED else value

    def _of_parts(self, name: str) -> Value:
        """Return an attribute of a complex instance: a part has the attributes of its own, the last ones of its entity."""
        for keyword, parameters in ((self.keyword, self.parameters), *self.instance.parts):
            names = positions(keyword, self.file.iso)
            k = names.get(name, -1) - max(len(names) - len(parameters), 0)
            if 0 <= k < len(parameters):
                return parameters[k]
        return None

    def number(self, name: str, default: float | None = None) -> float:
        """Return a number; `default` where it is missing, if given.

        Raises:
            Skip: where it is missing without a default, or no number.
        """
        value = self.get(name)
        if isinstance(value, Typed):
            value = value.value
        if value is None and default is not None:
            return default
        if isinstance(value, Ref) or not isinstance(value, int | float):
            raise self.fault("stepnc-missing", f"{name} must be a number", value)
        return self.within(name, value)

    def optional(self, name: str) -> float | None:
        """Return a number, or None where it is missing.

        Raises:
            Skip: where the attribute holds something else.
        """
        return None if self.get(name) is None else self.number(name)

    def ratio(self, name: str, value: float) -> float:
        """Return a ratio of a value that should be one; where it is above 1 it is percent, with a warning."""
        if value <= 1.0:
            return value
        text = f"{name} is {value:g}, which is too large for a ratio; it is taken as {value:g} percent"
        self.warn("stepnc-ratio", text)
        return value / 100.0

    def text(self, name: str) -> str:
        """Return a string, empty where it is missing or no string."""
        value = self.get(name)
        return str(value) if isinstance(value, str) else ""

    def flag(self, name: str) -> bool | None:
        """Return ``.T.`` or ``.F.`` as a bool, None for anything else."""
        value = self.get(name)
        return {"T": True, "F": False}.get(str(value)) if isinstance(value, Enumeration) else None

    def enum(self, name: str) -> str:
        """Return the name of an enumeration item, empty where it is missing."""
        value = self.get(name)
        return str(value) if isinstance(value, Enumeration) else ""

    def ref(self, name: str) -> int | None:
        """Return the id that an attribute refers to, None where it is missing.

        Raises:
            Skip: where the attribute holds something else.
        """
        value = self.get(name)
        if value is None:
            return None
        if not isinstance(value, Ref):
            raise self.fault("stepnc-missing", f"{name} must be a reference", value)
        return int(value)

    def entity(self, name: str, *kinds: str) -> Entity:
        """Return the entity that an attribute refers to, of one of the kinds if any are given.

        Raises:
            Skip: where the attribute is missing, or refers to an entity of another kind.
        """
        ident = self.ref(name)
        if ident is None:
            raise self.fault("stepnc-missing", f"{name} must be given", None)
        return self.file.get(ident, *kinds, owner=self.id)

    def refs(self, name: str) -> list[int]:
        """Return the ids of an aggregate of references, empty where it is missing.

        Raises:
            Skip: where the attribute holds something else.
        """
        value = self.get(name)
        if value is None:
            return []
        if not isinstance(value, tuple) or isinstance(value, Typed):
            raise self.fault("stepnc-missing", f"{name} must be a list of references", value)
        if not all(isinstance(v, Ref) for v in value):
            raise self.fault("stepnc-missing", f"{name} must hold references alone", None)
        return [int(v) for v in value]

    def numbers(self, name: str) -> list[float]:
        """Return an aggregate of numbers.

        Raises:
            Skip: where the attribute holds something else.
        """
        value = self.get(name)
        if not isinstance(value, tuple) or isinstance(value, Typed):
            raise self.fault("stepnc-missing", f"{name} must be a list of numbers", value)
        plain = [v.value if isinstance(v, Typed) else v for v in value]
        if not all(isinstance(v, int | float) and not isinstance(v, Ref) for v in plain):
            raise self.fault("stepnc-missing", f"{name} must hold numbers alone", None)
        return [self.within(name, v) for v in plain]

    def within(self, name: str, value: float) -> float:
        """Return a number.

        Raises:
            Skip: where it is too large.
        """
        if not abs(value) <= MAX_NUMBER:
            raise self.fault("stepnc-range", f"{name} is beyond ±{MAX_NUMBER:g}")
        return float(value)

    def fault(self, code: str, message: str, value: Any = None, hint: str = "") -> Skip:
        """Report an error of this instance and return the exception to raise."""
        shown = f", not {value!r}"[:60] if value is not None else ""
        self.file.exchange.report(self.id, code, f"#{self.id} {self.keyword}: {message}{shown}", hint=hint)
        return Skip()

    def warn(self, code: str, message: str, hint: str = "") -> None:
        """Report a warning of this instance."""
        text = f"#{self.id} {self.keyword}: {message}"
        self.file.exchange.report(self.id, code, text, severity=Severity.WARNING, hint=hint)


class Holder(Protocol):
    """A record that names an entity, as an item of a representation does."""

    @property
    def entity(self) -> Entity:
        """Return the entity."""


H = TypeVar("H", bound=Holder)


def only(name: str, found: Sequence[H], hint: str = "") -> H | None:
    """Return the first of records that all name one entity; None of none (`Entities.only`).

    Raises:
        Skip: where they name several.
    """
    if found:
        found[0].entity.file.only(name, (f.entity.id for f in found), hint)
    return found[0] if found else None


class Entities:
    """A file's instances as entities of ISO 14649 (`iso`) or of the AP238 AIM."""

    def __init__(self, exchange: Exchange, iso: bool) -> None:
        self.exchange = exchange
        self.iso = iso

    def get(self, ident: int, *kinds: str, owner: int | None = None) -> Entity:
        """Return an entity; of a complex instance the part of the first kind that it has.

        Raises:
            Skip: where the file has no such entity, or one of another kind.
        """
        instance = self.exchange.instance(ident)
        if instance is None:
            if self.exchange.row_of(ident) < 0 and owner is not None:
                self.exchange.report_missing(self.exchange.row_of(owner), ident)
            raise Skip()
        for kind in kinds:
            if instance.part(kind) is not None:
                return Entity(self, instance, kind)
        if kinds:
            wanted = kinds[0] if len(kinds) == 1 else "one of " + ", ".join(kinds[:6])
            place = owner if owner is not None else ident
            text = f"#{ident} {instance.keyword} stands where #{place} needs {wanted}"
            self.exchange.report(place, "stepnc-type", text)
            raise Skip()
        return Entity(self, instance, instance.parts[0].keyword)

    def only(self, name: str, ids: Iterable[int], hint: str = "") -> int | None:
        """Return the one entity that the standard has under a name; None where there is none.

        Args:
            name: How messages call it.
            ids: The ids in the file; one that is given twice counts once.
            hint: The text to write in place of several.

        Raises:
            Skip: where there are several: none of them is more valid than another.
        """
        found = list(dict.fromkeys(ids))
        if len(found) > 1:
            shown = ", ".join(f"#{i}" for i in found[:6]) + (", …" if len(found) > 6 else "")
            text = f"the standard has one {name}, and the file gives {len(found)} ({shown}): which of them counts is not known"
            raise self.get(found[1]).fault("stepnc-several", text, hint=hint)
        return found[0] if found else None

    def keyword(self, ident: int | None) -> str:
        """Return the type of an instance, empty where the file has none with this id."""
        instance = self.exchange.instance(ident) if ident is not None else None
        return instance.keyword if instance else ""

    def optional(self, ident: int | None) -> Entity | None:
        """Return an entity, or None where no id is given.

        Raises:
            Skip: where the id is not in the file.
        """
        return None if ident is None else self.get(ident)

    def all(self, ids: Sequence[int]) -> list[Entity]:
        """Return several entities.

        Raises:
            Skip: where one is not in the file.
        """
        return [self.get(i) for i in ids]
