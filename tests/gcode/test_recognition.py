"""Which control a text is of: told from its blocks as controls read them, with all signs weighed, and said."""

from __future__ import annotations

import _sre
import importlib
import io
import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check, read
from cncgen.gcode.source import open_source
from cncgen.gcode.text import built_patterns, dialects, signs
from cncgen.gcode.text.dialects import choose
from cncgen.toolpath.reading import ReadOptions


def dialect_of(text: str) -> tuple[str, str]:
    """Return the dialect of a text, and the one that it might be as well."""
    choice = choose(open_source(io.BytesIO(text.encode()), "t.nc"))
    return choice.dialect, choice.rival


#: Heads and bodies as controls' programs have them, and the dialect that each is of beyond doubt.
CERTAIN = [
    # Blocks without a blank behind N.
    ("N01G50S600\nN02G96S180M3\nN03G0X50.Z2.\nN04G1Z-30.F0.3\nN05M30", "fanuc-lathe"),
    ("N5G65P9100A1.\nN10M30", "fanuc"),
    ("N5G68X0Y0R30.\nN10G69\nN15M30", "fanuc"),
    ("N5G04X1.\nN10G1X10.F100.\nN15M30", "fanuc"),
    ("N1G28U0W0\nN2G0X50.Z2.\nN3M30", "fanuc-lathe"),
    # Lathes without G50 S, G71 or G28 U0 W0.
    ("%\nO0010\nT0101\nG97S1200M3\nG0X32.Z5.\nG1Z-20.F.25\nU2.W-1.\nG0X100.Z100.\nM30\n%", "fanuc-lathe"),
    ("O0011\nT0303\nG0X22.Z5.\nG92X19.5Z-20.F1.5\nX19.\nX18.6\nG0X100.Z50.\nM30", "fanuc-lathe"),
    ("O5\nG0T0101\nG96S200M3\nG0X40.Z2.\nG90X36.Z-20.F.2\nX32.\nG0X80.Z80.\nM30", "fanuc-lathe"),
    ("O60840\nT101\nG0G18G20G40G80G99\nG97S500M3\nG0G54X0Z.3\nM8\nG84Z-1.2R.2F.0833\nG80\nM30", "fanuc-lathe"),
    ("O6\nG99G97S800M3T0202\nG0X30.Z3.\nG32Z-20.F2.\nG0X40.\nM30", "fanuc-lathe"),
    # Threads of system A, which knows no G95: systems B and C would name positions by G92 and cut nothing.
    ("O11\nG21G40\nG28U0W0\nT0404\nG97S400M3\nG95\nG0X22.Z5.\nG92X19.4Z-42.F2.5\nG92X18.9Z-42.F2.5\nM30", "fanuc-lathe"),
    ("T0101\nG0X60.Z2.\nG71U2.R.5\nG71P10Q20U.4W.1F.25\nN10G0X20.\nN20G1Z-30.\nG70P10Q20\nM30", "fanuc-lathe"),
    ("G0X50.Z5.\nG76P020060Q100R50\nG76X20.Z-20.P920Q300F1.5\nM30", "fanuc-lathe"),
    # Systems B and C. Cycles of lines P to Q are of system B too.
    ("O5\nG21G40G90G95\nT0101\nG92S2200\nG96S180M3\nG0X52.Z2.\nG71U1.5R.5\nG71P10Q20U.4W.1F.28\nN10G0X25.\nN20G1Z-30.\nG70P10Q20\n"
     "T0202\nG97S900M3\nG0X34.Z6.\nG78X29.4Z-24.F2.\nX28.9\nM30", "fanuc-lathe-b"),
    ("O6\nG21G40\nG28U0.W0.\nT0303\nG97S700M3\nG0X32.Z5.\nG78X29.5Z-25.F1.5\nG78X29.1Z-25.F1.5\nM30", "fanuc-lathe-b"),
    ("O7\nG21G90G95\nG92S2000\nT0101\nG97S800M3\nG0X50.Z2.\nG77X46.Z-20.F.2\nX42.\nM30", "fanuc-lathe-b"),
    ("%O1200(BAR)\nN10G21G90G40G95\nN60G92S500\nN70G97S300M3\nN90G0X160.Z7.\nN110G1Z5.F.3\nN120G3X50.Z3.R3.\nN130M30", "fanuc-lathe-b"),
    ("O8\nG71G90G95T0202\nG0X50.Z2.\nG73U2.R.5\nG73P10Q20U.4W.1F.25\nN10G0X20.\nN20G1Z-30.\nG72P10Q20\nM30", "fanuc-lathe-c"),
    # Mills.
    ("%\nO1234(PART)\nG90G54G0X0Y0S3000M3\nG43H1Z50.\nG1Z-2.F150.\nM30\n%", "fanuc"),
    ("O10\nT1M6\nG54X0Y0\nG43Z10.H1\nG81X5.Y5.Z-5.R2.F120.\nG80\nM30", "fanuc"),
    ("#100=0\nN10 IF [#100 GE 5] GOTO 20\nG1 X#100 Y2. F100.\n#100=#100+1\nGOTO 10\nN20 M30", "fanuc"),
    ("G0G90G54.1P5X0Y0\nG1X10.F200.\nM30", "fanuc"),
    ("G17G20G40G80G49\nT1M6\nG103P1\nG154P2X0Y0\nM30", "fanuc"),
    ("%\nT1 M06\nG00 G90 G54 X0 Y0\nG43 H01 Z0.1\nG12 I0.75 F10. Z-1.2 D01\nG00 Z0.1\nM30\n%", "fanuc"),
    # A row of holes whose words L0 keeps, and a reference point beside a motion: LinuxCNC refuses both.
    ("T40\nM6\nG91G28G0Z0.\nG54\nG90G0X0.Y0.\nG43Z100.H40\nM3S500\nG98G84R5.Z-20.F500L0\nX10.Y10.\nG80\nM30", "fanuc"),
    # LinuxCNC.
    ("o100 sub\nG1 X#1 F100\no100 endsub\no100 call [5]\nM2", "linuxcnc"),
    ("#<depth> = 5\nG1 Z[-#<depth>] F100\nM2", "linuxcnc"),
    ("G20 G90 G64 P0.001\nG1 X1 Y1 F10\nM2", "linuxcnc"),
    ("G7\nG18\nG95\nG96 D2500 S250 M3\nG1 X20 Z-5 F0.2\nM2", "linuxcnc"),
    ("G18 G21\nG76 P1.5 Z-20 I-1 J0.1 K0.92 R1 Q29.5 H2\nM2", "linuxcnc"),
    # Heidenhain.
    ("0 BEGIN PGM A MM\n1 L X+10 R0 FMAX\n2 END PGM A MM", "heidenhain"),
    ("1 TOOL CALL 3 Z S4850\n2 L X+10 Y+0 R0 FMAX M3\n3 L X+20 F200", "heidenhain"),
    ("L X1,5 Y0.5 FMAX\nL Z-0.2 F100\nL Y9.5", "heidenhain"),
    # Heidenhain's DIN/ISO.
    ("%PART G71 *\nN10 G30 G17 X+0 Y+0 Z-40 *\nN20 G00 G40 G90 Z+250 *\nN30 G01 X-5 F200 *\n", "heidenhain"),
    ("%1 G71\nN10 G99 T1 L+0 R+5\nN20 T1 G17 S500\nN30 G00 G40 G90 Z+50 M3\nN50 G200 BORE Q200=2 Q201=-15\nN60 G79", "heidenhain"),
    ("N10 D00 Q1 P01 +5\nN20 G98 L1\nN30 G01 X+Q1 F100\nN40 L1,3\nN50 M30", "heidenhain"),
    # Tool and edge before M6, as SINUMERIK's milling programs have them.
    ("N10 G90 G54 G17\nN20 T1 D1 M6\nN30 S1000 M3\nN40 G0 X0 Y0 Z50\nN50 G1 Z-5 F200\nN70 M30", "sinumerik"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "dialect"), CERTAIN, ids=lambda v: str(v)[:24])
