# cython: infer_types=True
"""Linear filters sample by sample, where the next value needs the last one."""

import cython


def recursive(
    b: cython.double[::1],
    a: cython.double[::1],
    x: cython.double[::1],
    y: cython.double[::1],
    state: cython.double[::1],
) -> cython.void:
    """Filter x into y by Σ a_i y[k−i] = Σ b_i x[k−i], a_0 = 1.

    The transposed direct form II (A. V. Oppenheim and R. W. Schafer, Discrete-Time Signal Processing (1999), section 6.4).

    Args:
        b, a: Shape (m + 1,).
        x, y: Shape (n,); y may be x.
        state: Shape (m,): zero at the start, and left ready for the samples that follow.
    """
    n: cython.Py_ssize_t = x.shape[0]
    m: cython.Py_ssize_t = state.shape[0]
    with cython.nogil:
        for k in range(n):
            out = b[0] * x[k]
            if m > 0:
                out += state[0]
                for i in range(m - 1):
                    state[i] = state[i + 1] + b[i + 1] * x[k] - a[i + 1] * out
                state[m - 1] = b[m] * x[k] - a[m] * out
            y[k] = out
