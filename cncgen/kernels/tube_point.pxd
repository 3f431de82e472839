# The problem of `least_time_tube`, and the values of a point, for the kernels that work on them as C (see `tube_point`).

cdef class Tube:
    cdef public Py_ssize_t n
    cdef public Py_ssize_t steps
    cdef public double calm
    cdef public double mu
    cdef public double curvature
    cdef public double rho
    cdef public double[::1] V
    cdef public double[::1] AV
    cdef public double[::1] JA
    cdef public double[:, ::1] weight
    cdef public double[:, ::1] r
    cdef public double[:, ::1] t
    cdef public double[::1] h0
    cdef public long long[::1] first
    cdef public double[:, ::1] rows
    cdef public double[::1] feed
    cdef public double[::1] between
    cdef public double[::1] hlow
    cdef public double[::1] hhigh
    cdef public double[::1] goal
    cdef public double exact
    cdef public double cost
    cdef public double[:, ::1] x
    cdef public double[:, ::1] u
    cdef public double[:, ::1] x2
    cdef public double[:, ::1] u2
    cdef public double[:, ::1] dx
    cdef public double[:, ::1] du
    cdef public double[:, ::1] lam
    cdef public double[:, ::1] lam2
    cdef public double[::1] nu
    cdef public double[::1] nu2
    cdef public double[::1] lamT
    cdef public double[::1] lamT2
    cdef public double[:, ::1] zx
    cdef public double[:, ::1] dzx
    cdef public double[:, ::1] zu
    cdef public double[:, ::1] dzu
    cdef public double[::1] zr
    cdef public double[::1] dzr
    cdef public double[::1] zf
    cdef public double[::1] dzf
    cdef public double[:, ::1] zm
    cdef public double[:, ::1] dzm
    cdef public double[:, ::1] P
    cdef public double[:, ::1] q
    cdef public double[:, ::1] K
    cdef public double[:, ::1] seen
    cdef public double value
    cdef public double logs
    cdef public double missed
    cdef public double most
    cdef public double[::1] row_slack
    cdef public double[:, ::1] row_slope
    cdef public double[::1] feed_slack
    cdef public double[:, ::1] feed_slope
    cdef public double[::1] middle_slack
    cdef public double[:, ::1] middle
    cdef public double[:, ::1] miss

cpdef void measure(Tube tube, bint tried) noexcept nogil
