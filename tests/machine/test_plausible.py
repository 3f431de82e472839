"""Limits of which a unit was mistaken: told with the times that they ask for. Times are V/A, A/J and travel/V."""

import warnings

import pytest

import cncgen
from cncgen.diagnostics import RemarkWarning
from cncgen.machine import Axis, Machine, load, plausible, profile_names
from cncgen.machine.reading import machine_from_toml

RIGHT = {"velocity_mm_s": 250.0, "acceleration_mm_s2": 2500.0, "jerk_mm_s3": 50000.0}


@pytest.fixture(autouse=True)
def nothing_told(monkeypatch):
    monkeypatch.setattr(plausible, "_told", set())


def said(limits, more=""):
    text = 'name = "mill"\n' + more + "[axes.x]\ntravel_mm = [-500.0, 500.0]\n"
    text += "".join(f"max_{key} = {value}\n" for key, value in limits.items())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        machine_from_toml(text.encode(), "mill.toml")
    return [w.message.diagnostic for w in caught]


@pytest.mark.parametrize(
    ("key", "value", "words", "meant"),
    [
        ("jerk_mm_s3", 0.1, "needs 6.94 h to reach its 2500 mm/s²", "100 mm/s³"),  # 2500/0.1 = 25000 s
        ("jerk_mm_s3", 50.0, "needs 50 s to reach its 2500 mm/s²", "50000 mm/s³"),
        ("acceleration_mm_s2", 2.5, "needs 100 s to reach its 250 mm/s", "2500 mm/s²"),
        ("velocity_mm_s", 0.25, "reaches its 0.25 mm/s in 0.1 ms", "250 mm/s"),
    ],
)
def test_a_limit_in_metres_is_told_with_its_place(key, value, words, meant):
    found = said(RIGHT | {key: value})[0]
    assert (found.code, found.severity) == ("machine-doubt", "warning")
    assert words in found.message
    assert meant in found.hint
    assert found.excerpt == f"max_{key} = {value}"


def test_all_limits_in_metres_are_seen_by_the_travel():
    (found,) = said({k: v / 1000.0 for k, v in RIGHT.items()})
    assert "needs 66.7 min for its travel of 1000 mm" in found.message  # 1000/0.25 = 4000 s


@pytest.mark.parametrize(
    ("limits", "words", "meant"),
    [
        (RIGHT | {"velocity_mm_s": 30000.0}, "30000 mm/s is 30 m/s", "That is 500 mm/s"),  # 30 m/min
        ({k: 1000.0 * v for k, v in RIGHT.items()}, "250000 mm/s is 250 m/s", "in mm/min?"),
    ],
)
def test_a_rapid_in_millimetres_a_minute_and_limits_in_micrometres_are_told(limits, words, meant):
    (found,) = said(limits)
    assert words in found.message
    assert meant in found.hint
    assert found.excerpt == f"max_velocity_mm_s = {limits['velocity_mm_s']}"


def test_a_period_in_milliseconds_is_told():
    found = said(RIGHT, "period_s = 1.0\n")[0]
    assert found.excerpt == "period_s = 1.0"
    assert "reaches its 250 mm/s in 100 ms, less than half of the period of 1e+03 ms" in found.message


@pytest.mark.parametrize(
    "limits",
    [
        RIGHT,
        RIGHT | {"jerk_mm_s3": 1e15},
        RIGHT | {"acceleration_mm_s2": 1e12},
        RIGHT | {"velocity_mm_s": 1e9},
    ],
)
def test_machines_and_limits_that_stand_for_none_are_not_remarked_on(limits):
    assert said(limits) == []


def test_machines_that_ship_are_plausible():
    for name in profile_names():
        for axis in load(name).axes.values():
            assert list(plausible.doubts(axis, 0.001)) == []


def test_a_machine_of_a_script_is_told_once(tmp_path):
    program = tmp_path / "x.nc"
    program.write_text("G21 G90 G1 X1 F600\nM2\n")
    machine = Machine("mine", {"X": Axis("X", 0.25, 2500.0, 50000.0)})
    with pytest.warns(RemarkWarning, match="machine mine, max_velocity of axis X: at 2500 mm/s²"):
        cncgen.plan(program, machine)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cncgen.plan(program, machine)
