"""Identifying a simulated noisy axis gives its parameters within their stated uncertainty; excitations keep limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import UsageError
from cncgen.machine import servo_schema
from cncgen.machine.record import Axis, Servo
from cncgen.servo import plants
from cncgen.servo.identification.etfe import etfe
from cncgen.servo.identification.excitation import swept_sine
from cncgen.servo.identification.fits import (
    _OPEN,
    COEFFICIENTS,
    _open_response,
    _solved,
    fit_first_order,
    fit_fourth_order,
    fit_velocity_loop,
)
from cncgen.servo.identification.log import parse_log
from cncgen.servo.loop import close_loop

from .bench import profile, run

AXIS = Axis("X", 250.0, 2450.0, 50000.0)
T = 0.001
#: Standard deviations that a value may be off: 4 are passed once in 16,000 draws.
SIGMAS = 4.0


def logged(servo, noise=0.001, seed=3, **options):
    rows = swept_sine(AXIS, T, **{"duration_s": 6.0, **options})
    response = run(rows[:, None], {"X": servo}, axes="X")
    measured = response.position[:, 0] + np.random.default_rng(seed).normal(size=len(rows)) * noise
    return response.command[:, 0], response.force[:, 0], measured


def within(fit, expected):
    for name, value in expected.items():
        assert abs(fit.parameters[name] - value) <= SIGMAS * fit.uncertainty[name], name
        assert fit.uncertainty[name] < 0.5 * max(abs(value), 1e-12) or value == 0.0, name


def test_velocity_loop_with_friction():
    servo = profile("dyna-1007")["X"]
    _, drive, measured = logged(servo)
    fit = fit_velocity_loop(drive, measured, T)
    within(fit, {"gain": 1.0, "time_constant_s": 0.0047, "coulomb": 0.0451 * 105.9})
    assert fit.residual_rms == pytest.approx(0.001, rel=0.05)


def test_torque_mode_motor():
    """Gain Kc Ke/counts_per_mm of Yeh and Sun's X axis."""
    _, drive, measured = logged(profile("die-bonder")["X"])
    fit = fit_velocity_loop(drive, measured, T, friction=False)
    within(fit, {"gain": 2506.17 * 1.5915494, "time_constant_s": 0.31})


def test_first_order_loop_from_command_to_position():
    values = {"position_gain_1_s": 60.0, "time_constant_s": 0.004, "coulomb_lag_mm": 0.03}
    command, _, measured = logged(Servo("first-order", values), noise=0.0005)
    within(fit_first_order(command, measured, T), values)


def test_fourth_order_loop():
    servo = profile("xy-table")["X"]
    command, _, measured = logged(servo, noise=0.0002)
    fit = fit_fourth_order(command, measured, T)
    loop = servo_schema.closed_loop(servo)
    expected = dict(zip(COEFFICIENTS, [*loop.denominator[1:], *loop.numerator[:2]], strict=True))
    for name, value in expected.items():
        assert abs(fit.parameters[name] - value) <= SIGMAS * fit.uncertainty[name], name


def test_uncertainty_is_the_spread_of_repeated_experiments():
    values = {"position_gain_1_s": 60.0, "time_constant_s": 0.004}
    rows = swept_sine(AXIS, T, duration_s=3.0, low_hz=1.0)
    clean = run(rows[:, None], {"X": Servo("first-order", values)}, axes="X").position[:, 0]
    fits = []
    for seed in range(12):
        noise = np.random.default_rng(seed).normal(size=len(rows)) * 0.002
        fits.append(fit_first_order(rows, clean + noise, T, friction=False))
    for name in values:
        spread = np.std([f.parameters[name] for f in fits], ddof=1)
        assert spread == pytest.approx(np.mean([f.uncertainty[name] for f in fits]), rel=0.6)


def test_etfe_is_the_loops_frequency_response():
    servo = Servo("first-order", {"position_gain_1_s": 60.0, "time_constant_s": 0.004})
    command, _, measured = logged(servo, noise=0.0, duration_s=30.0, high_hz=60.0)
    found = etfe(command, measured, T, segments=6)
    good = (found.coherence > 0.98) & (found.frequency_hz > 2.0) & (found.frequency_hz < 20.0)
    assert good.sum() > 50
    s = 2j * np.pi * found.frequency_hz[good]
    # The setpoint is held over a period: half a sample of delay beside the continuous loop.
    expected = 60.0 / (0.004 * s**2 + s + 60.0) * np.exp(-s * T / 2)
    assert np.abs(found.response[good] / expected - 1.0).max() < 0.1
    with pytest.raises(ValueError, match="too few"):
        etfe(command[:40], measured[:40], T)


