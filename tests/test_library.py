"""The library as scripts use it: wrong arguments, records that are printed, compared and sent to other processes, threads."""

from __future__ import annotations

import gc
import json
import pickle
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cncgen
from cncgen.diagnostics import (
    Diagnostics,
    NoPlanError,
    ProgramError,
    RemarkWarning,
    Severity,
    UsageError,
    json_values,
)
from cncgen.machine import Axis, Drive, Servo
from cncgen.pipeline import fmu

SQUARE = "G21 G90 G61\nG0 X0 Y0\nG1 X10 F1200\nY10\nX0\nY0\nM2\n"


#: A program of STEP-NC whose execution finds faults: a workingstep without an operation, and one that is missing.
STEPNC = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('MACHINING_SCHEMA'));
ENDSEC;
DATA;
#1=PROJECT('P',#2,(),$,$,$);
#2=WORKPLAN('W',(#3,#9),$,$,$);
#3=MACHINING_WORKINGSTEP('S',$,$,$,$);
ENDSEC;
END-ISO-10303-21;
"""


def square() -> Any:
    return cncgen.read_text(SQUARE, "square.nc")


def read_with(**options: Any) -> Any:
    return cncgen.read_text(SQUARE, options=cncgen.ReadOptions(**options))


def points() -> Any:
    return cncgen.Setpoints("XY", 0.001, 0, np.zeros((5, 2)))


def judged(**options: Any) -> Any:
    return cncgen.judge(points(), square(), "xy-table", **options)


def machine(axis: Axis | None = None, **values: Any) -> cncgen.Machine:
    given = axis or Axis("X", 1, 1, 1)
    return cncgen.Machine("m", **{"axes": {given.letter: given}, **values})


def planned(_: object = None) -> tuple[int, float]:
    points = cncgen.sample(cncgen.plan(square(), "xy-table")).collect()
    return len(points), float(points.position.max())


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: cncgen.read(5), "the program is of type int; it is to be the name of a file"),
        (lambda: cncgen.read("none.nc"), "cannot read none.nc: there is no such file"),
        (lambda: cncgen.read(SQUARE), "the program is a text, not the name of a file\n  help: cncgen.read_text reads"),
        (lambda: cncgen.read(__file__, language="c"), "language = 'c' is not one of gcode, stepnc"),
        (lambda: cncgen.read(__file__, options={}), "options is of type dict; it is to be cncgen.ReadOptions"),
        (lambda: cncgen.read(__file__, dialekt="fanuc"), "there is no option 'dialekt'\n  help: did you mean dialect"),
        (lambda: cncgen.read_text(SQUARE, dialect="fanu"), "dialect = 'fanu' is not one of auto, linuxcnc, fanuc"),
        (lambda: cncgen.read_text(SQUARE, options={}, units="mm"), "options is of type dict; it is to be cncgen.ReadOptions"),
        (lambda: cncgen.read_text(5), "text is of type int; it is to be a text or bytes"),
        (lambda: cncgen.load_machine("mill"), "there is no machine profile 'mill'"),
        (lambda: cncgen.load_machine(None), "the machine is of type NoneType; it is to be a profile's name"),
        (lambda: read_with(dialect="fanu"), "dialect = 'fanu' is not one of auto, linuxcnc, fanuc, fanuc-lathe, fanuc-lathe-b, fanuc-lathe-c, heidenhain"),
        (lambda: read_with(max_steps=-1), "max_steps = -1 is not a whole number greater than 0"),
        (lambda: read_with(include="sub"), "include = 'sub' is not a sequence of names of folders"),
        (lambda: read_with(tolerance_mm=np.nan), "tolerance_mm = nan is not a number greater than 0"),
        (lambda: read_with(tool_table=3), "tool_table = 3 is not the name of a file"),
        (lambda: cncgen.plan(5), "the program is of type int"),
        (lambda: cncgen.plan(square(), None), "the machine is of type NoneType"),
        (lambda: cncgen.plan(square(), options="ild"), "options is of type str"),
        (lambda: cncgen.plan(square(), feed_rate="ild"), "there is no option 'feed_rate'\n  help: did you mean feedrate"),
        (lambda: cncgen.plan(square(), feedrate="fast"), "feedrate = 'fast' is not one of optimal"),
        (lambda: cncgen.plan(square(), path_tolerance_mm="1"), "path_tolerance_mm = '1' must be a number"),
        (lambda: cncgen.plan(square(), path_tolerance_mm=np.inf), "path_tolerance_mm = inf must be a number"),
        (lambda: cncgen.plan(square(), kbar_per_mm=None), "kbar_per_mm = None must be a number"),
        (lambda: cncgen.plan(square(), servos=5), "servos is of type int; it is to be a mapping of letters"),
        (lambda: cncgen.plan(square(), servos={"X": 1}), "servo data of axis X are 1; they are to be a cncgen.machine.Servo"),
        (lambda: cncgen.sample([]), "what is sampled is of type list; it is to be what cncgen.plan returns"),
        (lambda: cncgen.sample(cncgen.plan(square()), "vel,speed"), "signals speed: not one of vel"),
        (lambda: cncgen.sample(cncgen.plan(square()), None), "signals is of type NoneType; it is to be names of signals"),
        (lambda: cncgen.sample(cncgen.plan(square()), ["vel", 5]), "a signal is of type int; it is to be its name"),
        (lambda: cncgen.write([], "a.csv"), "there are no setpoints"),
        (lambda: cncgen.write(5, "a.csv"), "setpoints is of type int"),
        (lambda: cncgen.write(cncgen.plan(square()), "a", format="xls"), "format 'xls' is not one of csv"),
        (lambda: cncgen.write(cncgen.plan(square()), None), "the target is of type NoneType"),
        (lambda: cncgen.judge(cncgen.plan(square()), "none.nc", "xy-table"), "cannot read none.nc"),
        (lambda: cncgen.judge(cncgen.plan(square()), 5, "xy-table"), "the program is of type int"),
        (lambda: judged(tolerance_mm=-1), "tolerance_mm = -1 must be a finite number above 0"),
        (lambda: judged(tolerance_mm=np.nan), "tolerance_mm = nan must be a finite number above 0"),
        (lambda: judged(resolution="fine"), "resolution = 'fine' must be a finite number above 0"),
        (lambda: cncgen.plan(square(), machine(axes=["X"])), "machine m: axes is a list; it is to be a mapping"),
        (lambda: cncgen.plan(square(), machine(axes={"X": 1})), "axis 'X' is a int; it is to be a cncgen.machine.Axis"),
        (lambda: cncgen.plan(square(), machine(axes={"Y": Axis("X", 1, 1, 1)})), "axis 'X' stands under 'Y'"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, -1, 1))), "max_acceleration of axis X is -1; it is to be a number"),
        (lambda: cncgen.plan(square(), machine(Axis("C", 1, 1, np.nan))), "max_jerk of axis C is nan; it is to be a number"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, (1, 1)))), "travel of axis X is (1, 1); it is to be"),
        (lambda: cncgen.plan(square(), machine(axes={})), "machine m: it has no axis"),
        (lambda: cncgen.plan(square(), replace(machine(), name=5)), "name is 5; it is to be a text"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, None, 5))), "servo data of axis X are 5; they are to be"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, None, Servo("pi-p", {})))), "axis X, model: must be one of"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, None, Servo("first-order", [80])))), "parameters a mapping"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, None, Servo("first-order", {"position_gain_1_s": np.nan})))),
         "servo data of axis X, position_gain_1_s: must be a finite number; is nan"),
        (lambda: cncgen.plan(square(), machine(axes={"X": Axis(np.zeros(2), 1, 1, 1)})), "stands under 'X'; axes are X Y Z"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, drive=0))), "drive of axis X, is of type int; it is to be a cncgen.machine.Drive"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, drive=Drive(None)))), "drive of axis X, counts_per_mm: must be a number from "
         "1e-06 to 1e+12, is None"),
        (lambda: cncgen.plan(square(), machine(Axis("X", 1, 1, 1, drive=Drive(1, torque_friction=np.zeros(2))))), "torque_permille_friction: must be"),
        (lambda: cncgen.plan(square(), machine(Axis("A", 1, 1, 1, drive=Drive(10**400)))), "drive of axis A, counts_per_deg: must be"),
        (lambda: cncgen.simulate(points(), {"X": Servo("first-order", {"position_gain_1_s": 80}, 0)}), "servo data of axis X, knows: is 0"),
        (lambda: cncgen.simulate(points(), {"X": Servo("first-order", {"position_gain_1_s": 80}, Servo("first-order", {}))}),
         "servo data of axis X, knows, position_gain_1_s: missing"),
        (lambda: fmu({}), "there are no axes with servo data"),
        (lambda: fmu("xy-table", fmi=np.zeros(2)), "must be 2 or 3, the version of the standard"),
        (lambda: read_with(block_delete="no"), "block_delete is of type str; it is to be True or False"),
        (lambda: read_with(inch_tables=None), "inch_tables is of type NoneType; it is to be True or False"),
        (lambda: cncgen.plan(square(), machine(period_s=0)), "period_s is 0; it is to be a number from 1e-06 to 10"),
        (lambda: cncgen.plan(square(), machine(max_contour_error_mm="1")), "max_contour_error_mm is '1'; it is to be"),
        (lambda: cncgen.simulate(points(), None), "the machine is of type NoneType; it is to be a Machine"),
        (lambda: cncgen.simulate(points(), {"X": 1}), "servo data of axis X are 1; they are to be a cncgen.machine.Servo"),
        (lambda: cncgen.simulate(points(), {"x": Servo("first-order", {"position_gain_1_s": 80})}),
         "servo data of 'x': not an axis\n  help: axes are X Y Z A B C U V W, in capitals"),
        (lambda: cncgen.simulate(points(), {"X": Servo("pi-p", {})}), "servo data of axis X, model: must be one of"),
        (lambda: cncgen.simulate(points(), {"X": Servo("first-order", {"position_gain_1_s": 0})}),
         "servo data of axis X, position_gain_1_s: must be > 0; is 0"),
        (lambda: cncgen.read_setpoints("none.csv"), "cannot read none.csv"),
        (lambda: cncgen.read_setpoints("a.csv", axes="XX"), "axes = 'XX' must be letters of axes"),
        (lambda: cncgen.read_setpoints("a.csv", axes=5), "axes is of type int; it is to be a text or None"),
        (lambda: cncgen.read_setpoints("a.csv", period_s="1"), "period_s = '1' must be a finite number above 0"),
        (lambda: cncgen.simulate("a.csv", "xy-table"), "setpoints is of type str; it is to be cncgen.Setpoints, or a stream "
         "of them\n  help: cncgen.read_setpoints reads those of a file"),
        (lambda: cncgen.simulate(np.zeros((5, 2)), "xy-table"), 'help: cncgen.Setpoints("XY", period_s, 0, rows) makes'),
        (lambda: cncgen.simulate(5, "xy-table"), "setpoints is of type int"),
        (lambda: list(cncgen.simulate(iter(()), "xy-table")), "there are no setpoints\n  help: a generator can be read once"),
        (lambda: list(cncgen.simulate(cncgen.Setpoints("X", 0.001, 0, np.zeros((0, 1))), "xy-table")), "there are no setpoints"),
        (lambda: list(cncgen.simulate(cncgen.Setpoints("XY", 0.001, 0, [[0.0], [1.0, 2.0]]), "xy-table")),
         "positions of setpoints are not an array of numbers"),
        (lambda: cncgen.simulate([], "xy-table", controller="pid"), "no controller is called 'pid'"),
        (lambda: cncgen.simulate([], "xy-table", settle_s=-1), "settle_s = -1 must be a finite number not below 0"),
        (lambda: cncgen.simulate([], "xy-table", settle_s=1e9), "settle_s = 1000000000.0 must be a finite number not "
         "below 0, up to 3600"),
        (lambda: list(cncgen.simulate([np.zeros((3, 2))], "xy-table")), "a chunk of setpoints is of type ndarray"),
        (lambda: cncgen.read("a\ud800"), "cannot read a file whose name holds U+D800"),
        (lambda: cncgen.read("a\0"), "cannot read a file whose name holds a NUL"),
        (lambda: cncgen.write(points(), "a\ud800.csv"), "cannot write a file whose name holds U+D800"),
        (lambda: judged(tolerance_mm=1e300), "tolerance_mm = 1e+300 must be a finite number above 0, up to 1e+06"),
        # With 1000 mm butterfly.nc had left its path by 24 mm; with 1e300 there was no end.
        (lambda: judged(resolution=1000), "resolution = 1000 must be a finite number above 0, up to 1"),
        # Arrays are equal to nothing and to no one thing: each of these ended in numpy, or was taken for what is usual.
        (lambda: cncgen.read_text("M2", language=np.zeros(3)), "language is of type ndarray; it is to be a text or None"),
        (lambda: cncgen.read_text("M2", language=[]), "language is of type list; it is to be a text or None"),
        (lambda: cncgen.read_text("M2", language=""), "language = '' is not one of gcode, stepnc"),
        (lambda: cncgen.read_text("M2", 5), "name is of type int; it is to be a text"),
        (lambda: cncgen.read_text("M2", dialect=np.zeros(3)), "dialect is of type ndarray; it is to be a text"),
        (lambda: cncgen.read_text("M2", tips_alone="yes"), "tips_alone is of type str; it is to be True or False"),
        (lambda: cncgen.read_text("M2", kinematics={"model": "head-head"}), "kinematics is of type dict; it is to be Kinematics or None"),
        (lambda: cncgen.plan(square(), "xy-table", interpolator=["taylor1"]), "interpolator is of type list; it is to be a text"),
        (lambda: cncgen.plan(square(), "xy-table", corner_distance_mm=np.zeros(3)), "corner_distance_mm = array([0., 0., 0.]) must be a number"),
        (lambda: cncgen.plan(square(), "xy-table", max_steps=0), "max_steps = 0 must be a number greater than 0"),
        (lambda: cncgen.plan_with_summary(square(), "xy-table", line_times=True), "line_times is of type bool; it is to be LineTimes or None"),
        (lambda: cncgen.report_page(square(), "xy-table", {"feedrate": "ild"}), "options is of type dict; it is to be cncgen.PlanOptions or None"),
        (lambda: cncgen.report_page(square(), "xy-table", with_why="no"), "with_why is of type str; it is to be True or False"),
        (lambda: cncgen.report_page(square(), "xy-table", compare=5), "compare is of type int; it is to be plans, in a list"),
        (lambda: cncgen.report_page(square(), "xy-table", compare=[5]), "what is compared is of type int; it is to be a text as of --compare"),
        (lambda: cncgen.report_page(square(), "xy-table", compare="sped=5"), "compare: 'sped' is not a setting"),
        (lambda: cncgen.write(points(), "w.csv", format=np.zeros(3)), "format is of type ndarray; it is to be a text or None"),
        (lambda: cncgen.plan(square(), replace(cncgen.load_machine("xy-table"), settings={"times": {"tool_chnage_s": 4.0}})),
         "settings times.tool_chnage_s: unknown key; did you mean tool_change_s?"),
        (lambda: cncgen.plan(square(), replace(cncgen.load_machine("xy-table"), settings={"time": {}})), "settings 'time': {}; they are to be tables, by names of"),
        (lambda: cncgen.plan(square(), replace(cncgen.load_machine("xy-table"), settings=[])), "settings is a list; it is to be a mapping of names to tables"),
    ],
)  # fmt: skip
def test_a_wrong_argument_is_said(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(UsageError) as caught:
        call()
    assert words in str(caught.value)


def test_options_of_reading_are_keywords_or_a_record() -> None:
    """1 in is 25.4 mm."""
    text = "G0 X1\nM2\n"
    for program in (
        cncgen.read_text(text, units="inch"),
        cncgen.read_text(text, options=cncgen.ReadOptions(units="inch")),
        cncgen.read_text(text, options=cncgen.ReadOptions(dialect="linuxcnc"), units="inch"),
    ):
        assert max(chunk.end[:, 0].max() for chunk in program.chunks()) == pytest.approx(25.4)


@pytest.mark.parametrize("number", [10**400, -(10**400), np.nan, np.float32("inf"), True, "1", None, 1j])
def test_what_is_no_number_is_refused_everywhere(number: Any) -> None:
    """A whole number too long for a double among them."""
    calls = [
        lambda: list(cncgen.simulate(points(), "xy-table", settle_s=number)),
        lambda: judged(resolution=number),
        lambda: cncgen.plan(square(), kbar_per_mm=number),
        lambda: cncgen.plan(square(), machine(Axis("X", 1, number, 1))),
    ]
    for call in calls if number is None else [*calls, lambda: read_with(tolerance_mm=number)]:
        with pytest.raises(UsageError):
            call()


def test_the_drive_of_numpys_numbers_is_written(tmp_path: Path) -> None:
    """Increments as Python's numbers give: the same bytes."""
    written = []
    for one in (1.0, np.float32(1.0)):
        axes = {
            letter: Axis(letter, 250, 2500, 50_000, drive=Drive(1000 * one, torque_friction=25 * one))
            for letter in "XY"
        }
        cncgen.write(points(), tmp_path / "a.csp", format="csp", machine=cncgen.Machine("own", axes))
        written.append((tmp_path / "a.csp").read_bytes())
    assert written[0] == written[1]


