"""Small programs and motions with closed forms."""

from __future__ import annotations

import numpy as np

from cncgen.geometry.tables import ArcTable, NurbsTable, empty_arcs, empty_nurbs
from cncgen.machine import Axis, Machine
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.stream import SetpointStream
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath


def toolpath(
    start: list[float],
    rows: list[tuple[Kind, list[float], int]],
    *,
    arcs: ArcTable | None = None,
    nurbs: NurbsTable | None = None,
    mode: PathMode = PathMode.CONTINUOUS,
    tolerance: float = 0.01,
    axes: str = "XYZ",
) -> Toolpath:
    """Build a toolpath of rows (kind, end, curve); lines count from 1."""
    n = len(rows)
    return Toolpath(
        axes=axes,
        start=np.array(start, float),
        kind=np.array([kind for kind, _, _ in rows], np.int8),
        end=np.array([end for _, end, _ in rows], float).reshape(n, len(axes)),
        feed=np.full(n, 100.0),
        feed_mode=np.full(n, FeedMode.SPEED, np.int8),
        path_mode=np.full(n, mode, np.int8),
        tolerance=np.full(n, tolerance),
        curve=np.array([curve for _, _, curve in rows], np.int64),
        line=np.arange(1, n + 1),
        source=np.zeros(n, np.int16),
        arcs=arcs or empty_arcs(),
        nurbs=nurbs or empty_nurbs(len(axes)),
        events=(),
        sources=("part.nc",),
    )


def polyline(*points: list[float], tolerance: float = 0.01, mode: PathMode = PathMode.CONTINUOUS) -> Toolpath:
    """Build a toolpath of lines."""
    rows = [(Kind.LINE, point, -1) for point in points[1:]]
    return toolpath(points[0], rows, tolerance=tolerance, mode=mode)


def circle(radius: float, turns: float = 1.0, tolerance: float = 0.01) -> Toolpath:
    """Build a toolpath of one circle about the origin from (radius, 0), counter-clockwise."""
    sweep = 2 * np.pi * turns
    arcs = ArcTable(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([sweep]))
    end = [radius * np.cos(sweep), radius * np.sin(sweep), 0.0]
    return toolpath([radius, 0.0, 0.0], [(Kind.ARC, end, 0)], arcs=arcs, tolerance=tolerance)


def machine(velocity: float = 100.0, acceleration: float = 1000.0, jerk: float = 50_000.0) -> Machine:
    """Build a machine of three equal axes, ±500 mm, 1 ms, chord error 1 µm."""
    axes = {k: Axis(k, velocity, acceleration, jerk, (-500.0, 500.0)) for k in "XYZ"}
    return Machine("test", axes)


def stream(position: np.ndarray, axes: str = "XYZ", period_s: float = 0.001) -> SetpointStream:
    """Wrap positions as a stream of one chunk."""
    chunk = Setpoints(axes, period_s, 0, np.ascontiguousarray(position, float))
    return SetpointStream("test", axes, period_s, iter([chunk]))


def smooth(length: float, time_s: float, period_s: float = 0.001) -> np.ndarray:
    """Return s(t) = L (τ − sin 2πτ / 2π), τ = t / T, every period, rest at both ends.

    Peaks: velocity 2 L / T, acceleration 2π L / T², jerk 4π² L / T³.
    """
    tau = np.arange(round(time_s / period_s) + 1) * period_s / time_s
    return length * (tau - np.sin(2 * np.pi * tau) / (2 * np.pi))
