"""Memory of the page's record: a long plan may not take a row of doubles a setpoint."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator

import numpy as np

import cncgen
from cncgen.report.page.recording import Recording
from cncgen.report.page.streams import LONG
from cncgen.setpoints.record import Setpoints

PERIOD, CHUNK = 1e-3, 1 << 14


def chunks(count: int) -> Iterator[Setpoints]:
    """Yield setpoints along a circle that is gone at a speed which swings, with all signals of the page."""
    for k in range(count):
        t = (np.arange(CHUNK) + k * CHUNK) * PERIOD
        turn = 2.0 * t + 0.1 * np.sin(7.0 * t)
        x = 10.0 * np.column_stack([np.cos(turn), np.sin(turn)])
        v = np.gradient(x, PERIOD, axis=0)
        a = np.gradient(v, PERIOD, axis=0)
        signals = {
            "vel": v, "acc": a, "jerk": np.gradient(a, PERIOD, axis=0), "feed": np.hypot(*v.T),
            "programmed": np.full(CHUNK, 20.0), "line": np.arange(CHUNK) // 500 + k, "source": np.zeros(CHUNK, np.int64),
            "limit": np.arange(CHUNK) // 100 % 3,
        }  # fmt: skip
        yield Setpoints("XY", PERIOD, k * CHUNK, x, signals)


def test_memory_hardly_grows_with_the_plan() -> None:
    """The signals of a row are 100 bytes; a long plan keeps at most 8 of each, which are positions, lines and feed."""
    recording = Recording(cncgen.load_machine("xy-table"), "XY", PERIOD)
    soon, late = LONG // CHUNK + 1, 3 * LONG // CHUNK
    held = {}
    tracemalloc.start()
    try:
        for k, chunk in enumerate(recording.over_setpoints(chunks(late + 1))):
            if k in (soon, late):
                held[k] = tracemalloc.get_traced_memory()[0]
            del chunk
    finally:
        tracemalloc.stop()
    assert recording.rows > 2 * LONG
    assert held[late] - held[soon] < 8 * (late - soon) * CHUNK
