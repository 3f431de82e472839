"""Settings and patterns that programs of shops have on SINUMERIK, against what the manuals say of them (840D sl, Job planning)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.gcode import read
from cncgen.gcode.source import Source
from cncgen.gcode.text.dialects import choose
from cncgen.machine.kinematics import Kinematics
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode

Run = Callable[..., Any]


def ends(run: Run, text: str, **options: Any) -> list[list[float]]:
    """Return where the motions of a text lead in X Y Z, after asserting that all went well."""
    out = run(text, dialect="sinumerik", **options)
    assert out.errors == []
    return (np.round(out.path.end[out.path.kind != 3, :3], 9) + 0.0).tolist()


def fault(run: Run, text: str) -> tuple[str, str]:
    """Return the first error of a text: its code and message."""
    found = run(text, dialect="sinumerik").diagnostics
    return next((d.code, d.message) for d in found if d.severity == "error")


def codes(run: Run, text: str) -> list[str]:
    """Return the codes of the warnings of a text."""
    return [d.code for d in run(text, dialect="sinumerik").diagnostics if d.severity.value == "warning"]


@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        ("$P_UIFR[1,X,TR]=10 $P_UIFR[1,Y,TR]=-3\nG54", [11, -1, 3]),
        ("$P_UIFR[1]=CTRANS(X,10,Z,5)\n$P_UIFR[1,Y,TR]=4\nG54", [11, 6, 8]),
        ("$P_UIFR[1,Z,RT]=0 $P_UIFR[1,X,SC]=1 $P_UIFR[1,X,FI]=0\nG54", [1, 2, 3]),
        ("$P_UIFR[2]=CTRANS(X,7)\n$P_UIFR[1]=$P_UIFR[2]:CTRANS(Y,1)\nG54", [8, 3, 3]),
        ("$P_PFRAME=CTRANS(X,10):CROT(Z,90)", [8, 1, 3]),
        ("$P_PFRAME=CTRANS(X,10)\n$P_PFRAME=$P_PFRAME:CMIRROR(X)", [9, 2, 3]),
        ("$P_PFRAME=CROT(Z,90)\n$P_PFRAME[X,TR]=5", [3, 1, 3]),
        ("$P_PFRAME=CSCALE(X,2,Y,3)", [2, 6, 3]),
    ],
)
def test_frames_by_variables(run: Run, frame: str, expected: list[float]) -> None:
    """A chain takes a point through the frame on its right first: CTRANS:CROT is TRANS and AROT."""
    assert ends(run, f"G17 G90\n{frame}\nG0 X1 Y2 Z3\nM30")[-1] == expected


def test_origins_are_read_back(run: Run) -> None:
    text = "$P_UIFR[3,Y,TR]=12.5\nR1=$P_UIFR[3,Y,TR]\nG0 X=R1 Y=$P_UIFR[3,X,TR]\nM30"
    assert ends(run, text)[-1] == [12.5, 0, 0]


@pytest.mark.parametrize(
    ("line", "code", "part"),
    [
        ("$P_UIFR[1,X,RT]=45", "not-read", "RT"),
        ("$P_UIFR[1]=CROT(X,45)", "not-read", "turns"),
        ("$P_UIFR[100,X,TR]=1", "system-number", "1 to 99"),
        ("R1=CTRANS(X,1)", "not-read", "R1"),
        ("$P_PFRAME=CTRANS(X,1):R1", "not-read", "frame"),
        ("OVR=0", "feed-override", "OVR=0"),
        ("G42 G1 X5 F100\nOFFN=1\nX20", "not-read", "OFFN"),
        ("OFFN=-9\nG41 G1 X5 F100", "comp-radius", "OFFN=-9"),
        ("G1 X5 POS[Y]=3 F100", "not-read", "POS"),
        ("POS[1]=3", "variable-unknown", "an axis is needed"),
        ("CYCLE801(0,0,0,10,10,3,3)", "cycle-missing", "CYCLE801"),
        ("MCALL CYCLE81(10,0,2,-5)\nCYCLE802(111111111,111111111)", "cycle-words", "no place"),
        ("R1=$TC_DP25[1,1]", "variable-unknown", "$TC_DP25"),
    ],
)
def test_faults(run: Run, line: str, code: str, part: str) -> None:
    text = f"$TC_DP6[1,1]=5\nT1 D1 M6\nG0 X0 Y0 Z10\nF100\n{line}\nM30"
    found = fault(run, text)
    assert found[0] == code
    assert part in found[1]


def test_tools_that_the_program_describes(run: Run) -> None:
    """Length 1 is along Z for a mill, DP12 its wear; G41 keeps the radius DP6 and its wear DP15 from the wall."""
    text = (
        "$TC_DP1[4,1]=120 $TC_DP3[4,1]=50 $TC_DP12[4,1]=0.5\n$TC_DP6[4,1]=5 $TC_DP15[4,1]=-1\nT4 D1 M6\nG17 G90\n"
        "G0 X0 Y-20 Z10\nG41 G1 X0 Y0 F100\nY30\nX50\nG40 X80\nM30"
    )
    found = ends(run, text)
    assert found[0] == [0, -20, 60.5]
    assert [-4.0, 0.0, 60.5] in found
    assert ends(run, "$TC_DP6[4,1]=5\nT4 D1 M6\nR1=$TC_DP6[4,1]\nG0 X=R1 Y=$P_AD[6] Z=$P_TOOLR\nM30") == [
        [5, 5, 5]
    ]


def test_positions_of_edges(run: Run) -> None:
    """Position 3 turns outside and 2 inside, as on FANUC's lathes (from memory of "Cutting edge position", 840D sl, Tools): 2 stands a
    diameter of the nose farther out there. LinuxCNC's numbers were taken."""
    text = "$TC_DP1[1,1]=500 $TC_DP2[1,1]={} $TC_DP6[1,1]=0.4\nG18 G95 DIAMON\nT1 D1\nS500 M3\nG0 X30 Z5\nG42 G1 X20 Z0 F0.2\nZ-20\nR1=$TC_DP2[1,1]\nG40 G0 X60 Z=R1\nM30"
    for position, radius in ((3, 10), (2, 10.8)):
        assert [ends(run, text.format(position))[row][col] for row, col in ((-2, 0), (-1, 2))] == [
            radius,
            position,
        ]
    assert fault(run, "$TC_DP2[1,1]=10\nM30")[0] == "tool-orientation"


