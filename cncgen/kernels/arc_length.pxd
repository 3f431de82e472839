# The functions of `arc_length` that another kernel calls as C.

cpdef Py_ssize_t cell_at(
    const double[:, ::1] cell, Py_ssize_t low, Py_ssize_t high, double reach, Py_ssize_t near
) noexcept nogil
cpdef double parameter_at(
    const double[:, ::1] cell, Py_ssize_t low, Py_ssize_t last, double s, int side, double snap, double[::1] rest
) noexcept nogil
