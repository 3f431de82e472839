"""Setpoints of a library's user, looked at before they are worked with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from cncgen.arguments import expect, wrong
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.ranges import POSITION
from cncgen.setpoints.record import Setpoints

#: Hint to a caller who gives an array.
FROM_ARRAY = (
    'cncgen.Setpoints("XY", period_s, 0, rows) makes setpoints of an array, shape (n, axes), mm and rad'
)


def checked_setpoints(chunks: Iterable[Any]) -> Iterator[Setpoints]:
    """Yield chunks of setpoints as they are drawn, each looked at: `Setpoints` itself looks at its fields.

    Raises:
        UsageError: A chunk is not a `Setpoints`, a position is not finite, or a chunk does not go on where the one before it ends.
    """
    before: Setpoints | None = None
    for chunk in chunks:
        points: Setpoints = expect(chunk, Setpoints, "a chunk of setpoints", "cncgen.Setpoints", FROM_ARRAY)
        finite = np.isfinite(points.position).all(axis=1)
        if not finite.all():
            row = points.first + int(np.argmin(finite))
            raise wrong(f"setpoint {row}, at {row * points.period_s:.9g} s, is not finite")
        if before is not None:
            _check_order(before, points)
        before = points
        yield before


def check_range(points: Setpoints) -> None:
    """Refuse setpoints where no machine is: their differences may be beyond all numbers.

    Raises:
        UsageError: One is beyond `POSITION`.
    """
    far = np.abs(points.position) > POSITION
    if far.any():
        row, axis = np.argwhere(far)[0]
        message = (
            f"setpoint {points.first + int(row)} of axis {points.axes[axis]} is {points.position[row, axis]:.6g}, "
            f"beyond ±{POSITION:g}"
        )
        raise UsageError(Diagnostic("setpoints-range", message, hint="is the file in mm and degrees?"))


def _check_order(before: Setpoints, points: Setpoints) -> None:
    """Refuse a chunk of other axes, another period or signals than the one before it, or that leaves out rows."""
    for name, old, new in (
        ("axes", before.axes, points.axes),
        ("a period of", before.period_s, points.period_s),
        ("signals", tuple(before.signals), tuple(points.signals)),
    ):
        if old != new:
            raise wrong(f"a chunk of setpoints has {name} {new}; the one before it has {old}")
    following = before.first + len(before)
    if points.first != following:
        raise wrong(
            f"a chunk of setpoints begins with row {points.first}; it is to go on with row {following}"
        )