@given(st.floats(10, 500), st.floats(100, 5000), st.floats(2000, 1e5), st.floats(0.2, 5), st.floats(8, 200))
def test_an_excitation_keeps_the_limits_and_starts_and_ends_at_rest(velocity, acceleration, jerk, low, high):
    axis = Axis("X", velocity, acceleration, jerk)
    rows = swept_sine(axis, T, duration_s=6.0, low_hz=low, high_hz=high, share=1.0, amplitude=4.0, center=3.0)
    padded = np.concatenate([[3.0] * 3, rows, [3.0] * 3])
    for order, limit in ((1, velocity), (2, acceleration), (3, jerk)):
        assert np.abs(np.diff(padded, order)).max() / T**order <= limit * (1 + 1e-6)
    assert rows[0] == rows[-1] == 3.0
    assert np.abs(rows - 3.0).max() <= 4.0 + 1e-9


def test_an_excitation_that_cannot_be_is_refused():
    with pytest.raises(UsageError, match="excite-band"):
        swept_sine(AXIS, T, low_hz=50.0, high_hz=10.0)
    with pytest.raises(UsageError, match="a share of 1e-12 of the limits leaves a swing of "):
        swept_sine(AXIS, T, share=1e-12)
    with pytest.raises(UsageError, match="the share is 2;"):
        swept_sine(AXIS, T, share=2.0)
    with pytest.raises(UsageError, match="excite-travel"):
        swept_sine(Axis("X", 250.0, 2450.0, 5e4, (-1.0, 1.0)), T)
    # The swing goes both ways from its centre: each end of the travel is one that it may leave.
    reach = float(np.abs(swept_sine(AXIS, T)).max())
    for travel in ((-10.0 * reach, 0.9 * reach), (-0.9 * reach, 10.0 * reach)):
        with pytest.raises(UsageError, match="excite-travel"):
            swept_sine(Axis("X", 250.0, 2450.0, 5e4, travel), T)
        clear = 5.0 * reach if travel[1] > reach else -5.0 * reach
        assert len(swept_sine(Axis("X", 250.0, 2450.0, 5e4, travel), T, center=clear)) > 1


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (b"a,b\n1,2\n", "log-columns"),
        (b"t_s,q\n" + b"".join(b"%d,1\n" % k for k in range(20)), "log-columns"),
        (b"t_s,x_mm\n0,1\n1,x\n", "log-row"),
        (b"t_s,x_mm\n0,1\n1,2\n", "log-row"),
        (b"t_s,x_mm\n" + b"".join(b"%d,nan\n" % k for k in range(20)), "log-row"),
        (b"t_s,x_mm\n" + b"".join(b"%d,1\n" % (k * k) for k in range(20)), "log-time"),
        (b"", "log-columns"),
        (b"\x00\xff\xfe\n", "log-columns"),
    ],
)
def test_bad_logs_are_named(text, code):
    with pytest.raises(UsageError, match=code):
        parse_log(text, "log.csv")


@pytest.mark.parametrize(
    "head",
    [
        "time [ms];x_cmd [µm];x_pos [µm];x_torque [N·m];spindle load",
        "# written by a drive\ntime [ms]\tX ref (um)\tX act (um)\tx_u\tspindle load",
        "t_ms,x_cmd_um,x_um,x_force,spindle load",
        "\ufefft_ms,x_setpoint_um,X_um,X_drive,spindle load",
    ],
)
def test_logs_of_other_tools_are_read(head):
    separator = next(mark for mark in ";\t," if mark in head.splitlines()[-1])
    rows = [(100 + k, 2000.0 * k, 1000.5 * k, 5.0) for k in range(20)]
    text = "\n".join(separator.join([*(f"{v:.3f}" for v in row), "idle"]) for row in rows)
    text = text.replace(".", ",") if separator == ";" else text
    log = parse_log(f"{head}\n{text}\n".encode(), "log.csv")["X"]
    assert log.period_s == pytest.approx(0.001)
    assert log.position == pytest.approx(1.0005 * np.arange(20))
    assert log.command == pytest.approx(2.0 * np.arange(20))
    assert log.drive.tolist() == [5.0] * 20


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([*range(10), *range(9, 29)], "does not go on at row 12: 9 s, then 9 s"),
        ([*range(10), *range(15, 35)], "1 of 29 steps differ from 1 s, most at row 12, where it is 6 s"),
    ],
)
def test_times_that_are_not_even_are_named_with_their_row(times, message):
    text = "t_s,x_mm\n" + "".join(f"{t},1\n" for t in times)
    with pytest.raises(UsageError, match=message):
        parse_log(text.encode(), "log.csv")


