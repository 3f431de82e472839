"""Words that programs of shops have on FANUC's and Haas's controls, against what the manuals say of them."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check, read
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind

Run = Callable[..., Any]


def ends(run: Run, text: str, dialect: str = "fanuc") -> list[list[float]]:
    """Return where the motions of a text lead in X Y Z, after asserting that all went well."""
    out = run(text, dialect=dialect)
    assert out.errors == []
    rows = out.path.end[out.path.kind != 3, :3]
    return (np.round(rows, 9) + 0.0).tolist()


def codes(run: Run, text: str, dialect: str = "fanuc") -> list[tuple[str, str]]:
    """Return severity and code of what was said, but for assumed units."""
    found = run(text, dialect=dialect).diagnostics
    return [(d.severity.value, d.code) for d in found if d.code != "units-assumed"]


def test_an_arc_by_radius_to_where_it_starts_moves_nothing(run: Run) -> None:
    """It is an arc of 0 degrees: "the cutter does not move" (B-63324EN, 4.4)."""
    text = "G21 G0 X5 Y5\nG1 X10 F100\nG2 Y5 R5\nG1 X20\nM30"
    assert ends(run, text) == [[5, 5, 0], [10, 5, 0], [20, 5, 0]]
    assert codes(run, text) == [("warning", "arc-end")]
    assert ("error", "arc-end") in codes(run, text, "linuxcnc")


def test_the_radius_counts_beside_a_centre(run: Run, calls: Callable[..., list[str]]) -> None:
    """B-63324EN, 4.4: of I J K and R, R takes precedence; the centre of this R10 is (5, -5 sqrt 3)."""
    text = "G21 G0 X0 Y0\nG2 X10 Y0 I5 J0 R10 F100\nM30"
    assert codes(run, text) == [("warning", "arc-centre")]
    arc = next(line for line in calls(text, dialect="fanuc") if line.startswith("ARC_FEED"))
    assert arc.startswith(f"ARC_FEED(10.0000, 0.0000, 5.0000, {-5.0 * math.sqrt(3.0):.4f}, -1")


@pytest.mark.parametrize("word", ["M61", "M62", "M63", "M65", "M66", "M68"])
def test_outputs_of_haas_are_the_builders(run: Run, word: str) -> None:
    assert codes(run, f"G21 {word}\nG0 X1\nM30") == [("warning", "builders-code")]


def test_words_beside_m6_go_to_the_builders_macro(run: Run) -> None:
    """A shop's posts write `M6 Q0`: M6 may call a macro, with the words of its block as arguments (parameter 6080)."""
    assert ends(run, "G21 T1\nM6 Q0\nG0 X1\nM30") == [[1, 0, 0]]
    assert ("warning", "builders-code") in codes(run, "G21 T1\nM6 Q0\nG0 X1\nM30")
    assert ("warning", "builders-code") not in codes(run, "G21 T1\nG4 P10 M6\nG0 X1\nM30")
    assert ("error", "unused-word") in codes(run, "G21 T1\nM6 Q0\nG0 X1\nM30", "linuxcnc")


@pytest.mark.parametrize("word", ["P90", "R90"])
def test_m19_turns_the_spindle_to_an_angle(run: Run, word: str) -> None:
    out = run(f"G21 M19 {word}\nG0 X1\nM30", dialect="fanuc")
    assert out.errors == []
    assert [dict(event.values) for event in out.path.events if event.name == "spindle"] == [
        {"orient_deg": 90.0}
    ]


def test_p_beside_m3_names_a_spindle(run: Run) -> None:
    assert codes(run, "G21 S500 M3 P11\nG0 X1\nM5 P11\nM30") == [("warning", "spindle-number")]


def test_g60_in_a_canned_cycle_makes_its_hole(run: Run) -> None:
    """Plates with a thousand holes are drilled so. FANUC excepts only the drilling axis from coming from one side (B-63324EN, 4.2)."""
    out = run(
        "G90 G54 G60 X1 Y2\nG0 Z5\nG81 G99 Z-3 R1 L0 F100\nG54 G60 X4 Y6\nG60 Y7\nG80\nG60 X0\nM30",
        dialect="fanuc",
    )
    assert out.errors == []
    ends = out.path.end[out.path.kind != Kind.EVENT][:, :3].tolist()
    assert [end for end in ends if end[2] == -3.0] == [[4, 6, -3], [4, 7, -3]]
    assert ends[-1] == [0, 7, 1]


