"""Material removal on dexels: the swept volume of a tool that leans, cut from lines of material along one direction.

A field of dexels is a grid of lines along w over places (u, v); each holds the stretches of it that are material. A tool that moves
straight while its axis keeps its direction sweeps a convex body: the tool of `removal`, convex and without an end upwards, drawn
along a segment. So a line meets it in one interval. In the frame of the tool (z along its axis, x along its way across it) the
body is the points above the envelope of `removal`, over a stadium round the way. On the stretch of a line that is over the
stadium, the envelope less the height is convex, and Newton's method from either end goes to the interval's ends without passing them.

Most of the lines under a tool have been cut by the motions before. So a square of lines keeps a gap that all of them have, between two
planes over (u, v), which only grows as more is cut. The envelope less the height, and beside the stadium the distance from it, are convex
over space: their tangent plane at one point tells for all the square that the tool stays within the gap.
"""

import cython
from cython.cimports.libc.math import ceil, fabs, floor, sqrt

if cython.compiled:
    from cython.cimports.cncgen.kernels.removal import lift, lowest_at
else:
    from cncgen.kernels.removal import lift, lowest_at

#: Columns of the result of `cut_lines`.
COLUMNS = 11
#: Rows and columns of a square of lines, and the numbers that tell its gap: height over its middle and slopes along u and v of the
#: plane below, and of the one above.
SQUARE = 8
GAP = 6
_SQUARE = cython.declare(cython.Py_ssize_t, SQUARE)
#: A height without end, and one that is not known.
_ENDLESS = cython.declare(cython.double, 1e299)
#: Planes of gaps are not steeper.
_STEEPEST = cython.declare(cython.double, 8.0)
#: Steps of Newton's method, at most, the distance at which it ends, and its least step, mm.
_STEPS = cython.declare(cython.int, 60)
_CLOSE = cython.declare(cython.double, 1e-8)
#: A shorter way across the axis counts as 0, mm: along the axis a rise by it would be without end.
_ACROSS = cython.declare(cython.double, 1e-4)
#: Shorter stretches of material are dropped, mm.
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
    # How far a line of the field goes across the axis a mm, squared, 1 over that, and 1 over its parts along x and y; 0 for without end.
    across: cython.double
    per_across: cython.double
    per_x: cython.double
    per_y: cython.double
    # The squares of the distances from the way that count as beside the tool, and as clear of it.
    beside: cython.double
    clear_of: cython.double
    # The line at hand: its point at w = 0 in the frame.
    x: cython.double
    y: cython.double
    z: cython.double
    enter: cython.double
    leave: cython.double
    # Results: of `_clear` the envelope above a point, whose w is `known`, and its change along w, x and y, of `_between` the ends.
    known: cython.double
    # The last of the places that `_misses` looked at, with the two of `_clear` there.
    seen: cython.double
    seen_over: cython.double
    seen_change: cython.double
    over: cython.double
    change: cython.double
    gx: cython.double
    gy: cython.double
    # Least and largest w of the body, where it ends.
    lowest: cython.double
    highest: cython.double
    # Of `_tangent` the value at a point and its changes along u, v and w.
    value: cython.double
    fu: cython.double
    fv: cython.double
    fw: cython.double
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
        self.beside = self.radius * self.radius * (1.0 - 2e-9)
        self.clear_of = (self.radius + 2.0 * _CLOSE) * (self.radius + 2.0 * _CLOSE)
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
        self.across = self.xw * self.xw + self.yw * self.yw
        self.per_across = 1.0 / self.across if self.across > 1e-18 else 0.0
        self.per_x = 1.0 / self.xw if fabs(self.xw) > 1e-12 else 0.0
        self.per_y = 1.0 / self.yw if fabs(self.yw) > 1e-12 else 0.0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _disc(self, x: cython.double, y: cython.double) -> cython.void:
        """Widen `enter` to `leave` to where the line at hand, whose distance from a disc's middle is (x, y) at w = 0, is over the disc."""
        middle: cython.double = -(x * self.xw + y * self.yw) * self.per_across
        apart: cython.double = x * self.yw - y * self.xw
        wide: cython.double = self.radius * self.radius * self.across - apart * apart
        if wide <= 0.0:
            return
        wide = sqrt(wide) * self.per_across
        self.enter = middle - wide if middle - wide < self.enter else self.enter
        self.leave = middle + wide if middle + wide > self.leave else self.leave

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _clear(self, w: cython.double) -> cython.void:
        """Find how far the envelope is above the line at hand at w (below it: negative), and how that changes along w."""
        if w == self.known:
            return
        self.known = w
        x: cython.double = self.x + w * self.xw
        y: cython.double = self.y + w * self.yw
        m: cython.double = self.rise
        s: cython.double
        gx: cython.double = 0.0
        gy: cython.double = 0.0
        rho: cython.double = self.radius * self.radius - y * y
        over: cython.double
        steep: cython.double
        if self.flat >= self.radius and rho > 0.0:
            # A flat disc touches with its rear or front, at its rim where it is upright.
            rho = sqrt(rho)
            s = x - rho if m > 0.0 else (x + rho if m < 0.0 else x)
            if (s > 0.0 or x >= 0.0 or m >= 0.0) and (s < self.length or x <= self.length or m <= 0.0):
                if m != 0.0 and 0.0 < s < self.length:
                    gx = m
                    gy = fabs(m) * y / (rho if rho > 1e-9 else 1e-9)
                s = 0.0 if s < 0.0 else (self.length if s > self.length else s)
                self.over = self.base + m * s - (self.z + w * self.zw)
                self.gx, self.gy = gx, gy
                self.change = gx * self.xw + gy * self.yw - self.zw
                return
        s = lowest_at(x, fabs(y), self.length, m, self.radius, self.flat, self.edge, self.slope)
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
        self.gx, self.gy = gx, gy
        self.change = gx * self.xw + gy * self.yw - self.zw

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _place(self, u: cython.double, v: cython.double) -> cython.void:
        """Take a line of the field."""
        self.known = self.seen = 1e301
        u, v = u - self.ou, v - self.ov
        self.x = self.xu * u + self.xv * v - self.xw * self.ow
        self.y = self.yu * u + self.yv * v - self.yw * self.ow
        self.z = self.zu * u + self.zv * v - self.zw * self.ow

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _tangent(self, w: cython.double) -> cython.void:
        """Find a plane over space that is positive beyond the body's boundary alone: its value on the line at hand, and its changes."""
        x: cython.double = self.x + w * self.xw
        y: cython.double = self.y + w * self.yw
        gz: cython.double = -1.0
        rho: cython.double
        x = x if x < 0.0 else (x - self.length if x > self.length else 0.0)
        rho = sqrt(x * x + y * y)
        if rho * rho >= self.beside:
            # Beside the stadium.
            self.value = rho - self.radius
            self.gx, self.gy, gz = x / rho, y / rho, 0.0
            self.known = 1e301
        else:
            self._clear(w)
            self.value = self.over
        self.fu = self.gx * self.xu + self.gy * self.yu + gz * self.zu
        self.fv = self.gx * self.xv + self.gy * self.yv + gz * self.zv
        self.fw = self.gx * self.xw + self.gy * self.yw + gz * self.zw

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _beyond(
        self,
        w: cython.double,
        a: cython.double,
        b: cython.double,
        half: cython.double,
        side: cython.double,
    ) -> cython.bint:
        """Tell whether all above (`side` 1) or below (-1) a plane is outside of the body, in a square about the line at hand.

        The plane is w high there, with the slopes a and b; the square reaches `half` to each side.
        """
        if side * w > _ENDLESS:
            return True
        self._tangent(w)
        if side * self.fw < 0.0:
            return False
        return self.value - (fabs(self.fu + self.fw * a) + fabs(self.fv + self.fw * b)) * half > 2.0 * _CLOSE

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _misses(self, start: cython.double, end: cython.double) -> cython.bint:
        """Tell whether the body is sure to miss a stretch of the line at hand, by its tangent plane at one end of it or the other."""
        x: cython.double
        y: cython.double
        w: cython.double = start
        sense: cython.double = 1.0
        if end < self.lowest or start > self.highest:
            return True
        if start + end < self.lowest + self.highest:
            w, sense = end, -1.0
        # As `_tangent` has it, without the changes along u and v.
        x = self.x + w * self.xw
        y = self.y + w * self.yw
        x = x if x < 0.0 else (x - self.length if x > self.length else 0.0)
        if x * x + y * y >= self.beside:
            return x * x + y * y > self.clear_of and sense * (x * self.xw + y * self.yw) >= 0.0
        self._clear(w)
        self.seen, self.seen_over, self.seen_change = w, self.over, self.change
        return self.over > 2.0 * _CLOSE and sense * self.change >= 0.0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _line(self) -> cython.bint:
        """Find where the line at hand is over the stadium (`enter` to `leave`), and tell whether it is anywhere."""
        a: cython.double
        b: cython.double
        low: cython.double = -1e300
        high: cython.double = 1e300
        if self.per_across == 0.0:
            self.enter, self.leave = low, high
            a = self.x - (0.0 if self.x < 0.0 else (self.length if self.x > self.length else self.x))
            return a * a + self.y * self.y <= self.radius * self.radius
        self.enter, self.leave = 1e300, -1e300
        self._disc(self.x, self.y)
        self._disc(self.x - self.length, self.y)
        # Between the discs.
        if self.per_x != 0.0:
            a, b = -self.x * self.per_x, (self.length - self.x) * self.per_x
            low, high = (a, b) if a < b else (b, a)
        elif self.x < 0.0 or self.x > self.length:
            high = -2e300
        if self.per_y != 0.0:
            a, b = (-self.radius - self.y) * self.per_y, (self.radius - self.y) * self.per_y
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
    def _nearer(self, w: cython.double, sense: cython.double) -> cython.double:
        """Return a place nearer to a tool with a rounded edge than w, outside of it, on the line at hand; endless where it misses it.

        Where the edge is upright Newton's method makes small steps. The distance from the way is convex, so no less than its tangent,
        and the tool is nowhere higher over the line than at the lowest end of its way: with the two the edge is a circle, which the
        line meets in closed form.
        """
        x: cython.double = self.x + w * self.xw
        y: cython.double = self.y + w * self.yw
        a: cython.double
        b: cython.double
        da: cython.double
        db: cython.double = -sense * self.zw
        size: cython.double
        half: cython.double
        t: cython.double = 1e300
        found: cython.double
        x = x if x < 0.0 else (x - self.length if x > self.length else 0.0)
        a = sqrt(x * x + y * y)
        if a < 1e-9:
            return w
        da = sense * (x * self.xw + y * self.yw) / a
        # Beyond the flat, and below the upper end of the edge.
        a -= self.flat
        b = self.edge - (self.z + w * self.zw - self.base)
        b += self.rise * self.length if self.rise < 0.0 else 0.0
        if (
            (a <= self.edge and b <= 0.0)
            or (a <= 0.0 and b <= self.edge)
            or (a > 0.0 < b and a * a + b * b <= self.edge * self.edge)
        ):
            return w
        size = da * da + db * db
        if size <= 1e-18:
            return 1e300
        half = a * da + b * db
        found = half * half - size * (a * a + b * b - self.edge * self.edge)
        if found >= 0.0:
            found = (-half - sqrt(found)) / size
            if found >= 0.0 and a + found * da >= 0.0 and b + found * db >= 0.0:
                t = found
        if da < 0.0 and a > self.edge:
            found = (self.edge - a) / da
            if b + found * db <= 0.0:
                t = found if found < t else t
        if db < 0.0 and b > self.edge:
            found = (self.edge - b) / db
            if a + found * da <= 0.0:
                t = found if found < t else t
        # Slightly before it, because of rounding.
        t = t - 1e-9 if t > 1e-9 else 0.0
        return w + sense * t if t < _ENDLESS else sense * 1e300

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _root(self, w: cython.double, last: cython.double) -> cython.double:
        """Return where the line at hand goes into the body, from w, outside of it, towards a last place; 1e300 if nowhere before."""
        step: cython.double
        k: cython.int
        up: cython.bint = last > w
        if self.edge > 0.0:
            w = self._nearer(w, 1.0 if up else -1.0)
            if w >= last if up else w <= last:
                return 1e300
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
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _look(self, w: cython.double) -> cython.void:
        """Find what `_clear` does, but for the changes along x and y, without computing it again where `_misses` has."""
        if w == self.seen and w < 1e300:
            self.known = 1e301
            self.over, self.change = self.seen_over, self.seen_change
        else:
            self._clear(w)

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
        self._look(high)
        over, change = self.over, self.change
        if over > _CLOSE and change <= 0.0:
            return False
        if over <= _CLOSE and change < 0.0 and high - over / change > low:
            # The envelope is above the tangent, so the line below is outside.
            self.low, self.high = self._root(high - over / change, high), high
            return self.low < high
        self._look(low)
        if self.over > _CLOSE:
            if self.change >= 0.0:
                return False
            # The envelope is above both tangents, so nowhere below where they meet.
            if over > _CLOSE:
                w = (over - self.over - change * (high - low)) / (self.change - change)
                if self.over + self.change * w > _CLOSE:
                    return False
            self.low = self._root(low, high)
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
    def _take(self, lines: cython.double[:, ::1], k: cython.Py_ssize_t, whole: _Sweep) -> cython.bint:
        """Take a line; tell whether it may reach any dexel."""
        rows: cython.Py_ssize_t = self.counts.shape[0]
        radius: cython.double = whole.radius
        wide: cython.double = radius * sqrt(1.0 - whole.zw * whole.zw) if fabs(whole.zw) < 1.0 else 0.0
        size: cython.double
        lo: cython.double
        hi: cython.double
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
    def _columns(self, j: cython.Py_ssize_t, whole: _Sweep) -> cython.void:
        """Find the columns of a row that the line may reach: `first` to `last`."""
        columns: cython.Py_ssize_t = self.counts.shape[1]
        v: cython.double = j * self.cell
        whole.low, whole.high = self.lowest, self.highest
        # Strips along the way of the shank, and along that of the tip.
        whole._narrow(whole.zu, whole.zv, self.pu, self.pv, self.qu, self.qv, self.far, v)
        whole._narrow(self.qu - self.pu, self.qv - self.pv, self.pu, self.pv, self.qu, self.qv, self.far, v)
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
        whole: _Sweep,
        inner: _Sweep,
        out: cython.double[:, ::1],
    ) -> cython.bint:
        """Cut along one line, a square after the other; tell whether all dexels had places enough."""
        j: cython.Py_ssize_t
        row: cython.Py_ssize_t
        column: cython.Py_ssize_t
        low: cython.Py_ssize_t
        high: cython.Py_ssize_t
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
    def _clears(self, row: cython.Py_ssize_t, column: cython.Py_ssize_t, whole: _Sweep) -> cython.bint:
        """Tell whether the tool stays within the gap of a square, and keep the planes that would tell it of one dexel."""
        half: cython.double = 0.5 * (_SQUARE - 1) * self.cell
        below: cython.bint
        above: cython.bint
        self.low = self.high = -1.0
        self.low_u = self.low_v = self.low_w = self.high_u = self.high_v = self.high_w = 0.0
        if self.gaps[row, column, 0] > _ENDLESS:
            return False
        whole._place(
            self.u0 + column * _SQUARE * self.cell + half, self.v0 + row * _SQUARE * self.cell + half
        )
        low: cython.double = self.gaps[row, column, 0]
        high: cython.double = self.gaps[row, column, 3]
        below = whole._beyond(low, self.gaps[row, column, 1], self.gaps[row, column, 2], half, -1.0)
        if low >= -_ENDLESS and whole.fw <= 0.0:
            self.low = whole.value - whole.fw * low
            self.low_u, self.low_v, self.low_w = whole.fu, whole.fv, whole.fw
        above = whole._beyond(high, self.gaps[row, column, 4], self.gaps[row, column, 5], half, 1.0)
        if high <= _ENDLESS and whole.fw >= 0.0:
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
        whole: _Sweep,
        inner: _Sweep,
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
            low = self.low + du * self.low_u + dv * self.low_v - 2.0 * _CLOSE
            high = self.high + du * self.high_u + dv * self.high_v - 2.0 * _CLOSE
            for i in range(first, last + 1):
                if not self._missed(row * _SQUARE + j, i, low, high, whole) and (
                    whole._line() and not self._dexel(k, row * _SQUARE + j, i, judged, whole, inner, out)
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
        whole: _Sweep,
    ) -> cython.bint:
        """Take a dexel as the line at hand; tell whether the body is sure to miss all of it.

        The planes of its square have the values `low` and `high` there.
        """
        a: cython.int
        start: cython.double
        end: cython.double
        placed: cython.bint = False
        for a in range(self.counts[j, i]):
            start, end = self.ends[j, i, 2 * a], self.ends[j, i, 2 * a + 1]
            if low + end * self.low_w > 0.0 or high + start * self.high_w > 0.0:
                continue
            if not placed:
                placed = True
                whole._place(self.u0 + i * self.cell, self.v0 + j * self.cell)
            if not whole._misses(start, end):
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
        whole: _Sweep,
        inner: _Sweep,
        out: cython.double[:, ::1],
    ) -> cython.bint:
        """Cut the dexel on the line at hand; tell whether it had places enough."""
        room: cython.Py_ssize_t = self.ends.shape[2] // 2
        count: cython.int = self.counts[j, i]
        a: cython.int = 0
        lo: cython.double
        hi: cython.double
        start: cython.double
        end: cython.double
        lined: cython.bint = False
        touched: cython.bint = False
        self.deep = self.gouge = 0.0
        self.above = self.at = -1e300
        while a < self.counts[j, i]:
            start, end = self.ends[j, i, 2 * a], self.ends[j, i, 2 * a + 1]
            if not whole._between(start, end) or whole.high - whole.low <= _NOTHING:
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
                    inner._place(self.u0 + i * self.cell, self.v0 + j * self.cell)
                    touched = inner._line()
                if touched and inner._between(lo, hi):
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
        inner: _Sweep,
    ) -> cython.void:
        """Judge the cut of a dexel between two places: the touch of the smaller tool counts as far as the whole tool cuts."""
        size: cython.double
        begin: cython.double
        until: cython.double
        b: cython.int
        self.at = inner.low if self.at < -1e299 else self.at
        size = inner._above(inner.low)
        self.above = size if size > self.above else self.above
        size = inner._above(inner.high)
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
    def _note_gap(self, row: cython.Py_ssize_t, column: cython.Py_ssize_t, whole: _Sweep) -> cython.void:
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
        whole._place(
            self.u0 + column * _SQUARE * self.cell + half, self.v0 + row * _SQUARE * self.cell + half
        )
        if whole._line() and whole._between(self.bottom, self.top):
            begin, end = whole.low, whole.high
            place = end if whole.zw > 0.5 else (begin if whole.zw < -0.5 else 0.5 * (begin + end))
            whole._tangent(begin)
            if whole.fw < -1e-3:
                low_a, low_b = _bounded(-whole.fu / whole.fw), _bounded(-whole.fv / whole.fw)
            whole._tangent(end)
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
                if begin > -_ENDLESS:
                    begin -= low_a * du + low_b * dv
                    low = begin if begin > low else low
                if end < _ENDLESS:
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
        unknown; changed in place. reached: Shape (SQUARE, 2), for the kernel's own use. grid: u and v of the first dexel, and their
        distance, mm. bounds: Least and largest w of the material, mm. lines: Shape (n, 6): start and end of the tip, (u, v, w), mm.
        axes: Shape (n, 3): the tool's axis during each, of length 1, away from the tip. judged: Shape (n,): 1 for lines whose depths
        are computed, else only volumes are. tool: Radius, flat radius, radius of the edge, slope of the cone, length of the cutting
        edge, mm. margins: Shape (n, 2): at the tool's side and at its tip, within which a touch does not count, mm. dry: Nothing is
        cut; depths and heights are computed. first: The line to begin with. out: Shape (n, COLUMNS), added to: volume removed; the
        deepest bite and its u, v, w; the deepest gouge of the part, and its u, v, w; the volume gouged; how far material stands above
        the cutting edge. mm, mm³.

    Returns:
        The line for which a dexel has too few places, to go on with; n where all are cut.
    """
    n: cython.Py_ssize_t = lines.shape[0]
    k: cython.Py_ssize_t
    done: cython.Py_ssize_t = n
    whole: _Sweep = _Sweep()
    inner: _Sweep = _Sweep()
    field: _Field = _Field()
    field.ends, field.counts, field.parts, field.part_counts = ends, counts, parts, part_counts
    field.gaps, field.reached = gaps, reached
    field.u0, field.v0, field.cell = grid[0], grid[1], grid[2]
    field.bottom, field.top = bounds[0], bounds[1]
    field.edge_length, field.dry = tool[4], dry
    with cython.nogil:
        for k in range(first, n):
            whole._take(lines, axes, k, tool, 0.0, 0.0)
            if judged[k]:
                inner._take(lines, axes, k, tool, margins[k, 0], margins[k, 1])
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
