"""Slots, pockets in parts, back boring, single-lip drilling and patterns of Heidenhain: motions worked out by hand; tool 1 has the radius 4."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind

Run = Callable[..., Any]

PLAIN = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000 F350\n"
#: The rest of a cycle in parts: a slot or pocket 4 deep.
PARTS = "CYCL DEF {n}.1 SET UP 2\nCYCL DEF {n}.2 DEPTH -4\nCYCL DEF {n}.3 PECKG 4 F80\n"
OLD = "L Z+2 FMAX\nCYCL DEF {n}.0 MILLING\n" + PARTS
HEIGHTS = "Q200=+2 ~\n Q203=+0 ~\n Q204=+20"
BOW = (
    "CYCL DEF 254 CIRCULAR SLOT ~\n Q215=+0 ~\n Q219=+{width} ~\n Q375=+40 ~\n Q367=+0 ~\n Q216=+0 ~\n Q217=+0 ~\n Q376=+0 ~\n Q248=+90 ~\n"
    " Q378=+180 ~\n Q377=+{count} ~\n Q207=+500 ~\n Q351=+{sense} ~\n Q201=-4 ~\n Q202=+5 ~\n Q206=+150 ~\n "
    + HEIGHTS
)
BORE = "CYCL DEF 204 BACK BORING ~\n Q249=+5 ~\n Q250=+20 ~\n Q251=+3.5 ~\n Q252=+15 ~\n Q253=+750 ~\n Q254=+200 ~\n Q255=+0 ~\n Q214=+1 ~\n "
DEEP = "CYCL DEF 241 DEEP DRILLING ~\n Q201=-80 ~\n Q206=+150 ~\n Q379=+30 ~\n Q253=+750 ~\n Q208=+900 ~\n Q426=+3 ~\n Q427=+50 ~\n Q428=+500 ~\n "
CENTRE = "CYCL DEF 240 CENTERING ~\n Q343=+0 ~\n Q201=-1 ~\n Q206=+100 ~\n Q211=+0 ~\n " + HEIGHTS


def _hole(x: float, y: float, surface: float = 0.0) -> list[Any]:
    return [(x, y, surface + z, feed) for z, feed in ((2, 0), (-1, 100), (2, 0), (20, 0))]


def _pocket(loop: list[tuple[float, float]], first: tuple[float, float]) -> list[Any]:
    """Return a cycle in parts: 4 deep at 80, around at 100, and back to where the tool was."""
    down = [(*first, 2, 0)] if first != (0, 0) else []
    back = [(0, 0, 2, 0)] if first != (0, 0) else []
    return [(0, 0, 2, 0), *down, (*first, -4, 80), *[(x, y, -4, 100) for x, y in loop], (*first, 2, 0), *back]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # 20 by 12 less the tool's radius of 4 all around.
        (OLD.format(n=4) + "CYCL DEF 4.4 X20\nCYCL DEF 4.5 Y12\nCYCL DEF 4.6 F100 DR+ RADIUS 4\nCYCL CALL",
         _pocket([(6, -2), (6, 2), (-6, 2), (-6, -2), (0, -2)], (0, -2))),
        (OLD.format(n=4) + "CYCL DEF 4.4 X20\nCYCL DEF 4.5 Y12\nCYCL DEF 4.6 F100 DR-\nCYCL CALL",
         _pocket([(-6, -2), (-6, 2), (6, 2), (6, -2), (0, -2)], (0, -2))),
        (OLD.format(n=5) + "CYCL DEF 5.4 RADIUS 8\nCYCL DEF 5.5 F100 DR+\nCYCL CALL",
         _pocket([(0, -4), (4, 0), (0, 4), (-4, 0), (0, -4), (0, 0)], (0, 0))),
        # A slot as wide as the tool from where it stands: 20 long, so 12 on, its middle 6 on.
        (OLD.format(n=3) + "CYCL DEF 3.4 X20\nCYCL DEF 3.5 Y8\nCYCL DEF 3.6 F100\nCYCL CALL", _pocket([(12, 0), (0, 0), (6, 0)], (6, 0))),
        (OLD.format(n=3) + "CYCL DEF 3.4 Y-20\nCYCL DEF 3.5 X8\nCYCL DEF 3.6 F100\nCYCL CALL", _pocket([(0, 0), (0, -12), (0, -6)], (0, -6))),
        # Two slots as wide as the tool on a circle of radius 20, from 0 to 90 and from 180 to 270 degrees.
        (BOW.format(width=8, count=2, sense=1) + "\nCYCL CALL",
         [(0, 0, 2, 0), (20, 0, 2, 0), (20, 0, -4, 150), (0, 20, -4, 500), (20, 0, -4, 500), (20, 0, 2, 0), (20, 0, 20, 0), (-20, 0, 20, 0), (-20, 0, 2, 0),
          (-20, 0, -4, 150), (0, -20, -4, 500), (-20, 0, -4, 500), (-20, 0, 2, 0), (-20, 0, 20, 0)]),
        # 12 wide: 2 beside the middle line, out along the greater radius, around the end, back along the smaller.
        (BOW.format(width=12, count=1, sense=1) + "\nCYCL CALL",
         [(0, 0, 2, 0), (20, 0, 2, 0), (20, 0, -4, 150), *[(x, y, -4, 500) for x, y in ((22, 0), (0, 22), (0, 18), (18, 0), (22, 0), (20, 0))],
          (20, 0, 2, 0), (20, 0, 20, 0)]),
        (BOW.format(width=12, count=1, sense=-1) + "\nCYCL CALL",
         [(0, 0, 2, 0), (20, 0, 2, 0), (20, 0, -4, 150), *[(x, y, -4, 500) for x, y in ((18, 0), (0, 18), (0, 22), (22, 0), (18, 0), (20, 0))],
          (20, 0, 2, 0), (20, 0, 20, 0)]),
        # 204: the tip 15 under the tooth, which waits 2 under a part of 20 and cuts 5 up into it, beside the hole by 3.5 on its ways.
        (BORE + HEIGHTS + "\nCYCL CALL",
         [(0, 0, 2, 0), (-3.5, 0, 2, 0), (-3.5, 0, -37, 750), (0, 0, -37, 0), (0, 0, -30, 200), (0, 0, -37, 750), (-3.5, 0, -37, 0), (-3.5, 0, 2, 750), (0, 0, 2, 0),
          (0, 0, 20, 0)]),
        (DEEP + HEIGHTS + "\nCYCL CALL", [(0, 0, 2, 0), (0, 0, -28, 750), (0, 0, -80, 150), (0, 0, 2, 900), (0, 0, 20, 0)]),
        # Q435: the hole waits 70 below the surface, and goes on at half the feed.
        (DEEP + HEIGHTS + " ~\n Q211=+0.5 ~\n Q435=+70 ~\n Q401=+50\nCYCL CALL",
         [(0, 0, 2, 0), (0, 0, -28, 750), (0, 0, -70, 150), (0, 0, -80, 75), (0, 0, 2, 900), (0, 0, 20, 0)]),
        # Patterns: a point, a row turned by 90 degrees whose surface is 1 higher, half a circle, a grid to and fro.
        (f"PATTERN DEF POS1 (X+10 Y+5 Z+0) ~\n ROW1 (X+0 Y+0 D+4 NUM2 ROT+90 Z+1)\n{CENTRE}\nCYCL CALL PAT FMAX M3",
         [p for x, y, z in ((10, 5, 0), (0, 0, 1), (0, 4, 1)) for p in [*([(10, 5, 0, 0)] if y == 5 else [(x, y, 20 + z * (y == 4), 0)]), *_hole(x, y, z)]]),
        (f"PATTERN DEF PITCHCIRC1 (X+0 Y+0 D20 START+0 STEP90 NUM2 Z+0)\n{CENTRE}\nCYCL CALL PAT F400",
         [(10, 0, 0, 400), *_hole(10, 0), (0, 10, 20, 400), *_hole(0, 10)]),
        (f"PATTERN DEF FRAME1 (X+0 Y+0 DX+1 DY+2 NUMX3 NUMY3 ROT+0 Z+0)\n{CENTRE}\nCYCL CALL PAT FMAX",
         [p for k, (x, y) in enumerate(((0, 0), (1, 0), (2, 0), (2, 2), (0, 2), (0, 4), (1, 4), (2, 4))) for p in [*([(x, y, 20, 0)] if k else []), *_hole(x, y)]]),
    ],
)  # fmt: skip
def test_motions(moves: Any, body: str, expected: list[Any]) -> None:
    assert moves(f"{PLAIN}{body}\n9 END PGM T MM\n") == expected


@pytest.mark.parametrize(
    ("body", "code"),
    [
        (OLD.format(n=4) + "CYCL DEF 4.4 X20\nCYCL DEF 4.6 F100 DR+\nCYCL CALL", "cycle-words"),
        (OLD.format(n=5) + "CYCL DEF 5.4 RADIUS 3\nCYCL DEF 5.5 F100 DR+\nCYCL CALL", "cycle-tool"),
        (BOW.format(width=6, count=1, sense=1) + "\nCYCL CALL", "cycle-tool"),
        (BOW.format(width=8, count=1, sense=1).replace("Q367=+0", "Q367=+4") + "\nCYCL CALL", "cycle-words"),
        (BOW.format(width=8, count=1, sense=1).replace("Q207=+500", "Q207=+0") + "\nCYCL CALL", "feed-missing"),
        (DEEP + HEIGHTS + " ~\n Q435=+90\nCYCL CALL", "cycle-words"),
        (BORE.replace("Q214=+1", "Q214=+0") + HEIGHTS + "\nCYCL CALL", "cycle-words"),
        (f"{CENTRE}\nCYCL CALL PAT", "cycle-missing"),
        ("PATTERN DEF POS1 (X+10)", "cycle-words"),
        ("PATTERN DEF ROW1 (X+0 Y+0 D+4 NUM0)", "cycle-repeats"),
        ("PATTERN DEF POS1 (X+10 Y+5 Q1)", "unsupported-block"),
        ("PATTERN DEF STAR1 (X+10 Y+5)", "syntax"),
    ],
)  # fmt: skip
def test_wrong_ones(run: Any, tmp_path: Path, body: str, code: str) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    out = run(f"{PLAIN}{body}\n9 END PGM T MM\n", tool_table=table)
    assert out.errors[0][0] == code
    assert next(d for d in out.diagnostics if d.severity == "error").hint


@pytest.mark.parametrize(("where", "part"), [(1, 1.0), (2, 0.5), (3, 0.0)])
def test_a_bow_about_the_tool_is_that_about_its_centre(moves: Any, where: int, part: float) -> None:
    """Q367 = 2: the tool in the middle of the slot, at the angle Q376. (30, 0) at 0 degrees of a circle of radius 30 about 0, over 90
    degrees, is the slot from -45 degrees on. 1 and 3: in its left and right end, as seen from the middle outwards, which no text says."""
    about = BOW.format(width=12, count=2, sense=1)
    values = dict(
        word.split("=") for word in about.replace("~", " ").split() if word.startswith("Q") and "=" in word
    )
    angle = part * float(values["Q248"])
    radius, start = float(values["Q375"]) / 2.0, math.radians(float(values["Q376"]) + angle)
    centre = complex(float(values["Q216"]), float(values["Q217"]))
    place = centre + radius * complex(math.cos(start), math.sin(start))
    by_tool = about.replace(f"Q376={values['Q376']}", f"Q376={math.degrees(start):+.9f}").replace(
        "Q367=+0", f"Q367=+{where}"
    )
    by_tool = by_tool.replace(f"Q216={values['Q216']}", "Q216=+999")
    head = f"{PLAIN}L X{place.real:+.9f} Y{place.imag:+.9f} FMAX\n"
    wanted, found = (moves(f"{head}{body}\nCYCL CALL\n9 END PGM T MM\n") for body in (about, by_tool))
    assert found == [pytest.approx(move, abs=1e-5) for move in wanted]


def test_a_deepened_start(moves: Any) -> None:
    """205 with Q379 = 10, Q200 = 2: at Q253 to a fifth of Q379, at most Q200, above the start, then infeeds of 5 from -10 on, out to the
    set-up clearance as ever (TNC 640, "Position behavior when working with Q379")."""
    body = (
        "CYCL DEF 205 PECK ~\n Q200=2 ~\n Q201=-20 ~\n Q206=100 ~\n Q202=5 ~\n Q203=0 ~\n Q204=20 ~\n Q212=0 ~\n Q205=0 ~\n Q258=0.5 ~\n"
        " Q259=0.5 ~\n Q257=0 ~\n Q256=0 ~\n Q211=0 ~\n Q379={start} ~\n Q253=700"
    )
    found = moves(f"{PLAIN}{body.format(start=10)}\nCYCL CALL\n9 END PGM T MM\n")
    assert found == [
        (0, 0, 2, 0),
        (0, 0, -8, 700),
        (0, 0, -15, 100),
        (0, 0, 2, 0),
        (0, 0, -14.5, 0),
        (0, 0, -20, 100),
        (0, 0, 20, 0),
    ]
    assert moves(f"{PLAIN}{body.format(start=5)}\nCYCL CALL\n9 END PGM T MM\n")[1] == (0, 0, -4, 700)


def test_a_depth_by_the_diameter_is_told(run: Any, tmp_path: Path) -> None:
    """240 with Q343 = 1: a point of 90 degrees is 6 wide at the depth 3."""
    (tmp_path / "t.tbl").write_text("T1 P1 D8\n")
    body = "CYCL DEF 240 CENTERING ~\n Q200=2 ~\n Q343=1 ~\n Q201=0 ~\n Q344=-6 ~\n Q206=100 ~\n Q211=0 ~\n Q203=0 ~\n Q204=20"
    out = run(f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n", tool_table=tmp_path / "t.tbl")
    assert out.errors == []
    assert out.path.end[out.path.kind < 3][:, 2].min() == pytest.approx(-3)
    (said,) = [d for d in out.diagnostics if d.severity == "warning"]
    assert said.code == "tool-assumed"
    assert "depth 3" in said.message


@pytest.mark.parametrize("floor", [0, 1])
def test_levels_of_a_pocket(moves: Any, floor: int) -> None:
    """Q202 is the infeed per cut, the last one what is left (iTNC 530, cycle 251); roughing alone leaves Q369."""
    body = f"CYCL DEF 252 POCKET ~\n Q215={floor} ~\n Q223=30 ~\n Q368=0 ~\n Q207=500 ~\n Q351=1 ~\n Q201=-12 ~\n Q202=5 ~\n Q369={floor} ~\n Q206=100 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q370=1\n"
    found = moves(f"0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000\n{body}CYCL CALL\n9 END PGM T MM\n")
    assert [z for _, _, z, feed in found if feed == 100] == [-5, -10, -12 + floor]


FINISH = (
    "CYCL DEF {cycle} ~\n Q215={kind} ~\n Q368={side} ~\n Q369={floor} ~\n Q207=300 ~\n Q385=250 ~\n Q351={climb} ~\n Q201=-3 ~\n Q202=5 ~\n"
    " Q338=2 ~\n Q206=100 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q370=1 ~\n"
)
POCKET = FINISH.replace("{cycle}", "251 POCKET") + " Q218=40 ~\n Q219=20 ~\n Q220=5 ~\n Q224=0 ~\n Q367=0"
ARC = FINISH.replace("{cycle}", "254 SLOT") + " Q219=12 ~\n Q375=80 ~\n Q367=0 ~\n Q216=0 ~\n Q217=0 ~\n Q376=0 ~\n Q248=90 ~\n Q378=0 ~\n Q377=1"  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "side", "floor", "downs"),
    [
        (0, 0, 0, [(-3, 300)]),
        # Roughed to 0.2 above the floor; the wall in infeeds of 2, then the floor, at Q385.
        (0, 0.5, 0.2, [(-2.8, 300), (-2, 250), (-3, 250), (-3, 250)]),
        (0, 0.5, 0, [(-3, 300), (-2, 250), (-3, 250)]),
        (1, 0.5, 0.2, [(-2.8, 300)]),
        (2, 0.5, 0, [(-2, 250), (-3, 250)]),
        (2, 0, 0.2, [(-3, 250)]),
    ],
)
@pytest.mark.parametrize("cycle", [POCKET, ARC])
def test_roughing_and_finishing(
    moves: Any, cycle: str, kind: int, side: float, floor: float, downs: list[Any]
) -> None:
    """Q215: 0 both, 1 rough, 2 finish, what has an allowance (iTNC 530, cycle 251)."""
    body = cycle.format(kind=kind, side=side, floor=floor, climb=1)
    found = moves(f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n")
    assert [(z, found[k + 1][3]) for k, (_, _, z, feed) in enumerate(found) if feed == 100] == downs
    far = max(x for x, _, _, feed in found if feed in (300, 250))
    wall = 16 if cycle == POCKET else 42
    assert far == pytest.approx(wall - (side if kind == 1 else 0))


@pytest.mark.parametrize(("climb", "side"), [(1, 1), (-1, -1)])
def test_the_way_round_a_wall(moves: Any, climb: int, side: int) -> None:
    """Climb milling goes counter-clockwise; on and off it goes half a circle, from 0.5 and the radius of the tool beside the wall."""
    body = POCKET.format(kind=2, side=0.5, floor=0, climb=climb)
    found = [
        move for move in moves(f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n") if move[2] == -3 and move[3]
    ]
    around = [(15, -6), (16, -5), (16, 5), (15, 6), (-15, 6), (-16, 5), (-16, -5), (-15, -6)]
    around = [(side * x, y) for x, y in around]
    assert [move[:2] for move in found] == [(0, -1.5), (0, -6), *around, (0, -6), (0, -1.5)]


def test_finishing_without_an_allowance_is_told(run: Any, tmp_path: Path) -> None:
    (tmp_path / "t.tbl").write_text("T1 P1 D8\n")
    body = POCKET.format(kind=2, side=0, floor=0, climb=1)
    out = run(f"{PLAIN}{body}\nCYCL CALL\n9 END PGM T MM\n", tool_table=tmp_path / "t.tbl")
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["cycle-idle"]
    assert out.path.end[out.path.kind < 3][:, 2].min() >= 0


def test_infeeds_of_deep_drilling_are_told(run: Any) -> None:
    """Q202 of 241 was passed over without a word."""
    out = run(f"{PLAIN}{DEEP}{HEIGHTS} ~\n Q202=+20 ~\n Q211=+0\nCYCL CALL\n9 END PGM T MM\n")
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["cycle-peck"]


@pytest.mark.parametrize(
    ("given", "out"), [("", 0), (" ~\n Q208=+500", 500), (" ~\n Q208=+0", 100), (" ~\n Q208=MAX", 0)]
)
def test_pecking_comes_out_at_q208(moves: Any, given: str, out: float) -> None:
    """ "Retraction feed rate": 0 is Q206; it was passed over, and the way out of the finished hole made at full speed."""
    cycle = "CYCL DEF 205 PECK ~\n Q201=-8 ~\n Q206=+100 ~\n Q202=+9 ~\n Q258=+1 ~\n " + HEIGHTS
    found = moves(f"{PLAIN}{cycle}{given}\nCYCL CALL\n9 END PGM T MM\n")
    assert found[:2] == [(0, 0, 2, 0), (0, 0, -8, 100)]
    assert found[2:] == ([(0, 0, 2, out)] if out else []) + [(0, 0, 20, 0)]


TROCHOIDS = (
    "TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL 1\nCYCL DEF 275 TROCHOIDAL SLOT ~\n Q215={q215} ~\n Q219={q219} ~\n"
    " Q368={q368} ~\n Q436={q436} ~\n Q207=400 ~\n Q351={q351} ~\n Q201=-4 ~\n Q202=3 ~\n Q206=100 ~\n Q338=0 ~\n Q385=250 ~\n Q200=2 ~\n Q203=+0 ~\n"
    " Q204=50 ~\n Q366=0 ~\n Q369={q369} ~\n Q439=0\nL X+0 Y+0 Z+60 R0 FMAX M3\nCYCL CALL\n"
)
#: A line of 20, a quarter of a circle of radius 12 to the left, and a line of 10.
BENT = "LBL 1\nL X+10 Y+10\nL X+30\nCR X+42 Y+22 R+12 DR+\nL Y+32\nLBL 0"


def trochoids(run: Run, table: Path, contour: str = BENT, **changed: float) -> Any:
    """Return the outcome of cycle 275 with a tool 4 wide."""
    values = {"q215": 0, "q219": 12, "q368": 0, "q436": 2, "q351": 1, "q369": 0, **changed}
    text = f"0 BEGIN PGM A MM\n{TROCHOIDS.format(**values)}M30\n{contour}\nEND PGM A MM\n"
    return run(text, dialect="heidenhain", tool_table=table)


def from_bent(places: np.ndarray) -> np.ndarray:
    """Return how far places are from the path of BENT."""
    first = np.abs(places - (np.clip(places.real, 10, 30) + 10j))
    last = np.abs(places - (42 + 1j * np.clip(places.imag, 22, 32)))
    spoke = places - (30 + 22j)
    on_arc = (spoke.real >= 0) & (spoke.imag <= 0)
    return np.minimum(np.minimum(first, last), np.where(on_arc, np.abs(np.abs(spoke) - 12), np.inf))


def below(out: Any, level: float) -> np.ndarray:
    """Return places of the tool's middle, close to each other, on the moves at a level."""
    path, begins = out.path, out.path.path.row_s
    found = []
    for row in np.flatnonzero(path.kind != Kind.EVENT):
        s = np.linspace(begins[row], begins[row + 1], 2 + int((begins[row + 1] - begins[row]) / 0.05))
        points = path.path.evaluate(s)[0]
        found.append(points[np.abs(points[:, 2] - level) < 1e-9])
    points = np.concatenate(found)
    return points[:, 0] + 1j * points[:, 1]