def test_signs_that_are_certain(text: str, dialect: str) -> None:
    assert dialect_of(text) == (dialect, "")


def test_a_program_without_signs_is_plain() -> None:
    assert dialect_of("N10 G0 X1 Y2\nN20 G1 Z-1 F100\nN30 M30") == ("linuxcnc", "")
    assert dialect_of("G43 H2\nG0 X1 Z5\nM2") == ("linuxcnc", "")


def test_signs_in_comments_do_not_count() -> None:
    assert dialect_of("(N1 G50 S600)\nG0 X1 Y2 ; G28 U0 W0\nM2") == ("linuxcnc", "")


@pytest.mark.parametrize(
    ("text", "dialect", "rival"),
    [
        ("G0 X50 Z2\nS600 M3\nG1 Z-30 F0.3\nM30", "linuxcnc", "fanuc-lathe"),
        ("G0 X50. Z2.\nG1 Z-30. F100.\nX52. W-1.\nM30", "fanuc-lathe", "linuxcnc"),
        ("O1\nG0 X50. Z2.\nG0 T0101\nG43 Z5. H1\nG1 Z-30. F100.\nM30", "fanuc", ""),
        ("G31 Z-50 F100\nG92 Z0\nG0 Z5\nM30", "fanuc", ""),
    ],
)
def test_weak_signs_name_both(text: str, dialect: str, rival: str) -> None:
    assert dialect_of(text) == (dialect, rival)
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    doubts = [d for d in found if d.code == "dialect-doubtful"]
    assert len(doubts) == (1 if rival else 0)
    for doubt in doubts:
        assert rival in doubt.message
        assert f"--dialect {rival}" in doubt.hint
        assert dialect in doubt.hint


@pytest.mark.parametrize(
    ("text", "dialect", "expected"),
    [
        ("G0 X50 Z2\nG1 Z-30 F0.3\nM30", "linuxcnc", (2, 9)),
        ("G0 X50 Z2\nG1 Z-30 F.05\nM30", "fanuc", (2, 9)),
        ("G20\nG1 Z-3 F.01\nM30", "linuxcnc", (2, 8)),
        ("G98 G1 Z-3. F.2\nM30", "fanuc-lathe", (1, 13)),
    ],
)
def test_a_feed_that_nobody_means_is_said(text: str, dialect: str, expected: tuple[int, int]) -> None:
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect=dialect), found)
    said = [(d.span.line, d.span.column) for d in found if d.code == "feed-doubtful" and d.span]
    assert said == [expected]


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("S500 M3\nG95\nG1 Z-30 F0.3\nM30", "linuxcnc"),
        ("G93\nG1 Z-30 F0.3\nM30", "linuxcnc"),
        ("G20\nG1 Z-3 F0.5\nM30", "linuxcnc"),
        ("(F0.3)\nG1 Z-3 F5 ; F0.1\nM30", "linuxcnc"),
        ("S500 M3\nG1 Z-3. F.2\nM30", "fanuc-lathe"),
    ],
)
def test_feeds_that_are_meant(text: str, dialect: str) -> None:
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect=dialect), found)
    assert [d.code for d in found if d.code == "feed-doubtful"] == []


def remarks(text: str) -> list[str]:
    """Return codes of what is said when a program is read as LinuxCNC's."""
    program = read(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect="linuxcnc"))
    for _ in range(2):
        list(program.chunks())
    return [d.code for d in program.diagnostics]


