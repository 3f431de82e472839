"""Free contours, SL cycles and planes by vectors of Heidenhain's plain language, against places worked out by hand."""

from __future__ import annotations

import cmath
import math
import random
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cncgen.gcode.codes import contour_pockets
from cncgen.gcode.codes.pockets import Clearing
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.interpreter import Interpreter
from cncgen.machine.kinematics import Kinematics
from cncgen.toolpath.record import FeedMode

Run = Callable[..., Any]
DATA = "CYCL DEF 20 CONTOUR DATA ~\n Q1=-4 ~\n Q2=1 ~\n Q3=+0.5 ~\n Q4=+0 ~\n Q5=+0 ~\n Q6=2 ~\n Q7=+50 ~\n Q9=+1\n"
FEEDS = " Q10=2 ~\n Q11=100 ~\n Q12=400"
SQUARE = "LBL 1\nL X+0 Y+0 RL\nL X+20\nL Y+20\nL X+0\nL Y+0\nLBL 0"


def program(body: str, behind: str = "") -> str:
    """Return a program in mm that does some lines, subprograms behind its end."""
    return f"0 BEGIN PGM A MM\n{body}\nM30\n{behind}\nEND PGM A MM\n"


def ends(run: Run, body: str, behind: str = "", **options: Any) -> list[list[float]]:
    """Return where the motions of some lines lead in X Y Z, after asserting that all went well."""
    out = run(program(body, behind), dialect="heidenhain", **options)
    assert out.errors == []
    return (np.round(out.path.end[out.path.kind != 3, :3], 6) + 0.0).tolist()


def codes(run: Run, body: str, behind: str = "", **options: Any) -> list[str]:
    """Return the codes of the errors of some lines."""
    out = run(program(body, behind), dialect="heidenhain", **options)
    return [d.code for d in out.diagnostics if d.severity.value == "error"]


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    """Return a tool table: tool 1 is 4 mm wide."""
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 Z0 D4\n")
    return table


def test_lines_that_touch_two_circles(run: Run) -> None:
    """The first example of "FK free contour programming": from (20, 30) to (50, 75) radii 18 and 15 make a triangle 3 : 4 : 5."""
    body = "L X+2 Y+30 F250\nFC DR- R18 CLSD+ CCX+20 CCY+30\nFLT\nFCT DR- R15 CCX+50 CCY+75\nFLT\nFCT DR- R15 CCX+75 CCY+20\nFLT\nFCT DR- R18 CLSD- CCX+20 CCY+30"
    found = ends(run, body)
    assert found[1][:2] == [5.6, 40.8]
    assert found[2][:2] == [38.0, 84.0]
    # Equal radii: the line is parallel to that of the centres, 15 beside it.
    beside = 15.0 * 1j * (25 - 55j) / abs(25 - 55j)
    assert found[3][:2] == pytest.approx([50 + beside.real, 75 + beside.imag], abs=1e-6)
    assert found[4][:2] == pytest.approx([75 + beside.real, 20 + beside.imag], abs=1e-6)
    assert found[-1][:2] == [2.0, 30.0]


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("FL AN+30 LEN10 F100", [[5 * math.sqrt(3), 5]]),
        ("FL X+10 Y+0 F100\nFL IAN+90 LEN5", [[10, 0], [10, 5]]),
        ("FL AN+45 Y+3 F100", [[3, 3]]),
        ("FPOL X+10 Y+10\nFL PR+5 PA+90 F100", [[10, 15]]),
        ("FL IX+4 IY+3 F100\nFLT LEN5", [[4, 3], [8, 6]]),
        ("FL X+10 Y+0 F100\nFCT DR+ R5 CCA90", [[10, 0], [15, 5]]),
        ("FL X+10 Y+0 F100\nFCT DR+ X+20 Y+10", [[10, 0], [20, 10]]),
        ("FL X+10 Y+0 F100\nFC DR- CCX+10 CCY-5 CCA180", [[10, 0], [10, -10]]),
        # The arc between two lines square to each other begins 5 before their corner, and ends 5 behind it.
        ("FL AN+0 F100\nFCT DR+ R5\nFLT X+20 Y+20 AN+90", [[15, 0], [20, 5], [20, 20]]),
        # A line of 45 degrees meets the one through (20, 0) at (10, 10).
        ("FL AN+45 F100\nFL X+20 Y+0 AN-45", [[10, 10], [20, 0]]),
        # From the start a line touches the circle about (10, 0) of radius 6 at 8 from the start, above it in this sense.
        ("FL F100\nFCT DR- R6 CCX+10 CCY+0 CCA30", [[6.4, 4.8]]),
    ],
)  # fmt: skip
def test_elements_of_free_contours(run: Run, lines: str, expected: list[list[float]]) -> None:
    found = ends(run, lines)
    for place, want in zip(found, expected, strict=False):
        assert place[:2] == pytest.approx(want, abs=1e-6)


