# cython: infer_types=True
"""The words of a block, read from the columns of `gcode_scan`, and the modes under which they are: which are given, what their codes say,
and whether each of them is certain.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    ABSOLUTE, ANY_AXIS, ANY_HOLE, ANY_OFFSET, ARC_ABSOLUTE, CENTRE_LIMIT, CENTRE_RELATIVE, CENTRE_TOLERANCE, EXACT, FEED,
    FREE_SPINDLE, GIVEN_P, GIVEN_Q, HOLES, INVERSE_TIME, IN_CYCLE, LEAST_FEED, MOST_FEED, MOTION, OLD_LEVEL, PLANE,
    RADIUS_TOLERANCE, RARE, SILENT, SLOT_F, SLOT_G, SLOT_I, SLOT_M, SLOT_P, SLOT_S, SLOT_T, SYSTEM, TOOLS, WITH_F, WITH_L, WITH_P,
    WITH_Q, WITH_R, WITH_S, WITH_T,
)  # fmt: skip
from cython.cimports.libc.math import floor

#: Larger numbers are faults (`cncgen.gcode.block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e8)

#: Slot of the word of each letter from a to z, -1 for none.
_SLOT = cython.declare(cython.schar[26])
#: The cycles that are taken, by number: the words that they need as bits, and whether they are.
_NEEDS = cython.declare(cython.int[100])
_TAKEN = cython.declare(cython.bint[100])


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the table of letters, once."""
    k: cython.int
    for k in range(26):
        _SLOT[k] = b"xyzabcuvwijkrfspqltgm".find(97 + k)
    for k in range(100):
        _NEEDS[k], _TAKEN[k] = 0, False


_fill_tables()


@cython.ccall
@cython.exceptval(check=False)
def take_cycle(number: cython.int, needs: cython.int) -> cython.void:
    """Take a drilling cycle from now on, which needs words (`GIVEN_P`, `GIVEN_Q`) beside R and the depth."""
    _NEEDS[number], _TAKEN[number] = needs, True


@cython.ccall
@cython.exceptval(check=False)
def needs_of(number: cython.int) -> cython.int:
    """Return the words that a drilling cycle needs."""
    return _NEEDS[number]


@cython.final
@cython.cclass
class Modes:
    """The modes in force. `first` and `second` are the columns of the plane's axes, `offsets` the slots of the offsets that an arc in it may
    have.
    """

    @cython.cfunc
    @cython.exceptval(check=False)
    def take(self, modes: cython.longlong[::1], levels: cython.double[::1]) -> cython.void:
        """Take the state in force from the arrays of `gcode_motion.Advance`."""
        self.motion = modes[MOTION]
        self.absolute = modes[ABSOLUTE]
        self.arc_absolute = modes[ARC_ABSOLUTE]
        self.choose_plane(modes[PLANE])
        self.inverse_time = modes[INVERSE_TIME]
        self.silent = modes[SILENT]
        self.free_spindle = modes[FREE_SPINDLE]
        self.holes = modes[HOLES]
        self.in_cycle = modes[IN_CYCLE]
        self.old_level = modes[OLD_LEVEL]
        self.exact = modes[EXACT]
        self.tools = modes[TOOLS] and self.silent and self.free_spindle
        self.system = levels[SYSTEM]
        self.feed = levels[FEED]
        self.radius_tolerance = levels[RADIUS_TOLERANCE]
        self.centre_tolerance = levels[CENTRE_TOLERANCE]
        self.centre_relative = levels[CENTRE_RELATIVE]
        self.centre_limit = levels[CENTRE_LIMIT]
        self.least_feed = levels[LEAST_FEED]
        self.most_feed = levels[MOST_FEED]

    @cython.cfunc
    @cython.exceptval(check=False)
    def choose_plane(self, plane: cython.longlong) -> cython.void:
        """Put a plane in force."""
        self.plane = plane
        self.first = 2 if plane == 18 else (1 if plane == 19 else 0)
        self.second = (self.first + 1) % 3
        self.offsets = (1 << (SLOT_I + self.first)) | (1 << (SLOT_I + self.second))


