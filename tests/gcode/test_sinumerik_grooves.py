"""CYCLE93 of SINUMERIK: the walls, base and corners are those of its parameters, the plunges those that the module states."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind

Run = Callable[..., Any]
HEAD = "G18 G90 G95 DIAMON\nT2 D1\nG97 S600 M4\nG0 X{x} Z0\nF0.1\n"


@pytest.fixture
def cut(run: Run, tmp_path: Path) -> Callable[..., tuple[Any, list[list[float]]]]:
    """Return the outcome of a cycle with a tool 4 wide that comes from a diameter, and the ends of its motions: X, Z, 1 for a cut, 0 for a traverse."""
    table = tmp_path / "t.tbl"
    table.write_text("T2 P2 D4 ;groover\n")

    def of(cycle: str, x: float = 60.0) -> tuple[Any, list[list[float]]]:
        out = run(f"{HEAD.format(x=x)}{cycle}\nM30\n", dialect="sinumerik", tool_table=str(table))
        rows = out.path.kind != Kind.EVENT
        feed = np.where(out.path.feed_mode == FeedMode.RAPID, 0.0, 1.0)
        return out, (np.round(np.column_stack([out.path.end[:, [0, 2]], feed])[rows], 9) + 0.0).tolist()[1:]

    return of


def test_plunges_from_the_left_in_steps(cut: Any) -> None:
    """10 wide with a tool of 4: two steps aside of 3 (3.2 at most); 6 deep in three steps of 2 (2.5 at most), 1 mm back between them."""
    out, found = cut("CYCLE93(50,-30,10,6,0,0,0,0,0,0,0,0,0,2.5,0,1)")
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["tool-assumed"]
    expected = [[30, -30, 0], [26, -30, 0]]
    for z in (-30, -27, -24):
        expected += [[26, z, 0]] * (z != -30)
        expected += [[23, z, 1], [24, z, 0], [21, z, 1], [22, z, 0], [19, z, 1], [26, z, 0]]
    assert found == expected


def test_revolutions_of_the_wait_are_those_of_the_groove(cut: Any) -> None:
    """2 turns at 120 m a minute, around the diameter of the base: a groove as wide as the tool."""
    out, _ = cut("G96 S120\nCYCLE93(50,-30,4,6,0,0,0,0,0,0,0,0,0,6,-2,1)")
    assert out.errors == []
    speed = 120.0 / (math.pi * 0.038)
    assert [event.dwell_s for event in out.path.events if event.dwell_s] == pytest.approx([2 * 60.0 / speed])


def test_inside_from_the_right_with_allowances(cut: Any) -> None:
    """A bore of 50 with a groove of 8 by 3, its right edge at -10: 0.2 stay on the walls and 0.1 on the base, which are then cut to size."""
    _, found = cut("CYCLE93(50,-10,8,3,0,0,0,0,0,0,0,0.1,0.2,0,0,7)", x=40.0)
    left, right = -18.0, -14.0
    plunges = [-14.2, -16.0, -17.8]
    expected = [[20, -14.2, 0], [24, -14.2, 0]]
    for z in plunges:
        expected += [[24, z, 0]] * (z != -14.2)
        expected += [[27.9, z, 1], [24, z, 0]]
    for wall in (right, left):
        expected += [[24, wall, 0], [25, wall, 1], [28, wall, 1], [28, -16, 1], [24, -16, 0]]
    assert found == expected


def test_corners(cut: Any) -> None:
    """A radius of 1 at the edge and a chamfer of the leg 0.5 in the base at the start, the other way round behind; CHF is √2 legs long."""
    out, found = cut("CYCLE93(50,0,10,6,0,0,0,1,-0.5,-0.5,1,0,0,0,0,11)")
    # The first plunge stands in the chamfer of the base, the last in its radius.
    assert [row[0] for row in found if row[2] == 1.0][:3] == [19.5, 19.0, 20.0]
    assert found[9:] == [
        [26, -1, 0], [25, -1, 1], [24, 0, 1], [19.5, 0, 1], [19, 0.5, 1], [19, 2.75, 1], [26, 2.75, 0],
        [26, 6.5, 0], [25, 6.5, 1], [24.5, 6, 1], [20, 6, 1], [19, 5, 1], [19, 2.75, 1], [26, 2.75, 0],
    ]  # fmt: skip
    arcs = out.path.arcs
    assert np.round(arcs.centre, 9).tolist() == [[24, 0, -1], [20, 0, 5]]
    _, found = cut(f"CYCLE93(50,0,10,6,0,0,0,{-math.sqrt(2.0)},0,0,0,0,0,0,0,1)")
    assert [25, -1, 1] in found
    assert [24, 0, 1] in found


@pytest.mark.parametrize(
    ("cycle", "code"),
    [
        ("CYCLE93(50,0,10,6,0,0,0,0,0,0,0,0,0,0,0,2)", "not-read"),
        ("CYCLE93(50,0,10,6,5,0,0,0,0,0,0,0,0,0,0,1)", "not-read"),
        ("CYCLE93(50,0,10,6,0,10,0,0,0,0,0,0,0,0,0,1)", "not-read"),
        ("DIAMOF CYCLE93(50,0,10,6,0,0,0,0,0,0,0,0,0,0,0,1)", "not-read"),
        ("CYCLE93(50,0,3,6,0,0,0,0,0,0,0,0,0,0,0,1)", "cycle-tool"),
        ("CYCLE93(50,0,5,6,0,0,0,0,0,1,1,0,0,0,0,1)", "cycle-tool"),
        ("CYCLE93(50,0,5,6,0,0,0,0,0,0,0,0,0.6,0,0,1)", "cycle-tool"),
        ("CYCLE93(50,0,10,0,0,0,0,0,0,0,0,0,0,0,0,1)", "cycle-words"),
        ("G17 CYCLE93(50,0,10,6,0,0,0,0,0,0,0,0,0,0,0,1)", "cycle-words"),
    ],
)
def test_what_is_not_cut(cut: Any, cycle: str, code: str) -> None:
    assert [found for found, *_ in cut(cycle.replace(" ", "\n"))[0].errors] == [code]


#: Down to 40 at 0.1 and 800 rev/min, to 10 at 0.04 and 400 rev/min, 2 mm above the part.
CUT_OFF = ["50", "-30", "40", "10", "0", "2", "800", "", "4", "0.1", "0.04", "400", "", "0", "", "2", "0"]


def call(**changed: str) -> str:
    """Return a call of CYCLE92 with other values of some parameters, by their place from 1 on."""
    words = CUT_OFF.copy()
    for place, word in changed.items():
        words[int(place[1:]) - 1] = word
    return f"CYCLE92({','.join(words)})"


def test_cutting_off_in_two_sections(cut: Any) -> None:
    """840D sl, Operating Manual Turning 02/2012, 8.2.8: to X1 at F and S, to X2 at FR and SR, back to the safety distance in traverse."""
    out, found = cut(call())
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["cycle-parameters"]
    assert found == [[30, -30, 0], [27, -30, 0], [20, -30, 1], [5, -30, 1], [27, -30, 0]]
    path = out.path
    cuts = (path.kind != Kind.EVENT) & (path.feed_mode != FeedMode.RAPID)
    # Feeds a revolution, times the speed of each section; then F0.1 of the program counts again.
    assert (path.feed[cuts] * 60.0).tolist() == pytest.approx([0.1 * 800, 0.04 * 400])
    speeds = [event.values["speed_rpm"] for event in path.events if event.name == "spindle"]
    assert speeds[-2:] == [800, 400]


def test_cutting_off_at_a_cutting_speed(cut: Any) -> None:
    """60 m a minute, at most 3000 rev/min: at the diameter 10 that is 1910; without SS2 it stays there. A pipe: no slower section."""
    out, found = cut(call(_3="", _7="60", _8="3000"))
    assert out.errors == []
    assert found[-2:] == [[5, -30, 1], [27, -30, 0]]
    cuts = (out.path.kind != Kind.EVENT) & (out.path.feed_mode != FeedMode.RAPID)
    # G96: at the mean radius of each part of the way, which ends at 10.
    last = out.path.feed[cuts][-1] * 60.0
    assert 0.95 * 0.1 * 60e3 / (math.pi * 10) < last <= 0.1 * 60e3 / (math.pi * 10)


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({"_5": "0.5"}, "not-read"),
        ({"_14": "1"}, "not-read"),
        ({"_14": "10"}, "not-read"),
        ({"_17": "1"}, "not-read"),
        ({"_17": "10"}, "not-read"),
        ({"_9": "5"}, "cycle-spindle"),
        ({"_3": "60"}, "cycle-words"),
        ({"_4": "45"}, "cycle-words"),
        ({"_6": "-1"}, "cycle-words"),
        ({"_12": "-400"}, "cycle-words"),
        ({"_16": "1"}, "cycle-plane"),
    ],
)
def test_cutting_off_that_is_not_read(cut: Any, changed: dict[str, str], code: str) -> None:
    out, _ = cut(call(**changed))
    assert [found for found, *_ in out.errors] == [code]
