"""Iterated mirror compensation: a command that a known servo turns into the wanted motion.

r₀ = y*, rₙ₊₁ = rₙ + (y* − G rₙ): the error is added to the command, and the model G may be anything that
can be simulated, friction and bounds included. With E = 1 − G the error after n passes is Eⁿ⁺¹ y*, so it falls where
|E(jω)| < 1, and it grows above the frequency where that ends: a few passes are best, not many. This is iterative learning
(S. Arimoto, S. Kawamura and F. Miyazaki, Journal of Robotic Systems 1 (1984) 123) with a model in the place of the
machine. (Chen and Hsu invert the loop instead, `cncgen.servo.inversion`.)

Passes are stages of a stream: each simulates the command of the one before, some thousand rows behind it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError, UsageError
from cncgen.machine.record import Axis, Servo
from cncgen.servo.contour import ContourTracker
from cncgen.servo.scheme import SchemeMaker
from cncgen.servo.simulate import contour_axes, own_scheme, simulate_scheme
from cncgen.setpoints.record import Setpoints
from cncgen.units import ORDER_NAMES, file_unit, to_file

Floats = NDArray[np.float64]

#: A limit counts as broken beyond this share of it.
SLACK = 1e-6
LIMIT_KEYS = tuple(f"max_{name}" for name in ORDER_NAMES)
#: Share of what a limit's ratio leaves that a plan with a reserve takes: the correction is not quite in proportion.
ROOM = 0.97


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
        limits: Mapping[str, Axis] | None = None,
        settle_s: float = 0.1,
    ) -> None:
        """Prepare.

        Args:
            setpoints: The wanted positions.
            servos: Servo data by axis.
            passes: How many times the error is added, at least 1.
            limits: Axis limits that the command must keep; None: none are checked.
            settle_s: The last position is held so long at the end, for the command to come to rest there.

        Raises:
            UsageError: `passes` is not positive.
        """
        if passes < 1:
            raise UsageError(Diagnostic("compensate-passes", f"at least one pass is needed, not {passes}"))
        self._setpoints, self._servos, self._passes = setpoints, servos, passes
        self._settle_s = settle_s
        self._limits = dict(limits or {})
        self._before, self._after = Errors(), Errors()

    def chunks(self) -> Iterator[Setpoints]:
        """Yield the command for the machine.

        Raises:
            NoPlanError: The command breaks limits that the wanted motion keeps (``compensate-limit``, one diagnostic for
                each, with ``ratio``: by how much the worst place exceeds it). Earlier chunks have been yielded by then.
            UsageError: As `cncgen.servo.simulate`.
        """

        def scheme(axes: str, period_s: float) -> Any:
            return own_scheme(self._servos, axes, period_s)

        stage = _simulated(((c, c.position) for c in _held_at_end(self._setpoints, self._settle_s)), scheme)
        stage = _watched(stage, self._before)
        for _ in range(self._passes):
            stage = _simulated(_corrected(stage), scheme)
        watch = _LimitWatch(self._limits)
        for rows in _watched(stage, self._after):
            watch.check(rows)
            # Nothing is handed on once a limit is broken; the rest is looked at to name the worst.
            if not watch.broken:
                yield Setpoints(rows.head.axes, rows.head.period_s, rows.head.first, rows.command)
        watch.refuse()

    def gained(self) -> dict[str, Any]:
        """Return errors before and after, after `chunks` is drawn to its end."""
        before, after = self._before.as_dict(), self._after.as_dict()
        was, now = before["contour_max_mm"], after["contour_max_mm"]
        ratio = was / now if was is not None and now else None
        return {"passes": self._passes, "before": before, "after": after, "contour_max_ratio": ratio}


def limits_of(source: str, *, required: bool = False) -> Mapping[str, Axis] | None:
    """Return the axis limits of a machine profile or file; None where it holds servo data alone.

    Raises:
        UsageError: It cannot be read, or has no limits and `required`.
    """
    from cncgen.machine import load_machine, load_servos

    try:
        return load_machine(source).axes
    except UsageError:
        if required:
            raise
        load_servos(source)
        return None


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


@dataclass(frozen=True, slots=True)
class Break:
    """The worst place where a command breaks a limit: value and limit in inside units, order 0 for travel."""

    letter: str
    order: int
    value: float
    limit: float
    time_s: float

    @property
    def ratio(self) -> float:
        """Return how many times the limit the value is; inf for travel."""
        return abs(self.value / self.limit) if self.order else np.inf


class _LimitWatch:
    """Finite differences of command and wanted motion, over chunk borders; gathers where the command breaks a limit."""

    def __init__(self, limits: Mapping[str, Axis]) -> None:
        self._limits = limits
        self._tail: tuple[Floats, Floats] | None = None
        self.broken: dict[tuple[str, int], Break] = {}

    def check(self, rows: _Rows) -> None:
        """Check rows."""
        if not self._limits:
            return
        command, wanted = rows.command, rows.wanted
        # Before the first row the axes stand where they start.
        tail = self._tail or (np.repeat(wanted[:1], 3, axis=0), np.repeat(wanted[:1], 3, axis=0))
        command, wanted = (np.concatenate([a, b]) for a, b in zip(tail, (command, wanted), strict=True))
        self._tail = command[-3:], wanted[-3:]
        first = rows.head.first - 3
        for i, letter in enumerate(rows.head.axes):
            if letter in self._limits:
                for found in _breaks(
                    self._limits[letter], command[:, i], wanted[:, i], rows.head.period_s, first
                ):
                    before = self.broken.get((letter, found.order))
                    if before is None or abs(found.value) > abs(before.value):
                        self.broken[letter, found.order] = found

    def refuse(self) -> None:
        """Raise what was gathered.

        Raises:
            NoPlanError: See `Compensation.chunks`.
        """
        if self.broken:
            raise NoPlanError([_diagnostic(found) for found in self.broken.values()])


def _breaks(axis: Axis, command: Floats, wanted: Floats, period_s: float, first: int) -> Iterator[Break]:
    """Yield the worst place of each limit that a stretch of one axis breaks."""
    limits = (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
    for order, limit in enumerate(limits, start=1):
        size, before = (np.abs(np.diff(part, order)) / period_s**order for part in (command, wanted))
        if len(size) and size.max() > max(limit, before.max()) * (1.0 + SLACK):
            k = int(size.argmax())
            yield Break(axis.letter, order, float(size[k]), limit, (first + k) * period_s)
    if axis.travel is not None:
        low, high = axis.travel
        beyond = np.maximum(low - command, command - high)
        k = int(beyond.argmax())
        if beyond[k] > max(0.0, float(np.maximum(low - wanted, wanted - high).max())):
            yield Break(
                axis.letter, 0, float(command[k]), low if command[k] < low else high, (first + k) * period_s
            )


def _diagnostic(found: Break) -> Diagnostic:
    name = ("travel", *ORDER_NAMES)[found.order]
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
        f" {found.time_s:.3f} s, {found.ratio:.2f} times the limit {found.limit * factor:.6g}",
        hint=f"plan with {LIMIT_KEYS[found.order - 1]} of {found.letter} at {ROOM / found.ratio:.2g} of the limit, so that"
        " there is room for the correction (cncgen compensate PROGRAM -m MACHINE does so by itself), or use fewer passes",
        values={**values, "ratio": found.ratio},
    )
