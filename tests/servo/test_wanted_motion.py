"""Responses judged against the wanted motion, and on machines that are not quite the model."""

import json

import numpy as np
import pytest

from cncgen.cli.app import run as cncgen
from cncgen.diagnostics import UsageError
from cncgen.machine import load_machine
from cncgen.machine.record import Servo
from cncgen.pipeline import plan, read, read_text, sample
from cncgen.report.plot_data import against, of_response
from cncgen.servo.response_spread import drawn_figures, interval, spread_values
from cncgen.servo.simulate import simulate
from cncgen.servo.uncertainty import Perturbation
from cncgen.servo.wanted_motion import judged_against, reference_of, wanted_of_program

from .bench import circle, profile, stream

STIFF = {k: Servo("transfer-function", {"numerator": [1.0], "denominator": [1.0]}) for k in "XY"}


def test_the_contour_error_is_the_distance_from_the_programmed_path():
    """Axes that follow at once along a circle of 9.99 mm, judged by a program of 10 mm: 10 µm everywhere."""
    program = "(START, X10 Y0)\nG21 G90 G17 G61\nG3 X10 Y0 I-10 J0 F3000\nM2\n"
    plan = stream(circle(10.0, 50.0, turns=1.0))
    reference = wanted_of_program("circle", plan, read_text(program).chunks(), load_machine("xy-table"))
    assert reference.path_axes == "XY"
    assert np.hypot(*reference.path.T) == pytest.approx(10.0, abs=1e-5)
    found = judged_against(reference, list(simulate(stream(circle(9.99, 50.0 * 0.999, turns=0.9)), STIFF)))
    assert found["contour_error_max_mm"] == pytest.approx(0.01, abs=1e-5)
    assert found["contour_error_rms_mm"] == pytest.approx(0.01, abs=1e-5)
    assert found["tracking_max_mm"] == pytest.approx(0.01, abs=1e-4)
    assert found["shift_s"] == 0.0


def test_a_command_that_begins_before_the_motion_is_laid_over_it():
    u = np.linspace(0.0, 1.0, 801)
    angle = 6.0 * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    rows = 10.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    early = np.concatenate([np.repeat(rows[:1], 37, axis=0), rows + 0.001, np.repeat(rows[-1:], 20, axis=0)])
    found = judged_against(reference_of("plan", stream(rows)), list(simulate(stream(early), STIFF)))
    assert found["shift_s"] == pytest.approx(0.037)
    assert found["tracking_max_mm"] == pytest.approx(0.001 * np.sqrt(2.0), rel=1e-6)


def test_references_that_do_not_fit_are_refused():
    rows = circle(10.0, 50.0, turns=0.1)
    responses = list(simulate(stream(rows), STIFF))
    with pytest.raises(UsageError, match="reference-axes"):
        judged_against(reference_of("x", stream(rows[:, :1], "X")), responses)
    with pytest.raises(UsageError, match="reference-period"):
        judged_against(reference_of("slow", stream(rows, period=0.002)), responses)
    with pytest.raises(UsageError, match="setpoints-empty"):
        reference_of("nothing", [])


def test_ninety_percent_of_machines_are_in_the_interval():
    """200 machines drawn by numpy, and not by the sequence that made the interval: 90 ± 6 % (three standard deviations)."""
    rows, servos = circle(10.0, 60.0, turns=0.5, ramp=0.1), profile("dyna-1007")
    drawn = drawn_figures(list(stream(rows)), servos, Perturbation(0.1, 128))
    low, high = interval(drawn["contour_error_max_mm"])
    rng, inside = np.random.default_rng(11), 0
    for _ in range(200):
        machine = {
            k: Servo(s.model, {n: v * rng.uniform(0.9, 1.1) for n, v in s.parameters.items()})
            for k, s in servos.items()
        }
        error = max(float(r.contour_error_mm.max()) for r in simulate(stream(rows), machine))
        inside += low <= error <= high
    assert 168 <= inside <= 192


