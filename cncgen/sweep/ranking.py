"""The rows of a sweep put in order: by a figure, and the Pareto front of two."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.sweep.designs import unit_points
from cncgen.sweep.sensitivities import Sensitivities, sensitivities

if TYPE_CHECKING:
    import pyarrow

    from cncgen.sweep.results import DrawnDesign

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def ranked(values: Floats, *, largest: bool = False, excess: Floats | None = None) -> Indices:
    """Return the numbers of the rows with a finite value, the smallest value first (`largest`: last); ties as they stand.

    Args:
        values: Shape (n,).
        largest: Whether the largest value stands first.
        excess: How far each row is over its bounds, shape (n,): rows with more stand behind those with less, whatever their values.
    """
    finite = np.flatnonzero(np.isfinite(values))
    signed = -values[finite] if largest else values[finite]
    return finite[np.lexsort((signed, np.zeros(len(finite)) if excess is None else excess[finite]))]


def excess_over(table: pyarrow.Table, bounds: Mapping[str, float]) -> Floats:
    """Return how far each row is over its worst bound, as a share of the bound (of 1 where that is 0): 0 where it keeps all.

    Args:
        table: Rows; one without a figure counts as over its bound.
        bounds: Upper bounds by figure.
    """
    found = np.zeros(len(table))
    for name, bound in bounds.items():
        over = (column_of(table, name) - bound) / (abs(bound) or 1.0)
        found = np.maximum(found, np.where(np.isnan(over), np.inf, over))
    return found


def pareto_front(first: Floats, second: Floats) -> Indices:
    """Return the numbers of the rows that no other row beats in one value without being worse in the other, by the first.

    Both values are better the smaller they are. Of rows that are equal in both, the first is returned.

    Args:
        first, second: Shape (n,); rows with a NaN take no part.
    """
    both = np.flatnonzero(np.isfinite(first) & np.isfinite(second))
    order = both[np.lexsort((second[both], first[both]))]
    found, least = [], np.inf
    for row in order:
        if second[row] < least:
            found.append(row)
            least = second[row]
    return np.array(found, np.intp)


def rows_by_program(table: pyarrow.Table) -> dict[str, Indices]:
    """Return the numbers of the rows of each program, in the order in which programs first stand in the table."""
    programs = np.array(table.column("program").to_pylist(), object)
    return {program: np.flatnonzero(programs == program) for program in dict.fromkeys(programs)}


def column_of(table: pyarrow.Table, name: str) -> Floats:
    """Return a column of numbers, shape (rows,); NaN where it has none."""
    return np.array(
        [np.nan if value is None else value for value in table.column(name).to_pylist()], np.float64
    )


def sensitivities_of(drawn: DrawnDesign, table: pyarrow.Table) -> dict[tuple[str, str], list[Sensitivities]]:
    """Return the sensitivities of each figure by program and machine; {} where nothing is varied.

    Args:
        drawn: The design.
        table: Rows; points without one count as failed.
    """
    if not drawn.columns:
        return {}
    points = unit_points(drawn.design, drawn.points, drawn.seed, drawn.shares)
    rows = {key: number for number, key in enumerate(table.column("key").to_pylist())}
    found: dict[tuple[str, str], list[Sensitivities]] = {}
    for group, keys in drawn.groups.items():
        at = np.array([rows.get(key, -1) for key in keys])
        found[group] = []
        for figure in drawn.figures:
            column = np.append(column_of(table, figure), np.nan)  # where no row is, number -1
            found[group].append(
                sensitivities(drawn.design, points, drawn.levels, drawn.columns, figure, column[at])
            )
    return found
