# What `gcode_run` uses as C of `gcode_marks`.

cdef class Marks:
    cdef public list labels
    cdef long long[:, ::1] rows
    cdef dict written
    cdef list computed
    cdef list borders
    cdef dict subs
    cdef public Py_ssize_t count
    cdef public bint computes
    cdef public bint certain
    cpdef Py_ssize_t behind(self, long long offset) noexcept
    cpdef Py_ssize_t nearest(self, long long offset, int way, label, unsigned int keywords, bint over_borders, resolve) except -2
    cpdef Py_ssize_t border(self, Py_ssize_t m, int way) except -2
    cpdef Py_ssize_t subroutine(self, label) except -2
    cpdef bint leads(self, Py_ssize_t m)
    cdef bint _judge(self, Py_ssize_t m)
    cdef Py_ssize_t _nearest_of(self, list row, Py_ssize_t place, Py_ssize_t last, int way, unsigned int keywords, label, resolve) except -2
