"""R+ and R- of Heidenhain's plain language, G43 and G44 of its DIN/ISO: lines along one axis end the tool's radius further or earlier.

(TNC 406, "Electrode radius compensation"; iTNC 530, "DIN/ISO programming", 5.3.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]
HEAD = "0 BEGIN PGM A MM\n1 TOOL DEF 1 L+0 R+5\n2 TOOL CALL 1 Z S3000 F500\n"
FRAME = "X-20 R0 FMAX\nY-20 R0 FMAX\nZ-5 R0 FMAX\nX+0 R- F200\nY+100 R+\nX+100\nZ-8\nY+0 R+\nX+20 R0\nY+10\n"


def ends(run: Run, text: str) -> list[list[float]]:
    out = run(text, dialect="heidenhain")
    assert out.errors == []
    return (np.round(out.path.end[out.path.kind != 3, :3], 9) + 0.0).tolist()


def test_lines_are_lengthened_and_shortened_until_r0(run: Run) -> None:
    """From -20 to 0 less 5, to 100 and 5 more, back to 0 and 5 more; the tool's axis is not compensated, and R0 ends it."""
    assert ends(run, f"{HEAD}{FRAME}9 END PGM A MM\n")[2:] == [
        [-20, -20, -5], [-5, -20, -5], [-5, 105, -5], [105, 105, -5], [105, 105, -8], [105, -5, -8], [20, -5, -8], [20, 10, -8],
    ]  # fmt: skip


def test_g43_and_g44_of_din_iso(run: Run) -> None:
    text = (
        "%A G71 *\nN10 G99 T1 L+0 R+5 *\nN20 T1 G17 S3000 F500 *\nN30 G00 G40 G90 X-20 *\nN40 G01 G44 X+0 F200 *\nN50 G43 Y+100 *\n"
        "N60 X+100 *\nN70 G40 Y+0 *\nN99999 %A G71 *\n"
    )
    assert ends(run, text) == [[-20, 0, 0], [-5, 0, 0], [-5, 105, 0], [105, 105, 0], [105, 0, 0]]


@pytest.mark.parametrize("line", ["L X+10 Y+10", "CC X+0 Y+0\nC X+0 Y+10 DR+", "IX+10"])
def test_what_is_no_line_along_one_axis_to_a_coordinate_is_refused(run: Run, line: str) -> None:
    out = run(f"{HEAD}X+10 R+\n{line}\n9 END PGM A MM\n", dialect="heidenhain")
    assert [code for code, *_ in out.errors] == ["paraxial"]


@pytest.mark.parametrize(("first", "then"), [("RL", "RR"), ("RR", "RL")])
def test_one_side_does_not_follow_the_other(run: Run, first: str, then: str) -> None:
    """Between RL and RR a block with R0 is needed (TNC 640, "Radius compensation"), which the control asks for as well."""
    lines = f"L X+0 Y+0 {first} F100\nL X+10\nL X+20 {{}}{then}\nL X+30\nL X+40 Y+20 R0\n9 END PGM A MM\n"
    out = run(HEAD + lines.format(""), dialect="heidenhain")
    assert [code for code, *_ in out.errors] == ["comp-refused"]
    assert run(HEAD + lines.format("R0\nL Y+9 "), dialect="heidenhain").errors == []
