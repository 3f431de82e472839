"""Machine files: what is read, every fault named at once, and the way back to TOML."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import CncgenError, UsageError
from cncgen.machine import (
    Axis,
    Drive,
    Machine,
    Servo,
    load,
    load_machine,
    load_servos,
    profile_names,
    to_toml,
)
from cncgen.machine.checking import check_machine
from cncgen.machine.keys import rows
from cncgen.machine.reading import machine_from_toml, servos_from_toml
from cncgen.machine.writing import table_text
from cncgen.servo.named_schemes import COUPLING_KEYS
from cncgen.units import file_unit

GOOD = """
name = "shop"
period_s = 0.0005
chord_tolerance_mm = 0.002
path_tolerance_mm = 0.05
max_contour_error_mm = 0.01

[axes.x]
max_velocity_mm_s = 250
max_acceleration_mm_s2 = 2500.0
max_jerk_mm_s3 = 50_000
travel_mm = [-500, 500.5]

[axes.c]
max_velocity_deg_s = 180.0
max_acceleration_deg_s2 = 360.0
max_jerk_deg_s3 = 3600.0
travel_deg = [-90.0, 90.0]
"""


def faults_of(text: str) -> list[tuple[str, str, int | None]]:
    """Read a wrong file; return code, key path and line of each fault."""
    with pytest.raises(UsageError) as caught:
        machine_from_toml(text.encode(), "m.toml")
    assert caught.value.exit_code == 2
    return [
        (d.code, str(d.values.get("key", "")), d.span.line if d.span else None)
        for d in caught.value.diagnostics
    ]


def test_values_and_units() -> None:
    machine = machine_from_toml(GOOD.encode(), "m.toml")
    assert (machine.name, machine.period_s, machine.path_tolerance_mm) == ("shop", 0.0005, 0.05)
    assert machine.axes["X"] == Axis("X", 250.0, 2500.0, 50000.0, (-500.0, 500.5))
    assert machine.axes["C"].max_velocity == pytest.approx(math.pi, rel=1e-15)
    assert machine.axes["C"].travel == pytest.approx((-math.pi / 2, math.pi / 2), rel=1e-15)


def test_every_fault_is_named_in_one_run_in_the_order_of_the_file() -> None:
    text = """\
