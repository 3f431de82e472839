"""Lines within a tolerance of a path: arcs, helices and NURBS for readers of lines alone."""

from __future__ import annotations

import numpy as np

from cncgen.geometry.path import LINE, NURBS, Path
from cncgen.geometry.tables import Floats, Ints

#: Halvings of a chord that misses; each divides its error by four.
_MAX_HALVINGS = 40
#: A first guess of the steps is taken from the curvature at this many places of a panel of the arc-length table.
_PROBES = 5
#: Part of the tolerance that the guess asks for: it hardly ever has to be halved.
_GUESSED = 0.9


def linearize(path: Path, tolerance_mm: float, scale: Floats | None = None) -> tuple[Floats, Ints]:
    """Return points whose chords stay within a tolerance of a path; see `chords`.

    Args:
        path: Any rows; the lines among them stay one chord each.
        tolerance_mm: Largest distance, over all axes multiplied by `scale` (1 where None), at equal parameters.
        scale: Shape (axes,).

    Returns:
        Points of shape (n, axes) after the start, the ends of rows among them, and the row of each, shape (n,).

    Raises:
        ValueError: If the tolerance is not positive.
    """
    if not tolerance_mm > 0:
        raise ValueError(f"the tolerance must be positive, not {tolerance_mm}")
    factor = np.ones(len(path.axes)) if scale is None else scale
    curved = np.flatnonzero((path.kind != LINE) & (path.row_length > 0.0))
    of, far, x = chords(path, curved, np.full(len(curved), tolerance_mm), factor)
    inner = far > 0.0
    # A chord that begins inside of a row ends the one before it.
    row = np.concatenate([np.arange(len(path)), curved[of[inner]]])
    order = np.lexsort((np.concatenate([np.ones(len(path)), far[inner]]), row))
    return np.concatenate([path.end, x[inner]])[order], row[order]


def chords(path: Path, rows: Ints, tolerance: Floats, scale: Floats) -> tuple[Ints, Floats, Floats]:
    """Return where chords of arcs and NURBS begin that stay within a tolerance of them.

    A chord over h of the parameter misses a curve by h² |x''| / 8 at most (Filip, Magedson and Markot 1986), so steps of √(8
    tolerance / |x''|) are laid along each arc and panel; where the middle of a chord still misses by more it is halved.

    Args:
        path: The path.
        rows: Shape (k,): rows of it, none a line, ascending.
        tolerance: Shape (k,): largest distance of each at equal parameters, over all axes multiplied by `scale`.
        scale: Shape (axes,).

    Returns:
        Which of `rows` each chord is of, shape (n,), from which part of that row's parameter on, and from which point, shape (n, axes).
    """
    splines = np.flatnonzero(path.kind[rows] == NURBS)
    of, begin, width = path.panels(rows[splines])
    of, begin, width = of[width > 0.0], begin[width > 0.0], width[width > 0.0]
    others = np.flatnonzero(path.kind[rows] != NURBS)
    of = np.concatenate([others, splines[of]])
    begin = np.concatenate([np.zeros(len(others)), begin])
    width = np.concatenate([path.row_length[rows[others]], width])
    first = path.parameter_after(rows, np.zeros(len(rows)))
    whole = path.parameter_after(rows, path.row_length[rows], -1) - first
    low, high = (
        # A curve so short that its parameters are one number has one chord.
        np.divide(
            path.parameter_after(rows[of], at, side) - first[of],
            whole[of],
            np.zeros(len(of)),
            where=whole[of] != 0.0,
        )
        for at, side in ((begin, 1), (begin + width, -1))
    )

    def at(of: Ints, far: Floats, order: int = 0) -> Floats:
        return path.evaluate_parameter(rows[of], first[of] + far * whole[of], order)[order]

    look = low + (high - low) * (np.arange(_PROBES)[:, None] + 0.5) / _PROBES
    bend = np.stack([np.linalg.norm(at(of, far, 2) * scale, axis=1) for far in look]).max(axis=0, initial=0.0)
    steps = np.abs((high - low) * whole[of]) * np.sqrt(bend / (8.0 * _GUESSED * tolerance[of]))
    count = np.maximum(np.ceil(steps - 1e-9), 1).astype(np.int64)
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    of, each = np.repeat(of, count), np.repeat((high - low) / count, count)
    low, high = np.repeat(low, count) + number * each, np.repeat(low, count) + (number + 1) * each
    x0, x1 = at(of, low), at(of, high)
    done = []
    for halvings in range(_MAX_HALVINGS + 1):
        middle = 0.5 * (low + high)
        x = at(of, middle)
        over = np.linalg.norm((x - 0.5 * (x0 + x1)) * scale, axis=1) > tolerance[of]
        over &= halvings < _MAX_HALVINGS
        done.append((of[~over], low[~over], x0[~over]))
        if not over.any():
            break
        of = np.tile(of[over], 2)
        low, high = np.concatenate([low[over], middle[over]]), np.concatenate([middle[over], high[over]])
        x0, x1 = np.concatenate([x0[over], x[over]]), np.concatenate([x[over], x1[over]])
    of, low, x0 = (np.concatenate(parts) for parts in zip(*done, strict=True))
    order = np.lexsort((low, of))
    return of[order], low[order], x0[order]
