"""Studs, faces and ruled surfaces of Heidenhain, 256, 257, 232, 233 and 231: motions worked out by hand; tool 1 has the radius 4."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

PLAIN = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000 F350\n"

COMMON = "Q207=+300 ~\n Q201=-{depth} ~\n Q202=+5 ~\n Q206=+100 ~\n Q200=+2 ~\n Q203=+0 ~\n Q204=+20 ~\n Q370=+1 ~\n Q368=+0 ~\n Q351=+1"
RECTANGLE = (
    "CYCL DEF 256 STUD ~\n Q218=+40 ~\n Q424=+48 ~\n Q219=+20 ~\n Q425=+28 ~\n Q220=+0 ~\n Q224=+{turn} ~\n Q367=+0 ~\n "
    + COMMON
)
CIRCLE = "CYCL DEF 257 STUD ~\n Q223=+20 ~\n Q222=+{blank} ~\n Q369=+0 ~\n " + COMMON
FACE = ("CYCL DEF 232 FACE ~\n Q389={way} ~\n Q225=+0 ~\n Q226=+0 ~\n Q227=+1 ~\n Q386=+0 ~\n Q218=+30 ~\n Q219=+8 ~\n Q202=+1 ~\n"
        " Q369=+{last} ~\n Q370=+1 ~\n Q207=+300 ~\n Q385=+200 ~\n Q253=+500 ~\n Q200=+2 ~\n Q357=+1 ~\n Q204=+20")  # fmt: skip
RULED = (
    "CYCL DEF 231 RULED ~\n Q225=+0 ~\n Q226=+5 ~\n Q227=-2 ~\n Q228=+100 ~\n Q229=+15 ~\n Q230=+5 ~\n Q231=+90 ~\n Q232=+125 ~\n Q233=+25 ~\n \
Q234=+15 ~\n Q235=+125 ~\n Q236=+26 ~\n Q240={count} ~\n Q207=+300"
)
#: Once around at the tool's radius, clockwise from the right: the corners are those of the stud, rounded by the tool.
AROUND = [(24, 0), (24, -10), (20, -14), (-20, -14), (-24, -10), (-24, 10), (-20, 14), (20, 14), (24, 10), (24, 0)]  # fmt: skip


def _stud(loop: list[tuple[float, float]], beside: tuple[float, float], depth: float) -> list[Any]:
    return [
        (*beside, 0, 0),
        (*beside, 2, 0),
        (*beside, -depth, 100),
        *[(x, y, -depth, 300) for x, y in loop],
        (*beside, -depth, 300),
        (*beside, 2, 0),
        (*beside, 20, 0),
        (0, 0, 20, 0),
    ]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (RECTANGLE.format(depth=3, turn=0), _stud(AROUND, (30, 0), 3)),
        # Turned by 90 degrees, x is y and y is -x.
        (RECTANGLE.format(depth=3, turn=90), _stud([(-y, x) for x, y in AROUND], (0, 30), 3)),
        # Q437: off a corner, 24 + 4 + 2 and 14 + 4 + 2 from the middle; the lower left one, up the left side first; and the upper right one, up-cut.
        (RECTANGLE.format(depth=3, turn=0) + " ~\n Q437=+1", _stud([*AROUND[4:9], *AROUND[1:5]], (-30, -20), 3)),
        (RECTANGLE.format(depth=3, turn=0).replace("Q351=+1", "Q351=-1") + " ~\n Q437=+3",
         _stud([*AROUND[7:0:-1], *AROUND[8:6:-1]], (30, 20), 3)),
        # A round stud of 20 out of 36: 8 aside, so two loops, at 18 and 14 from the middle; each quarter is an arc.
        (CIRCLE.format(depth=3, blank=36),
         _stud([(r * x, r * y) for r in (18, 14) for x, y in ((1, 0), (0, -1), (-1, 0), (0, 1), (1, 0))], (24, 0), 3)),
        # Begun at 90 degrees, x is y and y is -x.
        (CIRCLE.format(depth=3, blank=36) + " ~\n Q376=+90",
         _stud([(-r * y, r * x) for r in (18, 14) for x, y in ((1, 0), (0, -1), (-1, 0), (0, 1), (1, 0))], (0, 24), 3)),
        # Two levels of 232 to and fro: 1 mm, then the last 0 at the same; rows of 4 mm at 0 and 4, ends 4 + 1 beyond.
        (FACE.format(way=0, last=0), [(0, 0, 21, 0), (-5, 0, 21, 0), (-5, 0, 3, 0), (-5, 0, 0, 500), (35, 0, 0, 300), (35, 4, 0, 500), (-5, 4, 0, 300),
                                      (-5, 4, 3, 0), (-5, 4, 21, 0)]),
        (FACE.format(way=1, last=0), [(0, 0, 21, 0), (0, 0, 3, 0), (0, 0, 0, 500), (30, 0, 0, 300), (30, 4, 0, 300), (0, 4, 0, 300), (0, 4, 3, 0), (0, 4, 21, 0)]),
        (FACE.format(way=2, last=0.5), [(0, 0, 21, 0), (-5, 0, 21, 0), (-5, 0, 3, 0), (-5, 0, 0.5, 500), (35, 0, 0.5, 300), (35, 0, 2.5, 500), (-5, 4, 2.5, 500),
                                        (-5, 4, 0.5, 500), (35, 4, 0.5, 300), (35, 4, 2, 500), (-5, 0, 2, 500), (-5, 0, 0, 500), (35, 0, 0, 200), (35, 0, 2, 500),
                                        (-5, 4, 2, 500), (-5, 4, 0, 500), (35, 4, 0, 200), (35, 4, 21, 0)]),
    ],
)  # fmt: skip
def test_motions(moves: Any, body: str, expected: list[Any]) -> None:
    assert moves(f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n") == expected


HERE = (
    FACE.replace("232", "233")
    .replace(" Q225=+0 ~\n Q226=+0 ~\n", "")
    .replace("Q389", "Q350={along} ~\n{place} Q389")
)


@pytest.mark.parametrize(
    ("way", "along", "place", "rows"),
    [
        # From the corner (10, 20): rows at 20 and 24, which end 4 + 1 beyond the face or at its edge.
        (0, 1, "", [(5, 20), (45, 20), (45, 24), (5, 24)]),
        (1, 1, " Q367=1 ~\n", [(10, 20), (40, 20), (40, 24), (10, 24)]),
        (3, 1, "", [(10, 20), (40, 20), (10, 24), (40, 24)]),
        # About the middle (10, 20), rows along Y: 30 wide, 8 rows of 3.75.
        (1, 2, " Q367=0 ~\n", [(x, y) for k in range(8) for x, y in [(-5 + 3.75 * (k + 1) - 4, 16), (-5 + 3.75 * (k + 1) - 4, 24)][:: 1 - 2 * (k % 2)]]),
        # From the upper right corner.
        (1, 1, " Q367=3 ~\n", [(-20, 12), (10, 12), (10, 16), (-20, 16)]),
    ],
)  # fmt: skip
def test_a_face_from_the_tools_place(moves: Any, way: int, along: int, place: str, rows: list[Any]) -> None:
    body = HERE.format(way=way, along=along, place=place, last=0)
    found = moves(f"{PLAIN}L X+10 Y+20 FMAX\n{body}\nCYCL CALL\n9 END PGM T MM\n")
    cut = [move[:2] for move in found[1:] if move[2] == 0.0]
    assert list(dict.fromkeys(cut)) == [pytest.approx(row) for row in rows]


def test_walls_of_a_face_are_not_read(run: Any) -> None:
    body = HERE.format(way=0, along=1, place=" Q347=+1 ~\n", last=0)
    assert run(f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n").errors[0][0] == "unsupported-block"


def test_levels_of_a_stud(moves: Any) -> None:
    """Q202 is the infeed per cut: a depth of 12 in infeeds of 5 ends in one of 2."""
    found = moves(f"{PLAIN}{CIRCLE.format(depth=12, blank=20)}\nCYCL CALL\n9 END PGM T MM\n")
    assert [z for _, _, z, feed in found if feed == 100] == [-5, -10, -12]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        (RECTANGLE.format(depth=3, turn=0).replace("Q424=+48", "Q424=+39").replace("Q425=+28", "Q425=+19"), "cycle-words"),
        (RECTANGLE.format(depth=3, turn=0).replace("Q367=+0", "Q367=+5"), "cycle-words"),
        (RECTANGLE.format(depth=3, turn=0) + " ~\n Q437=+5", "cycle-words"),
        (RECTANGLE.format(depth=3, turn=0).replace("Q220=+0", "Q220=-3"), "unsupported-block"),
        (RECTANGLE.format(depth=-3, turn=0), "cycle-depth"),
        (CIRCLE.format(depth=3, blank=36).replace("Q207=+300", "Q207=+0"), "feed-missing"),
        (RULED.format(count=1), "cycle-infeed"),
        (FACE.format(way=3, last=0), "cycle-words"),
        (FACE.format(way=0, last=0).replace("Q386=+0", "Q386=+2"), "cycle-words"),
    ],
)  # fmt: skip
def test_wrong_ones(run: Any, tmp_path: Path, body: str, code: str) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    text = f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n"
    assert run(text, tool_table=table).errors[0][:2] == (code, len(text.splitlines()) - 1)


def test_a_tool_without_a_radius(run: Any, tmp_path: Path) -> None:
    """A table without the tool's diameter is an error; without a table the tool is taken as 10 mm wide, so loops at 20 and 15."""
    text = f"{PLAIN}{CIRCLE.format(depth=3, blank=40)}\nCYCL CALL\n9 END PGM T MM\n"
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1\n")
    assert run(text, tool_table=table).errors[0][0] == "cycle-tool"
    out = run(text)
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["tool-assumed"]
    cut = out.path.end[(out.path.kind < 3) & (out.path.end[:, 2] < -2.9)]
    assert sorted({round(float(x), 6) for x in cut[:, 0] if x > 1}) == [15.0, 20.0, 27.0]


