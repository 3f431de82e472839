"""The smooth spline within a corridor around pieces of a path: one window of it, and the start of the next window.

A smoothing spline after Schoenberg (1964), whose smoothing length L varies along the path, as large as the tolerance allows
(docs/smoothing.md). This module chooses how large L may be and tries again; the fit itself is the kernel `smoothing`. Called by
`cncgen.planner.smoothing.stream`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cncgen.geometry import elementary
from cncgen.geometry.columns import max_over_axes
from cncgen.geometry.pieces import Pieces
from cncgen.geometry.tables import Floats
from cncgen.kernels import smoothing

#: Control points that the curve shares with the path at a closed end: the end point, its direction too, or three derivatives.
END_POINT, END_TANGENT, END_DERIVATIVES = 1, 2, 4
#: Rounds in which the smoothing length may grow, and the part of the tolerance that the fit should use at least. The second line
#: is for up to `_FEW_PIECES`, where more rounds cost next to no time.
ROUNDS, _LEAST_USED = 2, 0.85
_FEW_PIECES, _ROUNDS_OF_FEW, _LEAST_USED_OF_FEW = 512, 8, 0.96
#: Knots are laid about a joint that is rounded by itself (docs/smoothing.md, Knots): both rows beside it are longer than the first
#: number times L, and its first guess of L is less than the second number times the largest L there (else other joints decide).
_SEPARATE, _DECISIVE = 2.5137, 4.0
#: L in the end as a part of the first guess, measured; and half of the knot span about a step of curvature, in L.
_FINAL_PART, _HALF_SPAN = 0.7, 0.35
#: Largest smoothing length: in tolerances; in mean lengths of the rows around, four on each side; and as a part of all that is
#: fitted. By then facets and noise are gone: a longer one would smooth the curve itself, and gain no time.
WIDEST, FACETS, AROUND, RUN_PART = 45.0, 1.5, 4, 0.1
#: Largest L³ κ² on a curve of curvature κ, in tolerances: a circle is missed by about 0.37 L³ κ² where it ends.
_END_ERROR = 1.0
#: Knot spans before an open end that the next window fits again. Later points have no influence on the spans before them.
OVERLAP = 24
#: Where a fit fails it is tried with the smoothing length multiplied by these factors (beside a seam: by the length of its spans).
_RETRY_FACTORS = 0.6, 0.3, 0.1
#: Parts of the tolerance that a fit may use: on new pieces, and on those that an earlier window has fitted too.
_USABLE_NEW, _USABLE_AGAIN = 0.985, 0.9985
#: An axis that stands in the path stands on the curve too where it is off by less than this part of the tolerance; and the slope,
#: mm per mm, below which an axis stands.
_STILL_OFFSET, _STILL_SLOPE = 1e-6, 1e-13


class CorridorError(RuntimeError):
    """No spline was found within the tolerance; carries the largest part of the tolerance used."""

    def __init__(self, used: float, spans: int) -> None:
        super().__init__(
            f"no smooth curve found within the tolerance: {used:.4f} of it used by {spans} spans"
        )
        self.used = used


@dataclass(frozen=True, slots=True)
class Seam:
    """Where a window left off: the last nine knots and four control points, t from the next window's first piece."""

    knots: Floats
    points: Floats


@dataclass(frozen=True, slots=True)
class Spline:
    """B-spline of degree 4 over pieces, from ``knots[4]`` to ``knots[-5]``.

    Attributes:
        knots: Shape (points + 5,), mm along the pieces.
        points: Shape (points, axes), scaled as the pieces.
        used: Largest part of the tolerance that is used.
        deviation: Shape (n,), mm: bound of its distance from each piece.
    """

    knots: Floats
    points: Floats
    used: float
    deviation: Floats

    @property
    def spans(self) -> int:
        """Number of knot spans."""
        return len(self.points) - smoothing.DEGREE


