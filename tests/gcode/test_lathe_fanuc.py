"""FANUC's lathes (system A): words, and cycles against what their manual draws (B-64304EN-1, chapter 4)."""

from __future__ import annotations

import io
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.gcode import canon, read
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind
from cncgen.toolpath.slicing import join

ROOT = Path(__file__).resolve().parents[2]
HEAD = "O1\nG97 S1000 M3\n"
Move = tuple[float, float, int]


def outcome(text: str, dialect: str = "fanuc-lathe", **options: Any) -> Any:
    """Return toolpath and errors (code, line, column) of a text that stands from line 3 on."""
    options = {"dialect": dialect, "chunk_rows": 1_000_000, **options}
    program = read(io.BytesIO(f"{HEAD}{text}\nM30\n".encode()), "t.nc", ReadOptions(**options))
    path = join(list(program.chunks()))
    faults = [(d.code, d.span.line, d.span.column) for d in program.diagnostics if d.severity == "error"]
    return path, faults, program


def moves(text: str, **options: Any) -> list[Move]:
    """Return where the motions of a text lead, in X (radius) and Z, and whether they are feeds."""
    path, faults, _ = outcome(text, **options)
    assert faults == []
    rows = np.flatnonzero(path.kind != Kind.EVENT)
    x, z = path.end[rows, 0].round(9) + 0.0, path.end[rows, 2].round(9) + 0.0
    feeds = path.feed_mode[rows] != FeedMode.RAPID
    return list(zip(x.tolist(), z.tolist(), feeds.astype(int).tolist(), strict=True))


def test_x_is_a_diameter_and_u_and_w_are_distances() -> None:
    assert moves("G0 X40. Z5.\nG1 U-10. W-5. F.2\nW-3.\nX30. W1.\nG2 U10. W-5. R5.") == [
        (20, 5, 0),
        (15, 0, 1),
        (15, -3, 1),
        (15, -2, 1),
        (20, -7, 1),
    ]  # fmt: skip
    _, _, program = outcome("G0 U1. W2.")
    assert program.moving_axes == "XZ"


def test_positions_told_to_a_macro_are_diameters() -> None:
    assert moves("G0 X40. Z5.\n#1=#5001-10.\nG0 X#1 Z#5002") == [(20, 5, 0), (15, 5, 0)]


def test_a_profile_of_rounded_places_goes_on_along_z() -> None:
    """An arc of a shop's shaft ends 1 um past where it turns back along Z; it was refused. FANUC has an allowance, parameter 5145."""
    profile = "N1 G0 X0 Z0.1\nG1 Z0\nG3 X11.423 Z-12.361 R7.5\nG2 X12.947 Z-14.009 R1.\nG1 X21.592\nN2 X52."
    path = moves(f"G0 X50. Z5.\nG71 U1. R1.\nG71 P1 Q2 U0 W0 F0.2\n{profile}")
    assert min(x for x, _, feed in path if feed) == pytest.approx(0.0)
    assert min(z for _, z, feed in path if feed) == pytest.approx(-14.009)


def test_a_profile_of_rounded_places_rises() -> None:
    """A corner arc of a shop's tap insert bulges 0.5 um beyond its end, X10.18: R0.1 about (X9.981, Z-7.4) ends at Z-7.41; it was refused."""
    profile = "N1 G0 X8.05\nG1 Z-7.\nG2 X8.65 Z-7.3 R0.3\nG1 X9.98\nG3 X10.18 Z-7.41 R.1\nG1 Z-9.5\nN2 X20."
    path = moves(f"G0 X20. Z3.\nG71 U4.5 R.5\nG71 P1 Q2 U6. W.2 F.2\n{profile}")
    last = [(x, z) for x, z, feed in path if feed]
    assert (10.18 / 2 + 3.0, -7.21) in [(pytest.approx(x), pytest.approx(z)) for x, z in last]
    assert min(z for _, z in last) == pytest.approx(-9.3)


def test_a_tool_change_leaves_the_spindle_of_a_lathe_turning() -> None:
    """M6 stops the spindle in which the tool stands, and that of a lathe holds the part."""
    path, faults, _ = outcome("G99\nG0 X50. Z5.\nT0202 M6\nG1 Z0 F0.1")
    assert faults == []
    assert path.feed[~np.isnan(path.feed)].tolist() == pytest.approx([0.1 * 1000 / 60])


def test_h_is_a_distance_of_the_axis_c_and_marks_a_lathe() -> None:
    """``G01Z-10.5H-375.0F7500`` of a shop's lathe, whose subprogram has no other sign; a number of a length offset is not negative."""
    path, faults, program = outcome("G0 H-30.\nG1 Z-10. H-375. F7500\nG0 U2. H375.", dialect="auto")
    assert faults == []
    ends = path.end[path.kind != Kind.EVENT]
    assert ends[:, [0, 2]].tolist() == [[0, 0], [0, -10], [1, -10]]
    assert np.degrees(ends[:, 3]).tolist() == pytest.approx([-30, -405, -30])
    assert "a distance H of the axis C" in next(d.message for d in program.diagnostics if d.code == "dialect")
    assert "other-control" not in [d.code for d in program.diagnostics]


def test_feeds_a_revolution_of_a_driven_tool() -> None:
    """M113 S500 of a shop's lathe starts a driven tool while the spindle rests; its drilling was refused as one without a spindle."""
    head = "G99 G97 S1200 M3\nG0 X40. Z5.\nM5\n"
    path, faults, program = outcome(f"{head}M113 S500\nG1 X20. F0.1\nS600\nX10.\nM115\nX0.")
    assert faults == []
    assert path.feed[~np.isnan(path.feed)].tolist() == pytest.approx(
        [0.1 * 500 / 60, 0.1 * 600 / 60, 0.1 * 600 / 60]
    )
    assert [d.code for d in program.diagnostics if d.code == "driven-tool"] == ["driven-tool"]
    path, faults, _ = outcome(f"{head}M88 S500\nG1 X20. F0.1\nM3\nM5\nX10.")
    assert faults == [("spindle-stopped", 10, 1)]
    _, faults, _ = outcome(f"{head}M113\nG1 X20. F0.1")
    assert faults == [("spindle-stopped", 7, 1)]


def test_depths_of_a_dwell_and_a_reference_point_by_distances() -> None:
    path, faults, _ = outcome("G0 X40. Z5.\nG4 U1.5\nG4 X.5\nG28 U0 W0")
    assert faults == []
    dwells = [event.values["seconds"] for event in path.events if event.name == "dwell"]
    assert dwells == [1.5, 0.5]
    assert path.end[-1, [0, 2]].tolist() == [0, 0]


def test_t_has_the_tool_and_its_offset(tmp_path: Any) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 X1 Z-2 D0.8 Q3\nT2 P2 X3 Z4\n")
    text = "T0102\nG0 X40. Z5.\nT0100\nG0 X40. Z5.\nT0202\nG0 X40. Z5."
    assert moves(text, tool_table=table) == [(23, 9, 0), (20, 5, 0), (23, 9, 0)]
    path, _, _ = outcome(text, tool_table=table)
    assert [event.values["tool"] for event in path.events if event.name == "tool"] == [1, 2]
    # Five digits have three of the offset, as on Doosan's Lynx 2100.
    path, _, _ = outcome(
        text := "T01002\nG0 X40. Z5.\nT01000\nG0 X40. Z5.\nN5T02002\nG0 X40. Z5.", tool_table=table
    )
    assert moves(text, tool_table=table) == [(23, 9, 0), (20, 5, 0), (23, 9, 0)]
    assert [event.values["tool"] for event in path.events if event.name == "tool"] == [1, 2]