@pytest.mark.parametrize("code", ["G60", "G27"])
def test_g60_and_g27_traverse_once(calls: Callable[..., list[str]], code: str) -> None:
    """The code of motion in force comes back behind them (B-63324EN, 4.2 and 6)."""
    lines = calls(f"G21 G1 X1 F100\n{code} X5 Y2\nX7\nM30", dialect="fanuc")
    found = [
        line.split(", 0.0000, 0.0000, 0.0000, 0.0000)")[0] for line in lines if line.startswith("STRAIGHT")
    ]
    assert found == [
        "STRAIGHT_FEED(1.0000, 0.0000",
        "STRAIGHT_TRAVERSE(5.0000, 2.0000",
        "STRAIGHT_FEED(7.0000, 2.0000",
    ]


def test_m29_is_for_one_row_of_holes(calls: Callable[..., list[str]]) -> None:
    """A code of motion ends it as G80 does (B-64304EN-2, rigid tapping); the next taps feed."""
    text = "G21 G0 Z5\nM29 S500\nG84 X1 Z-1 R2 F500\nX2\nG0 X3\nM3\nG84 X4 Z-1 R2\nG80\nM30"
    lines = [line.split("(")[0] for line in calls(text, dialect="fanuc")]
    assert lines.count("RIGID_TAP") == 2
    assert lines.count("STRAIGHT_FEED") == 2


@pytest.mark.parametrize(("code", "turn"), [("G84.2", "CLOCKWISE"), ("G84.3", "COUNTERCLOCKWISE")])
def test_rigid_taps_without_m29(calls: Callable[..., list[str]], code: str, turn: str) -> None:
    """F is the lead under G95 (Mazak's EIA manual, G84.2 and G84.3)."""
    lines = calls(f"G21 G95 S500\nG0 Z5\n{code} X1 Z-1 R2 F1.5\nG80\nM30", dialect="fanuc")
    assert "RIGID_TAP(1.0000, 0.0000, -1.0000)" in lines
    assert "START_SPEED_FEED_SYNC(1.500000,0)" in lines
    assert f"START_SPINDLE_{turn}(0)" in lines


def offsets(run: Run, blocks: str) -> list[list[float]]:
    """Return X (radius) and Z of T0101 at X0 Z0 behind blocks that set its offset."""
    found = ends(run, f"G21 G99\n{blocks}\nG0 X0 Z0 T0101\nM30", "fanuc-lathe")
    return [[x, z] for x, _, z in found]


@pytest.mark.parametrize(
    ("blocks", "expected"),
    [
        ("G10 P1 X2 Z3", [1, 3]),
        ("G10 P10001 X20 Z30", [10, 30]),
        ("G10 P10001 X20 Z30\nG10 P1 X2 Z3", [11, 33]),
        ("G10 P10001 X20 Z30\nG10 P1 X2 Z3\nG10 P1 X0 Z0", [10, 30]),
        ("G10 P1 X2 Z3\nG10 P1 U2 W-1", [2, 2]),
        ("G10 P10001 X20 Z30\nG10 P1 X2\nG10 P10001 U2", [12, 30]),
        ("G10 L10 P1 X20 Z30 R0.4 Q3\nG10 L11 P1 X2", [11, 30]),
        ("G10 P0 Z-10", [0, -10]),
        ("G10 P0 Z-10\nG10 P0 U4 W-5", [2, -15]),
        ("G10 L2 P1 X10 Z5\nG10 L2 P1 U2 W-2\nG10 L2 P1 Z1\nG10 L2 P1 W3", [6, 4]),
    ],
)
def test_offsets_of_lathes_by_g10(run: Run, blocks: str, expected: list[float]) -> None:
    """P is wear, P10000 and more geometry, P0 the shift of the systems; X and U are diameters, U and W increments (B-64304EN-1, 7.2; of P0 too:
    blog.csdn.net/weixin_36480122/article/details/111943054). U and W of a system were the origins of axes that a lathe has not."""
    assert offsets(run, blocks)[-1] == expected


@pytest.mark.parametrize(
    ("blocks", "expected"),
    [
        ("#2001=2\n#2101=3", [1, 3]),
        ("#2701=20\n#2801=30\n#2001=2", [11, 30]),
        ("#15001=20\n#16001=30\n#10001=2\n#11001=#11001-1", [11, 29]),
        ("G10 P10001 X20 Z30\nG10 P1 X2 Z3\n#2001=0", [10, 33]),
        ("G10 P1 X2 Z3\n#2101=#2001+#2101", [1, 5]),
    ],
)
def test_offsets_of_lathes_by_variables(run: Run, blocks: str, expected: list[float]) -> None:
    """X and Z have variables of their own, wear #2001 #2101, geometry #2701 #2801 (from memory of B-64304EN-1's table): #2001 moved Z."""
    assert offsets(run, blocks)[-1] == expected


