"""Interpret runs of plain motion blocks (G0 to G3, axis words, F) from the columns of `gcode_scan` into motions.

Source: T. R. Kramer, F. M. Proctor and E. Messina, The NIST RS274NGC Interpreter, version 3, NISTIR 6556 (2000), sections
3.5.1 to 3.5.3.

The loop stops before a block that it does not take for certain; the interpreter, which knows the whole language and
every error, executes that one.

    words of a block ──► `_Block` (which words, the codes) ──► end point ──► centre of an arc ──► a row
"""

import cython
from cython.cimports.libc.math import asin, atan2, cos, fabs, hypot, sin

#: Places in the array `modes`; TAKE_COMMENTS: the sink prints nothing, so comments and changes of mode pass silently.
MOTION = 0
ABSOLUTE = 1
ARC_ABSOLUTE = 2
PLANE = 3
INVERSE_TIME = 4
SKIP_SLASH = 5
TAKE_COMMENTS = 6
MODES = 7

#: Places in the array `levels`.
FEED = 0
RADIUS_TOLERANCE = 1
CENTRE_TOLERANCE = 2
CENTRE_RELATIVE = 3
CENTRE_LIMIT = 4
LEVELS = 5

#: Flags of a block (`gcode_scan`).
_SLASH = cython.declare(cython.int, 1)
_COMMENT = cython.declare(cython.int, 2)
_ACTIVE = cython.declare(cython.int, 4)

#: Larger numbers are faults (`cncgen.gcode.block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e8)
_QUARTER = cython.declare(cython.double, 1.5707963267948966)
#: A radius this much (relative) above half the chord is a semicircle.
_SEMICIRCLE = cython.declare(cython.double, 1e-7)

#: Slots of the words of a block: the nine axes X Y Z A B C U V W, I J K, R, F.
_AXES = cython.declare(cython.int, 9)
_I = cython.declare(cython.int, 9)
_R = cython.declare(cython.int, 12)
_F = cython.declare(cython.int, 13)
#: The same as sets of slots, a bit each.
_ANY_AXIS = cython.declare(cython.uint, 0x1FF)
_ANY_OFFSET = cython.declare(cython.uint, 0xE00)
_RADIUS = cython.declare(cython.uint, 1 << 12)
_FEED = cython.declare(cython.uint, 1 << 13)
#: Letters that have no slot of their own.
_CODE = cython.declare(cython.int, 14)
_OTHER = cython.declare(cython.int, -1)

#: Slot of the word of each letter from a to z: an axis, I J K, R or F; `_CODE` for G; `_OTHER` else.
_SLOT = cython.declare(cython.schar[26])
_letter: cython.int
for _letter in range(26):
    _SLOT[_letter] = b"xyzabcuvwijkrfg".find(97 + _letter)

#: The modes in force, from `modes` and `levels`; `first` and `second` are the columns of the plane's axes, `offsets` the
#: slots of the offsets that an arc in it may have, `silent` is TAKE_COMMENTS.
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
    feed=cython.double,
    radius_tolerance=cython.double,
    centre_tolerance=cython.double,
    centre_relative=cython.double,
    centre_limit=cython.double,
)

#: The words of a block: whether it is plain, which slots they fill, and what its G words say (-1: nothing).
_Block = cython.struct(
    plain=cython.bint, given=cython.uint, motion=cython.int, absolute=cython.int, plane_said=cython.bint
)

#: A centre in the plane, and whether it is certain.
_Centre = cython.struct(x=cython.double, y=cython.double, certain=cython.bint)


