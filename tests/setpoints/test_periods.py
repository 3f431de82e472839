"""The constant period of a file: told from its times, and held against every row, over the borders of blocks too."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.ranges import POSITION
from cncgen.setpoints.checking import check_range
from cncgen.setpoints.events import EventWriter
from cncgen.setpoints.readers import open_setpoints
from cncgen.setpoints.readers.blocks import SHOWN_ROWS, FileBlock, stream_of
from cncgen.setpoints.readers.csv import BLOCK_BYTES
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.stream import SetpointStream
from cncgen.toolpath.record import Event

T = 0.001


def timed(*times: Sequence[float] | np.ndarray, period_s: float | None = None) -> SetpointStream:
    """Return the stream of blocks of one axis at these times."""
    blocks = (FileBlock("X", np.asarray(t, float), np.zeros((len(t), 1))) for t in times)
    return stream_of(blocks, "a.csv", period_s)


def test_rows_are_counted_from_time_zero() -> None:
    """Rows of 5 s on are rows 5000 on, whatever blocks they come in."""
    t = 5.0 + np.arange(2500) * T
    chunks = list(timed(t[:1200], t[1200:1201], t[1201:]).chunks)
    assert [chunk.first for chunk in chunks] == [5000, 6200, 6201]
    assert [len(chunk) for chunk in chunks] == [1200, 1, 1299]


@pytest.mark.parametrize(("off_s", "period_s"), [(1e-9, T), (3e-9, T + 3e-11)])
def test_a_period_is_a_round_number_of_nanoseconds_where_its_times_allow(
    off_s: float, period_s: float
) -> None:
    """Both ends rounded to nanoseconds make at most 1 ns of all steps together; more than that is no rounding."""
    t = np.arange(101) * T
    t[-1] += off_s
    assert timed(t).period_s == pytest.approx(period_s, abs=1e-15)
    assert (timed(t).period_s == T) == (period_s == T)
    assert timed(np.arange(30_001) / 3000.0).period_s == pytest.approx(1.0 / 3000.0, abs=1e-15)


def test_one_late_row_does_not_change_the_period() -> None:
    """The median step is the period, and the row after the gap is named; so at the border of two blocks."""
    t = np.arange(1500) * T
    t[700:] += 50.0 * T
    stream = timed(t[:1200], t[1200:])
    assert stream.period_s == T
    with pytest.raises(UsageError, match=r"row 701 \(t = 0.75 s\) comes 0.051 s after the one before it"):
        list(stream.chunks)
    t = np.arange(1500) * T
    t[700:] += 0.3 * T
    with pytest.raises(UsageError, match="row 701 "):
        list(timed(t, period_s=T).chunks)
    t = np.arange(1500) * T
    t[1200:] += T
    with pytest.raises(UsageError, match=r"row 1201 \(t = 1.201 s\) comes 0.002 s after") as caught:
        list(timed(t[:1200], t[1200:]).chunks)
    assert caught.value.diagnostics[0].values == {
        "row": 1201, "step_s": pytest.approx(0.002), "period_s": T,
    }  # fmt: skip


def test_times_that_drift_are_refused_where_they_are_half_a_period_off() -> None:
    """Steps of 1.005 ms are each near enough to 1 ms; row k is 0.005 k ms late, 0.5 for k = 100."""
    with pytest.raises(UsageError, match=r"row 10[12] "):
        list(timed(np.arange(300) * 1.005e-3, period_s=T).chunks)
    list(timed(np.arange(100) * 1.005e-3, period_s=T).chunks)
    # What rounding times to nanoseconds does is no drift of a fast loop either.
    list(timed(np.round(np.arange(3000) * 1e-7, 9), period_s=1e-7).chunks)


def test_a_hal_stream_of_several_blocks_has_one_time(tmp_path: Path) -> None:
    """More than a block of comments between two rows: the second block's time goes on where the first one's ended."""
    path = tmp_path / "a.hal"
    comments = (b"#" * 1000 + b"\n") * (2 * BLOCK_BYTES // 1000)
    path.write_bytes(b"# x_mm every 0.001 s\n" + b"1\n" * 1100 + comments + b"2\n" * 50)
    with open_setpoints(path) as source:
        chunks = list(source.chunks)
    assert [(chunk.first, len(chunk)) for chunk in chunks] == [(0, 1100), (1100, 50)]


@pytest.mark.parametrize("value", ["1e301", "-1e301", "1" + "0" * 400, "true", '"1"', "NaN"])
def test_json_lines_hold_numbers_of_a_machine(value: str, tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text('{"t_s": 0, "x_mm": 1}\n{"t_s": 0.001, "x_mm": ' + value + "}\n")
    with pytest.raises(UsageError, match="setpoints-number"), open_setpoints(path) as source:
        list(source.chunks)


@pytest.mark.parametrize("bad", [SHOWN_ROWS, SHOWN_ROWS + 1, SHOWN_ROWS + 5])
def test_faults_beyond_those_that_are_shown_are_counted(bad: int, tmp_path: Path) -> None:
    path = tmp_path / "a.hal"
    path.write_text("# x_mm every 0.001 s\n1\n" + "x\n" * bad + "2\n")
    with pytest.raises(UsageError) as caught, open_setpoints(path) as source:
        list(source.chunks)
    *shown, last = caught.value.diagnostics
    if bad == SHOWN_ROWS:
        assert len(shown) + 1 == SHOWN_ROWS
        return
    assert len(shown) == SHOWN_ROWS
    assert [fault.span.line for fault in shown if fault.span] == list(range(3, 3 + SHOWN_ROWS))
    assert f"{bad - SHOWN_ROWS} more rows like these, the last on line {2 + bad}" in last.message


def test_one_setpoint_out_of_the_world_is_named() -> None:
    rows = np.zeros((4, 2))
    rows[2, 1] = -1.01 * POSITION
    with pytest.raises(UsageError, match=r"setpoint 12 of axis Y is -1.01e\+08, beyond ±1e\+08"):
        check_range(Setpoints("XY", T, 10, rows))
    rows[2, 1] = -POSITION
    check_range(Setpoints("XY", T, 10, rows))


def test_events_are_lines_of_json_with_the_wait_of_a_dwell() -> None:
    sink = io.BytesIO()
    events = (
        (0.25, 3, Event("dwell", rest=True, dwell_s=0.5)),
        (1.0 / 3.0, 4, Event("spindle", values={"rpm": 300.0})),
        (0.5, 5, Event("dwell", rest=True)),
    )
    EventWriter(sink).write(Setpoints("X", T, 0, np.zeros((1, 1)), events=events))
    assert [json.loads(line) for line in sink.getvalue().splitlines()] == [
        {"t_s": 0.25, "line": 3, "event": "dwell", "dwell_s": 0.5, "end_t_s": 0.75},
        {"t_s": 0.333333333, "line": 4, "event": "spindle", "rpm": 300.0},
        {"t_s": 0.5, "line": 5, "event": "dwell", "dwell_s": 0.0},
    ]
