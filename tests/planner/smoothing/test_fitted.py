"""Runs of lines as one cubic curve each: within the tolerance, corners and feeds kept."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from cncgen import pipeline
from cncgen.geometry import nurbs
from cncgen.planner.smoothing.fitted import fit_runs
from cncgen.toolpath.record import FeedMode, Kind
from cncgen.toolpath.slicing import join
from tests.geometry.nearest import distances, samples
from tests.planner.smoothing.programs import chunked, facets, path_of, toolpath


def test_a_run_becomes_one_clamped_cubic_within_the_tolerance() -> None:
    rows = facets(400)
    result = join(list(fit_runs([rows], 0.02)))
    assert list(result.kind) == [Kind.NURBS]
    table = result.nurbs
    nurbs.check(table)
    assert table.degree[0] == 3
    assert np.all(table.knots[:4] == table.knots[0])
    np.testing.assert_allclose(table.control_points[[0, -1]], [rows.start, rows.end[-1]], atol=1e-12)
    one, two = path_of(rows), path_of(result)
    assert distances(one.evaluate(one.row_s)[0], two).max() <= 0.02
    assert distances(two.evaluate(samples(two)[::5])[0], one).max() <= 0.02


def test_corners_feeds_and_few_lines_stay() -> None:
    """A square of lines of 1 mm: four curves that meet in the corners; two lines are too few."""
    side = [[k, 0, 0] for k in range(1, 11)] + [[10, k, 0] for k in range(1, 11)]
    rows = toolpath([0, 0, 0], [*side, [9, 10, 0], [8, 10, 0]])
    result = join(list(fit_runs([rows], 0.01)))
    assert list(result.kind) == [Kind.NURBS, Kind.NURBS, Kind.LINE, Kind.LINE]
    np.testing.assert_allclose(result.end[:2], [[10, 0, 0], [10, 10, 0]], atol=1e-12)
    feeds = np.repeat([50.0, 60.0], [10, 12])
    changed = join(list(fit_runs([toolpath([0, 0, 0], [*side, [9, 10, 0], [8, 10, 0]], feed=feeds)], 0.01)))
    np.testing.assert_array_equal(changed.feed[:2], [50, 60])


def test_lines_of_inverse_time_stay() -> None:
    """Each line of G93 F60 takes a second, so ten of them take ten; one curve of F60 took one."""
    rows = toolpath([0, 0, 0], [[k, 0.001 * k * k, 0] for k in range(1, 11)], feed=np.ones(10))
    timed = replace(rows, feed_mode=np.full(10, FeedMode.INVERSE_TIME, np.int8))
    result = join(list(fit_runs([timed], 0.01)))
    assert list(result.kind) == [Kind.LINE] * 10
    assert 1.0 / result.feed @ np.ones(10) == 10.0


def test_chunks_do_not_matter() -> None:
    rows = facets(300, feed=np.repeat([50.0, 60.0, 50.0], 100))
    one = join(list(fit_runs([rows], 0.01)))
    other = join(list(fit_runs(chunked(rows, 13), 0.01)))
    np.testing.assert_array_equal(one.nurbs.control_points, other.nurbs.control_points)
    np.testing.assert_array_equal(one.line, [1, 101, 201])


def test_convert_writes_what_reads_back_within_the_tolerance(
    cncgen: Callable[..., subprocess.CompletedProcess[bytes]], programs: Path, tmp_path: Path
) -> None:
    """2000 short lines to G6.2 and back: fewer words, 10 µm at most between the two paths."""
    before = programs / "butterfly_g1.nc"
    run = cncgen("convert", before, "--fit", "0.01", "-o", tmp_path / "curves.nc")
    assert run.returncode == 0, run.stderr
    one, two = (
        path_of(join(list(pipeline.read(name).chunks()))) for name in (before, tmp_path / "curves.nc")
    )
    pick = np.random.default_rng(0)
    s, r = (pick.choice(samples(path), 1500) for path in (one, two))
    # Nine decimals in the file, nothing to speak of.
    assert distances(one.evaluate(s)[0], two).max() <= 0.01 + 1e-7
    assert distances(two.evaluate(r)[0], one).max() <= 0.01 + 1e-7
