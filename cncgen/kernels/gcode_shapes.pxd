# What `gcode_parse` calls as C of `gcode_shapes`.

cdef class Shapes:
    cdef unsigned char shape[256]
    cdef double value[256]
    cdef unsigned int sum
    cdef Py_ssize_t length
    cdef Py_ssize_t count
    cdef Py_ssize_t stored
    cdef unsigned char[::1] store
    cdef public long long[:, ::1] table
    cpdef Py_ssize_t read(self, const unsigned char[::1] text, Py_ssize_t at) noexcept
    cpdef Py_ssize_t find(self) noexcept
    cpdef Py_ssize_t put(self, Py_ssize_t row, double[::1] constants, Py_ssize_t first) noexcept
    cpdef void keep(self, long long code, long long marks, double[::1] constants, Py_ssize_t first, Py_ssize_t end) noexcept
    cpdef void forget(self) noexcept