def test_a_free_contour_behind_an_approach(run: Run) -> None:
    """The whole example: APPR CT leads into the first element, an arc, which is an entry that FANUC alone refuses."""
    body = (
        "L X-30 Y+30 F500\nAPPR CT X+2 Y+30 CCA90 R+5 RL F250\nFC DR- R18 CLSD+ CCX+20 CCY+30\nFLT\nFCT DR- R15 CCX+50 CCY+75\nFLT\n"
        "FCT DR- R15 CCX+75 CCY+20\nFLT\nFCT DR- R18 CLSD- CCX+20 CCY+30\nDEP CT CCA90 R+5"
    )
    out = run(program(body), dialect="heidenhain")
    assert [d.code for d in out.diagnostics if d.severity.value != "note"] == []
    assert ends(run, body)[2:5] == [[2, 30, 0], [5.6, 40.8, 0], [38, 84, 0]]


def test_the_element_without_a_solution_is_named_once(run: Run) -> None:
    """The approach leads into a contour whose line cannot touch the circle: (0, 30) is not 18 from (20, 30)."""
    body = "L X-30 Y+30 F500\nAPPR CT X+0 Y+30 CCA90 R+5 RL F250\nFC DR- R18 CCX+20 CCY+30\nFLT\nFCT DR- R15 CCX+50 CCY+75"
    out = run(program(body), dialect="heidenhain")
    assert [(d.code, d.span.line) for d in out.diagnostics if d.severity.value == "error"] == [
        ("free-contour", 5)
    ]


def test_a_corner_within_a_free_contour(run: Run) -> None:
    found = ends(run, "FL X+10 Y+0 F100\nRND R2\nFL AN+90 LEN10")
    assert [p[:2] for p in found] == [[8, 0], [10, 2], [10, 10]]


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        ("FL AN+45 F100\nL X+5", "free-contour"),
        ("FL F100\nFL X+5 Y+5", "free-contour"),
        ("FL X+10 Y+0 F100\nFC R5 DR+ X+15 Y+5", "free-contour"),
        ("FL X+10 Y+0 F100\nFCT R5", "arc-sense"),
        ("FL AN+45 LEN5 F100\nFSELECT 2", "free-contour"),
        ("FSELECT 1\nFL AN+45 LEN5 F100", "free-contour"),
        ("FL X+10 AN+0 PAR3 DP5 F100", "free-contour"),
        ("FL X+10 Y+0 RX3 F100", "free-contour"),
        # Both circles of radius 5 lie within that of radius 3.
        ("FC DR+ R3 CCX+0 CCY+3 F100\nFCT DR- R5\nFCT DR+ R3 CCX+100 CCY+3", "free-contour"),
        ("FL PR+5 PA+90 F100", "pole-missing"),
        # The line leads away from the coordinate that it is to reach.
        ("FL AN+180 X+5 F100", "free-contour"),
    ],
)
def test_free_contours_that_leave_a_choice_are_refused(run: Run, lines: str, code: str) -> None:
    assert codes(run, lines)[0] == code


def numbered(body: str) -> str:
    """Return lines with numbers from 10 on."""
    return "\n".join(f"{10 + k} {line}" for k, line in enumerate(body.split("\n")))


