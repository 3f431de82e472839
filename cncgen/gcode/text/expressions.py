"""Values of expressions: numbers where they are known when the text is read, else functions of the parameters.

Operators and functions are those of LinuxCNC's manual ("Expressions", "Functions"): angles are degrees, ``AND OR XOR``
take anything but zero as true, ``EQ`` and ``NE`` compare within 1e-4, operators of one rank group from the left.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping

from cncgen.gcode.block import Computed, Value, nearest
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text.evaluation import EQUAL, evaluate
from cncgen.kernels import gcode_arithmetic
from cncgen.records import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters


def _divide(a: float, b: float) -> float:
    if b == 0.0:
        raise BlockError("division-by-zero", f"{a:g} / 0 has no value")
    return a / b


def _modulo(a: float, b: float) -> float:
    """Return the remainder with the sign of the divisor's size: never negative."""
    if b == 0.0:
        raise BlockError("division-by-zero", f"{a:g} MOD 0 has no value")
    try:
        rest = math.fmod(a, b)
    except ValueError:
        raise BlockError("domain", f"{a:g} MOD {b:g} has no value") from None
    return rest + abs(b) if rest < 0.0 else rest


def _remainder(a: float, b: float) -> float:
    """Return the remainder with the sign of what is divided."""
    return math.copysign(_modulo(abs(a), abs(b)), a)


def _power(a: float, b: float) -> float:
    if a < 0.0 and not b.is_integer():
        raise BlockError("domain", f"{a:g} ** {b:g} has no real value")
    if a == 0.0 and b < 0.0:
        raise BlockError("division-by-zero", f"0 ** {b:g} has no value")
    try:
        return a**b
    except OverflowError:
        raise BlockError("number-range", f"{a:g} ** {b:g} is too large") from None


def _checked(name: str, function: Callable[[float], float], shown: str = "[]") -> Callable[[float], float]:
    """Return a function whose domain errors are faults of the block."""

    def run(a: float) -> float:
        try:
            return function(a)
        except (ValueError, OverflowError):
            raise _without_value(name, a, shown) from None

    return run


def _without_value(name: str, a: float, shown: str, why: str = " has no finite real value") -> BlockError:
    """Return the fault of a function; within ( ) functions stand as they are named, so that the fault has its place."""
    word = name.upper()
    return BlockError("domain", f"{word}{shown[0]}{a:g}{shown[1]}{why}", word if shown == "()" else "")


def _of_angle(name: str, function: Callable[[float], float], shown: str) -> Callable[[float], float]:
    """Return a function of an angle in degrees, which must be of a size that it can be told from others."""

    def run(a: float) -> float:
        if not abs(a) < gcode_arithmetic.LARGEST_ANGLE:
            most = gcode_arithmetic.LARGEST_ANGLE
            raise _without_value(name, a, shown, f": the angle is too large; its size must be below {most:g}")
        return function(a)

    return run


def _of_ratio(name: str, function: Callable[[float], float], shown: str) -> Callable[[float], float]:
    """Return an inverse function, of -1 to 1."""

    def run(a: float) -> float:
        if not -1.0 <= a <= 1.0:
            raise _without_value(name, a, shown)
        return function(a)

    return run


BINARY: dict[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _divide,
    "**": _power,
    "mod": _modulo,
    "and": lambda a, b: 1.0 if a and b else 0.0,
    "or": lambda a, b: 1.0 if a or b else 0.0,
    "xor": lambda a, b: 1.0 if bool(a) != bool(b) else 0.0,
    "eq": lambda a, b: 1.0 if abs(a - b) < EQUAL else 0.0,
    "ne": lambda a, b: 0.0 if abs(a - b) < EQUAL else 1.0,
    "gt": lambda a, b: 1.0 if a > b else 0.0,
    "ge": lambda a, b: 1.0 if a >= b else 0.0,
    "lt": lambda a, b: 1.0 if a < b else 0.0,
    "le": lambda a, b: 1.0 if a <= b else 0.0,
}

#: The least increment of lengths and angles where no machine says it, mm and degrees (IS-B); in inches a tenth.
LEAST_INCREMENT = 0.001


