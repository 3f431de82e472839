"""A chunk of a toolpath cut at its joints: the rows' ends, and the sharp corners within its curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.curvature import CurvatureExtrema, curvature_extrema
from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.assembly import events_before
from cncgen.planner.ild.sharp_corners import CornerRule
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.limits.row_limits import RowLimits, row_limits_of
from cncgen.planner.record import Limit
from cncgen.toolpath.record import Event, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: mm: joints that are closer are one.
_SAME_PLACE = 1e-9
#: Turn of the tangent below which two rows count as tangent: rounding of nine-digit coordinates, not a corner.
_TANGENT = 1e-6


@dataclass(frozen=True, slots=True)
class RowEnd:
    """The end of a stretch, for the joint with the next one: dx/ds and d²x/ds², each of shape (axes,)."""

    tangent: Floats
    bend: Floats


@dataclass(frozen=True, slots=True)
class _Inner:
    """Joints within curves, each of shape (n,); see `Stretch`, whose columns have the same names."""

    s: Floats
    cap: Floats
    cap_limit: NDArray[np.int8]
    sharp: NDArray[np.bool_]
    turns: NDArray[np.bool_]


@dataclass(slots=True)
class Stretch:
    """A chunk between joints: `n` segments, n + 1 joints.

    Attributes:
        toolpath, path: The chunk and its geometry.
        s: Shape (n + 1,), path coordinate of the joints.
        top, top_limit, acceleration, jerk: Shape (n,), of the segments (see `Segments`).
        cap, cap_limit: Shape (n + 1,), highest speed at the joints, mm/s, and the `Limit` behind it.
        sharp: Shape (n + 1,), bool: the joints that are corners.
        turns: Shape (n + 1,), bool: the joints of rows at which the tangent turns.
        events: Joint, source line and event, in order; an event that rests has its joint's cap at 0.
        end: How the last moving row ends; None where nothing moves.
        used: Segments that are planned for good.
    """

    toolpath: Toolpath
    path: Path
    s: Floats
    top: Floats
    top_limit: NDArray[np.int8]
    acceleration: Floats
    jerk: Floats
    cap: Floats
    cap_limit: NDArray[np.int8]
    sharp: NDArray[np.bool_]
    turns: NDArray[np.bool_]
    events: list[tuple[int, int, Event]]
    end: RowEnd | None
    used: int = 0

    def __len__(self) -> int:
        return len(self.top)

    def lower(self, joint: int, speed: float, limit: Limit) -> None:
        """Lower the cap of one joint to `speed` where it is higher."""
        if speed < self.cap[joint]:
            self.cap[joint] = speed
            self.cap_limit[joint] = limit


def stretch_of(
    toolpath: Toolpath,
    machine: Machine,
    rule: CornerRule,
    before: RowEnd | None,
    contour_centripetal: float = np.inf,
) -> Stretch:
    """Cut a chunk at its joints.

    Args:
        toolpath: The chunk.
        machine: Its limits.
        rule: The rule of sharp corners.
        before: How the row before the chunk ends; None at the start of the program and after it.
        contour_centripetal: v²κ that the contour error allows, mm/s²; the maxima of curvature where the feed exceeds
            it become joints too, though they do not count as sharp corners.
    """
    path = toolpath.path
    rows = row_limits_of(toolpath, path, machine)
    stretch = _joined(toolpath, path, rows, machine, before)
    curves = np.flatnonzero(toolpath.kind[rows.index] == Kind.NURBS)
    if len(curves):
        extrema = curvature_extrema(path)
        rests = stretch.cap == 0.0
        rests[0] |= before is None
        inner = [
            _bends(stretch, rows, int(i), extrema, rule, contour_centripetal, bool(rests[i])) for i in curves
        ]
        inner.append(_cusps(path, rows, curves, machine))
        _insert(stretch, inner)
    return stretch


def _joined(
    toolpath: Toolpath, path: Path, rows: RowLimits, machine: Machine, before: RowEnd | None
) -> Stretch:
    """Make the stretch whose joints are the rows' ends."""
    n = len(rows)
    limits = AxisLimits.of(machine, toolpath.axes)
    turn, bend = rows.tangent_in.copy(), rows.bend_in.copy()
    turn[1:] -= rows.tangent_out[:-1]
    bend[1:] -= rows.bend_out[:-1]
    turn[:1] -= before.tangent if before else turn[:1]
    bend[:1] -= before.bend if before else bend[:1]
    cap = np.append(joint_speeds(turn, bend, limits), np.inf)
    turns = np.append(turned(turn), False)
    end = RowEnd(rows.tangent_out[-1], rows.bend_out[-1]) if n else before
    start_s = path.row_s[0]
    stretch = Stretch(
        toolpath=toolpath,
        path=path,
        s=np.concatenate([rows.start[:1] if n else [start_s], rows.end]),
        top=rows.top,
        top_limit=rows.top_limit,
        acceleration=rows.acceleration,
        jerk=rows.jerk,
        cap=cap,
        cap_limit=np.full(n + 1, Limit.CORNER, dtype=np.int8),
        sharp=_slows(cap, rows.top),
        turns=turns,
        events=[],
        end=end,
    )
    _bent(stretch, rows, before is not None)
    _stops(stretch, rows)
    return stretch