def test_the_second_example_of_the_manual(run: Run) -> None:
    """A keyhole: a circle of radius 30 about (30, 30), one of radius 20 at 55 from there in 60 degrees, and two lines that are parallel to the
    way between them, 10 beside it. The lines meet the circles at root 800 before the first middle and root 300 before the second.
    FSELECT chooses one of 4 lines, 2 ends, 4 lines and 2 ends, as the manual has it."""
    body = (
        "L X+0 Y+30 F350\nFPOL X+30 Y+30\nFC DR- R30 CCX+30 CCY+30\nFL AN+60 PDX+30 PDY+30 D10\nFSELECT 3\nFC DR- R20 CCPR+55 CCPA+60\nFSELECT 2\n"
        "FL AN-120 PDX+30 PDY+30 D10\nFSELECT 3\nFC X+0 DR- R30 CCX+30 CCY+30\nFSELECT 2"
    )
    way = complex(0.5, math.sqrt(0.75))
    near, far = 30 + 30j + math.sqrt(800) * way, 30 + 30j + (55 - math.sqrt(300)) * way
    wanted = [near + 10j * way, far + 10j * way, far - 10j * way, near - 10j * way, 30j]
    assert [complex(*p[:2]) for p in ends(run, body)[1:]] == [pytest.approx(p, abs=1e-6) for p in wanted]
    out = run(program(body), dialect="heidenhain")
    assert [d.severity.value for d in out.diagnostics if d.code == "free-contour-choice"] == 4 * ["warning"]


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        # Words that count from a block (the manual's "relative data"): 20 from the end of 11, its direction turned by 90 degrees.
        ("L X+10 Y+10 F100\nFL X+18 Y+35\nFL IX+20 RX10 IY+5 RY11", [[10, 10], [18, 35], [30, 40]]),
        ("L X+10 Y+0 F100\nFL X+20 Y+0\nFL X+20 Y+9\nFL IAN+90 RAN11 LEN5", [[10, 0], [20, 0], [20, 9], [20, 14]]),
        ("L X+10 Y+0 F100\nFC DR+ R5 ICCX+15 RCCX10 ICCY+0 RCCY10 X+30 Y+0", "free-contour"),
        ("L X+10 Y+0 F100\nFC DR+ R5 ICCX+5 RCCX10 ICCY+0 RCCY10 X+20 Y+0", [[10, 0], [20, 0]]),
        # Parallel to block 11, 30 beside it, to X = 0.
        ("L X+0 Y+0 F100\nFL X+50 Y+0\nFL X+50 Y+30\nFL AN+180 PAR11 DP30\nFL X+0 Y+0 AN-90", [[50, 0], [50, 30], [0, 30], [0, 0]]),
        # A length and one coordinate: 3, 4, 5; FSELECT has the right one first.
        ("L X+0 Y+0 F100\nFL X+3 LEN5\nFSELECT 2\nFL AN+0 LEN1", [[3, 4], [4, 4]]),
        ("L X+0 Y+0 F100\nFL X+3 LEN5\nFL AN+0 LEN1", "free-contour"),
        # Which of both is left to the next element: the one from (3, -4) leads away from its end.
        ("L X+0 Y+0 F100\nFL X+3 LEN5\nFL X+3 Y+9 AN+90", "free-contour"),
        ("L X+0 Y+0 F100\nFL X+3 LEN5\nFL X+3 Y+0 AN+90", [[3, -4], [3, 0]]),
        # An arc of radius 5 from a line of y = 0 to (15, 5), tangentially: its middle is (20, 5) or (10, 5).
        ("L X+0 Y+0 F100\nFL AN+0\nFCT DR+ R5 X+15 Y+5\nFSELECT 2", [[10, 0], [15, 5]]),
        # A line that leaves a circle in a direction, and one that leaves it to a point.
        ("L X+0 Y+0 F100\nFC DR+ R5 CCX+0 CCY+5\nFLT AN+90 LEN7", [[5, 5], [5, 12]]),
        ("L X+0 Y+0 F100\nFC DR+ R5 CCX+0 CCY+5\nFLT X+5 Y+50", [[5, 5], [5, 50]]),
        # A chord of 6 in a circle of radius 5: the angle about the middle is 2 asin 0.6.
        ("L X+0 Y+0 F100\nFC DR+ R5 CCX+0 CCY+5 LEN6\nFSELECT 1\nFLT LEN1", [[4.8, 3.6]]),
    ],
)  # fmt: skip
def test_words_of_free_contours(run: Run, lines: str, expected: list[list[float]] | str) -> None:
    if isinstance(expected, str):
        assert codes(run, numbered(lines))[0] == expected
        return
    found = ends(run, numbered(lines))
    for place, want in zip(found, expected, strict=False):
        assert place[:2] == pytest.approx(want, abs=1e-6)


@pytest.mark.parametrize(
    "first", ["FL AN+90 LEN30", "FPOL X+10 Y+10\nL Y+30", "FPOL X+0 Y+0\nFL PR+30 PA+90"]
)
def test_a_free_contour_is_approached(run: Run, tools: Path, first: str) -> None:
    """The tool goes on 2 left of the first line, which leads along Y; a pole leads nowhere."""
    found = ends(
        run,
        f"TOOL CALL 1 Z S500\nL X-20 Y-20 R0 FMAX\nAPPR LT X+0 Y+0 LEN10 RL F100\n{first}\nDEP LN LEN5",
        tool_table=tools,
    )
    assert [p[:2] for p in found[1:]] == [[-2, -10], [-2, 0], [-2, 30], [-7, 30]]


