"""Path and speed planned together within the tolerance: beside another method, closed forms, and what the setpoints have to hold."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline

import cncgen
from cncgen.kernels import tube_places
from cncgen.machine.reading import machine_from_toml
from cncgen.machine.record import Axis, Machine
from cncgen.planner.tube import window_rounds, window_search
from cncgen.planner.tube.window_judge import holds, too_fast
from cncgen.planner.tube.window_problem import Guess, Problem, Search, Solved
from cncgen.planner.tube.window_rounds import Rounds
from cncgen.planner.tube.window_search import WindowSearch
from cncgen.units import DEGREE

ROOT = Path(__file__).resolve().parents[3]
Floats = NDArray[np.float64]

V, A, J = 250.0, 2500.0, 5e4

#: Least times that IPOPT finds by direct multiple shooting (a phase a row, constant jerk over steps of 1 ms, the tolerance both ways
#: and in order): at P 0.01, 0.05 and 0.1 mm.
OPTIMA = {
    "corner20": (0.3373, 0.2900, 0.2873),
    "corner90": (0.3487, 0.3302, 0.3200),
    "corner135": (0.3277, 0.3206, 0.3186),
    "corner175": (0.3342, 0.3333, 0.3323),
    "needle": (0.4264, 0.4254, 0.4241),
    "retrace": (0.5368, 0.5350, 0.5327),
    "zigzag": (0.7417, 0.5907, 0.5731),
    "stairs": (0.6123, 0.5055, 0.4769),
    "pocket": (0.8226, 0.7554, 0.7396),
    "s-arcs": (0.8179, 0.7686, 0.7383),
}


def machine(velocity: float = V, acceleration: float = A, jerk: float = J) -> Machine:
    base = cncgen.load_machine("generic-mill")
    axes = {
        letter: replace(
            base.axes[letter], max_velocity=velocity, max_acceleration=acceleration, max_jerk=jerk
        )
        for letter in "XYZ"
    }
    return replace(base, axes=axes, period_s=1e-3, chord_tolerance_mm=1e-3, path_tolerance_mm=0.01)


def polyline(points: Sequence[Sequence[float]]) -> list[str]:
    return [f"G1 X{x:.9f} Y{y:.9f}" for x, y in points[1:]]


def corner(degrees: float) -> list[str]:
    a = np.radians(degrees)
    return polyline([(0, 0), (10, 0), (10 + 10 * np.cos(a), 10 * np.sin(a))])


ROWS = {
    "corner20": corner(20),
    "corner90": corner(90),
    "corner135": corner(135),
    "corner175": corner(175),
    "needle": polyline([(0, 0), (8, 0), (0.5, 0.6), (9, 1.0)]),
    "retrace": polyline([(0, 0), (10, 0), (4, 0), (9, 0), (1, 0)]),
    "zigzag": polyline([(2 * i, 1.5 * (i % 2)) for i in range(9)]),
    "stairs": polyline([(0, 0)] + [((i + 1) // 2, i // 2) for i in range(1, 11)]),
    "pocket": [
        "G1 X19 Y0", "G3 X20 Y1 I0 J1", "G1 X20 Y9", "G3 X19 Y10 I-1 J0", "G1 X1 Y10", "G3 X0 Y9 I0 J-1", "G1 X0 Y1",
        "G3 X1 Y0 I1 J0", "G1 X10 Y0",
    ],
    "s-arcs": [f"G{3 - i % 2} X{10 * i + 10} Y0 I5 J0" for i in range(4)],
}  # fmt: skip


def program(name: str, tolerance: float) -> str:
    feed = 7000 if name == "s-arcs" else 6000
    x = 10 if name == "pocket" else 0
    head = [f"(START, X{x} Y0)", f"G21 G90 G94 G17 G64 P{tolerance} F{feed}"]
    return "\n".join([*head, *ROWS[name], "M30", ""])


def planned(text: str, on: Machine, **asked: object) -> tuple[float, list[str]]:
    """Return the motion time, and what verifying finds broken."""
    stream, summary = cncgen.plan_with_summary(cncgen.read_text(text), on, **asked)
    chunk = stream.collect()
    seconds = float(summary.as_json()["motion_time_s"])
    again = cncgen.sample(cncgen.plan(cncgen.read_text(text), on, **asked))
    assert len(again.collect()) == len(chunk)
    verdict = cncgen.judge(
        cncgen.sample(cncgen.plan(cncgen.read_text(text), on, **asked)), cncgen.read_text(text), on
    )
    return seconds, [each.message for each in verdict.breaches]


@pytest.mark.parametrize("name", sorted(OPTIMA))
@pytest.mark.parametrize("number", [0, 1, 2])
def test_plans_come_within_a_hundredth_of_what_direct_multiple_shooting_finds(name: str, number: int) -> None:
    seconds, broken = planned(program(name, (0.01, 0.05, 0.1)[number]), machine())
    assert not broken
    # The nodes are further apart than its steps, and room is kept for what lies between them.
    assert 0.998 < seconds / OPTIMA[name][number] < 1.01


#: Folds a few tolerances long, at P 0.1: limits of both axes, the feed, the ends of lines from 0, 0, and the least time, found as above.
FOLDS = {
    "walk": (
        (V, A, J), 6000, 0.1651,
        [(-0.0206, -0.3241), (0.0392, -0.4725), (-0.3973, -0.6595), (-0.414, -0.4648), (-0.7388, -0.637), (-1.0665, -0.6077),
         (-1.266, -0.7523), (-1.5082, -0.4021), (-1.8299, -0.3315), (-1.961, -0.6476)],
    ),
    "acute teeth": (
        (400.0, 6000.0, 4e5), 6000, 0.1233,
        [(-0.0556, 0.299), (0.094, 0.0342), (0.0383, 0.3332), (0.1879, 0.0684), (0.1323, 0.3674), (0.2819, 0.1026),
         (0.2263, 0.4016), (0.3759, 0.1368)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(FOLDS))
def test_the_tips_of_folds_are_left_out_as_far_as_the_tolerance_allows(name: str) -> None:
    limits, feed, least, ends = FOLDS[name]
    text = "\n".join(
        ["(START, X0 Y0)", f"G21 G90 G94 G17 G64 P0.1 F{feed}", *polyline([(0, 0), *ends]), "M30", ""]
    )
    seconds, broken = planned(text, machine(*limits))
    assert not broken
    assert 0.998 < seconds / least < 1.015


#: Corners about a tolerance apart between longer rows: tolerance, feed, least time as above, and the ends of lines in tolerances.
NEAR = [
    (0.01, 6000, 0.1210, [(52.93, -43.02), (53.84, -43.88), (56.86, -45.7), (55.54, -46.05), (58.39, -43.31), (57.29, -43.64), (58.17, -43.87), (17.78, -36.33)]),
    (0.03, 2000, 0.15075, [(-25.43, -26.25), (-25.95, -25.92), (-27.61, -25.26), (-27.93, -25.8), (-27.3, -26.03), (-26.01, -28.15), (-9.12, -2.16)]),
    (0.01, 2000, 0.2009, [(-41.02, -100.6), (-39.96, -99.99), (-77.15, -77.24), (-76.88, -75.41), (-242.15, -71.93), (-241.09, -72.94)]),
    (0.03, 9000, 0.18817, [(43.9, 44.62), (44.35, 44.0), (44.55, 41.55), (-11.79, 64.6)]),
    (0.1, 6000, 0.30721, [(13.43, 61.78), (13.41, 62.3), (15.34, 59.83), (15.36, 60.87), (15.02, 61.31), (15.69, 61.25), (-56.29, 62.66)]),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(NEAR)))
def test_corners_about_a_tolerance_apart_are_passed_at_once(number: int) -> None:
    """Rounds narrowed rooms that did not hold the missed corner, or the time between two nodes grew to several times that of a corner."""
    tolerance, feed, least, ends = NEAR[number]
    head = ["(START, X0 Y0)", f"G21 G90 G94 G17 G64 P{tolerance} F{feed}"]
    rows = polyline([(0.0, 0.0), *(tolerance * np.array(ends)).tolist()])
    seconds, broken = planned("\n".join([*head, *rows, "M30", ""]), machine())
    assert not broken
    assert 0.998 < seconds / least < 1.01


def test_corners_that_the_plan_passes_in_one_place_are_nodes_all_the_same() -> None:
    """A motion within a tolerance is one within a larger one, so that takes no longer, though the plan passes more corners at once."""
    ends = [(0.0703, 0.0831), (-0.0242, 0.0513), (-0.079, 0.0836), (-0.1387, -0.0077), (-0.1027, -0.0699), (-0.2282, -0.079),
            (-0.1891, -0.013), (-0.2624, -0.0273), (-0.1506, -0.0728)]  # fmt: skip
    axes = {"X": Axis("X", 250.0, 2500.0, 5e4), "Y": Axis("Y", 120.0, 900.0, 2e4)}
    table = Machine("table", axes, 0.001, 0.001, path_tolerance_mm=0.01)
    before = np.inf
    for tolerance in (0.08, 0.09, 0.1, 0.11):
        head = ["(START, X0 Y0)", f"G21 G90 G94 G17 G64 P{tolerance} F8000"]
        seconds, broken = planned("\n".join([*head, *polyline([(0, 0), *ends]), "M30", ""]), table)
        assert not broken
        assert seconds < 1.001 * before
        before = seconds


@pytest.mark.parametrize(("tolerance", "least"), [(0.02, 0.30753), (0.1, 0.30113)])
def test_a_change_of_feed_is_made_where_the_tolerance_lets_the_faster_row_reach(
    tolerance: float, least: float
) -> None:
    """A straight line at 10 and then at 50 mm/s; the least times are found by direct multiple shooting, as above."""
    text = f"(START, X0 Y0)\nG21 G90 G94 G17 G64 P{tolerance}\nG1 X1 Y1 F600\nX5 Y5 F3000\nM30\n"
    seconds, broken = planned(text, machine())
    assert not broken
    assert 0.999 < seconds / least < 1.005


@pytest.mark.parametrize(
    ("mode", "feeds"), [("G93", (60.0, 60.0)), ("G94", (0.3, 0.3)), ("G93", (60.0, 120.0))]
)
def test_the_feed_of_x_is_the_pace_of_a_rotary_axis_where_the_tolerance_lets_x_stand(
    mode: str, feeds: tuple[float, float]
) -> None:
    """Rows of 5° and 5 µm to and fro, a second each by either kind of feed, or half a second: P0.05 once took a tenth of that.

    A rests at both ends: by seven phases (no velocity limit is near) that takes no more than v/a + a/j longer, 0.04 s.
    """
    rows = [f"G1 X{0.005 * (k % 2)} A{5 * k} F{feeds[k % 2]}" for k in range(1, 21)]
    time, _ = planned(
        "\n".join(["G21 G90 G64 P0.05", mode, *rows, "M2"]), cncgen.load_machine("generic-mill")
    )
    programmed = 10.0 * (60.0 / feeds[0] + 60.0 / feeds[1]) if mode == "G93" else 20.0
    assert 0.9998 * programmed <= time <= programmed + 0.1


def test_a_way_back_by_two_right_angles_is_left_out_within_the_tolerance() -> None:
    """From rest to rest jerk alone bounds an axis, so its way d takes (32 d/J)^(1/3) at least."""
    jerk, ends = 2e4, [(0.003, -0.022), (0.012, -0.048), (0.044, -0.037), (0.05, -0.054), (0.008, -0.07), (0.037, -0.074), (0.031, -0.051)]  # fmt: skip
    text = "\n".join(
        ["(START, X0 Y0)", "G21 G90 G94 G17 G64 P0.043 F2000", *polyline([(0, 0), *ends]), "M30", ""]
    )
    seconds, broken = planned(text, machine(400.0, 6000.0, jerk))
    assert not broken
    least = (32.0 * 0.051 / jerk) ** (1.0 / 3.0)
    assert 0.998 < seconds / least < 1.015


@pytest.mark.parametrize("tolerance", [0.05, 0.5])
def test_a_curve_that_turns_back_takes_as_long_as_lines_to_its_tip(tolerance: float) -> None:
    """x = 18 u − 15 u², y = 4/3 x: from 0 along a line to x = 5.4 at u = 0.6 and back to 3, which two lines are as well."""
    begin = f"(START, X0 Y0)\nG21 G90 G94 G17 G64 P{tolerance}\nG1 X0 Y0 F6000\n"
    knots = "G6.2 P3 K0 X0 Y0 R1\nK0 X9 Y12 R1\nK0 X3 Y4 R1\nK1\nK1\nK1\nM30\n"
    (curve, curve_broken), (lines, lines_broken) = (
        planned(begin + rows, machine()) for rows in (knots, "G1 X5.4 Y7.2\nG1 X3 Y4\nM30\n")
    )
    assert not curve_broken
    assert not lines_broken
    assert curve == pytest.approx(lines, rel=4e-3)


def test_a_bend_of_a_few_nanometres_has_its_node_at_the_tip() -> None:
    """A random rational curve whose tip is two corners of lines nearer to each other than nodes may be; beside its own chords, by G1."""
    at = np.array(
        [
            (0.0, 0.0),
            (0.078340368, 0.084965858),
            (0.752567561, -0.374288791),
            (0.250390682, -0.969770407),
            (0.752567561, -0.374288791),
            (0.502388149, -0.328428085),
            (0.332452213, -1.034207473),
        ]
    )
    weights = np.array([0.81582, 1.85655, 1.34799, 0.44221, 0.70456, 3.55231, 0.33939])
    knots = np.array([0, 0, 0, 0.072453060, 0.230123158, 0.304739633, 0.395196278, 1, 1, 1])
    tolerance, chord = 0.000484, 2e-5
    seconds = []
    for points, own, steps in ((at, weights, knots), (at[::-1], weights[::-1], 1.0 - knots[::-1])):
        rows = [
            f"K{knot:.9f}"
            + (f" X{points[k, 0]:.9f} Y{points[k, 1]:.9f} R{own[k]:.5f}" if k < len(at) else "")
            for k, knot in enumerate(steps)
        ]
        begin = f"(START, X{points[0, 0]} Y{points[0, 1]})\nG21 G90 G94 G17 G64 P{tolerance} F60000\nG6.2 P3 "
        found, broken = planned(begin + "\n".join([*rows, "M30", ""]), machine())
        assert not broken
        seconds.append(found)
    homogeneous = BSpline(knots, np.column_stack([at * weights[:, None], weights]), 2)
    u = np.linspace(0.0, 1.0, 400_001)
    curve = homogeneous(u)[:, :2] / homogeneous(u)[:, 2:]
    # As many chords as keep each of them within a distance of the curve.
    bend = np.hypot(*np.gradient(np.gradient(curve, axis=0), axis=0).T)
    number = np.cumsum(np.sqrt(bend / 8.0 / chord))
    ends = np.searchsorted(number, np.linspace(0.0, number[-1], int(number[-1]) + 2))
    text = [f"G21 G90 G94 G17 G64 P{tolerance - chord} F60000", *polyline(curve[np.unique(ends)]), "M30", ""]
    lines, broken = planned("(START, X0 Y0)\n" + "\n".join(text), machine())
    assert not broken
    assert seconds == pytest.approx([lines, lines], rel=2e-3)


def test_a_curve_far_away_may_be_cut_where_its_parameters_are_one_number() -> None:
    """Weights of 24,000 to 1 at Y−59273 leave a bend that is shorter than numbers tell; within P it is planned like any other."""
    rows = [
        (0, 0.051218109278, -59272.946042598836, 28.515019987972),
        (0, 0.050043834453, -59272.943018482183, 0.806391119114),
        (0, 0.051397424586, -59272.941144206517, 0.016412436554),
        (0.013555135626, 0.054930789438, -59272.94021088005, 394.5071843571),
        (0.5, 0.057703898164, -59272.940648564043, 0.303094394064),
        (0.694647281267, 0.058458184137, -59272.936902993963, 2.95382816028),
    ]
    curve = "".join(f"K{k} X{x} Y{y} R{w}\n" for k, x, y, w in rows)
    begin = f"(START, X{rows[0][1]} Y{rows[0][2]})\nG21 G90 G94 G17 G64 P6 F18469\nG6.2 P3 "
    limits = {
        "X": Axis("X", 2200.37, 36866.0, 656977.0),
        "Y": Axis("Y", 3.23413, 132.505, 32624.7),
    }
    near = replace(machine(), axes=limits, period_s=0.00276869475, chord_tolerance_mm=2.56649e-06)
    seconds, broken = planned(
        begin + curve + "K1\nK1\nK1\nG1 X0.11894556454 Y-59272.867216401784\nM30\n", near
    )
    assert seconds > 0.0
    assert not broken


@pytest.mark.parametrize(("tolerance", "radius", "turns"), [(0.0129, 0.045, 4), (0.05, 0.2, 5)])
def test_several_turns_about_one_place_take_as_long_backwards(
    tolerance: float, radius: float, turns: int
) -> None:
    """A motion and its reverse take as long: no limit tells one from the other."""
    begin = f"G21 G90 G94 G17 G64 P{tolerance} F9000\n"
    there = f"G1 X0 Y0\nG2 J-{radius} P{turns}\nG2 I1.3\nG1 X-4\nM30\n"
    back = f"G1 X0 Y0\nG3 I1.3\nG3 J-{radius} P{turns}\nG1 X-3\nM30\n"
    (one, one_broken), (other, other_broken) = (
        planned(f"(START, X{x} Y0)\n{begin}{rows}", machine()) for x, rows in ((-3, there), (-4, back))
    )
    assert not one_broken
    assert not other_broken
    assert one == pytest.approx(other, rel=5e-4)


def test_a_helix_of_three_circles_takes_as_long_backwards() -> None:
    """The search of all of it failed one way: in parts it took 0.8 % longer."""
    turns = ["X0 Y0 Z-3 I0.9746 J-0.2241", "X0 Y0 Z-6 I0.4033 J-0.0927", "X0 Y0 Z-9 I0.9746 J-0.2241"]
    back = ["X0 Y0 Z-6 I0.9746 J-0.2241", "X0 Y0 Z-3 I0.4033 J-0.0927", "X0 Y0 Z0 I0.9746 J-0.2241"]
    on = machine(44.84, 1e4, 426304.0)
    slow = Axis("Z", 13.45, 3000.0, 127891.0)
    on = replace(on, axes={**on.axes, "Z": slow})
    (one, one_broken), (other, other_broken) = (
        planned(
            "\n".join(
                [
                    f"(START, Z{z})",
                    "G21 G90 G94 G17 G64 P0.1 F116",
                    *(g + " " + row for row in rows),
                    "M30",
                    "",
                ]
            ),
            on,
        )
        for z, g, rows in ((0, "G2", turns), (-9, "G3", back))
    )
    assert not one_broken
    assert not other_broken
    assert one == pytest.approx(other, rel=5e-3)


def test_closer_nodes_amid_a_run_leave_its_other_windows() -> None:
    """The windows searched ahead were counted by the closer nodes of the one before them: an IndexError."""
    rows = [
        "G2 X0 Y0 Z-3 I-0.513118 J-0",
        "G2 X0 Y0 Z-6 I-0.513118 J-0",
        "G1 X1 Y0 Z-6 A-1",
        "G2 X-0.5995127060267027 Y-0.8456298345962399 Z-6 I-1.02329 J-0",
        "G2 X-2.1990254120534054 Y-1.6912596691924797 Z-6 I-1.02329 J-0",
        "G1 X-2.209025412053405 Y-1.6912596691924797 Z-6 A-1",
        "G1 X-2.209025412053405 Y-1.6912595691924797 Z-5.99999997 A4.49578",
        "G1 X-3.8693227159662866 Y-5.871093185823603 Z-5.99999997 A4.49578",
        "G1 X-3.084087645206339 Y-0.8029528547210179 Z-4.46141697 A4.49578",
        "G2 X-3.084087645206339 Y-0.8029528547210179 Z-4.46141697 I0.133033 J0",
    ]
    text = "\n".join(["G21 G17 G90 G93 G64 P0.01", *(row + " F3.16228" for row in rows), "M2", ""])
    fast, slow = (21.6684, 316.228, 32835.1), (6.50052, 94.8684, 9850.53)
    axes = {"X": Axis("X", *fast), "Y": Axis("Y", *slow), "Z": Axis("Z", *fast)}
    axes["A"] = Axis("A", *(DEGREE * each for each in slow))
    on = replace(machine(), axes=axes)
    seconds, broken = planned(text, on)
    assert not broken
    assert seconds < planned(text, on, effort="fast")[0]


@pytest.mark.parametrize("feed", ["G94", "G93"])
def test_five_axes_at_their_feed_take_no_longer_than_along_the_path(feed: str) -> None:
    """The speed and the times of rows bind together; windows had no solution, and the plan had few nodes: 1.3 % longer."""
    place = np.zeros(3)
    rows = []
    for i in range(600):
        step = [0.5 * np.cos(i / 30.0), 0.5 * np.sin(i / 20.0), 0.1 * np.sin(i / 7.0)]
        place = place + step
        x, y, z = place
        a, b = 30.0 * np.sin(i / 50.0), 40.0 * np.cos(i / 35.0)
        f = 3000.0 / (np.linalg.norm(step) if feed == "G93" else 1.0)
        rows.append(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} A{a:.3f} B{b:.3f} F{f:.3f}")
    text = "\n".join([f"(START, X0.5 B40)\nG21 G17 G90 G64 P0.01 {feed}", *rows, "M2", ""])
    on = cncgen.load_machine("generic-mill")
    best, broken = planned(text, on)
    assert not broken
    assert best < planned(text, on, effort="fast")[0]


def test_lines_of_a_hundredth_between_larger_ones_are_passed_within_the_tolerance() -> None:
    """A star of 20 µm: the path without it, which is within the tolerance of the rows, takes as long."""
    ends = [(0, 0), (1, 0)]
    star = [(1.0 + 0.02 * np.cos(2.5 * i), 0.02 * np.sin(2.5 * i)) for i in range(12)]
    times = []
    for rows in (ends + star, ends):
        lines = polyline([*rows, (2, 1)])
        text = "\n".join(["(START, X0 Y0)", "G21 G90 G94 G17 G64 P0.2 F6000", *lines, "M30", ""])
        seconds, broken = planned(text, machine())
        assert not broken
        times.append(seconds)
    assert times[0] < 1.03 * times[1]


def test_a_nurbs_of_degree_2_is_no_slower_than_its_polyline() -> None:
    curve = (ROOT / "programs" / "star.nc").read_text()
    text = curve.replace("G61", "G64 P0.01").replace("F6000", "F7000")
    assert text.count("G64 P0.01") == text.count("F7000") == 1
    seconds, broken = planned(text, machine())
    assert not broken
    # 2.443 s is what short lines of 0.02 mm took.
    assert seconds < 2.42


def test_a_row_that_turns_alone_is_cut_at_both_ends() -> None:
    """IPOPT finds 0.3140 s (`trials/beside_ipopt.py`, over X Y A); it took 0.3211 s with planes beside the corners that the plan goes through."""
    base = machine()
    rotary = {"max_velocity": 120.0, "max_acceleration": 1500.0, "max_jerk": 3e4}
    turns = replace(base.axes["X"], letter="A", **{name: np.radians(limit) for name, limit in rotary.items()})
    on = replace(base, axes={"X": base.axes["X"], "Y": base.axes["Y"], "A": turns})
    rows = "G1 X2 Y0 A0\nG1 Y3\nG1 A0.6\nG1 X4\nG1 Y6"
    seconds, broken = planned(f"(START, X0 Y0 A0)\nG21 G90 G94 G17 G64 P0.15 F6000\n{rows}\nM2\n", on)
    assert not broken
    assert seconds < 1.0075 * 0.3140


def test_a_nurbs_that_bends_within_a_few_tolerances_is_no_slower_than_its_polyline() -> None:
    """A random cubic, as `trials/beside_ipopt.py` draws them: it took 0.420 s, its polyline 0.383 s."""
    points = np.array([
        (-1.371, 0.682), (-5.116, -3.241), (-7.299, -5.624), (-12.655, -7.42), (-13.55, -7.849), (-19.215, -7.602),
        (-21.947, -6.759), (-26.287, -10.384), (-28.848, -10.216), (-32.294, -15.451),
    ])  # fmt: skip
    weights = np.array([1.0, 1.0, 1.0, 1.0, 1.096, 1.0, 1.829, 1.0, 1.053, 1.0])
    knots = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 4.0, 5.0, 6.0, 7.0, 7.0, 7.0, 7.0])
    curve, lines = curve_and_lines(points, weights, knots, "G64 P0.138 F9000", machine())
    assert curve < 1.003 * lines


@pytest.mark.parametrize(
    ("points", "knots", "row"),
    [
        # A corner within the row: two knots of a curve of degree 2 are one. It took 6.5 % longer than its lines.
        (
            [(-0.2613, -1.7978), (4.5284, -1.8667), (2.2013, 2.2607), (-0.193, 0.9027), (-8.2443, 1.3659),
             (-1.9292, -2.3835), (6.8104, 0.9157)],
            [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0],
            "G64 P0.005 F12000",
        ),
        # Bends of radii from a thirtieth of the tolerance up: 4.3 % longer.
        (
            [(0.173, 0.9384), (0.871, -0.9839), (-1.4527, 0.0252), (-0.8344, -0.3243), (-0.451, -1.8839),
             (0.354, -2.7287), (-0.4269, -2.8133), (-0.0261, -3.244), (-0.5746, -1.8305), (0.1841, -3.551)],
            [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0, 4.0],
            "G64 P0.03 F12000",
        ),
    ],
)  # fmt: skip
def test_a_nurbs_that_bends_more_sharply_than_the_tolerance_is_wide_is_no_slower_than_its_polyline(
    points: list[tuple[float, float]], knots: list[float], row: str
) -> None:
    curve, lines = curve_and_lines(
        np.array(points), np.ones(len(points)), np.array(knots), row, cncgen.load_machine("generic-mill")
    )
    assert curve < 1.005 * lines


def curve_and_lines(
    points: Floats, weights: Floats, knots: Floats, row: str, on: Machine
) -> tuple[float, float]:
    """Return the times of a NURBS and of the same curve as short lines."""
    x0, y0 = points[0]
    head = [f"(START, X{x0} Y{y0})", f"G21 G90 G94 G17 {row}"]
    order = len(knots) - len(points)
    poles = zip(knots[: len(points)], points, weights, strict=True)
    rows = [f"K{k:g} X{x} Y{y} R{w}" for k, (x, y), w in poles] + order * [f"K{knots[-1]:g}"]
    seconds, broken = planned("\n".join([*head, f"G6.2 P{order} {rows[0]}", *rows[1:], "M30", ""]), on)
    assert not broken
    weighed = BSpline(knots, np.c_[points * weights[:, None], weights], order - 1)(
        np.linspace(knots[0], knots[-1], 2001)
    )
    lines = polyline(weighed[:, :2] / weighed[:, 2:])
    flattened, broken = planned("\n".join([*head, *lines, "M30", ""]), on)
    assert not broken
    return seconds, flattened


def test_the_exact_path_stays_under_g61_and_where_effort_is_fast() -> None:
    text = program("zigzag", 0.05)
    exact, broken = planned(text.replace("G64 P0.05", "G61"), machine())
    assert not broken
    fast, _ = planned(text, machine(), effort="fast")
    best, _ = planned(text, machine())
    assert best < fast < exact


@pytest.mark.parametrize("tolerance", [0.03, 0.1])
def test_a_circle_takes_the_time_of_its_slow_axis(tolerance: float) -> None:
    """Y is at its velocity nearly all the time: down by 2 − P at least, and back (5.625 and 5.630 s before)."""
    slow, fast = machine(0.708624, 261.289, 30000.0), machine(23.6208, 8709.64, 1e6)
    mixed = replace(slow, axes={**fast.axes, "Y": slow.axes["Y"]})
    text = f"G21 G90 G94 G17 G64 P{tolerance}\nG2 X0 Y0 I0 J-1 F2251.46\nM30\n"
    seconds, broken = planned(text, mixed)
    assert not broken
    assert seconds < 1.005 * 2.0 * (2.0 - tolerance) / 0.708624


def test_a_round_that_runs_out_of_iterations_begins_anew() -> None:
    """A random program on a machine of slow axes: such a round took 12.302 s where the one before took 11.895 s, and the plan was kept."""
    limits = {"X": (11.36, 112.9, 3209.0), "Y": (4.976, 147.8, 2426.0), "Z": (8.370, 18.49, 376.3)}
    slow = replace(machine(), axes={letter: machine(*each).axes[letter] for letter, each in limits.items()})
    rows = [
        "G1 X-3.2491 Y-3.4701 Z0.0000", "G3 X-7.1576 Z-26.2524 I-1.9543 K-13.1262", "G1 X-14.1372 Y-10.5838 Z-37.5192",
        "G2 X-7.1740 Z-49.1040 I3.4816 K-5.7924", "G1 X-18.1968 Y-24.4043 Z-49.1040", "G1 X-0.1745 Y-24.4043 Z-50.3830",
        "G1 X-0.1745 Y-2.2495 Z-49.4843", "G1 X-0.1745 Y-2.2495 Z-50.4395", "G2 X16.9014 Z-50.4341 I8.5379 K0.0027",
        "G3 X-10.6670 Z-34.0028 I-13.7842 K8.2157", "G1 X-6.6689 Y15.7311 Z-35.6514", "G2 X-9.7597 Z-48.8627 I-1.5454 K-6.6056",
        "G1 X-7.6253 Y15.7311 Z-48.8627", "G3 X-20.2507 Z-52.7434 I-6.3127 K-1.9404", "G2 X-27.3186 Z-28.4782 I-3.5339 K12.1326",
        "G3 X-57.7969 Z-2.5481 I-15.2391 K12.9651", "G1 X-57.7969 Y1.6973 Z-2.5481", "G1 X-76.1310 Y-17.9971 Z-28.7158",
        "G1 X-76.1310 Y-17.9971 Z-28.7158", "G1 X-76.1310 Y-53.4105 Z-22.6430", "G2 X-40.5929 Z-34.1102 I17.7690 K-5.7336",
        "G1 X-34.0274 Y-34.9153 Z-68.3371", "G1 X-34.0274 Y-30.6560 Z-48.2916", "G2 X-22.4857 Z-74.9029 I5.7708 K-13.3057",
        "G1 X-32.4493 Y-19.9855 Z-79.4393", "G1 X15.3002 Y-3.3082 Z-112.2701", "G1 X6.5099 Y8.7835 Z-134.0909",
    ]  # fmt: skip
    text = "\n".join(["G21 G90 G94 G18 G64 P0.0554 F672", *rows, "M30", ""])
    setpoints, summary = cncgen.plan_with_summary(cncgen.read_text(text), slow)
    setpoints.collect()
    assert summary.as_json()["tolerance_windows_kept"] == 0


def test_nodes_are_met_as_exactly_as_short_periods_need() -> None:
    """At 0.1 ms steps of 0.03 nm between pieces of the motion were 1.3 % of the jerk limit."""
    on = replace(machine(), period_s=1e-4)
    stream, summary = cncgen.plan_with_summary(cncgen.read_text(program("zigzag", 0.1)), on)
    x = stream.collect().position
    assert summary.as_json()["tolerance_windows_kept"] == 0
    assert np.abs(np.diff(x, 3, axis=0)).max() / 1e-12 <= 1.0005 * J


def test_velocity_holds_between_nodes_that_are_far_apart() -> None:
    text = "G21 G90 G94 G17 G64 P0.01 F9000\nG1 X40 Y40\nG1 X0 Y80\nM30\n"
    _, broken = planned(text, machine(100.0, 1000.0))
    assert not broken


WAVE = [
    (0.3162 * k, y) for k, y in enumerate([0, 2e-4, 0, 1e-4, -1e-4, -1e-4, -2e-4, 0, 1.5e-4, 1.5e-4, 2e-4])
]
SLOW = (2.38298, 10.4653, 16083.6), (23.8298, 104.653, 160836.0), (2.38298, 10.4653, 16083.6)
STAR = [
    (0, 0),
    (-0.939693, 0.34202),
    (-0.173648, -0.300767),
    (-0.673648, 0.565258),
    (-0.5, -0.41955),
    (-0.326352, 0.565258),
    (-0.826352, -0.300767),
    (-0.060307, 0.34202),
    (-1.0, 0.0),
    (-0.0, 0.0),
]
ARCS = [
    "G2 X-0.15619944 Y0.19903631 I-0.17791736 J0.02118341",
    "G2 X-1.02797458 Y1.30989118 I-0.99298646 J0.11822815",
]


@pytest.mark.parametrize(
    ("rows", "feed", "limits", "narrow", "wide"),
    [
        # Few nodes lost what the tolerance gave: 0.15 %.
        (polyline(WAVE), 1953.588, ((110.724, 500.0, 1e4),) * 3, 0.03, 0.15),
        # No motion was found for all of the run: 6.6 %.
        (ARCS, 6844.65, SLOW, 0.2, 0.5),
        # A search that took long ended in a poor motion of many: 4 %.
        (
            polyline(STAR),
            300,
            ((252.71, 500.0, 148510.0), (252.71, 500.0, 148510.0), (252.71, 500.0, 148510.0)),
            0.03,
            0.1,
        ),
    ],
)
def test_a_larger_tolerance_takes_no_longer(
    rows: list[str],
    feed: float,
    limits: Sequence[tuple[float, float, float]],
    narrow: float,
    wide: float,
) -> None:
    axes = {
        letter: replace(
            machine().axes[letter], max_velocity=each[0], max_acceleration=each[1], max_jerk=each[2]
        )
        for letter, each in zip("XYZ", limits, strict=True)
    }
    on = replace(machine(), axes=axes)
    seconds = []
    for tolerance in (narrow, wide):
        text = "\n".join([f"G21 G90 G94 G17 G64 P{tolerance} F{feed}", *rows, "M30", ""])
        time, broken = planned(text, on)
        assert not broken
        seconds.append(time)
    assert seconds[1] <= 1.001 * seconds[0]


@pytest.mark.parametrize("step", [0.0005, 0.001])
def test_more_jerk_than_setpoints_can_follow_takes_no_longer(step: float) -> None:
    """Stairs at P 0.25 µm and 8.3 ms: with ten times the jerk the search found nothing, and they took 1.15 and 1.9 times as long."""
    rows = polyline([(step * ((i + 1) // 2), step * (i // 2)) for i in range(40)])
    text = "\n".join(["G21 G90 G94 G17 G64 P0.00025 F60", *rows, "M30", ""])
    seconds = []
    for jerk in (1500.0, 15000.0, 150000.0):
        on = quick(dict.fromkeys("XY", (2.0, 500.0, jerk)), 8.3e-3, 1e-5, 1e-3)
        time, broken = planned(text, on)
        assert not broken
        seconds.append(time)
    assert max(seconds) <= 1.001 * seconds[0]


@pytest.mark.parametrize(("order", "factor"), [(0, 100.0), (0, 1000.0), (1, 1000.0), (1, 1e5)])
def test_a_limit_that_no_motion_comes_near_changes_nothing(order: int, factor: float) -> None:
    """Nodes are met to a part of the limits: with axes of 25 m/s at a feed of 20 mm/s some windows found no motion, with 250 m/s none."""
    rows = [f"G1 X{2 * k} Y{3 * (k % 2)}" for k in range(1, 9)]
    text = "\n".join(["G21 G90 G94 G64 P0.01 F1200", *rows, "M2", ""])
    # Full jerk from the feed one way to the feed the other way ends at √(2 · 20 mm/s · J), 1400 mm/s².
    limits = [V, A, J]
    usual, _ = planned(text, machine(*limits))
    limits[order] *= factor
    seconds, broken = planned(text, machine(*limits))
    assert not broken
    assert seconds == pytest.approx(usual, rel=1e-6)


@pytest.mark.parametrize(
    ("radius", "tolerance", "period"), [(0.05, 2e-4, 1e-3), (0.5, 1e-3, 1e-3), (2.0, 1e-3, 2e-3)]
)
def test_a_circle_is_passed_as_fast_as_chords_between_setpoints_allow(
    radius: float, tolerance: float, period: float
) -> None:
    """Setpoints are outside by P and the middle of the chords between them inside by P: v = √(16 P R)/T. The turns took 1.4 times that.

    Beside it are the start and the end, and the room that is kept for what lies between nodes.
    """
    turns = 8
    head = ["(START, X0 Y0)", f"G21 G90 G94 G17 G64 P{tolerance} F60000"]
    text = "\n".join([*head, *[f"G3 X0 Y0 I{radius} J0"] * turns, "M30", ""])
    on = replace(machine(1000.0, 1e5, 1e8), period_s=period, chord_tolerance_mm=tolerance)
    seconds, broken = planned(text, on)
    assert not broken
    least = 2.0 * np.pi * radius * turns * period / np.sqrt(16.0 * tolerance * radius)
    assert 0.99 < seconds / least < 1.04


@pytest.mark.parametrize("back", [1, -1])
def test_corners_that_chords_cut_off_take_hardly_more_than_without_chords(back: int) -> None:
    """A star of 1 mm at P 1 µm and 2 ms, whose chords are up to 1.7 µm off the motion: direct multiple shooting (IPOPT) without
    chords finds 0.26225 s. Where nodes alone had room it took 0.2756 s, and 0.2700 s from its end to its start."""
    points = [(0, 0), (-0.80902, 0.58779), (-0.5, -0.36327), (-0.19098, 0.58779), (-1, 0), (0, 0)][::back]
    text = "\n".join(["G21 G90 G94 G17 G64 P0.001 F29751", *polyline(points), "M30", ""])
    seconds, broken = planned(text, quick(dict.fromkeys("XY", (495.856, 3418.49, 1e5)), 2e-3, 1e-3, 0.01))
    assert not broken
    assert 0.26225 <= seconds <= 1.01 * 0.26225


def test_a_last_row_shorter_than_the_tolerance_loses_no_window() -> None:
    """The end of the program was taken for a rest that the plan had not come to, and all of the plan stood: twice the time."""
    rows = polyline([(0, 0), (-0.0279, 0.011), (-0.3045, -1.0764), (-1.1561, -0.5522), (-1.165, -0.5701)])
    text = "\n".join(["G21 G90 G94 G17 G64 P0.12 F1351", *rows, "M30", ""])
    on = replace(machine(329.872, 3699.68, 698449.0), period_s=4e-3, chord_tolerance_mm=1e-4)
    best, broken = planned(text, on)
    assert not broken
    assert best < 0.9 * planned(text, on, effort="fast")[0]


def test_an_end_is_a_rest_whatever_rounding_leaves_of_its_velocity() -> None:
    """1e-17 mm/s at the end counted as motion, whose places the window could not all reach: it stood as it was, 4 % slower."""
    rows = [
        "G2 X0.6960901216709344 Y-0.1644814700047609 Z1 I0.367478 J-0.00000000000000004500307564570711",
        "G2 X1.3921802433418689 Y-0.3289629400095218 Z2 I0.367478 J-0.00000000000000004500307564570711",
    ]
    text = "\n".join(["G21 G90 G94 G17 G64 P0.01 F7294.33", *rows, "M30", ""])
    seconds = []
    for factor in (1.0, 1.5):
        slow = {"max_velocity": 1.34263, "max_acceleration": 30.0, "max_jerk": 218.83}
        axes = {letter: replace(machine().axes[letter], **slow) for letter in "XY"}
        axes["X"] = replace(axes["X"], max_acceleration=30.0 * factor)
        axes["Z"] = replace(
            machine().axes["Z"], max_velocity=44.7544, max_acceleration=1000.0, max_jerk=7294.33
        )
        time, broken = planned(text, replace(machine(), axes=axes))
        assert not broken
        seconds.append(time)
    assert seconds[1] <= 1.001 * seconds[0]


def straight(length: float, nodes: int) -> tuple[Problem, Floats]:
    """Return the problem of a diagonal from rest to rest with next to no room, and a slow first guess."""
    # Nodes where the seven-phase profile of the way has them at even times.
    h = 4.0 * np.cbrt(length * np.sqrt(0.5) / 2.0 / J) / nodes
    jerk = np.repeat([J, -J, -J, J], nodes // 4)
    a = np.concatenate([[0.0], np.cumsum(jerk) * h])
    v = np.concatenate([[0.0], np.cumsum(a[:-1] * h + 0.5 * jerk * h**2)])
    s = np.sqrt(2.0) * np.concatenate([[0.0], np.cumsum(v[:-1] * h + a[:-1] * h**2 / 2 + jerk * h**3 / 6)])
    t = np.full(2, np.sqrt(0.5))
    point = s[:, None] * t
    velocity = 0.5 * np.sqrt(2.0) * np.maximum(v, 0.0)
    rest = np.zeros((3, 2))
    goal = rest.copy()
    goal[0] = point[-1]
    given = Problem(
        np.full(2, V), np.full(2, A), np.full(2, J), np.ones((nodes + 1, 2)), point, np.tile(t, (nodes + 1, 1)), np.full(nodes, 2.0 * h),
        np.concatenate([[0, 0], np.arange(1, nodes), [nodes - 1]]).astype(np.int64), point[1:-1].copy(), np.tile(t, (nodes - 1, 1)),
        np.full(nodes - 1, 1e-3), np.zeros(nodes - 1), np.full(nodes + 1, np.inf), np.zeros(nodes), np.full(nodes, np.inf), np.full(nodes, np.inf), rest, goal, 1e-3,
    )  # fmt: skip
    return given, velocity[:, None] * t


def begun_at(given: Problem, velocity: np.ndarray) -> Search:
    still = np.zeros_like(velocity)
    return Search(given, Guess(given.step, velocity, still, still, still[1:]))


def test_a_straight_line_takes_the_time_of_the_seven_phase_profile() -> None:
    """Each axis goes L/√2; A and V are not reached: four phases of (L/2/J)^(1/3) (Biagiotti and Melchiorri (2008), 3.4)."""
    length = 4.0
    given, velocity = straight(length, 200)
    found = begun_at(given, velocity).solve()
    least = 4.0 * np.cbrt(length * np.sqrt(0.5) / 2.0 / J)
    assert (J * least / 4.0) < A
    assert found.status == 1
    assert least * (1.0 - 1e-4) < found.step.sum() < least * 1.003
    assert np.abs(found.position - given.goal[0] * (found.position[:, :1] / given.goal[0, 0])).max() < 1.5e-3


def test_motion_between_nodes_is_that_of_constant_jerk() -> None:
    given, velocity = straight(4.0, 60)
    found = begun_at(given, velocity).solve()
    h, x, v, a = found.step[:, None], found.position, found.velocity, found.acceleration
    assert np.abs(x[:-1] + h * (v[:-1] + h * (a[:-1] / 2 + h * found.jerk / 6)) - x[1:]).max() < 1e-9
    assert np.abs(v[:-1] + h * (a[:-1] + h * found.jerk / 2) - v[1:]).max() < 1e-5
    assert np.abs(a).max() <= A
    assert np.abs(found.jerk).max() <= J


def diagonal(period_s: float) -> tuple[Problem, Solved]:
    given, velocity = straight(4.0, 60)
    given = replace(given, period_s=period_s)
    return given, begun_at(given, velocity).solve()


@pytest.mark.parametrize("period_s", [1e-3, 1e-4])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_judge_lets_no_step_pass_that_setpoints_show(period_s: float, order: int) -> None:
    """A step of the k-th derivative is J T^(3 - k) times its part of a third difference, which sums at most 3 - k of them."""
    given, found = diagonal(period_s)
    limits = given.acceleration, given.jerk, period_s
    for part, passes in ((0.0, True), (1e-5, True), (1e-3, False)):
        goal = given.goal.copy()
        goal[order, 1] += part * J * period_s ** (3 - order)
        assert holds(found, (given.start, goal), *limits) == passes
    states = [found.position, found.velocity, found.acceleration]
    states[order][30, 1] += 1e-3 * J * period_s ** (3 - order)
    assert not holds(found, (given.start, given.goal), *limits)


def test_the_judge_sees_steps_of_acceleration_where_jerk_hides_them() -> None:
    """A step of the velocity by 1e-2 A T is a part of 1e-2 of the acceleration in a second difference, whatever the jerk limit."""
    given, found = diagonal(1e-3)
    goal = given.goal.copy()
    goal[1, 1] += 1e-2 * A * 1e-3
    assert not holds(found, (given.start, goal), given.acceleration, 1e6 * given.jerk, 1e-3)
    assert holds(found, (given.start, given.goal), given.acceleration, 1e6 * given.jerk, 1e-3)


def test_the_judge_looks_between_nodes() -> None:
    """Velocities 0, 60 t - 30 t² and 40 over 2 s: the first parabola has its top, 30, at 1 s, where the speed is 50."""
    shape = np.zeros((2, 3))
    velocity, jerk = shape.copy(), np.array([[0.0, -60.0, 0.0]])
    velocity[:, 2] = 40.0
    acceleration = np.array([[0.0, 60.0, 0.0], [0.0, -60.0, 0.0]])
    found = Solved(shape, velocity, acceleration, jerk, np.array([2.0]), 1, 0)
    for top, feed, over in ((30.01, 50.01, False), (29.99, 50.01, True), (30.01, 49.99, True)):
        most, weight = np.array([100.0, top, 100.0]), np.ones((1, 3))
        assert too_fast(found, most, np.array([feed]), weight).tolist() == [over]


def test_places_of_points_on_a_closed_line_are_in_order() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 2001)
    line = np.column_stack([np.cos(angle), np.sin(angle)])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    # The first point is the last one too.
    asked = np.array([0.0, 1.0, 2.5, 4.0, 2.0 * np.pi])
    points = 1.001 * np.column_stack([np.cos(asked), np.sin(asked)])
    place = np.zeros(len(points))
    least = np.concatenate([[0.0], 0.8 * np.diff(asked)])
    entry, leaving = np.zeros(len(points)), np.zeros(len(points), np.int64)
    near = np.full(len(points), 2e-3)
    rests, still = np.zeros(len(points), np.int8), np.zeros(len(line), np.int8)
    found = tube_places.match(
        line, way, points, near, least, rests, still, 0.0, 0.0, True, entry, leaving, place, np.zeros(1)
    )
    assert found == len(points)
    assert np.abs(np.interp(place, np.arange(len(way)), way) - asked).max() < 1e-3


def test_the_summary_counts_windows(tmp_path: Path) -> None:
    stream, summary = cncgen.plan_with_summary(cncgen.read_text(program("zigzag", 0.05)), machine())
    stream.collect()
    found = json.loads(json.dumps(summary.as_json()))
    assert found["tolerance_windows"] == 1
    assert found["tolerance_windows_kept"] == 0


def test_the_end_of_a_program_is_no_rest_before_it() -> None:
    """A circle of a diameter of P/2 after a rapid, where the plan rests: its start is within the tolerance of all of it.

    It counted as the end as well, and the circle took 0.087 s more than the rapid alone.
    """
    head = "(START, X0 Y0)\nG21 G90 G94 G17 G64 P0.2 F6000\nG0 X5\n"
    alone, _ = planned(head + "M30\n", machine())
    seconds, broken = planned(head + "G2 X5 Y0 I0 J0.05\nM30\n", machine())
    assert not broken
    assert seconds < 1.05 * alone


def test_rows_that_the_plan_passes_before_a_window_begins_are_all_looked_at() -> None:
    """Rows of 0.01 mm after a rapid that does not end at rest: windows begin five periods later, when many of them are over.

    Where that is on the rows was looked for on the first one alone, and the plan was kept: 0.339 s.
    """
    rows = [f"G1 X{5 + 0.01 * k:.3f} Y{0.002 * (k % 2):.3f}" for k in range(1, 201)]
    head = ["(START, X0 Y0)", "G21 G90 G94 G17 G64 P0.02 F6000", "G0 X5"]
    text = "\n".join([*head, *rows, "G1 X7 Y3", "M30", ""])
    along, _ = planned(text, machine(), options=cncgen.PlanOptions(effort="fast"))
    seconds, broken = planned(text, machine())
    assert not broken
    assert seconds < 0.97 * along


def test_a_dwell_behind_a_tiny_row_is_found_on_the_plan() -> None:
    """The plan leaves a row of 0.2 um in a room of 0.3 mm out, so its start is where the dwell is. All behind it was planned as before.

    Without the row it is the same motion but for those 0.2 um.
    """
    teeth = [
        (0.0, 0.0),
        (-0.0368, 0.0169),
        (-0.0288, -0.0228),
        (-0.0656, -0.0059),
        (-0.0576, -0.0456),
        (-0.0944, -0.0287),
    ]
    found = []
    for tiny in ([], [(-0.0943, -0.0285)]):
        x, y = [*teeth, *tiny][-1]
        after = [(x + 0.3 * k, y + 0.5 * (k % 2)) for k in range(1, 40)]
        before, behind = (
            [f"G1 X{x:.4f} Y{y:.4f}" for x, y in rows] for rows in ([(-0.2782, 1.3834), *teeth, *tiny], after)
        )
        text = "\n".join(
            ["G21 G90 G17 G64 P0.336 F6000", "G1 X-0.5 Y3", *before, "G4 P0.05", *behind, "M2", ""]
        )
        stream, summary = cncgen.plan_with_summary(
            cncgen.read_text(text), cncgen.load_machine("generic-mill")
        )
        stream.collect()
        found.append(summary.as_json())
    assert [each["tolerance_windows"] for each in found] == [2, 2]
    assert found[1]["motion_time_s"] == pytest.approx(found[0]["motion_time_s"], rel=1e-4)


def test_a_dwell_between_rows_of_a_tenth_of_a_micrometre_is_waited_for() -> None:
    """Such rows are one place on the plan, so the run behind the dwell began before it, and a motion without it stood in its place.

    Each of the turns of A takes 2 √(L/a) at least, beside both dwells.
    """
    rows = """
        G1 A-0.0342947
        G1 X0.0000000918 Y-0.0000000396
        G4 P0.05
        G1 X0.000027105 Y-0.0000116975 Z0.0000088264
        G1 A-2.5461847
        G1 A-2.5804794
        G4 P0.05
        G1 A-1.5089594
        M2
    """
    on = machine(174.819, 8688.08, 820787.0)
    axes = on.axes | {"A": Axis("A", *(np.radians(limit) for limit in (174.819, 8688.08, 820787.0)))}
    least = 0.1 + sum(2.0 * np.sqrt(way / 8688.08) for way in (0.0342947, 2.5461847, 1.07152))
    for effort in ("fast", "best"):
        text = "G21 G90 G17 G64 P0.1 F91299.2" + rows
        plan = cncgen.plan(cncgen.read_text(text), replace(on, axes=axes), effort=effort)
        assert sum(float(part.profile.t[-1] - part.profile.t[0]) for part in plan) >= least


def _windows(text: str, on: Machine) -> int:
    """Return how many windows are searched."""
    chunks, summary = cncgen.plan_with_summary(cncgen.read_text(text), on)
    for _ in chunks:
        pass
    return int(summary.as_json().get("tolerance_windows", 0))


def test_a_tip_that_setpoints_do_not_show_is_found_on_the_plan() -> None:
    # The plan passes the way of 2.5 nm in Z without a rest, and samples of it lie on either side: from there on no row was found.
    quick = replace(machine(5000.0, 3.8e7, 9.4e10), period_s=1.1e-4, chord_tolerance_mm=9.5e-4)
    head = ["G21 G90 G94 F6000 G61.1", "G1 Y3.8", "Z0.0000025", "X0.01 Y3.81"]
    assert _windows("\n".join([*head, "G64 P0.05", "X2 Y1", "X4 Y0", "X6 Y1", "M2", ""]), quick) > 0


def test_a_short_row_before_an_exact_one_may_lose_most_of_its_length_at_its_start() -> None:
    # The plan cuts the sharp corner off by P, and meets the start of the exact row within nothing: the row between is as long as P.
    rows = [
        "G64 P0.04",
        "G1 X5 Y0",
        "X4.974 Y0.029",
        "G61",
        "X5.889 Y1.808",
        "G64 P0.04",
        "X0 Y4",
        "X4 Y8",
        "X0 Y10",
    ]
    assert _windows("\n".join(["G21 G90 G94 F6000", *rows, "M2", ""]), machine()) > 0


def test_runs_from_rest_to_rest_are_searched_before_their_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 40 pockets, with rapids between them, all but the first ones are; the motion is that of searches in turn."""
    mill = cncgen.load_machine("generic-mill")
    rows = ["G0 Z5"]
    for k in range(40):
        rows += [f"G0 X{20 * k} Y0", "G1 Z-2"]
        for n in range(1, 5):
            a, x = 2.0 * n, 20.0 * k
            rows += [f"G1 X{x + a} Y{-a}", f"G1 X{x + a} Y{a}", f"G1 X{x - a} Y{a}", f"G1 X{x - a} Y{-a}"]
        rows += ["G0 Z5"]
    text = "\n".join(["(START, X0 Y0 Z5)", "G21 G17 G90 G94 G64 P0.01", "F6000", *rows, "M2"])
    begun, begin = [], WindowSearch.begin
    monkeypatch.setattr(WindowSearch, "begin", lambda *given: begun.append(1) or begin(*given))
    time, faults = planned(text, mill)
    assert len(begun) >= 3 * 36
    assert not faults
    monkeypatch.setattr(WindowSearch, "begin", lambda *given: None)
    assert planned(text, mill)[0] == pytest.approx(time, rel=1e-4)


