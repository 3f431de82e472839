"""Runs of SINUMERIK and Heidenhain's plain language from line to line: what one executor does for both.

Expected motions are counted by hand from the texts.
"""

from __future__ import annotations

import io
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import budget, check
from cncgen.toolpath.reading import ReadOptions
from tests.gcode.conftest import Move


@pytest.fixture
def places(moves: Callable[..., list[Move]]) -> Callable[[str, str], list[tuple[float, float]]]:
    """Return the ends in X and Y of the motions of a program without errors."""
    return lambda text, dialect: [end[:2] for end in moves(text, dialect=dialect)]


def test_a_part_is_repeated_whose_last_line_calls(places: Any) -> None:
    """Once, and twice again."""
    text = "G0 X0 Y0\nA1: G1 X=IC(1) F100\nSUB1\nREPEAT A1 P=2\nM30\nPROC SUB1\nG1 Y=IC(1)\nRET\n"
    steps = places(text, "sinumerik")
    assert steps[-6:] == [(1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3)]


def test_a_part_is_repeated_whose_last_line_ends_a_loop(places: Any) -> None:
    """The loop runs all of its rounds each time."""
    text = (
        "DEF INT II\nG0 X0 Y0\nA1: G1 X=IC(1) F100\nFOR II=1 TO 2\nG1 Y=IC(1)\nENDFOR\nREPEAT A1 P=1\nM30\n"
    )
    assert places(text, "sinumerik")[-6:] == [(1, 0), (1, 1), (1, 2), (2, 2), (2, 3), (2, 4)]


@pytest.mark.parametrize("head", ["", ";NAME\n", "\n\n"])
def test_a_main_program_may_begin_with_proc(places: Any, head: str) -> None:
    """Whatever stands before it."""
    assert places(f"{head}PROC PART\nG0 X1 Y2\nG1 X3 F100\nM30\n", "sinumerik")[-1] == (3, 2)


ENDLESS = {
    "sinumerik": ("A1:\nG1 X5 F100\nG1 X0\nIF 1==1 GOTOB A1\nG1 X9 XX\nM30\n", 4, 5),
    "heidenhain": ("LBL 1\nL X+5 F100\nL X+0\nFN 9: IF +0 EQU +0 GOTO LBL 1\nL X+9 XX\nM30\n", 4, 5),
}


@pytest.mark.parametrize("dialect", ENDLESS)
def test_a_loop_that_changes_nothing_is_endless(run: Any, dialect: str) -> None:
    """It is known by its state, long before any bound, and reading goes on behind it."""
    text, line, fault = ENDLESS[dialect]
    out = run(text, dialect=dialect)
    assert [at for _, at, _ in out.errors] == [line, fault]
    assert out.errors[0][0] == "too-many-steps"


COUNTING = {
    "R parameter": ("sinumerik", "R1=0\nA1:\nR1=R1+1\nIF R1<9000 GOTOB A1\nG0 X=R1\nM30\n"),
    "variable": (
        "sinumerik",
        "DEF INT NN\nWHILE NN<9000\nNN=NN+1\nENDWHILE\nG0 X=NN\nM30\n",
    ),
    "element": (
        "sinumerik",
        "DEF INT NN[2]\nWHILE NN[1]<9000\nNN[1]=NN[1]+1\nENDWHILE\nG0 X=NN[1]\nM30\n",
    ),
    "place": ("sinumerik", "G0 X0\nA1:\nG0 X=IC(1)\nIF $P_EP[X]<9000 GOTOB A1\nM30\n"),
    "rounds": ("sinumerik", "G0 X0\nSUB1 P9000\nM30\nPROC SUB1\nG0 X=IC(1)\nRET\n"),
    "tool": ("sinumerik", "$TC_DP3[1,1]=0\nA1:\n$TC_DP3[1,1]=$TC_DP3[1,1]+1\nIF $TC_DP3[1,1]<9000 GOTOB A1\nG0 X=$TC_DP3[1,1]\nM30\n"),
    "Q parameter": ("heidenhain", "LBL 1\nQ1 = Q1 + 1\nFN 12: IF Q1 LT 9000 GOTO LBL 1\nL X+Q1 FMAX\nM30\n"),
    "repetition": ("heidenhain", "L X+0 FMAX\nLBL 1\nL IX+1 FMAX\nCALL LBL 1 REP 8999\nM30\n"),
}  # fmt: skip


@pytest.mark.parametrize("name", COUNTING)
def test_a_loop_that_counts_is_not(places: Any, name: str) -> None:
    """Wherever its count is kept."""
    dialect, text = COUNTING[name]
    assert places(text, dialect)[-1][0] == 9000.0


