"""Heidenhain's plain language from line to line: labels, Q parameters, contours, cycles, worked out by hand; and wrong programs."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest

from cncgen.toolpath.record import Kind

HEAD = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000\n"
TAIL = "\nEND PGM T MM\n"
DRILL = "CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-10 ~\n Q206=150 ~\n Q202=10 ~\n Q210=0 ~\n Q203=0 ~\n Q204=20 ~\n Q211=0\n"
HOLE = [(0, 0, 2), (0, 0, -10), (0, 0, 20)]
MILL = " Q215=0 ~\n Q368=0 ~\n Q207=500 ~\n Q351=1 ~\n Q201=-4 ~\n Q202=4 ~\n Q369=0 ~\n Q206=100 ~\n Q338=0 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q370=1 ~\n Q366=0"
THREAD = "CYCL DEF 262 THREAD MILLING ~\n Q335=10 ~\n Q201=-6 ~\n Q253=750 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q207=500 ~\n"
DRILL_MILL = (
    THREAD.replace("262 THREAD", "264 THREAD DRILLING").strip()
    + "\n Q206=150 ~\n Q356=-8 ~\n Q258=.5 ~\n Q256=.5 ~\n Q239=1.5 ~\n Q351=1 ~\n Q358=-1 ~\n Q359=1.5 ~\n"
)
HELIX = (
    THREAD.replace("262 THREAD", "265 HELICAL THREAD").strip() + "\n Q254=150 ~\n Q358=-1 ~\n Q359=1.5 ~\n"
)
#: Out by Q359, around, and back.
FRONT = [(1.5, 0, -1), (1.5, 0, -1), (0, 0, -1)]
K = 2.0 - math.sqrt(2.0)

#: Program, and where its motions end. Tool 1 has the radius 2 and no length.
MOTIONS: dict[str, tuple[str, list[tuple[float, ...]]]] = {
    "a subprogram": ("CALL LBL 1\nCALL LBL 1\nL Y+1 FMAX\nM30\nLBL 1\nL IX+1 FMAX\nLBL 0", [(1,), (2,), (2, 1)]),
    "a name": ('CALL LBL "BOHREN"\nM30\nLBL "BOHREN"\nL X+1 FMAX\nLBL 0', [(1,)]),
    "REP": ("LBL 1\nL IX+1 FMAX\nCALL LBL 1 REP 2\nL Y+1 FMAX", [(1,), (2,), (3,), (3, 1)]),
    "REP 2/2": ("LBL 1\nL IX+1 FMAX\nCALL LBL 1 REP 2/2", [(1,), (2,), (3,)]),
    "REP within REP": ("LBL 1\nLBL 2\nL IX+1 FMAX\nCALL LBL 2 REP 1\nL IY+1 FMAX\nCALL LBL 1 REP 1", [(1,), (2,), (2, 1), (3, 1), (4, 1), (4, 2)]),
    "FN 0 to 4": ("FN 0: Q1 = +6\nFN 1: Q2 = +Q1 + +2\nFN 2: Q3 = +Q1 - +2\nFN 3: Q4 = +Q1 * +2\nFN 4: Q5 = +Q1 DIV +2\nL X+Q2 Y+Q3 Z+Q4 FMAX\nL X+Q5 FMAX",
                  [(8, 4, 12), (3, 4, 12)]),
    "FN 5 to 8, 13": ("FN 5: Q1 = SQRT +16\nFN 6: Q2 = SIN +30\nFN 7: Q3 = COS +60\nFN 8: Q4 = +3 LEN +4\nFN 13: Q5 = +1 ANG -1\nL X+Q1 Y+Q2 Z+Q3 FMAX\nL X+Q4 Y+Q5 FMAX",
                      [(4, 0.5, 0.5), (5, 135, 0.5)]),
    "formulas": ("Q1 = ( 2 + 3 ) * 4 - SQ 2\nQ2 = - Q1 / 4\nQ3 = ABS Q2 ^ 2\nL X+Q1 Y+Q2 Z+Q3 FMAX", [(16, -4, 16)]),
    "FN 9": ("Q1 = 1\nFN 9: IF +Q1 EQU +1 GOTO LBL 5\nL X+9 FMAX\nLBL 5\nL X+1 FMAX", [(1,)]),
    "FN 10": ("FN 10: IF +Q1 NE +0 GOTO LBL 5\nL X+2 FMAX\nLBL 5\nL X+1 FMAX", [(2,), (1,)]),
    "FN 11": ("Q1 = 3\nLBL 1\nQ1 = Q1 - 1\nL IX+1 FMAX\nFN 11: IF +Q1 GT +0 GOTO LBL 1", [(1,), (2,), (3,)]),
    "FN 12": ("LBL 1\nQ1 = Q1 + 1\nL X+Q1 FMAX\nFN 12: IF +Q1 LT +2 GOTO LBL 1", [(1,), (2,)]),
    "RND": ("L X+10 F100\nRND R2\nL Y+10", [(8,), (10, 2), (10, 10)]),
    "CHF": ("L X+10 F100\nCHF 2\nL Y+10", [(8,), (10, 2), (10, 10)]),
    "RND before an arc": ("L X+10 F100\nRND R1\nCC X+10 Y+10\nL Y+5\nL Y+10", [(9,), (10, 1), (10, 5), (10, 10)]),
    "CT": ("L X+10 F100\nCT X+20 Y+10", [(10,), (20, 10)]),
    "RL": ("L X+0 Y+0 Z-1 F100\nL X+10 RL\nL Y+10\nL X+20\nL R0 X+30 Y+30", [(0, 0, -1), (8, 0, -1), (8, 10, -1), (10, 12, -1), (20, 12, -1), (30, 30, -1)]),
    "RR": ("L X+10 Z-1 RR F100\nL Y+10\nL R0 Y+30", [(12, 0, -1), (12, 10, -1), (10, 30, -1)]),
    "APPR LT DEP LT": ("L X-30 F100\nAPPR LT X+0 Y+0 LEN15 RL\nL Y+10\nDEP LT LEN5", [(-30,), (-2, -15), (-2,), (-2, 10), (-2, 15)]),
    "APPR LN DEP LN": ("L X-30 F100\nAPPR LN X+0 Y+0 LEN15 RL\nL Y+10\nDEP LN LEN5", [(-30,), (-17,), (-2,), (-2, 10), (-7, 10)]),
    "APPR CT DEP CT": ("L X-30 F100\nAPPR CT X+0 Y+0 CCA90 R+10 RL\nL Y+20\nDEP CT CCA90 R+10", [(-30,), (-12, -10), (-2,), (-2, 20), (-12, 30)]),
    "APPR CT on the side of the part": ("L X-30 F100\nAPPR CT X+0 Y+0 CCA90 R-10 RL\nL Y+20\nDEP CT CCA90 R-10", [(-30,), (8, -10), (-2,), (-2, 20), (8, 30)]),
    "APPR LCT": ("L X-30 Y-10 F100\nAPPR LCT X+0 Y+0 R10 RL\nL Y+20\nDEP LCT X-30 Y+30 R10", [(-30, -10), (-12, -10), (-2,), (-2, 20), (-12, 30), (-30, 30)]),
    "APPR LT with RR": ("L X+30 F100\nAPPR LT X+0 Y+0 LEN15 RR\nL Y+10\nDEP LT LEN5", [(30,), (2, -15), (2,), (2, 10), (2, 15)]),
    "200 with M99": (f"{DRILL}L X+0 Y+5 FMAX M99", [(0, 5), *[(0, 5, z) for _, _, z in HOLE]]),
    "CYCL CALL POS": (f"{DRILL}CYCL CALL POS X+5 Y+0 Z+0", [(0, 0, 2), *[(5, 0, z) for _, _, z in HOLE]]),
    "M89": (f"{DRILL}L X+5 FMAX M89\nL X+6 FMAX M99\nL X+7 FMAX",
            [(5,), *[(5, 0, z) for _, _, z in HOLE], (6, 0, 20), *[(6, 0, z) for _, _, z in HOLE], (7, 0, 20)]),
    "M89 ends with the next cycle": (f"{DRILL}L X+5 FMAX M89\n{DRILL}L X+6 FMAX\nCYCL CALL\nL X+7 FMAX",
                                     [(5,), *[(5, 0, z) for _, _, z in HOLE], (6, 0, 20), *[(6, 0, z) for _, _, z in HOLE], (7, 0, 20)]),
    "M89 ends with CYCL CALL POS": (f"{DRILL}L X+5 FMAX M89\nCYCL CALL POS X+6 Y+0 Z+0\nL X+7 FMAX",
                                    [(5,), *[(5, 0, z) for _, _, z in HOLE], (6, 0, 20), *[(6, 0, z) for _, _, z in HOLE], (7, 0, 20)]),
    "M89 stays where a cycle acts at once": (f"{DRILL}L X+5 FMAX M89\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+10\nL X+1 FMAX",
                                             [(5,), *[(5, 0, z) for _, _, z in HOLE], (11, 0, 20), *[(11, 0, z) for _, _, z in HOLE]]),
    "202": ("CYCL DEF 202 BORING ~\n Q200=2 ~\n Q201=-10 ~\n Q206=100 ~\n Q211=0 ~\n Q208=250 ~\n Q203=0 ~\n Q204=20 ~\n Q214=1\nCYCL CALL",
            [(0, 0, 2), (0, 0, -10), (-0.2, 0, -10), (-0.2, 0, 2), (-0.2, 0, 20), (0, 0, 20)]),
    "203": ("CYCL DEF 203 UNIVERSAL ~\n Q200=2 ~\n Q201=-12 ~\n Q206=100 ~\n Q202=5 ~\n Q210=0 ~\n Q203=0 ~\n Q204=20 ~\n Q212=1 ~\n Q213=1 ~\n Q205=3 ~\n Q211=0 ~\n Q208=0 ~\n Q256=0.5\nCYCL CALL",
            [(0, 0, z) for z in (2, -5, -4.5, -9, 2, -7, -12, 2, 20)]),
    "205": ("CYCL DEF 205 PECK ~\n Q200=2 ~\n Q201=-10 ~\n Q206=100 ~\n Q202=5 ~\n Q203=0 ~\n Q204=20 ~\n Q212=0 ~\n Q205=0 ~\n Q258=1 ~\n Q259=1 ~\n Q257=0 ~\n Q256=0.2 ~\n Q211=0 ~\n Q379=0\nCYCL CALL",
            [(0, 0, z) for z in (2, -5, 2, -4, -10, 20)]),
    "207": ("CYCL DEF 207 TAPPING ~\n Q200=2 ~\n Q201=-10 ~\n Q239=+1 ~\n Q203=0 ~\n Q204=20\nCYCL CALL", [(0, 0, z) for z in (2, -10, 2, 20)]),
    "208": ("CYCL DEF 208 BORE MILLING ~\n Q200=2 ~\n Q201=-4 ~\n Q206=100 ~\n Q334=2 ~\n Q203=0 ~\n Q204=20 ~\n Q335=10 ~\n Q342=0 ~\n Q351=1\nCYCL CALL",
            [(0, 0, 2), (3, 0, 2), (3, 0, -4), (3, 0, -4), (0, 0, -4), (0, 0, 20)]),
    "262": (f"{THREAD} Q239=1.5 ~\n Q355=0 ~\n Q351=1\nCYCL CALL",
            [(0, 0, 2), (0, 0, -6.75), (3, 0, -6), (3, 0, -4.5), (0, 0, -3.75), (0, 0, 20)]),
    "262 in one helix": (f"{THREAD} Q239=1.5 ~\n Q355=1 ~\n Q351=1\nCYCL CALL",
                         [(0, 0, 2), (0, 0, -6.75), (3, 0, -6), (3, 0, 0), (0, 0, 0.75), (0, 0, 20)]),
    "262 in steps": (f"{THREAD} Q239=1.5 ~\n Q355=2 ~\n Q351=1\nCYCL CALL",
                     [(0, 0, 2), (0, 0, -6.75), (3, 0, -6), (3, 0, -4.5), (0, 0, -3.75), (3, 0, -3), (3, 0, -1.5), (0, 0, -0.75), (0, 0, 20)]),
    "262 left-hand": (f"{THREAD} Q239=-1.5 ~\n Q355=0 ~\n Q351=1\nCYCL CALL",
                      [(0, 0, 2), (0, 0, -3.75), (3, 0, -4.5), (3, 0, -6), (0, 0, -6.75), (0, 0, 20)]),
    "264": (f"{DRILL_MILL} Q202=4 ~\n Q257=0\nCYCL CALL",
            [*[(0, 0, z) for z in (2, -4, 2, -3.5, -8, 2, -1)], *FRONT, (0, 0, -6.75), (3, 0, -6), (3, 0, -4.5), (0, 0, -3.75), (0, 0, 20)]),
    "264 with chips broken": (f"{DRILL_MILL} Q202=8 ~\n Q257=3 ~\n Q358=0\nCYCL CALL",
                              [*[(0, 0, z) for z in (2, -3, -2.5, -6, -5.5, -8, 2, -6.75)], (3, 0, -6), (3, 0, -4.5), (0, 0, -3.75), (0, 0, 20)]),
    "265": (f"{HELIX} Q239=1.5 ~\n Q360=0\nCYCL CALL",
            [(0, 0, 2), (0, 0, -1), *FRONT, (0, 0, 0.75), (3, 0, 0), (3, 0, -6), (0, 0, -6.75), (0, 0, 20)]),
    "265 countersunk last": (f"{HELIX} Q239=-1.5 ~\n Q360=1\nCYCL CALL",
                             [(0, 0, 2), (0, 0, 0.75), (3, 0, 0), (3, 0, -6), (0, 0, -6.75), (0, 0, -1), *FRONT, (0, 0, 20)]),
    "FN 18": ("L X+3 Y+4 FMAX\nFN 18: SYSREAD Q1 = ID20 NR1\nFN 18: SYSREAD Q2 = ID50 NR2 IDX1\nFN 18: SYSREAD Q3 = ID270 NR1 IDX2\n"
              "FN 18: SYSREAD Q4 = ID20 NR4\nL X+Q1 Y+Q2 FMAX\nL X+Q3 Y+Q4 FMAX", [(3, 4), (1, 2), (4, 1000)]),
    "comments in parentheses": ("(A HEAD)\nL X+3 FMAX (THERE)\nQ1 = ( 1 + 1 )\nL X+Q1 FMAX (BACK) ; AND ON", [(3,), (2,)]),
    "220": (f"{DRILL}CYCL DEF 220 CIRCLE ~\n Q216=0 ~\n Q217=0 ~\n Q244=20 ~\n Q245=0 ~\n Q246=360 ~\n Q247=0 ~\n Q241=2",
            [(10,), *[(10, 0, z) for _, _, z in HOLE], (-10, 0, 20), *[(-10, 0, z) for _, _, z in HOLE]]),
    "220 on a part of a circle": (f"{DRILL}CYCL DEF 220 CIRCLE ~\n Q216=0 ~\n Q217=0 ~\n Q244=20 ~\n Q245=0 ~\n Q246=180 ~\n Q247=0 ~\n Q241=3 ~\n Q301=1",
            [move for x, y in ((10, 0), (0, 10), (-10, 0)) for move in ((x, y, 20 if x < 10 else 0), *((x, y, z) for _, _, z in HOLE))]),
    "221": (f"{DRILL}CYCL DEF 221 LINES ~\n Q225=5 ~\n Q226=5 ~\n Q237=10 ~\n Q238=8 ~\n Q242=2 ~\n Q243=1 ~\n Q224=0",
            [(5, 5), *[(5, 5, z) for _, _, z in HOLE], (15, 5, 20), *[(15, 5, z) for _, _, z in HOLE]]),
    "221 at the set-up clearance": (f"{DRILL}CYCL DEF 221 LINES ~\n Q225=5 ~\n Q226=5 ~\n Q237=10 ~\n Q238=8 ~\n Q242=2 ~\n Q243=1 ~\n Q224=0 ~\n Q301=0",
            [(5, 5), (5, 5, 2), (5, 5, -10), (5, 5, 2), (15, 5, 2), (15, 5, -10), (15, 5, 20)]),
    "252": (f"CYCL DEF 252 POCKET ~\n Q223=8 ~\n{MILL}\nCYCL CALL",
            [(0, 0, 2), (0, 0, -4), (0, -2, -4), (2, 0, -4), (0, 2, -4), (-2, 0, -4), (0, -2, -4), (0, 0, -4), (0, 0, 2), (0, 0, 20)]),
    "253": (f"CYCL DEF 253 SLOT ~\n Q218=20 ~\n Q219=4 ~\n Q374=0 ~\n Q367=0 ~\n{MILL}\nCYCL CALL",
            [(0, 0, 2), (0, 0, -4), (8, 0, -4), (-8, 0, -4), (0, 0, -4), (0, 0, 2), (0, 0, 20)]),
    "7": ("CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Y+5\nLBL 9\nL X+1 Y+1 FMAX\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+1 Y+1 FMAX", [(11, 6), (1, 1)]),
    "8": ("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X\nL X+5 Y+1 FMAX\nCYCL DEF 8.0 MIRROR\nCYCL DEF 8.1\nL X+5 FMAX", [(-5, 1), (5, 1)]),
    "10": ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nL X+5 FMAX\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\nL X+5 Y+0 FMAX", [(0, 5), (5, 0)]),
    "11": ("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 2\nL X+5 FMAX\nCYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1\nL X+5 FMAX", [(10,), (5,)]),
    "7 and 10": ("CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+10\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nL X+5 Y+0 FMAX", [(10, 5)]),
    "9": ("CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 0.5\nL X+1 FMAX", [(1,)]),
    "247": ("CYCL DEF 247 PRESET ~\n Q339=1\nL X+1 FMAX", [(1,)]),
}  # fmt: skip


def outcome(run: Any, tmp_path: Path, text: str, **options: Any) -> Any:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D4\n")
    return run(HEAD + text + TAIL, tool_table=table, **options)


def ends(points: Any) -> list[tuple[float, ...]]:
    """Return points, zeros at their ends left out but for X."""
    found = []
    for row in points:
        point = [round(float(v), 6) + 0.0 for v in row]
        while len(point) > 1 and point[-1] == 0.0:
            point.pop()
        found.append(tuple(point))
    return found


@pytest.mark.parametrize("name", MOTIONS)
def test_motions(run: Any, tmp_path: Path, name: str) -> None:
    text, expected = MOTIONS[name]
    out = outcome(run, tmp_path, text)
    assert out.errors == []
    assert ends(out.path.end[out.path.kind < 3][:, :3]) == ends(expected)


#: Functions that act at the beginning of their block (M3 M4 M8 M13 M14), and at its end (M5 M6 M9), before a stop and the end of the program.
#: (TNC 155, "M-functions which affect program run")
TURNS = {
    "L X+1 F100 M13\nL X+2 M5\nL X+3 M9": "START_SPINDLE_CLOCKWISE FLOOD_ON X1 X2 STOP_SPINDLE_TURNING X3 MIST_OFF FLOOD_OFF",
    "L X+1 F100 M14\nL X+2 M9 M30": "START_SPINDLE_COUNTERCLOCKWISE FLOOD_ON X1 X2 MIST_OFF FLOOD_OFF",
    "L X+1 F100 M8\nL X+2 M5 M0": "FLOOD_ON X1 X2 STOP_SPINDLE_TURNING PROGRAM_STOP",
    "L X+1 F100\nL X+2 M6": "X1 X2 STOP_SPINDLE_TURNING",
    "CC X+5 Y+0\nCP IPA+180 DR+ F100 M9": "X10 MIST_OFF FLOOD_OFF",
    "L X-5 F100\nCT X+2 Y+9 M5": "X-5 X2 STOP_SPINDLE_TURNING",
    f"{DRILL}L X+5 FMAX M3\nCYCL CALL M9": "START_SPINDLE_CLOCKWISE X5 X5 X5 X5 MIST_OFF FLOOD_OFF",
    f"{DRILL}L X+5 FMAX M99 M5\nL X+6 FMAX": "X5 X5 X5 X5 STOP_SPINDLE_TURNING X6",
    f"{DRILL}CYCL CALL POS X+5 Y+0 M9": "X5 X5 X5 X5 MIST_OFF FLOOD_OFF",
    f"{DRILL}L X+5 FMAX\nCYCL CALL M30": "X5 X5 X5 X5 STOP_SPINDLE_TURNING PALLET",
    "APPR LT X+0 Y+0 LEN5 RL F100 M13\nL Y+9\nDEP LT LEN5 M9": "START_SPINDLE_CLOCKWISE FLOOD_ON X-2 X-2 X-2 X-2 MIST_OFF FLOOD_OFF",
}


@pytest.mark.parametrize("text", TURNS)
def test_spindle_and_coolant_stop_behind_the_motion_of_their_block(
    calls: Any, tmp_path: Path, text: str
) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D4\n")
    found = calls(f"{HEAD}{text}{TAIL}", dialect="heidenhain", tool_table=table)
    pattern = re.compile(
        r"(?:STRAIGHT_FEED|STRAIGHT_TRAVERSE|ARC_FEED)\((-?\d+)|((?:START|STOP)_SPINDLE\w+|FLOOD_O\w+|MIST_O\w+|PROGRAM_\w+|PALLET)"
    )
    turns = [f"X{m[1]}" if m[1] else m[2] for call in found for m in [pattern.match(call)] if m]
    begin = turns.index("STOP_SPINDLE_TURNING") + 1 if "STOP_SPINDLE_TURNING" in turns[:1] else 0
    expected = TURNS[text].split()
    assert turns[begin : begin + len(expected)] == expected


@pytest.mark.parametrize("declared", ["DECLARE STRING ", ""])
def test_a_parameter_of_text_names_a_tool(calls: Any, tmp_path: Path, declared: str) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D4\nT7 P5 D6.8 ; DRILL_6.8\n")
    text = f'{declared}QS1 = "DRILL_6.8"\nTOOL CALL QS1 Z S2800'
    found = calls(HEAD + text + TAIL, tool_table=table)
    assert [call for call in found if "CHANGE_TOOL" in call][-1] == "CHANGE_TOOL(2)"


def test_a_cycle_is_called_at_the_end_of_a_departure(run: Any, tmp_path: Path) -> None:
    """M99 behind DEP, whose R0 counts for the place: a hole at its end."""
    text = f"{DRILL}L X-30 F100\nAPPR LT X+0 Y+0 LEN15 RL\nL Y+10\nDEP LT LEN5 M99"
    out = outcome(run, tmp_path, text)
    assert out.errors == []
    assert ends(out.path.end[out.path.kind < 3][-3:, :3]) == [(-2, 15, 2), (-2, 15, -10), (-2, 15, 20)]


@pytest.mark.parametrize("kind", [0, 1])
def test_a_pattern_goes_along_its_circle_or_straight(calls: Any, kind: int) -> None:
    """Q365 of 220, from (10, 0) to (-10, 0): through the middle, or half around, as fast as it can; drilling goes on at Q206."""
    circle = "CYCL DEF 220 CIRCLE ~\n Q216=0 ~\n Q217=0 ~\n Q244=20 ~\n Q245=0 ~\n Q246=180 ~\n Q247=0 ~\n Q241=2 ~\n"
    found = calls(f"{HEAD}{DRILL}{circle} Q365={kind}{TAIL}", dialect="heidenhain")
    assert [call for call in found if "ARC" in call] == (
        ["ARC_FEED(-10.0000, 0.0000, 0.0000, 0.0000, 1, 20.0000, 0.0000, 0.0000, 0.0000)"] if kind else []
    )
    assert [call for call in found if "RATE(150" in call or "RATE(99999" in call] == [
        "SET_FEED_RATE(150.0000)",
        *["SET_FEED_RATE(99999.0000)"] * kind,
        "SET_FEED_RATE(150.0000)",
    ]


def test_a_depth_from_the_width_of_the_drill_on_has_a_warning(run: Any, tmp_path: Path) -> None:
    """Q395 = 1 needs T-ANGLE of the control's tool table; a later cycle without Q395 drills with its tip again."""
    out = outcome(run, tmp_path, f"{DRILL[:-1]} ~\n Q395=1\nCYCL CALL\n{DRILL}CYCL CALL")
    assert [(d.severity, d.span.line) for d in out.diagnostics if d.code == "tool-assumed"] == [
        ("warning", 13)
    ]