@pytest.mark.parametrize("effort", ["fast", "best"])
def test_rapids_are_rounded_as_feeds_at_the_velocity_of_the_axes(effort: str) -> None:
    """Lines along single axes: the velocity of an axis is the speed. Under G61 the same rows rest in each corner."""
    on, ways = machine(), ["Z20", "X20", "Z10", "X40", "Y15"]
    times = [
        planned(
            "\n".join([f"G21 G90 G17 {mode} F{60 * V}", *(word + way for way in ways), "M2", ""]),
            on,
            effort=effort,
        )
        for mode, word in (("G64 P0.05", "G0 "), ("G64 P0.05", "G1 "), ("G61", "G0 "))
    ]
    assert not any(broken for _, broken in times)
    rapid, feed, exact = (seconds for seconds, _ in times)
    assert rapid == pytest.approx(feed, rel=1e-4)
    assert rapid < 0.95 * exact


@pytest.mark.parametrize("effort", ["fast", "best"])
def test_cuts_begin_and_end_where_they_are_programmed_whatever_the_rapids_do(effort: str) -> None:
    """Rapids to a hole and away from it are rounded by P, 0.2 mm; the hole is as deep as programmed, and straight.

    A setpoint comes within the chord tolerance of the tip, as the motion turns back there (docs/corners.md, Turning back).
    """
    hole = "(START, Z20)\nG21 G90 G17 G64 P0.2 F300\nG0 X10\nG0 Z2\nG1 Z-6\nG0 Z20\nG0 X20\nM2\n"
    plan = cncgen.plan(cncgen.read_text(hole), machine(), effort=effort)
    chunk = cncgen.sample(plan, "line").collect()
    x, z = (chunk.position[:, chunk.axes.index(letter)] for letter in "XZ")
    assert -6.0 <= z.min() <= -6.0 + machine().chord_tolerance_mm
    cut = chunk.signals["line"] == 5
    assert np.abs(x[cut] - 10.0).max() < 1e-9
    assert np.hypot(x - 10.0, z - 20.0).min() > 0.05


