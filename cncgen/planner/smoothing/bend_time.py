"""The time through a rounded corner whose speed the chords between setpoints hold, step by step; for `rounding_decision`.

The curve about a single turn is known in closed form: `response` is the equivalent kernel of the smoothing spline that `stream`
fits (Silverman, Spline smoothing: the equivalent variable kernel method (1984), there for the second derivative in place of
the third). docs/rounding.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.planner.limits.bend_speeds import across, chord_speed

Floats = NDArray[np.float64]

#: Smoothing lengths on each side of a turn within which nearly all of it is made, and into how many steps they are divided.
REACH, STEPS = 3.0, 16
#: Largest |x''| at a turn of the fitted spline, whose knots stand a smoothing length apart, as a part of that of `response`.
#: Measured.
_MESHED = 0.85
#: Iterations of Newton's method for the time of a step. Four give 10⁻⁸ of it in the worst case, three equal terms.
_NEWTON = 4


def turned(s: Floats) -> Floats:
    """Return ∫₀ˢ h, shape as s: the part of a turn that is made between its middle and the distance s L; see `response`."""
    out: Floats = (
        3.0 - elementary.exp(-s) - 2.0 * elementary.exp(-0.5 * s) * np.cos(0.5 * np.sqrt(3.0) * s)
    ) / 6.0
    return out


def response(s: Floats) -> Floats:
    """Return h(s) = (1/π) ∫₀^∞ cos ωs/(1 + ω⁶) dω, s ≥ 0: x'' L/Δ at the distance s L from a turn Δ.

    The closed form is the sum of the residues at the poles of 1/(1 + ω⁶) in the upper half plane, e^(iπ/6), i, e^(5iπ/6).
    """
    half = elementary.exp(-0.5 * s)
    wave = 0.5 * np.sqrt(3.0) * s
    out: Floats = (half * half + half * (np.cos(wave) + np.sqrt(3.0) * np.sin(wave))) / 6.0
    return out


def bends(leave: Floats, entry: Floats) -> Floats:
    """Return |x''| L across x' on the way out of turns, shape (2, steps + 1, n): before them, backwards, and after them.

    Args:
        leave, entry: Shape (n, axes), x' before and after.
    """
    turn, scale = entry - leave, np.ones(entry.shape[1])
    s = np.linspace(0.0, REACH, STEPS + 1)
    made, there = turned(s), _MESHED * np.abs(response(s))
    return np.stack(
        [
            [
                bend * across(leave + (0.5 + sign * part) * turn, turn, scale)
                for part, bend in zip(made, there, strict=True)
            ]
            for sign in (-1.0, 1.0)
        ]
    )


@dataclass(frozen=True, slots=True)
class Way:
    """One side of rounded corners: a motion from the middle of the bend, where chords hold its speed, up to the row's top speed.

    Attributes:
        bend: Shape (steps + 1, n), |x''| across x' from the middle on, 1/mm.
        length: Shape (n,), mm: L.
        room: Shape (n,), mm: how far the bend may reach.
        chord: Shape (n,), mm: how far chords may be from the path.
        acceleration, jerk, top: Shape (n,): limits along the row, and the largest speed on it.
        period_s: Time between setpoints.
    """

    bend: Floats
    length: Floats
    room: Floats
    chord: Floats
    acceleration: Floats
    jerk: Floats
    top: Floats
    period_s: float

    def slowest(self) -> Floats:
        """Return the speed in the middle of the bend, mm/s."""
        return np.minimum(chord_speed(self.bend[0], self.chord, self.period_s), self.top)

    def lost(self) -> Floats:
        """Return the time lost against going on at the top speed, s.

        In the middle the acceleration is 0. From there on it grows by the jerk, as far as chords let the speed rise. From
        where they allow the top speed, or where the bend ends, what is left is a change of speed on a straight line.
        """
        caps = np.minimum(chord_speed(self.bend, self.chord, self.period_s), self.top)
        ends = np.minimum(self.length * np.linspace(0.0, REACH, STEPS + 1)[:, None], self.room)
        v, a, lost = caps[0], np.zeros_like(self.length), np.zeros_like(self.length)
        bent = np.ones(len(self.length), bool)
        for cap, step in zip(np.maximum.accumulate(caps, axis=0)[1:], np.diff(ends, axis=0), strict=True):
            freed = bent & (cap >= self.top)
            lost = np.where(freed, lost + self._rest(v, a), lost)
            bent = bent & ~freed
            dt, faster, free = self.step_time(v, a, step)
            # Where chords hold it, the speed grows from the one bound to the other.
            held = (faster > cap) & (step > 0.0)
            dt = np.where(held, np.maximum(dt, 2.0 * step / (v + cap)), dt)
            a = np.where(held, np.minimum(free, (cap - v) / np.where(held, dt, 1.0)), free)
            v, lost = np.minimum(faster, cap), np.where(bent, lost + dt - step / self.top, lost)
        return np.where(bent, lost + self._rest(v, a), lost)

    def step_time(self, v: Floats, a: Floats, way: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the time of a way from a speed and an acceleration on, which grows by the jerk up to its limit, and both after it."""
        jerk, most = self.jerk, self.acceleration
        rise = (most - a) / jerk
        risen, reached = (v + (0.5 * a + jerk * rise / 6.0) * rise) * rise, v + 0.5 * (a + most) * rise
        left = np.maximum(way - risen, 0.0)
        # f(t) = v t + a t²/2 + J t³/6 is convex for t > 0. If one of its terms alone is the way, t is too large, and Newton's
        # iterates from there fall monotonically to the root.
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.fmin(np.minimum(way / v, elementary.cbrt(6.0 * way / jerk)), np.sqrt(2.0 * way / a))
        for _ in range(_NEWTON):
            t = t - ((v + (0.5 * a + jerk * t / 6.0) * t) * t - way) / (v + (a + 0.5 * jerk * t) * t)
        rising = way <= risen
        time = np.where(rising, t, rise + 2.0 * left / (reached + np.sqrt(reached**2 + 2.0 * most * left)))
        faster = np.where(rising, v + (a + 0.5 * jerk * t) * t, reached + most * (time - rise))
        return time, faster, np.where(rising, a + jerk * t, most)

    def _rest(self, v: Floats, a: Floats) -> Floats:
        """Return the time lost from a speed and an acceleration to the top speed, in three phases."""
        change = self.top - v
        a = np.minimum(a, np.sqrt(2.0 * self.jerk * change))
        most = np.minimum(self.acceleration, np.sqrt(self.jerk * change + 0.5 * a * a))
        rise, fall = (most - a) / self.jerk, most / self.jerk
        risen, falling = v + 0.5 * (a + most) * rise, self.top - 0.5 * most * fall
        hold = np.where(most > 0.0, np.maximum(falling - risen, 0.0) / np.where(most > 0.0, most, 1.0), 0.0)
        way = (
            v * rise + (0.5 * a + self.jerk * rise / 6.0) * rise**2
            + 0.5 * (risen + falling) * hold
            + self.top * fall - self.jerk * elementary.power(fall, 3.0) / 6.0
        )  # fmt: skip
        return rise + hold + fall - way / self.top