def test_nose_radius_comes_from_the_offset(tmp_path: Any) -> None:
    """A tip that points to the chuck and the axis (Q2) cuts where it is programmed along X and Z; a cone needs the radius."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D0.8 Q2\n")
    text = "T0101\nG0 X60. Z5.\nG1 G42 X40. Z0. F.2\nZ-20.\nX60. Z-30.\nX70.\nG40 Z5."
    cut = [move for move in moves(text, tool_table=table) if move[2]]
    # Where line and cone of 45 degrees meet, the tip is r (1 - tan 22.5°) short along Z.
    assert cut[1] == pytest.approx((20, -20 - 0.4 * (1 - math.tan(math.pi / 8)), 1))


def test_g50_and_feeds() -> None:
    assert moves("G0 X40. Z5.\nG50 X50. Z0.\nG0 X50. Z0.\nX60.") == [(20, 5, 0), (25, 5, 0)]
    path, faults, _ = outcome("G50 S500\nG96 S100\nG0 X10. Z0.\nG1 Z-1. F.1\nG98 G1 Z-2. F60.")
    assert faults == []
    # 100 m/min at 10 mm of diameter are more than 500 rev/min.
    assert path.feed[~np.isnan(path.feed)].tolist() == pytest.approx([0.1 * 500 / 60, 1.0])


SIMPLE = {
    "G90": ("G90 X40. Z-20. F.2", [(20, 2, 0), (20, -20, 1), (25, -20, 1), (25, 2, 0)]),
    "G90 taper": ("G90 X40. Z-20. R-3. F.2", [(17, 2, 0), (20, -20, 1), (25, -20, 1), (25, 2, 0)]),
    "G90 distances": ("G90 U-10. W-22. F.2", [(20, 2, 0), (20, -20, 1), (25, -20, 1), (25, 2, 0)]),
    "G94": ("G94 X10. Z-1. F.2", [(25, -1, 0), (5, -1, 1), (5, 2, 1), (25, 2, 0)]),
    "G94 taper": ("G94 X10. Z-3. R-2. F.2", [(25, -5, 0), (5, -3, 1), (5, 2, 1), (25, 2, 0)]),
    "G92": ("G92 X46. Z-20. F1.5", [(23, 2, 0), (23, -20, 1), (25, -20, 0), (25, 2, 0)]),
    "G92 from an angle": (
        "G92 X46. Z-20. F1.5 Q180000",
        [(23, 2, 0), (23, -20, 1), (25, -20, 0), (25, 2, 0)],
    ),
    "G32": ("G32 Z-20. F1.5", [(25, -20, 1)]),
}


@pytest.mark.parametrize("name", SIMPLE)
def test_a_cycle_of_one_pass_leads_back(name: str) -> None:
    text, expected = SIMPLE[name]
    assert moves(f"G0 X50. Z2.\n{text}") == [(25, 2, 0), *expected]


def test_a_cycle_goes_on_with_the_words_that_change() -> None:
    one = moves("G0 X50. Z2.\nG90 X40. Z-20. F.2\nG90 X36. Z-20.\nG90 X36. Z-10.\nG0 X50. Z2.\nX60.")
    assert moves("G0 X50. Z2.\nG90 X40. Z-20. F.2\nX36.\nW-12.\nG0 X50. Z2.\nX60.") == one


def test_a_thread_keeps_its_lead_along_the_longer_axis() -> None:
    """At 1000 rev/min a lead of 1.5 is 25 mm/s along Z, however the thread tapers."""
    path, _, _ = outcome("G0 X50. Z2.\nG32 X60. Z-20. F1.5")
    motions = path.kind != Kind.EVENT
    along = abs(np.diff(path.end[motions, 2])[-1])
    length = math.hypot(5.0, 22.0)
    assert path.feed[motions][-1] * along / length == pytest.approx(25.0)


# Profiles.

HEIGHTS = st.lists(st.integers(0, 8), min_size=2, max_size=6)


def profile_text(steps: list[int], lengths: list[int]) -> tuple[str, list[tuple[float, float]]]:
    """Return the lines of a rising profile that begins at X20 and goes to the left, and its corners in X (radius) and Z."""
    x, z = 10.0, 0.0
    corners = [(x, z)]
    lines = ["N1 G0 X20.", "G1 Z0. F.1"]
    for rise, run in zip(steps, lengths, strict=False):
        x, z = x + rise, z - run
        corners.append((x, z))
        lines.append(f"X{2 * x:g}. Z{z:g}.")
    lines.append(f"N2 X{2 * x + 2:g}.")
    return "\n".join(lines), [*corners, (x + 1.0, z)]


@settings(max_examples=25)
@given(HEIGHTS, st.lists(st.integers(1, 9), min_size=6, max_size=6), st.sampled_from([0.7, 1.5, 4.0]))
def test_roughing_leaves_the_allowance_and_nothing_else(
    steps: list[int], lengths: list[int], depth: float
) -> None:
    """Each level is a depth below the one before it, ends on the moved profile (found by interpolation), and no cut is in it."""
    text, corners = profile_text(steps, lengths)
    top = corners[-1][0] + 3.0
    found = moves(f"G0 X{2 * top:g} Z2.\nG71 U{depth} R.5\nG71 P1 Q2 U.6 W.1 F.2\n{text}\nG0 X200. Z200.")
    moved = np.array([(x + 0.3, z + 0.1) for x, z in corners])
    levels = [
        before[0]
        for before, after in pairwise(found)
        if after[2] and before[:1] == after[:1] and not before[2]
    ]
    # The last one is the profile's own first level, where that begins along Z.
    levels = [level for level in levels if level > moved[0, 0] + 1e-9]
    count = math.ceil((top - 10.0) / depth - 1e-9) - 1
    np.testing.assert_allclose(levels, [top + 0.3 - depth * k for k in range(1, count + 1)])
    for before, after in pairwise(found):
        if after[2] and before[0] == after[0] in levels and not before[2]:
            above = moved[moved[:, 0] > after[0] + 1e-9]
            reach = np.interp(after[0], moved[:, 0], moved[:, 1]) if len(above) else moved[-1, 1]
            # Where the profile is level it may be met anywhere on it; interpolation takes its last corner.
            assert after[1] >= reach - 1e-6
    follows = [move[:2] for move in found if move[2]][-len({*map(tuple, moved.tolist())}) :]
    kept = [tuple(p) for p in moved.round(9).tolist()]
    assert follows[-1] == kept[-1]
    assert set(follows) <= {*kept, (kept[0][0], 2.1)}
    assert found[-2:] == [(top, 2, 0), (100, 200, 0)]


def cycle_moves(cycle: str, lines: str, start: str) -> list[Move]:
    """Return the moves of a cycle over a profile, without the way there and on."""
    return moves(f"{start}\n{cycle}\n{lines}\nG0 X500. Z500.")[1:-1]


def test_facing_is_turning_with_the_axes_exchanged() -> None:
    turning = cycle_moves(
        "G71 U2. R.5\nG71 P1 Q2 U.4 W.1 F.2", "N1 G0 X20.\nG1 Z-6. F.1\nX40. Z-9.\nN2 X60.", "G0 X60. Z2."
    )
    facing = cycle_moves(
        "G72 W2. R.5\nG72 P1 Q2 U.2 W.2 F.2", "N1 G0 Z10.\nG1 X-12. F.1\nX-18. Z20.\nN2 Z30.", "G0 X4. Z30."
    )
    assert [(z, x, feed) for x, z, feed in facing] == turning


def test_boring_is_turning_in_a_mirror() -> None:
    turning = cycle_moves(
        "G71 U2. R.5\nG71 P1 Q2 U.4 W.1 F.2",
        "N1 G0 X20.\nG1 Z-6.\nG2 X26. Z-9. R3.\nN2 G1 X60.",
        "G0 X60. Z2.",
    )
    boring = cycle_moves(
        "G71 U2. R.5\nG71 P1 Q2 U-.4 W.1 F.2",
        "N1 G0 X-20.\nG1 Z-6.\nG3 X-26. Z-9. R3.\nN2 G1 X-60.",
        "G0 X-60. Z2.",
    )
    assert [(-x, z, feed) for x, z, feed in boring] == turning


def test_lines_of_a_profile_count_as_executed() -> None:
    """Each cycle reads its profile anew: a loop of them ends at the bound of blocks."""
    lines = "".join(f"X{20 + 2 * k}.\nZ-{5 + k}.\n" for k in range(20))
    text = f"G0 X80. Z2. F.1\nG71 U20. R1.\nN9 G71 P1 Q2\nN1 G0 X20.\nG1 Z-4.\n{lines}N2 X70.\nIF[1EQ1]GOTO 9"
    assert outcome(text, max_steps=400)[1][0][0] == "too-many-steps"
    # Without a bound of its own the program is endless for another reason: nothing changes from round to round.
    assert outcome(text)[1] == [("too-many-steps", 49, 1)]


def test_a_thread_of_varying_lead_goes_as_far_each_turn_as_its_lead() -> None:
    """F2 K2 (FANUC 0-TD's example, Z4 to Z-4): 2 n + n² is 8 after two turns of 3 and 5; K-1 of a lead of 4 is 3.5, 2.5, then 1.5 of 2."""
    assert moves("G0 X29. Z4.\nG34 Z-4. F2. K2.")[1:] == [(14.5, 1, 1), (14.5, -4, 1)]
    assert moves("G0 X29. Z0.\nG34 Z-7.5 F4. K-1.")[1:] == [(14.5, -3.5, 1), (14.5, -6, 1), (14.5, -7.5, 1)]
    path, _, _ = outcome("G0 X29. Z4.\nG34 Z-4. F2. K2.")
    assert path.feed[path.kind != Kind.EVENT][1:].tolist() == pytest.approx([3 * 1000 / 60, 5 * 1000 / 60])


@pytest.mark.parametrize("words", ["Z-4. F2.", "Z-10. F4. K-1."])
def test_a_thread_without_a_change_of_lead_or_whose_lead_falls_to_nothing_is_refused(words: str) -> None:
    """A lead of 4 that falls by 1 a turn ends after 8 mm, of 14."""
    _, faults, _ = outcome(f"G0 X29. Z4.\nG34 {words}")
    assert [code for code, *_ in faults] == ["pitch-missing"]


@pytest.mark.parametrize("cycle", ["G71 U2. R.5\nG71", "G72 W2. R.5\nG72", "G73 U6. W3. R3\nG73"])
@pytest.mark.parametrize(
    "lines",
    [
        "#1=1\nWHILE[#1LE3]DO1\nX[20+#1*8] (STEP)\nZ-[2+#1*4]\n#1=#1+1\nEND1",
        "#1=1\nN5 X[20+#1*8]\nZ-[2+#1*4] ; STEP\n#1=#1+1\nIF[#1LE3]GOTO5",
        "#1=0\n/2 X99.\nIF[#1EQ0]THEN#2=28\nX#2Z-6.\nIF[#1EQ1]THEN#2=99\n#3=8\nX[#2+#3]\nZ-10.\nIF[#1GT0]GOTO2\nX44.\nZ-14.",
    ],
)
def test_macros_of_a_profile_mean_what_they_mean_anywhere(cycle: str, lines: str) -> None:
    """A profile by loops, jumps and variables cuts what the same one in numbers cuts; any of them was an error."""
    steps = (
        "X28. Z-6.\nX36.\nZ-10.\nX44.\nZ-14." if "X#2Z" in lines else "X28.\nZ-6.\nX36.\nZ-10.\nX44.\nZ-14."
    )
    text = f"G0 X70. Z2.\n{cycle} P1 Q2 U.4 W.1 F.2\nN1 G0 X20. Z1.\nG1 Z-2.\n{{}}\nN2 X60.\nG70 P1 Q2"
    if cycle.startswith("G72"):
        text = f"G0 X70. Z2.\n{cycle} P1 Q2 U.4 W.1 F.2\nN1 G0 X66. Z-20.\nG1 X60.\n{{}}\nN2 Z1.\nG70 P1 Q2"
        lines, steps = (
            "#1=1\nWHILE[#1LE3]DO1\nX[60-#1*8]\nZ-[20-#1*4]\n#1=#1+1\nEND1",
            "X52.\nZ-16.\nX44.\nZ-12.\nX36.\nZ-8.",
        )
    assert moves(text.format(lines)) == moves(text.format(steps))


def test_finishing_runs_the_comments_and_dwells_of_the_profile() -> None:
    text = "N1 G0 X20. (ROUND)\nG4 X1.\nN2 G1 Z-5. F.1\nG70 P1 Q2"
    whole = f"{HEAD}G0 X30. Z2.\n{text}\nM30\n".encode()
    said = list(canon(io.BytesIO(whole), "t.nc", ReadOptions(dialect="fanuc-lathe")))
    assert sum("ROUND" in line for line in said) == sum("DWELL" in line for line in said) == 2


def test_the_plunge_is_what_the_first_line_of_the_profile_is() -> None:
    cycle, lines = "G71 U5. R.5\nG71 P1 Q2 F.2", "N1 {} X40.\nG1 Z-6.\nN2 X60."
    rapid = cycle_moves(cycle, lines.format("G0"), "G0 X60. Z2.")
    feed = cycle_moves(cycle, lines.format("G1"), "G0 X60. Z2.")
    assert [move[:2] for move in rapid] == [move[:2] for move in feed]
    assert rapid[0] == (25, 2, 0)
    assert feed[0] == (25, 2, 1)


def test_corners_of_a_line_in_the_words_of_lathes() -> None:
    """R rounds, I and K chamfer, as ,R and ,C do; in arcs they mean what they always mean."""
    old = "G0 X20. Z2. F.1\nG1 Z-10. {}\nX40. {}\nZ-20.\nG2 X46. Z-23. {}\nG1 X50."
    signs = old.format(",R2.", ",C1.", "I3. K0.")
    assert moves(old.format("R2.", "K-1.", "R3.")) == moves(signs)
    assert moves(old.format("R2.", "I-1.", "R3.")) == moves(signs)
    # The sign tells which way the next move goes (B-64304EN-1, 8), of R as of I and K.
    assert moves(old.format("R-2.", "K-1.", "R3.")) == moves(signs)
    _, _, program = outcome("G0 X20. Z2. F.1\nG3 I-10. X20.")
    assert program.moving_axes == "XZ"
    found = [(d.code, d.span.line) for d in outcome("F.1\nG1 Z-10. C1.\nX40.")[2].diagnostics if d.span]
    assert ("other-control", 4) in found


def test_words_of_haas() -> None:
    """D is the depth of G71 beside P and Q; K D A I are height, first depth, angle and taper of G76; I K the steps of G75."""
    lines = "N1 G0 X20.\nG1 Z-6.\nX40. Z-9.\nN2 X60.\nG0 X70."
    one = moves(f"G0 X60. Z2.\nG71 P1 Q2 U.4 W.1 D2. F.2\n{lines}")
    assert one == moves(f"G0 X60. Z2.\nG71 U2. R0\nG71 P1 Q2 U.4 W.1 F.2\n{lines}")
    thread = moves("G0 X30. Z5.\nG76 P010060\nG76 X22. Z-20. P1200 Q400 R-.5 F2.")
    assert moves("G0 X30. Z5.\nG76 X22. Z-20. K1.2 D.4 A60 I-.5 F2.") == thread
    groove = moves("G0 X50. Z-10.\nG75 R.5\nG75 X40. Z-14. P3000 Q2500 F.1")
    assert moves("G0 X50. Z-10.\nG75 R.5\nG75 X40. Z-14. I3. K2.5 F.1") == groove


@pytest.mark.parametrize(
    ("way", "depths", "shifts"),
    [
        # D √n of K, at A90 as far along Z as deep.
        ("", [0.5, 0.5 * math.sqrt(2.0), 0.5 * math.sqrt(3.0), 1.0], None),
        ("P1", [0.5, 0.5 * math.sqrt(2.0), 0.5 * math.sqrt(3.0), 1.0], None),
        ("P2", [0.5, 0.5 * math.sqrt(2.0), 0.5 * math.sqrt(3.0), 1.0], [0.5, 2.0 - 0.5 * math.sqrt(2.0), 0.5 * math.sqrt(3.0), 1.0]),
        ("P3", [0.5, 1.0], None),
        ("P4", [0.5, 1.0], [0.5, 1.0]),
    ],
)  # fmt: skip
def test_threads_of_haas_feed_in_as_p_says(
    run: Any, way: str, depths: list[float], shifts: list[float] | None
) -> None:
    """P1 and P3 cut along one edge, P2 and P4 along both; P1 and P2 with a constant amount, P3 and P4 at a constant depth (Haas, "G76")."""
    out = run(
        f"O1\nG20 G97 S500 M3\nG0 X3. Z2.\nG76 X2. Z-2. K1. D.5 A90 {way} F.1\nM30",
        dialect="fanuc-lathe",
        units="inch",
    )
    assert [d.code for d in out.diagnostics if d.code == "unused-word"] == []
    path, begins = out.path, []
    for k in range(1, len(path.end)):
        if path.end[k, 2] < path.end[k - 1, 2] - 25.4:
            begins.append(path.end[k - 1] / 25.4)
    assert [2.0 - at[0] for at in begins] == pytest.approx(depths)
    assert [2.0 - at[2] for at in begins] == pytest.approx(shifts or depths)


def test_finishing_executes_the_lines_and_goes_back() -> None:
    lines = "N1 G0 X20.\nG1 Z-6. F.1 ,R2.\nX40. F.3 ,C1.\nZ-12.\nN2 X60."
    plain = moves(f"G0 X60. Z2.\n{lines}\nG0 X60. Z2.")
    rough = "G71 U9. R1.\nG71 P1 Q2 U.4 W.1 F.2"
    cut = moves(f"G0 X60. Z2.\n{rough}\n{lines}\nG70 P1 Q2")
    assert cut[-len(plain) + 1 :] == plain[1:]
    path, _, _ = outcome(f"G0 X60. Z2.\n{rough}\n{lines}\nG70 P1 Q2")
    assert path.line[path.kind != Kind.EVENT][-4:].tolist() == [8, 9, 10, 11]


def test_passes_like_the_profile() -> None:
    lines = "N1 G0 X20. Z1.\nG1 Z-5. F.1\nN2 X40."
    found = cycle_moves("G73 U4. W2. R3\nG73 P1 Q2 U.4 W.1 F.2", lines, "G0 X60. Z5.")
    expected: list[Move] = []
    for x, z in ((4.2, 2.1), (2.2, 1.1), (0.2, 0.1)):
        expected += [(30 + x, 5 + z, 0), (10 + x, 1 + z, 0), (10 + x, -5 + z, 1), (20 + x, -5 + z, 1)]
    assert found == [tuple(np.round(move, 9)) for move in [*expected, (30, 5, 0)]]
    # In one block, as on Haas's lathes: I and K are the way, radii, D the number of passes (Haas lathe operator's manual, "G73").
    text = f"G0 X60. Z5.\n{{}}\n{lines}"
    one = moves(text.format("G73 P1 Q2 I4. K2. D3 U.4 W.1 F.2"))
    assert one == moves(text.format("G73 U4. W2. R3\nG73 P1 Q2 U.4 W.1 F.2"))


# Grooves and threads.


def test_drilling_in_steps() -> None:
    found = moves("G0 X0. Z2.\nG74 R.5\nG74 Z-8. Q4000 F.1")[1:]
    assert found == [(0, -2, 1), (0, -1.5, 0), (0, -6, 1), (0, -5.5, 0), (0, -8, 1), (0, 2, 0)]


def test_radial_holes_of_haas() -> None:
    """X is the bottom and R a place, both diameters, Y Z C the hole's (Haas lathe operator's manual, "G241", with its example in mm)."""
    text = (
        "G98 G54 G0 X125. Z-19. C0\nG241 X53. Y3. Z-33. C35. R100. F500.\nX47. Y-6. Z-22. C-75.\nG0 G80 Z25."
    )
    path, faults, _ = outcome(text)
    assert faults == []
    rows = path.kind != Kind.EVENT
    ends = [
        end for end, feed in zip(path.end[rows], path.feed_mode[rows], strict=True) if feed != FeedMode.RAPID
    ]
    found = [
        (*end[:3].round(6).tolist(), round(math.degrees(end[list(path.axes).index("C")]), 6)) for end in ends
    ]
    assert found == [(26.5, 3.0, -33.0, 35.0), (23.5, -6.0, -22.0, -75.0)]


def test_left_hand_taps_of_haas_feed_as_right_hand_ones() -> None:
    taps = "G98 G0 X0. Z5.\n{} Z-10. R2. F500.\nG80"
    assert moves(taps.format("G184")) == moves(taps.format("G84"))


def test_grooving_in_steps_and_cuts_beside_one_another() -> None:
    found = moves("G0 X50. Z-10.\nG75 R.5\nG75 X40. Z-14. P3000 Q2500 R.1 F.1")[1:]
    expected: list[Move] = []
    for z in (-10, -12.5, -14):
        expected += [(25, z, 0)] if z != -10 else []
        expected += [(22, z, 1), (22.5, z, 0), (20, z, 1), (20, z + 0.1, 0), (25, z + 0.1, 0)]
    assert found == [*expected, (25, -10, 0)]


@pytest.mark.parametrize("value", ["4000", "4000.0", "3.999999999"])
def test_whole_numbers_of_a_step_are_increments_and_others_lengths(value: str) -> None:
    assert moves(f"G0 X0. Z2.\nG74 Z-8. Q{value} F.1")[1][1] == pytest.approx(-2.0)


def test_a_machine_that_counts_in_increments_counts_steps_so() -> None:
    found = moves("G0 X0. Z2.\nG74 R.5\nG74 Z-8. Q4000 F.1", least_increment=0.001)
    assert found[1:3] == [(0, -2, 1), (0, -1.5, 0)]


def test_a_thread_in_passes_of_equal_section() -> None:
    """Depths Δd √n while the finish is left, at least the least depth apart; two passes at full depth; along one flank."""
    text = "G0 X30. Z5.\nG76 P021060 Q50 R.05\nG76 X22. Z-20. P1200 Q400 F2."
    found = moves(text)[1:]
    cuts = [(before, after) for before, after in pairwise(found) if not before[2] and after[2]]
    depths = [11 + 1.2 - before[0] for before, _ in cuts]
    rough = [0.4 * math.sqrt(n) for n in range(1, 9)]
    np.testing.assert_allclose(depths, [*rough, 1.15, 1.2, 1.2], atol=1e-9)
    for (before, after), depth in zip(cuts, depths, strict=True):
        assert before[1] == pytest.approx(5 - depth * math.tan(math.radians(30)))
        # The chamfer of one lead begins 2 before the end and leaves at 45 degrees.
        assert after == (before[0], -18, 1)
        assert (round(before[0] + 2.0, 9), -20, 1) in found
    assert found[-1] == (15, 5, 0)


def test_a_chamfer_longer_than_the_way_off_the_thread_leaves_at_45_degrees_too() -> None:
    """0.4 and 1 deep under a tool that starts at the thread's crest: it is off 0.4 and 1 behind the chamfer's beginning, 2 before the end, and
    goes on to the end. A straight line to the end would leave a run-out five times as long."""
    found = moves("G0 X24. Z5.\nG76 P011060 Q100 R0\nG76 X22. Z-20. P1000 Q400 F2.")[1:]
    for depth in (0.4, 1.0):
        at = found.index((pytest.approx(12 - depth), -18, 1))
        assert found[at + 1 : at + 3] == [(12, pytest.approx(-18 - depth), 1), (12, -20, 1)]


def test_a_least_depth_of_a_pass_holds() -> None:
    found = moves("G0 X30. Z5.\nG76 P010000 Q150 R0\nG76 X22. Z-20. P1000 Q400 F2.")[1:]
    depths = [12.0 - a[0] for a, b in pairwise(found) if not a[2] and b[2]]
    # 0.4, 0.566 (0.166 more), 0.716 (0.15 more, not 0.127), 0.866, 1.0: the last one at full depth.
    np.testing.assert_allclose(
        depths, [0.4, 0.4 * math.sqrt(2), 0.4 * math.sqrt(2) + 0.15, 0.4 * math.sqrt(2) + 0.3, 1.0]
    )


WRONG = {
    "no depth": ("G0 X60. Z2.\nG71 P1 Q2 F.2\nN1 G0 X20.\nN2 G1 Z-5.", ("profile-step", 4, 1)),
    "no line": ("G0 X60. Z2.\nG71 U1. R1.\nG71 P1 Q3 F.2\nN1 G0 X20.\nN2 G1 Z-5.", ("goto-target", 5, 8)),
    "turned round": ("F.2\nG71 U1. R1.\nN2 G1 Z-5.\nN1 X10.\nG71 P1 Q2", ("profile-missing", 7, 8)),
    "no end": ("F.2\nG71 U1. R1.\nG71 P1", ("profile-missing", 5, 1)),
    "a pocket": (
        "G0 X60. Z2.\nG71 U1. R1.\nG71 P1 Q2 F.2\nN1 G0 X20.\nG1 Z-5.\nX40.\nX30. Z-10.\nN2 X60.",
        ("profile-not-monotonic", 5, 5),
    ),
    "a jump out": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nIF [#1 EQ #0] GOTO 3\nN2 G1 Z-5.\nX60.\nN3", ("profile-flow", 5, 5)),
    "a loop half inside": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nWHILE[#1 LT 0]DO1\nN2 G1 Z-5.\nEND1", ("profile-flow", 5, 5)),
    "an endless profile": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nWHILE[1]DO1\nEND1\nN2 G1 Z-5.", ("profile-length", 5, 5)),
    "a macro": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nG65 P9 X30. Z-3.\nN2 G1 Z-5.\nX60.\nM30\nO9\nM99", ("profile-flow", 5, 5)),
    "a subprogram": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nM98 P9\nN2 G1 Z-5.\nX60.\nM30\nO9\nG1 X9.\nM99", ("profile-flow", 5, 5)),
    "a call": ("F.2\nN1 G0 X20.\nM98 P5\nN2 G1 Z-5. F.1\nG70 P1 Q2", ("sub-missing", 5, 5)),
    "a thread": ("S100M3F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nG32 Z-5. F1.\nN2 G1 Z-9.", ("profile-flow", 5, 5)),
    "a hole": ("S100M3F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nG83 Z-5. R-1.\nN2 G1 Z-9.", ("profile-flow", 5, 5)),
    "the way home": ("S100M3F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nG28 U0\nN2 G1 Z-9.", ("profile-flow", 5, 5)),
    "itself": ("F.2\nN1 G0 X20.\nN2 G70 P1 Q2", ("profile-flow", 5, 8)),
    "one move": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nN2 M8", ("profile-length", 5, 5)),
    "a fault in the profile": ("F.2\nG71 U1. R1.\nG71 P1 Q2\nN1 G0 X20.\nN2 G2 Z-5. R1.", ("arc-radius", 5, 5)),
    "too many cuts": ("G0 X60. Z2. F.1\nG71 U.00001 R1.\nG71 P1 Q2\nN1 G0 X20.\nN2 G1 Z-5.", ("profile-step", 5, 1)),
    "no passes": ("G73 U1. W1. R0", ("profile-passes", 3, 13)),
    "no passes in one block": ("G73 P1 Q2 I1. D0 F.1", ("profile-passes", 3, 15)),
    "no lead": ("G32 Z-5.", ("pitch-missing", 3, 1)),
    "a negative lead": ("G32 Z-5. F-1.", ("pitch-missing", 3, 10)),
    "no spindle": ("M5\nG32 Z-5. F1.", ("spindle-stopped", 4, 1)),
    "no z": ("G90 X20. F.1", ("cycle-words", 3, 1)),
    "no feed": ("G90 X20. Z-5.", ("feed-missing", 3, 1)),
    "a thread in the air": ("G0 X20. Z2.\nG76 X20. Z-5. P1000 Q300 F1.", ("thread-words", 4, 5)),
    "a thread of no height": ("G0 X30. Z2.\nG76 X20. Z-5. P0 Q300 F1.", ("thread-words", 4, 15)),
    "a finish of all": ("G0 X30. Z2.\nG76 P010060 Q50 R1.\nG76 X20. Z-5. P1000 Q300 F1.", ("thread-words", 5, 15)),
    "no words": ("G76 X20. Z-5. F1.", ("thread-words", 3, 1)),
    "digits": ("G76 P123 Q1", ("thread-words", 3, 5)),
    "a short thread": ("G0 X30. Z2.\nG76 P019960 Q50\nG76 X20. Z-5. P1000 Q300 F1.", ("thread-words", 5, 10)),
    "many passes": ("G0 X30. Z2.\nG76 X20. Z-5. P1000 Q.001 F1.", ("thread-words", 4, 21)),
    "no step aside": ("G0 X50. Z2.\nG75 X40. Z-5. P1000 F.1", ("cycle-words", 4, 1)),
    "tiny steps": ("G0 X50. Z2.\nG74 Z-5. Q.00001 F.1", ("cycle-peck", 4, 10)),
    "no bottom": ("G0 X50. Z2.\nG75 Z-5. Q1000 F.1", ("cycle-words", 4, 1)),
    "x and u": ("G0 X50. U2.", ("axis-words-twice", 3, 9)),
    "an angle that leads nowhere": ("F.1\nG1 X50. A180.", ("drawing-angle", 4, 9)),
    "an angle alone": ("F.1\nG1 X50.\nA45. R2.", ("drawing-angle", 5, 1)),
    "a wide tool": ("G0 X30. Z2.\nG76 X20. Z-5. K1. D.3 A180 F1.", ("thread-words", 4, 23)),
    "a way to feed in that there is not": ("G0 X30. Z2.\nG76 X20. Z-5. K1. D.3 A60 P5 F1.", ("thread-words", 4, 27)),
    "a mill's code": ("G43 H1", ("unknown-code", 3, 1)),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_where_it_stands(name: str) -> None:
    text, expected = WRONG[name]
    assert outcome(text)[1][0] == expected


def test_the_fault_of_a_word_of_a_profile_names_its_line() -> None:
    text = "G0 X60. Z2.\nG71 U2. R1.\nG71 P1 Q2 U.4 W.1 F.2\nN1 G0 X20.\nG1 Z-6. A90.\nN2 X50."
    said = [(d.code, d.span.line, d.message) for d in outcome(text)[2].diagnostics if d.span]
    assert [line for code, line, _ in said if code == "drawing-angle"] == [5, 7]
    assert "line 7 of the profile" in next(message for code, _, message in said if code == "drawing-angle")


def test_a_tool_that_is_in_no_table(tmp_path: Any) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D0.8 Q3\n")
    assert outcome("T0109", tool_table=table)[1] == [("unknown-tool", 3, 1)]


@pytest.mark.parametrize(
    "block",
    [
        "G28 U0 W0", "G28 U0 W0\nT0202", "T0202", "T0100", "G53 G0 X0 Z0", "G54", "G50 X80. Z5.", "G92 X38. Z-15. F1.\nX37.",
        "G76 P010060 Q100 R.1\nG76 X38. Z-15. P1000 Q300 F1.5", "G74 R.5\nG74 Z-30. Q5000 F.1", "G75 R.5\nG75 X30. P2000 F.1",
        "G83 X0 Z-40. R-22. Q5000 F.1\nG80",
    ],
)  # fmt: skip
def test_what_interrupts_the_compensation_of_the_nose(tmp_path: Any, block: str) -> None:
    """As if G40 stood before it, and G42 behind it; T with the same offset changes nothing."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D0.8 Q3\nT2 P2 X1 Z2 D1.6 Q3\n")
    before, behind = (
        "T0101\nG0 X60. Z5.\nG1 G42 X40. Z0. F.2\nZ-20.\nX50.\n",
        "X40. Z0.\nZ-20.\nX50.\nG40 X60.",
    )
    written = moves(f"{before}G40\n{block}\nG42 G1 {behind}", tool_table=table)
    assert moves(f"{before}{block}\nG1 {behind}", tool_table=table) == written


@pytest.mark.parametrize(
    ("text", "told"),
    [("T1", True), ("T11", True), ("T 07", True), ("M6 T2", True), ("T0011", False), ("T101", False)],
)
def test_an_offset_without_a_tool_is_told(text: str, told: bool) -> None:
    """T1 and T11 are offsets 1 and 11 here; where T has two digits, T11 is tool 1 with offset 1, and nobody said so."""
    said = outcome(f"IF[#1 LT 1]GOTO5\nN5 {text}\nG0 X5.")[2].diagnostics
    assert [d.code for d in said if d.severity == "warning"] == ["other-control"] * told


def test_m6_does_no_more_than_t_has_done(tmp_path: Any) -> None:
    """The turret turns at T: the spindle runs on, and the tip stays that of the offset, not of the tool's number."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D0.8 Q3\nT12 P12 X1 Z2 D1.6 Q3\n")
    text = "G97 S250 M3\nT0112 {}M8\nG0 X60. Z5.\nG1 G42 X40. Z0. F.2\nZ-20.\nX50.\nG75 R.5\nG75 X30. P2000 F.1\nG40 X60."
    assert outcome(text.format("M6 "), tool_table=table)[1] == []
    assert moves(text.format("M6 "), tool_table=table) == moves(text.format(""), tool_table=table)


def test_the_feed_of_a_code_that_fails_is_not_doubted() -> None:
    """G411 F12. is of the machine's builder: F is no feed, and a remark on it had no place."""
    said = outcome("G411 F12.\nG0 X5.")[2].diagnostics
    assert [d.code for d in said if d.severity != "note"] == ["unknown-code"]


def test_the_same_offset_again_does_not_interrupt_it(tmp_path: Any) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D0.8 Q3\n")
    text = "T0101\nG0 X60. Z5.\nG1 G42 X40. Z0. F.2\n{}Z-20.\nX50.\nG40 X60."
    assert moves(text.format("T0101\n"), tool_table=table) == moves(text.format(""), tool_table=table)


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("G50 S2500", "fanuc-lathe"),
        ("G71 P10 Q20 U.4", "fanuc-lathe"),
        ("G76 P020060 Q100 R.05", "fanuc-lathe"),
        ("G28 U0. W0.", "fanuc-lathe"),
        ("G50", "fanuc"),
        ("G73 X1. Z-5. R1. Q2.", "fanuc"),
        ("(G50 S2500)", "fanuc"),
        ("o10 sub\no10 endsub\nG70 P2 Q10", "linuxcnc"),
    ],
)
def test_what_speaks_for_a_lathe(text: str, dialect: str) -> None:
    """A program number alone speaks for a mill."""
    _, _, program = outcome(text, dialect="auto")
    said = [d.message for d in program.diagnostics if d.code == "dialect"]
    assert said[0].startswith(f"read as {dialect}:")


def test_canonical_calls_begin_in_the_plane_and_feed_of_a_lathe() -> None:
    lines = list(canon(io.BytesIO(b"G0 X20.\nM30\n"), "t.nc", ReadOptions(dialect="fanuc-lathe")))
    assert any("SELECT_PLANE(CANON_PLANE_XZ)" in line for line in lines[:8])
    assert any("STRAIGHT_TRAVERSE(10.0000" in line for line in lines)


def test_the_shaft_is_read_without_a_fault_and_ends_at_home() -> None:
    """Its finish runs along the programmed contour, to the tangent point of each rounding, R tan (turn / 2)."""
    data = (ROOT / "programs" / "lathe" / "shaft.nc").read_bytes()
    program = read(io.BytesIO(data), "shaft.nc")
    (path,) = program.chunks()
    assert {d.severity for d in program.diagnostics} == {"note"}
    finish = path.end[(path.line >= 12) & (path.line <= 19) & (path.kind != Kind.EVENT)][:, [0, 2]]
    corners = [
        (8, 2),
        (8, 0),
        (10, -2),
        (10, -25),
        (12, -25),
        (15, -28),
        (15, 2 * math.tan(math.atan2(10, 15) / 2) - 40),
    ]
    np.testing.assert_allclose(finish[:7], corners, atol=1e-3)
    np.testing.assert_allclose(path.end[-1], 0.0, atol=1e-12)


def test_a_depth_of_cut_in_least_increments(run: Any) -> None:
    """D2000 of the form in one block is 2 mm (6T and 10T); it was read as 2 m, one cut at full depth, without a word."""
    head = "G21 G97 S500 M3\nG0 X52. Z2.\n"
    profile = "N10 G0 X20.\nG1 Z-20. F.1\nN20 X52.\nM30"
    whole, length = (
        run(f"{head}G71 P10 Q20 U.5 W.1 D{depth} F.25\n{profile}", dialect="fanuc-lathe")
        for depth in ("2000", "2.")
    )
    assert whole.errors == length.errors == []
    assert whole.path.end.tolist() == length.path.end.tolist()
    assert [d.code for d in whole.diagnostics if d.severity == "warning"] == ["profile-step"]
    assert not [d for d in length.diagnostics if d.severity == "warning"]


#: Cycles as shops write them, lengths in least increments, and the same with decimal points.
INCREMENTS = [
    ("G21", "G71 U1250 R500\nG71 P10 Q20 U300 W50 F.25", "G71 U1.25 R.5\nG71 P10 Q20 U.3 W.05 F.25", "UUWR"),
    (
        "G20",
        "G71 U1250 R50\nG71 P10 Q20 U500 W25 F.01",
        "G71 U.125 R.005\nG71 P10 Q20 U.05 W.0025 F.01",
        "UUWR",
    ),
    ("G21", "G72 W1000 R200\nG72 P30 Q40 U300 W100 F.25", "G72 W1. R.2\nG72 P30 Q40 U.3 W.1 F.25", "UWWR"),
    (
        "G21",
        "G73 U6000 W500 R3\nG73 P10 Q20 U300 W100 F.25",
        "G73 U6. W.5 R3\nG73 P10 Q20 U.3 W.1 F.25",
        "UUWW",
    ),
    ("G20", "G75 R25\nG75 X1. P500 F.01", "G75 R.0025\nG75 X1. P500 F.01", "R"),
    (
        "G21",
        "G76 P040060 Q30 R30\nG76 X46. Z-20. P920 Q250 F1.5",
        "G76 P040060 Q30 R.03\nG76 X46. Z-20. P920 Q250 F1.5",
        "R",
    ),
    # The form in one block (6T and 10T).
    ("G21", "G76 X46. Z-20. K1300 D400 F1.5 A60", "G76 X46. Z-20. K1.3 D.4 F1.5 A60", "KD"),
    # What is short enough is a length, and so is what has a point.
    ("G21", "G71 U2 R1\nG71 P10 Q20 U1 W0 F.25", "G71 U2. R1.\nG71 P10 Q20 U1. W0. F.25", ""),
    (
        "G21",
        "G73 U60. W0. R3\nG73 P10 Q20 U12. W0. F.25",
        "G73 U60.00 W0. R3\nG73 P10 Q20 U12.00 W0. F.25",
        "",
    ),
    ("G21", "G75 R.5\nG75 X40. P2. F.1", "G75 R.5\nG75 X40. P2000 F.1", ""),
]


@pytest.mark.parametrize(("unit", "written", "meant", "said"), INCREMENTS)
def test_lengths_of_cycles_in_least_increments(
    run: Any, unit: str, written: str, meant: str, said: str
) -> None:
    """B-64304EN-1, 1.6: without a decimal point 1 is a least increment, 0.001 mm or 0.0001 inch.

    G71 U1250 of a shop's program in inches was a single cut at full depth, 1250 inch below, with an allowance of 250 inch.
    """
    scale = 1.0 if unit == "G21" else 1.0 / 25.0
    lines = (
        ("N10 G0", "X", 20.5), ("G1", "Z", -20.5), ("N20 G1", "X", 52.5),
        ("N30 G0", "Z", -20.5), ("G1", "X", 20.5), ("N40 G1", "Z", 2.5),
    )  # fmt: skip
    # G75 and G76 have no profile.
    profile = "".join(
        f"{begin} {axis}{place * scale:g}\n" for begin, axis, place in lines if written[2] in "123"
    )
    texts = (
        f"{unit} G97 S500 M3\nG0 X{52.5 * scale:g} Z{2.5 * scale:g}\n{cycle}\n{profile}M30"
        for cycle in (written, meant)
    )
    found, expected = (run(text, dialect="fanuc-lathe") for text in texts)
    assert found.errors == expected.errors == []
    np.testing.assert_allclose(found.path.end, expected.path.end, atol=1e-9)
    remarks = [d for d in found.diagnostics if d.code == "profile-step"]
    assert sorted(d.message[0] for d in remarks) == sorted(said)
    assert not [d for d in expected.diagnostics if d.code == "profile-step"]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("G0 X50. Z2.\nG1 Z-20. F100.\nM30", (2, 10)),
        ("G20 G0 X2. Z.1\nG1 Z-1. (F50) F.5\nM30", (2, 15)),
        ("G98 G0 X50. Z2.\nG1 Z-20. F100.\nM30", None),
        ("G0 X50. Z2.\nG32 Z-20. F12.\nG1 Z-21. F10.\nM30", None),
        ("G0 X50. Z2.\nG1 Z-20. F0.2 (F100)\nM30", None),
    ],
)
def test_a_feed_that_nobody_means_a_revolution(run: Any, text: str, place: tuple[int, int] | None) -> None:
    """F100 in G99, where a post wrote mm a minute without G98, was 100 mm a revolution without a word."""
    out = run(f"G97 S500 M3\n{text}", dialect="fanuc-lathe")
    found = [(d.span.line - 1, d.span.column) for d in out.diagnostics if d.code == "feed-doubtful"]
    assert found == ([place] if place else [])


