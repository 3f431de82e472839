"""Values of expressions of SINUMERIK, which are the common ones (`cncgen.gcode.text.expressions`) with texts and variables of its own."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from typing import Protocol

from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import expressions as common
from cncgen.grammars.terminals import SINUMERIK as TERMINALS
from cncgen.kernels import gcode_codes as codes
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
    """Return the present value of an expression; raise where a name or function is not known, or the result has no value."""
    return value if isinstance(value, float) else value(variables)


def number(value: Scalar, what: str = "the value") -> float:
    """Return a number; raise where it is a text, or too large for a double."""
    if isinstance(value, str):
        message = f'{what} is the text "{value}", and a number is needed'
        raise BlockError("value-kind", message, hint="a text goes into variables of DEF STRING, and MSG")
    if not math.isfinite(value):
        raise BlockError("number-range", f"{what}, {value:g}, is beyond the range of numbers")
    return value


def whole(value: Scalar, what: str = "the value") -> int:
    """Return a number as an INT: a half goes away from zero, as ROUND does (840D, Advanced, 1.9, "Possible type conversions")."""
    given = number(value, what)
    return int(math.copysign(math.floor(abs(given) + 0.5), given))


# Expressions that have their value when the program runs.


@dataclass(frozen=True, slots=True)
class Quoted:
    """A text in quotes."""

    text: str

    def __call__(self, variables: Variables) -> Scalar:
        return self.text


@dataclass(frozen=True, slots=True)
class RParameter:
    """An R parameter."""

    index: Value

    @property
    def operands(self) -> tuple[Value, ...]:
        """The expressions that are computed before it."""
        return () if isinstance(self.index, float) else (self.index,)

    @staticmethod
    def of(variables: Variables, index: Scalar) -> Scalar:
        """Return the value of R[index]."""
        return variables.parameter(number(index, "the number of R"))

    def __call__(self, variables: Variables) -> Scalar:
        return self.of(variables, evaluate(self.index, variables))


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of DEF or of the system, or an element of one."""

    name: str
    indices: tuple[Value, ...]

    @property
    def operands(self) -> tuple[Value, ...]:
        return self.indices

    def of(self, variables: Variables, *indices: Scalar) -> Scalar:
        """Return the value of an element."""
        return variables.value(self.name, list(indices))

    def __call__(self, variables: Variables) -> Scalar:
        return variables.value(self.name, [evaluate(index, variables) for index in self.indices])


@dataclass(frozen=True, slots=True)
class TextFunction:
    """A function of texts (840D sl, Job planning, "String operations")."""

    name: str
    arguments: tuple[Value, ...]

    @property
    def operands(self) -> tuple[Value, ...]:
        return self.arguments

    def of(self, variables: Variables, text: Scalar, *more: Scalar) -> Scalar:
        """Return its value; raise where an argument is a number where a text is needed or the other way round, or NUMBER has a text that is none."""
        numbers = self.name == "SUBSTR"
        if not isinstance(text, str) or any(isinstance(value, str) == numbers for value in more):
            message = f"an argument of {self.name} is {'a text where a number' if isinstance(text, str) and numbers else 'a number where a text'} is needed"
            raise BlockError("value-kind", message, self.name, hint='SUBSTR("PART_12",5,2) is "12"')
        return _TEXTS[self.name](text, *more)

    def __call__(self, variables: Variables) -> Scalar:
        text, *more = (evaluate(argument, variables) for argument in self.arguments)
        return self.of(variables, text, *more)


_NUMBER = re.compile(rf"\s*[-+]?({TERMINALS['PLAIN_NUMBER']})\s*", re.ASCII)


def _number_of(text: str) -> float:
    if not _NUMBER.fullmatch(text):
        message = f'NUMBER("{text}"): the text is no number'
        raise BlockError("value-kind", message, "NUMBER", hint="ISNUMBER tells whether it is one")
    return float(text)


def _part(text: str, first: float, count: float | None = None) -> str:
    begin = round(max(first, 0.0))
    return text[begin:] if count is None else text[begin : begin + round(max(count, 0.0))]


#: Functions whose first argument is a text, and how many arguments each takes; places count from 0, and -1 is none.
_TEXTS: dict[str, Callable[..., Scalar]] = {
    # An axis is its name.
    **dict.fromkeys(("AXNAME", "AXSTRING"), lambda text: text.strip().upper()),
    "TOUPPER": str.upper, "TOLOWER": str.lower, "STRLEN": lambda text: float(len(text)), "NUMBER": _number_of,
    "ISNUMBER": lambda text: float(_NUMBER.fullmatch(text) is not None), "INDEX": lambda text, sign: float(text.find(sign)),
    "RINDEX": lambda text, sign: float(text.rfind(sign)), "SUBSTR": _part,
}  # fmt: skip
_TAKES = {**dict.fromkeys(_TEXTS, (1,)), **dict.fromkeys(("INDEX", "RINDEX"), (2,)), "SUBSTR": (2, 3)}