@pytest.mark.parametrize(
    ("blocks", "expected"),
    [
        ("#5221=20\n#5222=5", [10, 5]),
        ("G10 L2 P1 X20 Z5\n#5221=#5221+#5221", [20, 5]),
        ("G0 X30 Z5\n#5221=#5021\n#5222=#5022", [15, 5]),
        ("G98 G31 X30 Z5 F100\n#5221=#5061\n#5222=#5062", [15, 5]),
        ("G0 X30 Z5\n#5222=#5002+#5042-#5082", [0, 10]),
        ("G0 X30 Z5\n#5223=#5043", [0, 5]),
    ],
)
def test_origins_and_touched_places_of_lathes_are_diameters_in_variables(
    run: Run, blocks: str, expected: list[float]
) -> None:
    """The variables of an origin are those that G10 L2 sets, in the diameters of #5021 (B-64304EN-1, 7.2): #5221=20 moved it by 20 in radius,
    and what G31 left in #5061 was a radius, while #5041 beside it is a diameter."""
    assert offsets(run, blocks)[-1] == expected


def test_the_second_axis_of_lathes_is_z(run: Run) -> None:
    """Variables of places are numbered by axis, and lathes have X and Z (from memory of B-64304EN-1, 16.2): #5042 was Y, which is 0."""
    text = "G21 G99\nG0 X30 Z5\n#1={}\nG0 Z[#1+1.]\nM30"
    assert codes(run, text.format("#5042"), "fanuc-lathe") == [("note", "other-control")]
    assert codes(run, text.format("#5043"), "fanuc-lathe") == [("warning", "other-control")]
    for variable in ("#5042", "#5043"):
        assert ends(run, text.format(variable), "fanuc-lathe")[-1] == [15, 0, 6]
    assert ends(run, text.format("#5042"))[-1] == [30, 0, 1]


@pytest.mark.parametrize(
    ("dialect", "blocks", "code"),
    [
        ("fanuc-lathe", "G98\n#1=#4005", 98),
        ("fanuc-lathe", "G99\n#1=#4005", 99),
        ("fanuc-lathe-b", "G94\n#1=#4005", 94),
        ("fanuc-lathe-b", "G99\n#1=#4011", 99),
        ("fanuc-lathe", "G96 S100 M3\n#1=#4002", 96),
        ("fanuc-lathe", "#1=#4002", 97),
        ("fanuc-lathe", "G17\n#1=#4016", 17),
        ("fanuc-lathe", "#1=#4006", 21),
        ("fanuc", "G95\n#1=#4005", 95),
    ],
)
def test_modal_codes_of_lathes(run: Run, dialect: str, blocks: str, code: int) -> None:
    """Groups of lathes' codes are others than mills' (from memory of B-64304EN-1's list): 2 has G96 and G97, 5 G98 and G99, or G94 and G95 in
    systems B and C, 16 the planes. `#4005` was 94 or 95, so that a macro which restores it by `G#1` called the passes G94."""
    assert ends(run, f"G21\nG0 X1000. Z5.\n{blocks}\nG0 Z#1\nM30", dialect)[-1][2] == code


TURNED = "G21 G99 S500 M3\n{}\nT0101\nG0 X30 Z5\nG42 G1 X20 Z0 F0.2\nZ-20\nG40 G0 X60\nM30"


@pytest.mark.parametrize(
    ("blocks", "radius"),
    [
        ("G10 L10 P1 R0.4 Q3", 10),
        ("G10 L10 P1 R0.4 Q4", 10),
        ("G10 P1 R0.4 Q2", 10.8),
        ("G10 P1 R0.4 Q7", 10.4),
        ("G10 P1 R0.4 Q8", 10),
        ("#2901=0.3\n#2201=0.1\n#2301=3", 10),
        ("G10 P1 R0.4 Q3\n#2301=#2301-1", 10.8),
    ],
)
def test_directions_of_tips(run: Run, blocks: str, radius: float) -> None:
    """Haas's Lathe Operator's Manual, "Imaginary Tool Tip and Direction": 3 is X- Z-, 4 X- Z+, 8 X-: they turn outside without a shift
    along X; 2 is X+ Z-, which holds the tip a diameter of the nose farther out, and 7, Z-, its radius. LinuxCNC's 3 was taken, X+ Z-."""
    assert ends(run, TURNED.format(blocks), "fanuc-lathe")[-2][0] == radius


