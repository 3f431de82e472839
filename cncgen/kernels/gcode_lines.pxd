# What other kernels use as C of `gcode_lines`.

from cncgen.kernels.decimals cimport Numbers
from cncgen.kernels.grammar_tables cimport Tables


cdef class Code(Tables):
    cdef public int[::1] code
    cdef public double[::1] constants
    cdef public list names
    cdef dict numbered
    cdef int[::1] made
    cdef Py_ssize_t[::1] begins
    cdef Py_ssize_t[::1] ends
    cdef int[::1] codes
    cdef Numbers tokens
    cdef public int used
    cdef public int numbers
    cdef int base
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
    cdef Py_ssize_t read(self, Py_ssize_t offset)
    cdef int write(self, Py_ssize_t at, Py_ssize_t end)
    cdef void emit(self, int operation, int operand) noexcept
    cdef int push(self, double value) noexcept
    cdef void negate(self, int k) noexcept
    cpdef object label(self, Py_ssize_t at, Py_ssize_t constants)
    cdef int small(self, Py_ssize_t at) noexcept
    cdef double number(self, Py_ssize_t at, Py_ssize_t end) noexcept
    cdef int name_number(self, str name)
    cpdef Py_ssize_t cut(self) noexcept
