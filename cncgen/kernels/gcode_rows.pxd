# What `gcode_run` uses as C of `gcode_rows`.

cdef class Rows:
    cdef const unsigned char[::1] text
    cdef long long[:, ::1] kept
    cdef long long[:, ::1] near
    cdef object lines
    cdef dict entries
    cdef dict ways
    cdef Py_ssize_t used
    cdef Py_ssize_t last
    cdef Py_ssize_t ahead
    cdef Py_ssize_t thrown
    cdef bint again
    cdef void _forget(self) except *
    cdef Py_ssize_t at(self, Py_ssize_t offset, long long line) except? -1
    cdef Py_ssize_t _compiled(self, Py_ssize_t offset, long long line) except? -1
    cdef Py_ssize_t following(self, Py_ssize_t r) except? -1
