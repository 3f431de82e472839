"""Roughing and finishing of turned profiles: nothing is cut below what is to stay, and all above it is reached."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.codes.turning_profiles import Segment, moved_aside

Calls = Callable[..., list[str]]
STEPS = "o1 sub\nG0 X5 Z0\nG1 Z-5\nX8 Z-8\nZ-15\nX12 Z-20\no1 endsub\nG0 X15 Z2\n"


def moves(lines: list[str]) -> list[tuple[str, float, float]]:
    """Return kind, Z and X of straight moves."""
    out = []
    for line in lines:
        if line.startswith("STRAIGHT"):
            x, _, z = (float(word) for word in line[line.index("(") + 1 : -1].split(",")[:3])
            out.append((line[9], z, x))
    return out


def profile_at(z: float) -> float:
    """Return X of the steps at a Z."""
    return float(np.interp(-z, [0, 5, 8, 15, 20], [5, 5, 8, 8, 12]))


def test_every_cut_ends_where_its_level_meets_the_profile(calls: Calls) -> None:
    """With D0 the cuts at X 15, 13 … 7 end on the profile; the last cut follows it."""
    lines = calls(f"G18 F100\n{STEPS}G71 Q1 X15 Z2 D0 I2 R0.5\nM2\n", dialect="linuxcnc")
    cuts = [(z, x) for kind, z, x in moves(lines) if kind == "F"]
    levels = [(z, x) for z, x in cuts if x in (15, 13, 11, 9, 7)][:5]
    assert [x for _, x in levels] == [15, 13, 11, 9, 7]
    for z, x in levels[2:]:
        assert profile_at(z) == pytest.approx(x, abs=1e-3)
    assert cuts[-5:] == [(-5, 5), (-8, 8), (-15, 8), (-20, 12), (-20, 15)]


@pytest.mark.parametrize("aside", [0.2, 0.5, 1.0])
def test_what_is_left_is_left_everywhere(calls: Calls, aside: float) -> None:
    lines = calls(f"G18 F100\n{STEPS}G71 Q1 X15 Z2 D{aside} I0.7 R0.5\nM2\n", dialect="linuxcnc")
    for kind, z, x in moves(lines):
        if kind == "F" and -20 < z < 0:
            assert x >= profile_at(z) + aside - 1e-3


def test_finishing_follows_the_profile(calls: Calls) -> None:
    lines = calls(f"G18 F100\n{STEPS}G70 Q1 X15 Z2\nM2\n", dialect="linuxcnc")
    assert [(z, x) for kind, z, x in moves(lines) if kind == "F"] == [(-5, 5), (-8, 8), (-15, 8), (-20, 12)]


@pytest.mark.parametrize("start", ["X0 Z3", "X11 Z3", "X0 Z-9"])
def test_finishing_beside_one_line_is_above_it(calls: Calls, start: str) -> None:
    """Wherever the tool comes from, as LinuxCNC's interpreter ran it: 0.05 beside (2, 0) to (4, -4) begins at X2.045 Z0.022."""
    text = "o1 sub\nG0 X2 Z0\nG1 X4 Z-4\no1 endsub\n"
    lines = calls(f"G18 G8 G21 F100\n{text}G0 {start}\nG70 Q1 E0.05\nM2\n", dialect="linuxcnc")
    (kind, z, x), *rest = moves(lines)[-2:]
    assert (kind, round(z, 3), round(x, 3)) == ("T", 0.022, 2.045)
    assert [(kind, round(z, 3), round(x, 3)) for kind, z, x in rest] == [("F", -3.978, 4.045)]


@given(
    st.lists(st.tuples(st.floats(1.0, 5.0), st.floats(-1.5, 3.0)), min_size=2, max_size=6),
    st.floats(0.05, 0.3),
)
def test_moving_aside_keeps_the_distance(steps: list[tuple[float, float]], distance: float) -> None:
    """Ends of the moved profile are that far from the nearest line of the profile."""
    points = [complex(p) for p in np.cumsum([0j, *(complex(a, b) for a, b in steps)])]
    profile = [Segment(a, b) for a, b in pairwise(points)]
    for segment in moved_aside(profile, distance, left=True):
        gaps = []
        for line in profile:
            along = np.clip(
                ((segment.end - line.start) * line.heading(line.start).conjugate()).real,
                0,
                abs(line.end - line.start),
            )
            gaps.append(abs(segment.end - line.start - along * line.heading(line.start)))
        assert min(gaps) == pytest.approx(distance, rel=0.05)


