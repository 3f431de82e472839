"""SWEEP.toml: what it means, and every fault in one run."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import NoPlanError, UsageError
from cncgen.sweep.definition import load_sweep
from cncgen.sweep.driver import outlook
from cncgen.sweep.machine_keys import value_at
from cncgen.sweep.varying import job_at, jobs_of
from tests.sweep.conftest import SWEEP

Write = Callable[[str], Path]
HEAD = 'programs = ["part.nc"]\nmachine = "xy-table"\n'
SEARCH = '[vary]\nperiod_s = [1e-3, 2e-3]\n[search]\nminimise = "cycle_time_s"\ntrials = 2\n'.replace(
    "[search]\n", "[search]\n"
)


def test_files_of_one_name_stay_apart(folder: Path) -> None:
    """The first folder counts, as of ``--include``: it was the last; and of two options one file was read for both."""
    for name in ("first", "second"):
        (folder / name).mkdir()
        (folder / name / "sub.ngc").write_text(name)
    (folder / "first" / "t").write_text("T1 P1 D6")
    (folder / "second" / "t").write_text("5161 1")
    options = '[options]\ntool_table = "first/t"\nparameters = "second/t"\n'
    (folder / "s.toml").write_text(
        HEAD + 'include = ["first", "second"]\n' + options + SWEEP.partition(HEAD)[2]
    )
    sweep = load_sweep("s.toml")
    files = sweep.programs["part.nc"].files
    assert files["sub.ngc"] == b"first"
    assert files[sweep.options["tool_table"]] == b"T1 P1 D6"
    assert files[sweep.options["parameters"]] == b"5161 1"


def test_brackets_in_names_are_no_pattern(folder: Path) -> None:
    """Of a folder, and of a file that is there."""
    (folder / "a[1]").mkdir()
    (folder / "a[1]" / "part[2].nc").write_text("M2")
    (folder / "a[1]" / "s.toml").write_text(HEAD.replace("part.nc", "part[2].nc") + SWEEP.partition(HEAD)[2])
    assert list(load_sweep("a[1]/s.toml").programs) == ["part[2].nc"]
    (folder / "a[1]" / "s.toml").write_text(HEAD.replace("part.nc", "part?2?.nc") + SWEEP.partition(HEAD)[2])
    assert list(load_sweep("a[1]/s.toml").programs) == ["part[2].nc"]


@pytest.mark.parametrize(
    ("head", "told"),
    [
        (
            'programs = ["part.nc", "./part.nc"]\nmachine = "xy-table"\n',
            "./part.nc names what stands before it",
        ),
        ('programs = ["*.nc", "part.nc"]\nmachine = "xy-table"\n', "part.nc names what stands before it"),
        ('programs = ["part.nc"]\nmachines = ["xy-table", "xy-table"]\n', "xy-table stands twice"),
    ],
)
def test_what_is_named_twice_is_told(with_sweep: Write, head: str, told: str) -> None:
    """It was computed once, without a word."""
    with pytest.raises(UsageError, match=told):
        load_sweep(with_sweep(head))


def test_a_pattern_may_take_in_a_program_before_it(with_sweep: Write, folder: Path) -> None:
    (folder / "other.nc").write_text("G21 G1 X1 F100\nM2\n")
    sweep = load_sweep(with_sweep('programs = ["part.nc", "*.nc"]\nmachine = "xy-table"\n'))
    assert list(sweep.programs) == ["part.nc", "other.nc"]


def test_every_fault_is_named_in_one_run_with_its_line(with_sweep: Write) -> None:
    text = """programs = ["part.nc", "missing-*.nc"]