def test_hours_at_such_feeds_are_said_once_with_the_other_reading() -> None:
    """200 mm at 0.3 mm/min are 11.1 hours; at 0.3 mm a revolution and 1000 rev/min, 40 s."""
    assert remarks("G1 X200 F0.3\nM2").count("time-doubtful") == 1
    assert "time-doubtful" not in remarks("G1 X100 F0.3\nM2")
    assert remarks("G4 P40000\nM2").count("time-doubtful") == 1


@pytest.mark.parametrize(
    ("text", "rival"),
    [
        ("G95", "Okuma's OSP controls"),
        ("G99", ""),
        ("T0101\nG95", ""),
    ],
)
def test_g95_beside_g50_s_is_of_no_lathe_of_fanuc(text: str, rival: str) -> None:
    """A has G98 and G99 (B-64304EN-1, table 3), B and C have G92 S; Okuma's OSP has both. With signs of FANUC, G95 is the fault alone."""
    program = f"G50 S2000\nG96 S150 M3\n{text}\nG0 X62. Z2.\nG1 Z-20. F0.15\nM30"
    assert choose(open_source(io.BytesIO(program.encode()), "t.nc")).rival == rival


#: Programs of controls that are not read, in the style of their manuals, and what each control is called.
UNREAD = [
    ("T001001T000M6\nG0 X10 Y0", "Mazak's INTEGREX and other turning centres with milling"),
    ("IF[PRES EQ 1]NM59\nM58\nNM59 M59\nG0 X800 Z800", "Okuma's OSP controls"),
    ("$SHAFT.MIN%\nO0001\nG50 S2000\nG00 X800 Z800\nT010101\nG96 S200 M03\nG85 NLAP1 D4 F0.3\nM02", "Okuma"),
    ("O1001\nG16 H0\nG0 Z9999\nM6 T1\nG15 H1\nG0 X10. Y20.\nG56 Z15. H1\nG1 Z-5. F333.\nM2", "Okuma"),
    ("O1\nVC1=10\nVC2=VC1+5\nG0 X=VC2\nM2", "Okuma"),
    ("N100 G00 X80 Z5\nM110\nG94\nSB=2000 M13\nG181 X60 Z-10 C0 K5 F100\nC60\nG180\nM02", "Okuma"),
    ("G140\nNSTRT\n(OD ROUGH RIGHT)\nG0 X20. Z30.\nG50 S800\nT010101\nM42\nG97 S200 M3\nG0 X1.8 Z.1\nG95 G1 Z-1. F.01\nM2", "Okuma"),
    ("G140\nG50 S2000\nG00 X800 Z300\nT010101\nG96 S150 M03 M42\nG00 X100 Z2\nG01 Z-20 F0.2\nG00 X800 Z300\nM02", "Okuma"),
    ("G50 S2000\nG96 S150 M03\nT010101\nG95\nG00 X62 Z2\nG01 Z-20 F0.15\nG00 X200 Z100\nM02", "Okuma"),
    ("N10 G97 S800 M03\nG00 X34 Z5\nG71 X27.55 Z-24 B60 D0.6 U0.1\n$H2.45 L2 F2\nG00 X100 Z50\nM02", "Okuma"),
    ("; LightBurn 1.6.03\n; Marlin device profile, user origin\nG21\nG90\nM106 S128\nG1 X20 F1200\nM107\nM2", "3D printers"),
    (";FLAVOR:Marlin\nM104 S200\nG28\nG92 E0\nG1 X10 Y20 E1.5 F1500\nM84", "3D printers"),
    ("N1 O3 (EDGES)\nN2 G0 G90 M6 T7\nN4 G90 G0 X-40. Y0 E1\nN5 H7 Z5.\nN9 G0 Z50.\nN39 G90 H0 Z0.\nN40 E0 X0. Y250.\nN41 M2", "Fadal"),
    ("%MPF  90\nR11=384.5 R12=213.\nN1 @371 R52 K2 K0\nN2 @122 R52 K0 K10\nN10 G0 G17 G40 Z631.6 D0\nN670 M30", "SINUMERIK 810"),
    ("%1234\nN10 G0 G52 Z0\nN20 T1 D1 M6\nN40 G0 X0 Y0\nN60 G1 Z-2 F200\nN70 G77 N40 N60 S3\nM2", "NUM"),
    ("%55\nN10 G16 R+\nN20 T3 D3 M6\nN50 G81 Z-10 ER2 EH50 F100\nN60 X20\nN70 G80 G52 Z0 M5\nM2", "NUM"),
    ("%20\nL0=5\nN10 G0 X0 Y0\nN20 G1 X10 F200\nN30 L0=L0-1\nN40 G79 L0>0 N20\nM2", "NUM"),
    ("%7 (PIECE)\nN10 G40 G80 G90\nN20 G0 G52 Z0\nN30 T1 D1 M6\nN40 G0 X5 Y5\nM2", "NUM"),
    ("O1000\nG90 G0 G54 X0 Y0\nG100 T1 X0 Y0 Z10. S2000 M3 H1 D1\nG1 Z-5. F200\nM30", "Brother"),
    ("G21\n#1 = 10\nwhile [#1 > 0]\nG1 X#1 F100\n#1 = [#1 - 1]\nendwhile\nM30", "Eding"),
    ("G28\nG1 X10 Y10 F6000\nvar a = 5\nG1 X{var.a} F6000\nM30", "3D printers"),
    ("%PM\nN9000 (TURNED)\nN10 G54\nN20 G99 X105 Z1237\nN60 G1 Z-4 F0.4\nN950 M30", "Philips"),
    ("%1234\nN10 G0 G52 Z0\nN20 T1 D1 M6\nN30 S1500 M3 M40\nN40 G0 X10 Y20\nN50 G1 Z-5 F200\nN90 G77 N40 N50 S3\nN110 M2", "NUM"),
    ("%12\nN10 G0 G52 Z0\nN20 G0 X10 Y20\nN30 G1 Z-5 F200\nN40 M2", "NUM"),
    ("%1\nN10 L1=10\nN20 G79 L1>5 N50\nN50 G1 X10 EB5 F100\nN70 M2", "NUM"),
    ("%1\nN10 G52 X0 Z0\nN70 G64 N150 N90 I0.4 K0.1 P2\nN80 G1 X0 Z0 F.3\nN90 M2", "NUM"),
    ('(UAO,1)\n(DIS,"START")\nG0 X0 Y0\nT1.1 M6\n(RPT,5)\nG91 G1 X10 F200\n(ERP)\nM30', "OSAI"),
    ("N1 G17\nN3 G98 X0 Y0 Z-20 I100 J100 K20\nN4 G0 X10\nM30", "Philips"),
    ("N1 G17\nN2 G0 X1\nN9 G14 N1=2 N2=2 J2\nN10 M30", "Philips"),
    ("G21\n#1 = 5\nwhile [#1 > 0]\nG1 X[#1] F200\nendwhile\ngosub change\nM30\nsub change\nendsub", "Eding"),
    ("G90\nM3 S1000\nG1 Z-1 F100\nM98 P\"macro.g\"\nM5", "3D printers"),
    ("G90\nG28 X Y\nM106 S255\nG1 X10 F600\nM107\nM400\nM84", "3D printers"),
    ("; homex.g\nM98 P0:/sys/steppers.g ; slower\nM915 X S3 F0\nG91\nG1 S1 X-250 F3500", "3D printers"),
    ("%x = 20\n%wait\nG91 G38.2 Y[y] F[feed]\n%y1 = posy ; where\nG90 G10 L20 P1 Y[y1]", "CNCjs"),
    ('{"gc":"G0 X10"}\nG1 X10 F100\nM2', "TinyG"),
    ("%MAIN\nN20 #CONTOUR MODE ON [DEV PATH_DEV 0.01]\nN40 $IF P1 > 3\nN50 G1 X5 F1000\nN60 $ENDIF\nM30", "Beckhoff"),
    ("%@MACRO\n@1 := 5;\nG1 X10 F100;\nM30", "Syntec"),
    (":N10 G0 G70 G90 T1 M6\nN20 X1 Y1 S1000 M3\nN50 M2", "Acramatic"),
    ("N0001(9)M06$\nN0002(0)X1Y1$\nN0004(E)$", "Dynapath"),
    ("G06A1.2B0\nG92X1270.Y1270.\nX100.Y100.T201\nG50", "Amada"),
    ("C000 = 0006 015 2215 000 240\nH000 = +000000.0100\nG54\nG42H000\nG01X5.Y0\nM02", "Sodick"),
    ("M48\nMETRIC,TZ\nT1C0.800\n%\nT1\nX1000Y1000\nM30", "Excellon"),
    ("M25 G49\nG17 G40\nT1 M6\nM225 #100 \"Press start\"\nM2", "Centroid"),
    ("o9101\n#[z] = 1\nn5\nif [#(20100+#z) == 77] then goto 7\nn7\n#[z] = #z + 1\nif [#z < 6] goto 5\nM99", "Centroid"),
    ('M225 #100 "X at %f" #101\n#101 = 10\nG65 "probe.cnc" A1\nM2', "Centroid"),
    ("SET_VELOCITY_LIMIT ACCEL=3000\nG1 X10 F3000\nEXCLUDE_OBJECT_START NAME=a\nG1 X20", "printers"),
    ("SA\nMS,2,1\nJZ,0.5\nM3,2,2,-0.1", "ShopBot"),
    ("IN;SP1;PU0,0;PD1000,0;PU;", "HP-GL"),
    ("PARTNO/TEST\nLOADTL/1\nGOTO/10,10,0\nFINI", "APT"),
    ("Dim Abs\nRapid X 0 Y 0\nLine X 1 Y 1", "Anilam"),
    ("IMF_PBL V1.0\nFASTABS X10000 Y10000\nMOVEABS Z-500", "isel"),
    ("    N  G   X    Z   F  H\n    00 M03\n    01 00 -200  0000", "EMCO"),
    ("N10G90\n#1\nN70G1X1.F10.\n$\n=#1\nN90M2", "BOSS"),
    ("N10 G90 G54 G17\nN20 T1 D1\nN30 M6\nN40 S2000 M3\nN60 G69 G98 Z2 I-20 B5 D2 F150\nN70 X30\nN90 M30", "Fagor"),
    ("N10 G0 X10 Y10 Z50\nN20 G81 G98 Z2 I-10 F100\nN30 G80\nN40 M30", "Fagor"),
    ("N20 G54\nN40 G92 S2000\nN140 X46 Z-60\nN150 G36 R20 X55 Z-25\nN160 G39 R2.5 X68 Z-2.5\nN200 M30", "Fagor"),
    ("N10 G0 X0 Y0 Z10\nN20 (P1=10)\nN30 (P2=P1+5)\nN40 G1 XP1 F200\nN50 (GOTO N80)\nN80 M30", "Fagor"),
    ("%00214\nN0 T1.1\nN10 M6\nN20 G0 G90 G43 Z100 S100 M3\nN30 X-12 Y-67\nN50 G1 Z0 F100\nN60 M30", "Fagor"),
    ("O9104\n#V10 = 1 'TOOL\n#R5 = V12 'FEED\n#IF (R1 = 1) THEN GOTO:AX\n#:AX\nG1 G31 X+R6. F+R5.\n#WAIT\nL9101 R1+1. P2\nM99", "Fadal"),
    ('T99 M6;\nMSG_OK["REMOVE PROBE","",""]\n#100 = INPUT["TOOL","NUMBER?","",1,97,4];\nT#100 M6;\nG04 X10\nM30', "LNC"),
    ('#100 = @100\nG65 "PROBECONFIG"\nIF[#128 == 1]\nM19\nEND_IF\nIF[R_SKIP[0,1] == 1]\nALARM["STOP"]\nEND_IF\nM99', "LNC"),
    ("N1T1M6\nN3G0G90S2000M3X0Y0E1\nN4H1Z.1M8\nN5G1Z-.1F10.\nN8M2", "Fadal"),
    ("N1 O1 (CAP)\nN2 G21\nN3 G0 G17 G40 G49 G80 G90 H0 E0 Z0\nN5 T1 M6\nN6 E1\nN7 G0 G90 S6000 M3 X-36.5 Y-12.\nN8 H1 Z50. M8\nN517 M2", "Fadal"),
    ("N1 G17\nN4 S800 M3 F100\nN5 G81 Y2 Z-10 B10 F80\nN6 G79 X10 Y10 Z0\nN9 M30", "Philips"),
    ("N10 G0 X0 Y0\n10 @5=20\nN60 G1 X@5 F100\nN70 BRANCH STRT\nN80 M30", "Rexroth"),
    # A thread, a roughing cycle, a profile by radii and a loop of the manuals of HNC-21T.
    ("%3323\nN1 G55 G00 X35 Z104\nN2 M03 S300\nN3 G82 X29.2 Z18.5 C2 P180 F3\nN4 X28.6 Z18.5 C2 P180 F3\nN6 M30", "Huazhong"),
    ("%3320\nN1 T0101\nN4 G01 X46 Z3 F100\nN5 G71U1.5R1P6Q8X0.4Z0.1F150\nN6 G00 X0\nN8 Z-20\nN18 M30", "Huazhong"),
    ("%3305\nN1 G92 X16 Z1\nN2 G37 G00 Z0 M03\nN5 G36\nN7 M30", "Huazhong"),
    ("%0001\n#10=20\nG54 G90 G00 X20 Y0 Z5\nWHILE #10 LE 360\n#10=#10+1\nENDW\nM30", "Huazhong"),
    ("%1234\nN1 M03 S500 T0101\nN3 G80 X30 Z-30 I-2.2 F100\nN4 X27 Z-30 I-2.2\nN6 M30", "Huazhong"),
    ("%0024\nG92 X0 Y0 Z10\nG91 G17 M03 S600\nM98 P100\nG24 X0\nM98 P100\nG25 X0\nM30\n%100\nG01 X5 F300\nM99", "Huazhong"),
    ("%0068\nG90 G17 M03 S600\nG43 Z-5 H02\nG68 X0 Y0 P45\nG01 X20 F300\nG69 M05 M30", "Huazhong"),
    ("$1\nO0001\nG50 Z0.\nM06 T0100\nG1 X-0.5 F0.03\n$2\nG610\nM30", "Citizen"),
    ("E001=10 17 16 09 08 10 50 12 05 08 10.0 4.70 G95 100\nG90 G21\nG92 X0. Y0.\nE1\nG1 G42 H1 X0. Y5.\nM2", "AccuteX"),
    # With a macro as FANUC has it; subprograms at the head; a script with O-words.
    ("E001=10 11 10 10 05 15 45\nG92 X0. Y0.\n#6=1.0\nN100\nG1 G41 H#6 X5. Y0.\n#6=#6+1\nIF [#6 LE 2] GOTO 100\nM2", "AccuteX"),
    ("N1 O1 (HOLES)\nN2 L100\nN3 X-36. Y25.2\nN7 M17\nN11 M30\nN13 M6 T2\nN15 G0 G90 X0 Y0 E1 M8\nN16 H2 Z20.\n"
     "N18 G98 G83 X0 Y0 Z-3.35 R2. F40. L0 Q1. P0.500\nN19 L101\nN20 G80\nN50 M2", "Fadal"),
    ("o<skp> if [#<_skipmeasure> GT 0]\n(msg,Skipped)\no<skp> endif\n(dlgname)\n(dlg, Tool Number, dec=0, param=num)\n"
     "(dlgshow)\nG53 G00 Z10\nM2", "PlanetCNC"),
    # As the macros of fchabot-dxf/DDCS-Expert-skill and Klaus-Michael/PlanetCNC_KMS_Stuff jump and ask for their pins.
    ("#2=#2601 ;length\n//Z axis\nG91 G31 Z-#2 F200 P#30 L#31 Q1\nIF #1922==0 GOTO1\n#20=#1927\nN1\n#1505=1(No edge!)\nM30", "DDCS"),
    # Numbers that the operator types: #50 was 0 without a word.
    ("G21 G90 G54\n#2070 = 50(Enter depth: )\nG0 X0 Y0\nG01 Z-#50 F100\nM30", "DDCS"),
    ("#1510 = #50\n#1503 = -5000(Depth: %.1f)\nG0 X0\nM30", "DDCS"),
    ("G91\nWHILE #112<70 DO2\n#112=#112+ABS[#[1519+#45]-1]\nEND2\nIF #24!=#[1910+#1] GOTO2\nG31 X5 F9 K0\nN2 M99", "DDCS"),
    ("o<chk> if [#<_input|#<_probe_pin_1>> NE 0]\n(msg,Probe)\nM2\no<chk> endif\nG0 X1\nM2", "PlanetCNC"),
    ("O7000\nG90 G54\nT01 M06\nG43 H01 Z20.\nG98 G77 X10. Y10. Z-12. R2. J1.25 S1500 L3000\nG80\nM30", "Brother"),
    ("N0030 G95 G97\nN0050 G00 X40.000 Z2.000\nN0060 G84 X30. Z-20. P0=0 P2=0 D0=1000 D3=500 F200\nN0070 M30", "EMCO"),
    ("N1 G54\nN2 G92 S3000\nN3 G14 H0\nN4 G96 S180 F0.3 M4 T1\nN5 G0 X82 Z2\nN6 G81 D2.5 H2 AX0.5 AZ0.1\nN7 G1 X20 RN2\nN8 G80\nN9 M30", "PAL"),
    ("N1 G54\nN2 T2 F120 S1500 M3\nN3 G0 X0 Y0 Z2\nN4 G1 ZI-5\nN5 G1 XI20 YI10\nN6 G23 N4 N5 H2\nN7 M30", "PAL"),
    ("PROGRAMMKOPF\nREVOLVER 1\nFERTIGTEIL\nN2 G0 X0 Z0\nN3 G1 X20 BR-1\nBEARBEITUNG\nN10 G14 Q0\nN14 G810 NS3 NE5 P3\nENDE", "CNC PILOT"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "control"), UNREAD, ids=lambda v: str(v)[:20])
