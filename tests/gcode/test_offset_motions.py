"""G45 to G48: motions that go farther, or less far, by a tool offset."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cncgen.toolpath.record import Kind


def outcome(run: Any, tmp_path: Path, text: str) -> Any:
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 D20\nT2 P2 D-20\n")
    return run(f"O1\nG21 G17 G40 G80\n{text}\nM30", dialect="fanuc", tool_table=table, inch_tables=False)


def ends(out: Any) -> list[list[float]]:
    assert out.errors == []
    return out.path.end[out.path.kind != Kind.EVENT][:, :2].round(9).tolist()


def test_a_contour_of_increments_and_decreases(run: Any, tmp_path: Path) -> None:
    """FANUC's example "Program using tool offset" (B-63944EN, 14.3): D01 is 10. The way of the centre closes, 10 beside the part."""
    out = outcome(
        run,
        tmp_path,
        "G91 G46 G00 X80 Y50 D01\nG47 G01 X50 F120\nY40\nG48 X40\nY-40\nG45 X30\nG45 G03 X30 Y30 J30\n"
        "G45 G01 Y20\nG46 X0\nG46 G02 X-30 Y30 J30\nG45 G01 Y0\nG47 X-120\nG47 Y-80\nG46 G00 X-80 Y-50",
    )
    expected = [
        (70, 40),
        (140, 40),
        (140, 80),
        (160, 80),
        (160, 40),
        (200, 40),
        (240, 80),
        (240, 110),
        (230, 110),
    ]
    expected += [(210, 130), (210, 140), (70, 140), (70, 40), (0, 0)]
    assert ends(out) == [list(map(float, point)) for point in expected]


@pytest.mark.parametrize(
    ("block", "x"),
    [
        *(("G45 X1", 11), ("G45 X-1", -11), ("G46 X1", -9), ("G46 X-1", 9)),
        *(("G47 X1", 21), ("G47 X-1", -21), ("G48 X1", -19), ("G48 X-1", 19)),
        *(("G45 X0", 10), ("G45 X-0", -10), ("G46 X0", -10), ("G46 X-0", 10)),
    ],
)
def test_increments(run: Any, tmp_path: Path, block: str, x: float) -> None:
    """Mitsubishi's table (M700V programming manual, 12.6), for an offset l of 10; D2, -10, turns every sign of l."""
    assert ends(outcome(run, tmp_path, f"G91 G0 {block} D1"))[-1][0] == x
    step = float(block.split("X")[1])
    assert ends(outcome(run, tmp_path, f"G91 G0 {block} D2"))[-1][0] == 2 * step - x


def test_coordinates(run: Any, tmp_path: Path) -> None:
    """In G90 the way to the place is longer; an axis that is there stays (ibid., precaution 3)."""
    out = outcome(run, tmp_path, "G90 G0 X100 Y30\nG45 X150 Y30 D1\nG46 X100\nX50")
    assert ends(out) == [[100, 30], [160, 30], [110, 30], [50, 30]]


def test_three_quarters_of_a_circle(run: Any, tmp_path: Path) -> None:
    out = outcome(run, tmp_path, "G91 G45 G2 X-20 Y-20 I-20 D1 F100")
    assert ends(out) == [[-30, -30]]


@pytest.mark.parametrize(
    ("block", "error"),
    [
        ("G91 G45 G0 X10", ("comp-diameter", 3, 5)),
        ("G91 G45 G2 X-10 Y-20 I-20 D1 F100", ("not-read", 3, 5)),
        ("G91 G45 G2 X10 Y10 R10 D1 F100", ("unused-word", 3, 20)),
        ("G81 Z-1 R1 F50\nG45 X10 D1", ("not-read", 4, 1)),
        ("G41 D1 G1 X10 F100\nG45 X20", ("comp-refused", 4, 1)),
        ("G47 P0 X10 Y10 I0 J10 R1 Z-1 E5 F10", ("cycle-words", 3, 1)),
        ("G47 P1 X10 Y10 I0 J10 R1 Z-1 E5 F10 (0001)", ("not-read", 3, 1)),
        ("G45 D1", ("axis-missing", 3, 1)),
    ],
)
def test_what_is_refused(run: Any, tmp_path: Path, block: str, error: tuple[str, int, int]) -> None:
    assert outcome(run, tmp_path, block).errors[0] == error
