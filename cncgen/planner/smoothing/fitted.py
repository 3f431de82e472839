"""Runs of short lines as cubic NURBS curves, one row a run. `cncgen convert` writes them as G6.2, `plan --fit` plans them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.fitting import fit_run
from cncgen.geometry.tables import empty_arcs
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.smoothing.runs import classify
from cncgen.toolpath.record import FeedMode, Kind, Toolpath
from cncgen.toolpath.slicing import between, join

#: Lines that a run has at least; fewer stay lines.
LEAST_ROWS = 4
#: Lines that one curve stands for at most; bounds the memory.
MOST_ROWS = 4096
#: cos of the turn (30°) from which a corner is meant, and two curves meet in it.
_CORNER = 0.866


def fit_runs(chunks: Iterable[Toolpath], tolerance_mm: float) -> Iterator[Toolpath]:
    """Replace runs of LINE rows of one feed by cubic NURBS rows within a tolerance.

    Corners of more than 30°, rapids, arcs and events end a run; runs of fewer than `LEAST_ROWS` stay as they are.
    Rows of G93 stay too: each has a time of its own, and one curve has one speed.

    Args:
        chunks: Consecutive stretches of one program.
        tolerance_mm: Largest distance, over all axes, one degree counted as one millimetre.

    Yields:
        Stretches of the program with the curves in place; the line of a curve is that of its first row.

    Raises:
        ValueError: If the tolerance is not positive.
        CorridorError: If a run could not be fitted.
    """
    held: list[Toolpath] = []
    for chunk in chunks:
        rows = join([*held, chunk])
        borders = _borders(rows, tolerance_mm)
        keep = int(borders[-2]) if len(borders) > 1 else 0
        if keep:
            yield join([_fitted(rows, a, b, tolerance_mm) for a, b in _runs(borders[:-1])])
        held = [between(rows, keep, len(rows))] if keep < len(rows) else []
    if held:
        borders = _borders(held[0], tolerance_mm)
        yield join([_fitted(held[0], a, b, tolerance_mm) for a, b in _runs(borders)])


def _runs(borders: NDArray[np.int64]) -> list[tuple[int, int]]:
    return list(zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True))


def _borders(rows: Toolpath, tolerance: float) -> NDArray[np.int64]:
    """Return where runs begin, 0 and the number of rows among them."""
    scale = axis_scale(rows.axes, rows.degree_mm)
    n = len(rows)
    asked = replace(rows, path_mode=np.zeros(n, np.int8), tolerance=np.full(n, tolerance))
    classes = classify(asked, rows.path, scale)
    fits = classes.fits & (rows.kind == Kind.LINE) & (rows.feed_mode == FeedMode.SPEED)
    split = np.ones(n, bool)
    turn = np.einsum("ij,ij->i", classes.leave[:-1, :3], classes.entry[1:, :3])
    same = (rows.feed[1:] == rows.feed[:-1]) & (rows.feed_mode[1:] == rows.feed_mode[:-1])
    split[1:] = ~(fits[1:] & fits[:-1] & same & (turn > _CORNER))
    first = np.flatnonzero(split)
    sizes = np.diff(np.append(first, n))
    # A run longer than one curve may be is cut into equal parts from its start.
    parts = [np.arange(a, a + size, MOST_ROWS) for a, size in zip(first, sizes, strict=True)]
    return np.append(np.concatenate(parts), n).astype(np.int64) if parts else np.zeros(1, np.int64)


def _fitted(rows: Toolpath, first: int, last: int, tolerance: float) -> Toolpath:
    """Return the rows first … last as one curve, or as they are if they do not make a run."""
    part = between(rows, first, last)
    if last - first < LEAST_ROWS:
        return part
    table = fit_run(part.path, tolerance, axis_scale(part.axes, part.degree_mm))
    one = part.columns(slice(0, 1)) | {"end": part.end[-1:], "curve": np.zeros(1, np.int64)}
    one["kind"] = np.array([Kind.NURBS], np.int8)
    return replace(part, arcs=empty_arcs(), nurbs=table, events=(), **one)
