"""Units of the AIM: SI units, conversions, products of powers, and the units of a representation's context."""

from __future__ import annotations

import math
from typing import NamedTuple

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.part21 import Enumeration, Instance, Record, Ref, Typed, Value

_PREFIXES = {
    "EXA": 1e18,
    "PETA": 1e15,
    "TERA": 1e12,
    "GIGA": 1e9,
    "MEGA": 1e6,
    "KILO": 1e3,
    "HECTO": 1e2,
    "DECA": 1e1,
    "DECI": 1e-1,
    "CENTI": 1e-2,
    "MILLI": 1e-3,
    "MICRO": 1e-6,
    "NANO": 1e-9,
    "PICO": 1e-12,
    "FEMTO": 1e-15,
    "ATTO": 1e-18,
}
_MAX_DEPTH = 20
#: Largest factor between units, and 1 over the smallest one.
_MOST = 1e12


class Unit(NamedTuple):
    """A unit as a factor of mm, s, rad, revolutions and teeth, each to a power."""

    factor: float = 1.0
    length: float = 0.0
    time: float = 0.0
    angle: float = 0.0
    revolution: float = 0.0
    tooth: float = 0.0

    def to_power(self, exponent: float) -> Unit:
        """Return the unit to a power."""
        return Unit(self.factor**exponent, *(p * exponent for p in self[1:]))

    def times(self, other: Unit) -> Unit:
        """Return the product of two units."""
        return Unit(self.factor * other.factor, *(a + b for a, b in zip(self[1:], other[1:], strict=True)))


class Measure(NamedTuple):
    """A number with its unit; `value` in mm, s, rad …"""

    value: float
    unit: Unit
    name: str


