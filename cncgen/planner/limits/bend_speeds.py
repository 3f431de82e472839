"""The speed at which a bend may be passed: by the chords between setpoints, and by curvature as in the papers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import along_path

Floats = NDArray[np.float64]


def chord_speed(curvature: Floats, tolerance_mm: Floats | float, period_s: float) -> Floats:
    """Return the speed, mm/s, whose chord over a period stays within the tolerance of the arc (Tsai 2010, eq. 24).

    Of curvatures of any shape, 1/mm, and a tolerance for all or each; infinite where the path is straight.

    V_af = (2/T_s) √(ρ² − (ρ − δ)²) = (2/T_s) √(2δ/κ − δ²) with ρ = 1/κ. Where ρ is below δ, and the formula soon has no
    root, it is (2/T_s) √(δ/κ): no point of a way of V T_s is further than V T_s/2 < δ from its nearer end. With rotary axes,
    where |x'| = g and κ stands for |x''| across x', the chord is kept by (2/T_s) √(2δ/κ − (δ/g)²) and by (2/T_s) δ/g, of
    which the larger one is never below that, whatever g.
    """
    bend = np.ascontiguousarray(curvature, float)
    out = np.empty(bend.shape)
    tolerance = np.ascontiguousarray(np.broadcast_to(tolerance_mm, bend.shape), float)
    along_path.chord_speed(bend.ravel(), tolerance.ravel(), period_s, out.ravel())
    return out


def curvature_speed(curvature: Floats, feed_mm_s: float | Floats, kbar_per_mm: float) -> Floats:
    """Return V_cf = κ̄ V_max / (κ + κ̄) (Tsai 2010, eq. 25), mm/s, of curvatures κ (1/mm), shape (n,): half the feed at κ = κ̄."""
    return kbar_per_mm * feed_mm_s / (curvature + kbar_per_mm)
