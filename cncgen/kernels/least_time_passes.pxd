# The functions of `least_time_passes` that another kernel calls as C.

from cncgen.kernels.least_time_problem cimport Problem

cpdef void set_up(Problem problem, double mu) noexcept nogil
cpdef bint wake(Problem problem, double level) noexcept nogil
cpdef void gather(
    Problem problem,
    double step,
    double rise,
    double[::1] dual,
    double[::1] right,
    double[:, ::1] band,
    double[::1] out,
) noexcept nogil
cpdef void predict(
    Problem problem, double[::1] second, double[::1] centre, double[::1] out
) noexcept nogil
cpdef void correct(Problem problem, double mu, double[::1] out) noexcept nogil
