"""What the parameters of a control decide is stated once, as a note, at the place that asks for it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from .conftest import Outcome

Run = Callable[..., Outcome]
BORE = "G21 G90 G17 S1000 M3\nG98 G{} X10 Y10 Z-10 R{} Q0.5 F100\nX20\nG80\nM30"
CORNER = "G17 G21 G90 F500\nG10 L12 P1 R4\nG41 D1 G1 X10\nX30\nY{}\nX0\nG40 Y0\nM30"


def said(out: Outcome, code: str) -> list[tuple[str, int, int]]:
    """Return severity, line and column of each remark of a code."""
    return [(d.severity, d.span.line, d.span.column) for d in out.diagnostics if d.code == code and d.span]


@pytest.mark.parametrize("dialect", ["fanuc", "fanuc-lathe", "linuxcnc"])
def test_m99_repeats_a_main_program(run: Run, dialect: str) -> None:
    """FANUC's controls begin again at its top (B-64484EN, "Subprogram call"), LinuxCNC too; one pass is planned."""
    assert said(run("G21\nG0 X1\nM99\nX2", dialect=dialect), "program-repeats") == [("note", 3, 1)]
    assert not said(run("G21\nM98 P2\nM30\nO2\nG0 X1\nM99", dialect=dialect), "program-repeats")


def test_the_direction_of_a_shift_is_stated_once(run: Run) -> None:
    for number, begin in ((76, 2), (87, -12)):
        assert said(run(BORE.format(number, begin), dialect="fanuc"), "cycle-shift") == [
            ("note", 2, 24 + len(str(begin)))
        ]
    assert not said(run(BORE.format(85, 2), dialect="fanuc"), "cycle-shift")


@pytest.mark.parametrize(
    ("q", "units", "beside", "doubts"),
    [
        ("100", 21, 10.1, 1),
        ("100.", 21, 110.0, 0),
        ("1", 21, 11.0, 0),
        ("100", 20, 254.254, 1),
        (".5", 21, 10.5, 0),
    ],
)
def test_a_shift_too_far_for_a_bore_counts_in_least_increments(
    run: Run, q: str, units: int, beside: float, doubts: int
) -> None:
    """Q100 of G76 is 0.1 mm on FANUC's controls (IS-B); it was 100 mm, through the wall."""
    out = run(
        f"G{units} G90 G17 S1000 M3\nG98 G76 X10. Y0. Z-1. R.2 Q{q} F100\nX20.\nG80\nM30", dialect="fanuc"
    )
    xs = sorted({round(float(x), 6) for x in out.path.end[:, 0]})
    assert beside in xs
    assert [severity for severity, *_ in said(out, "cycle-shift")].count("warning") == doubts


def test_arcs_around_outside_corners_are_stated_once(run: Run) -> None:
    """CCC (19607#2) = 0 joins the moves by straight lines; inside corners are the same for both."""
    assert said(run(CORNER.format(-20), dialect="fanuc"), "comp-corners") == [("note", 5, 1)]
    assert not said(run(CORNER.format(20), dialect="fanuc"), "comp-corners")


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("T1 D1\nT2\nG1 X1 F100", [("note", 1, 1)]),
        ('G54\nT="MILL"\nG1 X1 F100', [("note", 2, 1)]),
        ("T1 D1\nM6\nG1 X1 F100", []),
        ("G18\nT1 D1\nG1 X1 F100", []),
    ],
)
def test_t_alone_changes_the_tool_of_a_sinumerik_mill(
    run: Run, text: str, places: list[tuple[str, int, int]]
) -> None:
    """Machine data 22550 = 0, the control's own value; lathes have it so."""
    assert said(run(text, dialect="sinumerik"), "tool-at-once") == places


@pytest.mark.parametrize("block", ["M0ATAN[1]/[0]", "X#1/Y3", "X1 Y[#2]/2", "/X1 /Y2", "N5 X1 /Y2"])
def test_a_slash_that_cuts_a_block_is_told(run: Run, block: str) -> None:
    out = run(f"G21\n#1=8/2\n#2=ATAN[1]/[2] (A/B)\nG0 X1 Y[1/2]\n{block}\nM30", dialect="fanuc")
    assert said(out, "other-control") == [("warning", 5, block.rindex("/") + 1)]


@pytest.mark.parametrize(
    ("block", "code"),
    [("G71 U2. R1.", 71), ("G76 P021060 Q100 R0.05", 76), ("G73 U5. W1. R3", 73), ("G74 R1.", 74)],
)
def test_turning_cycles_of_a_mills_dialect_name_that_of_lathes(run: Run, block: str, code: int) -> None:
    out = run(f"G21 G97 S500 M3\nG0 X20. Z2.\n{block}\nM30", dialect="fanuc")
    hints = [d.hint for d in out.diagnostics if d.severity == "error"]
    assert len(hints) == 1
    assert f"G{code}" in hints[0]
    assert "--dialect fanuc-lathe" in hints[0]


def test_motions_without_a_feed_are_one_fault(run: Run) -> None:
    """A program that forgot F had an error a line; what stands behind them is read as if they were made."""
    out = run("G21\nG1 X10\nY10\nG2 X20 Y0 R10\nX25 I3\nM30")
    assert [(code, line) for code, line, _ in out.errors] == [("feed-missing", 2), ("arc-radius", 5)]
    out = run("G21 G99 T0101\nG1 X10 F.1\nZ-5\nG3 X20 Z-10 R5\nM30", dialect="fanuc-lathe")
    assert [(code, line) for code, line, _ in out.errors] == [("spindle-stopped", 2)]