def test_numbers_of_numpy_are_numbers() -> None:
    axes = {letter: Axis(letter, np.float32(250), np.int64(2500), np.float64(50_000)) for letter in "XY"}
    own = cncgen.Machine("own", axes, period_s=np.float64(0.001))
    ours = cncgen.sample(cncgen.plan(square(), own, path_tolerance_mm=np.float32(0.01))).collect()
    assert len(ours) == planned()[0]


@pytest.mark.parametrize(
    ("position", "words"),
    [
        (np.zeros((5, 3)), "setpoints of axes XY have an array of shape (5, 3), not (rows, axes)"),
        (np.zeros(5), "of shape (5,)"),
        ([["a", "b"]], "not an array of numbers"),
        (np.array([[1j, 0]]), "positions of setpoints are complex numbers"),
        (np.ma.masked_array(np.zeros((5, 2)), mask=np.eye(5, 2)), "positions of setpoints are masked"),
        (np.array([[0, 0], [0, np.nan]]), "setpoint 1, at 0.001 s, is not finite"),
    ],
)
def test_setpoints_of_ones_own_are_looked_at(position: Any, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        list(cncgen.simulate(cncgen.Setpoints("XY", 0.001, 0, position), "xy-table"))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("axes", "period_s"), [(None, 0.001), ({1: None}, 0.001), ({}, "1 ms"), ({}, 10**400)]
)
def test_a_machine_that_is_built_wrongly_can_be_shown(axes: Any, period_s: Any) -> None:
    """Messages name it, and so do debuggers."""
    assert repr(cncgen.Machine("m", axes, period_s)).endswith(f"axes {axes!r}, period_s {period_s!r})")


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"axes": "xy"}, "axes of setpoints = 'xy' must be letters of axes, of XYZABCUVW, once each"),
        ({"axes": ["X", "Y"]}, "axes of setpoints = ['X', 'Y'] must be"),
        ({"axes": "XX"}, "axes of setpoints = 'XX' must be"),
        ({"period_s": 0}, "period_s of setpoints = 0 must be a finite number not below 1e-07, up to 1000"),
        ({"period_s": 10**400}, "period_s of setpoints = 1000"),
        ({"first": 10**400}, "first of setpoints = 1000"),
        ({"first": None}, "first of setpoints is of type NoneType"),
        ({"position": None}, "setpoints of axes XY have an array of shape ()"),
        ({"position": [[10**400, 0]]}, "positions of setpoints are not an array of numbers: int too large"),
        ({"signals": None}, "signals of setpoints is of type NoneType"),
        ({"events": "x"}, "events of setpoints hold 'x'; they are to be triples"),
        ({"period_s": "1 ms"}, "period_s of setpoints = '1 ms' must be"),
        ({"first": 0.5}, "first of setpoints is of type float"),
        ({"signals": {"speed": np.zeros(5)}}, "signals speed: not one of vel, acc, jerk, feed, line, limit"),
        (
            {"signals": {"vel": np.zeros(5)}},
            "the signal vel is to be an array of numbers of shape (5, 2); it has (5,)",
        ),
    ],
)
def test_fields_of_setpoints_of_ones_own_are_looked_at(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError) as caught:
        replace(points(), **fields)
    assert words in str(caught.value)


