"""Progress: a line on a terminal that is written over, and nothing elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest

from cncgen.cli import messages, progress
from cncgen.setpoints.record import Setpoints


@pytest.fixture(autouse=True)
def fresh_style() -> None:
    """Commands that ran in this process leave the style of their last one."""
    messages.reset()


def chunks() -> Iterator[Setpoints]:
    for first in (0, 1000, 2500):
        yield Setpoints("X", 0.001, first, np.zeros((500, 1)))


def shown(capsys: pytest.CaptureFixture[str]) -> str:
    drawn = [chunk.first for chunk in progress.with_progress(chunks(), "part.nc", 0.001)]
    assert drawn == [0, 1000, 2500]
    return capsys.readouterr().err


def test_a_line_that_is_written_over_and_taken_away(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The clock passes a second between chunks; the first comes too early to be shown."""
    clock = iter([0.0, 0.5, 1.6, 2.7])
    monkeypatch.setattr(progress, "is_terminal", lambda stream: True)
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    assert shown(capsys) == ("\rpart.nc: 1.5 s of motion\x1b[K\rpart.nc: 3.0 s of motion\x1b[K\r\x1b[K")


def test_nothing_where_nobody_looks_or_wants_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "_INTERVAL_S", -1.0)
    assert shown(capsys) == ""
    monkeypatch.setattr(progress, "is_terminal", lambda stream: True)
    monkeypatch.setattr(messages._Style, "quiet", True)
    assert shown(capsys) == ""
