"""A response judged against the motion that was wanted: the programmed path, and the plan in its time.

A command that was shaped is not the motion that was wanted, so errors against the command say little of the part. Here the contour
error is the distance from the programmed path, a polyline that is flattened as `cncgen verify` does it, and the
tracking error is that against the plan's setpoints.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.geometry.contour_distance import REACH
from cncgen.kernels import servo_contour
from cncgen.machine.kinematics import Kinematics, mechanism_of
from cncgen.machine.record import Machine
from cncgen.servo.contour import contour_error
from cncgen.servo.record import Response
from cncgen.servo.simulate import contour_axes
from cncgen.servo.tips import TipTracker, tips_on_workpiece
from cncgen.setpoints.columns import inside_units
from cncgen.setpoints.record import Setpoints
from cncgen.toolpath.record import Kind, Toolpath
from cncgen.toolpath.slicing import between
from cncgen.units import is_rotary, to_file
from cncgen.verify.flatten import FlatPath, flatten

Floats = NDArray[np.float64]

#: Longest segment of a programmed path here, mm: the place of a setpoint on it is found to half of that.
SEGMENT_MM = 0.02
#: Most that an axis turns between two places of a path that become places of the tip, deg: at 200 mm a chord of it is 0.1 µm off.
TURN_DEG = 0.1
#: A command that differs from the plan by less is the plan, mm.
SAME_MM = 1e-6


@dataclass(frozen=True, slots=True)
class WantedMotion:
    """The wanted motion.

    Attributes:
        name: The file that it came from.
        axes, period_s: Of the plan.
        rows: Shape (n, axes), mm and rad: the plan's setpoints.
        path: Shape (m, linear axes): the programmed path; None: the polyline of the setpoints is the path.
        path_axes: Letters of its columns.
        kinematics: How the rotary axes carry table or head, if the path is that of the tool's tip on the workpiece; its axes are X Y Z.
        lengths: Shape (n,), mm: the offset of the tool along the spindle then.
    """

    name: str
    axes: str
    period_s: float
    rows: Floats
    path: Floats | None = None
    path_axes: str = ""
    kinematics: Kinematics | None = None
    lengths: Floats | None = None


def reference_of(name: str, setpoints: Iterable[Setpoints]) -> WantedMotion:
    """Return setpoints as the wanted motion.

    Raises:
        UsageError: The setpoints are empty (``setpoints-empty``).
    """
    chunks = [chunk for chunk in setpoints if len(chunk)]
    if not chunks:
        raise UsageError(Diagnostic("setpoints-empty", f"the reference {name} has no setpoints"))
    rows = np.concatenate([np.asarray(chunk.position, float) for chunk in chunks])
    return WantedMotion(name, chunks[0].axes, chunks[0].period_s, rows)


def wanted_of_program(
    name: str, setpoints: Iterable[Setpoints], toolpaths: Iterable[Toolpath], machine: Machine
) -> WantedMotion:
    """Return a program's plan and path as the wanted motion.

    The path is that of the tool's tip if the machine says how its rotary axes carry table or head, and the setpoints have one of
    them and the signal ``tool_length``.

    Args:
        name: Of the program.
        setpoints: Of its plan.
        toolpaths: Of the program.
        machine: That it was planned on.
    """
    chunks = list(setpoints)
    wanted, mechanism = reference_of(name, chunks), mechanism_of(machine)
    head = next(chunk for chunk in chunks if len(chunk))
    if mechanism is not None and TipTracker.follows(mechanism, head):
        lengths = np.concatenate([chunk.signals["tool_length"] for chunk in chunks if len(chunk)])
        wanted = replace(wanted, kinematics=mechanism, lengths=lengths)
        return replace(wanted, path=_tip_path(toolpaths, machine, mechanism), path_axes="XYZ")
    path, letters = _programmed_path(toolpaths, machine, wanted.axes)
    return replace(wanted, path=path, path_axes=letters)


def _tip_path(toolpaths: Iterable[Toolpath], machine: Machine, mechanism: Kinematics) -> Floats:
    """Return the path of the tool's tip on the workpiece as a polyline, shape (m, 3)."""
    parts: list[Floats] = []
    length = 0.0
    for toolpath in toolpaths:
        begins = np.flatnonzero(toolpath.kind == Kind.EVENT)
        told = {int(row): toolpath.events[int(toolpath.curve[row])].values.get("length_mm") for row in begins}
        cuts = [row for row, value in told.items() if value is not None]
        for first, last in pairwise([0, *cuts, len(toolpath)]):
            begun = told.get(first)
            length = length if begun is None else float(begun)
            for piece in flatten([between(toolpath, first, last)], machine) if last > first else ():
                parts.append(_tips(piece, mechanism, length))
    return _cut(np.concatenate(parts) if parts else np.zeros((0, 3)))


