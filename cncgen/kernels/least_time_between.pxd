# The functions of `least_time_between` that another kernel calls as C.

cpdef double tighten(
    double[::1] c,
    double[::1] h,
    double[:, ::1] ends,
    double[:, :, ::1] d1,
    double[:, :, ::1] d2,
    double[:, :, ::1] d3,
    double[:, ::1] limits,
    double[:, :, ::1] factor,
    double[:, ::1] hidden,
    double[:, :, ::1] share,
    double slack,
    Py_ssize_t eased,
    bint fresh,
) noexcept nogil
cpdef void apply(
    double[:, ::1] rows,
    long long[::1] offset,
    char[::1] kind,
    long long[::1] axis,
    double[:, :, ::1] share,
    double slack,
    Py_ssize_t eased,
) noexcept nogil
