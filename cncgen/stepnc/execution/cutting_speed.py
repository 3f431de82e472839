"""A constant cutting speed: the spindle speed changes with the distance from the axis of the work."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np

from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Piece, Polyline
from cncgen.stepnc.model import Technology

#: Smallest radius that a constant cutting speed is kept at, and how much the radius may change at one feed, mm.
LEAST_RADIUS = 0.1
LONGEST_TURN = 0.5
#: Chords of arcs at a constant cutting speed, mm.
CHORD = 1e-3


def radius(piece: Piece) -> float:
    """Return the distance of the middle of a piece from the axis of the work, X 0 Y 0, mm."""
    points = polyline_of(piece, LONGEST_TURN).points
    return float(np.hypot(*((points[0] + points[-1]) / 2)[:2]))


def spindle_at(technology: Technology, distance: float) -> float:
    """Return the spindle speed of a constant cutting speed at a distance from the axis, rev/s with the sign of ISO 14649 (clockwise)."""
    return technology.spindle_at(2 * max(distance, LEAST_RADIUS))


def at_diameter(technology: Technology, pieces: list[Piece]) -> tuple[Technology, Technology | None]:
    """Return a technology with the spindle speed where pieces begin, and itself if its cutting speed is constant."""
    if technology.cutting_speed is None or technology.spindle is not None or not pieces:
        return technology, None
    begin = float(np.hypot(*pieces[0].start[:2]))
    return replace(technology, spindle=spindle_at(technology, begin), cutting_speed=None), technology


def stretches(piece: Piece) -> list[Piece]:
    """Return a piece in parts over which the distance from the axis changes by `LONGEST_TURN` at most."""
    points = piece.points if isinstance(piece, Polyline) else polyline_of(piece, CHORD).points
    out: list[Piece] = []
    for a, b in itertools.pairwise(points):
        change = abs(float(np.hypot(*b[:2]) - np.hypot(*a[:2])))
        n = max(math.ceil(change / LONGEST_TURN), 1)
        steps = a + np.linspace(0.0, 1.0, n + 1)[:, None] * (b - a)
        out += [Polyline(np.stack(pair)) for pair in itertools.pairwise(steps)]
    return out
