"""The limits of the search, and what they and the tolerance say of times, speeds and distances at corners."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary

Floats = NDArray[np.float64]

#: Time between nodes, as a part of (P/J)^(1/3), the time in which full jerk crosses the tolerance; beside corners the second part.
SPACING = 0.7, 0.34
#: Full jerk crosses the tolerance in this part of a period at least: chords between setpoints leave a motion that does so sooner.
SHOWN = 0.5
#: The way that a stop takes, in time of the reference, over which the end of a window is felt: a multiple of v/A + A/J.
_FELT = 1.2
#: A limit counts as this multiple, at most, of what a motion may come to.
_BEYOND = 2.0


@dataclass(frozen=True, slots=True)
class Bounds:
    """The limits of the search: velocity, acceleration and jerk of the axes, shape (axes,) each, scaled, infinite for those that the
    machine lacks; the period, and the chord tolerance between setpoints."""

    velocity: Floats
    acceleration: Floats
    jerk: Floats
    period_s: float
    chord_mm: float

    @property
    def strongest(self) -> tuple[float, float]:
        """Acceleration and jerk of the strongest axis; infinite where the machine has none of the axes."""
        acceleration, jerk = (
            float(each.max(where=np.isfinite(each), initial=0.0)) for each in (self.acceleration, self.jerk)
        )
        return acceleration or np.inf, jerk or np.inf

    def within(self, tolerance: float, feed: float) -> Bounds:
        """Return those of a motion that chords between setpoints can keep within a tolerance, at a feed that bounds linear axes.

        A limit that no such motion comes near is a multiple of the most that one may come to: the search counts in limits.
        """
        most = tolerance / (SHOWN * self.period_s) ** 3
        jerk = np.where(np.isfinite(self.jerk), np.minimum(self.jerk, most), np.inf)
        linear = np.arange(len(self.velocity)) < 3
        velocity = np.where(linear, np.minimum(self.velocity, _BEYOND * feed), self.velocity)
        # With full jerk the speed changes from the limit one way to that the other way.
        acceleration = np.minimum(self.acceleration, _BEYOND * np.sqrt(2.0 * velocity * jerk))
        return replace(self, velocity=velocity, acceleration=acceleration, jerk=jerk)

    def felt(self, feed: float) -> float:
        """Return the time over which the end of a window has influence, at a feed that bounds linear axes."""
        speed = np.where(np.arange(len(self.velocity)) < 3, np.minimum(self.velocity, feed), self.velocity)
        limited = np.isfinite(self.jerk)
        times = speed[limited] / self.acceleration[limited] + self.acceleration[limited] / self.jerk[limited]
        return _FELT * float(times.max())


@dataclass(frozen=True, slots=True)
class Scales:
    """Time and speed of corners: of the narrowest tolerance and the strongest jerk.

    Attributes:
        bounds: The limits.
        part: Part of the tolerance that nodes have for their room.
        close: How many times closer than usual nodes are.
    """

    bounds: Bounds
    part: float = 1.0
    close: float = 1.0

    @property
    def jerk(self) -> float:
        """That of the strongest axis."""
        return self.bounds.strongest[1]

    def spacing(self, tolerance: Floats | float) -> tuple[Floats, Floats]:
        """Return the time between nodes, and beside corners, s, for tolerances of any shape."""
        time = np.maximum(elementary.cbrt(tolerance / self.jerk) / self.close, SHOWN * self.bounds.period_s)
        return SPACING[0] * time, SPACING[1] * time

    def floor(self, tolerance: float) -> float:
        """Return a speed with which strong axes pass any corner, mm/s."""
        return 2.0 * float(elementary.cbrt(tolerance**2 * self.jerk))

    def sagitta(self, feed: Floats) -> Floats:
        """Return how far from the motion the middle of a chord between setpoints may be, mm, by the acceleration that one axis may come to.

        With full jerk the speed changes from the feed (mm/s, any shape) one way to that the other way.
        """
        acceleration, jerk = self.bounds.strongest
        out: Floats = np.minimum(acceleration, np.sqrt(2.0 * feed * jerk)) * self.bounds.period_s**2 / 8.0
        return out
