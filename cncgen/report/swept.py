"""The results of a sweep for a person: the table of the best rows, sensitivities, the Pareto front, and pictures of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.report.drawing import BLUE, GREY, ORANGE, RED, new_figure
from cncgen.report.tables import counted, number, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
#: A cell of the table of results.
Cell = str | float | int | bool | None

#: Columns of a picture of sensitivities.
_MOST_BARS = 12


@dataclass(frozen=True, slots=True)
class Share:
    """A line of a table of sensitivities: a varied value and its shares of the variance."""

    column: str
    first: float
    total: float


def rows_text(columns: Mapping[str, Sequence[Cell]], rows: Indices, shown: Sequence[str]) -> str:
    """Return some rows of a table, columns by name, as text."""
    cells = [[_cell(columns[name][row]) for name in shown] for row in rows]
    return text_table(list(shown), cells)


def shares_text(figure: str, method: str, count: int, explained: float, shares: Sequence[Share]) -> str:
    """Return the sensitivities of a figure as text, the largest total first."""
    order = sorted(shares, key=lambda share: -share.total if np.isfinite(share.total) else np.inf)
    told = "" if explained >= 1.0 else f", which predicts {100 * explained:.4g} % of the variance"
    head = f"{figure}: shares of the variance ({method} on {counted(count, 'row')}{told})\n"
    if explained <= 0.0:
        return f"{figure}: an {method} on {counted(count, 'row')} predicts none of its variance: draw more points\n"
    cells = [[share.column, _share(share.first), _share(share.total)] for share in order]
    return head + text_table(("varied", "first order", "total"), cells)


def _share(value: float) -> str:
    return "-" if not np.isfinite(value) else f"{value:.4f}"


def _cell(value: Cell) -> str:
    if isinstance(value, float):
        return number(value if np.isfinite(value) else None, digits=6)
    return "-" if value is None else str(value)


def swept_figure(
    title: str,
    pair: tuple[str, Floats, str, Floats],
    fronts: Sequence[Indices],
    sensitivities: Sequence[tuple[str, Sequence[Share]]],
) -> Figure:
    """Draw two figures of all rows against each other with Pareto fronts, and the sensitivities of each figure as bars.

    Args:
        title: Of the picture.
        pair: Name and values, shape (n,), of the figure along x, and of that along y.
        fronts: Rows of each program's front, in order.
        sensitivities: Names of figures with their shares.
    """
    figure, parts = new_figure(title, 1, 1 + bool(sensitivities), height=3.6, share=False)
    part = parts[0, 0]
    along, x, up, y = pair
    part.plot(x, y, ".", color=GREY, markersize=3)
    for k, front in enumerate(fronts):
        told = "" if k else "Pareto front" if len(fronts) == 1 else "Pareto front of each program"
        part.plot(x[front], y[front], "o-", color=RED, markersize=4, linewidth=1.0, label=told)
    part.set_xlabel(along)
    part.set_ylabel(up)
    part.legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    if sensitivities:
        _bars(parts[0, 1], sensitivities)
    return figure


def _bars(part: Axes, sensitivities: Sequence[tuple[str, Sequence[Share]]]) -> None:
    names: list[str] = []
    first: list[float] = []
    total: list[float] = []
    for figure, shares in sensitivities:
        for share in shares:
            if np.isfinite(share.total) and len(names) < _MOST_BARS:
                names.append(f"{figure}\n{share.column}")
                first.append(share.first)
                total.append(share.total)
    places = np.arange(len(names))
    part.barh(places - 0.2, first, 0.38, color=BLUE, label="first order")
    part.barh(places + 0.2, total, 0.38, color=ORANGE, label="total")
    part.set_yticks(places, names, fontsize=6)
    part.invert_yaxis()
    part.set_xlabel("share of the variance")
    part.legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