@pytest.mark.parametrize("place", [np.nan, np.inf, 1e300])
def test_setpoints_without_a_place_are_shown_as_a_line(place: float) -> None:
    """In a notebook, where a picture of them would fail."""
    assert replace(points(), period_s=np.float32(1))._repr_html_()
    assert replace(points(), position=np.full((5, 2), place))._repr_html_() is None


def test_chunks_of_setpoints_follow_each_other() -> None:
    """As rows of one file would: 5 rows from 0 are gone on with by row 5."""
    for other, words in (
        (points(), "begins with row 0; it is to go on with row 5"),
        (replace(points(), first=5, period_s=0.002), "has a period of 0.002; the one before it has 0.001"),
        (replace(points(), first=5, axes="XZ"), "has axes XZ; the one before it has XY"),
    ):
        with pytest.raises(UsageError, match=words):
            list(cncgen.simulate([points(), other], "xy-table"))
    assert sum(map(len, cncgen.simulate([points(), replace(points(), first=5)], "xy-table"))) == 10


def test_signals_of_ones_own_are_written(tmp_path: Path) -> None:
    """A list is as good as an array."""
    own = cncgen.Setpoints("X", 0.001, 0, [[0.0], [1.0]], {"line": [1, 2]})
    assert cncgen.write(own, tmp_path / "a.csv") == 2
    assert (tmp_path / "a.csv").read_text().split() == [
        "t_s,x_mm,line",
        "0.000000000,0.000000000,1",
        "0.001000000,1.000000000,2",
    ]