@dataclass(frozen=True, slots=True)
class Function:
    """A function that has no number: AC(10), CROT(Z,45), and what is not known."""

    name: str
    arguments: tuple[Value | None, ...]

    def __call__(self, variables: Variables) -> Scalar:
        """Raise the fault of a function that stands where a number is needed."""
        name, count = self.name, sum(argument is not None for argument in self.arguments)
        wanted = (
            1 if name in _ONE else 2 if name in _TWO else 3 if name == "BOUND" else _TAKES.get(name, (0,))[0]
        )
        if wanted:
            message = f"{name} has {count} arguments, and takes {wanted}"
            raise BlockError("function-arguments", message, name, hint=f"{name} takes {wanted}")
        hint = f"read are {', '.join([*_ONE, *_TWO, *_TEXTS])}"
        raise BlockError("function-unknown", f"the function {name} is not read", name, hint=hint)


#: The function that looks for a file, whose value the run knows as it knows those of variables.
IS_FILE = "ISFILE"


@dataclass(frozen=True, slots=True)
class Chain:
    """Two frames one after the other."""

    first: Value
    second: Value

    def __call__(self, variables: Variables) -> Scalar:
        """Raise: a frame is no number."""
        message = ": chains frames, and a number is needed"
        raise BlockError("value-kind", message, hint="$P_PFRAME=CTRANS(X,10):CROT(Z,45)")


def _flat(values: Iterable[Value]) -> tuple[Value, ...]:
    """Return values, as formulas where they have operands of their own, so that nothing nests."""
    return tuple(
        common.begun(value, _ARITHMETIC) if getattr(value, "operands", ()) else value for value in values
    )


def variable(name: str, indices: tuple[Value, ...]) -> Value:
    """Return what a name stands for."""
    indices = _flat(indices)
    if name[0] == "R" and name[1:].isdigit() and not indices:
        return RParameter(float(name[1:]))
    if name == "R" and len(indices) == 1:
        return RParameter(indices[0])
    if name in common.CONSTANTS_OF_SINUMERIK and not indices:
        return common.CONSTANTS_OF_SINUMERIK[name]
    return Variable(name, indices)


def function(name: str, arguments: tuple[Value | None, ...]) -> Value:
    """Return the value of a function."""
    given = [argument for argument in arguments if argument is not None]
    if name in _ONE and len(given) == 1:
        return unary(name, given[0])
    if name in _TWO and len(given) == 2:
        return binary(name, *given)
    if name == "BOUND" and len(given) == 3:
        low, high, value = given
        return binary("MAXVAL", low, binary("MINVAL", high, value))
    if name == IS_FILE and len(given) == 1:
        return Variable(name, _flat(given))
    if len(given) in _TAKES.get(name, ()) and len(given) == len(arguments):
        return TextFunction(name, _flat(given))
    return Function(name, arguments)


def binary(operator: str, a: Value, b: Value) -> Value:
    """Return ``a operator b``."""
    found: Value = common.binary(_OPERATORS[operator], a, b, _ARITHMETIC)
    return found


def unary(name: str, a: Value) -> Value:
    """Return a function or sign of a value."""
    found: Value = (
        common.negative(a, _ARITHMETIC) if name == "-" else common.unary(_UNARY[name], a, _ARITHMETIC)
    )
    return found


# Operators and functions.

_ONE, _TWO = common.FUNCTIONS_OF_SINUMERIK, common.PAIRS_OF_SINUMERIK
_OPERATORS = {**common.OF_SINUMERIK, **_TWO, "<<": codes.JOIN}
_UNARY = {**_ONE, "NOT": codes.NEGATED, "+": codes.PLUS}


def _digits(value: float | None) -> str:
    """Return a number as << writes it: a whole one in full."""
    return f"{value:.0f}" if value is not None and value.is_integer() else f"{value:.10g}"


class _Arithmetic(common.Arithmetic):
    def without(self, operation: int, which: int, a: common.Scalar, b: common.Scalar) -> common.Scalar:
        """Return the value of an operator on texts."""
        if operation == codes.BINARY:
            if which == codes.JOIN:
                return "".join(value if isinstance(value, str) else _digits(value) for value in (a, b))
            if isinstance(a, str) and isinstance(b, str) and which in (codes.SAME, codes.OTHER_THAN):
                return float((a.upper() == b.upper()) == (which == codes.SAME))
            if isinstance(a, str) or isinstance(b, str):
                message = f"{self.names[which]} needs two numbers, and one of its values is a text"
                raise BlockError("value-kind", message, hint="<< joins texts")
        elif a is not None:
            number(
                a,
                "the value"
                if operation == codes.NEGATIVE or which not in _ONE.values()
                else f"the argument of {self.names[which]}",
            )
        return super().without(operation, which, a, b)


_ARITHMETIC = _Arithmetic(common.names_of(_OPERATORS, _UNARY))
