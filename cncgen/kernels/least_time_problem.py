# cython: infer_types=True
"""The numbers of a least-time problem, as the kernels of `cncgen.kernels.least_time` share them.

Intervals lie in *blocks* of `LANES`, and each quantity of a block is one column of `LANES` numbers beside the next, so that a
loop over a block is the same arithmetic on consecutive numbers, without a branch. All columns of a block are in one array at
distances known when compiling: then no compiler need ask whether they overlap.

Rows are kept in *batches* of `LANES`: the rows of one kind, at one end, of one axis, for the intervals of a block. With q = v²,
d = q′/2 and κ = q″/2, at an end of an interval of length h,

    acceleration = x″ q + x′ d,      jerk = (x‴ q + 3 x″ d + x′ κ) q^1/2,

so a row is (A0, A1, A2)·(q, d, κ) there, as a part of its limit, and |A·(q, d, κ)| ≤ r: r = f, or f q^-1/2 for a jerk. A bound
of q, or of d, is a row as well; that its other side never binds does no harm. With q = b0, b2 at the ends of the interval and
b1 where the tangents there meet, at the way l, d is (b1 − b0)/2l at the left end and (b2 − b1)/2(h − l) at the right one, and κ
the difference of both by h; at an end it is `PULL` times that, which rows have in A2. They are taken from differences of
unknowns, hence have their digits where nodes stand close.

Columns of a batch: `A0`, `A1`, `A2`; `PART`, f; `W0`, `W1`, slacks of r − A·(q, d, κ) and r + A·(q, d, κ); `Y0`, `Y1`, multipliers;
`DW0`, `DW1`, `DY0`, `DY1`, their steps.

Columns of a block, all but the motion's changed at most where ways are settled: `E0` to `E3`, b0 = E0 c[k] + E1 c[k+1], b2 = E2
c[k+1] + E3 c[k+2]; d = `LEFT` (c[k+1] − c[k]) + `LEAVE` c[k+1] at the left end and `RIGHT` (c[k+2] − c[k+1]) − `ENTER` c[k+1]
at the right one; `LENGTH` and `PACE`, h and 1/h; `LIFT`, h (3/4 h − l); `WEIGHT0` to `WEIGHT2`, those of q^-1/2 at the left
end, in the middle and at the right end in F; `WAY`, l; `RATE`, the mean speed; `PULL` and `HELD`, by which part κ at each end
differs from the mean, and by which rows have it; `PARABOLA`, 1 where κ is constant instead. Of the motion: `B`, `D`, `K` are q,
d, κ, and `DB`, `DD`, `DK` their steps; `ROOT`, `SLOPE`, `SIZE` are q^-1/2, its derivative and q^1/2, or 1, 0, 1; `MIDDLE1`,
`MIDDLE2` first and second derivative of the middle term of F. Sums over the rows: the matrix `M00` to `M22` in (q, d, κ), and
two vectors `G`, `H` of three columns each.
"""

import cython

if not cython.compiled:
    # As in least_time_problem.pxd.
    vectorized = inlined = None
    LANES = 32
    A0, A1, A2, PART, W0, W1, Y0, Y1, DW0, DW1, DY0, DY1, ROWS = range(0, 13 * LANES, LANES)
    (
        E0,
        E1,
        E2,
        E3,
        LEFT,
        LEAVE,
        RIGHT,
        ENTER,
        LENGTH,
        PACE,
        LIFT,
        WEIGHT0,
        WEIGHT1,
        WEIGHT2,
        WAY,
        RATE,
        PULL,
    ) = range(0, 17 * LANES, LANES)
    HELD, PARABOLA, FIXED = 18 * LANES, 20 * LANES, 21 * LANES
    B, D, K, DB, DD, DK, END = range(0, 7 * LANES, LANES)
    ROOT, SLOPE, SIZE, SCALE = 12 * LANES, 13 * LANES, 14 * LANES, 3 * LANES
    MIDDLE1, MIDDLE2, MOTION = 21 * LANES, 22 * LANES, 23 * LANES
    M00, M01, M02, M11, M12, M22, G = range(0, 7 * LANES, LANES)
    PLACES, USED = 10 * LANES, 19 * LANES
    H, SUMMED, FOUND0, FOUND1, FOUND2, FOUND3, SUMS = (x * LANES for x in (9, 12, 12, 13, 14, 15, 16))


