"""Tables and summaries as text, and the command that prints them."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.cli.app import run as command
from cncgen.planner.record import Limit, Profile
from cncgen.report.slow_places import _valley_cuts
from cncgen.report.summary import _top_speeds, as_text
from cncgen.report.tables import counted, duration, number, text_table
from cncgen.setpoints.differences import DifferencePeaks

Run = Callable[..., "subprocess.CompletedProcess[bytes]"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0.0000 s"),
        (59.9999, "59.9999 s"),
        (59.99996, "1:00.000 min"),
        (62.3454, "1:02.345 min"),
        (119.9999, "2:00.000 min"),
        (3599.9996, "1:00:00.000 h"),
        (90_061.5, "25:01:01.500 h"),
    ],
)
def test_times_carry_into_minutes_and_hours(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_one_thing_has_no_plural() -> None:
    assert [counted(n, "motion") for n in (0, 1, 2)] == ["0 motions", "1 motion", "2 motions"]


def test_columns_stand_in_line() -> None:
    text = text_table(("name", "value"), [("a", "1"), ("longer", "12345")])
    assert text == (
        "| name   | value |\n"
        "| ------ | ----: |\n"
        "| a      |     1 |\n"
        "| longer | 12345 |\n"
    )  # fmt: skip


def test_numbers() -> None:
    assert [number(None), number(0.0123456, 1000), number(2.0)] == ["-", "12.35", "2"]


@given(st.integers(1, 40), st.lists(st.integers(1, 40), max_size=5), st.integers(0, 1000))
def test_differences_do_not_depend_on_chunks(rows: int, cuts: list[int], seed: int) -> None:
    position = np.random.default_rng(seed).uniform(-1, 1, (rows, 2))
    padded = np.concatenate([np.repeat(position[:1], 3, 0), position, np.repeat(position[-1:], 3, 0)])
    peaks = DifferencePeaks(2, 0.01)
    for part in np.split(position, sorted({min(cut, rows) for cut in cuts})):
        peaks.add(part)
    peaks.finish()
    assert peaks.samples == rows
    for order in (1, 2, 3):
        expected = np.abs(np.diff(padded, order, axis=0)).max(axis=0) / 0.01**order
        np.testing.assert_allclose(peaks.peak[order - 1], expected, rtol=1e-12)


def test_an_axis_that_stands_has_peaks_of_zero_and_not_of_minus_zero() -> None:
    peaks = DifferencePeaks(1, 0.001)
    peaks.add(np.full((5, 1), 2.0))
    peaks.finish()
    assert not np.signbit(peaks.peak).any()
    assert not peaks.peak.any()


def test_largest_speed_lies_within_a_piece() -> None:
    """v = 1 + 4 t − t² peaks at t = 2 with 5."""
    one = np.ones(1)
    profile = Profile(
        np.array([0.0, 3.0]), np.zeros(2), one, 4 * one, -2 * one, 0 * one, np.zeros(1, np.int8)
    )
    assert _top_speeds(profile) == pytest.approx([5.0])


def test_valleys_are_cut_at_their_maxima_and_ripple_is_not() -> None:
    speed = np.array([0.0, 5, 10, 10, 5, 1, 1.02, 0.99, 5, 9, 8.9, 9.05, 2, 8, 8, 8])
    assert _valley_cuts(speed) == [4, 12]


def test_text_of_a_summary() -> None:
    values = {
        "program": "a.nc", "machine": "m", "cycle_time_s": 76.0, "cycle_time_split_s": {"cutting": 70.0, "rapid": 5.5, "tool": 0.0, "spindle": 0.0, "dwell": 0.5, "other": 0.0, "stops": 0.0}, "motion_time_s": 75.5, "dwell_time_s": 0.5, "path_length_mm": 10.0,
        "motions": 1, "samples": 2, "feed_mm_s": {"mean": 1.0, "max": 2.0}, "sharp_corner_count": 0,
        "peak": {"x": {"unit": "mm", "velocity": 1.0, "velocity_of_limit": 0.5, "acceleration": 2.0,
                       "acceleration_of_limit": None, "jerk": 3.0, "jerk_of_limit": 0.1}},
        "feed_over_time_mm_s": [0.0, 1.0, 2.0],
        "slowest": [
            {"lost_s": 0.25, "line": 7, "source": "a.nc", "position": {"x_mm": 1.5, "a_deg": -90.0}, "t_s": 3.25, "limit": Limit.CONTOUR_ERROR.name.lower(), "axis": ""},
            {"lost_s": 0.125, "line": 2, "source": "sub.nc", "position": {"x_mm": 0.0}, "t_s": 1.0, "limit": "jerk", "axis": "X"},
        ],
    }  # fmt: skip
    text = as_text(values)
    assert (
        "a.nc on m: 1:16.000 min (1:10.000 min cutting, 5.5000 s rapid, 0.5000 s dwell), 10.0000 mm, 1 motion, 2 setpoints"
        in text
    )
    assert "X: velocity 1 mm/s (50.00 %), acceleration 2 mm/s², jerk 3 mm/s³ (10.00 %)" in text
    assert "\n  ▁▅█\n" in text
    assert "250 ms lost at line 7, X1.500 A-90.000, 3.250 s: contour error" in text
    assert "125 ms lost at line 2 of sub.nc, X0.000, 1.000 s: X jerk" in text


def test_compare_prints_both_tables(cncgen: Run, programs: Path) -> None:
    run = cncgen("compare", programs / "square_r5.nc", "-m", "xy-table", "--feedrates", "constant,ild")
    assert run.returncode == 0, run.stderr.decode()
    text = run.stdout.decode()
    assert [line.split("|")[1].strip() for line in text.splitlines() if line.startswith("| ")] == [
        "feedrate", "--------", "constant", "ild", "interpolator", "------------", "arclength", "taylor1", "taylor2",
    ]  # fmt: skip


def test_compare_takes_the_interpolators_that_are_named(tmp_path: Path) -> None:
    """In their order; on a line, where parameter and length are proportional, none of them fluctuates."""
    (tmp_path / "line.nc").write_text("G21 G90 G61\nG1 X10 F3000\nM2\n")
    line = f"compare {tmp_path}/line.nc --feedrates ild --interpolators uniform,taylor1"
    assert command([*line.split(), "-o", f"{tmp_path}/out.txt", "--summary", f"{tmp_path}/s.json"]) == 0
    found = json.loads((tmp_path / "s.json").read_text())["interpolators"]
    assert [each["interpolator"] for each in found] == ["uniform", "taylor1"]
    assert all(abs(each["max_part"]) < 1e-9 for each in found)


def test_compare_controllers(cncgen: Run, programs: Path) -> None:
    run = cncgen(
        "compare", programs / "circle.nc", "-m", "dyna-1007", "--feedrate", "ild", "--controllers", "p,ccc"
    )
    assert run.returncode == 0, run.stderr.decode()
    rows = [line.split("|") for line in run.stdout.decode().splitlines()]
    assert [row[1].strip() for row in rows[2:]] == ["p", "ccc"]
    # Cross coupling is there to cut the contour error.
    assert float(rows[3][2]) < 0.5 * float(rows[2][2])
    wrong = cncgen("compare", programs / "circle.nc", "-m", "dyna-1007", "--controllers", "pid2")
    assert wrong.returncode == 2
    assert b"pid2" in wrong.stderr
