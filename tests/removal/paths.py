"""Small toolpaths for tests."""

import numpy as np

from cncgen.geometry.tables import ArcTable
from cncgen.toolpath.building import RowBuilder, ToolpathBuilder
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode


def line(x, y, z, rapid=False):
    return ("line", (x, y, z), rapid)


def arc(end, centre, sweep):
    return ("arc", end, centre, sweep)


def event(name, **values):
    return ("event", name, values)


def path_of(start, *moves, feed=10.0):
    """Return a toolpath: lines, arcs against the clock about Z, events. Moves are numbered as lines, from 1."""
    builder = ToolpathBuilder("XYZ", np.array(start, float), ["t.nc"])
    builder.event(Event("spindle", values={"speed_rpm": 1000.0, "direction": 1}), 0, 0)
    for number, (kind, *rest) in enumerate(moves, start=1):
        if kind == "event":
            builder.event(Event(rest[0], values=rest[1]), number, 0)
            continue
        rapid = kind == "line" and rest[1]
        arcs = None
        if kind == "arc":
            arcs = ArcTable(np.array([rest[1]], float), np.array([[0, 0, 1.0]]), np.array([rest[2]]))
        builder.add(
            RowBuilder(
                kind=np.array([Kind.ARC if kind == "arc" else Kind.LINE], np.int8),
                end=np.array([rest[0]], float),
                feed=np.array([np.nan if rapid else feed]),
                feed_mode=np.array([FeedMode.RAPID if rapid else FeedMode.SPEED], np.int8),
                curve=np.array([0 if kind == "arc" else -1]),
                line=np.array([number]),
                path_mode=PathMode.CONTINUOUS,
                tolerance=np.nan,
                source=0,
                arcs=arcs,
            )
        )
    return builder.take()
