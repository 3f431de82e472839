"""Cutting and joining toolpaths: the parts together are the whole, curves and events along."""

from __future__ import annotations

from dataclasses import replace

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


def test_what_smoothing_leaves_to_chords_travels_beside_the_tolerance() -> None:
    """A part and a join have it row by row; rows that are not smoothed leave all of their tolerance."""
    whole = random_toolpath(7)
    room = np.linspace(0.001, 0.002, len(whole))
    smoothed = replace(whole, chord_room=room)
    part = between(smoothed, 3, 9)
    np.testing.assert_array_equal(part.chord_tolerance, room[3:9])
    np.testing.assert_array_equal(part.tolerance, whole.tolerance[3:9])
    mixed = join([part, between(whole, 9, 12)])
    np.testing.assert_array_equal(mixed.chord_room, np.concatenate([room[3:9], whole.tolerance[9:12]]))
    np.testing.assert_array_equal(mixed.tolerance, whole.tolerance[3:12])


def test_a_toolpath_measures_its_path_once() -> None:
    whole = random_toolpath(7)
    assert whole.path is whole.path
    assert replace(whole).path is not whole.path
    np.testing.assert_array_equal(whole.path.row_s, path_of(whole).row_s)
