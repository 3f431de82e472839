"""Words that controls run and that were refused, and a call of no times that was passed over in silence."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cncgen.toolpath.record import Kind

Run = Callable[..., Any]


@pytest.mark.parametrize("code", ["M3 P100", "M4 P50", "M3 P100 S255"])
def test_power_of_a_spindle_in_percent(run: Run, code: str) -> None:
    """Snapmaker's programs begin so; LinuxCNC's own interpreter refuses the word."""
    out = run(f"G21 G90\n{code}\nG1 X5 F100\nM5\nM2\n", dialect="auto")
    assert out.errors == []
    assert "spindle-power" in [d.code for d in out.diagnostics]
    assert [d[0] for d in run(f"{code}\nM2\n", dialect="linuxcnc").errors] == ["unused-word"]


def test_a_p_of_another_code_is_no_power(run: Run) -> None:
    out = run("G4 P0.5 M3\nM2\n", dialect="linuxcnc")
    assert out.errors == []
    assert "spindle-power" not in [d.code for d in out.diagnostics]


@pytest.mark.parametrize("call", ["M98 P2 L0", "G65 P2 L0"])
def test_a_call_of_no_times_is_told(run: Run, call: str) -> None:
    out = run(f"O1\n{call}\n{call}\nM30\nO2\nG0 X5\nM99\n", dialect="fanuc")
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["call-idle"]
    assert (out.path.kind < 3).sum() == 0


def test_a_line_of_one_axis_in_poly(run: Run) -> None:
    """PO[Y]=(5): the polynomial of degree 1 from 0 to 5, as PO[X]=(4,0) is from 0 to 4."""
    out = run("F100\nPOLY PO[X]=(4,0) PO[Y]=(5)\nM30", dialect="sinumerik")
    assert out.errors == []
    assert out.path.end[out.path.kind < 3, :2].round(9).tolist() == [[4, 5]]


def test_axes_of_splines(run: Run) -> None:
    """SPLINEPATH with X, Y and Z is what holds without it."""
    body = "F100\n{}BSPLINE X1 Y1\nX2 Y2\nX3 Y0\nM30"
    given, usual = (run(body.format(line), dialect="sinumerik") for line in ("SPLINEPATH(1,X,Y,Z)\n", ""))
    assert given.errors == []
    assert given.path.end.tolist() == usual.path.end.tolist()
    assert [d[0] for d in run(body.format("SPLINEPATH(1,X,Y)\n"), dialect="sinumerik").errors] == ["not-read"]


def test_speed_of_the_edge_of_a_tool(run: Run, tmp_path: Path) -> None:
    """VC in m a minute: 1000 VC / (pi D) turns a minute, with the diameter of the tool that is called."""
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 D8\nT5 P5 D20\n")
    text = "0 BEGIN PGM A MM\nTOOL CALL 1 Z S1\nTOOL CALL 5 Z S( VC = 120 )\nL X+5 FU0.1 M3\nEND PGM A MM\n"
    out = run(text, dialect="heidenhain", tool_table=table)
    assert out.errors == []
    feed = out.path.feed[out.path.kind < 3][-1] * 60.0
    assert feed == pytest.approx(0.1 * 1000.0 * 120.0 / (math.pi * 20.0), rel=1e-12)
    assert [d[0] for d in run(text, dialect="heidenhain").errors] == ["speed-missing"]


@pytest.mark.parametrize("words", ["P0 (I-) X10. Y20.", "P0 (I-) X10. Y20. (engraves)"])
def test_engraving_of_haas(run: Run, words: str) -> None:
    """G47 P0 (96-8000): I 12 high is a line up from the corner; I90. turns the text about it, Z is the depth, R the height between strokes,
    E the feed downwards, F that of the letters."""
    text = f"%\nO1\nG21 G90 G17\nG43 H1 Z5.\nG47 {words} I90. J12. R2. Z-0.5 F300. E60.\nM30\n%\n"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    assert "engraving-letters" in [d.code for d in out.diagnostics]
    # Strokes of our own letters: I is 12 mm up; - is 3 of the 6 units of its height above the line, 3 units wide, behind a gap of 2 units.
    moves = [
        (end, 0.0 if math.isnan(feed) else round(feed * 60.0, 6))
        for end, feed, kind in zip(
            out.path.end[:, :3].round(9).tolist(), out.path.feed.tolist(), out.path.kind.tolist(), strict=True
        )
        if kind < 3
    ]
    assert moves[-9:] == [
        ([10, 20, 5], 0), ([10, 20, 2], 0), ([10, 20, -0.5], 60), ([-2, 20, -0.5], 300), ([-2, 20, 2], 0), ([4, 24, 2], 0),
        ([4, 24, -0.5], 60), ([4, 30, -0.5], 300), ([4, 30, 2], 0),
    ]  # fmt: skip


def test_a_character_of_haas(run: Run) -> None:
    """G47 P45 is the hyphen, 45 in ASCII."""
    body = "G21 G90 G17\nG43 H1 Z5.\nG47 {} X0. Y0. J6. R2. Z-1. F300.\nM30\n"
    by_number, by_text = (run(body.format(one), dialect="fanuc") for one in ("P45", "P0 (-)"))
    assert by_number.errors == []
    assert by_number.path.end.tolist() == by_text.path.end.tolist()


def test_pins_of_the_machine_in_the_parameter_file(run: Run, tmp_path: Path) -> None:
    """F#<_hal[plasmac.cut-feed-rate]>, as posts for QtPlasmaC write it: a line of --parameters gives what the running machine knows."""
    path = tmp_path / "p.var"
    path.write_text("5220 1\n_hal[plasmac.cut-feed-rate] 3000\n_INI[TOOL]Z 7\n")
    text = "G21 G90\nF#<_hal[plasmac.cut-feed-rate]>\nG1 X5 Z#<_ini[tool]z>\nM2\n"
    out = run(text, dialect="linuxcnc", parameters=path)
    assert out.errors == []
    assert out.path.feed[out.path.kind < 3][-1] * 60.0 == pytest.approx(3000.0)
    assert out.path.end[out.path.kind < 3][-1, :3].tolist() == [5, 0, 7]
    assert next(d[0] for d in run(text, dialect="linuxcnc").errors) == "unknown-parameter"


