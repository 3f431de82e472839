# The functions of `plain_lines` that `language_code` calls as C.

cpdef double plain_value(const unsigned char[::1] text, Py_ssize_t at, Py_ssize_t end) noexcept
cpdef Py_ssize_t code_end(const unsigned char[::1] text, Py_ssize_t at, Py_ssize_t size) noexcept
cpdef Py_ssize_t behind_number(const unsigned char[::1] text, Py_ssize_t at, Py_ssize_t size) noexcept
