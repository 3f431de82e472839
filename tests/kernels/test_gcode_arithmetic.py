"""The arithmetic of expressions, compiled and plain, against the functions that the interpreter explains errors with."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.block import evaluate
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik import expressions as sinumerik
from cncgen.gcode.text import expressions
from cncgen.kernels import gcode_arithmetic, gcode_codes, gcode_formulas
from cncgen.kernels.gcode_codes import LITERALS

from .plain import uncompiled

BINARY, EQUAL, FUNCTION, NEGATIVE = (
    gcode_codes.CONSTANTS[name] for name in ("BINARY", "EQUAL", "FUNCTION", "NEGATIVE")
)
KERNELS = [gcode_arithmetic, uncompiled("gcode_arithmetic")]
NUMBERS = st.one_of(
    st.floats(-1e12, 1e12), st.sampled_from([0.0, -0.0, 1.0, -1.0, 2.0, 0.5, 30.0, 90.0, 1e-4])
)


def value_of(function: Any, *arguments: float) -> float:
    """Return the value of a definition, NaN where it has none."""
    try:
        value = float(function(*arguments))
    except (ValueError, OverflowError, ZeroDivisionError):
        return math.nan
    return value if math.isfinite(value) else math.nan


def modulo(a: float, b: float) -> float:
    """Return the remainder that is never negative."""
    rest = math.fmod(a, b)
    return rest + abs(b) if rest < 0.0 else rest


def power(a: float, b: float) -> float:
    """Return a power that is real."""
    if a < 0.0 and not b.is_integer():
        raise ValueError
    return a**b


def of_angle(function: Any) -> Any:
    """Return a function of degrees below 1e12, the kernel's own within it (`test_computing` has its values)."""

    def run(a: float) -> float:
        if not abs(a) < 1e12:
            raise ValueError
        return float(function(a))

    return run


def of_ratio(function: Any) -> Any:
    """Return an inverse function, of -1 to 1."""

    def run(a: float) -> float:
        if not -1.0 <= a <= 1.0:
            raise ValueError
        return float(function(a))

    return run


def nearly(a: float, b: float) -> bool:
    """Tell whether SINUMERIK takes reals as the same."""
    return abs(a - b) <= 2.0**-48 * max(abs(a), abs(b))


#: What the manuals of the languages say of operators and functions; comparisons within 1e-4 are LinuxCNC's.
OPERATORS: dict[str, Any] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "**": power,
    "mod": modulo,
    "and": lambda a, b: bool(a and b),
    "or": lambda a, b: bool(a or b),
    "xor": lambda a, b: bool(a) != bool(b),
    "eq": lambda a, b: abs(a - b) < 1e-4,
    "ne": lambda a, b: not abs(a - b) < 1e-4,
    "gt": lambda a, b: a > b,
    "ge": lambda a, b: a >= b,
    "lt": lambda a, b: a < b,
    "le": lambda a, b: a <= b,
}
FUNCTIONS: dict[str, Any] = {
    "abs": abs,
    "acos": of_ratio(gcode_arithmetic.arc_cosine),
    "asin": of_ratio(gcode_arithmetic.arc_sine),
    "cos": of_angle(gcode_arithmetic.cosine),
    "exp": math.exp,
    "fix": lambda a: math.copysign(math.floor(a), a),
    "fup": lambda a: math.copysign(math.ceil(a), a),
    "ln": math.log,
    "round": lambda a: math.copysign(math.floor(abs(a) + 0.5), a),
    "sin": of_angle(gcode_arithmetic.sine),
    "sqrt": math.sqrt,
    "tan": of_angle(gcode_arithmetic.tangent),
}
OF_LANGUAGES: dict[str, tuple[Any, Any]] = {
    "DIV": (sinumerik._OPERATORS, lambda a, b: math.trunc(a / b)),
    "MOD": (sinumerik._OPERATORS, math.fmod),
    "==": (sinumerik._OPERATORS, nearly),
    "<>": (sinumerik._OPERATORS, lambda a, b: not nearly(a, b)),
    ">": (sinumerik._OPERATORS, lambda a, b: a > b and not nearly(a, b)),
    "<": (sinumerik._OPERATORS, lambda a, b: a < b and not nearly(a, b)),
    ">=": (sinumerik._OPERATORS, lambda a, b: a >= b or nearly(a, b)),
    "<=": (sinumerik._OPERATORS, lambda a, b: a <= b or nearly(a, b)),
    "B_AND": (sinumerik._OPERATORS, lambda a, b: int(a) & int(b)),
    "B_OR": (sinumerik._OPERATORS, lambda a, b: int(a) | int(b)),
    "B_XOR": (sinumerik._OPERATORS, lambda a, b: int(a) ^ int(b)),
    "MINVAL": (sinumerik._OPERATORS, min),
    "MAXVAL": (sinumerik._OPERATORS, max),
    "ATAN2": (sinumerik._OPERATORS, lambda a, b: math.degrees(math.atan2(a, b))),
    "%": (expressions.OF_HEIDENHAIN, math.fmod),
    "^": (expressions.OF_HEIDENHAIN, power),
    "ANG": (expressions.OF_HEIDENHAIN, lambda a, b: math.degrees(math.atan2(a, b)) % 360.0),
    "EQU": (expressions.OF_HEIDENHAIN, lambda a, b: abs(a - b) < 1e-9),
    "NE": (expressions.OF_HEIDENHAIN, lambda a, b: abs(a - b) >= 1e-9),
}
FUNCTIONS_OF_LANGUAGES: dict[str, tuple[Any, Any]] = {
    "POT": (expressions.FUNCTIONS_OF_SINUMERIK, lambda a: a * a),
    "TRUNC": (expressions.FUNCTIONS_OF_SINUMERIK, math.trunc),
    "ROUNDUP": (expressions.FUNCTIONS_OF_SINUMERIK, math.ceil),
    "B_NOT": (expressions.FUNCTIONS_OF_SINUMERIK, lambda a: ~int(a)),
    "ATAN": (expressions.FUNCTIONS_OF_HEIDENHAIN, lambda a: math.degrees(math.atan(a))),
    "INT": (expressions.FUNCTIONS_OF_HEIDENHAIN, math.trunc),
    "FRAC": (expressions.FUNCTIONS_OF_HEIDENHAIN, lambda a: math.fmod(a, 1.0)),
    "NEG": (expressions.FUNCTIONS_OF_HEIDENHAIN, lambda a: -a),
    "LOG": (expressions.FUNCTIONS_OF_HEIDENHAIN, math.log10),
    "SGN": (expressions.FUNCTIONS_OF_HEIDENHAIN, lambda a: math.copysign(1.0, a) if a else 0.0),
}