def test_the_manuals_circular_movements(run: Any, tmp_path: Path) -> None:
    """iTNC 530, "Circular movements with Cartesian coordinates": R5 of APPR and DEP is the arc of the middle of a tool of radius 10."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D20\n")
    text = (
        "0 BEGIN PGM CIRCULAR MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 BLK FORM 0.2 X+100 Y+100 Z+0\n3 TOOL CALL 1 Z S4000\n4 L Z+250 R0 FMAX\n"
        "5 L X-10 Y-10 R0 FMAX\n6 L Z-5 R0 F1000 M3\n7 APPR LCT X+5 Y+5 R5 RL F300\n8 L X+5 Y+85\n9 RND R10 F150\n10 L X+30 Y+85\n"
        "11 CR X+70 Y+95 R+30 DR-\n12 L X+95\n13 L X+95 Y+40\n14 CT X+40 Y+5\n15 L X+5\n16 DEP LCT X-20 Y-20 R5 F1000\n17 L Z+250 R0 FMAX M2\n"
        "18 END PGM CIRCULAR MM\n"
    )
    out = run(text, tool_table=table)
    assert out.errors == []
    arcs = ends(out.path.end[out.path.kind == 1][:, :2])
    # On to (5 - 10, 5) beside the first point; off from (5, 5 - 10) beside the last one.
    assert arcs[0] == (-5, 5)
    points = ends(out.path.end[out.path.kind < 3][:, :2])
    assert points[-2] == (-20, -20)
    assert points[-4] == (5, -5)
    # The arcs of the way on and off touch lines to (-10, -10) and (-20, -20): 5 from their middles.
    assert abs(complex(*points[3]) - (-10 + 5j)) == pytest.approx(5)
    assert abs(complex(*points[-3]) - (5 - 10j)) == pytest.approx(5)


def test_a_pocket_stays_within_its_wall(run: Any, tmp_path: Path) -> None:
    """30 by 20, the tool's radius 2: its centre reaches 13 and 8, and steps aside by 2 at most."""
    text = (
        f"CYCL DEF 251 POCKET ~\n Q218=30 ~\n Q219=20 ~\n Q220=5 ~\n Q224=0 ~\n Q367=0 ~\n{MILL}\nCYCL CALL"
    )
    out = outcome(run, tmp_path, text)
    assert out.errors == []
    points = out.path.end[out.path.kind < 3][:, :2]
    assert abs(points[:, 0]).max() == pytest.approx(13.0)
    assert abs(points[:, 1]).max() == pytest.approx(8.0)
    assert sorted({round(float(y), 6) for y in points[:, 1] if y <= 0.0 and abs(y) % 2 == 0})[0] == -8.0


