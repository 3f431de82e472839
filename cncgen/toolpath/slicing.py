"""Cutting toolpaths into stretches of rows, and joining them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import nurbs
from cncgen.geometry.tables import ArcTable
from cncgen.toolpath.building import join_arcs, join_nurbs
from cncgen.toolpath.record import Kind, Toolpath


def between(toolpath: Toolpath, first: int, last: int) -> Toolpath:
    """Return the rows `first` up to `last` (not with it), with those curves and events alone that they point to."""
    rows = _chosen(toolpath, slice(first, last))
    return replace(rows, start=toolpath.start if first == 0 else toolpath.end[first - 1])


def chosen(toolpath: Toolpath, rows: NDArray[np.int64], start: NDArray[np.float64]) -> Toolpath:
    """Return rows in the order given, the first of which begins at `start`, with those curves and events alone that they point to."""
    return replace(_chosen(toolpath, rows), start=start)


def _chosen(toolpath: Toolpath, rows: slice | NDArray[np.int64]) -> Toolpath:
    """Return rows with their curves and events, and the start of the toolpath."""
    columns = toolpath.columns(rows)
    kind, curve = columns["kind"], columns["curve"].copy()
    arcs, table, events = toolpath.arcs, toolpath.nurbs, toolpath.events
    picked = {which: np.flatnonzero(kind == which) for which in (Kind.ARC, Kind.NURBS, Kind.EVENT)}
    index = curve[picked[Kind.ARC]]
    arcs = ArcTable(arcs.centre[index], arcs.normal[index], arcs.sweep[index])
    table = nurbs.take(table, curve[picked[Kind.NURBS]])
    events = tuple(events[k] for k in curve[picked[Kind.EVENT]])
    for where in picked.values():
        curve[where] = np.arange(len(where))
    return replace(toolpath, arcs=arcs, nurbs=table, events=events, **(columns | {"curve": curve}))


def join(toolpaths: list[Toolpath]) -> Toolpath:
    """Return one toolpath of the rows of several that follow each other; at least one, all with the same axes."""
    if len(toolpaths) == 1:
        return toolpaths[0]
    last = toolpaths[-1]
    sizes = {
        Kind.ARC: [len(t.arcs) for t in toolpaths],
        Kind.NURBS: [len(t.nurbs) for t in toolpaths],
        Kind.EVENT: [len(t.events) for t in toolpaths],
    }
    before = {kind: np.cumsum([0, *counts])[:-1] for kind, counts in sizes.items()}
    curves = []
    for n, part in enumerate(toolpaths):
        curve = part.curve.copy()
        for kind, offset in before.items():
            curve[part.kind == kind] += offset[n]
        curves.append(curve)

    columns: dict[str, Any] = {
        name: np.concatenate([getattr(t, name) for t in toolpaths]) for name in Toolpath.COLUMNS
    }
    if any(t.chord_room is not None for t in toolpaths):
        columns["chord_room"] = np.concatenate([t.chord_tolerance for t in toolpaths])
    if any(t.lever is not None for t in toolpaths):
        columns["lever"] = np.concatenate(
            [np.zeros(len(t)) if t.lever is None else t.lever for t in toolpaths]
        )
    return replace(
        last,
        start=toolpaths[0].start,
        arcs=join_arcs([t.arcs for t in toolpaths]),
        nurbs=join_nurbs([t.nurbs for t in toolpaths], len(last.axes)),
        events=tuple(event for t in toolpaths for event in t.events),
        **(columns | {"curve": np.concatenate(curves)}),
    )
