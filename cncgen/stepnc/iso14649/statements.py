"""Conditions, variables and values of IF, WHILE and assignments."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.stepnc.entities import Entities, Entity, Skip
from cncgen.stepnc.part21 import Enumeration, Ref, Typed, Value

Variables = dict[str, float]

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "COMPARISON_EQUAL": lambda a, b: a == b,
    "COMPARISON_NOT_EQUAL": lambda a, b: a != b,
    "COMPARISON_LESS": lambda a, b: a < b,
    "COMPARISON_LESS_EQUAL": lambda a, b: a <= b,
    "COMPARISON_GREATER": lambda a, b: a > b,
    "COMPARISON_GREATER_EQUAL": lambda a, b: a >= b,
}
_MAX_DEPTH = 50
#: Terms of one condition.
_MAX_TERMS = 10_000


class ControlStatements:
    """Reads expressions into functions of the variables."""

    def __init__(self, entities: Entities) -> None:
        self.entities = entities
        self._terms = 0

    def variables(self) -> Variables:
        """Return every NC_VARIABLE and NC_CONSTANT that has an initial value with it."""
        out: Variables = {}
        for instance in self.entities.exchange.instances("NC_VARIABLE", "NC_CONSTANT"):
            entity = self.entities.get(instance.id)
            try:
                value = entity.optional("initial_value")
            except Skip:
                continue
            if value is not None:
                out[self.name(entity)] = value
        return out

    def name(self, entity: Entity) -> str:
        """Return the name of a variable."""
        return entity.text("its_name") or f"#{entity.id}"

    def value(self, owner: Entity, value: Value) -> Callable[[Variables], float]:
        """Return the value of an rvalue: a number, a variable or a constant.

        Raises:
            Skip: for any other value.
        """
        while isinstance(value, Typed):
            value = value.value
        if isinstance(value, Ref):
            name = self.name(self.entities.get(int(value), "NC_VARIABLE", "NC_CONSTANT", owner=owner.id))

            def read(variables: Variables) -> float:
                if name not in variables:
                    text = f"variable {name!r} is read, and it has no initial_value and no assignment before"
                    raise owner.fault("stepnc-missing", text, hint="its initial_value")
                return variables[name]

            return read
        if isinstance(value, int | float):
            number = float(value)
            return lambda variables: number
        raise owner.fault("stepnc-missing", "a number or a variable is needed", value)

    def condition(self, owner: Entity, value: Value, depth: int = 0) -> Callable[[Variables], bool]:
        """Return a boolean expression as a function.

        Raises:
            Skip: where it cannot be evaluated.
        """
        while isinstance(value, Typed):
            value = value.value
        if isinstance(value, Enumeration) and value in ("T", "F"):
            truth = value == "T"
            return lambda variables: truth
        self._terms = self._terms + 1 if depth else 0
        if not isinstance(value, Ref) or depth > _MAX_DEPTH or self._terms > _MAX_TERMS:
            raise owner.fault("stepnc-missing", "a condition is needed", value)
        entity = self.entities.get(int(value), owner=owner.id)
        kind = entity.keyword
        if kind in _COMPARE:
            compare, first = _COMPARE[kind], self.value(entity, entity.get("operand1"))
            second = self.value(entity, entity.get("operand2"))
            return lambda variables: compare(first(variables), second(variables))
        if kind == "NOT_EXPRESSION":
            inner = self.condition(entity, entity.get("operand"), depth + 1)
            return lambda variables: not inner(variables)
        if kind == "XOR_EXPRESSION":
            one, other = (self.condition(entity, entity.get(n), depth + 1) for n in ("operand1", "operand2"))
            return lambda variables: one(variables) != other(variables)
        if kind in ("AND_EXPRESSION", "OR_EXPRESSION"):
            operands = entity.refs("operands")
            if not operands:
                raise entity.fault("stepnc-missing", "operands must be given")
            parts = [self.condition(entity, Ref(i), depth + 1) for i in operands]
            every = all if kind == "AND_EXPRESSION" else any
            return lambda variables: every(p(variables) for p in parts)
        raise entity.fault("stepnc-unsupported", "the condition cannot be evaluated")