nme = "x"
period_s = -1
[axes.x]
max_velocity_mm_s = 0
max_acceleration_mm_s2 = "fast"
travel_mm = [1, 0]
[axes.A]
max_velocity_mm_s = 1
[axes.q]
[axes.y]
max_velocity_mm_s = nan
max_acceleration_mm_s2 = true
max_jerk_mm_s3 = inf
servo = 1
"""
    assert faults_of(text) == [
        ("machine-key", "nme", 1),
        ("machine-value", "period_s", 2),
        ("machine-missing", "axes.x.max_jerk_mm_s3", 3),
        ("machine-value", "axes.x.max_velocity_mm_s", 4),
        ("machine-type", "axes.x.max_acceleration_mm_s2", 5),
        ("machine-value", "axes.x.travel_mm", 6),
        ("machine-missing", "axes.A.max_velocity_deg_s", 7),
        ("machine-missing", "axes.A.max_acceleration_deg_s2", 7),
        ("machine-missing", "axes.A.max_jerk_deg_s3", 7),
        ("machine-key", "axes.A.max_velocity_mm_s", 8),
        ("machine-key", "axes.q", 9),
        ("machine-value", "axes.y.max_velocity_mm_s", 11),
        ("machine-type", "axes.y.max_acceleration_mm_s2", 12),
        ("machine-value", "axes.y.max_jerk_mm_s3", 13),
        ("machine-type", "axes.y.servo", 14),
    ]


def test_a_period_too_short_and_a_table_known_by_its_children() -> None:
    limits = "max_velocity_mm_s = 1\nmax_acceleration_mm_s2 = 1\nmax_jerk_mm_s3 = 1\n"
    assert faults_of(f"period_s = 1e-7\n[axes.x]\n{limits}[axis.y]\n") == [
        ("machine-value", "period_s", 1),
        ("machine-key", "axis", 6),
    ]


def test_a_servo_whose_model_is_misspelt() -> None:
    text = "[axes.x.servo]\nmodle = 'first-order'\n"
    with pytest.raises(UsageError, match="is modle meant for it"):
        servos_from_toml(text.encode(), "m.toml")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "machine-missing"),
        ("axes = 3", "machine-type"),
        ("[axes]", "machine-missing"),
        ("axes.x = 3", "machine-type"),
        ("a = [1,", "machine-syntax"),
        ("a = 1\nb = = 2", "machine-syntax"),
        ("name = 3\n" + GOOD.replace('name = "shop"', ""), "machine-type"),
        (GOOD.replace("250", "1" + "0" * 400), "machine-value"),
        (GOOD + "[axes.X]\nmax_velocity_mm_s = 1", "machine-key"),
        (GOOD + "[interpreter]\n[[kinematics]]", "machine-type"),
        (GOOD + "[axes.x.servo]\nKp = 1", "machine-missing"),
        (GOOD + "[axes.x.servo]\nmodel = 1", "machine-type"),
        ("a = " + "[" * 5000, "machine-syntax"),
    ],
)
def test_wrong_files(text: str, code: str) -> None:
    assert code in [found for found, _, _ in faults_of(text)]


def test_a_rotary_axis_in_millimetres_is_told_its_key() -> None:
    with pytest.raises(UsageError, match="axis C turns: the key is max_velocity_deg_s"):
        machine_from_toml(GOOD.replace("max_velocity_deg_s", "max_velocity_mm_s").encode(), "m.toml")


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"name = 'x'\n\x80"])
def test_bytes_that_are_no_text(content: bytes) -> None:
    with pytest.raises(UsageError, match="not UTF-8"):
        machine_from_toml(content, "m.toml")


def test_profiles_load_and_print_back() -> None:
    assert set(profile_names()) >= {"generic-lathe", "generic-mill", "xy-table", "die-bonder", "dyna-1007"}
    for name in profile_names():
        machine = load(name)
        assert machine.name == name
        assert machine_from_toml(to_toml(machine).encode(), name) == machine


def test_the_papers_xy_table() -> None:
    """Limits of M.-S. Tsai's table: 250 mm/s, 0.25 g, 50,000 mm/s³, 1 ms, chord error 1 µm, contour error 10 µm."""
    machine = load_machine("xy-table")
    for letter in "XY":
        axis = machine.axes[letter]
        assert (axis.max_velocity, axis.max_acceleration, axis.max_jerk) == (250.0, 2450.0, 50000.0)
    assert (machine.period_s, machine.chord_tolerance_mm, machine.max_contour_error_mm) == (
        0.001,
        0.001,
        0.01,
    )


def test_by_file_by_name_and_neither(tmp_path: Path) -> None:
    path = tmp_path / "shop.toml"
    path.write_text(GOOD)
    assert load(path).name == "shop"
    with pytest.raises(UsageError, match="did you mean xy-table"):
        load("xy-tabel")
    with pytest.raises(UsageError, match="there is no such file"):
        load(tmp_path / "none.toml")
    with pytest.raises(UsageError, match="it is a directory"):
        load(tmp_path)
    path.write_bytes(b"#" * 2_000_000)
    with pytest.raises(UsageError, match="larger than"):
        load(path)


@pytest.mark.parametrize(
    ("key", "low", "high"),
    [
        ("period_s", "1e-6", "10"),
        ("chord_tolerance_mm", "1e-9", "1e6"),
        ("max_velocity_mm_s", "1e-3", "1e9"),
        ("max_acceleration_mm_s2", "1e-6", "1e12"),
        ("max_jerk_mm_s3", "1e-6", "1e15"),
    ],
)
def test_numbers_of_no_machine_are_faults(key: str, low: str, high: str) -> None:
    """Both ends of a range are allowed, what is beyond is named: no power of it overflows, no motion takes years."""
    pattern = re.compile(rf"^{key} = .*$", re.MULTILINE)
    text = f"{GOOD.partition('[axes.c]')[0]}"
    for value in (low, high):
        machine_from_toml(pattern.sub(f"{key} = {value}", text).encode(), "m.toml")
    for value in (f"{0.999 * float(low)!r}", f"{1.001 * float(high)!r}", "1e-308", "1e308", "9" * 400):
        (found,) = faults_of(pattern.sub(f"{key} = {value}", text))
        assert found[:2] == ("machine-value", key if "max" not in key else f"axes.x.{key}")


