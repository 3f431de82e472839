"""Simulation of streams: closed forms, chunks, what is not linear, faults, the kernel beside its plain form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.cli.app import run as cncgen
from cncgen.diagnostics import UsageError
from cncgen.kernels import servo_contour, servo_loop
from cncgen.machine.record import Servo
from cncgen.servo import bank
from cncgen.servo.contour import AHEAD, contour_error
from cncgen.servo.simulate import own_scheme, simulate
from cncgen.servo.stream import driven
from cncgen.servo.summary import summarize
from cncgen.setpoints.record import Setpoints
from tests.kernels.plain import uncompiled

from .bench import circle, joined, profile, run, stream


def first_order(gain, **more):
    return Servo("first-order", {"position_gain_1_s": gain, **more})


def test_a_ramp_lags_by_speed_over_gain():
    """Type-1 loop: e = v/Kv + v T/2 where the setpoint is held over the period (Koren 1983, eq. 7.21 and its hold)."""
    speed, gain = 40.0, 50.0
    rows = np.arange(2000)[:, None] * 0.001 * speed
    response = run(rows, {"X": first_order(gain)}, axes="X")
    lag = (response.command - response.position)[-1, 0]
    assert lag == pytest.approx(speed / gain, rel=1e-9)


def test_a_circle_shrinks_by_its_frequency_response():
    """Equal first-order axes: radius R |G(e^jωT)|, with G = k/(z − 1 + k), k = Kv T."""
    radius, speed, gain = 10.0, 80.0, 60.0
    rows = circle(radius, speed, turns=4.0)
    servos = {"X": first_order(gain), "Y": first_order(gain)}
    response = run(rows, servos)
    z = np.exp(1j * speed / radius * 0.001)
    k = 1.0 - (1.0 - gain * 0.001)
    expected = radius * abs(k / (z - 1.0 + k))
    reached = np.hypot(*response.position[-500:].T)
    assert reached == pytest.approx(np.full(500, expected), abs=1e-7)
    sagitta = (speed * 0.001) ** 2 / (8 * radius)
    assert response.contour_error_mm[-500:] == pytest.approx(
        np.full(500, radius - expected), abs=1.01 * sagitta
    )


@pytest.mark.parametrize("name", ["xy-table", "die-bonder", "dyna-1007"])
@pytest.mark.parametrize("chunk", [1, 997, 10_000])
def test_chunks_change_nothing(name, chunk):
    rows = circle(8.0, 60.0, turns=3.0)[: 10_500 if chunk > 1 else 700]
    whole = run(rows, profile(name), chunk=20_000)
    parts = run(rows, profile(name), chunk=chunk)
    for field in ("position", "force", "saturated", "contour_error_mm"):
        assert np.array_equal(getattr(parts, field), getattr(whole, field))


def test_noise_is_the_seeds_whatever_the_chunks():
    rows = np.zeros((9000, 1))
    servos = {"X": first_order(50.0, noise_rms_mm=0.01, noise_seed=7)}
    one, other = run(rows, servos, axes="X"), run(rows, servos, axes="X", chunk=123)
    assert np.array_equal(one.position, other.position)
    again = run(rows, {"X": first_order(50.0, noise_rms_mm=0.01, noise_seed=8)}, axes="X")
    assert not np.array_equal(one.position, again.position)
    # x+ = (1 − k) x − k n with k = Kv T: variance σ² k/(2 − k).
    k = 0.05
    assert one.position[200:].std() == pytest.approx(0.01 * math.sqrt(k / (2 - k)), rel=0.1)


def test_the_drive_is_bounded_and_says_so():
    rows = np.array([[0.0]] * 5 + [[10.05]] * 400)
    response = run(rows, {"X": first_order(50.0, saturation_mm_s=100.0)}, axes="X")
    assert np.abs(response.force).max() == 100.0
    full = response.saturated[:, 0]
    # 50/s asks for more than 100 mm/s until the error is 2 mm: 8.05 mm at 100 mm/s are 81 periods from row 5.
    assert np.flatnonzero(full).tolist() == list(range(5, 86))
    assert response.position[85, 0] == pytest.approx(8.0)


def test_backlash_leaves_half_its_play_on_either_side():
    t = np.arange(8000) * 0.001
    rows = 5.0 * np.sin(2.0 * t)[:, None]
    play = 0.2
    exact, loose = (
        run(rows, {"X": first_order(80.0, backlash_mm=b)}, axes="X").position[:, 0] for b in (0.0, play)
    )
    following = [0.0]
    for motor in exact[1:]:
        following.append(min(max(following[-1], motor - play / 2), motor + play / 2))
    assert loose == pytest.approx(following, abs=1e-12)


def test_coulomb_friction_costs_the_stated_lag():
    """At constant speed the P loop needs Kv·lag more command: tracking error v/Kv + lag."""
    servos = {"X": first_order(70.0, coulomb_lag_mm=0.04, time_constant_s=0.004)}
    rows = np.arange(1500)[:, None] * 0.02
    response = run(rows, servos, axes="X")
    assert (response.command - response.position)[-1, 0] == pytest.approx(20.0 / 70.0 + 0.04, rel=1e-6)
    pure = run(rows, {"X": first_order(70.0, coulomb_lag_mm=0.04)}, axes="X")
    assert (pure.command - pure.position)[-1, 0] == pytest.approx(20.0 / 70.0 + 0.04, rel=1e-6)


def test_an_encoder_reads_whole_steps():
    """P on an integrator moves by Kv T times an error of whole steps."""
    rows = np.full((600, 1), 0.0)
    rows[10:] = 0.05
    response = run(rows, {"X": first_order(100.0, encoder_resolution_mm=0.01)}, axes="X")
    steps = np.diff(response.position[:, 0]) / (100.0 * 0.001)
    assert steps * 100.0 == pytest.approx(np.round(steps * 100.0), abs=1e-9)
    assert abs(response.position[-1, 0] - 0.05) <= 0.005 + 1e-12


def test_settling_holds_the_last_setpoint():
    rows = np.linspace(0.0, 10.0, 100)[:, None]
    response = run(rows, {"X": first_order(50.0)}, axes="X", settle_s=0.4)
    assert len(response) == 500
    assert response.position[-1, 0] == pytest.approx(10.0, abs=1e-6)


def test_setpoint_and_control_period_may_differ():
    """Two control periods a setpoint, with the setpoint half-way between: as if it had been given twice as often."""
    rows = circle(10.0, 50.0)[:800]
    fine = np.empty((2 * len(rows) - 1, 2))
    fine[::2], fine[1::2] = rows, 0.5 * (rows[1:] + rows[:-1])
    servos = {k: first_order(60.0, control_period_s=0.0005, time_constant_s=0.003) for k in "XY"}
    coarse = run(rows, servos)
    finer = run(fine, servos, period=0.0005)
    assert coarse.position == pytest.approx(finer.position[::2], abs=1e-12)


@pytest.mark.parametrize(
    "line",
    [
        "simulate {p} -o {d}/r.csv --reference {p}",
        "simulate {s} -o {d}/r.csv --reference {p}",
        "compensate {p} -o {d}/c.csv --perturb 0%",
        "compensate {s} -o {d}/c.csv --perturb 0%",
        "tune {p} --sets 2 --jobs 1 --no-bode -o {d}/t.toml",
        "report {p} -o {d}/r.html --reference {p}",
        "plot {p} --kinds errors -o {d}/e.png --reference {p} --axis-params xy-table",
    ],
)
def test_an_axis_that_stands_and_that_the_machine_lacks_is_left_out(tmp_path, line, capfd):
    """Programs of `convert --fit` name Z0, and the xy-table has no Z."""
    program, setpoints = tmp_path / "p.nc", tmp_path / "s.csv"
    program.write_text("G21 G90 F1200\nG0 X0 Y0 Z0\nG3 X-2 Y2 I-2 J0\nM2\n")
    assert cncgen(["plan", str(program), "-m", "xy-table", "-o", str(setpoints)]) == 0
    assert setpoints.read_text().startswith("t_s,x_mm,y_mm,z_mm\n")
    words = line.format(p=program, s=setpoints, d=tmp_path).split()
    assert cncgen([*words, "-m", "xy-table"]) == 0, capfd.readouterr().err


def test_an_axis_that_moves_without_servo_data_is_refused_where_it_moves():
    rows = np.zeros((30, 2))
    rows[20:, 1] = 0.001
    parts = driven(stream(rows, chunk=10), {"X"})
    assert [next(parts).axes, next(parts).axes] == ["X", "X"]
    with pytest.raises(UsageError, match="no servo data for axis Y; X has servo data"):
        next(parts)
    with pytest.raises(UsageError, match="servo-missing"):
        next(driven(stream(rows[:5]), {"Z"}))


def test_faults_are_diagnostics():
    rows = np.zeros((10, 2))
    with pytest.raises(UsageError, match="servo-missing"):
        run(rows, {"X": first_order(50.0)})
    with pytest.raises(UsageError, match="servo-period"):
        run(rows, {"X": first_order(50.0, control_period_s=0.0007), "Y": first_order(50.0)})
    with pytest.raises(UsageError, match=r"1e\+09 control periods of 1e-12 s"):
        run(rows, {"X": first_order(50.0, control_period_s=1e-12), "Y": first_order(50.0)})
    with pytest.raises(UsageError, match="servo-unstable"):
        run(circle(10.0, 50.0), {"X": first_order(5000.0), "Y": first_order(50.0)})
    rows[4, 1] = math.nan
    with pytest.raises(UsageError, match=r"setpoint 4, at 0\.004 s, is not finite"):
        run(rows, profile("xy-table"))
    rows[4, 1] = 1e300  # no fault of the loop's
    with pytest.raises(UsageError, match=r"setpoints-range.*setpoint 4 of axis Y is 1e\+300"):
        run(rows, profile("xy-table"))
    mixed = [Setpoints("XY", 0.001, 0, np.zeros((5, 2))), Setpoints("XZ", 0.001, 5, np.zeros((5, 2)))]
    with pytest.raises(UsageError, match="has axes XZ; the one before it has XY"):
        joined(simulate(mixed, profile("xy-table")))


def test_no_setpoints_no_response():
    assert list(simulate([], profile("xy-table"))) == []
    assert list(simulate(stream(np.empty((0, 2))), profile("xy-table"))) == []


def test_one_setpoint_is_a_response_of_one_row():
    response = run(np.array([[3.0, 4.0]]), profile("xy-table"))
    assert response.position.tolist() == [[3.0, 4.0]]
    assert response.contour_error_mm.tolist() == [0.0]


def test_a_rotary_axis_alone_has_no_contour_error():
    response = run(np.linspace(0, 1, 50)[:, None], {"A": first_order(50.0)}, axes="A")
    assert np.isnan(response.contour_error_mm).all()
    assert summarize([response])["contour_error_max_mm"] is None


def brute_contour(command, position):
    """Distance to every segment of the whole path up to `AHEAD` samples on."""
    result = []
    for k, at in enumerate(position):
        points = command[: k + AHEAD + 1]
        start, step = points[:-1], np.diff(points, axis=0)
        square = (step**2).sum(axis=1)
        share = np.clip(((at - start) * step).sum(axis=1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
        near = np.sqrt(((start + share[:, None] * step - at) ** 2).sum(axis=1)).min(initial=np.inf)
        result.append(min(near, np.sqrt(((points - at) ** 2).sum(axis=1)).min()))
    return np.array(result)


@given(st.integers(0, 10**6), st.integers(2, 3))
def test_contour_error_is_the_nearest_of_all_segments(seed, axes):
    """A path that does not come back near itself, so that the window and the whole path must agree."""
    rng = np.random.default_rng(seed)
    command = np.cumsum(
        np.abs(rng.normal(size=(300, axes))) * rng.choice([0.0, 0.01, 0.3], size=(300, 1)), axis=0
    )
    position = command - rng.normal(size=axes) * 0.2 + 0.05 * np.cumsum(rng.normal(size=(300, axes)), axis=0)
    assert contour_error(command, position) == pytest.approx(brute_contour(command, position), abs=1e-12)


def test_contour_error_of_a_sharp_corner_is_not_the_nearest_samples():
    command = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert contour_error(command, np.array([[0.5, 0.1], [0.9, 0.2], [1.2, 0.5]])) == pytest.approx(
        [0.1, 0.1, 0.2]
    )


def test_standing_still_keeps_the_path_short():
    """An hour of dwell adds no points to the path, and the error to the last segment stays."""
    command = np.vstack(
        [np.column_stack([np.linspace(0, 1, 11), np.zeros(11)]), np.tile([1.0, 0.0], (200_000, 1))]
    )
    position = command + np.array([0.0, 0.25])
    assert contour_error(command, position) == pytest.approx(np.full(len(command), 0.25))


def test_summary_is_that_of_the_arrays():
    rows = circle(10.0, 80.0)
    servos = profile("dyna-1007")
    response = run(rows, servos)
    summary = summarize(simulate(stream(rows), servos))
    error = response.command - response.position
    assert summary["axes"]["y"]["tracking_rms_mm"] == pytest.approx(np.sqrt((error[:, 1] ** 2).mean()))
    assert summary["axes"]["x"]["tracking_max_mm"] == pytest.approx(np.abs(error[:, 0]).max())
    assert summary["axes"]["x"]["tracking_max_t_s"] == pytest.approx(np.abs(error[:, 0]).argmax() * 0.001)
    assert summary["contour_error_max_mm"] == pytest.approx(response.contour_error_mm.max())
    assert summary["contour_error_rms_mm"] == pytest.approx(np.sqrt((response.contour_error_mm**2).mean()))
    speeds = [np.hypot(*np.diff(part, axis=0).T) / 0.001 for part in (response.command, response.position)]
    assert summary["speed_variation_mm_s"] == pytest.approx(np.sqrt(((speeds[1] - speeds[0]) ** 2).mean()))
    assert summary["samples"] == len(rows)


def couplings(n: int) -> dict[str, bank.Coupling | None]:
    """No coupling, cross coupling along a turning tangent, and state feedback with an antisymmetric part."""
    angle = np.linspace(0.0, 3.0, n)
    tangent = np.column_stack([np.cos(angle), np.sin(angle)])
    gains = np.array([[[3.0, 0.5], [-0.5, 3.0]], [[0.02, 0.0], [0.0, 0.02]]])
    ahead = np.zeros((n, 2, 2))
    none = np.zeros((0, 2)), np.zeros((0, 2))
    return {
        "none": None,
        "cross": bank.Coupling(
            np.array([0.4, 0.01]), tangent, 0.2 * tangent[:, ::-1].copy(), ahead[:0], np.zeros((0, 2, 2, 2))
        ),
        "feedback": bank.Coupling(np.zeros(0), *none, ahead, np.tile(gains, (n, 1, 1, 1))),
    }


@pytest.mark.parametrize("coupling", ["none", "cross", "feedback"])
@pytest.mark.parametrize("name", ["xy-table", "dyna-1007", "die-bonder"])
def test_the_kernel_uncompiled_gives_the_same(name, coupling, monkeypatch):
    if servo_loop.__file__.endswith(".py"):
        pytest.skip("the kernel is not compiled here")
    rows = circle(5.0, 90.0)[:300]
    loops = own_scheme(profile(name), "XY", 0.001).loops
    if coupling == "feedback" and min(loop.velocity for loop in loops) < 0:
        pytest.skip("this plant has no velocity state to feed back")
    asked = couplings(len(rows) - 1)[coupling]
    compiled = bank.LoopBank(loops, 0.001).run(rows - rows[0], coupling=asked)
    monkeypatch.setattr(bank, "servo_loop", uncompiled("servo_loop"))
    plain = bank.LoopBank(loops, 0.001).run(rows - rows[0], coupling=asked)
    for ours, theirs in zip(compiled, plain, strict=True):
        assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-12)


def test_the_contour_kernel_uncompiled_gives_the_same():
    rng = np.random.default_rng(5)
    path = np.cumsum(rng.normal(size=(200, 2)), axis=0)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    own = np.arange(200)
    position = path + rng.normal(size=(200, 2))
    results = np.empty((2, 200, 3))
    for kernel, result in zip((servo_contour, uncompiled("servo_contour")), results, strict=True):
        distances, feet = np.empty(200), np.empty((200, 2))
        kernel.distances(path, arc, own, np.minimum(own + 30, 199), position, 3.0, distances, feet)
        result[:] = np.column_stack([distances, feet])
    assert results[0] == pytest.approx(results[1], rel=1e-13)


def test_a_rest_without_signals_may_follow_chunks_that_have_some():
    rows = circle(10.0, 50.0, turns=0.1)
    feed = Setpoints("XY", 0.001, 0, rows, signals={"feed": np.ones(len(rows))})
    rest = Setpoints("XY", 0.001, len(rows), np.repeat(rows[-1:], 5, axis=0))
    assert sum(map(len, simulate([feed, rest], profile("xy-table")))) == len(rows) + 5