def test_zeros_that_differ_and_a_late_clock_change_nothing():
    """Position 7 mm off: the same parameters, and the offset beside them."""
    values = {"position_gain_1_s": 60.0, "time_constant_s": 0.004}
    command, _, measured = logged(Servo("first-order", values), noise=0.0005, duration_s=3.0, low_hz=1.0)
    plain, off = (fit_first_order(command, measured + by, T, friction=False) for by in (0.0, 7.0))
    within(off, {**values, "offset": 7.0})
    assert off.parameters["time_constant_s"] == pytest.approx(plain.parameters["time_constant_s"], rel=1e-5)
    servo = profile("xy-table")["X"]
    command, _, measured = logged(servo, noise=0.0002, duration_s=3.0, low_hz=1.0)
    fit = fit_fourth_order(command, measured - 2.0, T)
    assert abs(fit.parameters["offset"] + 2.0) < SIGMAS * fit.uncertainty["offset"]
    assert fit.residual_rms == pytest.approx(0.0002, rel=0.05)
    with pytest.raises(ValueError, match="does not change"):
        fit_first_order(np.full(50, 3.0), np.full(50, 3.0), T)


def test_a_log_is_read_by_its_columns():
    rows = b"".join(b"%.3f,%d,%d,5\n" % (k * T, k, 2 * k) for k in range(20))
    log = parse_log(b"t_s,x_mm,x_cmd_mm,x_force\n" + rows, "log.csv")["X"]
    assert log.period_s == pytest.approx(T)
    assert log.position.tolist() == list(range(20))
    assert log.command.tolist() == [2 * k for k in range(20)]
    assert log.drive.tolist() == [5.0] * 20


@pytest.mark.parametrize(
    ("row", "column", "text"),
    [
        ("0.02,nan,1", 6, "column 2 is 'nan'"),
        ("0.02,1, 1e300", 8, "column 3 is '1e300'"),
        ("0.02,x,1", 6, "column 2 is 'x'"),
    ],
)
def test_a_value_that_is_no_number_is_pointed_at(row, column, text):
    """Comments and blank lines count as lines of the file."""
    rows = [f"{k / 1000:.3f},{k},0" for k in range(30)]
    content = "\n".join(["# a log of ours", "t_s,x_mm,x_force", *rows[:19], "", "# pause", row, *rows[20:]])
    with pytest.raises(UsageError) as caught:
        parse_log(content.encode(), "log.csv")
    fault = caught.value.diagnostics[0]
    assert fault.code == "log-row"
    assert text in fault.message
    assert (fault.span.file, fault.span.line, fault.span.column) == ("log.csv", 24, column)
    assert fault.excerpt == row


def test_a_row_that_is_too_short_is_named():
    rows = [f"{k / 1000:.3f},{k},0" for k in range(30)]
    rows[10] = "0.010,1"
    with pytest.raises(UsageError) as caught:
        parse_log("\n".join(["t_s,x_mm,x_force", *rows]).encode(), "log.csv")
    fault = caught.value.diagnostics[0]
    assert (fault.span.line, fault.message) == (
        12,
        "the row has 2 columns, and a value stands in column 3 of the header",
    )