def test_servos_alone(tmp_path: Path) -> None:
    path = tmp_path / "servo.toml"
    path.write_text("[axes.x]\n")
    with pytest.raises(UsageError, match="no axis has servo data"):
        load_servos(path)
    path.write_text(GOOD)
    with pytest.raises(UsageError, match="no axis has servo data"):
        load_servos(path)
    path.write_text("[axes.x.servo]\nmodel = 1\n[axes.q.servo]\n")
    with pytest.raises(CncgenError) as caught:
        load_servos(path)
    assert {d.code for d in caught.value.diagnostics} >= {"machine-type", "machine-key"}


limits = st.floats(1e-3, 1e7)
axes = st.sets(st.sampled_from("XYZABCUVW"), min_size=1)


def test_servo_data_in_the_place_of_a_machine_are_told() -> None:
    """Six limits were missing, and nothing said that the file of `cncgen tune` goes elsewhere; other faults are named beside."""
    text = '[axes.x.servo]\nmodel = "first-order"\nposition_gain_1_s = 80.0\nKp = 1\n'
    with pytest.raises(UsageError) as caught:
        machine_from_toml(text.encode(), "gains.toml")
    found = {d.code: d for d in caught.value.diagnostics}
    assert set(found) == {"machine-missing", "machine-key"}
    assert "--axis-params" in found["machine-missing"].hint
    assert "max_jerk_mm_s3 are missing" in found["machine-missing"].message


@given(
    letters=axes,
    numbers=st.lists(limits, min_size=3, max_size=3),
    period=st.floats(1e-6, 10.0),
    name=st.text(min_size=1).filter(str.strip),
)
def test_print_then_read_is_the_same_machine(
    letters: set[str], numbers: list[float], period: float, name: str
) -> None:
    name = name.encode("utf-8", "replace").decode()
    velocity, acceleration, jerk = numbers
    servos = {
        letter: Servo(
            "plant",
            {
                "numerator": [1],
                "denominator": [1.0, 0],
                "drive_unit": 'a\x7f"b',
                f"position_gain_1_{file_unit(letter)}": 1.0,
            },
        )
        for letter in letters
    }
    parts = {
        letter: Axis(letter, velocity, acceleration, jerk, (-velocity, acceleration), servos[letter])
        for letter in "XYZABCUVW"
        if letter in letters
    }
    kinematics = {"model": "head-head", "axes": ["a", "c"], "centre_mm": [1.0, 2, period]}
    settings = {"kinematics": kinematics} if {"A", "C"} <= letters else {}
    machine = Machine(name, parts, period_s=period, settings=settings)
    again = machine_from_toml(to_toml(machine).encode(), "m.toml")
    assert (again.name, again.period_s, again.settings) == (name, period, machine.settings)
    for letter, axis in parts.items():
        assert again.axes[letter].max_velocity == pytest.approx(axis.max_velocity, rel=1e-15)
        assert again.axes[letter].travel == pytest.approx(axis.travel, rel=1e-15)
        assert again.axes[letter].servo == servos[letter]


def test_faults_of_further_tables_stand_at_their_lines_with_all_others() -> None:
    text = (
        "period_s = 0\n[axes.x]\nmax_velocity_mm_s = 1\nmax_acceleration_mm_s2 = 1\nmax_jerk_mm_s3 = 1\n"
        '[interpreter]\ndialect = "fanuk"\n[kinematics]\naxes = ["a", "a"]\ncentre = 1\n'
        "[coupling]\nccc_integral_1_s = 1\n"
    )
    with pytest.raises(UsageError) as caught:
        machine_from_toml(text.encode(), "m.toml")
    found = [(d.span.line, d.code, d.values["key"]) for d in caught.value.diagnostics if d.span]
    assert found == [
        (1, "machine-value", "period_s"),
        (7, "machine-value", "interpreter.dialect"),
        (8, "machine-missing", "kinematics.model"),
        (9, "machine-value", "kinematics.axes"),
        (10, "machine-key", "kinematics.centre"),
        (12, "machine-missing", "coupling.ccc_integral_1_s"),
    ]
    assert caught.value.diagnostics[4].hint == "did you mean centre_mm?"


