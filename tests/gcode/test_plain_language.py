"""Heidenhain's plain language beside lines and splines: arcs and polar coordinates by hand, tools, cycles, Q parameters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

HEAD = "0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n"
TAIL = "\n99 END PGM PART MM\n"


def plain(run: Any, blocks: str) -> Any:
    """Run blocks; nothing may be wrong with them."""
    out = run(HEAD + blocks + TAIL)
    assert out.errors == []
    return out


def ends(out: Any) -> list[list[float]]:
    """Return X Y Z of the ends of the motions (rows of kind 3 are events)."""
    return np.round(out.path.end[out.path.kind != 3][:, :3], 6).tolist()


def test_an_arc_about_the_pole(run: Any) -> None:
    out = plain(run, "L X+50 Y+0 F500\nCC X+50 Y+25\nC X+50 Y+50 DR+\nC X+50 Y+0 DR-")
    assert ends(out) == [[50, 0, 0], [50, 50, 0], [50, 0, 0]]
    np.testing.assert_allclose(out.path.arcs.centre[:, :2], [[50, 25], [50, 25]])
    np.testing.assert_allclose(out.path.arcs.sweep * out.path.arcs.normal[:, 2], [math.pi, -math.pi])


def test_arcs_of_a_radius(run: Any) -> None:
    """R above 0 is less than half a turn, below 0 more."""
    out = plain(run, "L X+10 Y+0 F500\nCR X+0 Y+10 R+10 DR+\nCR X+10 Y+0 R-10 DR+")
    np.testing.assert_allclose(out.path.arcs.centre[:, :2], [[0, 0], [0, 0]], atol=1e-9)
    np.testing.assert_allclose(np.abs(out.path.arcs.sweep), [math.pi / 2, 3 * math.pi / 2])


def test_polar_arcs_and_helices(run: Any) -> None:
    out = plain(
        run, "L X+10 Y+0 F500\nCC X+0 Y+0\nCP PA+90 DR+\nCP IPA-90 DR-\nCP IPA+720 IZ-4 DR+\nCP PA+0 DR+"
    )
    assert ends(out) == [[10, 0, 0], [0, 10, 0], [10, 0, 0], [10, 0, -4], [10, 0, -4]]
    sweeps = out.path.arcs.sweep * out.path.arcs.normal[:, 2] / math.pi
    np.testing.assert_allclose(sweeps, [0.5, -0.5, 4.0, 2.0])


def test_the_plane_is_that_of_the_poles_axes(run: Any) -> None:
    """In ZX the angle counts from Z, and DR+ goes from Z to X; so a CAM system writes its approach."""
    out = plain(run, "L X+8.848 Z-14.606 F500\nCC X+10.242 Z-14.606\nCP IPA-90 DR-\nL X+20")
    assert ends(out)[1:] == [[10.242, 0, -16], [20, 0, -16]]


@pytest.mark.parametrize("block", ["STOP", "STOP M0", "L X+1 FMAX M0", "STOP M9"])
def test_stops_may_name_their_m_function(run: Any, block: str) -> None:
    assert [event.name for event in plain(run, block).path.events].count("stop") == 1


def test_lines_in_polar_coordinates(run: Any) -> None:
    out = plain(run, "CC X+10 Y+10\nLP PR+5 PA+0 FMAX\nLP IPA+90 F100\nLP PR+10\nCC\nLP PR+2 PA+180")
    assert ends(out) == [[15, 10, 0], [10, 15, 0], [10, 20, 0], [8, 20, 0]]
    assert np.isnan(out.path.feed[0])


def test_numbers_with_commas_and_q_parameters(run: Any) -> None:
    out = plain(run, "FN 0: Q50 = +551 ; cutting\nQ3=1,5\nL X+Q3 Y-Q3 FQ50\nL IX+Q3 Z+0,25")
    assert ends(out) == [[1.5, -1.5, 0], [3, -1.5, 0.25]]
    assert out.path.feed[0] == pytest.approx(551 / 60)


def test_a_tool_call_brings_its_length_and_speed(run: Any, tmp_path: Any) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T3 P3 Z20 D10\n")
    out = run(
        HEAD + "TOOL CALL 3 Z S4850 DL+0 DR+0,00\nM13\nL Z+0 FMAX M91\nL Z+0 FMAX" + TAIL, tool_table=table
    )
    assert out.errors == []
    # At the end of the tool, machine zero is at -20; the program's zero lifts the machine by the length.
    assert ends(out) == [[0, 0, 20]]
    names = [(event.name, event.values) for event in out.path.events]
    assert ("tool", {"tool": 3, "diameter_mm": 10.0}) in names
    assert {"spindle", "coolant"} <= {name for name, _ in names}


def test_tolerance_and_datum_shift(run: Any) -> None:
    blocks = "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05\nL X+1 F100\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nL X+1"
    out = plain(run, blocks)
    assert ends(out) == [[1, 0, 0], [11, 0, 0]]
    assert out.path.tolerance[0] == 0.05


def test_drilling_goes_in_by_infeeds(run: Any) -> None:
    """Cycle 200: back to the set-up clearance after each infeed, and down again to that clearance above the last depth."""
    cycle = (
        "CYCL DEF 200 DRILLING ~\n Q200=+2 ;SET-UP CLEARANCE ~\n Q201=-9 ;DEPTH ~\n Q206=+60 ;FEED ~\n"
        " Q202=+4 ;INFEED ~\n Q210=+0 ~\n Q203=+1 ;SURFACE ~\n Q204=+20 ;2ND CLEARANCE ~\n Q211=+0.5 ;DWELL\n"
    )
    out = plain(run, "L Z+50 FMAX\n" + cycle + "L X+5 Y+5 FMAX M99\nL X+7 FMAX")
    heights = [3, -3, 3, -1, -7, 3, -5, -8, 21]
    assert ends(out) == [[0, 0, 50], [5, 5, 50], *([5, 5, z] for z in heights), [7, 5, 21]]
    assert [event.values for event in out.path.events if event.name == "dwell"] == [{"seconds": 0.5}]
    reamed = plain(run, "L Z+50 FMAX\n" + cycle.replace("200 D", "201 D") + "Q208=120\nCYCL CALL")
    assert ends(reamed)[1:] == [[0, 0, z] for z in (3, -8, 3, 21)]
    np.testing.assert_allclose(reamed.path.feed[reamed.path.kind != 3][2:4], [1.0, 2.0])


def test_retracting_along_the_tool(run: Any) -> None:
    out = plain(run, "L Z+5 FMAX\nL M140 MB 50\nL M140 MB MAX\nL M140 MB MAX")
    assert ends(out) == [[0, 0, 5], [0, 0, 55]]
    assert [d.code for d in out.diagnostics] == ["dialect", "retract-unknown"]


def test_the_feed_of_a_retraction_ends_with_it(run: Any) -> None:
    """``L X+0 Y+38.5 F125 M140 MB 50 F750`` (iTNC 530, Miscellaneous functions, M140): back at 750, and on at 125."""
    out = plain(run, "Q5 = 7\nL X+20 F120 M140 MB 50 F720\nL X+30\nM140 MB Q5\nL X+40 M140 MB 3 FMAX\nL X+50")
    assert ends(out)[:3] == [[20, 0, 0], [20, 0, 50], [30, 0, 50]]
    assert ends(out)[3:] == [[30, 0, 57], [40, 0, 57], [40, 0, 60], [50, 0, 60]]
    feeds, moves = out.path.feed, out.path.kind != 3
    rapid = np.isnan(feeds[moves])
    np.testing.assert_allclose(feeds[moves][~rapid], [2, 12, 2, 2, 2])
    assert rapid.tolist() == [False, False, False, True, False, True, False]


def test_the_feed_of_a_corner_is_its_own(run: Any) -> None:
    """F of RND and CHF holds in that block alone; the one before it counts behind (iTNC 530, Path contours, "Corner rounding")."""
    lines = "L X+20 F600\nRND R2 F60\nL Y+20\nCHF 1 F120\nL X+40\nRND R1\nL Y+40\nRND R1 F AUTO\nL X+60"
    out = plain(run, f"TOOL CALL 1 Z S1000 F180\n{lines}")
    np.testing.assert_allclose(out.path.feed[out.path.kind != 3], [10, 1, 10, 2, 10, 10, 10, 3, 10])
    iso = run(
        "%A G71 *\nN1 G01 G90 X+20 F600 *\nN2 G25 R2 F60 *\nN3 Y+20 *\nN4 G24 R1 F120 *\nN5 X+40 *\nN9 M30 *\n"
    )
    assert iso.errors == []
    np.testing.assert_allclose(iso.path.feed[iso.path.kind != 3], [10, 1, 10, 2, 10])


@pytest.mark.parametrize(
    ("block", "code", "column"),
    [
        ("C X5 Y5 DR+", "pole-missing", 1),
        ("CC X0 Y0\nC X5 Y5 F100", "arc-sense", 1),
        ("CC X0 Y0\nL X5\nCP IPA+90 DR- F100", "arc-sense", 4),
        ("CC X0 Y0 Z0", "pole-plane", 1),
        ("L X5 F100\nCR X9 DR+", "arc-centre", 1),
        ("L X5 F100\nCR X9 R1 DR+", "arc-radius", 1),
        ("CC X5 Y0\nC X5 Y6 DR+ F100", "arc-radius", 1),
        ("L X1 FMAX M99", "cycle-missing", 11),
        ("CYCL DEF 27.0 CYLINDER SURFACE", "unsupported-block", 1),
        ("CALL LBL 1", "label-missing", 6),
        ("L X5 M130", "unsupported-block", 6),
        ("TOOL CALL 5 X S100", "unsupported-block", 13),
        ("CC X0 Y0\nC X5 FMAX DR+", "syntax", 6),
    ],
)
def test_what_is_wrong_or_not_read(run: Any, block: str, code: str, column: int) -> None:
    out = run(HEAD + block + TAIL)
    errors = [(found, at) for found, _, at in out.errors if found != "feed-missing"]
    assert errors == [(code, column)]
    assert all(d.hint for d in out.diagnostics if d.severity == "error" and d.code not in ("syntax",))


def test_holes_have_bounded_infeeds(run: Any) -> None:
    blocks = "CYCL DEF 200\nQ200=2\nQ201=-9\nQ202=0.00001\nQ206=60\nL X1 FMAX M99"
    assert [code for code, _, _ in run(HEAD + blocks + TAIL).errors] == ["cycle-infeed"]
    assert [code for code, _, _ in run(HEAD + blocks.replace("Q206=60", "") + TAIL).errors] == [
        "feed-missing"
    ]


def test_a_refused_line_leads_where_it_says(run: Any) -> None:
    """Arcs behind it were blamed for beginning elsewhere."""
    blocks = "CC X+20 Y+80\nL X+0 Y+70 F300\nL IY+10 M130\nC X+20 Y+100 DR-\nL X+50"
    out = run(HEAD + blocks + TAIL)
    assert [code for code, _, _ in out.errors] == ["unsupported-block"]


def test_oversizes_of_a_tool(run: Any) -> None:
    """Length and radius of TOOL CALL are added; that of the corner, which LN alone counts, is noted; those of other blocks are refused."""
    plain(run, "TOOL CALL 1 Z S1000 DL+0.0 DR0 DR2+0,00 F200\nL X5")
    plain(run, "TOOL CALL 1 Z S1000 DL+0.5 DR-0,25 F200\nL X5")
    out = run(HEAD + "TOOL CALL 1 Z S1000 DR2+0.1 F200\nL X5 F100" + TAIL)
    assert [d.code for d in out.diagnostics if d.code == "surface-normal"] == ["surface-normal"]
    assert out.errors == []
    out = run(HEAD + "L X5 DL+1 F200\nL X5 F100" + TAIL)
    assert [(code, column) for code, _, column in out.errors] == [("unsupported-block", 6)]


@pytest.mark.parametrize("block", ["L X5 Foo", "CC X5 Y0\nC X5 Y6 DR+ F100", "CC Z5 Y0\nC Z5 Y6 DR+ F100"])
def test_help_is_that_of_the_plain_language(run: Any, block: str) -> None:
    """It spoke of G1 and of I J K."""
    (found,) = (d for d in run(HEAD + block + TAIL).diagnostics if d.severity == "error")
    assert found.hint
    assert "G9" not in found.hint
    assert "G1" not in found.hint


def test_functions_of_fn_need_no_blank(run: Any) -> None:
    """FN 7 took the cosine of the cosine where no blank stood behind COS: 10 cos 60° is 5."""
    out = plain(run, "FN7:Q1=COS60\nFN 3:Q1=+Q1*+10\nFN6:Q2=SIN30\nL X+Q1 Y+Q2 F500")
    assert ends(out) == [[5.0, 0.5, 0.0]]


@pytest.mark.parametrize(
    ("block", "column", "message"),
    [
        ("5 FN 9: IF +Q1 GT +5 GOTO LBL 1", 16, "'GT' where EQU was expected"),
        ("5 L X+10 Y+ F200", 13, "'F200' where a number or a parameter Q was expected"),
        ("Q1 = ( Q2 + 3", 14, "the end of the block where ) or a sign was expected"),
        ("Q1 = 3 * * 4", 10, "'*' where (, a function, a number, a parameter Q or a sign was expected"),
        ("  7 CALL LBL", 13, "the end of the block where a name, a name \"…\" or a number was expected"),
        ("FN 1: Q1 = +Q2 - +5", 1, "- in FN 1 where + was expected"),
        ("4 CYCL DEF 7.1 X+ Y5", 19, "'Y5' where a number or a parameter Q was expected"),
    ],
)  # fmt: skip
def test_what_was_expected(run: Any, block: str, column: int, message: str) -> None:
    (found,) = (d for d in run(HEAD + block + TAIL).diagnostics if d.severity == "error")
    assert (found.code, found.span.column, found.message) == ("syntax", column, message)
    assert found.hint


@pytest.mark.parametrize("block", ["L X+5 F F200", "L X+5 R F200", "L M90 X+5 F200", "M90 X+5 F200"])
def test_words_that_say_nothing(run: Any, block: str) -> None:
    """F and R alone are no feed and no radius."""
    out = plain(run, f"L X+1 F100\n{block}")
    assert ends(out)[-1] == [5, 0, 0]
    assert out.path.feed[out.path.kind != 3][-1] == pytest.approx(200.0 / 60.0)


@pytest.mark.parametrize(
    "remark", ["5 ; note", "5;note", "5 * - note", "5* note", "N5 ;", "5 (note)", "5", "5 ~", "; note", ""]
)
def test_remarks_say_nothing(run: Any, remark: str) -> None:
    """A number alone was no block."""
    out = plain(run, f"4 L X+1 F100\n{remark}\n6 L X+2")
    assert ends(out) == [[1, 0, 0], [2, 0, 0]]


def test_a_corner_behind_a_line_that_is_not_read_is_no_second_fault(run: Any) -> None:
    out = run(HEAD + "L X+1 F100\nL Y+5 BAD\nRND R1\nL X+5" + TAIL)
    assert [code for code, _, _ in out.errors] == ["syntax"]


def test_a_corner_before_arcs_and_polar_lines(run: Any) -> None:
    """They were no motions to a corner, which was refused: a chamfer of 2 between a line to the pole's X axis and each of them."""
    for block in ("LP PR+20 PA+90", "CR X+20 Y+20 R-10 DR+", "C X+0 Y+20 DR+", "CP IPA+90 DR+"):
        out = run(HEAD + f"L X+5 Y+0 F100\nCC X+0 Y+0\nL X+20\nCHF 2\n{block}" + TAIL)
        assert "corner-next" not in [code for code, _, _ in out.errors]
    out = plain(run, "L X+5 Y+0 F100\nCC X+0 Y+0\nL X+20\nCHF 2\nLP PR+20 PA+90")
    # The line to (0, 20) leaves (20, 0) at 45 degrees; legs of 2.
    assert ends(out)[1:] == [[18, 0, 0], [round(20 - math.sqrt(2), 6), round(math.sqrt(2), 6), 0], [0, 20, 0]]