#: Program behind two lines, and code, line and column of its first fault.
WRONG: dict[str, tuple[str, tuple[str, int]]] = {
    "no label": ("CALL LBL 7", ("label-missing", 3)),
    "a label twice": ("CALL LBL 7\nLBL 7\nLBL 0\nLBL 7\nLBL 0", ("label-repeated", 3)),
    "a jump nowhere": ("FN 9: IF +1 EQU +1 GOTO LBL 7", ("label-missing", 3)),
    "a condition": ("LBL 7\nFN 9: IF +1 GT +1 GOTO LBL 7", ("syntax", 4)),
    "a formula": ("Q1 = 2 + * 3", ("syntax", 3)),
    "a formula that ends": ("Q1 = ( 2 + 3", ("syntax", 3)),
    "a function": ("Q1 = SINH 3", ("syntax", 3)),
    "a root": ("Q1 = SQRT ( 0 - 4 )", ("domain", 3)),
    "a division": ("FN 4: Q1 = +1 DIV +0", ("division-by-zero", 3)),
    "an error of the program": ("FN 14: ERROR = 1000", ("program-alarm", 3)),
    "a system function": ("FN 18: SYSREAD Q1 = ID210 NR4 IDX3", ("unsupported-block", 3)),
    "no contour before RND": ("RND R5", ("corner-motion", 3)),
    "a corner too large": ("L X+3 F100\nRND R5\nL Y+3", ("corner-size", 3)),
    "APPR without its length": ("L X-30 F100\nAPPR LT X+0 Y+0 RL\nL Y+10", ("approach-words", 4)),
    "APPR to nothing": ("L X-30 F100\nAPPR LT X+0 Y+0 LEN5 RL\nM30", ("approach-words", 4)),
    "APPR to a pole": ("L X-30 F100\nAPPR LT X+0 Y+0 LEN5 RL\nCC X+0 Y+0", ("approach-words", 4)),
    "APPR to an axis alone": ("L X-30 F100\nAPPR LT X+0 Y+0 LEN5\nL Z+5 FMAX M92", ("approach-words", 4)),
    "APPR without a radius": ("L X-30 F100\nAPPR CT X+0 Y+0 CCA90 R+0 RL\nL Y+10", ("comp-radius", 4)),
    "DEP from nothing": ("DEP LT LEN5 F100", ("approach-words", 3)),
    "CT from nothing": ("CT X+5 Y+5 F100", ("arc-tangent", 3)),
    "an unknown cycle": ("CYCL DEF 276 TRAIN", ("unsupported-block", 3)),
    "no cycle": ("LBL 1\nCYCL CALL", ("cycle-missing", 4)),
    "a depth upwards": ("CYCL DEF 207 TAPPING ~\n Q200=2 ~\n Q201=10 ~\n Q239=+1\nCYCL CALL", ("cycle-depth", 7)),
    "no pitch": ("CYCL DEF 207 TAPPING ~\n Q200=2 ~\n Q201=-10\nCYCL CALL", ("pitch-missing", 6)),
    "no hole": (f"{DRILL}CYCL DEF 220 CIRCLE ~\n Q244=20 ~\n Q241=0", ("cycle-repeats", 12)),
    "a slot too narrow": (f"CYCL DEF 253 SLOT ~\n Q218=20 ~\n Q219=3 ~\n{MILL}\nCYCL CALL", ("cycle-tool", 20)),
    "no angle": ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 X", ("rotation-angle", 4)),
    "a scale": ("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0", ("scale-missing", 4)),
    "recursion": ("LBL 1\nCALL LBL 1", ("call-depth", 4)),
    "endless": ("LBL 1\nQ1 = 1\nFN 9: IF +1 EQU +1 GOTO LBL 1", ("too-many-steps", 5)),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_where_it_stands(run: Any, tmp_path: Path, name: str) -> None:
    text, expected = WRONG[name]
    out = outcome(run, tmp_path, text, max_steps=2000)
    code, line, _ = out.errors[0]
    assert code == expected[0]
    assert line == expected[1] or code == "too-many-steps"
    assert next(d for d in out.diagnostics if d.severity == "error").hint


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("Q1 = Q1999999999 + 1", "parameter-number"),
        ("Q1 = ( 0 - 2 ) ^ 0.5", "domain"),
        ("Q1 = EXP 9999", "domain"),
        ("LBLFN 9: IF +1 GT +1 GOTO LBL 7", "syntax"),
    ],
)
def test_values_that_are_none(run: Any, tmp_path: Path, text: str, code: str) -> None:
    assert outcome(run, tmp_path, text).errors[0][0] == code


