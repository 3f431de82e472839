"""Lines within a tolerance of a path: arcs, helices and NURBS for controls that know G1 alone."""

from __future__ import annotations

import numpy as np

from cncgen.geometry.path import LINE, Path
from cncgen.geometry.tables import Floats, Ints

#: Halvings of a chord that misses; each divides its error by four.
_MAX_HALVINGS = 40
#: A first guess of the steps is taken from the curvature at this many places of a panel of the arc-length table.
_PROBES = 5


def linearize(path: Path, tolerance_mm: float, scale: Floats | None = None) -> tuple[Floats, Ints]:
    """Return points whose chords stay within a tolerance of a path.

    A chord of length h misses a curve by h² |x''| / 8 at most (Filip, Magedson and Markot 1986), so steps of √(8
    tolerance / |x''|) are laid along each stretch between the ends of rows and knots; where the middle of a chord still
    misses by more it is halved.

    Args:
        path: Any rows; the lines among them stay one chord each.
        tolerance_mm: Largest distance, over all axes multiplied by `scale` (1 where None), at equal s.
        scale: Shape (axes,).

    Returns:
        Points of shape (n, axes) after the start, the ends of rows among them, and the row of each, shape (n,).

    Raises:
        ValueError: If the tolerance is not positive.
    """
    if not tolerance_mm > 0:
        raise ValueError(f"the tolerance must be positive, not {tolerance_mm}")
    factor = np.ones(len(path.axes)) if scale is None else scale
    if path.length == 0.0:
        return path.end.copy(), np.arange(len(path))
    s = _laid(path, tolerance_mm, factor)
    for _ in range(_MAX_HALVINGS):
        middle = 0.5 * (s[1:] + s[:-1])
        chord = np.diff(path.evaluate(s)[0], axis=0)
        miss = path.evaluate(middle)[0] - (path.evaluate(s[:-1])[0] + 0.5 * chord)
        over = np.linalg.norm(miss * factor, axis=1) > tolerance_mm
        over &= path.kind[path.row_of(middle)] != LINE
        if not over.any():
            break
        s = np.sort(np.concatenate([s, middle[over]]))
    rows = path.row_of(s[1:], side=-1)
    points = path.evaluate(s[1:], 0, side=-1)[0]
    ends = np.isin(s[1:], path.row_s[1:])
    points[ends] = path.end[rows[ends]]
    return points, rows


def _laid(path: Path, tolerance: float, factor: Floats) -> Floats:
    """Return path coordinates in steps of the guess, every breakpoint among them."""
    borders = path.sample_borders()
    look = borders[:-1, None] + np.diff(borders)[:, None] * (np.arange(_PROBES) + 0.5) / _PROBES
    bend = np.linalg.norm(path.evaluate(look.ravel(), 2)[2] * factor, axis=1).reshape(look.shape).max(axis=1)
    steps = np.diff(borders) * np.sqrt(bend / (8.0 * tolerance))
    total = np.concatenate([[0.0], np.cumsum(steps)])
    stops = np.searchsorted(borders, path.breakpoints())
    # Nine tenths of the tolerance: the guess hardly ever has to be halved.
    counts = np.maximum(np.ceil(np.diff(total[stops]) / np.sqrt(0.9) - 1e-9), 1).astype(np.int64)
    out = [borders[:1]]
    for first, last, count in zip(stops[:-1], stops[1:], counts, strict=True):
        share = total[first] + (total[last] - total[first]) * np.arange(1, count) / count
        stretch = slice(first, last + 1)
        out += [np.interp(share, total[stretch], borders[stretch]), borders[last : last + 1]]
    return np.concatenate(out)
