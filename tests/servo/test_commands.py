"""The servo commands end to end: excite, simulate, identify, compensate, tune, reproduce, plot."""

import json

import numpy as np
import pytest

from cncgen.cli.app import run


def test_an_axis_is_excited_simulated_and_identified(tmp_path, capfd):
    sweep, log, summary = (str(tmp_path / name) for name in ("sweep.csv", "log.csv", "s.json"))
    assert run(["excite", "-m", "xy-table", "--axis", "x", "--duration", "4", "-o", sweep]) == 0
    assert run(["simulate", sweep, "--axis-params", "dyna-1007", "-o", log]) == 0
    assert run(["identify", log, "--summary", summary]) == 0
    found = json.loads((tmp_path / "s.json").read_text())["axes"]["x"]["parameters"]
    assert abs(found["time_constant_s"] - 0.0047) < 1e-6
    assert run(["identify", log, "--model", "etfe", "-o", str(tmp_path / "h.csv")]) == 0
    assert (tmp_path / "h.csv").read_text().startswith("frequency_hz,magnitude,phase_deg,coherence")
    assert run(["identify", log, "--axis", "Y"]) == 2
    assert "log-columns" in capfd.readouterr().err


def test_a_fourth_order_fit_is_a_servo_table_that_simulates(tmp_path):
    sweep, log, table = (str(tmp_path / name) for name in ("sweep.csv", "log.csv", "found.toml"))
    assert run(["excite", "-m", "xy-table", "--axis", "X", "--duration", "3", "--low", "1", "-o", sweep]) == 0
    assert run(["simulate", sweep, "--axis-params", "xy-table", "-o", log]) == 0
    assert run(["identify", log, "--model", "fourth-order", "-o", table]) == 0
    assert run(["simulate", sweep, "--axis-params", table, "-o", str(tmp_path / "again.csv")]) == 0


def test_compensate_writes_a_better_command_within_the_limits(tmp_path, programs, capfd):
    """A plan to the limits leaves no room, and yet the command keeps them; without limits it follows better still."""
    plan, command, summary = str(tmp_path / "plan.csv"), str(tmp_path / "command.csv"), tmp_path / "gain.json"
    assert run(["plan", str(programs / "circle.nc"), "-m", "xy-table", "-o", plan, "-q"]) == 0
    call = [
        "compensate",
        plan,
        "--axis-params",
        "xy-table",
        "-o",
        command,
        "--draws",
        "4",
        "--summary",
        str(summary),
    ]
    ratios = []
    for more in (["--no-limits"], []):
        assert run([*call, *more]) == 0
        assert "with every parameter within 10 % (4 draws): largest error median" in capfd.readouterr().err
        ratios.append(json.loads(summary.read_text())["contour_max_ratio"])
    assert ratios[0] > ratios[1] > 10.0
    assert run(["verify", command, "--program", str(programs / "circle.nc"), "-m", "xy-table", "--json"]) == 1
    said = capfd.readouterr().err  # it leaves the path, as it must, and keeps every limit
    assert "verify-distance" in said
    assert not any(f"verify-{limit}" in said for limit in ("velocity", "acceleration", "jerk"))


def test_compensate_refuses_what_gains_nothing_and_writes_no_file(tmp_path, programs, capfd):
    """Noise of 50 µm is all that the stiff axes err by, and no command knows it ahead."""
    command, servos = tmp_path / "command.csv", tmp_path / "noisy.toml"
    table = 'model = "first-order"\nposition_gain_1_s = 500.0\nnoise_rms_mm = 0.05\n'
    servos.write_text("".join(f"[axes.{k}.servo]\n{table}" for k in "xy"))
    program = tmp_path / "slow.nc"
    program.write_text("G21 G90 G17 G61\nG2 X0 Y0 I1 J0 F60\nM2\n")
    call = ["compensate", str(program), "-m", "xy-table", "--axis-params", str(servos), "-o", str(command)]
    assert run(call) == 3
    said = capfd.readouterr().err
    assert "error[compensate-no-gain]: no command follows better: the largest error is" in said
    assert "with the best command within the limits" in said
    assert not command.exists()


