"""The feed over a plan in a few numbers, beside sums that are written down."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.report.feed_curve import BINS, FeedCurve, sparkline


@pytest.mark.parametrize("chunk", [1, 7, 1000, 100_000])
@pytest.mark.parametrize("steps", [1, 5, BINS, BINS + 1, 3 * BINS, 5000])
def test_bins_are_mean_feeds_however_the_rows_come(chunk: int, steps: int) -> None:
    """The step k is k µm long; a bin of m periods of 1 ms holds the mean of m numbers."""
    position = np.zeros((steps + 1, 2))
    position[:, 1] = np.append(0.0, np.cumsum(np.arange(steps))) * 1e-3
    curve = FeedCurve((0, 1), 1e-3)
    for start in range(0, steps + 1, chunk):
        curve.add(position[start : start + chunk])
    each = 1
    while steps > BINS * each:
        each *= 2
    expected = [np.mean(np.arange(k, min(k + each, steps))) for k in range(0, steps, each)]
    assert curve.feeds_mm_s() == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert len(expected) <= BINS


def test_axes_that_are_not_named_are_left_out() -> None:
    curve = FeedCurve((0,), 0.5)
    curve.add(np.array([[0.0, 0.0], [3.0, 4.0]]))
    assert curve.feeds_mm_s() == [6.0]


def test_a_sparkline_reaches_from_nothing_to_the_largest_value() -> None:
    assert sparkline([0.0, 1.0, 8.0, 4.0]) == "▁▂█▅"
    assert sparkline([]) == sparkline([0.0, 0.0]) == ""
