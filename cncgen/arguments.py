"""What the library is called with, checked at its door: a wrong argument is a `UsageError` that says what was meant."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

from cncgen.diagnostics import Diagnostic, UsageError

if TYPE_CHECKING:
    from cncgen.setpoints.record import Setpoints


def wrong(message: str, hint: str = "") -> UsageError:
    """Return the exception of a wrong argument."""
    return UsageError(Diagnostic("argument", message, hint=hint))


def expect(value: Any, kinds: type | tuple[type, ...], name: str, wanted: str) -> Any:
    """Return `value` where it is of the `kinds`.

    Raises:
        UsageError: It is not; `name` is the argument's and `wanted` says what it is to be.
    """
    if not isinstance(value, kinds):
        raise wrong(f"{name} is of type {type(value).__name__}; it is to be {wanted}")
    return value


def expect_path(value: Any, name: str, wanted: str) -> str:
    """Return a file's name, or raise `UsageError`; see `expect`."""
    return os.fsdecode(expect(value, (str, os.PathLike), name, wanted))


def expect_fields(options: Any, asked: Iterable[str]) -> None:
    """Refuse keywords that are no field of a record of options.

    Raises:
        UsageError: Naming them all, and what may be meant.
    """
    known = [field.name for field in fields(options)]
    faults = []
    for name in asked:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            faults.append(Diagnostic("argument", f"there is no option {name!r}", hint=hint))
    if faults:
        raise UsageError(faults)


def checked_setpoints(chunks: Iterable[Any]) -> Iterator[Setpoints]:
    """Yield chunks of setpoints as they are drawn, each looked at: its axes, its array (made one of doubles), its numbers.

    Raises:
        UsageError: A chunk is no `Setpoints`, its `position` is not of shape (n, axes), or a number is not finite.
    """
    import numpy as np

    from cncgen.setpoints.record import Setpoints

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
