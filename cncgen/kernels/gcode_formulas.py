# cython: infer_types=True
"""Compute values that a program gives by expressions, of all languages: instructions as those of `gcode_run`, over numbers and texts.

A row of operators of any length takes no depth. Where `gcode_arithmetic` has no value, the language says what there is instead.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_arithmetic import function_of, joined
from cython.cimports.cncgen.kernels.gcode_codes import BINARY, EQUAL, FUNCTION, NEGATIVE, UNEQUAL


@cython.final
@cython.cclass
class Formula:
    """An expression whose value is asked for when the program runs.

    Args:
        first: Its first operand: a number, a formula, or a function of the store, whose `operands`, where it has some, stand before it for its
            method `of`.
        without: Takes operation, number and operands (the second one None for a function) of a step that has no number: a text, a vacant
            value, an operand out of range. Returns its value, or raises the fault.
        fills: Whether vacant operands (NaN) count as 0.
    """

    steps = cython.declare(list)
    without = cython.declare(object)
    fills = cython.declare(cython.bint)

    def __init__(self, first, without, fills: bool = False):
        self.steps, self.without, self.fills = [], without, fills
        self.add(first)

    @cython.ccall
    def add(self, operand):
        """Push an operand behind those that are there."""
        operands = getattr(operand, "operands", ())
        if isinstance(operand, Formula):
            formula: Formula = operand
            self.steps.extend(formula.steps)
        elif operands:
            for each in operands:
                self.add(each)
            self.take(operand.of, len(operands))
        else:
            self.steps.append(operand)

    @cython.ccall
    def apply(self, operation: cython.int, number: cython.int):
        """Take operands, and push what an instruction makes of them."""
        self.steps.append(operation + 256 * number)

    @cython.ccall
    def take(self, function, count: cython.int):
        """Take so many operands, and push what a function of the store and these returns."""
        self.steps.append((function, count))

    def __call__(self, store):
        """Return the present value; `store` has the values of names."""
        stack: list = []
        operation: cython.int
        number: cython.int
        for step in self.steps:
            if isinstance(step, float):
                stack.append(step)
                continue
            if isinstance(step, tuple):
                number = len(stack) - cython.cast(cython.int, step[1])
                values, stack = stack[number:], stack[:number]
                stack.append(step[0](store, *values))
                continue
            if not isinstance(step, int):
                stack.append(step(store))
                continue
            number = step
            operation, number = number & 255, number >> 8
            last = stack.pop()
            if operation == BINARY:
                stack.append(self._joined(number, stack.pop(), last))
            else:
                stack.append(self._of(operation, number, last))
        return stack[0]

    @cython.cfunc
    def _joined(self, number: cython.int, a, b):
        """Return what an operator makes of two values."""
        x: cython.double
        y: cython.double
        if isinstance(a, str) or isinstance(b, str):
            return self.without(BINARY, number, a, b)
        x, y = a, b
        if self.fills and number != EQUAL and number != UNEQUAL:
            x = x if x == x else 0.0
            y = y if y == y else 0.0
        value = joined(number, x, y)
        return value if value == value else self.without(BINARY, number, x, y)

    @cython.cfunc
    def _of(self, operation: cython.int, number: cython.int, a):
        """Return a function or the negative of a value."""
        x: cython.double
        if isinstance(a, str):
            return self.without(operation, number, a, None)
        x = a
        if operation == NEGATIVE:
            return -x
        if self.fills and x != x:
            x = 0.0
        value = function_of(number, x)
        return value if value == value else self.without(FUNCTION, number, x, None)