@cython.cfunc
@cython.exceptval(check=False)
def _modes_in_force(modes: cython.longlong[::1], levels: cython.double[::1]) -> _Modes:
    """Return `modes` and `levels` as a record."""
    force: _Modes = cython.declare(_Modes)
    force.motion = modes[MOTION]
    force.absolute = modes[ABSOLUTE]
    force.arc_absolute = modes[ARC_ABSOLUTE]
    force.plane = modes[PLANE]
    force.first = 2 if modes[PLANE] == 18 else (1 if modes[PLANE] == 19 else 0)
    force.second = (force.first + 1) % 3
    force.offsets = (1 << (_I + force.first)) | (1 << (_I + force.second))
    force.inverse_time = modes[INVERSE_TIME]
    force.silent = modes[TAKE_COMMENTS]
    force.feed = levels[FEED]
    force.radius_tolerance = levels[RADIUS_TOLERANCE]
    force.centre_tolerance = levels[CENTRE_TOLERANCE]
    force.centre_relative = levels[CENTRE_RELATIVE]
    force.centre_limit = levels[CENTRE_LIMIT]
    return force


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _with_code(block: _Block, code: cython.double, force: _Modes) -> _Block:
    """Return the block with a G word taken in: a motion, and where nobody has to be told also distance and plane."""
    if code == 0.0 or code == 1.0 or code == 2.0 or code == 3.0:
        block.plain = block.motion < 0
        block.motion = cython.cast(cython.int, code)
    elif force.silent and (code == 90.0 or code == 91.0):
        block.plain = block.absolute < 0
        block.absolute = code == 90.0
    elif force.silent and code == force.plane:
        # The plane in force, said again.
        block.plain = not block.plane_said
        block.plane_said = True
    else:
        block.plain = False
    return block


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _words(
    letters: cython.const[cython.uchar][::1],
    values: cython.const[cython.double][::1],
    begin: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    force: _Modes,
    word: cython.p_double,
) -> _Block:
    """Write words `begin` to `end` to their slots of `word`.

    A block with any other word, with one twice or with a negative feed is not plain.
    """
    block: _Block = _Block(plain=True, given=0, motion=-1, absolute=-1, plane_said=False)
    w: cython.Py_ssize_t
    slot: cython.int
    bit: cython.uint
    value: cython.double
    for w in range(begin, end):
        slot = _SLOT[letters[w] - 97]
        value = values[w]
        if slot == _CODE:
            block = _with_code(block, value, force)
        elif slot == _OTHER:
            block.plain = False
        else:
            bit = cython.cast(cython.uint, 1) << slot
            block.plain = not block.given & bit and -_LARGEST <= value <= _LARGEST
            block.given |= bit
            word[slot] = value
        if not block.plain:
            return block
    if block.given & _FEED and word[_F] < 0.0:
        block.plain = False
    return block


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _only_modes(block: _Block, force: _Modes) -> cython.bint:
    """Tell whether a block changes modes or the feed alone, and nobody needs to be told."""
    return force.silent and block.motion < 0 and not block.given & ~_FEED


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _may_move(block: _Block, motion: cython.int, feed: cython.double, force: _Modes) -> cython.bint:
    """Tell whether the words of a block are those of its motion, and a feed is in force where it wants one."""
    if motion < 0 or motion > 3:
        return False
    if motion >= 1 and (feed <= 0.0 or (force.inverse_time and not block.given & _FEED)):
        return False
    if motion < 2:
        return block.given & _ANY_AXIS != 0 and not block.given & (_ANY_OFFSET | _RADIUS)
    # Offsets along the plane's normal, and centre and radius together, are the interpreter's to judge.
    if force.arc_absolute or block.given & _ANY_OFFSET & ~force.offsets:
        return False
    if block.given & _RADIUS:
        return block.given & _ANY_AXIS != 0 and not block.given & _ANY_OFFSET
    return block.given & _ANY_OFFSET != 0


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _go_to(
    block: _Block,
    absolute: cython.bint,
    position: cython.double[::1],
    word: cython.p_double,
    end: cython.p_double,
) -> cython.void:
    """Write the end point: axes that the block names go there, or so far where it is incremental; the others stay."""
    k: cython.int
    for k in range(_AXES):
        end[k] = position[k]
        if block.given >> k & 1:
            end[k] = word[k] if absolute else position[k] + word[k]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _centre_from_radius(
    x0: cython.double,
    y0: cython.double,
    x1: cython.double,
    y1: cython.double,
    radius: cython.double,
    clockwise: cython.bint,
    tolerance: cython.double,
) -> _Centre:
    """See `centre_from_radius`."""
    mx: cython.double = (x0 + x1) / 2.0
    my: cython.double = (y0 + y1) / 2.0
    half: cython.double = hypot(mx - x1, my - y1)
    r: cython.double = fabs(radius)
    if half - r > tolerance or half == 0.0:
        return _Centre(x=mx, y=my, certain=False)
    if r / half < 1.0 + _SEMICIRCLE:
        r = half
    # The centre lies left of the chord for a counter-clockwise arc of less than half a turn.
    normal: cython.double = atan2(y1 - y0, x1 - x0)
    normal += -_QUARTER if clockwise == (radius > 0.0) else _QUARTER
    distance: cython.double = r * cos(asin(half / r))
    return _Centre(x=mx + distance * cos(normal), y=my + distance * sin(normal), certain=True)


