"""What a syntax error says beside its place: the mistakes that people make, and the help that each gets."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

from cncgen import gcode
from cncgen.explanations import cure_of


@pytest.mark.parametrize(
    ("block", "hint"),
    [
        ("G0 X10,5", "the decimal sign is a point"),
        ("G0 X1.2.3", "a number has one decimal point"),
        ("G1 X1O F100", "is the letter O meant as a zero?"),
        ("O0001 G0 X5", "an O-word is SUB, CALL, IF, WHILE …; a program number stands alone on its line"),
        ("G0 X=5", "a word is a letter and its number (X5); = sets parameters (#5=3)"),
        ("#depth=3", "the name of a parameter stands in < >: #<depth>; a comment stands in ( ) or behind ;"),
        ("G0 X10-5", "a sum stands in brackets: X[10-5]"),
        ("G0 X5 /G1", "/ stands first in a block (block delete), or divides within brackets"),
        ("10 G0 X5", "a block begins with a letter: is N missing before the number?"),
        ("G0 X[SIN 30]", "the argument of a function stands in brackets: SIN[30]"),
        ("G0 X[#1+3 Y1", "is a ] missing?"),
        ("G0 X[1+2", "is a ] missing?"),
        ("o1 whlie [1]", "is WHILE meant?"),
        ("#1=SINE[30]", "is SIN meant?"),
        ("o<name call", "is the > of the name missing?"),
        ("G1 X#<name", "is the > of the name missing?"),
        ("o100.5 sub", "a label is a whole number or a name: o100, o<pocket>"),
        ("o100 call #1", "values stand in brackets: o100 call [#1] [2]"),
        ("o100 call 5", "values stand in brackets: o100 call [#1] [2]"),
        ("#1=[2+]", "a value is missing before the ]"),
        ("#1=[#2 GT]", "a value is missing before the ]"),
        ("#1=[]", "a value is missing before the ]"),
        ("o1 if [#1 > 3]", "comparisons are words: EQ NE GT GE LT LE"),
        ("#1=[2^3]", "a power is **: [2**3]"),
        ("#1=[5 % 2]", "the remainder is MOD: [5 MOD 2]"),
        ("G0 X10mm", "numbers have no units: G21 says that they are mm, G20 inches"),
        ("G0 X1'000", "numbers have no separators"),
        ("G0 X−5", "this is a dash, not the minus sign -"),
        ("G0 A90°", "angles are in degrees, without a sign for it"),
        ("// move", "a comment stands in ( ) or behind ;"),
        ("$J=G91 X1", "leave it out"),
        ("#1=X5", "a parameter is set to a value, not to a word: #1=5"),
        (
            "G1 X10,C2",
            "chamfers ,C and roundings ,R are FANUC's: --dialect fanuc reads them",
        ),
        ("GO1 X5", "is the letter O meant as a zero: G0…?"),
        ("X5 MO5", "is the letter O meant as a zero: M0…?"),
        ("01000", "is the zero meant as the letter O of a program number: O1000?"),
        ("01000 (PART)", "is the zero meant as the letter O of a program number: O1000?"),
        ("G1 F", "write F with its value"),
        ("G1 F X1", "write F with its value"),
    ],
)
def test_what_was_meant(run: Any, block: str, hint: str) -> None:
    out = run(f"{block}\nM2", dialect="linuxcnc")
    (error,) = [d for d in out.diagnostics if d.severity == "error"]
    assert (error.code, error.hint) == ("syntax", hint)


def test_what_was_meant_by_macros(run: Any) -> None:
    found = [
        d for d in run("#1=#2-1 IF[#1 LT 2]THEN #1=2\nM30", dialect="fanuc").diagnostics if d.code == "syntax"
    ]
    assert [d.hint for d in found] == ["IF[…] begins a line of its own"]


@pytest.mark.parametrize(
    ("block", "hint"),
    [
        ("#1=#_ABSIO[1]", "the names of FANUC's system variables are not read, their numbers are: #5001 is"),
        ("#1=[#_UI[3]+1]", "the names of FANUC's system variables are not read, their numbers are: #5001 is"),
        (
            "#1=#[_ABSMT[1]]",
            "the names of FANUC's system variables are not read, their numbers are: #5001 is",
        ),
        ("#1=#_depth", "the name of a parameter stands in < >: #<_depth>"),
        ("#[ALPHA]=3", "names that SETVN gives to variables are not read"),
        ("#1=PRM[1260]", "PRM[ ] reads a parameter of the control, which is not known here"),
        ("#1=[PRM[1260,1]*2]", "PRM[ ] reads a parameter of the control, which is not known here"),
    ],
)
def test_what_names_of_variables_are_meant(run: Any, block: str, hint: str) -> None:
    (error,) = [d for d in run(f"{block}\nM30", dialect="fanuc").diagnostics if d.severity == "error"]
    assert (error.code, error.hint[: len(hint)]) == ("syntax", hint)


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("IF[#1 GT 0] AND [#2 GT 0] THEN #3=1", "conditions are joined outside of brackets"),
        ("IF[#1 EQ 1]OR[#1 EQ 2]GOTO5", "conditions are joined outside of brackets"),
        ("WHILE[#1 LT 3] XOR [#2 LT 3] DO1", "conditions are joined outside of brackets"),
        ("ELSE", "ELSE, ELSEIF and ENDIF do not stand alone"),
        ("N5 ENDIF (#1)", "ELSE, ELSEIF and ENDIF do not stand alone"),
        ("ELSEIF[#1 EQ 2]", "ELSE, ELSEIF and ENDIF do not stand alone"),
    ],
)
def test_branches_of_other_languages_are_named(run: Any, block: str, message: str) -> None:
    text = f"#1=1\n#2=1\n{block}\nN5 G0 X1.\nM30"
    found = [d for d in run(text, dialect="fanuc").diagnostics if d.code == "syntax"]
    assert [(d.message, d.span and d.span.line, bool(d.hint)) for d in found] == [(message, 3, True)]


def faults_without_hint() -> list[tuple[str, int, str]]:
    """Return file, line and code of the faults that the reader raises with no help of their own."""
    found = []
    for path in sorted(Path(gcode.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "BlockError":
                code = node.args[0]
                if isinstance(code, ast.Constant) and not any(k.arg == "hint" for k in node.keywords):
                    found.append((path.name, node.lineno, code.value))
    return found


def test_every_fault_has_help() -> None:
    """Its own, or the cure of its kind."""
    bare = faults_without_hint()
    assert [fault for fault in bare if not cure_of("gcode", fault[2])] == []


@pytest.mark.parametrize(
    ("block", "code", "hint"),
    [
        (
            "#1=#<_hal[x]>",
            "unknown-parameter",
            'pins and INI entries are the running machine\'s: a line "_hal[x] 1000" in the file of --parameters gives one',
        ),
        ("#1=#<_depth>", "unknown-parameter", "set it before it is used"),
        ("G70 X1", "profile-missing", "Q names the subroutine of the profile: G71 Q100 for o100"),
        ("o1 repeat", "oword-arguments", "o1 repeat [10]"),
        ("o1 while", "oword-arguments", "o1 while [#1 LT 10]"),
    ],
)
def test_faults_of_meaning_have_a_line_of_help(run: Any, block: str, code: str, hint: str) -> None:
    out = run(f"{block}\nM2", dialect="linuxcnc")
    assert [(d.code, d.hint) for d in out.diagnostics if d.severity == "error"] == [(code, hint)]


def test_a_blank_for_simulators_is_no_owner_of_a_word(run: Any) -> None:
    """G1900–G1907 describe blanks with nearly all letters: that E belongs to them helps no one."""
    out = run("G0 X10. Z5.\nX8. E5.\nM30", dialect="fanuc-lathe")
    (error,) = [d for d in out.diagnostics if d.code == "unused-word"]
    assert error.hint.endswith("E belongs to G187")
