"""Values of expressions: numbers where they are known when the text is read, else formulas that the kernel computes.

Operators and functions are those of LinuxCNC's manual ("Expressions", "Functions"): angles are degrees, ``AND OR XOR``
take anything but zero as true, ``EQ`` and ``NE`` compare within 1e-4, operators of one rank group from the left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from cncgen.gcode.block import Value, nearest
from cncgen.gcode.errors import BlockError
from cncgen.kernels import gcode_arithmetic
from cncgen.kernels import gcode_codes as codes
from cncgen.kernels.gcode_formulas import Formula
from cncgen.records import dataclass, field

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters


#: A number or a text, and a value of one.
Scalar = float | str | None
#: Numbers beyond it have no bits that AND, OR, XOR and NOT could take.
_MOST_BITS = 2.0**53
#: The name of an operation whose divisor is 0.
_DIVISIONS = {
    codes.DIVIDE: "/",
    codes.MOD: "MOD",
    codes.REMAINDER: "MOD",
    codes.WHOLE_REMAINDER: "MOD",
    codes.WHOLE_QUOTIENT: "DIV",
}
_BITS = (codes.BITS_AND, codes.BITS_OR, codes.BITS_XOR, codes.BITS_NOT)
_ANGLES = (codes.SIN, codes.COS, codes.TAN)
_PARTIAL = frozenset((codes.POWER, *_DIVISIONS, *_BITS))
#: The least increment of lengths and angles where no machine says it, mm and degrees (IS-B); in inches a tenth.
LEAST_INCREMENT = 0.001
Operand = float | Callable[..., float | str]


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """The operators and functions of a language.

    Attributes:
        names: Those of operators and functions in faults, by their numbers in the kernel.
        brackets: The brackets around the argument of a function in faults. Within ( ) functions stand as they are named, so that faults have
            their place.
        replaced: The operators and functions that it means by those of the common grammar, by their numbers.
        fills: Whether vacant operands (NaN) count as 0.
    """

    names: Mapping[int, str]
    brackets: str = "()"
    replaced: Mapping[int, int] = field(default_factory=dict)
    fills: bool = False

    def without(self, operation: int, number: int, a: Scalar, b: Scalar) -> Scalar:
        """Return the value of a step for which the kernel has none, or raise its fault; `b` is None for a function."""
        assert isinstance(a, float)
        if operation == codes.BINARY and isinstance(b, float):
            if number in _PARTIAL and a == a and b == b:
                raise _without_result(number, a, b)
            return math.nan
        if a != a:
            return a
        if number in _BITS:
            raise _too_large(a)
        name = self.names[number]
        why = " has no finite real value"
        if number in _ANGLES:
            why = f": the angle is too large; its size must be below {gcode_arithmetic.LARGEST_ANGLE:g}"
        word = name if self.brackets == "()" else ""
        raise BlockError("domain", f"{name}{self.brackets[0]}{a:g}{self.brackets[1]}{why}", word)


def _without_result(number: int, a: float, b: float) -> BlockError:
    """Return the fault of an operator."""
    if number in _BITS:
        return _too_large(b if abs(a) < _MOST_BITS else a)
    if number == codes.POWER:
        if a < 0.0 and not b.is_integer():
            return BlockError("domain", f"{a:g} ** {b:g} has no real value")
        if a == 0.0 and b < 0.0:
            return BlockError("division-by-zero", f"0 ** {b:g} has no value")
        return BlockError("number-range", f"{a:g} ** {b:g} is too large")
    if b == 0.0:
        return BlockError("division-by-zero", f"{a:g} {_DIVISIONS[number]} 0 has no value")
    return BlockError("domain", f"{a:g} {_DIVISIONS[number]} {b:g} has no value")


def _too_large(a: float) -> BlockError:
    return BlockError("number-range", f"{a:g} is too large for AND, OR and XOR")


class _Macro(Arithmetic):
    """The arithmetic of Macro B, with functions of digits."""

    def without(self, operation: int, number: int, a: Scalar, b: Scalar) -> Scalar:
        """Return BIN or BCD of a whole number."""
        if isinstance(a, float) and number in (codes.BIN, codes.BCD):
            with suppress(ValueError, OverflowError):
                return float(int(f"{int(a):x}") if number == codes.BIN else int(f"{int(a):d}", 16))
        return Arithmetic.without(self, operation, number, a, b)


def names_of(*tables: Mapping[str, int]) -> dict[int, str]:
    """Return the names of operators or functions by their numbers."""
    return {number: name.upper() for table in tables for name, number in table.items()}


_LITERALS = names_of({name: number for name, number in codes.LITERALS.items() if "[" not in name})
LINUXCNC = Arithmetic({number: _LITERALS[number] for number in range(codes.ABS, codes.TAN + 1)}, "[]")
#: Macro B: vacant operands, FIX and FUP by magnitude, AND OR XOR of the bits of whole numbers (B-63324EN, 15.3).
FANUC = _Macro(
    {**LINUXCNC.names, codes.TRUNC: "FIX", codes.AWAY: "FUP", codes.TURN_OF_SINE: "ASIN", codes.BIN: "BIN", codes.BCD: "BCD"},
    "[]",
    {
        codes.AND: codes.BITS_AND, codes.OR: codes.BITS_OR, codes.XOR: codes.BITS_XOR, codes.MOD: codes.WHOLE_REMAINDER,
        codes.EQ: codes.EQUAL, codes.NE: codes.UNEQUAL, codes.FIX: codes.TRUNC, codes.FUP: codes.AWAY, codes.SQR: codes.SQRT,
        codes.RND: codes.ROUND, codes.ANGLE_OF: codes.TURN_OF, codes.ASIN: codes.TURN_OF_SINE,
    },
    fills=True,
)  # fmt: skip

#: Operators of Heidenhain and SINUMERIK by their numbers, functions by theirs and how many values they take; the kernel that reads lines
#: takes both from here.
OF_HEIDENHAIN = {
    "+": codes.ADD, "-": codes.SUBTRACT, "*": codes.MULTIPLY, "/": codes.DIVIDE, "DIV": codes.DIVIDE, "%": codes.REMAINDER,
    "^": codes.POWER, "LEN": codes.LENGTH_OF, "ANG": codes.TURN_OF, "EQU": codes.NEAR, "NE": codes.APART, "NEQ": codes.APART,
    "GT": codes.GT, "LT": codes.LT,
}  # fmt: skip
FUNCTIONS_OF_HEIDENHAIN = {
    **{name: codes.CONSTANTS[name] for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "SQRT", "ABS", "LN", "EXP")},
    "ATAN": codes.ARC_OF, "SQ": codes.SQUARE, "INT": codes.TRUNC, "FRAC": codes.FRACTION, "NEG": codes.MINUS, "LOG": codes.LOG_10,
    "SGN": codes.SIGN_OF,
}  # fmt: skip
OF_SINUMERIK = {
    "+": codes.ADD, "-": codes.SUBTRACT, "*": codes.MULTIPLY, "/": codes.DIVIDE, "DIV": codes.WHOLE_QUOTIENT, "MOD": codes.REMAINDER,
    "AND": codes.AND, "OR": codes.OR, "XOR": codes.XOR, "==": codes.SAME, "<>": codes.OTHER_THAN, ">": codes.ABOVE, "<": codes.BELOW,
    ">=": codes.AT_LEAST, "<=": codes.AT_MOST, "B_AND": codes.BITS_AND, "B_OR": codes.BITS_OR, "B_XOR": codes.BITS_XOR,
}  # fmt: skip
FUNCTIONS_OF_SINUMERIK = {
    **{
        name: codes.CONSTANTS[name]
        for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "SQRT", "ABS", "TRUNC", "ROUND", "LN", "EXP")
    },
    "POT": codes.SQUARE, "ROUNDUP": codes.CEILING, "B_NOT": codes.BITS_NOT,
}  # fmt: skip
PAIRS_OF_SINUMERIK = {"ATAN2": codes.ANGLE_OF, "MINVAL": codes.LESSER, "MAXVAL": codes.GREATER}
CONSTANTS_OF_SINUMERIK = {"TRUE": 1.0, "FALSE": 0.0, "PI": math.pi, "$PI": math.pi}
#: Q parameters of Heidenhain: values nearer than 1e-9 are equal, a remainder has the sign of what is divided.
HEIDENHAIN = Arithmetic(names_of(FUNCTIONS_OF_HEIDENHAIN))


def begun(first: Operand, arithmetic: Arithmetic) -> Formula:
    """Return a formula that begins with a value; one that begins so already may grow, as no value is an operand twice."""
    return first if isinstance(first, Formula) else Formula(first, arithmetic.without, arithmetic.fills)


def joined_by(operator: int, a: Operand, b: Operand, arithmetic: Arithmetic) -> Formula:
    """Return what an operator of the kernel makes of two values."""
    found = begun(a, arithmetic)
    found.add(b)
    found.apply(codes.BINARY, operator)
    return found


def _known(formula: Formula) -> Any:
    """Return the value of a formula of numbers; one with a fault or of a text is left for the run."""
    with suppress(BlockError):
        found = formula(None)
        return found if isinstance(found, float) else formula
    return formula


def binary(operator: int, a: Operand, b: Operand, arithmetic: Arithmetic = LINUXCNC) -> Any:
    """Return ``a operator b``."""
    if arithmetic is FANUC and operator == codes.MOD:
        remainder = begun(a, arithmetic)
        remainder.add(b)
        remainder.take(_remainder, 2)
        return remainder
    found = joined_by(arithmetic.replaced.get(operator, operator), a, b, arithmetic)
    return _known(found) if isinstance(a, float) and isinstance(b, float) else found


def _remainder(p: Parameters, a: float, b: float) -> float:
    """Return ``a MOD b`` of Macro B, of whole numbers: FANUC's 30i rounds both first, of which a warning tells as others do not."""
    a, b = (0.0 if value != value else value for value in (a, b))
    # From 2^52 on all numbers are whole.
    x, y = (
        math.copysign(math.floor(abs(value) + 0.5), value) if abs(value) < 2.0**52 else value
        for value in (a, b)
    )
    if y == 0.0 or math.isinf(x):
        raise _without_result(codes.WHOLE_REMAINDER, x, y)
    if (x, y) != (a, b):
        other = f"that of the numbers as they are is {math.fmod(a, b):g}"
        message = f"{a:g} MOD {b:g} is {math.fmod(x, y):g}: both are rounded to whole numbers first, as on FANUC's series 30i; {other}"
        p.interpreter.warn_once(
            "other-control", message, "MOD", "FIX[ ] or ROUND[ ] around both is beyond doubt"
        )
    return math.fmod(x, y)


