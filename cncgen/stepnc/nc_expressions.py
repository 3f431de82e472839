"""Conditions and numbers as functions of variables, for IF, WHILE and assignments in files of both schemas."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce

Variables = dict[str, float]
Number = Callable[[Variables], float]
Condition = Callable[[Variables], bool]

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "COMPARISON_EQUAL": lambda a, b: a == b,
    "COMPARISON_NOT_EQUAL": lambda a, b: a != b,
    "COMPARISON_LESS": lambda a, b: a < b,
    "COMPARISON_LESS_EQUAL": lambda a, b: a <= b,
    "COMPARISON_GREATER": lambda a, b: a > b,
    "COMPARISON_GREATER_EQUAL": lambda a, b: a >= b,
}
#: Of two numbers or more, from the first on. Angles are in radians.
_COMBINE: dict[str, Callable[[float, float], float]] = {
    "PLUS_EXPRESSION": lambda a, b: a + b,
    "MINUS_EXPRESSION": lambda a, b: a - b,
    "MULT_EXPRESSION": lambda a, b: a * b,
    "SLASH_EXPRESSION": lambda a, b: a / b,
    "POWER_EXPRESSION": math.pow,
    "MAXIMUM_FUNCTION": max,
    "MINIMUM_FUNCTION": min,
    # The angle whose tangent is a/b, where b may be 0.
    "ATAN_FUNCTION": lambda a, b: math.atan(a / b) if b or not a else math.copysign(math.pi / 2.0, a),
}
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "MINUS_FUNCTION": lambda a: -a,
    "ABS_FUNCTION": abs,
    "SQUARE_ROOT_FUNCTION": math.sqrt,
    "SIN_FUNCTION": math.sin,
    "COS_FUNCTION": math.cos,
    "TAN_FUNCTION": math.tan,
    "ASIN_FUNCTION": math.asin,
    "ACOS_FUNCTION": math.acos,
    "EXP_FUNCTION": math.exp,
    "LOG_FUNCTION": math.log,
    "LOG2_FUNCTION": math.log2,
    "LOG10_FUNCTION": math.log10,
}
#: How many operands arithmetic of two numbers has, where not one or more.
_PAIRS = frozenset(["SLASH_EXPRESSION", "POWER_EXPRESSION", "ATAN_FUNCTION"])
COMPARISONS = frozenset(_COMPARE)
#: How many operands an expression of numbers has; 0 for one or more.
ARITHMETIC = {kind: 2 if kind in _PAIRS else 0 for kind in _COMBINE} | dict.fromkeys(_FUNCTIONS, 1)
#: How many operands an expression of truth values has; 0 for one or more.
CONNECTIVES = {"NOT_EXPRESSION": 1, "XOR_EXPRESSION": 2, "AND_EXPRESSION": 0, "OR_EXPRESSION": 0}
#: Levels and terms of one condition.
MAX_DEPTH, MAX_TERMS = 50, 10_000


def compared(kind: str, first: Number, second: Number) -> Condition:
    """Return a comparison of two numbers; `kind` is one of `COMPARISONS`."""
    compare = _COMPARE[kind]
    return lambda variables: compare(first(variables), second(variables))


def connected(kind: str, operands: Sequence[Condition]) -> Condition:
    """Return an expression of truth values; `kind` is one of `CONNECTIVES`."""
    if kind == "NOT_EXPRESSION":
        return lambda variables: not operands[0](variables)
    if kind == "XOR_EXPRESSION":
        return lambda variables: operands[0](variables) != operands[1](variables)
    every = all if kind == "AND_EXPRESSION" else any
    return lambda variables: every(operand(variables) for operand in operands)


def combined(kind: str, numbers: Sequence[Number], undefined: Callable[[str], Exception]) -> Number:
    """Return an expression of numbers; `kind` is one of `ARITHMETIC` (of ISO 13584-20).

    Its evaluation raises what `undefined` makes of a message where the numbers have no such result.
    """

    def value(variables: Variables) -> float:
        given = [number(variables) for number in numbers]
        try:
            found = float(_FUNCTIONS[kind](given[0]) if kind in _FUNCTIONS else reduce(_COMBINE[kind], given))
        except (ArithmeticError, ValueError):
            found = math.nan
        if not math.isfinite(found):
            raise undefined(f"{kind} of {', '.join(f'{each:g}' for each in given)} has no value")
        return found

    return value


def variable(name: str, missing: Callable[[str], Exception]) -> Number:
    """Return the value of a variable, which raises what `missing` makes of a message where it has none."""

    def read(variables: Variables) -> float:
        if name not in variables:
            text = f"variable {name!r} is read, and it has no initial_value and no assignment before"
            raise missing(text)
        return variables[name]

    return read


def constant(number: float) -> Number:
    """Return a number that does not change."""
    return lambda variables: number