@pytest.mark.parametrize("source", ["G1 X1 F100\n", "G1 X1 F100\nG1 X=\n", STEPNC])
def test_a_program_that_is_read_again_has_each_fault_once(source: str) -> None:
    """After a whole reading, after the beginning of one, and while another goes on."""
    program = cncgen.read_text(source)
    begun = program.chunks()
    next(begun, None)
    rows = sum(map(len, program.chunks()))
    found = [item.render() for item in program.diagnostics]
    assert found
    assert sum(map(len, program.chunks())) == rows
    list(begun)
    assert [item.render() for item in program.diagnostics] == found
    assert program.diagnostics.total == len(found)


def test_setpoints_of_ones_own_are_simulated() -> None:
    """Lists, whole numbers and columns that do not lie together are the same motion as an array of doubles."""
    rows = np.linspace(0, 1, 50)[:, None] * [10, 0]
    (want,) = cncgen.simulate(cncgen.Setpoints("XY", 0.001, 0, rows), "xy-table")
    for other in (rows.tolist(), np.asfortranarray(rows), np.repeat(rows, 2, axis=1)[:, ::2]):
        (found,) = cncgen.simulate([cncgen.Setpoints("XY", 0.001, 0, other)], "xy-table")
        np.testing.assert_array_equal(found.position, want.position)
    (found,) = cncgen.simulate(cncgen.plan(square(), "xy-table"), "xy-table")
    assert len(found) == planned()[0]


