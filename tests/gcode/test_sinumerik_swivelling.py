"""SINUMERIK: CYCLE800 as a frame and as a turn of the machine's rotary axes, by closed forms.

The numbers of MODE are bits: HiNC's documentation of NcArgCycle800, and posts of Autodesk for 840D, which write MODE 27 with C, B, A.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.machine.kinematics import Kinematics
from cncgen.toolpath.record import Kind

CENTRE = (0.0, 0.0, -100.0)
#: A carries C in the table of a trunnion; C carries A in a fork head.
TRUNNION, FORK = Kinematics(0, (3, 5), CENTRE), Kinematics(2, (5, 3), pivot=50.0)
S = math.sqrt(0.5)


def places(run: Any, text: str, kinematics: Kinematics | None = None) -> list[list[float]]:
    """Return where motions end, mm and degrees, in the order of the columns."""
    out = run(f"{text}\nM30", dialect="sinumerik", kinematics=kinematics)
    assert out.errors == []
    ends = out.path.end[out.path.kind != Kind.EVENT].copy()
    ends[:, 3:] = np.degrees(ends[:, 3:])
    return ends.round(6).tolist()  # type: ignore[no-any-return]


def turned(axis: int, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    out = np.eye(3)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out[a, a], out[a, b], out[b, a], out[b, b] = c, -s, s, c
    return out


@pytest.mark.parametrize(
    ("mode", "order"), [(57, (0, 1, 2)), (45, (0, 2, 1)), (54, (1, 0, 2)), (30, (1, 2, 0)), (39, (2, 0, 1)), (27, (2, 1, 0))]
)  # fmt: skip
def test_angles_turn_about_the_axes_that_mode_names(run: Any, mode: int, order: tuple[int, ...]) -> None:
    angles = (20.0, 30.0, 50.0)
    expected = np.eye(3)
    for axis, angle in zip(order, angles, strict=True):
        expected = expected @ turned(axis, angle)
    text = f'CYCLE800(0,"",0,{mode},1,2,3,20,30,50,4,5,6,-1)\nG0 X10 Y20 Z30'
    assert places(run, text)[-1][:3] == pytest.approx(expected @ (14, 25, 36) + (1, 2, 3), abs=1e-5)


def test_solid_angles_turn_about_z_then_y(run: Any) -> None:
    assert places(run, 'CYCLE800(0,"",0,64,0,0,0,30,40,0,0,0,0,-1)\nG0 X0 Y0 Z10')[-1][:3] == pytest.approx(
        turned(2, 30) @ turned(1, 40) @ (0, 0, 10), abs=1e-5
    )


@pytest.mark.parametrize("mode", [0b10111001, 0b10110110])
def test_projections_are_the_slopes_of_the_plane(run: Any, mode: int) -> None:
    """A plane whose line in Y Z is at 20 degrees, and in Z X at 30: z = y tan 20 - x tan 30, its X in the plane Z X."""
    angles = "20,30" if mode == 0b10111001 else "30,20"
    ends = places(
        run, f'CYCLE800(0,"",0,{mode},0,0,0,{angles},0,0,0,0,-1)\nG0 X10 Y0 Z0\nX0 Y10\nX3 Y0\nX0 Z1'
    )
    for x, y, z in (end[:3] for end in ends[:3]):
        assert z == pytest.approx(y * math.tan(math.radians(20)) - x * math.tan(math.radians(30)), abs=1e-5)
    assert ends[0][1] == 0.0
    assert np.dot(ends[0][:3], ends[1][:3]) == pytest.approx(0.0, abs=1e-4)


def test_another_mode_is_named(run: Any) -> None:
    out = run('CYCLE800(0,"",0,21,0,0,0,20,0,0,0,0,0,-1)\nM30', dialect="sinumerik")
    assert [code for code, *_ in out.errors] == ["not-read"]


# On machines that turn.


@pytest.mark.parametrize(("dir_", "a", "c"), [(-1, -30, -90), (1, 30, 90)])
def test_a_trunnion_turns_and_carries_the_plane(run: Any, dir_: int, a: float, c: float) -> None:
    """B30: the tool is along (sin 30, 0, cos 30) of the workpiece. A tip p stands at centre + R1(-a) R2(-c) (p - centre)."""
    text = f'G0 X1 Y2 Z50\nCYCLE800(0,"",0,57,10,0,0,0,30,0,0,0,0,{dir_})\nG0 X3 Y4 Z5'
    _, second, third = places(run, text, TRUNNION)
    assert second == [1, 2, 50, a, c]
    tip = np.array((10, 0, 0)) + turned(1, 30) @ (3, 4, 5)
    assert third[3:] == [a, c]
    assert third[:3] == pytest.approx(
        np.array(CENTRE) + turned(0, -a) @ turned(2, -c) @ (tip - CENTRE), abs=1e-5
    )


def test_a_head_turns_and_leads_the_plane(run: Any) -> None:
    """A-45 of a fork points the tool along (0, 1, 1)/√2: the pivot, 50 above the nose, comes aside."""
    first, second = places(run, 'CYCLE800(0,"",0,57,0,0,0,-45,0,0,0,0,0,-1)\nG0 X0 Y0 Z0', FORK)
    assert first[3:] == [-45, 0]
    assert second[:3] == pytest.approx([0, 50 * S, 50 * S - 50], abs=1e-5)


def test_arcs_stay_arcs_and_feeds_hold(run: Any) -> None:
    text = 'CYCLE800(0,"",0,57,0,0,0,25,15,0,0,0,0,-1)\nG0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F300\nM30'
    out = run(text, dialect="sinumerik", kinematics=TRUNNION)
    assert out.errors == []
    assert out.path.kind[-2] == Kind.ARC
    assert out.path.feed[-2] == pytest.approx(5.0)


def test_a_drilled_hole_of_the_plane_is_along_z(run: Any) -> None:
    text = 'CYCLE800(0,"",0,57,0,0,0,40,0,0,0,0,0,1)\nG0 X0 Y0 Z20\nF100 S500 M3\nCYCLE81(10,0,2,-5)'
    ends = np.array(places(run, text, TRUNNION))
    assert np.ptp(ends[1:, :2], axis=0) == pytest.approx([0, 0], abs=1e-5)
    assert ends[-1][2] - ends[-2][2] == pytest.approx(15)


def test_an_origin_within_a_turned_table(run: Any) -> None:
    """G55 lies 20 along X beside G54: with C90 of the table the machine goes along -Y, A at 0."""
    text = (
        "$P_UIFR[2]=CTRANS(X,20)\n"
        'G54\nCYCLE800(0,"",0,57,0,0,0,40,0,0,0,0,0,-1)\nG0 X0 Y0 Z0\nG55\nG0 X0 Y0 Z0'
    )
    ends = places(run, text, TRUNNION)
    tips = [np.array((x, 0, 0)) for x in (0, 20)]
    a, c = ends[-1][3], ends[-1][4]
    for end, tip in zip(ends[-2:], tips, strict=True):
        assert end[:3] == pytest.approx(
            np.array(CENTRE) + turned(0, -a) @ turned(2, -c) @ (tip - CENTRE), abs=1e-5
        )


def test_the_end_of_the_plane_leaves_the_axes(run: Any) -> None:
    text = 'CYCLE800(0,"",0,57,0,0,0,0,30,0,0,0,0,1)\nCYCLE800()\nG0 X1 Y2 Z3'
    assert places(run, text, TRUNNION)[-1] == [1, 2, 3, 30, 90]


def test_angles_of_zero_turn_the_axes_back(run: Any) -> None:
    text = 'CYCLE800(0,"",0,57,0,0,0,0,30,0,0,0,0,1)\nCYCLE800(0,"",0,57,0,0,0,0,0,0,0,0,0,-1)\nG0 X1 Y2 Z3'
    assert places(run, text, TRUNNION)[-1] == [1, 2, 3, 0, 0]


def test_positions_of_the_axes(run: Any) -> None:
    """MODE 192: A30 C90. The plane's X and Y are the machine's: Z is (sin 30, 0, cos 30) as above, and Y (-1, 0, 0) turned with it."""
    ends = places(run, 'CYCLE800(0,"",0,192,0,0,0,30,90,0,0,0,0,-1)\nG0 X0 Y0 Z0\nG0 X7 Y8 Z9', TRUNNION)
    assert ends[0][3:] == [30, 90]
    assert np.array(ends[2][:3]) - ends[1][:3] == pytest.approx([7, 8, 9], abs=1e-5)


def test_retraction_along_the_tool_comes_first(run: Any) -> None:
    text = 'G0 X0 Y0 Z10\nCYCLE800(5,"",0,57,0,0,0,30,0,0,0,0,0,-1,40)'
    assert [end[2] for end in places(run, text, TRUNNION)][:3] == [10, 50, 50]


def test_traori_within_the_plane_follows_the_tip(run: Any) -> None:
    """The plane of CYCLE800 stays, and the machine stands for a tip of it as without TRAORI."""
    swivel = 'CYCLE800(0,"",0,57,10,0,0,0,30,0,0,0,0,-1)\n'
    plain = places(run, f"{swivel}G0 X3 Y4 Z5", TRUNNION)[-1]
    assert places(run, f"{swivel}TRAORI\nG0 X3 Y4 Z5", TRUNNION)[-1] == pytest.approx(plain, abs=1e-5)
    assert places(run, f"{swivel}TRAORI\nG0 X1\nTRAFOOF\nG0 X3 Y4 Z5", TRUNNION)[-1] == pytest.approx(
        plain, abs=1e-5
    )


def test_positions_of_the_axes_need_a_machine(run: Any) -> None:
    out = run('CYCLE800(0,"",0,192,0,0,0,30,90,0,0,0,0,-1)\nM30', dialect="sinumerik")
    assert [code for code, *_ in out.errors] == ["tcp-machine"]


@pytest.mark.parametrize(
    ("words", "axis", "angle"), [("X30 Y20", 0, 20), ("Y20 Z30", 1, 30), ("Z10 X-25", 2, -25)]
)
def test_rots_puts_an_axis_into_a_plane_of_the_coordinates(
    run: Any, words: str, axis: int, angle: float
) -> None:
    """ROTS X Y: the new X is in the old plane Z X, turned by Y; so on in cyclic order (840D sl, Job planning, "ROTS, AROTS, CROTS"). The line
    of the plane X Y in the old plane Y Z is Y turned by X."""
    found = [np.array(places(run, f"ROTS {words}\nG0 {'XYZ'[k]}1")[-1][:3]) for k in range(3)]
    assert found[axis] == pytest.approx(turned((axis + 1) % 3, angle)[:, axis], abs=1e-6)
    assert np.linalg.det(np.column_stack(found)) == pytest.approx(1.0, abs=1e-5)
    first, second = (float(word[1:]) for word in words.split())
    line = turned(axis, first)[:, (axis + 1) % 3]
    assert np.dot(np.cross(found[axis], found[(axis + 1) % 3]), line) == pytest.approx(0.0, abs=1e-6)
    assert second == angle


def test_rots_of_one_angle_is_rot_and_of_three_is_none(run: Any) -> None:
    assert places(run, "ROTS Y20\nG0 X1 Z2") == places(run, "ROT Y20\nG0 X1 Z2")
    alone = np.array(places(run, "ROTS X30 Y20\nG0 X0 Y0 Z1")[-1][:3])
    added = places(run, "TRANS X5\nAROTS X30 Y20\nG0 X0 Y0 Z1")[-1][:3]
    assert added == pytest.approx(alone + np.array((5, 0, 0)), abs=1e-5)
    out = run("ROTS X1 Y2 Z3\nG0 X1\nM30", dialect="sinumerik")
    assert [code for code, *_ in out.errors] == ["not-read"]
