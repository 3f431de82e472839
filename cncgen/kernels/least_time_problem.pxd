# How the numbers of a least-time problem lie in memory, and the record that holds them (see `least_time_problem`).

# Return types, none, of functions that a compiler makes three times, for eight numbers at once where the processor has AVX-512, for
# four with AVX2, and for two; and of loops that are part of such a function. The results are the same to the bit: nothing is added in another order, and no
# product is fused with a sum.
cdef extern from *:
    """
    #if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
    #define CNCGEN_VECTORIZED __attribute__((target_clones("avx512f", "avx2", "default"))) void
    #define CNCGEN_INLINED inline __attribute__((always_inline)) void
    #else
    #define CNCGEN_VECTORIZED void
    #define CNCGEN_INLINED void
    #endif
    """
    ctypedef void vectorized "CNCGEN_VECTORIZED"
    ctypedef void inlined "CNCGEN_INLINED"

cdef enum:
    # Intervals of a block, and rows of a batch.
    LANES = 32

    # Columns of a batch of rows.
    A0 = 0 * LANES
    A1 = 1 * LANES
    A2 = 2 * LANES
    PART = 3 * LANES
    W0 = 4 * LANES
    W1 = 5 * LANES
    Y0 = 6 * LANES
    Y1 = 7 * LANES
    DW0 = 8 * LANES
    DW1 = 9 * LANES
    DY0 = 10 * LANES
    DY1 = 11 * LANES
    ROWS = 12 * LANES

    # Columns of a block of intervals: the constant ones,
    E0 = 0 * LANES
    E1 = 1 * LANES
    E2 = 2 * LANES
    E3 = 3 * LANES
    LEFT = 4 * LANES
    LEAVE = 5 * LANES
    RIGHT = 6 * LANES
    ENTER = 7 * LANES
    LENGTH = 8 * LANES
    PACE = 9 * LANES
    LIFT = 10 * LANES
    WEIGHT0 = 11 * LANES
    WEIGHT1 = 12 * LANES
    WEIGHT2 = 13 * LANES
    # what follows from the ways, PULL and HELD of both ends,
    WAY = 14 * LANES
    RATE = 15 * LANES
    PULL = 16 * LANES
    HELD = 18 * LANES
    # and 1 where q is a parabola instead,
    PARABOLA = 20 * LANES
    FIXED = 21 * LANES

    # those of the motion: at the left end, `END` further on at the right end,
    B = 0 * LANES
    D = 1 * LANES
    K = 2 * LANES
    DB = 3 * LANES
    DD = 4 * LANES
    DK = 5 * LANES
    END = 6 * LANES
    # what limits scale with: that of jerk at the left and at the right end, and that of all others,
    ROOT = 12 * LANES
    SLOPE = 13 * LANES
    SIZE = 14 * LANES
    SCALE = 3 * LANES
    # derivatives of the middle term of F;
    MIDDLE1 = 21 * LANES
    MIDDLE2 = 22 * LANES
    MOTION = 23 * LANES

    # and sums over the rows at the left end, `SUMS` further on at the right end.
    M00 = 0 * LANES
    M01 = 1 * LANES
    M02 = 2 * LANES
    M11 = 3 * LANES
    M12 = 4 * LANES
    M22 = 5 * LANES
    G = 6 * LANES
    H = 9 * LANES
    SUMMED = 12 * LANES
    # The first two are largest values, the others sums over all blocks.
    FOUND0 = 12 * LANES
    FOUND1 = 13 * LANES
    FOUND2 = 14 * LANES
    FOUND3 = 15 * LANES
    SUMS = 16 * LANES
    # Of the same numbers, while limits between the ends of intervals are looked at: q, d and v at three places, after the sizes of
    # acceleration and jerk at five,
    PLACES = 10 * LANES
    # and the parts of a limit that are used.
    USED = 19 * LANES

cdef class Runs:
    cdef public long long[:, ::1] of
    cdef public long long[::1] first

cdef class Problem:
    cdef public Py_ssize_t n
    cdef public Py_ssize_t blocks
    cdef public Py_ssize_t free
    cdef public double[::1] c
    cdef public double[::1] h
    cdef public double[:, ::1] extra
    cdef public char[::1] back
    cdef public double start
    cdef public double[::1] way
    cdef public double[:, ::1] ends
    cdef public double[:, ::1] middle
    cdef public double[:, :, ::1] d1
    cdef public double[:, :, ::1] d2
    cdef public double[:, :, ::1] d3
    cdef public double[:, ::1] limits
    cdef public double[:, :, ::1] factor
    cdef public double[:, ::1] x3_excess
    cdef public char[::1] moves
    cdef public double[:, :, ::1] share
    cdef public double[::1] fixed
    cdef public double[::1] motion
    cdef public double[::1] sums
    cdef public double[::1] rows
    cdef public long long[:, ::1] batches
    cdef public char[:, ::1] state
    cdef public Py_ssize_t count
    cdef public Runs awake
    cdef public Runs asleep

cpdef void lay(Problem problem) noexcept nogil
cpdef Py_ssize_t size(Problem problem, Py_ssize_t block) noexcept nogil
cpdef void find_runs(Problem problem, char state, Runs runs) noexcept nogil
cpdef Py_ssize_t sides(Problem problem) noexcept nogil