def _tips(piece: FlatPath, mechanism: Kinematics, length: float) -> Floats:
    """Return the tips of a stretch of the axes' path, between whose places no axis turns by more than `TURN_DEG`."""
    turning = [k for k, letter in enumerate(piece.axes) if is_rotary(letter)]
    most = np.abs(np.diff(piece.points[:, turning], axis=0)).max(axis=1, initial=0.0)
    points = _parted(piece.points, np.maximum(np.ceil(most / TURN_DEG).astype(int), 1))
    inside = inside_units(points, piece.axes)
    return tips_on_workpiece(mechanism, piece.axes, inside, np.full(len(points), length))


def _programmed_path(toolpaths: Iterable[Toolpath], machine: Machine, axes: str) -> tuple[Floats, str]:
    """Return the programmed path as a polyline of its linear axes among `axes`, shape (m, k), and their letters."""
    parts: list[Floats] = []
    letters = ""
    for piece in flatten(toolpaths, machine):
        if not letters:
            both = "".join(letter for letter in piece.axes if letter in axes)
            letters = "".join(both[i] for i in contour_axes(both))
        points = piece.restricted([piece.axes.index(letter) for letter in letters]).points
        parts.append(points if not parts else points[1:])
    path = np.concatenate(parts) if parts else np.zeros((0, len(letters)))
    return _cut(path), letters


def _cut(path: Floats) -> Floats:
    """Return a polyline without segments of no length, and with none longer than `SEGMENT_MM`."""
    if len(path) < 2:
        return path
    length = np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1))
    path, length = np.concatenate([path[:1], path[1:][length > 0.0]]), length[length > 0.0]
    return _parted(path, np.maximum(np.ceil(length / SEGMENT_MM).astype(int), 1))


def _parted(path: Floats, parts: NDArray[np.int64]) -> Floats:
    """Return a polyline each of whose segments is cut in so many equal parts."""
    begin = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts) + 1) / parts[begin]
    inner = path[begin] + share[:, None] * (path[begin + 1] - path[begin])
    return np.concatenate([path[:1], inner])


def judged_against(
    reference: WantedMotion, responses: Sequence[Response], shift: int | None = None
) -> dict[str, float | str | None]:
    """Return the errors of a response against the wanted motion, in mm (degrees of rotary axes alone) and s.

    A response that is longer than the plan because its command was shaped is laid over the plan where the two differ least, or
    after `shift` rows.

    Raises:
        UsageError: Axes or periods differ (``reference-axes``, ``reference-period``).
    """
    head = responses[0]
    wanted, position, contour, shift = laid_over(reference, responses, shift)
    judged = contour_axes(head.axes)
    unit, factor = ("mm", 1.0) if judged else ("deg", to_file(head.axes[0]))
    chosen = judged or list(range(len(head.axes)))
    distance = factor * np.sqrt(((wanted - position)[:, chosen] ** 2).sum(axis=1))
    return {
        "name": reference.name,
        "shift_s": shift * head.period_s,
        "contour_error_rms_mm": None if contour is None else float(np.sqrt((contour**2).mean())),
        "contour_error_max_mm": None if contour is None else float(contour.max()),
        "contour_error_max_t_s": None if contour is None else float(contour.argmax()) * head.period_s,
        "contour_error_of": "tip" if reference.kinematics else "".join(head.axes[k] for k in judged),
        f"tracking_rms_{unit}": float(np.sqrt((distance**2).mean())),
        f"tracking_max_{unit}": float(distance.max()),
    }


def distance_from_path(reference: WantedMotion, responses: Sequence[Response]) -> Floats | None:
    """Return how far the axes are from the wanted path, whenever they are there, shape (n,); None of rotary axes alone.

    The command follows that path at another speed, or near it.

    Raises:
        UsageError: Axes or periods differ (``reference-axes``, ``reference-period``).
    """
    head = responses[0]
    _check(reference, head)
    if not contour_axes(head.axes):
        return None
    if reference.path is None:
        columns = contour_axes(reference.axes)
        letters = "".join(reference.axes[k] for k in columns)
        reference = replace(reference, path=_cut(reference.rows[:, columns]), path_axes=letters)
    command, position = (np.concatenate([getattr(r, k) for r in responses]) for k in ("command", "position"))
    return _contour(reference, head.axes, command, position)


