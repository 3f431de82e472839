"""Programs with depth for the doors of G-code, and what changes them without breaking what they are made of.

Seeds are the texts that the tests of each dialect hold, so that a code whose tests are written is attacked as well, and calls in
calls and loops in loops. A change gives numbers extreme values as the dialect writes them (no exponents), repeats blocks, puts them
into loops and calls, and mixes lines of other seeds in.
"""

from __future__ import annotations

import ast
import random
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

TESTS = Path(__file__).resolve().parents[2] / "tests" / "gcode"
#: Seeds are no longer than this.
LONGEST = 3000
_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d*\.?\d+\.?|(?<=[A-Za-z=])[-+]?\d+\.?\d*")
_VALUES = (
    b"0", b"-0", b"1", b"-1", b"2", b"3", b"7", b"0.5", b"-0.5", b"90", b"-90", b"180", b"360", b"359.9999999", b"89.9999999999", b"0.000000001",
    b"-0.000000001", b"0.0000001", b"0.0001", b"0.001", b"-0.001", b"10000", b"65534", b"65535", b"32767", b"99999", b"1000000", b"-1000000",
    b"99999999", b"-99999999", b"100000000", b"100000000.1", b"999999999", b"2147483648", b"1000000000000", b"0.00000000000000000001", b"45.", b"1.",
)  # fmt: skip

