# What `gcode_run` uses as C of `gcode_jumps`.

cimport cython

from cncgen.kernels.gcode_frames cimport Frame
from cncgen.kernels.gcode_instructions cimport Instructions
from cncgen.kernels.gcode_marks cimport Marks


cdef class Jumps(Instructions):
    cdef Marks marks
    cdef object leads
    cdef object begins
    cdef object outermost
    cdef object find
    cdef Py_ssize_t deepest
    cdef long long source
    cdef public object away
    cdef public Py_ssize_t units
    cdef Py_ssize_t next
    cdef long long next_line
    cdef bint follow_line(self, Py_ssize_t r, int kind)
    @cython.final
    cdef bint _jump(self, Py_ssize_t r, int jump)
    @cython.final
    cdef bint _lead(self, Py_ssize_t r, int keyword)
    @cython.final
    cdef bint _flow(self, Py_ssize_t r, int keyword)
    @cython.final
    cdef bint _branch(self, Py_ssize_t r, int keyword, label)
    @cython.final
    cdef Py_ssize_t _branch_that_holds(self, Py_ssize_t m, label) except -2
    @cython.final
    cdef void _go_to_mark(self, Py_ssize_t m, bint at) except *
    @cython.final
    cdef bint _call(self, Py_ssize_t r, label)
    @cython.final
    cdef bint _leave(self, label, bint anywhere)
    @cython.final
    cdef bint _call_program(self, Py_ssize_t r)
    @cython.final
    cdef bint _end_program(self, Py_ssize_t r)
    @cython.final
    cdef Frame _begin(self, Py_ssize_t r, label, int count)
    @cython.final
    cdef bint _return(self, Frame frame, double result)
    @cython.final
    cdef void _end_call(self, Py_ssize_t r) except *
    @cython.final
    cdef void _go_to_place(self, place) except *
    @cython.final
    cdef void _go(self, Py_ssize_t offset, long long line) except *
