"""The time that a rounded corner takes whose speed chords hold: the way through its bend, step by step (docs/rounding.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.rows import across, chord_speed

Floats = NDArray[np.float64]

#: Smoothing lengths on each side of a turn in which nearly all of it is made, and steps in which they are gone.
REACH, STEPS = 3.0, 16
#: Largest |x''| of a turn by what the filter of `response` makes of it: knots stand a smoothing length apart. Measured.
_MESHED = 0.85
#: Newton's steps in which the time of a step is found, to 10⁻⁸ of it where all of its three parts are alike.
_NEWTON = 4


def turned(s: Floats) -> Floats:
    """Return ∫₀ˢ h: the part of a turn that is made on a way of s L from its middle; see `response`."""
    out: Floats = (3.0 - np.exp(-s) - 2.0 * np.exp(-0.5 * s) * np.cos(0.5 * np.sqrt(3.0) * s)) / 6.0
    return out


def response(s: Floats) -> Floats:
    """Return h(s) = (1/π) ∫₀^∞ cos ωs/(1 + ω⁶) dω, s ≥ 0: x'' L/Δ at a distance of s L from a turn Δ."""
    half = np.exp(-0.5 * s)
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
    """One side of rounded corners: how a motion leaves the middle of the bend, where chords hold it, for the top speed of the row.

    Attributes:
        bend: Shape (steps + 1, n), |x''| across x' from the middle on, 1/mm.
        length: Shape (n,), mm: L.
        room: Shape (n,), mm: how far the bend may reach.
        chord: Shape (n,), mm: what chords may leave the path by.
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
            dt, faster, free = self._stepped(v, a, step)
            # Where chords hold it, the speed grows from the one bound to the other.
            held = (faster > cap) & (step > 0.0)
            dt = np.where(held, np.maximum(dt, 2.0 * step / (v + cap)), dt)
            a = np.where(held, np.minimum(free, (cap - v) / np.where(held, dt, 1.0)), free)
            v, lost = np.minimum(faster, cap), np.where(bent, lost + dt - step / self.top, lost)
        return np.where(bent, lost + self._rest(v, a), lost)

    def _stepped(self, v: Floats, a: Floats, way: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the time of a way from a speed and an acceleration on, which grows by the jerk up to its limit, and both after it."""
        jerk, most = self.jerk, self.acceleration
        rise = (most - a) / jerk
        risen, reached = (v + (0.5 * a + jerk * rise / 6.0) * rise) * rise, v + 0.5 * (a + most) * rise
        left = np.maximum(way - risen, 0.0)
        # v t + a t²/2 + J t³/6 bends upwards: from where one of the three alone is the way Newton's steps only fall.
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.fmin(np.minimum(way / v, np.cbrt(6.0 * way / jerk)), np.sqrt(2.0 * way / a))
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
            + self.top * fall - self.jerk * fall**3 / 6.0
        )  # fmt: skip
        return rise + hold + fall - way / self.top
