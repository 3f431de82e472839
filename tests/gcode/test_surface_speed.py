"""Constant surface speed: feeds per revolution of G96, from the closed forms of the spindle's speed.

At a radius r and a surface speed v the spindle makes v/(2π r) revolutions, D at most; a feed of f a revolution along X
therefore takes the time ∫ 2π r dr/(f v), and dr/(f D) below the radius v/(2π D).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cncgen
from cncgen.cli.app import run
from cncgen.gcode.sinks.surface_speed import parted
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

#: Surface speed, mm/s, and feed, mm a revolution, of the programs.
V, F = 200_000.0 / 60.0, 0.2
HEAD = "G21 G18 G90 G8 G95 F0.2\nM3\n"


def toolpath(text: str) -> Toolpath:
    program = cncgen.read_text(HEAD + text + "M2\n")
    (chunk,) = program.chunks()
    assert not program.diagnostics.has_errors, list(program.diagnostics)
    return chunk


def cuts(chunk: Toolpath) -> np.ndarray:
    """Return the rows that feed."""
    return np.flatnonzero((chunk.kind != Kind.EVENT) & (chunk.feed_mode == FeedMode.SPEED))


def seconds(chunk: Toolpath) -> float:
    """Return what the lines of a program take at their feeds."""
    rows = cuts(chunk)
    length = np.linalg.norm((chunk.end - chunk.starts)[rows], axis=1)
    return float((length / chunk.feed[rows]).sum())


@pytest.mark.parametrize(
    ("text", "radius"),
    [
        ("G96 S200\nG0 X20\nG1 Z-30\n", 20.0),
        ("G7\nG96 S200\nG0 X40\nG1 Z-30\n", 20.0),
        ("G96 S200\nG0 X-20\nG1 Z-30\n", 20.0),
        ("G10 L2 P1 X100\nG96 S200\nG0 X5\nG1 Z-30\n", 5.0),
        ("G0 X20\nG92 X7\nG96 S200\nG1 Z-30\n", 7.0),
    ],
)
def test_along_the_axis_the_speed_is_that_of_the_radius(text: str, radius: float) -> None:
    chunk = toolpath(text)
    (row,) = cuts(chunk)
    assert chunk.feed[row] == pytest.approx(F * V / (2.0 * math.pi * radius), rel=1e-12)


def test_in_inches_the_speed_is_in_feet_a_minute() -> None:
    """600 ft/min at a radius of 1 inch are 7200/(2π) revolutions a minute; 0.01 inch each."""
    chunk = toolpath("G20\nG96 S600\nF0.01\nG0 X1\nG1 Z-2\n")
    (row,) = cuts(chunk)
    assert chunk.feed[row] == pytest.approx(0.01 * 25.4 * 7200.0 / (2.0 * math.pi) / 60.0, rel=1e-12)


@pytest.mark.parametrize(("start", "end"), [(50.0, 10.0), (10.0, 50.0), (50.0, 49.0), (3.0, 0.5)])
def test_facing_takes_the_time_of_the_integral(start: float, end: float) -> None:
    chunk = toolpath(f"G96 S200\nG0 X{start}\nG1 X{end}\n")
    assert seconds(chunk) == pytest.approx(math.pi * abs(start**2 - end**2) / (F * V), rel=1e-12)
    feeds = chunk.feed[cuts(chunk)]
    assert np.all(np.maximum(feeds[1:], feeds[:-1]) <= 1.0501 * np.minimum(feeds[1:], feeds[:-1]))
    assert chunk.end[-1, 0] == end


def test_the_limit_holds_below_its_radius() -> None:
    """D2500: 200 m/min are reached down to r = 12.73 mm; from there to the centre and beyond the speed is D."""
    knee, most = V / (2.0 * math.pi * 2500.0 / 60.0), 2500.0 / 60.0
    outside = math.pi * (50.0**2 - knee**2) / (F * V)
    assert seconds(toolpath("G96 D2500 S200\nG0 X50\nG1 X0\n")) == pytest.approx(
        outside + knee / (F * most), rel=1e-12
    )
    through = toolpath("G96 D2500 S200\nG0 X50\nG1 X-50\n")
    assert seconds(through) == pytest.approx(2.0 * (outside + knee / (F * most)), rel=1e-12)
    assert through.feed[cuts(through)].max() == pytest.approx(F * most, rel=1e-12)


def test_other_modes_are_as_they_were() -> None:
    """G94 knows no revolutions, in G97 and after D0 S is their number."""
    for text, feed in (
        ("G96 S200\nG94 F120\nG0 X20\nG1 X10\n", 2.0),
        ("G96 S200\nG97 S300\nG0 X20\nG1 X10\n", F * 5.0),
        ("G96 D0 S300\nG0 X20\nG1 X10\n", F * 5.0),
    ):
        chunk = toolpath(text)
        (row,) = cuts(chunk)
        assert chunk.feed[row] == pytest.approx(feed, rel=1e-12)


def test_a_thread_is_cut_at_the_speed_of_its_radius() -> None:
    for mode in ("G95 F0.2", "G94 F100"):
        chunk = toolpath(f"{mode}\nG96 S200\nG0 X10\nG33 Z-20 K1.5\nG1 Z-25\n")
        thread, after = cuts(chunk)
        turns = V / (2.0 * math.pi * 10.0)
        assert chunk.feed[thread] == pytest.approx(1.5 * turns, rel=1e-12)
        assert chunk.feed[after] == pytest.approx(F * turns if "95" in mode else 100.0 / 60.0, rel=1e-12)


def test_an_arc_has_the_speed_of_its_mean_radius() -> None:
    chunk = toolpath("G96 S200\nG0 X10 Z0\nG2 X20 Z-10 I10 K0\n")
    (row,) = cuts(chunk)
    assert chunk.kind[row] == Kind.ARC
    assert chunk.feed[row] == pytest.approx(F * V / (2.0 * math.pi * 15.0), rel=1e-12)


def test_the_limit_of_fanuc_and_what_events_say() -> None:
    """G92 S bounds the speed, before G96 and in it: at r = 5 mm 200 m/min would be 6366 rev/min.

    Events tell the revolutions where the tool stands: at r = 40 mm 796 rev/min.
    """
    for text in ("G92 S1200\nG96 S200\n", "G96 S200\nG92 S1200\n"):
        program = cncgen.read_text(
            f"G21 G18 G90 G95 F0.2\nM3\nG0 X40\n{text}M4\nG0 X5\nG1 Z-10\nM30\n",
            options=cncgen.ReadOptions(dialect="fanuc"),
        )
        (chunk,) = program.chunks()
        (row,) = cuts(chunk)
        assert chunk.feed[row] == pytest.approx(F * 20.0, rel=1e-12)
        said = [event.values for event in chunk.events if event.values.get("direction") == -1]
        assert said[0]["surface_m_min"] == 200.0
        assert said[0]["speed_rpm"] == pytest.approx(60.0 * V / (2.0 * math.pi * 40.0), rel=1e-12)


def test_a_converted_program_feeds_as_the_one_it_comes_from(tmp_path: Path) -> None:
    text = HEAD + "G96 D2500 S200\nG0 X20\nG1 X2\nZ-30\nM2\n"
    (tmp_path / "a.ngc").write_text(text)
    assert (
        run(["convert", str(tmp_path / "a.ngc"), "--linearize", "0.01", "-o", str(tmp_path / "b.ngc")]) == 0
    )
    (chunk,) = cncgen.read(tmp_path / "b.ngc").chunks()
    assert seconds(chunk) == pytest.approx(seconds(toolpath(text[len(HEAD) : -3])), rel=1e-4)


@given(st.floats(-80, 80), st.floats(-80, 80), st.floats(0, 60))
def test_parts_follow_each_other(start: float, end: float, knee: float) -> None:
    """Each part lies below the knee, or changes the radius by a twentieth at most, and the last one ends the line."""
    owner, until = parted(np.array([start]), np.array([end]), knee)
    assert not owner.any()
    assert until[-1] == 1.0
    assert np.all(np.diff(until, prepend=0.0) > 0.0)
    radius = np.abs(start + (end - start) * np.concatenate([[0.0], until]))
    high, low = np.maximum(radius[1:], radius[:-1]), np.minimum(radius[1:], radius[:-1])
    assert np.all((high <= max(knee, 0.01) * (1 + 1e-9)) | (high <= 1.05 * low * (1 + 1e-9)))


@pytest.mark.parametrize(
    ("dialect", "head"),
    [("fanuc-lathe", "G21 G99\nG50 S3000\n"), ("sinumerik", "G71 G18 G90 DIAMON\nLIMS=3000\n")],
)
def test_g97_keeps_the_speed_and_g96_takes_the_surface_speed_up_again(dialect: str, head: str) -> None:
    """SINUMERIK: without a new S, "the last speed set with G96 is retained", and S of a further G96 "is optional"; so FANUC."""
    text = (
        "G96 S200 M3\nG0 X40. Z5.\nG97\nG1 X20. Z-30. F.2\nG97 S500\nG1 Z-40.\nG0 X40.\nG96\nG1 Z-50.\nM30\n"
    )
    (chunk,) = (program := cncgen.read_text(head + text, dialect=dialect)).chunks()
    assert not program.diagnostics.has_errors, list(program.diagnostics)
    turning = F * V / (2.0 * math.pi * 20.0)
    assert chunk.feed[cuts(chunk)] == pytest.approx([turning, F * 500.0 / 60.0, turning], rel=1e-12)


def test_linuxcnc_takes_the_number_of_s_on() -> None:
    """As its interpreter does: S is one number, in G97 the revolutions a minute."""
    chunk = toolpath("G96 S200\nG0 X20\nG97\nG1 Z-10\n")
    assert chunk.feed[cuts(chunk)] == pytest.approx([F * 200.0 / 60.0], rel=1e-12)