def test_holes_have_no_room_and_no_windows() -> None:
    """One line along one axis has no room (docs/tube.md). Where a run ends, the tangent is by rounding that of the rapid after it."""
    holes = [f"G61 G0 X{4 * (k % 100)} Y{4 * (k // 100)} Z2\nG64 P0.01 G1 Z-6\nG61 G0 Z2" for k in range(120)]
    text = "\n".join(["G21 G90 G17 F6000", *holes, "M2", ""])
    stream, summary = cncgen.plan_with_summary(cncgen.read_text(text), cncgen.load_machine("generic-mill"))
    stream.collect()
    assert "tolerance_windows" not in summary.as_json()


@pytest.mark.parametrize(("radius", "tolerance"), [(0.042, 0.0294), (0.1, 0.1), (0.3, 0.2)])
def test_a_circle_hardly_larger_than_the_tolerance_takes_no_longer_than_its_chords(
    radius: float, tolerance: float
) -> None:
    """Five circles, a short line after each. Planes across the circle meet within the tolerance: they took 7.8 to 13.9 % longer."""
    chords = int(np.ceil(2.0 * np.pi / np.sqrt(8.0 * 0.003 * tolerance / radius)))
    turn = np.pi - np.linspace(0.0, 2.0 * np.pi, chords + 1)[1:]
    circle = radius * (1.0 + np.cos(turn)), radius * np.sin(turn)
    programs = []
    for lines in (False, True):
        rows = ["G21 G17 G90 G94", f"G64 P{tolerance} F6000", "G1 X0.5"]
        for x, y in ((0.5 + 0.02 * k, 0.02 * k) for k in range(5)):
            polygon = [f"G1 X{x + u:.9f} Y{y + v:.9f}" for u, v in zip(*circle, strict=True)]
            rows += [*(polygon if lines else [f"G2 I{radius} J0"]), f"G1 X{x + 0.02:.2f} Y{y + 0.02:.2f}"]
        programs.append("\n".join([*rows, "G1 X1.1", "M2", ""]))
    (time, faults), (along_lines, _) = (planned(text, machine()) for text in programs)
    assert not faults
    assert time <= 1.002 * along_lines