def test_rotary_axes_alone_have_no_contour_error(tmp_path, capfd):
    """compensate says what it gains in degrees (and compares that); tune has nothing to judge gain sets by."""
    program, summary = tmp_path / "turn.nc", tmp_path / "gain.json"
    program.write_text("G1 A90 F3600\nM2\n")
    command = str(tmp_path / "c.csv")
    assert (
        run(["compensate", str(program), "-m", "generic-mill", "-o", command, "--summary", str(summary)]) == 0
    )
    said = capfd.readouterr().err
    assert "mdeg" in said
    assert "contour" not in said
    gained = json.loads(summary.read_text())
    assert gained["contour_max_ratio"] is gained["after"]["contour_max_mm"] is None
    assert 0.0 < gained["after"]["tracking_max_deg"] < 0.2 * gained["before"]["tracking_max_deg"]
    assert run(["tune", str(program), "--sets", "4", "-o", str(tmp_path / "t.toml")]) == 2
    assert "error[tune-search]: gain sets are judged by the contour error" in capfd.readouterr().err


def test_compensate_plans_a_program_with_room_where_its_command_needs_some(tmp_path, capfd):
    """Friction of 0.3 mm, and loops of 60/s: a plan to the limits leaves too little acceleration to push through it."""
    command, summary, servos = tmp_path / "command.csv", tmp_path / "gain.json", tmp_path / "slow.toml"
    servos.write_text(
        "".join(
            f'[axes.{k}.servo]\nmodel = "first-order"\nposition_gain_1_s = 60.0\ncoulomb_lag_mm = 0.3\n'
            for k in "xy"
        )
    )
    program = tmp_path / "triangle.nc"
    program.write_text("G21 G90 G64 P0.01 F6000\nG1 X8 Y1\nX2 Y9\nX0 Y0\nM2\n")
    wanted, response = str(tmp_path / "wanted.csv"), tmp_path / "response.json"
    call = ["compensate", str(program), "-m", "xy-table", "--axis-params", str(servos), "-o", str(command),
            "--summary", str(summary), "--perturb", "0%", "--wanted", wanted]  # fmt: skip
    assert run(call) == 0
    assert " % of acceleration and jerk, to leave room: " in capfd.readouterr().err
    gained = json.loads(summary.read_text())
    assert gained["room"] < 1.0
    assert gained["contour_max_ratio"] >= 5.0
    assert gained["time_s"] > gained["full_time_s"]
    simulate = ["simulate", str(command), "--axis-params", str(servos), "--reference", wanted, "-q"]
    assert run([*simulate, "-o", str(tmp_path / "r.csv"), "--summary", str(response)]) == 0
    errors = json.loads(response.read_text())["reference"]
    assert errors["contour_error_max_mm"] == pytest.approx(gained["after"]["contour_max_mm"], abs=1e-6)
    assert errors["tracking_max_mm"] == pytest.approx(gained["after"]["tracking_max_mm"], abs=1e-6)
    assert run([*call, "--room", "100%"]) == 0
    full = json.loads(summary.read_text())
    assert full["room"] == 1.0
    assert full["time_s"] == full["full_time_s"] == gained["full_time_s"]
    assert full["after"]["contour_max_mm"] > gained["after"]["contour_max_mm"]


def test_tune_writes_servo_tables(tmp_path, capfd):
    table = str(tmp_path / "tuned.toml")
    assert run(["tune", "-m", "xy-table", "--bandwidth", "30", "-o", table]) == 0
    err = capfd.readouterr().err
    assert "phase margin" in err
    assert "magnitude dB" in err
    assert run(["tune", "-m", "xy-table", "--axis-params", table, "--bandwidth", "20", "--no-bode"]) == 0
    assert run(["tune", "-m", "xy-table"]) == 2


