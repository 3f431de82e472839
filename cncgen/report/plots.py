"""Pictures of a motion with matplotlib, drawn on figures of their own (no pyplot, no windows)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import open_output
from cncgen.report.plot_data import PlotData
from cncgen.units import file_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

FORMATS = (".png", ".svg", ".pdf")
#: Points a line is thinned to, keeping the extremes of each stretch.
MAX_POINTS = 20_000
_NAMES = ("velocity", "acceleration", "jerk")
_POWERS = ("/s", "/s²", "/s³")


def new_figure(title: str, rows: int = 1, height: float = 3.0, width: float = 9.0) -> tuple[Figure, Any]:
    """Return a figure and its axes, shape (rows,).

    Raises:
        UsageError: matplotlib is not installed (``plot-missing``).
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        hint = "install it: pip install 'cncgen[plot]'"
        raise UsageError(Diagnostic("plot-missing", "pictures need matplotlib", hint=hint)) from error
    figure = Figure(figsize=(width, max(2.2, height * rows)), layout="constrained")
    figure.suptitle(title, fontsize=11)
    parts = figure.subplots(rows, 1, squeeze=False)[:, 0]
    for part in parts:
        part.grid(True, linewidth=0.4, alpha=0.5)
    return figure, parts


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure whole or not at all, in the format of its suffix: PNG, SVG or PDF.

    Raises:
        UsageError: Another suffix (``plot-format``), or the file cannot be written.
    """
    import io

    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise UsageError(Diagnostic("plot-format", f"{path}: pictures are written as {', '.join(FORMATS)}"))
    picture = io.BytesIO()
    figure.savefig(picture, format=suffix[1:], dpi=130)
    with open_output(path) as sink:
        sink.write(picture.getvalue())


def line(part: Any, x: Floats, y: Floats, **style: Any) -> None:
    """Draw a line; a long one is thinned to the extremes of each stretch, so peaks stay."""
    if len(x) > MAX_POINTS:
        step = -(-2 * len(x) // MAX_POINTS)
        count = len(x) // step
        stretches = y[: count * step].reshape(count, step)
        picks = np.column_stack([stretches.argmin(axis=1), stretches.argmax(axis=1)])
        picks.sort(axis=1)
        keep = (picks + np.arange(count)[:, None] * step).ravel()
        x, y = x[keep], y[keep]
    part.plot(x, y, **{"linewidth": 0.9, **style})


def bound(part: Any, value: float | None, label: str | None = None) -> None:
    """Draw a limit, either sign."""
    if value is not None and np.isfinite(value):
        for sign in (1.0, -1.0):
            part.axhline(
                sign * value,
                color="crimson",
                linewidth=0.9,
                linestyle="--",
                label=label if sign > 0 else None,
            )


def path(data: PlotData) -> Figure:
    """Return the path with its sharp corners, and with the contour error magnified along it where it is known."""
    figure, (part,) = new_figure(data.title, height=7.0, width=7.5)
    i, j = data.plane
    part.plot(data.command[:, i], data.command[:, j], color="0.35", linewidth=0.8, label="command")
    if data.position is not None and data.contour is not None:
        scale = _magnification(data)
        offset = _normal_offset(data, i, j)
        shown = data.command[:, [i, j]] + scale * offset
        part.plot(
            shown[:, 0], shown[:, 1], color="tab:blue", linewidth=0.8, label=f"contour error × {scale:g}"
        )
    if data.corners is not None:
        part.plot(data.corners[:, i], data.corners[:, j], "o", color="crimson", markersize=4, fillstyle="none",
                  label=f"{len(data.corners)} sharp corners")  # fmt: skip
    part.set_aspect("equal", adjustable="datalim")
    part.set_xlabel(_label(data, i))
    part.set_ylabel(_label(data, j))
    part.legend(loc="upper right", fontsize=8)
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
    figure, (part,) = new_figure(data.title)
    speed = np.sqrt((data.difference(1)[:, _linear(data)] ** 2).sum(axis=1))
    line(part, data.time_s, speed, label="command")
    if data.position is not None:
        rows = data.position[:, _linear(data)]
        actual = np.sqrt((np.diff(rows, axis=0, prepend=rows[:1]) ** 2).sum(axis=1)) / data.period_s
        line(part, data.time_s, actual, color="tab:orange", linewidth=0.6, label="axes")
        part.legend(fontsize=8)
    part.set_ylabel("feed (mm/s)")
    part.set_xlabel("time (s)")
    return figure


def _linear(data: PlotData) -> list[int]:
    return [k for k, letter in enumerate(data.axes) if file_unit(letter) == "mm"] or list(
        range(len(data.axes))
    )


def axes(data: PlotData) -> Figure:
    """Return velocity, acceleration and jerk of each axis, by finite differences, with their limits."""
    figure, parts = new_figure(data.title, rows=3 * len(data.axes), height=1.7)
    for k, letter in enumerate(data.axes):
        for order in (1, 2, 3):
            part = parts[3 * k + order - 1]
            line(part, data.time_s, data.difference(order)[:, k])
            bound(part, data.limit(letter, order))
            part.set_ylabel(
                f"{letter} {_NAMES[order - 1]}\n({file_unit(letter)}{_POWERS[order - 1]})", fontsize=8
            )
    parts[-1].set_xlabel("time (s)")
    return figure


def curvature(data: PlotData) -> Figure:
    """Return the curvature of the commanded path over its length, on a logarithmic scale."""
    figure, (part,) = new_figure(data.title)
    rows = data.command[:, _linear(data)]
    step = np.sqrt((np.diff(rows, axis=0) ** 2).sum(axis=1))
    keep = np.concatenate([[True], step > 1e-6])
    points = rows[keep]
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


def force(data: PlotData) -> Figure:
    """Return the drives' inputs with their bounds."""
    values = _wanted(data.force, data, "forces")
    figure, parts = new_figure(data.title, rows=len(data.axes), height=2.2)
    for k, letter in enumerate(data.axes):
        line(parts[k], data.time_s, values[:, k])
        bound(parts[k], data.force_bound[k] if data.force_bound else None)
        unit = f" ({data.force_unit[k]})" if data.force_unit and data.force_unit[k] else ""
        parts[k].set_ylabel(f"{letter} drive{unit}")
    parts[-1].set_xlabel("time (s)")
    return figure