@cython.cclass
class Runs:
    """Rows beside each other that are in the same state.

    Attributes:
        of: Shape (room, 3): batch, first lane, and the lane after the last one of each run, block by block.
        first: Shape (blocks + 1,): the first run of each block.
    """

    def __init__(self, batches: cython.Py_ssize_t, blocks: cython.Py_ssize_t) -> None:
        """Make room for the runs of so many batches."""
        import numpy

        self.of = numpy.empty((max(batches * LANES // 2, 1), 3), numpy.int64)
        self.first = numpy.zeros(blocks + 1, numpy.int64)


@cython.cclass
class Problem:
    """A problem, and where its iteration stands.

    Attributes:
        n, blocks: Intervals, and blocks of them.
        c: Shape (n + 2,), the unknowns, positive.
        free: Index of the first unknown that may change (1, or 2 where the window starts in motion).
        h: Shape (n,), lengths of the intervals.
        extra: Shape (n, 2), weight of q^-1/2 at the left and right end beside that of the interval itself: beside a rest.
        back: Shape (n,), 1 where the motion turns back behind the rest at the right end: with the acceleration that it comes with.
        start: q′/2 at the start of a window in motion.
        way: Shape (n,), l of the intervals.
        ends: Shape (n, 4), E0 to E3 (see above).
        middle: Shape (n, 2), bound of each unknown, and how fast it rises with the way.
        d1, d2, d3: Shape (n, 3, axes), derivatives of the path at left end, middle and right end.
        limits: Shape (2, axes): acceleration, jerk.
        factor: Shape (n, 2, axes): parts of acceleration and jerk limits that the interval may use.
        x3_excess: Shape (n, axes), what d3 may be more at the quarter points than the parabola through its values shows.
        moves: Shape (axes,): whether an axis does not stand all along.
        share: Shape (n, 2, axes): parts of acceleration and jerk limits at the ends that hold them between.
        fixed, motion: The blocks' columns, one block after the other.
        sums: Columns of sums, of one block at a time.
        rows: The batches' columns, one batch after the other, block by block.
        batches: Shape (room, 4): block, end (0 left, 1 right), kind and axis (−1 for none) of each batch.
        count: Batches there are.
        state: Shape (room, `LANES`): 0 where an interval has no such row, 1 where it sleeps, 2 where it is awake.
        awake, asleep: Those rows.
    """

    def __init__(
        self,
        free: cython.Py_ssize_t,
        h: cython.double[::1],
        extra: cython.double[:, ::1],
        d1: cython.double[:, :, ::1],
        d2: cython.double[:, :, ::1],
        d3: cython.double[:, :, ::1],
        limits: cython.double[:, ::1],
        factor: cython.double[:, :, ::1],
        x3_excess: cython.double[:, ::1],
        back: cython.char[::1],
    ) -> None:
        """Take the intervals, make room for the rest: unknowns are 1, rows none.

        Args:
            free, h, extra, d1, d2, d3, limits, factor, x3_excess, back: See the attributes.
        """
        n: cython.Py_ssize_t = h.shape[0]
        axes: cython.Py_ssize_t = d1.shape[2]
        import numpy

        self.n, self.free, self.blocks = n, free, (n + LANES - 1) // LANES
        self.h, self.extra, self.back, self.d1, self.d2, self.d3 = h, extra, back, d1, d2, d3
        self.limits, self.factor, self.x3_excess = limits, factor, x3_excess
        self.c, self.share = numpy.ones(n + 2), numpy.ones((n, 2, axes))
        self.way, self.start = numpy.empty(n), 0.0
        self.ends, self.middle = numpy.zeros((n, 4)), numpy.zeros((n, 2))
        self.fixed, self.motion = numpy.zeros(self.blocks * FIXED), numpy.zeros(self.blocks * MOTION)
        self.sums = numpy.zeros(2 * SUMS)
        most = self.blocks * (5 + 4 * axes)
        self.rows, self.batches = numpy.empty(most * ROWS), numpy.empty((most, 4), numpy.int64)
        self.state, self.count = numpy.zeros((most, LANES), numpy.int8), 0
        self.awake, self.asleep = Runs(most, self.blocks), Runs(most, self.blocks)
        self.moves = numpy.zeros(axes, numpy.int8)
        for a in range(axes):
            for k in range(n):
                for e in range(3):
                    if d1[k, e, a] != 0.0 or d2[k, e, a] != 0.0 or d3[k, e, a] != 0.0:
                        self.moves[a] = 1
                if x3_excess[k, a] != 0.0:
                    self.moves[a] = 1
                if self.moves[a]:
                    break
        for k in range(self.blocks):
            for m in range(PULL, PARABOLA):
                self.fixed[k * FIXED + m] = 1.0
        for k in range(n):
            at = k // LANES * FIXED + k % LANES
            self.fixed[at + LENGTH] = h[k]
            self.fixed[at + PACE] = 1.0 / h[k]
            self.fixed[at + WAY] = 0.5 * h[k]
            self.fixed[at + WEIGHT0] = h[k] / 6.0 + extra[k, 0]
            self.fixed[at + WEIGHT1] = h[k] / 1.5
            self.fixed[at + WEIGHT2] = h[k] / 6.0 + extra[k, 1]
        lay(self)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lay(problem: Problem) -> cython.void:
    """Set the columns that follow from where the tangents of q meet.

    The ordinate at a node between two intervals follows from the tangent that they share there. Beside a rest q' is that of constant
    jerk, 4 q/(3 h), h the length of the interval of the rest, which is a third of `extra`; where the motion turns back, that of constant
    acceleration, q/h, and h half of `extra`.
    """
    slope: cython.double
    fixed: cython.double[::1] = problem.fixed
    ends: cython.double[:, ::1] = problem.ends
    before: cython.double = 0.0
    for k in range(problem.n):
        at = k // LANES * FIXED + k % LANES
        left = fixed[at + WAY]
        fixed[at + LEAVE] = fixed[at + ENTER] = 0.0
        if problem.extra[k, 0] > 0.0:
            slope = 2.0 if k > 0 and problem.back[k - 1] != 0 else 4.0
            both = 1.0 / (problem.extra[k, 0] + slope * left)
            ends[k, 0], ends[k, 1] = 0.0, problem.extra[k, 0] * both
            fixed[at + LEAVE], fixed[at + LEFT] = 0.5 * slope * both, 0.0
        elif k == 0:
            ends[k, 0], ends[k, 1] = 1.0, 0.0
            fixed[at + LEFT] = 0.5 / left
        else:
            # The node that the interval before shares.
            both = 1.0 / (before + left)
            ends[k, 0] = ends[k - 1, 2] = left * both
            ends[k, 1] = ends[k - 1, 3] = before * both
            fixed[at + LEFT] = 0.5 * both
            last = (k - 1) // LANES * FIXED + (k - 1) % LANES
            fixed[last + E2], fixed[last + E3], fixed[last + RIGHT] = ends[k, 0], ends[k, 1], 0.5 * both
        before = problem.h[k] - left
        if problem.extra[k, 1] > 0.0:
            slope = 2.0 if problem.back[k] != 0 else 4.0
            both = 1.0 / (problem.extra[k, 1] + slope * before)
            ends[k, 2], ends[k, 3] = problem.extra[k, 1] * both, 0.0
            fixed[at + ENTER], fixed[at + RIGHT] = 0.5 * slope * both, 0.0
        elif k == problem.n - 1:
            ends[k, 2], ends[k, 3] = 0.0, 1.0
            fixed[at + RIGHT] = 0.5 / before
        fixed[at + E0], fixed[at + E1], fixed[at + E2], fixed[at + E3] = (
            ends[k, 0],
            ends[k, 1],
            ends[k, 2],
            ends[k, 3],
        )
        fixed[at + LIFT] = problem.h[k] * (0.75 * problem.h[k] - left)
        problem.way[k] = left


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def size(problem: Problem, block: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the number of intervals of a block."""
    return min(LANES, problem.n - block * LANES)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def find_runs(problem: Problem, state: cython.char, runs: Runs) -> cython.void:
    """Find the rows that are in a state."""
    block: cython.Py_ssize_t = 0
    found: cython.Py_ssize_t = 0
    same: cython.int
    for b in range(problem.count):
        while block <= problem.batches[b, 0]:
            runs.first[block] = found
            block += 1
        same = 0
        for j in range(LANES):
            same += problem.state[b, j] == state
        if same == 0:
            continue
        start = -1
        for j in range(LANES):
            if problem.state[b, j] == state:
                if start < 0:
                    start = j
            elif start >= 0:
                runs.of[found, 0], runs.of[found, 1], runs.of[found, 2] = b, start, j
                found += 1
                start = -1
        if start >= 0:
            runs.of[found, 0], runs.of[found, 1], runs.of[found, 2] = b, start, LANES
            found += 1
    while block <= problem.blocks:
        runs.first[block] = found
        block += 1


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def sides(problem: Problem) -> cython.Py_ssize_t:
    """Return the number of one-sided constraints that are awake."""
    total: cython.Py_ssize_t = 0
    for i in range(problem.awake.first[problem.blocks]):
        total += 2 * (problem.awake.of[i, 2] - problem.awake.of[i, 1])
    return total
