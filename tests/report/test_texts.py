"""What the tables and texts of results say, number by number, from results that are made by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, UsageError
from cncgen.machine import load_servos
from cncgen.machine.record import Servo
from cncgen.report import comparing, response, tuned, verdict
from cncgen.report.comparison import Demand, Fluctuation, StrategyFigures
from cncgen.servo.controllers.hinf_servo import BoundCheck
from cncgen.servo.named_schemes import Settings
from cncgen.servo.tuning.analysis import OpenLoop
from cncgen.servo.tuning.search import BestGains
from cncgen.setpoints.record import Setpoints
from cncgen.verify.verdict import Peak, Verdict

WHOLE = StrategyFigures("ild", 1.25, 0.0125, 0.0025, 0.0075, 1234.56, 98765.4, 0.5, 1.5)
FAILED = StrategyFigures("optimal", fault=Diagnostic("no-plan", "why"))


def cells(table: str) -> list[list[str]]:
    """Return the cells of a table, its rule left out."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()]
    return [rows[0], *rows[2:]]


def test_strategies_side_by_side_in_micrometres() -> None:
    head, failed, whole = cells(comparing.strategy_table([FAILED, WHOLE]))
    assert whole == ["ild", "1.2500", "12.5", "2.5", "7.5", "1234.6", "0.5", "98765", "1.5"]
    assert failed == ["optimal", "no-plan", *["-"] * 7]
    assert len(head) == 9


def test_rows_show_effort_saturation_and_broken_limits() -> None:
    broken = [{"axis": "X", "limit": "jerk", "ratio": 9.334}, {"axis": "Y", "limit": "travel", "ratio": None}]
    whole = replace(WHOLE, demand=Demand({"x": (2.194, "V"), "y": (0.5, "V")}, 3, broken))
    head, failed, row = cells(comparing.strategy_table([FAILED, whole]))
    assert head[9:] == ["X effort V", "Y effort V", "saturated", "breaks"]
    assert row[9:] == ["2.194", "0.5", "3", "X jerk 9.33x, Y travel"]
    assert failed[9:] == 4 * ["-"]
    values = comparing.strategy_values([whole], [])["strategies"][0]
    assert values["force_max"] == {"x": 2.194, "y": 0.5}
    assert (values["saturated_samples"], values["breaks"]) == (3, broken)
    unknown = Fluctuation("taylor1", 0.0123, 0.0045, 2.5, demand=Demand(None, None, []))
    assert cells(comparing.interpolator_table([unknown]))[1][6:] == ["none"]


def test_strategies_and_interpolators_as_values() -> None:
    fluctuation = Fluctuation("taylor1", 0.0123, 0.0045, 2.5)
    found = comparing.strategy_values([WHOLE, FAILED], [fluctuation])
    assert found["strategies"][0]["contour_max_mm"] == 0.0125
    assert "fault" not in found["strategies"][0]
    assert found["strategies"][1] == {"feedrate": "optimal", "fault": "why"}
    assert found["interpolators"] == [
        {
            "interpolator": "taylor1",
            "max_part": 0.0123,
            "rms_part": 0.0045,
            "time_s": 2.5,
            "path_error_mm": None,
            "contour_max_mm": None,
            "reference_max_mm": None,
        }
    ]
    assert cells(comparing.interpolator_table([fluctuation]))[1] == [
        "taylor1",
        "1.23",
        "0.45",
        "2.5000",
        "-",
        "-",
    ]


def controlled(name: str) -> dict[str, object]:
    """The summary of a simulation of X and A as the table of controllers takes it."""
    axes = {
        "X": {"tracking_rms_mm": 0.001, "force_max": 1.5, "force_unit": "V"},
        "A": {"tracking_rms_deg": 0.002, "force_max": 2.5, "force_unit": "V"},
    }
    return {
        "controller": name,
        "axes": axes,
        "contour_error_max_mm": 0.003,
        "contour_error_rms_mm": 0.0004,
        "speed_variation_mm_s": 0.5,
        "saturated_samples": 7,
    }


def test_controllers_side_by_side() -> None:
    """A controller that failed has dashes, and its fault stands below the table."""
    text = comparing.controller_table([{"controller": "tcf", "fault": "no state"}, controlled("p")])
    table, fault = text.rsplit("|\n", 1)
    head, failed, whole = cells(table + "|")
    assert head[3:5] == ["X tracking rms µm", "A tracking rms mdeg"]
    assert head[6:8] == ["X effort V", "A effort V"]
    assert failed == ["tcf", *["-"] * 8]
    assert whole == ["p", "3", "0.4", "1", "2", "0.5", "1.5", "2.5", "7"]
    assert fault == "  no state\n"


