"""Conditions, variables and values of IF, WHILE and assignments."""

from __future__ import annotations

from cncgen.stepnc import nc_expressions
from cncgen.stepnc.entities import Entities, Entity, Skip
from cncgen.stepnc.nc_expressions import Condition, Number, Variables
from cncgen.stepnc.part21 import Enumeration, Ref, Typed, Value


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

    def value(self, owner: Entity, value: Value) -> Number:
        """Return the value of an rvalue: a number, a variable or a constant.

        Raises:
            Skip: for any other value.
        """
        while isinstance(value, Typed):
            value = value.value
        if isinstance(value, Ref):
            name = self.name(self.entities.get(int(value), "NC_VARIABLE", "NC_CONSTANT", owner=owner.id))
            return nc_expressions.variable(
                name, lambda text: owner.fault("stepnc-missing", text, hint="its initial_value")
            )
        if isinstance(value, int | float):
            return nc_expressions.constant(float(value))
        raise owner.fault("stepnc-missing", "a number or a variable is needed", value)

    def condition(self, owner: Entity, value: Value, depth: int = 0) -> Condition:
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
        too_many = depth > nc_expressions.MAX_DEPTH or self._terms > nc_expressions.MAX_TERMS
        if not isinstance(value, Ref) or too_many:
            raise owner.fault("stepnc-missing", "a condition is needed", value)
        entity = self.entities.get(int(value), owner=owner.id)
        kind = entity.keyword
        if kind in nc_expressions.COMPARISONS:
            first, second = (self.value(entity, entity.get(n)) for n in ("operand1", "operand2"))
            return nc_expressions.compared(kind, first, second)
        if kind not in nc_expressions.CONNECTIVES:
            raise entity.fault("stepnc-unsupported", "the condition cannot be evaluated")
        names = {"NOT_EXPRESSION": ("operand",), "XOR_EXPRESSION": ("operand1", "operand2")}
        operands = [entity.get(n) for n in names.get(kind, ())] or [Ref(i) for i in entity.refs("operands")]
        if not operands:
            raise entity.fault("stepnc-missing", "operands must be given")
        return nc_expressions.connected(kind, [self.condition(entity, o, depth + 1) for o in operands])
