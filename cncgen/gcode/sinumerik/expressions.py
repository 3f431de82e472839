"""Values of expressions of SINUMERIK; angles are degrees."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik.reading import Node
from cncgen.gcode.text.evaluation import too_deep

Scalar = float | str


class Variables(Protocol):
    """Where names have their values."""

    def value(self, name: str, indices: list[Scalar]) -> Scalar:
        """Return the value of a variable."""

    def parameter(self, index: float) -> float:
        """Return the value of an R parameter."""


def _domain(name: str, value: float, allowed: str) -> BlockError:
    return BlockError("domain", f"{name}({value:g}) has no value: {allowed}", name)


def _root(x: float) -> float:
    if x < 0.0:
        raise _domain("SQRT", x, "its argument is 0 or more")
    return math.sqrt(x)


def _arc(name: str, function: Callable[[float], float]) -> Callable[[float], float]:
    def run(x: float) -> float:
        if not -1.0 <= x <= 1.0:
            raise _domain(name, x, "its argument is -1 to 1")
        return math.degrees(function(x))

    return run


def _exponential(x: float) -> float:
    if x > 700.0:
        raise _domain("EXP", x, "its argument is 700 at most")
    return math.exp(x)


def _logarithm(x: float) -> float:
    if x <= 0.0:
        raise _domain("LN", x, "its argument is above 0")
    return math.log(x)


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)),
    "ASIN": _arc("ASIN", math.asin),
    "ACOS": _arc("ACOS", math.acos),
    "SQRT": _root,
    "ABS": abs,
    "POT": lambda x: x * x,
    "TRUNC": lambda x: float(math.trunc(x)),
    "ROUND": lambda x: math.copysign(math.floor(abs(x) + 0.5), x),
    "ROUNDUP": lambda x: float(math.ceil(x)),
    "LN": _logarithm,
    "EXP": lambda x: _exponential(x),
    "B_NOT": lambda x: float(~int(x)),
}
_TWO: dict[str, Callable[[float, float], float]] = {
    "ATAN2": lambda y, x: math.degrees(math.atan2(y, x)),
    "MINVAL": min,
    "MAXVAL": max,
}
_CONSTANTS = {"TRUE": 1.0, "FALSE": 0.0, "$PI": math.pi, "PI": math.pi}
#: Comparisons of reals hold within this part of the larger one (840D: the last four bits of a double).
_EQUAL = 2.0**-48


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


def evaluate(node: Node, variables: Variables) -> Scalar:
    """Return the value of an expression.

    Raises:
        BlockError: A name or function is not known, the result has no value, or functions and signs are nested too deep.
    """
    chain = []
    while node[0] == "bin":  # rows of operators lead to the left, as many as a line is long
        if node[1] == ":":
            message = ": chains frames, and a number is needed"
            raise BlockError("value-kind", message, hint="$P_PFRAME=CTRANS(X,10):CROT(Z,45)")
        chain.append(node)
        node = node[2]
    try:
        value = _operand(node, variables)
        for _, operator, _, right in reversed(chain):
            value = _binary(operator, value, evaluate(right, variables))
    except RecursionError:
        raise too_deep() from None
    return value


def _operand(node: Node, variables: Variables) -> Scalar:
    match node[0]:
        case "n":
            return number(node[1], "a number")
        case "s":
            text: str = node[1]
            return text
        case "r":
            return variables.parameter(number(evaluate(node[1], variables), "the number of R"))
        case "var":
            if node[1] in _CONSTANTS and not node[2]:
                return _CONSTANTS[node[1]]
            return variables.value(node[1], [evaluate(index, variables) for index in node[2]])
        case "fn":
            return _function(node[1], node[2], variables)
        case "un":
            operand = number(evaluate(node[2], variables))
            return {"-": -operand, "+": operand, "NOT": float(operand == 0.0)}[node[1]]
    raise AssertionError(node[0])


def _function(name: str, arguments: tuple[Node | None, ...], variables: Variables) -> Scalar:
    values = [evaluate(argument, variables) for argument in arguments if argument is not None]
    if name in _FUNCTIONS and len(values) == 1:
        return _FUNCTIONS[name](number(values[0], f"the argument of {name}"))
    if name in _TWO and len(values) == 2:
        return _TWO[name](number(values[0]), number(values[1]))
    if name == "BOUND" and len(values) == 3:
        low, high, value = (number(v) for v in values)
        return max(low, min(high, value))
    if name in _FUNCTIONS or name in _TWO or name == "BOUND":
        wanted = 1 if name in _FUNCTIONS else 2 if name in _TWO else 3
        raise BlockError(
            "function-arguments", f"{name} has {len(values)} arguments, and takes {wanted}", name, hint=f"{name} takes {wanted}"
        )  # fmt: skip
    raise BlockError(
        "function-unknown",
        f"the function {name} is not read",
        name,
        hint=f"read are {', '.join([*_FUNCTIONS, *_TWO])}",
    )


def _equal(a: float, b: float) -> bool:
    return abs(a - b) <= _EQUAL * max(abs(a), abs(b))


def _binary(operator: str, a: Scalar, b: Scalar) -> Scalar:
    if operator == "<<":
        return _text(a) + _text(b)
    if isinstance(a, str) or isinstance(b, str):
        if operator in ("==", "<>") and isinstance(a, str) and isinstance(b, str):
            return float((a.upper() == b.upper()) == (operator == "=="))
        raise BlockError(
            "value-kind",
            f"{operator} needs two numbers, and one of its values is a text",
            hint="<< joins texts",
        )
    if operator in ("/", "DIV", "MOD") and b == 0.0:
        raise BlockError("division-by-zero", f"{a:g} {operator} 0 has no value")
    return _ARITHMETIC[operator](a, b)


def _text(value: Scalar) -> str:
    return value if isinstance(value, str) else f"{value:g}"


_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "DIV": lambda a, b: float(math.trunc(a / b)),
    "MOD": math.fmod,
    "==": lambda a, b: float(_equal(a, b)),
    "<>": lambda a, b: float(not _equal(a, b)),
    ">": lambda a, b: float(a > b and not _equal(a, b)),
    "<": lambda a, b: float(a < b and not _equal(a, b)),
    ">=": lambda a, b: float(a >= b or _equal(a, b)),
    "<=": lambda a, b: float(a <= b or _equal(a, b)),
    "AND": lambda a, b: float(a != 0.0 and b != 0.0),
    "OR": lambda a, b: float(a != 0.0 or b != 0.0),
    "XOR": lambda a, b: float((a != 0.0) != (b != 0.0)),
    "B_AND": lambda a, b: float(int(a) & int(b)),
    "B_OR": lambda a, b: float(int(a) | int(b)),
    "B_XOR": lambda a, b: float(int(a) ^ int(b)),
}
