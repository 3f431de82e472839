"""Recursive filters, sample by sample."""

import cython


def all_pole(values: cython.double[::1], denominator: cython.double[::1], memory: cython.double[::1]) -> None:
    """Filter in place by 1/(1 + a1 z⁻¹ + … + am z⁻ᵐ).

    Args:
        values: Shape (n,).
        denominator: a1 … am.
        memory: Shape (m,): the last m outputs, the newest first; kept between calls.
    """
    n: cython.Py_ssize_t = values.shape[0]
    order: cython.Py_ssize_t = denominator.shape[0]
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    total: cython.double
    for k in range(n):
        total = values[k]
        for i in range(order):
            total -= denominator[i] * memory[i]
        for i in range(order - 1, 0, -1):
            memory[i] = memory[i - 1]
        if order > 0:
            memory[0] = total
        values[k] = total