def test_a_control_that_is_not_read_is_named_in_one_error(text: str, control: str) -> None:
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    errors = [one for one in found if one.severity == "error"]
    assert [one.code for one in errors] == ["control-unread"]
    assert control in errors[0].message


def test_a_loop_without_the_number_of_its_do_is_of_macros() -> None:
    """A loop of Huazhong has no DO; a forgotten number would have refused the program as of another control."""
    assert dialect_of("#1=0\nWHILE [#1 LT 3] DO\n#1=#1+1\nEND\nM30")[0] == "fanuc"


@pytest.mark.parametrize(
    "text",
    [
        # Hurco's surface quality, no NURBS of LinuxCNC; a radius beside G43, which LinuxCNC refuses; SINUMERIK in its ISO dialect.
        "G90 G20\nT1 M6\nG0 X1. Y1.\nG43 H1 Z1.\nG05.3 P35\nG1 Z-.1 F10.\nM30",
        "G90 G80 G40 G20\nM6 T1\nG43 H1 D1\nG0 X0 Y0 Z1 M3 S2000\nM2",
        "G291\nG90 G54 G17\nG0 X10. Y10.\nG1 Z-1. F100\nM30",
    ],
)
def test_codes_that_linuxcnc_and_sinumerik_do_not_have(text: str) -> None:
    assert dialect_of(text) == ("fanuc", "")
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    assert [one.code for one in found if one.severity == "error"] == []