@pytest.mark.parametrize(
    ("text", "axes"),
    [
        ("L X+10 F100\nL IY-2", "XY"),
        ("CC X+5 Y+0\nL Z+Q1 FMAX", "XYZ"),
        ("L Z+5 A+3 FMAX ; B+5", "ZA"),
        ("CC X+0 Y+0\nLP PR+5 PA+0 FMAX", "XY"),
    ],
)
def test_each_axis_has_its_column(run: Any, text: str, axes: str) -> None:
    """An axis behind a word without a number had none: X of ``L X+10``."""
    assert (
        run(f"0 BEGIN PGM T MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n{text}\n9 END PGM T MM\n").moving_axes == axes
    )


def test_boring_steps_off_by_q357_or_0_2_mm_in_programs_in_inches_too(calls: Any) -> None:
    """In inches 0.2 was an inch's fifth, on the other side of the hole."""
    cycle = "CYCL DEF 202 BORING ~\n Q200=.1 ~\n Q201=-1 ~\n Q206=10 ~\n Q211=0 ~\n Q208=25 ~\n Q203=0 ~\n Q204=1 ~\n Q214=3"
    aside = []
    for unit, more in (("INCH", ""), ("MM", ""), ("MM", " ~\n Q357=0.5"), ("INCH", " ~\n Q357=0.5")):
        text = f"0 BEGIN PGM A {unit}\nTOOL CALL 1 Z S500\n{cycle}{more}\nL X+1 Y+0 FMAX M99\nM30\nEND PGM A {unit}\n"
        ends = [
            line.split("(")[1].split(",")[0]
            for line in calls(text, dialect="heidenhain")
            if line.startswith("STRAIGHT")
        ]
        aside.append(max(map(float, ends)) - 1.0)
    assert aside == pytest.approx([0.0079, 0.2, 0.5, 0.5])