def test_a_slot_without_a_table_is_milled_by_a_narrower_tool(run: Any) -> None:
    """A slot 6 wide and 30 long by a tool of 4.8: one loop, 0.6 beside the middle line and 12.6 to its ends."""
    slot = (
        "CYCL DEF 253 SLOT ~\n Q215=0 ~\n Q218=30 ~\n Q219=6 ~\n Q374=0 ~\n Q367=0 ~\n Q207=300 ~\n Q351=1 ~\n"
        " Q201=-3 ~\n Q202=3 ~\n Q206=100 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20"
    )
    out = run(f"{PLAIN}{slot}\nCYCL CALL\n9 END PGM T MM\n")
    assert out.errors == []
    cut = out.path.end[(out.path.kind < 3) & (out.path.end[:, 2] < -2.9)]
    assert (cut[:, 0].max(), cut[:, 1].max()) == pytest.approx((12.6, 0.6))


def test_a_ruled_surface(moves: Any) -> None:
    """Lines 1-2, half-way and 4-3, the first at half the feed; back over them higher by the diameter 8, at the end over Z26."""
    text = f"{PLAIN}{RULED.format(count=3)}\nCYCL CALL\n9 END PGM T MM\n"
    assert moves(text) == [
        (0, 5, -2, 0), (100, 15, 5, 150), (100, 15, 13, 0), (0, 5, 6, 0), (0, 5, -2, 0),
        (7.5, 65, 12, 300), (95, 70, 15, 300), (95, 70, 23, 0), (7.5, 65, 20, 0), (7.5, 65, 12, 0),
        (15, 125, 26, 300), (90, 125, 25, 300), (90, 125, 33, 0), (90, 125, 34, 0),
    ]  # fmt: skip


