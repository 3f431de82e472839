"""Growing a toolpath: chunks are cut anywhere without changing what they say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.geometry.tables import ArcTable, NurbsTable
from cncgen.toolpath.building import RowBuilder, ToolpathBuilder, join_arcs, join_nurbs
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath


def lines(ends: list[list[float]], **changes: Any) -> RowBuilder:
    """Return rows of lines."""
    count = len(ends)
    values: dict[str, Any] = {
        "kind": np.zeros(count, np.int8),
        "end": np.array(ends, float),
        "feed": np.full(count, 10.0),
        "feed_mode": np.zeros(count, np.int8),
        "curve": np.full(count, -1, np.int64),
        "line": np.arange(count, dtype=np.int64),
        "path_mode": PathMode.CONTINUOUS,
        "tolerance": 0.01,
        "source": 0,
    }
    return RowBuilder(**{**values, **changes})


def arc(end: list[float], sweep: float) -> RowBuilder:
    """Return a row of one arc."""
    table = ArcTable(np.array([[sweep, 0, 0]]), np.array([[0.0, 0, 1]]), np.array([sweep]))
    return lines([end], kind=np.array([Kind.ARC], np.int8), curve=np.zeros(1, np.int64), arcs=table)


def nurbs(end: list[float], weight: float) -> RowBuilder:
    """Return a row of one straight B-spline."""
    points = np.array([[0.0, 0, 0], end])
    table = NurbsTable(
        np.array([1]),
        np.array([0, 2]),
        np.array([0, 4]),
        points,
        np.array([1.0, weight]),
        np.array([0.0, 0, 1, 1]),
    )
    return lines([end], kind=np.array([Kind.NURBS], np.int8), curve=np.zeros(1, np.int64), nurbs=table)


def fresh() -> ToolpathBuilder:
    """Return a builder of three axes at the origin."""
    return ToolpathBuilder("XYZ", np.zeros(3), ["t"])


def flat(chunks: list[Toolpath]) -> list[tuple[Any, ...]]:
    """Return every row with what it points to."""
    rows = []
    for chunk in chunks:
        for i in range(len(chunk)):
            what: Any = None
            k = int(chunk.curve[i])
            if chunk.kind[i] == Kind.ARC:
                what = float(chunk.arcs.sweep[k])
            elif chunk.kind[i] == Kind.NURBS:
                what = float(chunk.nurbs.weights[chunk.nurbs.point_offset[k + 1] - 1])
            elif chunk.kind[i] == Kind.EVENT:
                what = chunk.events[k].name
            start = chunk.starts[i].tolist()
            rows.append((int(chunk.kind[i]), start, chunk.end[i].tolist(), what))
    return rows


steps = st.lists(
    st.tuples(st.sampled_from(["line", "arc", "nurbs", "event", "cut"]), st.integers(1, 9)), max_size=30
)


@given(steps)
def test_chunks_cut_anywhere_say_the_same(plan: list[tuple[str, int]]) -> None:
    whole, cut = fresh(), fresh()
    pieces = []
    for count, (what, size) in enumerate(plan):
        end = [float(count + 1), float(size), 0.0]
        for builder in (whole, cut):
            if what == "line":
                builder.add(lines([end]))
            elif what == "arc":
                builder.add(arc(end, float(size)))
            elif what == "nurbs":
                builder.add(nurbs(end, float(size)))
            elif what == "event":
                builder.event(Event(f"e{size}"), count, 0)
        if what == "cut":
            pieces.append(cut.take())
    pieces.append(cut.take())
    assert flat([whole.take()]) == flat(pieces)


def test_lines_of_no_length_are_left_out() -> None:
    builder = fresh()
    builder.add(lines([[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]]))
    chunk = builder.take()
    assert chunk.end[:, 0].tolist() == [1, 2]
    assert chunk.line.tolist() == [1, 3]


def test_an_arc_that_ends_where_it_starts_stays() -> None:
    builder = fresh()
    builder.add(arc([0, 0, 0], 6.28))
    assert builder.take().kind.tolist() == [Kind.ARC]


def test_an_empty_chunk_stands_where_the_path_is() -> None:
    builder = fresh()
    builder.add(lines([[1, 2, 3]]))
    builder.take()
    chunk = builder.take()
    assert len(chunk) == 0
    assert chunk.start.tolist() == [1, 2, 3]
    assert chunk.end.shape == (0, 3)


def test_events_repeat_the_position_and_keep_their_line() -> None:
    builder = fresh()
    builder.add(lines([[1, 0, 0]]))
    builder.event(Event("dwell", True, 0.5), 7, 0)
    chunk = builder.take()
    assert chunk.end.tolist() == [[1, 0, 0], [1, 0, 0]]
    assert chunk.line.tolist() == [0, 7]
    assert np.isnan(chunk.feed[1])
    assert chunk.feed_mode[1] == FeedMode.RAPID
    assert chunk.events[0].dwell_s == 0.5


def test_path_modes_belong_to_their_rows() -> None:
    builder = fresh()
    builder.add(lines([[1, 0, 0]], path_mode=PathMode.EXACT_STOP, tolerance=float("nan")))
    builder.add(lines([[2, 0, 0], [3, 0, 0]], tolerance=0.5, source=1))
    chunk = builder.take()
    assert chunk.path_mode.tolist() == [PathMode.EXACT_STOP, PathMode.CONTINUOUS, PathMode.CONTINUOUS]
    np.testing.assert_array_equal(chunk.tolerance, [np.nan, 0.5, 0.5])
    assert chunk.source.tolist() == [0, 1, 1]


def test_retracing_goes_back_at_the_same_feed() -> None:
    builder = fresh()
    builder.add(lines([[0, 0, -5]]))
    builder.retrace(np.zeros(3))
    chunk = builder.take()
    assert chunk.end.tolist() == [[0, 0, -5], [0, 0, 0]]
    assert chunk.feed.tolist() == [10, 10]


@pytest.mark.parametrize("count", [0, 1, 3])
def test_joined_tables_hold_all_curves(count: int) -> None:
    tables = [nurbs([k + 1.0, 0, 0], k + 1.0).nurbs for k in range(count)]
    joined = join_nurbs([t for t in tables if t], 3)
    assert len(joined) == count
    assert joined.point_offset.tolist() == [2 * k for k in range(count + 1)]
    assert joined.knot_offset.tolist() == [4 * k for k in range(count + 1)]
    arcs = join_arcs([a for a in (arc([1, 0, 0], k + 1.0).arcs for k in range(count)) if a])
    assert arcs.sweep.tolist() == [k + 1.0 for k in range(count)]
