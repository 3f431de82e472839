"""Spacing of the nodes: graded, measured, inverted; blocks of rows."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

from cncgen.diagnostics import NoPlanError
from cncgen.kernels import node_places
from cncgen.machine import load
from cncgen.machine.record import Axis, Machine
from cncgen.pipeline import plan as plan_program
from cncgen.pipeline import read_text, sample
from cncgen.planner import PlanOptions, plan
from cncgen.planner.least_time import mesh, mesh_spacing
from cncgen.planner.least_time.block_planning import blocks
from cncgen.planner.least_time.breakpoints import PathBlock, breakpoints_of
from cncgen.planner.least_time.mesh import mesh_of
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.motion import motion_at
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind
from cncgen.toolpath.slicing import between, join
from tests.planner.judging import used
from tests.planner.smoothing.programs import chunked, facets


@given(st.floats(-0.9, 5.0), st.floats(1e-9, 1e3))
def test_the_measure_is_the_integral_of_one_over_the_spacing(growth: float, h: float) -> None:
    expected, _ = quad(lambda x: 1.0 / (h + growth * x), 0.0, h)
    got = node_places.slope_log(growth, 1.0)
    assert got == pytest.approx(expected, rel=1e-6)
    assert node_places.slope_exp(growth, got) == pytest.approx(1.0, rel=1e-9)


def test_nodes_grow_from_a_tiny_interval_without_more_than_its_logarithm() -> None:
    s, spacing = np.array([0.0, 1e-7, 1.0]), np.array([1e-9, 2e-8, 0.2])
    found = mesh_spacing.spread_nodes(s, spacing, s[[0, 2]], np.zeros(1, bool))
    steps = np.diff(found)
    assert found[0] == 0.0
    assert found[-1] == 1.0
    assert len(found) < 150
    assert np.all(steps > 0)
    # Each step is the spacing where it stands, at most: that of its right end, which is larger.
    assert np.all(steps <= np.interp(found[1:], s, spacing) * (1 + 1e-6))


@given(st.integers(0, 2**32 - 1))
def test_graded_spacing_grows_no_faster_and_is_never_larger(seed: int) -> None:
    random = np.random.default_rng(seed)
    s = np.sort(random.uniform(0, 10, 50))
    spacing = 10 ** random.uniform(-4, 1, 50)
    growth = float(random.choice([0.1, 0.2]))
    fine, out = mesh_spacing.graded(s, spacing, growth)
    assert np.all(np.isin(s, fine))
    grown = growth * fine
    assert np.all(np.abs(np.diff(out)) <= np.diff(grown) + 1e-12)
    # The largest such spacing: lower somewhere only because of another place.
    here = grown[np.searchsorted(fine, s)]
    reached = (spacing[None, :] + np.abs(here[:, None] - here[None, :])).min(axis=1)
    np.testing.assert_allclose(out[np.searchsorted(fine, s)], reached, rtol=1e-9, atol=1e-12)


def test_spacing_grows_back_from_a_place_that_is_fine_for_the_sake_of_the_next() -> None:
    """Fine at the last of two near places: the way back to the coarse one is graded too (once linear over all of it)."""
    s, spacing = np.array([0.0, 10.0, 10.0 + 1e-8]), np.array([0.01, 0.01, 1e-9])
    fine, out = mesh_spacing.graded(s, spacing, 0.2)
    assert np.interp(10.0 - 0.05, fine, out) == pytest.approx(0.01, rel=1e-6)
    assert len(mesh_spacing.spread_nodes(fine, out, s[[0, 2]], np.zeros(1, bool))) < 1200


@given(st.integers(0, 2**32 - 1))
def test_derivatives_at_the_quarter_points_are_compared_with_the_parabola(seed: int) -> None:
    """Lagrange's parabola through three values, by numpy; at a cusp, where one of them is no number, there is nothing to compare."""
    random = np.random.default_rng(seed)
    s = np.cumsum(random.uniform(0.01, 1.0, 9))
    x, seen = random.normal(size=(4, 8, 3, 2)), random.normal(scale=5.0, size=(4, 8, 4, 2))
    top, acceleration = random.uniform(0.1, 10.0, (8, 3)), random.uniform(1.0, 9.0, 2)
    spline = random.integers(0, 2, 8).astype(np.int8)
    seen[2:, 4, 3, 0] = np.nan
    found, lost = np.empty((8, 2)), np.empty(8)
    node_places.concealed(s, spline, x, seen, top, acceleration, 0.3, 2.5, found, lost)
    for n in np.flatnonzero(spline):
        bulge = np.empty(2)
        for axis in range(2):
            there = seen[:, n, 1::2, axis]
            second, third = (np.polyfit([0.0, 0.5, 1.0], x[order, n, :, axis], 2) for order in (2, 3))
            believed = 0.3 / (s[n + 1] - s[n]) ** 2
            apart = np.abs(np.clip(there[3], -believed, believed) - np.polyval(third, [0.25, 0.75])).max()
            assert found[n, axis] == pytest.approx(2.5 * np.nan_to_num(apart, nan=0.0), rel=1e-9, abs=1e-12)
            bulge[axis] = np.nan_to_num(np.abs(there[2] - np.polyval(second, [0.25, 0.75])).max(), nan=0.0)
        q = min(top[n].max(), (acceleration / np.abs(x[2, n]).max(axis=0)).min())
        assert lost[n] == pytest.approx((bulge * q / acceleration).max(), rel=1e-9)
    assert not found[spline == 0].any()
    assert not lost[spline == 0].any()


