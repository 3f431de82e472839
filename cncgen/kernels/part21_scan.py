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

_ID_LIMIT = cython.declare(cython.longlong, 1_000_000_000_000_000_000)

#: The digits of an id as a number (no more of them than fit), the offset after them, and whether all fitted.
_Id = cython.struct(value=cython.longlong, after=cython.Py_ssize_t, fits=cython.bint)

#: A number and the offset after it, -1 where none stands there.
_Number = cython.struct(value=cython.double, after=cython.Py_ssize_t)
_Exponent = cython.struct(value=cython.int, after=cython.Py_ssize_t)


def keyword_hash(word: bytes) -> int:
    """Return what `split` puts in `types` for a keyword: the 64-bit FNV-1a hash of its capitals, as signed."""
    h = 0xCBF29CE484222325
    for c in word.upper():
        h = ((h ^ c) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    return h - (1 << 64) if h >> 63 else h


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_space(c: cython.int) -> cython.bint:
    return c == 32 or 9 <= c <= 13


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_digit(c: cython.int) -> cython.bint:
    return 48 <= c <= 57


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_word(c: cython.int) -> cython.bint:
    return (65 <= c <= 90) or (97 <= c <= 122) or (48 <= c <= 57) or c == 95 or c == 45 or c == 33


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _opens_comment(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.bint:
    return data[p] == 47 and p + 1 < end and data[p + 1] == 42


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
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
@cython.nogil
@cython.exceptval(check=False)
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
@cython.nogil
@cython.exceptval(check=False)
def _past_blank(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    while p < end and _is_space(data[p]):
        p += 1
    return p


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
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
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _id(data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t) -> _Id:
    """Read the digits after the ``#`` at p."""
    value: cython.longlong = 0
    fits: cython.bint = True
    p += 1
    while p < end and _is_digit(data[p]):
        if value < _ID_LIMIT:
            value = value * 10 + (data[p] - 48)
        else:
            fits = False
        p += 1
    return _Id(value=value, after=p, fits=fits)


@cython.cfunc
@cython.exceptval(check=False)
def _head(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    size: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    ids: cython.longlong[::1],
    flags: cython.int[::1],
) -> cython.Py_ssize_t:
    """Read ``#id =`` at p into row n; return the offset of the body."""
    ident: _Id = _id(data, p, size)
    q: cython.Py_ssize_t = _past_blank_and_comments(data, ident.after, size)
    ids[n] = ident.value
    if not ident.fits:
        flags[n] |= BIG_ID
    if q < size and data[q] == 61:
        q = _past_blank_and_comments(data, q + 1, size)
    else:
        flags[n] |= NO_EQUALS
    if q > size:
        flags[n] |= UNTERMINATED
        q = size
    return q


@cython.cfunc
@cython.exceptval(check=False)
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
@cython.exceptval(check=False)
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
    ident: _Id
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
                if total == targets.shape[0]:
                    raise ValueError("the array of references is too short")
                ident = _id(data, p, end)
                targets[total] = ident.value
                total += 1
                p = ident.after
            else:
                p += 1
        offsets[i + 1] = total
    return total


def partials(
    data: cython.const[cython.uchar][::1],
    bodies: cython.longlong[::1],
    ends: cython.longlong[::1],
    owners: cython.longlong[::1],
    types: cython.longlong[::1],
    begins: cython.longlong[::1],
    stops: cython.longlong[::1],
) -> int:
    """List the partial entities of complex instances, ``(NAME(…)NAME(…))``, in order.

    Args:
        data: The file.
        bodies, ends: Shape (n,): the instances, from `split`.
        owners: Filled with the index of the instance of each, as many as there is room for, here and below.
        types: Filled with the `keyword_hash` of each.
        begins, stops: Filled with the offsets where its attributes begin and end, parentheses included.

    Returns:
        Number of partial entities.
    """
    i: cython.Py_ssize_t
    p: cython.Py_ssize_t
    end: cython.Py_ssize_t
    total: cython.Py_ssize_t = 0
    depth: cython.int
    c: cython.int
    if not cython.compiled:
        data = memoryview(data)  # its elements are Python's integers
    for i in range(bodies.shape[0]):
        p = bodies[i]
        end = ends[i]
        depth = 0
        while p < end:
            c = data[p]
            if c == 39:
                p = _past_string(data, p, end)
            elif c == 47 and _opens_comment(data, p, end):
                p = _past_comment(data, p, end)
            elif depth == 1 and _is_word(c):
                if total == owners.shape[0]:
                    return total
                owners[total] = i
                p = _keyword(data, p, end, total, types)
                begins[total] = p
                stops[total] = end
                total += 1
            else:
                if c == 40:
                    depth += 1
                elif c == 41:
                    depth -= 1
                    if depth == 1 and total > 0 and owners[total - 1] == i:
                        stops[total - 1] = p + 1
                p += 1
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _exponent(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> _Exponent:
    """Read the exponent of a number that may stand at p: 0 where it has no exponent."""
    value: cython.int = 0
    negative: cython.bint
    first: cython.Py_ssize_t
    if p >= end or (data[p] != 69 and data[p] != 101):
        return _Exponent(value=0, after=p)
    p += 1
    negative = p < end and data[p] == 45
    if negative or (p < end and data[p] == 43):
        p += 1
    first = p
    while p < end and _is_digit(data[p]) and value < 1000:
        value = value * 10 + (data[p] - 48)
        p += 1
    return _Exponent(value=-value if negative else value, after=p if p > first else -1)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _scaled(mantissa: cython.double, power: cython.int, powers: cython.double[::1]) -> cython.double:
    """Return mantissa · 10^power, rounded once."""
    if mantissa == 0.0:
        return 0.0
    return mantissa / powers[-power] if power < 0 else mantissa * powers[power]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _number(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    powers: cython.double[::1],
) -> _Number:
    """Read the number at p, of at most 15 digits and powers of ten up to 22."""
    none: _Number = _Number(value=0.0, after=-1)
    negative: cython.bint = p < end and data[p] == 45
    mantissa: cython.longlong = 0
    digits: cython.int = 0
    decimals: cython.int = 0
    seen: cython.bint = False
    point: cython.bint = False
    value: cython.double
    exponent: _Exponent
    if negative or (p < end and data[p] == 43):
        p += 1
    while p < end and (_is_digit(data[p]) or (data[p] == 46 and not point)):
        if data[p] == 46:
            point = True
        else:
            mantissa = mantissa * 10 + (data[p] - 48)
            seen = True
            digits += mantissa > 0
            decimals += point
            if digits > 15:
                return none
        p += 1
    exponent = _exponent(data, p, end)
    exponent.value -= decimals
    if not seen or exponent.after < 0 or (mantissa != 0 and not -22 <= exponent.value <= 22):
        return none
    value = _scaled(cython.cast(cython.double, mantissa), exponent.value, powers)
    return _Number(value=-value if negative else value, after=exponent.after)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _past_mark(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t, mark: cython.int
) -> cython.Py_ssize_t:
    """Return the offset after blanks and a mark; end + 1 where another stands there."""
    p = _past_blank(data, p, end)
    return p + 1 if p < end and data[p] == mark else end + 1


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _past_name(
    data: cython.const[cython.uchar][::1], p: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return the offset after blanks and a string or ``$``, which may be missing."""
    p = _past_blank(data, p, end)
    if p < end and data[p] == 39:
        return _past_string(data, p, end)
    return p + 1 if p < end and data[p] == 36 else p


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _point(
    data: cython.const[cython.uchar][::1],
    p: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    powers: cython.double[::1],
    coordinates: cython.double[:, ::1],
    i: cython.Py_ssize_t,
) -> cython.int:
    """Read ``WORD('name',(x,y,z))`` at p into coordinates[i]; return how many numbers, −1 for any other text."""
    k: cython.int = 0
    number: _Number
    while p < end and _is_word(data[p]):
        p += 1
    p = _past_mark(data, p, end, 40)
    p = _past_name(data, p, end)
    p = _past_mark(data, p, end, 44)
    p = _past_mark(data, p, end, 40)
    while True:
        number = _number(data, _past_blank(data, p, end), end, powers)
        if number.after < 0:
            return -1
        coordinates[i, k] = number.value
        k += 1
        p = _past_blank(data, number.after, end)
        if k == 3 or p >= end or data[p] != 44:
            break
        p += 1
    p = _past_mark(data, p, end, 41)
    p = _past_mark(data, p, end, 41)
    return k if _past_blank(data, p, end) == end else -1


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
    gives the correctly rounded number (W. D. Clinger, How to read floating point numbers accurately, PLDI (1990) 92).

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