POCKET = "CYCL DEF 251 POCKET ~\n Q215=0 ~\n Q218=40 ~\n Q219=20 ~\n Q220=5 ~\n Q224={turn} ~\n Q367={place} ~\n Q207=300 ~\n Q351=1 ~\n Q201=-3 ~\n Q202=5 ~\n Q206=100 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q370=1"
GROOVE = POCKET.replace("251", "253").replace("Q224", "Q374").replace("Q219=20", "Q219=12")
STUD = RECTANGLE.format(depth=3, turn="{turn}").replace("Q367=+0", "Q367={place}")


@pytest.mark.parametrize(
    ("cycle", "place", "way"),
    [
        # The tool is in the middle, or at a corner from the lower left one on.
        *[(cycle, k, way) for cycle in (POCKET, STUD) for k, way in enumerate((0j, -20 - 10j, 20 - 10j, 20 + 10j, -20 + 10j))],
        # At the left end, in the left circle, in the right one, at the right end: half of 40, less half of 12.
        *[(GROOVE, k, way) for k, way in enumerate((0j, -20 + 0j, -14 + 0j, 14 + 0j, 20 + 0j))],
    ],
)  # fmt: skip
@pytest.mark.parametrize("turn", [0, 90])
def test_places_of_the_tool(moves: Any, cycle: str, place: int, way: complex, turn: int) -> None:
    """Q367 names where the tool stands, about which the rectangle or slot is turned; it is the one about a middle that lies elsewhere."""
    text = "{}L X{} Y{} FMAX M99\n9 END PGM T MM\n"
    middle = 50 + 40j - way * (1j if turn else 1)
    there = moves(text.format(PLAIN + cycle.format(turn=turn, place=place) + "\n", 50, 40))
    usual = moves(text.format(PLAIN + cycle.format(turn=turn, place=0) + "\n", middle.real, middle.imag))
    cuts = [move for move in there if move[3]]
    assert cuts == [move for move in usual if move[3]]
    assert there[-1][:2] == (50, 40)


