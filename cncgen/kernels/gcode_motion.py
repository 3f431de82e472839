"""Interpret runs of plain motion blocks (G0 to G3, axis words, F) from the columns of `gcode_scan` into motions.

What the loop does not take for certain it leaves: it stops before the block, and the interpreter, which knows the
whole language and every error, executes that one.
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

#: Larger numbers are faults (`cncgen.gcode.block.LARGEST`).
_LARGEST: cython.double = 1e9
_QUARTER: cython.double = 1.5707963267948966
#: A radius this much (relative) above half the chord is a semicircle.
_SEMICIRCLE: cython.double = 1e-7


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _axis_of(c: cython.int) -> cython.int:
    """Column of an axis letter, or -1."""
    if 120 <= c <= 122:
        return c - 120
    if 97 <= c <= 99:
        return c - 94
    if 117 <= c <= 119:
        return c - 111
    return -1


@cython.ccall
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
    mx: cython.double = (x0 + x1) / 2.0
    my: cython.double = (y0 + y1) / 2.0
    half: cython.double = hypot(mx - x1, my - y1)
    r: cython.double = fabs(radius)
    if half - r > tolerance or half == 0.0:
        return mx, my, False
    if r / half < 1.0 + _SEMICIRCLE:
        r = half
    # The centre lies left of the chord for a counter-clockwise arc of less than half a turn.
    normal: cython.double = atan2(y1 - y0, x1 - x0)
    normal += -_QUARTER if clockwise == (radius > 0.0) else _QUARTER
    distance: cython.double = r * cos(asin(half / r))
    return mx + distance * cos(normal), my + distance * sin(normal), True


def advance(
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    block_line: cython.const[cython.longlong][::1],
    block_offset: cython.const[cython.longlong][::1],
    block_flags: cython.const[cython.uchar][::1],
    word_end: cython.const[cython.longlong][::1],
    letters: cython.const[cython.uchar][::1],
    values: cython.const[cython.double][::1],
    position: cython.double[::1],
    modes: cython.longlong[::1],
    levels: cython.double[::1],
    out_line: cython.longlong[::1],
    out_offset: cython.longlong[::1],
    out_motion: cython.schar[::1],
    out_end: cython.double[:, ::1],
    out_feed: cython.double[::1],
    out_feed_set: cython.uchar[::1],
    out_centre: cython.double[:, ::1],
    out_turns: cython.longlong[::1],
) -> tuple:
    """Interpret blocks `first` to `last` (not included) while they are plain motions.

    Args:
        block_line, block_offset, block_flags, word_end, letters, values: Columns of `gcode_scan.scan`.
        position: Shape (9,), X Y Z A B C U V W in program units and coordinates; moved on.
        modes: Shape (`MODES`,): modal motion 0 to 3 (else nothing is taken), flags, plane 17 to 19; changed.
        levels: Shape (`LEVELS`,): feed, then the tolerances of arcs (`cncgen.gcode.arcs`); changed.
        out_line, out_offset, out_motion, out_end, out_feed, out_feed_set, out_centre, out_turns: Filled, a row a
            motion: line and offset of its block, 0 to 3, end point, feed in force, whether this block gave F, centre in the two axes of the
            plane, turns (signed, positive counter-clockwise; 0 for lines).

    Returns:
        The first block not taken, and the number of rows.
    """
    rows: cython.Py_ssize_t = 0
    b: cython.Py_ssize_t
    w: cython.Py_ssize_t
    begin: cython.Py_ssize_t
    end: cython.Py_ssize_t
    k: cython.int
    c: cython.int
    axis: cython.int
    seen: cython.uint
    bit: cython.uint
    motion: cython.int
    given: cython.int
    distance: cython.int
    moves: cython.uint
    flags: cython.int
    moved: cython.bint
    plane_said: cython.bint
    taken: cython.bint
    value: cython.double
    feed: cython.double
    offset = cython.declare(cython.double[3])
    has_offset: cython.uint
    radius: cython.double
    turns: cython.longlong
    target = cython.declare(cython.double[9])
    first_axis: cython.int = 0
    second_axis: cython.int = 1
    cx: cython.double
    cy: cython.double
    start_radius: cython.double
    end_radius: cython.double
    gap: cython.double
    if modes[PLANE] == 18:
        first_axis = 2
        second_axis = 0
    elif modes[PLANE] == 19:
        first_axis = 1
        second_axis = 2
    for b in range(first, last):
        flags = block_flags[b]
        if flags & 1 and modes[SKIP_SLASH]:
            continue
        if flags & 4 or (flags & 2 and not modes[TAKE_COMMENTS]):
            return b, rows
        begin = word_end[b - 1] if b > 0 else 0
        end = word_end[b]
        if begin == end:
            continue
        for k in range(9):
            target[k] = position[k]
        offset[0] = 0.0
        offset[1] = 0.0
        offset[2] = 0.0
        has_offset = 0
        seen = 0
        given = -1
        distance = -1
        plane_said = False
        moves = 0
        moved = False
        feed = levels[FEED]
        radius = 0.0
        turns = 1
        taken = True
        for w in range(begin, end):
            c = cython.cast(cython.int, letters[w])
            value = values[w]
            bit = cython.cast(cython.uint, 1) << (c - 97)
            if c == 103:  # g
                if value == 0.0 or value == 1.0 or value == 2.0 or value == 3.0:
                    taken = given < 0
                    given = cython.cast(cython.int, value)
                elif (value == 90.0 or value == 91.0) and modes[TAKE_COMMENTS]:
                    # A sink that prints is told of the change, so the handler has to make it.
                    taken = distance < 0
                    distance = value == 90.0
                elif value == modes[PLANE] and modes[TAKE_COMMENTS]:
                    # The plane in force, said again.
                    taken = not plane_said
                    plane_said = True
                else:
                    taken = False
                if not taken:
                    break
                continue
            if seen & bit or value > _LARGEST or value < -_LARGEST:
                taken = False
                break
            seen |= bit
            axis = _axis_of(c)
            if axis >= 0:
                moved = True
                moves |= cython.cast(cython.uint, 1) << axis
                target[axis] = value
            elif c == 102:  # f
                if value < 0.0:
                    taken = False
                    break
                feed = value
            elif 105 <= c <= 107:  # i j k
                offset[c - 105] = value
                has_offset |= cython.cast(cython.uint, 1) << (c - 105)
            elif c == 114:  # r
                radius = value
            else:
                taken = False
                break
        if not taken:
            return b, rows
        if distance < 0:
            distance = cython.cast(cython.int, modes[ABSOLUTE])
        if given < 0 and not moved and has_offset == 0 and modes[TAKE_COMMENTS]:
            # Only modes: nothing moves, and nobody needs to be told.
            if seen & ~cython.cast(cython.uint, 1 << 5):
                return b, rows
            modes[ABSOLUTE] = distance
            levels[FEED] = feed
            continue
        if not distance and moved:
            for k in range(9):
                if moves & (1 << k):
                    target[k] = position[k] + target[k]
        motion = given if given >= 0 else cython.cast(cython.int, modes[MOTION])
        if motion < 0 or motion > 3:
            return b, rows
        if motion < 2:
            if not moved or has_offset or seen & (1 << 17):
                return b, rows
            turns = 0
        if motion >= 1 and (feed <= 0.0 or (modes[INVERSE_TIME] and not seen & (1 << 5))):
            return b, rows
        cx = 0.0
        cy = 0.0
        if motion >= 2:
            # Offsets along the plane's normal, and centre and radius together, are the interpreter's to judge.
            if has_offset & ~((1 << first_axis) | (1 << second_axis)) or modes[ARC_ABSOLUTE]:
                return b, rows
            if seen & (1 << 17):
                if has_offset or radius == 0.0 or not moved:
                    return b, rows
                if (
                    target[first_axis] == position[first_axis]
                    and target[second_axis] == position[second_axis]
                ):
                    return b, rows
                centre = centre_from_radius(
                    position[first_axis],
                    position[second_axis],
                    target[first_axis],
                    target[second_axis],
                    radius,
                    motion == 2,
                    levels[RADIUS_TOLERANCE],
                )
                if not centre[2]:
                    return b, rows
                cx = centre[0]
                cy = centre[1]
            else:
                if not has_offset:
                    return b, rows
                cx = position[first_axis] + offset[first_axis]
                cy = position[second_axis] + offset[second_axis]
                start_radius = hypot(cx - position[first_axis], cy - position[second_axis])
                end_radius = hypot(cx - target[first_axis], cy - target[second_axis])
                gap = fabs(start_radius - end_radius)
                if start_radius < levels[RADIUS_TOLERANCE] or end_radius < levels[RADIUS_TOLERANCE]:
                    return b, rows
                if gap > levels[CENTRE_LIMIT] or (
                    gap > levels[CENTRE_TOLERANCE]
                    and gap > levels[CENTRE_RELATIVE] * max(start_radius, end_radius)
                ):
                    return b, rows
            if motion == 2:
                turns = -1
        modes[MOTION] = motion
        modes[ABSOLUTE] = distance
        levels[FEED] = feed
        out_line[rows] = block_line[b]
        out_offset[rows] = block_offset[b]
        out_motion[rows] = motion
        out_feed[rows] = feed
        out_feed_set[rows] = 1 if seen & (1 << 5) else 0
        out_centre[rows, 0] = cx
        out_centre[rows, 1] = cy
        out_turns[rows] = turns
        for k in range(9):
            position[k] = target[k]
            out_end[rows, k] = target[k]
        rows += 1
    return last, rows
