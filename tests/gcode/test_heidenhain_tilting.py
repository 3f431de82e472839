"""Heidenhain: PLANE and cycle 19 turn the rotary axes of a machine with kinematics, by closed forms (TNC 640, "PLANE function")."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.machine.kinematics import Kinematics
from cncgen.ranges import FEEDS
from cncgen.toolpath.record import Kind

CENTRE = np.array((0.0, 0.0, -100.0))
#: A carries C in the table of a trunnion; C carries A in a fork head.
TRUNNION, FORK = Kinematics(0, (3, 5), (0.0, 0.0, -100.0)), Kinematics(2, (5, 3), pivot=50.0)
PLANE = "PLANE SPATIAL SPA+0 SPB+30 SPC+0"


def places(run: Any, body: str, kinematics: Kinematics | None = TRUNNION) -> list[list[float]]:
    """Return X Y Z, mm, and the rotary axes, degrees, at the ends of the motions."""
    out = run(f"0 BEGIN PGM A MM\n{body}\nM30\nEND PGM A MM\n", dialect="heidenhain", kinematics=kinematics)
    assert out.errors == []
    ends = out.path.end[out.path.kind != Kind.EVENT].copy()
    ends[:, 3:] = np.degrees(ends[:, 3:])
    return (ends.round(6) + 0.0).tolist()  # type: ignore[no-any-return]


def turned(axis: int, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    out = np.eye(3)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out[a, a], out[a, b], out[b, a], out[b, b] = c, -s, s, c
    return out


def stands(tip: Any, a: float, c: float) -> np.ndarray:
    """Return where the machine stands for a tip on the table, the tool's length 0."""
    return CENTRE + turned(0, -a) @ turned(2, -c) @ (np.array(tip) - CENTRE)  # type: ignore[no-any-return]


@pytest.mark.parametrize(("seq", "a", "c"), [("SEQ+", 30, 90), ("SEQ-", -30, -90), ("SYM-", -30, -90)])
def test_turn_turns_the_axes_alone(run: Any, seq: str, a: float, c: float) -> None:
    first, second, third = places(run, f"L X+1 Y+2 Z+3 FMAX\n{PLANE} TURN FMAX {seq}\nL X+4 Y+5 Z+6 FMAX")
    assert (first[:3], second) == ([1, 2, 3], [1, 2, 3, a, c])
    assert third[3:] == [a, c]
    assert third[:3] == pytest.approx(stands(turned(1, 30) @ (4, 5, 6), a, c), abs=1e-5)


@pytest.mark.parametrize("below", [0, 20])
def test_move_keeps_a_point_below_the_tip_on_the_workpiece(run: Any, below: float) -> None:
    """The point is at Z30 - DIST at first; the tool is along the plane's Z in the end."""
    second = places(run, f"L X+5 Y+0 Z+30 FMAX\n{PLANE} MOVE DIST{below} F2000 SEQ+")[-1]
    tip = np.array((5, 0, 30 - below)) + turned(1, 30) @ (0, 0, below)
    assert second[3:] == [30, 90]
    assert second[:3] == pytest.approx(stands(tip, 30, 90), abs=1e-3)


def test_after_stay_the_program_turns_the_axes_by_q120_and_q122(run: Any) -> None:
    first, second = places(run, f"{PLANE} STAY SEQ-\nL A+Q120 C+Q122 R0 FMAX\nL X+4 Y+5 Z+6 FMAX")
    assert first[3:] == [-30, -90]
    assert second[:3] == pytest.approx(stands(turned(1, 30) @ (4, 5, 6), -30, -90), abs=1e-5)


def test_a_head_turns_and_its_tool_is_changed(run: Any) -> None:
    """A-45 of a fork points the tool along (0, 1, 1)/√2: the pivot comes aside by (50 + L)/√2."""
    text = (
        "TOOL DEF 1 L+0 R+1\nTOOL DEF 2 L+10 R+1\nTOOL CALL 1 Z S100\nPLANE SPATIAL SPA-45 SPB+0 SPC+0 TURN FMAX SEQ-\n"
        "L X+0 Y+0 Z+0 FMAX\nTOOL CALL 2 Z S100\nL X+0 Y+0 Z+0 FMAX"
    )
    ends = places(run, text, FORK)
    half = math.sqrt(0.5)
    assert ends[1] == pytest.approx([0, 50 * half, 50 * half - 50, -45, 0], abs=1e-5)
    assert ends[-1] == pytest.approx([0, 60 * half, 60 * half - 50, -45, 0], abs=1e-5)


