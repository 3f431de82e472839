# What `gcode_run` uses as C of `language_store`.

cdef class LanguageStore:
    cdef double[::1] numbers
    cdef long long[::1] target
    cdef long long[::1] place
    cdef double[::1] before
    cdef int least
    cdef object scopes
    cdef public list names
    cdef int settings
    cdef double found
    cdef public object leads
    cdef object enters
    cdef object call
    cdef object leave
    cdef public int depth
    cdef dict loops
    cdef public dict ways
    cdef public tuple way
    cdef int index(self, double value) noexcept
    cdef bint set(self, int k, double value) noexcept
    cdef object _variable(self, int k, int indices)
    cdef bint has(self, int k) except -1
    cdef bint has_element(self, int k, double index) except -1
    cdef bint set_variable(self, int k, double value) except -1
    cdef bint set_element(self, int k, double index, double value) except -1
    cdef bint _put(self, object variable, int k, long long place, double value) except -1
    cdef int undo(self) except -1
    cdef int goes(self, Py_ssize_t r, long long line, int jump, int counter, double value, double last) except -2
