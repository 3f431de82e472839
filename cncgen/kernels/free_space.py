# cython: infer_types=True
"""The free space of two polylines, strip by strip: is there a monotone matching that is nowhere longer than allowed?

H. Alt and M. Godau, Computing the Fréchet distance between two polygonal curves, Int. J. Computational Geometry and
Applications 5 (1995), sections 3.1 and 3.2. A *cell* is a chord of one polyline (the points) and a segment of the other
(the line); the pairs of places in it that are not further apart than the segment allows are an ellipse cut by the unit
square, so convex. The pairs that can be reached from the start by going forward on both are then known from the borders of cells
alone: an interval on each segment at each point, an interval on each chord at each vertex. A strip is one chord with the
segments that are reached; only these are looked at, and the intervals of one point are all that is kept.
"""

import cython
from cython.cimports.libc.math import sqrt

#: Ends of `FreeSpace.run`: all chords are done; no place is reached after the next one; the line in memory ends; a place
#: is reached that is allowed at scale 1.
DONE, DEAD, MORE, REJOINED = 0, 1, 2, 3
_DONE = cython.declare(cython.int, 0)
_DEAD = cython.declare(cython.int, 1)
_MORE = cython.declare(cython.int, 2)
_REJOINED = cython.declare(cython.int, 3)

#: Segments of a strip at most: segments further ahead of the first one reached are left out.
WIDEST = cython.declare(cython.Py_ssize_t, 65536)

#: The part of a segment, low to high in fractions of it, that is within a radius of a point (none: low > high); the
#: fraction of the foot of the perpendicular, its distance squared, and the segment's length squared.
Near = cython.struct(
    low=cython.double, high=cython.double, foot=cython.double, square=cython.double, length2=cython.double
)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _near(
    n: cython.Py_ssize_t,
    centres: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    line: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    radius: cython.double,
) -> Near:
    """Return the part of segment `k` of a line within a radius of centre `i`, in `n` dimensions."""
    dot: cython.double = 0.0
    size: cython.double = 0.0
    square: cython.double = 0.0
    for c in range(n):
        d = line[k + 1, c] - line[k, c]
        dot += (centres[i, c] - line[k, c]) * d
        size += d * d
    foot = dot / size if size > 0.0 else 0.0
    for c in range(n):
        # Not |centre - start|² - dot²/size: the radius may be 1e-9 of the segment.
        d = centres[i, c] - line[k, c] - foot * (line[k + 1, c] - line[k, c])
        square += d * d
    if square > radius * radius:
        return Near(low=1.0, high=0.0, foot=foot, square=square, length2=size)
    half = sqrt((radius * radius - square) / size) if size > 0.0 else 1.0
    return Near(
        low=foot - half if foot > half else 0.0,
        high=foot + half if foot + half < 1.0 else 1.0,
        foot=foot,
        square=square,
        length2=size,
    )


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _least(near: Near, low: cython.double, high: cython.double) -> cython.double:
    """Return the square of the least distance between the fractions `low` and `high`."""
    f: cython.double = near.foot
    if f < low:
        f = low
    if f > high:
        f = high
    return near.square + (f - near.foot) * (f - near.foot) * near.length2


