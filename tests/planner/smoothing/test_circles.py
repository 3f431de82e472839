"""Arcs that go on count as one: cutting an arc, a circle or a helix changes neither the smoothed curve nor its time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from cncgen.geometry.tables import ArcTable
from cncgen.machine import load
from cncgen.pipeline import read_text, sound
from cncgen.planner import PlanOptions, plan
from cncgen.planner.smoothing import smooth
from cncgen.planner.smoothing.stretches import Stretches
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import join
from tests.planner.smoothing.programs import chunked, path_of, toolpath

#: Letters of the plane's axes, of its normal, and of the centre.
PLANES = {"G17": ("XY", "Z", "IJ"), "G18": ("ZX", "Y", "KI"), "G19": ("YZ", "X", "JK")}


def arcs(sweep: list[float], shares: list[float], radius: float = 5.0, rise: float = 0.0) -> Toolpath:
    """Arcs in X Y, bent to and fro, tangential, each cut at `shares`; the parts keep the line number."""
    at, heading, height = np.zeros(2), 0.0, 0.0
    rows = []
    for line, turn in enumerate(sweep):
        sense = 1.0 if line % 2 == 0 else -1.0
        centre = at + sense * radius * np.array([-np.sin(heading), np.cos(heading)])
        for a, b in zip([0.0, *shares], [*shares, 1.0], strict=True):
            angle = heading + sense * b * turn
            end = centre - sense * radius * np.array([-np.sin(angle), np.cos(angle)])
            rows.append(
                (
                    [*end, height + b * rise],
                    [*centre, height + a * rise],
                    [0, 0, sense],
                    (b - a) * turn,
                    line + 1,
                )
            )
        at, heading, height = end, angle, height + rise
    ends, centres, normals, sweeps, lines = (np.array(column, float) for column in zip(*rows, strict=True))
    n = len(rows)
    table = ArcTable(centres, normals, sweeps)
    made = toolpath([0, 0, 0], ends.tolist(), [Kind.ARC] * n, list(range(n)), table)
    return replace(made, line=lines.astype(np.int64))


def program(plane: str, parts: int, decimals: int, rise: float = 0.0, circle: bool = False) -> str:
    """A line, an arc of R4 on tangentially, two back in corners, a line; each arc cut in `parts`."""
    (one, two), normal, centre = PLANES[plane]
    at, height = np.array([12.0, 0.0]), 0.0
    lines = [f"{plane} G21 G90 G64 P0.03", f"G1 {one}12 {two}0 F6000"]
    for radius, heading, turn in (
        (4.0, 0.0, 2.0),
        (7.0, 3.4, -1.3),
        (1.5, 0.7, 2.0 * np.pi if circle else 4.0),
    ):
        sense = np.sign(turn)
        middle = at + sense * radius * np.array([-np.sin(heading), np.cos(heading)])
        for k in range(parts):
            angle = heading + turn * (k + 1) ** 1.3 / parts**1.3
            end = middle - sense * radius * np.array([-np.sin(angle), np.cos(angle)])
            away = middle - at.round(decimals)
            height += rise * ((k + 1) ** 1.3 - k**1.3) / parts**1.3
            lines.append(
                f"{'G3' if turn > 0 else 'G2'} {one}{end[0]:.{decimals}f} {two}{end[1]:.{decimals}f} "
                f"{normal}{height:.{decimals}f} {centre[0]}{away[0]:.{decimals}f} {centre[1]}{away[1]:.{decimals}f}"
            )
            at = end
    return "\n".join([*lines, f"G1 {one}{at[0] + 9:.3f} {two}{at[1]:.3f}", "M2", ""])


def seconds(text: str) -> float:
    chunks = sound(read_text(text, "a.nc"))
    # The circles that smoothing finds are exact; path and speed together are a local optimum near them.
    done = plan(chunks, load("generic-mill"), PlanOptions(feedrate="optimal", effort="fast"))
    return max(float(each.profile.t[-1]) for each in done)


@pytest.mark.parametrize("plane", list(PLANES))
@pytest.mark.parametrize("rise", [0.0, 0.8])
@pytest.mark.parametrize("circle", [False, True])
def test_cut_arcs_take_as_long(plane: str, rise: float, circle: bool) -> None:
    """Three parts once took up to 2.8 % more or less; the programs differ in the last digits of coordinates alone."""
    whole, parted = (seconds(program(plane, parts, 12, rise, circle)) for parts in (1, 3))
    assert parted == pytest.approx(whole, rel=1e-8)


@pytest.mark.parametrize(("decimals", "allowed"), [(6, 2e-4), (5, 1e-3)])
def test_centres_may_be_rounded(decimals: int, allowed: float) -> None:
    whole, parted = (seconds(program("G17", parts, decimals, 0.5)) for parts in (1, 4))
    assert parted == pytest.approx(whole, rel=allowed)


def test_cut_arcs_make_the_same_curve() -> None:
    """Over three windows of 2048 rows, and more than 16 384 parts."""
    sweep = np.random.default_rng(4).uniform(0.05, 0.6, 5000).tolist()
    shapes = []
    for rows in (arcs(sweep, []), arcs(sweep, [0.2, 0.55, 0.7])):
        path = path_of(join(list(smooth([rows]))))
        shapes.append(path.evaluate(np.linspace(0.0, path.length, 9000), 0)[0])
    np.testing.assert_allclose(shapes[1], shapes[0], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("size", [3, 5000])
def test_chunks_do_not_matter(size: int) -> None:
    """Of 40 arcs in 20 parts, and of one helix in 1500."""
    many = arcs(np.linspace(0.5, 2.0, 40).tolist(), np.linspace(0.05, 0.95, 19).tolist(), rise=0.3)
    helix = arcs([900.0], np.linspace(0.0, 1.0, 1501)[1:-1].tolist(), rise=60.0)
    moved = many.end[-1]
    helix = replace(
        helix,
        start=moved,
        end=helix.end + moved,
        arcs=replace(helix.arcs, centre=helix.arcs.centre + moved),
    )
    rows = join([many, helix])
    rows = replace(rows, line=np.arange(len(rows)))
    whole, parted = (join(list(smooth(each))) for each in ([rows], chunked(rows, size)))
    np.testing.assert_array_equal(parted.line, whole.line)
    np.testing.assert_array_equal(parted.end, whole.end)


def test_what_waits_is_bounded() -> None:
    """A circle gone round in 80 000 parts, of which 65 536 and some chunks wait at most."""
    rows = arcs([3000.0], np.linspace(0.0, 1.0, 80_001)[1:-1].tolist(), radius=0.05)
    taken = 0

    def parts() -> Iterator[Toolpath]:
        nonlocal taken
        for chunk in chunked(rows, 2048):
            taken += len(chunk)
            yield chunk

    assert len(next(iter(smooth(parts())))) > 0
    assert taken <= 65_536 + 3 * 2048


def test_lines_stay_known() -> None:
    """An arc in four parts: so do they come out, on the curve and where it is met exactly, on one circle."""
    both = arcs([1.5, 1.0], [0.2, 0.5, 0.6], rise=0.4)
    both = replace(both, line=np.arange(1, 9))
    (made,) = smooth([both])
    np.testing.assert_array_equal(np.unique(made.line), np.arange(1, 9))
    assert set(made.kind.tolist()) == {Kind.NURBS}
    one = arcs([1.5], [0.2, 0.5, 0.6], rise=0.4)
    one = replace(one, line=np.arange(1, 5))
    (exact,) = smooth([one])
    np.testing.assert_array_equal(exact.line, [1, 2, 3, 4])
    np.testing.assert_allclose(exact.end, one.end, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(path_of(exact).row_length, path_of(one).row_length, rtol=1e-12)


def test_parts_are_off_by_what_is_said() -> None:
    """Centres and ends off by up to 0.02 µm: the distance of points of the parts from the helix, at the same shares."""
    rng, shares = np.random.default_rng(5), [0.1, 0.35, 0.4, 0.8]
    rows = arcs([5.0], shares, rise=2.0)
    noise = 2e-5 * rng.uniform(-1.0, 1.0, rows.end.shape)
    noise[-1] = 0.0
    table = replace(rows.arcs, centre=rows.arcs.centre + 2e-5 * rng.uniform(-1.0, 1.0, (5, 3)) * [1, 1, 0])
    rows = replace(rows, end=rows.end + noise, arcs=table)
    joined = Stretches.of(rows)
    assert len(joined.rows) == 1
    whole, parts = path_of(joined.rows), path_of(rows)
    near, points = (each.evaluate(np.linspace(0.0, each.length, 20_001), 0)[0] for each in (whole, parts))
    far = np.linalg.norm(near - points, axis=1).max()
    assert 1e-5 < far < joined.off[0] < 0.02 * 0.01


def test_rounded_parts_met_exactly_leave_chords_less() -> None:
    """A circle in four whose centres are 0.03 µm apart, alone: no corners, and chords have what that leaves of P = 10 µm."""
    rows = arcs([2.0 * np.pi], [0.25, 0.5, 0.75])
    centre = rows.arcs.centre + 3e-5 * np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]])
    (made,) = smooth([replace(rows, arcs=replace(rows.arcs, centre=centre))])
    off = Stretches.of(replace(rows, arcs=replace(rows.arcs, centre=centre))).off[0]
    assert off > 3e-5
    np.testing.assert_allclose(made.chord_room, 0.01 - off)
    path = path_of(made)
    assert np.abs(path.jumps().tangent).max() < 1e-9


WAYS = {
    "feed": {"feed": np.array([100.0, 100.0, 90.0])},
    "tolerance": {"tolerance": np.array([0.01, 0.01, 0.02])},
    "mode": {"path_mode": np.array([PathMode.CONTINUOUS] * 2 + [PathMode.EXACT_PATH], np.int8)},
    "time": {"feed": np.array([2.0, 2.0, 2.0]), "feed_mode": np.full(3, FeedMode.INVERSE_TIME, np.int8)},
}


@pytest.mark.parametrize("name", [*WAYS, "centre", "sense", "pitch"])
def test_what_differs_is_not_joined(name: str) -> None:
    """Two parts of a quarter and one of a half, of which the third is another arc."""
    rows = arcs([4.0], [0.25, 0.5], rise=1.0)
    centre, normal, end = rows.arcs.centre.copy(), rows.arcs.normal.copy(), rows.end.copy()
    if name == "centre":
        centre[2, :2] += 1e-3 * (centre[2] - end[1])[:2]
    elif name == "sense":
        normal[2] *= -1.0
    elif name == "pitch":
        end[2, 2] += 0.1
    else:
        rows = replace(rows, **WAYS[name])
    other = replace(rows, end=end, arcs=ArcTable(centre, normal, rows.arcs.sweep))
    np.testing.assert_array_equal(Stretches.of(other).first, [0, 2, 3])


def test_times_of_parts_add_up() -> None:
    """G93: 1/s of each part by its length; the whole takes the sum of 1, 1 and 2 s."""
    rows = arcs([4.0], [0.25, 0.5], rise=1.0)
    modes = np.full(3, FeedMode.INVERSE_TIME, np.int8)
    joined = Stretches.of(replace(rows, feed=np.array([1.0, 1.0, 0.5]), feed_mode=modes)).rows
    assert len(joined) == 1
    assert joined.feed[0] == pytest.approx(0.25)
    assert joined.arcs.sweep[joined.curve[0]] == pytest.approx(4.0)


def test_speeds_may_be_rounded_as_coordinates_are() -> None:
    """Thirds of an arc of 4 µm whose lengths are rounded by a millionth of a micrometre, which G93 makes speeds of."""
    rows = arcs([4.0], [0.3, 0.6], radius=0.004)
    speed = 200.0 * (1.0 + np.array([0.0, 3e-7, -2e-7]))
    rows = replace(rows, feed=speed, tolerance=np.full(3, 0.003))
    found = Stretches.of(rows)
    assert found.first.tolist() == [0, 3]
    assert found.parts.feed.tolist() == [200.0] * 3
    # What is long enough to know better has another speed.
    longer = replace(arcs([4.0], [0.3, 0.6]), feed=speed, tolerance=np.full(3, 0.003))
    assert Stretches.of(longer).first.tolist() == [0, 1, 2, 3]
