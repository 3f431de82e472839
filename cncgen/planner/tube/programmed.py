"""The programmed rows as a stream; the tolerance is measured from them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.linearize import chords
from cncgen.geometry.path import STANDSTILL, Path
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.smoothing.runs import SHARPEST, loose, rapid, rests
from cncgen.ranges import FEEDS
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from cncgen.units import DEGREE

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Lines stand for a curve within this part of its tolerance.
_CHORD = 0.002
#: Part of the tolerance that is planned with: with what motions may pass it by, and lines and phases of setpoints miss, it is all.
USED = 0.994
#: A joint where the tangent turns by less, rad, and where curvature changes by less than this part of it, is one row cut in parts.
_STRAIGHT, _SAME_BEND = 1e-5, 1e-3
#: A place on a curve is found once a step goes less far, mm: its distance is then good to 10⁻¹² mm.
_FOUND = 1e-7
#: Steps that are gone for it at most; and by which part more a square of a distance may be and still be the same but for rounding.
_STEPS, _ROUNDED = 12, 1e-6


@dataclass(slots=True)
class _Chunk:
    path: Path
    first: int
    rows: Ints


@dataclass(frozen=True, slots=True)
class RowLines:
    """Rows as `m` lines.

    Attributes:
        points: Shape (m + 1, axes), vertices, scaled.
        key: Shape (m + 1,), ascending: the row of each and how far along its parameter it is.
        tolerance: Shape (m,), mm.
    """

    points: Floats
    key: Floats
    tolerance: Floats

    def since(self, key: float) -> RowLines:
        """Return the lines from the one that begins at a key."""
        first = int(np.searchsorted(self.key, key))
        return RowLines(self.points[first:], self.key[first:], self.tolerance[first:])


class Programmed:
    """Moving rows of the program, from `base` on; numbers of rows count from the start of the program.

    Columns by row: `line`, `length`, `curved`, `source`, `feed` (mm/s), `bound` and `over` (mm/s, over which of `metric_columns`), `least` (s), `tolerance` (mm), `free` (planned within the tolerance), `entry` and `leave`
    (unit tangents, scaled), `bent` (curvature at its end), `turn` (of an arc, mm; infinite for others), `stop` (the motion rests at its start), `rest` (it does so for an event
    or an exact stop), `exact` (no tolerance applies), `met` (the plan meets its start exactly), `joint` (it does not go on as the row before it does), `start` and `end` (scaled).
    """

    def __init__(self, chord_mm: float, fastest: float = FEEDS[1]) -> None:
        """Begin; `fastest` is the speed, mm/s, that the axes allow at most."""
        self.base = 0
        self.ended = False
        self.axes = ""
        self.scale: Floats = np.ones(0)
        #: mm by which a radian of a rotary axis counts.
        self.radius = 1.0 / DEGREE
        self._chord, self._fastest = chord_mm, fastest
        self._chunks: list[_Chunk] = []
        self._columns: dict[str, list[np.ndarray]] = {}
        # The first row whose curve is whole yet; of chords that do not begin a row: its number, the part of its parameter where the
        # chord begins, and that point, scaled.
        self._whole = 0
        self._chords: tuple[Ints, Floats, Floats] = np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 0))
        self._rest = True
        self._waiting: list[Toolpath] = []
        self.sources: tuple[str, ...] = ()

    def over(self, chunks: Iterable[Toolpath]) -> Iterator[Toolpath]:
        """Hand on chunks, and keep them."""
        for chunk in chunks:
            self._waiting.append(chunk)
            yield chunk

    def draw(self) -> None:
        """Add the motion that was handed on since."""
        while self._waiting:
            self._add(self._waiting.pop(0))

    def leave(self) -> None:
        """Leave out the motion that was handed on since: the plan is kept."""
        self._waiting.clear()

    def __len__(self) -> int:
        return sum(len(part) for part in self._columns.get("line", ()))

    def column(self, name: str) -> np.ndarray:
        """Return a column from row `base` on."""
        parts = self._columns.get(name)
        if not parts:
            return (
                np.zeros((0, len(self.scale)))
                if name in ("start", "end", "entry", "leave", "bent")
                else np.zeros(0)
            )
        if len(parts) > 1:
            parts[:] = [np.concatenate(parts)]
        return parts[0]

    def joints(self, rows: slice) -> Floats:
        """Return where rows, counted from `base`, begin and the last one ends, shape (rows + 1, axes)."""
        return np.concatenate([self.column("start")[rows], self.column("end")[rows][-1:]])

    def turns(self, rows: slice) -> Floats:
        """Return how far rows, counted from `base`, turn from the one before: size of the change of the tangent, 0 at both ends, shape (rows + 1,)."""
        change = self.column("entry")[rows][1:] - self.column("leave")[rows][:-1]
        return np.pad(np.sqrt((change**2).sum(axis=1)), 1)

    def forget(self, row: int) -> None:
        """Forget the rows before `row`."""
        drop = row - self.base
        if drop <= 0:
            return
        for name in self._columns:
            self._columns[name] = [self.column(name)[drop:].copy()]
        self.base = row
        while self._chunks and self._chunks[0].first + len(self._chunks[0].rows) <= row:
            self._chunks.pop(0)

    def _add(self, toolpath: Toolpath) -> None:
        if not self.axes:
            self.axes, self.scale = toolpath.axes, axis_scale(toolpath.axes, toolpath.degree_mm)
            self.radius = toolpath.degree_mm / DEGREE
            self._chords = *self._chords[:2], np.zeros((0, len(self.scale)))
        self.sources = toolpath.sources
        rows = np.flatnonzero((toolpath.kind != Kind.EVENT) & (toolpath.path.row_length > 0.0))
        stop = self._stops(toolpath, rows)
        if not len(rows):
            return
        columns = self._of(toolpath, rows) | {"stop": stop, "rest": stop.copy()}
        stop[:1] |= not len(self)
        self._compare(columns)
        self._chunks.append(_Chunk(toolpath.path, self.base + len(self), rows))
        for name, values in columns.items():
            self._columns.setdefault(name, []).append(values)

    def _stops(self, toolpath: Toolpath, rows: Ints) -> NDArray[np.bool_]:
        """Tell which rows follow an event that needs rest, or an exact stop; remember whether the next one does."""
        resting = rests(toolpath) | (toolpath.path_mode == PathMode.EXACT_STOP)
        before = np.concatenate([[0], np.cumsum(resting)])
        stop = np.diff(before[rows], prepend=0) > 0
        stop[:1] |= self._rest
        last = rows[-1] if len(rows) else 0
        self._rest = bool(before[-1] > before[last]) or (self._rest and not len(rows))
        return stop

    def _of(self, toolpath: Toolpath, rows: Ints) -> dict[str, np.ndarray]:
        """Return the columns of rows that do not depend on the rows before them."""
        path = toolpath.path
        length = np.asarray(path.row_length)[rows]
        # By each row's own parameter: so nothing depends on how the rows are cut into chunks.
        first, last = (
            path.parameter_after(rows, at, side) for at, side in ((np.zeros(len(rows)), 1), (length, -1))
        )
        entry, bend = self._turning(path.evaluate_parameter(rows, first, 2, 1))
        leave, bent = self._turning(path.evaluate_parameter(rows, last, 2, -1))
        inverse = toolpath.feed_mode[rows] == FeedMode.INVERSE_TIME
        with np.errstate(invalid="ignore"):
            feed = toolpath.feed[rows] * np.where(inverse, length, path.per_feed[rows])
        arc = np.flatnonzero(toolpath.kind[rows] == Kind.ARC)
        turn = np.full(len(rows), np.inf)
        turn[arc] = 2.0 * np.pi / np.sqrt((bent[arc] ** 2).sum(axis=1))
        exact = ~loose(toolpath)[rows]
        # The way of X Y Z, along which the feed is, may all lie within the tolerance. So the feed is the pace of axes that move beside them as
        # well; the ends of a curve do not tell whether they do. Rapids have none.
        swift = rapid(toolpath)[rows]
        over = path.measured_by[rows]
        bound = np.where(over == 2, self.radius * feed, feed)
        bound = np.where((over == 3) | (swift & (over > 0)), self._fastest, bound)
        turns = (toolpath.end[rows] != toolpath.starts[rows])[:, 3:].any(axis=1)
        turns |= (toolpath.kind[rows] == Kind.NURBS) & (len(toolpath.axes) > 3)
        others = ~swift & turns & ((over == 0) | (over == 3))
        return {
            "line": toolpath.line[rows],
            "source": toolpath.source[rows],
            "length": length,
            "curved": toolpath.kind[rows] != Kind.LINE,
            "feed": feed,
            "bound": bound,
            "over": over,
            "rapid": swift,
            "least": np.divide(length, feed, out=np.zeros(len(rows)), where=others & (feed > 0)),
            "free": ~exact & (bound > 0),
            "exact": exact,
            "tolerance": np.where(exact, self._chord, USED * toolpath.tolerance[rows]),
            "entry": entry,
            "leave": leave,
            "bend": bend,
            "bent": bent,
            "turn": turn,
            "start": toolpath.starts[rows] * self.scale,
            "end": toolpath.end[rows] * self.scale,
        }

    def _compare(self, columns: dict[str, np.ndarray]) -> None:
        """Add the columns of rows that come of comparing each with the row before it, and the first one with itself if there is none."""

        def before(name: str) -> np.ndarray:
            one = self.column(name)[-1:] if len(self) else columns[name][:1]
            return np.concatenate([one, columns[name][:-1]])

        stop, entry, bend = columns["stop"], columns["entry"], columns.pop("bend")
        leave, bent = before("leave"), before("bent")
        # The plan meets its places exactly: it is smoothed beside neither exact rows nor turns back.
        linear = np.einsum("ij,ij->i", leave[:, :3], entry[:, :3])
        long = np.minimum(before("length"), columns["length"]) > STANDSTILL
        swift = columns["rapid"] != before("rapid")
        stop |= swift
        columns["met"] = (
            columns["rest"] | columns["exact"] | before("exact") | swift | (long & (linear < SHARPEST))
        )
        larger = np.maximum(np.abs(bend), np.abs(bent)).max(axis=1)
        joint = stop | (np.abs(entry - leave).max(axis=1) > _STRAIGHT)
        joint |= np.abs(bend - bent).max(axis=1) > _SAME_BEND * larger + 1e-9
        for name in ("feed", "over", "tolerance", "free"):
            joint |= columns[name] != before(name)
        columns["joint"] = joint

    def _turning(self, x: Floats) -> tuple[Floats, Floats]:
        """Return unit tangents and curvature vectors of positions and their derivatives, shape (3, k, axes)."""
        x1, x2 = x[1] * self.scale, x[2] * self.scale
        tangent = self._unit(x[1])
        across = x2 - (x2 * tangent).sum(axis=1)[:, None] * tangent
        # Where a curve stands the curvature is large, and still a number.
        return tangent, across / np.maximum((x1**2).sum(axis=1), 1e-150)[:, None]

    def _unit(self, x1: Floats) -> Floats:
        x1 = x1 * self.scale
        size = np.sqrt((x1**2).sum(axis=1))[:, None]
        return np.divide(x1, size, out=np.zeros_like(x1), where=size > 0)

    def lines(self, first: int, stop: int) -> RowLines:
        """Return rows as lines, arcs and NURBS within a small part of the tolerance."""
        own = slice(first - self.base, stop - self.base)
        self._cut(stop)
        of, at, x = self._chords
        inner = slice(*np.searchsorted(of, [first, stop]).tolist())
        rows = np.concatenate([np.arange(first, stop), of[inner]])
        parts = np.concatenate([np.zeros(stop - first), at[inner]])
        order = np.lexsort((parts, rows))
        points = np.concatenate([self.column("start")[own], x[inner]])[order]
        vertices = np.concatenate([points, self.column("end")[own][-1:]])
        key = np.append(rows[order] + parts[order], float(stop))
        return RowLines(vertices, key, self.column("tolerance")[own][rows[order] - first])

    def _cut(self, stop: int) -> None:
        """Cut the curves of the rows before `stop` that are whole yet: rows are asked for again and again, as windows reach over each other."""
        first = max(self._whole, self.base)
        self._whole = max(stop, first)
        curved = first + np.flatnonzero(self.column("curved")[first - self.base : stop - self.base])
        tolerance = self.column("tolerance")[curved - self.base]
        held = int(np.searchsorted(self._chords[0], self.base))
        found = [tuple(each[held:] for each in self._chords)]
        for chunk in self._chunks:
            there = (curved >= chunk.first) & (curved < chunk.first + len(chunk.rows))
            if there.any():
                rows = chunk.rows[curved[there] - chunk.first]
                of, at, x = chords(chunk.path, rows, _CHORD * tolerance[there], self.scale)
                inner = at > 0.0
                found.append((curved[there][of[inner]], at[inner], x[inner] * self.scale))
        if len(found) > 1:
            of, at, x = (np.concatenate(each) for each in zip(*found, strict=True))
            self._chords = of, at, x

    def nearest(self, points: Floats, row: Ints, part: Floats) -> tuple[Floats, Floats]:
        """Return the places on given rows nearest to points, shape (k, axes), and the unit tangents there, all scaled.

        Args:
            points: Shape (k, axes), scaled.
            row: Shape (k,), number of the row.
            part: Shape (k,): the part of its length where the search starts.
        """
        start = self.column("start")[row - self.base]
        way = self.column("end")[row - self.base] - start
        size = np.maximum((way**2).sum(axis=1), 1e-300)
        u = np.clip(((points - start) * way).sum(axis=1) / size, 0.0, 1.0)
        place, tangent = start + u[:, None] * way, way / np.sqrt(size)[:, None]
        curved = np.flatnonzero(self.column("curved")[row - self.base])
        first = np.array([chunk.first for chunk in self._chunks])
        owner = np.searchsorted(first, row[curved], side="right") - 1
        for c in np.unique(owner):
            at = curved[owner == c]
            chunk = self._chunks[c]
            local = chunk.rows[row[at] - chunk.first]
            path = chunk.path
            first_u, last_u = self._ends(path, local)
            low, high = np.minimum(first_u, last_u), np.maximum(first_u, last_u)
            # By the length on curves, which is the parameter on lines and arcs but for rounded radii.
            u = first_u + np.clip(part[at], 0.0, 1.0) * (last_u - first_u)
            free = np.flatnonzero(path.kind[local] == Kind.NURBS)
            u[free] = path.parameter_after(
                local[free], np.clip(part[at[free]], 0.0, 1.0) * path.row_length[local[free]]
            )
            # Newton's method, from the nearest place yet: half way back to that where a step leads away, as where a curve nearly stands.
            best, reach = u.copy(), np.full(len(at), np.inf)
            left = np.arange(len(at))
            for _ in range(_STEPS):
                x0, x1 = path.evaluate_parameter(local[left], u[left], 1) * self.scale
                away = points[at[left]] - x0
                square = (away**2).sum(axis=1)
                nearer = square <= reach[left] * (1.0 + _ROUNDED) + _FOUND**2
                size = np.maximum((x1**2).sum(axis=1), 1e-300)
                found = np.where(
                    nearer, u[left] + (away * x1).sum(axis=1) / size, 0.5 * (u[left] + best[left])
                )
                found = np.clip(found, low[left], high[left])
                best[left[nearer]], reach[left[nearer]] = u[left[nearer]], square[nearer]
                far_off = ~nearer | ((found - u[left]) ** 2 * size > _FOUND**2)
                u[left] = found
                left = left[far_off]
                if not len(left):
                    break
            u[left] = best[left]
            x = path.evaluate_parameter(local, u, 1)
            inside = np.clip(u, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
            end = np.flatnonzero(inside != u)
            x[1, end] = path.evaluate_parameter(local[end], inside[end], 1)[1]
            place[at], tangent[at] = x[0] * self.scale, self._unit(x[1])
        return place, tangent

    @staticmethod
    def _ends(path: Path, local: Ints) -> tuple[Floats, Floats]:
        """Return the parameters of the ends of rows."""
        rows, of = np.unique(local, return_inverse=True)
        first, last = (path.parameter_after(rows, part * path.row_length[rows]) for part in (0.0, 1.0))
        return first[of], last[of]
