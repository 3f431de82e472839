"""Programs without end, and long ones that do end: what tells them apart, and when."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from itertools import groupby
from typing import Any

import pytest

from cncgen.gcode import budget
from cncgen.gcode.codes import tool_centre

Run = Callable[..., Any]

#: Each with the line that leads back: neither a parameter nor the machine is another one after a round.
ROUND = {
    "motions": ("G21 F100\no1 while [1]\nG1 X1\nG1 X0\no1 endwhile\nM2", "linuxcnc", 5),
    "no counter": ("#1=3\no1 while [#1 GT 2]\n#2=[#1*2]\no1 endwhile\nM2", "linuxcnc", 4),
    "a branch inside": (
        "o1 while [1]\no2 if [#<_x> GT 0]\nG0 X0\no2 else\nG0 X1\no2 endif\no1 endwhile\nM2",
        "linuxcnc",
        7,
    ),
    "called": ("o9 sub\no1 do\nG0 X1\nG0 X#1\no1 while [1]\no9 endsub\no9 call [7]\nM2", "linuxcnc", 5),
    "back by M99": ("O1\nN10 G0 X1\nX0\n[1 EQ 1] M99 P10\nM30", "fanuc", 4),
    "back by GOTO": ("O1\nN10 #2=#0\nG0 X1\nG0 X0\nIF [1 EQ 1] GOTO 10\nM30", "fanuc", 5),
    "under cutter compensation": (
        "O1\nG10 L12 P4 R2\nG41 D4 G1 X9 Y9 F100\nN10 X20\nY20\nX1\nY1\nIF [1 EQ 1] GOTO 10\nM30",
        "fanuc",
        8,
    ),
    "in a turned frame": ("O1\nG68 X0 Y0 R30\nN10 G0 X1\nX0\nIF [1 EQ 1] GOTO 10\nM30", "fanuc", 5),
    "compensated in a frame": (
        "O1\nG51.1 X0\nG41 D0 G1 X9 F9\nN10 X20\nY20\nX1\nY1\nIF [1 EQ 1] GOTO 10\nM30",
        "fanuc",
        8,
    ),
    "a tool a round": ("O1\nN10 T1 M6\nT2 M6\nIF [1 EQ 1] GOTO 10\nM30", "fanuc", 4),
}

#: Long loops that end, by what only one kind of state tells: rounds left, a name, a place, an offset, a tool, the calls.
ENDING = {
    "repeat": "o1 repeat [4000]\nG0 X1\nG0 X0\no1 endrepeat\nM2",
    "repeat around a call": (
        "o9 sub\no2 repeat [3]\nG0 X1\nG0 X0\no2 endrepeat\no9 endsub\no1 repeat [2000]\no9 call\no1 endrepeat\nM2"
    ),
    "name": "#<n>=0\no1 while [#<n> LT 4000]\nG0 X1\n#<n>=[#<n>+1]\nG0 X0\no1 endwhile\nM2",
    "place": "G91\no1 while [#<_x> LT 40]\nG0 X0.01\nY1\nY-1\no1 endwhile\nM2",
    "compensated": (
        "#<n>=5\nG41.1 D1 G1 X5 Y-5 F100\no1 while [#<n> LT 9]\nY#<n>\nX-#<n>\nY-#<n>\n#<n>=[#<n>+0.01]\nX#<n>\n"
        "o1 endwhile\nM2"
    ),
    "frame": "O1\n#1=0\nN10 G68 X0 Y0 R#1\nG0 X1\nG0 X0\nG69\n#1=#1+1\nIF [#1 LT 900] GOTO 10\nM30",
    "origin": "o1 while [#5221 LT 4]\nG10 L20 P1 X[#5420-0.001]\nG0 X0\no1 endwhile\nM2",
}


@pytest.mark.parametrize("name", ROUND)
def test_a_program_that_comes_back_to_the_same_state_is_endless(run: Run, name: str) -> None:
    text, dialect, line = ROUND[name]
    codes = [(code, at) for code, at, _ in run(text, dialect=dialect, max_steps=100_000).errors]
    assert codes == [("too-many-steps", line)]


@pytest.mark.parametrize("loop", ["N10 X9", "N10 Z1\nZ2", "N10 S100\nM8"])
def test_blocks_wait_for_a_move_under_cutter_compensation_up_to_a_bound(
    run: Run, monkeypatch: pytest.MonkeyPatch, loop: str
) -> None:
    """Nothing there moves in the plane: what waits grew without bound, and each block looked through all of it."""
    monkeypatch.setattr(tool_centre, "MAX_WAITING", 1000)
    out = run(f"O1\nG10 L12 P4 R2\nG41 D4 G1 X9 Y9 F100\n{loop}\nIF [1 EQ 1] GOTO 10\nM30", dialect="fanuc")
    assert "comp-waiting" in {code for code, _, _ in out.errors}
    assert {code for code, _, _ in out.errors} <= {"comp-waiting", "too-many-steps"}


def test_reading_goes_on_behind_an_endless_loop(run: Run) -> None:
    out = run("o1 while [1]\nG0 X1\nG0 X0\no1 endwhile\nG0 Y7\nG1 X=\nM2")
    assert [(code, line) for code, line, _ in out.errors] == [("too-many-steps", 4), ("syntax", 6)]


@pytest.mark.parametrize("name", ENDING)
def test_a_long_loop_ends_by_any_kind_of_state(run: Run, name: str) -> None:
    assert run(ENDING[name]).errors == []


def test_the_bound_of_loops_is_not_one_of_the_text(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget, "MOST_WORK", 500)
    monkeypatch.setattr(budget, "WORK_OF_A_LINE", 2)
    assert run("G0 X1\nG0 X0\n" * 10_000 + "M2").errors == []
    counts = "#1=0\no1 while [#1 LT 1000]\n#1=[#1+1]\no1 endwhile\nM2"
    assert [code for code, _, _ in run(counts).errors] == ["too-many-steps"]
    assert run(counts, max_steps=10_000).errors == []
    assert [code for code, _, _ in run("G0 X1\n" * 20 + "M2", max_steps=10).errors] == ["too-many-steps"]


#: Programs of a few lines whose blocks cost far more than a plain block, and their dialects.
COSTLY = {
    "nested calls": (
        "O1000\nM98 P2000 L999\nM30\nO2000\nM98 P3000 L999\nM99\nO3000\nM98 P4000 L999\nM99\nO4000\n#1=1\nM99\n",
        "fanuc",
    ),
    "holes of a line": (
        "F100\n#1=0\no1 while [#1 LT 1000000]\nG81 X#1 Y1 Z-1 R1 L100\n#1=[#1+0.01]\no1 endwhile\nM2\n",
        "linuxcnc",
    ),
    "pecks": ("F100\nG83 X1 Y1 Z-10 R1 Q0.001 L1000\nM2\n", "linuxcnc"),
    "lines of SINUMERIK": (
        "R1=0\nFOR R1=0 TO 1000000000\nG1 X=IC(0.001) Y=SIN(R1) F100\nENDFOR\nM30\n",
        "sinumerik",
    ),
    "lines of Heidenhain": (
        "BEGIN PGM A MM\nLBL 1\nQ1 = Q1 + 1\nL IX+0.001 F100\nFN 12: IF +Q1 LT +999999999 GOTO LBL 1\nEND PGM A MM\n",
        "heidenhain",
    ),
}


@pytest.mark.parametrize("name", COSTLY)
def test_the_bound_counts_what_blocks_cost(run: Run, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """A run of 5,000,000 units makes 600,000 canonical calls or Heidenhain lines at most, so its steps show the bound."""
    monkeypatch.setattr(budget, "MOST_MOVES", 1000)
    text, dialect = COSTLY[name]
    assert [code for code, _, _ in run(text, dialect=dialect).errors] == ["too-many-steps"]


#: Curves that loops compute, of 2000 points, and their dialects; each point takes 30 or 100 units, of lines that run by themselves too.
CURVES = {
    "heidenhain": (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1\nQ1 = 0\nCC X+0 Y+0\nLBL 1\nQ1 = Q1 + 0.1\nCALL LBL 2\nLP PR+9 PA+Q1 R0 F500\n"
        "FN 12: IF +Q1 LT +200 GOTO LBL 1\nM30\nLBL 2\nQ2 = Q1\nQ3 = Q2\nLBL 0\nEND PGM A MM\n"
    ),
    "sinumerik": (
        "DEF INT NUM\nFOR NUM=1 TO 2000\nPOINT(NUM)\nENDFOR\nM30\n%_N_POINT_SPF\nPROC POINT(INT COUNT)\nDEF REAL WAY\nWAY=COUNT/10\n"
        "G1 AP=WAY RP=9 F500\nRET\n"
    ),
}  # fmt: skip


@pytest.mark.parametrize("dialect", CURVES)
def test_a_curve_that_a_loop_computes_is_not_endless(
    run: Run, monkeypatch: pytest.MonkeyPatch, dialect: str
) -> None:
    """A loop that moves in each round may do more than one that does not: 75,000 points counted as endless."""
    monkeypatch.setattr(budget, "MOST_WORK", {"heidenhain": 40_000, "sinumerik": 150_000}[dialect])
    assert run(CURVES[dialect], dialect=dialect).errors == []
    monkeypatch.setattr(budget, "MOST_MOVES", 0)
    assert [code for code, _, _ in run(CURVES[dialect], dialect=dialect).errors] == ["too-many-steps"]


@pytest.mark.parametrize("block", ["G18 G2 K1", "G33 Z-1 K1", "M3 S500", "G21 G17 G90 G64 P0.01\nG1 X3"])
def test_the_budget_counts_what_a_block_costs(run: Any, monkeypatch: pytest.MonkeyPatch, block: str) -> None:
    """Arcs, synchronised moves and modes between motions take up to 300 times as long as a plain block, and counted as one: 30 s."""
    monkeypatch.setattr(budget, "MOST_WORK", 15_000)
    monkeypatch.setattr(budget, "WORK_OF_A_LINE", 0)
    text = "S100 M3 F100\no1 repeat [400]\n{}\no1 endrepeat\nM2"
    assert [code for code, _, _ in run(text.format(block)).errors] == ["too-many-steps"]
    assert run(text.format("G1 X1")).errors == []


def test_what_the_peer_prints_behind_the_end_needs_no_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run whose budget was spent to the last unit ended in an internal error where the reset was printed."""
    from cncgen.diagnostics import Diagnostics
    from cncgen.gcode import canon
    from cncgen.toolpath.reading import ReadOptions

    monkeypatch.setattr(budget, "MOST_WORK", 500)
    monkeypatch.setattr(budget, "WORK_OF_A_LINE", 0)
    found = Diagnostics()
    lines = list(
        canon(
            io.BytesIO(b"o1 repeat [99]\nM3 S1\no1 endrepeat\nM2\n"),
            "t.ngc",
            ReadOptions(dialect="linuxcnc"),
            found,
        )
    )
    assert [each.code for each in found] == ["too-many-steps"]
    assert lines[-1].endswith("ON_RESET()")


