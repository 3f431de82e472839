# cython: infer_types=True
"""Arithmetic of G-code's expressions: operators and functions of numbers, angles in degrees.

The language is LinuxCNC's (``grammars/gcode.lark``); `cncgen.gcode.text.expressions` defines operators and functions. An
expression without a value (a division by zero, a root of a negative number) gives NaN here, and the interpreter says why.

`gcode_run` calls these functions as C, by ``gcode_arithmetic.pxd``.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    ABS, ACOS, ADD, AND, ASIN, COS, DIVIDE, EQ, EXP, FIX, FUP, GE, GT, LE, LN, LT, MOD, MULTIPLY, NE, OR, POWER, ROUND, SIN, SQRT,
    SUBTRACT, TAN,
    ABOVE, ANGLE_OF, APART, ARC_OF, AT_LEAST, AWAY, BELOW, BITS_AND, BITS_NOT, BITS_OR, BITS_XOR, CEILING, EQUAL, FRACTION, GREATER, JOIN, LENGTH_OF, LESSER, MINUS,
    NEAR, NEGATED, OTHER_THAN, REMAINDER, SAME, SIGN_OF, SQUARE, TRUNC, TURN_OF, TURN_OF_SINE, UNEQUAL, WHOLE_QUOTIENT, WHOLE_REMAINDER,
)  # fmt: skip
from cython.cimports.libc.math import (
    acos, asin, atan, atan2, ceil, copysign, cos, exp, fabs, floor, fmod, hypot, isfinite, log, log10, pow, sin, sqrt, tan, trunc,
)  # fmt: skip

#: Reals of SINUMERIK are the same within this part of the larger one (`sinumerik.expressions`).
_LAST_BITS = cython.declare(cython.double, 2.0**-48)
#: Q parameters that are nearer than this are equal (`expressions.HEIDENHAIN`).
_NEAR = cython.declare(cython.double, 1e-9)
#: Equal in comparisons (`flow.o_words`).
_EQUAL = cython.declare(cython.double, 1e-4)
#: Whole numbers below it have bits.
_MOST_BITS = cython.declare(cython.double, 2.0**53)
_NAN = cython.declare(cython.double, float("nan"))

#: pi / 180 in two halves of 26 bits and what is left of it, and what splits a number so (2^27 + 1).
_DEGREE = cython.declare(cython.double, 0.017453292519943295)
_SPLIT = cython.declare(cython.double, 134217729.0)
_DEGREE_HIGH = cython.declare(cython.double, 0.01745329238474369)
_DEGREE_LOW = cython.declare(cython.double, 1.3519960498364902e-10)
_DEGREE_REST = cython.declare(cython.double, 2.9486522708701687e-19)
_PER_RADIAN = cython.declare(cython.double, 57.29577951308232)
#: Degrees beyond which an angle has no meaning (its sine would be noise); tangents beyond the other are left as they are.
LARGEST_ANGLE = 1e12
_LARGEST_ANGLE = cython.declare(cython.double, LARGEST_ANGLE)
#: Beyond this argument the exponential function overflows.
_LARGEST_EXPONENT = cython.declare(cython.double, 709.782712893384)
_STEEP = cython.declare(cython.double, 1e6)

#: An angle in radians, and what its rounding left.
_Angle = cython.struct(value=cython.double, rest=cython.double)


# Angles.


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _radians(a: cython.double) -> _Angle:
    """Return an angle in degrees as radians and what their rounding left: Dekker's product (Numer. Math. 18, 1971).

    With the latter, SIN[30] is 0.5 and TAN[45] is 1, which FIX, FUP and EQ must see.
    """
    split: cython.double = _SPLIT * a
    high: cython.double = split - (split - a)
    low: cython.double = a - high
    angle: cython.double = a * _DEGREE
    rest: cython.double = high * _DEGREE_HIGH - angle
    rest = ((rest + high * _DEGREE_LOW) + low * _DEGREE_HIGH) + low * _DEGREE_LOW
    return _Angle(value=angle, rest=rest + a * _DEGREE_REST)


@cython.ccall
def sine(a: cython.double) -> cython.double:
    """Return the sine of an angle in degrees, within `LARGEST_ANGLE`."""
    angle: _Angle = _radians(a)
    return sin(angle.value) + angle.rest * cos(angle.value)


@cython.ccall
def cosine(a: cython.double) -> cython.double:
    """Return the cosine of an angle in degrees, within `LARGEST_ANGLE`."""
    angle: _Angle = _radians(a)
    return cos(angle.value) - angle.rest * sin(angle.value)


@cython.ccall
def tangent(a: cython.double) -> cython.double:
    """Return the tangent of an angle in degrees, within `LARGEST_ANGLE`."""
    angle: _Angle = _radians(a)
    value: cython.double = tan(angle.value)
    return value + angle.rest * (1.0 + value * value) if fabs(value) < _STEEP else value


@cython.ccall
def arc_sine(a: cython.double) -> cython.double:
    """Return the angle in degrees whose sine is `a`, -1 to 1: a short number where its sine is `a` to the bit."""
    angle: cython.double = asin(a) * _PER_RADIAN
    short: cython.double = round(angle, 10)
    return short if sine(short) == a else angle


@cython.ccall
def arc_cosine(a: cython.double) -> cython.double:
    """Return the angle in degrees whose cosine is `a`, -1 to 1, as `arc_sine`."""
    angle: cython.double = acos(a) * _PER_RADIAN
    short: cython.double = round(angle, 10)
    return short if cosine(short) == a else angle


@cython.ccall
@cython.exceptval(check=False)
def arc_tangent(y: cython.double, x: cython.double) -> cython.double:
    """Return the angle in degrees of the direction (x, y), -180 to 180."""
    return atan2(y, x) * _PER_RADIAN


# Functions.


@cython.ccall
@cython.exceptval(check=False)
def function_of(name: cython.int, a: cython.double) -> cython.double:
    """Return the value of a function of one argument, by its number; NaN outside its domain."""
    value: cython.double = _NAN
    if name >= TRUNC:
        value = _function_of_languages(name, a)
    elif name == ABS:
        value = fabs(a)
    elif name == FIX:
        value = floor(a)
    elif name == FUP:
        value = ceil(a)
    elif name == ROUND:
        value = copysign(floor(fabs(a) + 0.5), a)
    elif name == SQRT and a >= 0.0:
        value = sqrt(a)
    elif name == EXP:
        if a <= _LARGEST_EXPONENT:
            value = exp(a)
    elif name == LN and a > 0.0:
        value = log(a)
    elif name == ASIN or name == ACOS:
        if -1.0 <= a <= 1.0:
            value = arc_sine(a) if name == ASIN else arc_cosine(a)
    elif fabs(a) < _LARGEST_ANGLE:
        value = _function_of_angle(name, a)
    return value if isfinite(value) else _NAN


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _function_of_angle(name: cython.int, a: cython.double) -> cython.double:
    """Return SIN, COS or TAN of an angle in degrees; NaN where the name is another one."""
    if name == SIN:
        return sine(a)
    if name == COS:
        return cosine(a)
    return tangent(a) if name == TAN else _NAN


@cython.cfunc
@cython.exceptval(check=False)
def _function_of_languages(name: cython.int, a: cython.double) -> cython.double:
    """Return the value of a function that G-code does not have; NaN outside its domain. A whole 0 has no sign."""
    if name == TRUNC:
        return trunc(a) + 0.0
    if name == CEILING:
        return ceil(a) + 0.0
    if name == SQUARE:
        return a * a
    if name == NEGATED:
        return 1.0 if a == 0.0 else 0.0
    if name == FRACTION:
        return fmod(a, 1.0)
    if name == SIGN_OF:
        return (1.0 if a > 0.0 else -1.0) if a != 0.0 else 0.0
    if name == ARC_OF:
        return atan(a) * _PER_RADIAN
    if name == TURN_OF_SINE:
        return arc_sine(a) + (360.0 if a < 0.0 else 0.0) if -1.0 <= a <= 1.0 else _NAN
    if name == MINUS:
        return -a
    if name >= AWAY:
        return copysign(ceil(fabs(a)), a) if name == AWAY else a
    if name == BITS_NOT:
        return cython.cast(cython.double, ~cython.cast(cython.longlong, a)) if fabs(a) < _MOST_BITS else _NAN
    return log10(a) if a > 0.0 else _NAN


# Operators.


@cython.ccall
@cython.exceptval(check=False)
def joined(operator: cython.int, a: cython.double, b: cython.double) -> cython.double:
    """Return ``a operator b``; NaN where it has no value."""
    if operator >= WHOLE_QUOTIENT:
        return _joined_in_languages(operator, a, b)
    if operator == ADD:
        return a + b
    if operator == SUBTRACT:
        return a - b
    if operator == MULTIPLY:
        return a * b
    if operator == DIVIDE or operator == MOD or operator == POWER:
        return _divided(operator, a, b)
    return 1.0 if _holds(operator, a, b) else 0.0


@cython.cfunc
@cython.exceptval(check=False)
def _divided(operator: cython.int, a: cython.double, b: cython.double) -> cython.double:
    """Return ``a / b``, ``a MOD b`` or ``a ** b``."""
    if operator == POWER:
        if (a < 0.0 and b != floor(b)) or (a == 0.0 and b < 0.0):
            return _NAN
        value = pow(a, b)
        return value if isfinite(value) else _NAN
    if b == 0.0:
        return _NAN
    if operator == DIVIDE:
        return a / b
    value = fmod(a, b)
    return value + fabs(b) if value < 0.0 else value


@cython.cfunc
@cython.exceptval(check=False)
def _holds(operator: cython.int, a: cython.double, b: cython.double) -> cython.bint:
    """Tell whether a relation or a connection of truth values holds."""
    if operator == LT:
        return a < b
    if operator == LE:
        return a <= b
    if operator == GT:
        return a > b
    if operator == GE:
        return a >= b
    if operator == EQ:
        return fabs(a - b) < _EQUAL
    if operator == NE:
        return not fabs(a - b) < _EQUAL
    if operator == AND:
        return a != 0.0 and b != 0.0
    if operator == OR:
        return a != 0.0 or b != 0.0
    return (a != 0.0) != (b != 0.0)


@cython.cfunc
@cython.exceptval(check=False)
def _joined_in_languages(operator: cython.int, a: cython.double, b: cython.double) -> cython.double:
    """Return ``a operator b`` of an operator that G-code does not have; NaN where it has no value."""
    if operator == WHOLE_QUOTIENT:
        return trunc(a / b) + 0.0 if b != 0.0 else _NAN
    if operator == REMAINDER:
        return fmod(a, b) if b != 0.0 else _NAN
    if operator == WHOLE_REMAINDER:
        return fmod(a, b) if b != 0.0 and floor(a) == a and floor(b) == b else _NAN
    if operator == LESSER:
        return b if b < a else a
    if operator == GREATER:
        return b if b > a else a
    if operator == ANGLE_OF:
        return arc_tangent(a, b)
    if operator == TURN_OF:
        angle = arc_tangent(a, b)
        return angle + (0.0 if angle >= 0.0 else 360.0)
    if operator == LENGTH_OF:
        return hypot(a, b)
    if operator == BITS_AND or operator == BITS_OR or operator == BITS_XOR:
        return _joined_bits(operator, a, b)
    if operator == JOIN:
        return _NAN
    return 1.0 if _holds_in_languages(operator, a, b) else 0.0


@cython.cfunc
@cython.exceptval(check=False)
def _holds_in_languages(operator: cython.int, a: cython.double, b: cython.double) -> cython.bint:
    """Tell whether a relation that G-code does not have holds."""
    same: cython.bint
    if operator == EQUAL or operator == UNEQUAL:
        # Two vacant values are equal.
        return (a == b or (a != a and b != b)) == (operator == EQUAL)
    if operator == NEAR or operator == APART:
        return (fabs(a - b) < _NEAR) == (operator == NEAR)
    same = fabs(a - b) <= _LAST_BITS * (fabs(b) if fabs(b) > fabs(a) else fabs(a))
    if operator == SAME or operator == OTHER_THAN:
        return same == (operator == SAME)
    if operator == ABOVE or operator == BELOW:
        return not same and (a > b) == (operator == ABOVE)
    return same or (a > b) == (operator == AT_LEAST)


@cython.cfunc
@cython.exceptval(check=False)
def _joined_bits(operator: cython.int, a: cython.double, b: cython.double) -> cython.double:
    """Return AND, OR or XOR of the bits of whole numbers."""
    if not (fabs(a) < _MOST_BITS and fabs(b) < _MOST_BITS):
        return _NAN
    one: cython.longlong = cython.cast(cython.longlong, a)
    other: cython.longlong = cython.cast(cython.longlong, b)
    if operator == BITS_AND:
        return cython.cast(cython.double, one & other)
    return cython.cast(cython.double, one | other if operator == BITS_OR else one ^ other)
