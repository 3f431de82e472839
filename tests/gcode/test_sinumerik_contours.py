"""CYCLE72 and CYCLE95 of SINUMERIK: motions worked out by hand; tool 1 has the radius 4."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import pytest

MILL = "G17 G90 G94 F500 S1000 M3\nT1 D1 M6\nG0 X-30 Y-30 Z20\nCYCLE72({})\nM30\n{}"
SQUARE = "PROC WAY\nG1 X0 Y0\nX40\nY20\nX0\nY0\nM17\n"
#: Inside the square, 4 aside; without a way on, none off.
INSIDE = [(0, 4), (36, 4), (36, 16), (4, 16), (4, 0)]


def _on_level(path: list[tuple[float, float]], z: float, feed: float) -> list[Any]:
    return [(x, y, z, feed) for x, y in path]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        # One level: over the beginning of the way on (a line of 10), down to 2, at FFD to -5, along, off by a line of 5.
        ('"WAY",20,0,2,-5,0,0,0,300,100,1,41,1,10,400,1,5',
         [(-30, -30, 20, 0), (-10, 4, 20, 0), (-10, 4, 2, 0), (-10, 4, -5, 100), *_on_level(INSIDE, -5, 300), (4, -5, -5, 400), (4, -5, 20, 0)]),
        # Two levels of 3 with allowances of 1 and 1; a quadrant of 5 leads on, a semicircle of 3 off; between them up to 2, there at G1.
        ('"WAY",20,0,2,-7,4,1,1,300,100,111,41,2,5,400,3,3',
         [(-30, -30, 20, 0), (-5, 10, 20, 0), (-5, 10, 2, 0), (-5, 10, -3, 100),
          *_on_level([(0, 5), (35, 5), (35, 15), (5, 15), (5, 0)], -3, 300), (11, 0, -3, 400), (11, 0, 2, 0),
          (-5, 10, 2, 400), (-5, 10, -6, 100), *_on_level([(0, 5), (35, 5), (35, 15), (5, 15), (5, 0)], -6, 300), (11, 0, -6, 400), (11, 0, 20, 0)]),
        # Finishing takes no allowance; on the contour itself (40), not up between the levels.
        ('"WAY",20,0,2,-4,2,1,1,300,100,302,40,1,2,0,1,2',
         [(-30, -30, 20, 0), (-2, 0, 20, 0), (-2, 0, 2, 0), (-2, 0, -2, 100), *_on_level([(0, 0), (40, 0), (40, 20), (0, 20), (0, 0), (0, -2)], -2, 300),
          (-2, 0, -2, 0), (-2, 0, -4, 100), *_on_level([(0, 0), (40, 0), (40, 20), (0, 20), (0, 0), (0, -2)], -4, 300), (0, -2, 20, 0)]),
    ],
)  # fmt: skip
def test_milling_beside_a_contour(moves: Any, words: str, expected: list[Any]) -> None:
    assert moves(MILL.format(words, SQUARE), dialect="sinumerik") == expected


def test_outside_corners_are_rolled_around(moves: Any) -> None:
    """Right of the square, 4 aside: each outer corner is an arc of 4 about it."""
    found = moves(MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,1,42,1,10,400,1,5', SQUARE), dialect="sinumerik")
    assert [(x, y) for x, y, z, feed in found if feed == 300] == [
        (0, -4), (40, -4), (44, 0), (44, 20), (40, 24), (0, 24), (-4, 20), (-4, 0)]  # fmt: skip


def test_a_contour_between_labels_of_the_program_is_run_in_its_place_as_well(moves: Any) -> None:
    text = 'G17 G90 F500\nT1 D1 M6\nCYCLE72("SIDE:SIDE_E",20,0,2,-5,0,0,0,300,100,1,40,1,10,400,1,5)\nGOTOF DONE\nSIDE:\nG1 X10 Y0\nX30 RND=5\nY20\nSIDE_E:\nDONE:\nG0 X1\nM30\n'
    found = moves(text, dialect="sinumerik")
    assert [(x, y) for x, y, z, feed in found if feed == 300] == [(10, 0), (25, 0), (30, 5), (30, 20)]
    assert found[-1][:3] == (1, 25, 20)


def test_a_contour_is_milled_backwards(moves: Any, run: Any) -> None:
    """VARI of CYCLE72: 1 in the ten thousands mills against the direction of the contour (NC programming 12/2019, 3.25)."""
    text = 'G17 G90 F500\nT1 D1 M6\nCYCLE72("SIDE:SIDE_E",20,0,2,-5,0,0,0,300,100,10001,{},1,10,400,1,5)\nM30\nSIDE:\nG1 X10 Y0\nX30 RND=5\nY20\nSIDE_E:\nM30\n'
    found = moves(text.format(40), dialect="sinumerik")
    assert [(x, y) for x, y, z, feed in found if feed == 300] == [(30, 20), (30, 5), (25, 0), (10, 0)]
    assert next(code for code, *_ in run(text.format(41), dialect="sinumerik").errors) == "not-read"


TURN = 'G18 G90 G94 F500 DIAMON\nG0 X100 Z20\nCYCLE95("PART:PARTE",{})\nM30\nPART:\n{}PARTE:\n'
SHAFT = "G1 X20 Z0\nZ-10\nX30 Z-20\nZ-30\nX40\n"
#: Levels of 2 from X20 to X10 (radius): X18, 16, 14, 12 end at Z-30, -30, -18, -14; then along the shaft.
LEVELS = [(18, -30), (16, -30), (14, -18), (12, -14)]
ALONG = [(10, 0), (10, -10), (15, -20), (15, -30), (20, -30)]


def _cuts(found: list[Any], feed: float) -> list[tuple[float, float]]:
    return [(x, z) for x, _, z, f in found if f == feed]


def test_roughing_along_z(moves: Any) -> None:
    found = moves(TURN.format("2,0,0,0,300,0,150,1", SHAFT), dialect="sinumerik")
    cuts = [end for _, end in itertools.groupby(_cuts(found, 300), key=lambda p: p[0])]
    assert cuts
    ends = [b for a, b in itertools.pairwise(_cuts(found, 300)) if a[0] == b[0] and a[1] == 1.0]
    assert ends == [*LEVELS, (10, 0)]
    assert _cuts(found, 300)[-5:] == ALONG
    # No traverse below the blank leads through stock: it stands where the cut before has been.
    for (x0, _, z0, _), (x1, _, z1, feed) in itertools.pairwise(found):
        assert feed or x1 >= x0 or z0 >= 1.0 or z1 >= 1.0


def test_allowances_and_finishing(moves: Any) -> None:
    """FALZ 0.1 and FALX 0.2 move the roughed contour; the last pass is the contour at FF3, and ends 1 mm above the blank."""
    found = moves(TURN.format("2,0.1,0.2,0,300,0,150,9", SHAFT), dialect="sinumerik")
    assert _cuts(found, 300)[-5:] == [(pytest.approx(x + 0.2), pytest.approx(z + 0.1)) for x, z in ALONG]
    assert _cuts(found, 150) == ALONG
    assert found[-1] == (21, 0, 1, 0)


def test_a_contour_written_backwards_and_one_inside(moves: Any) -> None:
    back = "G1 X40 Z-30\nX30\nZ-20\nX20 Z-10\nZ0\n"
    assert _cuts(moves(TURN.format("2,0,0,0,300,0,150,5", back), dialect="sinumerik"), 150) == ALONG
    bore = "G1 X40 Z0\nZ-10\nX20 Z-20\n"
    inside = moves(TURN.format("4,0,0.5,0,300,0,150,3", bore), dialect="sinumerik")
    # Levels of 5 at most from X10 to X20, which is 9.5 to 19.5 with the allowance: in three, at 12.833, 16.167 and 19.5.
    assert sorted({round(x, 3) for x, z in _cuts(inside, 300) if z == 1.0}) == [12.833, 16.167, 19.5]


def test_facing(moves: Any) -> None:
    """Along X from outside: levels of Z above the deepest of the contour, each to where the contour rises."""
    found = moves(TURN.format("5,0,0,0,300,0,150,2", "G1 X60 Z-10\nX40\nZ-5\nX20\nZ0\n"), dialect="sinumerik")
    starts = [(a, b) for a, b in itertools.pairwise(_cuts(found, 300)) if a[1] == b[1] and a[0] == 31.0]
    assert starts == [((31, -5), (20, -5)), ((31, -10), (30, -10))]


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        (MILL.format('WAY,20,0,2,-5,0,0,0,300,100,1,41,1,10', SQUARE), "variable-unknown", 4),
        (MILL.format('"NONE",20,0,2,-5,0,0,0,300,100,1,41,1,10', SQUARE), "sub-missing", 4),
        (MILL.format('"AA:BB",20,0,2,-5,0,0,0,300,100,1,41,1,10', SQUARE), "label-missing", 4),
        (MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,5,41,1,10', SQUARE), "not-read", 4),
        (MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,1,43,1,10', SQUARE), "not-read", 4),
        (MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,1,41,11,10', SQUARE), "not-read", 4),
        (MILL.format('"WAY",20,0,2,,0,0,0,300,100,1,41,1,10', SQUARE), "cycle-depth", 4),
        (MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,1,41,1,10', "PROC WAY\nG1 X0 Y0\nM17\n"), "profile-length", 4),
        (MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,1,41,1,10', "PROC WAY\nG1 X0 Y0\nX5\nY5\nX0\nY0\nM17\n"), "profile-corner", 4),
        (MILL.format('"WAY",20,0,2,-5,0,0,0,300,100,1,41,1,10', "PROC WAY\nT1 D1\nG41 G1 X0 Y0\nX5\nM17\n"), "not-read", 4),
        (TURN.format("2,0,0,0,300,0,150,1", f"T1 D1\nG42\n{SHAFT}"), "not-read", 3),
        (TURN.format("0,0,0,0,300,0,150,1", SHAFT), "cycle-words", 3),
        (TURN.format("2,0,0,0,300,0,150,13", SHAFT), "cycle-words", 3),
        (TURN.format("2,-1,0,0,300,0,150,1", SHAFT), "cycle-words", 3),
        (TURN.format("2,0,0,0,300,0,150,1", SHAFT).replace("G18", "G17"), "cycle-words", 3),
        (TURN.format("2,0,0,0,300,0,150,1", "G1 X20 Z0\nZ-20\nX30 Z-10\nX40\n"), "profile-not-monotonic", 3),
    ],
)  # fmt: skip
def test_wrong_ones(run: Any, tmp_path: Path, text: str, code: str, line: int) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    assert run(text, dialect="sinumerik", tool_table=table).errors[0][:2] == (code, line)
