"""Verifying: setpoints, ours or anyone's, judged against the programmed path and the machine's limits.

Nothing here is shared with the planner beyond reading the program: the path is flattened by other means (`flatten`),
speeds are finite differences of the setpoints (`limits`), and both are matched as two polylines (`matching`). Program and setpoints
are read side by side, so memory grows with neither.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import wrong
from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, UsageError
from cncgen.machine.record import Machine
from cncgen.setpoints.checking import check_range
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.stream import SetpointStream
from cncgen.toolpath.record import Toolpath
from cncgen.units import file_unit, is_rotary, to_file
from cncgen.verify.flatten import FlatPath, flatten
from cncgen.verify.limits import RESOLUTION, AxisJudge
from cncgen.verify.matching import Fault, Matching, Worst
from cncgen.verify.verdict import Peak, Verdict, breach, on_line
from cncgen.verify.window import MatchWindow

__all__ = ["Peak", "Verdict", "verify"]

Floats = NDArray[np.float64]

#: Segments of the path are cut to this many of the longest chords that the machine's speed allows.
_CHORDS = 4.0
#: Setpoints of another period than the machine's may be those of a slower master; so many times as far apart are in another unit.
OTHER_PERIOD = 50.0


def verify(
    setpoints: SetpointStream,
    toolpaths: Iterable[Toolpath],
    machine: Machine,
    *,
    tolerance_mm: float | None = None,
    named: str | None = None,
    resolution: float = RESOLUTION,
) -> Verdict:
    """Judge setpoints against a program and a machine.

    Args:
        setpoints: What is judged; drawn chunk by chunk.
        toolpaths: The program as a stream, read as far as the setpoints need it, and to its end.
        machine: Limits, travel, tolerances.
        tolerance_mm: Tolerance of every continuous motion, over what the program says.
        named: Axes that the program names; None: all of its toolpath's. Where another one stands is not known: it has
            to stand still.
        resolution: Rounding of the positions, mm and degrees: differences and distances may exceed their limits by the effect of this
            rounding.

    Returns:
        Peaks of each axis and both distances, with a diagnostic for each limit that is broken.

    Raises:
        UsageError: There is no toolpath, or the setpoints have none of its axes, or are where no machine is.
    """
    path = _Observed(flatten(toolpaths, machine, tolerance_mm))
    axes = setpoints.axes
    shared = [letter for letter in path.axes if letter in axes and letter in (named or path.axes)]
    if not shared:
        raise UsageError(
            Diagnostic(
                "verify-axes", f"the setpoints have axes {axes}, the program {path.axes}: none is common"
            )
        )
    columns = [path.axes.index(letter) for letter in shared]
    # All axes are mm here: a degree counts as the machine says.
    scale = np.array([machine.degree_mm if is_rotary(letter) else 1.0 for letter in shared])
    longest = max(_CHORDS * setpoints.period_s * _speed(shared, machine), machine.chord_tolerance_mm)
    rounding = 0.5 * resolution * float(np.sqrt(len(shared)))
    window = MatchWindow((piece.restricted(columns, scale) for piece in path), longest, rounding)
    matching = Matching(window, setpoints.period_s, rounding)
    judges = {
        k: AxisJudge(machine.axes[k], setpoints.period_s, resolution) for k in axes if k in machine.axes
    }
    count, travelled = _draw(setpoints, matching, [axes.index(letter) for letter in shared], scale, judges)
    breaches = Diagnostics(_of_period(setpoints.period_s, machine))
    _judge_axes(path, axes, shared, travelled, machine, resolution, breaches)
    peaks: list[Peak] = []
    for judge in judges.values():
        found, over = judge.finish()
        peaks += found
        breaches.extend(over)
    _judge_distance(matching.out, setpoints.period_s, breaches)
    _judge_coverage(matching.back, shared, scale, setpoints.period_s, breaches)
    _judge_order(matching, setpoints.period_s, breaches)
    _judge_waits(matching, setpoints.period_s, breaches)
    return Verdict(
        count, setpoints.period_s, tuple(peaks), matching.out.largest, matching.back.largest, breaches
    )


class _Observed:
    """Pieces of the path on their way, with the range of each axis that they have shown."""

    def __init__(self, pieces: Iterator[FlatPath]) -> None:
        first = next(pieces, None)
        if first is None:
            raise wrong("toolpaths are empty, so the setpoints have no path to follow")
        self.axes = first.axes
        self.low = self.high = first.points[0]
        self._first, self._rest = first, pieces

    def __iter__(self) -> Iterator[FlatPath]:
        yield self._seen(self._first)
        for piece in self._rest:
            yield self._seen(piece)

    def _seen(self, piece: FlatPath) -> FlatPath:
        self.low = np.minimum(self.low, piece.points.min(axis=0))
        self.high = np.maximum(self.high, piece.points.max(axis=0))
        return piece


def _of_period(period_s: float, machine: Machine) -> Iterator[Diagnostic]:
    """Yield a warning of setpoints that come by far at other times than the machine takes them: all limits hold in slow motion."""
    ratio = period_s / machine.period_s
    if max(ratio, 1.0 / ratio) > OTHER_PERIOD:
        message = f"the setpoints are {period_s:g} s apart, {ratio:.4g} times the machine's period of {machine.period_s:g} s"
        found = breach("period", message, period_s=period_s, machine_period_s=machine.period_s)
        yield replace(found, severity=Severity.WARNING, hint="are the times in seconds?")


def _speed(letters: Iterable[str], machine: Machine) -> float:
    """Return the largest speed of axes together, mm/s and degrees/s."""
    limits = [to_file(k) * machine.axes[k].max_velocity for k in letters if k in machine.axes]
    return float(np.linalg.norm(limits))


def _draw(
    setpoints: SetpointStream,
    matching: Matching,
    columns: list[int],
    scale: Floats,
    judges: dict[str, AxisJudge],
) -> tuple[int, Floats]:
    """Draw the setpoints through matching, some columns of them scaled, and judges; return how many there are, and how far each axis travels.

    Positions wait for the judges until their place on the path, and so their line, is known.
    """
    axes = setpoints.axes
    waiting = np.zeros((0, len(axes)))
    low, high = np.full(len(axes), np.inf), np.full(len(axes), -np.inf)
    count = 0

    def judge(lines: NDArray[np.int64]) -> None:
        for letter, each in judges.items():
            each.feed(waiting[: len(lines), axes.index(letter)], lines)

    for chunk in setpoints:
        check_range(chunk)
        position = file_units(chunk.position, axes)
        if not len(position):
            continue
        count += len(position)
        low, high = np.minimum(low, position.min(axis=0)), np.maximum(high, position.max(axis=0))
        waiting = np.concatenate([waiting, position])
        lines = matching.feed(np.ascontiguousarray(position[:, columns] * scale))
        judge(lines)
        waiting = waiting[len(lines) :]
    judge(matching.finish())
    return count, high - low if count else np.zeros(len(axes))


def _judge_axes(
    path: _Observed,
    axes: str,
    shared: list[str],
    travelled: Floats,
    machine: Machine,
    resolution: float,
    breaches: Diagnostics,
) -> None:
    """Name the axes that move in the program alone, in the setpoints alone, or on no machine."""
    # A rational curve rounds the axes on which all its points are the same.
    rounding = 8.0 * np.spacing(np.maximum(np.abs(path.low), np.abs(path.high)))
    for letter, span, least in zip(path.axes, path.high - path.low, rounding, strict=True):
        if letter not in axes and span > max(least, resolution):
            message = f"axis {letter} moves in the program, and the setpoints have none"
            breaches.add(breach("axis", message, axis=letter))
    for letter, span in zip(axes, travelled.tolist(), strict=True):
        if letter not in shared and span > machine.chord_tolerance_mm:
            message = (
                f"axis {letter} moves by {span:.6f} {file_unit(letter)}, and the program does not name it"
            )
            breaches.add(breach("axis", message, axis=letter, value=span))
        if letter not in machine.axes and span > resolution:
            message = f"axis {letter} moves, and machine {machine.name} has none"
            breaches.add(breach("axis", message, axis=letter))


def _judge_distance(out: Worst, period_s: float, breaches: Diagnostics) -> None:
    if not out.broken:
        return
    t_s, first_s = out.time * period_s, out.first * period_s
    so = f"; so are {out.over} samples in all, the first at t = {first_s:.4f} s" if out.over > 1 else ""
    breaches.add(
        breach(
            "distance",
            f"the setpoints are {out.value:.6f} mm from the programmed path at t = {t_s:.4f} s "
            f"{on_line(out.line)}, over the tolerance of {out.tolerance:g} mm{so}",
            value=out.value,
            limit=out.tolerance,
            t_s=t_s,
            first_t_s=first_s,
            line=out.line,
            samples=out.over,
        )
    )


def _judge_coverage(
    back: Worst, axes: list[str], scale: Floats, period_s: float, breaches: Diagnostics
) -> None:
    if not back.broken:
        return
    where = ", ".join(f"{axis}{value:.4f}" for axis, value in zip(axes, back.place / scale, strict=True))
    t_s = back.time * period_s
    breaches.add(
        breach(
            "coverage",
            f"the setpoints pass {back.value:.6f} mm from the programmed path near {where} {on_line(back.line)}, "
            f"over the tolerance of {back.tolerance:g} mm; in their order they are nearest at t = {t_s:.4f} s",
            value=back.value,
            limit=back.tolerance,
            t_s=t_s,
            line=back.line,
        )
    )


def _judge_order(matching: Matching, period_s: float, breaches: Diagnostics) -> None:
    """Report the worst fault that no distance shows: every place is near the other path, but not in the program's order."""
    told = matching.out.broken or matching.back.broken
    untold: list[Fault] = [fault for fault in matching.faults if fault.lost or not (fault.plain and told)]
    if not untold:
        return
    worst = max(untold, key=lambda fault: (fault.lost, fault.leash))
    t_s = worst.time * period_s
    how = (
        f"no way on along it is nearer than {worst.leash:.6f} mm; nothing after that is judged"
        if worst.lost
        else f"going along both, they are {worst.leash:.6f} mm apart at least"
    )
    breaches.add(
        breach(
            "order",
            f"the setpoints do not go along the programmed path in its order: at t = {t_s:.4f} s {on_line(worst.line)} "
            f"{how}; the tolerance is {worst.tolerance:g} mm",
            value=worst.leash,
            limit=worst.tolerance,
            t_s=t_s,
            line=worst.line,
        )
    )


def _judge_waits(matching: Matching, period_s: float, breaches: Diagnostics) -> None:
    """Name the wait that is shortened most."""
    if not matching.waits:
        return
    worst = max(matching.waits, key=lambda wait: wait.asked - wait.found)
    t_s, count = worst.time * period_s, len(matching.waits)
    so = f"; {count} waits are shortened in all" if count > 1 else ""
    breaches.add(
        breach(
            "dwell",
            f"the program waits {worst.asked * period_s:g} s on line {worst.line}, and the setpoints stand for "
            f"{worst.found * period_s:g} s there, at t = {t_s:.4f} s{so}",
            value=worst.found * period_s,
            limit=worst.asked * period_s,
            t_s=t_s,
            line=worst.line,
            samples=count,
        )
    )