#: A program of system B; those of A and C have other numbers for the same codes.
SYSTEM_B = """G21 G90 G95
G92 S2000
G97 S800 M3
G0 X50. Z2.
G77 X46. Z-20. F0.2
X42.
G79 X30. Z-1. F.1
G0 X30. Z5.
G78 X28. Z-15. F1.5
G0 X40. Z0
G91 G1 X4. Z-2. F.2
G90 X60.
G94 Z-20. F100.
G33 Z-30. F1.
M30
"""
SYSTEM_C = {"G77": "G20", "G79": "G24", "G78": "G21", "G21 G90 G95": "G71 G90 G95"}
SYSTEM_A = {"G21 G90 G95": "G21 G99", "G92 S": "G50 S", "G78": "G92", "G77": "G90", "G79": "G94", "G91 G1 X4. Z-2.": "G1 U4. W-2.",
            "G90 X60.": "X60.", "G94 Z-20.": "G98 G1 Z-20.", "G33": "G32"}  # fmt: skip


@pytest.mark.parametrize(("dialect", "other"), [("fanuc-lathe-b", {}), ("fanuc-lathe-c", SYSTEM_C)])
def test_systems_b_and_c_move_as_system_a(run: Any, dialect: str, other: dict[str, str]) -> None:
    """The table of G codes (B-64304EN-1, 3) has one meaning of each row for the three systems."""

    def written(names: dict[str, str]) -> str:
        return "".join(
            next((line.replace(a, b) for a, b in names.items() if a in line), line)
            for line in SYSTEM_B.splitlines(True)
        )

    texts = {dialect: written(other), "fanuc-lathe": written(SYSTEM_A)}
    found = [run(text, dialect=name) for name, text in texts.items()]
    assert [out.errors for out in found] == [[], []]
    for column in ("end", "feed", "feed_mode", "kind"):
        a, b = (getattr(out.path, column) for out in found)
        assert np.array_equal(a, b, equal_nan=True)
    assert found[0].path.end[-1].tolist()[0] == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("dialect", "line", "own"),
    [("fanuc-lathe-b", "G50 S1000", "G92"), ("fanuc-lathe-c", "G32 Z-1. F1.", "G33")],
)
def test_codes_of_system_a_in_another(run: Any, dialect: str, line: str, own: str) -> None:
    (fault,) = (d for d in run(f"{line}\nM30\n", dialect=dialect).diagnostics if d.severity == "error")
    assert (fault.code, fault.span.line, own in fault.message) == ("unknown-code", 1, True)


