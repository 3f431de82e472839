"""Whether a command keeps an axis's limits: finite differences of its setpoints, and its travel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.machine.record import Axis
from cncgen.setpoints.record import Setpoints
from cncgen.units import ORDER_NAMES, file_unit, to_file

Floats = NDArray[np.float64]

#: A limit counts as broken beyond this share of it, as `cncgen verify` has it.
SLACK = 1e-3
#: Positions are written with nine decimals; inside units.
RESOLUTION = 1e-9


@dataclass(frozen=True, slots=True)
class Break:
    """The worst place where a command breaks a limit: value and limit in inside units, order 0 for travel."""

    letter: str
    order: int
    value: float
    limit: float
    time_s: float

    @property
    def name(self) -> str:
        """Return the name of the limit."""
        return ("travel", *ORDER_NAMES)[self.order]

    @property
    def ratio(self) -> float:
        """Return how many times the limit the value is; inf for travel."""
        return abs(self.value / self.limit) if self.order else np.inf


def breaks(limits: Mapping[str, Axis], axes: str, command: Floats, period_s: float) -> list[Break]:
    """Return the worst place of each limit that a command breaks; the axes stand before its first row and after its last one.

    Args:
        limits: By axis letter.
        axes: Letters of the columns.
        command: Shape (n, axes).
        period_s: s.
    """
    found: list[Break] = []
    for i, letter in enumerate(axes):
        if letter in limits:
            found += _of_axis(limits[letter], command[:, i], period_s)
    return found


def _of_axis(axis: Axis, command: Floats, period_s: float) -> Iterator[Break]:
    limits = (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
    for order, limit in enumerate(limits, start=1):
        size = np.abs(differences(command, order)) / period_s**order
        if size.max() > limit * (1.0 + SLACK):
            k = int(size.argmax())
            yield Break(axis.letter, order, float(size[k]), limit, max(k - order, 0) * period_s)
    if axis.travel is not None:
        low, high = axis.travel
        beyond = np.maximum(low - command, command - high)
        k = int(beyond.argmax())
        if beyond[k] > RESOLUTION:
            yield Break(axis.letter, 0, float(command[k]), low if command[k] < low else high, k * period_s)


def differences(positions: Floats, order: int) -> Floats:
    """Return the differences of an axis that stands before its first position and after its last, shape (n + order,)."""
    return np.diff(
        np.concatenate([np.repeat(positions[:1], order), positions, np.repeat(positions[-1:], order)]), order
    )


def broken_values(found: Iterable[Break]) -> list[dict[str, Any]]:
    """Return axis, limit and ratio (None of travel) of broken limits as plain values."""
    return [
        {
            "axis": each.letter,
            "limit": each.name,
            "ratio": each.ratio if each.order else None,
        }
        for each in found
    ]


def hold(command: Setpoints, limits: Mapping[str, Axis]) -> None:
    """Refuse a command that breaks limits.

    Raises:
        NoPlanError: It does (``compensate-limit``); every limit is named.
    """
    found = breaks(limits, command.axes, np.asarray(command.position, float), command.period_s)
    if found:
        raise NoPlanError([broken(each) for each in found])


def broken(found: Break) -> Diagnostic:
    """Return the diagnostic of a broken limit (``compensate-limit``)."""
    name = found.name
    unit = file_unit(found.letter) + ("/s" + ("", "²", "³")[found.order - 1] if found.order else "")
    factor = to_file(found.letter)
    values = {"axis": found.letter, "limit": name, "value": found.value * factor, "t_s": found.time_s}
    if not found.order:
        message = f"reaches {found.value * factor:.6g} {unit} at {found.time_s:.3f} s, beyond {found.limit * factor:.6g}"
        return Diagnostic(
            "compensate-limit", f"axis {found.letter}: the compensated command {message}", values=values
        )
    return Diagnostic(
        "compensate-limit",
        f"axis {found.letter}: the compensated command needs {found.value * factor:.6g} {unit} of {name} at"
        f" {found.time_s:.3f} s, {found.ratio:.4g} times the limit {found.limit * factor:.6g}",
        hint="--feedrate optimal plans motions that keep every limit; --no-limits writes the command as it is",
        values={**values, "ratio": found.ratio},
    )
