"""G12 and G13 of Haas's mills: circles about the tool's place, less the tool's radius; and what is wrong with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import Kind


def outcome(run: Any, tmp_path: Path, text: str) -> Any:
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 D4\nT2 P2 D40\n")
    return run(
        f"O1\nG17 G40 G90 G0 X10 Y5 Z1\n{text}\nM30", dialect="fanuc", tool_table=table, inch_tables=False
    )


@pytest.mark.parametrize(("code", "turn"), [("G12", -1), ("G13", 1)])
def test_circles_from_i_to_k(run: Any, tmp_path: Path, code: str, turn: int) -> None:
    """Circles of 5, 8 and 10 less the tool's radius of 2 about (10, 5): 13, 16 and 18 in X; then back to the middle."""
    out = outcome(run, tmp_path, f"{code} I5 K10 Q3 Z-2 D1 F100\nG0 Z5")
    assert out.errors == []
    rows = out.path.kind != Kind.EVENT
    ends, kinds = out.path.end[rows][:, :3].round(9), out.path.kind[rows]
    expected = [
        (10, 5, 1),
        (10, 5, -2),
        (13, 5, -2),
        (13, 5, -2),
        (16, 5, -2),
        (16, 5, -2),
        (18, 5, -2),
        (18, 5, -2),
        (10, 5, -2),
        (10, 5, 5),
    ]
    assert [tuple(p) for p in ends.tolist()] == expected
    assert np.count_nonzero(kinds == Kind.ARC) == 3


def test_depths_in_steps(run: Any, tmp_path: Path) -> None:
    out = outcome(run, tmp_path, "G91 G13 I5 Z-0.5 L3 D0 F100\nG90 G0 Z5")
    assert out.errors == []
    depths = out.path.end[out.path.kind == Kind.ARC, 2]
    assert depths.round(9).tolist() == [0.5, 0.0, -0.5]


@pytest.mark.parametrize(
    ("block", "error"),
    [
        ("G13 K5 Z-1 D1 F100", ("cycle-words", 3, 1)),
        ("G13 I5 K9 Z-1 D1 F100", ("cycle-words", 3, 8)),
        ("G13 I5 Z-1 F100", ("comp-diameter", 3, 1)),
        ("G13 I5 Z-1 D2 F100", ("cycle-tool", 3, 1)),
        ("G13 I5 Z-1 D1 L2 F100", ("cycle-repeats", 3, 15)),
        ("G13 I5 Z-1 D1", ("feed-missing", 3, 1)),
        ("G18 G13 I5 Z-1 D1 F100", ("cycle-plane", 3, 5)),
    ],
)
def test_what_is_wrong_is_named_where_it_stands(
    run: Any, tmp_path: Path, block: str, error: tuple[str, int, int]
) -> None:
    out = outcome(run, tmp_path, block)
    assert out.errors[0] == error
    assert next(d for d in out.diagnostics if d.severity == "error").hint
