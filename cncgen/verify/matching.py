"""Setpoints matched with the programmed path, both followed in their order (docs/verify.md).

The Fréchet distance of both polylines must be within the tolerance at each place of the path (Alt and Godau (1995), by
`cncgen.kernels.free_space`): two points run along them, never back, and are never further apart. Setpoints and path are read as they
are needed and then dropped. If the distance exceeds the tolerance, the matching searches the least factor on the tolerance with which
it can go on, until the tolerance itself is enough again. So a fault has a place, a size and an end.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import free_space as kernel
from cncgen.verify.standing import BETWEEN_TICKS, Passed, Stands, Wait
from cncgen.verify.window import MatchWindow

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Rows between two states that are kept to go back to, and how many states.
STRIDE, STATES = 512, 16
#: Rows over which a way past a fault is looked for.
HORIZON = 8192
#: Cells of the free space that may be visited while looking for ways past faults: in all, and in addition for each row that is
#: done. After that the setpoints are given up as lost.
PATIENCE, PATIENCE_A_ROW = 50_000_000, 300
#: A place where the setpoints stand still counts as that of a wait if it is further from it than the nearest one by less than this
#: part of the tolerance.
_AS_NEAR = 1e-3
#: Ratio of the bounds between which the factor on the tolerance is narrowed down.
_FINE = 1.001
#: Factor on the tolerance beyond which the setpoints are lost.
_FURTHEST = 1e12


@dataclass(slots=True)
class Worst:
    """Distances in one direction.

    Attributes:
        largest: The largest one, mm.
        value: The largest relative to its tolerance, mm.
        tolerance: The tolerance there, mm.
        time: When, in periods.
        line: Source line there.
        place: Shape (axes,): where on the path.
        over: How many samples, or vertices, are over their tolerance,
        between: and how many middles between two samples.
        first: When it first was over, in periods.
    """

    largest: float = 0.0
    value: float = 0.0
    tolerance: float = 0.0
    time: float = 0.0
    line: int = 0
    place: Floats = field(default_factory=lambda: np.zeros(0))
    over: int = 0
    between: int = 0
    first: float = 0.0
    excess: float = -np.inf

    @property
    def broken(self) -> bool:
        """Tell whether a tolerance is broken."""
        return self.over + self.between > 0


@dataclass(frozen=True, slots=True)
class Fault:
    """A place beyond which no matching within the tolerance leads.

    Attributes:
        time: When, in periods.
        line: Source line of the furthest place that was reached.
        leash: Least distance with which the matching goes on from here, mm (the dog-leash distance of Alt and Godau (1995)); the
            largest that was tried if the setpoints are `lost`.
        tolerance: mm.
        lost: No way on was found; nothing after this is judged.
        plain: Distances that are over the tolerance report it already.
    """

    time: float
    line: int
    leash: float
    tolerance: float
    lost: bool = False
    plain: bool = False


@dataclass(frozen=True, slots=True)
class _State:
    """The places that are reached at one row.

    Attributes:
        row: Its number from the start: chords done.
        first: The first segment that is reached, counted from the path's start.
        low, high: The intervals from it on.
    """

    row: int
    first: int
    low: list[float]
    high: list[float]


class Matching:
    """The state of the matching. A row is a setpoint or the middle between two; the first setpoint is there twice.

    Attributes:
        out: Distances of samples, and of the middles of the chords between them, from the path.
        back: Distances of the path's vertices from the chords.
        faults: In order.
        waits: Of the program, that the setpoints do not make.
    """

    def __init__(self, window: MatchWindow, period_s: float = 1.0, still_mm: float = 0.0) -> None:
        """Begin.

        Args:
            window: The path.
            period_s: Time between setpoints.
            still_mm: How far rounding may move a setpoint that stands.
        """
        self._path, self._period = window, period_s
        self._stands = Stands(still_mm)
        self._waited = -2  # The segment of the last wait, counted from the path's start.
        self.waits: list[Wait] = []
        self.out, self.back = Worst(), Worst()
        self.faults: list[Fault] = []
        self._rows = np.zeros((0, window.points.shape[1]))
        self._base = 0  # Number of the first of `_rows`.
        self._row = 0  # Chords done.
        self._scale = 1.0
        self._free = 0  # The row after which a fault may end.
        self._spent = 0
        start = _State(0, 0, [0.0], [0.0])
        self._space = self._space_at(start)
        self._marks = [start]
        self._fault: Fault | None = None
        self._plain = False

    @property
    def lost(self) -> bool:
        """Tell whether the matching has been given up."""
        return bool(self.faults) and self.faults[-1].lost

    def feed(self, points: Floats) -> Ints:
        """Add setpoints, shape (n, axes); return the source lines of the setpoints matched so far."""
        if len(points):
            before = self._rows[-1:] if len(self._rows) else points[:1]
            begin = np.concatenate([before, points[:-1]])
            rows = np.stack([0.5 * (begin + points), points], axis=1).reshape(-1, points.shape[1])
            self._stands.feed(rows, before)
            self._rows = np.concatenate([self._rows, rows])
        return self._go(final=False)

    def finish(self) -> Ints:
        """End both; return the source lines of the setpoints that were still open."""
        if len(self._rows):
            self._rows = np.concatenate([self._rows, self._rows[-1:]])
        lines = self._go(final=True)
        if not self.lost:
            self._end(self._rows[-1] if len(self._rows) else self._path.points[0])
        self._close()
        while self._path.extend():
            self._path.drop(len(self._path) - 1)
        return lines

    # ---- going along both -----------------------------------------------------------------------------------------

    def _go(self, final: bool) -> Ints:
        """Match the rows that are there; return the source lines of the samples that are done."""
        stop = self._base + len(self._rows) - 1
        begun, found = self._row, [np.zeros(0, np.int64)]
        while self._row < stop and not self.lost:
            why, lines = self._stretch(min(stop, self._row + STRIDE))
            found.append(lines)
            if why == kernel.MORE:
                self._more_path(self._marks[0].first)
            elif why == kernel.REJOINED:
                self._scale = 1.0
                self._close()
                self._marks = [self._state()]
            elif why == kernel.DEAD:
                if not final and stop - self._row < HORIZON:
                    break
                self._find_a_way(min(stop, self._row + HORIZON))
            elif self._scale == 1.0 and self._row >= self._marks[-1].row + STRIDE:
                self._marks = [*self._marks[1 - STATES :], self._state()]
        if self.lost:
            found.append(np.zeros(stop - self._row, np.int64))
            self._row = stop
        keep = self._row if self.lost else min(self._marks[0].row, self._row)
        self._rows, self._base = self._rows[max(keep - self._base, 0) :], max(keep, self._base)
        # A chord of an even number ends at a sample.
        return np.concatenate(found)[begun % 2 :: 2]

    def _stretch(self, stop: int) -> tuple[int, Ints]:
        """Go on to row `stop` at most, noting distances; return what ended it, and the lines of the rows done."""
        begin = self._row - self._base
        rows = self._rows[begin : stop - self._base + 1]
        distance, segment = np.zeros(len(rows)), np.zeros(len(rows), np.int64)
        free = self._free - self._row
        done, why = self._space.run(rows, 0, len(rows) - 1, self._scale, free, self._row, distance, segment)
        lines = self._judge_rows(distance[1 : done + 1], segment[1 : done + 1])
        self._row += done
        return why, lines

    def _state(self) -> _State:
        first, low, high = self._space.reached()
        return _State(self._row, self._path.dropped + first, low, high)

    def _space_at(self, state: _State) -> kernel.FreeSpace:
        path = self._path
        scratch = np.empty((4, len(path)))
        space = kernel.FreeSpace(
            path.points, path.allowed, path.ended, path.distance, path.at, path.during, scratch
        )
        space.enter(state.first - path.dropped, state.low, state.high)
        return space

    def _more_path(self, before: int | None = None) -> None:
        """Draw more of the path; forget what is behind segment `before`."""
        state = self._state()
        if before is not None and before > self._path.dropped:
            count = before - self._path.dropped
            self._judge_vertices(count)
            self._path.drop(count)
        self._path.extend()
        self._space = self._space_at(state)

    # ---- past a fault ---------------------------------------------------------------------------------------------

    def _find_a_way(self, stop: int) -> None:
        """Continue with the least factor on the tolerance that leads to a place where 1 is enough again, or to row `stop`."""
        here = self._state()
        on = here.first + len(here.low) - 1 - self._path.dropped
        allowed = float(self._path.allowed[on])
        # Within a fault there is no way back: places behind were passed with a wider tolerance.
        open_, self._plain = self._fault is not None, self._plain and self._fault is not None

        def passes(scale: float) -> bool:
            """Tell whether a factor leads over this row to a place where 1 is enough, or to row `stop`."""
            self._enter(here if open_ else self._before(here, scale * allowed))
            return self._advance(stop, scale, here.row) != kernel.DEAD

        failed, passed = self._scale, 2.0 * self._scale
        while not passes(passed):
            failed, passed = passed, 2.0 * passed
            if self._impatient() or passed > _FURTHEST:
                self._note_fault(on, here.row, failed, lost=True)
                return
        while passed > _FINE * failed and not self._impatient():
            middle = float(np.sqrt(failed * passed))
            if passes(middle):
                passed = middle
            else:
                failed = middle
        self._note_fault(on, here.row, passed)
        self._scale, self._free = passed, here.row
        self._enter(here if open_ else self._before(here, passed * allowed))
        while self._row < here.row:
            if self._stretch(here.row)[0] == kernel.MORE:
                self._more_path()

    def _impatient(self) -> bool:
        return self._spent > PATIENCE + PATIENCE_A_ROW * self._row

    def _before(self, here: _State, allowed: float) -> _State:
        """Return the last stored state that lies before all rows which can be matched with the furthest place reached.

        Those rows are all within twice the tolerance of each other.
        """
        first = self._marks[0]
        rows = self._rows[first.row - self._base : here.row - self._base + 1]
        away = np.flatnonzero(np.linalg.norm(rows - rows[-1], axis=1) > 2.0 * allowed)
        upto = first.row + (int(away[-1]) if len(away) else 0)
        return [mark for mark in self._marks if mark.row <= upto][-1]

    def _enter(self, state: _State) -> None:
        self._space.enter(state.first - self._path.dropped, state.low, state.high)
        self._row = state.row

    def _advance(self, stop: int, scale: float, free: int) -> int:
        """Go on to row `stop` at most, noting nothing; return what ended it."""
        nothing, no_segment = np.zeros(0), np.zeros(0, np.int64)
        rows = self._rows[: stop - self._base + 1]
        why = kernel.MORE
        while why == kernel.MORE:
            begun = self._space.cells
            row, why = self._space.run(
                rows, self._row - self._base, len(rows) - 1, scale, free - self._base, -1, nothing, no_segment
            )
            self._row = self._base + row
            self._spent += self._space.cells - begun
            if why == kernel.MORE:
                self._more_path()
        return int(why)

    def _note_fault(self, on: int, row: int, scale: float, lost: bool = False) -> None:
        """Begin a fault, or widen the open one."""
        path = self._path
        leash = scale * float(path.allowed[on])
        if self._fault is None:
            self._fault = Fault(0.5 * row, int(path.line[on]), leash, float(path.tolerance[on]))
        else:
            self._fault = replace(self._fault, leash=leash)
        if lost:
            self._row = row
            self._close(lost=True)

    def _close(self, lost: bool = False) -> None:
        """End the fault that is open."""
        if self._fault is None:
            return
        first, low, _ = self._space.reached()
        upto = slice(first, first + len(low) + 1)
        distance = self._path.distance[upto]
        over = np.isfinite(distance) & (distance > self._path.vertex_allowed()[upto])
        self.faults.append(replace(self._fault, lost=lost, plain=self._plain or bool(over.any())))
        self._fault = None

    def _end(self, last: Floats) -> None:
        """Judge the rest of the path, which the last setpoint leaves out."""
        path = self._path
        first, low, _ = self._space.reached()
        on = first + len(low) - 1
        if path.ended and on == len(path) - 1:
            self._judge_vertices(len(path))
            return
        self._judge_vertices(on)
        furthest, line, tolerance = 0.0, int(path.line[on]), float(path.tolerance[on])
        while True:
            path.distance[on + 1 :] = np.linalg.norm(path.points[on + 1 :] - last, axis=1)
            path.at[on + 1 :] = self._row
            path.during[on + 1 :] = self._row
            furthest = max(furthest, float(path.distance[on + 1 :].max(initial=0.0)))
            self._judge_vertices(len(path))
            path.drop(len(path) - 1)
            on = 1
            if not path.extend():
                break
        fault = self._fault or Fault(0.5 * self._row, line, furthest, tolerance)
        self._fault = replace(fault, leash=max(fault.leash, furthest))

    # ---- what is noted --------------------------------------------------------------------------------------------

    def _judge_rows(self, distance: Floats, segment: Ints) -> Ints:
        """Note the distances of rows that are done; return their source lines."""
        path, out = self._path, self.out
        if not len(distance):
            return np.zeros(0, np.int64)
        excess = distance - path.allowed[segment]
        worst = int(np.argmax(excess))
        out.largest = max(out.largest, float(distance.max()))
        if excess[worst] > out.excess:
            on = int(segment[worst])
            out.excess, out.value = float(excess[worst]), float(distance[worst])
            out.tolerance, out.line = float(path.tolerance[on]), int(path.line[on])
            out.time = 0.5 * (self._row + worst)
        if excess[worst] > 0:
            rows = self._row + np.flatnonzero(excess > 0)
            out.first = out.first if out.broken else 0.5 * float(rows[0])
            middles = int(np.count_nonzero(rows % 2))
            out.over += len(rows) - middles
            out.between += middles
            self._plain = True
        return path.line[segment]

    def _judge_vertices(self, stop: int) -> None:
        """Note the distances of the vertices up to `stop`, and forget them: each is judged once."""
        path, back = self._path, self.back
        self._judge_waits(stop)
        upto = slice(0, stop + 1)
        distance = np.where(np.isfinite(path.distance[upto]), path.distance[upto], 0.0)
        path.distance[upto] = np.inf
        excess = distance - path.vertex_allowed()[upto]
        worst = int(np.argmax(excess))
        back.largest = max(back.largest, float(distance.max()))
        # A chord of an odd number ends in the middle between two samples.
        time = np.maximum(0.5 * path.at[upto] - 0.25, 0.0)
        if excess[worst] > back.excess:
            on = max(worst - 1, 0)
            back.excess, back.value = float(excess[worst]), float(distance[worst])
            back.line, back.time = int(path.line[on]), float(time[worst])
            back.tolerance = float(path.tolerance[on : worst + 1].max())
            back.place = path.points[worst].copy()
        if excess[worst] > 0:
            back.first = back.first if back.broken else float(time[int(np.argmax(excess > 0))])
            back.over += int(np.count_nonzero(excess > 0))
            self._plain = True

    def _judge_waits(self, stop: int) -> None:
        """Look for the waits at the vertices up to `stop`."""
        path = self._path
        for k in np.flatnonzero(path.wait_s[:stop]).tolist():
            asked, row = float(path.wait_s[k]) / self._period, int(path.at[k + 1])
            if not np.isfinite(path.distance[k + 1]):
                continue
            near = float(path.distance[k + 1]) + _AS_NEAR * float(path.allowed[k])
            first, last = path.during[k + 1].tolist()
            passed = Passed(path.points[k + 1].copy(), row, first, last, near)
            # Waits after one another are segments of no length, and each asks for all of them so far.
            again = self._waited == path.dropped + k - 1 and bool(
                (path.points[k] == path.points[k + 1]).all()
            )
            self._waited = path.dropped + k
            found = self._stands.found(asked, passed, again)
            if found < asked - BETWEEN_TICKS:
                self.waits.append(Wait(int(path.line[k]), asked, found, max(0.5 * row - 0.25, 0.0)))
            path.wait_s[k] = 0.0
        # A vertex that a kept state may still go back behind is judged later, though its stand is over.
        later = np.flatnonzero(path.wait_s[stop : len(path)]) + stop + 1
        seen = path.during[later, 0][np.isfinite(path.distance[later])]
        self._stands.forget(min([self._marks[0].row, *seen.tolist()]))