def test_every_key_is_listed_and_read() -> None:
    """A file with every key that is listed as a number, at its default or 1, is a machine."""
    listed = {key: (wanted, default) for key, wanted, default, _ in rows()}
    assert len(listed) == len(list(rows()))
    assert all(about and "{" not in about for *_, about in rows())
    lines = [
        f"{key} = {default if default[0].isdigit() else 1}"
        for key, (wanted, default) in listed.items()
        if wanted.startswith("a number from") and "." not in key
    ]
    limits = [key.removeprefix("axes.x.") for key in listed if key.startswith("axes.x.max_")]
    lines += ["[axes.x]", *(f"{key} = 1" for key in limits), "travel_mm = [0, 1]", "[axes.x.servo]"]
    servo = [
        key.split(": ")[1]
        for key, row in listed.items()
        if key.startswith("first-order") and row[0][:3] == "a n"
    ]
    lines += ['model = "first-order"', *(f"{key} = 1" for key in servo)]
    lines += ["[interpreter]", "least_increment_mm = 1", "[coupling]"]
    lines += [f"{key.removeprefix('coupling.')} = 1" for key in listed if key.startswith("coupling.")]
    machine = machine_from_toml("\n".join(lines).encode(), "m.toml")
    assert (machine.period_s, machine.max_centripetal_mm_s2) == (0.001, 1.0)
    assert set(machine.axes["X"].servo.parameters) == set(servo)  # type: ignore[union-attr]
    assert set(machine.settings["coupling"]) == set(COUPLING_KEYS)


def test_whole_degrees_are_written_as_they_were_read() -> None:
    for degrees in range(1, 361):
        text = f"[axes.c]\nmax_velocity_deg_s = {degrees}\nmax_acceleration_deg_s2 = 100\nmax_jerk_deg_s3 = 1000\n"
        written = to_toml(machine_from_toml(text.encode(), "m.toml"))
        assert f"max_velocity_deg_s = {float(degrees)}\n" in written


def test_a_table_begins_with_its_header() -> None:
    assert table_text("coupling", {"a": 1.5, "b": [1, 2]}) == "[coupling]\na = 1.5\nb = [1, 2]\n"


AXIS = "[axes.x]\nmax_velocity_mm_s = 1\nmax_acceleration_mm_s2 = 1\nmax_jerk_mm_s3 = 1\n"
TURNING = "".join(AXIS.replace("[axes.x]", f"[axes.{letter}]").replace("_mm", "_deg") for letter in "bc")
FORK = '[kinematics]\nmodel = "head-head"\naxes = ["c", "B"]\n'


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ("[interpreter]\nleast_increment_mm = 0\n", "interpreter.least_increment_mm"),
        ("[interpreter]\nleast_increment_mm = 1.001\n", "interpreter.least_increment_mm"),
        ("[interpreter]\ndialect = 3\n", "interpreter.dialect"),
        (f"{FORK}tolerance_mm = 0\n", "kinematics.tolerance_mm"),
        (f"{FORK}pivot_mm = -1e-9\n", "kinematics.pivot_mm"),
        (f"{FORK}pivot_mm = inf\n", "kinematics.pivot_mm"),
        (f"{FORK}pivot_mm = 1.1e6\n", "kinematics.pivot_mm"),
        (f"{FORK}centre_mm = [0, 0, -1.1e6]\n", "kinematics.centre_mm"),
        (f"{FORK}tolerance_mm = 9e-10\n", "kinematics.tolerance_mm"),
        ("[interpreter]\nleast_increment_mm = 1e-10\n", "interpreter.least_increment_mm"),
        ("[coupling]\ntcf_normal_rad_s = 1e16\n", "coupling.tcf_normal_rad_s"),
        (f"{FORK}centre_mm = [0, 0]\n", "kinematics.centre_mm"),
        (f"{FORK}centre_mm = [0, 0, nan]\n", "kinematics.centre_mm"),
        ('[kinematics]\nmodel = "head-head"\naxes = ["a", "x"]\n', "kinematics.axes"),
        ("[coupling]\ntcf_normal_damping = 0\n", "coupling.tcf_normal_damping"),
        ("[coupling]\nccc_proportional = 0\nccc_integral_1_s = 1\n", "coupling.ccc_proportional"),
    ],
)
def test_ranges_of_further_tables(table: str, key: str) -> None:
    assert [found[:2] for found in faults_of(AXIS + TURNING + table)] == [("machine-value", key)]