def errors(data: PlotData) -> Figure:
    """Return tracking error of each axis and the contour error."""
    position = _wanted(data.position, data, "positions of the axes")
    rows = len(data.axes) + (data.contour is not None)
    figure, parts = new_figure(data.title, rows=rows, height=2.2)
    for k, letter in enumerate(data.axes):
        unit = "µm" if file_unit(letter) == "mm" else "mdeg"
        line(parts[k], data.time_s, 1e3 * (data.command - position)[:, k])
        parts[k].set_ylabel(f"{letter} tracking ({unit})")
    if data.contour is not None:
        line(parts[-1], data.time_s, 1e3 * data.contour, color="tab:red")
        parts[-1].set_ylabel("contour (µm)")
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
    names = ["path", "feed", "axes", "curvature"]
    return (
        names
        + (["force"] if data.force is not None else [])
        + (["errors"] if data.position is not None else [])
    )


def draw(data: PlotData, kinds: Sequence[str], output: str) -> list[str]:
    """Draw pictures: one to the file `output`, or each to ``<output>/<kind>.png``; return the files.

    Raises:
        UsageError: A kind is unknown (``plot-kind``) or needs what the data lack.
    """
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise UsageError(
            Diagnostic(
                "plot-kind", f"no picture is called {', '.join(unknown)}; there are {', '.join(KINDS)}"
            )
        )
    target = Path(output)
    if target.suffix.lower() in FORMATS:
        if len(kinds) != 1:
            raise UsageError(
                Diagnostic("plot-kind", f"{output} is one file for {len(kinds)} pictures; name a folder")
            )
        save(KINDS[kinds[0]](data), target)
        return [output]
    target.mkdir(parents=True, exist_ok=True)
    files = []
    for kind in kinds:
        file = target / f"{kind}.png"
        save(KINDS[kind](data), file)
        files.append(str(file))
    return files
