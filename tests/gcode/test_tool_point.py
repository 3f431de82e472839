"""G43.4: the machine's axes by closed forms of the kinematics; how far its lines leave the path; the speed of the tip."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import UsageError
from cncgen.machine.kinematics import Kinematics, kinematics_of
from cncgen.toolpath.record import Kind

TABLES = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))
HEADS = Kinematics(2, (5, 4), pivot=100.0)
MIXED = Kinematics(1, (4, 5), (0.0, 0.0, -100.0), pivot=100.0)
START = "G10 L10 P1 R50.\nG0 X10 Y0 Z0\nG43.4 H1 G0 X10 Y0 Z0\n"
NUMBER = st.floats(-200.0, 200.0)


def machine(run: Any, text: str, kinematics: Kinematics) -> Any:
    """Run a text after the start; return the toolpath."""
    out = run(START + text + "\nM30", dialect="fanuc", kinematics=kinematics)
    assert out.errors == []
    return out


def moves(out: Any) -> Any:
    """Return the ends of motions: the lengths of tools are events between them."""
    return out.path.end[out.path.kind != Kind.EVENT]


@pytest.mark.parametrize("kinematics", [TABLES, HEADS, MIXED])
def test_at_angle_zero_it_is_the_tool_length(run: Any, kinematics: Kinematics) -> None:
    out = machine(run, "G1 X20 F100", kinematics)
    lines = out.path.end[out.path.kind == 0, :3]
    np.testing.assert_allclose(lines, [[10, 0, 0], [10, 0, 50], [20, 0, 50]])


def test_a_table_turns_the_workpiece_against_the_angle(run: Any) -> None:
    """At C90 the point (10, 0) of the table is at (0, -10); at A90 the height above the centre points to +Y."""
    out = machine(run, "G0 C90\nG0 X20", TABLES)
    np.testing.assert_allclose(moves(out)[2:4, :3], [[0, -10, 50], [0, -20, 50]], atol=1e-9)
    # About A: y' = y cos + (z - zc) sin, z' = zc - y sin + (z - zc) cos, of the table turned by -90 degrees.
    out = machine(run, "G0 A90", TABLES)
    np.testing.assert_allclose(moves(out)[2, :3], [10, 100, -100 + 50], atol=1e-9)


def test_a_head_swings_about_its_pivot(run: Any) -> None:
    """At B90 the tool lies along +X: the pivot is 150 beside the tip, the machine 100 below its zero."""
    out = machine(run, "G0 B90\nG0 C90", HEADS)
    np.testing.assert_allclose(moves(out)[2:4, :3], [[160, 0, -100], [10, 150, -100]], atol=1e-9)


def test_a_head_over_a_table(run: Any) -> None:
    """At B90 the pivot is 150 beside the tip along +X; at C90 the point (10, 0) of the table is at (0, -10), and the head stays."""
    out = machine(run, "G0 B90\nG0 C90\nG0 B0", MIXED)
    np.testing.assert_allclose(
        moves(out)[2:5, :3], [[160, 0, -100], [150, -10, -100], [0, -10, 50]], atol=1e-9
    )


def test_g49_leaves_the_machine_where_it_is(run: Any) -> None:
    out = machine(run, "G0 B90\nG49\nG0 Y1", HEADS)
    np.testing.assert_allclose(moves(out)[3, :3], [160, 1, -100], atol=1e-9)


def test_lines_stay_within_the_tolerance_and_take_the_tips_time(run: Any) -> None:
    """A quarter turn of C about a point 10 mm off takes 90 degrees at F90: a minute; the axes follow the circle."""
    out = machine(run, "G1 C90 F90", TABLES)
    rows = np.flatnonzero((out.path.kind == 0) & (out.path.feed_mode == 1))
    points = out.path.end[rows, :2]
    np.testing.assert_allclose(np.hypot(*points.T), 10.0)
    chord = np.hypot(*np.diff(np.vstack([[10.0, 0.0], points]), axis=0).T)
    assert np.all(10.0 - np.sqrt(100.0 - chord**2 / 4) <= TABLES.tolerance * 1.01)
    assert np.sum(1.0 / out.path.feed[rows]) == pytest.approx(60.0)


@pytest.mark.parametrize(("degrees", "lines"), [(0.5, 1), (2.0, 4)])
def test_a_turn_is_as_many_lines_as_it_bends(run: Any, degrees: float, lines: int) -> None:
    """Of a tip 100 mm from A, R T² / 8 is 1 µm for half a degree, and 15 µm for two, so 1 µm for a fourth of them."""
    out = machine(run, f"G1 X10.1 A{degrees} F90", replace(TABLES, tolerance=0.002))
    assert np.count_nonzero((out.path.kind == 0) & (out.path.feed_mode == 1)) == lines


@pytest.mark.parametrize("number", ["X0", "X[0]"])
def test_a_motion_to_where_the_tip_stands_is_none(run: Any, number: str) -> None:
    """In arrays and alone: its axes moved by their rounding, 4e-17 mm, and in inverse time without an end."""
    text = f"G0 X0 Y0 Z0 A6.218 C0\nG43.4 H0\nG1 {number} F6000\nG1 X1\nM30\n"
    out = run(text, dialect="fanuc", kinematics=Kinematics(0, (3, 5), (0.0, 0.0, -150.0)))
    assert out.path.line[out.path.kind == 0].tolist() == [1, 4]


def test_an_arc_of_the_tip(run: Any) -> None:
    """With the rotary axes at rest an arc stays one, in lines, and takes its length over F."""
    out = machine(run, "G2 X-10 I-10 F600", TABLES)
    rows = np.flatnonzero((out.path.kind == 0) & (out.path.feed_mode == 1))
    np.testing.assert_allclose(np.hypot(*out.path.end[rows, :2].T), 10.0)
    assert np.sum(1.0 / out.path.feed[rows]) == pytest.approx(np.pi)


@pytest.mark.parametrize("kinematics", [TABLES, HEADS, MIXED])
@given(tip=st.tuples(NUMBER, NUMBER, NUMBER), angles=st.tuples(NUMBER, NUMBER))
def test_the_inverse_kinematics(kinematics: Kinematics, tip: Any, angles: Any) -> None:
    there = kinematics.machine(tip, angles, 50.0)
    np.testing.assert_allclose(kinematics.tip(there, angles, 50.0), tip, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("G33.1 Z1 K1 M3 S100", "tcp-refused"),
        ("G41 D1", "tcp-refused"),
        ("G28 X0", "tcp-refused"),
        ("G55", "tcp-refused"),
        ("G154 P2", "tcp-refused"),
        ("G111", "tcp-refused"),
        ("G92 X0", "tcp-refused"),
        ("T2 M6", "tcp-refused"),
        ("G38.2 X0 F100", "tcp-refused"),
        ("G53 X0", "tcp-refused"),
        ("H2", "tcp-refused"),
    ],
)
def test_what_does_not_go_with_it(run: Any, text: str, code: str) -> None:
    out = run(START + text + "\nM30", dialect="fanuc", kinematics=TABLES)
    assert [(c, line) for c, line, _ in out.errors] == [(code, 4)]


def test_splines_do_not_go_with_it(run: Any) -> None:
    """Said where the curve is complete, on its last line."""
    out = run(START + "G6.2 P2 K0 X10 Y0 Z0 F100\nK0 X20\nK1\nK1\nM30", dialect="fanuc", kinematics=TABLES)
    assert [(code, line) for code, line, _ in out.errors] == [("tcp-refused", 7)]


DIRECTIONS = START.replace("G43.4", "G43.5")


def test_directions_in_place_of_angles(run: Any) -> None:
    """G43.5 (A-79348E, type 2): the head at B90 points along +X, then C90 along +Y (`test_a_head_swings_about_its_pivot`)."""
    for text in ("G0 I1.\nG0 J2.", "G0 I3. K0\nG91 G0 J1."):
        out = run(f"{DIRECTIONS}{text}\nG49\nG90 G0 Y1\nM30", dialect="fanuc", kinematics=HEADS)
        assert out.errors == []
        np.testing.assert_allclose(
            moves(out)[2:5, :3], [[160, 0, -100], [10, 150, -100], [10, 1, -100]], atol=1e-9
        )


@pytest.mark.parametrize("kinematics", [TABLES, HEADS, MIXED])
def test_directions_move_as_their_angles_do(run: Any, kinematics: Kinematics) -> None:
    """The vector that the kinematics give a pair of angles, against these angles under G43.4; without I J K the tool stays."""
    i, j, k = kinematics.direction((20.4, 30.3))
    outer, inner = ("ABC"[axis - 3] for axis in kinematics.axes)
    by_angles = machine(run, f"G1 X20 Z5 {outer}20.4 {inner}30.3 F300\nX30", kinematics).path
    # Its length means nothing, and it holds until the next one.
    vector = f"I{3 * i:.12f} J{3 * j:.12f} K{3 * k:.12f}"
    out = run(f"{DIRECTIONS}G1 X20 Z5 {vector} F300\nX30\nM30", dialect="fanuc", kinematics=kinematics)
    assert out.errors == []
    assert out.path.axes == by_angles.axes
    np.testing.assert_allclose(out.path.end, by_angles.end, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("G1 X20 I0 J0 K0 F100", "orientation-vector"),
        ("G1 X20 B10 I1 F100", "tcp-refused"),
        ("G2 X20 R5 I1 F100", "tcp-refused"),
        ("G43.5 H1 K1", "not-read"),
        ("G43.5 H1 Q2.", "not-read"),
        ("G43.4 H1\nG1 X20 K1 F100", "unused-word"),
    ],
)
def test_directions_that_are_not_read(run: Any, text: str, code: str) -> None:
    out = run(DIRECTIONS + text + "\nM30", dialect="fanuc", kinematics=HEADS)
    assert [c for c, _, _ in out.errors] == [code]


def test_directions_without_a_machine_are_read_and_warned_of(run: Any) -> None:
    out = run("G21 G90\nG43.5 H1\nG1 X10 I1. K1. F600\nG49\nM30", dialect="fanuc", tips_alone=True)
    assert [d.code for d in out.diagnostics if d.severity != "note"] == ["tcp-machine"]


def test_a_line_runs_again_with_directions(run: Any) -> None:
    """A line of a loop is planned by its letters: without G43.5 its I is refused as ever, with it the letters are others."""
    text = "#1=0\nWHILE[#1LT2]DO1\n#1=#1+1\nG0 X[#1*10] I1.\nEND1\nM30"
    out = run(DIRECTIONS + text, dialect="fanuc", kinematics=HEADS)
    assert out.errors == []
    np.testing.assert_allclose(moves(out)[2:4, 0], [160, 170], atol=1e-9)


@pytest.mark.parametrize("before", ["G41 D1", "G95 F0.1"])
def test_what_may_not_be_in_force_before_it(run: Any, before: str) -> None:
    out = run(f"G10 L12 P1 R1.\n{before}\nG43.4 H1\nM30", dialect="fanuc", kinematics=TABLES)
    assert out.errors == [("tcp-refused", 3, 1)]


@pytest.mark.parametrize("kinematics", [TABLES, HEADS, MIXED])
def test_inverse_time_is_shared_out_by_the_parameter_of_the_move(run: Any, kinematics: Kinematics) -> None:
    """G93 F2 is half a minute for the move, however many lines the axes follow it in."""
    out = machine(run, "G93 G1 X20 C90 F2", kinematics)
    rows = np.flatnonzero((out.path.kind == 0) & (out.path.feed_mode == 1))
    assert len(rows) > 5
    assert np.sum(1.0 / out.path.feed[rows]) == pytest.approx(30.0)
    turned = np.diff(out.path.end[rows, out.path.axes.index("C")], prepend=0.0)
    np.testing.assert_allclose(1.0 / out.path.feed[rows], 30.0 * turned / (np.pi / 2), rtol=1e-9)


def test_motions_of_axes_need_kinematics(run: Any) -> None:
    assert run("G43.4 H1\nM30", dialect="fanuc").errors == [("tcp-machine", 1, 1)]


def test_without_a_machine_the_path_is_that_of_the_tip(run: Any) -> None:
    """The tip goes to X10 Z5 while B turns; with the length 20 the spindle's nose is 20 higher, as under G43."""
    out = run(
        "G21 G90\nG10 L10 P1 R20.\nG43.4 H1\nG1 X10 Z5 B30 F600\nG43.4 H1\nG49\nM30",
        dialect="fanuc",
        tips_alone=True,
    )
    assert [(d.code, d.severity, d.span.line) for d in out.diagnostics if d.code == "tcp-machine"] == [
        ("tcp-machine", "warning", 3)
    ]
    assert out.errors == []
    assert out.path.end[out.path.kind == 0][:, [0, 2]].tolist() == [[10.0, 25.0]]


