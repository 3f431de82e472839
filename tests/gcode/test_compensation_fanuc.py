"""Cutter compensation as FANUC's controls do it: G41 again, the other side, another D, G43 H and G28 Z meanwhile, H of the 0M."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

TOOLS = "T1 P1 Z10 D4\nT2 P2 Z20 D6\nT7 P7 D8\n"
ENTER = "G0X0Y0\nG41D1G1X10F100\nY10\n"


def ends(run: Any, tmp_path: Path, text: str, dialect: str = "fanuc") -> list[tuple[float, ...]]:
    """Return where motions end, X Y, and Z where one of them is not 0."""
    table = tmp_path / "tools.tbl"
    table.write_text(TOOLS)
    out = run(text, dialect=dialect, tool_table=table)
    assert out.errors == []
    rows = out.path.end[out.path.kind < 3]
    width = 3 if rows[:, 2].any() else 2
    return [tuple(round(float(v), 6) for v in row[:width]) for row in rows]


def test_the_same_again_changes_nothing(run: Any, tmp_path: Path) -> None:
    rest = "X20\nY0\nG40X0\nM30"
    plain = ends(run, tmp_path, f"{ENTER}{rest}")
    assert plain == [(0, 0), (8, 0), (8, 10), (10, 12), (20, 12), (22, 10), (22, 0), (0, 0)][1:]
    assert ends(run, tmp_path, f"{ENTER}G41D1{rest}") == plain
    assert ends(run, tmp_path, f"{ENTER}D1\n{rest}") == plain


@pytest.mark.parametrize("line", ["G5.1Q1", "G5P10000", "G61.1"])
def test_modes_of_looking_ahead_go_with_it(run: Any, tmp_path: Path, line: str) -> None:
    """They are no splines and no path modes of LinuxCNC, whose numbers they have, and change no path."""
    rest = "X20\nY0\nG40X0\nM30"
    assert ends(run, tmp_path, f"{ENTER}{line}\n{rest}") == ends(run, tmp_path, f"{ENTER}{rest}")


@pytest.mark.parametrize("word", ["D2", "G41D2"])
def test_another_number_counts_at_the_end_of_its_move(run: Any, tmp_path: Path, word: str) -> None:
    """The move begins at the radius of 2, and ends at 3 beside its end; the corner after it is rolled around with 3."""
    expected = [(8, 0), (8, 10), (10, 12), (20, 13), (23, 10), (23, 0), (0, 0)]
    assert ends(run, tmp_path, f"{ENTER}{word}X20\nY0\nG40X0\nM30") == expected


def test_the_other_side_is_taken_at_the_corner(run: Any, tmp_path: Path) -> None:
    """Back along the same line with the other side, the tool stays on its side; along another one, it crosses the corner."""
    assert ends(run, tmp_path, f"{ENTER}G42Y0\nX20\nG40X0\nM30")[2:4] == [(8, 0), (10, -2)]
    crossing = ends(run, tmp_path, f"{ENTER}G42Y20\nX20\nG40X0\nM30")
    assert crossing == [(8, 0), (8, 10), (12, 10), (12, 18), (20, 18), (0, 20)]


def test_the_length_changes_meanwhile(run: Any, tmp_path: Path) -> None:
    """Z50 with the length 20 is Z70 of the machine; around the corner it stays there."""
    found = ends(run, tmp_path, f"{ENTER}G43H2Z50.\nX20\nY5.\nG91G28Z0\nG90\nG40X0\nM30")
    assert found == [
        (8, 0, 0), (8, 10, 0), (8, 10, 70), (10, 12, 70), (20, 12, 70), (22, 10, 70), (22, 5, 70), (22, 5, 0), (0, 5, 0),
    ]  # fmt: skip


@pytest.mark.parametrize(
    "block",
    [
        "G28X10Y20",
        "G30X10Y20",
        "G53X0Y0",
        "G81X30Y30Z-5R2F100\nX40\nG80",
        "T2M6",
        "G55",
        "G92X0Y0",
        "G52X5",
        "G28X10Y20\nT2M6\nG53Y0",
    ],
)
def test_what_interrupts_it(run: Any, tmp_path: Path, block: str) -> None:
    """The controls cancel compensation for such a block and begin it again with the next move: as if G40 and G41 were written."""
    rest = "X10\nY10\nG40X-20\nM30"
    written = ends(run, tmp_path, f"{ENTER}G40\n{block}\nG41G1{rest}")
    assert ends(run, tmp_path, f"{ENTER}{block}\nG1{rest}") == written


def test_the_way_to_a_reference_point_and_back_under_it(run: Any, tmp_path: Path) -> None:
    """The offset of 2 to the left is there up to the point beside (10, 10), and from the entry behind the reference point on."""
    found = ends(run, tmp_path, f"{ENTER}G28X10Y20\nG1X10\nY10\nG40X-20\nM30")
    assert found == [(8, 0), (8, 10), (10, 20), (0, 0), (8, 0), (8, 10), (-20, 10)]


def test_an_interruption_is_said_once(run: Any, tmp_path: Path) -> None:
    out = run(f"{ENTER}G28X10Y20\nG1X10\nY10\nG28X10Y20\nG40X-20\nM30", dialect="fanuc")
    assert [d.span.line for d in out.diagnostics if d.code == "comp-interrupted"] == [4]


def test_h_without_d_is_the_radius_of_the_0m(run: Any, tmp_path: Path) -> None:
    assert ends(run, tmp_path, "G0X0Y0\nG42H7G1X10F100\nY10\nG40X0\nM30")[0] == (14, 0)
    out = run("G0X0Y0\nG42H7G1X10F100\nG40X0\nM30", dialect="fanuc")
    assert "radius-by-h" in [d.code for d in out.diagnostics]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G41D1G1X10F100\nY10", (8, 0)),  # inner side
        ("G42D1G1X10F100\nY10", (12, 0)),  # outer side, a right angle
        ("G42D1G1X10F100\nX0Y10", (10 + 2**0.5, 2**0.5)),  # outer side, an acute angle
        ("G41D1G1X10F100\nG3X0Y10I-10J0", (8, 0)),
        ("G41D1G1X10F100\nZ-5\nY10", (8, 0)),
    ],
)
def test_the_start_up_leads_beside_the_second_move(
    run: Any, tmp_path: Path, text: str, expected: tuple[float, float]
) -> None:
    """B-64484EN, "Tool Movement in Start-up", type A: the offset of 2 is square to the beginning of the move behind the start-up."""
    found = ends(run, tmp_path, f"G0X0Y0\n{text}\nG40G1X-20Y-20\nM30")
    assert found[0][:2] == pytest.approx(expected, abs=1e-6)


def test_the_entry_may_be_short(run: Any, tmp_path: Path) -> None:
    assert ends(run, tmp_path, "G0X0Y0\nG41D1G1X1F100\nY10\nG40X0\nM30")[:2] == [(-1, 0), (-1, 10)]


@pytest.mark.parametrize(("dialect", "lines"), [("fanuc", [3]), ("linuxcnc", [])])
def test_an_entry_on_an_arc_is_said(run: Any, tmp_path: Path, dialect: str, lines: list[int]) -> None:
    """FANUC's alarm PS0034: no circle in the start-up block; LinuxCNC enters on arcs."""
    table = tmp_path / "tools.tbl"
    table.write_text(TOOLS)
    out = run(
        "G21G17G90F100\nG0X0Y0\nG42D1G3X20Y0R10\nG3X0Y0R10\nG1G40X-20Y-20\nM30",
        dialect=dialect,
        tool_table=table,
    )
    assert out.errors == []
    assert [d.span.line for d in out.diagnostics if d.code == "comp-entry" and d.span] == lines