@pytest.mark.parametrize("block", ["G10 P1 Q10", "#2301=10", "#2301=1.5"])
def test_a_direction_that_no_tip_has(run: Run, block: str) -> None:
    out = run(f"G21 G99\n{block}\nM30", dialect="fanuc-lathe")
    assert [code for code, *_ in out.errors] == ["tool-orientation"]


@pytest.mark.parametrize(
    ("cycle", "expected"),
    [
        ("G90 X40 Z-20 I-2 F.2", [[18, 5], [20, -20], [30, -20], [30, 5]]),
        ("G94 X40 Z-5 K-3 F.2", [[30, -8], [20, -5], [20, 5], [30, 5]]),
        ("G92 X40 Z-20 I-2 F1.5", [[18, 5], [20, -20], [30, -20], [30, 5]]),
    ],
)
def test_tapers_of_older_lathes_by_i_and_k(run: Run, cycle: str, expected: list[list[float]]) -> None:
    """I and K are R of the 0i (B-64304EN-1, 4.1)."""
    found = ends(run, f"G21 G99 S500 M3\nG0 X60 Z5\n{cycle}\nM30", "fanuc-lathe")
    assert [[x, z] for x, _, z in found][1:] == expected


def test_a_starting_angle_of_a_thread_is_read() -> None:
    text = "O1\nG21 G97 S500 M3\nG0 X60. Z5.\nG32 Z-20. F1.5 Q180000\nM30\n"
    program = read(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect="fanuc-lathe"))
    assert sum(path.end.shape[0] > 0 for path in program.chunks()) == 1
    assert [d.code for d in program.diagnostics if d.severity == "error"] == []


def _places(run: Run, body: str) -> list[list[float]]:
    """Return where holes of a program reach Z-5."""
    found = ends(run, f"%\nO1\nG21 G17 G90 G54\nG0 X10. Y10. Z20.\n{body}\nG80\nM30\n%")
    return [[round(v, 4) for v in place[:2]] for place in found if place[2] == -5.0]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("G81 Z-5. R2. F100. L0\nG70 I5. J0 L4", [[15, 10], [10, 15], [5, 10], [10, 5]]),
        ("G81 Z-5. R2. F100. G70 I-5. J90. L4", [[10, 15], [15, 10], [10, 5], [5, 10]]),
        ("G81 Z-5. R2. F100. L0\nG71 X0 Y0 I10. J90. K-90. L2", [[0, 10], [10, 0]]),
        ("G83 Z-5. R2. Q9. F100. G71 I5. J0 K180. L2\nX50.", [[15, 10], [5, 10], [50, 10]]),
        ("G91\nG81 Z-7. R-18. F100. L0\nG70 X10. Y0 I4. J0 L2", [[24, 10], [16, 10]]),
    ],
)
def test_holes_on_circles_and_arcs_of_haas(run: Run, body: str, expected: list[list[float]]) -> None:
    """G70 shares a circle evenly, G71 goes on by K; clockwise with I or K below 0; no hole is made in the middle."""
    assert _places(run, body) == expected


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("G72 I5. J90. L3", [[10, 10], [10, 15], [10, 20]]),
        ("G72 X0 Y0 I-5. L2", [[0, 0], [-5, 0]]),
        ("G34 X20. Y10. I10. J90. K4", [[20, 20], [10, 10], [20, 0], [30, 10]]),
        ("G34.1 X20. Y10. I10. J90. K-4", [[20, 20], [30, 10], [20, 0], [10, 10]]),
        ("G35 X20. Y10. I5. J180. K3", [[20, 10], [15, 10], [10, 10]]),
        ("G36 X20. Y10. I10. J0 P90. K3", [[30, 10], [20, 20], [10, 10]]),
        ("G37.1 X20. Y10. I5. P3 J-4. K2", [[20, 10], [25, 10], [30, 10], [30, 6], [25, 6], [20, 6]]),
        ("G91 G35 X5. Y5. I5. J0 K2\nG90 X50. Y1.", [[15, 15], [20, 15], [50, 1]]),
    ],
)
def test_holes_on_lines_arcs_and_grids(run: Run, body: str, expected: list[list[float]]) -> None:
    """G72 of Haas; G34 to G37.1 of Mitsubishi and Mazak: X Y begin the row, or are the middle of G34 and G36."""
    assert _places(run, f"G81 Z-5. R2. F100. L0\n{body}") == expected


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("G81 Z-5. R2. F100. L0\nG34 X20. Y10. I10. J90.", "cycle-words"),
        ("G81 Z-5. R2. F100. L0\nG37.1 X20. Y10. I5. P3 K2", "cycle-words"),
        ("G81 Z-5. R2. F100. L0\nG36 X20. Y10. I5. P3. K2.5", "cycle-words"),
        ("G35 X20. Y10. I5. K2", "cycle-missing"),
        ("G72 P10 Q20 I1. L2", "cycle-missing"),
        ("G70 I5. J0 L4", "cycle-missing"),
        ("G81 Z-5. R2. F100. L0\nG70 I5. J0", "cycle-words"),
        ("G81 Z-5. R2. F100. L0\nG70 I5. J0 K10. L4", "cycle-words"),
        ("G81 Z-5. R2. F100. L0\nG71 I5. J0 L4", "cycle-words"),
    ],
)
def test_holes_on_circles_that_cannot_be(run: Run, body: str, code: str) -> None:
    assert ("error", code) in codes(run, f"%\nO1\nG21 G17 G90 G54\nG0 X1 Z9\n{body}\nM30\n%")