def unary(function: int, a: Operand, arithmetic: Arithmetic = LINUXCNC) -> Any:
    """Return ``function[a]``."""
    number = arithmetic.replaced.get(function, function)
    if number not in arithmetic.names:
        raise BlockError("unknown-function", f"{_LITERALS[function]}[…] is not a function of this dialect")
    found = begun(a, arithmetic)
    found.apply(codes.FUNCTION, number)
    return _known(found) if isinstance(a, float) else found


def negative(a: Operand, arithmetic: Arithmetic = LINUXCNC) -> Any:
    """Return ``-a``."""
    if isinstance(a, float):
        return -a
    found = begun(a, arithmetic)
    found.apply(codes.NEGATIVE, 0)
    return found


def _increments_in_one(p: Parameters) -> float:
    """Return how many of the control's least increments a millimetre, inch or degree has."""
    interpreter = p.interpreter
    least = interpreter.options.least_increment or LEAST_INCREMENT
    return float(round(1.0 / (least / (10.0 if interpreter.state.inches else 1.0))))


def increments(a: Value, arithmetic: Arithmetic) -> Value:
    """Return a number of least increments in the units in force."""
    return joined_by(codes.MULTIPLY, a, lambda p: p.interpreter.increment(), arithmetic)


def rounded_to_increment(a: Value) -> Value:
    """Return ROUND in a word of FANUC, which rounds to the least increment of the word (B-63324EN, 15.3, "ROUND function")."""
    whole = joined_by(codes.MULTIPLY, a, _increments_in_one, FANUC)
    whole.apply(codes.FUNCTION, codes.ROUND)
    return joined_by(codes.DIVIDE, whole, _increments_in_one, FANUC)