def test_a_thread_that_begins_within_its_height() -> None:
    """Shops' programs name a height that the bar has not: the first passes cut air, and the tool comes back to where the cycle began.

    The passes are 0.5 sqrt(n) deep (B-64304EN-1, 4.4.7); their chamfer of 1.5, the lead, is cut below where the cycle began alone.
    """
    text = "G0 X20.6 Z2.\nG76 P011000 Q50 R0\nG76 X20. Z-20. P1000 Q500 F1.5"
    found = moves(text)[1:]
    roots = [11.0 - depth for depth in (0.5, 0.5 * math.sqrt(2.0), 0.5 * math.sqrt(3.0), 1.0)]
    assert [a[0] for a, b in pairwise(found) if not a[2] and b[2]] == pytest.approx(roots, abs=1e-9)
    cuts = [(10.5, -20.0)]
    for x in roots[1:]:
        cuts += [(x, -18.5), (10.3, -18.5 - (10.3 - x)), (10.3, -20.0)]
    np.testing.assert_allclose([(x, z) for x, z, feed in found if feed], cuts, rtol=0.0, atol=1e-8)
    assert found[-1] == (10.3, 2, 0)
    told = [(d.code, d.span.line) for d in outcome(text)[2].diagnostics if d.severity == "warning" and d.span]
    assert told == [("thread-words", 5)]