@pytest.mark.parametrize("rows", [(1000, 6000), (6000, 1000), (6000, 5800)])
def test_a_step_of_the_feed_amid_a_line_takes_a_ramp(rows: tuple[int, int]) -> None:
    """Full jerk leads from one feed to the other, Δv/A + A/J or 2 √(Δv/J) long at their mean, on the slower row's far side."""
    first, second = rows
    text = f"G21 G90 G61 G1 X500 F{first}\nX1000 F{second}\nM2\n"
    mill = load("generic-mill")
    (*_, last) = plan(read_text(text).chunks(), mill, PlanOptions())
    axis, v = mill.axes["X"], np.array(rows) / 60.0

    def ramp(change: float) -> float:
        a, j = axis.max_acceleration, axis.max_jerk
        return change / a + a / j if change > a * a / j else 2.0 * float(np.sqrt(change / j))

    change = abs(v[1] - v[0])
    # The ramp lies on the faster row, as no row may be faster than its feed.
    way = ramp(change) * v.mean()
    ends = sum(0.5 * ramp(each) for each in v)
    length = np.array([500.0, 500.0])
    length[int(v.argmax())] -= way
    expected = float((length / v).sum()) + ramp(change) + ends
    assert last.profile.t[-1] == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("jerk", [2.5e7, 1e9])
def test_setpoints_more_often_need_no_more_nodes_where_jerk_hardly_counts(jerk: float) -> None:
    """Half a period apart they were 20,000 at 0.05 ms, of which A/J is two or a twentieth; the limits hold with fewer."""
    text = "G21 G90 G61 F30000\nG1 X45\nG3 X50 Y5 I0 J5\nG1 Y45\nG3 X45 Y50 I-5\nG1 X0\nM2\n"
    axes = MappingProxyType({a: Axis(a, 250.0, 2500.0, jerk) for a in "XYZ"})
    plans = [
        list(plan(read_text(text).chunks(), replace(Machine("stiff", axes), period_s=period), PlanOptions()))
        for period in (1e-3, 5e-5)
    ]
    counts = [sum(len(part.profile.v) for part in parts) for parts in plans]
    assert counts[1] <= 1.5 * counts[0]
    (part,) = plans[1]
    t = 5e-5 * (np.arange(-3, int(part.profile.t[-1] / 5e-5) + 4) + 0.3)
    s = motion_at(part.profile, np.clip(t, 0.0, part.profile.t[-1])).s
    x = part.toolpath.path.evaluate(s, 0)[0]
    for order, limit in ((1, 250.0), (2, 2500.0), (3, jerk)):
        assert np.abs(np.diff(x, order, axis=0)).max() / 5e-5**order <= 1.001 * limit + 1e-12 / 5e-5**order


