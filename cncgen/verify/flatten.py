"""The programmed path as a polyline, by the verifier's own means: no line of the planner's geometry is used here.

Arcs are rotated vectors, NURBS go through scipy's BSpline in homogeneous coordinates; both are cut until the chord
is within `CHORD_MM` of the curve. Rotary axes count one degree as one millimetre, as controls do.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.toolpath.record import Kind, PathMode, Toolpath
from cncgen.units import to_file

Floats = NDArray[np.float64]

#: Distance of the polyline from the curve.
CHORD_MM = 1e-6

#: Halvings of a NURBS piece at most; a piece of a metre is then 1e-6 mm long.
_MAX_HALVINGS = 30


@dataclass(frozen=True, slots=True)
class Polyline:
    """The programmed path, `m` segments.

    Attributes:
        axes: Letters of the columns.
        points: Shape (m + 1, axes), mm and degrees.
        line: Shape (m,), source line of each segment.
        tolerance: Shape (m,), mm: how far setpoints may be from the segment.
        source: Shape (m,), index into `sources`.
        sources: Names of the files that lines refer to.
    """

    axes: str
    points: Floats
    line: NDArray[np.int64]
    tolerance: Floats
    source: NDArray[np.int16]
    sources: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.line)

    @property
    def lengths(self) -> Floats:
        """Shape (m + 1,): length up to each point."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])


def flatten(
    toolpaths: Iterable[Toolpath], machine: Machine, tolerance_mm: float | None = None
) -> Polyline | None:
    """Flatten a program; one that only waits is a segment of no length, None is said of one without a row.

    Args:
        toolpaths: Consecutive stretches of the program.
        machine: Gives the tolerance where the program gives none, and the chord tolerance.
        tolerance_mm: Tolerance of every continuous motion, over what the program says.
    """
    pieces: list[Floats] = []
    lines: list[NDArray] = []
    tolerances: list[Floats] = []
    sources: list[NDArray] = []
    names: tuple[str, ...] = ()
    axes = ""
    for toolpath in toolpaths:
        if not pieces and len(toolpath):
            first = toolpath
            pieces.append(_scaled(toolpath.start[None, :], toolpath.axes))
        points, rows = _flatten_rows(toolpath)
        pieces.append(_scaled(points, toolpath.axes))
        lines.append(toolpath.line[rows])
        sources.append(toolpath.source[rows])
        tolerances.append(_tolerance(toolpath, machine, tolerance_mm)[rows])
        axes, names = toolpath.axes, toolpath.sources
    if not pieces:
        return None
    if not sum(map(len, lines)):
        pieces.append(pieces[0])
        lines, sources = [np.array([first.line[0]])], [np.array([first.source[0]])]
        tolerances = [np.array([machine.chord_tolerance_mm])]
    return Polyline(
        axes,
        np.ascontiguousarray(np.concatenate(pieces)),
        np.concatenate(lines),
        np.concatenate(tolerances),
        np.concatenate(sources),
        names,
    )


def _scaled(points: Floats, axes: str) -> Floats:
    return points * np.array([to_file(axis) for axis in axes])


def _tolerance(toolpath: Toolpath, machine: Machine, tolerance_mm: float | None) -> Floats:
    """Return the tolerance in force on each row; never less than the chord between two setpoints may take."""
    given = np.where(np.isnan(toolpath.tolerance), machine.path_tolerance_mm, toolpath.tolerance)
    if tolerance_mm is not None:
        given = np.full_like(given, tolerance_mm)
    continuous = toolpath.path_mode == PathMode.CONTINUOUS
    return np.maximum(np.where(continuous, given, 0.0), machine.chord_tolerance_mm)


def _flatten_rows(toolpath: Toolpath) -> tuple[Floats, NDArray[np.int64]]:
    """Return the points after the start, and the row of each."""
    curved = np.flatnonzero((toolpath.kind == Kind.ARC) | (toolpath.kind == Kind.NURBS))
    starts = toolpath.starts
    points: list[Floats] = []
    rows: list[NDArray[np.int64]] = []
    after = 0
    for row in (*curved, len(toolpath)):
        straight = np.arange(after, row)[toolpath.kind[after:row] == Kind.LINE]
        points.append(toolpath.end[straight])
        rows.append(straight)
        if row < len(toolpath):
            shape = _arc if toolpath.kind[row] == Kind.ARC else _nurbs
            cut = shape(toolpath, row, starts[row])
            points.append(cut)
            rows.append(np.full(len(cut), row))
        after = row + 1
    return np.concatenate(points), np.concatenate(rows)


