# The parser that another kernel calls as C.

cdef class Parser:
    cdef const short[:, ::1] action, goto, again, move, token
    cdef const short[::1] length, origin, made, classes, mode, literal, kept
    cdef const unsigned char[::1] text
    cdef public int[::1] code
    cdef public double[::1] constants
    cdef int[:, ::1] symbol
    cdef public tuple terminals
    cdef public list names
    cdef dict numbered
    cdef int start, accept, end, delete, line_word, stored, top, depth
    cdef bint increments
    cdef Py_ssize_t begin
    cdef public int used, numbers, flags
    cdef public Py_ssize_t error, number_begin, number_end

    cpdef Py_ssize_t parse(self, const unsigned char[::1] text, Py_ssize_t offset)
    cdef void _push(self, Py_ssize_t at, Py_ssize_t taken, int literal) noexcept
    cdef int _reduce(self, int kind) except -1
    cdef void _emit(self, int operation, int operand) noexcept
    cdef void _constant(self, double value) noexcept
    cdef int _act(self, int action, int count) except -1
    cdef int _act_rarely(self, int action, int first, int count) except -1
    cdef void _flow(self, int keyword, int count) noexcept
    cdef void _statement(self, int number, int first, int count) noexcept
    cdef int _plain_word(self, int k) except -1
    cdef int _letter(self, int k) noexcept
    cdef bint _dotted(self, int k) noexcept
    cdef void _parameter(self, int k) noexcept
    cdef void _exists(self, int k) noexcept
    cdef void _negative(self, int first, int action) noexcept
    cdef int _name(self, int begin, int end) except -1
    cdef int _named_label(self, int k) except -1
    cdef void _remark(self, int operation, int k) noexcept
    cdef double _number(self, int begin, int end) except? -1.0
    cdef unsigned long long _words_named(self, int[::1] first, const unsigned char[::1] calls, int line) noexcept
    cdef int _place(self, int at, int letter) noexcept
    cdef int _program_called(self, int letter, set programs) except -1