def test_coupling_gains_are_tuned_written_and_used(tmp_path, programs, capfd):
    program, table, summary = str(programs / "circle.nc"), str(tmp_path / "t.toml"), tmp_path / "s.json"
    tune = ["tune", program, "-m", "dyna-1007", "--sets", "10", "--no-bode", "-o", table, "--jobs", "1"]
    for controller in ("ccc", "tcf"):
        assert run([*tune, "--controller", controller, "--summary", str(summary)]) == 0
        found = json.loads(summary.read_text())
        assert found["search"]["contour_rms_mm"] <= found["search"]["start_contour_rms_mm"]
        assert all(loop["modulus_margin"] >= 0.25 for loop in found["loops"])
        simulate = [
            "simulate",
            program,
            "-m",
            "dyna-1007",
            "--axis-params",
            table,
            "--controller",
            controller,
        ]
        assert run([*simulate, "-o", str(tmp_path / "r.csv"), "--summary", str(summary)]) == 0
        again = json.loads(summary.read_text())["contour_error_rms_mm"]
        assert abs(again - found["search"]["contour_rms_mm"]) < 1e-12
    assert "modulus margin" in capfd.readouterr().err
    (tmp_path / "bad.toml").write_text((tmp_path / "t.toml").read_text() + "tcf_gain = 1.0\n")
    assert run(["simulate", program, "-m", "dyna-1007", "--axis-params", str(tmp_path / "bad.toml")]) == 2
    assert "coupling.tcf_gain: unknown key" in capfd.readouterr().err


def test_compare_sets_controllers_side_by_side_and_says_which_cannot_be_had(tmp_path, programs, capfd):
    program, summary = str(programs / "circle.nc"), tmp_path / "s.json"
    command = ["compare", program, "-m", "dyna-1007", "--summary", str(summary), "--controllers"]
    assert run([*command, "p,zpetc,ccc,zpetc+ccc,tcf"]) == 0
    names = [c["controller"] for c in json.loads(summary.read_text())["controllers"]]
    assert names == ["p", "zpetc", "ccc", "zpetc+ccc", "tcf"]
    pure = tmp_path / "pure.toml"
    tables = [f'[axes.{k}.servo]\nmodel = "first-order"\nposition_gain_1_s = 50.0\n' for k in "xy"]
    pure.write_text("\n".join(tables))
    assert run([*command, "p,tcf", "--axis-params", str(pure)]) == 0
    assert "velocity state" in capfd.readouterr().out
    assert "velocity state" in json.loads(summary.read_text())["controllers"][1]["fault"]
    assert run([*command, "tcf", "--axis-params", str(pure)]) == 2
    assert run([*command, "p,pid"]) == 2


def test_reproduce_prints_a_table_and_its_exit_code(tmp_path, capfd):
    summary = tmp_path / "s.json"
    assert run(["reproduce", "002", "--summary", str(summary)]) == 0
    values = json.loads(summary.read_text())
    assert values["holds"] is True
    keys = {
        "figure",
        "printed",
        "ours",
        "unit",
        "asked",
        "holds",
        "outcome",
        "basis",
        "sensitivity",
        "reason",
    }
    assert keys <= set(values["tables"][0]["rows"][0])
    assert "not reproducible: 10 items" in capfd.readouterr().out
    page = tmp_path / "page.md"
    assert run(["reproduce", "002", "-o", str(page)]) == 0
    assert page.read_text().startswith("# The papers, item by item\n")
    assert run(["reproduce", "nothing"]) == 2