def test_a_tool_by_the_remark_of_the_table(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "t.tbl"
    table.write_text("T7 P7 Z30 D10 ;Mill_10\n")
    assert ends(run, 'T="MILL_10" D1 M6\nG0 Z1\nM30', tool_table=table)[-1] == [0, 0, 31]


def test_an_allowance_stands_beside_the_radius(run: Run) -> None:
    """OFFN is added to the tool's radius: 5 + 2."""
    text = "$TC_DP6[1,1]=5\nT1 D1 M6\nG0 X0 Y-20\nOFFN=2\nG41 G1 X0 Y0 F100\nY30\nX60\nG40 X90\nM30"
    assert [-7.0, 0.0, 0.0] in ends(run, text)


def feeds(run: Run, text: str) -> list[float]:
    """Return the feeds of the cutting motions, mm/min."""
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    cuts = out.path.feed_mode == FeedMode.SPEED
    return (out.path.feed[cuts] * 60.0).round(6).tolist()


def test_override_and_feeds_of_one_block(run: Run) -> None:
    assert feeds(run, "G1 X1 F100\nOVR=50\nX2\nX3 F200\nOVR=100\nX4\nM30") == [100, 50, 100, 200]
    assert feeds(run, "G1 X1 F100\nX2 FB=30\nX3\nM30") == [100, 30, 100]


def test_axes_that_move_by_themselves(run: Run) -> None:
    """POS moves at FA, or in traverse, and the motion and feed in force come back."""
    out = run("G1 X1 F100\nPOS[Y]=5\nFA[Z]=60\nPOS[Z]=3\nX4\nG0 X0 POS[Y]=0\nM30", dialect="sinumerik")
    assert out.errors == []
    assert out.path.end[:, :3].tolist()[:5] == [[1, 0, 0], [1, 5, 0], [1, 5, 3], [4, 5, 3], [0, 0, 3]]
    assert [round(f * 60, 6) for f in out.path.feed[[0, 2, 3]]] == [100, 60, 100]
    assert out.path.feed_mode[[1, 4]].tolist() == [FeedMode.RAPID] * 2


def test_an_axis_with_a_feed_of_its_own_is_no_traverse_beside_one_without(run: Run) -> None:
    """Z has 60 mm/min; that X of the same block has none made a traverse of both."""
    text = "POS[X]=30 POS[Z]=40 FA[Z]=60\nPOS[X]=0 POS[Z]=0 FA[X]=90\nG1 X1 F100\nM30"
    assert feeds(run, text) == [60, 60, 100]


def test_limits_of_axes_are_the_machines(run: Run) -> None:
    assert codes(run, "ACC[X]=50 VELOLIM[Y]=20\nG0 X1\nM30") == ["limit-kept"]
    assert codes(run, "FL[X]=100\nG0 X1\nM30") == ["limit-kept"]
    assert codes(run, "ACC[X]=100\nG0 X1\nM30") == []


def holes(run: Run, pattern: str) -> list[list[float]]:
    """Return X and Y of the bottoms that a pattern drills."""
    text = f"G17 G90\nG0 X0 Y0 Z10\nF100\nMCALL CYCLE81(10,0,2,-5)\n{pattern}\nMCALL\nM30"
    return [[x, y] for x, y, z in ends(run, text) if z == -5]


def test_a_grid_of_holes(run: Run) -> None:
    """Columns 10 apart, rows 20 apart, turned by 90 degrees: the point (10 i, 20 j) comes to (-20 j, 10 i)."""
    expected = {(-20 * j, 10 * i) for i in range(3) for j in range(2)}
    found = holes(run, "CYCLE801(0,0,90,10,20,3,2)")
    assert {tuple(place) for place in found} == expected
    assert len(found) == 6


def test_a_grid_begins_at_the_corner_nearest_to_the_tool(run: Run) -> None:
    """The cycle of the 840D (software 6.2) compares half of each side with the position before it; the first hole was always that of SPCA, SPCO."""
    assert holes(run, "G0 X25 Y5\nCYCLE801(0,0,0,10,20,3,2)")[1:] == [
        [20, 0],
        [10, 0],
        [0, 0],
        [0, 20],
        [10, 20],
        [20, 20],
    ]


def test_a_frame_of_holes(run: Run) -> None:
    found = holes(run, "CYCLE801(1,2,0,10,20,4,3,1)")
    assert len(found) == 10
    assert [11, 22] not in found
    assert [1, 22] in found


def test_places_of_holes(run: Run) -> None:
    """The third place is a step from the second along X (digit 2), a coordinate along Y."""
    assert holes(run, "CYCLE802(111111211,111111111,1,2,10,3,5,4)") == [[1, 2], [10, 3], [15, 4]]


@pytest.mark.parametrize("text", ["N10 PLATE_TOP(15,1.5,30)\nN20 M30\n", "N5 DRILL_ROW(1,,3) ;holes\nM30\n"])
def test_a_call_with_arguments_is_of_sinumerik(text: str) -> None:
    assert choose(Source(text.encode(), "t.nc")).dialect == "sinumerik"


def test_the_suffix_speaks_where_nothing_else_does() -> None:
    text = b"G0 X10\nG1 Z-1 F100\nM30\n"
    assert choose(Source(text, "part.MPF")).dialect == "sinumerik"
    assert choose(Source(text, "part.nc")).dialect == "linuxcnc"


def test_main_blocks_of_a_program_of_sinumerik() -> None:
    """A block with : for N begins a section (840D sl, Fundamentals): it was taken for Acramatic's."""
    found = choose(Source(b":100 G54\nN110 G0 X1\n:120 G1 Y5 F100\nM30\n", "part.mpf"))
    assert (found.dialect, found.unread) == ("sinumerik", "")


def test_pockets_of_older_controls_are_named(run: Run) -> None:
    found = run("R22=10 R23=5 R24=3 L930\nM30\n", dialect="sinumerik").diagnostics
    (hint,) = [told.hint for told in found if told.code == "sub-missing"]
    assert hint.endswith("it mills a circular pocket, as POCKET2 and POCKET4 here")


@pytest.fixture
def ten(tmp_path: Path) -> Path:
    """Return a tool table: tool 1 is 10 mm wide."""
    table = tmp_path / "ten.tbl"
    table.write_text("T1 P1 Z0 D10\n")
    return table


def low(run: Run, cycle: str, table: Path) -> np.ndarray:
    """Return where the tool goes below 0 in a cycle."""
    out = run(
        f"G17 G90 G94 G54 T1 D1 S600 M3\nG0 X0 Y0 Z5\n{cycle}\nM30", dialect="sinumerik", tool_table=table
    )
    assert out.errors == []
    ends = out.path.end[out.path.kind != 3, :3]
    return np.round(ends[ends[:, 2] < 0.0], 9)


def test_slots_along_a_circle(run: Run, ten: Path) -> None:
    """Three slots 15 wide along the circle of radius 42 about (60, 60): the tool stays 2.5 beside it, and levels are 6 deep at most."""
    found = low(run, "SLOT2(2,0,2,-23,,3,70,15,60,60,42,,120,100,300,6,2,0.5,0)", ten)
    spokes = (found[:, 0] - 60) + 1j * (found[:, 1] - 60)
    assert np.abs(np.abs(spokes) - 42.0).max() == pytest.approx(2.5)
    assert sorted(set(found[:, 2])) == [-23.0, -17.25, -11.5, -5.75]
    angles = np.degrees(np.angle(spokes)) % 360.0
    for begin in (0.0, 120.0, 240.0):
        assert np.isclose(angles, begin).any()
        assert np.isclose(angles, begin + 70.0).any()


def test_a_slot_as_wide_as_the_tool_is_its_middle_line(run: Run, ten: Path) -> None:
    found = low(run, "SLOT2(2,0,2,-4,,1,90,10,0,0,20,0,,100,300,5,3,0,0)", ten)
    assert sorted({tuple(place) for place in found.tolist()}) == [(0.0, 20.0, -4.0), (20.0, 0.0, -4.0)]


def test_pockets_of_older_controls(run: Run, ten: Path) -> None:
    """POCKET1 roughs 0.5 off the wall, turned by 90 degrees; POCKET2 goes to the wall."""
    found = low(run, "POCKET1(5,0,2,-4,,40,20,6,100,0,90,100,300,2,3,0.5,1)", ten)
    assert (found[:, 0].min(), found[:, 0].max()) == (95.5, 104.5)
    assert (found[:, 1].min(), found[:, 1].max()) == (-14.5, 14.5)
    found = low(run, "POCKET2(5,0,2,-4,,10,0,100,100,300,2,3,0.5,0)", ten)
    assert (found[:, 1].min(), found[:, 1].max()) == (95.0, 105.0)


def test_slots_that_cannot_be(run: Run, tmp_path: Path) -> None:
    slot = "G54 T1 D1\nSLOT2(2,0,2,-8,,3,{angle},15,60,60,42,,120,100,300,6,2,0.5,0)\nM30"
    (tmp_path / "t.tbl").write_text("T1 P1\n")
    for angle, code in ((400, "cycle-words"), (70, "cycle-tool")):
        out = run(slot.format(angle=angle), dialect="sinumerik", tool_table=tmp_path / "t.tbl")
        assert [found for found, _, _ in out.errors] == [code]


@pytest.mark.parametrize(
    ("cycle", "said"),
    [
        ("CYCLE86(10,0,2,-8,,0,3,-1,-1,1,45)", []),
        ("CYCLE87(5,0,2,-10,,3)", []),
        ("CYCLE87(5,0,2,-10,,3,,,)", []),
        ("CYCLE87(5,0,2,-10,,3,,,1)", ["cycle-parameters"]),
        ('CYCLE84(15,0,5,-12,,0,3,,1.25,0,500,600,0,1,0,0,,1.4,"","ISO_METRIC","M8",0,1,1001002)', []),
        ('CYCLE84(15,0,5,-12,,0,3,,1.25,0,500,600,0,1,0,0,,1.4,"","ISO_METRIC","M8",0,1,1001002,,5)', []),
    ],
)
def test_parameters_that_a_cycle_does_not_look_at_are_told(run: Run, cycle: str, said: list[str]) -> None:
    """They were passed over without a word, whatever they choose."""
    assert codes(run, f"G710 G90 S1000 M3 F200\nG0 X0 Y0 Z20\n{cycle}\nM30") == said


def test_functions_of_a_spindle_and_of_a_group_by_their_index(
    moves: Callable[..., list[tuple[float, ...]]],
) -> None:
    """M[1]=3 S[1]=500 are those of the first spindle: 0.2 mm at 500 rev/min; G[8]=3 is G55, the third of group 8."""
    text = "$P_UIFR[2]=CTRANS(X,10)\nM[2]=4 S[2]=9000\nR1=1\nM[R1]=3 S[R1]=500\nG95 F0.2\nG[8]=3 G1 X1\nG[8]=1\nG[14]=2 X1\nG[1]=1 X1\nM30"
    assert moves(text, dialect="sinumerik") == [(11, 0, 0, 100), (2, 0, 0, 100), (3, 0, 0, 0)]


def test_interrupts_and_files_of_the_control_move_nothing(run: Run) -> None:
    """Signals, dialogs and files: the subprogram of an interrupt is not called where SETINT names it."""
    text = 'SETINT(8) PRIO=1 AL600\nMMC("popup","N")\nWRITE(R1,"file","text")\nG0 X5\nCLRINT(8)\nM30'
    assert ends(run, text) == [[5, 0, 0]]
    found = run(text, dialect="sinumerik").diagnostics
    assert [(d.severity.value, d.code) for d in found if d.code != "units-assumed"] == [
        ("note", "interrupt-not-run")
    ]


@pytest.mark.parametrize(
    "action",
    [
        "ID=1 WHENEVER $AA_IW[X]>3 DO M7",
        "N5 WHEN $A_IN[1]==TRUE DO M8 $A_OUT[2]=1 H5 ; M3",
        "IDS=2 EVERY $A_IN[2]==1 do $A_OUTA[1]=5",
        "ID=3 WHEN $R11>=$$AA_IW[Z] DO M=37",
    ],
)
def test_outputs_of_synchronous_actions_move_nothing(run: Run, action: str) -> None:
    """Outputs and M functions that the control sends while blocks move: the motions are those without them, with a note."""
    text = f"{action}\nG0 X5\nCANCEL(1)\nM30"
    assert ends(run, text) == [[5, 0, 0]]
    assert ("note", "synchronous-output") in [
        (d.severity.value, d.code) for d in run(text, dialect="sinumerik").diagnostics
    ]


@pytest.mark.parametrize(
    "done",
    ["M3", "M17", "M2=3", "$AC_OVR=50", "POS[X]=5", "M8 POS[X]=5", "R1=5", "S500", "$AA_OFF[X]=1", "M1"],
)
def test_other_synchronous_actions_are_refused(run: Run, done: str) -> None:
    assert [
        code for code, *_ in run(f"ID=1 WHEN TRUE DO {done}\nG0 X5\nM30", dialect="sinumerik").errors
    ] == ["not-read"]


def test_an_origin_that_turns_about_z(run: Run) -> None:
    """$P_UIFR[1]=CTRANS(X,10,Y,5):CROT(Z,90): X of the program is Y of the machine, Y is -X (by hand); a frame turns within it."""
    text = """$P_UIFR[1]=CTRANS(X,10,Y,5):CROT(Z,90)
G54 G0 X10 Y0
G1 X10 Y5 F100
G2 X15 Y0 I0 J-5
G91 G1 X2
G90 TRANS X5
X0 Y0
ROT Z-90
X3 Y1
ROT
SUPA G0 X1 Y2
G53 X3
X0 Y1
R1=$P_UIFR[1,Z,RT]
$P_UIFR[1,Z,RT]=R1+90
X2 Y0
$P_UIFR[2]=$P_UIFR[1]:CROT(Z,-180)
G55 X4 Y2
G500 X1 Y1
M30"""
    machine = [
        [10, 15],
        [5, 15],
        [10, 20],
        [10, 22],
        [10, 10],
        [13, 6],
        [1, 2],
        [3, 2],
        [9, 5],
        [8, 5],
        [14, 7],
        [1, 1],
    ]
    assert ends(run, text) == [[*place, 0] for place in machine]


def test_directions_turn_with_an_origin(run: Run) -> None:
    """The same place and direction, in coordinates turned by 90 degrees about Z by the origin and by ROT."""
    trunnion = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))
    block = "TRAORI\nG0 X2 Y-10 Z3 A3=0.3 B3=-0.1 C3=1\nG1 X4 A3=0 B3=0.2 C3=1 F500\nM30"
    places = [
        run(f"{turned}\n{block}", dialect="sinumerik", kinematics=trunnion).path.end
        for turned in ("$P_UIFR[1]=CROT(Z,90)\nG54", "ROT Z90")
    ]
    assert places[0] == pytest.approx(places[1], abs=1e-9)
    assert np.ptp(places[0], axis=0).max() > 1.0
    plane = '$P_UIFR[1]=CROT(Z,90)\nG54\nCYCLE800(0,"",0,57,0,0,0,20,0,0,0,0,0,-1)\nM30'
    found = run(plane, dialect="sinumerik", kinematics=trunnion)
    assert [code for code, *_ in found.errors] == ["not-read"]


