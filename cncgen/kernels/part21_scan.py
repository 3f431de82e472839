"""Split an ISO 10303-21 exchange structure into its statements, and read the bulk of it without parsing.

`split` finds every ``#id = body ;`` and every section keyword; `references` lists the ``#n`` of each statement;
`points` reads the coordinates of CARTESIAN_POINTs. Bytes and arrays in, arrays out.
"""

import cython

#: Bits of the flags of a statement.
HAS_COMMENT = 1
UNBALANCED = 2
NO_SEMICOLON = 4
UNTERMINATED = 8
BIG_ID = 16
NO_EQUALS = 32

_ID_LIMIT: cython.longlong = 1_000_000_000_000_000_000


def keyword_hash(word: bytes) -> int:
    """Return what `split` puts in `types` for a keyword: the 64-bit FNV-1a hash of its capitals, as signed."""
    h = 0xCBF29CE484222325
    for c in word.upper():
        h = ((h ^ c) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    return h - (1 << 64) if h >> 63 else h


@cython.cfunc
@cython.inline
def _is_space(c: cython.int) -> cython.bint:
    return c == 32 or 9 <= c <= 13


@cython.cfunc
@cython.inline
def _is_digit(c: cython.int) -> cython.bint:
    return 48 <= c <= 57


@cython.cfunc
@cython.inline
def _is_word(c: cython.int) -> cython.bint:
    return (65 <= c <= 90) or (97 <= c <= 122) or (48 <= c <= 57) or c == 95 or c == 45 or c == 33


@cython.cfunc
@cython.inline
def _opens_comment(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.bint:
    return data[p] == 47 and p + 1 < end and data[p + 1] == 42


@cython.cfunc
@cython.inline
def _past_comment(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return the offset after the comment that opens at p; end + 1 where it is not closed."""
    p += 2
    while p + 1 < end:
        if data[p] == 42 and data[p + 1] == 47:
            return p + 2
        p += 1
    return end + 1


@cython.cfunc
@cython.inline
def _past_string(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return the offset after the apostrophe that closes the one at p; end + 1 where none does."""
    p += 1
    while p < end:
        if data[p] == 39:
            return p + 1
        p += 1
    return end + 1


@cython.cfunc
@cython.inline
def _past_blank(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    while p < end and _is_space(data[p]):
        p += 1
    return p


@cython.cfunc
def _past_blank_and_comments(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return the offset of the next token; end + 1 where a comment is not closed."""
    while p < end:
        if _is_space(data[p]):
            p += 1
        elif _opens_comment(data, p, end):
            p = _past_comment(data, p, end)
        else:
            break
    return p


@cython.cfunc
def _head(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    size: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    ids: cython.longlong[::1],
    flags: cython.int[::1],
) -> cython.Py_ssize_t:
    """Read ``#id =`` at p into row n; return the offset of the body."""
    q: cython.Py_ssize_t = p + 1
    ident: cython.longlong = 0
    while q < size and _is_digit(data[q]):
        if ident < _ID_LIMIT:
            ident = ident * 10 + (data[q] - 48)
        else:
            flags[n] |= BIG_ID
        q += 1
    ids[n] = ident
    p = q
    q = _past_blank_and_comments(data, q, size)
    if q < size and data[q] == 61:
        p = q + 1
        q = _past_blank_and_comments(data, p, size)
    else:
        flags[n] |= NO_EQUALS
    if q > size:
        flags[n] |= UNTERMINATED
        q = size
    return q


@cython.cfunc
def _keyword(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    size: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    types: cython.longlong[::1],
) -> cython.Py_ssize_t:
    """Hash the word at p into row n; return the offset after it."""
    q: cython.Py_ssize_t = p
    c: cython.int
    while q < size and _is_word(data[q]):
        q += 1
    if q == p:
        types[n] = 0
    elif not cython.compiled:
        types[n] = keyword_hash(bytes(data[p:q]))
    else:
        h: cython.ulonglong = 0xCBF29CE484222325
        while p < q:
            c = data[p]
            if 97 <= c <= 122:
                c -= 32
            h = (h ^ c) * cython.cast(cython.ulonglong, 0x100000001B3)
            p += 1
        types[n] = cython.cast(cython.longlong, h)
    return q


@cython.cfunc
def _body(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    size: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    instance: cython.bint,
    flags: cython.int[::1],
) -> cython.Py_ssize_t:
    """Return the offset of the semicolon that ends the body at p (or where one is missing), noting faults in row n."""
    depth: cython.int = 0
    closed: cython.bint = False
    c: cython.int
    q: cython.Py_ssize_t
    while p < size:
        c = data[p]
        if c == 59:
            break
        if c == 39:
            p = _past_string(data, p, size)
            continue
        if c == 47 and _opens_comment(data, p, size):
            flags[n] |= HAS_COMMENT
            p = _past_comment(data, p, size)
            continue
        if c == 40:
            depth += 1
        elif c == 41:
            depth -= 1
            closed = depth == 0
        elif c == 60:
            q = p + 1
            while q < size and data[q] != 62 and data[q] != 10:
                q += 1
            if q < size and data[q] == 62:
                p = q
        elif c == 35 and closed and depth == 0 and instance:
            flags[n] |= NO_SEMICOLON
            break
        p += 1
    if p >= size:
        p = size
        flags[n] |= UNTERMINATED
    if depth != 0:
        flags[n] |= UNBALANCED
    return p


def split(
    data: cython.const[cython.uchar][::1],
    position: cython.Py_ssize_t,
    ids: cython.longlong[::1],
    starts: cython.longlong[::1],
    bodies: cython.longlong[::1],
    ends: cython.longlong[::1],
    types: cython.longlong[::1],
    flags: cython.int[::1],
) -> tuple:
    """Find the statements of `data` from `position` on, one array element each, until the arrays are full.

    Args:
        data: The file, any bytes.
        position: Where to begin, outside strings and comments.
        ids: Filled with the number of ``#id``, −1 where the statement does not begin with ``#digits``.
        starts: Filled with the offset of the statement's first character.
        bodies: Filled with the offset of what follows ``#id =`` (else of the statement).
        ends: Filled with the offset of the semicolon (exclusive end of the body).
        types: Filled with the `keyword_hash` of the body's keyword, 0 where none stands there.
        flags: Filled with the bits named above.

    Returns:
        Statements found, and the offset after the last of them: the size of the data when all are found.
    """
    if not cython.compiled:
        data = memoryview(data)  # its elements are Python's integers
    size: cython.Py_ssize_t = data.shape[0]
    room: cython.Py_ssize_t = ids.shape[0]
    p: cython.Py_ssize_t = position
    q: cython.Py_ssize_t
    n: cython.Py_ssize_t = 0
    while n < room:
        q = _past_blank_and_comments(data, p, size)
        if q == size:
            return n, size
        ids[n] = -1
        flags[n] = 0
        types[n] = 0
        if q > size:  # a comment that is not closed
            p = _past_blank(data, p, size)
            starts[n] = p
            bodies[n] = p
            ends[n] = size
            flags[n] = UNTERMINATED | HAS_COMMENT
            return n + 1, size
        starts[n] = q
        if data[q] == 35 and q + 1 < size and _is_digit(data[q + 1]):
            q = _head(data, q, size, n, ids, flags)
        bodies[n] = q
        q = _keyword(data, q, size, n, types)
        p = _body(data, q, size, n, ids[n] >= 0, flags)
        ends[n] = p
        if p < size and data[p] == 59:
            p += 1
        n += 1
    return n, p


def references(
    data: cython.const[cython.uchar][::1],
    bodies: cython.longlong[::1],
    ends: cython.longlong[::1],
    targets: cython.longlong[::1],
    offsets: cython.longlong[::1],
) -> int:
    """List the ids that each statement refers to, in order, outside strings and comments.

    Args:
        data: The file.
        bodies, ends: Shape (n,), from `split`.
        targets: Filled with ids; as long as the file has ``#`` suffices where statements do not overlap.
        offsets: Shape (n + 1,): the references of statement i are ``targets[offsets[i]:offsets[i + 1]]``.

    Returns:
        Number of references.

    Raises:
        ValueError: where `targets` is too short.
    """
    i: cython.Py_ssize_t
    p: cython.Py_ssize_t
    end: cython.Py_ssize_t
    total: cython.Py_ssize_t = 0
    value: cython.longlong
    c: cython.int
    if not cython.compiled:
        data = memoryview(data)  # its elements are Python's integers
    offsets[0] = 0
    for i in range(bodies.shape[0]):
        p = bodies[i]
        end = ends[i]
        while p < end:
            c = data[p]
            if c == 39:
                p = _past_string(data, p, end)
            elif c == 47 and _opens_comment(data, p, end):
                p = _past_comment(data, p, end)
            elif c == 35 and p + 1 < end and _is_digit(data[p + 1]):
                value = 0
                p += 1
                while p < end and _is_digit(data[p]):
                    if value < _ID_LIMIT:
                        value = value * 10 + (data[p] - 48)
                    p += 1
                if total == targets.shape[0]:
                    raise ValueError("there is no room for all references")
                targets[total] = value
                total += 1
            else:
                p += 1
        offsets[i + 1] = total
    return total


@cython.cfunc
def _number(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    powers: cython.double[::1],
    coordinates: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Read the number at p into coordinates[i, k]; return the offset after it, −1 where this is no short number."""
    negative: cython.bint = data[p] == 45
    mantissa: cython.longlong = 0
    digits: cython.int = 0
    shift: cython.int = 0
    exponent: cython.int = 0
    seen: cython.bint = False
    point: cython.bint = False
    value: cython.double
    if negative or data[p] == 43:
        p += 1
    while p < end and (_is_digit(data[p]) or (data[p] == 46 and not point)):
        if data[p] == 46:
            point = True
        else:
            mantissa = mantissa * 10 + (data[p] - 48)
            if mantissa > 0:
                digits += 1
            if digits > 15:
                return -1
            shift += point
            seen = True
        p += 1
    if not seen:
        return -1
    if p < end and (data[p] == 69 or data[p] == 101):
        p += 1
        point = p < end and data[p] == 45
        if point or (p < end and data[p] == 43):
            p += 1
        seen = False
        while p < end and _is_digit(data[p]) and exponent < 1000:
            exponent = exponent * 10 + (data[p] - 48)
            seen = True
            p += 1
        if not seen:
            return -1
        shift += exponent if point else -exponent
    value = mantissa
    if mantissa != 0 and (shift > 22 or shift < -22):
        return -1
    if mantissa != 0 and shift > 0:
        value = value / powers[shift]
    elif mantissa != 0:
        value = value * powers[-shift]
    coordinates[i, k] = -value if negative else value
    return p


@cython.cfunc
def _point(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    powers: cython.double[::1],
    coordinates: cython.double[:, ::1],
    i: cython.Py_ssize_t,
) -> cython.int:
    """Read ``WORD('name',(x,y,z))`` at p into coordinates[i]; return how many numbers, −1 where it is no such text."""
    k: cython.int = 0
    while p < end and _is_word(data[p]):
        p += 1
    p = _past_blank(data, p, end)
    if p >= end or data[p] != 40:
        return -1
    p = _past_blank(data, p + 1, end)
    if p < end and data[p] == 39:
        p = _past_string(data, p, end)
    elif p < end and data[p] == 36:
        p += 1
    p = _past_blank(data, p, end)
    if p >= end or data[p] != 44:
        return -1
    p = _past_blank(data, p + 1, end)
    if p >= end or data[p] != 40:
        return -1
    while k < 3:
        p = _past_blank(data, p + 1, end)
        if p >= end:
            return -1
        p = _number(data, p, end, powers, coordinates, i, k)
        if p < 0:
            return -1
        k += 1
        p = _past_blank(data, p, end)
        if p >= end or data[p] != 44:
            break
    if p >= end or data[p] != 41:
        return -1
    p = _past_blank(data, p + 1, end)
    if p >= end or data[p] != 41:
        return -1
    return k if _past_blank(data, p + 1, end) == end else -1


def points(
    data: cython.const[cython.uchar][::1],
    bodies: cython.longlong[::1],
    ends: cython.longlong[::1],
    coordinates: cython.double[:, ::1],
    dimensions: cython.schar[::1],
    powers: cython.double[::1],
) -> None:
    """Read ``KEYWORD('name',(x,y,z))`` with 1 to 3 numbers of at most 15 digits, exactly.

    A decimal of up to 15 digits and a power of ten up to 22 are doubles without error, so one division or product
    gives the correctly rounded number (W. D. Clinger, "How to read floating point numbers accurately", 1990).

    Args:
        data: The file.
        bodies, ends: Shape (n,): the statements to read.
        coordinates: Shape (n, 3), filled; the coordinates that a point has not are 0.
        dimensions: Shape (n,), filled with 1, 2 or 3, or −1 where the statement has another form: parse it.
        powers: Shape (23,): 1, 10, …, 1e22.
    """
    i: cython.Py_ssize_t
    if not cython.compiled:
        data = memoryview(data)  # its elements are Python's integers
    for i in range(bodies.shape[0]):
        coordinates[i, 0] = coordinates[i, 1] = coordinates[i, 2] = 0.0
        dimensions[i] = _point(data, bodies[i], ends[i], powers, coordinates, i)