def test_a_window_that_begins_and_ends_at_feed_is_solved() -> None:
    """Half circles of R0.5 at 6 mm/s, whose first windows end at the feed: held between nodes, they once had no solution."""
    rows = [f"G{2 + k % 2} X{k + 1} Y0 I0.5 J0" for k in range(40)]
    text = "\n".join(["G21 G90 G17 G64 P0.005 F360", *rows, "M2", ""])
    stream, summary = cncgen.plan_with_summary(cncgen.read_text(text), machine(10.0, 400.0, 4e5))
    stream.collect()
    found = summary.as_json()
    assert found["tolerance_windows"] >= 3
    assert found["tolerance_windows_kept"] == 0


def test_rows_in_inverse_time_end_a_run_that_is_planned_in_windows() -> None:
    """Corners of G93 leave their rows by P too; they were not found on the plan, and the motion jumped back to that: no plan."""
    rows = polyline([(2 * i, 1.5 * (i % 2)) for i in range(60)])
    slow = ["G93 G1 X125 Y0 F60", "X125 Y6 F60", "X120 Y7 F60", "G94 G1 X110 Y3 F6000", "X100 Y9"]
    text = "\n".join(["G21 G90 G94 G17 G64 P0.05 F6000", *rows, *slow, "M2", ""])
    best, broken = planned(text, machine())
    assert not broken
    assert best < planned(text, machine(), effort="fast")[0]