def test_functions_whose_output_is_not_waited_for(run: Run) -> None:
    """M=QU(8) is M8 that the control does not wait for (840D sl, Fundamentals, "Auxiliary function outputs")."""
    assert ends(run, "M=QU(8) H=QU(5)\nG0 X5 M=QU(9)\nM30") == [[5, 0, 0]]
    assert fault(run, "G0 X=QU(5)\nM30")[0] == "not-read"


def test_couplings_of_spindles_move_no_axis(run: Run) -> None:
    """A sub-spindle that turns with the main one takes a part over; a coupling of axes would move them, and is refused."""
    text = 'COUPDEF(S2,S1,1,1,"NOC","DV")\nCOUPON(S2,S1,113.5)\nCOUPON(SPI(2),SPI(1))\nG0 Z5\nCOUPOF(S2,S1)\nCOUPDEL(S2,S1)\nM30'
    assert ends(run, text) == [[0, 0, 5]]
    assert [code for code, *_ in run("COUPON(Y,X)\nG0 X5\nM30", dialect="sinumerik").errors] == ["not-read"]


def test_an_end_and_a_centre_of_another_plane_make_an_arc_there(run: Run) -> None:
    """840D sl, Fundamentals, "Circular interpolation": the axes of the end name the plane; by hand, quadrants and a half of radius 10.

    In the plane Z X, counter-clockwise leads from +Z to +X: from 10 below the centre along X, to 10 beyond it along Z.
    """
    text = "G17 G0 X50 Y0 Z0\nG3 X60 Z10 I10 K0 F100\nG1 X70\nG2 X60 Z0 I0 K-10\nG3 X60 Z20 K=AC(10) I=AC(60)\nG2 X70 Y10 I10 J0\nM30"
    toolpath = run(text, dialect="sinumerik").path
    arcs = toolpath.arcs
    assert arcs.centre.tolist() == [[60, 0, 0], [70, 0, 0], [60, 0, 10], [70, 0, 20]]
    assert arcs.sweep.tolist() == pytest.approx([math.pi / 2, math.pi / 2, math.pi, math.pi / 2])
    assert arcs.normal.tolist() == [[0, 1, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1]]
    # A helix stays in its plane, and a centre outside the plane of the end is no arc.
    helix = run("G17 G0 X0 Y0 Z0\nG2 X20 Z-5 I10 J0 F100\nM30", dialect="sinumerik").path
    assert helix.arcs.normal.tolist() == [[0, 0, -1]]
    for wrong in ("G2 X50 Y0 I-10 J0 K5", "G2 Y50 I-10 K5", "G2 K10 AR=90"):
        found = run(f"G17 G0 X50 Y0 Z0 F100\n{wrong}\nM30", dialect="sinumerik").errors
        assert [code for code, *_ in found] == ["arc-plane"]


#: A contour as the control's editor writes it, and what mills beside it, left, 5 away: its corner of 4 becomes one of 9.
EDITED = """CYCLE72("{}",100,0,1,5,5,0,0,300,100,1,41,1,5,300,1,5,0,1,2,101,1011,101)
M30
E_LAB_A_SQ: ;#SM Z:2
;#7__DlgK contour definition begin - Don't change!;*GP*;*RO*;*HD*
G17 G90 DIAMOF;*GP*
G0 X0 Y0 ;*GP*
G1 Y20 ;*GP*
X30 RND=4 ;*GP*
Y0 ;*GP*
X0 ;*GP*
;#End contour definition end - Don't change!;*GP*;*RO*;*HD*
E_LAB_E_SQ:
M17
"""


@pytest.mark.parametrize(
    ("call", "name"),
    [
        ('CYCLE62("SQ",1,,)', ""),
        ('CYCLE62("OTHER",0)\nCYCLE62()\nCYCLE62("SQ",1)', ""),
        ('CYCLE62(,2,"E_LAB_A_SQ","E_LAB_E_SQ")', ""),
        ("", "E_LAB_A_SQ:E_LAB_E_SQ"),
    ],
)
def test_a_contour_that_is_called_beforehand(run: Run, call: str, name: str) -> None:
    found = ends(run, f"$TC_DP6[1,1]=5\nT1 D1 M6\nS1000 M3\n{call}\n" + EDITED.format(name))
    assert [e[:2] for e in found[4:-1]] == [
        [-5, 0],
        [-5, 20],
        [0, 25],
        [26, 25],
        [35, 16],
        [35, 0],
        [30, -5],
        [0, -5],
        [-5, -5],
    ]


@pytest.mark.parametrize(
    ("line", "code", "part"),
    [
        ('CYCLE62("SQ",3)', "cycle-words", "TYPE = 3"),
        ('CYCLE62("SQ",2)', "cycle-words", "TYPE = 2"),
        (
            'CYCLE62("A",0)\nCYCLE62("B",0)\nCYCLE72("",100,0,1,-5,5,0,0,300,100,1,40)',
            "cycle-words",
            "not the name of a contour",
        ),
        ("G[3]=1", "not-read", "G[3]=1"),
        ("G[8]=200", "not-read", "G[8]=200"),
        ("G0 X1 MEASA=1", "not-read", "measuring"),
    ],
)
def test_faults_of_calls_and_groups(run: Run, line: str, code: str, part: str) -> None:
    found = fault(run, f"{line}\nM30")
    assert found[0] == code
    assert part in found[1]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        # NOT, then * and DIV, then +, the bits, AND, XOR, OR, <<, and comparisons last (840D, Programming Guide Advanced, 1.8).
        ("R1>2 AND R2", 1),
        ("R1>0 AND R2", 1),
        ("2 AND R2>0", 1),
        ("R1==4 OR 1", 0),
        ("NOT R1==0", 1),
        ("NOT (R1==0)", 1),
        ("NOT R1==5", 0),
        ("1 OR 0 AND 0", 1),
        ("1 OR 1 XOR 1", 1),
        ("6 B_AND 3 B_OR 8", 10),
        ("1+2 B_AND 2*3", 2),
        ("7 B_XOR 2 B_OR 2", 7),
        ("B_NOT 5+1", -5),
        ("10-4 DIV 2", 8),
    ],
)
def test_operators_bind_as_the_manual_has_it(run: Run, expression: str, value: float) -> None:
    """With R1 = 5 and R2 = 3: R1 == 4 OR 1 is R1 == (4 OR 1), 5 against 1; it was true here, and IF took the other branch."""
    assert ends(run, f"R1=5 R2=3\nG0 X={expression} Y9\nM30") == [[value, 9, 0]]


def test_two_comparisons_stand_in_brackets(run: Run) -> None:
    text = "R1=1 R2=2\nIF R1==1 AND R2==2 GOTOF THERE\nG0 X1\nTHERE:\nM30"
    error = next(d for d in run(text, dialect="sinumerik").diagnostics if d.severity == "error")
    assert (error.code, error.span.line, error.hint) == (
        "syntax",
        2,
        "AND and OR bind before comparisons: IF (R1==1) AND (R2==2)",
    )
    assert ends(run, text.replace("R1==1 AND R2==2", "(R1==1) AND (R2==2)")) == []
    # A join of texts comes before the comparison.
    assert ends(run, 'DEF STRING[9] NAME="A6"\nR1=5\nIF NAME=="A"<<R1+1\nG0 X1\nENDIF\nM30') == [[1, 0, 0]]


def test_machine_coordinates_are_those_of_the_tip_without_d0(run: Run) -> None:
    """With machine data 10760 = 0 G53, G153 and SUPA take offsets away, and the tool's length of 50 stays (ISO Milling, "G53"; D0 ends it)."""
    text = "$TC_DP3[1,1]=50\nT1 D1 M6\n$P_UIFR[1]=CTRANS(Z,7,X,3)\nG54 G0 Z0\n{} X1 Z100\nM30"
    assert ends(run, text.format("G0 SUPA"))[-1] == [1, 0, 150]
    assert codes(run, text.format("G0 SUPA")) == ["machine-length"]
    assert ends(run, text.format("G0 G53 D0"))[-1] == [1, 0, 100]
    assert codes(run, text.format("G0 G53 D0")) == []


@pytest.mark.parametrize(
    ("cycle", "depth", "said"),
    [
        ("CYCLE81(10,0,2,-5,8)", -8, ["cycle-depths"]),
        ("CYCLE82(10,1,2,-5,6,0)", -5, []),
        ("CYCLE81(10,0,2,-5,0)", -5, []),
        ("CYCLE81(10,0,2,,8)", -8, []),
        # AMODE chooses, whatever else is given.
        ("CYCLE82(10,0,2,-5,8,0,0,1,12)", -5, []),
        ("CYCLE82(10,0,2,-5,8,0,0,1,11)", -8, []),
    ],
)
def test_of_two_depths_the_distance_counts(run: Run, cycle: str, depth: float, said: list[str]) -> None:
    """ "If a value is entered both for DP and for DPR, the final drilling depth is derived from DPR" (840D, Cycles, CYCLE81)."""
    text = f"F100\n{cycle}\nM30"
    assert min(e[2] for e in ends(run, text)) == depth
    assert codes(run, text) == said


