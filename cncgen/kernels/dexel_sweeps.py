"""Material removal on dexels: the swept volume of a tool that leans, cut from lines of material along one direction.

A field of dexels is a grid of lines along w over places (u, v); each holds the stretches of it that are material. A tool that moves
straight while its axis keeps its direction sweeps a convex body: the tool of `removal`, convex and without an end upwards, drawn
along a segment. So a line meets it in one interval. In the frame of the tool (z along its axis, x along its way across it) the
body is the points above the envelope of `removal`, over a stadium round the way. On the stretch of a line that is over the
stadium, the envelope less the height is convex, and Newton's method from either end goes to the interval's ends without passing them.
"""

import cython
from cython.cimports.libc.math import ceil, fabs, floor, sqrt

if cython.compiled:
    from cython.cimports.cncgen.kernels.removal import lift, lowest_at
else:
    from cncgen.kernels.removal import lift, lowest_at

#: Columns of the result of `cut_lines`.
COLUMNS = 11
#: Steps of Newton's method, at most, the distance at which it ends, and its least step, mm.
_STEPS = cython.declare(cython.int, 60)
_CLOSE = cython.declare(cython.double, 1e-8)
#: A shorter way across the axis is none, mm: along the axis a rise by it would be without end.
_ACROSS = cython.declare(cython.double, 1e-4)
#: Shorter stretches of material are none, mm.
_NOTHING = cython.declare(cython.double, 1e-9)