def test_unstable_machines_are_counted():
    servos = {k: Servo("first-order", {"position_gain_1_s": 1950.0}) for k in "XY"}
    found = drawn_figures(list(stream(circle(10.0, 60.0, turns=4.0))), servos, Perturbation(0.1, 16))
    values = spread_values(found, Perturbation(0.1, 16))
    assert 0 < values["unstable"] < 16
    assert values["contour_error_max_mm"]["worst"] is None


def test_simulate_gives_both_beside_the_errors_against_the_command(tmp_path, programs, capfd):
    """The gain of a compensated command shows against the program alone: against itself the command is as bad as ever."""
    program, command, summary = str(programs / "circle.nc"), str(tmp_path / "c.csv"), tmp_path / "s.json"
    assert cncgen(["compensate", program, "-m", "xy-table", "-o", command, "--perturb", "0%"]) == 0
    call = ["simulate", command, "-m", "xy-table", "-o", str(tmp_path / "r.csv"), "--reference", program,
            "--perturb", "10%", "--draws", "8", "--summary", str(summary)]  # fmt: skip
    assert cncgen(call) == 0
    said = capfd.readouterr().err
    assert f"against {program}, which begins at 0." in said
    assert (
        "on 8 machines with every parameter within 10 % (90 ± 19.0 % of all such machines are within):"
        in said
    )
    found = json.loads(summary.read_text())
    assert found["contour_error_max_mm"] > 0.010
    assert found["reference"]["contour_error_max_mm"] < 0.002
    assert (
        found["perturbed"]["reference_contour_error_max_mm"]["worst"]
        > found["reference"]["contour_error_max_mm"]
    )


def test_a_picture_shows_the_errors_against_the_wanted_motion(tmp_path, programs, capfd):
    """Of axes that follow at once, a command moved by 5 µm is 5 µm off the wanted motion, and on its own path."""
    rows = circle(10.0, 50.0, turns=0.3)
    responses = list(simulate(stream(rows + np.array([0.005, 0.0])), STIFF))
    shown = of_response(iter(responses), "moved")
    assert shown.contour is not None
    assert shown.contour.max() < 1e-9
    found = against(shown, reference_of("plan", stream(rows)), responses)
    assert np.hypot(*(found.command - found.position).T) == pytest.approx(0.005)
    assert found.contour.max() == pytest.approx(0.005, rel=0.01)
    program, picture = str(programs / "circle.nc"), tmp_path / "e.svg"
    call = [
        "plot",
        program,
        "-m",
        "xy-table",
        "--kinds",
        "errors",
        "-o",
        str(picture),
        "--reference",
        program,
    ]
    assert cncgen(call) == 0
    assert picture.exists()
    plan_file = str(tmp_path / "p.csv")
    assert cncgen(["plan", program, "-m", "xy-table", "-o", plan_file, "-q"]) == 0
    one = ["--kinds", "path", "-o", str(picture)]
    assert cncgen(["plot", plan_file, *one, "--reference", program]) == 2
    assert "--reference judges a simulation" in capfd.readouterr().err