@pytest.mark.parametrize(
    "cycle",
    [
        "G73 X10. Y10. Z-5. R2. Q1. P500 F100.",
        "G82 X10. Z-5. R2. P500 F100.",
        "G68 X0 Y0 R45.\nG69",
        "G25 P1 Q2 R3",
        "G81 X10. Z-5. F100.",
        "G37 Z-5. H2",
        # The words of Haas's G83 are those of a blank of Philips' G98.
        "G83 G98 X10. Y0 Z-10. R2. I4. J1. K2. F100.",
        "G98 G73 X10. Z-10. I4. J1. K2. R2. F100.",
        "WHILE[#1LT5]DO1\n#1=#1+1\nEND1",
        # Words of PAL that stand in other languages: a check that is switched off, and angles beside coordinates.
        "G23",
        "G1 X10. A5. F100.",
    ],
)
def test_programs_of_mills_have_no_signs_of_such_controls(cycle: str) -> None:
    found = Diagnostics()
    text = f"O1\nG21 G90 G54\nT1 M6\nS1000 M3\n#1=1\nG43 H1 Z5.\n{cycle}\nG80\nM30"
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    assert "control-unread" not in [one.code for one in found]


def test_a_dwell_of_a_drilling_cycle_is_fanucs() -> None:
    """LinuxCNC has P with G82, G86, G88 and G89 alone; posts of FANUC's kin write it with G83 too."""
    assert (
        dialect_of(
            "G21 G90\nT1 M6\nS1000 M3\nG0 X10. Y10.\nG83 X10. Y10. Z-20. R2. Q5. F200. P0\nX20.\nG80\nM30"
        )[0]
        == "fanuc"
    )
    assert (
        dialect_of(
            "G21 G90\nT1 M6\nS1000 M3\nG0 X10. Y10.\nG83 X10. Y10. Z-20. R2. Q5. F200.\nX20.\nG80\nM30"
        )[0]
        == "linuxcnc"
    )