class Units:
    """Reads units, measures and the units of contexts, each once."""

    def __init__(self, entities: Entities) -> None:
        self.entities = entities
        self._units: dict[int, Unit] = {}
        self._contexts: dict[int | None, tuple[float, float]] = {None: (1.0, math.pi / 180)}

    def unit(self, ident: int, depth: int = 0) -> Unit:
        """Return a unit.

        Raises:
            Skip: where the unit is not known.
        """
        if ident not in self._units:
            entity = self.entities.get(ident)
            if depth > _MAX_DEPTH:
                raise entity.fault("part21-cycle", "the unit is made of itself")
            self._units[ident] = self._read(entity, depth + 1)
        return self._units[ident]

    def _read(self, entity: Entity, depth: int) -> Unit:
        instance = entity.instance
        si = instance.part("SI_UNIT")
        if si is not None:
            return self._si(entity, si)
        conversion = instance.part("CONVERSION_BASED_UNIT")
        if conversion is not None:
            return self._conversion(entity, conversion, depth)
        dependent = instance.part("CONTEXT_DEPENDENT_UNIT")
        if dependent is not None:
            return self._dependent(entity, str(dependent.parameters[-1] if dependent.parameters else ""))
        derived = instance.part("DERIVED_UNIT")
        if derived is not None:
            product = Unit()
            for element_id in self.entities.get(entity.id, "DERIVED_UNIT").refs("elements"):
                element = self.entities.get(element_id, "DERIVED_UNIT_ELEMENT", owner=entity.id)
                base = self.unit(element.entity("unit").id, depth)
                exponent = element.number("exponent")
                if abs(exponent) > 10:
                    raise element.fault(
                        "stepnc-unit", f"the exponent of a unit is {exponent:g}; it must be within ±10"
                    )
                product = product.times(base.to_power(exponent))
            return product
        if instance.part("RATIO_UNIT") is not None:
            return Unit()
        raise entity.fault("stepnc-unit", "this unit is not known")

    def _si(self, entity: Entity, part: Record) -> Unit:
        names = [str(v) for v in part.parameters if isinstance(v, Enumeration)]
        prefix = _PREFIXES.get(names[0], 1.0) if len(names) > 1 else 1.0
        name = names[-1] if names else ""
        known = {
            "METRE": Unit(1000.0 * prefix, length=1),
            "SECOND": Unit(prefix, time=1),
            "RADIAN": Unit(prefix, angle=1),
            "HERTZ": Unit(prefix, time=-1, revolution=1),
        }
        other = {
            "GRAM",
            "KELVIN",
            "PASCAL",
            "NEWTON",
            "JOULE",
            "WATT",
            "AMPERE",
            "DEGREE_CELSIUS",
            "STERADIAN",
        }
        if name in known:
            return known[name]
        if name in other:
            return Unit(prefix)
        raise entity.fault("stepnc-unit", f"SI unit {name or '$'} is not known")

    def _conversion(self, entity: Entity, part: Record, depth: int) -> Unit:
        factor_id = next((v for v in reversed(part.parameters) if isinstance(v, Ref)), None)
        if factor_id is None:
            raise entity.fault("stepnc-unit", "the conversion factor must be given")
        factor = self.entities.get(int(factor_id), owner=entity.id)
        value, unit_id = _value_and_unit(factor.instance)
        if not value or unit_id is None or not 1.0 / _MOST < abs(value) < _MOST:
            raise factor.fault(
                "stepnc-unit", f"a conversion needs a unit and a number within {_MOST:g}, and 1 over that"
            )
        base = self.unit(unit_id, depth)
        return base._replace(factor=base.factor * value)

    def _dependent(self, entity: Entity, name: str) -> Unit:
        key = name.strip().lower()
        if key in ("revolution", "rev", "revolutions", "turn"):
            return Unit(revolution=1)
        if key in ("tooth", "teeth"):
            return Unit(tooth=1)
        if key in ("count", "counts", "each", "piece", "pieces", "number", "dimensionless", "none", ""):
            entity.warn("stepnc-unit", f"unit {name!r} is taken as a number without a unit")
            return Unit()
        known = "revolution, tooth, count"
        raise entity.fault("stepnc-unit", f"unit {name!r} is not known; those by their names are {known}")

    def measure(self, entity: Entity) -> Measure | None:
        """Return a measure; None where its value is ``$``, which means that it is not set.

        Raises:
            Skip: where the entity does not hold one.
        """
        value, unit_id = _value_and_unit(entity.instance)
        if value is None:
            return None
        unit = Unit() if unit_id is None else self.unit(unit_id)
        entity.within("the measure", value * unit.factor)
        item = entity.instance.part("REPRESENTATION_ITEM") or entity.instance.parts[0]
        name = item.parameters[0] if item.parameters and isinstance(item.parameters[0], str) else ""
        return Measure(value * unit.factor, unit, str(name).strip().lower())

    def context(self, ident: int | None) -> tuple[float, float]:
        """Return the factors of lengths to mm and of plane angles to rad in a representation's context.

        Raises:
            Skip: where its units have a fault.
        """
        if ident not in self._contexts:
            length, angle = None, math.pi / 180
            instance = self.entities.exchange.instance(ident) if ident is not None else None
            part = instance.part("GLOBAL_UNIT_ASSIGNED_CONTEXT") if instance else None
            members = part.parameters[-1] if part and part.parameters else ()
            for member in members if isinstance(members, tuple) else ():
                unit = self.unit(int(member)) if isinstance(member, Ref) else Unit()
                if (unit.length, unit.time, unit.angle) == (1, 0, 0):
                    length = unit.factor
                elif (unit.length, unit.time, unit.angle) == (0, 0, 1):
                    angle = unit.factor
            if length is None and instance is not None:
                self.entities.get(instance.id).warn(
                    "stepnc-unit", "the context of a geometry has no unit of length; mm are taken"
                )
            self._contexts[ident] = (length or 1.0, angle)
        return self._contexts[ident]


def _value_and_unit(instance: Instance) -> tuple[float | None, int | None]:
    """Return number and unit of any …MEASURE_WITH_UNIT, simple or complex; None for what is not there."""
    part = instance.part("MEASURE_WITH_UNIT") or instance.parts[0]
    value: Value = None
    unit: int | None = None
    for given in part.parameters:
        if isinstance(given, Ref):
            unit = int(given)
            continue
        plain = given.value if isinstance(given, Typed) else given
        if isinstance(plain, int | float):
            value = float(plain)
    return value, unit
