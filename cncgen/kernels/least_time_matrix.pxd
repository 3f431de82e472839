# The functions of `least_time_matrix` that another kernel calls as C.

from cncgen.kernels.least_time_problem cimport Problem

cpdef double survey(Problem problem) noexcept nogil
cpdef void begin(Problem problem, Py_ssize_t block) noexcept nogil
cpdef void spread(Problem problem, Py_ssize_t block, Py_ssize_t column, double[::1] vector) noexcept nogil
cpdef void gathered(Problem problem, Py_ssize_t block, double[:, ::1] band) noexcept nogil
cpdef bint factorize(double[:, ::1] band, Py_ssize_t start, Py_ssize_t stop) noexcept nogil
cpdef void substitute(
    double[:, ::1] band, Py_ssize_t start, Py_ssize_t stop, double[::1] right, double[::1] dc
) noexcept nogil
cpdef double turn(Problem problem, double[::1] dc) noexcept nogil
