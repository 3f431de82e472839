"""Data of a picture: a plan, setpoints, or a simulated response, as whole arrays in the units of files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Axis, Servo
from cncgen.machine.servo_schema import resolve
from cncgen.planner.record import SharpCorner
from cncgen.servo.contour import contour_error
from cncgen.servo.identification.log import AxisLog
from cncgen.servo.record import Response
from cncgen.servo.response_csv import force_in_files
from cncgen.servo.simulate import contour_axes
from cncgen.servo.wanted_motion import WantedMotion, laid_over
from cncgen.setpoints.columns import file_units, position_column
from cncgen.setpoints.record import Setpoints
from cncgen.units import to_file

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PlotData:
    """Arrays of a motion; None where the source does not have them.

    Attributes:
        title: Its title.
        axes: Letters.
        period_s: s.
        command: Shape (n, axes), mm or deg.
        position: Shape (n, axes): where the servo axes were.
        force: Shape (n, axes), with `force_unit` and `force_bound` (nan: none).
        contour: Shape (n,), mm.
        limits: Axis limits by letter (inside units).
        corners: Sharp corners of the plan, shape (k, axes).
    """

    title: str
    axes: str
    period_s: float
    command: Floats
    position: Floats | None = None
    force: Floats | None = None
    force_unit: tuple[str, ...] = ()
    force_bound: tuple[float, ...] = ()
    contour: Floats | None = None
    limits: Mapping[str, Axis] | None = None
    corners: Floats | None = None

    @property
    def time_s(self) -> Floats:
        """Shape (n,)."""
        return np.asarray(np.arange(len(self.command)) * self.period_s, np.float64)

    def difference(self, order: int) -> Floats:
        """Return the finite difference of the command, shape (n, axes), standing still before it."""
        padded = np.concatenate([np.repeat(self.command[:1], order, axis=0), self.command])
        return np.asarray(np.diff(padded, order, axis=0) / self.period_s**order, np.float64)

    def limit(self, letter: str, order: int) -> float | None:
        """Return an axis's limit of velocity, acceleration or jerk in the units of files."""
        if self.limits is None or letter not in self.limits:
            return None
        axis = self.limits[letter]
        return (axis.max_velocity, axis.max_acceleration, axis.max_jerk)[order - 1] * to_file(letter)

    @property
    def plane(self) -> list[int]:
        """The columns of the path: up to two that move most."""
        columns = contour_axes(self.axes) or list(range(len(self.axes)))
        spread = np.ptp(self.command[:, columns], axis=0)
        chosen = sorted(columns[i] for i in np.argsort(-spread)[:2])
        return chosen if len(chosen) == 2 else [*chosen, *chosen]


def of_setpoints(
    chunks: Iterable[Setpoints],
    title: str,
    limits: Mapping[str, Axis] | None = None,
    corners: Iterable[SharpCorner] = (),
) -> PlotData:
    """Return the data of a setpoint stream; corners come from the plan, in the columns of the program's axes X Y Z …."""
    parts = [c for c in chunks if len(c)]
    if not parts:
        raise ValueError(f"{title} has no setpoints")
    axes = parts[0].axes
    rows = file_units(np.concatenate([c.position for c in parts]), axes)
    places = ["XYZ".find(letter) for letter in axes]
    marks = [
        [c.position[i] for i in places] for c in corners if all(0 <= i < len(c.position) for i in places)
    ]
    return PlotData(
        title, axes, parts[0].period_s, rows, limits=limits, corners=np.array(marks) if marks else None
    )


def of_response(
    responses: Iterable[Response],
    title: str,
    limits: Mapping[str, Axis] | None = None,
    servos: Mapping[str, Servo] | None = None,
    corners: Floats | None = None,
) -> PlotData:
    """Return the data of a simulated response."""
    parts = list(responses)
    if not parts:
        raise ValueError(f"{title} has no samples")
    axes = parts[0].axes
    joined = {
        k: np.concatenate([getattr(p, k) for p in parts]) for k in ("command", "position", "contour_error_mm")
    }
    contour = joined["contour_error_mm"]
    return PlotData(
        title,
        axes,
        parts[0].period_s,
        command=file_units(joined["command"], axes),
        position=file_units(joined["position"], axes),
        force=np.concatenate([force_in_files(p)[0] for p in parts]),
        force_unit=force_in_files(parts[0])[1],
        force_bound=tuple(_bound(servos, letter) for letter in axes),
        contour=None if np.isnan(contour).all() else contour,
        limits=limits,
        corners=corners,
    )


def against(data: PlotData, wanted: WantedMotion, responses: Sequence[Response]) -> PlotData:
    """Return the data of a response with the wanted motion in the place of its command, and the distance from its path.

    Raises:
        UsageError: The two do not fit (`cncgen.servo.wanted_motion`).
    """
    rows, _, contour, _ = laid_over(wanted, responses)
    title = f"{data.title}, against {wanted.name}"
    return replace(data, title=title, command=file_units(rows, data.axes), contour=contour)


def of_log(log: Mapping[str, AxisLog], title: str, limits: Mapping[str, Axis] | None = None) -> PlotData:
    """Return the data of a response file.

    Raises:
        UsageError: An axis has no command.
    """
    bare = [position_column(letter) for letter, axis in log.items() if axis.command is None]
    if bare:
        message = f"{title}: no commanded positions stand beside {', '.join(bare)}"
        hint = "a response has t_s, x_cmd_mm, x_mm, x_force, as cncgen simulate writes it"
        raise UsageError(Diagnostic("plot-log", message, hint=hint))
    axes = "".join(log)
    command = np.column_stack([axis.command for axis in log.values()])  # type: ignore[misc]
    position = np.column_stack([axis.position for axis in log.values()])
    columns = contour_axes(axes)
    errors = contour_error(command[:, columns], position[:, columns]) if columns else None
    forces = [axis.drive for axis in log.values()]
    force = None if any(f is None for f in forces) else np.column_stack(forces)  # type: ignore[arg-type]
    period = next(iter(log.values())).period_s
    return PlotData(
        title,
        axes,
        period,
        command=file_units(command, axes),
        position=file_units(position, axes),
        force=force,
        force_unit=("",) * len(axes),
        force_bound=(np.nan,) * len(axes),
        contour=errors,
        limits=limits,
    )


def _bound(servos: Mapping[str, Servo] | None, letter: str) -> float:
    if servos is None or letter not in servos:
        return np.nan
    values = resolve(servos[letter], letter)
    bound = next((v for k, v in values.items() if k.startswith("saturation_")), None)
    return np.nan if bound is None else float(bound)
