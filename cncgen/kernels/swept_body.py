# cython: infer_types=True
"""The body that a tool sweeps on a straight motion while its axis keeps its direction, and where lines meet it.

The body is convex: the tool of `removal`, convex and without an end upwards, drawn along a segment. So a line meets it in one
interval. In the frame of the tool (z along its axis, x along its way across it) the body is the points above the envelope of `removal`,
over a stadium round the way. On the stretch of a line that is over the stadium, the envelope less the height is convex, and Newton's
method from either end goes to the interval's ends without passing them.
"""

import cython
from cython.cimports.cncgen.kernels.removal import lift, lowest_at
from cython.cimports.libc.math import fabs, sqrt

if not cython.compiled:
    # As in swept_body.pxd.
    CLOSE, ENDLESS = 1e-8, 1e299

#: Steps of Newton's method, at most.
_STEPS = cython.declare(cython.int, 60)
#: Below this part of its radius, squared, a ball counts as upright.
_UPRIGHT = cython.declare(cython.double, 1e-6)
#: A shorter way across the axis counts as 0, mm: along the axis a rise by it would be without end.
_ACROSS = cython.declare(cython.double, 1e-4)


@cython.final
@cython.cclass
class SweptBody:
    """The body of a motion (`take`), and a line along w at hand (`place`); numbers that methods leave are in swept_body.pxd."""

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def take(
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
        self.clear_of = (self.radius + 2.0 * CLOSE) * (self.radius + 2.0 * CLOSE)
        self.flat = tool[1] if tool[1] < self.radius else self.radius
        self.edge = tool[2]
        self.slope = tool[3]
        self.ball = self.flat == 0.0 and self.edge == self.radius
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
        self.cosine = 1.0 / sqrt(1.0 + self.rise * self.rise)
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
        found: cython.bint = (self.ball and self._over_ball(x, y)) or (
            self.flat >= self.radius and self._over_disc(x, y)
        )
        if not found:
            self._over_tool(x, y)
        self.over -= self.z + w * self.zw
        self.change = self.gx * self.xw + self.gy * self.yw - self.zw

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _over_ball(self, x: cython.double, y: cython.double) -> cython.bint:
        """Find the envelope of a ball at a place, and how it changes; return False where the ball is upright."""
        least: cython.double = _UPRIGHT * self.radius * self.radius
        rho: cython.double = self.radius * self.radius - y * y
        if rho <= least:
            return False
        # The ball touches where it is as steep as its way, or at an end of that.
        over = sqrt(rho)
        s = x - self.rise * over * self.cosine
        if 0.0 <= s <= self.length:
            steep = over / self.cosine
            self.over = self.base + self.rise * x + self.radius - steep
            self.gx, self.gy = self.rise, y * steep / (over * over)
            return True
        s = 0.0 if s < 0.0 else (self.length if s > self.length else s)
        rho -= (x - s) * (x - s)
        if rho <= least:
            return False
        over = sqrt(rho)
        self.over = self.base + self.rise * s + self.radius - over
        self.gx, self.gy = (x - s) / over, y / over
        return True

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _over_disc(self, x: cython.double, y: cython.double) -> cython.bint:
        """Find the envelope of a flat disc, which touches with its rear or front, at its rim where it is upright; return False beyond."""
        m: cython.double = self.rise
        rho: cython.double = self.radius * self.radius - y * y
        if rho <= 0.0:
            return False
        rho = sqrt(rho)
        s = x - rho if m > 0.0 else (x + rho if m < 0.0 else x)
        behind: cython.bint = s <= 0.0 and x < 0.0 and m < 0.0
        before: cython.bint = s >= self.length and x > self.length and m > 0.0
        if behind or before:
            return False
        self.gx = self.gy = 0.0
        if m != 0.0 and 0.0 < s < self.length:
            self.gx = m
            self.gy = fabs(m) * y / (rho if rho > 1e-9 else 1e-9)
        s = 0.0 if s < 0.0 else (self.length if s > self.length else s)
        self.over = self.base + m * s
        return True

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _over_tool(self, x: cython.double, y: cython.double) -> cython.void:
        """Find the envelope of any tool by the place of the way that touches, and how it changes."""
        m: cython.double = self.rise
        s = lowest_at(x, fabs(y), self.length, m, self.radius, self.flat, self.edge, self.slope)
        rho = sqrt(y * y + (x - s) * (x - s))
        rho = self.radius if rho > self.radius else rho
        self.over = self.base + m * s + lift(rho, self.flat, self.edge, self.slope)
        self.gx = self.gy = 0.0
        if m != 0.0 and 0.0 < s < self.length:
            # The tool touches ahead of or behind the foot, where it rises as its way does; at its rim it is upright.
            over = fabs(x - s)
            self.gx = m
            self.gy = fabs(m) * y / (over if over > 1e-9 else 1e-9)
        elif rho > 0.0:
            steep = self._steep(rho)
            # Beyond the upper end of the way the tool's rim is as steep as the way.
            over = (x - s if s > 0.0 else 0.0) if m > 0.0 else (-x if s <= 0.0 else 0.0)
            if over > 0.0 and steep * over < fabs(m) * rho:
                steep = fabs(m) * rho / (over if over > 1e-9 else 1e-9)
            self.gx = steep * (x - s) / rho
            self.gy = steep * y / rho

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _steep(self, rho: cython.double) -> cython.double:
        """Return how steep the tool's underside is at a distance from its axis: 0 below its flat, along its edge or cone."""
        over: cython.double = rho - self.flat
        if over <= 0.0:
            return 0.0
        if self.edge > 0.0:
            over = over if over < self.edge * (1.0 - 1e-12) else self.edge * (1.0 - 1e-12)
            return over / sqrt(self.edge * self.edge - over * over)
        return self.slope

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def place(self, u: cython.double, v: cython.double) -> cython.void:
        """Take a line of the field."""
        self.known = self.seen = 1e301
        u, v = u - self.ou, v - self.ov
        self.x = self.xu * u + self.xv * v - self.xw * self.ow
        self.y = self.yu * u + self.yv * v - self.yw * self.ow
        self.z = self.zu * u + self.zv * v - self.zw * self.ow

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def tangent(self, w: cython.double) -> cython.void:
        """Find a plane over space that is positive beyond the body's boundary alone: its value on the line at hand, and its changes."""
        x: cython.double = self.x + w * self.xw
        y: cython.double = self.y + w * self.yw
        gz: cython.double = -1.0
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
    def beyond(
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
        if side * w > ENDLESS:
            return True
        self.tangent(w)
        if side * self.fw < 0.0:
            return False
        return self.value - (fabs(self.fu + self.fw * a) + fabs(self.fv + self.fw * b)) * half > 2.0 * CLOSE

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def misses(self, start: cython.double, end: cython.double) -> cython.bint:
        """Tell whether the body is sure to miss a stretch of the line at hand, by its tangent plane at one end of it or the other."""
        w: cython.double = start
        sense: cython.double = 1.0
        if end < self.lowest or start > self.highest:
            return True
        if start + end < self.lowest + self.highest:
            w, sense = end, -1.0
        # As `tangent` has it, without the changes along u and v.
        x = self.x + w * self.xw
        y = self.y + w * self.yw
        x = x if x < 0.0 else (x - self.length if x > self.length else 0.0)
        if x * x + y * y >= self.beside:
            return x * x + y * y > self.clear_of and sense * (x * self.xw + y * self.yw) >= 0.0
        self._clear(w)
        self.seen, self.seen_over, self.seen_change = w, self.over, self.change
        return self.over > 2.0 * CLOSE and sense * self.change >= 0.0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def line(self) -> cython.bint:
        """Find where the line at hand is over the stadium (`enter` to `leave`), and tell whether it is anywhere."""
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
        db: cython.double = -sense * self.zw
        t: cython.double = 1e300
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
        return w + sense * t if t < ENDLESS else sense * 1e300

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _onto_ball(self, w: cython.double, sense: cython.double) -> cython.double:
        """Return where the line at hand meets a ball's body from w, outside of it; endless where it misses it.

        The ball's middle goes along a segment. From below, the line meets what is within the radius of that: of a cylinder round it
        and of the balls at its ends, the one that has the place at which the line meets the cylinder.
        """
        x: cython.double = self.x + w * self.xw
        y: cython.double = self.y + w * self.yw
        z: cython.double = self.z + w * self.zw - self.base - self.radius
        dx: cython.double = sense * self.xw
        dy: cython.double = sense * self.yw
        dz: cython.double = sense * self.zw
        # The direction of the segment is (ex, 0, ez).
        ex: cython.double = self.cosine
        ez: cython.double = self.rise * ex
        far: cython.double = self.length / ex
        along: cython.double = x * ex + z * ez
        turn: cython.double = dx * ex + dz * ez
        size: cython.double = 1.0 - turn * turn
        half: cython.double = x * dx + y * dy + z * dz
        c: cython.double = x * x + y * y + z * z - self.radius * self.radius
        if size > 1e-12:
            t = half - along * turn
            root = t * t - size * (c - along * along)
            if root < 0.0:
                return sense * 1e300
            t = (-t - sqrt(root)) / size
            along += t * turn
            if 0.0 <= along <= far:
                return w + sense * t if t > 0.0 else w
        elif turn < 0.0:
            along = far + 1.0
        else:
            along = -1.0
        if along > far:
            # The ball at the end, whose middle is far along the segment.
            half -= far * turn
            c += far * (far - 2.0 * (x * ex + z * ez))
        root = half * half - c
        if root < 0.0:
            return sense * 1e300
        t = -half - sqrt(root)
        return w + sense * t if t > 0.0 else w

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _root(self, w: cython.double, last: cython.double) -> cython.double:
        """Return where the line at hand goes into the body, from w, outside of it, towards a last place; 1e300 if nowhere before."""
        up: cython.bint = last > w
        if self.edge > 0.0:
            w = self._onto_ball(w, 1.0 if up else -1.0) if self.ball else self._nearer(w, 1.0 if up else -1.0)
            if w >= last if up else w <= last:
                return 1e300
            if self.ball:
                return w
        for k in range(_STEPS):
            self._clear(w)
            if self.over <= CLOSE:
                break
            if self.change >= 0.0 if up else self.change <= 0.0:
                return 1e300
            # Where the tool is upright the change is infinite, and a step is nothing.
            step = self.over / fabs(self.change)
            step = step if step > CLOSE else CLOSE
            w = w + step if up else w - step
            if w >= last if up else w <= last:
                return 1e300
        return w

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _look(self, w: cython.double) -> cython.void:
        """Find what `_clear` does, but for the changes along x and y, without computing it again where `misses` has."""
        if w == self.seen and w < 1e300:
            self.known = 1e301
            self.over, self.change = self.seen_over, self.seen_change
        else:
            self._clear(w)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def between(self, low: cython.double, high: cython.double) -> cython.bint:
        """Find where the line at hand is within the body between two places (`low` to `high`); tell whether it is anywhere."""
        low = low if low > self.enter else self.enter
        high = high if high < self.leave else self.leave
        if low >= high:
            return False
        # Most lines have been cut by the motions before and miss the body at one end, where the envelope rises away from it.
        self._look(high)
        over, change = self.over, self.change
        if over > CLOSE and change <= 0.0:
            return False
        if over <= CLOSE and change < 0.0 and high - over / change > low:
            # The envelope is above the tangent, so the line below is outside.
            self.low, self.high = self._root(high - over / change, high), high
            return self.low < high
        self._look(low)
        if self.over > CLOSE:
            if self.change >= 0.0:
                return False
            # The envelope is above both tangents, so nowhere below where they meet.
            if over > CLOSE:
                w = (over - self.over - change * (high - low)) / (self.change - change)
                if self.over + self.change * w > CLOSE:
                    return False
            self.low = self._root(low, high)
        else:
            self.low = low
        if over > CLOSE:
            # From within, a step goes beyond the end.
            w = low - self.over / self.change if self.low == low and self.change > 0.0 else high
            self.high = self._root(w if w < high else high, low)
        else:
            self.high = high
        return self.low < self.high < 1e300

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def narrow(
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
    def above(self, w: cython.double) -> cython.double:
        """Return how far the line at hand is above the tip, along the axis, when the tool passes it."""
        x: cython.double = self.x + w * self.xw
        x = 0.0 if x < 0.0 else (self.length if x > self.length else x)
        return self.z + w * self.zw - self.base - self.rise * x