def test_an_arc_with_another_radius_is_refused(run: Any, tmp_path: Path) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text(TOOLS)
    text = "G41D1G1X10F100\nX20\nD2\nG3X30Y10R10\nG1Y20\nG40X50\nM30"
    assert run(text, dialect="fanuc", tool_table=table).errors[0][:2] == ("comp-refused", 4)


def test_an_entry_as_long_as_the_radius_of_a_table(run: Any, tmp_path: Path) -> None:
    """rs274: STRAIGHT_FEED(0, 0.25), STRAIGHT_FEED(0, 10) for an entry of 0.25 inch with a tool of 0.5 inch."""
    found = ends(run, tmp_path, "G0X0Y0\nG41D1\nG1X2F100\nY10\nG40X20\nM2", "linuxcnc")
    assert found[:2] == [(0, 2), (0, 10)]
    assert run("G41.1D4\nG1X2F100\nY10\nG40X20\nM2", dialect="linuxcnc").errors == [("comp-entry", 2, 1)]


@pytest.mark.parametrize("dialect", ["fanuc", "linuxcnc"])
def test_a_percent_at_the_end_alone_ends_the_program(run: Any, dialect: str) -> None:
    out = run("G0X1\nG1X10F100\n%\nG1X50\n", dialect=dialect)
    assert out.errors == []
    assert out.path.end[-1, 0] == 10.0
    remarks = ["text-behind-end", "stray-percent"] if dialect == "linuxcnc" else ["text-behind-end"]
    assert [d.code for d in out.diagnostics] == remarks


@pytest.mark.parametrize(
    ("way", "last"),
    [
        ("", (8, 10)),
        ("I-5J-5", (8, 5.171573)),  # 2 beside X10 and 2 beside Y = X, below it: 8 - 2√2
        ("I-5", (8, 8)),  # a wall to the left: inside corner
        ("I5", (8, 12)),  # outside: where the offset paths cross, not rolled around
        ("J5", (8, 10)),  # straight on
        ("J-5", (8, 10)),  # back: they do not cross
    ],
)
def test_a_direction_beside_g40_ends_the_last_move(
    run: Any, tmp_path: Path, way: str, last: tuple[float, ...]
) -> None:
    """B-63014EN, "Cutter Compensation Cancel"; Okuma 5238-E, p. 84: the tool touches the last line and the imaginary one I J."""
    assert ends(run, tmp_path, f"{ENTER}G40X30Y0{way}\nM30") == [(8, 0), last, (30, 0)]


