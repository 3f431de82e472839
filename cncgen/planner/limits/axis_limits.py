"""Bounds of the speed and its derivatives along a path: the limits of the axes, and the bounds of q = v².

An axis x_i(s) moves with x_i' v, x_i'' q + x_i' q'/2 and so on (Verscheure et al., 2009, without the robot's
dynamics); where the path is straight, its limit by |x_i'| is the limit along the path. `least_time` takes all its limits
from here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import min_over_axes
from cncgen.geometry.path import metric_columns
from cncgen.kernels import along_path as kernel
from cncgen.kernels import node_places
from cncgen.machine.record import Axis, Machine
from cncgen.planner.record import Limit
from cncgen.units import DEGREE, is_rotary

Floats = NDArray[np.float64]

#: Part of the jerk limit that a jump of tangent or curvature may take at most; the rest is for the motion around it. Chosen:
#: with more the motion beside a corner can hardly brake or accelerate, with less corners are passed more slowly.
JUMP_SHARE = 0.75
#: Part of the jerk limit by which the motion around a step of the tangent has less, by the part that the step takes. A third difference
#: that ends a period after the step sees all of its share J, and half a period of full jerk from before its way with 1/48 of its weight:
#: share + rest 47/48 + 1/48 is 1 at most.
STEP_TAKES = 48.0 / 47.0
#: Part of the jerk limit, beside `JUMP_SHARE`, that the acceleration along the path may take while a jump is passed.
SWAY_SHARE = 0.02
#: A jerk limit counts as this multiple of A/T at most, which ramps to full acceleration in a tenth of a period. Setpoints show 2 A/T of
#: any ramp, and shorter ones gain less than that tenth, but need nodes as close as they are short (docs/least-time.md).
_HARDEST = 10.0
#: A bend is too short to show in setpoints if it is shorter than the first part of J T³/6, the way that full jerk leads from
#: rest in a period, and than the second part of A T²/2, that of full acceleration: J T³/50 and A T²/200 (docs/least-time.md).
_UNSEEN = 0.12, 0.01


def axis_scale(axes: str, degree_mm: float) -> Floats:
    """Return what the columns of axes are multiplied by to be mm: 1, and of the rotary ones the radius at which a degree is so many mm.

    At this radius rotary axes are held to the tolerance.
    """
    out = np.ones(len(axes))
    out[metric_columns(axes)[2]] = degree_mm / DEGREE
    return out


#: Limit, in its unit, of an axis that the machine lacks: never reached, and finite because infinity times a direction of 0 is not a number.
_FREE = 1e15


def chord_reserve(machine: Machine, axes: str) -> float:
    """Return by how much the chord of a period may leave a path without corners, mm: the tolerance, or what is possible.

    Over a chord of the duration T a motion x(t) is at most max |d²x/dt²| T²/8 away, and its second derivative at most the
    root of the sum of the squares of the axes' acceleration limits. With rotary axes the tolerance counts: how much of a
    distance they make is a matter of units.

    Args:
        machine: Limits, period, chord tolerance.
        axes: Letters of the program's axes.
    """
    given = machine.chord_tolerance_mm
    if any(map(is_rotary, axes)):
        return given
    limits = [machine.axes[letter].max_acceleration for letter in axes if letter in machine.axes]
    return min(given, float(np.linalg.norm(limits)) * machine.period_s**2 / 8.0)


def _jerk(axis: Axis, period_s: float) -> float:
    return min(axis.max_jerk, _HARDEST * axis.max_acceleration / period_s)


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """The limits of a machine for the axes of a toolpath, in the order of its columns.

    Attributes:
        velocity, acceleration, jerk: Shape (axes,), mm/s, mm/s², mm/s³ (rad for rotary axes); infinite for axes that the
            machine lacks. The jerk is 10 A/T at most.
        period_s: Time between setpoints.
        chord_mm: Largest distance of the chord of a period from the path.
        centripetal: Largest v²κ, mm/s², and the `Limit` that it stands for.
        scale: Shape (axes,), what columns are multiplied by to be mm (`axis_scale`): chords are those of all axes.
    """

    velocity: Floats
    acceleration: Floats
    jerk: Floats
    period_s: float
    chord_mm: float
    centripetal: tuple[float, Limit]
    scale: Floats

    @classmethod
    def of(cls, machine: Machine, letters: str, contour_centripetal: float = np.inf) -> AxisLimits:
        """Take the limits of a machine; `contour_centripetal` is the v²κ at which the predicted contour error is met."""
        axes = [machine.axes.get(letter) for letter in letters]
        given = machine.max_centripetal_mm_s2 or np.inf
        centripetal = (given, Limit.CENTRIPETAL)
        if contour_centripetal < given:
            centripetal = (contour_centripetal, Limit.CONTOUR_ERROR)
        return cls(
            velocity=np.array([a.max_velocity if a else np.inf for a in axes], float),
            acceleration=np.array([a.max_acceleration if a else np.inf for a in axes], float),
            jerk=np.array([_jerk(a, machine.period_s) if a else np.inf for a in axes], float),
            period_s=machine.period_s,
            chord_mm=machine.chord_tolerance_mm,
            centripetal=centripetal,
            scale=axis_scale(letters, machine.degree_mm),
        )

    def in_mm(self) -> AxisLimits:
        """Return the limits of columns that are multiplied by `scale`; those of axes that the machine lacks are finite."""
        velocity, acceleration, jerk = (
            np.where(np.isfinite(each), each, _FREE) * self.scale
            for each in (self.velocity, self.acceleration, self.jerk)
        )
        return replace(self, velocity=velocity, acceleration=acceleration, jerk=jerk)

    @property
    def rotary(self) -> NDArray[np.bool_]:
        """Shape (axes,): axes whose unit is an angle."""
        out: NDArray[np.bool_] = self.scale != 1.0
        return out

    @property
    def speed_step(self) -> Floats:
        """Shape (axes,), mm/s: the step of an axis's speed that setpoints may show, the smaller of A T and J T²."""
        return np.minimum(self.acceleration * self.period_s, self.jerk * self.period_s**2)

    def top(
        self, feed: Floats, feed_limit: NDArray[np.int8], x1: Floats, x2: Floats
    ) -> tuple[Floats, NDArray[np.int8]]:
        """Return the largest q = v² at points of the path and the `Limit` behind it.

        Args:
            feed: Shape (n,), mm/s, infinite for rapids.
            feed_limit: Shape (n,), int8, the `Limit` that it stands for.
            x1, x2: Shape (n, axes), dx/ds and d²x/ds².
        """
        q, limit = np.empty(len(x1)), np.empty(len(x1), np.int8)
        kernel.top(
            feed,
            feed_limit,
            self.velocity,
            self.chord_mm,
            self.period_s,
            self.centripetal[0],
            self.scale,
            np.array([Limit.VELOCITY, Limit.CHORD, self.centripetal[1]], np.int8),
            np.ascontiguousarray(x1),
            np.ascontiguousarray(x2),
            q,
            limit,
        )
        return q, limit

    def jump(self, turn: Floats, bend: Floats) -> tuple[Floats, Floats]:
        """Return what jumps of dx/ds and d²x/ds², shape (n, axes), cost: per axis, the part of the jerk limit taken at speed v is linear·v + square·v²,
        shape (n, axes) each, s/mm and s²/mm² (docs/corners.md, Jumps).
        """
        return np.abs(turn) / self.speed_step, 0.75 * np.abs(bend) / (self.jerk * self.period_s)


