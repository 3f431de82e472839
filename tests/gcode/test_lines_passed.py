"""Lines that a run leads past: their syntax is read too, since other values would lead to them."""

from __future__ import annotations

import pytest

from cncgen import read_text

#: By dialect, a program whose first jump or branch leads past the line BAD, and what that line is with a fault and without one.
PROGRAMS = {
    "fanuc": ("O1\nG0X0\nIF[#1EQ#0]GOTO9\nG1X1.F100.\nBAD\nN9G0X5.\nM30\n", "GG1X2.", "G1X2."),
    "fanuc by line": ("O1\nG21\nG91G28Z0\nGOTO9\n/BAD\nBAD\nN9G0X5.\nM30\n", "G1X[2.", "G1X[2.]"),
    "linuxcnc": ("G0X0\no1 if [#1]\nBAD\no1 else\nG0X1\no1 endif\nM2\n", "GG38.2 Z1 F9", "G1 Z1 F9"),
    "sinumerik": ("G0 X0\nIF R1>5\nBAD\nENDIF\nGOTOF AB\nBAD\nAB: G0 X5\nM30\n", "G1 X1..2 F9", "G1 X1.2 F9"),
    "heidenhain": (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1\nFN 9: IF +0 EQU +0 GOTO LBL 1\nBAD\nLBL 1\nL X+5 R0 FMAX\nEND PGM A MM\n",
        "L X+1O F100",
        "L X+10 F100",
    ),
}


def said(dialect: str, text: str) -> list[tuple[str, int | None, str]]:
    """Return severity, line and message of the faults of syntax."""
    program = read_text(text, dialect=dialect.split()[0])
    list(program.chunks())
    faults = (one for one in program.diagnostics if one.code == "syntax")
    return [(one.severity.value, one.span.line if one.span else None, one.message) for one in faults]


@pytest.mark.parametrize("dialect", PROGRAMS)
def test_a_fault_of_a_line_that_is_led_past_is_warned_of(dialect: str) -> None:
    """An error it is not: a control that reads block by block never comes to it. (`GG38.6` stood in a probe's program, in the branch
    of inches; nothing was said.)"""
    text, bad, good = PROGRAMS[dialect]
    lines = text.splitlines()
    count = sum(line == "BAD" for line in lines)
    ((severity, line, message),) = said(dialect, text.replace("BAD", bad))
    assert (severity, line) == ("warning", lines.index("BAD") + 1)
    assert "the run leads past this line" in message
    assert ("past 1 more" in message) == (count == 2)
    assert not said(dialect, text.replace("BAD", good))


def test_a_line_that_is_run_later_is_an_error_alone() -> None:
    """N8 is led past first and run behind N9."""
    text = "O1\nG21\n#1=0\nGOTO9\nN8GG1X1.F100.\nM30\nN9#1=#1+1\nGOTO8\nM30\n"
    ((severity, line, message),) = said("fanuc", text)
    assert (severity, line) == ("error", 5)
    assert "leads past" not in message


def test_a_jump_past_a_long_program_reads_a_bounded_part_of_it() -> None:
    """A restart in the middle: the lines before it are not read again line by line; the first ones are."""
    rows = "G1X1.F100.\n" * 20_000
    assert not said("fanuc", f"O1\nGOTO9\n{rows}GG1\nN9G0X5.\nM30\n")
    assert said("fanuc", f"O1\nGOTO9\nGG1\n{rows}N9G0X5.\nM30\n")
