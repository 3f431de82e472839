"""A summary counts every corner, though a plan hands on a bounded number of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cncgen
from cncgen import pipeline
from cncgen.planner.least_time import timeline


def summary_of(text: str) -> dict:
    stream, summary = pipeline.plan_with_summary(pipeline.read_text(text), "generic-mill")
    stream.collect()
    return summary.as_json()


def test_corners_beyond_the_most_that_are_handed_on_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    teeth = "".join(f"G1 X{5 * (k + 1)} Y{8 * ((k + 1) % 2)}\n" for k in range(9))
    text = f"(START, X0 Y0)\nG21 G90 G61 F3000\n{teeth}M2\n"
    whole = summary_of(text)
    assert whole["sharp_corner_count"] == len(whole["sharp_corners"]) == 8
    monkeypatch.setattr(timeline, "MAX_CORNERS", 3)
    some = summary_of(text)
    assert some["sharp_corner_count"] == 8
    assert some["sharp_corners"] == whole["sharp_corners"][:3]


def test_a_joint_is_one_corner_and_a_change_of_feed_is_none() -> None:
    """Beside a joint of line and arc, at 10 mm/s, the speed is lowest 11 µm on; beside F60 it is once below 1 mm/s for 5 µm."""
    joints = summary_of("G21 G61 F6000\nG1 X100\nG2 X102 Y-2 R2\nG1 Y-100\nM2\n")["sharp_corners"]
    assert [(corner["line"], corner["limit"]) for corner in joints] == [(3, "corner"), (4, "corner")]
    assert summary_of("G21 G61 F6000\nG1 X50\nF60\nG1 X60\nF6000\nG1 X100\nM2\n")["sharp_corners"] == []


def test_the_feed_of_a_corner_is_that_of_the_setpoints() -> None:
    """The speed at its time, by central differences, which are off by no more than A T: 2500 mm/s² in 0.25 ms."""
    machine = replace(cncgen.load_machine("xy-table"), period_s=2.5e-4)
    teeth = "".join(f"G1 X{2 * (k + 1)} Y{1.5 * ((k + 1) % 2)}\n" for k in range(8))
    text = f"(START, X0 Y0)\nG21 G90 G64 P0.01 F6000\n{teeth}M2\n"
    stream, summary = pipeline.plan_with_summary(pipeline.read_text(text), machine)
    rows = stream.collect()
    speed = np.hypot(*np.gradient(rows.position, rows.time_s, axis=0).T)
    corners = summary.as_json()["sharp_corners"]
    assert len(corners) == 7
    for corner in corners:
        assert corner["feed_mm_s"] == pytest.approx(np.interp(corner["t_s"], rows.time_s, speed), abs=0.7)