#: Calls in calls, loops in loops, frames in frames, and what waits for many blocks.
DEEP: dict[str, tuple[str, ...]] = {
    "linuxcnc": (
        "G21 F500\no1 sub\no2 repeat [3]\nG91 G1 X1 Y[#1]\no2 endrepeat\no1 endsub\no3 sub\no1 call [2]\no1 call [3]\no3 endsub\no4 while [#5 LT 4]\n#5=[#5+1]\no3 call\no4 endwhile\nM2\n",
        "G17 G40 T1 M6\nG41 D1 G1 X10 F300\nY10\nG3 X0 Y20 I-10\no1 repeat [5]\nG4 P0.1\no1 endrepeat\nG1 X-10\nG40 Y40\nM2\n",
        "G91 G83 X1 Y1 Z-10 R2 Q1 L5 F100\nG73 X1 Z-10 R2 Q.5 L3\nG98 G85 X2 Z-1 R1 L2\nG80\nG90 F100 G5 X10 Y0 I3 J3 P-3 Q3\nG5 X20 I2 J2 P-3 Q-3\nM2\n",
        "G5.2 X0 Y1 P1 L3 F200\nX2 Y2 P2\nX4 Y0 P.5\nX6 Y1 P1\nG5.3\nG6.2 P4 K0 X6 Y1 R1\nK0 X7 Y1 R2\nK0 X8 Y-1 R.5\nK0 X9 Y0 R1\nK1\nK1\nK1\nK1\nM2\n",
        "G18 G7 G90 S500 M3 G0 X20 Z2\nG76 P1.5 Z-20 I-1 J.2 R1.5 K1 Q29.5 H2 E1 L2 F100\nG33 Z-10 K1\nG95 F.2 S500 M3\nG1 X10 Z-5\nG96 S100 D2000\nX5\nM2\n",
        "o10 sub\nG1 X20 Z0\nG3 X30 Z-5 I0 K-5\nG1 X30 Z-20\nX40\no10 endsub\nG18 G7 G90 F100\nG0 X50 Z5\nG71 Q10 X50 Z5 D1 I.5 R.5\nG70 Q10 X50 Z5\nM2\n",
        "G10 L2 P1 X5 R30\nG54 G92 X1\nG52 X2 Y2\nG0 X0 Y0\nG2 X10 Y0 I5 J0 P3 Z-5 F100\nG93 G1 X1 F2\nA90 F.1\nG94 F100 X2 B45 C720\nG28 X1\nG30.1\nM2\n",
    ),
    "fanuc": (
        "O1\nG43.4 H1\nG1 X10. A30. C90. F500.\nA60. C720.\nG0 X0 C0\nG49\nM30\n",
        "G90 G21\nG68.2 X10. Y5. Z0 I30. J45. K-10.\nG53.1\nG98 G81 X3. Y1. Z-4. R2. F100. K5\nG83 X5. Q.5 Z-9. R1. L2\nG80\nG2 X10. Y0 R10.\nG69\nM30\n",
        "G7.1 C20.\nG1 Z5. C30. F100.\nG2 Z10. C60. R12.\nG1 C720.\nG7.1 C0\nG12.1\nG1 X10. C5.\nG3 X5. C10. R8.\nG1 X-10.\nG13.1\nM30\n",
        "G51 X1. Y1. P2000\nG51.1 X5.\nG68 X0 Y0 R30.\nG52 X1.\nG16 G1 X10. Y30. F100.\nG91 Y30.\nG15 G90 G2 I5. J0\nG50.1 X0\nG50\nM30\n",
        "O1\n#1=0\nWHILE[#1LT3]DO1\n#2=0\nWHILE[#2LT3]DO2\n#2=#2+1\nG65 P2 A#1 B#2 L2\nEND2\n#1=#1+1\nEND1\nG66 P2 A1.\nX1.\nX2.\nG67\nM98 P30002\nM30\nO2\nIF[#2GT1]THEN #3=4.\nG91 G1 X#1 Y[#2*#3] F100.\nM99\n",
        "T1 M6\nG41 D1 G1 X10. Y0 F300.\nG2 X20. Y10. R10.\nG1 Y20. ,R6.\nX-20.\nY40.\nG40 Y60.\nG13 D1 I5. K20. Q2. F100.\nG12 I10. F50. D1\nG10 L12 P1 R4.\nG31 Z-5. F50.\nM30\n",
        "G84 Z-10. R2. F500. Q1. K3\nM29 S500\nG74 Z-5. R1. F1.\nG76 Z-5. R1. Q.3 P500\nG87 Z5. R-10. Q1.\nG73 X1. Z-20. R1. Q.01 K0\nM30\n",
    ),
    "fanuc-lathe": (
        "O1\nG97 S1000 M3 T0101\nG0 X42. Z2.\nG71 U2. R1.\nG71 P1 Q2 U.4 W.1 F.2\nN1 G0 X20.\nG1 Z-10.\nG2 X30. Z-15. R5.\nG1 X30. Z-20. ,R2.\nN2 X40. Z-30.\nG70 P1 Q2\nM30\n",
        "G97 S500 M3\nG0 X42. Z2.\nG72 W2. R1.\nG72 P1 Q2 U.4 W.1 F.2\nN1 G0 Z-30.\nG1 X30. F.1\nZ-20.\nN2 X20. Z0\nG73 U4. W1. R3\nG73 P3 Q4 U.4 W.1 F.2\nN3 G0 X20.\nG1 Z-10.\nN4 X40. Z-20.\nM30\n",
        "G97 S500 M3\nG76 P021060 Q80 R.1\nG76 X18. Z-20. P900 Q200 R0 F1.5\nG74 R.5\nG74 X10. Z-20. P2000 Q3000 F.1\nG75 R.5\nG75 X10. Z-9. P2000 Q1500 F.1\nG92 X20. Z-9. R-1. F1.\nX19.\nX18.\nG90 X30. Z-10. F.2\nG94 X10. Z-5. R-1.\nM30\n",
        "G96 S200 M3\nG50 S2000\nG12.1\nG42 G1 X20. C10. F100.\nC-10.\nG3 X10. C-20. R10.\nG40 G1 X40.\nG13.1\nG83 Z-10. R-2. Q2000 F100. C90.\nG80\nG32 Z-9. F1.\nM30\n",
    ),
    "sinumerik": (
        "G17 G90 F300 S1000 M3\nT1 D1 M6\nPOCKET3(5,0,1,-6,30,20,4,0,0,15,2,0.2,0.1,300,100,0,11,3)\nPOCKET4(5,0,1,-6,15,0,0,2,0.2,0.1,300,100,0,11,3)\nSLOT1(5,0,1,-6,,3,30,12,0,0,20,0,120,100,300,2,0,0.2,0)\nLONGHOLE(5,0,1,-6,,4,30,0,0,20,45,90,100,300,2)\nM30\n",
        "G17 F300 S1000 M3\nT1 D1 M6\nCYCLE71(10,0,2,-4,0,0,60,40,30,2,5,2,0,500,31,0)\nCYCLE61(50,0,1,-6,0,0,100,50,2,80,0,500,31,0,1,10)\nCYCLE76(10,0,1,-10,,40,30,5,0,0,0,4,0.2,0.1,500,200,0,1,60,50)\nCYCLE77(10,0,1,-10,,40,0,0,4,0.2,0.1,500,200,0,1,60)\nM30\n",
        'G17 G90 G94 F500 S1000 M3\nT1 D1 M6\nG0 X-30 Y-30 Z20\nCYCLE72("WAY",20,0,2,-7,4,1,1,300,100,111,41,2,5,400,3,3)\nM30\nPROC WAY\nG1 X0 Y0\nX40 RND=9\nG3 Y20 CR=10\nG1 X0\nY0\nM17\n',
        'G18 G90 G94 F500 S500 M4 DIAMON\nG0 X100 Z20\nCYCLE95("PA:PE",2,0.1,0.2,0,300,100,150,9,0,0,1)\nCYCLE97(1.5,,0,-30,20,20,3,2,0.92,0.02,29,0,6,1,3,1)\nM30\nPA:\nG1 X20 Z0\nZ-10\nG2 X30 Z-15 CR=5\nG1 Z-30\nX40\nPE:\n',
        "R1=0\nWHILE R1<4\nR1=R1+1\nFOR R2=1 TO 3\nATRANS X=R1\nAROT RPL=10\nASCALE X0.5 Y0.5\nAMIRROR X0\nUP(R1,R2) P2\nENDFOR\nENDWHILE\nTRANS\nM30\nPROC UP(REAL A, REAL B)\nG1 X=A Y=B F100\nREPEAT ANF P=2\nANF:\nG91 X1 G90\nRET\n",
        "F100 S500 M3\nMCALL CYCLE83(5,0,1,-40,,-5,,1,0.1,0,1,0,3,2,0.5,0.6,1)\nHOLES1(0,0,30,10,5,400)\nHOLES2(0,0,20,0,10,36)\nMCALL CYCLE84(5,0,1,-10,,0.5,3,,1.5,0,500,500)\nX1\nMCALL\nCYCLE800(1,\"\",0,57,0,0,0,30,45,10,0,0,0,-1)\nX1 Y1 Z1\nM30\n",
        "G1 F500 X0 Y0\nBSPLINE X1 Y2 PL=1 PW=2\nX3 Y0 PW=0.5\nX4 Y4\nX6 Y0 PL=2\nASPLINE X8 Y1\nX9 Y3\nCSPLINE X10 Y0\nX12 Y1\nG2 X14 Y1 CR=2 TURN=3\nG3 AR=120 X10 Y5\nCT X12 Y8\nPOLY PO[X]=(1,2,3) PO[Y]=(4,5,6) PL=1\nM30\n",
        "G54 S500 M3 G0 X0 Z5\nTRANSMIT\nG1 X10 Y5 F100\nG3 X5 Y10 CR=8\nTRAFOOF\nTRACYL(40)\nG1 Y20 Z-5\nG2 Y40 Z-10 CR=15\nTRAFOOF\nG33 Z-10 K2\nG331 Z-10 K1.5\nG332 Z5 K1.5\nG95 F.2 G96 S100 LIMS=2000\nG1 X20\nSUPA G0 X0\nG4 S5\nM30\n",
    ),
    "heidenhain": (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F300\nLBL 1\nLBL 2\nL IX+1 FMAX\nCALL LBL 2 REP 3\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 IROT+30\nCYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.9\nCYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X Y\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 IX+5\nCALL LBL 1 REP 3\nCALL LBL 9\nM30\nLBL 9\nCALL LBL 8\nCALL LBL 8\nLBL 0\nLBL 8\nL IY+1 F100\nLBL 0\nEND PGM A MM\n",
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F300\nCYCL DEF 251 POCKET ~\n Q215=0 ~\n Q218=40 ~\n Q219=30 ~\n Q220=5 ~\n Q368=0.2 ~\n Q224=0 ~\n Q367=0 ~\n Q207=500 ~\n Q351=1 ~\n Q201=-8 ~\n Q202=4 ~\n Q369=0.1 ~\n Q206=100 ~\n Q338=0 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q370=1 ~\n Q366=0\nCYCL DEF 220 POLAR ~\n Q216=0 ~\n Q217=0 ~\n Q244=60 ~\n Q245=0 ~\n Q246=360 ~\n Q247=0 ~\n Q241=3 ~\n Q200=2 ~\n Q203=0 ~\n Q204=50 ~\n Q301=1 ~\n Q365=0\nCYCL DEF 252 ROUND ~\n Q215=1 ~\n Q368=0 ~\n Q223=30 ~\n Q207=500 ~\n Q351=1 ~\n Q201=-8 ~\n Q202=4 ~\n Q369=0 ~\n Q206=100 ~\n Q338=0 ~\n Q200=2 ~\n Q203=0 ~\n Q204=20 ~\n Q370=1 ~\n Q366=0\nCYCL DEF 221 ROWS ~\n Q225=0 ~\n Q226=0 ~\n Q237=10 ~\n Q238=8 ~\n Q242=3 ~\n Q243=4 ~\n Q224=15 ~\n Q200=2 ~\n Q203=0 ~\n Q204=50 ~\n Q301=1\nL X+0 Y+0 R0 FMAX M99\nEND PGM A MM\n",
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F350\nCYCL DEF 256 STUD ~\n Q218=+40 ~\n Q424=+48 ~\n Q219=+20 ~\n Q425=+28 ~\n Q220=+0 ~\n Q224=+30 ~\n Q367=+0 ~\n Q207=+300 ~\n Q201=-8 ~\n Q202=+5 ~\n Q206=+100 ~\n Q200=+2 ~\n Q203=+0 ~\n Q204=+20 ~\n Q370=+1 ~\n Q368=+0 ~\n Q351=+1\nCYCL CALL\nCYCL DEF 257 STUD ~\n Q223=+20 ~\n Q222=+36 ~\n Q369=+0 ~\n Q207=+300 ~\n Q201=-8 ~\n Q202=+5 ~\n Q206=+100 ~\n Q200=+2 ~\n Q203=+0 ~\n Q204=+20 ~\n Q370=+1 ~\n Q368=+0 ~\n Q351=+1\nCYCL CALL\nCYCL DEF 232 FACE ~\n Q389=2 ~\n Q225=+0 ~\n Q226=+0 ~\n Q227=+3 ~\n Q386=+0 ~\n Q218=+30 ~\n Q219=+28 ~\n Q202=+1 ~\n Q369=+0.5 ~\n Q370=+1 ~\n Q207=+300 ~\n Q385=+200 ~\n Q253=+500 ~\n Q200=+2 ~\n Q357=+1 ~\n Q204=+20\nCYCL CALL\nEND PGM A MM\n",
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F350\nCYCL DEF 262 THREAD ~\n Q335=20 ~\n Q239=1.5 ~\n Q201=-18 ~\n Q355=3 ~\n Q253=750 ~\n Q351=1 ~\n Q200=2 ~\n Q203=0 ~\n Q204=50 ~\n Q207=500\nCYCL CALL\nCYCL DEF 208 BORE ~\n Q200=2 ~\n Q201=-8 ~\n Q206=100 ~\n Q334=0.5 ~\n Q203=0 ~\n Q204=20 ~\n Q335=20 ~\n Q342=0 ~\n Q351=1\nCYCL CALL\nCYCL DEF 205 PECK ~\n Q200=2 ~\n Q201=-20 ~\n Q206=100 ~\n Q202=5 ~\n Q203=0 ~\n Q204=20 ~\n Q212=0.5 ~\n Q205=1 ~\n Q258=1 ~\n Q259=1 ~\n Q257=2 ~\n Q256=0.2 ~\n Q211=0 ~\n Q379=0\nCYCL CALL\nCYCL DEF 203 UNIVERSAL ~\n Q200=2 ~\n Q201=-12 ~\n Q206=100 ~\n Q202=5 ~\n Q210=0 ~\n Q203=0 ~\n Q204=20 ~\n Q212=1 ~\n Q213=1 ~\n Q205=3 ~\n Q211=0 ~\n Q208=0 ~\n Q256=0.5\nCYCL CALL\nEND PGM A MM\n",
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F350\nL X-30 Y+0 R0 FMAX\nAPPR CT X+0 Y+0 CCA90 R+10 RL F300\nL X+20\nRND R6\nL Y+20\nL X+0\nCC X+0 Y+10\nC X+0 Y+0 DR+\nCR X+5 Y+5 R+8 DR-\nCT X+9 Y+9\nDEP LCT X-30 Y+28 R10\nCC X+5 Y+5\nLP PR+10 PA+30\nCP IPA+720 IZ-5 DR+\nL X+6 Y+6 Z+0\nSPL X+0 Y+0 K3X+2 K2X+3 K1X+1 K3Y+1 K2Y+2 K1Y+3 F100\nEND PGM A MM\n",
        "BEGIN PGM A MM\nQ1 = 2\nQ2 = SQRT ( Q1 ^ 2 + 3 ) * SIN 30\nFN 4: Q5 = +Q1 DIV +3\nLBL \"A\"\nQ3 = Q3 + 1\nL X+Q3 Y+Q2 Z+Q5 F100\nFN 12: IF +Q3 LT +9 GOTO LBL \"A\"\nFN 18: SYSREAD Q9 = ID20 NR1\nCALL LBL \"B\" REP 5\nPLANE SPATIAL SPA+30 SPB+10 SPC+0 STAY\nL X+1 Y+1 Z+1\nPLANE RESET STAY\nM128\nL X+2 A+10\nM129\nLBL \"B\"\nL IX+1\nEND PGM A MM\n",
    ),
}  # fmt: skip
#: A block in a loop or a call: what stands before and behind it.
_AROUND: dict[str, tuple[tuple[bytes, bytes], ...]] = {
    "linuxcnc": (
        (b"o91 repeat [%d]\n", b"\no91 endrepeat\n"),
        (b"#91=0\no92 while [#91 LT %d]\n#91=[#91+1]\n", b"\no92 endwhile\n"),
        (b"o93 sub\n", b"\no93 endsub\no94 repeat [%d]\no93 call [1]\no94 endrepeat\n"),
    ),
    "fanuc": (
        (b"#91=0\nWHILE[#91LT%d]DO3\n#91=#91+1\n", b"\nEND3\n"),
        (b"M98 P91 L%d\nM30\nO91\n", b"\nM99\n"),
        (b"G91\n", b"\nM99 P%d\n"),
    ),
    "sinumerik": (
        (b"FOR R91=1 TO %d\n", b"\nENDFOR\n"),
        (b"REPEAT\n", b"\nR92=R92+1\nUNTIL R92>%d\n"),
        (b"A91:\n", b"\nREPEAT A91 P=%d\n"),
    ),
    "heidenhain": ((b"LBL 91\n", b"\nCALL LBL 91 REP %d\n"), (b"LBL 92\nQ91 = Q91 + 1\n", b"\nFN 12: IF +Q91 LT +%d GOTO LBL 92\n")),
}  # fmt: skip
_COUNTS = (2, 3, 10, 100, 10_000, 65_534, 999_999_999)