def test_setpoints_to_a_file_and_back(tmp_path: Path) -> None:
    """With signals and without, whole and as a stream; what is written is judged as what is planned."""
    points = cncgen.sample(cncgen.plan(square(), "xy-table"), "vel,line").collect()
    assert cncgen.write(points, tmp_path / "a.csv") == len(points)
    assert (tmp_path / "a.csv").read_text().startswith("t_s,x_mm,y_mm,x_vel_mm_s,y_vel_mm_s,line\n")
    assert cncgen.write(cncgen.plan(square(), "xy-table"), tmp_path / "b", format="f64") == len(points)
    for found in (cncgen.read_setpoints(tmp_path / "a.csv"),
                  cncgen.read_setpoints(tmp_path / "b", format="f64", axes="XY")):  # fmt: skip
        assert (found.axes, found.period_s) == ("XY", 0.001)
        np.testing.assert_allclose(found.position, points.position, rtol=0, atol=5.1e-10)
        assert cncgen.judge(found, square(), "xy-table").holds
    late = cncgen.Setpoints("XY", 0.001, 0, points.position[::2])
    codes = {item.code for item in cncgen.judge(late, square(), "xy-table").breaches}
    assert {"verify-acceleration", "verify-jerk"} <= codes


def test_the_summary_of_a_plan() -> None:
    """40 mm in the time that its setpoints take, at 20 mm/s at most; options as keywords, as `plan` has them."""
    stream, summary = cncgen.plan_with_summary(square(), "xy-table", feedrate="ild", signals="feed")
    points = stream.collect()
    found = json.loads(json.dumps(summary.as_json(), allow_nan=False))
    assert (found["program"], found["machine"], found["feedrate"]) == ("square.nc", "xy-table", "ild")
    assert (found["samples"], found["motions"]) == (len(points), 4)
    assert found["path_length_mm"] == pytest.approx(40.0)
    assert found["feed_mm_s"]["max"] == pytest.approx(float(points.signals["feed"].max()))
    assert 0.0 <= points.time_s[-1] - found["motion_time_s"] < 0.001
    with pytest.raises(UsageError, match="there is no option 'feed_rate'"):
        cncgen.plan_with_summary(square(), feed_rate="ild")


