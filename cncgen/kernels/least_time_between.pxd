# The functions of `least_time_between` that another kernel calls as C.

from cncgen.kernels.least_time_problem cimport Problem

cpdef double tighten(Problem problem, double slack, Py_ssize_t eased, bint fresh) noexcept nogil
cpdef void apply(Problem problem, double slack, Py_ssize_t eased) noexcept nogil