def centre_from_radius(
    x0: cython.double,
    y0: cython.double,
    x1: cython.double,
    y1: cython.double,
    radius: cython.double,
    clockwise: cython.bint,
    tolerance: cython.double,
) -> tuple:
    """Return centre and whether it exists, of the arc of `radius` between two points of a plane.

    A negative radius asks for the arc of more than half a turn (RS274/NGC, 3.5.3.1). A radius shorter than half the
    chord by at most `tolerance` counts as half the chord.
    """
    centre: _Centre = _centre_from_radius(x0, y0, x1, y1, radius, clockwise, tolerance)
    return centre.x, centre.y, centre.certain


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _centre_from_offsets(
    x0: cython.double,
    y0: cython.double,
    x1: cython.double,
    y1: cython.double,
    cx: cython.double,
    cy: cython.double,
    force: _Modes,
) -> _Centre:
    """Return a programmed centre; it is certain where start and end are on one circle about it, within tolerance."""
    start: cython.double = hypot(cx - x0, cy - y0)
    end: cython.double = hypot(cx - x1, cy - y1)
    gap: cython.double = fabs(start - end)
    certain: cython.bint = start >= force.radius_tolerance and end >= force.radius_tolerance
    if gap > force.centre_limit or (
        gap > force.centre_tolerance and gap > force.centre_relative * max(start, end)
    ):
        certain = False
    return _Centre(x=cx, y=cy, certain=certain)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _centre(
    block: _Block,
    motion: cython.int,
    position: cython.double[::1],
    end: cython.p_double,
    word: cython.p_double,
    force: _Modes,
) -> _Centre:
    """Return the centre of an arc from `position` to `end`, by its radius or its offsets (0 where not given).

    That of a line is certain, and 0.
    """
    if motion < 2:
        return _Centre(x=0.0, y=0.0, certain=True)
    x0: cython.double = position[force.first]
    y0: cython.double = position[force.second]
    x1: cython.double = end[force.first]
    y1: cython.double = end[force.second]
    if block.given & _RADIUS:
        if word[_R] == 0.0 or (x1 == x0 and y1 == y0):
            return _Centre(x=x0, y=y0, certain=False)
        return _centre_from_radius(x0, y0, x1, y1, word[_R], motion == 2, force.radius_tolerance)
    cx: cython.double = x0
    cy: cython.double = y0
    if block.given & (cython.cast(cython.uint, 1) << (_I + force.first)):
        cx += word[_I + force.first]
    if block.given & (cython.cast(cython.uint, 1) << (_I + force.second)):
        cy += word[_I + force.second]
    return _centre_from_offsets(x0, y0, x1, y1, cx, cy, force)