def test_rows_in_inverse_time_are_planned_within_their_tolerance() -> None:
    """The same zigzag by G93, whose F is the feed over the length of a row, 2.5 mm: the same optimum (once 1.25 times that)."""
    rows = [f"{row} F{6000 / 2.5:.9f}" for row in polyline([(2 * i, 1.5 * (i % 2)) for i in range(9)])]
    seconds, broken = planned("\n".join(["G21 G90 G17 G64 P0.05 G93", *rows, "M30", ""]), machine())
    assert not broken
    assert 0.998 < seconds / OPTIMA["zigzag"][1] < 1.01


def test_a_window_that_begins_beside_a_turn_back_starts_from_the_setpoint_before_it() -> None:
    """No setpoint fell at the tip in X-0.2: the chord over it, of 20 ms, was 6 times the tolerance away, as `cncgen.judge` sees."""
    rows = [
        "G1 X0.017483 Y-0.147321",
        "X0 Y0",
        "X-0.203482 Y-0.01487",
        "X0 Y0",
        "X0.203482 Y0.01487",
        "X0 Y0",
        "X0.170921 Y-0.463058",
        "X0 Y0",
        "X-0.028675 Y-0.587936",
    ]
    axes = {"X": Axis("X", 20.9, 883.0, 21_200.0), "Y": Axis("Y", 6320.0, 263_000.0, 3.79e7)}
    on = Machine("coarse", axes, 0.02, 1e-3, 0.01)
    _, broken = planned("\n".join(["G21 G17 G90 G64 P0.001 F50", *rows, "M2", ""]), on)
    assert not broken