def arc_tangent(y: Value, x: Value | None, arithmetic: Arithmetic = LINUXCNC) -> Value:
    """Return ``ATAN[y]/[x]`` in degrees: -180 to 180, in FANUC's macros 0 to 360; there ``ATAN[y]`` is -90 to 90.

    Raises:
        BlockError: ``ATAN[y]`` alone in LinuxCNC's dialect.
    """
    if x is not None:
        return joined_by(arithmetic.replaced.get(codes.ANGLE_OF, codes.ANGLE_OF), y, x, arithmetic)
    if arithmetic is not FANUC:
        message = "ATAN needs two values: ATAN[y]/[x]"
        raise BlockError("syntax", message, "ATAN", hint="ATAN[y]/[1] for the slope y")
    found = begun(y, arithmetic)
    found.apply(codes.FUNCTION, codes.ARC_OF)
    return found


def parameter(target: Value | str, arithmetic: Arithmetic = LINUXCNC) -> Value:
    """Return ``#target``: a number, a name or a function that computes the number."""
    if isinstance(target, str):
        name = target
        return lambda p: p.name(name)
    if isinstance(target, float):
        index = nearest(target, "the number of a parameter")
        if index == target and 0 < index < 1000:
            if arithmetic is FANUC:
                return lambda p: p.told(index, p.numbers[index])
            return lambda p: p.numbers[index]
        number = target
        return lambda p: p.number(number)
    found = begun(target, arithmetic)
    found.take(lambda p, number: p.number(number), 1)
    return found


def exists(target: Value | str, arithmetic: Arithmetic = LINUXCNC) -> Value:
    """Return ``EXISTS[#<name>]``: 1 where the parameter has a value, or a parameter of that number exists."""
    if isinstance(target, str):
        name = target
        return lambda p: 1.0 if p.has(name) else 0.0
    found = begun(target, arithmetic)
    found.take(lambda p, number: 1.0 if p.has_number(number) else 0.0, 1)
    return found