def functions(shown: str = "[]") -> dict[str, Callable[[float], float]]:
    """Return the functions of one value, whose faults show it within these brackets."""
    return {
        "abs": abs,
        "acos": _of_ratio("acos", gcode_arithmetic.arc_cosine, shown),
        "asin": _of_ratio("asin", gcode_arithmetic.arc_sine, shown),
        "cos": _of_angle("cos", gcode_arithmetic.cosine, shown),
        "exp": _checked("exp", math.exp, shown),
        "fix": _checked("fix", lambda a: math.copysign(math.floor(a), a), shown),
        "fup": _checked("fup", lambda a: math.copysign(math.ceil(a), a), shown),
        "ln": _checked("ln", math.log, shown),
        "round": _checked("round", lambda a: math.copysign(math.floor(abs(a) + 0.5), a), shown),
        "sin": _of_angle("sin", gcode_arithmetic.sine, shown),
        "sqrt": _checked("sqrt", math.sqrt, shown),
        "tan": _of_angle("tan", gcode_arithmetic.tangent, shown),
    }


UNARY = functions()


def _plain(value: float) -> float:
    """Return a number, 0 for a vacant one (NaN)."""
    return value if value == value else 0.0


def _fill(function: Callable[[float, float], float]) -> Callable[[float, float], float]:
    """Return an operator that takes vacant operands as 0."""
    return lambda a, b: function(_plain(a), _plain(b))


def _fill_one(function: Callable[[float], float]) -> Callable[[float], float]:
    """Return a function that takes a vacant argument as 0."""
    return lambda a: function(_plain(a))


def bits(a: float) -> int:
    """Return a number as the whole number whose bits AND, OR, XOR and NOT take."""
    if not abs(a) < 2.0**53:
        raise BlockError("number-range", f"{a:g} is too large for AND, OR and XOR")
    return int(a)


def _same(a: float, b: float) -> bool:
    """Tell whether two values are equal in a macro: a vacant one equals a vacant one only."""
    return (a != a and b != b) or a == b


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """Operators and functions of a dialect by name."""

    binary: Mapping[str, Callable[[float, float], float]]
    unary: Mapping[str, Callable[[float], float]]


LINUXCNC = Arithmetic(BINARY, UNARY)
#: Macro B: vacant operands, FIX and FUP by magnitude, AND OR XOR of the bits of whole numbers (B-63324EN, 15.3).
FANUC = Arithmetic(
    {
        **{name: _fill(function) for name, function in BINARY.items()},
        "and": _fill(lambda a, b: float(bits(a) & bits(b))),
        "or": _fill(lambda a, b: float(bits(a) | bits(b))),
        "xor": _fill(lambda a, b: float(bits(a) ^ bits(b))),
        "mod": _fill(_remainder),
        "eq": lambda a, b: 1.0 if _same(a, b) else 0.0,
        "ne": lambda a, b: 0.0 if _same(a, b) else 1.0,
    },
    {
        **{name: _fill_one(function) for name, function in UNARY.items()},
        "asin": _fill_one(lambda a: UNARY["asin"](a) % 360.0),
        "fix": _fill_one(_checked("fix", lambda a: float(math.trunc(a)))),
        "fup": _fill_one(_checked("fup", lambda a: math.copysign(math.ceil(abs(a)), a))),
        "sqr": _fill_one(UNARY["sqrt"]),
        "rnd": _fill_one(UNARY["round"]),
        "bin": _fill_one(_checked("bin", lambda a: float(int(f"{int(a):x}")))),
        "bcd": _fill_one(_checked("bcd", lambda a: float(int(f"{int(a):d}", 16)))),
    },
)

_OF_Q = functions("()")
#: Q parameters of Heidenhain: values nearer than 1e-9 are equal, a remainder has the sign of what is divided.
HEIDENHAIN = Arithmetic(
    {
        **{name: BINARY[name] for name in "+-*/"},
        "DIV": _divide,
        "%": _remainder,
        "^": _power,
        "LEN": math.hypot,
        "ANG": lambda a, b: math.degrees(math.atan2(a, b)) % 360.0,
        "EQU": lambda a, b: 1.0 if abs(a - b) < 1e-9 else 0.0,
        **dict.fromkeys(("NE", "NEQ"), lambda a, b: 1.0 if abs(a - b) >= 1e-9 else 0.0),
        "GT": BINARY["gt"],
        "LT": BINARY["lt"],
    },
    {
        **{
            name.upper(): _OF_Q[name]
            for name in ("sin", "cos", "tan", "asin", "acos", "sqrt", "abs", "ln", "exp")
        },
        "ATAN": lambda a: math.degrees(math.atan(a)),
        "SQ": lambda a: a * a,
        "INT": _checked("int", lambda a: float(math.trunc(a)), "()"),
        "FRAC": _checked("frac", lambda a: math.fmod(a, 1.0), "()"),
        "NEG": operator.neg,
        "LOG": _checked("log", math.log10, "()"),
        "SGN": lambda a: math.copysign(1.0, a) if a else 0.0,
    },
)


Operator = Callable[[float, float], float]
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
