"""The parameters that lines of G-code read and set while `gcode_run` runs them: a setting acts at the end of its line."""

import cython
from cython.cimports.libc.math import fabs, floor

#: Settings of a line, at most.
_MOST_SETTINGS = cython.declare(cython.int, 40)
#: How far from a whole number the number of a parameter may be (`flow.o_words`).
_WHOLE = cython.declare(cython.double, 1e-4)
#: The sort of names that cannot be set; 0 and 1 are those of the call in progress and of all.
_RESERVED = cython.declare(cython.int, 2)


@cython.cclass
class Store:
    """Numbered and named parameters.

    Args:
        numbers: Numbered parameters by number, an array of doubles, read and set.
        named: Global parameters by name, read and set.
        reserved: Names that cannot be set.
        storage: Parameters below this are plain storage; the others belong to the machine.

    Attributes:
        names: The names by their number in the code.
        local: The named parameters of the call in progress.
        settings: How many settings the line has.
        found: The value that `has` has found.
        ways: Where jumps lead, by what tells them apart (`gcode_run`, `gcode_rows`).
        calls: How many calls are in progress that the store follows, as those of languages.
        returned: Whether a subroutine has returned to here, and `result`, the value that it gave, NaN for none: `settle` puts that
            into the parameters that tell of it.
    """

    def __init__(self, numbers, named: dict, reserved: frozenset, storage: int):
        self.numbers, self.named, self.local = numbers, named, {}
        self.reserved, self.storage = reserved, storage
        self.names, self.sorts = [], bytearray()
        self.target = memoryview(bytearray(8 * _MOST_SETTINGS)).cast("q")
        self.value = memoryview(bytearray(8 * _MOST_SETTINGS)).cast("d")
        self.ways, self.settings, self.calls = {}, 0, 0
        self.returned, self.result = False, 0.0

    @cython.cfunc
    @cython.exceptval(check=False)
    def index(self, value: cython.double) -> cython.int:
        """Return the number of a parameter; -1 unless it is plain storage."""
        whole: cython.double = floor(value + 0.5)
        if fabs(value - whole) > _WHOLE or not 0.0 < whole < self.storage:
            return -1
        return cython.cast(cython.int, whole)

    @cython.cfunc
    @cython.exceptval(check=False)
    def set(self, k: cython.int, value: cython.double) -> cython.bint:
        """Set a parameter; tell whether it can be done."""
        if self.settings == _MOST_SETTINGS:
            return False
        self.target[self.settings], self.value[self.settings] = k, value
        self.settings += 1
        return True

    @cython.cfunc
    def _sort(self, k: cython.int) -> cython.int:
        """Return of which sort a name is."""
        while len(self.sorts) <= k:
            name: str = self.names[len(self.sorts)]
            self.sorts.append(_RESERVED if name in self.reserved else name.startswith("_"))
        return self.sorts[k]

    @cython.cfunc
    def has(self, k: cython.int) -> cython.bint:
        """Take the value of a named parameter as `found`; tell whether it has one.

        Parameters that tell the machine's state are not stored, so they are not found.
        """
        if self.returned:
            self.settle()
        value = (self.named if self._sort(k) else self.local).get(self.names[k])
        if value is None:
            return False
        self.found = value
        return True

    @cython.cfunc
    def set_variable(self, k: cython.int, value: cython.double) -> cython.bint:
        """Set a named parameter; tell whether it can be done."""
        return self._sort(k) != _RESERVED and self.set(-1 - k, value)

    @cython.cfunc
    def end(self) -> cython.int:
        """Do the settings of a line."""
        k: cython.int
        name: cython.longlong
        if self.returned:
            self.settle()
        for k in range(self.settings):
            name = -1 - self.target[k]
            if name < 0:
                self.numbers[self.target[k]] = self.value[k]
            else:
                (self.named if self.sorts[name] else self.local)[self.names[name]] = self.value[k]
        return 0

    @cython.cfunc
    def settle(self) -> cython.int:
        """Set what the last subroutine has returned: most programs do not ask for it at each call."""
        given: cython.bint = self.result == self.result
        self.named["_value"] = self.result if given else 0.0
        self.named["_value_returned"] = 1.0 if given else 0.0
        self.returned = False
        return 0

    @cython.cfunc
    def undo(self) -> cython.int:
        """Take back what a line has set."""
        self.settings = 0
        return 0