@cython.final
@cython.cclass
class BlockWords:
    """The words of a block: whether it is plain, which slots they fill, and the codes of its G and M words (-1: none).

    `rare` tells whether it is more than a motion, G90, G91 or a plane that is in force.

    Args:
        letters, values: The columns.
    """

    def __init__(self, letters, values):
        if not cython.compiled:
            self.word = [0.0] * 19
        self.letters, self.values = letters, values

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def read(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t, force: Modes) -> cython.void:
        """Take words `begin` to `end` of the columns, under the modes in force.

        A block with any other word, with one twice or with a feed out of bounds is not plain.
        """
        self.plain = True
        self.given = 0
        self.motion = self.absolute = self.old_level = self.spindle = self.coolant = -1
        self.plane = 0
        self.plane_said = self.system_said = self.changes = self.rare = False
        self.dwells = self.cancels = self.uncompensated = False
        given: cython.uint = 0
        slot: cython.int
        for w in range(begin, end):
            slot = _SLOT[self.letters[w] - 97]
            value = self.values[w]
            if slot == SLOT_G:
                self._take_code(value, force)
            elif slot == SLOT_M:
                self._take_function(value, force)
            elif slot < 0:
                self.plain = False
            else:
                bit = cython.cast(cython.uint, 1) << slot
                self.plain = not given & bit and -_LARGEST <= value <= _LARGEST
                given |= bit
                self.word[slot] = value
            if not self.plain:
                return
        self.given = given
        if given & WITH_F and not force.least_feed <= self.word[SLOT_F] <= force.most_feed:
            self.plain = False
        if given & RARE or self.rare:
            self._judge_rare_words(force)

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _take_code(self, code: cython.double, force: Modes) -> cython.void:
        """Take a G word in: a motion, and if the sink need not know, also distance and plane."""
        if code == 0.0 or code == 1.0 or code == 2.0 or code == 3.0:
            self.plain = self.motion < 0
            self.motion = cython.cast(cython.int, code)
        elif not force.silent:
            self.plain = False
        elif code == 90.0 or code == 91.0:
            self.plain = self.absolute < 0
            self.absolute = code == 90.0
        elif code == force.plane:
            # The plane in force, said again.
            self.plain = not self.plane_said
            self.plane_said = True
        elif code == force.system:
            self.plain = not self.system_said
            self.system_said = True
        elif 0.0 < code < 100.0 and code == cython.cast(cython.int, code):
            self._take_rare_code(cython.cast(cython.int, code), force)
        else:
            self.plain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take_rare_code(self, code: cython.int, force: Modes) -> cython.void:
        """Take another G word in, each once: planes, G40 where it ends nothing, G80, cycles, G98, G99, G4."""
        self.rare = True
        if 17 <= code <= 19:
            # A cycle has its depth along the normal of the plane that it began in.
            self.plain = not self.plane_said and force.motion <= 3
            self.plane_said = True
            self.plane = code
        elif code == 40:
            self.plain = not self.uncompensated
            self.uncompensated = True
        elif code == 80:
            self.plain = not self.cancels and (force.holes or not force.in_cycle)
            self.cancels = True
        elif not force.holes:
            self.plain = False
        elif code == 4:
            self.plain = not self.dwells
            self.dwells = True
        elif code >= 98:
            self.plain = self.old_level < 0
            self.old_level = code == 98
        else:
            self.plain = self.motion < 0 and _TAKEN[code]
            self.motion = code

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take_function(self, code: cython.double, force: Modes) -> cython.void:
        """Take an M word in: spindle, coolant or tool, where no text of it is wanted."""
        self.rare = True
        if code == 3.0 or code == 4.0 or code == 5.0:
            self.plain = self.spindle < 0 and force.silent and force.free_spindle
            self.spindle = cython.cast(cython.int, code)
        elif code == 7.0 or code == 8.0 or code == 9.0:
            self.plain = self.coolant < 0 and force.silent
            self.coolant = cython.cast(cython.int, code)
        elif code == 6.0:
            self.plain = not self.changes and force.tools
            self.changes = True
        else:
            self.plain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _judge_rare_words(self, force: Modes) -> cython.void:
        """Tell of a block that is more than a motion whether it is plain: each of its words has one use."""
        self.rare = True
        # Beside another motion, G80 says nothing.
        ends: cython.bint = self.cancels and self.motion < 0 and force.holes
        motion: cython.int = -1 if ends else (self.motion if self.motion >= 0 else force.motion)
        drills: cython.bint = motion > 3 and self.given & ANY_HOLE
        if self.given & self._unused(motion, ends, drills, force) or (self.motion > 3 and not drills):
            self.plain = False
        if self.given & WITH_S and not self.word[SLOT_S] >= 0.0:
            self.plain = False
        if self.given & WITH_T and not (
            0.0 <= self.word[SLOT_T] <= _LARGEST and self.word[SLOT_T] == floor(self.word[SLOT_T])
        ):
            self.plain = False
        if self.dwells and not (self.given & WITH_P and self.word[SLOT_P] >= 0.0 and motion < 2):
            self.plain = False

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _unused(
        self, motion: cython.int, ends: cython.bint, drills: cython.bint, force: Modes
    ) -> cython.uint:
        """Return the words that nothing in the block has a use for: under a motion in force, which G80 `ends`, or which `drills` a hole."""
        needs: cython.int = _NEEDS[motion] if drills else 0
        words: cython.uint = ANY_OFFSET | (ANY_AXIS & ~ANY_HOLE) if drills else WITH_L
        if not drills and (ends or motion > 3):
            words |= ANY_AXIS | ANY_OFFSET | WITH_R
        if not (self.dwells or needs & GIVEN_P):
            words |= WITH_P
        if not needs & GIVEN_Q:
            words |= WITH_Q
        if not (force.silent and force.free_spindle):
            words |= WITH_S
        return words if force.tools else words | WITH_T
