# What other kernels use as C of `gcode_lines`.

cdef class Code:
    cdef public const unsigned char[::1] text
    cdef public int[::1] code
    cdef public double[::1] constants
    cdef public list names
    cdef public int used
    cdef public int numbers
    cdef public long long flags
    cdef public bint shaped
    cdef public bytes fixed
    cdef public bint comma
    cdef public bint remarks
    cdef public bint alike
    cdef public Py_ssize_t begin
    cdef public Py_ssize_t error
    cdef public Py_ssize_t lines
    cdef public Py_ssize_t number_begin
    cdef public Py_ssize_t number_end
    cpdef bint room(self) noexcept
    cpdef Py_ssize_t read(self, Py_ssize_t offset) except -1
    cpdef Py_ssize_t cut(self) noexcept
