"""The gate of a toolpath: every double of a program or a caller is finite and within the range of planning."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic
from cncgen.ranges import FEEDS, KNOT_PART, POSITION, TOLERANCE_MM, WEIGHT_RATIO
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_FAR = "was a decimal point lost, or is an offset wrong?"


def beyond_numbers(chunk: Toolpath) -> Iterator[Diagnostic]:
    """Yield a fault for the first row of each kind of number that is out of range (`cncgen.ranges`)."""
    yield from _places(chunk)
    yield from _feeds(chunk)
    yield from _arcs(chunk)
    if len(chunk.nurbs):
        yield from _curves(chunk)


def _places(chunk: Toolpath) -> Iterator[Diagnostic]:
    """Look at start and ends."""
    for column, letter in enumerate(chunk.axes):
        places = np.concatenate([chunk.start[None, column], chunk.end[:, column]])
        found = _first(~(np.abs(places) <= POSITION))
        if found is not None:
            yield _fault(
                chunk, max(found - 1, 0), f"axis {letter} is sent to", places[found], f"±{POSITION:g}", _FAR
            )


def _feeds(chunk: Toolpath) -> Iterator[Diagnostic]:
    """Look at feeds (0 is refused with its own words later) and tolerances."""
    low, high = FEEDS
    feed = chunk.feed
    moves = (chunk.kind != Kind.EVENT) & (chunk.feed_mode != FeedMode.RAPID) & (feed != 0.0)
    found = _first(moves & ~((feed >= low) & (feed <= high)))
    if found is not None:
        hint = "look at F, at its unit and at the spindle's speed"
        yield _fault(chunk, found, "the feed is", feed[found], f"{low:g} to {high:g}", hint, "a second")
    tolerance = chunk.tolerance
    found = _first(~np.isnan(tolerance) & ~((tolerance >= 0.0) & (tolerance <= TOLERANCE_MM)))
    if found is not None:
        hint = "P of G64 is a length"
        yield _fault(chunk, found, "the tolerance is", tolerance[found], f"0 to {TOLERANCE_MM:g}", hint)


def _arcs(chunk: Toolpath) -> Iterator[Diagnostic]:
    """Look at centres, normals and sweeps."""
    rows = np.flatnonzero(chunk.kind == Kind.ARC)
    index = chunk.curve[rows]
    centre = np.abs(chunk.arcs.centre[index]).max(axis=1, initial=0.0)
    found = _first(~(centre <= POSITION))
    if found is not None:
        yield _fault(chunk, int(rows[found]), "the arc's centre is at", centre[found], f"±{POSITION:g}", _FAR)
    found = _first(~np.isfinite(chunk.arcs.sweep[index] + chunk.arcs.normal[index].sum(axis=1)))
    if found is not None:
        sweep = chunk.arcs.sweep[index][found]
        yield _fault(chunk, int(rows[found]), "the arc turns by", sweep, "finite numbers", "", "rad")


def _curves(chunk: Toolpath) -> Iterator[Diagnostic]:
    """Look at control points, weights and knots of each curve."""
    table = chunk.nurbs
    rows = np.flatnonzero(chunk.kind == Kind.NURBS)
    index = chunk.curve[rows]
    first, last = table.point_offset[:-1], table.point_offset[1:] - 1
    far = np.maximum.reduceat(np.abs(table.control_points).max(axis=1), first)[index]
    found = _first(~(far <= POSITION))
    if found is not None:
        yield _fault(chunk, int(rows[found]), "a control point is at", far[found], f"±{POSITION:g}", _FAR)
    with np.errstate(all="ignore"):
        ratio = np.maximum.reduceat(table.weights, first) / np.minimum.reduceat(table.weights, first)
        ratio = ratio[index]
        whole = table.knots[table.knot_offset[1:] - 1] - table.knots[table.knot_offset[:-1]]
        part = _shortest_span(table.knots, table.knot_offset)[index] / whole[index]
    found = _first(~(ratio <= WEIGHT_RATIO))
    if found is not None:
        said = f"the weights of the curve ({last[index[found]] - first[index[found]] + 1} points) are in a ratio of"
        hint = "weights this far apart draw the curve to one point: leave control points out"
        yield _fault(chunk, int(rows[found]), said, ratio[found], f"1 to {WEIGHT_RATIO:g}", hint, "")
    found = _first(~(part >= KNOT_PART))
    if found is not None:
        said = "the nearest knots of the curve are apart by a part of all knots of"
        hint = "make the knots equal, or further apart"
        yield _fault(chunk, int(rows[found]), said, part[found], f"{KNOT_PART:g} to 1", hint, "")


def _shortest_span(knots: Floats, offset: NDArray[np.int64]) -> Floats:
    """Return the shortest distance of different knots of each curve, shape (m,)."""
    way = np.diff(knots, append=np.inf)
    way[offset[1:] - 1] = np.inf
    way[way == 0.0] = np.inf
    return np.minimum.reduceat(way, offset[:-1])


def _first(wrong: Flags) -> int | None:
    """Return the first place of a truth, or None."""
    return int(np.argmax(wrong)) if wrong.any() else None


def _fault(
    chunk: Toolpath, row: int, said: str, value: float, bound: str, hint: str, unit: str = "mm or rad"
) -> Diagnostic:
    message = " ".join(f"{said} {value:.9g} {unit}".split()) + f", not within {bound}"
    return Diagnostic(
        "number-range", message, span=chunk.span(row), hint=hint, values={"value": float(value)}
    )
