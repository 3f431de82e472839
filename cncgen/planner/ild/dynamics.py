"""The dynamics module of `ild`: speeds low enough that the predicted contour error stays under its bound (docs/ild.md).

The first cap is v²κ <= ε_max/C at every place. The plan under that cap is run through the error filters; where the error still exceeds
ε_max, the cap is lowered over the memory of the loops, and the window is planned again. A profile meets a pointwise cap by further
joints: where it runs above the cap, the part of the path around the worst place where the cap is nearly the same becomes a segment of
its own, with that cap as its top speed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError, Span
from cncgen.machine.record import Machine
from cncgen.planner.contour_prediction import ContourPrediction, prediction
from cncgen.planner.ild.look_ahead import SegmentPieces, Segments, build, joint_caps, joint_speeds
from cncgen.planner.ild.open_stretches import OpenPath, OpenStretches, laid_out
from cncgen.planner.motion import motion_at
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Rounds of lowering the caps where the predicted error is too large, and of cutting at a given cap.
_MAX_LOWERINGS = 15
_MAX_CUTS = 25
#: Segments that one of the window's may be cut into, on average.
_MAX_PARTS = 20
#: Accepted excess over a cap, and the spread of the cap within a plateau.
_EXCESS = 1e-3
_PLATEAU = 0.04
#: Part of ε_max that the caps aim at, so that the rounds end.
_AIM = 0.98
#: A window is slowed by this factor at most; a bound that asks for more is reported as not held.
_MAX_SLOWING = 20.0
#: Samples of a window at most (at a millisecond more than two hours, and 0.1 kB each), and those evaluated at a time.
_MAX_SAMPLES = 1 << 23
_AT_ONCE = 1 << 17


@dataclass(slots=True)
class _Samples:
    """A window's plan at its ticks: place (window coordinate), speed, tangent and curvature in X Y Z."""

    s: Floats
    v: Floats
    tangent: Floats
    curvature: Floats

    @classmethod
    def empty(cls, count: int, axes: int) -> _Samples:
        """Make room for so many samples."""
        return cls(np.empty(count), np.empty(count), np.empty((count, axes)), np.empty(count))


@dataclass(frozen=True, slots=True)
class _Cut:
    """Segments of a window, the places of their joints, and where the kept joints stand among these."""

    segments: Segments
    place: Floats
    joint: Ints


