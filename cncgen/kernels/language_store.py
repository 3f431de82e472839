# cython: infer_types=True
"""The values that lines of SINUMERIK and Heidenhain read and set while `gcode_run` runs them, and where their jumps lead.

A setting acts in its own line. A line that is left to the interpreter gives back first what it has set.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    CALLS, COUNTS, GOES, LEAVES, REPEATS, SET_VARIABLE, UNLESS, WHEN,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_store import Store
from cython.cimports.libc.math import copysign, fabs, floor, isfinite

#: Settings of a line, at most.
_MOST_SETTINGS = cython.declare(cython.int, 40)
#: Larger numbers of rounds are faults (`block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e9)
#: Types of variables that hold numbers.
_NUMERIC = frozenset(("REAL", "INT", "BOOL"))


@cython.final
@cython.cclass
class LanguageStore(Store):
    """Parameters, variables, elements of arrays, and loops in progress. Of each setting of a line, `value` keeps what stood there before.

    Args:
        numbers: R or Q parameters by number, an array of doubles, read and set.
        least: The least number of one.
        scopes: Variables by name, with type, bounds and values: of the program in progress the last ones, of all programs the first.
    """

    def __init__(self, numbers, least, scopes):
        Store.__init__(self, numbers, {}, frozenset(), 0)
        self.least, self.scopes = least, scopes
        self.place = memoryview(bytearray(8 * _MOST_SETTINGS)).cast("q")
        self.leads = self.enters = self.call = self.leave = None
        self.loops, self.way = {}, ()

    def lead(self, leads, enters, loops: dict, call=None, leave=None):
        """Say how the next runs follow jumps.

        Args:
            leads: Returns by the number of a line with a jump its index among the lines of the program, and index, offset and number of
                the line that it leads to; None where that is not certain. Without it, jumps end a run.
            enters: Takes the index of a line that was jumped to, where loops are in progress.
            loops: The loops in progress by the indices of their lines (`flow.language_run.Frame`).
            call: Begins a call by the indices of its line and of its first one; returns the loops in it, None where it cannot be.
            leave: Ends it; returns what `leads` does for the line behind it, and the loops there, or None.
        """
        if leads is not self.leads:
            self.ways.clear()
        self.leads, self.enters, self.loops = leads, enters, loops
        self.call, self.leave, self.calls = call, leave, 0

    # Values.

    @cython.cfunc
    @cython.exceptval(check=False)
    def index(self, value: cython.double) -> cython.int:
        """Return the number of a parameter; -1 where there is none of it."""
        whole: cython.double = floor(value)
        return (
            cython.cast(cython.int, whole)
            if value == whole and self.least <= value < self.numbers.shape[0]
            else -1
        )

    @cython.cfunc
    @cython.exceptval(check=False)
    def set(self, k: cython.int, value: cython.double) -> cython.bint:
        """Set a parameter; tell whether it can be done."""
        if self.settings == _MOST_SETTINGS or not isfinite(value):
            return False
        self.target[self.settings] = k
        self.value[self.settings] = self.numbers[k]
        self.settings += 1
        self.numbers[k] = value
        return True

    @cython.cfunc
    def _variable(self, k: cython.int, indices: cython.int):
        """Return the variable of a name that holds numbers and has so many indices, else None."""
        if not self.scopes:
            return None
        name = self.names[k]
        found = self.scopes[len(self.scopes) - 1].get(name)
        if found is None:
            found = self.scopes[0].get(name)
        return (
            found if found is not None and len(found.bounds) == indices and found.kind in _NUMERIC else None
        )

    @cython.cfunc
    def has(self, k: cython.int) -> cython.bint:
        """Take the value of a variable as `found`; tell whether it has one."""
        variable = self._variable(k, 0)
        if variable is None:
            return False
        self.found = variable.values[0]
        return True

    @cython.cfunc
    def has_element(self, k: cython.int, index: cython.double) -> cython.bint:
        """Do the same with an element of an array."""
        variable = self._variable(k, 1)
        place: cython.longlong = _place(variable, index)
        if place < 0:
            return False
        self.found = variable.values[place]
        return True

    @cython.cfunc
    def set_variable(self, k: cython.int, value: cython.double) -> cython.bint:
        """Set a variable; tell whether it can be done."""
        return self._put(self._variable(k, 0), k, -1, value)

    @cython.cfunc
    def set_element(self, k: cython.int, index: cython.double, value: cython.double) -> cython.bint:
        """Set an element of an array; tell whether it can be done."""
        variable = self._variable(k, 1)
        place: cython.longlong = _place(variable, index)
        return place >= 0 and self._put(variable, k, place, value)

    @cython.cfunc
    def _put(self, variable, k: cython.int, place: cython.longlong, value: cython.double) -> cython.bint:
        """Set a variable, or its element at a place, and keep its value of before."""
        at: cython.longlong = max(place, 0)
        if variable is None or self.settings == _MOST_SETTINGS or not isfinite(value):
            return False
        if variable.kind == "INT":
            value = _whole(value)
        elif variable.kind == "BOOL":
            value = 1.0 if value != 0.0 else 0.0
        self.target[self.settings] = -1 - k
        self.place[self.settings] = place
        self.value[self.settings] = variable.values[at]
        self.settings += 1
        variable.values[at] = value
        return True

    @cython.cfunc
    def end(self) -> cython.int:
        """Leave a line, whose settings are done."""
        return 0

    @cython.cfunc
    def undo(self) -> cython.int:
        """Give all that a line has set its values of before."""
        while self.settings > 0:
            self.settings -= 1
            k, place = self.target[self.settings], self.place[self.settings]
            if k >= 0:
                self.numbers[k] = self.value[self.settings]
            else:
                self._variable(-1 - k, place >= 0).values[max(place, 0)] = self.value[self.settings]
        return 0

    # Jumps.

    @cython.cfunc
    @cython.exceptval(-2, check=False)
    def goes(
        self,
        r: cython.Py_ssize_t,
        line: cython.longlong,
        jump: cython.int,
        counter: cython.int,
        value: cython.double,
        last: cython.double,
    ) -> cython.int:
        """Tell whether the jump of a row goes to where its `way` leads: 1, 0 for the next line, -1 where that is not certain.

        Args:
            r, line: The row, and the number of its line.
            jump: Which jump.
            counter: Of FOR, the instruction that sets its counter, which `value` begins; `last` ends it.
            value: The condition, or a number of rounds.
        """
        goes: cython.int = 1
        if jump == LEAVES:
            back = self.leave() if self.calls > 0 else None
            if back is None:
                return -1
            self.way, self.loops = back
            self.calls -= 1
            return 1
        way: tuple = self.ways.get(r)
        if way is None:
            way = self.leads(line)
            if way is None:
                return -1
            self.ways[r] = way
        self.way = way
        here = way[0]
        if jump == UNLESS:
            goes = value == 0.0
        elif jump == WHEN:
            goes = value != 0.0
        elif jump == REPEATS:
            goes = self._repeats(here, value)
        elif jump == CALLS:
            loops = self.call(here, way[1])
            if loops is None:
                return -1
            self.loops = loops
            self.calls += 1
        elif jump == COUNTS:
            goes = self._counts(here, counter, value, last)
        if goes > 0 and (jump == GOES or jump == WHEN) and self.loops:
            self.enters(way[1])
        return goes

    @cython.cfunc
    def _repeats(self, here, value: cython.double) -> cython.int:
        """Count the rounds of a call down; tell whether one follows, -1 where their number can be none."""
        left = self.loops.get(here)
        if left is None:
            if not fabs(value) <= _LARGEST:
                return -1
            left = float(round(value))
        if left > 0.0:
            self.loops[here] = left - 1.0
        else:
            self.loops.pop(here, None)
        return left > 0.0

    @cython.cfunc
    def _counts(self, here, counter: cython.int, value: cython.double, last: cython.double) -> cython.int:
        """Count a loop up; tell whether it is beyond its end, -1 where that is not certain."""
        named: cython.bint = (counter & 255) == SET_VARIABLE
        k: cython.int = counter >> 8
        if here in self.loops:
            if named and not self.has(k):
                return -1
            value = (self.found if named else self.numbers[k]) + 1.0
        if not isfinite(last) or not (self.set_variable(k, value) if named else self.set(k, value)):
            return -1
        if value > last:
            self.loops.pop(here, None)
        else:
            self.loops[here] = last
        return value > last


@cython.cfunc
def _place(variable, index: cython.double) -> cython.longlong:
    """Return where an element stands in its array, -1 where the array has none of that index."""
    if variable is None or not fabs(index) <= _LARGEST:
        return -1
    place: cython.longlong = cython.cast(cython.longlong, _whole(index))
    return place if 0 <= place < len(variable.values) else -1


@cython.cfunc
def _whole(value: cython.double) -> cython.double:
    """Return a number as an INT: a half goes away from zero (`sinumerik.expressions.whole`)."""
    return copysign(floor(fabs(value) + 0.5), value) + 0.0
