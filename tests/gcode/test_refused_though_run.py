"""Words that controls run and that were refused, and a call of no times that was passed over in silence."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

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