@pytest.mark.parametrize("size", [1, 7, 100, 1000])
def test_blocks_do_not_depend_on_chunks(size: int) -> None:
    rows = facets(250)
    made = list(blocks(chunked(rows, size), 4 * 16, 4 * 54))
    assert [len(block) for block in made] == [16, 24, 36, 54, 54, 54, 12]
    np.testing.assert_array_equal(join(made).end, rows.end)
    np.testing.assert_array_equal(made[1].start, rows.end[15])


@pytest.mark.parametrize("size", [1, 2, 100])
def test_a_block_has_the_work_of_its_rows_and_not_their_number(size: int) -> None:
    """Control points: a straight line counts as 4, a NURBS of nine as nine."""
    curve = "\n".join(["G5.2 X0.5 Y1 P1 L3", *(f"X{0.5 + k} Y{k % 2} P1" for k in range(1, 8)), "G5.3"])
    text = f"G21 G90 G61 F600\nG1 X0.5\n{curve}\nG1 X10 Y0\nX11 Y1\nX12 Y0\nM2\n"
    rows = join(list(read_text(text, options=ReadOptions(dialect="linuxcnc")).chunks()))
    assert [int(kind) for kind in rows.kind[:5]] == [Kind.LINE, Kind.NURBS, *[Kind.LINE] * 3]
    counts = [4] * len(rows)
    counts[1] = len(rows.nurbs.control_points)
    assert counts[1] > 8
    parts = (between(rows, k, min(k + size, len(rows))) for k in range(0, len(rows), size))
    made = [len(block) for block in blocks(parts, 8, 8)]
    expected, held = [0], 0
    for count in counts:
        expected[-1] += 1
        held += count
        if held >= 8:
            expected.append(0)
            held = 0
    assert made == [n for n in expected if n]


def test_more_nodes_than_memory_is_meant_for_are_refused_with_their_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = read_text("G21 G17 G90 G61 F600\nG1 X1\nG2 X1 Y0 I10 J0\nG1 X0\nM2\n")
    for module in (mesh_spacing, mesh):
        monkeypatch.setattr(module, "MOST", 50)
    with pytest.raises(NoPlanError) as told:
        list(plan(program.chunks(), load("generic-mill"), PlanOptions()))
    (fault,) = told.value.diagnostics
    assert fault.code == "too-many-nodes"
    assert fault.span is not None
    assert fault.span.line == 3
    assert fault.values["nodes"] > 50
    assert "More memory makes no room" in fault.hint


