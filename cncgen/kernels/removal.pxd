# The functions of `removal` that another kernel calls as C.

cpdef double lift(double rho, double flat, double edge, double slope) noexcept nogil
cpdef double lead(double m, double d, double half, double flat, double edge, double slope) noexcept nogil
