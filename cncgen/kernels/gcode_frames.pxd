# What `gcode_run` uses as C of `gcode_frames`.

cdef class Frame:
    cdef long long source
    cdef long long offset
    cdef long long line
    cdef public int count
    cdef double kept[33]
    cdef Py_ssize_t row
    cdef public object label
    cdef public dict named
    cdef public object values
    cdef public object again
    cdef public set doing
    cdef public dict left
    cdef public object saved
    cdef public bint restore
    cdef public bint modal
    cpdef void keep(self, double[::1] numbers, int count) noexcept
    cpdef void put_back(self, double[::1] numbers) noexcept
    cpdef bint repeats(self, label)
    cpdef int lead(self, long long keyword, label, double value)
    cdef int _at_while(self, label, bint holds)
    cdef int _at_repeat(self, bint begins, label, double count)
    cdef int _go_round(self, label, long long rounds)