@pytest.fixture
def four(tmp_path: Path) -> Path:
    table = tmp_path / "four.tbl"
    table.write_text("T1 P1 Z0 D4\n")
    return table


@pytest.mark.parametrize(("q436", "q351"), [(2, 1), (4, 1), (4, -1), (0.7, -1)])
def test_a_slot_in_trochoids_is_cut_as_wide_as_it_says(
    run: Run, four: Path, q436: float, q351: float
) -> None:
    """275: nothing within 6 of the path is left, and the middle of the tool goes no farther from it than 6 - 2, at each level."""
    out = trochoids(run, four, q436=q436, q351=q351)
    assert out.errors == []
    x, y = np.meshgrid(np.arange(2, 51, 0.5), np.arange(2, 41, 0.5))
    wanted = (x + 1j * y)[from_bent(x + 1j * y) <= 6.0]
    for level in (-3.0, -4.0):
        places = below(out, level)
        assert from_bent(places).max() < 4.0 + 1e-6
        assert max(float(np.abs(places - w).min()) for w in wanted) < 2.0 + 0.03
    # Infeeds of Q202 and the rest, the set-up clearance between; Q204 at the end.
    ends = out.path.end[out.path.kind != Kind.EVENT, 2]
    assert sorted(set(ends.round(9))) == [-4, -3, 2, 50, 60]
    assert ends[-1] == 50
    ways = np.diff(below(out, -4.0))
    ways = ways[np.abs(ways) > 1e-9]
    assert (np.angle(ways[1:] / ways[:-1]).sum() > 0.0) == (q351 > 0)