def test_p_beside_a_spindle_code_may_be_of_another_code(run: Run) -> None:
    """P of G54.1 names the coordinate system."""
    head = "%\nO1\nG21 G90\n"
    assert ("warning", "spindle-number") not in codes(run, f"{head}G54.1 P3 G0 X1. S2000 M3\nM30\n%")
    assert ("warning", "spindle-number") in codes(run, f"{head}G0 X1. S2000 M3 P1\nM30\n%")


def test_a_speed_beside_g50_and_the_start_of_the_spindle(run: Run) -> None:
    """``G50 X100 Z50 M3 S300`` of GSK's manuals; the thread after it turns with 300 rev/min."""
    body = "G0 X40 Z5\nG92 X38 Z-10 F2\nM30\n"
    assert codes(run, f"O1\nG50 X100 Z50 M3 S300\n{body}", "fanuc-lathe") == [
        ("warning", "other-control"),
        ("note", "thread-chamfer"),
    ]
    assert ("error", "spindle-stopped") in codes(run, f"O1\nG50 S300 M3\n{body}", "fanuc-lathe")


@pytest.mark.parametrize(
    ("body", "found"),
    [
        # Two signs are alarm 6 of FANUC's controls (B-64484EN, alarm list); within brackets they are sums.
        ("G0 X--5.", [("error", "syntax")]),
        ("#1=3*-2\nG0 X-#1 Y+#1 Z[2--5]", []),
        # M8 by its pitch of 1.25 mm, under G94 at 1000 rev/min 0.00125 mm; 1250 mm/min are meant.
        ("S1000 M3\nG84 Z-5. R2. F1.25", [("warning", "tap-pitch")]),
        ("S1000 M3\nG95 G84 Z-5. R2. F1.25", []),
        ("S1000 M3\nG84 Z-5. R2. F1250.", []),
        ("S10 M3\nG84 Z-5. R2. F1250.", [("warning", "tap-pitch")]),
        ("G65 H01 P#100 Q5", [("error", "not-read")]),
        ("#100=5\nG65 H01 P#100 Q5", [("error", "not-read")]),
        ("G65 H81 P100 Q#100 R1", [("error", "not-read")]),
        ("G65 P100 H81", [("error", "sub-missing")]),
        ("G10.9 X0\nG291\nG05.3 P35", []),
        ("G10.9 X1.", [("error", "not-read")]),
    ],
)
def test_words_that_controls_refuse_or_take(run: Run, body: str, found: list[tuple[str, str]]) -> None:
    assert codes(run, f"%\nO1\nG21 G17 G90 G54\nG0 X1. Y1. Z9.\n{body}\nM30\n%") == found


def test_a_slash_within_a_block_ends_it(run: Run) -> None:
    """N words and parentheses may stand before the slash of a block that is left out, and a quotient has brackets."""
    text = "O1\nG21 G54\nG0 X0 Y0 (A/B)\nN4 /2 G1 X99\nG1 X10 F100 /2 Y5\n#1=6/2\nG1 X[#1/2] Y1\nM30"
    assert ends(run, text) == [[10, 0, 0], [1.5, 1, 0]]
    assert codes(run, text) == [("warning", "other-control"), ("note", "blocks-left-out")]
    assert ("error", "syntax") in codes(run, text, "linuxcnc")


