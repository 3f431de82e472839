"""Two-stage interpolation: a master gives a position every few periods, a second stage the setpoints between them.

Source: B. K. Jung and W. C. Choi, eqs 2 to 4, after Yellowley and Pottier (1989). Between master points X_i and X_i+1, Δt apart:

    linear   x = X_i + (X_i+1 − X_i) t/Δt                                                                    (2)
    centred  + (X_i+2 − X_i+1 − X_i + X_i−1)/(2Δt²) · (t²/2 − Δt t/2)                                        (3)
    causal   + (X_i+1 − 2X_i + X_i−1)/Δt² · (t²/2 − Δt t/2)                                                  (4)

Where master points are not evenly spaced in time, as before the end of a stream, the quotients are divided differences: half the
change of speed at a point over half of the time of both stretches beside it.

The setpoints leave the path by the chords of the master's points, which is measured here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, UsageError
from cncgen.geometry.contour_distance import ContourTracker
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

#: A distance below the last decimal of a file is none.
LEAST_SHOWN_MM = 1e-6

#: Names of the interpolators, and the equation of each.
KINDS = {"two-stage-linear": 2, "two-stage-centred": 3, "two-stage-causal": 4}


def second_stage(master: Floats, parts: int, kind: int, last: int | None = None) -> Floats:
    """Return the second stage's positions, shape ((n − 2) parts + last + 1, axes), through master points, shape (n, axes).

    Args:
        master: X_i, one every Δt. Before the first and after the last one the end points repeat.
        parts: Periods in Δt.
        kind: 2, 3 or 4: the equation of the paper.
        last: Periods from the last point but one to the last; None: `parts`.

    Raises:
        ValueError: Another kind.
    """
    if kind not in (2, 3, 4):
        raise ValueError(f"the interpolators are equations 2, 3 and 4, not {kind}")
    spans = np.full((len(master) + 1, 1), parts)
    spans[-2] = last or parts
    still = np.zeros((1, master.shape[1]))
    speed = np.concatenate([still, np.diff(master, axis=0) / spans[1:-1], still])
    change = np.diff(speed, axis=0) / (0.5 * (spans[1:] + spans[:-1]))
    bend = {2: np.zeros_like(change[1:]), 3: 0.5 * (change[1:] + change[:-1]), 4: change[:-1]}[kind]
    at, span = np.divmod(np.arange(int(spans[1:-1].sum())), parts)
    tick = span[:, None]
    rows = master[at] + speed[1:][at] * tick + bend[at] * 0.5 * tick * (tick - spans[1:-1][at])
    return np.concatenate([rows, master[-1:]])


def two_stage(
    chunks: Iterable[Setpoints], name: str, master_s: float, remarks: Diagnostics | None = None
) -> Iterator[Setpoints]:
    """Yield setpoints of which every Δt/T-th is kept as the master's, and those between are interpolated.

    The last row of the stream is a master's point too, which the last stretch reaches in less than Δt. ``vel``, ``acc`` and ``jerk``
    stay those of the plan. A chunk is yielded when the stream is two master points further.

    Args:
        chunks: Setpoints of a plan.
        name: One of `KINDS`.
        master_s: Δt, s; rounded to whole periods.
        remarks: Takes how far the setpoints leave the path of the plan, once they are drawn.

    Raises:
        UsageError: Δt is shorter than a period; or the axes move, and the stream ends within Δt: no point of the master lies between
            its ends.
    """
    kind, parts = KINDS[name], 1
    waiting: list[Setpoints] = []
    ready: list[Floats] = []
    rows, first, done = (
        np.zeros((0, 0)),
        0,
        0,
    )  # rows of the plan from the one before the first stretch to come
    left = _Leaving()
    for chunk in chunks:
        if not len(chunk):
            continue
        parts = round(master_s / chunk.period_s)
        if not parts:
            raise UsageError(_too_short(master_s, chunk.period_s))
        rows = np.concatenate([rows, chunk.position]) if len(rows) else chunk.position
        waiting.append(chunk)
        end = ((first + len(rows) - 1) // parts - 1) * parts
        if end > done:
            found = second_stage(rows[: end + parts - first + 1 : parts], parts, kind)
            ready.append(found[done - first : end - first])
            rows, first, done = rows[end - parts - first :], end - parts, end
            yield from _filled(waiting, ready, left)
    if waiting:
        last, period = len(rows) - 1, waiting[0].period_s
        if first + last <= parts > 1 and np.ptp(rows, axis=0).any():
            raise UsageError(_too_long(parts * period, last * period))
        whole = np.arange(0, last, parts)
        found = second_stage(rows[[*whole, last]], parts, kind, last - int(whole[-1])) if last else rows
        ready.append(found[done - first :])
        yield from _filled(waiting, ready, left)
    if remarks is not None:
        remarks.extend(left.remarks(parts))


def _too_short(master_s: float, period_s: float) -> Diagnostic:
    return Diagnostic(
        "option-value",
        f"the master's period of {master_s:g} s is shorter than that of the setpoints, {period_s:g} s",
        hint="the period is in seconds (--master-period 0.016)",
        values={"master_period_s": master_s, "period_s": period_s},
    )


def _too_long(master_s: float, motion_s: float) -> Diagnostic:
    return Diagnostic(
        "option-value",
        f"the master's period of {master_s:g} s is not shorter than the motion of {motion_s:g} s, so no point of the master lies "
        "between its ends",
        hint="the period is in seconds (--master-period 0.016)",
        values={"master_period_s": master_s, "motion_s": motion_s},
    )


class _Leaving:
    """How far the path of a plan lies from the path through the setpoints that stand in for its own, at most and where."""

    def __init__(self) -> None:
        self._tracker: ContourTracker | None = None
        self._rows, self._most_mm, self._at_s, self._period_s = 0, 0.0, 0.0, 0.0

    def add(self, planned: Setpoints, found: Floats) -> None:
        """Take a chunk of the plan and the rows instead of its own, shape (n, axes)."""
        linear = [k for k, letter in enumerate(planned.axes) if letter in "XYZ"]
        if linear:
            self._tracker = self._tracker or ContourTracker(len(linear))
            self._period_s = planned.period_s
            self._take(self._tracker.push(found[:, linear], planned.position[:, linear]))

    def remarks(self, parts: int) -> Iterator[Diagnostic]:
        """Yield the distance, where it is one that files show."""
        if self._tracker is None:
            return
        self._take(self._tracker.finish())
        if self._most_mm < LEAST_SHOWN_MM:
            return
        master_s = parts * self._period_s
        yield Diagnostic(
            "two-stage-distance",
            f"between the master's points, one every {1e3 * master_s:g} ms, the setpoints pass the planned path at a distance of up to "
            f"{self._most_mm:.6f} mm, at t = {self._at_s:.3f} s",
            severity=Severity.WARNING,
            hint="a shorter --master-period or a lower feed keeps them nearer; --interpolator arclength follows the path exactly",
            values={
                "distance_mm": self._most_mm,
                "t_s": self._at_s,
                "master_period_s": master_s,
            },
        )

    def _take(self, distances: Floats) -> None:
        worst = int(distances.argmax()) if len(distances) else 0
        if len(distances) and distances[worst] > self._most_mm:
            self._most_mm = float(distances[worst])
            self._at_s = (self._rows + worst) * self._period_s
        self._rows += len(distances)


def _filled(waiting: list[Setpoints], ready: list[Floats], left: _Leaving) -> Iterator[Setpoints]:
    """Yield the chunks that interpolated rows fill, and take both out of the lists."""
    rows = np.concatenate(ready)
    while waiting and len(waiting[0]) <= len(rows):
        chunk = waiting.pop(0)
        left.add(chunk, rows[: len(chunk)])
        yield replace(chunk, position=np.ascontiguousarray(rows[: len(chunk)]))
        rows = rows[len(chunk) :]
    ready[:] = [rows]
