"""Growing a toolpath: rows in machine coordinates go in, chunks of `Toolpath` come out."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.nurbs import concatenate
from cncgen.geometry.tables import ArcTable, NurbsTable, empty_arcs, empty_nurbs
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RowBuilder:
    """A stretch of rows with one path mode, tolerance, lever and source; see `Toolpath` for shapes and units.

    `curve` counts from 0 within `arcs` (ARC rows) and `nurbs` (NURBS rows).
    """

    kind: NDArray[np.int8]
    end: Floats
    feed: Floats
    feed_mode: NDArray[np.int8]
    curve: NDArray[np.int64]
    line: NDArray[np.int64]
    path_mode: PathMode
    tolerance: float
    source: int
    arcs: ArcTable | None = None
    nurbs: NurbsTable | None = None
    lever: float = 0.0


@dataclass(slots=True)
class ToolpathBuilder:
    """Collects rows and events of a program; `take` makes a chunk of them.

    Attributes:
        axes: Letters of the columns.
        position: Where the last row ended, mm or rad.
        sources: Names of the files, the program first; may grow.
        count: Rows collected since the last chunk.
    """

    axes: str
    position: Floats
    sources: list[str]
    count: int = 0
    _rows: list[RowBuilder] = field(default_factory=list)
    _events: list[Event] = field(default_factory=list)
    _start: Floats | None = None

    def place(self, position: Floats) -> None:
        """Start at `position`; before the first row only."""
        self.position = position

    def add(self, rows: RowBuilder) -> None:
        """Append rows; lines of no length are left out (they neither move nor take time)."""
        rows = self._without_idle(rows)
        if not len(rows.kind):
            return
        if self._start is None:
            self._start = self.position
        self._rows.append(rows)
        self.position = rows.end[-1].copy()
        self.count += len(rows.kind)

    def retrace(self, position: Floats) -> None:
        """Append the last row, a line, again, back to `position`."""
        last = self._rows[-1]
        self.add(
            replace(
                last,
                kind=last.kind[-1:],
                end=position[None, :],
                feed=last.feed[-1:],
                feed_mode=last.feed_mode[-1:],
                curve=last.curve[-1:],
                line=last.line[-1:],
                arcs=None,
                nurbs=None,
            )
        )

    def event(self, event: Event, line: int, source: int) -> None:
        """Append an event at the present position."""
        one = np.ones(1)
        self.add(
            RowBuilder(
                kind=np.array([Kind.EVENT], np.int8),
                end=self.position[None, :],
                feed=one * np.nan,
                feed_mode=np.array([FeedMode.RAPID], np.int8),
                curve=np.array([len(self._events)], np.int64),
                line=np.array([line], np.int64),
                path_mode=PathMode.CONTINUOUS,
                tolerance=np.nan,
                source=source,
            )
        )
        self._events.append(event)

    def _without_idle(self, rows: RowBuilder) -> RowBuilder:
        starts = np.concatenate([self.position[None, :], rows.end[:-1]])
        keep = (rows.kind != Kind.LINE) | (rows.end != starts).any(axis=1)
        if keep.all():
            return rows
        return replace(
            rows,
            kind=rows.kind[keep],
            end=rows.end[keep],
            feed=rows.feed[keep],
            feed_mode=rows.feed_mode[keep],
            curve=rows.curve[keep],
            line=rows.line[keep],
        )

    def take(self) -> Toolpath:
        """Return what was collected as a chunk and start the next one."""
        rows = self._rows
        width = len(self.axes)
        counts = [len(r.kind) for r in rows]

        def join(name: str, empty: Any) -> Any:
            return np.concatenate([getattr(r, name) for r in rows]) if rows else empty

        def spread(values: list[Any], kind: type[np.generic]) -> Any:
            return np.repeat(np.array(values, kind), counts)

        start = self._start if self._start is not None else self.position
        chunk = Toolpath(
            axes=self.axes,
            start=start,
            kind=join("kind", np.zeros(0, np.int8)),
            end=join("end", np.zeros((0, width))),
            feed=join("feed", np.zeros(0)),
            feed_mode=join("feed_mode", np.zeros(0, np.int8)),
            path_mode=spread([r.path_mode for r in rows], np.int8),
            tolerance=spread([r.tolerance for r in rows], np.float64),
            curve=_shifted_curves(rows),
            line=join("line", np.zeros(0, np.int64)),
            source=spread([r.source for r in rows], np.int16),
            arcs=join_arcs([r.arcs for r in rows if r.arcs is not None]),
            nurbs=join_nurbs([r.nurbs for r in rows if r.nurbs is not None], width),
            events=tuple(self._events),
            sources=tuple(self.sources),
            lever=spread([r.lever for r in rows], np.float64) if any(r.lever for r in rows) else None,
        )
        self._rows, self._events, self._start, self.count = [], [], None, 0
        return chunk


def _shifted_curves(rows: list[RowBuilder]) -> NDArray[np.int64]:
    """Return the curve column with the indices of each stretch moved behind those before it."""
    arcs = curves = 0
    out = [np.zeros(0, np.int64)]
    for stretch in rows:
        column = stretch.curve
        if stretch.arcs is not None and arcs:
            column = np.where(stretch.kind == Kind.ARC, column + arcs, column)
        if stretch.nurbs is not None and curves:
            column = np.where(stretch.kind == Kind.NURBS, column + curves, column)
        arcs += len(stretch.arcs) if stretch.arcs is not None else 0
        curves += len(stretch.nurbs) if stretch.nurbs is not None else 0
        out.append(column)
    return np.concatenate(out)


def join_arcs(tables: list[ArcTable]) -> ArcTable:
    """Return one table of the arcs of several."""
    if not tables:
        return empty_arcs()
    return ArcTable(
        np.concatenate([t.centre for t in tables]),
        np.concatenate([t.normal for t in tables]),
        np.concatenate([t.sweep for t in tables]),
    )


def join_nurbs(tables: list[NurbsTable], width: int) -> NurbsTable:
    """Return one table of the curves of several, all of `width` axes."""
    return concatenate(tables) if tables else empty_nurbs(width)
