"""The programmed path as a polyline, by the verifier's own means: no line of the planner's geometry is used here.

Arcs are rotated vectors, NURBS go through scipy's BSpline in homogeneous coordinates; both are cut until the chord
is within `chord_mm` of the curve. Rotary axes count one degree as one millimetre, as controls do.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.toolpath.record import Kind, PathMode, Toolpath
from cncgen.units import to_file

Floats = NDArray[np.float64]

#: Distance of the polyline from the curve, at least, and as a part of the tolerance.
CHORD_MM, CHORD_PART = 1e-6, 1e-4

#: Turn of an arc's piece at most.
_TURN = np.pi / 8

#: Points of a stretch at least, as far as there are so many; a NURBS is cut whole.
_AT_LEAST = 1 << 15

#: Halvings of a NURBS piece at most; a piece of a metre is then 1e-6 mm long.
_MAX_HALVINGS = 30


@dataclass(frozen=True, slots=True)
class FlatPath:
    """A stretch of the programmed path, `m` segments.

    Attributes:
        axes: Letters of the columns.
        points: Shape (m + 1, axes), mm and degrees.
        line: Shape (m,), source line of each segment.
        tolerance: Shape (m,), mm: how far setpoints may be from the segment.
        wait_s: Shape (m,): how long the axes have to stand at its end. A wait is a segment of no length.
    """

    axes: str
    points: Floats
    line: NDArray[np.int64]
    tolerance: Floats
    wait_s: Floats

    def __len__(self) -> int:
        return len(self.line)

    def restricted(self, columns: list[int], scale: Floats | float = 1.0) -> FlatPath:
        """Return some columns of it, scaled."""
        points = np.ascontiguousarray(self.points[:, columns] * scale)
        axes = "".join(self.axes[k] for k in columns)
        return replace(self, axes=axes, points=points)


def chord_mm(tolerance: Floats | float) -> Floats:
    """Return how far the polyline is from the curve where the tolerance is this, mm."""
    return np.maximum(CHORD_PART * np.asarray(tolerance), CHORD_MM)


def flatten(
    toolpaths: Iterable[Toolpath], machine: Machine, tolerance_mm: float | None = None
) -> Iterator[FlatPath]:
    """Flatten a program, stretch by stretch; one that only stands somewhere is a segment of no length.

    Args:
        toolpaths: Consecutive stretches of the program.
        machine: Gives the tolerance where the program gives none, and the chord tolerance.
        tolerance_mm: Tolerance of every continuous motion, over what the program says.

    Yields:
        Stretches of one segment at least, each from where the one before it ends; empty without a toolpath.
    """
    waiting: FlatPath | None = None
    moved = False
    for toolpath in toolpaths:
        allowed = _tolerance(toolpath, machine, tolerance_mm)
        start = toolpath.start[None, :] * _scale(toolpath)
        waits, lines = _waits(toolpath), toolpath.line.astype(np.int64)
        # Curves are cut in mm and degrees, of which one may count more.
        finer = allowed / max(machine.degree_mm, 1.0)
        for points, rows in _gathered(_flatten_rows(toolpath, finer, waits > 0)):
            moved = True
            joined = np.concatenate([start, points])
            start = points[-1:]
            last = np.append(np.diff(rows) != 0, True)
            yield FlatPath(
                toolpath.axes, joined, lines[rows], allowed[rows], np.where(last, waits[rows], 0.0)
            )
        if waiting is None or not waiting.line[0]:
            least = np.array([machine.chord_tolerance_mm])
            line = np.append(lines[:1], 0)[:1]
            waiting = FlatPath(toolpath.axes, np.repeat(start, 2, axis=0), line, least, np.zeros(1))
    if waiting is not None and not moved:
        yield waiting


def _gathered(
    parts: Iterator[tuple[Floats, NDArray[np.int64]]],
) -> Iterator[tuple[Floats, NDArray[np.int64]]]:
    """Join parts, points and the row of each, until they are `_AT_LEAST` points."""
    held: list[tuple[Floats, NDArray[np.int64]]] = []
    count = 0
    for part in parts:
        held.append(part)
        count += len(part[1])
        if count >= _AT_LEAST:
            yield np.concatenate([p for p, _ in held]), np.concatenate([r for _, r in held])
            held, count = [], 0
    if count:
        yield np.concatenate([p for p, _ in held]), np.concatenate([r for _, r in held])


def _scale(toolpath: Toolpath) -> Floats:
    """Return what columns are multiplied by to be mm and degrees."""
    return np.array([to_file(axis) for axis in toolpath.axes])


def _tolerance(toolpath: Toolpath, machine: Machine, tolerance_mm: float | None) -> Floats:
    """Return the tolerance in force on each row; never less than the chord between two setpoints may take."""
    given = np.where(np.isnan(toolpath.tolerance), machine.path_tolerance_mm, toolpath.tolerance)
    if tolerance_mm is not None:
        given = np.full_like(given, tolerance_mm)
    if toolpath.lever is not None:
        # The tolerance is the tip's: a degree of the rotary axes moves it by the lever times pi / 180.
        given = given / np.hypot(1.0, np.radians(toolpath.lever) / machine.degree_mm)
    continuous = toolpath.path_mode == PathMode.CONTINUOUS
    out = np.maximum(np.where(continuous, given, 0.0), machine.chord_tolerance_mm)
    # An event has no tolerance of its own: a wait is where the motions beside it meet.
    moving = np.flatnonzero(toolpath.kind != Kind.EVENT)
    if len(moving):
        event = np.flatnonzero(toolpath.kind == Kind.EVENT)
        after = np.searchsorted(moving, event)
        beside = moving[np.maximum(after - 1, 0)], moving[np.minimum(after, len(moving) - 1)]
        out[event] = np.maximum(out[beside[0]], out[beside[1]])
    return out


def _waits(toolpath: Toolpath) -> Floats:
    """Return how long the axes have to have stood by the end of each row: dwells after one another add up."""
    out = np.zeros(len(toolpath))
    total = 0.0
    for row, _, event in toolpath.event_rows:
        if row > 0 and toolpath.kind[row - 1] != Kind.EVENT:
            total = 0.0
        total += event.dwell_s
        out[row] = total if event.dwell_s > 0 else 0.0
    return out


def _flatten_rows(
    toolpath: Toolpath, tolerance: Floats, waits: NDArray[np.bool_]
) -> Iterator[tuple[Floats, NDArray[np.int64]]]:
    """Yield points after the start, mm and degrees, and the row of each; a row that waits is its place."""
    curved = np.flatnonzero((toolpath.kind == Kind.ARC) | (toolpath.kind == Kind.NURBS))
    straight_rows = (toolpath.kind == Kind.LINE) | waits
    starts, ends = toolpath.starts, toolpath.end * _scale(toolpath)
    after = 0
    for row in (*curved.tolist(), len(toolpath)):
        straight = after + np.flatnonzero(straight_rows[after:row])
        yield ends[straight], straight
        if row < len(toolpath):
            shape = _arc if toolpath.kind[row] == Kind.ARC else _nurbs
            for cut in shape(toolpath, row, starts[row], float(chord_mm(tolerance[row]))):
                yield cut, np.full(len(cut), row)
        after = row + 1


def _arc(toolpath: Toolpath, row: int, start: Floats, chord: float) -> Iterator[Floats]:
    """Cut an arc or helix, some turns at a time: the radius vector turned about the axis, the rest linear in the angle."""
    arcs, curve, end = toolpath.arcs, toolpath.curve[row], toolpath.end[row]
    centre, normal, sweep = arcs.centre[curve], arcs.normal[curve], float(arcs.sweep[curve])
    first = start[:3] - centre
    first_height = first @ normal
    first = first - first_height * normal
    last = end[:3] - centre
    last_height = last @ normal
    last = last - last_height * normal
    r0, r1 = float(np.linalg.norm(first)), float(np.linalg.norm(last))
    radius = max(r0, r1, chord)
    step = min(2.0 * np.arccos(max(1.0 - chord / radius, -1.0)), _TURN)
    count = max(int(np.ceil(abs(sweep) / step)), 1)
    u = first / r0 if r0 > 0 else first
    w = np.cross(normal, u)
    scale = _scale(toolpath)
    for done in range(0, count, _AT_LEAST):
        f = (np.arange(done + 1, min(done + _AT_LEAST, count) + 1) / count)[:, None]
        around = (r0 + f * (r1 - r0)) * (np.cos(f * sweep) * u + np.sin(f * sweep) * w)
        along = (first_height + f * (last_height - first_height)) * normal
        rest = start[3:] + f * (end[3:] - start[3:])
        points = np.concatenate([centre + around + along, rest], axis=1)
        if f[-1, 0] == 1.0:
            points[-1] = end
        yield points * scale


def _nurbs(toolpath: Toolpath, row: int, start: Floats, chord: float) -> Iterator[Floats]:
    """Cut a rational B-spline, all at a time: halve every piece whose middle is too far from its chord."""
    from scipy.interpolate import BSpline

    table, i = toolpath.nurbs, toolpath.curve[row]
    degree = int(table.degree[i])
    knots = table.knots[table.knot_offset[i] : table.knot_offset[i + 1]]
    between = slice(table.point_offset[i], table.point_offset[i + 1])
    weights = table.weights[between]
    scale = _scale(toolpath)
    homogeneous = np.column_stack([table.control_points[between] * scale * weights[:, None], weights])
    spline = BSpline(knots, homogeneous, degree)

    def at(u: Floats) -> Floats:
        x = spline(u)
        return x[:, :-1] / x[:, -1:]

    spans = np.unique(knots[degree : len(knots) - degree])
    pieces = [np.linspace(a, b, 8 * degree, endpoint=False) for a, b in itertools.pairwise(spans)]
    u = np.concatenate([*pieces, spans[-1:]])
    x = at(u)
    found_u, found_x = [u], [x]
    begin_u, end_u, begin, end = u[:-1], u[1:], x[:-1], x[1:]
    for _ in range(_MAX_HALVINGS):
        middle = 0.5 * (begin_u + end_u)
        point = at(middle)
        # Half-way along a smooth piece the curve is farthest from its chord, or nearly so, unless it turns back on it.
        bad = np.maximum(_chord_distance(point, begin, end), _beyond(point, begin, end)) > 0.5 * chord
        if not bad.any():
            break
        middle, point = middle[bad], point[bad]
        found_u.append(middle)
        found_x.append(point)
        begin_u, end_u = np.concatenate([begin_u[bad], middle]), np.concatenate([middle, end_u[bad]])
        begin, end = np.concatenate([begin[bad], point]), np.concatenate([point, end[bad]])
    x = np.concatenate(found_x)[np.argsort(np.concatenate(found_u), kind="stable")]
    x[-1] = toolpath.end[row] * scale
    yield x[1:]


def _chord_distance(point: Floats, a: Floats, b: Floats) -> Floats:
    chord = b - a
    size = np.maximum((chord**2).sum(axis=1), 1e-300)
    f = np.clip(((point - a) * chord).sum(axis=1) / size, 0.0, 1.0)
    return np.linalg.norm(point - a - f[:, None] * chord, axis=1)


def _beyond(point: Floats, a: Floats, b: Floats) -> Floats:
    """Return how far a piece goes beyond its ends along its chord: that of one axis may turn back, and lie on the chord's line.

    The chord has the length L, and the middle of the piece lies p before the middle of the chord. Where 4 p > L, the parabola
    L t + 4 p t (1 − t) turns within the piece, at (4 p − L)²/(16 p) beyond the end.
    """
    chord = b - a
    length = np.linalg.norm(chord, axis=1)
    ahead = np.abs(((point - 0.5 * (a + b)) * chord).sum(axis=1)) / np.maximum(length, 1e-300)
    return np.maximum(4.0 * ahead - length, 0.0) ** 2 / (16.0 * np.maximum(ahead, 1e-300))