def told(name: int, language: expressions.Arithmetic, *operands: float) -> float:
    """Return the value of an operator or function of a language, known or computed when the program runs; NaN where it is a fault."""
    make = expressions.binary if len(operands) == 2 else expressions.unary
    known, asked = make(name, *operands, language), make(name, lambda p: operands[0], *operands[1:], language)
    found = []
    for value in (known, asked):
        try:
            found.append(float(evaluate(value, None)))  # type: ignore[arg-type]
        except BlockError:
            found.append(math.nan)
    assert same(*found)
    return found[0]


def language_of(numbers: dict[str, int]) -> expressions.Arithmetic:
    """Return the language of a table of operators or functions."""
    heidenhain = numbers in (expressions.OF_HEIDENHAIN, expressions.FUNCTIONS_OF_HEIDENHAIN)
    return expressions.HEIDENHAIN if heidenhain else sinumerik._ARITHMETIC


def same(a: float, b: float) -> bool:
    """Tell whether two numbers are the same to the bit, or both none."""
    return (a != a and b != b) or (a == b and math.copysign(1.0, a) == math.copysign(1.0, b))


@given(st.sampled_from(sorted(OPERATORS)), NUMBERS, NUMBERS)
def test_operators_are_those_of_the_manual(name: str, a: float, b: float) -> None:
    wanted = value_of(OPERATORS[name], a, b)
    for kernel in KERNELS:
        assert same(kernel.joined(LITERALS[name], a, b), wanted)
    assert same(told(LITERALS[name], expressions.LINUXCNC, a, b), wanted)


@given(st.sampled_from(sorted(FUNCTIONS)), NUMBERS)
def test_functions_are_those_of_the_manual(name: str, a: float) -> None:
    wanted = value_of(FUNCTIONS[name], a)
    for kernel in KERNELS:
        assert same(kernel.function_of(LITERALS[name], a), wanted)
    assert same(told(LITERALS[name], expressions.LINUXCNC, a), wanted)


@given(st.sampled_from(sorted(OF_LANGUAGES)), NUMBERS, NUMBERS)
def test_operators_of_the_languages(name: str, a: float, b: float) -> None:
    numbers, definition = OF_LANGUAGES[name]
    assert same(told(numbers[name], language_of(numbers), a, b), value_of(definition, a, b))


@given(st.sampled_from(sorted(FUNCTIONS_OF_LANGUAGES)), NUMBERS)
def test_functions_of_the_languages(name: str, a: float) -> None:
    numbers, definition = FUNCTIONS_OF_LANGUAGES[name]
    assert same(told(numbers[name], language_of(numbers), a), value_of(definition, a))


@pytest.mark.parametrize("kernel", KERNELS, ids=["compiled", "plain"])
def test_what_is_no_function_has_no_value(kernel: Any) -> None:
    assert all(math.isnan(kernel.function_of(LITERALS[name], 1.0)) for name in ("bin", "sqr", "if", "+"))
    assert kernel.arc_tangent(1.0, -1.0) == 135.0


@pytest.mark.parametrize("kernel", [gcode_formulas, uncompiled("gcode_formulas")], ids=["compiled", "plain"])
def test_formulas(kernel: Any) -> None:
    """Operands of names and of elements, texts and vacant values; no nesting takes depth."""
    asked: list[Any] = []

    def without(*step: Any) -> float:
        asked.append(step)
        return 7.0

    element = SimpleNamespace(operands=(1.0, lambda store: 2.0), of=lambda store, a, b: store[int(a + b)])
    formula = kernel.Formula(element, without)
    formula.add(kernel.Formula(0.5, without))
    formula.apply(BINARY, LITERALS["*"])
    formula.apply(NEGATIVE, 0)
    assert formula([0.0, 0.0, 0.0, 8.0]) == -4.0
    deep = kernel.Formula(0.0, without)
    for _ in range(5_000):
        deep = kernel.Formula(SimpleNamespace(operands=(deep,), of=lambda store, a: a + 1.0), without)
    assert deep(None) == 5_000.0
    text = kernel.Formula(lambda store: "A", without)
    text.apply(FUNCTION, LITERALS["sin"])
    root = kernel.Formula(-1.0, without)
    root.apply(FUNCTION, LITERALS["sqrt"])
    assert (text(None), root(None)) == (7.0, 7.0)
    assert asked == [(FUNCTION, LITERALS["sin"], "A", None), (FUNCTION, LITERALS["sqrt"], -1.0, None)]
    vacant = kernel.Formula(math.nan, without, True)
    vacant.add(3.0)
    vacant.apply(BINARY, LITERALS["+"])
    assert vacant(None) == 3.0
    same = kernel.Formula(math.nan, without, True)
    same.add(0.0)
    same.apply(BINARY, EQUAL)
    assert same(None) == 0.0
