"""Toolpaths of lines alone: as near as asked, with the ends, feeds and events of what they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cncgen
from cncgen.cli.app import run
from cncgen.toolpath.lines import lines_alone
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

HALF = "G21 G90 G93 G61\n(START, X0 Y0)\nM3 S100\nG1 X10 F60\nG4 P1\nG3 X-10 I-10 J0 F30\nM2\n"


def cut(text: str, tolerance: float) -> tuple[Toolpath, Toolpath]:
    (chunk,) = cncgen.read_text(text).chunks()
    (lines,) = lines_alone([chunk], tolerance)
    return chunk, lines


@pytest.mark.parametrize("tolerance", [1.0, 0.01, 1e-5])
def test_a_half_circle_in_lines(tolerance: float) -> None:
    """R = 10: every point is on the circle and every middle within the tolerance; F30 is 1/s over 2 s, as before."""
    chunk, lines = cut(HALF, tolerance)
    arc = lines.line == 6
    points = lines.end[arc, :2]
    assert np.hypot(*points.T) == pytest.approx(10.0, abs=1e-9)
    middles = 0.5 * (points + np.concatenate([[[10.0, 0.0]], points[:-1]]))
    assert 10.0 - np.hypot(*middles.T).min() <= tolerance
    # No more lines than four times what a circle takes: an angle of 2 acos(1 − tolerance/R) each.
    assert arc.sum() <= 4 * np.ceil(np.pi / (2 * np.arccos(1.0 - tolerance / 10.0)))
    assert (1.0 / lines.feed[arc]).sum() == pytest.approx(2.0, rel=1e-12)
    assert (lines.feed_mode[arc] == FeedMode.INVERSE_TIME).all()
    assert lines.end[-1].tolist() == chunk.end[-1].tolist()


def test_what_is_no_curve_stays_as_it_is() -> None:
    chunk, lines = cut(HALF, 0.1)
    for path in (chunk, lines):
        kept = path.kind == Kind.EVENT
        assert [path.events[k].name for k in path.curve[kept]] == ["spindle", "spindle", "dwell", "end"]
        assert path.line[kept].tolist() == [3, 3, 5, 7]
    assert (set(lines.kind.tolist()), len(lines.arcs), len(lines.nurbs)) == ({Kind.LINE, Kind.EVENT}, 0, 0)
    straight, same = cut("G1 X1 F1\nX1\nM2\n", 0.1)
    assert straight is same


def test_splines_between_lines_and_events_keep_their_ends(programs: Path) -> None:
    """NURBS beside lines and events; the ends of all motions are met."""
    chunk, lines = cut((programs / "butterfly.nc").read_text(), 0.01)
    assert len(chunk.nurbs)
    assert not len(lines.nurbs)
    last = np.flatnonzero(np.diff(lines.line, append=-1))
    assert lines.end[last].tolist() == chunk.end[np.flatnonzero(np.diff(chunk.line, append=-1))].tolist()


def test_convert_writes_lines_in_either_language(tmp_path: Path, programs: Path) -> None:
    source = str(programs / "butterfly.nc")
    for name in ("a.stp", "a.ngc"):
        target = tmp_path / name
        assert run(["convert", source, "--linearize", "0.01", "-o", str(target)]) == 0
        assert "B_SPLINE" not in target.read_text()
        assert "G6.2" not in target.read_text()
        (chunk,) = cncgen.read(target).chunks()
        assert len(chunk) > 300
        assert not len(chunk.nurbs)
