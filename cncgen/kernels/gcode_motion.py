"""Interpret runs of blocks from the columns of `gcode_scan` into motions: G0 to G3, drilling, and the events between them.

Source: T. R. Kramer, F. M. Proctor and E. Messina, The NIST RS274NGC Interpreter, version 3, NISTIR 6556 (2000), sections
3.5.1 to 3.5.3 and 3.5.16.

The loop stops before a block that it does not take for certain; the interpreter, which knows the whole language and
every error, executes that one.

    words of a block ──► `_Block` (which words, the codes) ─┬► end point ──► centre of an arc ──► a row
                                                            ├► asides: spindle, coolant, dwell, plane
                                                            └► a hole: rows and asides by the letters of its cycle
"""

import cython
from cython.cimports.libc.math import fabs, floor, hypot

if cython.compiled:
    from cython.cimports.cncgen.kernels.arc_centres import centre_from_radius
else:
    from cncgen.kernels.arc_centres import centre_from_radius

#: Places in the array `modes`.
#: SILENT: the sink prints nothing, so comments, changes of mode and asides pass without a text.
#: FREE_SPINDLE: no feed hangs on the spindle. HOLES: the dialect has LinuxCNC's dwell, G80 and cycles. IN_CYCLE: G80 would end one.
#: DIRECTION, MIST, FLOOD: of spindle and coolant. OLD_LEVEL: G98. EXACT: G61.
#: TOOLS: any tool may be changed in. CYCLE, GIVEN: the cycle whose words are kept, and a bit for each (0: none; -1: with words that are not taken here).
MOTION, ABSOLUTE, ARC_ABSOLUTE, PLANE, INVERSE_TIME, SKIP_SLASH, SILENT, FREE_SPINDLE = range(8)
HOLES, IN_CYCLE, DIRECTION, MIST, FLOOD, OLD_LEVEL, EXACT, TOOLS, CYCLE, GIVEN = range(8, 18)
MODES = 18

#: Places in the array `levels`; SYSTEM is the G code of the coordinate system in force, TOOL the one of T; from LEVEL on of the cycle: where the row of holes began, the last dwell, R, P, Q and the bottom.
FEED, RADIUS_TOLERANCE, CENTRE_TOLERANCE, CENTRE_RELATIVE, CENTRE_LIMIT, LEAST_FEED, MOST_FEED = range(7)
SPEED, SYSTEM, TOOL, PECK_CLEARANCE, LEVEL, DWELL, RETRACT, PAUSE, STEP, BOTTOM = range(7, 17)
LEVELS = 17
#: Words of a cycle as bits of `modes[GIVEN]`, in the order of `levels`.
GIVEN_R, GIVEN_P, GIVEN_Q, GIVEN_DEPTH = 1, 2, 4, 8

#: Asides that are no M code by their number: S, G4, the wait of a cycle, exact path around a hole and its end, T.
ASIDE_SPEED, ASIDE_DWELL, ASIDE_PAUSE, ASIDE_EXACT, ASIDE_PATH, ASIDE_TOOL = 1, 2, 10, 11, 12, 13

#: Flags of a block (`gcode_scan`).
_SLASH = cython.declare(cython.int, 1)
_COMMENT = cython.declare(cython.int, 2)
_ACTIVE = cython.declare(cython.int, 4)

#: Larger numbers are faults (`cncgen.gcode.block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e8)

#: The bits and places by names of C.
_GIVEN_R = cython.declare(cython.int, GIVEN_R)
_GIVEN_P = cython.declare(cython.int, GIVEN_P)
_GIVEN_Q = cython.declare(cython.int, GIVEN_Q)
_GIVEN_DEPTH = cython.declare(cython.int, GIVEN_DEPTH)
_SPEED = cython.declare(cython.int, SPEED)
_TOOL = cython.declare(cython.int, TOOL)
_CYCLE = cython.declare(cython.int, CYCLE)
_GIVEN = cython.declare(cython.int, GIVEN)
_LEVEL = cython.declare(cython.int, LEVEL)
_DWELL = cython.declare(cython.int, DWELL)
_RETRACT = cython.declare(cython.int, RETRACT)
_PAUSE = cython.declare(cython.int, PAUSE)
_STEP = cython.declare(cython.int, STEP)
_BOTTOM = cython.declare(cython.int, BOTTOM)
_CLEARANCE = cython.declare(cython.int, PECK_CLEARANCE)
_DIRECTION = cython.declare(cython.int, DIRECTION)
_MIST = cython.declare(cython.int, MIST)
_FLOOD = cython.declare(cython.int, FLOOD)
_HOLES = cython.declare(cython.int, HOLES)
_ASIDE_SPEED = cython.declare(cython.int, ASIDE_SPEED)
_ASIDE_DWELL = cython.declare(cython.int, ASIDE_DWELL)
_ASIDE_PAUSE = cython.declare(cython.int, ASIDE_PAUSE)
_ASIDE_EXACT = cython.declare(cython.int, ASIDE_EXACT)
_ASIDE_PATH = cython.declare(cython.int, ASIDE_PATH)
_ASIDE_TOOL = cython.declare(cython.int, ASIDE_TOOL)
#: Asides of one block beside the waits of its holes, at most.
_MOST_ASIDES = cython.declare(cython.int, 8)
#: Repeats of a hole that are made here.
_MOST_REPEATS = cython.declare(cython.int, 1000)

