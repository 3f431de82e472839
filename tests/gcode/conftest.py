"""What the tests of reading G-code share: a program's text to its toolpath, diagnostics and canonical calls."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostic, Diagnostics
from cncgen.gcode import canon, read
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind, Toolpath
from cncgen.toolpath.slicing import join


@dataclass
class Outcome:
    """The rows of a short program (one chunk), and what was said about it."""

    path: Toolpath
    diagnostics: list[Diagnostic]
    axes: str
    moving_axes: str

    @property
    def errors(self) -> list[tuple[str, int, int]]:
        """Return code, line and column of each error."""
        return [
            (d.code, d.span.line, d.span.column) for d in self.diagnostics if d.severity == "error" and d.span
        ]


@pytest.fixture
def run() -> Callable[..., Outcome]:
    """Read a text in mm; ``run("G0 X1", dialect="fanuc")``."""

    def read_text(text: str | bytes, **options: Any) -> Outcome:
        data = text.encode() if isinstance(text, str) else text
        program = read(
            io.BytesIO(data), "t.ngc", ReadOptions(**{"chunk_rows": 1_000_000, "units": "mm", **options})
        )
        path = join(list(program.chunks()))
        return Outcome(path, list(program.diagnostics), program.axes, program.moving_axes)

    return read_text


#: End in X Y Z, and mm a minute; 0 is a traverse.
Move = tuple[float, float, float, float]


@pytest.fixture
def moves(tmp_path: Path) -> Callable[..., list[Move]]:
    """Return the motions of a text that has no errors; tool 1 has the radius 4 and no length."""

    def moves_of(text: str, **options: Any) -> list[Move]:
        table = tmp_path / "tool.tbl"
        table.write_text("T1 P1 D8\n")
        options = {"tool_table": table, "chunk_rows": 1_000_000, **options}
        program = read(io.BytesIO(text.encode()), "t.nc", ReadOptions(**options))
        path = join(list(program.chunks()))
        assert [d.message for d in program.diagnostics if d.severity == "error"] == []
        rows = np.flatnonzero(path.kind != Kind.EVENT)
        feeds = np.where(path.feed_mode[rows] == FeedMode.RAPID, 0.0, np.nan_to_num(path.feed[rows]) * 60.0)
        ends = path.end[rows, :3].round(6) + 0.0
        return [(*end, round(feed, 6)) for end, feed in zip(ends.tolist(), feeds.tolist(), strict=True)]

    return moves_of


@pytest.fixture
def calls() -> Callable[..., list[str]]:
    """Return the canonical calls of a text without numbering, those of start and end left out."""

    def canon_text(text: str, **options: Any) -> list[str]:
        lines = canon(
            io.BytesIO(text.encode()), "t.ngc", ReadOptions(**{"units": "mm", **options}), Diagnostics()
        )
        return [line.split(" ", 1)[1].split(" ", 1)[1].strip() for line in _bare(lines)][6:-2]

    def _bare(lines: Any) -> list[str]:
        return [line.strip() for line in lines]

    return canon_text
