"""A toolpath cut into blocks of a fixed number of rows, however it arrives: what is planned does not depend on it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from cncgen.geometry import nurbs
from cncgen.geometry.tables import ArcTable
from cncgen.toolpath.record import Kind, Toolpath


def blocks(chunks: Iterable[Toolpath], rows: int) -> Iterator[Toolpath]:
    """Yield toolpaths of `rows` rows each, the last one shorter; chunks without rows vanish."""
    held: list[Toolpath] = []
    count = 0
    for chunk in chunks:
        first = 0
        while count + len(chunk) - first >= rows:
            last = first + rows - count
            yield joined([*held, cut(chunk, first, last)])
            held, count, first = [], 0, last
        if first < len(chunk):
            held.append(cut(chunk, first, len(chunk)))
            count += len(chunk) - first
    if held:
        yield joined(held)


def cut(toolpath: Toolpath, first: int, last: int) -> Toolpath:
    """Return rows `first` to `last` − 1 with the curves that they use."""
    if first == 0 and last == len(toolpath):
        return toolpath
    rows = slice(first, last)
    t = toolpath
    curve = t.curve[rows].copy()
    arc, spline = t.kind[rows] == Kind.ARC, t.kind[rows] == Kind.NURBS
    arcs = ArcTable(*(column[curve[arc]] for column in (t.arcs.centre, t.arcs.normal, t.arcs.sweep)))
    splines = nurbs.take(t.nurbs, curve[spline])
    curve[arc], curve[spline] = np.arange(len(arcs)), np.arange(len(splines))
    return replace(
        t,
        start=t.end[first - 1] if first else t.start,
        kind=t.kind[rows],
        end=t.end[rows],
        feed=t.feed[rows],
        feed_mode=t.feed_mode[rows],
        path_mode=t.path_mode[rows],
        tolerance=t.tolerance[rows],
        curve=curve,
        line=t.line[rows],
        source=t.source[rows],
        arcs=arcs,
        nurbs=splines,
    )


def joined(parts: Sequence[Toolpath]) -> Toolpath:
    """Return the rows of several toolpaths of the same axes as one."""
    if len(parts) == 1:
        return parts[0]
    curves = []
    arcs = splines = events = 0
    for part in parts:
        base = np.zeros(len(part), np.int64)
        for kind, offset in ((Kind.ARC, arcs), (Kind.NURBS, splines), (Kind.EVENT, events)):
            base[part.kind == kind] = offset
        curves.append(part.curve + base)
        arcs, splines, events = arcs + len(part.arcs), splines + len(part.nurbs), events + len(part.events)

    def column(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts])

    return replace(
        parts[0],
        kind=column("kind"),
        end=column("end"),
        feed=column("feed"),
        feed_mode=column("feed_mode"),
        path_mode=column("path_mode"),
        tolerance=column("tolerance"),
        curve=np.concatenate(curves),
        line=column("line"),
        source=column("source"),
        arcs=ArcTable(
            *(
                np.concatenate([getattr(part.arcs, name) for part in parts])
                for name in ("centre", "normal", "sweep")
            )
        ),
        nurbs=nurbs.concatenate([part.nurbs for part in parts]),
        events=tuple(event for part in parts for event in part.events),
        sources=max((part.sources for part in parts), key=len),
    )