@pytest.mark.parametrize("word", [",R0", ",R1"])
def test_synchronous_tapping_of_mazak(run: Run, word: str) -> None:
    """,R1 and ,R0 of G84 and G74 say on Mazak's and Mitsubishi's controls whether the spindle follows the feed (M700V, G84): no corner is
    rounded there, and a whole number beside lengths with a point is none that lacks it."""
    body = "%\nO1\nG21 G90 G17 G0 X1.5 Y2.5\nS500 M3\nG84 X1. Y1. Z-5. R1. F500{}\nX2.\nG80\nM30\n%\n"
    own, bare = (run(body.format(one), dialect="fanuc") for one in (word, ""))
    assert own.errors == []
    assert own.path.end.tolist() == bare.path.end.tolist()
    assert [d.code for d in own.diagnostics] == [d.code for d in bare.diagnostics]


def test_the_origin_of_mazatrol_is_told(run: Run) -> None:
    """G53.5 heads programs for Mazak's Integrex; G52.5 ends it."""
    out = run("%\nO1\nG21 G90\nG54\nG53.5\nG0 X1. Y1.\nG52.5\nM30\n%\n", dialect="fanuc")
    assert out.errors == []
    assert "builders-point" in [d.code for d in out.diagnostics if d.severity == "warning"]


def test_a_comment_within_a_word(run: Run) -> None:
    """LinuxCNC's interpreter refuses it too; the comment is closed, and was said to be open."""
    for line in ("#1=[1+(c)2]", "G1 X(c)5 F100", "#2(c)=3"):
        [(code, *_)] = run(f"{line}\nM2\n", dialect="linuxcnc").errors[:1]
        assert code == "syntax"


def test_names_of_variables_for_the_screen(run: Run) -> None:
    """SETVN (custom macro B) gives variables names that the screen shows, and prints nothing."""
    out = run("%\nO1\nG21 G90\nSETVN#500[SIZE,DEPTH]\n#500=3.\nG0 X#500\nM30\n%\n", dialect="fanuc")
    assert out.errors == []
    assert out.path.end[out.path.kind < 3][-1, 0] == 3
    assert not any(event.values.get("print") for event in out.path.events)


