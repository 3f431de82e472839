# The functions of `decimals` that other kernels call as C.

cpdef double decimal(unsigned long long mantissa, int digits, int decimals) noexcept nogil
cpdef bint is_blank(int c) noexcept nogil
cpdef bint is_of_name(int c) noexcept nogil