LONG = {
    "FOR": ("sinumerik", "R2=0\nFOR R1=1 TO 200000\nR2=R2+R1\nENDFOR\nG0 X=R2/1000000\nM30\n"),
    "variables": ("sinumerik", "DEF INT NN\nDEF REAL SUM\nWHILE NN<200000\nNN=NN+1\nSUM=SUM+NN\nENDWHILE\nG0 X=SUM/1000000\nM30\n"),
    "GOTOB": ("sinumerik", "R1=0 R2=0\nA1:\nR1=R1+1\nR2=R2+R1\nIF R1<200000 GOTOB A1\nG0 X=R2/1000000\nM30\n"),
    "FN 12": ("heidenhain", "LBL 1\nQ1 = Q1 + 1\nQ2 = Q2 + Q1\nFN 12: IF Q1 LT 200000 GOTO LBL 1\nQ3 = Q2 / 1000000\nL X+Q3 FMAX\nM30\n"),
    "REP": ("heidenhain", "LBL 1\nQ1 = Q1 + 1\nQ2 = Q2 + Q1\nCALL LBL 1 REP 199999\nQ3 = Q2 / 1000000\nL X+Q3 FMAX\nM30\n"),
}  # fmt: skip


@pytest.mark.parametrize("name", LONG)
def test_a_loop_of_many_rounds_is_not_endless(places: Any, name: str) -> None:
    """The sum of the numbers 1 to n is n (n + 1) / 2."""
    dialect, text = LONG[name]
    assert places(text, dialect)[-1][0] == pytest.approx(200_000 * 200_001 / 2 / 1e6, abs=1e-9)


def test_what_a_call_has_run_is_not_reached_by_its_caller(run: Any) -> None:
    """The subprogram stands behind the endless loop, and the lines between are read afterwards."""
    text = (
        "CALL LBL 2\nLBL 1\nL X+5 F100\nL X+0\nFN 9: IF +0 EQU +0 GOTO LBL 1\nL X+9 XX\nM30\nLBL 2\n"
        + 9 * "Q1 = 1\n"
        + "LBL 0\n"
    )
    assert [at for _, at, _ in run(text, dialect="heidenhain").errors] == [5, 6]


def test_the_contour_of_a_cycle_names_its_line_that_is_wrong(run: Any) -> None:
    """As a profile of G-code does; the fault is at the call."""
    text = (
        "TOOL CALL 1 Z S1000 F100\nL X+0 Y+0 Z+5 FMAX\nCYCL DEF 14.0\nCYCL DEF 14.1 CONTOUR LABEL 1\n"
        "CYCL DEF 25 ~\nQ1=-1 ~\nQ3=0 ~\nQ5=0 ~\nQ7=5 ~\nQ10=-1 ~\nQ11=50 ~\nQ12=100 ~\nQ15=1\nCYCL CALL\nM30\n"
        "LBL 1\nL X+1 Y+0 RL\nL X+Q99999\nLBL 0\n"
    )
    out = run(text, dialect="heidenhain")
    assert [line for _, line, _ in out.errors] == [14]
    assert any(d.message.startswith("line 18 of the contour LBL 1: ") for d in out.diagnostics)


def test_reading_goes_on_where_no_line_was_run(run: Any) -> None:
    """Behind a loop without end, wherever the last line stands of a subprogram that was called before."""
    calls = (
        "SUB1\n"
        + "A1:\nG1 X5 F100\nG1 X0\nIF 1==1 GOTOB A1\nG1 XX\nG1 YY\nM30\nPROC SUB1\n"
        + 12 * "G0 Z0\n"
        + "RET\n"
    )
    assert [at for _, at, _ in run(calls, dialect="sinumerik").errors] == [5, 6, 7]


ELEMENTS = """DEF REAL FELD[5]
DEF INT GG[3]
DEF REAL MAT[2,3]
R1=0
AGAIN:
R1=R1+1
FELD[R1 MOD 5]=R1/4 GG[R1 MOD 3]=FELD[R1 MOD 5]
MAT[1,2]=FELD[2.5]
G1 X=FELD[R1 MOD 5] Y=GG[R1 MOD 3] Z=MAT[1,2] F500
IF R1<200 GOTOB AGAIN
M30
"""


def test_elements_of_arrays_in_a_loop(moves: Any) -> None:
    """An element is that of the rounded index, as an INT is rounded: halves upwards (840D, Advanced, 1.9, "Possible type conversions")."""
    elements, wanted = [0.0] * 5, []
    for count in range(1, 201):
        elements[count % 5] = count / 4
        wanted.append((elements[count % 5], float(int(elements[count % 5] + 0.5)), elements[3]))
    assert [end[:3] for end in moves(ELEMENTS, dialect="sinumerik")][-200:] == wanted