def test_a_controller_that_cannot_be_had_is_left_to_the_others() -> None:
    """A first-order loop has no velocity state for `tcf`; where no controller can be had, the first fault is the error."""
    servos = {k: Servo("first-order", {"position_gain_1_s": 50.0}) for k in "XY"}
    points = [Setpoints("XY", 0.001, 0, np.linspace(0.0, 1.0, 40)[:, None] * [1.0, 2.0])]
    failed, whole = comparing.compare_controllers(points, servos, ["tcf", "p"])
    assert set(failed) == {"controller", "fault"}
    assert "velocity state" in failed["fault"]
    assert whole["controller"] == "p"
    with pytest.raises(UsageError, match="controller-unfit") as caught:
        comparing.compare_controllers(points, servos, ["tcf", "tcf"])
    assert caught.value.diagnostics[0].message == failed["fault"]
    # Any other error is not a matter of the controller.
    with pytest.raises(UsageError, match="axis Y"):
        comparing.compare_controllers(points, {"X": servos["X"]}, ["p", "tcf"])


def test_text_of_a_simulation() -> None:
    """The contour error is named with its axes where one that turns moves beside them."""
    axis = {"force_max": 1.23456, "force_unit": "V", "saturated_samples": 1, "tracking_max_t_s": 0.25}
    summary = {
        "samples": 2,
        "axis_params": "mine",
        "axes": {
            "x": {**axis, "tracking_rms_mm": 0.0015, "tracking_max_mm": 0.0025},
            "a": {**axis, "tracking_rms_deg": 0.0035, "tracking_max_deg": 0.0045, "saturated_samples": 2},
        },
        "contour_error_max_mm": 0.0065,
        "contour_error_rms_mm": 0.0055,
        "contour_error_max_t_s": 0.75,
        "contour_error_of": "X",
        "speed_variation_mm_s": 0.125,
    }
    assert response.as_text(summary).splitlines() == [
        "2 samples simulated with mine",
        "  X: tracking error rms 1.500, max 2.500 µm at 0.2500 s; force up to 1.235 V, 1 saturated sample",
        "  A: tracking error rms 3.500, max 4.500 mdeg at 0.2500 s; force up to 1.235 V, 2 saturated samples",
        "contour error of X alone rms 5.500, max 6.500 µm at 0.7500 s; speed variation 0.1250 mm/s",
    ]
    assert "contour" not in response.as_text({**summary, "contour_error_max_mm": None})


def test_text_of_a_verdict() -> None:
    """Notes break nothing; a limit that several axes break is named once."""
    peaks = tuple(
        Peak(axis, order, 3.0, 4.0, 0.0, 0, 0)
        for axis in "XA"
        for order in ("velocity", "acceleration", "jerk")
    )
    said = [("verify-jerk", Severity.ERROR)] * 2 + [("verify-acceleration", Severity.ERROR)]
    breaches = Diagnostics(Diagnostic(code, "m", severity) for code, severity in said)
    breaches.add(Diagnostic("verify-path", "m", Severity.WARNING))
    found = Verdict(1001, 0.002, peaks, 0.001, 0.0025, breaches)
    assert verdict.as_text(found).splitlines() == [
        "1001 setpoints every 2 ms, 2.0000 s",
        "  X: velocity 3 mm/s (75.00 %), acceleration 3 mm/s² (75.00 %), jerk 3 mm/s³ (75.00 %)",
        "  A: velocity 3 deg/s (75.00 %), acceleration 3 deg/s² (75.00 %), jerk 3 deg/s³ (75.00 %)",
        "distance: setpoints to path 1.000 µm, path to setpoints 2.500 µm",
        "broken: acceleration, jerk",
    ]
    assert verdict.as_text(replace(found, breaches=Diagnostics())).endswith("broken: none")