def test_haas_calls_it_g234(run: Any) -> None:
    """G234 H, which G49 ends, is G43.4; its messages have its name, and it says whose the program is."""
    text = START + "G1 B30 F600\nG49\nG0 Z80\nM30"
    ours, theirs = (
        run(one, dialect="fanuc", kinematics=TABLES).path.end.tolist()
        for one in (text, text.replace("G43.4", "G234"))
    )
    assert ours == theirs
    out = run("G21 G90\nG234 H1\nG1 X5 F100\nM30", kinematics=None)
    assert [(d.code, d.message[:4]) for d in out.diagnostics if d.severity == "error"] == [
        ("tcp-machine", "G234")
    ]


def test_the_table_of_the_machine() -> None:
    table = {"model": "head-head", "axes": ["c", "b"], "pivot_mm": 100}
    assert kinematics_of(table) == HEADS
    with pytest.raises(UsageError) as caught:
        kinematics_of({"model": "delta", "axes": ["a", "a"], "centre_mm": [1], "pivot_mm": -1, "colour": 1})
    keys = [d.message.split(":")[0].removeprefix("kinematics.") for d in caught.value.diagnostics]
    assert keys == ["colour", "model", "axes", "centre_mm", "pivot_mm"]


ROWS = st.lists(
    st.tuples(
        st.sampled_from(["G1", "G1", "G1", "G0", "G3"]),
        *[st.floats(-20.0, 20.0).map(lambda x: round(x, 2))] * 3,
        *[st.floats(-9.0, 9.0).map(lambda x: round(x, 2))] * 2,
        st.sampled_from([100, 1000]),
    ),
    min_size=1,
    max_size=12,
)


