# The functions of `least_time_ways` that another kernel calls as C.

from cncgen.kernels.least_time_problem cimport Problem

cpdef double settle(Problem problem, bint choose) noexcept nogil
cpdef void refit(Problem problem) noexcept nogil
cpdef void meet(Problem problem) noexcept nogil
cpdef double agree(Problem problem, double least, int most) noexcept nogil