POLYGON = (
    "CYCL DEF 258 STUD ~\n Q573={around} ~\n Q571={size} ~\n Q222=+20 ~\n Q572=+4 ~\n Q224=+45 ~\n Q220={corner} ~\n Q215={mode} ~\n "
    "Q385=+200 ~\n Q338=+0 ~\n Q369=+0 ~\n " + COMMON.format(depth=3).replace("Q368=+0", "Q368={left}")
)


def _square(off: float, corner: float = 0.0) -> list[tuple[float, float]]:
    """Return the way around a square of 20 at a distance, clockwise from the middle of the corner at 45 degrees."""
    flat, side = 10 - corner, 10 + off
    begin = flat + (corner + off) / 2**0.5
    ends = [(side, flat), (side, -flat), (flat, -side), (-flat, -side), (-side, -flat), (-side, flat), (-flat, side), (flat, side)]  # fmt: skip
    return [(begin, begin), *ends, (begin, begin)]


@pytest.mark.parametrize(
    ("given", "loops"),
    [
        ({}, [(300, _square(4))]),
        # The same square within a circle of 20 sqrt 2.
        ({"around": 1, "size": 20 * 2**0.5}, [(300, _square(4))]),
        # Corners rounded by 2 have their middles 8 from both sides, and arcs of 6.
        ({"corner": 2}, [(300, _square(4, 2))]),
        # 1 stays on the wall, and is taken at Q385 (all), or stays (roughing), or is taken alone (finishing).
        ({"left": 1}, [(300, _square(5)), (200, _square(4))]),
        ({"left": 1, "mode": 1}, [(300, _square(5))]),
        ({"left": 1, "mode": 2}, [(200, _square(4))]),
    ],
)
def test_a_stud_of_four_sides(moves: Any, given: dict[str, float], loops: list[Any]) -> None:
    """The tool comes along the diagonal from 2 mm beside what sticks out farthest, the blank's circle of 20 or the corner."""
    corner = given.get("corner", 0)
    values = {"around": 0, "size": 20, "corner": 0, "mode": 0, "left": 0, **given}
    found = moves(f"{PLAIN}{POLYGON.format(**values)}\nCYCL CALL\n9 END PGM T MM\n")
    beside = (max(10.0, (10 - corner) * 2**0.5 + corner) + 4 + 2) / 2**0.5
    expected = [(beside, beside, 0, 0), (beside, beside, 2, 0)]
    for feed, loop in loops:
        expected += [(beside, beside, -3, 100), *[(x, y, -3, feed) for x, y in loop]]
        expected += [(beside, beside, -3, feed), (beside, beside, 2, 0)]
    expected += [(beside, beside, 20, 0), (0, 0, 20, 0)]
    assert found == [pytest.approx(move, abs=1e-6) for move in expected]


def test_loops_of_a_polygon_come_in_from_the_blank(moves: Any) -> None:
    """A hexagon about a circle of 20 out of 36: 8 aside are two loops of 4, whose flats are 18 and 14 from the middle; up-cut goes left first."""
    values = {"around": 0, "size": 20, "corner": 0, "mode": 0, "left": 0}
    body = POLYGON.format(**values).replace("Q222=+20", "Q222=+36").replace("Q572=+4", "Q572=+6")
    found = moves(
        f"{PLAIN}{body.replace('Q224=+45', 'Q224=+0').replace('Q351=+1', 'Q351=-1')}\nCYCL CALL\n9 END PGM T MM\n"
    )
    flats = sorted({abs(y) for x, y, z, feed in found if feed == 300 and abs(x) < 8})
    assert flats == pytest.approx([14, 18])
    first = [move[1] for move in found if move[3] == 300][1]
    assert first > 0.0


@pytest.mark.parametrize(
    ("word", "code"),
    [
        ("Q572=+2", "cycle-words"),
        ("Q573=+2", "cycle-words"),
        ("Q215=+3", "cycle-words"),
        ("Q220=-1", "unsupported-block"),
        ("Q220=+10", "cycle-words"),
        ("Q222=+19", "cycle-words"),
        ("Q207=+0", "feed-missing"),
    ],
)
def test_wrong_studs_of_several_sides(run: Any, tmp_path: Path, word: str, code: str) -> None:
    body = POLYGON.format(around=0, size=20, corner=0, mode=0, left=0)
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    out = run(f"{PLAIN}{body} ~\n {word}\nCYCL CALL\n9 END PGM T MM\n", tool_table=table)
    assert out.errors[0][0] == code