def fit(
    pieces: Pieces,
    cuts: Floats,
    head: int,
    tail: int,
    seam: Seam | None = None,
    widest: float = WIDEST,
) -> Spline:
    """Fit the smoothest spline to pieces that stays within their tolerance.

    Args:
        pieces: The path to follow; with a seam, from the piece in which it lies.
        cuts: Places along the pieces, ascending, that are to be knots.
        head: `END_POINT`, `END_TANGENT` or `END_DERIVATIVES` at the start; not used with a seam.
        tail: The same at the end, or 0 where the curve will go on.
        seam: The state from which the curve goes on.
        widest: Largest smoothing length, in tolerances: a longer one takes fewer knots, a shorter one is faster.

    Raises:
        CorridorError: If the tolerance cannot be held.
    """
    longest = _longest(pieces, widest)
    cuts = np.union1d(cuts, _about_joints(pieces, longest))
    for part in (1.0, *_RETRY_FACTORS):
        spline = _attempt(
            pieces, cuts, head, tail, seam, longest if part == 1.0 else _cut(pieces, seam, longest, part)
        )
        if spline.used <= 1.0:
            return spline
    raise CorridorError(spline.used, spline.spans)


def _cut(pieces: Pieces, seam: Seam | None, longest: Floats, part: float) -> Floats:
    """Return the largest smoothing lengths of a further try, smaller by the factor `part`.

    With a seam only those near it shrink, to a part of its knot spans. The knots before the seam are given, and held the tolerance
    with the control points that followed them in the last window. Other points may not, so shorter lengths are needed behind it.
    """
    if seam is None:
        return part * longest
    spans = seam.knots[-1] - seam.knots[4]
    near = pieces.t < seam.knots[-1] + spans
    return np.where(near, np.minimum(longest, part * spans / 4.0), longest)


def _attempt(
    pieces: Pieces, cuts: Floats, head: int, tail: int, seam: Seam | None, longest: Floats
) -> Spline:
    """Fit as `fit` does, with the largest smoothing lengths at the ends of pieces given; more of the tolerance may be used."""
    t, axes, total = pieces.t, pieces.y.shape[2], pieces.t[-1]
    laid = 4 if seam is None else 8
    start = t[0] if seam is None else seam.knots[-1]
    places = np.append(cuts[(cuts > start + 1e-9 * (total - t[0])) & (cuts < total)], total)
    rounds, least = (
        (_ROUNDS_OF_FEW, _LEAST_USED_OF_FEW) if len(pieces.y) <= _FEW_PIECES else (ROUNDS, _LEAST_USED)
    )
    scale = np.minimum(first_lengths(pieces), longest)
    share = np.where(t[:-1] < start, _USABLE_AGAIN, _USABLE_NEW) if seam is not None else _USABLE_NEW
    used = np.empty((len(pieces.y), 2))
    # Taken from the start of the window, so that rounding is that of its size, and an axis that stands is 0.
    origin = pieces.y[0, 0].copy()
    y = pieces.y.copy()
    y[:, 0] -= origin
    room = 4 * len(pieces.y) + 4 * len(places) + 256
    allowed = pieces.tolerance * share
    while True:
        knots, fixed, points = np.zeros(room), np.zeros((room, axes)), np.zeros((room, axes))
        if seam is None:
            knots[:5] = t[0]
        else:
            knots[:9], fixed[:4] = seam.knots, seam.points - origin
        last, worst = smoothing.fit(
            t,
            y,
            pieces.bend,
            allowed,
            places,
            scale.copy(),
            longest,
            rounds,
            least,
            knots,
            laid,
            fixed,
            head if seam is None else 4,
            tail,
            points,
            used,
        )
        if last >= 0:
            break
        room *= 2
    knots, points = knots[: last + 5].copy(), points[:last].copy()
    _stand(t, y, knots, points, _STILL_OFFSET * pieces.tolerance.min())
    points += origin
    if seam is not None:
        points[:4] = seam.points
    return Spline(knots, points, worst, allowed * max_over_axes(used))


def first_lengths(pieces: Pieces) -> Floats:
    """Guess the smoothing length at the ends of pieces, shape (n + 1,), mm: that of the turn and of the step there."""
    out = np.full(len(pieces.t), 1e9)
    out[1:-1] = np.minimum(pieces.for_turn, pieces.for_step)[:-1]
    return out