def _arc(toolpath: Toolpath, row: int, start: Floats) -> Floats:
    """Cut an arc or helix: the radius vector turned about the axis, the rest linear in the angle."""
    arcs, curve, end = toolpath.arcs, toolpath.curve[row], toolpath.end[row]
    centre, normal, sweep = arcs.centre[curve], arcs.normal[curve], float(arcs.sweep[curve])
    first = start[:3] - centre
    first_height = first @ normal
    first = first - first_height * normal
    last = end[:3] - centre
    last_height = last @ normal
    last = last - last_height * normal
    r0, r1 = float(np.linalg.norm(first)), float(np.linalg.norm(last))
    radius = max(r0, r1, CHORD_MM)
    step = 2.0 * np.arccos(max(1.0 - CHORD_MM / radius, -1.0))
    count = max(int(np.ceil(abs(sweep) / step)), 1)
    f = np.linspace(0.0, 1.0, count + 1)[1:, None]
    u = first / r0 if r0 > 0 else first
    w = np.cross(normal, u)
    around = (r0 + f * (r1 - r0)) * (np.cos(f * sweep) * u + np.sin(f * sweep) * w)
    along = (first_height + f * (last_height - first_height)) * normal
    rest = start[3:] + f * (end[3:] - start[3:])
    points = np.concatenate([centre + around + along, rest], axis=1)
    points[-1] = end
    return points


def _nurbs(toolpath: Toolpath, row: int, start: Floats) -> Floats:
    """Cut a rational B-spline: halve every piece whose middle is too far from its chord."""
    from scipy.interpolate import BSpline

    table, i = toolpath.nurbs, toolpath.curve[row]
    degree = int(table.degree[i])
    knots = table.knots[table.knot_offset[i] : table.knot_offset[i + 1]]
    between = slice(table.point_offset[i], table.point_offset[i + 1])
    weights = table.weights[between]
    homogeneous = np.column_stack([table.control_points[between] * weights[:, None], weights])
    spline = BSpline(knots, homogeneous, degree)

    def at(u: Floats) -> Floats:
        x = spline(u)
        return x[:, :-1] / x[:, -1:]

    spans = np.unique(knots[degree : len(knots) - degree])
    pieces = [np.linspace(a, b, 8 * degree, endpoint=False) for a, b in itertools.pairwise(spans)]
    u = np.concatenate([*pieces, spans[-1:]])
    x = at(u)
    open_ = np.ones(len(u) - 1, bool)
    for _ in range(_MAX_HALVINGS):
        index = np.flatnonzero(open_)
        if not len(index):
            break
        middle = 0.5 * (u[index] + u[index + 1])
        point = at(middle)
        # Half-way along a smooth piece the curve is farthest from its chord, or nearly so.
        bad = _chord_distance(point, x[index], x[index + 1]) > 0.5 * CHORD_MM
        open_ = np.zeros(len(u) - 1, bool)
        open_[index[bad]] = True
        u, x, open_ = _insert(u, x, open_, index[bad], middle[bad], point[bad])
    x[-1] = toolpath.end[row]
    return x[1:]


def _insert(
    u: Floats, x: Floats, open_: NDArray[np.bool_], at: NDArray, middle: Floats, point: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Put a point into the middle of pieces `at`; both halves of each are open."""
    return np.insert(u, at + 1, middle), np.insert(x, at + 1, point, axis=0), np.insert(open_, at + 1, True)


def _chord_distance(point: Floats, a: Floats, b: Floats) -> Floats:
    chord = b - a
    size = np.maximum((chord**2).sum(axis=1), 1e-300)
    f = np.clip(((point - a) * chord).sum(axis=1) / size, 0.0, 1.0)
    return np.linalg.norm(point - a - f[:, None] * chord, axis=1)