def _language(dialect: str) -> str:
    """Return the dialect whose loops and tests serve another one."""
    return {"fanuc-lathe": "fanuc", "auto": "linuxcnc"}.get(dialect, dialect)


@cache
def seeds(dialect: str) -> list[bytes]:
    """Return programs of a dialect: deep ones, and the texts of its tests."""
    deep = [text.encode() for text in DEEP.get(dialect, sum(DEEP.values(), ()))]
    return deep * 4 + [text for name, text in _texts() if dialect == "auto" or _of(name) == dialect]


def _of(name: str) -> str:
    """Return the dialect that the file of a test is about."""
    marks = (("sinumerik", "sinumerik"), ("heidenhain", "heidenhain"), ("lathe_fanuc", "fanuc-lathe"), ("lathe", "fanuc-lathe"),
             ("turning", "fanuc-lathe"), ("fanuc", "fanuc"), ("haas", "fanuc"), ("tilted", "fanuc"), ("rotary", "fanuc"),
             ("tool_point", "fanuc"), ("by_name", "fanuc"))  # fmt: skip
    return next((dialect for mark, dialect in marks if mark in name), "linuxcnc")


@cache
def _texts() -> list[tuple[str, bytes]]:
    """Return the texts of more than one line in the tests of G-code, each with the name of its file."""
    return [
        (file.name, text.encode())
        for file in sorted(TESTS.glob("test_*.py"))
        for text in sorted(set(_of_module(ast.parse(file.read_text()))))
        if "\n" in text.strip() and len(text) <= LONGEST
    ]