def test_the_print_of_a_motion_of_a_cycle_counts_as_the_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """It counted half of what the same motion counts in `check`: 100 lines of SINUMERIK's HOLES1 took 9 s."""
    from cncgen.diagnostics import Diagnostics
    from cncgen.gcode import canon
    from cncgen.toolpath.reading import ReadOptions

    monkeypatch.setattr(budget, "MOST_WORK", 8000)
    monkeypatch.setattr(budget, "WORK_OF_A_LINE", 0)
    found = Diagnostics()
    text = b"G21 F100\nG83 X1 Y1 Z-10 R1 Q0.001 L1000\nM2\n"
    lines = list(canon(io.BytesIO(text), "t.ngc", ReadOptions(dialect="linuxcnc"), found))
    assert [each.code for each in found] == ["too-many-steps"]
    assert 900 < sum("STRAIGHT" in line for line in lines) <= 8000 / budget.MOTION


def test_a_line_of_blanks_takes_no_longer_than_its_length(run: Any) -> None:
    """Two runs of blanks side by side in a pattern took 20 s for 40,000 blanks."""
    text = "BEGIN PGM A MM\nG1 X" + 40_000 * " " + "\nEND PGM A MM"
    begin = time.process_time()
    run(text, dialect="heidenhain")
    assert time.process_time() - begin < 5.0