def test_a_thread_without_last_passes(run: Any) -> None:
    """P00…: the control's count of last passes is 1 at least."""
    text = "G98 S500 M3\nG0 X62. Z2.\nG76 P{}0060 Q200 R0.1\nG76 X58. Z-20. P1000 Q500 F1.5\nM30\n"
    none, one = (run(text.format(count), dialect="fanuc-lathe") for count in ("00", "01"))
    assert np.array_equal(none.path.end, one.path.end)
    assert [(d.code, d.span.line) for d in none.diagnostics if d.severity == "warning" and d.span] == [
        ("thread-words", 3)
    ]


@pytest.mark.parametrize("bound", ["", "G50 S9000\n"])
def test_a_constant_surface_speed_keeps_to_the_fastest_of_the_machines_spindle(bound: str) -> None:
    """As if G50 said so: the control bounds the speed by its parameter as well (FANUC, B-64304EN, "Constant surface speed control")."""
    text = "G0 X100. Z5.\n{}G96 S200 M3\nG1 X0 F.2\nG97 S800"
    given, _, program = outcome(text.format(bound), fastest_spindle=1000.0)
    told, _, _ = outcome(text.format("G50 S1000\n"))
    speeds = [
        [e.values["speed_rpm"] for e in each.events if "speed_rpm" in e.values] for each in (given, told)
    ]
    assert speeds[0] == speeds[1]
    assert max(speeds[0]) == 1000.0
    assert np.array_equal(given.feed, told.feed, equal_nan=True)
    assert "speed-unbounded" not in [d.code for d in program.diagnostics]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("G28 U0 W0\nG50 S2000\nG96 S200 M3\nG0 X100. Z5.", False),
        ("G28 U0 W0\nG96 S200 M3\nG0 X100. Z5.", True),
        ("G0 X100. Z5.\nG96 S200 M3", False),
    ],
)
def test_a_spindle_that_starts_unbounded_beside_the_axis_warns(lines: str, said: bool) -> None:
    """A shop's program begins with G28 U0 W0 and G96 S200 M03: of the plan's 550 s, 530 s were the spindle's and unsaid."""
    _, faults, program = outcome(f"{lines}\nG1 Z-20. F.2")
    assert not faults
    assert ("speed-unbounded" in [d.code for d in program.diagnostics]) is said