def test_a_summary_of_setpoints_that_were_not_drawn_is_an_error_and_no_row_of_zeros() -> None:
    """A plan that is half drawn has no time: what `as_json` gave before the end were the figures so far."""
    stream, summary = cncgen.plan_with_summary(square(), "xy-table")
    with pytest.raises(cncgen.CncgenError, match="drawn to their end"):
        summary.as_json()
    drawn = stream.collect()
    assert summary.as_json()["motion_time_s"] == pytest.approx(drawn.time_s[-1], abs=0.001)


def test_a_summary_shows_itself() -> None:
    """As the command prints it; it was an object at an address."""
    stream, summary = cncgen.plan_with_summary(square(), "xy-table")
    assert repr(summary) == str(summary) == "Summary('square.nc' on 'xy-table', not drawn to its end)"
    time_s = stream.collect().time_s[-1]
    assert str(summary).startswith("square.nc on xy-table: ")
    told = repr(summary).removeprefix("Summary('square.nc' on 'xy-table', ").removesuffix(" s)")
    assert float(told) == pytest.approx(time_s, abs=0.001)


def test_a_stream_is_drawn_once() -> None:
    """A second time it would look like a program that moves nothing."""
    plan, stream = cncgen.plan(square()), cncgen.sample(cncgen.plan(square()))
    list(plan), stream.collect()
    for again in (lambda: list(plan), lambda: cncgen.sample(plan), stream.collect,
                  lambda: list(cncgen.simulate(stream, "xy-table"))):  # fmt: skip
        with pytest.raises(UsageError, match="was drawn already, and can be drawn once"):
            again()


