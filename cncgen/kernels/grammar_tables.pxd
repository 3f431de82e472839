# The class of `grammar_tables` that other kernels have for a base.

cdef class Tables:
    cdef const unsigned char[::1] text
    cdef const short[::1] action
    cdef const short[::1] goto
    cdef const short[::1] lead
    cdef const short[::1] move
    cdef const short[::1] token
    cdef const short[::1] mode
    cdef const short[::1] classes
    cdef const short[::1] origin
    cdef const short[::1] length
    cdef const short[::1] passed
    cdef const short[::1] apart
    cdef int[::1] silent
    cdef int[::1] stack
    cdef int widths[5]
    cdef public tuple terminals
    cdef dict starts
    cdef int depth
    cdef int first
    cdef int accept
    cdef int end
    cdef Py_ssize_t taken
    cdef int ended
    cdef Py_ssize_t refused
    cdef int run(self, Py_ssize_t at, Py_ssize_t size)
    cdef int _shifted(self, int kind, Py_ssize_t at)
    cdef int _reduced(self, int rule, Py_ssize_t at)