@dataclass(slots=True)
class Dynamics:
    """Holds the predicted contour error of windows under a bound.

    Attributes:
        bound_mm: ε_max.
        period_s: Time between the samples that the prediction sees.
        model: The error filters, with their state at the window's start.
        columns: Columns of X Y Z that are predicted (the axes that the machine has).
        memory: Samples that the loops remember.
    """

    bound_mm: float
    period_s: float
    model: ContourPrediction
    columns: list[int]
    memory: int
    _slow_s: Floats = field(default_factory=lambda: np.zeros(1))
    _slowness: Floats = field(default_factory=lambda: np.zeros(1))

    @classmethod
    def of(cls, machine: Machine, options: PlanOptions) -> Dynamics | None:
        """Set up from the options' or the machine's `max_contour_error_mm`; None where neither gives one."""
        bound = options.max_contour_error_mm or machine.max_contour_error_mm
        if bound is None:
            return None
        letters = [letter for letter in "XYZ" if letter in machine.axes]
        model = prediction(machine, options, "".join(letters))
        return cls(bound, machine.period_s, model, ["XYZ".index(c) for c in letters], model.loops.memory())

    @property
    def centripetal(self) -> float:
        """Return v²κ at which the static contour error is the bound, mm/s²; infinite for perfect loops.

        The error is that of Tsai 2010, eq. 18, on a circle in the steady state (`static_coefficients`).
        """
        per = self.model.per_centripetal_s2
        return _AIM * self.bound_mm / per if per > 0.0 else np.inf

    def refine(
        self, window: OpenStretches, open_path: OpenPath, profile: str, last: bool
    ) -> tuple[Segments, Ints, float]:
        """Cut and slow the segments of a window until the predicted contour error is under the bound.

        Args:
            window: The open stretches.
            open_path: Their joints and segments.
            profile: One of `PROFILES`.
            last: Whether the program ends with the window; an overshoot of its end then counts as well.

        Returns:
            The finer segments, where the kept joints stand among theirs, and the largest error predicted, mm.

        Raises:
            NoPlanError: The window takes more than `_MAX_SAMPLES` periods.
        """
        self._slow_s, self._slowness = np.zeros(1), np.zeros(1)
        segments = open_path.segments
        joint = np.arange(len(segments) + 1)
        if not len(segments):
            return segments, joint, 0.0
        place = np.concatenate([[0.0], np.cumsum(segments.length)])
        # A stop with nothing known behind it may be the end.
        ends = last or segments.cap[-1] == 0.0
        corners = np.append(window.turns(open_path), place[-1] if ends else np.inf)
        plan, pieces = _Cut(segments, place, joint), _planned(window, segments, profile)
        longest = _MAX_SLOWING * float(pieces.duration.sum()) + 1.0
        worst = float(
            self._predicted(self._sampled(window, place, pieces, len(segments)), corners).max(initial=0.0)
        )
        for _ in range(_MAX_LOWERINGS):
            found = self._under_caps(window, plan, profile, longest)
            if found is None:
                break
            plan, at = found
            error = self._predicted(at, corners)
            worst = float(error.max(initial=0.0))
            if worst <= self.bound_mm:
                break
            self._lower(at, error)
        return plan.segments, plan.joint, worst

    def _predicted(self, at: _Samples, corners: Floats) -> Floats:
        """Return the distance from the path that the loops will make of a plan, at each of its samples.

        Where the path goes on, only what is across it counts (eq. 18). At a corner, and at the end, an axis that
        overshoots leaves the path as well; the last sample stands for what follows it, too.
        """
        n, hold = len(at.v), 4 * self.memory
        if not n:
            return np.zeros(0)
        before = self.model.loops.snapshot()
        across, along = self.model.run(
            np.concatenate([at.tangent, np.repeat(at.tangent[-1:], hold, axis=0)]),
            np.concatenate([at.v, np.zeros(hold)]),
        )
        self.model.loops.restore(before)
        place = np.concatenate([at.s, np.repeat(at.s[-1:], hold)])
        corner = np.append(corners, np.inf)[np.searchsorted(corners, place - 1e-9)]
        error = np.hypot(across, np.maximum(place - along - corner, 0.0))
        error[n - 1] = error[n - 1 :].max()
        return error[:n]

    def commit(
        self, window: OpenStretches, segments: Segments, joint: Ints, pieces: SegmentPieces, upto: int
    ) -> None:
        """Move the filters on over the first `upto` segments of the window."""
        place = np.concatenate([[0.0], np.cumsum(segments.length)])
        at = self._sampled(window, place, pieces, int(joint[upto]))
        self.model.run(at.tangent, at.v)

    def _under_caps(
        self, window: OpenStretches, plan: _Cut, profile: str, longest: float
    ) -> tuple[_Cut, _Samples] | None:
        """Cut until no sample of the plan is faster than its cap; None where that takes longer than `longest`."""
        found: tuple[_Cut, _Samples] | None = None
        most = _MAX_PARTS * (len(plan.joint) + 100)
        for _ in range(_MAX_CUTS):
            pieces = _planned(window, plan.segments, profile)
            if pieces.duration.sum() > longest or len(plan.segments) > most:
                return None
            at = self._sampled(window, plan.place, pieces, len(plan.segments))
            found = plan, at
            cap = self._cap(at)
            over = at.v > cap * (1.0 + _EXCESS)
            if not over.any():
                break
            plan = _Cut(*_cut(plan.segments, plan.place, plan.joint, at, cap, over))
        return found

    def _cap(self, at: _Samples) -> Floats:
        """Return the highest speed at each sample, by curvature and by earlier rounds."""
        slowness = np.interp(at.s, self._slow_s, self._slowness)
        with np.errstate(divide="ignore"):
            return np.minimum(np.sqrt(self.centripetal / at.curvature), 1.0 / slowness)

    def _lower(self, at: _Samples, error: Floats) -> None:
        """Lower the cap where the error is too large and over the memory of the loops before it.

        Caps are kept as slowness 1/v, zero without one, as that can be interpolated between samples.
        """
        factor = np.minimum(1.0, np.sqrt(_AIM * self.bound_mm / np.maximum(error, 1e-12)))
        spread = factor.copy()
        for back in range(1, self.memory + 1):
            np.minimum(spread[:-back], factor[back:], out=spread[:-back])
        # At this speed the path covers ε_max while the loops remember it: there is nothing left to gain below it.
        least = self.bound_mm / (self.memory * self.period_s)
        asked = np.where(spread < 1.0, 1.0 / np.maximum(at.v * spread, least), 0.0)
        self._slowness = np.maximum(np.interp(at.s, self._slow_s, self._slowness), asked)
        self._slow_s = at.s

    def _sampled(self, window: OpenStretches, place: Floats, pieces: SegmentPieces, upto: int) -> _Samples:
        """Sample the first `upto` segments of a plan at the ticks that fall into it."""
        joint = np.arange(upto + 1)
        plan, _ = laid_out(window.t_s, place[: upto + 1], pieces, joint, np.zeros(upto + 1))
        t = plan.t
        first, stop = np.ceil(t[[0, -1]] / self.period_s - 1e-9)
        if stop - first > _MAX_SAMPLES:
            slowest = int(np.argmax(np.diff(t[pieces.offset[: upto + 1]])))
            raise NoPlanError(self._too_slow(window.span_at(0.5 * (place[slowest] + place[slowest + 1])), t))
        at = _Samples.empty(int(max(0, stop - first)), len(self.columns))
        for begin in range(0, len(at.s), _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            motion = motion_at(plan, np.arange(first + begin, min(stop, first + some.stop)) * self.period_s)
            at.s[some], at.v[some] = motion.s, motion.v
            at.tangent[some], at.curvature[some] = self._geometry(window, motion.s)
        return at

    def _too_slow(self, span: Span, t: Floats) -> Diagnostic:
        """Say that a window takes too long for a prediction at every period; `span` is where most of it goes."""
        taken = float(t[-1] - t[0])
        return Diagnostic(
            "look-ahead-endless",
            f"the look-ahead of ild takes {taken:.4g} s, which is more than {_MAX_SAMPLES} predictions of the contour "
            f"error every {1e3 * self.period_s:g} ms",
            span=span,
            hint="look at the feed there and at the machine's velocities; --feedrate optimal needs no such look-ahead",
            values={"time_s": taken, "samples": taken / self.period_s, "most": _MAX_SAMPLES},
        )

    def _geometry(self, window: OpenStretches, s: Floats) -> tuple[Floats, Floats]:
        """Evaluate tangents (of the predicted axes) and curvatures at places of the window, non-decreasing."""
        tangents, curvatures = [np.zeros((0, len(self.columns)))], [np.zeros(0)]
        start = 0.0
        begin = 0
        for i, stretch in enumerate(window.stretches):
            origin = stretch.s[stretch.used]
            length = stretch.s[-1] - origin
            last = i == len(window.stretches) - 1
            end = len(s) if last else int(np.searchsorted(s, start + length, side="right"))
            x = stretch.path.evaluate(origin + s[begin:end] - start, 2)
            tangents.append(x[1][:, self.columns])
            curvatures.append(np.linalg.norm(x[2][:, :3], axis=1))
            start += length
            begin = end
        return np.concatenate(tangents), np.concatenate(curvatures)


def _planned(window: OpenStretches, segments: Segments, profile: str) -> SegmentPieces:
    """Lay out the profiles of a window's segments, to rest at its end."""
    return build(segments, joint_speeds(segments, window.speed_mm_s, 0.0, profile), profile)


def _cut(
    segments: Segments, place: Floats, joint: Ints, at: _Samples, cap: Floats, over: NDArray[np.bool_]
) -> tuple[Segments, Floats, Ints]:
    """Cut every segment that runs above the cap around its worst place; the part around it has the cap as its top speed, and so have its joints."""
    fast, levels, ends = _plateaus(place, at, cap, over)
    inner = (place[fast, None] < ends) & (ends < place[fast + 1, None])
    inner[:, 1] &= ends[:, 1] > ends[:, 0]
    more = inner.sum(axis=1)
    added = np.zeros(len(segments), np.int64)
    added[fast] = more
    of, joints = np.repeat(np.arange(len(segments)), 1 + added), np.repeat(fast, more) + 1
    caps = np.insert(joint_caps(segments.cap, segments.top), joints, np.repeat(levels, more))
    place = np.insert(place, joints, ends[inner])
    before = np.concatenate([[0], np.cumsum(added)])
    top, limit = segments.top[of], segments.top_limit[of]
    lasts = ends[:, 1] > ends[:, 0]
    capped = (fast + before[fast] + inner[:, 0])[lasts]
    top[capped], limit[capped] = np.minimum(top[capped], levels[lasts]), Limit.CONTOUR_ERROR
    finer = Segments(np.diff(place), top, limit, segments.acceleration[of], segments.jerk[of], caps)
    return finer, place, joint + before[joint]


def _plateaus(
    place: Floats, at: _Samples, cap: Floats, over: NDArray[np.bool_]
) -> tuple[Ints, Floats, Floats]:
    """Return the segments with samples above the cap, shape (k,), the cap at the worst of each, and the ends of its plateau, (k, 2)."""
    owner = np.clip(np.searchsorted(place, at.s, side="right") - 1, 0, len(place) - 2)
    ratio = np.where(over, at.v / cap, 0.0)
    fast = np.unique(owner[over])
    levels, ends = np.empty(len(fast)), np.empty((len(fast), 2))
    for k, segment in enumerate(fast.tolist()):
        first, stop = np.searchsorted(owner, [segment, segment + 1]).tolist()
        worst = int(np.argmax(ratio[first:stop]))
        levels[k] = cap[first + worst]
        run = _run_around(cap[first:stop] <= levels[k] * (1.0 + _PLATEAU), worst)
        ends[k] = np.clip(at.s[[first + each for each in run]], place[segment], place[segment + 1])
    return fast, levels, ends


def _run_around(flags: NDArray[np.bool_], i: int) -> tuple[int, int]:
    """Return the first and last index of the run of true flags that holds index `i`."""
    breaks = np.flatnonzero(~flags)
    before = breaks[breaks < i]
    after = breaks[breaks > i]
    low = int(before[-1]) + 1 if len(before) else 0
    high = int(after[0]) - 1 if len(after) else len(flags) - 1
    return low, high