def test_records_say_what_they_are_in_a_line() -> None:
    plan = cncgen.plan(square(), "xy-table", feedrate="ild")
    trajectory = next(iter(plan))
    points = cncgen.sample(cncgen.plan(square(), "xy-table", feedrate="ild"), "vel").collect()
    (response,) = cncgen.simulate(points, "xy-table")
    found = Diagnostics(
        cncgen.Diagnostic("a", "b", severity) for severity in (Severity.ERROR, *2 * [Severity.NOTE])
    )
    at_rest = cncgen.Setpoints("XY", 0.001, 0, np.zeros((5, 2)))
    still = cncgen.judge(at_rest, cncgen.read_text("G1 X0 Y0 F1\nM2\n"), "xy-table")
    said = {
        repr(found): "Diagnostics(1 error, 2 notes)",
        repr(square()): "Program('square.nc', gcode, axes XY, Diagnostics(none))",
        repr(plan): f"Plan({square()!r}, {plan.machine!r})",
        repr(plan.machine): "Machine('xy-table', axes XY, every 1 ms)",
        repr(trajectory.toolpath): "Toolpath(5 rows, axes XYZ, lines 3 to 7 of square.nc)",
        repr(points): f"Setpoints({len(points)} rows from 0, axes XY, every 1 ms, signals vel)",
        repr(still): "Verdict(5 setpoints, at most 0 µm from the path, Diagnostics(none))",
        repr(response): f"Response({len(points)} rows from 0, axes XY, every 1 ms)",
    }
    assert list(said) == list(said.values())
    assert repr(trajectory).startswith("Trajectory(Toolpath(5 rows")
    assert "\n" not in repr(trajectory)
    assert points == points
    assert points != response
    assert len({points, response, trajectory, trajectory.profile, trajectory.toolpath}) == 5


def test_records_are_pickled() -> None:
    trajectory = next(iter(cncgen.plan(square(), "xy-table", feedrate="ild")))
    points = cncgen.sample(cncgen.plan(square(), "xy-table", feedrate="ild"), "vel").collect()
    machine = cncgen.load_machine("xy-table")
    assert pickle.loads(pickle.dumps(machine)) == machine
    for record in (
        points,
        trajectory,
        trajectory.toolpath,
        *cncgen.simulate(points, machine),
        cncgen.PlanOptions(),
    ):
        assert repr(pickle.loads(pickle.dumps(record))) == repr(record)
    for kind in (ProgramError, UsageError, NoPlanError, cncgen.CncgenError):
        error = pickle.loads(pickle.dumps(kind(cncgen.Diagnostic("a", "b", values={"c": 1.0}))))
        assert (type(error), str(error)) == (kind, "error[a]: b")
        assert error.diagnostics[0].values["c"] == 1.0


def test_threads() -> None:
    """The same rows everywhere."""
    want = planned()
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(planned, range(3))) == [want] * 3


#: What workers do stands in a module of its own, which a new process can import wherever the tests were started from.
WORK = """
import cncgen

def planned(text):
    points = cncgen.sample(cncgen.plan(cncgen.read_text(text, "bad.nc"), "xy-table")).collect()
    return len(points), float(points.position.max())
"""

POOL = """
import multiprocessing
import work
from cncgen.diagnostics import ProgramError

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(1) as workers:
        print(*workers.map(work.planned, [{square!r}])[0])
        try:
            workers.map(work.planned, ["G1 X= F1\\nM2\\n"])
        except ProgramError as error:
            print(error)
"""


