# The function of `arc_centres` that another kernel calls as C.

cpdef double complex centre_from_radius(
    double x0, double y0, double x1, double y1, double radius, bint clockwise, double tolerance
) noexcept nogil
