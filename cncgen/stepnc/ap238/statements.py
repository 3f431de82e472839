"""IF, WHILE and assignments of the AIM (ISO 10303-238, 5.1.6): expressions of ISO 13584-20 as functions of the variables.

In the fourth edition an EXPRESSION_ITEM_REPRESENTATION_ITEM holds an expression; before it, the expression is an
EXPRESSION_REPRESENTATION_ITEM itself, a complex instance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cncgen.stepnc import nc_expressions
from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.entities import Entity, Skip, only
from cncgen.stepnc.nc_expressions import Condition, Number, Variables
from cncgen.stepnc.part21 import Enumeration, Ref

_VARIABLES = frozenset(["NUMERIC_VARIABLE", "INT_NUMERIC_VARIABLE", "REAL_NUMERIC_VARIABLE"])
_LITERALS = frozenset(["LITERAL_NUMBER", "INT_LITERAL", "REAL_LITERAL"])
_HOLDER = "EXPRESSION_ITEM_REPRESENTATION_ITEM"


class ControlStatements:
    """Reads the expressions of executables."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.entities = graph.entities
        self._terms = 0

    def variables(self) -> Variables:
        """Return the variables that have an initial value with it."""
        out: Variables = {}
        for link in self.entities.exchange.instances("REPRESENTATION_ITEM_RELATIONSHIP"):
            try:
                relation = self.entities.get(link.id)
                if relation.text("description").strip().lower() == "initial value":
                    target = relation.entity("relating_representation_item")
                    out[self._name(target)] = self._number(relation.entity("related_representation_item"))(
                        out
                    )
            except Skip:
                continue
        return out

    def property(self, owner: Entity, properties: Mapping[str, Sequence[Item]], name: str) -> Entity:
        """Return the expression of a property of an executable.

        Raises:
            Skip: where there is none, or there are several.
        """
        item = only(f"{name} of an executable", properties.get(name, []))
        if item is None:
            raise owner.fault("stepnc-missing", f"the property {name!r} must be given")
        return item.entity

    def target(self, item: Entity) -> str:
        """Return the name of the variable that an assignment sets.

        Raises:
            Skip: where the item holds none.
        """
        if not self._kinds(self._held(item)) & _VARIABLES:
            raise item.fault("stepnc-missing", "a variable is needed to the left of an assignment")
        return self._name(item)

    def number(self, item: Entity) -> Number:
        """Return an expression of numbers as a function.

        Raises:
            Skip: where it cannot be evaluated.
        """
        self._terms = 0
        return self._number(item)

    def condition(self, item: Entity) -> Condition:
        """Return a boolean expression as a function.

        Raises:
            Skip: where it cannot be evaluated.
        """
        self._terms = 0
        return self._condition(item)

    def _condition(self, item: Entity, depth: int = 0) -> Condition:
        entity = self._held(item)
        kinds = self._kinds(entity, depth)
        for kind in sorted(kinds & nc_expressions.COMPARISONS):
            first, second = (self._number(o, depth + 1) for o in self._operands(entity, 2))
            return nc_expressions.compared(kind, first, second)
        for kind in sorted(kinds & nc_expressions.CONNECTIVES.keys()):
            operands = self._operands(entity, nc_expressions.CONNECTIVES[kind])
            return nc_expressions.connected(kind, [self._condition(o, depth + 1) for o in operands])
        if "BOOLEAN_LITERAL" in kinds:
            for part in entity.instance.parts:
                for value in part.parameters:
                    if isinstance(value, Enumeration) and value in ("T", "F"):
                        truth = value == "T"
                        return lambda variables: truth
        raise entity.fault("stepnc-unsupported", f"a condition cannot be evaluated as {self._called(kinds)}")

    def _number(self, item: Entity, depth: int = 0) -> Number:
        entity = self._held(item)
        kinds = self._kinds(entity, depth)
        if kinds & _VARIABLES:
            return nc_expressions.variable(self._name(item), lambda text: item.fault("stepnc-missing", text))
        if kinds & _LITERALS:
            for part in entity.instance.parts:
                for value in part.parameters:
                    if isinstance(value, int | float) and not isinstance(value, Ref):
                        return nc_expressions.constant(entity.within("the number", value))
        for kind in sorted(kinds & nc_expressions.ARITHMETIC.keys()):
            operands = self._operands(entity, nc_expressions.ARITHMETIC[kind])
            numbers = [self._number(o, depth + 1) for o in operands]
            return nc_expressions.combined(kind, numbers, lambda text: entity.fault("stepnc-range", text))
        raise entity.fault("stepnc-unsupported", f"a number cannot be evaluated as {self._called(kinds)}")

    @staticmethod
    def _called(kinds: set[str]) -> str:
        """Return what says most of the kinds of an expression."""
        return " ".join(
            sorted(kind for kind in kinds if "GENERIC" not in kind and "REPRESENTATION" not in kind)
        )

    def _held(self, item: Entity) -> Entity:
        """Return the expression that an item of a representation holds; an expression itself as it is."""
        return item.entity("item") if item.keyword == _HOLDER else item

    def _kinds(self, entity: Entity, depth: int = 0) -> set[str]:
        self._terms += 1
        if depth > nc_expressions.MAX_DEPTH or self._terms > nc_expressions.MAX_TERMS:
            raise entity.fault("stepnc-unsupported", "the expression is too deep, or too long")
        return {part.keyword for part in entity.instance.parts}

    def _operands(self, entity: Entity, count: int) -> list[Entity]:
        """Return the operands of an expression, so many of them, or (0) one at least."""
        values = [v for part in entity.instance.parts for v in part.parameters]
        flat = [v for value in values for v in (value if isinstance(value, tuple) else (value,))]
        found = [self.entities.get(int(v), owner=entity.id) for v in flat if isinstance(v, Ref)]
        if not found or (count and len(found) != count):
            wanted = str(count) if count else "one or more"
            raise entity.fault("stepnc-missing", f"operands: {len(found)} are given of {wanted}")
        return found

    def _name(self, item: Entity) -> str:
        """Return the name of a variable: that of its entity, since two may be called alike."""
        return f"#{self._held(item).id}"