def test_blocks_that_end_in_a_star_are_likely_of_heidenhain() -> None:
    """Books of other controls write * for the end of a block too; a head with G71 leaves no doubt, a program number speaks for FANUC."""
    blocks = "N10 G00 X+10 Y+10 *\nN20 G01 X+20 F100 *\nN30 M30 *\n"
    for text, sure in ((blocks, "likely"), (f"%PART G71 *\n{blocks}", "certain")):
        choice = choose(open_source(io.BytesIO(text.encode()), "t.nc"))
        assert (choice.dialect, choice.reason.rpartition("(")[2]) == ("heidenhain", f"{sure})")
    assert dialect_of("O1000\nN10 G00 X1.0 Y1.0*\nN20 G43 H1 Z1.*\nN30 M30*\n")[0] == "fanuc"


@pytest.mark.parametrize(
    ("text", "dialect", "line"),
    [
        # On NUM's controls G52 is of machine coordinates; here, and on FANUC's, it shifts the origin.
        ("N10 G0 X0\nN20 G52 Z-10\nN30 G1 X5 F100\nN40 M2", "linuxcnc", 2),
        ("N10 G21\nN20 G0 X0 Y0\nN30 H1 Z5.\nN40 G1 X5 F100\nN50 M2", "linuxcnc", 3),
        # A plotter on a printer's board: M300 S turns its servo, and G4 P50 waits for 50 ms.
        ("G21\nG90\nM300 S30\nG4 P50\nG1 X10 Y5 F3500\nM300 S50\nM2", "linuxcnc", 3),
    ],
)
def test_weak_signs_of_a_control_that_is_not_read_are_said(text: str, dialect: str, line: int) -> None:
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    doubts = [one for one in found if one.code == "dialect-doubtful"]
    assert [one.span.line for one in doubts if one.span] == [line]
    assert dialect in doubts[0].message
    assert "not read" in doubts[0].message
    assert f"--dialect {dialect}" in doubts[0].hint
    # With signs of its own the text is beyond doubt.
    found = Diagnostics()
    check(io.BytesIO(b"O1\nG28 G91 Z0\nG5.1 Q1\n" + text.encode()), "t.nc", diagnostics=found)
    assert [one for one in found if one.code == "dialect-doubtful"] == []