machine = "xy-tabel"
colour = "red"
[vary]
"axes.x.max_jerk_mm_s3" = { log = [0, 2e5] }
path_tolerance_mm = 0.01
"spindle.speed" = [1, 2]
"axes.y.max_jerk_mm_s3" = { linear = [2e5], uniform = [1, 2] }
"axes.y.max_velocity_mm_s" = ["fast", 3]
[draw]
design = "sobol"
points = 0
seed = "x"
[keep]
figures = ["cycletime_s"]
"""
    with pytest.raises(UsageError) as raised:
        load_sweep(with_sweep(text))
    found = [(item.code, item.span.line if item.span else 0) for item in raised.value.diagnostics]
    assert found == [
        ("sweep-value", 1),
        ("machine-unknown", 2),
        ("sweep-key", 3),
        ("sweep-value", 5),
        ("sweep-type", 6),
        ("sweep-key", 7),
        ("sweep-value", 8),
        ("sweep-type", 9),
        ("sweep-value", 12),
        ("sweep-type", 13),
        ("sweep-value", 15),
    ]
    assert "cycle_time_s" in raised.value.diagnostics[-1].hint


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ('"axes.q.max_jerk_mm_s3" = [1e4, 2e4]', "not an axis"),
        ('"axes.*.max_jurk_mm_s3" = [1e4, 2e4]', "no such key"),
        ('"axes.x.servo.position_gain" = [1, 2]', "position_gain"),
        ("chord_tolerance_mm = { linear = [-1, 1], count = 2 }", "chord_tolerance_mm"),
        ('feedrate = ["optimal", "quick"]', "'quick' is not one of"),
        ("max_contour_error_mm = [1e-9, 1]", "below 1e-06"),
        ('"axes.x.max_jerk_mm_s3" = { uniform = [0.5, 2] }\n', "needs a count of"),
        ("path_tolerance_mm = { uniform = [0.5, 2], relative = true, count = 3 }", "relative"),
        ('"axes.x.max_jerk_mm_s3" = [1e4, 1e4]', "twice"),
    ],
)
def test_values_that_machine_or_planner_refuse_are_named_before_anything_runs(
    with_sweep: Write, line: str, wanted: str
) -> None:
    with pytest.raises(UsageError, match=re.escape(wanted)):
        load_sweep(with_sweep(f"{HEAD}[vary]\n{line}\n"))


@pytest.mark.parametrize(
    ("text", "line", "column", "wanted"),
    [
        ('[vary]\n"axes.*.max_jerk_mm_s3" = { log = [0, 1], count = 2 }', 4, 1, "begins above 0"),
        ("[vary]\naxes . 'x' . \"max_jerk_mm_s3\" = { list = [1e4], count = 2 }", 4, 1, "a list takes none"),
        ('[options]\neffort = "fast"\nfeedrate = "quick"', 5, 1, "'quick' is not one of"),
        ("[options]\nsettle_s = nan", 4, 1, "settle_s = nan"),
        ("[options]\ncell_mm = 1e-12", 4, 1, "not below 1e-06"),
        ('[options]\ntools = "1=flat:6"', 4, 1, "a list of texts"),
        ('[options]\nlanguage = "apt"', 4, 1, "gcode, stepnc"),
        ('[keep]\nfigures = ""', 4, 1, "keep.figures: must be a list"),
        (f"{SEARCH}seed = 4294967296", 8, 1, "must not be above 4294967295"),
        (f"{SEARCH}under = {{ contour_error_max_mm = nan }}", 8, 1, "finite upper bounds"),
        (f"{SEARCH}under = {{ contour_error = 1 }}", 8, 1, "'contour_error' is not a figure"),
        ("[vary]\nperiod_s = [", 4, 13, "Invalid value"),
    ],
)
def test_a_fault_is_shown_at_its_key(
    with_sweep: Write, text: str, line: int, column: int, wanted: str
) -> None:
    """Keys with a star and options were shown at their table; of a search two faults were internal errors."""
    with pytest.raises(UsageError, match=re.escape(wanted)) as raised:
        load_sweep(with_sweep(HEAD + text))
    (fault,) = raised.value.diagnostics
    assert fault.span is not None
    assert (fault.span.line, fault.span.column) == (line, column)


def test_an_option_of_a_stage_that_no_figure_asks_for_is_told(with_sweep: Write) -> None:
    text = f'{HEAD}[options]\nsettle_s = 1\ncell_mm = 1\n[keep]\nfigures = ["axes.x.force_max"]\n'
    found = load_sweep(with_sweep(text)).remarks
    assert [(item.code, item.severity, item.span and item.span.line) for item in found] == [
        ("option-unused", "warning", 5)
    ]


def test_more_jobs_than_the_run_has_memory_for_are_refused_before_they_are_made(with_sweep: Write) -> None:
    text = f'{HEAD}[vary]\nperiod_s = {{ log = [1e-3, 2e-3] }}\n[draw]\ndesign = "sobol"\npoints = 67108864\n'
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cncgen.sweep.driver.room", lambda: 1e9)
        with pytest.raises(NoPlanError, match="67108864 jobs take some 96000 MiB"):
            outlook(load_sweep(with_sweep(text)), None)


def test_a_wildcard_sets_the_key_of_each_axis(with_sweep: Write) -> None:
    sweep = load_sweep(with_sweep(f'{HEAD}[vary]\n"axes.*.max_jerk_mm_s3" = [1e4, 2e4]\n'))
    _, job = job_at(sweep, "part.nc", "xy-table", 1, [0.75])
    assert [value_at(job.tables, f"axes.{letter}.max_jerk_mm_s3") for letter in "xy"] == [2e4, 2e4]


def test_a_relative_value_is_a_factor_of_the_machines(with_sweep: Write) -> None:
    text = f'{HEAD}[vary]\n"axes.*.max_jerk_mm_s3" = {{ list = [0.5, 2.0], relative = true }}\n'
    sweep = load_sweep(with_sweep(text))
    _, job = job_at(sweep, "part.nc", "xy-table", 0, [0.25])
    assert value_at(job.tables, "axes.y.max_jerk_mm_s3") == 25_000.0


def test_an_option_comes_before_the_machines_key_of_its_name(with_sweep: Write) -> None:
    text = f"{HEAD}[vary]\npath_tolerance_mm = [0.005, 0.02]\n'machine.path_tolerance_mm' = [0.1]\n"
    sweep = load_sweep(with_sweep(text))
    place, job = job_at(sweep, "part.nc", "xy-table", 0, [0.9, 0.5])
    assert (job.options["path_tolerance_mm"], job.tables["path_tolerance_mm"]) == (0.02, 0.1)
    assert place.values == (0.02, 0.1)


def test_programs_machines_and_points_are_all_combined_and_equal_jobs_are_one(with_sweep: Write) -> None:
    Path("other.nc").write_text("G21 G61 F600\nG1 X5\nM2\n")
    text = (
        'programs = ["*.nc"]\nmachines = ["xy-table", "generic-mill"]\n[vary]\npath_tolerance_mm = [0.01, 0.02]\n'
        '[draw]\ndesign = "sobol"\npoints = 8\nseed = 1\n'
    )
    laid = jobs_of(load_sweep(with_sweep(text)))
    assert (len(laid.groups), len(laid.jobs)) == (4, 8)  # two values alone in eight points
    assert {len(keys) for keys in laid.groups.values()} == {8}


def test_the_key_tells_program_machine_options_and_figures_apart(with_sweep: Write) -> None:
    def key(text: str = SWEEP) -> str:
        sweep = load_sweep(with_sweep(text))
        return job_at(sweep, "part.nc", "xy-table", 0, [0.5, 0.5])[1].key

    usual = key()
    assert key() == usual
    others = {
        key(SWEEP.replace("xy-table", "xy-table").replace("2e5", "3e5")),
        key(SWEEP.replace("[vary]", '[options]\nfeedrate = "ild"\n[vary]')),
        key(SWEEP.replace(', "setpoints_to_path_mm"', "")),
    }
    Path("part.nc").write_text("G21 G61 F600\nG1 X5\nM2\n")
    others.add(key())
    assert len(others - {usual}) == 4


def test_an_identified_plant_wants_a_machine_with_its_gains(with_sweep: Write) -> None:
    """xy-table has another model of servo; the message says which table is missing, and where to take it."""
    found = {"gain": 0.03, "time_constant_s": 0.03}
    covariance = {"parameters": list(found), "logarithm": [True, True], "matrix": [[1e-4, 0], [0, 1e-4]]}
    axis = {"parameters": found, "covariance": covariance}
    Path("x.json").write_text(json.dumps({"model": "velocity-loop", "axes": {"x": axis}}))
    text = (
        f'{HEAD}[vary]\n"axes.x.servo" = {{ identified = "x.json" }}\n[draw]\ndesign = "sobol"\npoints = 4\n'
    )
    with pytest.raises(UsageError) as caught:
        load_sweep(with_sweep(text))
    (fault,) = caught.value.diagnostics
    assert "position_gain_1_mm: missing" in fault.message
    assert "cncgen identify" in fault.hint


def test_a_covariance_is_drawn_as_it_was_found(with_sweep: Write) -> None:
    """Of many draws, the logarithms have the mean and the covariance of the summary (law of large numbers, 4 σ/√n)."""
    matrix = [[0.04, 0.01], [0.01, 0.09]]
    axis = {
        "parameters": {"position_gain_1_s": 80.0, "time_constant_s": 0.005},
        "covariance": {
            "parameters": ["position_gain_1_s", "time_constant_s"],
            "logarithm": [True, True],
            "matrix": matrix,
        },
    }
    Path("x.json").write_text(json.dumps({"model": "first-order", "axes": {"x": axis}}))
    text = f'{HEAD}[vary]\n"axes.x.servo" = {{ identified = "x.json" }}\n[draw]\ndesign = "sobol"\npoints = 1024\n'
    sweep = load_sweep(with_sweep(text))
    assert sweep.columns == ("axes.x.servo.position_gain_1_s", "axes.x.servo.time_constant_s")
    jobs = [place.values for place, _ in jobs_of(sweep).jobs.values()]
    found = np.log(np.array(jobs, float))
    assert found.mean(axis=0) == pytest.approx(np.log([80.0, 0.005]), abs=4 * 0.3 / 32)
    assert np.cov(found.T) == pytest.approx(np.array(matrix), abs=0.02)
    _, job = job_at(sweep, "part.nc", "xy-table", 0, [0.5, 0.5])
    servo = value_at(job.tables, "axes.x.servo")
    assert servo["model"] == "first-order"
    assert servo["position_gain_1_s"] == pytest.approx(80.0)