def test_margins_of_an_integrator() -> None:
    """L = ωc/(jω): 90° at ωc, and never nearer to −1 than 1, far above ωc; its phase is never 180°."""
    loop = OpenLoop("X", 0.001, lambda w: 100.0 / (1j * w))
    text = tuned.margin_text(loop, bode=False)
    assert "\n" not in text
    assert text.startswith("X: gain margin infinite, phase margin 90.0°, modulus margin 1.00")
    assert text.endswith(f"crossover {100.0 / (2.0 * math.pi):.3g} Hz, sampled every 1 ms")
    head, titles, *rows = tuned.margin_text(loop).splitlines()
    assert head == text
    assert titles.split() == ["frequency", "Hz", "magnitude", "dB", "phase", "°"]
    for hertz, size, phase in (map(float, row.split()) for row in rows):
        assert size == pytest.approx(20.0 * math.log10(100.0 / (2.0 * math.pi * hertz)), abs=0.01)
        assert phase == -90.0
    summary = tuned.summary_of(
        "p", {"X": Servo("first-order", {"position_gain_1_s": 50.0})}, {}, [loop], None
    )
    (values,) = summary.pop("loops")
    assert summary == {
        "schema_version": 1,
        "controller": "p",
        "axes": {"x": {"model": "first-order", "position_gain_1_s": 50.0}},
        "coupling": {},
    }
    assert values["gain_margin"] is None
    assert values["phase_margin_deg"] == pytest.approx(90.0, abs=1e-6)
    assert values["crossover_hz"] == pytest.approx(100.0 / (2.0 * math.pi), rel=1e-2)


@pytest.mark.parametrize(
    ("sensitivity", "complementary", "missed"), [(1.0, 1.0, 0), (1.2, 1.0, 1), (1.0, 1.3, 1), (1.2, 1.3, 1)]
)
def test_bounds_of_a_design(sensitivity: float, complementary: float, missed: int) -> None:
    """Decibels of each bound beside what is allowed, and the frequency where one is missed."""
    frequency = 2.0 * math.pi * np.arange(1.0, 6.0)
    low = np.full(5, 0.1)
    found = BoundCheck(
        frequency, np.where(frequency > 30.0, sensitivity, low), np.full(5, 1.1),
        np.where(frequency > 30.0, complementary, low), 1.25, True, 9,
    )  # fmt: skip
    head, table = tuned.bounds_text("X", 0.98762, found).split("\n", 1)
    verb = "DO NOT HOLD" if missed else "hold"
    assert head == f"X: norm 0.9876; the bounds {verb} for 9 plants, all of them stable"
    rows = cells(table)[1:]
    assert [row[0] for row in rows] == ["1", "2", "3", "4", "5"]
    assert [row[5] for row in rows] == ["ok"] * 4 + ["MISSED" if missed else "ok"]
    decibels = [20.0 * math.log10(v) for v in (sensitivity, 1.1, complementary, 1.25)]
    assert rows[-1][1:5] == [f"{v:.1f}" for v in decibels]
    unstable = tuned.bounds_text("X", 1.0, replace(found, stable=False))
    assert "DO NOT HOLD for 9 plants, NOT ALL STABLE" in unstable


def test_a_search_and_its_gains(tmp_path: Path) -> None:
    """A start that is refused has no error; tables are read back as the gains that they were."""
    servos = {"X": Servo("first-order", {"position_gain_1_s": 50.0, "time_constant_s": 0.01})}
    found = BestGains(servos, Settings(), 0.0015, math.inf, 12, 3)
    assert tuned.search_text(found) == (
        "12 gain sets, 3 refused: contour error rms refused -> 1.500 µm"
    )  # fmt: skip
    better = replace(found, start_rms_mm=0.0025)
    assert "rms 2.500 -> 1.500 µm" in tuned.search_text(better)
    for search, start in ((found, None), (better, 0.0025)):
        assert tuned.summary_of("p", servos, {}, [], search)["search"] == {
            "sets": 12, "refused": 3, "contour_rms_mm": 0.0015, "start_contour_rms_mm": start,
        }  # fmt: skip
    file = tmp_path / "gains.toml"
    file.write_text(tuned.gain_tables(servos, {}))
    assert load_servos(file) == servos
    assert "coupling" not in file.read_text()
    assert tuned.gain_tables(servos, {"ccc_proportional": 2.5}).endswith(
        "\n[coupling]\nccc_proportional = 2.5\n"
    )


def test_loops_of_a_scheme_say_their_bandwidth() -> None:
    """P control of an integrator at 50 1/s: −3 dB at 50 rad/s, but for the sampling."""
    servos = {"X": Servo("first-order", {"position_gain_1_s": 50.0})}
    margins, bandwidth = tuned.loop_texts("p", servos, "X", 1e-4, None, bode=False)
    assert margins.startswith("X: gain margin")
    assert bandwidth.startswith("X: closed loop, setpoint to position: ")
    assert float(bandwidth.split(": ")[2].split()[0]) == pytest.approx(50.0 / (2.0 * math.pi), rel=0.01)
    whole = {"X": Servo("transfer-function", {"numerator": [1.0], "denominator": [0.01, 1.0]})}
    (refusal,) = tuned.loop_texts("p", whole, "X", 0.001, None, bode=False)
    assert refusal == "the model transfer-function has no plant that another controller could drive"
