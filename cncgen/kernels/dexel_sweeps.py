# cython: infer_types=True
"""Material removal on dexels: a tool that leans cuts lines of material along one direction.

A field of dexels is a grid of lines along w over places (u, v); each holds the stretches of it that are material. A straight motion
cuts from each the interval in which the line meets the body that the tool sweeps (`swept_body`).

Most of the lines under a tool have been cut by the motions before. So a square of lines keeps a gap that all of them have, between two
planes over (u, v), which only grows as more is cut. The envelope less the height, and beside the stadium the distance from it, are convex
over space: their tangent plane at one point tells for all the square that the tool stays within the gap.
"""

import cython
from cython.cimports.cncgen.kernels.swept_body import CLOSE, ENDLESS, SweptBody
from cython.cimports.libc.math import ceil, fabs, floor, sqrt

#: Columns of the result of `cut_lines`.
COLUMNS = 11
#: Rows and columns of a square of lines, and the numbers that tell its gap: height over its middle and slopes along u and v of the
#: plane below, and of the one above.
SQUARE = 8
GAP = 6
_SQUARE = cython.declare(cython.Py_ssize_t, SQUARE)
#: Planes of gaps are not steeper.
_STEEPEST = cython.declare(cython.double, 8.0)
#: Shorter stretches of material are dropped, mm.
_NOTHING = cython.declare(cython.double, 1e-9)


