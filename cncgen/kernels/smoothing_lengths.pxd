# The functions of `smoothing_lengths` that `smoothing` calls as C.

cpdef double length_at(const double[::1] t, double[::1] scale, Py_ssize_t k, double at) noexcept nogil
cpdef void lower(const double[::1] t, double[::1] scale) noexcept nogil
cpdef Py_ssize_t lay(
    const double[::1] t,
    double[::1] scale,
    const double[::1] cuts,
    double[::1] knots,
    Py_ssize_t laid,
    double[::1] strides,
) noexcept nogil
cpdef Py_ssize_t choose(
    const double[::1] t,
    const double[::1] bend,
    double[::1] knots,
    Py_ssize_t first,
    Py_ssize_t last,
    double[::1] at,
) noexcept nogil
cpdef void adjust(
    const double[::1] t,
    double[::1] scale,
    double[:, ::1] used,
    const double[::1] longest,
    bint grow,
    double least,
    double[::1] change,
) noexcept nogil
