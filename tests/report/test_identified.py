"""What `cncgen identify` writes can be read: the tables give back the axis that was simulated."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from cncgen.cli.app import run
from cncgen.machine import load_servos
from cncgen.servo.models import axis_loop

SERVO = '[axes.{0}.servo]\nmodel = "first-order"\nposition_gain_1_s = 40.0\ntime_constant_s = 0.01\n'


@pytest.fixture
def log(tmp_path: Path) -> str:
    """A response of X and A, both the same loop, to a sweep of 6 s."""
    time = np.arange(6000) * 0.001
    sweep = 5.0 * np.sin(2 * np.pi * (0.5 * time + 1.2 * time**2)) * np.sin(np.pi * time / 6.0)
    rows = "".join(f"{t:.9f},{x:.9f},{x:.9f}\n" for t, x in zip(time, sweep, strict=True))
    (tmp_path / "s.csv").write_text("t_s,x_mm,a_deg\n" + rows)
    (tmp_path / "servo.toml").write_text(SERVO.format("x") + SERVO.format("a"))
    call = [
        "simulate",
        f"{tmp_path}/s.csv",
        "--axis-params",
        f"{tmp_path}/servo.toml",
        "-q",
        "-o",
        f"{tmp_path}/r.csv",
    ]
    assert run(call) == 0
    return f"{tmp_path}/r.csv"


def test_a_first_order_loop_comes_back(log: str, tmp_path: Path) -> None:
    found = tmp_path / "found.toml"
    assert run(["identify", log, "--model", "first-order", "--no-friction", "-q", "-o", str(found)]) == 0
    servos = load_servos(found)
    assert list(servos) == ["X", "A"]
    for servo in servos.values():
        assert servo.model == "first-order"
        assert servo.parameters["position_gain_1_s"] == pytest.approx(40.0, rel=0.01)
        assert servo.parameters["time_constant_s"] == pytest.approx(0.01, rel=0.05)


def test_a_closed_loop_as_a_ratio_follows_alike(log: str, tmp_path: Path) -> None:
    """The fourth-order model of the loop, simulated, gives the log again."""
    found, again = str(tmp_path / "found.toml"), tmp_path / "again.csv"
    assert run(["identify", log, "--model", "fourth-order", "--axis", "x", "-q", "-o", found]) == 0
    assert load_servos(found)["X"].model == "transfer-function"
    call = ["simulate", f"{tmp_path}/s.csv", "--axes", "X", "--axis-params", found, "-q", "-o", str(again)]
    assert run(call) == 0
    want = np.loadtxt(log, delimiter=",", skiprows=1)[:, 2]
    have = np.loadtxt(again, delimiter=",", skiprows=1)[:, 2]
    assert np.abs(want - have).max() < 0.01 * np.abs(want).max()


@pytest.mark.parametrize(("noise", "told"), [(0.0, False), (50.0, True)])
def test_a_model_that_explains_little_is_a_warning(
    log: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], noise: float, told: bool
) -> None:
    """Noise of ten times the swing: a fit is found all the same."""
    table = np.loadtxt(log, delimiter=",", skiprows=1)
    table[:, 2] += noise * np.random.default_rng(1).standard_normal(len(table))
    rows = "".join(f"{t:.9f},{c:.9f},{x:.9f}\n" for t, c, x in table[:, :3])
    (tmp_path / "noisy.csv").write_text("t_s,x_cmd_mm,x_mm\n" + rows)
    assert (
        run(["identify", f"{tmp_path}/noisy.csv", "--model", "first-order", "--no-friction", "--json"]) == 0
    )
    said = [json.loads(line) for line in capsys.readouterr().err.splitlines() if line.startswith("{")]
    assert [item["code"] for item in said] == ["identify-poor"] * told
    assert all(item["values"]["fit_percent"] < 50.0 for item in said)


def test_a_fit_that_is_unstable_as_sampled_is_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A loop with feedforward leads where a P loop lags: the best P loop is one of 2,000/s, which its period does not hold."""
    files = [str(tmp_path / name) for name in ("sweep.csv", "log.csv", "found.toml")]
    assert run(["excite", "-m", "xy-table", "--axis", "X", "--duration", "4", "-q", "-o", files[0]]) == 0
    assert run(["simulate", files[0], "--axis-params", "xy-table", "-q", "-o", files[1]]) == 0
    for model, told in (("first-order", 1), ("fourth-order", 0)):
        assert run(["identify", files[1], "--model", model, "--json", "-o", files[2]]) == 0
        said = [json.loads(line) for line in capsys.readouterr().err.splitlines() if line.startswith("{")]
        assert [item["code"] for item in said] == ["identify-unstable"] * told
    poles = axis_loop(load_servos(files[2])["X"], "X", 0.001).poles()
    assert np.abs(poles).max() < 1.0


def test_what_a_log_does_not_determine_is_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An axis that moves one way, with friction of 20: x = 0.03 (u - 20) t from a lag of 30 ms on."""
    t = np.arange(400) * 0.001
    moved = 0.03 * 80.0 * (t - 0.03 * (1.0 - np.exp(-t / 0.03)))
    rows = "".join(f"{a:.9f},{x:.9f},100\n" for a, x in zip(t, moved, strict=True)).replace(",100", ",101", 1)
    (tmp_path / "log.csv").write_text("t_s,x_mm,x_force\n" + rows)
    assert run(["identify", f"{tmp_path}/log.csv", "--json", "--summary", f"{tmp_path}/s.json"]) == 0
    (said,) = (json.loads(line) for line in capsys.readouterr().err.splitlines() if line.startswith("{"))
    assert said["code"] == "identify-undetermined"
    spread = json.loads((tmp_path / "s.json").read_text())["axes"]["x"]["uncertainty"]
    assert said["values"]["parameters"] == [name for name, value in spread.items() if value is None]
    assert {"gain", "bias", "coulomb"} <= set(said["values"]["parameters"])


def test_kc_of_a_torque_motor_and_the_frequency_response(
    log: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    call = ["identify", log, "--axis", "x", "--counts-per-mm", "1000", "--counts-per-rad", "500"]
    assert run([*call, "--summary", f"{tmp_path}/s.json", "-o", f"{tmp_path}/x.toml"]) == 0
    said = capsys.readouterr().err
    assert "velocity_gain_rad_s_volt (Kc)" in said
    assert run(["identify", log, "--axis", "x", "--counts-per-mm", "1000"]) == 2
    assert run(["identify", log, "--axis", "x", "--model", "etfe", "-q", "-o", f"{tmp_path}/e.csv"]) == 0
    head, *rows = (tmp_path / "e.csv").read_text().splitlines()
    assert head.split(",")[0].startswith("frequency")
    slowest = [float(cell) for cell in rows[0].split(",")]
    assert len(rows) > 10
    assert len(slowest) == len(head.split(","))
