# What other kernels use as C of `gcode_instructions`.

from cncgen.kernels.gcode_lines cimport Code
from cncgen.kernels.gcode_rows cimport Rows
from cncgen.kernels.gcode_store cimport Store
from cncgen.kernels.language_store cimport LanguageStore


cdef class Instructions:
    cdef const int[::1] code
    cdef const double[::1] constants
    cdef long long[::1] block_line
    cdef long long[::1] block_offset
    cdef unsigned char[::1] block_flags
    cdef long long[::1] word_end
    cdef unsigned char[::1] letters
    cdef double[::1] values
    cdef double[::1] numbers
    cdef long long[:, ::1] kept
    cdef Code reader
    cdef Store store
    cdef public LanguageStore language
    cdef Rows rows
    cdef double stack[100]
    cdef int depth
    cdef object waits
    cdef int counter
    cdef int meant[128]
    cdef bint macros
    cdef public bint calls
    cdef int called
    cdef unsigned char taken[200]
    cdef public Py_ssize_t blocks
    cdef list frames
    cdef Py_ssize_t first
    cdef Py_ssize_t words
    cdef unsigned int given
    cdef int flags
    cdef bint passed
    cdef bint rounded
    cdef bint holds
    cdef int arguments
    cdef int execute(self, Py_ssize_t r) except? -2
    cdef int end_block(self, Py_ssize_t r)
