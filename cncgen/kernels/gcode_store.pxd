# What other kernels use as C of `gcode_store`.

cdef class Store:
    cdef double[::1] numbers
    cdef public dict named
    cdef public dict local
    cdef frozenset reserved
    cdef int storage
    cdef public list names
    cdef bytearray sorts
    cdef long long[::1] target
    cdef double[::1] value
    cdef public dict ways
    cdef public int calls
    cdef int settings
    cdef double found
    cdef bint returned
    cdef double result
    cdef int index(self, double value) noexcept
    cdef bint set(self, int k, double value) noexcept
    cdef int _sort(self, int k)
    cdef bint has(self, int k)
    cdef bint set_variable(self, int k, double value)
    cdef int end(self)
    cdef int settle(self)
    cdef int undo(self)