def test_the_axis_along_the_tool(run: Any) -> None:
    """COORD ROT leaves C where it is, TABLE ROT turns it by the plane's angle: the same place of the workpiece either way."""
    plane = "PLANE SPATIAL SPA+0 SPB+0 SPC+40 TURN FMAX"
    tip = turned(2, 40) @ (4, 5, 6)
    for word, c in (("COORD ROT", 0), ("", 0), ("TABLE ROT", 40)):
        end = places(run, f"L A+0 C+0 FMAX\n{plane} {word}\nL X+4 Y+5 Z+6 FMAX")[-1]
        assert end[3:] == [0, c]
        assert end[:3] == pytest.approx(stands(tip, 0, c), abs=1e-5)


def test_reset_turns_the_axes_back(run: Any) -> None:
    text = f"{PLANE} TURN FMAX SEQ+\nPLANE RESET TURN FMAX\nL X+1 Y+2 Z+3 FMAX"
    assert places(run, text)[-1] == [1, 2, 3, 0, 0]
    text = f"{PLANE} TURN FMAX SEQ+\nPLANE RESET STAY\nL X+1 Y+2 Z+3 FMAX"
    assert places(run, text)[-1] == [1, 2, 3, 30, 90]


def test_positions_of_the_axes(run: Any) -> None:
    """PLANE AXIAL: an axis that is not named stays; X of the plane is the machine's."""
    ends = places(run, "L C+90 A+0 FMAX\nPLANE AXIAL A+30 TURN FMAX\nL X+0 Y+0 Z+0 FMAX\nL X+7 Y+8 Z+9 FMAX")
    assert ends[-1][3:] == [30, 90]
    assert np.subtract(ends[-1][:3], ends[-2][:3]) == pytest.approx([7, 8, 9], abs=1e-5)


def test_cycle_19_turns_the_axes_where_it_has_a_feed(run: Any) -> None:
    body = "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+30 C+0{}\nL B+0 X+0 Y+0 Z+0 FMAX"
    kinematics = Kinematics(2, (5, 4), pivot=50.0)
    assert places(run, body.format(" F1000 ABST10").replace("B+0 X", "X"), kinematics)[0][3:] == [0, 30, 0]
    assert places(run, body.format("").replace("B+0 X", "B+Q121 X"), kinematics)[0][3:] == [0, 30, 0]


def test_m128_within_the_plane_follows_the_same_tip(run: Any) -> None:
    plane = f"{PLANE} TURN FMAX SEQ+\n"
    plain = places(run, f"{plane}L X+4 Y+5 Z+6 FMAX")[-1]
    assert places(run, f"{plane}L X+4 Y+5 Z+6 FMAX M128")[-1] == pytest.approx(plain, abs=1e-5)
    ends = places(run, f"{plane}L X+1 FMAX M128\nL X+2 FMAX M129\nL X+4 Y+5 Z+6 FMAX")
    assert ends[-1] == pytest.approx(plain, abs=1e-5)


def test_a_plane_out_of_reach_is_refused(run: Any) -> None:
    text = "0 BEGIN PGM A MM\nPLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY\nL X+1 FMAX\nEND PGM A MM\n"
    out = run(text, dialect="heidenhain", kinematics=Kinematics(0, (5, 3)))
    assert [code for code, *_ in out.errors] == ["orientation-vector"]


SIDE = f"X+{math.sin(math.radians(30)):.9f} {{0}}Y+0 {{0}}Z+{math.cos(math.radians(30)):.9f}"


@pytest.mark.parametrize(
    "direction",
    [
        "T" + SIDE.format("T"),
        "N" + SIDE.format("N"),
        "NX+0 NY+0 NZ+1 T" + SIDE.format("T"),
    ],
)
def test_the_tool_takes_the_direction_of_ln(run: Any, direction: str) -> None:
    """Under M128 the rotary axes turn to TX TY TZ, without them to the normal ("the TNC maintains the tool perpendicular to the workpiece
    contour if no tool orientation is programmed", iTNC 530). 30 degrees about Y is A30 C90, or A-30 C-90, which is farther from A10 C80."""
    body = f"L X+0 Y+0 Z+0 A+10 C+80 FMAX\nM128\nLN X+4 Y+5 Z+6 {direction} F1000"
    last = places(run, body)[-1]
    assert last[3:] == [30, 90]
    assert last[:3] == pytest.approx(stands((4, 5, 6), 30, 90), abs=1e-5)
    first = places(run, body.replace("\nM128", "").replace("F1000", "F1000 M128"))[-1]
    assert first == last