def test_a_pocket_of_a_contour_is_roughed(run: Run, tools: Path) -> None:
    """Rows 2 apart at most and the way around stay 2.5 off the wall: the radius and the allowance."""
    body = f"TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR GEOMETRY\nCYCL DEF 14.1 CONTOUR LABEL 1\n{DATA}CYCL DEF 22 ROUGH-OUT ~\n{FEEDS}\nL Z+50 FMAX\nCYCL CALL"
    found = np.array(ends(run, body, SQUARE, tool_table=tools))
    low = found[found[:, 2] < 0.0]
    assert sorted(set(low[:, 2])) == [-4.0, -2.0]
    assert low[:, :2].min() == 2.5
    assert low[:, :2].max() == 17.5
    rows = np.unique(low[:, 1])
    assert np.diff(rows).max() <= 2.0 + 1e-9
    assert found[-1][2] == 50.0


def test_walls_are_finished_with_the_wall_to_the_right(run: Run, tools: Path) -> None:
    """Climbing, a pocket is gone around counter-clockwise and an island clockwise."""
    island = "LBL 2\nL X+8 Y+8 RL\nL Y+12\nL X+12\nL Y+8\nL X+8\nLBL 0"
    body = f"TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL 1 /2\n{DATA}CYCL DEF 24 SIDE ~\n{FEEDS} ~\n Q14=+0\nL Z+50 FMAX\nCYCL CALL"
    out = run(program(body, f"{SQUARE}\n{island}"), dialect="heidenhain", tool_table=tools)
    assert out.errors == []
    ways = out.path.end[(out.path.kind != 3) & (out.path.end[:, 2] == -4.0)][:, :2].round(6)
    outer, inner = (
        ways[(ways < 4).any(axis=1) | (ways > 16).any(axis=1)],
        ways[(ways > 4).all(axis=1) & (ways < 16).all(axis=1)],
    )
    for way, sense, reach in ((outer, 1.0, 16.0), (inner, -1.0, 8.0)):
        points = [complex(*p) for p in way]
        area = (
            sum((a.conjugate() * b).imag for a, b in zip(points, points[1:] + points[:1], strict=True)) / 2.0
        )
        assert math.copysign(1.0, area) == sense
        assert np.ptp(way, axis=0).tolist() == [reach, reach]


def test_a_contour_train_goes_to_and_fro(run: Run, tools: Path) -> None:
    body = f"TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL 1\nCYCL DEF 25 TRAIN ~\n Q1=-4 ~\n Q3=+1 ~\n Q5=+0 ~\n Q7=+50 ~\n{FEEDS} ~\n Q15=0\nCYCL CALL"
    found = ends(run, body, "LBL 1\nL X+0 Y+0 RR\nL X+30\nLBL 0", tool_table=tools)
    assert found[1:] == [[0, -3, 50], [0, -3, -2], [30, -3, -2], [30, -3, -4], [0, -3, -4], [0, -3, 50]]


def test_corners_of_a_pocket_are_rounded_by_q8(run: Run, tools: Path) -> None:
    """Q8 is the radius of the path of the tool's centre, here 2 off the walls of a square of 20: its middles are 2 + 3 off them."""
    body = "TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL 1\n" + DATA.replace(
        "Q9=+1", "Q9=+1 ~\n Q8={radius}"
    )
    body += f"CYCL DEF 24 SIDE ~\n{FEEDS} ~\n Q9=+1 ~\n Q14=+0\nCYCL CALL"
    found = ends(run, body.format(radius=3), SQUARE, tool_table=tools)
    around = [(10, 2), (15, 2), (18, 5), (18, 15), (15, 18), (5, 18), (2, 15), (2, 5), (5, 2), (10, 2)]
    assert [tuple(end[:2]) for end in found if end[2] == -4.0] == around
    sharp = run(program(body.format(radius=30), SQUARE), dialect="heidenhain", tool_table=tools)
    assert [d.code for d in sharp.diagnostics if d.severity == "warning"] == ["corner-size"]


WAYS = "CYCL DEF 270 WAYS ~\n Q390={kind} ~\n Q391={side} ~\n Q392=+5 ~\n Q393=+90 ~\n Q394=+4\n"
TRAIN = f"TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL 1\n{{ways}}CYCL DEF 25 TRAIN ~\n Q1=-2 ~\n Q3=+1 ~\n Q5=+0 ~\n Q7=+50 ~\n{FEEDS} ~\n Q15=1\nCYCL CALL"


