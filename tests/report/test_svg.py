"""Pictures as SVG: well formed, thinned without losing a peak."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import numpy as np

from cncgen.report.svg import SPEEDS, path_picture


def test_a_path_is_drawn_in_its_longest_plane() -> None:
    angle = np.linspace(0, 2 * np.pi, 3000)
    points = np.column_stack([0 * angle, 30 * np.cos(angle), 20 * np.sin(angle)])
    svg = path_picture(points, ["X", "Y", "Z"], 10 + 5 * np.sin(angle), points[:1])
    assert "across Y -30 to 30 mm, up Z -20 to 20 mm" in svg
    root = ET.fromstring(svg)
    _, _, width, height = map(float, (root.get("viewBox") or "").split())
    numbers = [
        float(n)
        for e in root.iter()
        if e.get("class") == "path"
        for n in re.findall(r"[\d.]+", e.get("d") or "")
    ]
    assert min(numbers) >= 39.9
    assert max(numbers) <= width - 39.9
    assert abs(height - (90 + 820 * 40 / 60)) <= 1.0


def test_linear_axes_are_drawn_before_rotary_ones() -> None:
    """An axis that turns ten times round has the longest extent in degrees; where one axis alone is linear it is up."""
    t = np.linspace(0, 1, 100)
    points = np.column_stack([75 * t, 0 * t, np.sin(t), 3600 * t])
    assert "across X 0 to 75 mm, up Z 0 to 0.841 mm" in path_picture(points, "XYZA", 1 + t, points[:0])
    svg = path_picture(points[:, [0, 3]], "XA", t, points[:0, :2])
    assert "across X 0 to 75 mm, up A 0 to 3600 deg" in svg
    (d,) = {e.get("d") or "" for e in ET.fromstring(svg).iter() if e.get("stroke") == SPEEDS[0]}
    assert d.startswith("M40.0 450.0L")
    ends = [e.get("d") or "" for e in ET.fromstring(svg).iter() if e.get("class") == "path"]
    assert ends[-1].endswith("L860.0 40.0")
    alone = path_picture(points[:, :1], "X", t, points[:0, :1])
    assert "across X 0 to 75 mm, up X 0 to 75 mm" in alone


def test_a_rapid_does_not_hide_differences_of_speed() -> None:
    """Cutting at 10 and 20 mm/s with 2 % of rapids at 500: the colours run to 20."""
    t = np.arange(1000.0)
    speed = np.where(t < 20, 500.0, np.where(t < 500, 10.0, 20.0))
    svg = path_picture(np.column_stack([t, t]), "XY", speed, np.zeros((0, 2)))
    assert ">20 mm/s (up to 500)<" in svg
    colours = {e.get("stroke") for e in ET.fromstring(svg).iter() if e.get("class") == "path"}
    assert len(colours) == 2
    still = path_picture(np.column_stack([t, t]), "XY", 0.0 * t, np.zeros((0, 2)))
    assert ">0 mm/s<" in still


def test_a_single_point() -> None:
    svg = path_picture(np.zeros((1, 3)), ["X", "Y", "Z"], np.zeros(1), np.zeros((0, 3)))
    paths = [e.get("d") for e in ET.fromstring(svg).iter() if e.get("class") == "path"]
    assert paths == ["M40.0 40.0"]
    assert "across X 0 to 0 mm" in svg


def test_the_picture_of_a_long_path_is_bounded() -> None:
    """A million points that fill the page: under a megabyte, and still XML."""
    t = np.arange(1_000_000.0)
    points = np.column_stack([t % 1000, t // 1000])
    svg = path_picture(points, ["X", "Y"], 1 + np.sin(t / 50), points[:0])
    assert len(svg) < 1_000_000
    ET.fromstring(svg)
