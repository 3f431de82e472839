"""Values of Q parameters: ``Q1 = ( Q2 + 3 ) * SIN Q3`` and the functions FN 0 to FN 8, FN 13."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from cncgen.gcode.errors import BlockError, Stop

_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d++[.,]?+\d*+|[.,]\d+)|Q(?P<q>\d{1,99})|(?P<name>[A-Z]+)|(?P<sign>[-+*/^()%]))",
    re.IGNORECASE,
)
_UNARY: dict[str, Callable[[float], float]] = {
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)),
    "ASIN": lambda x: math.degrees(math.asin(x)),
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ATAN": lambda x: math.degrees(math.atan(x)),
    "SQRT": math.sqrt,
    "SQ": lambda x: x * x,
    "ABS": abs,
    "INT": lambda x: float(math.trunc(x)),
    "FRAC": lambda x: math.fmod(x, 1.0),
    "NEG": lambda x: -x,
    "LN": math.log,
    "LOG": math.log10,
    "EXP": math.exp,
    "SGN": lambda x: math.copysign(1.0, x) if x else 0.0,
}
_FN = re.compile(r"FN\s*(?P<number>\d{1,99})\s*:\s*(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_TARGET = re.compile(r"Q(?P<q>\d{1,99})\s*=\s*(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_OPERAND = r"\s*((?:[-+]\s*)?(?:Q\d+|\d++[.,]?+\d*+|[.,]\d+))\s*"
_TWO = {
    1: (re.compile(_OPERAND + r"\+" + _OPERAND + r"\Z", re.IGNORECASE), lambda a, b: a + b),
    2: (re.compile(_OPERAND + r"-" + _OPERAND + r"\Z", re.IGNORECASE), lambda a, b: a - b),
    3: (re.compile(_OPERAND + r"\*" + _OPERAND + r"\Z", re.IGNORECASE), lambda a, b: a * b),
    4: (re.compile(_OPERAND + r"(?:DIV|/)" + _OPERAND + r"\Z", re.IGNORECASE), lambda a, b: _divided(a, b)),
    8: (re.compile(_OPERAND + r"LEN" + _OPERAND + r"\Z", re.IGNORECASE), math.hypot),
    13: (
        re.compile(_OPERAND + r"ANG" + _OPERAND + r"\Z", re.IGNORECASE),
        lambda a, b: math.degrees(math.atan2(a, b)) % 360.0,
    ),
}
_ONE = {5: "SQRT", 6: "SIN", 7: "COS"}
_CONDITION = re.compile(
    r"IF"
    + _OPERAND
    + r"(?P<how>EQU|NEQ|NE|GT|LT)"
    + _OPERAND
    + r"GOTO\s+LBL\s+(?P<label>\"[^\"]*\"|\w+)\s*\Z",
    re.IGNORECASE,
)
_HOLDS: dict[int, tuple[str, Callable[[float, float], bool]]] = {
    9: ("EQU", lambda a, b: abs(a - b) < 1e-9),
    10: ("NE", lambda a, b: abs(a - b) >= 1e-9),
    11: ("GT", lambda a, b: a > b),
    12: ("LT", lambda a, b: a < b),
}
_FEED_WORD = re.compile(r"\s*F?\s*(?P<word>AUTO|MAX)\s*\Z", re.IGNORECASE)
#: Functions that move and set nothing here; texts are not kept, and statements that use one report it.
_PRINTS = (15, 16, 19, 20, 26, 27, 29, 37, 38)
_TEXT = re.compile(r"QS\d+\s*=", re.IGNORECASE)
Read = Callable[[int], float]


def _divided(a: float, b: float) -> float:
    if b == 0.0:
        raise BlockError("division-by-zero", f"{a:g} is divided by 0", hint="was the Q parameter set?")
    return a / b


def _remainder(a: float, b: float) -> float:
    if not math.isfinite(a):
        raise BlockError("domain", f"{a:g} % {b:g} has no value", hint="was the Q parameter set?")
    if b == 0.0:
        raise BlockError("division-by-zero", f"{a:g} is divided by 0", hint="was the Q parameter set?")
    return math.fmod(a, b)


def _raised(a: float, b: float) -> float:
    try:
        value = a**b
    except (OverflowError, ZeroDivisionError):
        value = math.inf
    if isinstance(value, complex) or not math.isfinite(value):
        raise BlockError("domain", f"{a:g} ^ {b:g} has no value", hint="was the Q parameter set?")
    return float(value)


#: Signs, functions and brackets within one another; each takes four calls.
_DEEPEST = 100


class _Formula:
    """A recursive descent over the tokens of a formula; ^ binds tightest, then * /, then + -; all group from the left."""

    def __init__(self, text: str, read: Read) -> None:
        self._read = read
        self._tokens: list[tuple[str, str]] = []
        at = 0
        body = text.rstrip()
        while at < len(body):
            match = _TOKEN.match(body, at)
            if match is None:
                raise BlockError(
                    "syntax",
                    f"'{body[at:].strip()[:1]}' stands in no formula of Q",
                    hint="Q1 = ( Q2 + 3 ) * SIN Q3",
                )
            self._tokens.append((str(match.lastgroup), match[0].strip()))
            at = match.end()
        self._at = 0
        self._depth = 0

    def whole(self) -> float:
        value = self._sum()
        if self._at < len(self._tokens):
            raise BlockError(
                "syntax",
                f"'{self._tokens[self._at][1]}' follows a formula that is complete",
                hint="Q1 = ( Q2 + 3 ) * SIN Q3",
            )
        return value

    def _peek(self) -> str:
        return self._tokens[self._at][1].upper() if self._at < len(self._tokens) else ""

    def _sum(self) -> float:
        value = self._product()
        while self._peek() in ("+", "-"):
            sign = self._next()
            other = self._product()
            value = value + other if sign == "+" else value - other
        return value

    def _product(self) -> float:
        value = self._power()
        while self._peek() in ("*", "/", "%"):
            sign = self._next()
            other = self._power()
            value = (
                value * other
                if sign == "*"
                else _divided(value, other)
                if sign == "/"
                else _remainder(value, other)
            )
        return value

    def _power(self) -> float:
        value = self._operand()
        while self._peek() == "^":
            self._next()
            value = _raised(value, self._operand())
        return value

    def _next(self) -> str:
        if self._at >= len(self._tokens):
            raise BlockError(
                "syntax", "a formula ends where a value was expected", hint="Q1 = ( Q2 + 3 ) * SIN Q3"
            )
        self._at += 1
        return self._tokens[self._at - 1][1].upper()

    def _operand(self) -> float:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise BlockError("syntax", f"a formula nests more than {_DEEPEST} signs, functions and brackets")
        value = self._operand_within()
        self._depth -= 1
        return value

    def _operand_within(self) -> float:
        kind = self._tokens[self._at][0] if self._at < len(self._tokens) else ""
        token = self._next()
        if kind == "number":
            return float(token.replace(",", "."))
        if kind == "q":
            return self._read(int(token[1:]))
        if token in ("-", "+"):
            value = self._operand()
            return -value if token == "-" else value
        if token == "(":
            value = self._sum()
            if self._next() != ")":
                raise BlockError("syntax", "a bracket of a formula is not closed", hint="each ( has its )")
            return value
        if token == "PI":
            return math.pi
        if token in _UNARY:
            operand = self._operand()
            try:
                return _UNARY[token](operand)
            except (ValueError, OverflowError):
                raise BlockError(
                    "domain", f"{token} of {operand:g} has no value", token, hint="was the Q parameter set?"
                ) from None
        raise BlockError(
            "syntax",
            f"{token} is not a function of Q parameters",
            token,
            hint=f"read are {', '.join(_UNARY)}",
        )


def formula(text: str, read: Read) -> float:
    """Return the value of a formula; raise where a double cannot hold it."""
    value = _Formula(text, read).whole()
    if not math.isfinite(value):
        raise BlockError("number-range", f"a value is {value:g}, beyond the range of numbers")
    return value


def assignment(body: str, read: Read, feed_word: Callable[[str], float]) -> tuple[float, float] | None:
    """Return the Q parameter that a line sets, and its value; None where it sets none.

    Args:
        body: The line.
        read: Gives the value of a Q parameter.
        feed_word: Gives the feed that AUTO or MAX stands for.

    Raises:
        BlockError: The formula is wrong, or has no value.
    """
    function = _FN.match(body)
    number = int(function["number"]) if function else 0
    target = _TARGET.match(function["rest"] if function else body)
    if target is None or (function and number not in (0, *_TWO, *_ONE)):
        return None
    rest = target["rest"]
    if number in _TWO:
        pattern, run = _TWO[number]
        operands = pattern.match(rest)
        if operands is None:
            raise BlockError("syntax", f"FN {number} has not its two values", hint="FN 1: Q1 = +Q2 + +5")
        return float(target["q"]), run(formula(operands[1], read), formula(operands[2], read))
    if number in _ONE:
        rest = re.sub(rf"\A\s*{_ONE[number]}\b", "", rest, flags=re.IGNORECASE)
        return float(target["q"]), formula(f"{_ONE[number]} ( {rest} )", read)
    word = _FEED_WORD.match(rest)
    return float(target["q"]), feed_word(word["word"].upper()) if word else formula(rest, read)


def pass_over(body: str) -> None:
    """Pass over a function that prints, sends or waits, or sets a text.

    Raises:
        Stop: FN 14 ends the program.
        BlockError: It is not read.
    """
    number = function_number(body)
    if number == 14:
        message = f"the program raises an error: {body}"
        raise Stop(BlockError("program-alarm", message, "FN", hint="FN 14 ends the program"))
    if number in _PRINTS or _TEXT.match(body):
        return
    what = f"FN {number}" if number is not None else "a line that begins with Q"
    hint = "FN 0 to FN 14, FN 18 and formulas of Q are read"
    raise BlockError("unsupported-block", f"{what} is not read", "FN", hint=hint)


def jump(body: str, read: Read) -> tuple[bool, str] | None:
    """Return whether a jump FN 9 to FN 12 is made, and its label; None for any other line."""
    function = _FN.match(body)
    if function is None or int(function["number"]) not in _HOLDS:
        return None
    number = int(function["number"])
    condition = _CONDITION.match(function["rest"].strip())
    how, holds = _HOLDS[number]
    if condition is None or condition["how"].upper().replace("NEQ", "NE") != how:
        raise BlockError(
            "syntax",
            f"FN {number} is written IF +Q1 {how} +Q2 GOTO LBL 5",
            hint=f"FN {number}: IF +Q1 {how} +5 GOTO LBL 1",
        )
    return holds(formula(condition[1], read), formula(condition[3], read)), condition["label"].strip(
        '"'
    ).upper()


def function_number(body: str) -> int | None:
    """Return n of a line FN n, None of others."""
    function = _FN.match(body)
    return int(function["number"]) if function else None