def test_a_dialect_that_is_given_reads_it_all_the_same() -> None:
    found = Diagnostics()
    text = b"O1\nG21 G90\nG15 H1\nG0 X10. Y20.\nM2"
    check(io.BytesIO(text), "t.nc", ReadOptions(dialect="fanuc"), diagnostics=found)
    assert [one.code for one in found if one.severity == "error"] == []


def test_brothers_tool_change_is_no_end_of_a_mirror_image() -> None:
    found = Diagnostics()
    text = b"O1\nG21 G54\nG100 T1 X10. Y10. Z50.\nG100\nG1 Z-2. F300\nM30"
    check(io.BytesIO(text), "t.nc", ReadOptions(dialect="fanuc"), diagnostics=found)
    assert [(one.code, one.span.line) for one in found if one.severity == "error" and one.span] == [
        ("not-read", 3)
    ]


def test_messages_to_the_operator_of_eding_are_passed_over() -> None:
    text = b'G90\nMSG "Tool #11"\nT11 M06\nM03 S26000\nG00 Z5\nlogmsg "cut"\nG01 X10 F1500\nM30'
    program = read(io.BytesIO(text), "t.nc")
    (path,) = program.chunks()
    said = [(one.code, one.span.line) for one in program.diagnostics if one.span and one.severity != "note"]
    assert said == [("other-control", 2)]
    assert path.end[-1, :3].tolist() == [10.0, 0.0, 5.0]


def test_texts_for_the_display_of_marlin_are_passed_over() -> None:
    text = b"G90\nG21\nM117  2D Contour2\nM3 S10000\nG1 X10 F25\nm118 end of job\nN5 M117 Job end\nM117 P1 Q2\nM2"
    program = read(io.BytesIO(text), "t.nc")
    (path,) = program.chunks()
    said = [(one.code, one.span.line) for one in program.diagnostics if one.span and one.severity != "note"]
    assert said == [("other-control", 3)]
    assert path.end[-1, :3].tolist() == [10.0, 0.0, 0.0]


def test_lines_to_a_simulator_are_passed_over() -> None:
    found = Diagnostics()
    text = b"[BILLET X100 Y60 Z20\n[TOOLDEF T1 D6\nO0001\nG21 G90\nG0 X10 Y10\nM30"
    check(io.BytesIO(text), "t.nc", diagnostics=found)
    assert [one.code for one in found if one.severity != "note"] == ["other-control"]


def test_mazaks_exact_path_is_not_of_linuxcnc_alone() -> None:
    text = (
        "(WNO 1)\nG0G90G40G80G17G94\nG61.1\nT01T02M6\nG54X10.Y10.\nG43Z50.H1\nG05P2\nG1Z-5.F200.\nG05P0\nM30"
    )
    assert dialect_of(text) == ("fanuc", "")


def test_words_of_sinumerik_in_comments_do_not_count() -> None:
    text = "(roughing out in soft material)\nG93 (loop)\nG0 X1 Y2 ; TRANS X5\nG1 X5 F10 (goto end)\nM2"
    assert dialect_of(text) == ("linuxcnc", "")
    assert dialect_of("G0 X1\nSOFT\nG1 X5 F100\nM30")[0] == "sinumerik"


@pytest.mark.parametrize(
    "remark",
    ["; toward workpiece (stop on contact)", '(T="DRILL" D10)', "; supply = AC (230 V)", '; MSG ("done")'],
)
def test_calls_and_values_of_sinumerik_in_comments_do_not_count(remark: str) -> None:
    """The first is of a program for grbl; CYCLE800(0) and X=AC(5) of blocks stand before any comment."""
    assert dialect_of(f"G21\nG38.2 Z-10 F100 {remark}\nG0 Z5\nM2") == ("linuxcnc", "")


#: Signs of the table, by their place in it, for messages of a test that fails.
SIGNS = [*signs.WRITTEN, *signs.SPOKEN, *signs.BARE]


@given(st.data())
def test_a_sign_stands_only_where_one_of_its_texts_does(data: st.DataObject) -> None:
    reason, _, pattern, texts = data.draw(st.sampled_from(SIGNS))
    line = data.draw(st.from_regex(re.compile(pattern, re.MULTILINE)))
    assert any(text in line for text in texts), (reason, line)


def test_patterns_compiled_beforehand_are_those_that_re_compiles() -> None:
    """The engine of this Python takes the code that was made when the package was built, and `re` would make the same."""
    made = importlib.import_module("cncgen.grammars.pattern_codes")
    assert made.MAGIC == _sre.MAGIC
    wanted = list(signs.patterns())
    assert made.CODES.keys() == set(wanted)
    assert len(wanted) > len(SIGNS)
    for pattern in wanted:
        # Equal patterns have the same code and flags.
        assert built_patterns.compiled(pattern) == re.compile(pattern)
        assert built_patterns.compiled(pattern).groupindex == re.compile(pattern).groupindex


