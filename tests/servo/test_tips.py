"""Contour errors of the tool's tip: closed forms of axes that carry table or head, and a program under G43.4."""

import csv
import json

import numpy as np
import pytest

from cncgen.cli.app import run as cncgen
from cncgen.machine.kinematics import Kinematics
from cncgen.machine.record import Servo
from cncgen.pipeline import simulate
from cncgen.servo.tips import tips_on_workpiece
from cncgen.setpoints.record import Setpoints

from .bench import ROOT

PERIOD = 0.001
GAIN, SPEED = 60.0, 0.8  # 1/s, rad/s
TIMES = np.arange(3000) * PERIOD
SERVOS = {letter: Servo("first-order", {"position_gain_1_s": GAIN}) for letter in "XYZABC"}
#: Response of an axis to e^(iωt): k/(z − 1 + k), k = Kv T; a ramp lags by ω/Kv (`test_simulate`).
SWING = GAIN * PERIOD / (np.exp(1j * SPEED * PERIOD) - 1.0 + GAIN * PERIOD)
LAG = np.exp(-1j * SPEED / GAIN)


def run(axes, rows, kinematics, length=0.0, chunk=1000, **more):
    parts = [
        Setpoints(
            axes, PERIOD, k, rows[k : k + chunk], {"tool_length": np.full(len(rows[k : k + chunk]), length)}
        )
        for k in range(0, len(rows), chunk)
    ]
    return list(simulate(iter(parts), SERVOS, kinematics=kinematics, **more))


def errors(responses):
    return np.concatenate([part.contour_error_mm for part in responses])


def test_a_table_that_turns_under_a_tip_that_rests_on_the_workpiece():
    """m = R e^(−iθ) is followed as R conj(G) e^(−iθ), θ as θ − ω/Kv: the tip is R |1 − conj(G) e^(−iω/Kv)| off the point."""
    radius = 50.0
    turned = SPEED * TIMES
    rows = np.column_stack(
        [radius * np.cos(turned), -radius * np.sin(turned), 0.0 * turned, 0.0 * turned, turned]
    )
    found = run("XYZAC", rows, Kinematics(0, (3, 5)))
    expected = radius * abs(1.0 - np.conj(SWING) * LAG)
    assert expected > 4e-3
    assert errors(found)[-500:] == pytest.approx(np.full(500, expected), abs=1e-9)
    assert all((part.tool_length_mm == 0.0).all() for part in found)


@pytest.mark.parametrize("chunk", [37, 3000])
def test_a_head_that_tilts_about_a_tip_that_rests(chunk):
    """Z + iX = (L + P) e^(iθ) is followed with G, θ as θ − ω/Kv: the tip is (L + P) |G − e^(−iω/Kv)| off."""
    length, pivot = 80.0, 120.0
    arm = (length + pivot) * np.exp(1j * SPEED * TIMES)
    still = 0.0 * TIMES
    rows = np.column_stack([arm.imag, still, arm.real - pivot, SPEED * TIMES, still])
    found = run("XYZBC", rows, Kinematics(2, (5, 4), pivot=pivot), length, chunk)
    expected = (length + pivot) * abs(SWING - LAG)
    assert expected > 1e-2
    assert errors(found)[-500:] == pytest.approx(np.full(500, expected), abs=1e-9)


def test_the_last_length_holds_while_the_axes_settle():
    rows = np.zeros((10, 5))
    found = run("XYZAC", rows, Kinematics(0, (3, 5)), 25.0, settle_s=0.005)
    assert np.concatenate([part.tool_length_mm for part in found]).tolist() == [25.0] * 15


@pytest.mark.parametrize(
    ("axes", "kinematics", "signals"),
    [("XYZAC", None, True), ("XYZAC", Kinematics(0, (3, 5)), False), ("XYZB", Kinematics(0, (3, 5)), True)],
    ids=["no kinematics", "no lengths", "other axes"],
)
def test_else_contour_errors_are_those_of_the_slides(axes, kinematics, signals):
    rows = np.column_stack([np.sin(TIMES), np.cos(TIMES), *([TIMES] * (len(axes) - 2))])
    lengths = {"tool_length": np.zeros(len(rows))} if signals else {}
    [found] = simulate(iter([Setpoints(axes, PERIOD, 0, rows, lengths)]), SERVOS, kinematics=kinematics)
    [plain] = simulate(iter([Setpoints(axes, PERIOD, 0, rows)]), SERVOS)
    assert found.tool_length_mm is None
    assert np.array_equal(found.contour_error_mm, plain.contour_error_mm)


def test_tips_are_where_one_place_at_a_time_has_them():
    mechanism = Kinematics(1, (4, 5), (3.0, -2.0, 40.0), 150.0)
    rows = np.random.default_rng(2026).uniform(-1.0, 1.0, (5, 5)) * [100.0, 100.0, 100.0, 1.5, 3.0]
    lengths = np.array([0.0, 10.0, 20.0, 50.0, 80.0])
    expected = [
        mechanism.tip(tuple(row[:3]), tuple(np.degrees(row[3:])), length)
        for row, length in zip(rows, lengths, strict=True)
    ]
    assert tips_on_workpiece(mechanism, "XYZBC", rows, lengths) == pytest.approx(
        np.array(expected), abs=1e-12
    )