@pytest.mark.parametrize(
    "table",
    [
        "[interpreter]\nleast_increment_mm = 1\n",
        f"{FORK}pivot_mm = 0\ncentre_mm = [0, 0, -1]\n",
        "[coupling]\nccc_proportional = 1\nccc_integral_1_s = 0\n",
    ],
)
def test_bounds_of_further_tables_are_allowed(table: str) -> None:
    assert machine_from_toml((AXIS + TURNING + table).encode(), "m.toml").axes["X"].max_jerk == 1.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GOOD.replace("250", "250,5"), "help: the decimal sign is a point"),
        ("name: shop\naxes:\n", "help: this is YAML"),
        ('{"name": "shop"}', "help: this is JSON"),
        ("[EMC]\nMACHINE = shop", "help: texts stand in quotes"),
        ("name = \u201cshop\u201d", "help: texts stand in straight quotes"),
        (GOOD + "[axes.x]\n", "error[machine-syntax]: the table [axes.x] stands twice"),
        (
            "period_s = 0.001\nperiod_s = 0.002\n" + GOOD,
            "error[machine-syntax]: the key period_s stands twice in its table",
        ),
        (GOOD.replace("0.0005", "2026-01-01"), "must be a number, is a date (2026-01-01)"),
        (GOOD.replace('"shop"', '""'), "name: must be a text that is not empty"),
    ],
)
def test_what_is_meant_by_a_file_that_is_no_toml(text: str, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        machine_from_toml(text.encode(), "m.toml")
    assert words in str(caught.value)


def test_the_name_of_a_profile_in_capitals() -> None:
    with pytest.raises(UsageError, match="did you mean xy-table"):
        load("XY_TABLE")


def test_keys_tell_the_defaults_of_drives() -> None:
    """Each was said to be 0: of a truth value, and of a scale that may not be 0."""
    told = {key: default for key, _, default, _ in rows()}
    assert told["axes.x.drive.counts_per_mm"] == told["axes.x.max_velocity_mm_s"]
    assert told["axes.x.drive.reversed"] == "false"
    assert told["axes.x.drive.velocity_units_per_mm_s"] == "counts a second"
    assert told["axes.x.drive.offset_counts"] == "0"


def test_axes_of_kinematics_are_axes_of_the_machine() -> None:
    """B of a machine with A and C counted as one that stands at 0: G43.4 was planned as if C turned nothing."""
    limits = "{max_velocity_UNIT_s = 1, max_acceleration_UNIT_s2 = 1, max_jerk_UNIT_s3 = 1}"
    units = (("x", "mm"), ("y", "mm"), ("z", "mm"), ("A", "deg"), ("c", "deg"))
    axes = "".join(f"{letter} = {limits.replace('UNIT', unit)}\n" for letter, unit in units)
    text = f'[axes]\n{axes}[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\n'
    machine = machine_from_toml(text.encode(), "m.toml")
    with pytest.raises(UsageError) as caught:
        machine_from_toml(text.replace('"a", "c"', '"A", "B"').encode(), "m.toml")
    (found,) = caught.value.diagnostics
    assert (found.code, found.span and found.span.line) == ("machine-missing", 9)
    assert found.message == "kinematics.axes: B carries table or head, and the machine has no [axes.b]"
    settings = {"kinematics": {"model": "table-table", "axes": ["a", "b"]}}
    with pytest.raises(UsageError, match=r"settings kinematics.axes: b carries table or head"):
        check_machine(replace(machine, settings=settings))


def test_numbers_of_numpy_become_numbers_of_files() -> None:
    """`np.float64(80.0)` stood in the TOML that files of setpoints carry, and coefficients of scipy's systems were refused."""
    single = np.float32(0.125)
    servo = Servo(
        "transfer-function",
        {"numerator": np.array([80.0]), "denominator": [np.float64(1.0), 80], "delay_s": single},
    )
    travel = np.array([-5.0, 5.0])
    axis = Axis(
        "X", np.float64(300.0), np.int64(3000), np.float32(60000.0), travel, servo, Drive(np.float64(1e4))
    )  # type: ignore[arg-type]
    machine = Machine("bench", {"X": axis}, np.float64(0.001), max_centripetal_mm_s2=single)
    check_machine(machine)
    again = machine_from_toml(to_toml(machine).encode(), "again.toml")
    assert again == Machine(
        "bench",
        {
            "X": Axis(
                "X",
                300.0,
                3000.0,
                60000.0,
                (-5.0, 5.0),
                Servo("transfer-function", {"numerator": [80.0], "denominator": [1.0, 80], "delay_s": 0.125}),
                Drive(1e4),
            )
        },
        0.001,
        max_centripetal_mm_s2=0.125,
    )
    json.dumps([machine.period_s, axis.max_jerk, axis.travel, dict(servo.parameters)])
