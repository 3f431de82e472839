"""Sharp corners of curves (Tsai 2010, sections 5.2 and 5.3), and the speeds at them.

A sharp corner is a local maximum of |κ| on a NURBS where κ > κ_th = A_max / V_max² (eq. 21), at least d_min from the corner before it
and from the start of the curve. That last rule is ours; docs/ild.md says why.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.limits.speeds import chord_speed, curvature_speed
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CornerRule:
    """The rule that makes a corner sharp, and its speed.

    Attributes:
        chord_tolerance_mm: δ of eq. 24.
        period_s: T_s.
        kbar_per_mm: κ̄ of eq. 25.
        distance_mm: d_min.
    """

    chord_tolerance_mm: float
    period_s: float
    kbar_per_mm: float
    distance_mm: float

    def speeds(self, curvature: Floats, feed_mm_s: float) -> tuple[Floats, NDArray[np.int8]]:
        """Return min(V_af, V_cf, V_max) at places of that curvature (eq. 23) and which of them it is."""
        chord = chord_speed(curvature, self.chord_tolerance_mm, self.period_s)
        bend = curvature_speed(curvature, feed_mm_s, self.kbar_per_mm)
        speed = np.minimum(chord, bend)
        limit = np.where(chord < bend, np.int8(Limit.CHORD), np.int8(Limit.CURVATURE))
        return np.minimum(speed, feed_mm_s), limit.astype(np.int8)

    def corners(
        self, s: Floats, curvature: Floats, start: float, centripetal: float, feed_mm_s: float
    ) -> NDArray[np.int64]:
        """Return the indices of the sharp corners of one curve.

        Args:
            s, curvature: Shape (n,), path coordinates of the maxima of |κ|, increasing, and |κ| there, 1/mm.
            start: Path coordinate where the curve starts.
            centripetal, feed_mm_s: A_max, mm/s², and V_max.
        """
        sharp = np.flatnonzero(curvature * feed_mm_s**2 > centripetal)
        kept: list[int] = []
        last = start
        for i in sharp:
            if s[i] - last >= self.distance_mm:
                kept.append(int(i))
                last = float(s[i])
        return np.array(kept, dtype=np.int64)