def test_of_two_first_depths_the_distance_counts(run: Run) -> None:
    text = "F100\nCYCLE83(10,0,2,-20,,-5,8,0,0,0,1,1)\nM30"
    assert [e[2] for e in ends(run, text)][:3] == [2, -8, 2]
    assert codes(run, text) == ["cycle-depths"]


def test_a_first_step_less_than_the_degression_is_said(run: Run) -> None:
    assert codes(run, "F100\nCYCLE83(10,0,2,-20,,,5,8,0,0,1,1)\nM30") == ["cycle-parameters"]
    assert codes(run, "F100\nCYCLE83(10,0,2,-20,,,8,8,0,0,1,1)\nM30") == []


def test_the_way_out_of_a_thread_that_is_stopped_moves_nothing(run: Run) -> None:
    text = "G18 DIAMOF\nG0 X10 Z0 S500 M3\nPOLF[X]=40\nPOLFMLIN(X,Z)\nLFON LFPOS DILF=5 ALF=3\nLFTXT\nLFWP\nG33 Z-20 K2\nLFOF\nM30"
    assert [[e[0], e[2]] for e in ends(run, text)] == [[10, 0], [10, -20]]
    assert codes(run, text) == []


def test_the_centre_of_an_arc_is_not_told_of_other_controls(run: Any) -> None:
    """SINUMERIK has no G90.1: a centre as a coordinate is I=AC(...)."""
    (fault,) = (
        d
        for d in run("F100\nG0 X10\nG2 X0 I5 J15\nM30", dialect="sinumerik").diagnostics
        if d.severity == "error"
    )
    assert fault.code == "arc-radius"
    assert "I=AC" in fault.hint
    assert "G90.1" not in fault.hint


def test_the_master_spindle(run: Any) -> None:
    """SETMS(4) of lathes with the main spindle 4: S4 and M4=3 are those that G95 follows; M20=151 is a function of the builder."""
    text = "SETMS(4)\nG18 DIAMON G95 S4=1200 M4=3 S1=50\nM20=151\nG0 X20 Z2\nG1 Z-10 F0.5\nSETMS\nS1=600\nG1 Z-20\nM30"
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    feeds = out.path.feed[(out.path.kind == 0) & ~np.isnan(out.path.feed)]
    assert feeds.tolist() == pytest.approx([10.0, 5.0])


def test_an_edge_is_chosen_under_traori(run: Any) -> None:
    """Posts write T M6 TRAORI G54 D1: the length is that of D1 from there on."""
    out = run(
        "T1 M6\nTRAORI\nG54\nG0 X1 Y2 Z3 A0 C0 D1\nG1 X4 F100\nTRAFOOF\nM30",
        dialect="sinumerik",
        kinematics=Kinematics(0, (3, 5)),
    )
    assert out.errors == []
    assert out.path.end[out.path.kind == 0][-1, :3].tolist() == [4, 2, 3]


@pytest.mark.parametrize(
    ("first", "x"), [("", 10.0), ('MSG("OHNE G17, DIAMOF")', 10.0), ("MSG('Y5')", 10.0), ("N10G17", 20.0), ("DIAMOF", 20.0), ("G0 Y=0", 20.0)]
)  # fmt: skip
def test_x_of_a_program_that_turns_is_a_diameter_unless_a_block_says_else(
    run: Any, first: str, x: float
) -> None:
    """G96 turns; what stands in a text says nothing."""
    out = run(f"{first}\nG96 S100 LIMS=2000 M3\nG0 X20\nM30", dialect="sinumerik")
    assert out.path.end[-1][0] == pytest.approx(x)


@pytest.mark.parametrize(
    ("change", "back", "x"),
    [("TRANS X10", "", 45), ("ATRANS X10", "", 45), ("TRANS X10\nG1 Y1", "", 45), ("TRANS X10\nG1 X30", "", 45),
     ("$P_UIFR[2]=CTRANS(X,10)\nG55", "", 45), ("TRANS X10", "TRANS", 35), ("MIRROR X0", "", -35)],
)  # fmt: skip
def test_increments_traverse_a_change_of_the_frame(run: Run, change: str, back: str, x: float) -> None:
    """As setting data 42440 = 1 says, with which the control comes: the coordinate of before, 30, plus 5, in the new frame."""
    text = f"G17 G90 F100\nG0 X30 Y0 Z0\n{change}\n{back}\nG1 X=IC(5)\nM30"
    assert ends(run, text)[-1][0] == x
    assert codes(run, text) == ([] if back or "X30" in change else ["frame-increment"])


def test_an_increment_of_another_axis_and_the_next_one_go_their_own_way(run: Run) -> None:
    text = "G17 G90 F100\nG0 X30 Y0 Z0\nTRANS X10\nG91 G1 Y5\nX5\nX5\nM30"
    assert ends(run, text)[1:] == [[30, 5, 0], [45, 5, 0], [50, 5, 0]]


def test_dwell_of_centring(run: Run) -> None:
    """CYCLE81 has DTB before GMODE DMODE AMODE on 840D sl: 0.2 s here, and 12 revolutions at 1200 a minute are 0.6 s."""
    for cycle, seconds in (("5,0,2,-5,,0.2,0,1,12", 0.2), ("5,0,2,-5,,12,0,1,22", 0.6), ("5,0,2,-5", 0.0)):
        out = run(f"G17 G90 F100 S1200 M3\nG0 Z5\nCYCLE81({cycle})\nM30", dialect="sinumerik")
        assert out.errors == []
        assert sum(event.dwell_s for event in out.path.events) == pytest.approx(seconds)


def test_a_turning_cycle_tells_a_lathe(run: Run) -> None:
    """A program without plane and DIAMON that calls CYCLE95 is a lathe's, as one with G96 is: X is a diameter, in G18."""
    text = """T1 D1
G95 F0.25 S1000 M3
G0 X44 Z2
CYCLE95("A1:E1", 2.5, 0, 0, 0, 0.25, 0.15, 0.1, 1)
GOTOF E1
A1: G0 X20 Z2
G1 Z0
X30 Z-10
E1: X40
M30"""
    out = run(text.replace("A1", "BEGIN").replace("E1", "FINIS"), dialect="sinumerik")
    assert out.errors == []
    assert out.path.end[:, 0].max() == 22.0
    assert "diameter-doubtful" in {d.code for d in out.diagnostics}


def test_constants_of_other_bases(run: Run) -> None:
    """Job planning, "Constants": 'HFF' is 255, 'B101' is 5."""
    assert ends(run, "R1='HFF' R2='b101'\nG17 G0 X=R1 Y=R2+'H0A'\nM30")[-1] == [255, 15, 0]


@pytest.mark.parametrize(
    ("mode", "inside", "outside"),
    [("", 60.0, 140.0), ("CFC", 60.0, 140.0), ("CFIN", 60.0, 100.0), ("CFTCP", 100.0, 100.0)],
)
def test_the_feed_of_compensated_arcs_is_that_along_the_contour(
    calls: Any, mode: str, inside: float, outside: float
) -> None:
    """808D, "Programming and Operating, Milling" (2014), page 79: F (r - r_tool) / r inside, F (r + r_tool) / r outside; CFC is usual.

    A tool of radius 4 in an arc of radius 10, left of it and right of it; the lines beside it and the arc at the corner keep F.
    """
    for code, feed in (("G41", inside), ("G42", outside)):
        text = f"""$TC_DP6[1,1]=4
T1 D1 M6
G17 G90 G0 X-20 Y-30 Z0
{mode}
{code} G1 X0 Y-10 F100
X10
G3 X20 Y0 CR=10
G1 Y30
G40 X50 Y50
M30"""
        feeds = [
            float(line[14:-1])
            for line in calls(text, dialect="sinumerik")
            if line.startswith("SET_FEED_RATE(")
        ]
        assert feeds[:-1] == ([100.0] if feed == 100.0 else [100.0, feed, 100.0])


@pytest.mark.parametrize(
    "lines", ["LIMS=3000\nG96 S200 M3", "G96 S200 M3\nLIMS=3000", "G96 S200 M3 LIMS=3000", "LIMS[1]=3000\nG96 S200 M3", "G92 S3000\nG96 S200 M3"]
)  # fmt: skip
def test_the_bound_of_the_speed_stands_before_in_and_behind_g96(calls: Any, lines: str) -> None:
    """At X4 200 m a minute would be 15,900 turns; the mode of the spindle has the bound of 3000 as the motion begins."""
    found = calls(f"G18 G90 G95 DIAMON\n{lines}\nG0 X4 Z0\nG1 Z-100 F0.1\nM30", dialect="sinumerik")
    bounds = [line.split("SET_SPINDLE_MODE(")[1] for line in found if "SET_SPINDLE_MODE(" in line]
    assert bounds[-2] == "0 3000.0000)"


@pytest.mark.parametrize(
    ("line", "code"),
    [("FGROUP(X,Y)", "feed-group"), ("FGREF[A]=12.5", "feed-group"), ("R1=$AC_TIMER[1]", "counter-stands"),
     ("FGROUP(X,Y,Z)", None), ("FGROUP()", None),  ("$AC_TIMER[1]=0", None), ("DRFOF", None), ("CP", None), ("CANCEL(1)", None), ("SETPIECE(1)", None),
     ("IPTRLOCK", None), ("OSC", None), ("CALLPATH(\"/_N_WKS_DIR/_N_A_WPD\")", None), ("$A_OUT[3]=1", None), ("GEOAX()", None),
     ("GEOAX(1,X,2,Y)", None), ("SCC[X]", None), ("scc [ x ]", None), ("DELETE(R1,\"LOG\")", None)],
)  # fmt: skip
def test_words_that_move_nothing(run: Run, line: str, code: str | None) -> None:
    assert codes(run, f"{line}\nG0 X1\nM30") == ([] if code is None else [code])
    assert ends(run, f"{line}\nG0 X1\nM30") == [[1, 0, 0]]