def _places(out: Any) -> list[float]:
    """Return the places in X that a path comes to, one after another."""
    return [x for x, _ in groupby(out.path.end[:, 0].tolist()) if x]


#: Programs that repeat without end, as for bar feeders, the line of the jump, and places of their one pass in X.
REPEATING = {
    "no counter": ("N10 G0 X1\nX3\nGOTO 10\nM30", 4, [1, 3]),
    "a counter": ("G0 X5\nN10 #500=#500+1\nX#500\nGOTO 10", 5, [5, 1]),
    "by M99": ("N10 #500=#500+1\nG0 X7\nM99 P10", 4, [7]),
    "jumps within": ("N10 G0 X1\nIF [#1 EQ 5] GOTO 20\nX2\nN20 X3\nGOTO 10\nM30", 6, [1, 2, 3]),
    "a call": ("N10 M98 P2\nGOTO 10\nM30\n%\nO2\nG0 X4\nM99", 3, [4]),
    "an end that is left out": ("N10 G0 X1\n/M30\n#1=#1+1\nX2 (GOTO 99)\nGOTO 10", 6, [1, 2]),
}


@pytest.mark.parametrize("name", REPEATING)
def test_a_jump_back_that_nothing_leads_out_of_ends_the_main_program(run: Run, name: str) -> None:
    """A control repeats what stands between until its operator or bar feeder ends it; one pass is planned, as of M99."""
    text, line, places = REPEATING[name]
    out = run(f"O1\nG21 G90\n{text}", dialect="fanuc")
    assert out.errors == []
    found = [d.span.line - 1 for d in out.diagnostics if d.code == "program-repeats" and d.span]
    assert found == [line]
    assert _places(out) == places


