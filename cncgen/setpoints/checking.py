"""Setpoints of a library's user, looked at before they are worked with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from cncgen.arguments import expect, wrong
from cncgen.setpoints.record import Setpoints


def checked_setpoints(chunks: Iterable[Any]) -> Iterator[Setpoints]:
    """Yield chunks of setpoints as they are drawn, each looked at: its axes, its array (made one of doubles), its numbers.

    Raises:
        UsageError: A chunk is no `Setpoints`, its `position` is not of shape (n, axes), or a number is not finite.
    """
    for chunk in chunks:
        points: Setpoints = expect(chunk, Setpoints, "a chunk of setpoints", "cncgen.Setpoints")
        if not (0.0 < points.period_s < np.inf):
            raise wrong(f"setpoints have a period of {points.period_s} s")
        try:
            position = np.ascontiguousarray(points.position, np.float64)
        except (TypeError, ValueError) as error:
            raise wrong(f"positions of setpoints are no array of numbers: {error}") from None
        if position.ndim != 2 or position.shape[1] != len(points.axes):
            raise wrong(
                f"setpoints of axes {points.axes} have an array of shape {position.shape}, not (rows, axes)"
            )
        finite = np.isfinite(position).all(axis=1)
        if not finite.all():
            row = points.first + int(np.argmin(finite))
            raise wrong(f"setpoint {row}, at {row * points.period_s:.9g} s, is not finite")
        yield points if position is points.position else replace(points, position=position)
