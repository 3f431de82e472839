"""Branches and loops whose condition has a fault: one fault is one error, and none follows from lines that nobody knows to run."""

from __future__ import annotations

import io

import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check
from cncgen.toolpath.reading import ReadOptions


def errors_in(text: str, dialect: str) -> list[tuple[int, str]]:
    """Return the line and code of each error."""
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect=dialect), found)
    return [(one.span.line, one.code) for one in found if one.severity == "error"]


#: A branch each that divides by zero or ends the program where it runs; the feed is given in one of them, the line behind needs it.
BRANCHES = {
    "linuxcnc": "G21 G90\n#1=5\no1 if [#1 GX 3]\n#7=[#1/0]\nF100\n#<a>=1\no1 else\nG1 X#<b>\no1 endif\nG1 X#<a>\nM2\n",
    "sinumerik": "G71 G90\nR1=5\nIF R1 >> 3\nR2=R1/0\nG1 F100\nELSE\nM30\nENDIF\nX5\nR3=R1/0\nM30\n",
}
LOOPS = {
    "while": ("linuxcnc", "#1=5\no1 while [#1 LX 9]\n#1=[#1/0]\nF100\no1 endwhile\nG1 X1\nM2\n"),
    "repeat": ("linuxcnc", "#1=5\no1 repeat [#1 LX 9]\n#1=[#1/0]\nF100\no1 endrepeat\nG1 X1\nM2\n"),
    "a macro's": ("fanuc", "#1=5\nWHILE [#1 LX 9] DO1\n#1=#1/0\nF100\nEND1\nG1 X1.\nM30\n"),
    "a macro's with a number": ("fanuc", "#1=5\nN20 WH [#1 LX 9] DO 2\n#1=#1/0\nF100\nEND2\nG1 X1.\nM30\n"),
    "SINUMERIK's WHILE": ("sinumerik", "R1=5\nWHILE R1 ==\nR1=R1/0\nF100\nENDWHILE\nG1 X1\nM30\n"),
    "SINUMERIK's FOR": ("sinumerik", "R2=0\nN20 FOR R1=1 TO\nR1=R1/R2\nF100\nENDFOR\nG1 X1\nM30\n"),
}


def test_the_branches_of_a_faulty_condition_are_passed_by_in_linuxcnc() -> None:
    """The first ran: its division was blamed, and the parameter and feed of it are known behind it all the same."""
    assert errors_in(BRANCHES["linuxcnc"], "linuxcnc") == [(3, "syntax")]


def test_the_branches_of_a_faulty_condition_are_passed_by_in_sinumerik() -> None:
    """Both ran, and ELSE and ENDIF were blamed for having no IF; line 10 is a fault of its own, which M30 in ELSE hid."""
    assert errors_in(BRANCHES["sinumerik"], "sinumerik") == [(3, "syntax"), (10, "division-by-zero")]


@pytest.mark.parametrize("kind", LOOPS)
def test_a_loop_with_a_faulty_condition_is_passed_by(kind: str) -> None:
    dialect, text = LOOPS[kind]
    assert errors_in(text, dialect) == [(2, "syntax")]


def test_faults_of_spelling_within_are_told() -> None:
    """They are faults whichever way the program goes."""
    text = "#1=5\no1 if [#1 GX 3]\n#8=[#1 +]\no1 endif\nM2\n"
    assert errors_in(text, "linuxcnc") == [(2, "syntax"), (3, "syntax")]
    text = "R1=5\nIF R1 >> 3\nR2=(R1\nENDIF\nM30\n"
    assert errors_in(text, "sinumerik") == [(2, "syntax"), (3, "syntax")]


def test_a_faulty_elseif_is_told_at_its_own_line() -> None:
    """It was told at the line of the IF that looks for it, and again where the run came to it."""
    text = "#1=5\no1 if [#1 GT 9]\nG0 X1\no1 elseif [#1 GX 3]\nG0 X2\no1 endif\nM2\n"
    assert errors_in(text, "linuxcnc") == [(4, "syntax")]


def test_a_faulty_end_of_do_does_not_pass_a_loop_by() -> None:
    text = "#1=5\no1 do\n#1=[#1+1]\no1 while [#1 LX 9]\n#2=[#1/0]\nM2\n"
    assert errors_in(text, "linuxcnc") == [(4, "syntax"), (5, "division-by-zero")]


def test_a_jump_of_sinumerik_with_a_faulty_condition_opens_no_branch() -> None:
    text = "R1=5\nIF R1 == GOTOF AB\nR2=R1/0\nAB: M30\n"
    assert errors_in(text, "sinumerik") == [(2, "syntax"), (3, "division-by-zero")]


def test_a_faulty_end_closes_its_branch() -> None:
    """It is one fault: its IF was told to have no ENDIF besides."""
    assert errors_in("R1=5\nIF R1 > 3\nG0 X1\nENDIF R1\nM30\n", "sinumerik") == [(4, "syntax")]