@pytest.mark.parametrize(
    ("program", "code"),
    [
        (f"G18 F100\n{STEPS}G71 X15 Z2\n", "profile-missing"),
        (f"F100\n{STEPS}G71 Q1 X15 Z2\n", "profile-plane"),
        (f"G18 F100\n{STEPS}G71 Q1 X15 Z2 I0\n", "profile-step"),
        (f"G18 F100\n{STEPS}G71 Q1 X15 Z2 I0.00001\n", "profile-step"),
        (
            "G18 F100\no1 sub\nG0 X5 Z0\nG1 Z-9\nX7 Z-8\no1 endsub\nG0 X15 Z2\nG71 Q1\n",
            "profile-not-monotonic",
        ),
        ("G18 F100\no1 sub\nG0 X5 Z0\no1 endsub\nG0 X15 Z2\nG71 Q1\n", "profile-length"),
        ("G18 F100\no1 sub\nG0 X5 Z0\nG1 Z-4 A1\nZ-9\no1 endsub\nG0 X15 Z2\nG71 Q1\n", "profile-corner"),
    ],
)
def test_faults_have_their_code(run: Callable[..., object], program: str, code: str) -> None:
    out = run(f"{program}M2\n", dialect="linuxcnc")
    assert out.errors[0][0] == code  # type: ignore[attr-defined]


def test_a_program_ends_behind_a_cycle_that_another_lane_follows(run: Any) -> None:
    """The state is one object for the whole run: M2 ends it in the stream, behind a wrong line, and in a loop."""
    profile = "G21 G18 G8 F200\no100 sub\nG0 X5 Z0\nG1 X5 Z-5\nG1 X8 Z-8\no100 endsub\nG0 X15 Z2\n"
    cycle = "G71 Q100 X15 Z2 D0.5 I1 R0.5\n"
    assert [error[0] for error in run(f"{profile}{cycle}G1 X\nM2\nG0 X99\n").errors] == ["syntax"]
    looped = run(f"{profile}o1 while [1]\n{cycle}M2\no1 endwhile\n", max_steps=1000)
    assert looped.errors == []


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        ("O101 WHILE [1]\n#1=2\nO101 ENDWHILE", "profile-length"),
        ("O101 IF [1]\nG1 X3", ""),
        ("O101 IF [0]\nG1 X3", "oword-unmatched"),
        ("G1 X3\nO102 ENDWHILE", "oword-unmatched"),
        ("O102 BREAK", "oword-unmatched"),
        ("O100 CALL", "call-depth"),
        ("O77 CALL", "sub-missing"),
        ("G1 X3\nO100 RETURN\nO102 ENDWHILE", ""),
    ],
)
def test_profiles_whose_flow_leads_nowhere(run: Any, lines: str, code: str) -> None:
    """Loops of a profile are bounded, and what has no end is said at the cycle."""
    out = run(
        f"G18 G21 F100\nO100 SUB\nG0 X2 Z0\nG1 Z-1\n{lines}\nO100 ENDSUB\nG0 X20 Z1\nG70 Q100 X20 Z1\nM2"
    )
    assert [found for found, _, _ in out.errors] == ([code] if code else [])


def test_settings_of_a_profile_are_its_own(run: Any) -> None:
    text = "#5=50\nO100 SUB\nG0 X[2+#5] Z0\n#5=4\nG1 X#5 Z-1\nO100 ENDSUB\nG0 X20 Z1\nG70 Q100 X20 Z1\nG0 X#5\nM2"
    out = run(f"G18 G21 F100\n{text}")
    assert out.errors == []
    assert out.path.end[out.path.kind != 3][-3:, 0].tolist() == [2.0, 4.0, 50.0]


def test_a_line_of_a_profile_that_may_be_left_out_is(run: Any) -> None:
    text = "O100 SUB\nG0 X2 Z0\n/G1 X9\nG1 X4 Z-1\nO100 ENDSUB\nG0 X20 Z1\nG70 Q100 X20 Z1\nM2"
    ends = [
        run(f"G18 G21 F100\n{text}", block_delete=left_out).path.end[:, 0].tolist()
        for left_out in (True, False)
    ]
    assert [9.0 in places for places in ends] == [False, True]


def test_calls_of_a_profile_are_bounded_together(run: Any) -> None:
    """Loops of calls within loops of calls do not multiply."""
    subs = "O100 SUB\nG0 X2 Z0\nO101 REPEAT [9999]\nO77 CALL\nO101 ENDREPEAT\nO100 ENDSUB\n"
    subs += "O77 SUB\nO102 REPEAT [9999]\n#1=1\nO102 ENDREPEAT\nO77 ENDSUB\n"
    out = run(f"G18 G21 F100\n{subs}G0 X20 Z1\nG70 Q100 X20 Z1\nM2")
    assert [found for found, _, _ in out.errors] == ["profile-length"]


def test_a_roughing_that_cuts_nothing_is_said(run: Any) -> None:
    """A profile that falls is cut from inside: from outside the tool is fed along it at full depth, as rs274 does."""
    lines = "G18 G8 G21 F100\nG0 X30 Z2\no100 sub\nG0 X8 Z1\nG1 X6 Z-1\nX4 Z-5\no100 endsub\n"
    said = [d.code for d in run(lines + "G71 Q100 X20 Z5 I1\nM2").diagnostics]
    assert "profile-full-depth" in said
    said = [d.code for d in run(lines + "G71 Q100 X1 Z5 I1\nM2").diagnostics]
    assert "profile-full-depth" not in said