def test_directions_alone_move_the_axes_of_the_machine(run: Any) -> None:
    """The manual's block: its vector is (0.0078922, -0.8764339, 0.2590319), about X by 73.5 degrees from Z."""
    vector = np.array((0.0078922, -0.8764339, 0.2590319))
    body = "LN X+31.737 Y+21.954 Z+33.165 NX+0.2637581 NY+0.0078922 NZ-0.8764339 TX+0.0078922 TY-0.8764339 TZ+0.2590319 F1000 M128"
    *_, a, c = places(run, body)[-1]
    assert turned(2, c) @ turned(0, a) @ (0, 0, 1) == pytest.approx(vector / np.linalg.norm(vector), abs=1e-6)


def test_without_m128_the_direction_is_ignored(run: Any) -> None:
    """ "If you have not activated M128 (or TCPM FUNCTION), then the TNC ignores the direction vector T" (iTNC 530)."""
    assert places(run, "LN X+4 Y+5 Z+6 TX+0 TY+1 TZ+0 F1000") == [[4, 5, 6]]


def test_a_direction_without_length(run: Any) -> None:
    out = run(
        "0 BEGIN PGM A MM\nM128\nLN X+4 TX+0 TY+0 TZ+0 F1000\nM30\nEND PGM A MM\n",
        dialect="heidenhain",
        kinematics=TRUNNION,
    )
    assert [code for code, *_ in out.errors] == ["orientation-vector"]


def test_compensation_square_to_a_tilted_tool_is_refused(run: Any) -> None:
    """ "3-D radius compensation with workpiece orientation" (iTNC 530) was made in the plane X Y where no kinematics are known."""
    text = "0 BEGIN PGM A MM\nTOOL DEF 1 L+0 R+5\nTOOL CALL 1 Z S1\nM128\nLN X+4 Y+0 TX+0 TY+1 TZ+1 RR F1000\nL X+9\nL X+20 R0\nM30\nEND PGM A MM\n"
    out = run(text, dialect="heidenhain", tips_alone=True)
    assert next(code for code, *_ in out.errors) == "tcp-refused"


SPATIAL = "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS"


def test_spatial_angles_of_tcpm_turn_the_tool_as_a_plane(run: Any) -> None:
    """The manual's block, L A+0 B+45 C+0, sets the tool to 45 degrees about Y; angles that are left out stay (TNC 640, FUNCTION TCPM)."""
    turn = f"{SPATIAL}\nL A+0 B+45 C+0 FMAX"
    assert places(run, turn)[-1][3:] == [45, 90]
    last = places(run, f"{turn}\nL X+4 Y+5 Z+6 B+30 F100")[-1]
    assert last[3:] == [30, 90]
    assert last[:3] == pytest.approx(stands((4, 5, 6), 30, 90), abs=1e-5)


def test_spatial_angles_count_in_the_tilted_plane(run: Any) -> None:
    """Angles of 0 are square to the plane in force."""
    *_, last = places(run, f"{PLANE} STAY\n{SPATIAL}\nL A+0 B+0 C+0 FMAX\nL X+4 Y+5 Z+6 FMAX")
    assert last[3:] == [30, 90]
    assert last[:3] == pytest.approx(stands(turned(1, 30) @ (4, 5, 6), 30, 90), abs=1e-5)


def test_m128_has_positions_of_the_axes_again(run: Any) -> None:
    *_, last = places(run, f"{SPATIAL}\nL A+0 B+45 C+0 FMAX\nM128\nL A+10 C+20 FMAX")
    assert last[3:] == [10, 20]


def test_increments_of_spatial_angles_are_refused(run: Any) -> None:
    text = f"0 BEGIN PGM A MM\n{SPATIAL}\nL IB+5 FMAX\nM30\nEND PGM A MM\n"
    out = run(text, dialect="heidenhain", kinematics=TRUNNION)
    assert [code for code, *_ in out.errors] == ["unsupported-block"]


