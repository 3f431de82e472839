# What `gcode_motion` uses as C of `gcode_words`.

cpdef void take_cycle(int number, int needs) noexcept
cpdef int needs_of(int number) noexcept

cdef class Modes:
    cdef int motion
    cdef bint absolute
    cdef bint arc_absolute
    cdef double plane
    cdef int first
    cdef int second
    cdef unsigned int offsets
    cdef bint inverse_time
    cdef bint silent
    cdef bint free_spindle
    cdef bint holes
    cdef bint in_cycle
    cdef bint old_level
    cdef bint exact
    cdef bint tools
    cdef double system
    cdef double feed
    cdef double radius_tolerance
    cdef double centre_tolerance
    cdef double centre_relative
    cdef double centre_limit
    cdef double least_feed
    cdef double most_feed
    cdef void take(self, long long[::1] modes, double[::1] levels) noexcept
    cdef void choose_plane(self, long long plane) noexcept

cdef class BlockWords:
    cdef const unsigned char[::1] letters
    cdef const double[::1] values
    cdef bint plain
    cdef unsigned int given
    cdef int motion
    cdef int absolute
    cdef bint plane_said
    cdef bint system_said
    cdef bint changes
    cdef bint rare
    cdef int plane
    cdef int old_level
    cdef int spindle
    cdef int coolant
    cdef bint dwells
    cdef bint cancels
    cdef bint uncompensated
    cdef double word[19]
    cdef void read(self, Py_ssize_t begin, Py_ssize_t end, Modes force) noexcept
    cdef void _take_code(self, double code, Modes force) noexcept
    cdef void _take_rare_code(self, int code, Modes force) noexcept
    cdef void _take_function(self, double code, Modes force) noexcept
    cdef void _judge_rare_words(self, Modes force) noexcept
    cdef unsigned int _unused(self, int motion, bint ends, bint drills, Modes force) noexcept
