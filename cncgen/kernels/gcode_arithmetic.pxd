# The functions of `gcode_arithmetic` that another kernel calls as C.

cpdef double arc_tangent(double y, double x) noexcept
cpdef double function_of(int name, double a) noexcept
cpdef double joined(int operator, double a, double b) noexcept