@cython.final
@cython.cclass
class _Sweep:
    """A straight motion of a tool whose axis keeps its direction."""

    radius: cython.double
    flat: cython.double
    edge: cython.double
    slope: cython.double
    # The frame of the tool at the start of the motion: its origin, and x, y, z seen from the field.
    ou: cython.double
    ov: cython.double
    ow: cython.double
    xu: cython.double
    xv: cython.double
    xw: cython.double
    yu: cython.double
    yv: cython.double
    yw: cython.double
    zu: cython.double
    zv: cython.double
    zw: cython.double
    # Its way across the axis, how far it rises along the axis a mm of that, and the lowest place of one that goes nowhere else.
    length: cython.double
    rise: cython.double
    base: cython.double
    # The line at hand: its point at w = 0 in the frame.
    x: cython.double
    y: cython.double
    z: cython.double
    enter: cython.double
    leave: cython.double
    # Results: of `_clear` the envelope above a point and its change along w, of `_between` the ends.
    over: cython.double
    change: cython.double
    low: cython.double
    high: cython.double

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _take(
        self,
        lines: cython.double[:, ::1],
        axes: cython.double[:, ::1],
        k: cython.Py_ssize_t,
        tool: cython.double[::1],
        side: cython.double,
        tip: cython.double,
    ) -> cython.void:
        """Take a motion, of a tool that is smaller by a margin at its side, and higher by one at its tip."""
        self.radius = tool[0] - side
        self.flat = tool[1] if tool[1] < self.radius else self.radius
        self.edge = tool[2]
        self.slope = tool[3]
        self.zu, self.zv, self.zw = axes[k, 0], axes[k, 1], axes[k, 2]
        self.ou = lines[k, 0] + tip * self.zu
        self.ov = lines[k, 1] + tip * self.zv
        self.ow = lines[k, 2] + tip * self.zw
        tu: cython.double = lines[k, 3] - lines[k, 0]
        tv: cython.double = lines[k, 4] - lines[k, 1]
        tw: cython.double = lines[k, 5] - lines[k, 2]
        along: cython.double = tu * self.zu + tv * self.zv + tw * self.zw
        tu, tv, tw = tu - along * self.zu, tv - along * self.zv, tw - along * self.zw
        self.length = sqrt(tu * tu + tv * tv + tw * tw)
        self.base = 0.0
        self.rise = 0.0
        if self.length > _ACROSS:
            self.rise = along / self.length
            self.xu, self.xv, self.xw = tu / self.length, tv / self.length, tw / self.length
        else:
            self.length = 0.0
            self.base = along if along < 0.0 else 0.0
            # Any direction across the axis.
            if fabs(self.zw) < 0.9:
                tu, tv, tw = self.zv, -self.zu, 0.0
            else:
                tu, tv, tw = 0.0, self.zw, -self.zv
            along = sqrt(tu * tu + tv * tv + tw * tw)
            self.xu, self.xv, self.xw = tu / along, tv / along, tw / along
        self.yu = self.zv * self.xw - self.zw * self.xv
        self.yv = self.zw * self.xu - self.zu * self.xw
        self.yw = self.zu * self.xv - self.zv * self.xu

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _disc(self, x: cython.double, y: cython.double) -> cython.void:
        """Widen `enter` to `leave` to where the line at hand, whose distance from a disc's middle is (x, y) at w = 0, is over the disc."""
        across: cython.double = self.xw * self.xw + self.yw * self.yw
        middle: cython.double = -(x * self.xw + y * self.yw) / across
        apart: cython.double = x * self.yw - y * self.xw
        wide: cython.double = self.radius * self.radius * across - apart * apart
        if wide <= 0.0:
            return
        wide = sqrt(wide) / across
        self.enter = middle - wide if middle - wide < self.enter else self.enter
        self.leave = middle + wide if middle + wide > self.leave else self.leave

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _clear(self, w: cython.double) -> cython.void:
        """Find how far the envelope is above the line at hand at w (below it: negative), and how that changes along w."""
        x: cython.double = self.x + w * self.xw
        y: cython.double = self.y + w * self.yw
        m: cython.double = self.rise
        d: cython.double = fabs(y)
        s: cython.double = lowest_at(x, d, self.length, m, self.radius, self.flat, self.edge, self.slope)
        gx: cython.double = 0.0
        gy: cython.double = 0.0
        rho: cython.double
        over: cython.double
        steep: cython.double
        rho = sqrt(y * y + (x - s) * (x - s))
        rho = self.radius if rho > self.radius else rho
        self.over = self.base + m * s + lift(rho, self.flat, self.edge, self.slope) - (self.z + w * self.zw)
        if m != 0.0 and 0.0 < s < self.length:
            # The tool touches ahead of or behind the foot, where it rises as its way does; at its rim it is upright.
            over = fabs(x - s)
            gx = m
            gy = fabs(m) * y / (over if over > 1e-9 else 1e-9)
        elif rho > 0.0:
            over = rho - self.flat
            if over <= 0.0:
                steep = 0.0
            elif self.edge > 0.0:
                over = over if over < self.edge * (1.0 - 1e-12) else self.edge * (1.0 - 1e-12)
                steep = over / sqrt(self.edge * self.edge - over * over)
            else:
                steep = self.slope
            # Beyond the upper end of the way the tool's rim is as steep as the way.
            over = (x - s if s > 0.0 else 0.0) if m > 0.0 else (-x if s <= 0.0 else 0.0)
            if over > 0.0 and steep * over < fabs(m) * rho:
                steep = fabs(m) * rho / (over if over > 1e-9 else 1e-9)
            gx = steep * (x - s) / rho
            gy = steep * y / rho
        self.change = gx * self.xw + gy * self.yw - self.zw

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _line(self, u: cython.double, v: cython.double) -> cython.bint:
        """Take a line of the field; find where it is over the stadium (`enter` to `leave`), and tell whether it is anywhere."""
        a: cython.double
        b: cython.double
        low: cython.double = -1e300
        high: cython.double = 1e300
        u, v = u - self.ou, v - self.ov
        self.x = self.xu * u + self.xv * v - self.xw * self.ow
        self.y = self.yu * u + self.yv * v - self.yw * self.ow
        self.z = self.zu * u + self.zv * v - self.zw * self.ow
        if self.xw * self.xw + self.yw * self.yw <= 1e-18:
            self.enter, self.leave = low, high
            a = self.x - (0.0 if self.x < 0.0 else (self.length if self.x > self.length else self.x))
            return a * a + self.y * self.y <= self.radius * self.radius
        self.enter, self.leave = 1e300, -1e300
        self._disc(self.x, self.y)
        self._disc(self.x - self.length, self.y)
        # Between the discs.
        if fabs(self.xw) > 1e-12:
            a, b = -self.x / self.xw, (self.length - self.x) / self.xw
            low, high = (a, b) if a < b else (b, a)
        elif self.x < 0.0 or self.x > self.length:
            high = -2e300
        if fabs(self.yw) > 1e-12:
            a, b = (-self.radius - self.y) / self.yw, (self.radius - self.y) / self.yw
            if a > b:
                a, b = b, a
            low, high = low if low > a else a, high if high < b else b
        elif fabs(self.y) > self.radius:
            high = -2e300
        if low < high:
            self.enter = low if low < self.enter else self.enter
            self.leave = high if high > self.leave else self.leave
        return self.enter < self.leave

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _root(self, w: cython.double, last: cython.double) -> cython.double:
        """Return where the line at hand goes into the body, from w, outside of it, towards a last place; 1e300 if nowhere before."""
        step: cython.double
        k: cython.int
        up: cython.bint = last > w
        for k in range(_STEPS):
            self._clear(w)
            if self.over <= _CLOSE:
                break
            if self.change >= 0.0 if up else self.change <= 0.0:
                return 1e300
            # Where the tool is upright the change is infinite, and a step is nothing.
            step = self.over / fabs(self.change)
            step = step if step > _CLOSE else _CLOSE
            w = w + step if up else w - step
            if w >= last if up else w <= last:
                return 1e300
        return w

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _between(self, low: cython.double, high: cython.double) -> cython.bint:
        """Find where the line at hand is within the body between two places (`low` to `high`); tell whether it is anywhere."""
        over: cython.double
        change: cython.double
        w: cython.double
        low = low if low > self.enter else self.enter
        high = high if high < self.leave else self.leave
        if low >= high:
            return False
        # Most lines have been cut by the motions before and miss the body at one end, where the envelope rises away from it.
        self._clear(high)
        over, change = self.over, self.change
        if over > _CLOSE and change <= 0.0:
            return False
        self._clear(low)
        if self.over > _CLOSE:
            if self.change >= 0.0:
                return False
            # The envelope is above both tangents, so nowhere below where they meet.
            if over > _CLOSE:
                w = (over - self.over - change * (high - low)) / (self.change - change)
                if self.over + self.change * w > _CLOSE:
                    return False
            w = high - over / change if over <= _CLOSE and change < 0.0 else low
            self.low = self._root(w if w > low else low, high)
        else:
            self.low = low
        if over > _CLOSE:
            # From within, a step goes beyond the end.
            w = low - self.over / self.change if self.low == low and self.change > 0.0 else high
            self.high = self._root(w if w < high else high, low)
        else:
            self.high = high
        return self.low < self.high < 1e300

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _narrow(
        self,
        du: cython.double,
        dv: cython.double,
        pu: cython.double,
        pv: cython.double,
        qu: cython.double,
        qv: cython.double,
        far: cython.double,
        v: cython.double,
    ) -> cython.void:
        """Narrow the result, places u of a row at v, to the strip along a direction that holds the tool on its way from p to q."""
        size: cython.double = sqrt(du * du + dv * dv)
        if size < 1e-9 or fabs(dv) < 1e-9 * size:
            return
        nu: cython.double = -dv / size
        nv: cython.double = du / size
        start: cython.double = nu * pu + nv * pv
        end: cython.double = nu * qu + nv * qv
        shank: cython.double = far * (nu * self.zu + nv * self.zv)
        if start > end:
            start, end = end, start
        start = (start - self.radius + (shank if shank < 0.0 else 0.0) - nv * v) / nu
        end = (end + self.radius + (shank if shank > 0.0 else 0.0) - nv * v) / nu
        if start > end:
            start, end = end, start
        self.low = start if start > self.low else self.low
        self.high = end if end < self.high else self.high

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _above(self, w: cython.double) -> cython.double:
        """Return how far the line at hand is above the tip, along the axis, when the tool passes it."""
        x: cython.double = self.x + w * self.xw
        x = 0.0 if x < 0.0 else (self.length if x > self.length else x)
        return self.z + w * self.zw - self.base - self.rise * x