@pytest.mark.parametrize(
    ("before", "code", "feeds", "mode"),
    [
        ("G94", "G96 S100", [0.0, 0.2], "0, 1"),
        ("F0.3", "G96 S100", [0.3, 0.0, 0.3, 0.2], "0, 1"),
        ("G95 F0.3", "G961 S100", [0.0, 0.3, 0.0, 0.2], "0, 0"),
        ("G95 F0.3", "G962 S100", [0.0, 0.3, 0.2], "0, 1"),
        ("G96 S100", "G971 S500", [0.0, 0.0, 0.2], "0, 0"),
        ("G96 S100", "G972 S500", [0.0, 0.2], "0, 1"),
        ("G94", "G97 S500", [0.0, 0.2], "0, 1"),
        ("G94 F100", "G97 S500", [100.0, 0.0, 0.2], "0, 1"),
        ("G94", "G973 S500", [0.0, 0.2], "0, 1"),
    ],
)
def test_constant_cutting_rate_says_what_f_is(
    calls: Any, before: str, code: str, feeds: list[float], mode: str
) -> None:
    """Fundamentals, "Constant cutting rate": G96 has the feed of G95, G961 and G971 that of G94; a change ends F that G94 or G95 said. G97 without
    G96 "has the same effect as G95" (10/2004, 7.13), G973 is "revolutional" (SINUMERIK ONE, NC programming 12/2019, 2.7); both kept G94."""
    found = calls(f"DIAMON G18 M3 S300\n{before}\n{code}\nG1 X10 Z-5 F0.2\nM30", dialect="sinumerik")
    said = [line[14:-1] for line in found if line.startswith("SET_FEED_MODE(")]
    assert [float(line[14:-1]) for line in found if line.startswith("SET_FEED_RATE(")][:-1] == feeds
    assert said[-2] == mode


def test_an_origin_by_its_frame_variable(run: Run) -> None:
    """$P_IFRAME=$P_UIFR[n] puts an origin in force as G54 to G57 do, and $P_UIFR[3]=$P_UIFR[2] copies one."""
    text = "$P_UIFR[2]=CTRANS(X,100,Y,20)\nR1=2\n$P_IFRAME=$P_UIFR[R1]\nG0 X1 Y1\n$P_UIFR[3]=$P_UIFR[2]\nG56 X2\n$P_IFRAME=$P_UIFR[0]\nX3 Y1\nM30\n"
    assert ends(run, text) == [[101, 21, 0], [102, 21, 0], [3, 1, 0]]


def test_a_motion_with_meas_is_planned_to_its_end_and_kept(run: Run) -> None:
    """The variables of the probe have the end of that motion, not the place of a later one (Job planning 03/2006, 5.7)."""
    text = "G54 G0 X5 Z50\nMEAS=1 G1 Z-10 F300\nG0 Z50\nIF $AC_MEA[1]==0 GOTOF ENDE\nX=$AA_MW[Z] Z=$AA_MM[X]\nENDE:\nM30\n"
    out = run(text, dialect="sinumerik")
    assert ends(run, text) == [[5, 0, 50], [5, 0, -10], [5, 0, 50], [-10, 0, 5]]
    assert [d.code for d in out.diagnostics if d.severity == "note"] == ["probe-not-run"]


@pytest.mark.parametrize(
    "cycle",
    [
        'CYCLE978(100,9000,,1,5,3,2,3,2,1,"",,0,1.01,1.01,-1.01,0.34,1,0,,1,1)',
        'CYCLE977(103,9000,,1,20,,,10,2,0,10,28,,1,1,"",,0,1.01,1.01,-1.01,0.34,1,0,,1,1)',
        "CYCLE961",
    ],
)
def test_measuring_cycles_are_passed_over_with_a_warning(run: Run, cycle: str) -> None:
    """They lead back to where they began (840D sl, Measuring cycles 03/2009), and nothing can be touched here."""
    text = f"G54 G0 X5 Z50\n{cycle}\nX6\nM30\n"
    assert ends(run, text) == [[5, 0, 50], [6, 0, 50]]
    assert codes(run, text) == ["probe-not-run"]


def test_a_cycle_that_is_not_read_says_what_it_does_and_what_stands_in_its_place(run: Run) -> None:
    found = run('CYCLE952("A",,"",1)\nCYCLE3106(1)\nM30', dialect="sinumerik").diagnostics
    told = [(d.code, d.message, d.hint.split(";")[0]) for d in found if d.severity == "error"]
    assert told == [
        (
            "not-read",
            "the cycle CYCLE952 (stock removal) is not read",
            "CYCLE95 roughs and finishes a contour",
        ),
        ("not-read", "the cycle CYCLE3106 is not read", "docs/sinumerik.md lists those that are read"),
    ]


def test_a_cycle_of_the_machines_builder_is_a_subprogram(run: Run) -> None:
    """It was refused although the text has it: cycles of the builder and the user are programs like any (840D sl, Job planning)."""
    text = "CYCLE3106(1,2)\nM30\n%_N_CYCLE3106_SPF\nPROC CYCLE3106(REAL A, REAL B)\nG0 X=A Y=B\nRET"
    assert ends(run, text) == [[1, 2, 0]]


def test_a_tool_change_under_g96_leaves_the_spindle_turning(run: Run) -> None:
    """A lesson's shaft: T2 D1 M6 stands before CYCLE95, whose feed per revolution was no number. A cycle with the spindle at rest is told."""
    head = "G18 DIAMON G90\nLIMS=2500\nT1 D1 M6\nG96 S250 F0.1 M4\nG0 X40 Z5\n"
    tail = 'CYCLE95("WAY",1,0,0,0,0.1,0.05,0.05,5,0,0,0)\nM30\n%_N_WAY_SPF\nG0 X10 Z2\nG1 Z-5\nX30 Z-15\nX40\nM17'
    out = run(f"{head}T2 D1 M6\n{tail}", dialect="sinumerik")
    assert out.errors == []
    feeds = out.path.feed[out.path.feed_mode == 0]
    assert len(feeds)
    assert (feeds[np.isfinite(feeds)] > 0).tolist() == [True] * len(feeds)
    assert fault(run, f"{head}M5\n{tail}")[0] == "spindle-stopped"


def test_an_end_without_a_beginning_counts_where_a_run_meets_it(run: Run) -> None:
    """A grinder's cycle has an ENDIF that a GOTOF before it passes by; alarm 12640 is of what the control runs. It was refused."""
    text = "G0 X1\nGOTOF AWAY\nENDIF\nAWAY: X2\nIF R1==0 GOTOF DONE\nENDIF\nDONE: X3\nM30"
    assert ends(run, text) == [[1, 0, 0], [2, 0, 0], [3, 0, 0]]
    assert fault(run, "IF R1==1 GOTOF DONE\nENDIF\nDONE: X3\nM30")[0] == "flow-unmatched"


def test_signals_of_the_machine_count_as_zero(run: Run) -> None:
    """$A_IN and the data of the PLC, $A_DBB, are the machine's; what the program sets of them is read back."""
    text = "G0 X1\nIF $A_IN[3]==1 GOTOF AWAY\nX=4+$A_DBB[2]\n$A_DBB[2]=7 $A_OUT[1]=1\nX=$A_DBB[2]\nX=$A_OUT[1]+$A_INA[2]\nAWAY: X9\nM30"
    assert ends(run, text) == [[1, 0, 0], [4, 0, 0], [7, 0, 0], [1, 0, 0], [9, 0, 0]]
    told = [
        d.message.split(" is ")[0]
        for d in run(text, dialect="sinumerik").diagnostics
        if d.code == "variable-assumed"
    ]
    assert told == ["$A_IN[3]", "$A_DBB[2]", "$A_INA[2]"]


def test_a_subprogram_whose_name_begins_as_a_step_of_shopmill_does(run: Run) -> None:
    """A grinder's program calls its own F_TP_GRINDING_PARAMETERS(…); it was refused as a step, though its file was there."""
    text = "DEF REAL HALF\nF_TP_SIZES(4,HALF)\nG0 X=HALF\nM30\n%_N_F_TP_SIZES_SPF\nPROC F_TP_SIZES(REAL ALL, VAR REAL PART)\nPART=ALL/2\nRET"
    assert ends(run, text) == [[2, 0, 0]]
    out = run("F_TP_SIZES(4)\nM30", dialect="sinumerik")
    assert [(e[0], e[1]) for e in out.errors] == [("not-read", 1)]


@pytest.mark.parametrize(
    ("dialect", "text", "at"),
    [
        (
            "sinumerik",
            "G0 X0\nTRANS X-100 Z-7\nG0 X10 Z10\nT2 D1\nM6\nG0 Y20\nM30\n",
            "-90.0000, 20.0000, 3.0000",
        ),
        (
            "heidenhain",
            "BEGIN PGM A MM\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X-100\nCYCL DEF 7.2 Z-7\n"
            "L X+10 Z+10 FMAX\nTOOL CALL 2 Z S1000\nL Y+20 FMAX\nEND PGM A MM\n",
            "-90.0000, 20.0000, 3.0000",
        ),
        (
            "fanuc",
            "G21 G90\nG0 X10. Z10.\nG51.1 X0.\nT2 M6\nG0 Y20.\nM30\n",
            "10.0000, 20.0000, 10.0000",
        ),
    ],
)
def test_a_tool_change_in_a_frame_leaves_the_tool_where_it_is(
    calls: Run, dialect: str, text: str, at: str
) -> None:
    """`canon` put it off by the frame once more: after TRANS X-100 the next motion went from X-90 to X-190."""
    motions = [c for c in calls(text, dialect=dialect) if "STRAIGHT_TRAVERSE" in c]
    assert motions[-1] == f"STRAIGHT_TRAVERSE({at}, 0.0000, 0.0000, 0.0000)"


def test_a_jump_to_a_number(run: Run) -> None:
    """GOTOF 90 goes to block N90 ("block number, e.g. 200, N300": 840D sl, Fundamentals, "Program jumps")."""
    assert ends(run, "N10 G0 X1\nGOTOF 90\nN20 X2\nN90 X3\nM30") == [[1, 0, 0], [3, 0, 0]]


def test_the_degree_of_a_spline_stands_alone(run: Run) -> None:
    """SD in the block of BSPLINE, and the points behind it, as a public interpreter's example has it: five points of degree 2, uniform."""
    out = run(
        "G1 X0 Y0 F100\nBSPLINE SD=2\nX10 Y20\nX30 Y40\nX50 Y10\nX60 Y20\nG1 X70\nM30", dialect="sinumerik"
    )
    assert out.errors == []
    assert out.path.nurbs.degree.tolist() == [2]
    assert out.path.nurbs.knots.tolist() == [0, 0, 0, 1, 2, 3, 3, 3]


