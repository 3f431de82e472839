# The knot span of `bspline`, for another kernel that works on it as C.

cdef class Span:
    cdef readonly Py_ssize_t i
    cdef readonly Py_ssize_t p
    cdef const double[::1] knots
    cdef double[:, :, ::1] q
    cdef readonly double[:, ::1] value
    cdef double[::1] basis

    cpdef Py_ssize_t find(self, Py_ssize_t first, Py_ssize_t last, double u, int side) noexcept nogil
    cpdef void enter(
        self,
        Py_ssize_t i,
        Py_ssize_t p,
        Py_ssize_t order,
        Py_ssize_t point,
        const double[:, ::1] points,
        const double[::1] weights,
    ) noexcept nogil
    cpdef void homogeneous(self, Py_ssize_t order, double u, double[:, ::1] out) noexcept nogil
    cpdef void derivatives(self, Py_ssize_t order, double u) noexcept nogil
