"""Distance of points to a path, slow and obvious: all chords, then Newton on the nearest few stretches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path

Floats = NDArray[np.float64]


def samples(path: Path, most_turn: float = 0.05, least: int = 3) -> Floats:
    """Path coordinates between which the path turns little, breakpoints among them."""
    borders = path.sample_borders()
    middle = 0.5 * (borders[1:] + borders[:-1])
    count = np.ceil(path.curvature(middle) * np.diff(borders) / most_turn).astype(int).clip(least, 2000)
    inner = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(borders, borders[1:], count, strict=False)]
    return np.append(np.concatenate(inner), borders[-1])


def distances(points: Floats, path: Path, s: Floats | None = None) -> Floats:
    """Distance in X Y Z of each point to the path, shape (n,)."""
    at = samples(path) if s is None else s
    corners = path.evaluate(at)[0][:, :3]
    start, step = corners[:-1], np.diff(corners, axis=0)
    square = np.maximum(np.sum(step**2, axis=1), 1e-300)
    out = np.empty(len(points))
    for first in range(0, len(points), 200):
        some = points[first : first + 200, :3]
        away = some[:, None] - start
        share = np.clip(np.sum(away * step, axis=2) / square, 0, 1)
        gap = np.linalg.norm(away - share[..., None] * step, axis=2)
        few = np.argsort(gap, axis=1)[:, :4]
        best = np.full(len(some), np.inf)
        for k in few.T:
            low, high = at[k], at[k + 1]
            place = low + np.take_along_axis(share, k[:, None], 1)[:, 0] * (high - low)
            for _ in range(6):
                x, x1, x2 = path.evaluate(place, 2)[:, :, :3]
                miss = x - some
                best = np.minimum(best, np.linalg.norm(miss, axis=1))
                slope = np.sum(miss * x1, axis=1)
                bend = np.sum(x1 * x1, axis=1) + np.sum(miss * x2, axis=1)
                bend = np.where(bend > 0.1, bend, 1.0)
                place = np.clip(place - slope / bend, low, high)
        out[first : first + 200] = best
    return out