def test_a_direction_beside_g40_crosses_an_arc(run: Any, tmp_path: Path) -> None:
    """Behind a quarter about (20, 10), offset to 12; its line at Y20 goes back to -X, 2 below it on the left: the arc's at Y18."""
    text = f"{ENTER}G2X20Y20R10\nG1G40X30Y40I-5\nM30"
    assert ends(run, tmp_path, text)[-2] == (round(20 - (12**2 - 8**2) ** 0.5, 6), 18)


def test_a_direction_beside_g40_of_a_lathe_is_no_chamfer(run: Any, tmp_path: Path) -> None:
    """The tip is the nose's centre (orientation 9): the face at Z-20 holds it 2 before, 2 outside of the turned diameter."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D4 Q9\n")
    text = "G21\nT0101\nG97S500M3\nG0X30.Z5.\nG42G1X20.Z0F0.2\nZ-20.\nG40G0X60.Z-15.I10.K0\nM30"
    out = run(text, dialect="fanuc-lathe", tool_table=table)
    assert out.errors == []
    rows = [tuple(round(float(v), 6) for v in row[[0, 2]]) for row in out.path.end[out.path.kind < 3]]
    assert rows[-2:] == [(12, -18), (30, -15)]


@pytest.mark.parametrize(
    ("leave", "warned"),
    [
        ("G40\nG0Z5.\nX-20", 1),
        ("G40G0Z5.\nX-20", 1),
        ("G40\nG91G28Z0\nG90X-20", 1),
        ("G40G0X-20\nZ5.", 0),
        ("G40\nX-20Z5.", 0),
        ("G40\nM8\nX-20\nZ5.", 0),
    ],
)
def test_a_move_out_of_the_plane_that_ends_the_offset_is_warned_of(
    run: Any, tmp_path: Path, leave: str, warned: int
) -> None:
    """The tool stands 2 beside X10, and goes across while it is drawn back: controls differ in that."""
    table = tmp_path / "tools.tbl"
    table.write_text(TOOLS)
    out = run(f"{ENTER}{leave}\nM30", dialect="fanuc", tool_table=table)
    assert out.errors == []
    found = [d.message for d in out.diagnostics if d.code == "comp-exit"]
    assert len(found) == warned
    assert all("back onto the programmed path too, by 2 mm" in message for message in found)


@pytest.mark.parametrize(("corner", "said"), [("G39", 0), ("G39I10J0", 1), ("G39X20", 1)])
def test_g39_is_the_arc_around_an_outside_corner(run: Any, tmp_path: Path, corner: str, said: int) -> None:
    """ "The arc at the corner is formed so that the vector at the end point of the arc is perpendicular to the start point of the next
    block" (B-63324EN, 14.4.9); the tool of radius 2 goes around X10 Y10 from 8, 10 to 10, 12."""
    table = tmp_path / "tools.tbl"
    table.write_text(TOOLS)
    out = run(f"{ENTER}{corner}\nX20\nY0\nG40X0\nM30", dialect="fanuc", tool_table=table)
    assert out.errors == []
    assert len([d for d in out.diagnostics if d.message.startswith(("I of G39", "X of G39"))]) == said
    rows = [tuple(row) for row in out.path.end[out.path.kind < 3][:, :2].round(6).tolist()]
    assert rows[1:6] == [(8, 10), (10, 12), (20, 12), (22, 10), (22, 0)]
    assert run("G0X0\nG39\nM30", dialect="fanuc").errors == [("comp-refused", 2, 1)]


def test_widths_in_position_and_the_speed_of_the_way_out_change_nothing(run: Any) -> None:
    """Of Mitsubishi's controls: ,I and ,J beside a motion or a cycle, ,S beside a tap; each is told."""
    plain = "G21G90G94S500M3F500\nG0X5{}\nG84X10Z-5R2{}{}\nG81X20Z-3R2{}\nG80\nM30"
    told = run(plain.format(",I0.02", ",R1", ",S900", ",I0.1,J0.05"), dialect="fanuc")
    bare = run(plain.format("", "", "", ""), dialect="fanuc")
    assert told.errors == bare.errors == []
    assert told.path.end.tolist() == bare.path.end.tolist()
    codes = [(d.code, d.span.line) for d in told.diagnostics if d.message.startswith(",") and d.span]
    assert codes == [("other-control", 2), ("cycle-words", 3)]
    assert run("G21G1X1F9,S5\nM30", dialect="fanuc").errors == [("unused-word", 1, 10)]
