"""What a machine says about how its control reads a program."""

from __future__ import annotations

import pytest

from cncgen.diagnostics import UsageError
from cncgen.gcode.settings import interpreter_settings
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
        "interpreter.dialect: must be one of linuxcnc, fanuc",
        "interpreter.least_increment_mm: must be a number above 0, at most 1",
    ]