@pytest.mark.parametrize(
    ("kind", "side", "points"),
    [
        # A tool of 4 with 1 beside the contour is 3 to its left or right; a quarter of radius 5 comes from there.
        (1, 1, [(-5, 8), (0, 3), (30, 3), (35, 8)]),
        (1, 2, [(-5, -8), (0, -3), (30, -3), (35, -8)]),
        (2, 2, [(-4, -3), (0, -3), (30, -3), (34, -3)]),
        (2, 0, [(-4, 0), (0, 0), (30, 0), (34, 0)]),
        (3, 1, [(0, 7), (0, 3), (30, 3), (30, 7)]),
        (0, 1, [(0, 3), (30, 3)]),
    ],
)
def test_ways_to_and_from_a_contour_train(
    run: Run, tools: Path, kind: int, side: int, points: list[tuple[float, float]]
) -> None:
    """The side of 270 is that of the contour, which has none then (TNC 640, user's manual for cycles, "CONTOUR TRAIN DATA")."""
    found = ends(
        run,
        TRAIN.format(ways=WAYS.format(kind=kind, side=side)),
        "LBL 1\nL X+0 Y+0\nL X+30\nLBL 0",
        tool_table=tools,
    )
    first, last = points[0], points[-1]
    assert found[1:] == [[*first, 50], *[[x, y, -2] for x, y in points], [*last, 50]]


@pytest.mark.parametrize(
    ("ways", "code"),
    [
        (WAYS.format(kind=1, side=0), "unsupported-block"),
        (WAYS.format(kind=4, side=1), "cycle-words"),
        (WAYS.format(kind=1, side=3), "cycle-words"),
        (WAYS.format(kind=1, side=1).replace("Q392=+5", "Q392=+0"), "cycle-words"),
    ],
)
def test_wrong_ways_to_a_contour_train(run: Run, tools: Path, ways: str, code: str) -> None:
    assert codes(run, TRAIN.format(ways=ways), "LBL 1\nL X+0 Y+0\nL X+30\nLBL 0", tool_table=tools) == [code]


@pytest.mark.parametrize(
    ("contours", "labels", "code"),
    [
        (SQUARE.replace("L Y+0\nLBL 0", "LBL 0"), "1", "profile-length"),
        (SQUARE.replace(" RL", ""), "1", "cycle-words"),
        (SQUARE, "1 /2", "label-missing"),
        (f"{SQUARE}\nLBL 2\nL X+10 Y+10 RL\nL X+30\nL Y+30\nL X+10\nL Y+10\nLBL 0", "1 /2", "not-read"),
        # A pocket within a pocket is none.
        (f"{SQUARE}\nLBL 2\nL X+8 Y+8 RL\nL X+12\nL Y+12\nL X+8\nL Y+8\nLBL 0", "1 /2", "not-read"),
        ("LBL 1\nL X+0 Y+0 RL\nL X+20\nL Y+3\nL X+0\nL Y+0\nLBL 0", "1", "cycle-tool"),
        # The tool goes in, and not around the island.
        (f"{SQUARE}\nLBL 2\nL X+3 Y+3 RL\nL Y+12\nL X+12\nL Y+3\nL X+3\nLBL 0", "1 /2", "cycle-tool"),
    ],
)
def test_contours_that_make_no_pocket(run: Run, tools: Path, contours: str, labels: str, code: str) -> None:
    body = f"TOOL CALL 1 Z S500\nCYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL {labels}\n{DATA}CYCL DEF 22 ROUGH ~\n{FEEDS}\nCYCL CALL"
    assert codes(run, body, contours, tool_table=tools) == [code]


def _ring(rng: random.Random) -> list[Segment]:
    count = rng.randint(3, 9)
    places = [
        cmath.rect(rng.uniform(30, 50), math.tau * (k + rng.uniform(-0.2, 0.2)) / count) for k in range(count)
    ]
    return [Segment(a, b) for a, b in zip(places, places[1:] + places[:1], strict=True)]


