"""Coordinate systems, tool offsets, reference points: program coordinates to machine coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.state.modal import to_machine, to_program
from cncgen.toolpath.record import PathMode


def machine(out: Any) -> np.ndarray:
    """Return machine X Y Z of the motions."""
    assert out.errors == []
    return out.path.end[out.path.kind != 3, :3]


offset = st.lists(st.floats(-100, 100), min_size=9, max_size=9)


@given(offset, offset, st.floats(-360, 360), offset, offset)
def test_program_and_machine_coordinates_undo_each_other(
    point: list[float], origin: list[float], angle: float, g92: list[float], tool: list[float]
) -> None:
    there = to_machine(point, origin, angle, g92, tool)
    np.testing.assert_allclose(to_program(there, origin, angle, g92, tool), point, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G10 L2 P1 X10 Y20\nG0 X1 Y1", [[11, 21, 0]]),
        ("G10 L2 P2 X10\nG0 X1\nG55 X1\nG54 X1", [[1, 0, 0], [11, 0, 0], [1, 0, 0]]),
        ("G10 L2 P1 X10 R90\nG0 X5 Y0", [[10, 5, 0]]),
        ("G0 X7\nG10 L20 P1 X2\nG0 X0", [[7, 0, 0], [5, 0, 0]]),
        ("G0 X7\nG92 X2\nG0 X0\nG92.1\nG0 X1", [[7, 0, 0], [5, 0, 0], [1, 0, 0]]),
        ("G0 X7\nG92 X2\nG92.2\nG0 X1\nG92.3\nG0 X0", [[7, 0, 0], [1, 0, 0], [5, 0, 0]]),
        ("G52 X3\nG0 X1\nG52 X0\nG0 X1", [[4, 0, 0], [1, 0, 0]]),
        ("G10 L2 P1 X10\nG53 G0 X5\nG0 X5", [[5, 0, 0], [15, 0, 0]]),
        ("G43.1 Z12\nG0 Z0\nG49\nG0 Z0", [[0, 0, 12], [0, 0, 0]]),
        ("G0 X3 Y4\nG28.1\nG0 X9\nG28 Y6", [[3, 4, 0], [9, 4, 0], [9, 6, 0], [9, 4, 0]]),
        ("G20\nG10 L2 P1 X1\nG21\nG0 X1", [[26.4, 0, 0]]),
    ],
)
def test_offsets_shift_the_machine(run: Any, text: str, expected: list[list[float]]) -> None:
    np.testing.assert_allclose(machine(run(text + "\nM2")), expected, atol=1e-9)


def test_the_end_of_a_program_leaves_the_machine_where_it_is(run: Any) -> None:
    out = run("G10 L2 P2 X10\nG55 G0 X1\nM2")
    assert out.path.end[-1].tolist() == [11, 0, 0]


def test_tool_table(run: Any, tmp_path: Any) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 Z10 D6 ; end mill\nT2 P2 X1 Z-5\n\n; remark\n")
    text = "T1 M6 G43\nG0 Z0\nT2 M6\nG43 H2 G0 Z0\nG0 X#5410 Y#5400\nM2"
    np.testing.assert_allclose(
        machine(run(text, tool_table=table)), [[0, 0, 10], [0, 0, -5], [1, 2, -5]], atol=1e-9
    )
    inches = machine(run("T1 M6 G43\nG0 Z0\nM2", tool_table=table, inch_tables=True))
    np.testing.assert_allclose(inches, [[0, 0, 254.0]])
    assert run("T3 M6\nM2", tool_table=table).errors == [("unknown-tool", 1, 1)]


def test_g10_sets_the_tool_under_the_program(run: Any, tmp_path: Any) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 Z10\n")
    text = "T1 M6 G43\nG0 Z5\nG10 L10 P1 Z2\nG43\nG0 Z0\nM2"
    out = machine(run(text, tool_table=table))
    # At machine Z15 the tool's tip is said to be at Z2: the tool is 13 long.
    np.testing.assert_allclose(out, [[0, 0, 15], [0, 0, 13]])
    assert run("G10 L1 P1 Z4 R3\nG43 H1\nG0 Z0\nM2", tool_table=table).path.end[0, 2] == 4


def test_a_wrong_tool_table_names_every_fault(run: Any, tmp_path: Any) -> None:
    from cncgen.diagnostics import UsageError

    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1\nP2 Z1\nT1 P3\nT4 P4 K9\nT5 what\n")
    with pytest.raises(UsageError) as caught:
        run("M2", tool_table=table)
    assert [d.span.line for d in caught.value.diagnostics if d.span] == [2, 3, 4, 5]


def test_polar_words(run: Any) -> None:
    out = machine(run("G0 @10 ^90\nG91 ^-90\n@5\nG90 @2\nM2"))
    np.testing.assert_allclose(out, [[0, 10, 0], [10, 0, 0], [15, 0, 0], [2, 0, 0]], atol=1e-9)


def test_synchronised_motion_feeds_by_the_spindle(run: Any) -> None:
    out = run("S120 M3\nF300\nG33 Z-10 K1.5\nG1 Z0\nG33.1 Z-5 K2\nM2")
    assert out.errors == []
    rows = out.path.kind == 0
    np.testing.assert_allclose(out.path.feed[rows], [3.0, 5.0, 4.0, 4.0])
    np.testing.assert_allclose(out.path.end[rows, 2], [-10, 0, -5, 0])
    # A tap stops at its depth, where the spindle turns back (LinuxCNC blends no rigid tap).
    stops, free = PathMode.EXACT_STOP, PathMode.CONTINUOUS
    assert out.path.path_mode[rows].tolist() == [free, free, stops, stops]


def test_probing_goes_to_the_point_and_says_so(run: Any) -> None:
    out = run("G38.2 Z-5 F60\nG0 X[#5063]\nM2")
    assert [d.code for d in out.diagnostics] == ["probe-not-run"]
    np.testing.assert_allclose(machine(out), [[0, 0, -5], [-5, 0, -5]])


def test_a_probe_that_must_touch_has_touched(run: Any, calls: Any) -> None:
    """G38.2 goes on only after contact; G38.3 may find nothing; `rs274` says that there was none."""
    text = "F60\nG38.2 Z-5\n#1=#5070\nG38.3 Z-8\n#2=#5070\nG38.4 Z0\n#3=#5070\nG0 X#1 Y[#2+5] Z#3\nM2"
    assert machine(run(text))[-1].tolist() == [1, 5, 1]
    assert "STRAIGHT_TRAVERSE(0.0000, 5.0000, 0.0000, 0.0000, 0.0000, 0.0000)" in calls(text)


def test_tapping_where_the_tool_stands_is_no_motion(run: Any) -> None:
    """Neither at the start, where no row is that the way back could repeat, nor later."""
    assert (run("S120 M3\nG33.1 Z0 K2\nM2").path.kind == 0).sum() == 0
    out = run("S120 M3 F60\nG1 Z5\nG33.1 Z5 K2\nM2")
    assert out.errors == []
    assert (out.path.kind == 0).sum() == 1


def test_threads_in_any_feed_mode(run: Any) -> None:
    """5 mm a revolution at 120 a minute is 10 mm/s, whatever F means around it."""
    for mode, f, others in (("G94", "F300", 5.0), ("G95", "F1.5", 3.0), ("G93", "F6", 0.1)):
        out = run(f"{mode} S120 M3 {f}\nG1 Z1 {f}\nG33 Z-10 K5\nG1 Z0 {f}\nM2")
        assert out.errors == []
        assert out.path.feed[out.path.kind == 0].tolist() == pytest.approx([others, 10.0, others])


def test_events_between_motions(run: Any) -> None:
    text = "S100 M3\nM8\nG0 X1\nG4 P0.5\nT2 M6\n(MSG, hello)\nM62 P1\nM101 P5\nM0\nM5\nM9\nM30"
    events = [(e.name, e.rest) for e in run(text).path.events]
    assert events == [
        ("spindle", False),
        ("spindle", True),
        ("coolant", False),
        ("dwell", True),
        ("tool", True),
        ("message", False),
        ("output", False),
        ("user", True),
        ("stop", True),
        ("spindle", True),
        ("coolant", False),
        ("end", True),
    ]


def test_inverse_rotation(run: Any) -> None:
    """Turning a system and turning the point back is no turn."""
    out = machine(run(f"G10 L2 P1 R30\nG0 X{math.cos(math.pi / 6):.12f} Y-0.5\nM2"))
    np.testing.assert_allclose(out, [[1, 0, 0]], atol=1e-11)


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_sizes_that_no_table_gives_are_told_once(run: Any, dialect: str) -> None:
    out = run("G43 H3 G0 Z5\nG43 H4 Z6\nG41 D5 G1 X10 F100\nG40 X20\nM30", dialect=dialect)
    assert [(d.code, d.severity, d.span.line) for d in out.diagnostics if d.span] == [
        ("no-tool-table", "note", 1)
    ]


def test_a_tool_set_one_axis_at_a_time_in_a_turned_system(
    calls: Callable[..., list[str]], tmp_path: Path
) -> None:
    """rs274, inches: X2 sets 2.5981 1.5 of X5 Y6 in a system turned by 30 degrees, then Y3 sets 1.0981 4.0981."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 Z1\n")
    text = "G20\nT1 M6 G43\nG10 L2 P1 R30\nG0 X5 Y6 Z7\nG10 L10 P1 X2\nG10 L10 P1 Y3\nM2"
    said = calls(text, tool_table=table, inch_tables=True, stand_alone=True)
    entries = [line for line in said if line.startswith("SET_TOOL_TABLE_ENTRY(1,")]
    assert [line.split()[2:4] for line in entries] == [["2.5981", "1.5000"], ["1.0981", "4.0981"]]