def turned(turn: Floats) -> NDArray[np.bool_]:
    """Tell at which joints the tangent turns by more than rounding, shape (n,)."""
    return np.any(np.abs(turn) >= _TANGENT, axis=1)


def joint_speeds(turn: Floats, bend: Floats, limits: AxisLimits) -> Floats:
    """Return the speed at which each joint of two rows may be passed, from the limits of the axes within one period (docs/ild.md):

    v |Δt_i| <= min(A_i T, J_i T²)  where the tangent turns,   v² |Δ(κn)_i| <= J_i T  where only the curvature jumps.

    Args:
        turn, bend: Shape (n, axes), steps of dx/ds and d²x/ds² from the row before the joint to the row after it.
        limits: Limits of the axes, and T.

    Returns:
        Shape (n,), mm/s; infinite where nothing jumps.
    """
    jump = np.abs(bend)
    turn = np.abs(turn)
    turn[turn < _TANGENT] = 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        by_turn = np.where(turn > 0.0, limits.speed_step / turn, np.inf).min(axis=1, initial=np.inf)
        by_jump = np.where(jump > 0.0, np.sqrt(limits.jerk * limits.period_s / jump), np.inf)
    return np.minimum(by_turn, by_jump.min(axis=1, initial=np.inf))


def _bend_speed(curvature: Floats, centripetal: Floats | float, jerk: Floats | float) -> Floats:
    """Return the speed at which a circle of that curvature asks for A_max or J_max, shape (n,), mm/s: v²κ = A, v³κ² = J."""
    with np.errstate(divide="ignore"):
        speed: Floats = np.minimum(np.sqrt(centripetal / curvature), elementary.cbrt(jerk / curvature**2))
    return speed


def _bent(stretch: Stretch, rows: RowLimits, goes_on: bool) -> None:
    """Lower the joints between NURBS rows to `_bend_speed`: a rounded corner bends most where its two rows meet.

    The rule of sharp corners does not count such a joint. The first joint is between rows only where the stretch goes on.
    """
    curved = stretch.toolpath.kind[rows.index] == Kind.NURBS
    entry, leave = (
        np.where(
            curved, _bend_speed(np.linalg.norm(bend[:, :3], axis=1), rows.centripetal, rows.jerk), np.inf
        )
        for bend in (rows.bend_in, rows.bend_out)
    )
    speed = np.append(entry, np.inf)
    speed[1:-1] = np.minimum(speed[1:-1], leave[:-1])
    speed[:1] = speed[:1] if goes_on else np.inf
    slower = speed < stretch.cap
    stretch.cap[slower] = speed[slower]
    stretch.cap_limit[slower] = Limit.CURVATURE


def _slows(cap: Floats, top: Floats) -> NDArray[np.bool_]:
    """Tell which joints are slower than the segments on both sides."""
    return cap < np.minimum(np.append(np.inf, top), np.append(top, np.inf))