def _cut(contours: list[tuple[list[Segment], bool]], radius: float, step: float) -> np.ndarray:
    """Return points of the tool's way at depth."""
    places: list[complex] = []
    position = [0.0] * 9

    def feed(end: list[float]) -> None:
        a, b = complex(*position[:2]), complex(*end[:2])
        if position[2] < 0.0 and end[2] < 0.0:
            places.extend(a + (b - a) * np.linspace(0.0, 1.0, 2 + int(abs(b - a) / 0.5)))
        position[:] = end

    def arc(end: list[float], x: float, y: float, turns: int, plane: int) -> None:
        centre, spoke = complex(x, y), complex(*position[:2]) - complex(x, y)
        sweep = (cmath.phase((complex(*end[:2]) - centre) / spoke) * turns) % math.tau or math.tau
        if position[2] < 0.0:
            places.extend(
                centre
                + spoke * np.exp(1j * turns * sweep * np.linspace(0, 1, 2 + int(sweep * abs(spoke) / 0.5)))
            )
        position[:] = end

    sink = SimpleNamespace(
        set_feed_rate=lambda feed: None, straight_feed=feed, straight_traverse=feed, arc_feed=arc
    )
    ip: Any = SimpleNamespace(
        sink=sink, state=SimpleNamespace(position=[0.0, 0.0, 50.0, *[0.0] * 6], moved=False, feed_mode=94)
    )
    ip.go = partial(Interpreter.go, ip)
    how = Clearing(radius, step, (-1.0,), 2.0, 100.0, 50.0)
    contour_pockets.clear(ip, [c for c, _ in contours], radius, how, 1.0, "a pocket")
    contour_pockets.walls(ip, contour_pockets.around(contours, radius, "a pocket", climb=True), how)
    return np.array(places)


@pytest.mark.parametrize("seed", [0, 1, 3, 4, 5, 6])
def test_random_pockets_are_cleared_and_their_walls_kept(seed: int) -> None:
    """Beside dense points of the walls: no place of the tool is nearer than its radius, and what it can reach is cut."""
    rng = random.Random(seed)
    middle, size = complex(rng.uniform(-8, 8), rng.uniform(-8, 8)), rng.uniform(3, 8)
    island = [
        Segment(middle + size, middle - size, middle, 1),
        Segment(middle - size, middle + size, middle, 1),
    ]
    contours, radius = [(_ring(rng), False), (island, True)], rng.uniform(1.0, 3.0)
    contour_pockets.check(contours, "a pocket")
    way = _cut(contours, radius, radius * rng.uniform(0.5, 1.6))
    turn = np.linspace(0.0, math.pi, 300)
    walls = np.concatenate(
        [s.start + (s.end - s.start) * np.linspace(0, 1, 600) if s.centre is None else s.centre + (s.start - s.centre) * np.exp(1j * turn)
         for contour, _ in contours for s in contour]
    )  # fmt: skip
    ring = np.array([s.start for s in contours[0][0]])
    assert min(abs(place - walls).min() for place in way) > radius - 0.01
    for _ in range(60):
        place = complex(rng.uniform(-50, 50), rng.uniform(-50, 50))
        inside = (
            abs(np.angle((np.roll(ring, -1) - place) / (ring - place)).sum()) > 6.0
            and abs(place - middle) > size
        )
        if inside and abs(place - walls).min() > radius + 0.1:
            assert abs(place - way).min() < radius


def test_a_plane_by_vectors(run: Run) -> None:
    """The direction of X and the normal of a plane that is turned by 90 degrees about X: its Y is Z."""
    found = ends(run, "PLANE VECTOR BX1 BY0 BZ0 NX0 NY-1 NZ0 STAY\nL X+1 Y+2 Z+3 FMAX")
    assert found == [[1, -3, 2]]
    assert codes(run, "PLANE VECTOR BX1 BY0 BZ0 NX2 NY0 NZ0 STAY") == ["plane-points"]


def test_the_plane_of_the_manual_by_vectors(run: Run) -> None:
    """PLANE VECTOR BX0.8 BY-0.4 BZ-0.4472 NX0.2 NY0.2 NZ0.9592 (TNC 320, "The PLANE function"): X goes along B as far as N allows."""
    base, normal = np.array([0.8, -0.4, -0.4472]), np.array([0.2, 0.2, 0.9592])
    normal /= np.linalg.norm(normal)
    along = base - base @ normal * normal
    along /= np.linalg.norm(along)
    found = ends(
        run,
        "PLANE VECTOR BX0.8 BY-0.4 BZ-0.4472 NX0.2 NY0.2 NZ0.9592 STAY\nL X+10 Y+0 Z+0 FMAX\nL X+0 Z+10 FMAX",
    )
    assert found[0] == pytest.approx((10 * along).tolist(), abs=1e-5)
    assert found[1] == pytest.approx((10 * normal).tolist(), abs=1e-5)