def test_an_element_beyond_its_array_is_named_in_its_line(run: Any) -> None:
    text = (
        "DEF REAL FELD[5]\nR1=0\nAGAIN:\nR1=R1+1\nR2=R1 FELD[R1]=1\nG1 X=R2 F500\nIF R1<6 GOTOB AGAIN\nM30\n"
    )
    said = [(d.code, d.span.line, d.message) for d in run(text, dialect="sinumerik").diagnostics]
    assert said == [("variable-index", 5, "FELD[5]: its indices are 0 to 4")]  # once a line


NESTED = """BEGIN PGM A MM
Q1 = 0
LBL 1
Q1 = Q1 + 1
CALL LBL "OUTER"
L X+Q1 F500
FN 12: IF +Q1 LT +300 GOTO LBL 1
M30
LBL "OUTER"
Q2 = 0
LBL 5
Q2 = Q2 + 1
CALL LBL 6
CALL LBL 5 REP 2
LBL 0
LBL 6
L Y+Q2 F500
LBL 0
END PGM A MM
"""


def test_calls_in_calls_and_repeats_in_them(places: Any) -> None:
    """Each round runs the inner part three times, as REP 2 is twice again; Y counts these, X the rounds."""
    found = places(NESTED, "heidenhain")
    wanted = [(k - (j < 3), min(j + 1, 3)) for k in range(1, 301) for j in range(4)]
    assert found[-len(wanted) :] == wanted


@pytest.mark.parametrize("end", ["LBL 0", "FN 9: IF +0 EQU +0 GOTO LBL 7\nLBL 0"], ids=["around it", "in it"])
def test_a_loop_with_a_call_that_changes_nothing_is_endless(run: Any, end: str) -> None:
    text = (
        "BEGIN PGM A MM\nLBL 1\nCALL LBL 6\nFN 9: IF +0 EQU +0 GOTO LBL 1\nM30\n"
        f"LBL 6\nLBL 7\nL X+5 F100\nL X+0\n{end}\nEND PGM A MM\n"
    )
    assert [code for code, _, _ in run(text, dialect="heidenhain").errors] == ["too-many-steps"]


def test_a_call_without_end_is_named(run: Any) -> None:
    """The line of the call that would be one too deep, where lines are run together too."""
    text = "BEGIN PGM A MM\nQ1 = 0\nCALL LBL 6\nM30\nLBL 6\nQ1 = Q1 + 1\nCALL LBL 6\nLBL 0\nEND PGM A MM\n"
    said = [(code, line) for code, line, _ in run(text, dialect="heidenhain", max_call_depth=200).errors]
    assert said == [("call-depth", 7)]


def test_formulas_that_go_on_behind_a_tilde_run_in_the_loop_of_the_others(
    run: Any, places: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each such line was run by itself, 75,000 points of a curve in 4 s where they count as endless; the same formula in one line took
    0.15 s. The lines behind it keep their numbers, and a comment that goes on is none of it."""
    text = (
        "BEGIN PGM A MM\nQ1 = 0\nLBL 1\nQ1 = Q1 + 1\nQ2 = SIN Q1 * ( Q1 ~\n    + 2 ~\n  * 3 )\n"
        "L X+Q2 R0 F500\nFN 12: IF +Q1 LT +3000 GOTO LBL 1\n{}END PGM A MM\n"
    )
    alone = text.replace(" ~\n    + 2 ~\n  * 3 )", " + 2 * 3 ) ; said ~\n and more")
    assert places(text.format(""), "heidenhain") == places(alone.format(""), "heidenhain")
    monkeypatch.setattr(budget, "MOST_WORK", 40_000)
    assert [line for _, line, _ in run(text.format("L Y+1 Y\n"), dialect="heidenhain").errors] == [10]


def test_faults_of_a_run_of_lines_take_time_as_their_number() -> None:
    """The place of a line is looked for from that of the line before, forwards or backwards."""

    def taken(lines: int) -> float:
        text = "BEGIN PGM A MM\n" + "L X+1\n" * lines + "END PGM A MM\n"
        begin = time.process_time()
        found = Diagnostics()
        check(io.BytesIO(text.encode()), "a.h", ReadOptions(dialect="heidenhain"), found)
        assert found.has_errors
        return time.process_time() - begin

    # As the number: 8; as its square, 64.
    assert taken(8_000) < 20.0 * max(taken(1_000), 0.02)


def test_a_folder_is_listed_once_however_many_programs_are_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each missing program listed the folder anew: 100,000 of them beside 1,500 files took minutes."""
    listed: list[object] = []
    all_of = os.listdir

    def count(folder: Any) -> list[str]:
        listed.append(folder)
        return all_of(folder)

    monkeypatch.setattr(os, "listdir", count)
    program = tmp_path / "part.mpf"
    program.write_text("".join(f"FOO{k}(1)\n" for k in range(50)) + "M30\n")
    found = Diagnostics()
    check(program, program.name, diagnostics=found, options=ReadOptions(dialect="sinumerik"))
    assert {one.code for one in found if one.severity == "error"} == {"sub-missing"}
    assert len(listed) == 1