PROGRAM = """G21 G90 G17 G40 G49 G80 G64
T1 M6
G0 X30 Y0 Z50 A0 C0
G43.4 H1
G0 Z0
G1 X-30 Y40 A20 C90 F2000
G0 Z30
G49
M30
"""


@pytest.fixture
def five_axes(tmp_path, monkeypatch):
    """A directory with the program, a table of tools and a machine whose table A carries C."""
    monkeypatch.chdir(tmp_path)
    text = (
        (ROOT / "cncgen" / "machine" / "profiles" / "generic-mill.toml")
        .read_text()
        .replace("feedforward_gain = 0.97", "feedforward_gain = 0.5")
    )
    table = '[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\ncentre_mm = [0.0, 0.0, -100.0]\n'
    (tmp_path / "five.toml").write_text(f"{text}\n{table}")
    (tmp_path / "tools.tbl").write_text("T1 P1 Z80 D6\n")
    (tmp_path / "part.nc").write_text(PROGRAM)
    return tmp_path


READING = ("-m", "five.toml", "--dialect", "fanuc", "--tool-table", "tools.tbl")


def turned_back(x, y, z, a, c, length=80.0):
    """Return the tip of a tool of that length from the slides, by the matrices of A and C, which meet at Z-100."""
    a, c, z = np.radians(a), np.radians(c), z - length + 100.0
    y, z = y * np.cos(a) - z * np.sin(a), y * np.sin(a) + z * np.cos(a)
    return np.column_stack([x * np.cos(c) - y * np.sin(c), x * np.sin(c) + y * np.cos(c), z - 100.0])


def distance_to(path, point):
    """Return the distance of a point to the nearest of all segments."""
    step = np.diff(path, axis=0)
    along = ((point - path[:-1]) * step).sum(axis=1) / np.maximum((step * step).sum(axis=1), 1e-300)
    feet = path[:-1] + np.clip(along, 0.0, 1.0)[:, None] * step
    return np.linalg.norm(feet - point, axis=1).min()


def test_a_program_under_tool_centre_point_control(five_axes, capfd):
    assert cncgen(["simulate", "part.nc", *READING, "-o", "r.csv", "--summary", "s.json"]) == 0
    assert "contour error of the tip on the workpiece rms" in capfd.readouterr().err
    assert json.loads((five_axes / "s.json").read_text())["contour_error_of"] == "tip"
    with (five_axes / "r.csv").open() as file:
        rows = list(csv.DictReader(file))
    names = ("x_mm", "y_mm", "z_mm", "a_deg", "c_deg")
    actual, asked = (
        turned_back(
            *(np.array([float(row[name.replace("_", between, 1)]) for row in rows]) for name in names)
        )
        for between in ("_", "_cmd_")
    )
    asked_c = np.array([float(row["c_cmd_deg"]) for row in rows])
    turning = np.flatnonzero((asked_c > 5.0) & (asked_c < 85.0))
    told = np.array([float(row["contour_error_mm"]) for row in rows])
    near = slice(turning[0] - 500, turning[-1] + 500)
    chosen = turning[::40]
    assert told[chosen].max() > 0.001
    assert told[chosen] == pytest.approx([distance_to(asked[near], actual[k]) for k in chosen], abs=1e-8)
    # The tip of the plan stays on the line of the program, within the 10 µm of G64.
    line = np.array([[30.0, 0.0, 0.0], [-30.0, 40.0, 0.0]])
    assert max(distance_to(line, asked[k]) for k in chosen) < 0.01


def test_setpoints_alone_do_not_have_the_tools_length(five_axes, capfd):
    assert cncgen(["plan", "part.nc", *READING, "-o", "p.csv", "--signals", "tool_length"]) == 0
    with (five_axes / "p.csv").open() as file:
        lengths = [float(row["tool_length_mm"]) for row in csv.DictReader(file)]
    assert sorted(set(lengths)) == [0.0, 80.0]
    capfd.readouterr()
    assert cncgen(["simulate", "p.csv", "-m", "five.toml", "-o", "r.csv", "--summary", "s.json"]) == 0
    assert "contour error of X Y Z alone rms" in capfd.readouterr().err
    assert json.loads((five_axes / "s.json").read_text())["contour_error_of"] == "XYZ"


def test_against_the_program_setpoints_are_judged_at_the_tip(five_axes, capfd):
    assert cncgen(["plan", "part.nc", *READING, "-o", "p.csv"]) == 0
    capfd.readouterr()
    assert (
        cncgen(
            ["simulate", "p.csv", *READING, "--reference", "part.nc", "-o", "r.csv", "--summary", "s.json"]
        )
        == 0
    )
    assert "contour error of the tip on the workpiece rms" in capfd.readouterr().err
    found = json.loads((five_axes / "s.json").read_text())["reference"]
    assert found["contour_error_of"] == "tip"
    assert cncgen(["simulate", "part.nc", *READING, "-o", "q.csv"]) == 0
    with (five_axes / "q.csv").open() as file:
        largest = max(float(row["contour_error_mm"]) for row in csv.DictReader(file))
    # The path of the program is within the chord tolerance and G64's 10 µm of the setpoints.
    assert found["contour_error_max_mm"] == pytest.approx(largest, abs=0.011)
