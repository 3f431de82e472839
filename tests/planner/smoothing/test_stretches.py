"""Lines that go straight on count as one: cutting a line into parts changes neither the smoothed curve nor its time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from cncgen.machine import Machine, load
from cncgen.pipeline import read_text, sound
from cncgen.planner import PlanOptions, plan
from cncgen.planner.smoothing import smooth
from cncgen.planner.smoothing.stretches import Stretches
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import join
from tests.planner.smoothing.programs import chunked, facets, path_of, toolpath


def cut(rows: Toolpath, parts: int, seed: int = 3) -> Toolpath:
    """Cut each line at random places; the parts keep the line number."""
    rng = np.random.default_rng(seed)
    share = np.sort(rng.uniform(size=(len(rows), parts)), axis=1)
    share[:, -1] = 1.0
    ends = rows.starts[:, None] + share[:, :, None] * (rows.end - rows.starts)[:, None]
    return replace(toolpath(rows.start, ends.reshape(-1, 3).tolist()), line=np.repeat(rows.line, parts))


def noisy(count: int) -> Toolpath:
    """Lines of 0.02 to 2 mm along a wave, whose ends lie beside it."""
    rng = np.random.default_rng(11)
    turn = np.sin(np.arange(count) / 5.0) + rng.normal(size=count) * 0.2
    way = np.exp(rng.uniform(np.log(0.02), np.log(2.0), count))
    ends = np.cumsum(way[:, None] * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1), axis=0)
    return toolpath([0, 0, 0], ends.tolist())


def shape(rows: Toolpath) -> np.ndarray:
    path = path_of(rows)
    return path.evaluate(np.linspace(0.0, path.length, 5000), 0)[0]


@pytest.mark.parametrize("rows", [noisy(150), facets(150, 0.7)])
def test_cut_lines_make_the_same_curve(rows: Toolpath) -> None:
    """Once the lengths of the parts told what is short: here the curves were 2.7 and 7.2 µm apart."""
    machine = load("generic-mill")
    whole, parted = (join(list(smooth([each], machine))) for each in (rows, cut(rows, 3)))
    np.testing.assert_allclose(shape(parted), shape(whole), rtol=0.0, atol=1e-8)


def test_parts_leave_chords_what_the_whole_leaves() -> None:
    """Parts away from where smoothing uses most once left them more: a cut line took up to 1.7 % less at 4 ms."""
    machine, rows = replace(load("generic-mill"), period_s=4e-3), facets(40, 0.9)
    whole, parted = (join(list(smooth([each], machine))) for each in (rows, cut(rows, 3)))
    of_line = dict(zip(whole.line.tolist(), whole.chord_room.tolist(), strict=True))
    assert len(parted) > len(whole)
    assert len(set(of_line.values())) > 5
    np.testing.assert_allclose(parted.chord_room, [of_line[line] for line in parted.line.tolist()], rtol=1e-6)


def seconds(lines: str, machine: Machine) -> float:
    chunks = sound(read_text(f"G21 G90 G64 P0.02\n{lines}M2\n", "a.nc"))
    return max(float(each.profile.t[-1]) for each in plan(chunks, machine, PlanOptions(feedrate="optimal")))


def test_a_cut_polyline_takes_as_long() -> None:
    def program(rows: Toolpath) -> str:
        return "".join(f"G1 X{x:.12f} Y{y:.12f} F6000\n" for x, y, _ in rows.end)

    machine, rows = load("generic-mill"), noisy(60)
    whole = seconds(program(rows), machine)
    assert seconds(program(cut(rows, 3)), machine) == pytest.approx(whole, rel=1e-3)


def test_lines_stay_known() -> None:
    """10 mm in four parts of a line each: so do they come out, on the curve and where it is met exactly."""
    x = np.array([2.0, 5.0, 7.0, 10.0, 10.0])
    ends = np.stack([x, [0, 0, 0, 0, 10], np.zeros(5)], axis=1).tolist()
    (made,) = smooth([toolpath([0, 0, 0], ends)])
    assert sorted(set(made.line.tolist())) == [1, 2, 3, 4, 5]
    assert set(made.kind.tolist()) == {Kind.NURBS}
    (exact,) = smooth([toolpath([0, 0, 0], ends[:4])])
    np.testing.assert_array_equal(exact.line, [1, 2, 3, 4])
    np.testing.assert_allclose(exact.end[:, 0], x[:4])


@pytest.mark.parametrize("size", [3, 5000])
def test_chunks_do_not_matter(size: int) -> None:
    """Of lines in 24 parts, more than a window of them, and of one in 1500."""
    rows = join([cut(facets(250), 24), cut(toolpath(facets(250).end[-1], [[99.0, 40.0, 7.0]]), 1500)])
    rows = replace(rows, line=np.arange(len(rows)))
    whole, parted = (join(list(smooth(each))) for each in ([rows], chunked(rows, size)))
    np.testing.assert_array_equal(parted.line, whole.line)
    np.testing.assert_array_equal(parted.end, whole.end)


def test_what_waits_is_bounded() -> None:
    """A straight line in 80 000 parts, of which 65 536 and some chunks wait at most."""
    taken = 0

    def parts() -> Iterator[Toolpath]:
        nonlocal taken
        for first in range(0, 80_000, 2048):
            x = 0.01 * np.arange(first, first + 2049)
            ends = np.stack([x, 0.5 * x, 0.0 * x], axis=1)
            taken = first
            yield toolpath(ends[0], ends[1:])

    first = next(iter(smooth(parts())))
    assert len(first) > 0
    assert taken <= 65_536 + 3 * 2048


STRAIGHT = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]


def test_parts_are_one_row() -> None:
    joined = Stretches.of(toolpath([0, 0, 0], STRAIGHT))
    np.testing.assert_array_equal(joined.first, [0, 3])
    np.testing.assert_array_equal(joined.rows.end, [[4.0, 0.0, 0.0]])
    part, t, of = joined.parts_of(np.array([0]), np.array([10.0, 18.0]))
    np.testing.assert_array_equal(part, [0, 1, 2])
    np.testing.assert_allclose(t, [10.0, 12.0, 14.0, 18.0])
    np.testing.assert_array_equal(of, [0, 0, 0])


def test_rounding_leaves_no_corner() -> None:
    """Parts that pass exactly lie on the line: one of 10 µm whose end is off by 10⁻⁹ mm would turn by 10⁻⁴."""
    ends = np.array([3.0, 3.01, 7.0])[:, None] * [0.6, 0.8, 0.0]
    ends[1] += [-0.8e-9, 0.6e-9, 0.0]
    (made,) = smooth([toolpath([0, 0, 0], ends.tolist())])
    np.testing.assert_array_equal(made.line, [1, 2, 3])
    np.testing.assert_allclose(made.end[:, 1] / made.end[:, 0], 4.0 / 3.0, rtol=1e-14)
    np.testing.assert_allclose(made.end, ends, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(
    "given",
    [
        {"feed": [100.0, 100.0, 90.0]},
        {"tolerance": [0.01, 0.01, 0.02]},
        {"path_mode": [PathMode.CONTINUOUS, PathMode.CONTINUOUS, PathMode.EXACT_PATH]},
        {"feed_mode": [FeedMode.SPEED, FeedMode.SPEED, FeedMode.RAPID]},
        {"feed_mode": FeedMode.INVERSE_TIME, "feed": [2.0, 2.0, 2.0]},
    ],
)
def test_what_differs_is_not_joined(given: dict) -> None:
    """1 mm, 1 mm and 2 mm: the third is another row."""
    np.testing.assert_array_equal(Stretches.of(toolpath([0, 0, 0], STRAIGHT, **given)).first, [0, 2, 3])


def test_an_event_and_a_way_back_part_a_line() -> None:
    ends = [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 0.0, 0.0]]
    rows = toolpath(
        [0, 0, 0], ends, kind=[0, Kind.EVENT, 0, 0], curve=[-1, 0, -1, -1], events=(Event("coolant"),)
    )
    np.testing.assert_array_equal(Stretches.of(rows).first, [0, 1, 2, 3, 4])


def test_times_of_parts_add_up() -> None:
    """G93: 1/s of each part by its length; the whole takes the sum of 1, 1 and 2 s."""
    rows = toolpath([0, 0, 0], STRAIGHT, feed=[1.0, 1.0, 0.5], feed_mode=FeedMode.INVERSE_TIME)
    joined = Stretches.of(rows).rows
    assert len(joined) == 1
    assert joined.feed[0] == pytest.approx(0.25)


def test_facets_of_a_slight_curve_are_no_line() -> None:
    """400 facets on a radius of 1 km turn by 10⁻⁹ rad each: ℓ²κ/2 = 5·10⁻¹³ mm of one, 20 nm of all beside P = 10 µm."""
    angle = 1e-9 * np.arange(401)
    ends = 1e6 * np.stack([np.sin(angle), 2.0 * np.sin(0.5 * angle) ** 2, 0.0 * angle], axis=1)
    rows = toolpath(ends[0], ends[1:])
    np.testing.assert_array_equal(Stretches.of(rows).first, np.arange(401))


def test_facets_of_a_slight_curve_stay_whole_where_they_are_cut() -> None:
    """Thirty of 0.1 mm, none of whose turns of 6·10⁻⁹ reaches 10⁻⁶ P with 1.5 mm on its sides: all parts once became rows."""
    angle = 6e-9 * np.arange(31)
    ends = 0.1 / 6e-9 * np.stack([np.sin(angle), 2.0 * np.sin(0.5 * angle) ** 2, 0.0 * angle], axis=1)
    rows = toolpath(ends[0], ends[1:].tolist())
    np.testing.assert_array_equal(Stretches.of(rows).first, np.arange(31))
    np.testing.assert_array_equal(Stretches.of(cut(rows, 3)).first, 3 * np.arange(31))


@pytest.mark.parametrize(("off", "joined"), [(0.9e-8, True), (1.1e-8, False)])
def test_what_is_straight_is_so_however_it_is_cut(off: float, joined: bool) -> None:
    """Two lines of 1 mm whose joint is beside the line between their ends, by less and by more than 10⁻⁶ P.

    Their turn times the shorter of them is twice of that, and once parted them both times, unless they were cut.
    """
    whole = toolpath([0, 0, 0], [[1.0, off, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]])
    np.testing.assert_array_equal(Stretches.of(whole).first, [0, 2, 3] if joined else [0, 1, 2, 3])
    np.testing.assert_array_equal(Stretches.of(cut(whole, 4)).first, [0, 8, 12] if joined else [0, 4, 8, 12])


def test_a_part_below_a_standstill_is_part_of_its_line() -> None:
    """0.1 pm cut off 1 pm, and 2 pm in four: parts that do not move by themselves; lines of other ways stay rows."""
    ends = np.array([[1.0, 0.0], [1.0, 1e-10], [1.0, 1e-9], [2.0, 1e-9]])
    ends = np.concatenate([ends, [[2.0, 1e-9 + 5e-10 * k] for k in (1, 2, 3, 4)], [[3.0, 3e-9]]])
    rows = toolpath([0, 0, 0], np.pad(ends, ((0, 0), (0, 1))).tolist())
    np.testing.assert_array_equal(Stretches.of(rows).first, [0, 1, 3, 4, 8, 9])


def test_speeds_of_eight_digits_are_one() -> None:
    """What G93 makes of lengths and of an F with eight digits; a speed that is another one in the sixth is another."""
    rows = toolpath([0, 0, 0], STRAIGHT, feed=[100.0, 100.000003, 100.0001])
    found = Stretches.of(rows)
    np.testing.assert_array_equal(found.first, [0, 2, 3])
    np.testing.assert_array_equal(found.parts.feed, [100.0, 100.0, 100.0001])


def test_a_slight_turn_parts_lines_however_they_are_cut() -> None:
    """2·10⁻⁸ rad at 1 mm is 20 nm, over 10⁻⁶ P; beside parts of 0.3 mm it is 6 nm, and once parted all parts or none."""
    ends = np.cumsum([[1.0, 0.0, 0.0], [1.0, 2e-8, 0.0], [1.0, 2e-8, 0.0]], axis=0)
    whole = toolpath([0, 0, 0], ends.tolist())
    np.testing.assert_array_equal(Stretches.of(whole).first, [0, 1, 3])
    parted = cut(whole, 4)
    np.testing.assert_array_equal(Stretches.of(parted).first, [0, 4, 12])
