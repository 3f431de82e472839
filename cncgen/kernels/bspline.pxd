# The curves and the knot span of `bspline`, for another kernel that works on them as C.

cdef class Curves:
    cdef readonly const long long[::1] degree
    cdef readonly const long long[::1] point_offset
    cdef readonly const long long[::1] knot_offset
    cdef readonly const double[:, ::1] points
    cdef readonly const double[::1] weights
    cdef readonly const double[::1] knots
    cdef readonly Py_ssize_t highest


cdef class Span:
    cdef readonly Curves curves
    cdef readonly Py_ssize_t c
    cdef readonly Py_ssize_t i
    cdef readonly Py_ssize_t p
    cdef readonly bint plain
    cdef double[:, :, ::1] q
    cdef readonly double[:, ::1] value
    cdef double[::1] basis
    cdef double[:, ::1] over

    cpdef Py_ssize_t find(self, Py_ssize_t c, double u, int side) noexcept nogil
    cpdef void enter(self, Py_ssize_t c, Py_ssize_t i, Py_ssize_t order) noexcept nogil
    cpdef void homogeneous(self, Py_ssize_t order, double u, double[:, ::1] out) noexcept nogil
    cpdef void derivatives(self, Py_ssize_t order, double u) noexcept nogil