def test_a_tolerance_below_that_of_chords_is_kept() -> None:
    """Of 90 nm, beside 1 µm for chords: once the motion was 3 nm over on the arc of this program."""
    text = "\n".join(
        [
            "G21 G90 G17 G64 P0.00009 F548.8",
            "G1 X0.0003 Y0.0391",
            "X-0.0376 Y-0.0198",
            "G0 X0.0585 Y-0.0317",
            "G1 X0.0536 Y-0.0046",
            "X0.0252 Y-0.0397",
            "G91 G2 X0.066 Y0 I0.033 J0",
            "M2",
            "",
        ]
    )
    program, slow = cncgen.read_text(text), machine(7.0, 100.0, 2e4)
    verdict = cncgen.judge(cncgen.sample(cncgen.plan(program, slow)), cncgen.read_text(text), slow)
    assert len(verdict.breaches) == 0
    # Of the motion; chords of this period add less than 0.1 µm.
    assert verdict.setpoints_to_path_mm < 2e-4


#: Of an examiner that shares nothing with the planner: limits of each axis, period, chord and path tolerance, and the program.
OUT_OF_ORDER = {
    # A row was left for one ahead, and taken again behind it: 0.19 mm off in order.
    "hook": (
        {"X": (90.0, 10060.0, 2.424e7), "Y": (87.21, 9746.0, 2.349e7), "A": (161.6, 18060.0, 4.354e7)},
        (9.2e-5, 2.32e-5, 0.0772),
        """G20 G17 G90 G94 G64 F107.58
G1 X-0.1138 Y0.0265 A-0.0840
X-0.1141 Y0.0263 A-0.0841
X-0.1144 Y0.0261 A-0.0842
X-0.1147 Y0.0259 A-0.0843
X-0.1150 Y0.0257 A-0.0844
X-0.1153 Y0.0255 A-0.0845
X-0.1156 Y0.0253 A-0.0846
X-0.1159 Y0.0251 A-0.0847
X-0.1162 Y0.0249 A-0.0848
X-0.1165 Y0.0247 A-0.0849
X-0.1168 Y0.0245 A-0.0850
X-0.1171 Y0.0243 A-0.0851
X-0.1174 Y0.0241 A-0.0852
X-0.1177 Y0.0239 A-0.0853
X-0.1180 Y0.0237 A-0.0854
X-0.1183 Y0.0235 A-0.0855
G91 G2 X-0.020117679 Y0.010520339 A0.00820757 R0.012941433 F10.18
G1 X-0.0044 Y-0.0031 A-0.0026
G90 X-0.1183 Y0.0235 A-0.0855
M2
""",
    ),
    # Rows that fold within P: a stretch of the plan that was kept was taken for a later row.
    "fold": (
        dict.fromkeys("XYZ", (184.725, 3594.9, 888522.0)),
        (0.004, 0.0001, 0.01),
        """G21 G90 G17 G94 G64 P0.2314 F2849
G3 R0.1351 X0.0549 Y0.0920
G1 X-0.1512 Y-0.2530
G1 X0.5077 Y0.8498 Z1.351
G1 X0.4231 Y0.6905
G1 X0.5674 Y0.6066 Z-1.314
G1 X0.4148 Y0.6950
G1 X0.1411 Y0.5976 Z0.334
G1 X1.4690 Y1.0670
M2
""",
    ),
    # Several bends within a period: 5 nm over 135 nm beside the middles of chords.
    "bends": (
        {"X": (0.6, 200.0, 7e4), "Y": (20.0, 6000.0, 2e6), "Z": (0.06, 20.0, 7000.0), "A": (0.7, 200.0, 8e4)},
        (0.0025, 1.41e-5, 0.000135),
        """G21 G17 G90 G94
G1 X0.0019 Y0.0031 A-0.0048 F58
G64 P0.090216925
X0.00207 Y0.00268 Z0.00022 A-0.00505 F180000
X0.00223 Y0.00228 Z0.00044 A-0.00532
X0.00236 Y0.00191 Z0.00065 A-0.00564
X0.002395 Y0.00165 Z0.00082 A-0.0061
M2
""",
    ),
}