@pytest.mark.parametrize(
    "way",
    [
        "IF [#1 GE 3] GOTO 99",
        "IF [#1 GE 3] THEN #3000=1 (FULL)",
        "M98 P2",
        "GOTO [10+89*FIX[#1/3]]",
        "IF [#1 LT 3] GOTO 10\nM30.",
    ],
)
def test_a_jump_back_that_something_leads_out_of_is_followed(run: Run, way: str) -> None:
    """Three rounds: until the jump out, the alarm, the end in the called program, the computed jump, or an end that has a point."""
    text = f"O1\nG21 G90\nN5 #1=#1+1\nG0 X#1\n{way}\nN10 Y#1\nGOTO 5\nN99 M30\nO2\nIF [#1 LT 3] GOTO 1\nM30\nN1 M99"
    out = run(text, dialect="fanuc")
    assert not [d for d in out.diagnostics if d.code == "program-repeats"]
    assert out.path.end[:, 0].max() == 3


#: Programs of SINUMERIK that a bar feeder ends, the line that leads back, and the places of one pass.
FED = {
    "GOTOS": ("G0 X1\nIF R1==0\nX2\nELSE\nX3\nENDIF\nGOTOS\nM30", 8, [1, 2]),
    "a label": ("LAB1:\nR1=R1+1\nG0 X=R1\nGOTOB LAB1\nG0 X9\nM30", 5, [1]),
    "LOOP": ("LOOP\nSUB1\nENDLOOP\nM30\nPROC SUB1\nG0 X4\nIF R1==0 GOTOF OUT1\nX5\nOUT1:\nM17", 4, [4]),
}
#: And those that an end of their own leads out of: R1 counts to 3.
LEFT = {
    "a jump": ("IF R1>=3 GOTOF OUT1\nGOTOS\nOUT1:\nM30", [1, 2, 3]),
    "a jump in a branch": ("IF R1<3\nGOTOS\nENDIF\nM30", [1, 2, 3]),
    "a jump by a case": ("CASE R1 OF 3 GOTOF OUT1\nGOTOS\nOUT1: M30", [1, 2, 3]),
    "an end in a branch": ("IF R1==3\nM30\nENDIF\nGOTOS", [1, 2, 3]),
    "an end by a variable": ("R2=8\nIF R1==3\nR2=30\nENDIF\nM=R2\nGOTOS", [1, 2, 3]),
    "a repeat": ("N90 G91 X1\nREPEATB N90 P=2\nM30", [1, 2, 3, 4]),
}


@pytest.mark.parametrize("name", FED)
def test_one_pass_of_a_program_of_sinumerik_that_repeats_itself(run: Run, name: str) -> None:
    """840D sl, Fundamentals, "GOTOS": a jump to the beginning; it ran into the bound of work, as a jump back or LOOP did."""
    text, line, places = FED[name]
    out = run(f"G71 G90\n{text}\n", dialect="sinumerik")
    assert out.errors == []
    assert [d.span.line for d in out.diagnostics if d.code == "program-repeats"] == [line]
    assert _places(out) == places


@pytest.mark.parametrize("name", LEFT)
def test_a_program_of_sinumerik_that_ends_is_run_to_its_end(run: Run, name: str) -> None:
    text, places = LEFT[name]
    out = run(f"G71 G90\nR1=R1+1\nG0 X=R1\n{text}\n", dialect="sinumerik")
    assert out.errors == []
    assert not [d for d in out.diagnostics if d.code == "program-repeats"]
    assert _places(out) == places