@cython.cclass
class Advance:
    """The columns of plain blocks and those of their motions, and what is in force between runs.

    Args:
        blocks: Columns of `gcode_scan.scan`: line, offset, flags, end of the words, letters, values.
        position: Shape (9,), X Y Z A B C U V W in program units and coordinates; moved on.
        modes: Shape (`MODES`,): modal motion 0 to 3 (else nothing is taken), flags, plane 17 to 19; changed.
        levels: Shape (`LEVELS`,): feed, then the tolerances of arcs (`cncgen.gcode.codes.arcs`); changed.
        motions: Columns that are filled, a row a motion: line and offset of its block; 0 to 3; end point, shape (n, 9);
            feed in force; whether this block gave F; centre in the two axes of the plane, shape (n, 2); turns (signed,
            positive counter-clockwise; 0 for lines).
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

    def __init__(self, blocks, position, modes, levels, motions):
        self.block_line, self.block_offset, self.block_flags = blocks[:3]
        self.word_end, self.letters, self.values = blocks[3:]
        self.position, self.modes, self.levels = position, modes, levels
        self.line, self.offset, self.motion, self.end = motions[:4]
        self.feed, self.feed_set, self.centre, self.turns = motions[4:]

    def run(self, first: cython.Py_ssize_t, last: cython.Py_ssize_t) -> tuple:
        """Interpret blocks `first` to `last` (not included) while they are plain motions.

        Returns the first block not taken, and the number of rows.
        """
        force: _Modes = _modes_in_force(self.modes, self.levels)
        passed_over: cython.int = _SLASH if self.modes[SKIP_SLASH] else 0
        left: cython.int = _ACTIVE if force.silent else _ACTIVE | _COMMENT
        block: _Block
        centre: _Centre
        word = cython.declare(cython.double[14])
        end = cython.declare(cython.double[9])
        done: cython.Py_ssize_t = last
        rows: cython.Py_ssize_t = 0
        begin: cython.Py_ssize_t
        finish: cython.Py_ssize_t = self.word_end[first - 1] if first > 0 else 0
        b: cython.Py_ssize_t
        motion: cython.int
        absolute: cython.bint
        feed: cython.double
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
            block = _words(self.letters, self.values, begin, finish, force, word)
            if not block.plain:
                break
            feed = word[_F] if block.given & _FEED else force.feed
            absolute = force.absolute if block.absolute < 0 else block.absolute
            if _only_modes(block, force):
                force.absolute = absolute
                force.feed = feed
                continue
            motion = force.motion if block.motion < 0 else block.motion
            if not _may_move(block, motion, feed, force):
                break
            _go_to(block, absolute, self.position, word, end)
            centre = _centre(block, motion, self.position, end, word, force)
            if not centre.certain:
                break
            force.motion = motion
            force.absolute = absolute
            force.feed = feed
            self._put(rows, b, force, block.given & _FEED != 0, centre, end)
            rows += 1
        else:
            done = last
        self.modes[MOTION] = force.motion
        self.modes[ABSOLUTE] = force.absolute
        self.levels[FEED] = force.feed
        return done, rows

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _put(
        self,
        row: cython.Py_ssize_t,
        b: cython.Py_ssize_t,
        force: _Modes,
        feed_set: cython.bint,
        centre: _Centre,
        end: cython.p_double,
    ) -> cython.void:
        """Fill the row of the motion of block b, and stand at its end."""
        k: cython.int
        self.line[row] = self.block_line[b]
        self.offset[row] = self.block_offset[b]
        self.motion[row] = force.motion
        self.feed[row] = force.feed
        self.feed_set[row] = feed_set
        self.centre[row, 0] = centre.x
        self.centre[row, 1] = centre.y
        self.turns[row] = 0 if force.motion < 2 else 2 * force.motion - 5
        for k in range(_AXES):
            self.position[k] = end[k]
            self.end[row, k] = end[k]