def test_a_plane_by_the_angles_of_axes(run: Run) -> None:
    """A45 turns Z towards -Y, C90 from there to X; only the machine says which of A and B carries the other: of its table X and Y are those of the machine."""
    half = math.sqrt(0.5)
    assert ends(run, "PLANE AXIAL A+45 STAY\nL X+0 Y+0 Z+2 FMAX")[0] == pytest.approx(
        [0, -2 * half, 2 * half], abs=1e-6
    )
    assert codes(run, "PLANE AXIAL A+45 B+90 STAY") == ["plane-kind"]
    # A C on A, or an A on C, has another plane than an A that a table C carries: that it is guessed is said, where it matters.
    for words, guessed in (("A+45 C+90", True), ("A+45", False), ("C+90", False), ("A+0 C+90", False)):
        text = f"0 BEGIN PGM T MM\n1 PLANE AXIAL {words} STAY\n2 L X+1 R0 FMAX\n3 END PGM T MM"
        said = {one.code for one in run(text, dialect="heidenhain").diagnostics}
        assert ("plane-axes" in said) == guessed
    assert ends(run, "PLANE AXIAL A+45 B+0 C+90 STAY\nL X+0 Y+0 Z+2 FMAX")[0] == pytest.approx(
        [2 * half, 0, 2 * half], abs=1e-6
    )
    table = Kinematics(0, (3, 5))
    found = ends(run, "PLANE AXIAL A+45 C+90 STAY\nL X+2 Y+0 Z+0 FMAX\nL X+0 Z+2 FMAX", kinematics=table)
    assert found[0] == pytest.approx([2, 0, 0], abs=1e-6)
    assert found[1] == pytest.approx([0, 0, 2], abs=1e-6)


def test_labels_without_a_blank(run: Run) -> None:
    assert ends(run, "FN 9: IF +1 EQU +1 GOTO LBL 2\nL X+9 FMAX\nLBL2\nL X+5 FMAX") == [[5, 0, 0]]
    assert ends(run, "CALL LBL3\nCALL LBL3", "LBL3\nL IX+1 FMAX\nLBL0") == [[1, 0, 0], [2, 0, 0]]


DRILL = "TOOL DEF 1 L+0 R+4\nTOOL CALL 1 Z S1000 F100\nCYCL DEF 200 Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=9 Q211=0\n"
ELEMENTS = ["CT X+40 Y+20", "CC X+30 Y+20\nCTP PR+10 PA+0", "FL X+40 Y+20", "FCT X+40 Y+20 DR+"]


@pytest.mark.parametrize("element", ELEMENTS)
def test_tangential_and_free_elements_have_the_functions_of_lines(run: Run, element: str) -> None:
    """They lost R0, so that the tool stayed beside the contour, M99 and M89, so that holes were missing, without a word.

    Each leads to (40, 20); R0 ends compensation on the way there, as on L. M89 drills there and at the line's end.
    """
    out = run(
        program(f"{DRILL}L X+0 Y+10 Z+9 FMAX M3\nL X+11 RL F100\nL X+30\n{element} R0\nL X+60"),
        dialect="heidenhain",
    )
    # Compensation does not end on an arc by its centre.
    assert [fault[0] for fault in out.errors] == ["comp-exit"] * element.startswith("FC")
    assert out.errors or out.path.end[out.path.kind != 3, :3].round(6).tolist()[-2:] == [
        [40, 20, 9],
        [60, 20, 9],
    ]
    for function, count in (("", 0), ("M99", 1), ("M89", 2)):
        body = f"{DRILL}L X+0 Y+10 Z+9 FMAX M3\nL X+30 F100\n{element} {function}\nL X+60"
        holes = [place for place in ends(run, body) if place[2] == -5.0]
        assert holes == [[40, 20, -5], [60, 20, -5]][:count]