def _stops(stretch: Stretch, rows: RowLimits) -> None:
    """Put the events at their joints, and rest where an event or the path mode asks for it."""
    toolpath = stretch.toolpath
    stretch.events = events_before(toolpath, rows.index)
    for joint, _, event in stretch.events:
        if event.stands:
            stretch.lower(joint, 0.0, Limit.STOP)
    for row in np.flatnonzero(toolpath.path_mode[rows.index] == PathMode.EXACT_STOP):
        stretch.lower(int(row) + 1, 0.0, Limit.STOP)


def _bends(
    stretch: Stretch,
    rows: RowLimits,
    position: int,
    extrema: CurvatureExtrema,
    rule: CornerRule,
    contour_centripetal: float,
    from_rest: bool,
) -> _Inner:
    """Return the joints at the sharp corners of a NURBS row, and at maxima of |κ| that the feed may not pass though they do not count.

    These are maxima too near to another corner or to a start where the tool does not rest, which are passed at `_bend_speed`, and
    those where the contour error asks for less than the feed.
    """
    feed = float(stretch.top[position])
    start, end = float(rows.start[position]), float(rows.end[position])
    mine = extrema.is_maximum & (extrema.s > start) & (extrema.s < end)
    s, curvature = extrema.s[mine], extrema.curvature[mine]
    centripetal = float(rows.centripetal[position])
    sharp = rule.corners(s, curvature, start, centripetal, feed)
    passing = _bend_speed(curvature, centripetal, float(rows.jerk[position]))
    too_near = (curvature * feed**2 > centripetal) & (passing < feed)
    too_near &= (not from_rest) | (s - start >= rule.distance_mm)
    extra = np.flatnonzero(too_near | (curvature * feed**2 > contour_centripetal))
    at = np.union1d(sharp, extra)
    speed, limit = rule.speeds(curvature[at], feed)
    is_sharp = np.isin(at, sharp)
    speed = np.where(is_sharp, speed, np.minimum(feed, passing[at]))
    limit = np.where(is_sharp, limit, np.int8(Limit.CURVATURE))
    bound = np.sqrt(contour_centripetal / curvature[at])
    limit = np.where(bound < speed, np.int8(Limit.CONTOUR_ERROR), limit).astype(np.int8)
    return _Inner(s[at], np.minimum(speed, bound), limit, is_sharp, np.zeros(len(at), dtype=bool))


def _cusps(path: Path, rows: RowLimits, curves: Ints, machine: Machine) -> _Inner:
    """Return the joints where the tangent jumps within a NURBS, at a knot of full multiplicity or where C' vanishes."""
    jumps = path.jumps()
    inside = (jumps.before == jumps.after) & np.isin(jumps.after, rows.index[curves])
    inside &= turned(jumps.tangent)
    turn = jumps.tangent[inside]
    speed = joint_speeds(turn, np.zeros_like(turn), AxisLimits.of(machine, path.axes))
    yes = np.ones(len(turn), dtype=bool)
    return _Inner(jumps.s[inside], speed, np.full(len(turn), Limit.CORNER, dtype=np.int8), yes, yes)


def _insert(stretch: Stretch, inner: list[_Inner]) -> None:
    """Cut segments into several at joints within them; where two are at one place, the slower one is taken."""
    s = np.concatenate([i.s for i in inner])
    order = np.lexsort((np.concatenate([i.cap for i in inner]), s))
    order = order[np.append(True, np.diff(s[order]) > _SAME_PLACE)] if len(order) else order
    joint = np.searchsorted(stretch.s, s[order])
    for name in _Inner.__slots__:
        values = np.concatenate([getattr(i, name) for i in inner])[order]
        setattr(stretch, name, np.insert(getattr(stretch, name), joint, values))
    for name in ("top", "top_limit", "acceleration", "jerk"):
        column = getattr(stretch, name)
        setattr(stretch, name, np.insert(column, joint, column[joint - 1]))
    stretch.events = [
        (at + int(np.searchsorted(joint, at, side="right")), line, event)
        for at, line, event in stretch.events
    ]
