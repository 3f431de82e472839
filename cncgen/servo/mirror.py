"""Iterated mirror compensation, as in paper 003; `cncgen compensate` uses another method (`cncgen.servo.learning`).

r₀ = y*, rₙ₊₁ = rₙ + (y* − G rₙ): the error is added to the command, and the model G may be anything that
can be simulated, friction and bounds included. With E = 1 − G the error after n passes is Eⁿ⁺¹ y*, so it falls at frequencies with
|E(jω)| < 1, and grows above them. So a few passes are best. This is iterative learning (S. Arimoto, S. Kawamura and F. Miyazaki,
Journal of Robotic Systems 1 (1984) 123) with a model in place of the machine. (Chen and Hsu invert the loop instead,
`cncgen.servo.inversion`.)

Passes are stages of a stream: each simulates the command of the one before, some thousand rows behind it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import wrong
from cncgen.machine.record import Servo
from cncgen.servo.contour import ContourTracker
from cncgen.servo.scheme import SchemeMaker
from cncgen.servo.simulate import contour_axes, own_scheme, simulate_scheme
from cncgen.setpoints.record import Setpoints
from cncgen.units import file_unit, to_file

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Rows:
    """A stretch of the stream: the wanted positions, the command so far, and what the servo makes of that command."""

    head: Setpoints
    wanted: Floats
    command: Floats
    position: Floats


class Errors:
    """Contour and tracking error of a stream of positions against the wanted ones.

    Both are of the linear axes; on a machine of rotary axes alone the tracking error is theirs, and the others are left out.
    """

    def __init__(self) -> None:
        self._tracker: ContourTracker | None = None
        self._columns: list[int] = []
        self._unit, self._factor = "mm", 1.0
        self._sums = np.zeros(2)
        self._peaks = np.zeros(2)
        self._count = 0

    def add(self, axes: str, wanted: Floats, position: Floats) -> None:
        """Take rows in, shape (n, axes)."""
        if not self._columns:
            self._begin(axes)
        self._count += len(wanted)
        wanted, position = wanted[:, self._columns], position[:, self._columns]
        self._note(0, self._factor * np.sqrt(((wanted - position) ** 2).sum(axis=1)))
        if self._tracker is not None:
            self._note(1, self._tracker.push(wanted, position))

    def _begin(self, axes: str) -> None:
        self._columns = contour_axes(axes)
        if self._columns:
            self._tracker = ContourTracker(len(self._columns))
        else:
            self._columns = list(range(len(axes)))
            self._unit, self._factor = file_unit(axes[0]), to_file(axes[0])

    def _note(self, which: int, values: Floats) -> None:
        self._sums[which] += float(values @ values)
        self._peaks[which] = max(self._peaks[which], float(values.max(initial=0.0)))

    def as_dict(self) -> dict[str, float | None]:
        """Return rms and maximum of both errors, mm (degrees of rotary axes alone); to be called once, at the end."""
        if self._tracker is not None:
            self._note(1, self._tracker.finish())
        rms = np.sqrt(self._sums / max(self._count, 1))
        contour = self._tracker is not None
        return {
            f"tracking_rms_{self._unit}": float(rms[0]),
            f"tracking_max_{self._unit}": float(self._peaks[0]),
            "contour_rms_mm": float(rms[1]) if contour else None,
            "contour_max_mm": float(self._peaks[1]) if contour else None,
        }


class Compensation:
    """A compensated command stream: draw `chunks`, then read `gained`."""

    def __init__(
        self,
        setpoints: Iterable[Setpoints],
        servos: Mapping[str, Servo],
        *,
        passes: int = 2,
        settle_s: float = 0.1,
    ) -> None:
        """Prepare.

        Args:
            setpoints: The wanted positions.
            servos: Servo data by axis.
            passes: How many times the error is added, at least 1.
            settle_s: The last position is held so long at the end, for the command to come to rest there.

        Raises:
            UsageError: `passes` is not positive.
        """
        if passes < 1:
            raise wrong(f"passes = {passes}: at least one is needed")
        self._setpoints, self._servos, self._passes = setpoints, servos, passes
        self._settle_s = settle_s
        self._before, self._after = Errors(), Errors()

    def chunks(self) -> Iterator[Setpoints]:
        """Yield the command for the machine.

        Raises:
            UsageError: As `cncgen.servo.simulate`.
        """

        def scheme(axes: str, period_s: float) -> Any:
            return own_scheme(self._servos, axes, period_s)

        stage = _simulated(((c, c.position) for c in _held_at_end(self._setpoints, self._settle_s)), scheme)
        stage = _watched(stage, self._before)
        for _ in range(self._passes):
            stage = _simulated(_corrected(stage), scheme)
        for rows in _watched(stage, self._after):
            yield Setpoints(rows.head.axes, rows.head.period_s, rows.head.first, rows.command)

    def gained(self) -> dict[str, Any]:
        """Return errors before and after, after `chunks` is drawn to its end."""
        before, after = self._before.as_dict(), self._after.as_dict()
        was, now = before["contour_max_mm"], after["contour_max_mm"]
        ratio = was / now if was is not None and now else None
        return {"passes": self._passes, "before": before, "after": after, "contour_max_ratio": ratio}


def _held_at_end(setpoints: Iterable[Setpoints], settle_s: float) -> Iterator[Setpoints]:
    """Yield a stream, and its last row again for a while."""
    last = None
    for chunk in setpoints:
        yield chunk
        last = chunk if len(chunk) else last
    if last is not None:
        rows = np.repeat(last.position[-1:], round(settle_s / last.period_s), axis=0)
        yield Setpoints(last.axes, last.period_s, last.first + len(last), rows)


def _corrected(stage: Iterator[_Rows]) -> Iterator[tuple[Setpoints, Floats]]:
    for rows in stage:
        command = rows.command + (rows.wanted - rows.position)
        head = rows.head
        yield Setpoints(head.axes, head.period_s, head.first, command), rows.wanted


def _simulated(stage: Iterable[tuple[Setpoints, Floats]], scheme: SchemeMaker) -> Iterator[_Rows]:
    """Simulate a command stream that comes with the wanted positions, and keep the two together."""
    waiting: list[Floats] = []

    def commands() -> Iterator[Setpoints]:
        for chunk, wanted in stage:
            waiting.append(wanted)
            yield chunk

    for response in simulate_scheme(commands(), scheme):
        joined = np.concatenate(waiting)
        waiting[:] = [joined[len(response) :]]
        head = Setpoints(response.axes, response.period_s, response.first, response.command)
        yield _Rows(head, joined[: len(response)], response.command, response.position)


def _watched(stage: Iterator[_Rows], errors: Errors) -> Iterator[_Rows]:
    for rows in stage:
        errors.add(rows.head.axes, rows.wanted, rows.position)
        yield rows