@pytest.mark.parametrize("fit", [fit_first_order, fit_fourth_order, fit_velocity_loop, etfe])
@pytest.mark.parametrize(
    ("given", "position", "period_s", "words"),
    [
        (np.arange(300.0), np.zeros(200), T, r"shapes \(300,\) and \(200,\)"),
        (np.zeros((300, 1)), np.zeros((300, 1)), T, r"shapes \(300, 1\)"),
        (np.arange(3.0), np.zeros(3), T, "the log has 3 rows; 16 are needed"),
        (np.full(300, np.nan), np.zeros(300), T, "what the axis is given is not finite in row 0"),
        (
            np.arange(300.0),
            np.where(np.arange(300) == 7, np.inf, 0),
            T,
            "the position is not finite in row 7",
        ),
        (np.arange(300.0), np.zeros(300), 0, "the period is 0; it is to be a number of seconds above 0"),
        (np.arange(300.0), np.zeros(300), "1 ms", "the period is '1 ms'"),
        # A dead axis was fitted by a model with exit 0, 3e91 % beside it.
        (np.arange(300.0), np.zeros(300), T, "the position does not change"),
        (np.zeros(300), np.arange(300.0), T, "what the axis is given does not change"),
    ],
)
def test_what_is_no_log_is_said(fit, given, position, period_s, words):
    """NaN was a command that does not change, a period of 0 a division by it."""
    with pytest.raises(ValueError, match=words):
        fit(given, position, period_s)


def test_what_a_log_does_not_determine_is_infinitely_uncertain():
    """Moving one way, friction c and offset b of the drive show as b - c alone: both had a standard deviation of 0.03 %."""
    drive = 100.0 * (1.0 + 0.3 * np.sin(2.0 * np.pi * 7.0 * T * np.arange(400)))
    loop = close_loop(plants.velocity_loop(0.03, 0.03).with_imperfections(coulomb=20.0), _OPEN, T)
    position = _open_response(loop, drive) + 1e-4 * np.random.default_rng(5).standard_normal(400)
    one_way = fit_velocity_loop(drive, position, T)
    assert {k for k, v in one_way.uncertainty.items() if np.isinf(v)} == {"bias", "coulomb"}
    assert one_way.parameters["bias"] - one_way.parameters["coulomb"] == pytest.approx(-20.0, abs=0.5)
    to_and_fro = fit_velocity_loop(*_swept(loop), T)
    assert all(np.isfinite(v) for v in to_and_fro.uncertainty.values())
    within(to_and_fro, {"gain": 0.03, "time_constant_s": 0.03, "bias": 0.0, "coulomb": 20.0})


def _swept(loop):
    """Return a drive's input that goes to and fro, and the noisy position of the axis."""
    t = T * np.arange(2000)
    drive = 100.0 * np.sin(2.0 * np.pi * (1.0 + 5.0 * t) * t)
    return drive, _open_response(loop, drive) + 1e-4 * np.random.default_rng(6).standard_normal(len(t))


def test_friction_of_nothing_has_the_uncertainty_of_a_slope():
    """It enters by its size, whose central difference vanishes about 0; of y = |c| t it is s/|t|, as of any slope."""
    t = np.linspace(0.0, 1.0, 300)
    noise = 0.01 * np.random.default_rng(4).standard_normal(len(t))
    theta, covariance, rest = _solved(lambda c: np.abs(c[0]) * t + 0.01 * t + noise, np.array([0.3]), t)
    assert abs(theta[0]) < 1e-4
    assert covariance[0, 0] == pytest.approx(rest @ rest / (len(t) - 1) / (t @ t), rel=1e-6)


@pytest.mark.parametrize("start", [-3e-6, 3e-6])
def test_the_slope_of_friction_next_to_nothing_is_not_taken_across_it(start):
    """A step over 0, where the size turns back, would show less of a slope than there is: y = |c| t, at its solution."""
    t = np.linspace(0.0, 1.0, 300)
    noise = 0.01 * np.random.default_rng(4).standard_normal(len(t))
    noise -= t * (noise @ t) / (t @ t)
    position = abs(start) * t + noise
    theta, covariance, rest = _solved(lambda c: np.abs(c[0]) * t - position, np.array([start]), position)
    assert abs(theta[0]) < 1e-5
    assert covariance[0, 0] == pytest.approx(rest @ rest / (len(t) - 1) / (t @ t), rel=1e-6)


def test_rounding_does_not_decide_what_a_log_determines():
    """An axis that moves one way, its bias and friction alike: logs that differ by roundings have the same named."""
    t = T * np.arange(400)
    moved = 2.4 * (t - 0.03 * (1.0 - np.exp(-t / 0.03)))
    drive = np.full(len(t), 100.0)
    drive[0] = 101.0
    rng = np.random.default_rng(8)
    for _ in range(2):
        fit = fit_velocity_loop(drive, moved * (1.0 + 2e-16 * rng.integers(-2, 3, len(t))), T)
        assert {k for k, v in fit.uncertainty.items() if np.isinf(v)} == {"gain", "bias", "coulomb"}
