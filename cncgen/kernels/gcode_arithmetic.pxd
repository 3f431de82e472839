# The functions of `gcode_arithmetic` that another kernel calls as C.

cpdef double arc_tangent(double y, double x) noexcept
cpdef double function_of(unsigned int name, double a) noexcept
cpdef int operator_at(int first, int second, int third) noexcept
cpdef double joined(int operator, double a, double b) noexcept