@pytest.mark.parametrize(("control", "most"), [("VECTOR", 0.02), ("AXIS", 5.0)])
def test_the_tool_stays_in_the_plane_of_its_directions(run: Any, control: str, most: float) -> None:
    """PATHCTRL VECTOR: between A30 C0 and A30 C60 the directions lie in one plane through the origin, which midway
    is atan(tan 30 cos 30) = 26.6 degrees off Z; axes that turn evenly go around Z and are 3.4 degrees off there."""
    body = (
        f"FUNCTION TCPM F TCP AXIS POS PATHCTRL {control}\nL X+0 Y+0 Z+0 A+30 C+0 FMAX\nL X+10 A+30 C+60 F500"
    )
    rows = places(run, body)
    ways = np.array([turned(2, c) @ turned(0, a) @ (0, 0, 1) for *_, a, c in rows if a >= 20.0])
    normal = np.cross(ways[0], ways[-1])
    off = np.degrees(np.arcsin(np.abs(ways @ (normal / np.linalg.norm(normal)))))
    assert rows[-1][3:] == [30, 60]
    assert off.max() <= most
    assert control == "VECTOR" or off.max() > 3.0


@pytest.mark.parametrize("named", ["", "M128\nL A+10 C+20 FMAX\n"])
def test_axes_that_angles_are_called_as_have_a_column_where_they_move(run: Any, named: str) -> None:
    """A of AXIS SPAT is an angle, and moves B and C of a machine that has no A; A under M128 is an axis, whatever stands before."""
    text = f"0 BEGIN PGM A MM\n{SPATIAL}\nL A+0 B+30 C+10 FMAX\n{named}M30\nEND PGM A MM\n"
    mixed = Kinematics(1, (4, 5), (0.0, 0.0, -100.0), pivot=100.0)
    out = run(text, dialect="heidenhain", kinematics=mixed)
    assert (out.errors, out.path.axes) == ([], "XYZABC" if named else "XYZBC")


@pytest.mark.parametrize(
    ("lines", "place", "told"),
    [
        # Turned by 90 degrees about Y: X goes down, Z to the right. 20 along the tilted X beside 100 along X.
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\nCYCL DEF 7.0\nCYCL DEF 7.1 X+20\n", (105, 0, -21), True),
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\nTRANS DATUM AXIS X+20\n", (105, 0, -21), True),
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\nCYCL DEF 7.0\nCYCL DEF 7.1 X+20\nCYCL DEF 7.0\nCYCL DEF 7.1 IX+3\n", (105, 0, -24), True),
        # A shift of 0 within the plane leaves the one before it.
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\nCYCL DEF 7.0\nCYCL DEF 7.1 X+0\n", (105, 0, -1), True),
        # One shift alone, before or within the plane.
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\n", (105, 0, -1), False),
        ("{plane}\nCYCL DEF 7.0\nCYCL DEF 7.1 X+20\n", (5, 0, -21), False),
        # Without the plane the next shift is the only one.
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\nCYCL DEF 7.0\nCYCL DEF 7.1 X+20\nPLANE RESET STAY\nCYCL DEF 7.0\nCYCL DEF 7.1 X+50\n", (51, 0, 5), True),
        ("CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{plane}\nTRANS DATUM AXIS X+20\nTRANS DATUM RESET\n", (5, 0, -1), True),
    ],
)  # fmt: skip
def test_a_shift_within_a_plane_shifts_the_tilted_coordinates(
    run: Any, lines: str, place: tuple[float, ...], told: bool
) -> None:
    """iTNC 530, cycle 19, "Combining coordinate transformation cycles": a shift before it shifts the machine's coordinates, one after it the
    tilted ones; they are reset in the reverse order."""
    body = lines.format(plane="PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY")
    out = run(
        f"BEGIN PGM T MM\nTOOL CALL 1 Z S1000\n{body}L X+1 Y+0 Z+5 FMAX\nM30\nEND PGM T MM\n",
        dialect="heidenhain",
    )
    assert out.errors == []
    assert out.path.end[out.path.kind != 3, :3][-1].tolist() == pytest.approx(place)
    assert [d.code for d in out.diagnostics].count("shift-tilted") == told


def test_a_turn_to_where_the_axes_stand_is_no_faster_than_feeds_are(run: Any) -> None:
    """Far from the axes rounding leaves a way of 10⁻¹⁰ mm, whose share of F would be of more than 10¹¹ motions a second."""
    turn = "LBL 91\nPLANE SPATIAL SPA146 SPB+0 SPC+0 MOVE F2000\nL X+1 Y1000000 Z+3 FMAX\nCALL LBL 91 REP 1"
    text = f"0 BEGIN PGM A MM\n{turn}\nM30\nEND PGM A MM\n"
    out = run(text, dialect="heidenhain", kinematics=Kinematics(2, (5, 4), pivot=100.0))
    assert out.errors == []
    assert np.nanmax(out.path.feed) <= FEEDS[1]
