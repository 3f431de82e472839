"""The banded solver of the least-time kernels beside numpy's dense one."""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
import pytest

from cncgen.kernels import least_time_matrix
from tests.kernels.plain import uncompiled


@pytest.fixture(params=["compiled", "plain"])
def kernel(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The kernel, compiled (where it is) and as plain Python."""
    if request.param == "compiled":
        return least_time_matrix
    monkeypatch.setitem(sys.modules, "cncgen.kernels.least_time_problem", uncompiled("least_time_problem"))
    return uncompiled("least_time_matrix")


def positive_band(n: int, seed: int) -> np.ndarray:
    """Return a symmetric positive definite matrix of five diagonals, shape (n, n): B Bᵀ with B of three lower ones."""
    rng = np.random.default_rng(seed)
    lower = np.tril(np.triu(rng.normal(size=(n, n)), -2))
    return lower @ lower.T + 1e-3 * np.eye(n)


def upper_diagonals(matrix: np.ndarray) -> np.ndarray:
    """Return three upper diagonals, shape (3, n + 2): entry [m, k] is that of row k and column k + m."""
    n = len(matrix)
    band = np.zeros((3, n + 2))
    for m in range(min(3, n)):
        band[m, : n - m] = np.diag(matrix, m)
    return band


@pytest.mark.parametrize(("n", "start"), [(1, 0), (2, 0), (3, 1), (40, 0), (40, 2)])
def test_a_banded_system_is_solved_as_numpy_solves_it(kernel: ModuleType, n: int, start: int) -> None:
    """On the unknowns from `start` on; those before it are given, and stay."""
    matrix, rng = positive_band(n, 7 * n + start), np.random.default_rng(1)
    band, right, dc = upper_diagonals(matrix), np.append(rng.normal(size=n), [0.0, 0.0]), np.ones(n + 2)
    assert kernel.factorize(band, start, n)
    kernel.substitute(band, start, n, right, dc)
    expected = np.linalg.solve(matrix[start:, start:], right[start:n])
    assert dc[start:n] == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
    assert not dc[:start].any()


def test_a_matrix_that_is_not_positive_is_refused(kernel: ModuleType) -> None:
    """diag(1, −1, 1) has a negative pivot, and so has [[1, 2], [2, 1]], whose diagonal is positive."""
    assert not kernel.factorize(upper_diagonals(np.diag([1.0, -1.0, 1.0])), 0, 3)
    assert not kernel.factorize(upper_diagonals(np.array([[1.0, 2.0], [2.0, 1.0]])), 0, 2)
    # Behind the pivot that is not positive nothing is looked at.
    assert kernel.factorize(upper_diagonals(np.diag([1.0, -1.0, 1.0])), 2, 3)