def test_more_nodes_than_the_run_has_memory_for_are_refused_before_it_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Chords within 1e-9 mm of a curve ended in the message of a full memory, without a place."""
    program = read_text("G21 G17 G90 G61 F600\nG1 X1\nG2 X1 Y0 I10 J0\nG1 X0\nM2\n")
    monkeypatch.setattr(mesh_spacing, "_FEW", 50)
    monkeypatch.setattr(mesh_spacing, "room", lambda: 70.0 * mesh_spacing._BYTES)
    with pytest.raises(NoPlanError) as told:
        list(plan(program.chunks(), load("generic-mill"), PlanOptions()))
    (fault,) = told.value.diagnostics
    assert (fault.code, fault.span and fault.span.line) == ("too-many-nodes", 3)
    assert fault.values["most"] == 70
    assert "within 0.001 mm" in fault.hint
    assert "A larger --max-memory has room" in fault.hint


@pytest.mark.parametrize("far", [0.02, 0.05, 0.1])
def test_a_rest_near_a_slow_feed_is_reached_at_full_jerk(far: float) -> None:
    """From 2 mm/s to v and to rest in so many mm, at full jerk, (v + 2) √((v − 2)/J) + v √(v/J) of way, is a plan.

    A single interval of constant jerk, sized for the feed of the last line, which it cannot reach, took 1.6 to 3 ms longer.
    """
    axes = {letter: Axis(letter, 100.0, 1e4, 1e6) for letter in "XY"}
    machine = Machine("quick", MappingProxyType(axes), 1e-3, 1e-3, 0.01)
    slow, jerk = 2.0, 0.9993e6
    top = brentq(lambda v: (v + slow) * np.sqrt((v - slow) / jerk) + v * np.sqrt(v / jerk) - far, slow, 100.0)
    start = 2.0 * np.sqrt(slow / jerk)
    known = start + 5.0 / slow - 0.5 * start + 2.0 * np.sqrt((top - slow) / jerk) + 2.0 * np.sqrt(top / jerk)
    *_, last = plan_program(read_text(f"G21 G90 G61\nG1 X5 F120\nX{5.0 + far} F6000\nM2\n"), machine)
    assert last.profile.t[-1] <= known


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("b", [0.1, 0.03, 0.01])
def test_a_rest_near_a_bend_is_reached_at_full_jerk(b: float, back: bool) -> None:
    """A C² curve whose last span is straight: from v₀ where that begins to v and to rest, as in the test above, is a plan.

    A single interval of constant jerk, sized for the way to the next breakpoint, took 4.8 to 10 ms longer.
    """
    machine = Machine(
        "table", {letter: Axis(letter, 250.0, 2450.0, 5e4) for letter in "XY"}, 1e-3, 1e-3, 0.01
    )
    points = np.array([(0, 0), (5, 0), (10 - b, 0), (10, 0), (10, b), (10, 2 * b), (10, 4 * b)])
    points = points[::-1] - points[-1] if back else points
    knots = [0, 0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1, 1]
    first, *rest = [f"K{knot} X{x} Y{y} R1" for knot, (x, y) in zip(knots, points.tolist(), strict=False)]
    curve = "\n".join([f"G6.2 P4 {first} F60000", *rest, *["K1"] * 4])
    (part,) = plan_program(read_text(f"G21 G90 G94 G61\n{curve}\nM2\n"), machine)
    motion = part.profile
    # The span begins at 13/12 b, a mean of b and 2 b.
    way, jerk = 4 * b - 13 / 12 * b, 0.9993 * 5e4
    place = way if back else motion.s[-1] - way
    there = brentq(lambda t: motion_at(motion, np.array([t])).s[0] - place, 0.0, motion.t[-1])
    took, slow = there if back else motion.t[-1] - there, motion_at(motion, np.array([there])).v[0]
    top = brentq(lambda v: (v + slow) * np.sqrt((v - slow) / jerk) + v * np.sqrt(v / jerk) - way, slow, 100.0)
    assert took <= 2.0 * np.sqrt((top - slow) / jerk) + 2.0 * np.sqrt(top / jerk)


#: Near-cusps: points, weights, and by their size and the period the limits of jerk, acceleration and chords.
CUSPS = (
    ([(0.0, 0.0), (1.0, 0.0), (0.22, 0.037)], (1.0, 1.0, 1.0), (0.02, 0.1, 2e-3)),
    ([(0.0, 0.0), (1.0, 0.0), (0.64, 0.0031)], (1.0, 3.0, 1.0), (0.1, 1.0, 2.4e-4)),
    ([(0.0, 0.0), (1.0, 0.0), (0.998, -0.001), (0.19, 0.002)], (1.0, 1.0, 1.0, 1.0), (0.06, 0.3, 5e-3)),
)


@pytest.mark.parametrize(("points", "weights", "limits"), CUSPS)
def test_a_path_and_its_reverse_have_the_same_nodes(
    points: list[tuple[float, float]], weights: tuple[float, ...], limits: tuple[float, float, float]
) -> None:
    """Panels cut from the start on, and x''' looked at in the first three quarters of each, had given others: up to 12 % of time."""
    period = 1e-3
    jerk, acceleration, chord = limits
    axes = {letter: Axis(letter, 1e6, acceleration / period**2, jerk / period**3) for letter in "XYZ"}
    machine = Machine("quick", MappingProxyType(axes), period, chord, 0.01)
    found = []
    for step in (1, -1):
        way = np.array(points)[::step] - points[::step][0]
        rows = [f"K0 X{x:.12f} Y{y:.12f} R{r}" for (x, y), r in zip(way, weights[::step], strict=True)]
        end = "\n".join(["K1"] * len(rows))
        found.append(
            _nodes_of(
                f"G21 G90 G94 G61\nG6.2 P{len(rows)} F60000 " + "\n".join(rows) + f"\n{end}\nM2\n", machine
            )
        )
    np.testing.assert_allclose(found[0], found[0][-1] - found[1][::-1], rtol=0.0, atol=1e-6)


def test_a_curve_that_stands_at_its_end_has_as_many_nodes_as_its_reverse() -> None:
    """A cubic with a doubled last point, where its x''' is infinite, and a line that goes on in its direction.

    Once the infinite x''' was taken with the speed on the line: more than a million nodes, where the reverse has some hundred.
    """
    machine = load("xy-table")
    curve = np.array([(0, 0), (5, 8), (12, 10), (12, 10)])
    end = np.array([19, 12])
    found = []
    for points, before, after in ((curve, "", "G1 X19 Y12\n"), (end - curve[::-1], "G1 X7 Y2\n", "")):
        rows = "\n".join(f"K0 X{x} Y{y} R1" for x, y in points)
        text = f"G21 G90 G94 G61 F60000\n{before}G6.2 P4 {rows}" + "\nK1" * 4 + f"\n{after}M2\n"
        found.append(_nodes_of(text, machine))
    assert len(found[0]) < 2000
    np.testing.assert_allclose(found[0], found[0][-1] - found[1][::-1], rtol=0.0, atol=1e-3)


def _nodes_of(text: str, machine: Machine) -> NDArray[np.float64]:
    """Return where the nodes of a program of one block stand."""
    toolpath = join(list(read_text(text).chunks()))
    bounds = AxisLimits.of(machine, toolpath.axes)
    block = PathBlock.of(toolpath, None, bounds)
    points = breakpoints_of(block, bounds)
    points.rest[[0, -1]] = True
    return mesh_of(block, points, (None, None), bounds).s


def test_turns_of_one_arc_beside_a_weak_axis_keep_its_velocity() -> None:
    """Places that look at an arc of many turns alike missed where Y begins to go back: its velocity was passed by 13 %.

    Judged by differences; Y goes 4 r a turn, so that 7 turns take at least 42 s at 1 mm/s.
    """
    axes = {
        "X": Axis("X", 1000.0, 2e4, 1e6),
        "Y": Axis("Y", 1.0, 20.0, 1e3),
        "Z": Axis("Z", 250.0, 2e4, 1e6),
    }
    machine = Machine("weak", axes, period_s=0.001)
    program = read_text("G21 G90 G61 F8000\nG2 I1.5 P6\nG3 I-1.5 P1\nM2\n", "turns.nc")
    setpoints = sample(plan_program(program, machine)).collect()
    assert setpoints.axes == "XY"
    x = np.column_stack([setpoints.position, np.zeros(len(setpoints))])
    assert used(x, machine) <= 1.001
    assert 42.0 < setpoints.time_s[-1] < 42.0 * 1.02


@pytest.mark.parametrize(
    ("rows", "period"),
    [
        ("K0 X0 Y0 R1|K0 X5 Y5 R1000|K0 X10 Y0 R0.001|K1 X15 Y5 R1|K2 X20 Y0 R1|K3|K3|K3", 1e-4),
        ("K0 X0 Y0 R1|K0 X5 Y5 R1000|K0 X10 Y0 R0.001|K1 X15 Y5 R1|K2 X20 Y0 R1|K3|K3|K3", 2.5e-4),
        (
            "K0 X-8.251 Y-7.486 R1|K0 X-0.446 Y-2.5 R0.001|K0 X-7.934 Y2.426 R1000|K1 X0.235 Y2.376 R1000|"
            "K2 X-7.776 Y-9.174 R0.1|K3 X9.07 Y-8.86 R1|K4|K4|K4",
            1e-4,
        ),
    ],
)
def test_bends_beside_control_points_of_large_weight_keep_the_jerk(rows: str, period: float) -> None:
    """Derivatives were taken a little beside, where the bend is over: the jerk limit was passed by 25, 4 and 33 %.

    Judged by differences of setpoints.
    """
    machine = Machine("fine", {k: Axis(k, 250.0, 2500.0, 5e4) for k in "XYZ"}, period_s=period)
    start, curve = rows.split("|")[0].split(maxsplit=1)[1][:-3], rows.replace("|", "\n")
    program = read_text(f"G21 G90 G61 F6000\nG1 {start}\nG6.2 P3 {curve}\nM2\n", "weights.nc")
    setpoints = sample(plan_program(program, machine)).collect()
    assert setpoints.axes == "XY"
    x = np.column_stack([setpoints.position, np.zeros(len(setpoints))])
    assert used(x, machine) <= 1.001


@pytest.mark.parametrize(("x", "y"), [(0.0, 2e-7), (1e-7, 2e-7), (2e-7, 2e-7), (1e-6, 1e-6)])
@pytest.mark.parametrize("knots", [(0.25, 0.5, 0.75), (0.2, 0.4, 0.8), (0.4, 0.45, 0.5)])
def test_a_curve_that_turns_between_nearly_equal_points_stops_there(
    x: float, y: float, knots: tuple[float, float, float]
) -> None:
    """Two lines of 2 mm with a bend of 10⁻⁷ mm between: no node saw it, and acceleration was passed by up to 50 times (no plan).

    Each line takes A/J + √((A/J)² + 4 L/A) from rest to rest, and the rest waits for a setpoint at most.
    """
    places = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0 + x, y), (2.0, 1.0), (2.0, 2.0)]
    rows = [f"K{k:g} X{a:.7f} Y{b:.7f} R1" for k, (a, b) in zip((0, 0, 0, 0, *knots), places, strict=True)]
    text = "\n".join(["G21 G90 G61 F600", f"G6.2 P4 {rows[0]}", *rows[1:], *["K1"] * 4, "M2", ""])
    machine = Machine("slow", {k: Axis(k, 5.0, 2.0, 200.0) for k in "XYZ"}, period_s=0.01)
    for effort in ("fast", "best"):
        setpoints = sample(
            plan_program(read_text(text, "k.nc"), machine, PlanOptions(effort=effort))
        ).collect()
        ramp = 2.0 / 200.0
        least = 2.0 * (ramp + np.sqrt(ramp**2 + 4.0 * 2.0 / 2.0))
        assert setpoints.time_s[-1] == pytest.approx(least, abs=0.021)
        positions = np.column_stack([setpoints.position, np.zeros(len(setpoints))])
        assert used(positions, machine) <= 1.001


@pytest.mark.parametrize("radius", [0.3333, 0.4, 0.4333])
def test_a_velocity_that_an_arc_soon_needs_less_of_is_held_between_nodes(
    radius: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """|y'| v is V of a weak Y at most: where Y turns back on a circle, (V/y')² falls by half from node to node (once 1.0018 V)."""
    monkeypatch.setattr(mesh_spacing, "AMPLE", 0)
    axes = {"X": Axis("X", 2.5, 133.0, 3e4), "Y": Axis("Y", 0.4, 100.0, 3e4)}
    machine = Machine("weak", MappingProxyType(axes), 1e-3, 1e-3, 0.01)
    for each in plan_program(read_text(f"G21 G90 G61 F6000\nG3 X0 Y0 I{-radius} J0\nM2\n"), machine):
        profile = each.profile
        motion = motion_at(profile, np.linspace(profile.t[0], profile.t[-1], 50_001)[1:-1])
        slope = each.toolpath.path.evaluate(motion.s, 1)[1][:, each.toolpath.axes.index("Y")]
        assert (np.abs(slope) * motion.v).max() <= 0.4 * (1.0 + 5e-4)


@pytest.mark.parametrize("radius", [0.4, 0.5])
def test_a_velocity_that_takes_over_from_the_feed_within_an_interval_is_held_between_nodes(
    radius: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A weak Y holds 1 mm/s back from where |y'| is 0.4 on: the parabola through both bounds was 9·10⁻⁴ above V."""
    monkeypatch.setattr(mesh_spacing, "AMPLE", 0)
    monkeypatch.setattr(mesh_spacing, "_OF_RADIUS", 0.12)
    axes = {"X": Axis("X", 2.5, 133.0, 3e4), "Y": Axis("Y", 0.4, 100.0, 3e4)}
    machine = Machine("weak", MappingProxyType(axes), 1e-3, 1e-3, 0.01)
    for each in plan_program(read_text(f"G21 G90 G61 F60\nG3 X0 Y0 I{-radius} J0\nM2\n"), machine):
        profile = each.profile
        motion = motion_at(profile, np.linspace(profile.t[0], profile.t[-1], 50_001)[1:-1])
        slope = each.toolpath.path.evaluate(motion.s, 1)[1][:, each.toolpath.axes.index("Y")]
        assert (np.abs(slope) * motion.v).max() <= 0.4 * (1.0 + 5e-4)


#: A curve on X and A that goes back on its own way, smoothly.
TURNS_BACK = """G21 G90 G94 G61 F900
G0 X0.29 A-2
G6.2 P4 K0 X0.29 A-2 R1
K0 X0.63 A-1.4 R1
K0 X0.29 A-2 R1
K0 X0.63 A-1.4 R1
K0.58 X0.29 A-2 R1
K0.58 X1.58 A-2.17 R1
K1
K1
K1
K1
M2
"""


def test_intervals_that_hide_a_bend_are_halved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes of any density give the time of dense ones, within 0.5 %, and setpoints within the acceleration, by differences.

    Without halving, these took 0.1504 (4), 0.1558 (1) and 0.1741 s (1.7), and no plan was found for 1.3.
    """
    limits = {"X": (99.52, 3406.0, 2.875e6), "A": tuple(np.radians((175.6, 6009.0, 5.072e6)))}
    axes = {letter: Axis(letter, *values) for letter, values in limits.items()}
    machine = Machine("table", axes, 0.00059, 1e-3, 0.01)
    times = []
    for closest in (4.0, 1.0, 1.3, 1.7):
        monkeypatch.setattr(mesh_spacing, "CLOSEST", closest)
        motion = plan_program(read_text(TURNS_BACK), machine, effort="fast")
        out = sample(motion).collect()
        times.append(len(out.position) * out.period_s)
        bend = np.abs(np.diff(out.position, 2, axis=0)).max(axis=0) / out.period_s**2
        assert (bend <= 1.0005 * np.array([limits[letter][1] for letter in out.axes])).all()
    assert max(times) < 1.005 * min(times)


@pytest.mark.parametrize("width", [0.02, 0.01, 0.007, 0.005])
def test_an_axis_turns_back_on_a_narrow_tip_with_the_acceleration_that_it_has(width: float) -> None:
    """X goes 0.5 mm and back on a parabola whose tip has a radius of `width`²/4, 6 to 100 nm: nothing else limits the motion than its jerk.

    Closed form: from rest with jerk J for t, then −J for r t to velocity 0, r = 1 + √2, and all of it backwards; the way is
    J t³ (1/6 + r/2 + r²/2 − r³/6). Y takes next to nothing. Nodes by the radius, and no closer than the resolution, took up to
    11 % more.
    """
    ratio, way, jerk = 1.0 + np.sqrt(2.0), 0.5, 5e4
    part = 1.0 / 6.0 + ratio / 2.0 + ratio**2 / 2.0 - ratio**3 / 6.0
    least = 2.0 * (1.0 + ratio) * np.cbrt(way / (jerk * part))
    machine = Machine(
        "table", {letter: Axis(letter, 250.0, 2450.0, jerk) for letter in "XY"}, 0.001, 1e-3, 0.01
    )
    rows = f"K0 X0 Y0 R1\nK0 X1 Y0 R1\nK0 X0 Y{width} R1\nK1\nK1\nK1"
    text = f"G21 G90 G61 G0 X0 Y0\nG6.2 P3 F60000 {rows}\nM2\n"
    (motion,) = plan(read_text(text).chunks(), machine, PlanOptions())
    assert least < motion.profile.t[-1] < 1.0015 * least
