"""Figures of matplotlib, made without pyplot and without windows: a common style of all pictures, and writing them to files."""

from __future__ import annotations

import importlib.util
import io
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import file_fault, open_output

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    _Corner = Literal[
        "best",
        "upper left",
        "upper center",
        "upper right",
        "lower left",
        "lower center",
        "lower right",
        "center right",
    ]
    #: Pictures with the names of their files.
    Figures = Iterator[tuple[str, Figure]]

Floats = NDArray[np.float64]

# A cache of fonts that another installation wrote makes twenty lines about fonts which are not missed, and a folder that cannot be
# written three about where the cache is instead: standard error is for diagnostics.
logging.getLogger("matplotlib").setLevel(logging.ERROR)

FORMATS = (".png", ".svg", ".pdf")
#: Points a line is thinned to, keeping the extremes of each stretch.
MAX_POINTS = 20_000
#: Colours that differ for the colour-blind too (Okabe and Ito), in the order lines take them.
BLUE, ORANGE, GREEN = "#0072B2", "#E69F00", "#009E73"
#: Commands, and limits.
GREY, RED = "0.45", "#C8102E"


def new_figure(
    title: str,
    rows: int = 1,
    columns: int = 1,
    *,
    height: float = 3.0,
    width: float = 9.0,
    share: Literal["col"] | bool = True,
) -> tuple[Figure, Any]:
    """Return a figure and its axes, shape (rows, columns); by default all of them share their abscissa.

    Raises:
        UsageError: matplotlib is not installed, or refuses its settings, as a backend that it does not have (``plot-missing``).
    """
    locale = os.environ.get("LC_ALL")
    # fc-list, which matplotlib may ask for fonts, prints a warning of a locale that does not exist.
    os.environ["LC_ALL"] = "C"
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise _missing() from error
    except ValueError as error:
        # Its parts stay behind, and it cannot be imported again beside them.
        for name in [each for each in sys.modules if each.partition(".")[0] == "matplotlib"]:
            del sys.modules[name]
        message = f"matplotlib refuses its settings: {str(error).partition(';')[0]}"
        hint = "look at MPLBACKEND in the environment, and at matplotlibrc"
        raise UsageError(Diagnostic("plot-missing", message, hint=hint)) from error
    finally:
        os.environ.pop("LC_ALL")
        if locale is not None:
            os.environ["LC_ALL"] = locale
    figure = Figure(figsize=(width, max(2.6, height * rows + 0.5)), layout="constrained")
    figure.suptitle(title, fontsize=11)
    parts = figure.subplots(rows, columns, squeeze=False, sharex=share)
    for part in parts.ravel():
        part.grid(True, linewidth=0.4, alpha=0.5)
        part.set_axisbelow(True)
        part.spines[["top", "right"]].set_visible(False)
        part.tick_params(labelsize=8)
        part.xaxis.label.set_size(9)
        part.yaxis.label.set_size(9)
    return figure, parts


def check_installed() -> None:
    """Raise `UsageError` (``plot-missing``) where there is no matplotlib; it is not imported."""
    if importlib.util.find_spec("matplotlib") is None:
        raise _missing()


def _missing() -> UsageError:
    hint = "install it: pip install 'cncgen[plot]'"
    return UsageError(Diagnostic("plot-missing", "pictures need matplotlib", hint=hint))


def check_format(path: str | Path) -> None:
    """Raise `UsageError` unless a picture can be written in the format of a file's suffix (``plot-format``), by an installed matplotlib."""
    check_installed()
    if Path(path).suffix.lower() not in FORMATS:
        raise UsageError(Diagnostic("plot-format", f"{path}: pictures are written as {', '.join(FORMATS)}"))


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure whole or not at all, in the format of its suffix: PNG, SVG or PDF.

    Raises:
        UsageError: Another suffix (``plot-format``), or the file cannot be written.
    """
    check_format(path)
    picture = io.BytesIO()
    figure.savefig(picture, format=Path(path).suffix.lower()[1:], dpi=130)
    with open_output(path) as sink:
        sink.write(picture.getvalue())


def check_folder(path: str | Path) -> None:
    """Refuse a name that is no folder's: with a suffix it is a file's, unless a slash ends it or the folder exists.

    Raises:
        UsageError: It is that of a file in a format that is not written (``plot-format``), or of a file that exists.
    """
    target = Path(path)
    is_folder = os.path.isdir(target)
    if os.path.exists(target) and not is_folder:
        raise UsageError(Diagnostic("file-write", f"cannot write pictures into {path}: it is a file"))
    if target.suffix and not is_folder and not os.fspath(path).endswith(("/", os.sep)):
        hint = f"a folder is named with a slash at its end: {path}/"
        raise UsageError(
            Diagnostic("plot-format", f"{path}: pictures are written as {', '.join(FORMATS)}", hint=hint)
        )


def folder(path: str | Path) -> Path:
    """Return a folder for pictures, made where it is missing.

    Raises:
        UsageError: As `check_folder`, or it cannot be made.
    """
    check_folder(path)
    target = Path(path)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise file_fault(path, "write", error) from error
    return target


def line(part: Axes, x: Floats, y: Floats, **style: Any) -> None:
    """Draw a line; a long one is thinned to the extremes of each stretch, so peaks stay."""
    if len(x) > MAX_POINTS:
        step = -(-2 * len(x) // MAX_POINTS)
        count = len(x) // step
        stretches = y[: count * step].reshape(count, step)
        picks = np.column_stack([stretches.argmin(axis=1), stretches.argmax(axis=1)])
        picks.sort(axis=1)
        keep = (picks + np.arange(count)[:, None] * step).ravel()
        x, y = x[keep], y[keep]
    part.plot(x, y, **{"linewidth": 0.9, "color": BLUE, **style})


def bound(part: Axes, value: float | None, label: str | None = None) -> None:
    """Draw a limit, either sign."""
    if value is not None and np.isfinite(value):
        for sign in (1.0, -1.0):
            part.axhline(
                sign * value, color=RED, linewidth=0.9, linestyle="--", label=label if sign > 0 else None
            )


def legend(part: Axes, where: _Corner = "best", **more: Any) -> None:
    """Show what the lines are; lines in it are thick enough to tell their colours."""
    shown = part.legend(loc=where, fontsize=8, framealpha=0.9, **more)
    for handle in shown.get_lines():
        if handle.get_linewidth() > 0.0:
            handle.set_linewidth(max(1.6, handle.get_linewidth()))


def plane(part: Axes, rows: Sequence[Floats], labels: tuple[str, str]) -> None:
    """Make a part a map: equal scales on both axes, the box round all rows (each of shape (n, 2))."""
    whole = np.concatenate([np.asarray(r, float) for r in rows])
    low, high = np.nanmin(whole, axis=0), np.nanmax(whole, axis=0)
    room = 0.04 * max(float((high - low).max()), 1e-9)
    part.set_xlim(low[0] - room, high[0] + room)
    part.set_ylim(low[1] - room, high[1] + room)
    part.set_aspect("equal", adjustable="box")
    part.set_xlabel(labels[0])
    part.set_ylabel(labels[1])


def map_size(rows: Floats, width: float = 8.0, most: float = 9.0) -> float:
    """Return the height of a picture in which a map of rows (n, 2) fills that width."""
    spread = np.maximum(np.ptp(rows, axis=0), 1e-9)
    return float(np.clip(width * spread[1] / spread[0], 2.6, most))


def ticks(count: int, period: float = 0.001, first: int = 0) -> Floats:
    """Return times of that many periods, s."""
    return np.asarray((first + np.arange(count)) * period, np.float64)