@pytest.mark.parametrize("q219", [4.1, 4.6, 9])
def test_a_narrow_slot_in_trochoids_keeps_to_its_bend(run: Run, four: Path, q219: float) -> None:
    """The chord of 4 in the bend of 12 is 0.17 off it, more than the middle of the tool may be in a slot of 4.1."""
    out = trochoids(run, four, q219=q219, q436=4)
    assert out.errors == []
    assert from_bent(below(out, -4.0)).max() < q219 / 2 - 2 + 1e-6


def test_a_slot_in_trochoids_around_a_corner(run: Run, four: Path) -> None:
    out = trochoids(run, four, "LBL 1\nL X+10 Y+10\nL X+40\nL Y+40\nLBL 0", q436=3)
    assert out.errors == []

    def away(places: np.ndarray) -> np.ndarray:
        first = np.abs(places - (np.clip(places.real, 10, 40) + 10j))
        return np.minimum(first, np.abs(places - (40 + 1j * np.clip(places.imag, 10, 40))))

    x, y = np.meshgrid(np.arange(2, 49, 0.5), np.arange(2, 49, 0.5))
    wanted, places = (x + 1j * y)[away(x + 1j * y) <= 6.0], below(out, -4.0)
    assert away(places).max() < 4.0 + 1e-6
    assert max(float(np.abs(places - w).min()) for w in wanted) < 2.0 + 0.03


