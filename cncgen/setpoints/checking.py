"""Setpoints of a library's user, looked at before they are worked with."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import expect, expect_axes, expect_number, wrong
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.ranges import POSITION
from cncgen.setpoints.columns import AXIS_SIGNALS, PATH_SIGNALS
from cncgen.setpoints.record import Setpoints

#: Hint to a caller who gives an array.
FROM_ARRAY = (
    'cncgen.Setpoints("XY", period_s, 0, rows) makes setpoints of an array, shape (n, axes), mm and rad'
)


def checked_setpoints(chunks: Iterable[Any]) -> Iterator[Setpoints]:
    """Yield chunks of setpoints as they are drawn, each looked at: its axes, its arrays, its numbers.

    Raises:
        UsageError: A chunk is not a `Setpoints`, a field of it is wrong (`position` is to be of shape (n, axes)), a position
            is not finite, or a chunk does not go on where the one before it ends.
    """
    before: Setpoints | None = None
    for chunk in chunks:
        points: Setpoints = expect(chunk, Setpoints, "a chunk of setpoints", "cncgen.Setpoints", FROM_ARRAY)
        expect_axes(points.axes, "axes of setpoints")
        expect_number(points.period_s, "period_s of setpoints", open_low=True)
        expect(points.first, numbers.Integral, "first of setpoints", "the index of the first row")
        position = _doubles(points.position, "positions of setpoints")
        if position.ndim != 2 or position.shape[1] != len(points.axes):
            raise wrong(
                f"setpoints of axes {points.axes} have an array of shape {position.shape}, not (rows, axes)"
            )
        finite = np.isfinite(position).all(axis=1)
        if not finite.all():
            row = points.first + int(np.argmin(finite))
            raise wrong(f"setpoint {row}, at {row * points.period_s:.9g} s, is not finite")
        if before is not None:
            _check_order(before, points)
        before = replace(points, position=position, signals=_signals(points.signals, position.shape))
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


def _doubles(values: Any, name: str) -> NDArray[np.float64]:
    """Return an array of doubles in C order, the same where it is one."""
    try:
        if np.iscomplexobj(values):
            raise wrong(f"{name} are complex numbers; they must be real (numpy.real gives the real part)")
        if np.ma.is_masked(values):
            raise wrong(f"{name} are masked: every setpoint needs a position")
        return np.ascontiguousarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise wrong(f"{name} are not an array of numbers: {error}") from None


def _signals(signals: Any, shape: tuple[int, ...]) -> dict[str, NDArray]:
    """Return signals as arrays; refuse those of another name or shape than writers know, for positions of a `shape`."""
    found = {}
    for name, values in expect(
        signals, Mapping, "signals of setpoints", "a mapping of names to arrays"
    ).items():
        if name not in AXIS_SIGNALS and name not in PATH_SIGNALS:
            raise wrong(f"signals {name}: not one of {', '.join((*AXIS_SIGNALS, *PATH_SIGNALS))}")
        array, wanted = np.asarray(values), shape if name in AXIS_SIGNALS else shape[:1]
        if array.shape != wanted or array.dtype.kind not in "iuf":
            raise wrong(
                f"the signal {name} is to be an array of numbers of shape {wanted}; it has {array.shape}"
            )
        found[name] = array
    return found


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
