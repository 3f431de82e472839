"""Places on rows that are nearest to points of a plan."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.pipeline import read_text
from cncgen.planner.tube.programmed import Programmed


@pytest.mark.parametrize("seed", [0, 2, 3, 5, 9])
def test_the_nearest_place_on_a_curve_is_no_further_than_where_the_search_begins(seed: int) -> None:
    """Cubics with double points, where |C'| nearly vanishes, from places up to a hundredth of their length beside.

    Newton's steps, which nothing held, ended up to 3.8 mm away: at the end of the curve.
    """
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(size=(12, 2)), axis=0)
    for k in rng.choice(np.arange(1, 11), 3, replace=False):
        points[k] = points[k - 1]
    knots = np.concatenate([np.zeros(4), np.sort(rng.uniform(0.0, 1.0, 8)), np.ones(4)])
    rows = [f"K{knots[i]:.6f} X{x:.6f} Y{y:.6f} R1" for i, (x, y) in enumerate(points)]
    rows += [f"K{knot:.6f}" for knot in knots[12:]]
    start = f"(START, X{points[0, 0]:.6f} Y{points[0, 1]:.6f})"
    text = "\n".join([start, "G21 G17 G90 G94 G64 P0.2", f"G6.2 P4 {rows[0]} F6000", *rows[1:], "M2\n"])
    program = Programmed(0.001)
    (toolpath,) = program.over(read_text(text).chunks())
    program.draw()
    path, (row,) = toolpath.path, np.flatnonzero(toolpath.path.row_length > 0.0)
    begin, length = path.row_s[row], path.row_length[row]
    part = np.linspace(0.003, 0.997, 400)
    on = path.evaluate(begin + part * length, 1)
    across = np.stack([-on[1][:, 1], on[1][:, 0], np.zeros(len(part))], axis=1)
    for away in (0.0, 0.002, 0.05):
        for late in (0.0, 0.001, 0.01):
            sought, first = on[0] + away * across, np.clip(part + late, 0.0, 1.0)
            place, _ = program.nearest(sought, np.zeros(len(part), np.int64), first)
            before = np.linalg.norm(path.evaluate(begin + first * length)[0] - sought, axis=1)
            assert np.all(np.linalg.norm(place - sought, axis=1) <= before + 1e-7)


def test_rows_are_the_same_lines_however_they_are_asked_for() -> None:
    """Arcs and a spline, by windows that reach over each other, with the first rows forgotten, and all at once; on an arc of radius
    R, chords of the same length miss it by R (1 - cos of half their angle)."""
    arcs = [f"G{2 + k % 2} X{2 * k + 2} Y0 I1 J0" for k in range(9)]
    text = "\n".join(["G21 G17 G90 G94 G64 P0.1 F6000", *arcs, "G5 X20 Y3 I1 J1 P-1 Q-1", "M2\n"])

    def programmed() -> Programmed:
        program = Programmed(0.001)
        list(program.over(read_text(text).chunks()))
        program.draw()
        return program

    whole, parts = programmed().lines(0, 10), programmed()
    for first, stop in ((0, 3), (1, 2), (2, 7), (4, 10)):
        parts.forget(first - 1)
        some = parts.lines(first, stop)
        own = slice(*np.searchsorted(whole.key, [first, stop]).tolist())
        assert np.array_equal(some.points[:-1], whole.points[own])
        assert np.array_equal(some.key[:-1], whole.key[own])
        assert np.array_equal(some.tolerance, whole.tolerance[own])
    angle = np.pi / np.searchsorted(whole.key, 1.0)
    # A five-hundredth of the 0.994 of the tolerance that is planned with.
    assert 1.0 - np.cos(0.5 * angle) <= 0.002 * 0.994 * 0.1 <= 1.0 - np.cos(0.55 * angle)