def test_a_row_of_compare_shows_effort_and_what_the_shaped_setpoints_break(tmp_path, programs, capfd):
    """The mirror gives the loops 2 r − G r: its third differences, taken here, are the ratio that the row states."""
    summary = tmp_path / "s.json"
    call = [
        "compare",
        str(programs / "circle.nc"),
        "-m",
        "dyna-1007",
        "--controllers",
        "p,mirror",
        "--summary",
        str(summary),
    ]
    assert cncgen(call) == 0
    header, _, own, mirrored = capfd.readouterr().out.splitlines()[:4]
    assert "from the program µm" in header
    assert "X effort mm/s" in header
    assert own.split("|")[-2].strip() == "none"
    assert "Y jerk" in mirrored.split("|")[-2]
    first, second = json.loads(summary.read_text())["controllers"]
    assert first["breaks"] == []
    assert first["reference"]["contour_error_max_mm"] == pytest.approx(
        first["contour_error_max_mm"], abs=1e-3
    )
    machine = load_machine("dyna-1007")
    chunks = list(sample(plan(read(str(programs / "circle.nc")), machine)).chunks)
    rows = np.concatenate([chunk.position for chunk in chunks])
    position = np.concatenate([r.position for r in simulate(iter(chunks), profile("dyna-1007"))])
    shaped = (2.0 * rows - position)[:, 1]
    whole = np.concatenate([np.repeat(shaped[:1], 3), shaped, np.repeat(shaped[-1:], 3)])
    ratio = np.abs(np.diff(whole, 3)).max() / 1e-9 / machine.axes["Y"].max_jerk
    (jerk,) = (b["ratio"] for b in second["breaks"] if (b["axis"], b["limit"]) == ("Y", "jerk"))
    assert jerk == pytest.approx(ratio, rel=1e-6)


def test_axes_that_only_turn_are_judged_by_their_tracking(tmp_path, capfd):
    program, summary = tmp_path / "turn.nc", tmp_path / "s.json"
    program.write_text("G1 A90 F3600\nM2\n")
    call = ["simulate", str(program), "-o", str(tmp_path / "r.csv"), "--reference", str(program), "--perturb", "5%",
            "--draws", "4", "--summary", str(summary)]  # fmt: skip
    assert cncgen(call) == 0
    found = json.loads(summary.read_text())
    assert found["reference"]["contour_error_max_mm"] is None
    assert found["reference"]["tracking_max_deg"] == pytest.approx(found["axes"]["a"]["tracking_max_deg"])
    assert "mdeg" in capfd.readouterr().err
    assert cncgen(["compare", str(program), "--controllers", "p"]) == 0


def test_compare_gives_the_distance_from_another_program(tmp_path, capfd):
    """A circle that is 5 µm too large: axes that follow at once are 5 µm off the reference, whatever the strategy takes of time."""
    stiff = tmp_path / "stiff.toml"
    servo = 'model = "transfer-function"\nnumerator = [1.0]\ndenominator = [1e-5, 1.0]\n'
    stiff.write_text("".join(f"[axes.{k}.servo]\n{servo}" for k in "xy"))
    for name, radius in (("a.nc", 10.0), ("b.nc", 10.005)):
        (tmp_path / name).write_text(
            f"G21 G90 G61 F3000\n(START, X{radius} Y0)\nG3 X{radius} Y0 I-{radius} J0\nM2\n"
        )
    call = ["compare", str(tmp_path / "b.nc"), "-m", "xy-table", "--axis-params", str(stiff), "--reference"]
    for given in ("a.nc", "a.csv"):
        if given == "a.csv":
            plan = ["plan", str(tmp_path / "a.nc"), "-m", "xy-table", "-o", str(tmp_path / given)]
            assert cncgen(plan) == 0
        summary = tmp_path / "s.json"
        more = [
            "--feedrates",
            "optimal,ild",
            "--interpolators",
            "arclength,stateline",
            "--summary",
            str(summary),
        ]
        assert cncgen([*call, str(tmp_path / given), *more]) == 0, capfd.readouterr().err
        assert capfd.readouterr().out.count("from the reference µm") == 2
        found = json.loads(summary.read_text())
        for one in found["strategies"] + found["interpolators"]:
            assert one["reference_max_mm"] == pytest.approx(0.005, abs=2e-4)
    assert cncgen([*call, str(tmp_path / "a.nc"), "--controllers", "p", "--summary", str(summary)]) == 0
    assert "from the reference µm" in capfd.readouterr().out
    (row,) = json.loads(summary.read_text())["controllers"]
    assert row["reference"]["contour_error_max_mm"] == pytest.approx(0.005, abs=2e-4)
