"""The servo commands end to end: excite, simulate, identify, compensate, tune, reproduce, plot."""

import json

import numpy as np

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


def test_compensate_writes_a_better_command_or_refuses(tmp_path, programs, capfd):
    plan, command = str(tmp_path / "plan.csv"), tmp_path / "command.csv"
    assert run(["plan", str(programs / "circle.nc"), "-m", "xy-table", "-o", plan, "-q"]) == 0
    assert run(["compensate", plan, "--axis-params", "xy-table", "-o", str(command)]) == 3
    assert "compensate-limit" in capfd.readouterr().err
    assert not command.exists()
    summary = tmp_path / "gain.json"
    code = run(
        [
            "compensate",
            plan,
            "--axis-params",
            "xy-table",
            "--no-limits",
            "-o",
            str(command),
            "--summary",
            str(summary),
        ]
    )
    assert code == 0
    assert json.loads(summary.read_text())["contour_max_ratio"] > 5.0


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
    assert "worse" not in said
    gained = json.loads(summary.read_text())
    assert gained["contour_max_ratio"] is gained["after"]["contour_max_mm"] is None
    assert 0.0 < gained["after"]["tracking_max_deg"] < 0.1 * gained["before"]["tracking_max_deg"]
    assert run(["tune", str(program), "--sets", "4", "-o", str(tmp_path / "t.toml")]) == 2
    assert "error[tune-search]: gain sets are judged by the contour error" in capfd.readouterr().err


def test_compensate_says_whether_more_or_fewer_passes_help(tmp_path, capfd):
    """P loops of 50 1/s, one with a lag of 10 ms: one pass leaves a corner farther off, four bring it nearer."""
    program, machine = tmp_path / "corner.nc", tmp_path / "m.toml"
    program.write_text("G21 G90\nG1 X60 F6000\nY60\nM2\n")
    limits = "max_velocity_mm_s = 250\nmax_acceleration_mm_s2 = 2500\nmax_jerk_mm_s3 = 50000\n"
    servo = 'servo = { model = "first-order", position_gain_1_s = 50.0'
    axes = f"[axes.x]\n{limits}{servo} }}\n[axes.y]\n{limits}{servo}, time_constant_s = 0.01 }}\n"
    machine.write_text(f'name = "lag"\nperiod_s = 0.001\n{axes}')
    call = ["compensate", str(program), "-m", str(machine), "-o", str(tmp_path / "c.csv")]
    assert run([*call, "--passes", "1"]) == 0
    assert "farther from the path: use more passes" in capfd.readouterr().err
    assert run([*call, "--passes", "4"]) == 0
    assert "passes, or a plan" not in capfd.readouterr().err


def test_compensate_gives_up_where_passes_multiply_the_command(tmp_path, programs, capfd):
    """At high frequencies 1 − G is above 1, so twenty passes ask for hundreds of times the jerk: no plan is slow enough."""
    command = tmp_path / "c.csv"
    program = str(programs / "square_sharp.nc")
    assert run(["compensate", program, "-m", "xy-table", "--passes", "20", "-o", str(command)]) == 3
    said = capfd.readouterr().err
    assert "error[compensate-room]" in said
    assert "error[compensate-limit]" in said
    assert not command.exists()


def test_compensate_plans_a_program_with_the_room_that_its_command_needs(tmp_path, programs, capfd):
    """The command's own finite differences keep the limits, and the error falls by more than ten times."""
    program = programs / "butterfly.nc"  # at 7000 mm/min
    command, summary = tmp_path / "command.csv", tmp_path / "gain.json"
    arguments = ["compensate", str(program), "-m", "xy-table", "-o", str(command), "--summary", str(summary)]
    assert run(arguments) == 0
    said = capfd.readouterr().err
    assert "to leave room: " in said
    assert "X jerk 0." in said
    gained = json.loads(summary.read_text())
    assert gained["contour_max_ratio"] >= 10.0
    assert gained["full_before"]["contour_max_mm"] >= 10.0 * gained["after"]["contour_max_mm"]
    assert gained["time_s"] > gained["full_time_s"]
    rows = np.loadtxt(command, delimiter=",", skiprows=1)[:, 1:]
    padded = np.concatenate([np.repeat(rows[:1], 3, axis=0), rows, np.repeat(rows[-1:], 3, axis=0)])
    for order, limit in ((1, 250.0), (2, 2450.0), (3, 50000.0)):
        assert np.abs(np.diff(padded, order, axis=0)).max() / 0.001**order <= limit * 1.001
    assert run(["compensate", str(program), "-o", str(command)]) == 2
    assert run(["compensate", str(program), "--axis-params", "xy-table", "-o", str(command)]) == 2


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