def test_a_subprogram_is_called_by_the_name_of_its_file(run: Run, tmp_path: Path) -> None:
    """A generator of programs for 840D writes _N_CMP_INIT_SPF; the control names files so."""
    (tmp_path / "CMP_INIT.SPF").write_text("G0 Y3\nRET\n")
    main = tmp_path / "MAIN.MPF"
    main.write_text("G0 X1\n_N_CMP_INIT_SPF;\nM30\n")
    found = read(main, "MAIN.MPF", ReadOptions(dialect="sinumerik"))
    rows = np.concatenate([chunk.end[chunk.kind != 3, :2] for chunk in found.chunks()])
    assert [d.code for d in found.diagnostics if d.severity == "error"] == []
    assert rows.tolist() == [[1, 0], [1, 3]]


def test_functions_of_texts(run: Run) -> None:
    """Places count from 0; -1 is none (840D sl, Job planning, "String operations")."""
    text = 'DEF STRING[20] AA="part_12"\nIF TOUPPER(AA)<<"X"=="PART_12X"\nG0 X=NUMBER(SUBSTR(AA,5)) Y=STRLEN(AA << "xy") Z=INDEX(AA,"_")\nENDIF\nIF ISNUMBER(SUBSTR(AA,5,1))\nG0 X=RINDEX(TOLOWER("AB"),"c")\nENDIF\nM30'
    assert ends(run, text) == [[12, 9, 4], [-1, 9, 4]]


@pytest.mark.parametrize(
    ("call", "code"),
    [("STRLEN(5)", "value-kind"), ('SUBSTR("A","b")', "value-kind"), ('SUBSTR("A")', "function-arguments"), ('NUMBER("1_0")', "value-kind")],
)  # fmt: skip
def test_functions_of_texts_take_texts(run: Run, call: str, code: str) -> None:
    assert fault(run, f"R1={call}\nG0 X1\nM30")[0] == code


def test_the_depth_of_a_shank_is_taken_as_that_of_the_tip(run: Run) -> None:
    """GMODE = 10 of drilling, which programs made at the control have, was refused."""
    text = "F100\nG0 Z10\nCYCLE82(10,0,2,-5,,0,10,1,12)\nM30"
    assert min(z for *_, z in ends(run, text)) == -5
    assert codes(run, text) == ["tool-assumed"]


def test_feed_types_by_their_group(run: Run) -> None:
    """Group 15: 4 is G96, 7 is G961, 8 is G971 (840D sl, Fundamentals, "G functions"), as a generator of programs writes them."""
    text = "S1000 M3\nG95\nG[15]=8 F200\nTOWSTD\nG1 X10\nM30"
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    assert out.path.feed[out.path.kind != 3][0] * 60.0 == pytest.approx(200.0)


def test_f_stays_in_force_under_g93(run: Run) -> None:
    """Each block with a feed under G93 was refused: the interpreter wants F in each, the control keeps it (840D sl, Fundamentals, "Feedrate")."""
    out = run("G0 X0\nG93 F10 G1 X5\nG3 X10 I2.5\nG1 Y5 F20\nG94 F300 X0\nM30", dialect="sinumerik")
    assert out.errors == []
    moved = out.path.kind != 3
    assert (out.path.feed[moved] * 60.0).round(6).tolist()[-4:] == [10, 10, 20, 300]
    assert out.path.feed_mode[moved].tolist()[-4:] == [FeedMode.INVERSE_TIME] * 3 + [0]


def test_an_f_of_another_unit_is_none_under_g93(run: Run) -> None:
    """F500 a minute would be a block in 0.12 s."""
    assert fault(run, "G1 X1 F500\nG93 X5\nM30")[0] == "feed-missing"


def test_isfile_looks_for_a_program(run: Run) -> None:
    """828D, Job planning 07/2010, 1.21 "Check for presence of file": with or without _N_ and _SPF; it was refused."""
    text = 'DEF BOOL HERE\nHERE=ISFILE("_N_PART_SPF")\nG0 X=HERE Y=ISFILE("OTHER") Z=ISFILE("PART")\nM30\n%_N_PART_SPF\nG0 X9\nM17\n'
    assert ends(run, text)[-1] == [1, 0, 1]


@pytest.mark.parametrize("line", ["GEOAX(1,U)", "TANGON(C,0)", "TCARR", "REPOSA", "CUT3DCC", "SON"])
def test_commands_that_would_move_otherwise_are_refused_by_name(run: Run, line: str) -> None:
    """TANGON, REPOSA and SON were called no commands."""
    assert [code for code, *_ in run(f"{line}\nG0 X1\nM30", dialect="sinumerik").errors] == ["not-read"]


@pytest.mark.parametrize(
    ("before", "feed", "expected"),
    [
        ("G94\nG97", 200, ["feed-doubtful"]),
        ("G95", 200, ["feed-doubtful"]),
        ("G97", 0.3, []),
        ("G971", 200, []),
        ("G94", 200, []),
    ],
)
def test_a_feed_a_revolution_that_nobody_can_mean(
    run: Run, before: str, feed: float, expected: list[str]
) -> None:
    """200 mm a revolution, at 2000 rev/min 400 m a minute, where G97 has ended G94."""
    assert codes(run, f"M3\n{before} S2000\nG1 X10 F{feed}\nX20 F{feed}\nM30") == expected


def test_g_functions_in_force_are_read(run: Run) -> None:
    """Places in the groups as of G[8]=2 (840D sl, Fundamentals, "G functions"); the basic system is metric."""
    text = "G17 G54 G90 G710 G64 G451\nR1=$P_GG[6]*100000+$P_GG[8]*10000+$P_GG[14]*1000+$P_GG[13]*100+$P_GG[10]*10+$P_GG[18]\n"
    more = "G19 G505 G91 G700 G60 G0\nR2=$P_GG[6]*10000+$P_GG[8]*1000+$P_GG[14]*100+$P_GG[13]*10+$P_GG[10]\nG710 G90 G17\n"
    last = "X=R1 Y=R2 Z=$P_GG[1]*10+$P_GG[7]+$P_MC+$MN_SCALING_SYSTEM_IS_METRIC\nM30"
    assert ends(run, text + more + last)[-1] == [121422, 36231, 12]


def test_g_functions_that_are_not_kept_are_refused(run: Run) -> None:
    assert fault(run, "G95 F0.1\nR1=$P_GG[15]\nM30")[0] == "variable-unknown"


def test_m6_in_a_subprogram_is_the_programs(run: Run) -> None:
    """A note said that the program has no M6."""
    text = "G17 G90\nCHANGE(3)\nG0 X1\nM30\n%_N_CHANGE_SPF\nPROC CHANGE(INT NR)\nT=NR\nM6\nM17\n"
    out = run(text, dialect="sinumerik")
    assert [d.code for d in out.diagnostics if d.code == "tool-at-once"] == []


@pytest.mark.parametrize(
    ("blocks", "drilled"),
    [
        ("X10", [10]),
        ("G0\nX10", [0, 10]),
        ("G1 G90\nX10", [0, 10]),
        ("F200\nS600\nX10", [0, 0, 10]),
        ("S600 M3\nX10", [0, 10]),
        # A modal function alone, a dwell, and words beside G0 call nothing.
        ("G90\nG4 F1\nM8\nG0 M8\nX10", [10]),
    ],
)
def test_mcall_calls_in_blocks_without_a_motion(run: Run, blocks: str, drilled: list[float]) -> None:
    """S or F under G0 or G1, and G0 or G1 alone or with other G functions, call as well (840D sl, Job planning, "Modal subprogram
    call (MCALL)"): holes were left out without a word."""
    text = f"G17 G90 G54 S500 M3\nG0 X0 Y0 Z20\nF100\nMCALL CYCLE81(10,0,2,-5)\n{blocks}\nMCALL\nF50\nM30"
    assert [x for x, _, z in ends(run, text) if z == -5] == drilled
    assert codes(run, text) == ["modal-call"] * (len(drilled) > 1)


@pytest.mark.parametrize(
    ("words", "x"),
    [
        ("DIAMON\nG0 X20", 10), ("DIAMON\nG0 X20\nX=RAC(20)", 20), ("DIAMON\nG0 X20\nX=RIC(20)", 30), ("DIAMON\nG0 X20\nX=DIC(20)", 20),
        ("DIAMOF\nG0 X20\nX=DAC(20)", 10), ("DIAMOF\nG0 X20\nX=DIC(20)", 30), ("DIAM90\nG91 G0 X5 X1=0\nX=DAC(4)", 2),
    ],
)  # fmt: skip
def test_diameters_and_radii_of_one_value(run: Run, words: str, x: float) -> None:
    """840D sl, Fundamentals, "DAC, DIC, RAC, RIC"."""
    assert ends(run, f"G18 G90\n{words.replace(' X1=0', '')}\nM30")[-1][0] == x


@pytest.mark.parametrize("word", ["Z=DAC(4)", "I=RAC(1)", "RP=DAC(4)"])
def test_diameters_and_radii_are_of_x(run: Run, word: str) -> None:
    assert fault(run, f"G18 G0 {word}\nM30")[0] == "axis-mode"


def test_leading_zeros_are_of_the_name_of_l(run: Run) -> None:
    """ "L123, L0123 and L00123 are three programs" (840D sl, Job planning): L0123 ran L123."""
    text = "G91 G0\nL0123\nL123 P2\nM30\n%_N_L123_SPF\nX1\nM17\n%_N_L0123_SPF\nY1\nM17\n"
    assert ends(run, text)[-1][:2] == [2, 1]


def test_main_blocks_folders_and_signs_between_words(run: Run) -> None:
    """: numbers a main block, & parts words, PCALL names a folder, S0 is the master spindle (840D sl, Fundamentals, Job planning)."""
    text = "G90&G0&X1 S0=500\nGOTOF 110\nX77\n:110 X14\nGOTOF 120\n:120 R1=2\nPCALL/_N_WKS_DIR/_N_WELLE_WPD/WELLE(3)\nPCALL /_N_SPF_DIR/WELLE(R1)\nM30\n%_N_WELLE_SPF\nPROC WELLE(REAL QQ)\nY=IC(QQ)\nM17\n"
    assert ends(run, text) == [[1, 0, 0], [14, 0, 0], [14, 3, 0], [14, 5, 0]]