@pytest.mark.parametrize("body", ["G1 X1000 F2\nX0\nX1000", "G1 X1 F100\nG4 P40000000\nX2"])
def test_a_check_tells_of_ten_hours(body: str) -> None:
    """As reading does: feeds of 2 mm a minute, or a dwell of 11 hours."""
    found = Diagnostics()
    check(io.BytesIO(f"O1\nG21 G90\n{body}\nM30".encode()), "long.nc", ReadOptions(dialect="fanuc"), found)
    assert [d.code for d in found if d.code == "time-doubtful"] == ["time-doubtful"]


def test_the_mirror_of_haas(run: Run) -> None:
    """G101 mirrors about the zero of G52 too; G100 ends it for its axes, or all. Lengths may be sums behind a minus."""
    text = "O1\nG21 G54\nG52 X10. Y5.\nG101 Y0.\nG0 X1. Y2.\nG101 X0\nG0 X - [ 1. + 1. ] Y2.\nG100 Y0.\nG0 X1. Y2.\nG100\nG0 X1. Y3.\nM30"
    assert [p[:2] for p in ends(run, text)] == [[11, 3], [12, 3], [9, 7], [11, 8]]
    assert ("error", "not-read") in codes(run, "O1\nG21 G54\nG101 X5.\nM30")


@pytest.mark.parametrize("dialect", ["fanuc", "fanuc-lathe"])
def test_an_arc_without_centre_and_radius_is_a_straight_line(run: Run, dialect: str) -> None:
    """B-64310EN, parameter CIR (3403#5) = 0: "the tool moves to an end point by linear interpolation". G2 stays in force."""
    text = "G21 G18 G98 G0 X0 Z0\nG2 X20. Z-10. R20. F100\nZ-30.\nX40. Z-40. R20.\nM30"
    x = 2.0 if dialect == "fanuc" else 1.0
    assert ends(run, text, dialect) == [[10 * x, 0, -10], [10 * x, 0, -30], [20 * x, 0, -40]]
    assert codes(run, text, dialect)[-1] == ("warning", "arc-centre")
    path = run(text, dialect=dialect).path
    arcs = [int(line) for kind, line in zip(path.kind, path.line, strict=True) if kind == Kind.ARC]
    assert arcs == [2, 4]
    assert ("error", "arc-centre") in codes(run, text.replace("G98 ", ""), "linuxcnc")


def test_a_circular_pocket_takes_the_d_in_force(run: Run) -> None:
    """Haas: D is optional for G12 and G13; here it stands beside the tool change."""
    text = "G21 T2 D0 M6\nG0 X0 Y0 Z5.\nG13 {}I5. F100 Z-1.\nM30"
    assert ends(run, text.format("")) == ends(run, text.format("D0 "))
    assert ("error", "comp-diameter") in codes(run, text.format("").replace("D0 ", ""))


def test_an_m_code_of_the_builder_calls_a_macro_of_a_probe(run: Run) -> None:
    """M165P9810Z-.5F50. of a shop's machines was a traverse to Z-.5, without a word, and M165P9814D.453 an error."""
    text = "G20 G90 G0 Z1.\n{0}P9832(START)\n{0}P9810Z-.5F50.\n{0} P9814 D.453 S2.\n{0}P9810Z1.F100.\nM30"
    found, expected = (run(text.format(call), dialect="fanuc") for call in ("M165", "G65"))
    assert found.errors == expected.errors == []
    assert found.path.end.tolist() == expected.path.end.tolist()
    np.testing.assert_array_equal(found.path.feed, expected.path.feed)
    assert [(d.code, d.span.line) for d in found.diagnostics if d.code == "builders-code"] == [
        ("builders-code", 2)
    ]


def test_a_main_program_behind_a_subprogram_that_returns_to_a_line(run: Run) -> None:
    """M99 P30 goes on at N30 of the program that called O2."""
    text = "%\nO0002\nX2.\nM99 P30\nO1\nG21 G0 X1.\nM98 P2\nX9.\nN30 Y7.\nM30\n%"
    assert ends(run, text) == [[1, 0, 0], [2, 0, 0], [2, 7, 0]]
    assert codes(run, text) == [("warning", "main-behind")]
    # Nothing calls it: it is a main program that repeats itself.
    alone = "%\nO2\nN30 G21 G0 X2.\nM99 P30\nO1\nG21 G0 X1.\nM30\n%"
    assert ("warning", "main-behind") not in codes(run, alone)