def along_path(limit: Floats, *x1: Floats) -> Floats:
    """Return the largest speed, acceleration or jerk along the path that keeps every axis to its limit, shape (n,).

    Args:
        limit: Shape (axes,).
        x1: Shape (n, axes) each, dx/ds at places of the path, or on both sides of them. Infinite where no axis moves.
    """
    out = np.empty(len(x1[0]))
    largest = x1[0] if len(x1) == 1 else reduce(np.maximum, map(np.abs, x1))
    kernel.weakest(limit, np.ascontiguousarray(largest), out)
    return out


def resolution(bounds: AxisLimits, x1: Floats) -> Floats:
    """Return up to which length a bend of the path does not show in setpoints, shape (n,), mm.

    It is a small part, `_UNSEEN`, of the way that full jerk, J T³/6, or full acceleration, A T²/2, leads from rest in a
    period, and the chord tolerance at most. X Y Z may turn to any direction within the bend, so each of them counts with
    its whole limit; further axes follow at the ratio dx/ds that they have at the places of the path, `x1`, shape (n, axes).
    """
    # Of X Y Z alone it is the same everywhere. Column by column, for one that moves is seen at its first places.
    gain = np.abs(x1 if x1.shape[1] > 3 else x1[:1])
    gain[:, :3] = [column.any() for column in x1[:, :3].T]
    by_jerk = along_path(bounds.jerk, gain) * bounds.period_s**3 / 6.0
    by_acceleration = along_path(bounds.acceleration, gain) * bounds.period_s**2 / 2.0
    found = np.minimum(_UNSEEN[0] * by_jerk, _UNSEEN[1] * by_acceleration)
    shown = np.where(np.isfinite(found), np.minimum(found, bounds.chord_mm), 0.0)
    return np.broadcast_to(shown, len(x1)).copy()


def speed_within(linear: Floats, square: Floats, share: float) -> Floats:
    """Return the largest v with linear·v + square·v² ≤ share for every axis, shape (n,).

    The root of the quadratic is taken in the form that also holds for square = 0, and loses no digits near that.
    """
    with np.errstate(divide="ignore", over="ignore"):
        v = 2.0 * share / (linear + np.sqrt(linear**2 + 4.0 * share * square))
    return min_over_axes(v)


def lowered(values: Floats, way: Floats) -> Floats:
    """Return the largest values, none above those given, that differ between two places by at most the distance between them.

    This is a look-ahead and a look-back in one: with v² for the values and 2 A s for the way it is the largest speed that
    full acceleration allows (Bobrow et al., 1985). A value that no other one lowers is returned unchanged to the last
    digit, however large the way is beside it.

    Args:
        values: Shape (n,).
        way: Shape (n,), ascending.
    """
    out = np.empty(len(values))
    node_places.lowered(values, way, out)
    return out