@cython.final
@cython.cclass
class FreeSpace:
    """The reached intervals of one point after another, along a line that may go on beyond what is in memory.

    At the start, the first segment is reached at its start.

    Args:
        line: Shape (m + 1, d): vertices.
        allowed: Shape (m,): how far from each segment a place may be; at a vertex the wider of the two counts.
        ended: The line ends with its last segment.
        distance: Shape (m + 1,): the least distance of each vertex from the points' chords, among the places it can be
            matched with; infinite at first, lowered.
        at: Shape (m + 1,): the chord that it is reached on, counted over all calls.
        during: Shape (m + 1, 2): the first and the last chord on which it can be matched; -1 at first.
    """

    line: cython.double[:, ::1]
    allowed: cython.double[::1]
    ended: cython.bint
    distance: cython.double[::1]
    at: cython.longlong[::1]
    during: cython.longlong[:, ::1]
    low: cython.double[::1]
    high: cython.double[::1]
    next_low: cython.double[::1]
    next_high: cython.double[::1]
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t
    visited: cython.longlong
    nearest: cython.double
    nearest_segment: cython.Py_ssize_t

    def __init__(self, line, allowed, ended, distance, at, during, scratch) -> None:
        """Take the arrays; `scratch` has shape (4, m)."""
        self.line = line
        self.allowed = allowed
        self.ended = ended
        self.distance = distance
        self.at = at
        self.during = during
        self.low = scratch[0]
        self.high = scratch[1]
        self.next_low = scratch[2]
        self.next_high = scratch[3]
        self.first = 0
        self.last = 0
        self.low[0] = 0.0
        self.high[0] = 0.0
        self.visited = 0

    @property
    def cells(self) -> int:
        """How many cells have been looked at."""
        return self.visited

    def reached(self) -> tuple[int, list[float], list[float]]:
        """Return the first segment that is reached, and where the intervals from it on begin and end."""
        low = [self.low[k] for k in range(self.first, self.last + 1)]
        high = [self.high[k] for k in range(self.first, self.last + 1)]
        return self.first, low, high

    def enter(self, first: int, low: list[float], high: list[float]) -> None:
        """Go on from intervals that `reached` returned."""
        self.first = first
        self.last = first + len(low) - 1
        for k in range(len(low)):
            self.low[first + k] = low[k]
            self.high[first + k] = high[k]

    def run(
        self,
        points: cython.double[:, ::1],
        begin: cython.Py_ssize_t,
        stop: cython.Py_ssize_t,
        scale: cython.double,
        free: cython.Py_ssize_t,
        count: cython.longlong,
        distance: cython.double[::1],
        segment: cython.longlong[::1],
    ) -> tuple[int, int]:
        """Go on along the chords begin … stop - 1.

        Args:
            points: Shape (n, d), n > stop: chord k goes from point k to point k + 1.
            begin, stop: The chords.
            scale: Factor on the tolerance.
            free: Above scale 1, it ends after this chord or later, where a place is reached that is allowed at scale 1.
            count: Number of chord `begin` in the notes at vertices; negative: nothing is noted, there or below.
            distance: Shape (n,): receives the least distance of each point from the segments that it reaches,
            segment: Shape (n,): and on which segment.

        Returns:
            The chord that was not done (`stop` where all were; the next one where it rejoined), and why.
        """
        k: cython.Py_ssize_t = begin
        why: cython.int = _DONE
        with cython.nogil:
            while k < stop and why == _DONE:
                # For as many dimensions as a compiler knows it unrolls the loops.
                if points.shape[1] == 2:
                    why = self._strip(2, points, k, scale, count + (k - begin) if count >= 0 else -1)
                elif points.shape[1] == 3:
                    why = self._strip(3, points, k, scale, count + (k - begin) if count >= 0 else -1)
                else:
                    why = self._strip(
                        points.shape[1], points, k, scale, count + (k - begin) if count >= 0 else -1
                    )
                if why != _DONE:
                    break
                if count >= 0:
                    distance[k + 1] = sqrt(self.nearest)
                    segment[k + 1] = self.nearest_segment
                k += 1
                if scale > 1.0 and k > free and self._rejoins(points, k):
                    why = _REJOINED
        return k, why

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _strip(
        self,
        n: cython.Py_ssize_t,
        points: cython.double[:, ::1],
        i: cython.Py_ssize_t,
        scale: cython.double,
        number: cython.longlong,
    ) -> cython.int:
        """Carry the intervals at point `i` over its chord; return DONE, DEAD or MORE (then nothing is changed)."""
        m: cython.Py_ssize_t = self.line.shape[0] - 1
        j: cython.Py_ssize_t = self.first
        first: cython.Py_ssize_t = -1
        last: cython.Py_ssize_t = -1
        entered: cython.double = (
            -1.0
        )  # Where on the chord the segment's start is first reached; negative: it is not.
        own: cython.bint
        top: Near
        self.nearest = 1e300
        while j <= self.last or entered >= 0.0:
            if j - self.first >= WIDEST:
                break
            own = j <= self.last and self.low[j] <= self.high[j]
            if not own and entered < 0.0:
                self.next_low[j] = 1.0
                self.next_high[j] = 0.0
                j += 1
                continue
            if j >= m:
                return _MORE
            self.visited += 1
            radius = self.allowed[j] * scale
            top = _near(n, points, i + 1, self.line, j, radius)
            low = self.low[j] if entered < 0.0 and self.low[j] > top.low else top.low
            self.next_low[j] = low
            self.next_high[j] = top.high
            if low <= top.high:
                if first < 0:
                    first = j
                last = j
                least = _least(top, low, top.high)
                if least < self.nearest:
                    self.nearest = least
                    self.nearest_segment = j
            if j == m - 1 and self.ended:
                break
            entered = self._cross(n, points, i, j, scale, 0.0 if own else entered, number)
            j += 1
        if first < 0:
            return _DEAD
        self.first = first
        self.last = last
        self.low, self.next_low = self.next_low, self.low
        self.high, self.next_high = self.next_high, self.high
        return _DONE

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _cross(
        self,
        n: cython.Py_ssize_t,
        points: cython.double[:, ::1],
        i: cython.Py_ssize_t,
        j: cython.Py_ssize_t,
        scale: cython.double,
        since: cython.double,
        number: cython.longlong,
    ) -> cython.double:
        """Return where on chord `i` segment j + 1 is first reached from segment `j`, negative where it is not.

        Segment `j` is reached from `since` on. From the first place that is near enough to segment `j`, the vertex may be
        stayed at as long as either segment allows it, until the next segment allows it too.
        """
        allowed: cython.double = self.allowed[j] * scale
        there: Near = _near(n, self.line, j + 1, points, i, allowed)
        low: cython.double = there.low if there.low > since else since
        high: cython.double = there.high
        if low > high:
            return -1.0
        if number >= 0:
            least = _least(there, low, high)
            if least < self.distance[j + 1] * self.distance[j + 1]:
                self.distance[j + 1] = sqrt(least)
                self.at[j + 1] = number
            if self.during[j + 1, 0] < 0 or number < self.during[j + 1, 0]:
                self.during[j + 1, 0] = number
            if number > self.during[j + 1, 1]:
                self.during[j + 1, 1] = number
        if j + 2 < self.line.shape[0] and self.allowed[j + 1] * scale < allowed:
            there = _near(n, self.line, j + 1, points, i, self.allowed[j + 1] * scale)
            if there.low > low:
                low = there.low
            if there.high < high:
                high = there.high
        return low if low <= high else -1.0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _rejoins(self, points: cython.double[:, ::1], i: cython.Py_ssize_t) -> cython.bint:
        """Keep only what is allowed at scale 1 of the intervals at point `i`, if that is anything."""
        first: cython.Py_ssize_t = -1
        last: cython.Py_ssize_t = -1
        near: Near
        for j in range(self.first, self.last + 1):
            near = _near(points.shape[1], points, i, self.line, j, self.allowed[j])
            low = near.low if near.low > self.low[j] else self.low[j]
            high = near.high if near.high < self.high[j] else self.high[j]
            self.next_low[j] = low
            self.next_high[j] = high
            if low <= high:
                if first < 0:
                    first = j
                last = j
        if first < 0:
            return False
        self.first = first
        self.last = last
        self.low, self.next_low = self.next_low, self.low
        self.high, self.next_high = self.next_high, self.high
        return True
