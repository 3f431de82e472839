"""Conditions and numbers as functions of variables, for IF, WHILE and assignments in files of both schemas."""

from __future__ import annotations

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
_COMBINE: dict[str, Callable[[float, float], float]] = {
    "PLUS_EXPRESSION": lambda a, b: a + b,
    "MINUS_EXPRESSION": lambda a, b: a - b,
    "MULT_EXPRESSION": lambda a, b: a * b,
}
COMPARISONS = frozenset(_COMPARE)
ARITHMETIC = frozenset(_COMBINE)
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


def combined(kind: str, numbers: Sequence[Number]) -> Number:
    """Return the sum, difference or product of numbers, from the first on; `kind` is one of `ARITHMETIC`."""
    operate = _COMBINE[kind]
    return lambda variables: reduce(operate, (number(variables) for number in numbers))


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
