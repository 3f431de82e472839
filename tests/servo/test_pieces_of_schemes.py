"""What schemes are made of, one piece at a time, beside the equations that they are to solve."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine.record import Axis, Servo
from cncgen.servo import plants
from cncgen.servo.bank import LoopBank
from cncgen.servo.command_limits import breaks, broken
from cncgen.servo.controllers import ccc, tcf
from cncgen.servo.controllers.hinf_servo import family
from cncgen.servo.controllers.p import p
from cncgen.servo.controllers.pid import pid
from cncgen.servo.loop import close_loop, follow_transfer_function
from cncgen.servo.mirror import Compensation
from cncgen.servo.models import control_period
from cncgen.servo.named_schemes import Settings, cross_coupling, scheme_maker
from cncgen.servo.simulate import RUNAWAY_MM, own_scheme
from cncgen.servo.stream import blocks
from cncgen.servo.summary import summarize
from cncgen.setpoints.record import Setpoints

from .bench import profile, run, run_scheme, stream

T = 0.001


@pytest.mark.parametrize(
    ("kp", "ki", "kd", "corner", "tracking"),
    [(3.0, 10.0, 0.05, 400.0, 0.2), (3.0, 10.0, 0.05, None, None), (3.0, 10.0, 0.0, None, None), (3.0, 0.0, 0.05, 250.0, None),
     (0.0, 10.0, 0.0, None, None)],
)  # fmt: skip
def test_pid_is_the_books_recursion(
    kp: float, ki: float, kd: float, corner: float | None, tracking: float | None
) -> None:
    """Åström and Hägglund 1995, sections 3.4 and 3.5, step by step, with a drive that is bounded: Tt as given, √(Ti Td), or Ti."""
    rng = np.random.default_rng(2)
    setpoint, position = rng.normal(size=(2, 200))
    made, bound = pid(kp, ki, kd, T, corner, tracking), 4.0
    memory = np.zeros(3)
    integral = filtered = before = 0.0
    reset = tracking
    if reset is None:
        has_both = kp > 0.0 and ki > 0.0
        reset = math.inf if not has_both else math.sqrt(kp / ki * kd / kp) if kd else kp / ki
    alpha = math.exp(-corner * T) if corner else 0.0
    for r, y in zip(setpoint, position, strict=True):
        e = r - y
        filtered = alpha * filtered + kd * (1.0 - alpha) / T * (e - before)
        wanted = kp * e + integral + filtered
        found = made.c @ memory + made.d_setpoint * r + made.d_position * y
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)
        excess = np.clip(wanted, -bound, bound) - wanted
        memory = made.a @ memory + made.b_setpoint * r + made.b_position * y + made.b_bound * excess
        if ki:
            integral += ki * T * e + T / reset * excess
        before = e


def test_viscous_friction_of_the_motor_is_a_load_of_its_drive() -> None:
    """A torque c φ̇ at the motor, as a term of the plant and as friction in drive input a mm/s: the same matrix.

    The velocity that friction acts on is that of the motor, where the drive acts.
    """
    rest = (1e-3, 2e-3, 400.0, 0.02)
    travel, c = 1.6, 0.03
    plain, braked = (plants.two_mass(*rest, viscous, 0.005, travel) for viscous in (0.0, c))
    assert plain.with_viscous(c / travel).a == pytest.approx(braked.a, rel=1e-12)
    assert plain.b[plain.velocity] > 0.0
    assert plain.a[0, plain.velocity] == 1.0


@pytest.mark.parametrize("gain", [2000.0, -2000.0])
def test_a_ratio_of_relative_degree_two_has_a_velocity(gain: float) -> None:
    """Its second state is the rate of its output; of relative degree one there is none, whatever the signs."""
    made = plants.transfer_function(np.array([gain]), np.array([1.0, 50.0, 0.0]))
    assert made.velocity == 1
    assert made.c @ made.a == pytest.approx(np.eye(2)[1])
    assert plants.transfer_function(np.array([gain, 5.0]), np.array([1.0, 50.0, 0.0])).velocity is None
    for s in 1j * np.array([0.5, 30.0, 900.0]):
        found = made.c @ np.linalg.solve(s * np.eye(2) - made.a, made.b)
        assert found == pytest.approx(gain / (s * (s + 50.0)), rel=1e-9)


def test_the_task_frame_turns_with_the_path() -> None:
    """A clothoid at constant speed turns by ω = α t: W and Ẇ are ω and α times the quarter turn; feedforward the plant's."""
    speed, alpha = 50.0, 40.0
    t = np.arange(400) * T
    angle = 0.5 * alpha * t**2
    x = np.cumsum(speed * T * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
    gain, lag = np.array([1.3, 0.8]), np.array([0.005, 0.007])
    frame = tcf.task_frame(
        [plants.velocity_loop(g, tau) for g, tau in zip(gain, lag, strict=True)], (300.0, 1.0), (250.0, 0.9)
    )
    assert frame.stiffness == pytest.approx([300.0**2, 250.0**2])
    assert frame.damping == pytest.approx([2.0 * 300.0, 2.0 * 0.9 * 250.0])
    (block,) = blocks([Setpoints("XY", T, 0, x)], frame.before, frame.after)
    found = frame.over(block)
    # A row of the cumulated sum stands half a step behind its direction.
    inner, at = slice(20, -20), t + 0.5 * T
    angle = 0.5 * alpha * at**2
    tangent = np.column_stack([np.cos(angle), np.sin(angle)])
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    want = frame.feedback(
        tangent, (alpha * at)[:, None, None] * quarter, np.tile(alpha * quarter, (400, 1, 1))
    )
    scale = np.abs(want).max(axis=0)
    assert np.abs((found.feedback - want)[inner] / scale).max() < 2e-4
    velocity = speed * tangent
    acceleration = speed * (alpha * at)[:, None] * tangent[:, ::-1] * [-1.0, 1.0]
    drive = (acceleration + velocity / lag) * lag / gain
    assert found.feedforward[inner, 0] == pytest.approx(drive[inner], rel=1e-3, abs=1e-2)
    assert found.feedforward[inner, 1] == pytest.approx(velocity[inner], rel=1e-3, abs=1e-2)


def test_the_family_of_plants_is_every_corner_of_its_ranges() -> None:
    """g G(s/f) at s = jω is g times the plant's response at ω/f, for nine pairs of g and f."""
    values = {"numerator": [3.0, 900.0], "denominator": [1.0, 20.0, 4e4], "frequency_uncertainty": 0.1,
              "gain_uncertainty": 0.25, "viscous_s_mm": 0.0}  # fmt: skip
    w = 150.0
    found = sorted(
        (complex(np.polyval(above, 1j * w) / np.polyval(below, 1j * w)) for above, below in family(values)),
        key=lambda h: (round(abs(h), 9), round(h.imag, 9)),
    )
    want = sorted(
        (
            g
            * complex(
                np.polyval(values["numerator"], 1j * w / f) / np.polyval(values["denominator"], 1j * w / f)
            )
            for f, g in itertools.product((0.9, 1.0, 1.1), (0.75, 1.0, 1.25))
        ),
        key=lambda h: (round(abs(h), 9), round(h.imag, 9)),
    )
    assert found == pytest.approx(want, rel=1e-12)


@pytest.mark.parametrize("end", [-10.0, 10.0])
def test_a_command_that_leaves_the_travel_is_refused_where_it_goes_furthest(end: float) -> None:
    """A circle of 10 mm round the axis: its command is 10/|G| and leaves both ends; one end alone is refused alone."""
    angle = np.linspace(0.0, 12.0 * np.pi, 6000)
    rows = np.column_stack([10.0 * np.sin(angle), 0.0 * angle])
    travel = (-10.0, 100.0) if end < 0.0 else (-100.0, 10.0)
    limits = {"X": Axis("X", 1e3, 1e7, 1e12, travel), "Y": Axis("Y", 1e3, 1e7, 1e12, (-1.0, 1.0))}
    servos = {k: Servo("first-order", {"position_gain_1_s": 60.0}) for k in "XY"}
    whole = Compensation(stream(rows, chunk=700), servos, passes=2)
    command = np.concatenate([chunk.position for chunk in whole.chunks()])
    (found,) = breaks(limits, "XY", command[: len(rows)], T)
    fault = broken(found)
    at = int((command[: len(rows), 0] * np.sign(end)).argmax())
    assert fault.values["limit"] == "travel"
    assert fault.values["value"] == pytest.approx(command[at, 0], rel=1e-12)
    assert fault.values["t_s"] == pytest.approx(at * T)
    assert f"beyond {end:g}" in fault.message


def test_a_runaway_says_when() -> None:
    """P control beyond 2/T grows by |1 − Kv T| a period; it is named at the first setpoint that is too far."""
    rows = np.concatenate([np.zeros((50, 1)), np.ones((300, 1))])
    with pytest.raises(UsageError, match="servo-unstable") as caught:
        run(rows, {"X": Servo("first-order", {"position_gain_1_s": 2500.0})}, axes="X")
    # The error of 1 mm of row 50 grows by 1.5 a period.
    (fault,) = caught.value.diagnostics
    assert fault.values["axis"] == "X"
    assert fault.values["t_s"] == pytest.approx((50 + math.log(RUNAWAY_MM) / math.log(1.5)) * T, abs=1.5 * T)


def test_the_summary_is_in_the_units_of_files_with_the_times_of_the_worst() -> None:
    """An axis that turns lags by ω/Kv (and half a period): 180/π of it in degrees; the worst contour error is timed."""
    t = np.arange(1000) * T
    rows = np.column_stack([10.0 * t, np.where(t < 0.5, 0.0, 10.0 * (t - 0.5)), 2.0 * t])
    servos = {k: Servo("first-order", {"position_gain_1_s": 50.0}) for k in "XYA"}
    response = run(rows, servos, axes="XYA")
    found = summarize([response])
    error = (response.command - response.position)[:, 2]
    assert found["axes"]["a"]["tracking_max_deg"] == pytest.approx(math.degrees(np.abs(error).max()))
    assert found["axes"]["a"]["tracking_rms_deg"] == pytest.approx(math.degrees(np.sqrt((error**2).mean())))
    assert error[-1] == pytest.approx(2.0 / 50.0, rel=1e-6)
    worst = int(response.contour_error_mm.argmax())
    assert 500 < worst < 700
    assert found["contour_error_max_t_s"] == pytest.approx(worst * T)


@pytest.mark.parametrize("sampled", [True, False])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_axis_sticks_until_its_drive_is_above_the_friction(sign: float, sampled: bool) -> None:
    """P at rest: 97.5 % of the Coulomb friction never moves the axis, 102.5 % does, either way, sampled or continuous."""
    plant = plants.velocity_loop(2.0, 0.005).with_imperfections(coulomb=2.0)
    controller = p(1.0) if sampled else replace(p(1.0), continuous=True)
    loop = close_loop(plant, controller, T)
    for error, moves in ((1.95, False), (2.05, True)):
        rows = np.full((100, 1), sign * error)
        rows[0] = 0.0
        position = LoopBank([loop], T).run(rows)[0][:, 0]
        assert (np.abs(position).max() > 0.0) == moves
        assert (sign * position >= 0.0).all()


@pytest.mark.parametrize(
    ("period", "parts"),
    [(0.001 / 1.9, None), (0.001 / 2.1, None), (0.001 / 2.0, 2), (0.0021, None), (0.001, 1)],
)
def test_a_control_period_parts_the_setpoints(period: float, parts: int | None) -> None:
    """A whole number of times, and one that is a little more or less is none."""
    servo = Servo("first-order", {"position_gain_1_s": 50.0, "control_period_s": period})
    if parts is None:
        with pytest.raises(UsageError, match="servo-period"):
            control_period(servo, "X", T)
    else:
        assert control_period(servo, "X", T) == T / parts


def test_a_plant_in_z_has_its_own_control_period() -> None:
    servo = Servo("plant", {"numerator": [0.0005], "denominator": [1.0, -1.0], "sample_time_s": 0.0005,
                            "position_gain_1_mm": 50.0})  # fmt: skip
    assert control_period(servo, "X", T) == 0.0005


def test_a_ratio_in_z_behind_three_of_its_periods() -> None:
    """0.3 s of 0.1 s each, which is a little less than 3 in doubles: 1/(z − 1/2) comes three samples later."""
    now, late = (
        LoopBank(
            [follow_transfer_function(np.array([1.0]), np.array([1.0, -0.5]), 0.1, delay, discrete=True)], 0.1
        )
        for delay in (0.0, 0.3)
    )
    rows = np.random.default_rng(3).normal(size=(60, 1))
    rows[0] = 0.0
    undelayed, delayed = now.run(rows)[0][:, 0], late.run(rows)[0][:, 0]
    assert delayed[3:] == pytest.approx(undelayed[:-3], abs=1e-12)
    assert not delayed[:4].any()


def test_coupled_axes_are_linear() -> None:
    """Two axes of which one turns have no path that an error could stand across."""
    servos = {k: Servo("pd-plus", {"time_constant_s": 0.3, "velocity_gain_rad_s_volt": 2500.0, "counts_per_rad": 1600.0,
                                   f"counts_per_{'deg' if k == 'A' else 'mm'}": 1000.0, "position_gain_volt_count": 0.01,
                                   "derivative_gain_volt_s_rad": 0.03}) for k in "XA"}  # fmt: skip
    rows = np.zeros((20, 2))
    for name in ("ccc", "tcf"):
        with pytest.raises(UsageError, match="it couples two or three linear axes, not X, A"):
            run_scheme(rows, scheme_maker(name, servos), axes="XA")


def test_gains_of_a_coupling_are_fitted_unless_both_are_given() -> None:
    """What one of them would be beside the other is not known: both are lowered together."""
    loops = own_scheme(profile("dyna-1007"), "XY", T).loops
    fit = ccc.fitted(loops)
    for settings in (Settings(), Settings(ccc_proportional=1.0), Settings(ccc_integral_1_s=1.0)):
        assert cross_coupling(loops, "XY", settings) == fit
    own = ccc.own_gain(loops)
    given = cross_coupling(loops, "XY", Settings(ccc_proportional=2.0, ccc_integral_1_s=3.0))
    assert (given.proportional, given.integral) == pytest.approx((2.0 * own, 3.0 * own))
