"""Machines that the log of an identification leaves possible."""

import json
import math
from statistics import NormalDist

import numpy as np
import pytest

from cncgen.cli.app import run as cncgen
from cncgen.diagnostics import UsageError
from cncgen.machine.record import Servo
from cncgen.servo.identified_spread import servo_values, spread_of
from cncgen.servo.response_spread import drawn_figures, spread_values
from cncgen.servo.uncertainty import Perturbation, perturbed

from .bench import stream

SERVO = {"X": Servo("first-order", {"position_gain_1_s": 80.0, "time_constant_s": 0.002})}


def summary(spread=0.1, model="first-order", matrix=None):
    names = ["position_gain_1_s", "time_constant_s"]
    matrix = [[spread**2, 0.0], [0.0, 1e-6]] if matrix is None else matrix
    covariance = {"parameters": names, "logarithm": [True, True], "matrix": matrix}
    axis = {"parameters": {names[0]: 80.0, names[1]: 0.002}, "covariance": covariance}
    return {"model": model, "axes": {"x": axis}}


def test_a_ramp_lags_by_the_drawn_gain():
    """Behind a ramp of v a position loop lags v / Kp: with ln Kp normal, quantiles of the lag are v/80 · exp(z σ)."""
    period, v, spread = 0.001, 50.0, 0.1
    rows = v * period * np.arange(400.0)[:, None]
    drawn = Perturbation(0.0, 256, 3, (spread_of(summary(spread), "X"),))
    found = drawn_figures(list(stream(rows, "X", period)), SERVO, drawn)
    values = spread_values(found, drawn)
    z = NormalDist().inv_cdf(0.95)
    figures = values["tracking_max_mm_x"]
    assert values["of"] == "parameters of X within the covariance of their fit"
    for name, sigmas in (("low", -z), ("median", 0.0), ("high", z)):
        assert figures[name] == pytest.approx(v / 80.0 * math.exp(sigmas * spread), rel=0.01)


def test_axes_without_a_summary_have_the_share():
    both = {**SERVO, "Y": SERVO["X"]}
    drawn = list(perturbed(both, "XY", Perturbation(0.05, 64, 1, (spread_of(summary(0.5), "X"),))))
    x, y = (np.array([one[k].parameters["position_gain_1_s"] for one in drawn]) / 80.0 for k in "XY")
    assert 0.95 <= y.min() < 0.96 < 1.04 < y.max() <= 1.05
    assert x.min() < 0.5
    assert x.max() > 2.0  # 2.2 σ of 64: exp(±1.1)


def test_a_rotary_axis_has_degrees_in_its_table():
    """180/π degrees a radian: gain and lag in file units."""
    loop = servo_values("A", "velocity-loop", {"gain": 2.0, "time_constant_s": 0.01})
    assert loop["numerator"] == [pytest.approx(2.0 * 180.0 / math.pi)]
    first = servo_values(
        "A", "first-order", {"position_gain_1_s": 80.0, "coulomb_lag_mm": 0.1, "offset": 1.0}
    )
    assert first == {"position_gain_1_s": 80.0, "coulomb_lag_deg": pytest.approx(18.0 / math.pi)}


@pytest.mark.parametrize(
    ("found", "said"),
    [
        ({}, "not a summary"),
        (summary(model="etfe"), "no parameters to draw"),
        (summary(matrix=[[math.inf, 0.0], [0.0, 1.0]]), "does not determine"),
        (summary(matrix=[[1.0]]), "no parameters to draw"),
    ],
)
def test_what_cannot_be_drawn(found, said):
    with pytest.raises(ValueError, match=said):
        spread_of(found, "X")


def test_another_model_than_the_machines_is_refused():
    four = dict.fromkeys(("b1", "b2", "a0", "a1", "a2", "a3"), 1.0)
    covariance = {"parameters": list(four), "logarithm": [False] * 6, "matrix": np.eye(6).tolist()}
    axis = {"parameters": four, "covariance": covariance}
    spread = spread_of({"model": "fourth-order", "axes": {"x": axis}}, "X")
    with pytest.raises(UsageError, match="identified as fourth-order"):
        list(perturbed(SERVO, "X", Perturbation(0.0, 2, 0, (spread,))))


def test_compare_draws_the_machines_that_simulate_draws(tmp_path, programs, capfd):
    """The same seed gives the same machines, so the spread of the axes' own controller is that of simulate."""
    program, drawn = str(programs / "circle.nc"), ["-m", "dyna-1007", "--perturb", "10%", "--draws", "8"]
    one, many = tmp_path / "one.json", tmp_path / "many.json"
    assert cncgen(["simulate", program, *drawn, "-o", str(tmp_path / "r.csv"), "--summary", str(one)]) == 0
    assert cncgen(["compare", program, *drawn, "--controllers", "p,zpetc", "--summary", str(many)]) == 0
    rows = json.loads(many.read_text())["controllers"]
    alone = json.loads(one.read_text())["perturbed"]
    assert rows[0]["perturbed"]["contour_error_max_mm"] == pytest.approx(alone["contour_error_max_mm"])
    assert rows[1]["perturbed"]["contour_error_max_mm"]["worst"] < alone["contour_error_max_mm"]["low"]
    assert "drawn 90 ± 19.0 % µm" in capfd.readouterr().out
    assert cncgen(["compare", program, *drawn]) == 2


def test_simulate_takes_the_summary_of_identify(tmp_path, capfd):
    """From excitation to the interval: the log of a known axis, its fit, and the spread of the lag that the fit leaves."""
    machine = tmp_path / "m.toml"
    machine.write_text(
        "period_s = 0.001\n[axes.x]\nmax_velocity_mm_s = 200.0\nmax_acceleration_mm_s2 = 2000.0\nmax_jerk_mm_s3 = 5e4\n"
        '[axes.x.servo]\nmodel = "first-order"\nposition_gain_1_s = 80.0\ntime_constant_s = 0.002\n'
    )
    command, log, found = tmp_path / "c.csv", tmp_path / "log.csv", tmp_path / "x.json"
    assert cncgen(["excite", "-m", str(machine), "-o", str(command), "--axis", "X"]) == 0
    assert cncgen(["simulate", str(command), "-m", str(machine), "-o", str(log)]) == 0
    assert cncgen(["identify", str(log), "--model", "first-order", "--summary", str(found)]) == 0
    call = ["simulate", str(command), "-m", str(machine), "-o", str(tmp_path / "r.csv"), "--draws", "8"]
    assert cncgen([*call, "--perturb", str(found), "--summary", str(tmp_path / "s.json")]) == 0
    figures = json.loads((tmp_path / "s.json").read_text())["perturbed"]
    assert (figures["identified"], figures["draws"], figures["unstable"]) == (["X"], 8, 0)
    log.write_text("{}")
    bad = tmp_path / "bad.json"
    bad.write_text("[1]")
    assert cncgen([*call, "--perturb", str(bad)]) == 2
    assert "perturb-summary" in capfd.readouterr().err
