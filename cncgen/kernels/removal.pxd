# The functions of `removal` that another kernel calls as C.

cpdef double lift(double rho, double flat, double edge, double slope) noexcept nogil
cpdef double lowest_at(
    double x, double d, double length, double m, double radius, double flat, double edge, double slope
) noexcept nogil
