"""Lines for curves, and cubic curves for lines: within the tolerance, and not many more than needed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.geometry.fitting import fit_run
from cncgen.geometry.linearize import linearize
from cncgen.geometry.path import ARC, LINE, Path
from cncgen.geometry.tables import ArcTable, NurbsTable, empty_arcs, empty_nurbs
from tests.geometry.curves import curves, path_of_curve, program_curve
from tests.geometry.nearest import distances, samples


def polyline(points: np.ndarray) -> Path:
    n = len(points) - 1
    return Path("XYZ", points[0], [LINE] * n, points[1:], [-1] * n, empty_arcs(), empty_nurbs(3))


def test_circle_by_chords() -> None:
    """A sagitta of 0.01 mm on R10: chords of 2 acos(1 − 0.001), 71 of them to the turn; ours hold it with few more."""
    arc = ArcTable(np.zeros((1, 3)), np.array([[0.0, 0, 1]]), np.array([2 * np.pi]))
    path = Path("XYZ", [10, 0, 0], [ARC], [[10, 0, 0]], [0], arc, empty_nurbs(3))
    points, rows = linearize(path, 0.01)
    least = np.ceil(np.pi / np.arccos(1 - 0.001))
    assert least <= len(points) <= least * 1.06
    assert set(rows) == {0}
    np.testing.assert_array_equal(points[-1], [10, 0, 0])
    middle = 0.5 * (points[1:] + points[:-1])
    assert (10 - np.linalg.norm(middle, axis=1)).max() <= 0.01


@given(curves(max_degree=4), st.sampled_from([0.1, 0.001]))
@settings(max_examples=15)
def test_any_curve_by_chords(table: NurbsTable, tolerance: float) -> None:
    path = path_of_curve(table)
    points, _ = linearize(path, tolerance)
    lines = polyline(np.vstack([path.start, points]))
    s = samples(path)
    s = np.random.default_rng(0).choice(s, min(len(s), 800), replace=False)
    assert distances(path.evaluate(s)[0], lines, lines.row_s).max() <= tolerance * 1.05
    np.testing.assert_array_equal(points[-1], path.end[-1])


def test_lines_stay_lines() -> None:
    path = polyline(np.array([[0, 0, 0], [10, 0, 0], [10, 5, 0], [10.0, 5, 7]]))
    points, rows = linearize(path, 0.01)
    np.testing.assert_array_equal(points, path.end)
    np.testing.assert_array_equal(rows, [0, 1, 2])


@pytest.mark.parametrize("name", ["butterfly", "star"])
def test_there_and_back(name: str) -> None:
    """Curve to lines within 1 µm, lines to a cubic within 10 µm: both ways within the sum."""
    path = path_of_curve(program_curve(name))
    points, _ = linearize(path, 0.001)
    run = polyline(np.vstack([path.start, points]))
    table = fit_run(run, 0.01)
    assert (table.degree[0], np.ptp(table.weights)) == (3, 0.0)
    assert len(table.weights) < 0.6 * len(points)
    fitted = path_of_curve(table)
    pick = np.random.default_rng(1)
    for one, other in ((path, fitted), (fitted, path)):
        s = samples(one)
        some = one.evaluate(pick.choice(s, min(len(s), 3000), replace=False))[0]
        assert distances(some, other).max() <= 0.011


def test_tolerances_must_be_positive() -> None:
    path = polyline(np.array([[0, 0, 0], [1.0, 0, 0]]))
    for function in (linearize, fit_run):
        with pytest.raises(ValueError, match="positive"):
            function(path, 0.0)