@cython.final
@cython.cclass
class _Field:
    """A field of dexels, and how the line at hand goes over it."""

    ends: cython.double[:, :, ::1]
    counts: cython.int[:, ::1]
    parts: cython.double[:, :, ::1]
    part_counts: cython.int[:, ::1]
    gaps: cython.double[:, :, ::1]
    # The columns that a row of a square reaches.
    reached: cython.longlong[:, ::1]
    u0: cython.double
    v0: cython.double
    cell: cython.double
    bottom: cython.double
    top: cython.double
    edge_length: cython.double
    dry: cython.bint
    # The line: its ends from the first dexel, how far the shank goes until it has left the material, the places u it reaches.
    pu: cython.double
    pv: cython.double
    pw: cython.double
    qu: cython.double
    qv: cython.double
    qw: cython.double
    far: cython.double
    lowest: cython.double
    highest: cython.double
    first_row: cython.Py_ssize_t
    last_row: cython.Py_ssize_t
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t
    # Planes beside the body, by which the dexels of a square miss it: values at the square's middle at w = 0, and changes.
    low: cython.double
    low_u: cython.double
    low_v: cython.double
    low_w: cython.double
    high: cython.double
    high_u: cython.double
    high_v: cython.double
    high_w: cython.double
    # The judgement of a dexel.
    deep: cython.double
    gouge: cython.double
    above: cython.double
    at: cython.double

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _take(self, lines: cython.double[:, ::1], k: cython.Py_ssize_t, whole: SweptBody) -> cython.bint:
        """Take a line; tell whether it may reach any dexel."""
        rows: cython.Py_ssize_t = self.counts.shape[0]
        radius: cython.double = whole.radius
        wide: cython.double = radius * sqrt(1.0 - whole.zw * whole.zw) if fabs(whole.zw) < 1.0 else 0.0
        self.pu, self.pv, self.pw = lines[k, 0] - self.u0, lines[k, 1] - self.v0, lines[k, 2]
        self.qu, self.qv, self.qw = lines[k, 3] - self.u0, lines[k, 4] - self.v0, lines[k, 5]
        lo = self.pw if self.pw < self.qw else self.qw
        hi = self.pw if self.pw > self.qw else self.qw
        # Rounded up by a hair: ends of stretches are compared with them.
        whole.lowest = lo - wide - 1e-6 if whole.zw >= 0.0 else -1e300
        whole.highest = hi + wide + 1e-6 if whole.zw <= 0.0 else 1e300
        self.far = 1e6
        if whole.zw > 1e-9:
            self.far = (self.top - lo + wide) / whole.zw
        elif whole.zw < -1e-9:
            self.far = (hi + wide - self.bottom) / -whole.zw
        elif lo - radius > self.top or hi + radius < self.bottom:
            return False
        if self.far < 0.0:
            return False
        self._end_shank(whole.zu, self.pu, self.qu, (self.counts.shape[1] - 1) * self.cell, radius)
        self._end_shank(whole.zv, self.pv, self.qv, (rows - 1) * self.cell, radius)
        size = radius * sqrt(1.0 - whole.zv * whole.zv) if fabs(whole.zv) < 1.0 else 0.0
        lo = (self.pv if self.pv < self.qv else self.qv) - size
        hi = (self.pv if self.pv > self.qv else self.qv) + size
        lo = lo + self.far * whole.zv if whole.zv < 0.0 else lo
        hi = hi + self.far * whole.zv if whole.zv > 0.0 else hi
        if hi < 0.0 or lo > (rows - 1) * self.cell:
            return False
        self.first_row = cython.cast(cython.Py_ssize_t, ceil(lo / self.cell)) if lo > 0.0 else 0
        self.last_row = rows - 1
        if hi < (rows - 1) * self.cell:
            self.last_row = cython.cast(cython.Py_ssize_t, floor(hi / self.cell))
        size = radius * sqrt(1.0 - whole.zu * whole.zu) if fabs(whole.zu) < 1.0 else 0.0
        self.lowest = (self.pu if self.pu < self.qu else self.qu) - size
        self.highest = (self.pu if self.pu > self.qu else self.qu) + size
        self.lowest = self.lowest + self.far * whole.zu if whole.zu < 0.0 else self.lowest
        self.highest = self.highest + self.far * whole.zu if whole.zu > 0.0 else self.highest
        return True

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _end_shank(
        self,
        slope: cython.double,
        p: cython.double,
        q: cython.double,
        side: cython.double,
        radius: cython.double,
    ) -> cython.void:
        """Shorten `far` to where a shank that leaves p to q with a slope is off the grid, whose side is so long."""
        far: cython.double = 1e6
        if slope > 1e-9:
            far = (side - (p if p < q else q) + radius) / slope
        elif slope < -1e-9:
            far = ((p if p > q else q) + radius) / -slope
        far = far if far > 0.0 else 0.0
        self.far = far if far < self.far else self.far

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _columns(self, j: cython.Py_ssize_t, whole: SweptBody) -> cython.void:
        """Find the columns of a row that the line may reach: `first` to `last`."""
        columns: cython.Py_ssize_t = self.counts.shape[1]
        v: cython.double = j * self.cell
        whole.low, whole.high = self.lowest, self.highest
        # Strips along the way of the shank, and along that of the tip.
        whole.narrow(whole.zu, whole.zv, self.pu, self.pv, self.qu, self.qv, self.far, v)
        whole.narrow(self.qu - self.pu, self.qv - self.pv, self.pu, self.pv, self.qu, self.qv, self.far, v)
        self.first, self.last = 0, -1
        if whole.high < 0.0 or whole.low > (columns - 1) * self.cell or whole.high < whole.low:
            return
        if whole.low > 0.0:
            self.first = cython.cast(cython.Py_ssize_t, ceil(whole.low / self.cell))
        self.last = columns - 1
        if whole.high < (columns - 1) * self.cell:
            self.last = cython.cast(cython.Py_ssize_t, floor(whole.high / self.cell))

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _cut(
        self,
        lines: cython.double[:, ::1],
        k: cython.Py_ssize_t,
        judged: cython.bint,
        whole: SweptBody,
        inner: SweptBody,
        out: cython.double[:, ::1],
    ) -> cython.bint:
        """Cut along one line, a square after the other; tell whether all dexels had places enough."""
        if not self._take(lines, k, whole):
            return True
        for row in range(self.first_row // _SQUARE, self.last_row // _SQUARE + 1):
            low, high = self.counts.shape[1], -1
            for j in range(_SQUARE):
                self.first, self.last = 0, -1
                if self.first_row <= row * _SQUARE + j <= self.last_row:
                    self._columns(row * _SQUARE + j, whole)
                self.reached[j, 0], self.reached[j, 1] = self.first, self.last
                if self.first <= self.last:
                    low = self.first if self.first < low else low
                    high = self.last if self.last > high else high
            if high < 0:
                continue
            for column in range(low // _SQUARE, high // _SQUARE + 1):
                if self._clears(row, column, whole):
                    continue
                if not self._square(k, row, column, judged, whole, inner, out):
                    return False
                self._note_gap(row, column, whole)
        return True

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _clears(self, row: cython.Py_ssize_t, column: cython.Py_ssize_t, whole: SweptBody) -> cython.bint:
        """Tell whether the tool stays within the gap of a square, and keep the planes that would tell it of one dexel."""
        half: cython.double = 0.5 * (_SQUARE - 1) * self.cell
        self.low = self.high = -1.0
        self.low_u = self.low_v = self.low_w = self.high_u = self.high_v = self.high_w = 0.0
        if self.gaps[row, column, 0] > ENDLESS:
            return False
        whole.place(self.u0 + column * _SQUARE * self.cell + half, self.v0 + row * _SQUARE * self.cell + half)
        low: cython.double = self.gaps[row, column, 0]
        high: cython.double = self.gaps[row, column, 3]
        below = whole.beyond(low, self.gaps[row, column, 1], self.gaps[row, column, 2], half, -1.0)
        if low >= -ENDLESS and whole.fw <= 0.0:
            self.low = whole.value - whole.fw * low
            self.low_u, self.low_v, self.low_w = whole.fu, whole.fv, whole.fw
        above = whole.beyond(high, self.gaps[row, column, 4], self.gaps[row, column, 5], half, 1.0)
        if high <= ENDLESS and whole.fw >= 0.0:
            self.high = whole.value - whole.fw * high
            self.high_u, self.high_v, self.high_w = whole.fu, whole.fv, whole.fw
        return below and above

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _square(
        self,
        k: cython.Py_ssize_t,
        row: cython.Py_ssize_t,
        column: cython.Py_ssize_t,
        judged: cython.bint,
        whole: SweptBody,
        inner: SweptBody,
        out: cython.double[:, ::1],
    ) -> cython.bint:
        """Cut the dexels of a square; tell whether all had places enough."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        first: cython.Py_ssize_t
        last: cython.Py_ssize_t
        du: cython.double
        dv: cython.double
        low: cython.double
        high: cython.double
        for j in range(_SQUARE):
            first, last = column * _SQUARE, column * _SQUARE + _SQUARE - 1
            first = self.reached[j, 0] if self.reached[j, 0] > first else first
            last = self.reached[j, 1] if self.reached[j, 1] < last else last
            # The planes over this row: at the square's middle u, and their changes from one dexel to the next.
            du = self.cell * (first - column * _SQUARE - 0.5 * (_SQUARE - 1))
            dv = self.cell * (j - 0.5 * (_SQUARE - 1))
            low = self.low + du * self.low_u + dv * self.low_v - 2.0 * CLOSE
            high = self.high + du * self.high_u + dv * self.high_v - 2.0 * CLOSE
            for i in range(first, last + 1):
                if not self._missed(row * _SQUARE + j, i, low, high, whole) and (
                    whole.line() and not self._dexel(k, row * _SQUARE + j, i, judged, whole, inner, out)
                ):
                    return False
                low += self.cell * self.low_u
                high += self.cell * self.high_u
        return True

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _missed(
        self,
        j: cython.Py_ssize_t,
        i: cython.Py_ssize_t,
        low: cython.double,
        high: cython.double,
        whole: SweptBody,
    ) -> cython.bint:
        """Take a dexel as the line at hand; tell whether the body is sure to miss all of it.

        The planes of its square have the values `low` and `high` there.
        """
        placed: cython.bint = False
        for a in range(self.counts[j, i]):
            start, end = self.ends[j, i, 2 * a], self.ends[j, i, 2 * a + 1]
            if low + end * self.low_w > 0.0 or high + start * self.high_w > 0.0:
                continue
            if not placed:
                placed = True
                whole.place(self.u0 + i * self.cell, self.v0 + j * self.cell)
            if not whole.misses(start, end):
                return False
        return True

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _dexel(
        self,
        k: cython.Py_ssize_t,
        j: cython.Py_ssize_t,
        i: cython.Py_ssize_t,
        judged: cython.bint,
        whole: SweptBody,
        inner: SweptBody,
        out: cython.double[:, ::1],
    ) -> cython.bint:
        """Cut the dexel on the line at hand; tell whether it had places enough."""
        room: cython.Py_ssize_t = self.ends.shape[2] // 2
        count: cython.int = self.counts[j, i]
        a: cython.int = 0
        lined: cython.bint = False
        touched: cython.bint = False
        self.deep = self.gouge = 0.0
        self.above = self.at = -1e300
        while a < self.counts[j, i]:
            start, end = self.ends[j, i, 2 * a], self.ends[j, i, 2 * a + 1]
            if not whole.between(start, end) or whole.high - whole.low <= _NOTHING:
                a += 1
                continue
            lo, hi = whole.low, whole.high
            if self.counts[j, i] == room and start < lo and hi < end and not self.dry:
                return False
            # A bite that is not deeper than the deepest says nothing more.
            if judged and (
                count > 1 or hi - lo > out[k, 1] or self.part_counts.shape[0] > 0 or self.edge_length < 1e300
            ):
                if not lined:
                    lined = True
                    inner.place(self.u0 + i * self.cell, self.v0 + j * self.cell)
                    touched = inner.line()
                if touched and inner.between(lo, hi):
                    self._judge(j, i, lo, hi, inner)
            if self.dry:
                a += 1
            else:
                out[k, 0] += (hi - lo) * self.cell * self.cell
                a = _subtract(self.ends, self.counts, j, i, a, lo, hi)
        if self.deep > 0.0:
            self._tell(k, self.u0 + i * self.cell, self.v0 + j * self.cell, out)
        return True

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _judge(
        self,
        j: cython.Py_ssize_t,
        i: cython.Py_ssize_t,
        lo: cython.double,
        hi: cython.double,
        inner: SweptBody,
    ) -> cython.void:
        """Judge the cut of a dexel between two places: the touch of the smaller tool counts as far as the whole tool cuts."""
        self.at = inner.low if self.at < -1e299 else self.at
        size = inner.above(inner.low)
        self.above = size if size > self.above else self.above
        size = inner.above(inner.high)
        self.above = size if size > self.above else self.above
        self.deep += hi - lo
        if self.part_counts.shape[0]:
            for b in range(self.part_counts[j, i]):
                begin, until = self.parts[j, i, 2 * b], self.parts[j, i, 2 * b + 1]
                if _shared(begin, until, inner.low, inner.high) > 0.0:
                    self.gouge += _shared(begin, until, lo, hi)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _tell(
        self, k: cython.Py_ssize_t, u: cython.double, v: cython.double, out: cython.double[:, ::1]
    ) -> cython.void:
        """Add the judgement of a dexel to the result."""
        if self.deep > out[k, 1]:
            out[k, 1] = self.deep
            out[k, 2], out[k, 3], out[k, 4] = u, v, self.at
        if self.gouge > out[k, 5]:
            out[k, 5] = self.gouge
            out[k, 6], out[k, 7], out[k, 8] = u, v, self.at
        out[k, 9] += self.gouge * self.cell * self.cell
        if self.above - self.edge_length > out[k, 10]:
            out[k, 10] = self.above - self.edge_length

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _note_gap(self, row: cython.Py_ssize_t, column: cython.Py_ssize_t, whole: SweptBody) -> cython.void:
        """Note the gap of a square where the tool is, between planes as steep as the tool is over its middle."""
        half: cython.double = 0.5 * (_SQUARE - 1) * self.cell
        low_a: cython.double = 0.0
        low_b: cython.double = 0.0
        high_a: cython.double = 0.0
        high_b: cython.double = 0.0
        low: cython.double = -1e300
        high: cython.double = 1e300
        begin: cython.double
        end: cython.double
        place: cython.double
        du: cython.double
        dv: cython.double
        a: cython.int
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        last: cython.Py_ssize_t = column * _SQUARE + _SQUARE
        last_row: cython.Py_ssize_t = row * _SQUARE + _SQUARE
        last = last if last < self.counts.shape[1] else self.counts.shape[1]
        last_row = last_row if last_row < self.counts.shape[0] else self.counts.shape[0]
        # A place that is within the tool: towards the shank it is empty sooner.
        place = 0.5 * (self.pw + self.qw)
        if whole.zw > 0.5:
            place = self.top
        elif whole.zw < -0.5:
            place = self.bottom
        whole.place(self.u0 + column * _SQUARE * self.cell + half, self.v0 + row * _SQUARE * self.cell + half)
        if whole.line() and whole.between(self.bottom, self.top):
            begin, end = whole.low, whole.high
            place = end if whole.zw > 0.5 else (begin if whole.zw < -0.5 else 0.5 * (begin + end))
            whole.tangent(begin)
            if whole.fw < -1e-3:
                low_a, low_b = _bounded(-whole.fu / whole.fw), _bounded(-whole.fv / whole.fw)
            whole.tangent(end)
            if whole.fw > 1e-3:
                high_a, high_b = _bounded(-whole.fu / whole.fw), _bounded(-whole.fv / whole.fw)
        for j in range(row * _SQUARE, last_row):
            dv = (j - row * _SQUARE) * self.cell - half
            for i in range(column * _SQUARE, last):
                du = (i - column * _SQUARE) * self.cell - half
                begin, end = -1e300, 1e300
                for a in range(self.counts[j, i]):
                    if self.ends[j, i, 2 * a + 1] <= place:
                        begin = self.ends[j, i, 2 * a + 1]
                    elif self.ends[j, i, 2 * a] >= place:
                        end = self.ends[j, i, 2 * a]
                        break
                    else:
                        # Not a gap of this dexel.
                        self.gaps[row, column, 0] = 1e300
                        return
                if begin > -ENDLESS:
                    begin -= low_a * du + low_b * dv
                    low = begin if begin > low else low
                if end < ENDLESS:
                    end -= high_a * du + high_b * dv
                    high = end if end < high else high
        self.gaps[row, column, 0] = low
        self.gaps[row, column, 1] = low_a
        self.gaps[row, column, 2] = low_b
        self.gaps[row, column, 3] = high
        self.gaps[row, column, 4] = high_a
        self.gaps[row, column, 5] = high_b


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _bounded(slope: cython.double) -> cython.double:
    """Return a slope, `_STEEPEST` at most."""
    return _STEEPEST if slope > _STEEPEST else (-_STEEPEST if slope < -_STEEPEST else slope)


def cut_lines(
    ends: cython.double[:, :, ::1],
    counts: cython.int[:, ::1],
    parts: cython.double[:, :, ::1],
    part_counts: cython.int[:, ::1],
    gaps: cython.double[:, :, ::1],
    reached: cython.longlong[:, ::1],
    grid: cython.double[::1],
    bounds: cython.double[::1],
    lines: cython.double[:, ::1],
    axes: cython.double[:, ::1],
    judged: cython.uchar[::1],
    tool: cython.double[::1],
    margins: cython.double[:, ::1],
    dry: cython.bint,
    first: cython.Py_ssize_t,
    out: cython.double[:, ::1],
) -> cython.Py_ssize_t:
    """Cut a field of dexels along straight lines, one after the other.

    Args:
        ends: Shape (rows, columns, 2 k): where stretches of material begin and end along w, rising, mm; changed in place.
        counts: Shape (rows, columns): how many stretches there are.
        parts, part_counts: The finished part alike, of shape (0, 0, 0) and (0, 0) if unknown.
        gaps: Shape (rows / SQUARE, columns / SQUARE, GAP), rounded up: the gap of each square of dexels, its first number 1e300 if
            unknown; changed in place.
        reached: Shape (SQUARE, 2), for the kernel's own use.
        grid: u and v of the first dexel, and their distance, mm.
        bounds: Least and largest w of the material, mm.
        lines: Shape (n, 6): start and end of the tip, (u, v, w), mm.
        axes: Shape (n, 3): the tool's axis during each, of length 1, away from the tip.
        judged: Shape (n,): 1 for lines whose depths are computed, else only volumes are.
        tool: Radius, flat radius, radius of the edge, slope of the cone, length of the cutting edge, mm.
        margins: Shape (n, 2): at the tool's side and at its tip, within which a touch does not count, mm.
        dry: Nothing is cut; depths and heights are computed.
        first: The line to begin with.
        out: Shape (n, COLUMNS), added to: volume removed; the deepest bite and its u, v, w; the deepest gouge of the part, and its
            u, v, w; the volume gouged; how far material stands above the cutting edge. mm, mm³.

    Returns:
        The line for which a dexel has too few places, to go on with; n where all are cut.
    """
    n: cython.Py_ssize_t = lines.shape[0]
    done: cython.Py_ssize_t = n
    whole: SweptBody = SweptBody()
    inner: SweptBody = SweptBody()
    field: _Field = _Field()
    field.ends, field.counts, field.parts, field.part_counts = ends, counts, parts, part_counts
    field.gaps, field.reached = gaps, reached
    field.u0, field.v0, field.cell = grid[0], grid[1], grid[2]
    field.bottom, field.top = bounds[0], bounds[1]
    field.edge_length, field.dry = tool[4], dry
    with cython.nogil:
        for k in range(first, n):
            whole.take(lines, axes, k, tool, 0.0, 0.0)
            if judged[k]:
                inner.take(lines, axes, k, tool, margins[k, 0], margins[k, 1])
            if not field._cut(lines, k, judged[k], whole, inner, out):
                done = k
                break
    return done


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _shared(a: cython.double, b: cython.double, low: cython.double, high: cython.double) -> cython.double:
    """Return how much of a stretch from a to b is between two places."""
    a = a if a > low else low
    b = b if b < high else high
    return b - a if b > a else 0.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _subtract(
    ends: cython.double[:, :, ::1],
    counts: cython.int[:, ::1],
    j: cython.Py_ssize_t,
    i: cython.Py_ssize_t,
    a: cython.int,
    lo: cython.double,
    hi: cython.double,
) -> cython.int:
    """Take an interval from a stretch of a dexel, which has a place more if that parts it; return the stretch to go on with."""
    count: cython.int = counts[j, i]
    left: cython.bint = lo - ends[j, i, 2 * a] > _NOTHING
    right: cython.bint = ends[j, i, 2 * a + 1] - hi > _NOTHING
    b: cython.int
    if left and right:
        for b in range(count - 1, a, -1):
            ends[j, i, 2 * b + 2], ends[j, i, 2 * b + 3] = ends[j, i, 2 * b], ends[j, i, 2 * b + 1]
        ends[j, i, 2 * a + 2], ends[j, i, 2 * a + 3] = hi, ends[j, i, 2 * a + 1]
        counts[j, i] = count + 1
    if left:
        ends[j, i, 2 * a + 1] = lo
    elif right:
        ends[j, i, 2 * a] = hi
    else:
        for b in range(a, count - 1):
            ends[j, i, 2 * b], ends[j, i, 2 * b + 1] = ends[j, i, 2 * b + 2], ends[j, i, 2 * b + 3]
        counts[j, i] = count - 1
        return a
    return a + 1