def quick(limits: dict[str, Sequence[float]], period: float, chord: float, path: float) -> Machine:
    lines = [
        "name = 'quick'",
        f"period_s = {period}",
        f"chord_tolerance_mm = {chord}",
        f"path_tolerance_mm = {path}",
    ]
    for letter, values in limits.items():
        unit = "deg" if letter == "A" else "mm"
        lines.append(f"[axes.{letter.lower()}]")
        for key, value in zip(("velocity", "acceleration", "jerk"), values, strict=True):
            power = {"velocity": "s", "acceleration": "s2", "jerk": "s3"}[key]
            lines.append(f"max_{key}_{unit}_{power} = {value!r}")
    return machine_from_toml("\n".join(lines).encode(), "quick")


@pytest.mark.parametrize("name", OUT_OF_ORDER)
def test_the_order_of_rows_is_kept(name: str) -> None:
    limits, given, text = OUT_OF_ORDER[name]
    on = quick(limits, *given)
    verdict = cncgen.judge(cncgen.sample(cncgen.plan(cncgen.read_text(text), on)), cncgen.read_text(text), on)
    assert [fault.message for fault in verdict.breaches] == []


def test_the_last_setpoint_is_the_end_of_the_program() -> None:
    """Nodes are met within the resolution of setpoints, and the end once was 0.01 nm beside the last one."""
    limits = {"X": (84.65, 29150.0, 8.407e8), "Y": (92.61, 31890.0, 9.198e8), "Z": (163.3, 56240.0, 1.622e9)}
    text = """G21 G17 G90 G94
G64
G17 G5 X-0.1733223 Y-0.2770875 I0.0125980 J0.1331937 P-0.0501236 Q0.1958049 F7803.8299861
G1 X-0.1733223 Y-0.2770875 Z0.0000000 F6893.2912565
M2
"""
    on = quick(limits, 7.9e-5, 0.001, 0.314)
    x = cncgen.sample(cncgen.plan(cncgen.read_text(text), on)).collect().position
    np.testing.assert_allclose(x[-1, :2], [-0.1733223, -0.2770875], rtol=0, atol=1e-12)