@pytest.mark.parametrize(("dialect", "last"), [("fanuc-lathe", "spindle"), ("linuxcnc", "motion")])
def test_the_spindle_of_fanuc_stops_behind_the_motion_of_its_block(run: Run, dialect: str, last: str) -> None:
    """A feed per revolution beside M5 has a spindle that turns; in LinuxCNC's order of execution M5 comes first."""
    feed = "G99 G97" if dialect == "fanuc-lathe" else "G94 F100"
    out = run(f"G21 G18 {feed} S500 M3\nG0 X50. Z2.\nG1 X52. F.2 M5\nM30", dialect=dialect)
    assert out.errors == []
    rows = [
        out.path.events[int(at)].name if kind == Kind.EVENT else "motion"
        for kind, at in zip(out.path.kind, out.path.curve, strict=True)
    ]
    assert [row for row in rows if row in ("spindle", "motion")][-1] == last


def test_spindles_in_step_of_haas(run: Run) -> None:
    """G199 and G198, between which a second spindle takes the part over: they move no slide, and one spindle is planned for."""
    text = "%\nO1\nG18 G21 G99 G97\nS500 M3\nG0 X10. Z5.\nG199 R90.\nG1 Z1. F.2\nG198\nX20.\nM30\n%\n"
    out = run(text, dialect="fanuc-lathe")
    assert out.errors == []
    assert [(d.severity, d.code) for d in out.diagnostics if d.code == "spindle-number"] == [
        ("note", "spindle-number")
    ]
    assert out.path.end[out.path.kind != 3][:, [0, 2]].tolist() == [[5, 5], [5, 1], [10, 1]]


def test_a_bar_feeder_of_haas(run: Run) -> None:
    """G105 J K R P: motions of the control's own program, which move no axis of the plan; a warning tells of them."""
    out = run("%\nO1\nG18 G21 G99\nG0 X10. Z5.\nG105 J38. K2.5\nX20.\nM30\n%\n", dialect="fanuc-lathe")
    assert out.errors == []
    assert "builders-code" in [d.code for d in out.diagnostics if d.severity == "warning"]
    assert out.path.end[out.path.kind < 3].shape[0] == 2


@pytest.mark.parametrize(
    ("dialect", "deleted"),
    [
        ("fanuc", '/ N65 M200 "CHECK THE TOOL\\nPRESS START"'),
        ("fanuc", "N65 / G1 X5. $"),
        ("fanuc", "/2 G1 X5. FOO"),
        ("linuxcnc", "/ G1 X5 ?A"),
        ("sinumerik", '/N20 FOO("A" B'),
        ("sinumerik", "/1 X=(1+"),
    ],
)
def test_what_a_deleted_block_holds_is_no_fault(run: Run, dialect: str, deleted: str) -> None:
    """FANUC B-64484EN, 13.2: with the switch of /n on, the information in the block is ignored; without, the text is a fault."""
    text = (
        f"G21\nG0 X1.\n{deleted}\nG0 X3.\nM30" if dialect != "sinumerik" else f"G0 X1\n{deleted}\nG0 X3\nM30"
    )
    out = run(text, dialect=dialect)
    assert out.errors == []
    assert out.path.end[out.path.kind != 3, 0].tolist() == [1, 3]
    assert [code for code, *_ in run(text, dialect=dialect, block_delete=False).errors] == ["syntax"]


def test_of_a_letter_that_stands_twice_the_last_counts_on_fanuc(run: Run) -> None:
    """Parameter 3403#6 of FANUC; LinuxCNC refuses the block. Blocks of plain numbers and of parameters go different ways."""
    text = "G21\nG1 X1 X2. F100 F200\n#1=3\nG1 X#1 F1 F300\nM30\n"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    assert out.path.end[:2, 0].tolist() == [2.0, 3.0]
    assert (60.0 * out.path.feed[:2]).round(9).tolist() == [200.0, 300.0]
    told = [(d.span.line, d.span.column) for d in out.diagnostics if d.code == "repeated-word"]
    assert told == [(2, 4), (2, 11), (4, 8)]
    assert [error[0] for error in run(text, dialect="linuxcnc").errors] == ["repeated-word"] * 2


@pytest.mark.parametrize(("code", "wrong"), [("G54.2 P0", "G54.2 P1"), ("G54.4 P0", "G54.4 P1")])
def test_ends_of_offsets_that_are_never_on(run: Run, code: str, wrong: str) -> None:
    assert run(f"{code}\nG0 X1.\nM30\n", dialect="fanuc").errors == []
    assert run(f"{wrong}\nM30\n", dialect="fanuc").errors == [("unknown-code", 1, 1)]
