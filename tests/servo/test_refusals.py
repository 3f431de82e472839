"""Servo data that are right by themselves and do not go with what is asked of them: said, with the reason, exit 2."""

from __future__ import annotations

from pathlib import Path

import pytest

from cncgen.cli.app import run

RATIO = 'model = "transfer-function"\nnumerator = {0}\ndenominator = {1}\n{2}\n'
PLANT = 'model = "plant"\nnumerator = [1.0]\ndenominator = [1.0, 1.0, 0.0]\nposition_gain_1_mm = 1.0\n{0}\n'
FIRST_ORDER = 'model = "first-order"\nposition_gain_1_s = 40.0\n{0}\n'
LAG = RATIO.format("[1.0]", "[0.01, 1.0]", "")
#: It answers a constant setpoint with 0: (z − 1)/(z − 0.5).
BLOCKING = RATIO.format("[1.0, -1.0]", "[1.0, -0.5]", "sample_time_s = 0.001")


@pytest.mark.parametrize(
    ("table", "controller", "told"),
    [
        (LAG, "ccc", "ccc: it acts on the drives, and a closed loop given as a whole has none"),
        (LAG, "tcf", "the model transfer-function has no plant that another controller could drive"),
        (LAG, "h-infinity", "axis X: it is designed for the model plant, not transfer-function"),
        (BLOCKING, "zpetc", "the loop has a zero at z = 1 and cannot be inverted"),
        (BLOCKING, "feedforward", "the loop does not reach its setpoint at rest"),
        (RATIO.format("[0.5, 1.0]", "[0.01, 1.0]", "backlash_mm = 0.01"), "p", "without direct feedthrough"),
        (RATIO.format("[1.0]", "[1.0, -0.5]", "sample_time_s = 0.001\ndelay_s = 0.0005"), "p", "whole number of its sample"),
        (FIRST_ORDER.format(""), "tcf", "needs plants with a position and a velocity state, and a lag"),
        (PLANT.format(""), "h-infinity", "axis X: its table has no weights (sensitivity_bandwidth_rad_s"),
        (PLANT.format("delay_s = 0.9"), "p", "a dead time of 0.9 s is more than 250 control periods of 0.001 s"),
        (PLANT.format("delay_s = 0.0005\ncoulomb = 1.0"), "p", "the dead time 0.0005 s must be a whole number"),
        (PLANT.format("control_period_s = 0.0007"), "p", "must be a whole multiple of the control period 0.0007 s"),
        (PLANT.format("control_period_s = 1e-8"), "p", "1e+05 control periods of 1e-08 s in a setpoint of 0.001 s"),
        (PLANT.replace("1.0, 1.0, 0.0", "1.0, 1.0").format("viscous_s_mm = 1.0"), "p", "needs a plant with a velocity state"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], table: str, controller: str, told: str
) -> None:
    assert simulated(tmp_path, table, table, controller) == 2
    said = capsys.readouterr()
    assert told in said.err
    assert said.out == ""


@pytest.mark.parametrize("controller", ["ccc", "tcf"])
def test_axes_of_two_control_periods_are_not_coupled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], controller: str
) -> None:
    tables = FIRST_ORDER.format(""), FIRST_ORDER.format("control_period_s = 0.0005")
    assert simulated(tmp_path, *tables, controller) == 2
    said = capsys.readouterr().err
    assert "it couples axes of one control period, and theirs are 0.0005 s and 0.001 s" in said
    assert simulated(tmp_path, *tables, "p") == 0


def simulated(folder: Path, x: str, y: str, controller: str) -> int:
    """Simulate a short diagonal under two tables; return the exit code."""
    rows = "".join(f"{k / 1000:.3f},{k * 1e-3:.6f},{k * 1e-3:.6f}\n" for k in range(20))
    (folder / "s.csv").write_text("t_s,x_mm,y_mm\n" + rows)
    (folder / "servo.toml").write_text(f"[axes.x.servo]\n{x}[axes.y.servo]\n{y}")
    call = ["simulate", f"{folder}/s.csv", "--axis-params", f"{folder}/servo.toml"]
    return run([*call, "--controller", controller, "-q"])
