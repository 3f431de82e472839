# The numbers of a body that a tool sweeps, and its methods, for a kernel that cuts along many lines.

cdef extern from *:
    """
    #define CNCGEN_CLOSE 1e-8
    #define CNCGEN_ENDLESS 1e299
    """
    # The distance at which Newton's method ends, and its least step, mm; a height without end, and one that is not known.
    const double CLOSE "CNCGEN_CLOSE"
    const double ENDLESS "CNCGEN_ENDLESS"

cdef class SweptBody:
    cdef double radius
    cdef double flat
    cdef double edge
    cdef double slope
    # Whether the tool is a ball.
    cdef bint ball
    # The frame of the tool at the start of the motion: its origin, and x, y, z seen from the field.
    cdef double ou
    cdef double ov
    cdef double ow
    cdef double xu
    cdef double xv
    cdef double xw
    cdef double yu
    cdef double yv
    cdef double yw
    cdef double zu
    cdef double zv
    cdef double zw
    # Its way across the axis, how far it rises along the axis a mm of that, and the lowest place of one that goes nowhere else.
    cdef double length
    cdef double rise
    # That of the angle between its way and the plane across the axis.
    cdef double cosine
    cdef double base
    # How far a line of the field goes across the axis a mm, squared, 1 over that, and 1 over its parts along x and y; 0 for without end.
    cdef double across
    cdef double per_across
    cdef double per_x
    cdef double per_y
    # The squares of the distances from the way that count as beside the tool, and as clear of it.
    cdef double beside
    cdef double clear_of
    # The line at hand: its point at w = 0 in the frame.
    cdef double x
    cdef double y
    cdef double z
    cdef double enter
    cdef double leave
    # Results: of `_clear` the envelope above a point, whose w is `known`, and its change along w, x and y, of `between` the ends.
    cdef double known
    # The last of the places that `misses` looked at, with the two of `_clear` there.
    cdef double seen
    cdef double seen_over
    cdef double seen_change
    cdef double over
    cdef double change
    cdef double gx
    cdef double gy
    # Least and largest w of the body, where it ends.
    cdef double lowest
    cdef double highest
    # Of `tangent` the value at a point and its changes along u, v and w.
    cdef double value
    cdef double fu
    cdef double fv
    cdef double fw
    cdef double low
    cdef double high

    cdef void take(
        self, double[:, ::1] lines, double[:, ::1] axes, Py_ssize_t k, double[::1] tool, double side, double tip
    ) noexcept nogil
    cdef void _disc(self, double x, double y) noexcept nogil
    cdef void _clear(self, double w) noexcept nogil
    cdef inline bint _over_ball(self, double x, double y) noexcept nogil
    cdef inline bint _over_disc(self, double x, double y) noexcept nogil
    cdef void _over_tool(self, double x, double y) noexcept nogil
    cdef double _steep(self, double rho) noexcept nogil
    cdef void place(self, double u, double v) noexcept nogil
    cdef void tangent(self, double w) noexcept nogil
    cdef bint beyond(self, double w, double a, double b, double half, double side) noexcept nogil
    cdef bint misses(self, double start, double end) noexcept nogil
    cdef bint line(self) noexcept nogil
    cdef double _nearer(self, double w, double sense) noexcept nogil
    cdef double _onto_ball(self, double w, double sense) noexcept nogil
    cdef double _root(self, double w, double last) noexcept nogil
    cdef void _look(self, double w) noexcept nogil
    cdef bint between(self, double low, double high) noexcept nogil
    cdef void narrow(
        self, double du, double dv, double pu, double pv, double qu, double qv, double far, double v
    ) noexcept nogil
    cdef double above(self, double w) noexcept nogil
