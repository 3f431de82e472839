"""Toolpaths and machines that the planner's tests run on, made by hand or read from `programs/`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.geometry.tables import ArcTable, NurbsTable, empty_arcs, empty_nurbs
from cncgen.machine import Machine, load
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath

PROGRAMS = Path(__file__).parents[2] / "programs"


def toolpath_of(
    points: Sequence[Sequence[float]],
    feed: float = 100.0,
    mode: PathMode = PathMode.EXACT_PATH,
    axes: str = "XYZ",
    events: dict[int, Event] | None = None,
    feed_mode: FeedMode = FeedMode.SPEED,
) -> Toolpath:
    """Make lines from point to point at `feed` mm/s; `events` puts an event after that many lines."""
    x = np.array(points, float)
    x = np.concatenate([x, np.zeros((len(x), len(axes) - x.shape[1]))], axis=1)
    kind, end, curve, line, happened = [], [], [], [], []
    for i in range(len(x)):
        if i:
            kind.append(Kind.LINE), end.append(x[i]), curve.append(-1), line.append(i)
        if events and i in events:
            kind.append(Kind.EVENT), end.append(x[i]), curve.append(len(happened)), line.append(100 + i)
            happened.append(events[i])
    n = len(kind)
    return Toolpath(
        axes=axes,
        start=x[0],
        kind=np.array(kind, np.int8),
        end=np.array(end).reshape(n, len(axes)),
        feed=np.where(np.array(kind) == Kind.EVENT, np.nan, feed),
        feed_mode=np.full(n, feed_mode, np.int8),
        path_mode=np.full(n, mode, np.int8),
        tolerance=np.full(n, np.nan),
        curve=np.array(curve, np.int64),
        line=np.array(line, np.int64),
        source=np.zeros(n, np.int16),
        arcs=empty_arcs(),
        nurbs=empty_nurbs(len(axes)),
        events=tuple(happened),
        sources=("test.nc",),
    )


def one_curve(kind: Kind, start: np.ndarray, end: np.ndarray, feed: float, **tables: object) -> Toolpath:
    """Make a toolpath of one arc or NURBS row in X Y Z."""
    made = toolpath_of([start, end], feed)
    return replace(made, kind=np.array([kind], np.int8), curve=np.zeros(1, np.int64), **tables)


def arc_of(radius: float, sweep: float, feed: float) -> Toolpath:
    """Make an arc about the origin in X Y that starts at (radius, 0)."""
    table = ArcTable(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([sweep]))
    end = radius * np.array([np.cos(sweep), np.sin(sweep), 0.0])
    return one_curve(Kind.ARC, np.array([radius, 0.0, 0.0]), end, feed, arcs=table)


def nurbs_of(
    points: Sequence[Sequence[float]], feed: float, knots: Sequence[float] | None = None
) -> Toolpath:
    """Make a cubic B-spline in X Y with uniform knots inside, unless they are given."""
    p = np.array(points, float)
    p = np.concatenate([p, np.zeros((len(p), 3 - p.shape[1]))], axis=1)
    n = len(p)
    u = knots if knots is not None else [0.0] * 3 + list(np.linspace(0.0, 1.0, n - 2)) + [1.0] * 3
    table = NurbsTable(
        np.array([3]), np.array([0, n]), np.array([0, n + 4]), p, np.ones(n), np.array(u, float)
    )
    return one_curve(Kind.NURBS, p[0], p[-1], feed, nurbs=table)


def program_of(name: str, feed_mm_min: float | None = None) -> list[Toolpath]:
    """Read a program of `programs/`, with its feed replaced where one is given."""
    from cncgen.pipeline import read

    chunks = list(read(PROGRAMS / name).chunks())
    if feed_mm_min is None:
        return chunks
    return [replace(c, feed=np.where(np.isnan(c.feed), np.nan, feed_mm_min / 60.0)) for c in chunks]


@pytest.fixture
def lines() -> Callable[..., Toolpath]:
    """Return `toolpath_of`."""
    return toolpath_of


@pytest.fixture
def arc() -> Callable[..., Toolpath]:
    """Return `arc_of`."""
    return arc_of


@pytest.fixture
def nurbs() -> Callable[..., Toolpath]:
    """Return `nurbs_of`."""
    return nurbs_of


@pytest.fixture
def program() -> Callable[..., list[Toolpath]]:
    """Return `program_of`."""
    return program_of


@pytest.fixture
def table() -> Machine:
    """Return the X-Y table of Tsai 2010, without its bound on the contour error."""
    return replace(load("xy-table"), max_contour_error_mm=None)


@pytest.fixture
def bounded_table() -> Machine:
    """Return the X-Y table of Tsai 2010."""
    return load("xy-table")


@pytest.fixture
def mill() -> Machine:
    """Return the generic mill."""
    return load("generic-mill")


@pytest.fixture
def bonder() -> Machine:
    """Return the die bonder of Yeh and Sun 2008."""
    return load("die-bonder")