def test_numbered_systems_of_pathpilot(run: Any) -> None:
    """G54.1 P2 is G55 on Tormach's PathPilot (its list of supported codes); LinuxCNC has no G54.1."""
    out = run("G21 G10 L2 P2 X100\nG54.1 P2 G0 X1\nG54.1 P1 X1\nM2", dialect="linuxcnc")
    assert out.errors == []
    assert out.path.end[:2, 0].tolist() == [101.0, 1.0]
    assert [(d.severity.value, d.code) for d in out.diagnostics] == [("warning", "other-control")]
    assert run("G21 G54.1 P12 G0 X1\nM2", dialect="linuxcnc").errors[0][:2] == ("system-number", 1)


@pytest.mark.parametrize("block", ["G92.4 A0", "G92.4 A0 S0", "G92.4 A0 R0", "G28.3 A0"])
def test_axes_are_homed_by_hand_on_smoothieware_and_tinyg(run: Any, block: str) -> None:
    """G92.4 is the last line of Makera's own programs for a fourth axis: A stands at 720 and is called 0, so 90 more lead to 810."""
    out = run(f"G21 G90\nG1 A720 F3000\n{block}\nG1 A90\nM2")
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity.value == "warning"] == ["other-control"]
    assert np.degrees(out.path.end[:2, 3]) == pytest.approx([720.0, 810.0])