@pytest.mark.parametrize("codes", [{}, None])
def test_patterns_without_code_are_compiled(
    codes: dict[bytes, bytes] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the package was built for another engine, or not at all."""
    monkeypatch.setattr(built_patterns, "_codes", codes)
    monkeypatch.setattr(built_patterns, "_known", {})
    monkeypatch.setattr(_sre, "MAGIC", 1)
    pattern = next(signs.patterns())
    assert built_patterns.compiled(pattern) == re.compile(pattern)


def each_line(text: bytes, stand: list[int] | None = None) -> tuple[bytes, list[int], list[int]]:
    """Return all lines in capitals, as signs were looked for before lines that differ in coordinates alone were taken once."""
    count = text.count(b"\n") + 1
    return text.upper(), list(range(1, count + 1)), stand or [1] * count


@pytest.mark.parametrize(
    "text",
    [b"X1Y1" + 17 * b"S100" + b"Q E5", b"M106" + 13 * b"S1000" + b"Q", b"(P1=1" + 17 * b"+100" + b"Q)"],
)
def test_a_row_of_numbers_is_looked_at_once(text: bytes) -> None:
    """Each digit could be before or behind a point that is not there, so these lines took from 12 s to minutes."""
    begin = time.process_time()
    choose(open_source(io.BytesIO(text), "t.nc"))
    assert time.process_time() - begin < 1.0


def test_a_point_without_digits_is_no_number() -> None:
    """As the sign of a variable V says (found by the test below)."""
    assert choose(open_source(io.BytesIO(b"V.I."), "t.nc")).reason == "a variable V"


@given(st.data())
def test_signs_are_the_same_in_all_lines_and_in_those_that_differ(data: st.DataObject) -> None:
    number = st.sampled_from(["1", "-0.5", "12.25", ".3", "0.", " 7.5", "+3", "#1", "0.300", "100", "[1.5]"])
    word = st.tuples(st.sampled_from("xXYZIJKFfGMTUWRPQHSA("), number).map("".join)
    lines = [
        st.lists(word, max_size=4).map(lambda words: "".join(words).encode()),
        st.sampled_from(SIGNS).flatmap(lambda sign: st.from_regex(re.compile(sign[2], re.MULTILINE))),
    ]
    text = b"\n".join(data.draw(st.lists(st.one_of(lines), max_size=12)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dialects, "different_lines", each_line)
        expected = choose(open_source(io.BytesIO(text), "t.nc"))
    assert choose(open_source(io.BytesIO(text), "t.nc")) == expected


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("O1\nG21\nM60\nM70\nG0 X1 M72\nM50\nM30", [60, 70, 72, 50]),
        ("BEGIN PGM A MM\nM11 M16\nL X+10 FMAX M62\nM70\nM72\nEND PGM A MM", [11, 16, 62, 70, 72]),
        ('T="A"\nM62\nG0 X1 M72\nM30', [62, 72]),
    ],
    ids=["fanuc", "heidenhain", "sinumerik"],
)
def test_codes_of_linuxcnc_are_the_builders_on_other_controls(text: str, numbers: list[int]) -> None:
    """M70 to M73 saved and restored modal states, M50 to M53 switched overrides, and M11 was refused."""
    program = read(io.BytesIO(text.encode()), "t.nc")
    events = [event for chunk in program.chunks() for event in chunk.events if event.name == "user"]
    assert [event.values["m"] for event in events] == numbers
    assert {d.code for d in program.diagnostics if d.severity == "error"} == set()


@pytest.mark.parametrize(
    "text", ["G21 G90\nG1 X1e F100\nG1 Y= F100\nM2", "G21 G90\nT1M6(ER20 COLLET)\nG0 X1\nM2"]
)
def test_a_spoilt_number_or_a_collet_is_not_of_num(text: str) -> None:
    """``E F100`` without its blank was a word EF, as a collet's ER20 was a word ER."""
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    assert "control-unread" not in {one.code for one in found}


@pytest.mark.parametrize("text", [b"Y" + b"X1" * 32_000, b"G90" * 21_000, b"G0" * 32_000 + b"G91.1"])
def test_signs_of_mills_are_looked_for_once_along_a_line(text: bytes) -> None:
    """A search that goes on to the end of the line from each of n words has n^2 / 2 steps: these took half a minute for 64 KiB."""
    for name, _, pattern, _ in signs.BARE:
        if name in ("X and Y in a block", "a mode G90 or G91 beside G0 or G1"):
            assert re.search(signs.by_line(pattern), text) is None


def test_parentheses_that_nothing_closes_are_looked_at_once() -> None:
    """An end that is missing was looked for anew from each of n parentheses, n^2 / 2 steps: 28 s for 64 KiB."""
    text = b"G1 " + b"(c" * 32_000
    assert re.sub(signs.OUT_OF_CODE, b"", text + b"\nG0") == b"G1 \nG0"
    nested = next(pattern for name, _, pattern, _ in signs.WRITTEN if name == "a comment within a comment")
    assert re.search(signs.by_line(nested), text) is None
    assert re.search(signs.by_line(nested), b"(of (a) part)") is not None
    assert re.search(signs.by_line(nested), b"(of) (a part)") is None


def test_a_line_without_an_end_is_no_sign() -> None:
    """Each code of it was followed to its end, by each sign of a cycle's words: 300 kB took minutes."""
    begin = time.process_time()
    found = Diagnostics()
    check(io.BytesIO(b"G21 F100\n" + b"G81 " * 100_000 + b"\nM2\n"), "long.nc", ReadOptions(), found)
    assert "line-too-long" in {each.code for each in found}
    assert time.process_time() - begin < 10.0
