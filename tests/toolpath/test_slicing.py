"""Cutting and joining toolpaths: the parts together are the whole, curves and events along."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cncgen.toolpath.slicing import between, join
from tests.planner.smoothing.programs import chunked, path_of, random_toolpath


@given(st.integers(0, 2**32 - 1), st.integers(1, 20))
def test_parts_join_to_the_whole(seed: int, size: int) -> None:
    whole = random_toolpath(seed)
    again = join(list(chunked(whole, size)))
    for name in (
        "start",
        "kind",
        "end",
        "feed",
        "feed_mode",
        "path_mode",
        "tolerance",
        "curve",
        "line",
        "source",
    ):
        np.testing.assert_array_equal(getattr(again, name), getattr(whole, name))
    np.testing.assert_array_equal(again.arcs.sweep, whole.arcs.sweep)
    assert again.events == whole.events
    np.testing.assert_array_equal(path_of(again).row_s, path_of(whole).row_s)


def test_a_part_carries_its_own_curves_alone() -> None:
    whole = random_toolpath(7)
    part = between(whole, 3, 9)
    np.testing.assert_array_equal(part.start, whole.end[2])
    assert len(part.arcs) == np.count_nonzero(part.kind == 1)
    assert len(part.events) == np.count_nonzero(part.kind == 3)