def test_allowances_of_a_slot_in_trochoids(run: Run, four: Path) -> None:
    """Roughing leaves 0.5 on the walls and 0.25 on the floor; finishing takes the floor, then the walls, at Q385."""
    rough = trochoids(run, four, q215=1, q368=0.5, q369=0.25)
    assert sorted(set(rough.path.end[rough.path.kind != Kind.EVENT, 2].round(9))) == [
        -3.75,
        -3,
        2,
        50,
        60,
    ]
    assert from_bent(below(rough, -3.75)).max() == pytest.approx(3.5, abs=1e-6)
    finish = trochoids(run, four, q215=2, q368=0.5, q369=0.25)
    assert from_bent(below(finish, -4.0)).max() == pytest.approx(4.0, abs=1e-6)
    cuts = finish.path.feed_mode != FeedMode.RAPID
    assert sorted(set((finish.path.feed[cuts & (finish.path.kind != Kind.EVENT)] * 60).round(6))) == [
        100,
        250,
    ]


@pytest.mark.parametrize("wider", [0.0, 3e-9])
def test_a_slot_as_wide_as_the_tool_is_its_path(run: Run, four: Path, wider: float) -> None:
    """A width that a computation left a little greater makes no circles, from one of which to the next a chord would cut the wall of the bend."""
    out = trochoids(run, four, q219=4 + wider)
    assert out.errors == []
    assert from_bent(below(out, -4.0)).max() < 1e-8


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({"q219": 3.9}, "cycle-tool"),
        ({"q219": 5, "q368": 0.6}, "cycle-tool"),
        ({"q436": 0}, "cycle-infeed"),
        ({"q436": 4.1}, "cycle-infeed"),
        ({"q215": 3}, "cycle-words"),
        ({"contour": "LBL 1\nLBL 0"}, "cycle-missing"),
    ],
)
def test_a_slot_in_trochoids_that_cannot_be(run: Run, four: Path, changed: dict[str, Any], code: str) -> None:
    assert [found for found, *_ in trochoids(run, four, **changed).errors] == [code]


def test_meanings_from_memory_are_warned_of(run: Run, four: Path) -> None:
    out = trochoids(run, four)
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["cycle-parameters"]
