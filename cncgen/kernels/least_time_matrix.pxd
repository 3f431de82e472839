# The functions of `least_time_matrix` that another kernel calls as C.

cpdef double objective(
    double[::1] c,
    double[::1] h,
    double[:, ::1] ends,
    double[:, ::1] extra,
    double[::1] grad,
    double[:, ::1] band,
    double[:, ::1] root,
) noexcept nogil
cpdef bint factorize(double[:, ::1] band, Py_ssize_t start, Py_ssize_t stop) noexcept nogil
cpdef void substitute(
    double[:, ::1] band, Py_ssize_t start, Py_ssize_t stop, double[::1] right, double[::1] dc
) noexcept nogil
cpdef double positive(double[::1] c, double[::1] dc, double[:, ::1] ends) noexcept nogil
