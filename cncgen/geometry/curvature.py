"""Local extrema of the curvature along a path, where `ild` and the baselines look for sharp corners (Tsai (2010), eq. 21)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.geometry.tables import Floats

#: Samples in each panel of the arc-length table; panels are short where the curve changes fast.
_SAMPLES = 4
#: Curvatures that differ by less than this part are equal: a circle has no extrema.
_PLATEAU = 1e-9
#: The golden section, and steps of the search: each shortens the bracket by it, 42 steps by 1.7e-9.
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
_STEPS = 42


@dataclass(frozen=True, slots=True)
class CurvatureExtrema:
    """Local extrema of curvature, ascending in s; a stretch of constant curvature counts once, at its middle.

    Attributes:
        s: Shape (n,), path coordinate.
        curvature: Shape (n,), 1/mm, in X Y Z.
        is_maximum: Shape (n,).
    """

    s: Floats
    curvature: Floats
    is_maximum: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.s)


def curvature_extrema(path: Path) -> CurvatureExtrema:
    """Find the local extrema of curvature inside a path, its ends left out.

    Curvature is sampled in every panel of the arc-length table and on both sides of breakpoints, and its extrema refined by
    the golden section (Kiefer, Proc. AMS 4 (1953) 502) to some 1e-9 of the sample distance. Its maxima are the first
    criterion of a sharp corner of Tsai (2010), whose second one is κ > A/V² (eq. 21).
    """
    s, kappa = _samples(path)
    # Runs of equal curvature become one sample with a first and a last place.
    new = np.concatenate([[True], np.abs(np.diff(kappa)) > _PLATEAU * np.maximum(kappa[1:], kappa[:-1])])
    first = np.flatnonzero(new)
    last = np.append(first[1:], len(kappa)) - 1
    rise = np.sign(np.diff(kappa[first]))
    turn = np.flatnonzero(rise[1:] * rise[:-1] < 0) + 1
    is_maximum = rise[turn - 1] > 0
    place = 0.5 * (s[first[turn]] + s[last[turn]])
    value = kappa[first[turn]]
    point = s[first[turn]] == s[last[turn]]
    if np.any(point):
        middle = place[point]
        # The neighbours in place, not in the list: a breakpoint is in it twice.
        low = s[np.maximum(np.searchsorted(s, middle, "left") - 1, 0)]
        high = s[np.minimum(np.searchsorted(s, middle, "right"), len(s) - 1)]
        place[point], value[point] = _refine(path, low, high, place[point], value[point], is_maximum[point])
    return CurvatureExtrema(place, value, is_maximum)


def _samples(path: Path) -> tuple[Floats, Floats]:
    """Return sample places (breakpoints twice: left, right) and curvatures."""
    borders = path.sample_borders()
    if len(borders) < 2:
        return np.zeros(0), np.zeros(0)
    share = np.arange(1, _SAMPLES) / _SAMPLES
    inner = (borders[:-1, None] + share * np.diff(borders)[:, None]).ravel()
    s = np.concatenate([borders[:-1], inner, borders[1:]])
    kappa = np.concatenate(
        [path.curvature(borders[:-1], 1), path.curvature(inner), path.curvature(borders[1:], -1)]
    )
    # In order along the path; at a border the left value comes before the right one.
    order = np.lexsort((np.repeat([1, 0, 0], [len(borders) - 1, len(inner), len(borders) - 1]), s))
    return s[order], kappa[order]


def _refine(
    path: Path, low: Floats, high: Floats, place: Floats, value: Floats, is_maximum: NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Refine extrema by the golden section in all brackets at once (Kiefer (1953)); where that finds nothing better, as at a
    kink, the sample stays."""
    sign = np.where(is_maximum, 1.0, -1.0)
    a, b = low.copy(), high.copy()
    for _ in range(_STEPS):
        c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
        left = sign * path.curvature(c) > sign * path.curvature(d)
        b, a = np.where(left, d, b), np.where(left, a, c)
    found = 0.5 * (a + b)
    kappa = path.curvature(found)
    better = sign * kappa > sign * value
    return np.where(better, found, place), np.where(better, kappa, value)