def test_a_free_line_traverses_by_fmax(run: Run) -> None:
    """FMAX of FL was lost: it went at the feed in force."""
    out = run(program("L X+0 Y+0 FMAX\nL X+10 F100\nFL X+10 Y+20 FMAX\nL X+0 F50"), dialect="heidenhain")
    assert out.errors == []
    rapid = out.path.feed_mode[out.path.kind == 0] == FeedMode.RAPID
    assert rapid.tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("block", "code"),
    [
        ("FL X+20 Y+20 LEN3", "free-contour"),
        ("FL X+20 Y+10\nFCT DR+ R5 CCA90 LEN2", "free-contour"),
        ("FL X+20 Y+10\nFCT X+25 Y+15 DR+ R7", "free-contour"),
        ("FPOL X+0 Y+0\nFL PR+20 PA+45 X+3", "free-contour"),
        ("FL X+20 Y+10\nFCT DR+ R5 CCA90 FMAX", "syntax"),
        ("CT X+20 Y+20 DR+", "unused-word"),
        ("CT X+20 Y+20 PR+5", "unused-word"),
        ("CT X+20 Y+20 M91", "g53-motion"),
        ("CC X+0 Y+0\nLP PR+10 PA+30 X+3", "unused-word"),
        ("CC X+0 Y+0\nCP PA+90 DR+ Y+3", "unused-word"),
        ("CC X+0 Y+0\nCTP PR+20 PA+10 IX+3", "unused-word"),
    ],
)
def test_words_that_contradict_others_are_errors(run: Run, block: str, code: str) -> None:
    """One of them was passed over without a word."""
    out = run(program(f"L X+0 Y+10 R0 FMAX\nL X+11 F100\n{block}"), dialect="heidenhain")
    assert [error[0] for error in out.errors] == [code]


def test_data_of_an_element_may_say_more_than_it_needs(run: Run) -> None:
    """A quarter of a circle of 5 about (20, 15); its chord is 7.071 on the drawing."""
    body = "L X+0 Y+10 R0 FMAX\nL X+11 F100\nFL X+20 Y+10 LEN9\nFCT X+25 Y+15 DR+ R5 LEN7.071 CCX+20 CCY+15"
    assert ends(run, body)[-1] == [25, 15, 0]


@pytest.mark.parametrize(
    ("before", "element", "end"),
    [
        ("L X+30", "FLT LEN10", [40, 10]),
        ("L X+30", "FCT R5 DR+ CCA90", [35, 15]),
        ("CC X+11 Y+20\nC X+21 Y+20 DR+", "FLT LEN10", [21, 30]),
        ("CC X+11 Y+20\nC X+21 Y+20 DR+", "FCT R5 DR- CCA90", [26, 25]),
        ("CT X+21 Y+20", "FLT LEN10", [21, 30]),
    ],
)
def test_a_free_element_goes_on_from_a_line_or_arc(
    run: Run, before: str, element: str, end: list[float]
) -> None:
    """FLT LEN10 behind a line of 19 went 190 far, without a word, and FCT was refused: the direction had the length of the motion before."""
    body = f"L X+0 Y+10 R0 FMAX\nL X+11 F100\n{before}\n{element}"
    assert ends(run, body)[-1] == pytest.approx([*end, 0])


def _leaving(way: str) -> str:
    return (
        f"TOOL DEF 1 L+0 R+4\nTOOL CALL 1 Z S1000 F100\nL X+0 Y+10 Z+5 R0 FMAX\nL X+11 RL F100\nL X+30\n{way}"
    )


def test_a_departure_may_count_from_the_contour(run: Run) -> None:
    """IX and IY of DEP LCT were passed over without a word: the tool stayed beside the last point."""
    assert ends(run, _leaving("DEP LCT IX+20 IY+20 IZ+3 R5")) == ends(
        run, _leaving("DEP LCT X+50 Y+30 Z+8 R5")
    )


@pytest.mark.parametrize(
    "way", ["DEP LT LEN5 X+3", "DEP LN LEN5 Z+9", "DEP CT CCA90 R5 LEN3", "DEP LCT X+5 IX+4 Y+3 R5"]
)
def test_words_that_a_way_from_a_contour_has_not(run: Run, way: str) -> None:
    assert [fault[0] for fault in run(program(_leaving(way)), dialect="heidenhain").errors] == [
        "approach-words"
    ]


@pytest.mark.parametrize("element", ["CT X+10 Y-20", "FLT LEN10", "FCT R5 DR+ CCA90"])
@pytest.mark.parametrize(
    "frame", ["TRANS ROTATION ROT+90", "TRANS MIRROR AXIS X", "CYCL DEF 10.0 ROT\nCYCL DEF 10.1 ROT+30"]
)
def test_no_direction_goes_over_into_turned_coordinates(run: Run, frame: str, element: str) -> None:
    """That of the coordinates before was taken for one of the new ones, without a word; a shift keeps it."""
    body = "L X+0 Y+0 R0 FMAX\nL X+10 F100\n{}\n" + element
    turned = run(program(body.format(frame)), dialect="heidenhain")
    assert [fault[0] for fault in turned.errors] == ["arc-tangent" if element[:2] == "CT" else "free-contour"]
    assert run(program(body.format("TRANS DATUM AXIS X+0")), dialect="heidenhain").errors == []