#: The cycles that are taken, by number: the words that they need as bits, and how long the letters of their moves are.
_NEEDS = cython.declare(cython.int[100])
_PECK_MOVES = cython.declare(cython.int[100])
_LAST_MOVES = cython.declare(cython.int[100])
#: The letters of the moves (`canned_cycles.CYCLES`): those between pecks, those of the end.
_MOVES = cython.declare(cython.uchar[1600])
_number: cython.int
for _number in range(100):
    _NEEDS[_number] = _PECK_MOVES[_number] = _LAST_MOVES[_number] = 0

#: Slots of the words of a block: the nine axes X Y Z A B C U V W, I J K, R, F, and behind those of plain motions S P Q L T.
_AXES = cython.declare(cython.int, 9)
_I = cython.declare(cython.int, 9)
_R = cython.declare(cython.int, 12)
_F = cython.declare(cython.int, 13)
_S = cython.declare(cython.int, 14)
_P = cython.declare(cython.int, 15)
_Q = cython.declare(cython.int, 16)
_L = cython.declare(cython.int, 17)
_T = cython.declare(cython.int, 18)
#: The same as sets of slots, a bit each.
_ANY_AXIS = cython.declare(cython.uint, 0x1FF)
_ANY_OFFSET = cython.declare(cython.uint, 0xE00)
_RADIUS = cython.declare(cython.uint, 1 << 12)
_FEED = cython.declare(cython.uint, 1 << 13)
_ANY_HOLE = cython.declare(cython.uint, 7)
_SPOKEN = cython.declare(cython.uint, 1 << 14)
_WAIT = cython.declare(cython.uint, 1 << 15)
_PECK = cython.declare(cython.uint, 1 << 16)
_TIMES = cython.declare(cython.uint, 1 << 17)
_NEXT = cython.declare(cython.uint, 1 << 18)
_RARE = cython.declare(cython.uint, 31 << 14)
#: Letters that have no slot of their own: G and M.
_CODE = cython.declare(cython.int, 19)
_FUNCTION = cython.declare(cython.int, 20)
_OTHER = cython.declare(cython.int, -1)

#: Slot of the word of each letter from a to z, `_CODE`, `_FUNCTION` or `_OTHER`.
_SLOT = cython.declare(cython.schar[26])
_letter: cython.int
for _letter in range(26):
    _SLOT[_letter] = b"xyzabcuvwijkrfspqltgm".find(97 + _letter)

#: The modes in force, from `modes` and `levels`; `first` and `second` are the columns of the plane's axes, `offsets` the
#: slots of the offsets that an arc in it may have.
_Modes = cython.struct(
    motion=cython.int,
    absolute=cython.bint,
    arc_absolute=cython.bint,
    plane=cython.double,
    first=cython.int,
    second=cython.int,
    offsets=cython.uint,
    inverse_time=cython.bint,
    silent=cython.bint,
    free_spindle=cython.bint,
    holes=cython.bint,
    in_cycle=cython.bint,
    old_level=cython.bint,
    exact=cython.bint,
    tools=cython.bint,
    system=cython.double,
    feed=cython.double,
    radius_tolerance=cython.double,
    centre_tolerance=cython.double,
    centre_relative=cython.double,
    centre_limit=cython.double,
    least_feed=cython.double,
    most_feed=cython.double,
)

#: The words of a block: whether it is plain, which slots they fill, and the codes of its G and M words (-1: none). `rare` tells
#: whether it is more than a motion, G90, G91 or a plane that is in force.
_Block = cython.struct(
    plain=cython.bint,
    given=cython.uint,
    motion=cython.int,
    absolute=cython.int,
    plane_said=cython.bint,
    system_said=cython.bint,
    changes=cython.bint,
    rare=cython.bint,
    plane=cython.int,
    old_level=cython.int,
    spindle=cython.int,
    coolant=cython.int,
    dwells=cython.bint,
    cancels=cython.bint,
    uncompensated=cython.bint,
)

#: The words of a drilling cycle: which of them are given, as bits, where the row of holes began, R, P, Q and the bottom.
_Hole = cython.struct(
    given=cython.int,
    level=cython.double,
    retract=cython.double,
    pause=cython.double,
    step=cython.double,
    depth=cython.double,
)