#: Waits for a signal that no program knows, with what moves meanwhile.
WAITS = {
    "its own line": ("N10 IF [#1005 EQ 0] GOTO 10", "GOTO", []),
    "a dwell": ("N10 G4 X0.5\nIF [#1005 EQ 0] GOTO 10", "GOTO", []),
    "a loop": ("WHILE [#1005 EQ 0] DO1\nG4 P100\nEND1", "WHILE", []),
    "an empty loop": ("WHILE [#1005 NE 1] DO1\nEND1", "WHILE", []),
    "M96 of Haas": ("N10 M96 P10 Q5", "M96", []),
    "a part": ("N10 G0 X2\nX3\nM96 P10 Q5", "M96", [2, 3]),
}


@pytest.mark.parametrize("name", WAITS)
def test_a_wait_for_a_signal_is_over_after_one_pass(run: Run, name: str) -> None:
    """Haas's manual 96-8000, "M96": ``M96 P10 Q8`` in line N05 waits for the door, ``M96 P10 Q27`` below a part repeats it."""
    text, word, places = WAITS[name]
    out = run(f"O1\nG21 G90\n{text}\nG0 X9\nM30", dialect="fanuc")
    assert out.errors == []
    assert [d.message.split()[0] for d in out.diagnostics if d.code == "wait-assumed"] == [word]
    assert _places(out) == [*places, 9]


#: Waits of SINUMERIK, with what moves meanwhile.
SIGNALS = {
    "its own line": ("AA1: IF $A_IN[1]==0 GOTOB AA1", "GOTOB", []),
    "a dwell": ("AA1:\nG4 F0.5\nSTOPRE\nIF NOT $A_IN[1] GOTO AA1", "GOTO", []),
    "an empty loop": ("WHILE $A_IN[1]==0\nENDWHILE", "WHILE", []),
    "a loop, twice": ("FOR R1=1 TO 2\nWHILE $A_IN[1]==0\nX2\nX3\nENDWHILE\nENDFOR", "WHILE", [2, 3, 2, 3]),
    "until": ("REPEAT\nX4\nUNTIL $A_INA[2]>5", "UNTIL", [4]),
}


@pytest.mark.parametrize("name", SIGNALS)
def test_a_wait_of_sinumerik_is_over_after_one_pass(run: Run, name: str) -> None:
    """It was refused as endless, since a signal that is not known counts as 0."""
    text, word, places = SIGNALS[name]
    out = run(f"G71 G90 G0\n{text}\nG0 X9\nM30", dialect="sinumerik")
    assert out.errors == []
    assert [d.message.split()[0] for d in out.diagnostics if d.code == "wait-assumed"] == [word]
    assert _places(out) == [*places, 9]


@pytest.mark.parametrize(
    "text",
    [
        "AA1:\nR1=R1+1\nG0 X=R1\nIF ($A_IN[1]==0) AND (R1<4) GOTOB AA1",
        "WHILE ($A_IN[1]==0) AND (R1<4)\nR1=R1+1\nG0 X=R1\nENDWHILE",
        "REPEAT\nR1=R1+1\nG0 X=R1\nUNTIL ($A_IN[1]==1) OR (R1==4)",
        "AA1:\nG91 G0 X1\nG90\nIF ($A_IN[1]==0) AND ($P_EP[X]<4) GOTOB AA1",
        "$A_OUT[1]=1\nAA1:\nG91 G0 X1\nG90\nIF ($A_OUT[1]==1) AND ($P_EP[X]<4) GOTOB AA1",
    ],
)
def test_a_loop_of_sinumerik_that_counts_is_no_wait(run: Run, text: str) -> None:
    out = run(f"G71 G90\n{text}\nM30", dialect="sinumerik")
    assert out.errors == []
    assert not [d for d in out.diagnostics if d.code == "wait-assumed"]
    assert _places(out) == [1, 2, 3, 4]


def test_a_signal_that_something_sets_is_no_wait(run: Run) -> None:
    text = "O1\nG21 G90\nN10 #1=#1+1\nG0 X#1\nIF [[#1005 EQ 0] AND [#1 LT 4]] GOTO 10\nM30"
    out = run(text, dialect="fanuc")
    assert not [d for d in out.diagnostics if d.code == "wait-assumed"]
    assert _places(out) == [1, 2, 3, 4]


@pytest.mark.parametrize(("value", "places"), [(0, [1, 3]), (1, [1, 2, 3])])
def test_m96_leads_to_a_line_where_its_input_is_0(run: Run, value: int, places: list[int]) -> None:
    """Haas's manual 96-8000, "M96 Jump If No Input"; a program may set the variable of the input before."""
    text = f"O1\nG21 G90\n#1008={value}\nG0 X1\nM96 P30 Q8\nX2\nN30 X3\nM30"
    assert _places(run(text, dialect="fanuc")) == places
