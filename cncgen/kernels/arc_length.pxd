# The function of `arc_length` that another kernel calls as C.

cpdef double parameter_at(
    const double[:, ::1] cell, Py_ssize_t low, Py_ssize_t high, double s, int side, double snap, double[::1] rest
) noexcept nogil