def laid_over(
    reference: WantedMotion, responses: Sequence[Response], shift: int | None = None
) -> tuple[Floats, Floats, Floats | None, int]:
    """Return wanted and actual position, shape (n, axes), contour error, shape (n,) or None of rotary axes alone, and the shift.

    Raises:
        UsageError: As `judged_against`.
    """
    head = responses[0]
    _check(reference, head)
    columns = [reference.axes.index(letter) for letter in head.axes]
    rows = reference.rows[:, columns]
    command, position = (np.concatenate([getattr(r, k) for r in responses]) for k in ("command", "position"))
    shift = _shift(rows, command, position) if shift is None else shift
    after = max(len(position) - shift - len(rows), 0)
    wanted = _placed(rows, shift, after)[: len(position)]
    if reference.lengths is not None:
        reference = replace(reference, lengths=_placed(reference.lengths, shift, after)[: len(position)])
    contour = _contour(reference, head.axes, wanted, position) if contour_axes(head.axes) else None
    return wanted, position, contour, shift


def _placed(rows: Floats, before: int, after: int) -> Floats:
    """Return rows with the first and the last of them repeated."""
    return np.concatenate([np.repeat(rows[:1], before, axis=0), rows, np.repeat(rows[-1:], after, axis=0)])


def _check(reference: WantedMotion, head: Response) -> None:
    missing = [letter for letter in head.axes if letter not in reference.axes]
    if missing:
        message = (
            f"the response has the axes {head.axes}, and the reference {reference.name} has {reference.axes}"
        )
        raise UsageError(Diagnostic("reference-axes", message))
    still = [
        letter for letter, rows in zip(reference.axes, reference.rows.T, strict=True) if not np.ptp(rows)
    ]
    moving = [letter for letter in reference.axes if letter not in head.axes and letter not in still]
    if moving:
        message = f"the reference {reference.name} moves {', '.join(moving)}, which the response has not ({head.axes})"
        raise UsageError(Diagnostic("reference-axes", message))
    if abs(reference.period_s - head.period_s) > 1e-9:
        message = f"setpoints come every {head.period_s:g} s, and those of the reference every {reference.period_s:g} s"
        raise UsageError(Diagnostic("reference-period", message))


def _shift(rows: Floats, command: Floats, position: Floats) -> int:
    """Return by how many rows the plan lies behind the beginning of a response."""
    room = len(position) - len(rows)
    if room <= 0 or np.abs(command[: len(rows)] - rows).max() <= SAME_MM:
        return 0
    # |p − r|² over each shift: the cross product by FFT, the squares of p by running sums.
    length = len(position) + len(rows)
    cross = np.zeros(room + 1)
    for p, r in zip((position - rows[0]).T, (rows - rows[0]).T, strict=True):
        spectrum = np.fft.rfft(p, length) * np.conj(np.fft.rfft(r, length))
        squares = np.concatenate([[0.0], np.cumsum(p**2)])
        cross += (
            squares[len(r) : len(r) + room + 1]
            - squares[: room + 1]
            - 2.0 * np.fft.irfft(spectrum, length)[: room + 1]
        )
        # Beyond the plan the axis should stand where the plan ends.
        after = np.concatenate([np.cumsum(((p - r[-1]) ** 2)[::-1])[::-1], [0.0]])
        cross += squares[: room + 1] + after[len(r) : len(r) + room + 1]
    return int(cross.argmin())


def _contour(reference: WantedMotion, axes: str, wanted: Floats, position: Floats) -> Floats:
    """Return the distance of each position from the path, shape (n,)."""
    if reference.kinematics is not None and reference.lengths is not None:
        lengths = reference.lengths
        wanted, position = (
            tips_on_workpiece(reference.kinematics, axes, rows, lengths) for rows in (wanted, position)
        )
        axes = "XYZ"
    if reference.path is None or len(reference.path) < 2:
        columns = contour_axes(axes)
        return contour_error(wanted[:, columns], position[:, columns])
    kept = [k for k, letter in enumerate(reference.path_axes) if letter in axes]
    columns = [axes.index(reference.path_axes[k]) for k in kept]
    path = np.ascontiguousarray(reference.path[:, kept])
    arc = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1)))])
    own = np.empty(len(wanted), np.int64)
    servo_contour.vertices_reached(path, arc, np.ascontiguousarray(wanted[:, columns]), SEGMENT_MM, own)
    result = np.empty(len(position))
    beyond = np.full(len(own), len(path) - 1, np.int64)
    servo_contour.distances(
        path,
        arc,
        own,
        beyond,
        np.ascontiguousarray(position[:, columns]),
        REACH,
        result,
        np.empty((0, len(columns))),
    )
    return result