def cut_lines(
    ends: cython.double[:, :, ::1],
    counts: cython.int[:, ::1],
    parts: cython.double[:, :, ::1],
    part_counts: cython.int[:, ::1],
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
        parts, part_counts: The finished part alike, of shape (0, 0, 0) and (0, 0) where it is not known.
        grid: u and v of the first dexel, and their distance, mm.
        bounds: Least and largest w of the material, mm.
        lines: Shape (n, 6): start and end of the tip, (u, v, w), mm.
        axes: Shape (n, 3): the tool's axis during each, of length 1, away from the tip.
        judged: Shape (n,): lines whose depths are told, 1, else their volumes alone.
        tool: Radius, flat radius, radius of the edge, slope of the cone, length of the cutting edge, mm.
        margins: Shape (n, 2): at the tool's side and at its tip, within which a touch does not count, mm.
        dry: Nothing is cut; depths and heights are told.
        first: The line to begin with.
        out: Shape (n, COLUMNS), added to: volume removed; the deepest bite and its u, v, w; the deepest gouge of the
            part, and its u, v, w; the volume gouged; how far material stands above the cutting edge. mm, mm³.

    Returns:
        The line for which a dexel has too few places, to go on with; n where all are cut.
    """
    n: cython.Py_ssize_t = lines.shape[0]
    k: cython.Py_ssize_t
    done: cython.Py_ssize_t = n
    whole: _Sweep = _Sweep()
    inner: _Sweep = _Sweep()
    with cython.nogil:
        for k in range(first, n):
            whole._take(lines, axes, k, tool, 0.0, 0.0)
            if judged[k]:
                inner._take(lines, axes, k, tool, margins[k, 0], margins[k, 1])
            if not _cut(
                ends,
                counts,
                parts,
                part_counts,
                grid,
                bounds,
                lines,
                k,
                judged[k],
                tool[4],
                dry,
                whole,
                inner,
                out,
            ):
                done = k
                break
    return done


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cut(
    ends: cython.double[:, :, ::1],
    counts: cython.int[:, ::1],
    parts: cython.double[:, :, ::1],
    part_counts: cython.int[:, ::1],
    grid: cython.double[::1],
    bounds: cython.double[::1],
    lines: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    judged: cython.bint,
    edge_length: cython.double,
    dry: cython.bint,
    whole: _Sweep,
    inner: _Sweep,
    out: cython.double[:, ::1],
) -> cython.bint:
    """Cut along one line; tell whether all dexels had places enough."""
    cell: cython.double = grid[2]
    rows: cython.Py_ssize_t = counts.shape[0]
    columns: cython.Py_ssize_t = counts.shape[1]
    room: cython.Py_ssize_t = ends.shape[2] // 2
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    first_row: cython.Py_ssize_t
    last_row: cython.Py_ssize_t
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t
    a: cython.int
    b: cython.int
    count: cython.int
    radius: cython.double = whole.radius
    pu: cython.double = lines[k, 0] - grid[0]
    pv: cython.double = lines[k, 1] - grid[1]
    pw: cython.double = lines[k, 2]
    qu: cython.double = lines[k, 3] - grid[0]
    qv: cython.double = lines[k, 4] - grid[1]
    qw: cython.double = lines[k, 5]
    wide: cython.double = radius * sqrt(1.0 - whole.zw * whole.zw) if fabs(whole.zw) < 1.0 else 0.0
    far: cython.double = 1e6
    u: cython.double
    v: cython.double
    lo: cython.double
    hi: cython.double
    size: cython.double
    lowest: cython.double
    highest: cython.double
    deep: cython.double
    gouge: cython.double
    above: cython.double
    at: cython.double
    start: cython.double
    end: cython.double
    begin: cython.double
    until: cython.double
    lined: cython.bint
    touched: cython.bint = False
    # How far the shank goes until it has left the material.
    if whole.zw > 1e-9:
        far = (bounds[1] - (pw if pw < qw else qw) + wide) / whole.zw
    elif whole.zw < -1e-9:
        far = ((pw if pw > qw else qw) + wide - bounds[0]) / -whole.zw
    elif (pw if pw < qw else qw) - radius > bounds[1] or (pw if pw > qw else qw) + radius < bounds[0]:
        return True
    if far < 0.0:
        return True
    far = far if far < 1e6 else 1e6
    size = radius * sqrt(1.0 - whole.zv * whole.zv) if fabs(whole.zv) < 1.0 else 0.0
    lo = (pv if pv < qv else qv) - size + (far * whole.zv if whole.zv < 0.0 else 0.0)
    hi = (pv if pv > qv else qv) + size + (far * whole.zv if whole.zv > 0.0 else 0.0)
    if hi < 0.0 or lo > (rows - 1) * cell:
        return True
    first_row = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
    last_row = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (rows - 1) * cell else rows - 1
    size = radius * sqrt(1.0 - whole.zu * whole.zu) if fabs(whole.zu) < 1.0 else 0.0
    lowest = (pu if pu < qu else qu) - size + (far * whole.zu if whole.zu < 0.0 else 0.0)
    highest = (pu if pu > qu else qu) + size + (far * whole.zu if whole.zu > 0.0 else 0.0)
    for j in range(first_row, last_row + 1):
        v = j * cell
        whole.low, whole.high = lowest, highest
        # Strips along the way of the shank, and along that of the tip.
        whole._narrow(whole.zu, whole.zv, pu, pv, qu, qv, far, v)
        whole._narrow(qu - pu, qv - pv, pu, pv, qu, qv, far, v)
        lo, hi = whole.low, whole.high
        if hi < 0.0 or lo > (columns - 1) * cell or hi < lo:
            continue
        first = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
        last = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (columns - 1) * cell else columns - 1
        for i in range(first, last + 1):
            count = counts[j, i]
            if count == 0:
                continue
            u = grid[0] + i * cell
            if not whole._line(u, grid[1] + v):
                continue
            deep = gouge = 0.0
            above = at = -1e300
            lined = False
            a = 0
            while a < counts[j, i]:
                start, end = ends[j, i, 2 * a], ends[j, i, 2 * a + 1]
                if not whole._between(start, end) or whole.high - whole.low <= _NOTHING:
                    a += 1
                    continue
                lo, hi = whole.low, whole.high
                if counts[j, i] == room and start < lo and hi < end and not dry:
                    return False
                if judged and (
                    count > 1 or hi - lo > out[k, 1] or part_counts.shape[0] > 0 or edge_length < 1e300
                ):
                    if not lined:
                        lined = True
                        touched = inner._line(u, grid[1] + v)
                    if touched and inner._between(lo, hi):
                        at = inner.low if at < -1e299 else at
                        size = inner._above(inner.low)
                        above = size if size > above else above
                        size = inner._above(inner.high)
                        above = size if size > above else above
                        # What the smaller tool touches counts as far as the whole one cuts.
                        deep += hi - lo
                        if part_counts.shape[0]:
                            for b in range(part_counts[j, i]):
                                begin, until = parts[j, i, 2 * b], parts[j, i, 2 * b + 1]
                                if _shared(begin, until, inner.low, inner.high) > 0.0:
                                    gouge += _shared(begin, until, lo, hi)
                if dry:
                    a += 1
                else:
                    out[k, 0] += (hi - lo) * cell * cell
                    a = _subtract(ends, counts, j, i, a, lo, hi)
            if deep > 0.0:
                if deep > out[k, 1]:
                    out[k, 1] = deep
                    out[k, 2], out[k, 3], out[k, 4] = u, grid[1] + v, at
                if gouge > out[k, 5]:
                    out[k, 5] = gouge
                    out[k, 6], out[k, 7], out[k, 8] = u, grid[1] + v, at
                out[k, 9] += gouge * cell * cell
                if above - edge_length > out[k, 10]:
                    out[k, 10] = above - edge_length
    return True


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


def mesh_crossings(
    triangles: cython.double[:, :, ::1],
    grid: cython.double[::1],
    rows: cython.Py_ssize_t,
    columns: cython.Py_ssize_t,
    dexel: cython.longlong[::1],
    place: cython.double[::1],
    sense: cython.schar[::1],
) -> cython.Py_ssize_t:
    """Find where a mesh crosses dexels.

    Args:
        triangles: Shape (n, 3, 3), corners (u, v, w), mm.
        grid: As of `cut_lines`; no dexel may go through an edge of a triangle.
        rows, columns: Of the field.
        dexel, place, sense: Shape (m,), filled: number of the dexel, row by row; w, mm; 1 where the line goes into the mesh, -1 where
            it leaves it, by the sense of the triangle's corners.

    Returns:
        How many crossings there are; no more than m are filled in.
    """
    n: cython.Py_ssize_t = triangles.shape[0]
    found: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    cell: cython.double = grid[2]
    ax: cython.double
    ay: cython.double
    bx: cython.double
    by: cython.double
    cx: cython.double
    cy: cython.double
    area: cython.double
    p: cython.double
    q: cython.double
    u: cython.double
    v: cython.double
    lo: cython.double
    hi: cython.double
    i0: cython.Py_ssize_t
    i1: cython.Py_ssize_t
    j0: cython.Py_ssize_t
    j1: cython.Py_ssize_t
    with cython.nogil:
        for k in range(n):
            ax, ay = triangles[k, 0, 0] - grid[0], triangles[k, 0, 1] - grid[1]
            bx, by = triangles[k, 1, 0] - grid[0], triangles[k, 1, 1] - grid[1]
            cx, cy = triangles[k, 2, 0] - grid[0], triangles[k, 2, 1] - grid[1]
            area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
            if area == 0.0:
                continue
            lo = ax if ax < bx else bx
            lo = lo if lo < cx else cx
            hi = ax if ax > bx else bx
            hi = hi if hi > cx else cx
            if hi < 0.0 or lo > (columns - 1) * cell:
                continue
            i0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
            i1 = (
                cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (columns - 1) * cell else columns - 1
            )
            lo = ay if ay < by else by
            lo = lo if lo < cy else cy
            hi = ay if ay > by else by
            hi = hi if hi > cy else cy
            if hi < 0.0 or lo > (rows - 1) * cell:
                continue
            j0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
            j1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (rows - 1) * cell else rows - 1
            for j in range(j0, j1 + 1):
                v = j * cell
                for i in range(i0, i1 + 1):
                    u = i * cell
                    # Shares of the corners b and c.
                    p = ((u - ax) * (cy - ay) - (cx - ax) * (v - ay)) / area
                    q = ((bx - ax) * (v - ay) - (u - ax) * (by - ay)) / area
                    if p < 0.0 or q < 0.0 or p + q > 1.0:
                        continue
                    if found < place.shape[0]:
                        dexel[found] = j * columns + i
                        place[found] = triangles[k, 0, 2] + p * (triangles[k, 1, 2] - triangles[k, 0, 2])
                        place[found] += q * (triangles[k, 2, 2] - triangles[k, 0, 2])
                        # Seen from above, the corners of an upper side go against the clock.
                        sense[found] = -1 if area > 0.0 else 1
                    found += 1
    return found