@pytest.mark.parametrize(("mode", "feed"), [("G94", 750), ("G95", 1.25)])
def test_without_encoder_cycle840_takes_the_lead_from_the_feed(run: Run, mode: str, feed: float) -> None:
    """ENC = 1: "the feed has to be the speed times the pitch" (840D sl, CYCLE840): 1.25 at 600 a minute; it was refused without PIT."""
    text = f"G17 G90 {mode} S600 M3\nG0 X0 Y0 Z10\nF{feed}\nCYCLE840(10,0,2,-10,,0,4,3,1)\nM30"
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    rows = out.path.kind != 3
    tapped = out.path.feed[rows & (out.path.end[:, 2] == -10)] * 60
    assert tapped == pytest.approx([750])


@pytest.mark.parametrize("chosen", ["G17", "G18"])
def test_lengths_of_tools_are_read_back_in_any_plane(run: Run, chosen: str) -> None:
    """A datum is what was set, whatever plane is in force as it is read: X is 300 / 2 + 5 and Z is 7 + 10 (840D sl, Tools: $TC_DP3 is length 1)."""
    other = {"G17": "G18", "G18": "G17"}[chosen]
    text = f"{chosen}\n$TC_DP3[1,1]=300 $TC_DP4[1,1]=7\n{other} DIAMOF\nTRANS X=$TC_DP3[1,1]/2 Z=$TC_DP4[1,1]\nG0 X5 Z10\nM30"
    assert ends(run, text)[-1] == [155, 0, 17]


@pytest.mark.parametrize(
    "line", ["TRANS X1 ROT Z30", "ROT Z30 TRANS X1", "TRANS X1 MIRROR Y0", "TRANS X1 ATRANS Y2"]
)
def test_a_frame_has_a_block_of_its_own(run: Run, line: str) -> None:
    """A frame is programmed in a separate block (840D sl, Fundamentals, "Frame instructions"): which axes would be of which?"""
    found = fault(run, f"T1 M6\nF100\n{line}\nG1 X5 Y5\nM30")
    assert found[0] == "modal-conflict"
    assert "a frame has a block of its own" in found[1]


def test_the_feed_of_corners_and_tolerances_of_g0_may_stand_alone(run: Run) -> None:
    text = "T1 M6\nF100\nFRCM=50\nCTOLG0=0.1\nOTOLG0=0.2\nG1 X5 RND=1 FRC=20\nY5\nM30"
    assert ends(run, text) == [[4, 0, 0], [5, 1, 0], [5, 5, 0]]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("$TC_DP3[1,1]=50\nT1 D1 M6\nG18\nG0 X5", ["length-plane"]),
        ("$TC_DP3[1,1]=50\nT1 D1 M6\nG19\nG0 X5", ["length-plane"]),
        ("$TC_DP3[1,1]=50\nT1 D1 M6\nG17\nG0 X5", []),
        ("T1 D1 M6\nG18\nG0 X5", []),
        ("DIAMON G18\n$TC_DP3[1,1]=50 $TC_DP4[1,1]=9\nT1 D1\nG18\nG0 X5", []),
    ],
)
def test_the_length_of_a_mill_goes_with_the_plane_on_the_control(
    run: Run, lines: str, told: list[str]
) -> None:
    """Length 1 of a milling tool is along Z in G17, Y in G18, X in G19 (840D sl, Tools), unless setting data 42940 says another plane."""
    assert codes(run, f"{lines}\nM30") == told


def test_corners_have_the_feed_of_frc_and_frcm(run: Run) -> None:
    """FRC= is the feed of that corner alone, FRCM= that of all until FRCM=0 (840D sl, Fundamentals, "Chamfer, rounding"): by hand."""
    text = (
        "T1 M6\nF600\nG1 X20 RND=2 FRC=60\nY20 F1200\nX40 CHR=1\nY40\nFRCM=120\n"
        "X60 RNDM=1\nY60 CHR=1 FRC=180\nX80\nY80 FRCM=0\nX100 RNDM=0\nM30"
    )
    path = run(text).path
    moves = path.kind != 3
    feeds = [10, 1, 20, 20, 20, 20, 20, 2, 20, 3, 20, 2, 20, 20, 20]
    np.testing.assert_allclose(path.feed[moves], feeds)
    assert not [event.name for event in path.events if event.name == "corner-feed"]


@pytest.mark.parametrize(
    ("line", "word"), [("G1 X5 RNDM=-1", "RNDM=-1"), ("G1 X5 RND=-1", "RND=-1"), ("G1 X5 CHF=-1", "CHF=-1")]
)
def test_a_corner_of_a_size_below_0_is_called_by_its_name(run: Run, line: str, word: str) -> None:
    assert fault(run, f"T1 M6\nF100\n{line}\nY5\nM30")[:2] == ("corner-size", f"{word} is negative")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('SUB\nG0 X1\nOUT: G0 X3\nM30\nPROC SUB\nG0 X9\nRET("OUT")\nG0 X8\nM17', [9, 3]),
        (
            'OUT: G0 X3\nR1=R1+1\nIF R1>1 GOTOF DONE\nSUB\nG0 X1\nDONE: M30\nPROC SUB\nG0 X9\nRET("OUT")\nM17',
            [3, 9, 3],
        ),
        ('SUB\nG0 X1\nOUT: G0 X3\nG0 X4\nM30\nPROC SUB\nRET("OUT",1)\nM17', [4]),
        ("SUB\nG0 X1\nN300 G0 X3\nM30\nPROC SUB\nRET(300)\nM17", [3]),
        ("SUB P3\nG0 X7\nM30\nPROC SUB\nR1=R1+1\nG0 X=R1\nRET()\nM17", [1, 2, 3, 7]),
        ('AA\nG0 X1\nOUT: G0 X3\nM30\nPROC AA\nBB\nOUT: G0 X5\nM17\nPROC BB\nRET("OUT",0,2)\nM17', [3]),
        ('AA\nG0 X1\nOUT: G0 X3\nM30\nPROC AA\nBB\nOUT: G0 X5\nM17\nPROC BB\nRET("OUT")\nM17', [5, 1, 3]),
        ("AA\nG0 X1\nM30\nPROC AA\nBB\nG0 X5\nM17\nPROC BB\nRET(,,2)\nM17", [1]),
        (
            'FOR R1=1 TO 5\nSUB\nENDFOR\nOUT: G0 X3\nM30\nPROC SUB\nG0 X=R1\nIF R1>1\nRET("OUT")\nENDIF\nM17',
            [1, 2, 3],
        ),
        # What a subprogram leaves is no program without end.
        (
            'AGAIN: R1=R1+1\nSUB\nGOTOB AGAIN\nOUT: G0 X3\nM30\nPROC SUB\nG0 X=R1\nIF R1>1\nRET("OUT")\nENDIF\nM17',
            [1, 2, 3],
        ),
    ],
)
def test_a_subprogram_returns_to_a_target(run: Run, text: str, expected: list[float]) -> None:
    """From memory of 840D sl, Job planning, "Parameterizable subprogram return (RET)": target, the line behind it, the number of calls; it was refused."""
    assert [place[0] for place in ends(run, f"G90\n{text}\n")] == expected
    found = run(f"G90\n{text}\n", dialect="sinumerik").diagnostics
    assert ("cycle-parameters" in [d.code for d in found]) == bool(re.search(r"RET\([^)]*,", text))


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ('SUB\nM30\nPROC SUB\nRET("END")\n', "label-missing"),
        ('SUB\nEND: M30\nPROC SUB\nRET("END",0,2)\n', "call-depth"),
        ('END: RET("END")\nM30\n', "call-depth"),
        ('SUB\nEND: M30\nPROC SUB\nRET("END",0,1,1)\n', "unsupported-block"),
    ],
)
def test_a_return_that_leads_nowhere_is_an_error(run: Run, text: str, code: str) -> None:
    assert fault(run, text)[0] == code


@pytest.mark.parametrize(
    ("head", "end"),
    [("REAL A, REAL B", [0, 0]), ("REAL A=7, REAL B", [7, 0]), ("VAR REAL A, INT B=3", [0, 3])],
)
def test_a_subprogram_that_nothing_calls(run: Run, head: str, end: list[float]) -> None:
    """A PROC read alone, as of a collection: its parameters have their usual values, or 0, and a warning names those; it was refused."""
    out = run(f"PROC WEG({head})\nG0 X1 Y1\nG0 X=A Y=B\nRET\n", dialect="sinumerik")
    assert out.errors == []
    assert out.path.end[-1, :2].tolist() == end
    [told] = [d for d in out.diagnostics if d.code == "variable-assumed"]
    assert ("A" in told.message.split(": ")[1]) == ("A=" not in head)


def test_arrays_of_a_subprogram_that_nothing_calls(run: Run) -> None:
    text = "PROC SUMME(VAR REAL FELD[2,3], REAL TEIL)\nFELD[1,2]=4\nG0 X=FELD[1,2] Y=FELD[0,0]+TEIL\nRET\n"
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    assert out.path.end[-1, :2].tolist() == [4, 0]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("$R[20]=4\nX=$R[20]+R20", [8]),
        ("LAB1: $AC_MARKER[1]=$AC_MARKER[1]+1\nX=$AC_MARKER[1]\nIF $AC_MARKER[1]<3 GOTOB LAB1", [1, 2, 3]),
        ("$SC_DRY_RUN_FEED=5\nX=$SC_DRY_RUN_FEED", [5]),
        ("ACC[S1]=50 VELOLIM[S1]=100\nH0=3 H[0]=4 H50=50 X1", [1]),
        ("CUTCONOF COMPPATH\nSTOLF=2 ATOL[C]=1 CUTMOD=0 OVRRAP=100 X1", [1]),
    ],
)
def test_memory_of_the_channel_and_idle_words(run: Any, body: str, expected: list[float]) -> None:
    """840D sl, Job planning and List of system variables: $R is R, $AC_MARKER is 0 until a program sets it."""
    out = run(f"G1 F100\n{body}\nM30", dialect="sinumerik")
    assert out.errors == []
    assert out.path.end[out.path.kind < 3, 0].tolist() == expected