@pytest.mark.parametrize(
    ("lines", "place"),
    [
        ("G96 S200 M3\nG0 X100. Z5.", "no move has said X yet"),
        ("G0 X0. Z5.\nG96 S200 M3", "beside X0"),
    ],
)
def test_an_unbounded_speed_tells_whether_x_is_known(lines: str, place: str) -> None:
    """Four shops' programs begin with G96 before any move: millions of rev/min were told "beside X0", where the tool is not."""
    _, _, program = outcome(f"{lines}\nG1 Z-20. F.2")
    assert [place in d.message for d in program.diagnostics if d.code == "speed-unbounded"] == [True]


def test_a_mills_g90_beside_a_traverse_is_one_fault() -> None:
    """A shop's cone: the traverse was lost with the block, and the profile of G71 behind it was blamed for where the tool stood."""
    lines = "G0 G90 X55. Z5.\nG71 U2. R.5\nG71 P1 Q2 U.3 W.1 F.25\nN1 G0 X32.\nG1 Z0\nX32. Z-2.\nX50. Z-57.\nZ-60.\nN2 X55."
    _, faults, _ = outcome(lines)
    assert [fault[0] for fault in faults] == ["modal-conflict"]


@pytest.mark.parametrize("line", ["G5 R90. X10. Z-1. F10.", "G5 R180. F10."])
def test_a_move_with_a_turn_of_the_spindle_is_refused(run: Any, line: str) -> None:
    """G5 of Haas's lathes is fine spindle control (96-8700): its X and Z were a traverse."""
    out = run(f"G0 X50. Z2.\n{line}\nM30", dialect="fanuc-lathe")
    assert [(code, at) for code, at, _ in out.errors] == [("other-control", 2)]
    assert run("G98 G0 X50.\nG5 P10000\nG5 P0\nG1 G8 P1 X40. F100.\nM30", dialect="fanuc-lathe").errors == []


