"""Canned cycles: where the tool goes, by hand and by symmetry between the planes."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import canon
from cncgen.toolpath.reading import ReadOptions

Calls = Callable[..., list[str]]
Z = 2


def motions(lines: list[str]) -> list[tuple[str, list[float]]]:
    """Return traverses and feeds: ``T`` or ``F`` and X Y Z."""
    out = []
    for line in lines:
        if line.startswith("STRAIGHT_"):
            numbers = [float(word) for word in line[line.index("(") + 1 : -1].split(",")]
            out.append((line[9], numbers[:3]))
    return out


def test_the_manuals_first_example(calls: Calls) -> None:
    """LinuxCNC, "G81 Example 1": from X1 Y2 Z3, G90 G98 G81 X4 Y5 Z1.5 R2.8."""
    moves = motions(calls("F100\nG0 X1 Y2 Z3\nG90 G98 G81 X4 Y5 Z1.5 R2.8\nM2\n", dialect="linuxcnc"))
    assert moves[1:] == [("T", [4, 5, 3]), ("T", [4, 5, 2.8]), ("F", [4, 5, 1.5]), ("T", [4, 5, 3])]


def test_the_manuals_second_example(calls: Calls) -> None:
    """LinuxCNC, "G81 Example 2": incremental, three holes from X1 Y2 Z3, clear Z 4.8, bottom 4.2."""
    moves = motions(calls("F100\nG0 X1 Y2 Z3\nG91 G98 G81 X4 Y5 Z-0.6 R1.8 L3\nM2\n", dialect="linuxcnc"))
    holes = [[5, 7], [9, 12], [13, 17]]
    expected = [("T", [1, 2, 4.8])]
    for x, y in holes:
        expected += [("T", [x, y, 4.8]), ("F", [x, y, 4.2]), ("T", [x, y, 4.8])]
    assert moves[1:] == expected


@given(st.floats(0.3, 3.0), st.floats(1.0, 12.0))
def test_pecks_are_q_deep_and_end_at_the_bottom(step: float, depth: float) -> None:
    text = f"G21 F100\nG0 Z1\nG83 X1 Z{1 - depth:.3f} R1 Q{step:.3f}\nM2\n"
    lines = canon(io.BytesIO(text.encode()), "t", ReadOptions(dialect="linuxcnc"), Diagnostics())
    feeds = [move[Z] for kind, move in motions([li.split(maxsplit=2)[2] for li in lines]) if kind == "F"]
    pecks = -np.diff([1.0, *feeds])
    assert feeds[-1] == pytest.approx(round(1 - depth, 3), abs=1e-4)
    np.testing.assert_allclose(pecks[:-1], round(step, 3), atol=1.1e-4)
    assert 0 <= pecks[-1] <= step + 2e-3
    assert abs(len(feeds) - math.ceil(round(depth, 3) / round(step, 3))) <= 1


@pytest.mark.parametrize("code", ["G73", "G81", "G82", "G83", "G85", "G86", "G89"])
def test_a_cycle_is_the_same_in_every_plane_but_for_the_names_of_the_axes(calls: Calls, code: str) -> None:
    extra = {"G73": "Q1.5", "G83": "Q1.5", "G82": "P1", "G86": "P1", "G89": "P1"}.get(code, "")
    paths = []
    for plane, axes in (("G17", "XYZ"), ("G18", "ZXY"), ("G19", "YZX")):
        a, b, n = axes
        text = f"{plane} F100 S100 M3\nG0 {n}9\nG98 {code} {a}1 {b}2 {n}-4 R3 {extra}\nG99 {a}5\nM2\n"
        order = ["XYZ".index(letter) for letter in axes]
        paths.append([(k, [m[o] for o in order]) for k, m in motions(calls(text, dialect="linuxcnc"))])
    assert paths[0] == paths[1] == paths[2]


def test_tapping_turns_the_spindle_round_at_the_bottom_and_back_on_top(calls: Calls) -> None:
    lines = calls("F100 S100 M3\nG0 Z5\nG84 X1 Z-3 R2\nM2\n", dialect="linuxcnc")
    spindle = [line for line in lines if "SPINDLE" in line and "SPEED" not in line and "MODE" not in line]
    assert spindle[:5] == [
        "START_SPINDLE_CLOCKWISE(0)",
        "STOP_SPINDLE_TURNING(0)",
        "START_SPINDLE_COUNTERCLOCKWISE(0)",
        "STOP_SPINDLE_TURNING(0)",
        "START_SPINDLE_CLOCKWISE(0)",
    ]


@pytest.mark.parametrize(
    ("block", "code"),
    [
        ("G81 X1 Z-1", "cycle-words"),
        ("G81 X1 R1", "cycle-words"),
        ("G81 R1 Z-1 A4 X1", "cycle-rotary"),
        ("G81 X1 Z2 R1", "cycle-depth"),
        ("G81 X1 Z-1 R1 L0", "cycle-repeats"),
        ("G81 X1 Z-1 R1 L9999999", "cycle-repeats"),
        ("G82 X1 Z-1 R1", "cycle-words"),
        ("G82 X1 Z-1 R1 P-1", "dwell-negative"),
        ("G83 X1 Z-1 R1", "cycle-words"),
        ("G83 X1 Z-1 R1 Q0", "cycle-peck"),
        ("G83 X1 Z-1 R1 Q0.0000001", "cycle-peck"),
        ("G84 X1 Z-1 R1", "cycle-spindle"),
        ("G86 X1 Z-1 R1 P1", "cycle-spindle"),
        ("G93 G81 X1 Z-1 R1 F1", "cycle-feed-mode"),
    ],
)
def test_faults_have_their_code_and_line(run: Callable[..., Any], block: str, code: str) -> None:
    out = run(f"F100\nG0 Z5\n{block}\nM2\n", dialect="linuxcnc")
    assert [(found, line) for found, line, _ in out.errors][:1] == [(code, 3)]


def test_the_path_is_exact_within_a_cycle_and_blended_again_after_it(run: Callable[..., Any]) -> None:
    out = run("G64 P0.1 F100\nG0 Z5\nG81 X1 Z-1 R1\nG0 X5\nM2\n", dialect="linuxcnc")
    moving = out.path.kind != 3
    assert out.path.path_mode[moving].tolist() == [0, 1, 1, 1, 1, 0]
