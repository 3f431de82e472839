"""Judges setpoints against the path that was meant and the machine's limits, by means that share nothing with cncgen.

Limits: finite differences. Distances: every setpoint and the middle of every chord from the curves, every sample of the
curves from the chords; found on polylines, and where it matters measured on the curve itself. The order in which the path is
gone along is not looked at (`cncgen.judge` does).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from trials.generators.elements import Feed, Floats, Piece, Writer
from trials.generators.meant_programs import Rig

#: Allowance beyond a limit, a tolerance or a feed, as a part of it.
MARGIN = 1e-3
#: Of setpoints, as they are computed: a part of their size.
ROUNDING = 1e-12
#: Degrees a millimetre from which controls differ on what F is of.
STEEP = 1000.0
#: Setpoints beyond which distances are not looked at: it takes too long.
MOST = 40_000
#: Pairs of points and segments that are compared outright.
FEW = 4_000_000
#: Nearest middles of segments looked at first.
NEIGHBOURS = 24
#: Tolerances within which a polyline is near a point: it is less than 0.1 of one from its curve.
NEAR = 1.5
#: Samples of each piece that are looked for on the chords.
SAMPLES = 1500


@dataclass(frozen=True)
class Fault:
    """What is broken: a short name, by how much (1 is the most that is allowed), and the figures in words."""

    name: str
    amount: float
    text: str

    def __str__(self) -> str:
        return f"{self.name} {self.amount:.6g}: {self.text}"


def to_segments(points: Floats, a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    """Return distances of points, shape (n, d), from segments between a and b, pair by pair, and where on these (0 to 1)."""
    along = b - a
    square = np.maximum((along**2).sum(axis=-1), 1e-300)
    u = np.clip(((points - a) * along).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(points - a - u[..., None] * along, axis=-1), u, square


def nearest(points: Floats, a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    """Return of each point the distance from the nearest of the segments, its number, and where on it.

    Args:
        points: Shape (n, d).
        a, b: Ends of the segments, shape (m, d).
    """
    if len(points) * len(a) < FEW:
        return _compared(points, a, b)
    length = np.linalg.norm(b - a, axis=1)
    step = max(length.sum() / (4 * len(a) + 1000), 1e-12)
    parts = np.maximum(1, np.ceil(length / step).astype(int))
    which = np.repeat(np.arange(len(a)), parts)
    k = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    ends = [a[which] + (b - a)[which] * ((k + e) / parts[which])[:, None] for e in (0, 1)]
    tree = cKDTree(0.5 * (ends[0] + ends[1]))
    half = 0.5 * np.linalg.norm(ends[1] - ends[0], axis=1).max()
    count = min(NEIGHBOURS, len(which))
    middles, near = tree.query(points, k=count)
    middles, near = middles.reshape(len(points), -1), near.reshape(len(points), -1)
    found = to_segments(points[:, None], ends[0][near], ends[1][near])
    best = found[0].argmin(axis=1)
    row = np.arange(len(points))
    distance, piece, u = found[0][row, best], near[row, best], found[1][row, best]
    # Where the last of these middles is near, a segment further down the list may be nearer.
    for i in np.flatnonzero(middles[:, -1] < distance + half) if count == NEIGHBOURS else ():
        more = np.array(tree.query_ball_point(points[i], distance[i] + half))
        found = to_segments(points[i], ends[0][more], ends[1][more])
        best = found[0].argmin()
        if found[0][best] < distance[i]:
            distance[i], piece[i], u[i] = found[0][best], more[best], found[1][best]
    return distance, which[piece], (k[piece] + u) / parts[which[piece]]


def _compared(points: Floats, a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    distance, which, where = np.empty(len(points)), np.empty(len(points), int), np.empty(len(points))
    for i in range(0, len(points), 200):
        found = to_segments(points[i : i + 200, None], a[None], b[None])
        best = found[0].argmin(axis=1)
        row = np.arange(len(best))
        distance[i : i + 200], which[i : i + 200] = found[0][row, best], best
        where[i : i + 200] = found[1][row, best]
    return distance, which, where


def closest(piece: Piece, point: Floats, u: float, reach: float) -> float:
    """Return the distance of a point from a curve near u, by ever finer samples."""
    for _ in range(6):
        at = np.linspace(max(u - reach, 0.0), min(u + reach, 1.0), 65)
        distance = np.linalg.norm(piece.curve(at) - point, axis=1)
        u, reach = float(at[distance.argmin()]), reach / 16.0
    return float(distance.min())


class Path:
    """The path that is meant, as polylines, with the tolerance of each part."""

    def __init__(self, pieces: Sequence[Piece], rig: Rig) -> None:
        self.pieces = pieces
        self.points = [piece.points for piece in pieces]
        asked = [rig.path_mm if piece.tolerance is None else piece.tolerance for piece in pieces]
        self.tolerance = np.maximum(asked, rig.chord_mm)
        count = [len(points) - 1 for points in self.points]
        self.piece = np.repeat(np.arange(len(pieces)), count)
        self.first = np.repeat(np.cumsum(count) - count, count)
        self.a = np.concatenate([points[:-1] for points in self.points])
        self.b = np.concatenate([points[1:] for points in self.points])

    def excess(self, x: Floats) -> Floats:
        """Return the distances of points from the path, as parts of the tolerance there, shape (n,)."""
        ratio = np.full(len(x), np.inf)
        per = self.tolerance[self.piece]
        for tolerance in np.unique(per):
            mine = np.flatnonzero(per == tolerance)
            distance, which, where = nearest(x, self.a[mine], self.b[mine])
            segment = mine[which]
            for i in np.flatnonzero((distance > 0.9 * tolerance) & (distance < ratio * tolerance)):
                piece = self.pieces[self.piece[segment[i]]]
                if len(piece.u) > 2:
                    k = segment[i] - self.first[segment[i]]
                    reach = 2.0 * (piece.u[k + 1] - piece.u[k])
                    u = piece.u[k] + where[i] * (piece.u[k + 1] - piece.u[k])
                    distance[i] = closest(piece, x[i], u, reach)
            ratio = np.minimum(ratio, distance / tolerance)
        # Of turns that lie closer together than polylines tell, another one may be the nearest: asked of the largest alone.
        while len(ratio) and ratio[worst := int(ratio.argmax())] > 1.0:
            found = self._elsewhere(x[worst], per)
            if found >= ratio[worst]:
                break
            ratio[worst] = found
        return ratio

    def _elsewhere(self, point: Floats, per: Floats) -> float:
        """Return the least distance of a point from the curves, at all places where their polylines come near it.

        Args:
            point: Shape (axes,).
            per: The tolerance of each segment.

        Returns:
            As a part of the tolerance there; infinite where none comes near.
        """
        distance, where, _ = to_segments(point, self.a, self.b)
        padded = np.concatenate([[np.inf], distance, [np.inf]])
        least = (distance <= padded[:-2]) & (distance <= padded[2:]) & (distance < NEAR * per)
        ratio = np.inf
        for i in np.flatnonzero(least):
            piece = self.pieces[self.piece[i]]
            k = i - self.first[i]
            step = piece.u[k + 1] - piece.u[k]
            here = (
                closest(piece, point, piece.u[k] + where[i] * step, 2.0 * step)
                if len(piece.u) > 2
                else distance[i]
            )
            ratio = min(ratio, float(here / per[i]))
        return ratio

    def samples(self) -> tuple[Floats, Floats]:
        """Return points of the path, and the tolerance of each: at an end of a piece the wider of both sides."""
        points, tolerance = [], []
        for i, (samples, own) in enumerate(zip(self.points, self.tolerance, strict=True)):
            if len(samples) == 2:
                samples = samples[0] + np.linspace(0.0, 1.0, 9)[:, None] * (samples[1] - samples[0])
            keep = np.unique(
                np.append(np.arange(0, len(samples), max(1, len(samples) // SAMPLES)), len(samples) - 1)
            )
            points.append(samples[keep])
            here = np.full(len(keep), own)
            here[0] = max(own, self.tolerance[max(i - 1, 0)])
            here[-1] = max(own, self.tolerance[min(i + 1, len(self.tolerance) - 1)])
            tolerance.append(here)
        return np.concatenate(points), np.concatenate(tolerance)


def limit_faults(x: Floats, axes: str, rig: Rig, margin: float = MARGIN) -> list[Fault]:
    """Judge first to third differences of setpoints, shape (n, axes), at rest before and after."""
    period = rig.period_s
    at_rest = np.concatenate([np.repeat(x[:1], 3, axis=0), x, np.repeat(x[-1:], 3, axis=0)])
    faults = []
    for order, name in enumerate(("velocity", "acceleration", "jerk"), 1):
        found = np.abs(np.diff(at_rest, order, axis=0)) / period**order
        noise = 2.0**order * ROUNDING * max(1.0, float(np.abs(x).max())) / period**order
        for i, letter in enumerate(axes):
            limit = rig.limits[letter][order - 1]
            k = int(found[:, i].argmax())
            if found[k, i] > limit * (1.0 + margin) + noise:
                ratio = found[k, i] / limit
                faults.append(
                    Fault(
                        f"{name} of {letter}",
                        ratio,
                        f"{found[k, i]:.6g} of {limit:.6g} at setpoint {k} of {len(x)}",
                    )
                )
    return faults


def path_faults(x: Floats, path: Path) -> list[Fault]:
    """Judge the distances of setpoints (and middles of chords) and path, both ways."""
    if len(x) > MOST:
        return []
    fine = np.concatenate([x, 0.5 * (x[1:] + x[:-1])])
    size = max(1.0, float(np.abs(x).max()))
    slack = MARGIN + 1e-9 * size / path.tolerance.min()
    faults = []
    ratio = path.excess(fine)
    k = int(ratio.argmax())
    if ratio[k] > 1.0 + slack:
        place = f"setpoint {k}" if k < len(x) else f"chord {k - len(x)}"
        faults.append(Fault("distance", float(ratio[k]), f"{place} of {len(x)} at {np.round(fine[k], 6)}"))
    samples, tolerance = path.samples()
    a, b = (x[:-1], x[1:]) if len(x) > 1 else (x, x)
    away = nearest(samples, a, b)[0] / tolerance
    k = int(away.argmax())
    if away[k] > 1.0 + slack:
        faults.append(Fault("coverage", float(away[k]), f"the path at {np.round(samples[k], 6)}"))
    return faults


def end_faults(x: Floats, times: Floats, to: Writer, rig: Rig) -> list[Fault]:
    """Judge where the setpoints begin and end, and that they are a period apart."""
    first, last = to.pieces[0].curve(np.array([0.0]))[0], to.pieces[-1].curve(np.array([1.0]))[0]
    faults = []
    far = max(float(np.abs(x[0] - first).max()), float(np.abs(x[-1] - last).max()))
    if far > 1e-9 * max(1.0, float(np.abs(x).max())):
        faults.append(Fault("ends", far / 1e-9, f"{x[0] - first} at the start, {x[-1] - last} at the end"))
    if len(times) > 1 and not np.allclose(np.diff(times), rig.period_s, rtol=1e-6, atol=1e-12):
        faults.append(
            Fault("period", 2.0, f"{np.diff(times).min()} to {np.diff(times).max()}, not {rig.period_s}")
        )
    return faults


def feed_faults(x: Floats, to: Writer, rig: Rig) -> list[Fault]:
    """Judge the speed in X Y Z (U V W) against the largest feed of the program, where all motions have one."""
    feeds = [piece.feed for piece in to.pieces]
    if any(feed.kind != "minute" for feed in feeds) or len(x) < 2:
        return []
    for family in ("XYZ", "UVW"):
        columns = [i for i, letter in enumerate(to.axes) if letter in family]
        if columns:
            if any(letter not in family and letter not in "ABC" for letter in to.axes):
                return []  # F is of either
            if any(np.ptp(piece.points[:, columns], axis=0).max() == 0.0 for piece in to.pieces):
                return []  # and degrees a minute
            allowed = max(feed.value for feed in feeds) / 60.0
            speed = np.linalg.norm(np.diff(x[:, columns], axis=0), axis=1).max() / rig.period_s
            noise = 2.0 * ROUNDING * max(1.0, float(np.abs(x).max())) / rig.period_s
            if speed > allowed * (1.0 + MARGIN) + noise:
                return [Fault("feed", speed / allowed, f"{speed:.6g} of {allowed:.6g} mm/s")]
            return []
    return []


def least_time(to: Writer, rig: Rig) -> float:
    """Return a time, s, that no plan can be below: dwells, and what motions on their path take at feed and full speed.

    Motions of G64 may be cut short by twice their tolerance at each end and are only counted on exact paths.
    """
    total = to.waits
    for piece in to.pieces:
        if not piece.exact:
            continue
        points = piece.points
        steps = np.abs(np.diff(points, axis=0))
        speeds = np.array([rig.limits[letter][0] for letter in to.axes])
        best = float((steps / speeds).max(axis=1).sum())
        total += max(best, _asked(piece.feed, steps, to.axes))
    return total


def _asked(feed: Feed, steps: Floats, axes: str) -> float:
    """Return the least time of a motion by its feed, s: along X Y Z, else U V W, else the rotary axes."""
    if feed.kind == "traverse":
        return 0.0
    if feed.kind == "time":
        return feed.value if steps.any() else 0.0
    length = {}
    for family in ("XYZ", "UVW", "ABC"):
        columns = [i for i, letter in enumerate(axes) if letter in family]
        length[family] = float(np.linalg.norm(steps[:, columns], axis=1).sum())
    for way in length.values():
        if way > 0.0:
            steep = any(other > STEEP * way for other in length.values())
            return 0.0 if steep else 60.0 * way / feed.value
    return 0.0


def time_faults(x: Floats, to: Writer, rig: Rig) -> list[Fault]:
    """Judge whether the motion takes the time at least that dwells, feeds and velocities ask for."""
    taken, least = (len(x) - 1) * rig.period_s, least_time(to, rig)
    # A motion may end between two setpoints; of the least time samples of curves miss some 1e-6.
    if taken < least * (1.0 - MARGIN) - 2.0 * rig.period_s:
        return [
            Fault("time", least / max(taken, 1e-12), f"{taken:.9g} s, {least:.9g} s at feed and full speed")
        ]
    return []


def judged(x: Floats, times: Floats, to: Writer, rig: Rig) -> list[Fault]:
    """Return all that is broken.

    Args:
        x: Setpoints, shape (n, axes), mm and degrees, in the order of the writer's axes.
        times: Shape (n,), s.
        to: The program as written.
        rig: The machine.
    """
    faults = limit_faults(x, to.axes, rig) + end_faults(x, times, to, rig)
    if len(x) <= MOST:
        faults += path_faults(x, Path(to.pieces, rig))
    return faults + feed_faults(x, to, rig) + time_faults(x, to, rig)