def test_other_processes(tmp_path: Path) -> None:
    """The same rows everywhere, and an error of a worker comes back as it is."""
    (tmp_path / "work.py").write_text(WORK)
    (tmp_path / "pool.py").write_text(POOL.format(square=SQUARE))
    run = subprocess.run(
        [sys.executable, "pool.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr
    rows, error = run.stdout.split("\n", 1)
    assert rows.split() == [str(value) for value in planned()]
    assert "bad.nc:1:5: error[syntax]" in error


def test_stages_that_are_dropped_leave_no_thread() -> None:
    before = set(threading.enumerate())
    text = (
        "G21 G90 G64 P0.01\n" + "".join(f"G1 X{k % 7} Y{0.1 * k:.1f} F6000\n" for k in range(3000)) + "M2\n"
    )
    for stage in (iter, cncgen.sample, lambda plan: cncgen.simulate(plan, "xy-table")):
        drawn = iter(stage(cncgen.plan(cncgen.read_text(text), "xy-table")))
        next(drawn)
        del drawn
        gc.collect()
    deadline = time.monotonic() + 10
    while set(threading.enumerate()) - before and time.monotonic() < deadline:
        time.sleep(0.02)
    assert set(threading.enumerate()) <= before


def test_no_warnings_and_strict_arithmetic() -> None:
    script = """
import numpy, cncgen
numpy.seterr(divide="raise", invalid="raise", over="raise")
for text in ("G21\\nG1 X10 F1200\\nG2 Y10 J5\\nG1 Y20\\nX10.0000001\\nM2\\n", "G21\\nG1 X1 F0.1\\nM2\\n"):
    plan = cncgen.plan(cncgen.read_text(text), "xy-table")
    assert list(cncgen.simulate(plan, "xy-table"))
"""
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", script],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stderr


def test_values_as_json() -> None:
    """What strict readers of JSON take: no NaN, no types of numpy."""
    values = {
        "a": np.float64("nan"),
        "b": (np.int64(3), np.arange(2.0)),
        5: [True, None, Severity.NOTE],
        "c": 1j,
    }
    want = {"a": None, "b": [3, [0.0, 1.0]], "5": [True, None, "note"], "c": "1j"}
    assert json_values(values) == want
    said = cncgen.Diagnostic("a", "b", values={"limit": np.inf}).as_json()
    assert json.loads(json.dumps(said, allow_nan=False))["values"] == {"limit": None}


def test_half_a_stream_is_not_taken_for_all_of_it(tmp_path: Path) -> None:
    """What was left after a first chunk was written, and collected, as if it were the whole motion."""
    stream = cncgen.sample(cncgen.plan(square(), "xy-table"))
    next(iter(stream))
    with pytest.raises(UsageError, match="was drawn in part already"):
        stream.collect()
    with pytest.raises(UsageError, match="was drawn in part already"):
        cncgen.write(stream, tmp_path / "rest.csv")
    assert not (tmp_path / "rest.csv").exists()


def test_a_program_that_cannot_be_pickled_says_what_can() -> None:
    with pytest.raises(TypeError, match="hand on the name of the file"):
        pickle.dumps(square())
    with pytest.raises(TypeError, match=r"hand on what its collect\(\) returns"):
        pickle.dumps(cncgen.sample(cncgen.plan(square(), "xy-table")))


def test_an_option_that_is_not_asked_for_is_told() -> None:
    """--profile is one of ild: under optimal it was passed over in silence."""
    with pytest.warns(RemarkWarning, match="profile = linear changes nothing here"):
        cncgen.plan(square(), "xy-table", profile="linear")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cncgen.plan(square(), "xy-table", feedrate="ild", profile="linear")
        cncgen.plan(square(), "xy-table", interpolator="two-stage-linear", master_period_s=0.01)


def test_a_signal_that_is_named_twice_is_one_column(tmp_path: Path) -> None:
    stream = cncgen.sample(cncgen.plan(square(), "xy-table"), "vel,feed,vel")
    assert stream.layout(("vel", "feed", "vel")).signals == ("vel", "feed")
    assert list(stream.collect().signals) == ["vel", "feed"]


@pytest.mark.parametrize(("unit", "told"), [(1.0, False), (16.0, False), (1000.0, True)])
def test_times_in_milliseconds_are_told(unit: float, told: bool) -> None:
    """Setpoints in slow motion keep every limit; a master's period of 16 ms is no other unit."""
    good = cncgen.sample(cncgen.plan(square(), "xy-table")).collect()
    slow = cncgen.Setpoints("XY", unit * 0.001, 0, good.position)
    verdict = cncgen.judge(slow, square(), "xy-table")
    assert ["verify-period" in {found.code for found in verdict.breaches}] == [told]
    assert "verify-jerk" not in {found.code for found in verdict.breaches}
