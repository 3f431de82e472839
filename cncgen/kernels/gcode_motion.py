# cython: infer_types=True
"""Interpret runs of blocks from the columns of `gcode_scan` into motions: G0 to G3, drilling, and the events between them.

Source: T. R. Kramer, F. M. Proctor and E. Messina, The NIST RS274NGC Interpreter, version 3, NISTIR 6556 (2000), sections
3.5.1 to 3.5.3 and 3.5.16.

The loop stops before a block that it does not take for certain; the interpreter, which knows the whole language and
every error, executes that one.

    words of a block ──► `BlockWords`, under the `Modes` ─┬► end point ──► centre of an arc ──► a row
                                                          ├► asides: spindle, coolant, dwell, plane
                                                          └► a hole: rows and asides by the letters of its cycle
"""

import cython
from cython.cimports.cncgen.kernels.arc_centres import centre_from_radius
from cython.cimports.cncgen.kernels.gcode_codes import (
    ABSOLUTE, ANY_AXIS, ANY_HOLE, ANY_OFFSET, ANY_ROTARY, ASIDE_DWELL, ASIDE_EXACT, ASIDE_PATH, ASIDE_PAUSE, ASIDE_SPEED, ASIDE_TOOL, BOTTOM,
    CYCLE, DIRECTION, DWELL, FEED, FLOOD, GIVEN, GIVEN_DEPTH, GIVEN_P, GIVEN_Q, GIVEN_R, LEVEL, MIST, MOTION, OLD_LEVEL, PAUSE,
    PECK_CLEARANCE, PLANE, RETRACT, SKIP_SLASH, SLOT_F, SLOT_I, SLOT_L, SLOT_P, SLOT_Q, SLOT_R, SLOT_S, SLOT_T, SPEED, STEP, TOOL,
    WITH_F, WITH_L, WITH_P, WITH_Q, WITH_R, WITH_S, WITH_T,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_words import BlockWords, Modes, needs_of, take_cycle
from cython.cimports.libc.math import fabs, hypot

#: Flags of a block (`gcode_scan`).
_SLASH = cython.declare(cython.int, 1)
_COMMENT = cython.declare(cython.int, 2)
_ACTIVE = cython.declare(cython.int, 4)

#: Asides of one block beside the waits of its holes, at most.
_MOST_ASIDES = cython.declare(cython.int, 8)
#: A way of X Y Z that is less than this part of the turn beside it may leave them next to no feed.
_CREEP = cython.declare(cython.double, 1e-6)
#: Repeats of a hole that are made here.
_MOST_REPEATS = cython.declare(cython.int, 1000)

#: The cycles that are taken, by number: where the letters of their moves stand.
_PECK_MOVES = cython.declare(cython.int[100])
_LAST_MOVES = cython.declare(cython.int[100])
#: The letters of the moves (`canned_cycles.CYCLES`): those between pecks, those of the end.
_MOVES = cython.declare(cython.uchar[1600])
_number: cython.int
for _number in range(100):
    _PECK_MOVES[_number] = _LAST_MOVES[_number] = 0

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
        waited: For how long blocks with G4 dwell, s.
        changed: The tool that was changed in last, -1 for none.
        reach: The largest number of a place or a centre, of either sign.
        turn: The longest way of A, B or C in a motion.
        creeps: Whether a line turns an axis while X Y Z (else U V W) move by less than a millionth of that.
        full: Whether the last run ended as a column had no room for the block.
    """

    block_line: cython.const[cython.longlong][::1]
    block_offset: cython.const[cython.longlong][::1]
    block_flags: cython.const[cython.uchar][::1]
    word_end: cython.const[cython.longlong][::1]
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
    waited = cython.declare(cython.double, visibility="public")
    changed = cython.declare(cython.double, visibility="public")
    reach = cython.declare(cython.double, visibility="public")
    turn = cython.declare(cython.double, visibility="public")
    creeps = cython.declare(cython.bint, visibility="public")
    full = cython.declare(cython.bint, visibility="public")
    outcome = cython.declare(cython.int)
    force = cython.declare(Modes)
    block = cython.declare(BlockWords)
    hole = cython.declare(_Hole)
    target = cython.declare(cython.double[9])
    centre_at = cython.declare(_Centre)

    def __init__(self, blocks, position, modes, levels, motions, asides):
        if not cython.compiled:
            self.hole, self.centre_at, self.target = _Hole(), _Centre(), [0.0] * 9
        self.block_line, self.block_offset, self.block_flags = blocks[:3]
        self.word_end = blocks[3]
        self.force, self.block = Modes(), BlockWords(blocks[4], blocks[5])
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
            take_cycle(n, needs)
            _PECK_MOVES[n], _LAST_MOVES[n] = used, used + 8
            for k in range(16):
                _MOVES[used + k] = 0
            for k, letter in enumerate(between.encode()):
                _MOVES[used + k] = letter
            for k, letter in enumerate(last.encode()):
                _MOVES[used + 8 + k] = letter
            used += 16

    def run(self, first: cython.Py_ssize_t, last: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Interpret blocks `first` to `last` (not included) while they are taken; return the first block not taken."""
        self.force.take(self.modes, self.levels)
        self.rows = self.asides = self.events = self.drilled = 0
        self.changed = -1.0
        self.reach = self.waited = self.turn = 0.0
        self.creeps = False
        for k in range(SLOT_I):
            self.reach = max(self.reach, fabs(self.position[k]))
        self.outcome = _MADE
        passed_over: cython.int = _SLASH if self.modes[SKIP_SLASH] else 0
        left: cython.int = _ACTIVE if self.force.silent else _ACTIVE | _COMMENT
        done: cython.Py_ssize_t = last
        finish: cython.Py_ssize_t = self.word_end[first - 1] if first > 0 else 0
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
            self.block.read(begin, finish, self.force)
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

    # Motions.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _make(self, b: cython.Py_ssize_t) -> cython.void:
        """Make motions and asides of block b, which is plain; `outcome` tells whether that was done, and nothing changes where not."""
        given: cython.uint = self.block.given
        motion: cython.int = self.force.motion
        feed: cython.double = self.block.word[SLOT_F] if given & WITH_F else self.force.feed
        # Modes and the feed alone change without a motion, if the sink need not know.
        moves: cython.bint = (
            not self.force.silent
            or self.block.motion >= 0
            or given & ~(WITH_F | WITH_S | WITH_P | WITH_T) != 0
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
                self.force.choose_plane(self.block.plane)
                self._move(b, motion, feed, moves)
                if self.outcome != _MADE:
                    self.force.choose_plane(plane)
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
                self._put(b, motion, feed, self.block.given & WITH_F != 0)
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
        if motion < 0 or (motion >= 1 and (feed <= 0.0 or (self.force.inverse_time and not given & WITH_F))):
            return False
        if motion < 2:
            return given & ANY_AXIS != 0 and not given & (ANY_OFFSET | WITH_R)
        # Offsets along the plane's normal, and centre and radius together, are the interpreter's to judge.
        if self.force.arc_absolute or given & ANY_OFFSET & ~self.force.offsets:
            return False
        if given & WITH_R:
            return given & ANY_AXIS != 0 and not given & ANY_OFFSET
        return given & ANY_OFFSET != 0

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _aim(self, motion: cython.int, absolute: cython.bint) -> cython.bint:
        """Find the end of a motion, `target`, and the centre of an arc; tell whether they are certain.

        Axes that the block names go there, or so far where it is incremental; the others stay.
        """
        named: cython.uint = self.block.given & ANY_AXIS
        k: cython.int
        for k in range(SLOT_I):
            self.target[k] = self.position[k]
        k = 0
        while named:
            if named & 1:
                self.target[k] = self.block.word[k] if absolute else self.position[k] + self.block.word[k]
                self.reach = max(self.reach, fabs(self.target[k]))
            named >>= 1
            k += 1
        if motion < 2:
            self.centre_at.x = self.centre_at.y = 0.0
            return True
        x0: cython.double = self.position[self.force.first]
        y0: cython.double = self.position[self.force.second]
        x1: cython.double = self.target[self.force.first]
        y1: cython.double = self.target[self.force.second]
        if self.block.given & WITH_R:
            if self.block.word[SLOT_R] == 0.0 or (x1 == x0 and y1 == y0):
                return False
            found: cython.doublecomplex = centre_from_radius(
                x0, y0, x1, y1, self.block.word[SLOT_R], motion == 2, self.force.radius_tolerance
            )
            self.centre_at.x, self.centre_at.y = found.real, found.imag
            return found.real == found.real
        self.centre_at.x, self.centre_at.y = x0, y0
        if self.block.given & (cython.cast(cython.uint, 1) << (SLOT_I + self.force.first)):
            self.centre_at.x += self.block.word[SLOT_I + self.force.first]
        if self.block.given & (cython.cast(cython.uint, 1) << (SLOT_I + self.force.second)):
            self.centre_at.y += self.block.word[SLOT_I + self.force.second]
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
        if motion > 1:
            self.reach = max(self.reach, fabs(self.centre_at.x), fabs(self.centre_at.y))
        self.turns[row] = 0 if motion < 2 else 2 * motion - 5
        if self.block.given & ANY_ROTARY:
            turn: cython.double = 0.0
            way: cython.double = 0.0
            for k in range(3, 6):
                turn = max(turn, fabs(self.target[k] - self.position[k]))
            for k in range(3):
                way = max(way, fabs(self.target[k] - self.position[k]))
            if way == 0.0:
                for k in range(6, 9):
                    way = max(way, fabs(self.target[k] - self.position[k]))
            self.turn = max(self.turn, turn)
            self.creeps = self.creeps or (motion == 1 and 0.0 < way < _CREEP * turn)
        for k in range(SLOT_I):
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
        if self.block.given & WITH_S:
            self.levels[SPEED] = self.block.word[SLOT_S]
            self._aside(b, ASIDE_SPEED, self.block.word[SLOT_S], True)
        if self.block.given & WITH_T:
            self.levels[TOOL] = self.block.word[SLOT_T]
            self._aside(b, ASIDE_TOOL, self.block.word[SLOT_T], False)
        if self.block.changes:
            self.modes[DIRECTION] = 0
            self.changed = self.levels[TOOL]
            self._aside(b, 6, 0.0, True)
        if self.block.spindle >= 0:
            self.modes[DIRECTION] = (self.block.spindle == 3) - (self.block.spindle == 4)
            self._aside(b, self.block.spindle, 0.0, True)
        if self.block.coolant >= 0:
            self.modes[MIST] = (self.modes[MIST] or self.block.coolant == 7) and self.block.coolant != 9
            self.modes[FLOOD] = (self.modes[FLOOD] or self.block.coolant == 8) and self.block.coolant != 9
            self._aside(b, self.block.coolant, 0.0, True)
        if self.block.dwells:
            self.waited += self.block.word[SLOT_P]
            self._aside(b, ASIDE_DWELL, self.block.word[SLOT_P], True)
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
        pecks: cython.int = self._pecks(top, bottom, self.hole.step) if needs_of(n) & GIVEN_Q else 0
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
        self.modes[CYCLE] = n
        self.modes[GIVEN] = self.hole.given
        self.levels[LEVEL] = self.hole.level
        self.levels[RETRACT] = self.hole.retract
        self.levels[PAUSE] = self.hole.pause
        self.levels[STEP] = self.hole.step
        self.levels[BOTTOM] = self.hole.depth
        if self.hole.given & GIVEN_P:
            self.levels[DWELL] = self.hole.pause

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take_words(self, n: cython.int) -> cython.void:
        """Take the words of cycle n: those of the row of cycles before, and those of the block."""
        normal: cython.int = 3 - self.force.first - self.force.second
        fresh: cython.bint = self.force.motion <= 3
        self.hole.given = 0 if fresh or self.modes[CYCLE] != n else cython.cast(cython.int, self.modes[GIVEN])
        self.hole.level = self.position[normal] if fresh else self.levels[LEVEL]
        self.hole.retract = self.levels[RETRACT]
        self.hole.pause = self.levels[PAUSE]
        self.hole.step = self.levels[STEP]
        self.hole.depth = self.levels[BOTTOM]
        if self.block.given & WITH_R:
            self.hole.retract = self.block.word[SLOT_R]
            self.hole.given |= GIVEN_R
        if self.block.given & WITH_P:
            self.hole.pause = self.block.word[SLOT_P]
            self.hole.given |= GIVEN_P
        if self.block.given & WITH_Q:
            self.hole.step = self.block.word[SLOT_Q]
            self.hole.given |= GIVEN_Q
        if self.block.given >> normal & 1:
            self.hole.depth = self.block.word[normal]
            self.hole.given |= GIVEN_DEPTH

    @cython.cfunc
    @cython.exceptval(check=False)
    def _times(self, n: cython.int, feed: cython.double) -> cython.int:
        """Return how often the block makes its hole; 0 where it is left to the interpreter."""
        given: cython.uint = self.block.given
        needs: cython.int = needs_of(n) | GIVEN_R | GIVEN_DEPTH
        if self.modes[CYCLE] < 0 or self.hole.given & needs != needs or not given & ANY_HOLE:
            return 0
        if self.force.inverse_time or feed <= 0.0 or given & (ANY_OFFSET | (ANY_AXIS & ~ANY_HOLE)):
            return 0
        if self.hole.given & GIVEN_P and self.hole.pause < 0.0:
            return 0
        if not given & WITH_L:
            return 1
        if not 1.0 <= self.block.word[SLOT_L] <= _MOST_REPEATS:
            return 0
        times: cython.int = cython.cast(cython.int, self.block.word[SLOT_L])
        return times if times == self.block.word[SLOT_L] else 0

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
        if self.hole.level < top:
            self._along(b, feed, normal, top, False)
        if not self.force.exact:
            self._aside(b, ASIDE_EXACT, 0.0, False)
        for _ in range(times):
            high = max(self.position[normal], clear)
            for k in (self.force.first, self.force.second):
                if self.block.given >> k & 1:
                    self.position[k] = (
                        self.block.word[k] if absolute else self.position[k] + self.block.word[k]
                    )
                    self.reach = max(self.reach, fabs(self.position[k]))
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
            self._aside(b, ASIDE_PATH, 0.0, False)

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
        normal: cython.int = 3 - self.force.first - self.force.second
        while _MOVES[first]:
            c = _MOVES[first]
            lower = c | 32
            first += 1
            if c == 112:
                self._aside(b, ASIDE_PAUSE, self.hole.pause, True)
                continue
            to = bottom
            if lower == 114:
                to = top
            elif lower == 99:
                to = clear
            elif lower == 108:
                to = place
            elif lower == 107:
                to = place + self.levels[PECK_CLEARANCE]
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
        for k in range(SLOT_I):
            self.target[k] = self.position[k]
        self.target[normal] = level
        self.reach = max(self.reach, fabs(level))
        self.centre_at.x = self.centre_at.y = 0.0
        self._put(b, feeds, feed, False)