def test_pecks_of_cycle_1_come_back_by_millimetres_in_programs_in_inches(calls: Any) -> None:
    """0.6 mm are 0.0236 inch; 2 inches deep it is a fiftieth, 0.04 inch. The first step of 0.4 begins 0.1 below the tool."""
    for depth, back in ((-1, -0.5 + 0.6 / 25.4), (-2, -0.5 + 0.04)):
        body = f"CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SET UP.1\nCYCL DEF 1.2 DEPTH{depth}\nCYCL DEF 1.3 PECKG.4\nCYCL DEF 1.4 DWELL 0\nCYCL DEF 1.5 F10\nM99"
        found = calls(
            f"0 BEGIN PGM A INCH\nTOOL CALL 1 Z S500\n{body}\nM30\nEND PGM A INCH\n", dialect="heidenhain"
        )
        heights = [float(line.split(",")[2]) for line in found if line.startswith("STRAIGHT_TRAVERSE")]
        assert next(height for height in heights if height < 0.0) == pytest.approx(back, abs=1e-4)


@pytest.mark.parametrize("side", ["RL", "RR"])
def test_lct_straight_ahead_has_no_arc(run: Any, side: str) -> None:
    """The way on or off the contour goes on as the contour does: the arc was a full circle."""
    body = f"L X-20 Y+0 F100\nAPPR LCT X+0 Y+0 R5 {side}\nL X+20\nDEP LCT X+40 Y+0 R5\n"
    out = run(f"0 BEGIN PGM A MM\n{body}M30\nEND PGM A MM\n", dialect="heidenhain")
    assert out.errors == []
    assert set(out.path.kind.tolist()) <= {int(Kind.LINE), int(Kind.EVENT)}
    assert out.path.end[out.path.kind == Kind.LINE][:, 0].tolist() == [-20, 0, 20, 40]
