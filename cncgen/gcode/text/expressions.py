"""Values of expressions: numbers where they are known when the text is read, else functions of the parameters.

Operators and functions are those of LinuxCNC's manual ("Expressions", "Functions"): angles are degrees, ``AND OR XOR``
take anything but zero as true, ``EQ`` and ``NE`` compare within 1e-4, operators of one rank group from the left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from cncgen.gcode.block import Computed, Value, nearest
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text.evaluation import evaluate
from cncgen.kernels import gcode_arithmetic
from cncgen.kernels import gcode_codes as codes
from cncgen.records import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters


Operator = Callable[[float, float], float]
Function = Callable[[float], float]
#: Numbers beyond it have no bits that AND, OR, XOR and NOT could take.
_MOST_BITS = 2.0**53
#: What a division is called whose divisor is 0.
_DIVISIONS = {codes.DIVIDE: "/", codes.MOD: "MOD", codes.REMAINDER: "MOD", codes.WHOLE_QUOTIENT: "DIV"}
_BITS = (codes.BITS_AND, codes.BITS_OR, codes.BITS_XOR, codes.BITS_NOT)
_ANGLES = (codes.SIN, codes.COS, codes.TAN)
#: Operators that have no value for some finite numbers.
_PARTIAL = frozenset((codes.POWER, *_DIVISIONS, *_BITS))


def operator_of(number: int) -> Operator:
    """Return an operator by its number in the kernel, which computes it here too; a fault says why there is no value."""

    def run(a: float, b: float) -> float:
        value: float = gcode_arithmetic.joined(number, a, b)
        if value != value and number in _PARTIAL and a == a and b == b:
            raise _without_result(number, a, b)
        return value

    return run


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


def function_of(name: str, number: int, shown: str = "[]") -> Function:
    """Return a function by its name and its number in the kernel, as `operator_of`; faults show the value within these brackets."""
    word = name.upper()

    def run(a: float) -> float:
        value: float = gcode_arithmetic.function_of(number, a)
        if value != value and a == a:
            if number in _BITS:
                raise _too_large(a)
            most, why = gcode_arithmetic.LARGEST_ANGLE, " has no finite real value"
            if number in _ANGLES:
                why = f": the angle is too large; its size must be below {most:g}"
            # Within ( ) functions stand as they are named, so that the fault has its place.
            raise BlockError("domain", f"{word}{shown[0]}{a:g}{shown[1]}{why}", word if shown == "()" else "")
        return value

    return run


BINARY = {
    name: operator_of(codes.LITERALS[name])
    for name in ("+", "-", "*", "/", "**", "mod", "and", "or", "xor", "eq", "ne", "gt", "ge", "lt", "le")
}
UNARY = {
    name: function_of(name, codes.LITERALS[name])
    for name in ("abs", "acos", "asin", "cos", "exp", "fix", "fup", "ln", "round", "sin", "sqrt", "tan")
}

#: The least increment of lengths and angles where no machine says it, mm and degrees (IS-B); in inches a tenth.
LEAST_INCREMENT = 0.001


def _plain(value: float) -> float:
    """Return a number, 0 for a vacant one (NaN)."""
    return value if value == value else 0.0


def _fill(function: Operator) -> Operator:
    """Return an operator that takes vacant operands as 0."""
    return lambda a, b: function(_plain(a), _plain(b))


def _fill_one(function: Function) -> Function:
    """Return a function that takes a vacant argument as 0."""
    return lambda a: function(_plain(a))


def _same(a: float, b: float) -> bool:
    """Tell whether two values are equal in a macro: a vacant one equals a vacant one only."""
    return (a != a and b != b) or a == b


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """Operators and functions of a dialect by name."""

    binary: Mapping[str, Operator]
    unary: Mapping[str, Function]


def _whole(name: str, function: Callable[[float], int]) -> Function:
    """Return a function of the digits of a whole number."""

    def run(a: float) -> float:
        try:
            return float(function(a))
        except (ValueError, OverflowError):
            raise BlockError("domain", f"{name.upper()}[{a:g}] has no finite real value") from None

    return run


LINUXCNC = Arithmetic(BINARY, UNARY)
#: Macro B: vacant operands, FIX and FUP by magnitude, AND OR XOR of the bits of whole numbers (B-63324EN, 15.3).
FANUC = Arithmetic(
    {
        **{name: _fill(function) for name, function in BINARY.items()},
        "and": _fill(operator_of(codes.BITS_AND)),
        "or": _fill(operator_of(codes.BITS_OR)),
        "xor": _fill(operator_of(codes.BITS_XOR)),
        "mod": _fill(operator_of(codes.REMAINDER)),
        "eq": lambda a, b: 1.0 if _same(a, b) else 0.0,
        "ne": lambda a, b: 0.0 if _same(a, b) else 1.0,
    },
    {
        **{name: _fill_one(function) for name, function in UNARY.items()},
        "asin": _fill_one(lambda a: UNARY["asin"](a) % 360.0),
        "fix": _fill_one(function_of("fix", codes.TRUNC)),
        "fup": _fill_one(lambda a: math.copysign(UNARY["fup"](abs(a)), a)),
        "sqr": _fill_one(UNARY["sqrt"]),
        "rnd": _fill_one(UNARY["round"]),
        "bin": _fill_one(_whole("bin", lambda a: int(f"{int(a):x}"))),
        "bcd": _fill_one(_whole("bcd", lambda a: int(f"{int(a):d}", 16))),
    },
)

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
#: Functions of SINUMERIK of two values.
PAIRS_OF_SINUMERIK = {"ATAN2": codes.ANGLE_OF, "MINVAL": codes.LESSER, "MAXVAL": codes.GREATER}
#: Q parameters of Heidenhain: values nearer than 1e-9 are equal, a remainder has the sign of what is divided.
HEIDENHAIN = Arithmetic(
    {name: operator_of(number) for name, number in OF_HEIDENHAIN.items()},
    {name: function_of(name, number, "()") for name, number in FUNCTIONS_OF_HEIDENHAIN.items()},
)


#: Operators in a row that call one another; a longer row is run through.
_NESTED = 6


def binary(name: str, a: Value, b: Value, arithmetic: Arithmetic = LINUXCNC) -> Value:
    """Return ``a name b``; a row of operators of any length takes no more depth than `_NESTED` calls."""
    function = arithmetic.binary[name]
    if isinstance(a, float) and isinstance(b, float):
        try:
            return function(a, b)
        except BlockError:
            return lambda p: function(a, b)
    if isinstance(a, float):
        return _after(function, a, b)
    nested = getattr(a, "nested", 0)
    if nested < _NESTED:
        computed = _joined(function, a, b)
        computed.nested = nested + 1  # type: ignore[attr-defined]
        return computed
    step = function, b if callable(b) else _constant(b)
    if hasattr(a, "steps"):
        # The left operand of an operator is not the left operand of another one, so it may grow.
        a.steps.append(step)
        return a
    return _row(a, [step])


def _after(function: Operator, known: float, b: Value) -> Computed:
    """Return an operator whose left side is known."""
    assert callable(b)
    return lambda p: function(known, b(p))


def _joined(function: Operator, a: Computed, b: Value) -> Computed:
    """Return an operator; the operand that is known is not called: most operators of real programs have one."""
    if isinstance(b, float):
        return lambda p: function(a(p), b)
    return lambda p: function(a(p), b(p))


def _constant(value: float) -> Computed:
    return lambda p: value


def _row(first: Computed, steps: list[tuple[Operator, Computed]]) -> Computed:
    """Return operators one after another, from the left; `steps` may grow until the expression is read."""

    def run(p: Parameters) -> float:
        total = first(p)
        for function, value in steps:
            total = function(total, value(p))
        return total

    run.steps, run.nested = steps, _NESTED  # type: ignore[attr-defined]
    return run


def unary(name: str, a: Value, arithmetic: Arithmetic = LINUXCNC) -> Value:
    """Return ``name[a]``."""
    function = arithmetic.unary.get(name)
    if function is None:
        raise BlockError("unknown-function", f"{name.upper()}[…] is not a function of this dialect")
    if isinstance(a, float):
        try:
            return function(a)
        except BlockError:
            value = a
            return lambda p: function(value)
    return lambda p: function(a(p))


def negative(a: Value) -> Value:
    """Return ``-a``; signs in a row do not nest."""
    if isinstance(a, float):
        return -a
    positive: Computed | None = getattr(a, "positive", None)
    if positive is not None:
        return positive

    def run(p: Parameters) -> float:
        return -a(p)

    run.positive = a  # type: ignore[attr-defined]
    return run


def increments(a: Value) -> Value:
    """Return a number of least increments in the units in force."""
    return lambda p: evaluate(a, p) * p.interpreter.increment()


def rounded_to_increment(a: Value) -> Value:
    """Return ROUND in a word of FANUC, which rounds to the least increment of the word (B-63324EN, 15.3, "ROUND function")."""

    def run(p: Parameters) -> float:
        value = evaluate(a, p)
        if value != value:
            return 0.0
        interpreter = p.interpreter
        counts = round(
            1.0
            / (
                (interpreter.options.least_increment or LEAST_INCREMENT)
                / (10.0 if interpreter.state.inches else 1.0)
            )
        )
        return math.copysign(math.floor(abs(value) * counts + 0.5) / counts, value)

    return run


def arc_tangent(y: Value, x: Value | None, arithmetic: Arithmetic = LINUXCNC) -> Value:
    """Return ``ATAN[y]/[x]`` in degrees: -180 to 180, in FANUC's macros 0 to 360; there ``ATAN[y]`` is -90 to 90.

    Raises:
        BlockError: ``ATAN[y]`` alone in LinuxCNC's dialect.
    """
    macro = arithmetic is FANUC
    if x is None:
        if not macro:
            raise BlockError(
                "syntax", "ATAN needs two values: ATAN[y]/[x]", "ATAN", hint="ATAN[y]/[1] for the slope y"
            )
        return lambda p: math.degrees(math.atan(_plain(evaluate(y, p))))
    over = x

    def angle(p: Parameters) -> float:
        found = math.degrees(math.atan2(_plain(evaluate(y, p)), _plain(evaluate(over, p))))
        return found + 360.0 if macro and found < 0.0 else found

    return angle


def parameter(target: Value | str) -> Value:
    """Return ``#target``: a number, a name or a function that computes the number."""
    if isinstance(target, str):
        return _named(target)
    if isinstance(target, float):
        index = nearest(target, "the number of a parameter")
        if index == target and 0 < index < 1000:
            return lambda p: p.numbers[index]
        number = target
        return lambda p: p.number(number)
    return lambda p: p.number(target(p))


def _named(name: str) -> Computed:
    """Return ``#<name>``."""

    def of_all(p: Parameters) -> float:
        value = p.named.get(name)
        return p.name(name) if value is None else value

    def of_the_subroutine(p: Parameters) -> float:
        value = p.local.get(name)
        return p.name(name) if value is None else value

    return of_all if name.startswith("_") else of_the_subroutine


def exists(target: Value | str) -> Value:
    """Return ``EXISTS[#<name>]``: 1 where the parameter has a value, or a parameter of that number exists."""
    if isinstance(target, str):
        name = target
        return lambda p: 1.0 if p.has(name) else 0.0
    number = target
    return lambda p: 1.0 if p.has_number(evaluate(number, p)) else 0.0