def test_a_plain_face_is_no_profile_of_g72(run: Any, calls: Calls) -> None:
    """rs274 feeds along it at full depth, the allowance behind it, and roughs what lies behind: 0.4 apart, from Z-1 to Z-0.03."""
    lines = "G18 G8 G21 F100\no100 sub\nG1 X25 Z0\nG1 X0 Z0\no100 endsub\nG72 Q100 X25 Z{} D0.03 I0.4\nM2\n"
    for start, far, cuts in (
        (1, True, [(-0.03, 25.0), (-0.03, 0.0)]),
        (-1, False, [(-1.0, 0.0), (-0.6, 0.0), (-0.2, 0.0), (-0.03, 0.0), (-1.0, 0.0)]),
    ):
        assert [(z, x) for kind, z, x in moves(calls(lines.format(start))) if kind == "F"] == cuts
        assert ("profile-full-depth" in [d.code for d in run(lines.format(start)).diagnostics]) == far


def test_the_allowance_of_one_line_lies_where_its_cuts_come_from(calls: Calls) -> None:
    """A profile that falls is cut from inside: 0.5 beside it is 20 - 0.5 * 2 / sqrt(5) in X, also from outside, where rs274 begins so."""
    lines = "G18 G8 G21 F100\no100 sub\nG1 X20 Z0\nG1 X10 Z-20\no100 endsub\nG71 Q100 X25 Z1 D0.5 I10\nM2\n"
    cuts = [(z, x) for kind, z, x in moves(calls(lines)) if kind == "F"]
    assert cuts == [(0.2236, 19.5528), (-19.7764, 9.5528)]


def test_a_profile_without_a_code_begins_with_a_traverse(calls: Calls) -> None:
    """rs274 makes the same cuts of both."""
    text = "G18 G8 G21 F100\no100 sub\n{}X10\nG1 Z-10\nX20 Z-20\no100 endsub\nG71 Q100 X30 Z2 I2 R.5 D0.2\nM2"
    assert calls(text.format("")) == calls(text.format("G0 "))


def test_finishing_under_compensation(run: Any, tmp_path: Path) -> None:
    """The last cuts are those of rs274: beside the profile by the radius of 5, tip 2."""
    table = tmp_path / "tools.tbl"
    table.write_text("T2 P2 D10 Q2\n")
    lines = "G18 G8 G21 F100\nT2 M6\nG0 X80 Z12\no100 sub\nG0 X10\nG1 Z-10\nX20 Z-20\nX30\no100 endsub\n"
    text = f"{lines}G42 D2\nG0 X60\nG70 Q100 X30 Z2\nG40\nG0 X90\nM2"
    out = run(text, tool_table=table, dialect="linuxcnc")
    assert out.errors == []
    ends = [(round(float(x), 4), round(float(z), 4)) for x, _, z in out.path.end[out.path.kind < 3][:, :3]]
    cut = 5.0 * (2.0 - 2.0**0.5)
    assert ends[-4:-1] == [(10.0, round(-10.0 - cut, 4)), (round(20.0 - cut, 4), -20.0), (25.0, -20.0)]


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        # LinuxCNC's own interpreter refuses both lines.
        ("linuxcnc", "o1 sub\nG0 X5 Z0\n{}\nX8 Z-8\no1 endsub\nG7 G18 F100 G0 X20 Z2\nG71 Q1 D1 I0.5 R0.5\nM2"),
        ("fanuc-lathe", "O1\nG21 G99 S500 M3\nT0101\nG0 X20. Z2.\nG71 U1. R1.\nG71 P1 Q2 F.2\nN1 G0 X5.\nG1 Z0\n{}\nN2 G1 X10. Z-8.\nM30"),
        ("fanuc", "O1\nG21 G17 G90 F100\nT1 M6\nG0 X0 Y0 Z1.\nG150 P2 X0 Y0 Z-1. I2. Q1. R1. K0 G41 D1\nM30\nO2\nG1 X20.\nY20.\nX-20.\nY-20.\nX20.\n{}\nX20.\nY0\nM99"),
    ],
)  # fmt: skip
@pytest.mark.parametrize(("line", "code"), [("G9999 X9.", "unknown-code"), ("G1 X9. E5", "unused-word")])
def test_a_line_of_a_profile_that_nobody_knows_is_a_fault(
    run: Any, dialect: str, text: str, line: str, code: str
) -> None:
    """Roughing and pockets took the moves of such lines, and passed the rest over without a word."""
    out = run(text.format(line), dialect=dialect)
    assert code in [d.code for d in out.diagnostics if d.severity.value == "error"]
