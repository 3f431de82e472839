# What `gcode_run` uses as C of `language_store`.

from cncgen.kernels.gcode_store cimport Store


cdef class LanguageStore(Store):
    cdef long long[::1] place
    cdef int least
    cdef object scopes
    cdef public object leads
    cdef object enters
    cdef object call
    cdef object leave
    cdef dict loops
    cdef public tuple way
    cdef object _variable(self, int k, int indices)
    cdef bint has_element(self, int k, double index)
    cdef bint set_element(self, int k, double index, double value)
    cdef bint _put(self, object variable, int k, long long place, double value)
    cdef int _repeats(self, object here, double value)
    cdef int _counts(self, object here, int counter, double value, double last)
    cdef int goes(self, Py_ssize_t r, long long line, int jump, int counter, double value, double last) except -2