def test_cycles_of_lathes_end_at_r_in_g99_of_system_b(run: Run) -> None:
    text = "G94 G0 X0 Z5.\n{} G83 Z-6. R-3. F100\nG80 G0 X10.\nM30"
    for dialect in ("fanuc-lathe-b", "fanuc-lathe-c"):
        assert [end[2] for end in ends(run, text.format("G99"), dialect)][-2:] == [2, 2]
        assert [end[2] for end in ends(run, text.format("G98"), dialect)][-2:] == [5, 5]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        # AND is of the rank of *, OR and XOR of that of +, from the left; comparisons come last (B-64484EN, 16.4, "Priority of operations").
        ("#1AND4EQ4", 1),
        ("#1AND1EQ1", 0),
        ("4EQ#1AND4", 1),
        ("2*3AND3", 2),
        ("4OR1*2", 6),
        ("1OR4-1", 4),
        ("8-1XOR2", 5),
        ("1+2AND2", 3),
    ],
)
def test_and_binds_before_comparisons(run: Run, expression: str, value: int) -> None:
    """With #1 = 6. LinuxCNC's logic binds loosest: 6 AND [4 EQ 4] was 0 here, which took the other branch without a word."""
    assert ends(run, f"#1=6\n#2=[{expression}]\nG0X#2Y9\nM30") == [[value, 9, 0]]


def test_comparisons_in_a_row_stand_in_brackets(run: Run) -> None:
    """#1 EQ 1 AND #2 EQ 2 is #1 EQ [1 AND #2] EQ 2, which nobody means."""
    text = "#1=1\n#2=2\nIF[#1EQ1AND#2EQ2]GOTO5\nG0X1\nN5\nM30"
    (error,) = [d for d in run(text, dialect="fanuc").diagnostics if d.severity == "error"]
    assert (error.code, error.span.line, error.hint) == (
        "syntax",
        3,
        "AND and OR bind before comparisons: [[#1 EQ 1] AND [#2 EQ 2]]",
    )
    assert ends(run, text.replace("#1EQ1AND#2EQ2", "[#1EQ1]AND[#2EQ2]")) == []


def test_round_in_a_word_rounds_to_the_least_increment(run: Run) -> None:
    """The manual's printed figures: 1.235 + 2.346 = 3.581 (B-63324EN, 15.3, "ROUND function"); it was 1 + 2 here. Elsewhere 1.2345 is 1."""
    text = "G21\n#1=1.2345\n#2=2.3456\nG91G0X[ROUND[#1]+ROUND[#2]]\n#3=ROUND[#1]\nG90Y#3\nIF[ROUND[#2]EQ2]THEN Z-[RND[#2]]\nM30"
    assert ends(run, text) == [[3.581, 0, 0], [3.581, 1, 0], [3.581, 1, -2.346]]
    # A ten-thousandth of an inch; arguments of a macro and speeds are whole.
    assert ends(run, "G20\nG0X[ROUND[1.23456]]\nM30") == [[31.35884, 0, 0]]
    assert ends(run, "G21\nG65P2A[ROUND[1.2345]]\nM30\nO2\nG0X#1\nM99") == [[1, 0, 0]]
    assert ends(run, "G21\nG0X[ROUND[1.2345]]\nM30", "linuxcnc") == [[1, 0, 0]]


#: Ends and centres within 0.1 um of each other, as CAM systems write them, a line of 0.2 um with the centre on its start, and one arc.
POINTS = "G21 G90 G17 G1 X10 Y10 F500\nG2 X10.0001 Y10 I0.0001 J0\nG3 X10.0003 Y10 I0.0001 J0\nX10.0005 I0 J0\nG2 X12.0005 I1\nM30"


@pytest.mark.parametrize("dialect", ["auto", "fanuc"])
def test_arcs_that_a_control_does_not_resolve_are_lines(run: Run, dialect: str) -> None:
    """grbl makes no segments of them (mc_arc), and on FANUC's controls I and J are 0 in the least increment of 0.001 mm."""
    out = run(POINTS, dialect=dialect)
    assert [(d.severity.value, d.code) for d in out.diagnostics] == [("warning", "arc-zero-radius")]
    rows = out.path.kind != Kind.EVENT
    assert out.path.end[rows, 0].tolist() == pytest.approx(
        [10, 10.0001, 10.0003, 10.0005, 12.0005], abs=1e-12
    )
    assert [Kind(kind) for kind in out.path.kind[rows]] == [Kind.LINE] * 4 + [Kind.ARC]