def _about_joints(pieces: Pieces, longest: Floats) -> Floats:
    """Return where knots are laid about joints that are rounded by themselves, mm.

    How fast the curve is passed there depends on where its knots are, since its third derivative is linear between them. At a
    turn that changes its sign: a knot stands there. At a step of curvature it is largest: a span lies about it. If knots were
    only counted on from the start, they could be anywhere, and a little more tolerance could take longer.

    Args:
        pieces: See `fit`.
        longest: Shape (n + 1,), the largest smoothing lengths at the ends of pieces, mm.
    """
    joint = np.flatnonzero(np.diff(pieces.row, prepend=-1))[1:]
    by_turn, by_step = pieces.for_turn[joint - 1], pieces.for_step[joint - 1]
    guess, length = np.minimum(by_turn, by_step), np.diff(pieces.row_t)
    left = np.minimum(_FINAL_PART * guess, longest[joint])
    lone = np.minimum(length[1:], length[:-1]) > _SEPARATE * left
    lone &= guess < _DECISIVE * longest[joint]
    turn, step = lone & (by_turn <= by_step), lone & (by_turn > by_step)
    at, half = pieces.t[joint], _HALF_SPAN * left[step]
    return np.concatenate([at[turn], at[step] - half, at[step] + half])


def _stand(t: Floats, y: Floats, knots: Floats, points: Floats, near: float) -> None:
    """Let axes stand, in `points`, where they do in the pieces and the curve is `near` them, mm.

    At a distance the effect of a bend is far below the tolerance; further away it is rounding. It would be a motion of an axis
    that does not move.
    """
    moves = np.abs(y[:, 1:]).max(axis=1) > _STILL_SLOPE
    axes = np.flatnonzero(~moves.all(axis=0))
    if not axes.size:
        return
    moves = moves[:, axes]
    # Pieces that a control point is attracted by, and whether the axis stands on all of them.
    first = np.clip(np.searchsorted(t, knots[: len(points)], side="right") - 1, 0, len(y) - 1)
    last = np.clip(np.searchsorted(t, knots[5:], side="left"), first + 1, len(y))
    # After each piece, how many of them the axis moves on, and behind which one it moved last.
    moved, since = np.zeros((2, len(y) + 1, len(axes)), np.int64)
    np.cumsum(moves, axis=0, out=moved[1:])
    np.maximum.accumulate(np.where(moves, np.arange(1, len(y) + 1)[:, None], 0), axis=0, out=since[1:])
    # The same number on all pieces of a stretch: arcs carry rounding.
    place = y[np.minimum(since[first + 1], len(y) - 1), 0, axes]
    stands = (moved[last] == moved[first]) & (np.abs(points[:, axes] - place) < near)
    points[:, axes] = np.where(stands, place, points[:, axes])


def _longest(pieces: Pieces, widest: float) -> Floats:
    """Return the largest smoothing length at the ends of pieces, shape (n + 1,), mm."""
    length = np.diff(pieces.row_t)[pieces.row]
    n = len(length)
    summed = np.concatenate([[0.0], np.cumsum(length)])
    first = np.maximum(np.arange(n + 1) - AROUND, 0)
    last = np.minimum(np.arange(n + 1) + AROUND, n)
    facets = FACETS * (summed[last] - summed[first]) / (last - first)
    tolerance = np.maximum(np.append(pieces.tolerance, 0.0), np.append(0.0, pieces.tolerance))
    out: Floats = np.minimum(np.maximum(widest * tolerance, facets), RUN_PART * (pieces.t[-1] - pieces.t[0]))
    bends = np.append(_bends(pieces), np.inf)
    return np.minimum(out, np.minimum(bends, np.roll(bends, 1)))


def _bends(pieces: Pieces) -> Floats:
    """Return the smoothing length that circles allow, by pieces, shape (n,), mm.

    Where a curve of curvature κ ends, or L changes, the spline leaves it by about 0.37 L³ κ²; an arc shorter than L acts as a
    turn, and is left by L Δx'/3. That falls so fast with L that iterating from a larger L would oscillate, so L begins below it.
    """
    kappa = pieces.bend + 1e-9 / pieces.tolerance
    turn = kappa * np.diff(pieces.row_t)[pieces.row]
    out: Floats = np.maximum(
        elementary.cbrt(_END_ERROR * pieces.tolerance / kappa**2), 6.0 * pieces.tolerance / turn
    )
    return out


def split(spline: Spline, span: int, origin: float) -> tuple[Spline, Seam]:
    """Return the first `span` spans of a spline, and the seam to go on from, its t counted from `origin`."""
    at = 4 + span
    done = Spline(spline.knots[: at + 5], spline.points[:at], spline.used, spline.deviation)
    return done, Seam(spline.knots[at - 4 : at + 5] - origin, spline.points[at - 4 : at])
