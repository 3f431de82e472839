"""Pictures of a motion: path, feed, axes, curvature, force, errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import check_writable
from cncgen.report.drawing import (
    BLUE,
    FORMATS,
    GREY,
    ORANGE,
    RED,
    bound,
    check_folder,
    check_installed,
    folder,
    legend,
    line,
    map_size,
    new_figure,
    plane,
    save,
)
from cncgen.report.plot_data import PlotData
from cncgen.units import ORDERS, file_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


def path(data: PlotData) -> Figure:
    """Return the path with its sharp corners, and with the contour error magnified along it where it is known.

    Of a path in space the two axes that move most are shown.
    """
    i, j = data.plane
    command = data.command[:, [i, j]]
    figure, ((part,),) = new_figure(data.title, height=map_size(command), width=8.5)
    part.plot(command[:, 0], command[:, 1], color=GREY, linewidth=0.9, label="command")
    shown = [command]
    if data.position is not None and data.contour is not None:
        scale = _magnification(data)
        shown.append(command + scale * _normal_offset(data, i, j))
        label = f"axes, contour error × {scale:g} (max {1e3 * float(np.nanmax(data.contour)):.3g} µm)"
        part.plot(shown[1][:, 0], shown[1][:, 1], color=BLUE, linewidth=0.9, label=label)
    if data.corners is not None:
        part.plot(data.corners[:, i], data.corners[:, j], "o", color=RED, markersize=4, fillstyle="none",
                  label=f"{len(data.corners)} sharp corners")  # fmt: skip
    plane(part, shown, (_label(data, i), _label(data, j)))
    figure.legend(loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    return figure


def _label(data: PlotData, column: int) -> str:
    letter = data.axes[column]
    return f"{letter} ({file_unit(letter)})"


def _magnification(data: PlotData) -> float:
    """Return 1, 2 or 5 times a power of ten that makes the largest error a twentieth of the path's size."""
    largest = float(np.nanmax(data.contour)) if data.contour is not None else 0.0
    size = float(np.ptp(data.command[:, data.plane], axis=0).max())
    if not largest > 0.0 or not size > 0.0:
        return 1.0
    wanted = size / 20.0 / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(m for m in (1.0, 2.0, 5.0) if m * power <= wanted))


def _normal_offset(data: PlotData, i: int, j: int) -> Floats:
    """Return the part of the position error across the path, shape (n, 2)."""
    command = data.command[:, [i, j]]
    actual = data.command if data.position is None else data.position
    error = actual[:, [i, j]] - command
    tangent = np.gradient(command, axis=0) if len(command) > 1 else np.zeros_like(command)
    size = np.sqrt((tangent**2).sum(axis=1))
    moving = size > 1e-9
    unit = np.where(moving[:, None], tangent / np.where(moving, size, 1.0)[:, None], 0.0)
    across = error - (error * unit).sum(axis=1)[:, None] * unit
    return np.where(moving[:, None], across, 0.0)


def feed(data: PlotData) -> Figure:
    """Return the speed along the path."""
    figure, ((part,),) = new_figure(data.title)
    speed = np.sqrt((data.difference(1)[:, _linear(data)] ** 2).sum(axis=1))
    alone = data.position is None
    line(
        part,
        data.time_s,
        speed,
        color=BLUE if alone else GREY,
        linewidth=0.9 if alone else 2.0,
        label="command",
    )
    if data.position is not None:
        rows = data.position[:, _linear(data)]
        actual = np.sqrt((np.diff(rows, axis=0, prepend=rows[:1]) ** 2).sum(axis=1)) / data.period_s
        line(part, data.time_s, actual, color=ORANGE, linewidth=0.7, label="axes")
        legend(part, "lower center", ncols=2)
    part.set_ylabel("feed (mm/s)")
    part.set_xlabel("time (s)")
    return figure


def _linear(data: PlotData) -> list[int]:
    return [k for k, letter in enumerate(data.axes) if file_unit(letter) == "mm"] or list(
        range(len(data.axes))
    )


def axes(data: PlotData) -> Figure:
    """Return velocity, acceleration and jerk of each axis, by finite differences, with their limits."""
    count = len(data.axes)
    figure, parts = new_figure(data.title, 3, count, height=2.1, width=max(9.0, 4.8 * count))
    for k, letter in enumerate(data.axes):
        for order, (name, power) in enumerate(ORDERS, start=1):
            part = parts[order - 1, k]
            line(part, data.time_s, data.difference(order)[:, k], linewidth=0.9 if order < 3 else 0.5)
            bound(part, data.limit(letter, order), "limit")
            part.set_ylabel(f"{letter} {name} ({file_unit(letter)}/s{power})", fontsize=8)
        parts[-1, k].set_xlabel("time (s)")
    if data.limits:
        handles, labels = parts[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", fontsize=8, frameon=False)
    return figure


def curvature(data: PlotData) -> Figure:
    """Return the curvature of the commanded path over its length, on a logarithmic scale."""
    figure, ((part,),) = new_figure(data.title)
    points = _distinct(data)
    if len(points) < 3:
        raise UsageError(Diagnostic("plot-empty", f"{data.title}: the path does not move"))
    a, b = np.diff(points, axis=0)[:-1], np.diff(points, axis=0)[1:]
    la, lb = (np.sqrt((v**2).sum(axis=1)) for v in (a, b))
    turn = np.arccos(np.clip((a * b).sum(axis=1) / (la * lb), -1.0, 1.0))
    s = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1)))])
    line(part, s[1:-1], np.maximum(2.0 * turn / (la + lb), 1e-6))
    part.set_yscale("log")
    part.set_ylabel("curvature (1/mm)")
    part.set_xlabel("length (mm)")
    return figure


