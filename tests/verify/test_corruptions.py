"""Setpoints made wrong in every kind, and honest ones of low resolution; `python -m trials.corruptions` judges ten thousand."""

from __future__ import annotations

import random

import numpy as np
import pytest

from trials import corruptions

LINE = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11)])


@pytest.fixture(scope="module")
def parts() -> list[corruptions.Part]:
    return corruptions.parts_of(random.Random(5), 4, shipped=False)


def test_every_kind_is_found_and_nothing_else(parts: list[corruptions.Part]) -> None:
    """Against the judge of the trial, which shares nothing with `verify`."""
    score, rng = corruptions.Score(), random.Random(6)
    corruptions.corruptions(rng, parts, range(2 * len(corruptions.KINDS)), score)
    corruptions.honest(rng, parts, 10, score)
    assert score.misses == []
    assert score.alarms == []
    assert sum(score.wrong.values()) > 1.5 * len(corruptions.KINDS)


def test_the_judge_keeps_the_order() -> None:
    """Of a line and its reverse every point of one is on the other, and the leash has to span it all (closed form: 1)."""
    assert corruptions.within(LINE, LINE, 1e-12)
    assert not corruptions.within(LINE, LINE[::-1], 0.99)
    assert corruptions.within(LINE, LINE[::-1], 1.0)
    back = np.concatenate(
        [LINE, LINE[::-1], LINE]
    )  # a way there, back and there: half of it is the least leash
    assert not corruptions.within(back, LINE, 0.49)
    assert corruptions.within(back, LINE, 0.5)


def test_misses_and_false_alarms_are_counted(
    parts: list[corruptions.Part], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A verifier that lets all pass, and one that lets nothing pass."""
    for holds in (True, False):
        monkeypatch.setattr(corruptions, "verdict", lambda *_, holds=holds: (holds, ""))
        score, rng = corruptions.Score(), random.Random(6)
        corruptions.corruptions(rng, parts, range(len(corruptions.KINDS)), score)
        corruptions.honest(rng, parts, 5, score)
        assert len(score.misses) == (sum(score.wrong.values()) if holds else 0)
        assert len(score.alarms) == (0 if holds else sum(score.honest.values()))