#: A centre in the plane.
_Centre = cython.struct(x=cython.double, y=cython.double)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _length(first: cython.int) -> cython.int:
    """Return how many letters of moves stand from `first` on."""
    count: cython.int = 0
    while _MOVES[first + count]:
        count += 1
    return count


#: Results of a block: it was made, it is left to the interpreter, or the columns have no room for it.
_MADE = cython.declare(cython.int, 0)
_LEFT = cython.declare(cython.int, 1)
_FULL = cython.declare(cython.int, 2)


@cython.final
@cython.cclass
class Advance:
    """The columns of plain blocks and those of their motions, and the state in force between runs.

    Args:
        blocks: Columns of `gcode_scan.scan`: line, offset, flags, end of the words, letters, values.
        position: Shape (9,), X Y Z A B C U V W in program units and coordinates; moved on.
        modes: Shape (`MODES`,): modal motion 0 to 3, a cycle that is taken or -1; flags; plane 17 to 19; changed.
        levels: Shape (`LEVELS`,): feed, the tolerances of arcs (`cncgen.gcode.codes.arcs`), the feeds that are taken, spindle speed,
            words of the cycle in force; changed.
        motions: Columns that are filled, a row a motion: line and offset of its block; 0 to 3; end point, shape (n, 9);
            feed in force; whether this block gave F; centre in the two axes of the plane, shape (n, 2); turns (signed,
            positive counter-clockwise; 0 for lines).
        asides: Columns of events between motions: the row before which, its kind (`ASIDE_SPEED` …, or the number of the code),
            its value, and the block.

    Attributes:
        rows, asides, events: How many motions, asides, and asides that are events the last run made.
        drilled: How many of the motions are of holes.
        changed: The tool that was changed in last, -1 for none.
        full: Whether the last run ended as a column had no room for the block.
    """

    block_line: cython.const[cython.longlong][::1]
    block_offset: cython.const[cython.longlong][::1]
    block_flags: cython.const[cython.uchar][::1]
    word_end: cython.const[cython.longlong][::1]
    letters: cython.const[cython.uchar][::1]
    values: cython.const[cython.double][::1]
    position: cython.double[::1]
    modes: cython.longlong[::1]
    levels: cython.double[::1]
    line: cython.longlong[::1]
    offset: cython.longlong[::1]
    motion: cython.schar[::1]
    end: cython.double[:, ::1]
    feed: cython.double[::1]
    feed_set: cython.uchar[::1]
    centre: cython.double[:, ::1]
    turns: cython.longlong[::1]
    aside_row: cython.longlong[::1]
    aside_kind: cython.longlong[::1]
    aside_value: cython.double[::1]
    aside_block: cython.longlong[::1]
    rows = cython.declare(cython.Py_ssize_t, visibility="public")
    asides = cython.declare(cython.Py_ssize_t, visibility="public")
    events = cython.declare(cython.Py_ssize_t, visibility="public")
    drilled = cython.declare(cython.Py_ssize_t, visibility="public")
    changed = cython.declare(cython.double, visibility="public")
    full = cython.declare(cython.bint, visibility="public")
    outcome = cython.declare(cython.int)
    force = cython.declare(_Modes)
    block = cython.declare(_Block)
    hole = cython.declare(_Hole)
    word = cython.declare(cython.double[19])
    target = cython.declare(cython.double[9])
    centre_at = cython.declare(_Centre)

    def __init__(self, blocks, position, modes, levels, motions, asides):
        if not cython.compiled:
            self.force, self.block, self.hole, self.centre_at = _Modes(), _Block(), _Hole(), _Centre()
            self.word, self.target = [0.0] * 19, [0.0] * 9
        self.block_line, self.block_offset, self.block_flags = blocks[:3]
        self.word_end, self.letters, self.values = blocks[3:]
        self.position, self.modes, self.levels = position, modes, levels
        self.line, self.offset, self.motion, self.end = motions[:4]
        self.feed, self.feed_set, self.centre, self.turns = motions[4:]
        self.aside_row, self.aside_kind, self.aside_value, self.aside_block = asides

    def take_cycles(self, cycles) -> None:
        """Take the drilling cycles from now on.

        Args:
            cycles: By number, the words that each needs (`GIVEN_P`, `GIVEN_Q`), the letters of its moves between pecks and at the end:
                B the bottom, R, C where the tool clears, L the peck's level, K a clearance above it; capital letters are feeds,
                small ones traverses, p is a wait.
        """
        used: cython.int = 0
        n: cython.int
        for n, (needs, between, last) in cycles.items():
            _NEEDS[n], _PECK_MOVES[n], _LAST_MOVES[n] = needs, used, used + 8
            for k in range(16):
                _MOVES[used + k] = 0
            for k, letter in enumerate(between.encode()):
                _MOVES[used + k] = letter
            for k, letter in enumerate(last.encode()):
                _MOVES[used + 8 + k] = letter
            used += 16

    def run(self, first: cython.Py_ssize_t, last: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Interpret blocks `first` to `last` (not included) while they are taken; return the first block not taken."""
        self._begin()
        passed_over: cython.int = _SLASH if self.modes[SKIP_SLASH] else 0
        left: cython.int = _ACTIVE if self.force.silent else _ACTIVE | _COMMENT
        done: cython.Py_ssize_t = last
        begin: cython.Py_ssize_t
        finish: cython.Py_ssize_t = self.word_end[first - 1] if first > 0 else 0
        b: cython.Py_ssize_t
        for b in range(first, last):
            begin = finish
            finish = self.word_end[b]
            if self.block_flags[b] & passed_over:
                continue
            done = b
            if self.block_flags[b] & left:
                break
            if begin == finish:
                continue
            self._read(begin, finish)
            if not self.block.plain:
                break
            self._make(b)
            if self.outcome != _MADE:
                break
        else:
            done = last
        self.full = self.outcome == _FULL
        self.modes[MOTION] = self.force.motion
        self.modes[ABSOLUTE] = self.force.absolute
        self.modes[PLANE] = cython.cast(cython.longlong, self.force.plane)
        self.modes[OLD_LEVEL] = self.force.old_level
        self.levels[FEED] = self.force.feed
        return done

    @cython.cfunc
    def _begin(self) -> cython.void:
        """Take the state in force from `modes` and `levels`."""
        self.force.motion = self.modes[MOTION]
        self.force.absolute = self.modes[ABSOLUTE]
        self.force.arc_absolute = self.modes[ARC_ABSOLUTE]
        self._choose_plane(self.modes[PLANE])
        self.force.inverse_time = self.modes[INVERSE_TIME]
        self.force.silent = self.modes[SILENT]
        self.force.free_spindle = self.modes[FREE_SPINDLE]
        self.force.holes = self.modes[HOLES]
        self.force.in_cycle = self.modes[IN_CYCLE]
        self.force.old_level = self.modes[OLD_LEVEL]
        self.force.exact = self.modes[EXACT]
        self.force.tools = self.modes[TOOLS] and self.force.silent and self.force.free_spindle
        self.force.system = self.levels[SYSTEM]
        self.force.feed = self.levels[FEED]
        self.force.radius_tolerance = self.levels[RADIUS_TOLERANCE]
        self.force.centre_tolerance = self.levels[CENTRE_TOLERANCE]
        self.force.centre_relative = self.levels[CENTRE_RELATIVE]
        self.force.centre_limit = self.levels[CENTRE_LIMIT]
        self.force.least_feed = self.levels[LEAST_FEED]
        self.force.most_feed = self.levels[MOST_FEED]
        self.rows = self.asides = self.events = self.drilled = 0
        self.changed = -1.0
        self.outcome = _MADE

    @cython.cfunc
    @cython.exceptval(check=False)
    def _choose_plane(self, plane: cython.longlong) -> cython.void:
        """Put a plane in force."""
        self.force.plane = plane
        self.force.first = 2 if plane == 18 else (1 if plane == 19 else 0)
        self.force.second = (self.force.first + 1) % 3
        self.force.offsets = (1 << (_I + self.force.first)) | (1 << (_I + self.force.second))

    # The words of a block.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _read(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.void:
        """Write words `begin` to `end` to their slots, and their description to `block`.

        A block with any other word, with one twice or with a feed out of bounds is not plain.
        """
        self.block = _Block(
            plain=True,
            given=0,
            motion=-1,
            absolute=-1,
            plane_said=False,
            system_said=False,
            changes=False,
            rare=False,
            plane=0,
            old_level=-1,
            spindle=-1,
            coolant=-1,
            dwells=False,
            cancels=False,
            uncompensated=False,
        )
        given: cython.uint = 0
        w: cython.Py_ssize_t
        slot: cython.int
        bit: cython.uint
        value: cython.double
        for w in range(begin, end):
            slot = _SLOT[self.letters[w] - 97]
            value = self.values[w]
            if slot == _CODE:
                self._take_code(value)
            elif slot == _FUNCTION:
                self._take_function(value)
            elif slot == _OTHER:
                self.block.plain = False
            else:
                bit = cython.cast(cython.uint, 1) << slot
                self.block.plain = not given & bit and -_LARGEST <= value <= _LARGEST
                given |= bit
                self.word[slot] = value
            if not self.block.plain:
                return
        self.block.given = given
        if given & _FEED and not self.force.least_feed <= self.word[_F] <= self.force.most_feed:
            self.block.plain = False
        if given & _RARE or self.block.rare:
            self._judge_rare_words()

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _take_code(self, code: cython.double) -> cython.void:
        """Take a G word in: a motion, and if the sink need not know, also distance and plane."""
        if code == 0.0 or code == 1.0 or code == 2.0 or code == 3.0:
            self.block.plain = self.block.motion < 0
            self.block.motion = cython.cast(cython.int, code)
        elif not self.force.silent:
            self.block.plain = False
        elif code == 90.0 or code == 91.0:
            self.block.plain = self.block.absolute < 0
            self.block.absolute = code == 90.0
        elif code == self.force.plane:
            # The plane in force, said again.
            self.block.plain = not self.block.plane_said
            self.block.plane_said = True
        elif code == self.force.system:
            self.block.plain = not self.block.system_said
            self.block.system_said = True
        elif 0.0 < code < 100.0 and code == cython.cast(cython.int, code):
            self._take_rare_code(cython.cast(cython.int, code))
        else:
            self.block.plain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take_rare_code(self, code: cython.int) -> cython.void:
        """Take another G word in, each once: planes, G40 where it ends nothing, G80, cycles, G98, G99, G4."""
        self.block.rare = True
        if 17 <= code <= 19:
            # A cycle has its depth along the normal of the plane that it began in.
            self.block.plain = not self.block.plane_said and self.force.motion <= 3
            self.block.plane_said = True
            self.block.plane = code
        elif code == 40:
            self.block.plain = not self.block.uncompensated
            self.block.uncompensated = True
        elif code == 80:
            self.block.plain = not self.block.cancels and (self.force.holes or not self.force.in_cycle)
            self.block.cancels = True
        elif not self.force.holes:
            self.block.plain = False
        elif code == 4:
            self.block.plain = not self.block.dwells
            self.block.dwells = True
        elif code >= 98:
            self.block.plain = self.block.old_level < 0
            self.block.old_level = code == 98
        else:
            self.block.plain = self.block.motion < 0 and _LAST_MOVES[code] > 0
            self.block.motion = code

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take_function(self, code: cython.double) -> cython.void:
        """Take an M word in: spindle, coolant or tool, where no text of it is wanted."""
        self.block.rare = True
        if code == 3.0 or code == 4.0 or code == 5.0:
            self.block.plain = self.block.spindle < 0 and self.force.silent and self.force.free_spindle
            self.block.spindle = cython.cast(cython.int, code)
        elif code == 7.0 or code == 8.0 or code == 9.0:
            self.block.plain = self.block.coolant < 0 and self.force.silent
            self.block.coolant = cython.cast(cython.int, code)
        elif code == 6.0:
            self.block.plain = not self.block.changes and self.force.tools
            self.block.changes = True
        else:
            self.block.plain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _judge_rare_words(self) -> cython.void:
        """Tell of a block that is more than a motion whether it is plain: each of its words has one use."""
        given: cython.uint = self.block.given
        motion: cython.int = self.block.motion
        needs: cython.int = 0
        plain: cython.bint = self.block.plain
        self.block.rare = True
        if self.block.cancels and motion < 0 and self.force.holes:
            # Beside another motion, G80 says nothing.
            plain = plain and not given & (_ANY_AXIS | _ANY_OFFSET | _RADIUS)
        elif motion < 0:
            motion = self.force.motion
        if motion > 3 and given & _ANY_HOLE:
            needs = _NEEDS[motion]
            if given & (_ANY_OFFSET | (_ANY_AXIS & ~_ANY_HOLE)) or self.block.dwells:
                plain = False
        elif (
            self.block.motion > 3
            or given & _TIMES
            or (motion > 3 and given & (_ANY_AXIS | _ANY_OFFSET | _RADIUS))
        ):
            plain = False
        if given & _SPOKEN and not (self.word[_S] >= 0.0 and self.force.silent and self.force.free_spindle):
            plain = False
        if given & _NEXT and not (
            self.force.tools and 0.0 <= self.word[_T] <= _LARGEST and self.word[_T] == floor(self.word[_T])
        ):
            plain = False
        if given & _WAIT and not (self.block.dwells or needs & _GIVEN_P):
            plain = False
        if given & _PECK and not needs & _GIVEN_Q:
            plain = False
        if self.block.dwells and not (given & _WAIT and self.word[_P] >= 0.0 and motion < 2):
            plain = False
        self.block.plain = plain

    # Motions.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _make(self, b: cython.Py_ssize_t) -> cython.void:
        """Make motions and asides of block b, which is plain; `outcome` tells whether that was done, and nothing changes where not."""
        plane: cython.longlong
        given: cython.uint = self.block.given
        motion: cython.int = self.force.motion
        feed: cython.double = self.word[_F] if given & _FEED else self.force.feed
        # Modes and the feed alone change without a motion, if the sink need not know.
        moves: cython.bint = (
            not self.force.silent or self.block.motion >= 0 or given & ~(_FEED | _SPOKEN | _WAIT | _NEXT) != 0
        )
        if self.block.motion >= 0:
            motion = self.block.motion
        elif self.block.cancels and self.force.holes:
            motion = -1
        if self.block.rare:
            if self.asides + _MOST_ASIDES > self.aside_row.shape[0]:
                self.outcome = _FULL
                return
            if self.block.plane:
                plane = cython.cast(cython.longlong, self.force.plane)
                self._choose_plane(self.block.plane)
                self._move(b, motion, feed, moves)
                if self.outcome != _MADE:
                    self._choose_plane(plane)
                return
        self._move(b, motion, feed, moves)

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _move(
        self, b: cython.Py_ssize_t, motion: cython.int, feed: cython.double, moves: cython.bint
    ) -> cython.void:
        """Make the motion of block b with a motion code and a feed in force."""
        absolute: cython.bint = self.force.absolute if self.block.absolute < 0 else self.block.absolute
        old_level: cython.bint = self.force.old_level if self.block.old_level < 0 else self.block.old_level
        if moves and motion > 3:
            self._holes(b, motion, feed, absolute, old_level)
            if self.outcome != _MADE:
                return
        else:
            if moves:
                if self.rows >= self.line.shape[0]:
                    self.outcome = _FULL
                    return
                if not self._may_move(motion, feed) or not self._aim(motion, absolute):
                    self.outcome = _LEFT
                    return
            if self.block.rare:
                self._say(b)
            if moves:
                self._put(b, motion, feed, self.block.given & _FEED != 0)
        self.force.motion = motion
        self.force.feed = feed
        self.force.absolute = absolute
        self.force.old_level = old_level

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _may_move(self, motion: cython.int, feed: cython.double) -> cython.bint:
        """Tell whether the words of a block are those of its motion, and a feed is in force where it wants one."""
        given: cython.uint = self.block.given
        if motion < 0 or (motion >= 1 and (feed <= 0.0 or (self.force.inverse_time and not given & _FEED))):
            return False
        if motion < 2:
            return given & _ANY_AXIS != 0 and not given & (_ANY_OFFSET | _RADIUS)
        # Offsets along the plane's normal, and centre and radius together, are the interpreter's to judge.
        if self.force.arc_absolute or given & _ANY_OFFSET & ~self.force.offsets:
            return False
        if given & _RADIUS:
            return given & _ANY_AXIS != 0 and not given & _ANY_OFFSET
        return given & _ANY_OFFSET != 0

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _aim(self, motion: cython.int, absolute: cython.bint) -> cython.bint:
        """Find the end of a motion, `target`, and the centre of an arc; tell whether they are certain.

        Axes that the block names go there, or so far where it is incremental; the others stay.
        """
        k: cython.int
        for k in range(_AXES):
            self.target[k] = self.position[k]
            if self.block.given >> k & 1:
                self.target[k] = self.word[k] if absolute else self.position[k] + self.word[k]
        if motion < 2:
            self.centre_at.x = self.centre_at.y = 0.0
            return True
        x0: cython.double = self.position[self.force.first]
        y0: cython.double = self.position[self.force.second]
        x1: cython.double = self.target[self.force.first]
        y1: cython.double = self.target[self.force.second]
        if self.block.given & _RADIUS:
            if self.word[_R] == 0.0 or (x1 == x0 and y1 == y0):
                return False
            found: cython.doublecomplex = centre_from_radius(
                x0, y0, x1, y1, self.word[_R], motion == 2, self.force.radius_tolerance
            )
            self.centre_at.x, self.centre_at.y = found.real, found.imag
            return found.real == found.real
        self.centre_at.x, self.centre_at.y = x0, y0
        if self.block.given & (cython.cast(cython.uint, 1) << (_I + self.force.first)):
            self.centre_at.x += self.word[_I + self.force.first]
        if self.block.given & (cython.cast(cython.uint, 1) << (_I + self.force.second)):
            self.centre_at.y += self.word[_I + self.force.second]
        # It is certain where start and end are on one circle about it, within tolerance.
        start: cython.double = hypot(self.centre_at.x - x0, self.centre_at.y - y0)
        end: cython.double = hypot(self.centre_at.x - x1, self.centre_at.y - y1)
        gap: cython.double = fabs(start - end)
        return (
            start >= self.force.radius_tolerance
            and end >= self.force.radius_tolerance
            and gap <= self.force.centre_limit
            and (gap <= self.force.centre_tolerance or gap <= self.force.centre_relative * max(start, end))
        )

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _put(
        self, b: cython.Py_ssize_t, motion: cython.int, feed: cython.double, feed_set: cython.bint
    ) -> cython.void:
        """Fill the row of a motion of block b to `target`, and stand there."""
        k: cython.int
        row: cython.Py_ssize_t = self.rows
        self.line[row] = self.block_line[b]
        self.offset[row] = self.block_offset[b]
        self.motion[row] = motion
        self.feed[row] = feed
        self.feed_set[row] = feed_set
        self.centre[row, 0] = self.centre_at.x
        self.centre[row, 1] = self.centre_at.y
        self.turns[row] = 0 if motion < 2 else 2 * motion - 5
        for k in range(_AXES):
            self.position[k] = self.target[k]
            self.end[row, k] = self.target[k]
        self.rows = row + 1

    # Asides.

    @cython.cfunc
    @cython.exceptval(check=False)
    def _aside(
        self, b: cython.Py_ssize_t, kind: cython.int, value: cython.double, event: cython.bint
    ) -> cython.void:
        """Fill the row of an aside."""
        self.aside_row[self.asides] = self.rows
        self.aside_kind[self.asides] = kind
        self.aside_value[self.asides] = value
        self.aside_block[self.asides] = b
        self.asides += 1
        self.events += event

    @cython.cfunc
    @cython.exceptval(check=False)
    def _say(self, b: cython.Py_ssize_t) -> cython.void:
        """Make the asides of a block, in the order of execution (`modal.Stage`)."""
        if self.block.given & _SPOKEN:
            self.levels[_SPEED] = self.word[_S]
            self._aside(b, _ASIDE_SPEED, self.word[_S], True)
        if self.block.given & _NEXT:
            self.levels[_TOOL] = self.word[_T]
            self._aside(b, _ASIDE_TOOL, self.word[_T], False)
        if self.block.changes:
            self.modes[_DIRECTION] = 0
            self.changed = self.levels[_TOOL]
            self._aside(b, 6, 0.0, True)
        if self.block.spindle >= 0:
            self.modes[_DIRECTION] = (self.block.spindle == 3) - (self.block.spindle == 4)
            self._aside(b, self.block.spindle, 0.0, True)
        if self.block.coolant >= 0:
            self.modes[_MIST] = (self.modes[_MIST] or self.block.coolant == 7) and self.block.coolant != 9
            self.modes[_FLOOD] = (self.modes[_FLOOD] or self.block.coolant == 8) and self.block.coolant != 9
            self._aside(b, self.block.coolant, 0.0, True)
        if self.block.dwells:
            self._aside(b, _ASIDE_DWELL, self.word[_P], True)
        if self.block.plane:
            self._aside(b, self.block.plane, 0.0, False)

    # Holes (`canned_cycles`).

    @cython.cfunc
    @cython.exceptval(check=False)
    def _holes(
        self,
        b: cython.Py_ssize_t,
        n: cython.int,
        feed: cython.double,
        absolute: cython.bint,
        old_level: cython.bint,
    ) -> cython.void:
        """Make the holes of a block of drilling cycle n."""
        self._take_words(n)
        self.outcome = _LEFT
        times: cython.int = self._times(n, feed)
        top: cython.double = self.hole.retract if absolute else self.hole.level + self.hole.retract
        bottom: cython.double = self.hole.depth if absolute else top + self.hole.depth
        if times == 0 or bottom > top:
            return
        pecks: cython.int = self._pecks(top, bottom, self.hole.step) if _NEEDS[n] & _GIVEN_Q else 0
        if pecks < 0:
            return
        rows: cython.Py_ssize_t = 1 + times * (2 + _length(_LAST_MOVES[n]) + pecks * _length(_PECK_MOVES[n]))
        if rows > self.line.shape[0] // 2 or times + _MOST_ASIDES > self.aside_row.shape[0] // 2:
            return
        if (
            self.rows + rows > self.line.shape[0]
            or self.asides + times + _MOST_ASIDES > self.aside_row.shape[0]
        ):
            self.outcome = _FULL
            return
        self.outcome = _MADE
        self._say(b)
        rows = self.rows
        self._drill(b, n, feed, absolute, old_level, top, bottom, times)
        self.drilled += self.rows - rows
        self.modes[_CYCLE] = n
        self.modes[_GIVEN] = self.hole.given
        self.levels[_LEVEL] = self.hole.level
        self.levels[_RETRACT] = self.hole.retract
        self.levels[_PAUSE] = self.hole.pause
        self.levels[_STEP] = self.hole.step
        self.levels[_BOTTOM] = self.hole.depth
        if self.hole.given & _GIVEN_P:
            self.levels[_DWELL] = self.hole.pause

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take_words(self, n: cython.int) -> cython.void:
        """Take the words of cycle n: those of the row of cycles before, and those of the block."""
        normal: cython.int = 3 - self.force.first - self.force.second
        fresh: cython.bint = self.force.motion <= 3
        self.hole.given = (
            0 if fresh or self.modes[_CYCLE] != n else cython.cast(cython.int, self.modes[_GIVEN])
        )
        self.hole.level = self.position[normal] if fresh else self.levels[_LEVEL]
        self.hole.retract = self.levels[_RETRACT]
        self.hole.pause = self.levels[_PAUSE]
        self.hole.step = self.levels[_STEP]
        self.hole.depth = self.levels[_BOTTOM]
        if self.block.given & _RADIUS:
            self.hole.retract = self.word[_R]
            self.hole.given |= _GIVEN_R
        if self.block.given & _WAIT:
            self.hole.pause = self.word[_P]
            self.hole.given |= _GIVEN_P
        if self.block.given & _PECK:
            self.hole.step = self.word[_Q]
            self.hole.given |= _GIVEN_Q
        if self.block.given >> normal & 1:
            self.hole.depth = self.word[normal]
            self.hole.given |= _GIVEN_DEPTH

    @cython.cfunc
    @cython.exceptval(check=False)
    def _times(self, n: cython.int, feed: cython.double) -> cython.int:
        """Return how often the block makes its hole; 0 where it is left to the interpreter."""
        given: cython.uint = self.block.given
        needs: cython.int = _NEEDS[n] | _GIVEN_R | _GIVEN_DEPTH
        if self.modes[_CYCLE] < 0 or self.hole.given & needs != needs or not given & _ANY_HOLE:
            return 0
        if self.force.inverse_time or feed <= 0.0 or given & (_ANY_OFFSET | (_ANY_AXIS & ~_ANY_HOLE)):
            return 0
        if self.hole.given & _GIVEN_P and self.hole.pause < 0.0:
            return 0
        if not given & _TIMES:
            return 1
        if not 1.0 <= self.word[_L] <= _MOST_REPEATS:
            return 0
        times: cython.int = cython.cast(cython.int, self.word[_L])
        return times if times == self.word[_L] else 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _pecks(self, top: cython.double, bottom: cython.double, step: cython.double) -> cython.int:
        """Return how many pecks lead from R to the bottom, beside the last; -1 where they are no few."""
        pecks: cython.int = 0
        if step <= 0.0:
            return -1
        top -= step
        while top > bottom:
            top -= step
            pecks += 1
            if pecks > _MOST_REPEATS:
                return -1
        return pecks

    @cython.cfunc
    @cython.exceptval(check=False)
    def _drill(
        self,
        b: cython.Py_ssize_t,
        n: cython.int,
        feed: cython.double,
        absolute: cython.bint,
        old_level: cython.bint,
        top: cython.double,
        bottom: cython.double,
        times: cython.int,
    ) -> cython.void:
        """Make a hole so many times: across, down to R, and the moves of its cycle."""
        normal: cython.int = 3 - self.force.first - self.force.second
        clear: cython.double = max(self.hole.level, top) if old_level else top
        place: cython.double
        high: cython.double
        k: cython.int
        if self.hole.level < top:
            self._along(b, feed, normal, top, False)
        if not self.force.exact:
            self._aside(b, _ASIDE_EXACT, 0.0, False)
        for _ in range(times):
            high = max(self.position[normal], clear)
            for k in (self.force.first, self.force.second):
                if self.block.given >> k & 1:
                    self.position[k] = self.word[k] if absolute else self.position[k] + self.word[k]
            self._along(b, feed, normal, high, False)
            if high != top:
                self._along(b, feed, normal, top, False)
            if _MOVES[_PECK_MOVES[n]]:
                place = top - self.hole.step
                while place > bottom:
                    self._moves(b, feed, _PECK_MOVES[n], top, bottom, clear, place)
                    place -= self.hole.step
            self._moves(b, feed, _LAST_MOVES[n], top, bottom, clear, bottom)
        if not self.force.exact:
            self._aside(b, _ASIDE_PATH, 0.0, False)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _moves(
        self,
        b: cython.Py_ssize_t,
        feed: cython.double,
        first: cython.int,
        top: cython.double,
        bottom: cython.double,
        clear: cython.double,
        place: cython.double,
    ) -> cython.void:
        """Make the moves whose letters stand from `first` on (`take_cycles`)."""
        c: cython.int
        lower: cython.int
        to: cython.double
        normal: cython.int = 3 - self.force.first - self.force.second
        while _MOVES[first]:
            c = _MOVES[first]
            lower = c | 32
            first += 1
            if c == 112:
                self._aside(b, _ASIDE_PAUSE, self.hole.pause, True)
                continue
            to = bottom
            if lower == 114:
                to = top
            elif lower == 99:
                to = clear
            elif lower == 108:
                to = place
            elif lower == 107:
                to = place + self.levels[_CLEARANCE]
            self._along(b, feed, normal, to, c != lower)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _along(
        self,
        b: cython.Py_ssize_t,
        feed: cython.double,
        normal: cython.int,
        level: cython.double,
        feeds: cython.bint,
    ) -> cython.void:
        """Fill the row of a straight motion from where the tool stands along the normal."""
        k: cython.int
        for k in range(_AXES):
            self.target[k] = self.position[k]
        self.target[normal] = level
        self.centre_at.x = self.centre_at.y = 0.0
        self._put(b, feeds, feed, False)