def test_a_machine_without_the_axes_of_a_program_that_does_not_move() -> None:
    """There is no limit to take the distance of nodes from."""
    on = quick({"U": (218.7, 12060.0, 8.915e6)}, 1.7e-4, 1e-5, 0.105)
    assert (
        len(cncgen.sample(cncgen.plan(cncgen.read_text("G21 G90 G94\nG61\nM2\n"), on)).collect().position)
        == 1
    )


def test_parts_that_are_searched_again_are_those_of_the_whole_window(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rounds from the third one on change little: the same motion, whether all of the window is searched or the parts beside the change."""
    rng = np.random.default_rng(96)
    angle = np.cumsum(rng.normal(0.0, 0.4, 3000))
    points = np.cumsum(0.2 * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis=0)
    text = "G21 G90 G94 F6000\nG64 P0.01\n" + "\n".join(polyline([(0.0, 0.0), *points])) + "\nM2\n"
    searched: list[list[tuple[int, int]]] = []
    narrower = Search.narrower

    def seen(self: Search, *given: object) -> Solved:
        searched.append(given[2])  # type: ignore[arg-type]
        return narrower(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(Search, "narrower", seen)

    def seconds() -> float:
        searched.clear()
        setpoints, summary = cncgen.plan_with_summary(cncgen.read_text(text), machine())
        setpoints.collect()
        return float(summary.as_json()["motion_time_s"])

    by_parts = seconds()
    assert any(len(parts) > 1 or parts[0][0] > 0 for parts in searched)
    monkeypatch.setattr(window_rounds, "_MOSTLY", 0.0)
    assert by_parts == pytest.approx(seconds(), rel=2e-4)
    assert all(len(parts) == 1 and parts[0][0] == 0 for parts in searched)


@pytest.mark.parametrize(
    ("row", "searches"),
    [("G3 X10 Y0 I0 J-5", 1), ("G1 X10 Y0.2", 2)],
    ids=["a closed contour ends in its corner", "two corners two tolerances apart"],
)
def test_only_windows_with_corners_side_by_side_are_searched_twice(
    monkeypatch: pytest.MonkeyPatch, row: str, searches: int
) -> None:
    """Near corners have many local optima; those of a contour that ends where it began are all of it apart."""
    rounds: list[Rounds] = []
    begin = Rounds.__init__

    def begun(self: Rounds, *given: object) -> None:
        rounds.append(self)
        begin(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(Rounds, "__init__", begun)
    text = f"G21 G90 G94 F6000\nG64 P0.1\nG1 X10 Y0\n{row}\nG1 X0 Y10\nM2\n"
    cncgen.plan_with_summary(cncgen.read_text(text), machine())[0].collect()
    assert len(rounds) == searches


def test_a_window_without_a_motion_is_searched_a_second_time_whatever_that_took(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Lines of a program, each cut in two, took 9 % longer than whole, as the search of a window with near corners found nothing."""
    to_end = Rounds.to_end
    monkeypatch.setattr(window_search, "_CHEAP", -1.0)
    monkeypatch.setattr(
        Rounds,
        "to_end",
        lambda self, *given: self.tangent is self.window.nodes.looser and to_end(self, *given),
    )
    text = "G21 G90 G94 F6000\nG64 P0.1\nG1 X10 Y0\nG1 X10 Y0.2\nG1 X0 Y10\nM2\n"
    along, _ = planned(text, machine(), options=cncgen.PlanOptions(effort="fast"))
    seconds, broken = planned(text, machine())
    assert not broken
    assert seconds < 0.99 * along


def test_a_curve_of_one_place_has_no_chords() -> None:
    """It is no motion: the line behind it takes as long as without it."""
    curve = "G6.2 P2 K0 X0 Y0 R1\nK0 X0 Y0 R1\nK1\nK1\n"
    times = []
    for before in (curve, ""):
        text = f"G21 G90 G64 P0.01 F2000\n{before}G1 X-1 Y1\nM2\n"
        *_, last = cncgen.plan(cncgen.read_text(text), "generic-mill")
        times.append(float(last.profile.t[-1]))
    assert times[0] == pytest.approx(times[1], rel=1e-9)