@pytest.mark.parametrize(
    ("block", "idle"),
    [
        ("G71 U2. W1. R1. D2.", "W, D"),
        ("G72 W2. U1. R1.", "U"),
        ("G73 U5. W2. R3 D2", "D"),
        ("G74 R1. Q100", "Q"),
        ("G74 X40. Z-5. P1000 I1. Q2000 F0.1", "P"),
        ("G75 X40. Z-5. P2000 Q1000 K1. F0.1", "Q"),
        ("G76 P011060 Q100 R0.05 I1.", "I"),
        ("G76 X56. Z-20. P1200 Q300 I0.1 F1.5", "I"),
        ("G76 X56. Z-20. K1.2 D0.3 P2 Q30 F1.5", "Q"),
    ],
)
def test_words_that_a_form_of_a_cycle_has_no_use_for_are_told(run: Any, block: str, idle: str) -> None:
    """B-64304EN-1, 4.4, names the words of each form; those of the other one are of Haas or of older controls."""
    text = f"O1\nG21 T0101\nG97 S500 M3\nG0 X60. Z2.\n{block}\nM30"
    out = run(text, dialect="fanuc-lathe")
    assert out.errors == []
    told = [d.message for d in out.diagnostics if d.code == "unused-word"]
    assert told == [f"{idle} of {block[:3]} change{'' if ',' in idle else 's'} nothing here"]
    used = run(
        text.replace(block, " ".join(w for w in block.split() if w[0] not in idle)), dialect="fanuc-lathe"
    )
    assert out.path.end.tolist() == used.path.end.tolist()