def test_the_cutting_speed_gives_the_speed_of_the_spindle(calls: Any) -> None:
    """SVC: 100 m a minute at the edge of a tool 10 mm wide are 100 / (0.01 pi) revolutions a minute; M[0] and M0= are the master spindle."""
    out = calls("$TC_DP6[1,1]=5\nT1 D1 SVC=100 M0=3\nM[0]=5\nSVC[1]=50\nM30", dialect="sinumerik")
    speeds = [float(line[:-1].split(", ")[1]) for line in out if line.startswith("SET_SPINDLE_SPEED")]
    assert speeds == pytest.approx([100 / (0.01 * math.pi), 50 / (0.01 * math.pi)], abs=1e-4)
    assert "START_SPINDLE_CLOCKWISE(0)" in out


@pytest.mark.parametrize(
    "word", ["TOFFL=1", "TOFF[X]=1", "PTP", "INVCW X5", "FXS[X]=1", "CUTCONON", "CUTMOD=2", "FPO(1,2)"]
)
def test_commands_that_are_not_read_are_named_as_such(run: Any, word: str) -> None:
    (fault,) = (d for d in run(f"{word}\nM30", dialect="sinumerik").diagnostics if d.severity == "error")
    assert fault.code == "not-read"
    assert " (" in fault.message


def test_edges_of_a_tool(run: Run) -> None:
    """$TC_DP3[1,2] and $TC_DP6[1,2] are length and radius of edge 2, which D2 takes; both edges are read back."""
    out = run(
        "$TC_DP3[1,1]=100 $TC_DP6[1,1]=4\n$TC_DP3[1,2]=110 $TC_DP6[1,2]=5\nT1 D1 M6\nG0 X0 Y0 Z0\nD2\nG0 Z0\n"
        "G41 G1 X20 Y20 F500\nX40\nG40 X60 Y0\nG0 Y=$TC_DP3[1,1] Z=$P_AD[3]\nD1\nG0 Z0\nM30",
        dialect="sinumerik",
    )
    assert out.errors == []
    found = (np.round(out.path.end[out.path.kind != 3, :3], 9) + 0.0).tolist()
    assert found[:3] == [[0, 0, 100], [0, 0, 110], [20, 25, 110]]
    assert found[-2:] == [[60, 100, 220], [60, 100, 100]]


def test_an_edge_that_nothing_describes(run: Run) -> None:
    out = run("$TC_DP3[1,1]=100\nT1 D3 M6\nG0 Z1\nM30", dialect="sinumerik")
    assert [d.code for d in out.diagnostics if "D3" in d.message] == ["tool-edge"]
    assert out.path.end[-1, 2] == 101


@pytest.mark.parametrize(
    ("words", "height", "beside"),
    [
        ("TOFFL=2.5", 102.5, 24),
        ("TOFFL[1]=-4", 96, 24),
        ("TOFFR=0.5", 100, 24.5),
        ("TOFFLR=-1", 99, 23),
        ("TOFFLR=-1\nTOFFL=0", 100, 23),
    ],
)
def test_what_is_added_to_a_tool(run: Run, words: str, height: float, beside: float) -> None:
    """TOFFL adds to the length, TOFFR to the radius, TOFFLR the same to both: of a ball whose centre is programmed -R (NC programming, p. 88)."""
    text = f"$TC_DP3[1,1]=100 $TC_DP6[1,1]=4\nT1 D1 M6\n{words}\nG0 X0 Y0 Z0\nG41 G1 X20 Y20 F500\nX30\nG40 X40 Y0\nTOFFLR=0\nG0 Z0\nM30"
    found = ends(run, text)
    assert found[0] == [0, 0, height]
    assert found[1] == [20, beside, height]
    assert found[-1] == [40, 0, 100]


@pytest.mark.parametrize("word", ["T2", "D2", "M6", "D0"])
def test_another_tool_behind_an_offset(run: Run, word: str) -> None:
    """No text says whether the offset lives on."""
    assert fault(run, f"T1 D1 M6\nTOFFL=1\n{word}\nG0 Z1\nM30")[0] == "not-read"


def test_a_radius_that_changes_under_compensation(run: Run) -> None:
    text = "$TC_DP6[1,1]=4\nT1 D1 M6\nG41 G1 X20 Y20 F500\nX40\nTOFFR=1\nX50\nM30"
    assert fault(run, text)[0] == "not-read"


def test_another_machine_position(run: Run) -> None:
    """After PRESETON(X,-5) at the machine's 100 its zero is at 105 for all but SUPA, under origins and frames too."""
    text = (
        "$P_UIFR[1,X,TR]=10\nG54 G90 G17\nG0 X90 Y1\nPRESETON(X,-5)\nG0 X0\nG53 G0 X0\nG153 G0 X1\nSUPA G0 X0\n"
        "ROT Z90\nG0 X7 Y0\nG500\nROT\nG0 X=$AA_IM[X]+1 Y0\nM30"
    )
    found = [x for x, *_ in ends(run, text)]
    assert found == [100, 115, 105, 106, 0, 115, 116]


def test_a_rotary_axis_is_set(run: Run) -> None:
    out = run("G0 C350\nPRESETON(C,10,A,3)\nG0 A0 C20\nG0 SUPA C=AC(350)\nM30", dialect="sinumerik")
    assert out.errors == []
    turns = np.degrees(out.path.end[out.path.kind != 3, 3:])
    assert turns == pytest.approx(np.array([[0, 350], [-3, 360], [-3, 350]]))


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("PRESETON(X,0,C)", "sub-arguments"),
        ("PRESETON()", "sub-arguments"),
        ("PRESETON(5,1)", "variable-unknown"),
        ("DIAMON\nG0 X10\nPRESETON(X,5)", "not-read"),
        ("$TC_DP6[1,1]=4\nT1 D1 M6\nG41 G1 X20 Y20 F500\nX40\nPRESETON(Z,5)", "not-read"),
        ("$P_UIFR[1,Z,RT]=30\nG54\nPRESETON(X,5)", "not-read"),
    ],
)
def test_positions_that_cannot_be_set(run: Run, text: str, code: str) -> None:
    assert fault(run, f"{text}\nG0 X1\nM30")[0] == code


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        ("G53 Z=IC(50)", [10, 0, 90, 350]),
        ("G91 SUPA Z=IC(-5) X=AC(1)", [1, 0, 35, 350]),
        ("G53 C=DC(10)", [10, 0, 40, 370]),
        ("G53 C=ACN(10)", [10, 0, 40, 10]),
        ("G153 X=AC(3) Z7", [3, 0, 27, 350]),
    ],
)
def test_modes_of_machine_coordinates(run: Run, block: str, expected: list[float]) -> None:
    """An increment beside G53 goes on from where the axis is; it was read as a coordinate."""
    out = run(f"$TC_DP3[1,1]=20\nT1 D1 M6\nG0 X10 Z20 C350\nG0 {block}\nM30", dialect="sinumerik")
    assert out.errors == []
    end = out.path.end[-1]
    assert [*end[:3], math.degrees(end[3])] == pytest.approx(expected)


@pytest.mark.parametrize(("mode", "x"), [("DIAMON", 25), ("DIAM90", 25), ("DIAMOF", 50)])
def test_positions_are_read_as_they_are_written(run: Run, mode: str, x: float) -> None:
    """X of $AA_IW and $P_EP is a diameter where words of X are: read and written back it is the same."""
    text = f"G18 G90 {mode}\nG0 X50 Z10\nR1=$AA_IW[X] R2=$P_EP[X] R3=$AA_IW[Z]\nG0 X0 Z0\nG0 X=R1 Z=R3\nG0 X=R2\nM30"
    assert [row[::2] for row in ends(run, text)] == [[x, 10], [0, 0], [x, 10]]
    assert ("diameter-doubtful" in codes(run, text)) == (mode != "DIAMOF")


def test_fixed_points_under_compensation(run: Run) -> None:
    text = "$TC_DP6[1,1]=4\nT1 D1 M6\nG41 G1 X20 Y20 F500\nX40\nG75 X0\nM30"
    assert fault(run, text) == (
        "comp-refused",
        "G75 goes to a point of the machine, and cutter compensation is on",
    )


@pytest.mark.parametrize("block", ["TRANS X=IC(10)", "G58 X=IC(5)", "ATRANS Y=IC(1)"])
def test_increments_in_frames(run: Run, block: str) -> None:
    """They were read as the values themselves."""
    assert fault(run, f"{block}\nG0 X1\nM30")[0] == "not-read"


def test_a_loop_without_an_end_in_a_subprogram(run: Run) -> None:
    """The warm-up of a machine, a subprogram that never returns: one pass of it is planned, and nothing behind its call."""
    out = run(
        "G90 F1000\nUP1\nG1 X99\nM30\n%_N_UP1_SPF\nPROC UP1\nBEGAIN:\nG1 Z5\nG4 F1\nZ-5\nGOTOB BEGAIN\nRET\n",
        dialect="sinumerik",
    )
    assert out.errors == []
    assert out.path.end[out.path.kind != 3, 2].tolist() == [5, -5]
    assert "program-repeats" in [d.code for d in out.diagnostics]


#: A program of a grinding machine, whose dresser goes along axes that data of the machine name; numbers are ours.
DRESSER = """DEF STRING[10] AXIS_HORI="Z", AXIS_VER="x "
G18 G94
DRESS
M30
%_N_DRESS_SPF
PROC DRESS DISPLOF
DEF AXIS HOR, VER
HOR=AXNAME(AXIS_HORI) VER=AXNAME(AXIS_VER)
TRANS AX[HOR]=0.5 AX[VER]=2
G1 G90 AX[VER]=0 F=300
G1 G90 AX[HOR]=0-$AC_DRF[Z] F=600
G3 AX[HOR]=-6 AX[VER]=6 CR=6 F=100
IF AXSTRING(HOR)=="Z"
G1 AX[HOR]=-8
ENDIF
TRANS
RET
"""


def test_axes_by_their_names(run: Run) -> None:
    """Z is the first axis of G18: from (0.5, 2) counter-clockwise about (-5.5, 2) to its top."""
    out = run(DRESSER, dialect="sinumerik")
    assert out.errors == []
    assert out.moving_axes == "XYZ"
    found = out.path.end[out.path.kind != 3]
    assert (np.round(found[:, [0, 2]], 9) + 0.0).tolist() == [[2, 0], [2, 0.5], [8, -5.5], [8, -7.5]]
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["variable-assumed"]
