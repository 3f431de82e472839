"""Reductions column by column, against NumPy's along the last axis: the same bits."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.geometry.columns import anywhere, max_over_axes, min_over_axes, norm, total


@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (50, 3), (50, 7), (20, 3, 5)])
def test_reductions_are_those_along_the_last_axis(shape: tuple[int, ...]) -> None:
    """Extremes, sums and lengths of random vectors, and of views of them."""
    values = np.random.default_rng(5).normal(size=shape) * 10.0 ** np.arange(shape[-1])
    for x in (values, values[::-1]):
        assert np.array_equal(max_over_axes(x), x.max(axis=-1))
        assert np.array_equal(min_over_axes(x), x.min(axis=-1))
        assert np.array_equal(total(x), x.sum(axis=-1))
        assert np.array_equal(norm(x), np.linalg.norm(x, axis=-1))
        assert np.array_equal(anywhere(x > 1.0), (x > 1.0).any(axis=-1))