def test_g50_names_the_place_of_the_spindle_too(run: Any) -> None:
    """``G50 C0`` before polar coordinates: C10. is then 10 degrees on from where C stood, and ``G50 H5.`` names it 5 more."""
    out = run(
        "G21\nG0 X50. Z2. C30.\nG50 C0\nG0 C10.\nG50 X60. C40.\nX60. C45.\nG50 H5.\nC45.\nM30",
        dialect="fanuc-lathe",
    )
    assert out.errors == []
    axes = list(out.path.axes)
    moved = out.path.end[out.path.kind != 3]
    assert np.degrees(moved[:, axes.index("C")]).tolist() == pytest.approx([30, 40, 45, 40])
    assert moved[:, axes.index("X")].tolist() == pytest.approx([25, 25, 25, 25])


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("G0 B-150.", True),
        ("G28 B0. (SUB)", True),
        ("G65 P9 B2.", False),
        ("(GO TO B-150.)", False),
        ("#2=B", False),
    ],
)
def test_a_word_b_of_a_lathe_is_read_as_degrees_with_a_warning(line: str, said: bool) -> None:
    """A shop's program for a lathe of two spindles sends the slide of the second one home by ``G00 G28 B0. (SUB)``."""
    from cncgen import read_text

    program = read_text(f"O1\nG21 G99\nT0101\nG0 X50. Z2.\n{line}\nM30\nO9\nM99", dialect="fanuc-lathe")
    list(program.chunks())
    told = [d for d in program.diagnostics if "second spindle" in d.message]
    assert bool(told) == said
    assert all(d.code == "other-control" for d in told)
