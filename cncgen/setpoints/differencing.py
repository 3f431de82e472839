"""Velocity, acceleration, jerk and speed of setpoints that come without them, as differences of their rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.setpoints.record import Setpoints


def differenced(chunks: Iterable[Setpoints]) -> Iterator[Setpoints]:
    """Yield chunks with the signals ``vel``, ``acc``, ``jerk`` and ``feed``; those that a chunk has are kept.

    They are backward differences; before the first row the axes stand. The feed is the speed in X Y Z, else that in U V W.
    """
    before: NDArray[np.float64] | None = None
    for chunk in chunks:
        if not len(chunk):
            continue
        head = np.repeat(chunk.position[:1], 3, axis=0) if before is None else before
        joined = np.concatenate([head, chunk.position])
        before = joined[-3:]
        signals = {}
        rows = joined
        for order, name in enumerate(("vel", "acc", "jerk"), start=1):
            rows = np.diff(rows, axis=0)
            signals[name] = rows[3 - order :] / chunk.period_s**order
        linear = [k for k, letter in enumerate(chunk.axes) if letter in "XYZ"] or [
            k for k, letter in enumerate(chunk.axes) if letter in "UVW"
        ]
        signals["feed"] = np.sqrt((signals["vel"][:, linear] ** 2).sum(axis=1))
        yield replace(chunk, signals={**signals, **chunk.signals})
