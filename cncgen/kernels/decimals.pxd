# What other kernels use as C of `decimals`.

cpdef double decimal(unsigned long long mantissa, int digits, int decimals) noexcept nogil
cpdef bint is_blank(int c) noexcept nogil
cpdef bint is_of_name(int c) noexcept nogil


cdef class Numbers:
    cdef const unsigned char[::1] text
    cdef int comma
    cdef bint blanks
    cdef unsigned long long mantissa
    cdef double value
    cdef int decimals
    cdef Py_ssize_t _digits(self, Py_ssize_t at, Py_ssize_t end) noexcept
    cdef Py_ssize_t _go_on(self, Py_ssize_t at, Py_ssize_t end, int digits) noexcept
    cdef Py_ssize_t read(self, Py_ssize_t at, Py_ssize_t end) noexcept