def test_linuxcnc_refuses_arcs_that_small(run: Run) -> None:
    """Its interpreter says "Zero-radius arc" of each of the three."""
    out = run(POINTS, dialect="linuxcnc")
    assert [(code, line) for code, line, *_ in out.errors] == [("arc-zero-radius", n) for n in (2, 3, 4)]
    # With its end written, an arc of no radius goes there; a circle of no radius is none on any control.
    assert ends(run, "G21 G1 X1 F100\nG2 X1 Y0 Z-2 I0 J0\nM30") == [[1, 0, 0], [1, 0, -2]]
    assert run("G21 G1 X1 F100\nG2 I0 J0\nM30", dialect="fanuc").errors[0][:2] == ("arc-zero-radius", 2)


@pytest.mark.parametrize(
    ("code", "dwell"),
    [("G82 X1. Y1. Z-5. R2. P100 F100.", 0.1), ("G4 P100", 0.1), ("G0 X1. Y1.", None)],
)
def test_p_beside_g54_belongs_to_the_code_that_needs_it(run: Run, code: str, dwell: float | None) -> None:
    """G54 P is G54.1 P; a dwell of 100 ms beside G54 was the additional system 100 as well, without a word."""
    text = f"G21 G10 L20 P100 X777.\nG0 Z5.\nG54 {code}{'' if dwell else ' P100'}\nG80\nX1. Y1.\nM30"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    assert out.path.end[-1, 0] == (1.0 if dwell else 778.0)
    assert ("system-number" in [d.code for d in out.diagnostics]) == bool(dwell)


def test_g54_beside_a_pocket_of_haas(run: Run, tmp_path: Path) -> None:
    """P of G150 is the program of its outline: a square of 40 mm, and a tool of 4 mm clears up to 18 mm from its centre."""
    outline = "O1001\nG1 X20.\nY20.\nX-20.\nY-20.\nX20.\nY0\nM99"
    text = f"O1\nG21 G0 X0 Y0 Z9.\nG150 G54 G41 X0 Y0 Z-5. P1001 R2. Q5. J2. D1 F100.\nG40 G0 Z9.\nM30\n{outline}\n%"
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D4\n")
    out = run(text, dialect="fanuc", tool_table=table)
    assert out.errors == []
    assert abs(out.path.end[:, :2]).max() == pytest.approx(18.0)


def test_words_of_a_cycle_in_a_block_without_a_hole_are_not_kept(run: Run) -> None:
    """They are stored from blocks with the place of a hole alone (B-63324EN, 13.1): the second hole dwells 0.1 s as the first one."""
    out = run("G21 G0 Z5.\nG82 X1. Y1. Z-5. R2. P100 F100.\nP900\nX5.\nG80\nM30", dialect="fanuc")
    assert out.errors == []
    assert [(d.severity.value, d.code) for d in out.diagnostics] == [("warning", "cycle-words")]
    waits = [e.dwell_s for e in out.path.events if e.name == "dwell"]
    assert waits == [0.1, 0.1]
    assert ("unused-word", 2) in [e[:2] for e in run("G21 G0 Z5.\nP900\nM30", dialect="fanuc").errors]


def test_m99_behind_a_condition_jumps_where_it_holds(run: Run) -> None:
    """``N50 [#100 LT 10] M99 P10`` branches to N10 only where #100 is less than 10, "otherwise processing continues" (Haas 96-8000, "M99")."""
    text = "G21\n#100=0\nN10 #100=#100+1\nG0 X#100\n[#100 LT 3] M99 P10\nN50 [#100 LT 3] M99 P10\nY1.\nM30"
    assert ends(run, text) == [[1, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0]]
    assert run("G21\n[1 LT 3] X5\nM30", dialect="fanuc").errors[0][:2] == ("syntax", 2)


def test_a_jump_after_settings_of_its_block(run: Run) -> None:
    """Macros of shops write ``N1 #29=1 GOTO10``: the block runs from left to right."""
    text = "O1\nG21 G54\nN1 #29=1 #2=4 GOTO[#29+9] (on)\nG0 X9\nN10 G0 X#29 Y#2\nM30"
    assert ends(run, text) == [[1, 4, 0]]
    assert codes(run, text) == []
    assert codes(run, "O1\nG21\nG0 X5 GOTO10\nN10 M30") == [("error", "unsupported-flow")]


@pytest.mark.parametrize(("code", "said"), [("M88", False), ("M31", False), ("M36", True)])
def test_codes_of_haas_that_move_nothing_are_not_the_builders(run: Any, code: str, said: bool) -> None:
    """M88 is coolant through the spindle, M31 the conveyor; M36 waits for the operator (Haas 96-8000, "M-Codes")."""
    for sign, told in (("G154 P3", said), ("G54", True)):
        assert (("warning", "builders-code") in codes(run, f"G21 G90 {sign}\n{code}\nG0 X1\nM30")) is told
