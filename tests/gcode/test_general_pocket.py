"""G150 of Haas's mills: how near the tool comes to the walls, the levels, the rows, islands, and what is wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind

HEAD = "O1\nG21 G17 G40 G90\nG0 X0 Y0 Z20\n"
#: A rectangle of 40 by 20 about the origin, counter-clockwise; the first move leads to its upper wall.
RECTANGLE = "G1 Y10\nX-20\nY-10\nX20\nY10\nX0\nM99"
#: The same with a bridge to an island, a square of 4 about X12 Y0.
ISLAND = "G1 Y10\nX-20\nY-10\nX12\nY-2\nX10\nY2\nX14\nY-2\nX12\nY-10\nX20\nY10\nX0\nM99"


def outcome(run: Any, tmp_path: Path, text: str, outline: str = RECTANGLE) -> Any:
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 D8\nT2 P2 D40\nT3 P3 D4\n")
    return run(f"{HEAD}{text}\nM30\nO2\n{outline}", dialect="fanuc", tool_table=table, inch_tables=False)


def fed(out: Any) -> np.ndarray:
    """Return where the feeds end, and by columns: X Y Z."""
    assert out.errors == []
    return np.asarray(out.path.end[_moves(out) & (out.path.feed_mode != FeedMode.RAPID)][:, :3]).round(9)


def _moves(out: Any) -> np.ndarray:
    return np.asarray(out.path.kind != Kind.EVENT)


@pytest.mark.parametrize(("code", "side"), [("J3", 1), ("I3", 0)])
def test_rows_and_walls(run: Any, tmp_path: Path, code: str, side: int) -> None:
    """From R1 down in steps of Q1.5: -0.5, -2 and what is left, -3. The radius of 4 and K1 leave 15 and 5 of the half sides 20 and 10; the
    last pass has 16 and 6. Rows are 3 apart at most: 10 wide in Y, 5 rows at 2.5; 30 wide in X, 11 rows at 3.
    """
    out = outcome(run, tmp_path, f"G150 X0 Y0 Z-3 R1 Q1.5 {code} K1 P2 G41 D1 F100\nG40 X0 Y0")
    places = fed(out)
    assert sorted(set(places[:, 2])) == [-3.0, -2.0, -0.5]
    for level in (-0.5, -2.0):
        at = places[places[:, 2] == level]
        assert np.abs(at[:, :2]).max(axis=0).tolist() == [15.0, 5.0]
    floor = places[places[:, 2] == -3.0]
    assert np.abs(floor[:, :2]).max(axis=0).tolist() == [16.0, 6.0]
    rows = places[(places[:, 2] == -2.0)][:, side]
    assert np.diff(np.unique(rows)).max() <= 3.0
    # Where the tool goes in, which may be drilled before.
    assert [0.0, 0.0, -0.5] in places.tolist()


def test_an_island_stays(run: Any, tmp_path: Path) -> None:
    """The tool of radius 2 keeps 2 from a square of 4: no place of it is nearer, along no feed."""
    out = outcome(run, tmp_path, "G150 X0 Y0 Z-1 R1 Q2 J1 P2 G41 D3 F100", ISLAND)
    places = fed(out)
    assert np.abs(places[:, :2]).max(axis=0).tolist() == [18.0, 8.0]
    path = out.path
    nearest = np.inf
    for row in range(1, len(path.kind)):
        if path.kind[row] == Kind.LINE and path.feed_mode[row] != FeedMode.RAPID:
            ways = path.end[row - 1, :2] + np.linspace(0.0, 1.0, 50)[:, None] * (
                path.end[row, :2] - path.end[row - 1, :2]
            )
            aside = np.maximum(np.abs(ways - [12.0, 0.0]) - 2.0, 0.0)
            nearest = min(nearest, np.hypot(*aside.T).min())
    assert nearest == pytest.approx(2.0, abs=1e-9)


def test_the_outline_is_lines_of_the_program_itself(run: Any, tmp_path: Path) -> None:
    text = "G150 X0 Y0 Z-3 R1 Q1.5 J3 K1 P{} G41 D1 F100\nM30"
    inside = outcome(run, tmp_path, f"{text.format(7)}\nN7 {RECTANGLE}")
    assert fed(inside).tolist() == fed(outcome(run, tmp_path, text.format(2))).tolist()


def test_parameters_of_the_caller_make_the_outline(run: Any, tmp_path: Path) -> None:
    outline = "G1 Y#1\nX-[2*#1]\nY-#1\nX[2*#1]\nY#1\nX0\nM99"
    text = "#1=10\nG150 X0 Y0 Z-3 R1 Q1.5 J3 K1 P2 G41 D1 F100"
    assert fed(outcome(run, tmp_path, text, outline)).tolist() == fed(outcome(run, tmp_path, text)).tolist()


def test_without_a_tool_table_the_tool_goes_around_the_corners(run: Any) -> None:
    """The step of 3 is half the width of a tool that does not fit in corners of 2.5."""
    outline = "G1 Y10\nX-17.5\nG3 X-20 Y7.5 R2.5\nG1 Y-10\nX20\nY10\nX0\nM99"
    out = run(f"{HEAD}G150 X0 Y0 Z-1 R1 Q2 J3 P2 G41 D1 F100\nM30\nO2\n{outline}", dialect="fanuc")
    assert out.errors == []
    assert [d.severity.value for d in out.diagnostics if d.code == "tool-assumed"] == ["warning"]


GOOD = "G150 X0 Y0 Z-3 R1 Q1.5 J3 P2 G41 D1 F100"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (GOOD.replace("G41", "G40"), ("cycle-plane", 4, 1)),
        (GOOD.replace("G41", "G42"), ("not-read", 4, 27)),
        (GOOD.replace(" J3", ""), ("cycle-words", 4, 1)),
        (GOOD.replace("J3", "I3 J3"), ("cycle-words", 4, 1)),
        (GOOD.replace("J3", "J0"), ("cycle-infeed", 4, 24)),
        (GOOD.replace(" R1", ""), ("cycle-words", 4, 1)),
        (GOOD.replace("R1", "R-5"), ("cycle-level", 4, 12)),
        (GOOD.replace("Q1.5", "Q.000001"), ("profile-step", 4, 19)),
        (GOOD.replace(" F100", ""), ("feed-missing", 4, 1)),
        (GOOD.replace("D1", "D9"), ("unknown-tool", 4, 34)),
        (GOOD.replace("D1", "D2"), ("cycle-tool", 4, 1)),
        (GOOD.replace("P2", "P3"), ("sub-missing", 4, 27)),
        (f"G91\n{GOOD}", ("cycle-plane", 5, 1)),
        (f"G18\n{GOOD}", ("cycle-plane", 5, 1)),
    ],
)  # fmt: skip
def test_what_is_wrong(run: Any, tmp_path: Path, text: str, expected: tuple[str, int, int]) -> None:
    assert outcome(run, tmp_path, text).errors[0] == expected


@pytest.mark.parametrize(
    ("outline", "code"),
    [("G1 Y10\nX-20\nM99", "profile-length"), ("G2 X5 R1\nM99", "arc-radius"), ("M99", "profile-length")],
)
def test_what_is_wrong_in_the_outline(run: Any, tmp_path: Path, outline: str, code: str) -> None:
    assert outcome(run, tmp_path, GOOD, outline).errors[0][:2] == (code, 4)
