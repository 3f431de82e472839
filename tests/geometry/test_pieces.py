"""Cubic pieces of arcs and NURBS rows: how far they miss the curve, their bound of curvature, and the cells that they are cut at."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.geometry import nurbs
from cncgen.geometry.path import ARC, NURBS, Path
from cncgen.geometry.pieces import ARC_SHARE, NURBS_SHARE, pieces_of
from cncgen.geometry.tables import ArcTable, empty_arcs, empty_nurbs


def curve_path() -> Path:
    """A line, a cubic of three spans with weights, and a line."""
    points = np.array([[0, 0, 0], [3, 4, 0], [6, -2, 1], [9, 5, 0], [12, 1, 2], [15, 0, 0]], float)
    table = nurbs.single(3, [0, 0, 0, 0, 1, 2, 3, 3, 3, 3], points, [1, 1, 2, 0.5, 1, 1])
    end = [[0, 0, 0], [15, 0, 0], [20, 0, 0]]
    return Path("XYZ", [-5.0, 0, 0], [0, NURBS, 0], end, [-1, 0, -1], empty_arcs(), table)


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_pieces_miss_a_curve_by_their_share_of_the_tolerance(tolerance: float) -> None:
    path = curve_path()
    pieces = pieces_of(path, np.full(3, tolerance), np.ones(3)).joined()
    h = np.diff(pieces.t)
    assert np.all(h > 0)
    np.testing.assert_allclose(pieces.row_t, path.row_s, atol=1e-9)
    for part in (0.0, 0.3, 0.5, 0.8, 1.0):
        u = (part * h)[:, None]
        y = pieces.y
        at = y[:, 0] + u * (y[:, 1] + u * (y[:, 2] + u * y[:, 3]))
        x = path.evaluate(pieces.t[:-1] + part * h)[0]
        assert np.linalg.norm(at - x, axis=1).max() <= 2.0 * NURBS_SHARE * tolerance
        second = np.linalg.norm(2.0 * y[:, 2] + 6.0 * u * y[:, 3], axis=1)
        assert np.all(second <= pieces.bend * (1 + 1e-9))


@pytest.mark.parametrize("rise", [0.0, 0.3, 8.0, 600.0])
@pytest.mark.parametrize("tolerance", [0.1, 0.001])
def test_pieces_miss_a_helix_by_their_share_of_the_tolerance(rise: float, tolerance: float) -> None:
    """One that rises steeply bends little and turns as often: pieces whose length came of its curvature missed it by its radius."""
    arc = ArcTable(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([4.0 * np.pi]))
    path = Path("XYZ", [2.0, 0, 0], [ARC], [[2.0, 0, rise]], [0], arc, empty_nurbs(3))
    pieces = pieces_of(path, np.full(1, tolerance), np.ones(3)).joined()
    h = np.diff(pieces.t)
    for part in (0.1, 0.5, 0.7):
        u = (part * h)[:, None]
        y = pieces.y
        at = y[:, 0] + u * (y[:, 1] + u * (y[:, 2] + u * y[:, 3]))
        turn = 4.0 * np.pi * (pieces.t[:-1] + part * h) / pieces.t[-1]
        x = np.column_stack([2.0 * np.cos(turn), 2.0 * np.sin(turn), rise * turn / (4.0 * np.pi)])
        assert np.linalg.norm(at - x, axis=1).max() <= ARC_SHARE * tolerance


def test_cells_cover_a_curve_from_end_to_end() -> None:
    path = curve_path()
    of, begin, width = path.panels(np.array([1]))
    assert set(of.tolist()) == {0}
    assert begin[0] == 0.0
    np.testing.assert_allclose(begin[1:], (begin + width)[:-1], atol=1e-12)
    assert begin[-1] + width[-1] == pytest.approx(path.row_length[1], rel=1e-12)


@pytest.mark.parametrize("unit", [1.0, 25.4])
def test_pieces_of_straight_spans_are_lines(unit: float) -> None:
    """A polyline written as a curve of degree 1: rounding bent its pieces in some units, and they were sampled as curves are."""
    x = np.array(
        [0.0026, 0.0020937338349376706, 0.0050843566691213295, 0.005801748202490801, 0.004144729792416178]
    )
    points = unit * np.outer(x, [1.0, 0.3, -0.7])
    table = nurbs.single(1, [0, 0, 0.0048801, 0.1915253, 0.5012891, 1, 1], points)
    path = Path("XYZ", points[0], [NURBS], points[-1:], [0], empty_arcs(), table)
    pieces = pieces_of(path, np.full(1, 0.001 * unit), np.ones(3)).joined()
    assert len(pieces.bend) == 4
    assert not pieces.bend.any()
    assert not pieces.y[:, 2:].any()
    h = np.diff(pieces.t)[:, None]
    np.testing.assert_allclose(pieces.y[:, 0] + h * pieces.y[:, 1], points[1:], rtol=1e-14)
