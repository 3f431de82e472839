"""Toolpaths for the tests of smoothing: by hand, and at random over everything that it may meet."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cncgen.geometry.nurbs import concatenate, single
from cncgen.geometry.path import Path
from cncgen.geometry.tables import ArcTable, NurbsTable, empty_arcs, empty_nurbs
from cncgen.toolpath.record import Event, Kind, Toolpath
from cncgen.toolpath.slicing import between


def toolpath(
    start: list,
    end: list,
    kind: list | None = None,
    curve: list | None = None,
    arcs: ArcTable | None = None,
    nurbs: NurbsTable | None = None,
    events: tuple[Event, ...] = (),
    axes: str = "XYZ",
    **columns: object,
) -> Toolpath:
    """Rows of lines at 100 mm/s under G64 P0.01 where nothing else is said; line numbers count from 1."""
    n = len(end)
    given = {"feed": 100.0, "feed_mode": 0, "path_mode": 0, "tolerance": 0.01, **columns}
    return Toolpath(
        axes=axes,
        start=np.asarray(start, float),
        kind=np.asarray(kind if kind is not None else [Kind.LINE] * n, np.int8),
        end=np.asarray(end, float),
        feed=np.broadcast_to(np.asarray(given["feed"], float), n).copy(),
        feed_mode=np.broadcast_to(np.asarray(given["feed_mode"], np.int8), n).copy(),
        path_mode=np.broadcast_to(np.asarray(given["path_mode"], np.int8), n).copy(),
        tolerance=np.broadcast_to(np.asarray(given["tolerance"], float), n).copy(),
        curve=np.asarray(curve if curve is not None else [-1] * n, np.int64),
        line=np.arange(1, n + 1),
        source=np.zeros(n, np.int16),
        arcs=arcs or empty_arcs(),
        nurbs=nurbs or empty_nurbs(len(axes)),
        events=events,
        sources=("test.nc",),
    )


def facets(count: int, length: float = 0.2, **columns: object) -> Toolpath:
    """Short lines along a smooth wavy curve in space."""
    s = np.arange(count + 1) * length
    angle = 1.5 * np.sin(s / 13) + 1.1 * np.sin(s / 5.1 + 1) + 0.4 * np.sin(s / 1.7) + s / 200
    step = length * np.stack([np.cos(angle), np.sin(angle), 0.1 * np.cos(s / 9)], 1)
    points = np.cumsum(step, axis=0).round(4)
    return toolpath(points[0], points[1:], **columns)


def chunked(rows: Toolpath, size: int) -> Iterator[Toolpath]:
    """Cut a toolpath into chunks."""
    for first in range(0, len(rows), size):
        yield between(rows, first, min(first + size, len(rows)))


def path_of(rows: Toolpath) -> Path:
    return Path(rows.axes, rows.start, rows.kind, rows.end, rows.curve, rows.arcs, rows.nurbs)


def random_toolpath(seed: int) -> Toolpath:
    """Facets, corners, reversals, arcs and curves of all sizes, moves of 1e-7 mm and of none, further axes, events, modes,
    feeds."""
    random = np.random.default_rng(seed)
    axes = str(random.choice(["XYZ", "XYZA", "XYZBC", "XYZAU"]))
    style = str(random.choice(["facets", "corners", "mixed"]))
    position, heading = np.zeros(len(axes)), random.uniform(0, 6.28)
    tolerance, feed = 10 ** random.uniform(-4, -0.5), 100.0
    rows: list[tuple] = []
    arcs: list[tuple] = []
    curves: list[NurbsTable] = []
    events: list[Event] = []
    for _ in range(random.integers(2, 50)):
        chance = random.random()
        if chance < 0.06:
            kind, curve, new = Kind.EVENT, len(events), position
            events.append(Event("dwell", dwell_s=0.1) if random.random() < 0.2 else Event("spindle"))
        elif chance < 0.2 and style != "facets":
            kind, curve = Kind.ARC, len(arcs)
            radius, sweep, sense = (
                10 ** random.uniform(-2, 2),
                random.uniform(0.05, 6.2),
                random.choice([-1, 1]),
            )
            tangent = heading if random.random() < 0.6 else random.uniform(0, 6.28)
            inward = np.array([-np.sin(tangent), np.cos(tangent)]) * sense
            centre = position[:2] + radius * inward
            turned = np.arctan2(-inward[1], -inward[0]) + sense * sweep
            new = position.copy()
            new[:2] = centre + radius * np.array([np.cos(turned), np.sin(turned)])
            if random.random() < 0.3:
                new[2:] += random.normal(size=len(axes) - 2)
            arcs.append(([*centre, position[2]], [0, 0, sense], sweep))
            heading = tangent + sense * sweep
        elif chance < 0.27 and style != "facets":
            kind, curve = Kind.NURBS, len(curves)
            curves.append(random_curve(random, position, heading))
            new = curves[-1].control_points[-1]
            heading = float(np.arctan2(*(new - curves[-1].control_points[-2])[1::-1]))
        else:
            kind, curve = Kind.LINE, -1
            small = -7 if random.random() < 0.1 else -2
            length = 10 ** (random.uniform(-1.5, 0) if style == "facets" else random.uniform(small, 2))
            turns = (
                [0.1 * random.normal()]
                if style == "facets"
                else [0, 0.2 * random.normal(), random.uniform(-3.2, 3.2)]
            )
            heading += random.choice(turns)
            new = position.copy()
            new[:2] += length * np.array([np.cos(heading), np.sin(heading)])
            if random.random() < 0.3:
                new[2] += length * random.normal()
            if len(axes) > 3 and random.random() < 0.7:
                new[3:] += 0.02 * length * 10 ** random.uniform(-1, 1) * random.normal(size=len(axes) - 3)
            if random.random() < 0.05:
                new = position.copy()
        if random.random() < 0.1:
            feed = random.uniform(10, 200)
        mode = 0 if random.random() < 0.93 else random.choice([1, 2])
        path_mode = 0 if random.random() < 0.96 else random.choice([1, 2])
        rows.append((kind, curve, new, feed, mode, path_mode, tolerance))
        position = new
        if random.random() < 0.03:
            tolerance = 10 ** random.uniform(-4, -0.5)
    kind, curve, end, feeds, modes, path_modes, tolerances = zip(*rows, strict=True)
    table = ArcTable(
        *(
            np.array([a[k] for a in arcs], float).reshape(shape)
            for k, shape in ((0, (-1, 3)), (1, (-1, 3)), (2, (-1,)))
        )
    )
    return toolpath(
        [0.0] * len(axes), list(end), list(kind), list(curve), table,
        concatenate(curves) if curves else None, tuple(events), axes,
        feed=feeds, feed_mode=modes, path_mode=path_modes, tolerance=tolerances,
    )  # fmt: skip


def random_curve(random: np.random.Generator, start: np.ndarray, heading: float) -> NurbsTable:
    """A NURBS of degree 2 to 4 with or without weights, that goes on tangentially or not."""
    degree = int(random.integers(2, 5))
    count = degree + 1 + int(random.integers(0, 4))
    size = 10 ** random.uniform(-1.5, 1.5)
    turns = random.normal(scale=0.5, size=count - 1)
    turns[0] = 0.0 if random.random() < 0.5 else random.uniform(-3, 3)
    angle = heading + np.cumsum(turns)
    steps = np.zeros((count - 1, len(start)))
    steps[:, :2] = size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if random.random() < 0.3:
        steps[:, 2:] = 0.1 * size * random.normal(size=(count - 1, len(start) - 2))
    knots = np.concatenate([np.zeros(degree), np.linspace(0, 1, count - degree + 1), np.ones(degree)])
    weights = random.uniform(0.5, 2, count) if random.random() < 0.5 else None
    return single(degree, knots, np.concatenate([start[None], start + np.cumsum(steps, axis=0)]), weights)