def _of_module(tree: ast.Module) -> Iterator[str]:
    """Yield the texts of a module: fields of f-strings are its constants of that name, or 1; fields of formats are 1."""
    named = {
        target.id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name) and isinstance(node.value.value, str)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield re.sub(r"\{\w*\}", "1", node.value)
        elif isinstance(node, ast.JoinedStr):
            yield "".join(
                str(part.value)
                if isinstance(part, ast.Constant)
                else named.get(ast.unparse(part.value) if isinstance(part, ast.FormattedValue) else "", "1")
                for part in node.values
            )


def changed(rng: random.Random, data: bytes, sources: list[bytes], dialect: str) -> bytes:
    """Return a program with one to three things changed in ways that leave most of its structure valid."""
    for _ in range(rng.choice([1, 1, 2, 3])):
        kind = rng.random()
        if kind < 0.6:
            data = _numbers(rng, data)
            continue
        lines = data.split(b"\n")
        begin = rng.randrange(len(lines))
        end = min(begin + rng.choice([1, 2, 5]), len(lines))
        if kind < 0.75:
            before, behind = rng.choice(_AROUND[_language(dialect)])
            count = rng.choice(_COUNTS)
            around = [part % count if b"%d" in part else part for part in (before, behind)]
            lines[begin:end] = [around[0] + b"\n".join(lines[begin:end]) + around[1]]
        elif kind < 0.9:
            other = rng.choice(sources).split(b"\n")
            at = rng.randrange(len(other))
            lines[begin:begin] = other[at : at + rng.choice([1, 2, 4])]
        elif kind < 0.95:
            lines[begin:end] = lines[begin:end] * rng.choice([2, 3, 50])
        else:
            del lines[begin:end]
        data = b"\n".join(lines)
    return data[:20_000]


def _numbers(rng: random.Random, data: bytes) -> bytes:
    """Return a text with one to three numbers replaced."""
    for _ in range(rng.choice([1, 1, 2, 3])):
        found = list(_NUMBER.finditer(data))
        if not found:
            return data
        match = rng.choice(found)
        data = data[: match.start()] + _value(rng) + data[match.end() :]
    return data


def _value(rng: random.Random) -> bytes:
    """Return a number without an exponent: one of the extremes, or of any magnitude."""
    if rng.random() < 0.6:
        return rng.choice(_VALUES)
    text = f"{rng.choice([1, 1, -1]) * 10.0 ** rng.uniform(-9.0, 8.0):.10f}"
    return text.rstrip("0").encode()
