"""What a machine says about how its control reads a program."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest

from cncgen.diagnostics import UsageError
from cncgen.gcode.state.settings import interpreter_settings
from cncgen.machine import load
from cncgen.machine.kinematics import Kinematics
from cncgen.pipeline import options_on
from cncgen.toolpath.reading import ReadOptions


def test_settings_fill_what_options_leave_open() -> None:
    table = {"dialect": "fanuc", "least_increment_mm": 0.001}
    found = interpreter_settings(table, ReadOptions())
    assert (found.dialect, found.least_increment) == ("fanuc", 0.001)
    found = interpreter_settings(table, ReadOptions(dialect="linuxcnc", least_increment=0.01))
    assert (found.dialect, found.least_increment) == ("linuxcnc", 0.01)


def test_every_wrong_setting_is_named() -> None:
    with pytest.raises(UsageError) as caught:
        interpreter_settings({"dialect": "heidi", "least_increment_mm": -1, "speed": 3}, ReadOptions())
    messages = [d.message for d in caught.value.diagnostics]
    assert messages == [
        "interpreter.speed: unknown key",
        "interpreter.dialect: must be one of linuxcnc, fanuc, fanuc-lathe, fanuc-lathe-b, fanuc-lathe-c, heidenhain, sinumerik; is 'heidi'",
        "interpreter.least_increment_mm: must be a number from 1e-9 to 1; is -1",
    ]


def test_the_tables_of_a_machine_file_become_options(tmp_path: Path) -> None:
    """By way of the machine's reader, as every command with a machine does."""
    text = (files("cncgen.machine") / "profiles" / "generic-mill.toml").read_text("utf-8")
    tables = '[interpreter]\nleast_increment_mm = 0.001\n\n[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\n'
    (tmp_path / "five.toml").write_text(f"{text}\n{tables}")
    found = options_on(load(tmp_path / "five.toml"))
    assert (found.dialect, found.least_increment) == ("auto", 0.001)
    assert found.kinematics == Kinematics(0, (3, 5))
    assert options_on(load("generic-mill")) == ReadOptions(fastest_spindle=12_000.0)


def test_the_travel_of_the_axes_becomes_an_option() -> None:
    """In mm and degrees, as programs count, of bounded axes alone; its file says -500 to 500 mm of both axes."""
    assert options_on(load("xy-table")).travel == (("X", -500.0, 500.0), ("Y", -500.0, 500.0))
    machine = load("generic-mill")
    turning = replace(machine.axes["A"], travel=(-math.pi / 2, math.pi))
    found = options_on(replace(machine, axes={**machine.axes, "A": turning})).travel
    assert found == (("A", pytest.approx(-90.0), pytest.approx(180.0)),)
