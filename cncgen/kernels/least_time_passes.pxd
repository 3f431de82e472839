# The functions of `least_time_passes` that another kernel calls as C.

cpdef void exchange(
    double[:, ::1] rows,
    char[::1] kind,
    long long[::1] axis,
    Py_ssize_t i,
    Py_ssize_t j,
) noexcept nogil
cpdef void gather(
    double[::1] c,
    double[:, ::1] ends,
    double[:, ::1] root,
    double[:, ::1] rows,
    long long[::1] offset,
    long long[::1] awake,
    char[::1] kind,
    long long[::1] axis,
    double level,
    double step,
    double rise,
    double mu,
    double[::1] grad,
    double[::1] dual,
    double[::1] right,
    double[:, ::1] band,
    double[::1] out,
) noexcept nogil
cpdef void predict(
    double[::1] c,
    double[::1] dc,
    double[:, ::1] ends,
    double[:, ::1] root,
    double[:, ::1] rows,
    long long[::1] offset,
    long long[::1] awake,
    char[::1] kind,
    double[::1] centre,
    double[::1] second,
    double[::1] out,
) noexcept nogil
cpdef void correct(
    double[::1] c,
    double[::1] dc,
    double[:, ::1] ends,
    double[:, ::1] root,
    double[:, ::1] rows,
    long long[::1] offset,
    long long[::1] awake,
    char[::1] kind,
    double mu,
    double[::1] out,
) noexcept nogil
