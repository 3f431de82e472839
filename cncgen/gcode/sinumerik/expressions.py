"""Values of expressions of SINUMERIK, which are the common ones (`cncgen.gcode.text.expressions`) with texts and variables of its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol, cast

from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import expressions as common
from cncgen.gcode.text.evaluation import too_deep
from cncgen.records import dataclass

Scalar = float | str


class Variables(Protocol):
    """Where names have their values."""

    def value(self, name: str, indices: list[Scalar]) -> Scalar:
        """Return the value of a variable."""

    def parameter(self, index: float) -> float:
        """Return the value of an R parameter."""


Value = float | Callable[[Variables], Scalar]


def evaluate(value: Value, variables: Variables) -> Scalar:
    """Return the present value of an expression.

    Raises:
        BlockError: A name or function is not known, the result has no value, or functions and signs are nested too deep.
    """
    if isinstance(value, float):
        return value
    try:
        return value(variables)
    except RecursionError:
        raise too_deep() from None


def number(value: Scalar, what: str = "the value") -> float:
    """Return a number; raise where it is a text, or too large for a double."""
    if isinstance(value, str):
        raise BlockError(
            "value-kind",
            f'{what} is the text "{value}", and a number is needed',
            hint="a text goes into variables of DEF STRING, and MSG",
        )
    if not math.isfinite(value):
        raise BlockError("number-range", f"{what}, {value:g}, is beyond the range of numbers")
    return value


# Expressions that have their value when the program runs.


@dataclass(frozen=True, slots=True)
class Quoted:
    """A text in quotes."""

    text: str

    def __call__(self, variables: Variables) -> Scalar:
        """Return the text."""
        return self.text


@dataclass(frozen=True, slots=True)
class RParameter:
    """An R parameter."""

    index: Value

    def __call__(self, variables: Variables) -> Scalar:
        """Return its value."""
        index = self.index
        if not isinstance(index, float):
            index = number(index(variables), "the number of R")
        return variables.parameter(index)


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of DEF or of the system, or an element of one."""

    name: str
    indices: tuple[Value, ...]

    def __call__(self, variables: Variables) -> Scalar:
        """Return its value."""
        return variables.value(self.name, [evaluate(index, variables) for index in self.indices])


@dataclass(frozen=True, slots=True)
class Function:
    """A function that has no number: AC(10), CROT(Z,45), and what is not known."""

    name: str
    arguments: tuple[Value | None, ...]

    def __call__(self, variables: Variables) -> Scalar:
        """Raise the fault of a function that stands where a number is needed."""
        name, count = self.name, sum(argument is not None for argument in self.arguments)
        wanted = 1 if name in _FUNCTIONS else 2 if name in _TWO else 3 if name == "BOUND" else 0
        if wanted:
            raise BlockError(
                "function-arguments", f"{name} has {count} arguments, and takes {wanted}", name, hint=f"{name} takes {wanted}"
            )  # fmt: skip
        raise BlockError(
            "function-unknown",
            f"the function {name} is not read",
            name,
            hint=f"read are {', '.join([*_FUNCTIONS, *_TWO])}",
        )


@dataclass(frozen=True, slots=True)
class Chain:
    """Two frames one after the other."""

    first: Value
    second: Value

    def __call__(self, variables: Variables) -> Scalar:
        """Raise: a frame is no number."""
        message = ": chains frames, and a number is needed"
        raise BlockError("value-kind", message, hint="$P_PFRAME=CTRANS(X,10):CROT(Z,45)")


_CONSTANTS = {"TRUE": 1.0, "FALSE": 0.0, "$PI": math.pi, "PI": math.pi}


def variable(name: str, indices: tuple[Value, ...]) -> Value:
    """Return what a name stands for."""
    if name[0] == "R" and name[1:].isdigit() and not indices:
        return RParameter(float(name[1:]))
    if name == "R" and len(indices) == 1:
        return RParameter(indices[0])
    if name in _CONSTANTS and not indices:
        return _CONSTANTS[name]
    return Variable(name, indices)


def function(name: str, arguments: tuple[Value | None, ...]) -> Value:
    """Return the value of a function."""
    given = [argument for argument in arguments if argument is not None]
    if name in _FUNCTIONS and len(given) == 1:
        return unary(name, given[0])
    if name in _TWO and len(given) == 2:
        return binary(name, *given)
    if name == "BOUND" and len(given) == 3:
        low, high, value = given
        return binary("MAXVAL", low, binary("MINVAL", high, value))
    return Function(name, arguments)


def binary(operator: str, a: Value, b: Value) -> Value:
    """Return ``a operator b``."""
    return cast(Value, common.binary(operator, cast(Any, a), cast(Any, b), _ARITHMETIC))


def unary(name: str, a: Value) -> Value:
    """Return a function or sign of a value."""
    return cast(Value, common.unary(name, cast(Any, a), _ARITHMETIC))


# Operators and functions.

_FUNCTIONS = {
    name: common.function_of(name, number, "()") for name, number in common.FUNCTIONS_OF_SINUMERIK.items()
}
_SIGNS: dict[str, Callable[[float], float]] = {
    "-": lambda x: -x,
    "+": lambda x: x,
    "NOT": lambda x: float(x == 0.0),
}
_TWO = {name: common.operator_of(number) for name, number in common.PAIRS_OF_SINUMERIK.items()}
_OPERATORS = {name: common.operator_of(number) for name, number in common.OF_SINUMERIK.items()}


def _of_numbers(operator: str, function: common.Operator) -> Callable[[Scalar, Scalar], Scalar]:
    """Return an operator that takes no texts."""

    def run(a: Scalar, b: Scalar) -> Scalar:
        if isinstance(a, str) or isinstance(b, str):
            if operator in ("==", "<>") and isinstance(a, str) and isinstance(b, str):
                return float((a.upper() == b.upper()) == (operator == "=="))
            raise BlockError(
                "value-kind",
                f"{operator} needs two numbers, and one of its values is a text",
                hint="<< joins texts",
            )
        return function(a, b)

    return run


def _of_number(what: str, function: Callable[[float], float]) -> Callable[[Scalar], Scalar]:
    """Return a function that takes a number."""
    return lambda x: function(number(x, what))


def _joined(a: Scalar, b: Scalar) -> str:
    return "".join(value if isinstance(value, str) else f"{value:g}" for value in (a, b))


_ARITHMETIC = common.Arithmetic(
    cast(Any, {"<<": _joined, **{name: _of_numbers(name, f) for name, f in (_OPERATORS | _TWO).items()}}),
    cast(Any, {
        **{name: _of_number(f"the argument of {name}", f) for name, f in _FUNCTIONS.items()},
        **{name: _of_number("the value", f) for name, f in _SIGNS.items()},
    }),
)  # fmt: skip