@pytest.mark.parametrize("kinematics", [TABLES, HEADS, MIXED])
@pytest.mark.parametrize("modes", ["G94", "G93", "G91"])
@given(rows=ROWS)
def test_runs_of_motions_are_what_their_motions_are_alone(
    run: Any, kinematics: Kinematics, modes: str, rows: Any
) -> None:
    """A number in brackets keeps a line out of the lane of plain lines."""

    def text(number: str) -> str:
        def line(row: Any) -> str:
            code, x, y, z, a, b, feed = row
            first, second = ("XYZABC"[k] for k in kinematics.axes)
            if code == "G3":
                return f"G3 I{number.format(x or 1.0)} Z{z} {first}{a} {second}{b} F{feed}"
            return f"{code} X{number.format(x)} Y{y} Z{z} {first}{a} {second}{b} F{feed}"

        return f"{modes}\n" + "\n".join(map(line, rows))

    plain, slow = machine(run, text("{}"), kinematics), machine(run, text("[{}]"), kinematics)
    np.testing.assert_array_equal(plain.path.kind, slow.path.kind)
    np.testing.assert_allclose(plain.path.end, slow.path.end, atol=1e-9)
    np.testing.assert_allclose(plain.path.feed, slow.path.feed, rtol=1e-9)
    np.testing.assert_array_equal(plain.path.feed_mode, slow.path.feed_mode)
    np.testing.assert_array_equal(plain.path.line, slow.path.line)
    assert plain.path.lever is not None
    np.testing.assert_allclose(plain.path.lever, slow.path.lever, rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "dialect", "name", "end"),
    [
        ("G43.4 H1\nG95\nM30", "fanuc", "G43.4", "G49"),
        ("G234 H1\nG95\nM30", "fanuc", "G234", "G49"),
        ("TRAORI\nG95\nM30", "sinumerik", "TRAORI", "TRAFOOF"),
        ("0 BEGIN PGM A MM\n1 M128\n2 M136\n3 END PGM A MM", "heidenhain", "M128", "M129"),
    ],
)
def test_a_refusal_names_the_word_of_the_program(
    run: Any, text: str, dialect: str, name: str, end: str
) -> None:
    """All of them said that G43.4 is in force, and that G49 ends it."""
    faults = [d for d in run(text, dialect=dialect, kinematics=TABLES).diagnostics if d.severity == "error"]
    assert [(d.code, d.message.endswith(f"not under {name}"), d.hint) for d in faults] == [
        ("tcp-refused", True, f"use {end}")
    ]