def test_plot_draws_programs_setpoints_and_responses(tmp_path, programs, capfd):
    folder, plan, response = tmp_path / "p", str(tmp_path / "plan.csv"), str(tmp_path / "r.csv")
    program = str(programs / "circle.nc")
    assert run(["plot", program, "-m", "xy-table", "-o", str(folder)]) == 0
    names = {"path.png", "feed.png", "axes.png", "curvature.png", "force.png", "errors.png"}
    assert {f.name for f in folder.iterdir()} == names
    assert run(["plan", program, "-m", "xy-table", "-o", plan]) == 0
    assert run(["simulate", plan, "--axis-params", "xy-table", "-o", response]) == 0
    assert run(["plot", plan, "--kinds", "feed", "-o", str(tmp_path / "feed.svg")]) == 0
    assert run(["plot", response, "--kinds", "errors", "-o", str(tmp_path / "errors.pdf")]) == 0
    assert run(["plot", plan, "--kinds", "errors", "-o", str(tmp_path / "no.png")]) == 2
    assert "plot-needs-response" in capfd.readouterr().err


def test_a_flexible_stage_is_designed_by_h_infinity_and_simulated(tmp_path, capfd):
    table = str(tmp_path / "designed.toml")
    assert run(["tune", "-m", "flexure-stage", "--controller", "h-infinity", "-o", table]) == 0
    assert "the bounds hold for 9 plants" in capfd.readouterr().err
    program = tmp_path / "dot.nc"
    program.write_text("G21 G90 F30\nG1 X0.05\nG1 Y0.02\nM2\n")
    compared = tmp_path / "c.json"
    command = ["compare", str(program), "-m", "flexure-stage", "--controllers", "p,h-infinity"]
    assert run([*command, "--summary", str(compared)]) == 0
    own, designed = (c["axes"]["x"] for c in json.loads(compared.read_text())["controllers"])
    assert designed["tracking_rms_mm"] < 0.5 * own["tracking_rms_mm"]
    simulate = ["simulate", str(program), "-m", "flexure-stage", "--axis-params", table]
    assert run([*simulate, "-o", str(tmp_path / "r.csv"), "--summary", str(compared)]) == 0
    assert json.loads(compared.read_text())["axes"]["x"] == designed
    capfd.readouterr()
    assert (
        run(["tune", "-m", "flexure-stage", "--controller", "h-infinity", "--bandwidth", "8", "-o", table])
        == 3
    )
    assert "tune-bounds" in capfd.readouterr().err


def test_from_a_log_to_tuned_gains(tmp_path):
    """excite, log, identify the drive, place PD on it, simulate: each file goes into the next command."""
    sweep, log, found, tuned = (
        str(tmp_path / n) for n in ("sweep.csv", "log.csv", "found.toml", "tuned.toml")
    )
    assert run(["excite", "-m", "dyna-1007", "--axis", "x", "--duration", "4", "-o", sweep]) == 0
    assert run(["simulate", sweep, "--axis-params", "dyna-1007", "-o", log]) == 0
    assert run(["identify", log, "-o", found]) == 0
    assert run(["simulate", sweep, "--axis-params", found, "-o", str(tmp_path / "r.csv")]) == 0
    summary = tmp_path / "s.json"
    tune = [
        "tune",
        "-m",
        "dyna-1007",
        "--axis-params",
        found,
        "--bandwidth",
        "40",
        "--damping",
        "0.8",
        "--no-bode",
    ]
    assert run([*tune, "-o", tuned, "--summary", str(summary)]) == 0
    gains = json.loads(summary.read_text())["axes"]["x"]
    # PD round 1/(s(τs + 1)): Kp = ω²τ, Kd = 2ζωτ − 1.
    omega, lag = 2 * np.pi * 40, 0.0047
    assert abs(gains["position_gain_1_mm"] / (omega**2 * lag) - 1) < 1e-4
    assert abs(gains["derivative_gain_s_mm"] / (1.6 * omega * lag - 1) - 1) < 1e-4
    assert run(["simulate", sweep, "--axis-params", tuned, "-o", str(tmp_path / "r.csv")]) == 0