def _distinct(data: PlotData) -> Floats:
    """Return the commanded points that are apart from the one before, shape (points, linear axes)."""
    rows = data.command[:, _linear(data)]
    step = np.sqrt((np.diff(rows, axis=0) ** 2).sum(axis=1))
    return np.asarray(rows[np.concatenate([[True], step > 1e-6])], np.float64)


def force(data: PlotData) -> Figure:
    """Return the drives' inputs with their bounds."""
    values = _wanted(data.force, data, "forces")
    figure, grid = new_figure(data.title, len(data.axes), height=2.2)
    parts = grid[:, 0]
    for k, letter in enumerate(data.axes):
        line(parts[k], data.time_s, values[:, k])
        bound(parts[k], data.force_bound[k] if data.force_bound else None, "bound of the drive")
        if parts[k].get_legend_handles_labels()[1]:
            legend(parts[k], "upper right")
        unit = f" ({data.force_unit[k]})" if data.force_unit and data.force_unit[k] else ""
        parts[k].set_ylabel(f"{letter} drive{unit}")
    parts[-1].set_xlabel("time (s)")
    return figure


def errors(data: PlotData) -> Figure:
    """Return tracking error of each axis and the contour error."""
    position = _wanted(data.position, data, "positions of the axes")
    rows = len(data.axes) + (data.contour is not None)
    figure, grid = new_figure(data.title, rows, height=2.0)
    parts = grid[:, 0]
    for k, letter in enumerate(data.axes):
        unit = "µm" if file_unit(letter) == "mm" else "mdeg"
        line(parts[k], data.time_s, 1e3 * (data.command - position)[:, k])
        parts[k].set_ylabel(f"{letter} tracking error ({unit})")
    if data.contour is not None:
        line(parts[-1], data.time_s, 1e3 * data.contour, color=RED)
        parts[-1].set_ylim(bottom=0.0)
        parts[-1].set_ylabel("contour error (µm)")
    parts[-1].set_xlabel("time (s)")
    return figure


def _wanted(values: Floats | None, data: PlotData, what: str) -> Floats:
    if values is None:
        raise UsageError(
            Diagnostic(
                "plot-needs-response",
                f"{data.title} has no {what}",
                hint="plot a response file, or a program or setpoints with --axis-params",
            )
        )
    return values


#: Pictures by name.
KINDS: dict[str, Callable[[PlotData], Any]] = {
    "path": path,
    "feed": feed,
    "axes": axes,
    "curvature": curvature,
    "force": force,
    "errors": errors,
}


def available(data: PlotData) -> list[str]:
    """Return the pictures that the data allow."""
    possible = {
        "path": True,
        "feed": True,
        "axes": True,
        "curvature": len(_distinct(data)) > 2,
        "force": data.force is not None,
        "errors": data.position is not None,
    }
    return [name for name, holds in possible.items() if holds]


def check_target(kinds: Sequence[str] | None, output: str) -> None:
    """Refuse what `draw` could not write; without `kinds` it draws all that the data allow, which are several.

    Raises:
        UsageError: A kind is unknown, or `output` is one file for several (``plot-kind``); it cannot be written; it is a file in
            a format that is not written (``plot-format``), or in the place of a folder.
    """
    unknown = [kind for kind in kinds or () if kind not in KINDS]
    if unknown:
        message = f"no picture is called {', '.join(unknown)}; there are {', '.join(KINDS)}"
        raise UsageError(Diagnostic("plot-kind", message))
    check_installed()
    target = Path(output)
    if target.suffix.lower() not in FORMATS:
        check_folder(output)  # as it was given: a path drops the slash at its end
    elif kinds is None or len(kinds) != 1:
        hint = f"name a folder, or one of them: --kinds {kinds[0] if kinds else 'path'}"
        raise UsageError(Diagnostic("plot-kind", f"{output} is one file for several pictures", hint=hint))
    else:
        check_writable(target)


def draw(data: PlotData, kinds: Sequence[str], output: str) -> list[str]:
    """Draw pictures: one to the file `output`, or each to ``<output>/<kind>.png``; return the files.

    Raises:
        UsageError: As `check_target`; a kind needs what the data lack (``plot-kind``).
    """
    check_target(kinds, output)
    target = Path(output)
    if target.suffix.lower() in FORMATS:
        save(KINDS[kinds[0]](data), target)
        return [output]
    files = []
    for kind in kinds:
        file = target / f"{kind}.png"
        figure = KINDS[kind](data)
        folder(output)  # not before there is something to put into it
        save(figure, file)
        files.append(str(file))
    return files
