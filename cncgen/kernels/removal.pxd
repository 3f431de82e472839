# The functions of `removal` that another kernel calls as C.

cpdef double lift(double rho, double flat, double edge, double slope) noexcept nogil
cpdef double lowest_at(
    double x, double d, double length, double m, double radius, double flat, double edge, double slope
) noexcept nogil
cpdef Py_ssize_t first_node(double low, double cell) noexcept nogil
cpdef Py_ssize_t last_node(double high, double cell, Py_ssize_t count) noexcept nogil
cpdef double least(double a, double b, double c) noexcept nogil
