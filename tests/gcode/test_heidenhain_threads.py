"""Threads of Heidenhain, 262 to 267: motions and feeds worked out by hand from the user's manual for cycles; tool 1 has the radius 4."""

from __future__ import annotations

from typing import Any

import pytest

PLAIN = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000 F350\n"
END = "\nCYCL CALL\n9 END PGM T MM\n"
#: M16 x 1.5, 20 deep, of the manual's examples.
SIZE = " Q335=+16 ~\n Q239={pitch} ~\n Q201=-20 ~\n Q253=+750 ~\n Q351={climb} ~\n Q200=+2 ~\n Q203=+0 ~\n Q204=+50 ~\n Q207=+500"
OUTSIDE = (
    "CYCL DEF 267 OUTSIDE THREAD MLLNG ~\n Q355={steps} ~\n Q358={front} ~\n Q359={offset} ~\n Q254=+150 ~\n"
    + SIZE
)
SUNK = (
    "CYCL DEF 263 THREAD MLLNG/CNTSNKG ~\n Q356=-20 ~\n Q357={wall} ~\n Q358={front} ~\n Q359=+3 ~\n Q254=+150 ~\n"
    + SIZE.replace("Q201=-20", "Q201=-16")
)
#: The tool's middle goes 4 inside M16, whose tooth has the feed 500: 500 4 / 8; outside it goes 12 from the middle: 500 12 / 8.
INSIDE_FEED, OUTSIDE_FEED = 250, 750


def _outside(begin: float, end: float, half: float) -> list[Any]:
    """Beside the stud, down, on, around, off again; the place is 8 + 4 + 1.5 from the middle."""
    return [
        (13.5, 0, begin - half, 750),
        (12, 0, begin, OUTSIDE_FEED),
        (12, 0, end, OUTSIDE_FEED),
        (13.5, 0, end + half, OUTSIDE_FEED),
    ]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # Climb milling around a stud is clockwise, so that a right-hand thread goes down: the last turn ends at the depth.
        (OUTSIDE.format(pitch=1.5, climb=1, steps=0, front=0, offset=0), _outside(-18.5, -20, -0.75)),
        (OUTSIDE.format(pitch=1.5, climb=-1, steps=0, front=0, offset=0), _outside(-20, -18.5, 0.75)),
        (OUTSIDE.format(pitch=-1.5, climb=1, steps=0, front=0, offset=0), _outside(-20, -18.5, 0.75)),
        # All turns in one: 20 / 1.5 are 14, which begin 1 above the surface.
        (OUTSIDE.format(pitch=1.5, climb=1, steps=1, front=0, offset=0), _outside(1, -20, -0.75)),
        # Every eighth thread: two helices, 12 apart.
        (OUTSIDE.format(pitch=1.5, climb=1, steps=8, front=0, offset=0), _outside(-6.5, -8, -0.75) + _outside(-18.5, -20, -0.75)),
        # Countersunk at the front: the tool's middle goes 13 around the middle of the stud at Q254.
        (OUTSIDE.format(pitch=1.5, climb=1, steps=0, front=-1, offset=13),
         [(13.5, 0, -1, 750), (13, 0, -1, 150), (13, 0, -1, 150), (13.5, 0, -1, 150), *_outside(-18.5, -20, -0.75)]),
    ],
)  # fmt: skip
def test_outside(moves: Any, body: str, expected: list[Any]) -> None:
    found = moves(PLAIN + body + END)
    assert found[:2] == [(0, 0, 2, 0), (13.5, 0, 2, 0)]
    assert found[2:-1] == expected
    assert found[-1] == (13.5, 0, 50, 0)


def test_outside_turns_against_the_way_to_it(calls: Any) -> None:
    """Around clockwise, half a turn on and off counter-clockwise, which makes them tangential."""
    text = PLAIN + OUTSIDE.format(pitch=1.5, climb=1, steps=0, front=0, offset=0) + END
    arcs = [call for call in calls(text) if call.startswith("ARC_FEED")]
    turns = [float(call.strip(")").split(",")[4]) for call in arcs]
    assert turns == [1, -1, 1]


HELIX = [
    (0, 0, -16.75, 750),
    (4, 0, -16, INSIDE_FEED),
    (4, 0, -14.5, INSIDE_FEED),
    (0, 0, -13.75, INSIDE_FEED),
]


@pytest.mark.parametrize(
    ("wall", "front", "expected"),
    [
        # Countersunk: to 2 above the depth at Q253, down at Q254; then one turn upwards.
        (0, 0, [(0, 0, -18, 750), (0, 0, -20, 150), *HELIX]),
        # The hole's wall is 0.2 from the tooth: down at Q253, around 0.2 beside the middle.
        (0.2, 0, [(0, 0, -20, 750), (0.2, 0, -20, 150), (0.2, 0, -20, 150), (0, 0, -20, 150), *HELIX]),
        (0, -1, [(0, 0, -18, 750), (0, 0, -20, 150), (0, 0, -1, 750), (3, 0, -1, 150), (3, 0, -1, 150), (0, 0, -1, 150), *HELIX]),
    ],
)  # fmt: skip
def test_countersunk(moves: Any, wall: float, front: float, expected: list[Any]) -> None:
    body = SUNK.format(pitch=1.5, climb=1, wall=wall, front=front)
    assert moves(PLAIN + body + END) == [(0, 0, 2, 0), *expected, (0, 0, 50, 0)]


def test_the_feed_is_that_of_the_tooth(moves: Any) -> None:
    """ "The TNC references the programmed feed rate during thread milling to the tool cutting edge": 500 (16 - 8) / 16; on and off at Q512."""
    body = "CYCL DEF 262 THREAD MILLING ~\n Q355=+0 ~\n" + SIZE.format(pitch=1.5, climb=1)
    feeds = [move[3] for move in moves(PLAIN + body + END)]
    assert feeds == [0, 750, INSIDE_FEED, INSIDE_FEED, INSIDE_FEED, 0]
    feeds = [move[3] for move in moves(PLAIN + body + " ~\n Q512=+60" + END)]
    assert feeds == [0, 750, 60, INSIDE_FEED, INSIDE_FEED, 0]


@pytest.mark.parametrize("cycle", ["262 THREAD MILLING ~\n Q355=+0 ~\n" + SIZE.format(pitch=1.5, climb=1),
                                   "208 BORE MILLING ~\n Q200=+2 ~\n Q201=-4 ~\n Q206=+100 ~\n Q334=+2 ~\n Q203=+0 ~\n Q204=+20 ~\n Q335=+16 ~\n Q351=+1"])  # fmt: skip
def test_a_tool_without_a_table_is_assumed(run: Any, cycle: str) -> None:
    """Its middle does not go along the wall: 10 mm are taken, as in pockets, and told."""
    out = run(f"{PLAIN}CYCL DEF {cycle}{END}")
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["tool-assumed"]
    assert out.path.end[:, 0].max() == pytest.approx(3.0)


def test_a_stud_needs_a_diameter(run: Any) -> None:
    body = OUTSIDE.format(pitch=1.5, climb=1, steps=0, front=0, offset=0).replace("Q335=+16", "Q335=+0")
    assert [e[0] for e in run(PLAIN + body + END).errors] == ["cycle-tool"]
