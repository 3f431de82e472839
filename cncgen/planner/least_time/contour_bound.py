"""A bound of the contour error of the servo loops, held by `optimal`: plan, predict, lower, plan again.

The first plan keeps v²κ below the value that gives the bound in the steady state of a circle. The loops run along it as models
(`contour_prediction`). Where their positions leave the path by more than the bound, the speed over the memory of the loops becomes a
cap for the next plan. This is repeated for some rounds. Every round is a stream: it takes blocks from the previous round one by one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.geometry import elementary
from cncgen.geometry.contour_distance import ContourTracker
from cncgen.machine.record import Machine
from cncgen.planner.contour_prediction import ContourPrediction, prediction
from cncgen.planner.least_time.block_planning import plan_blocks, smooth_blocks
from cncgen.planner.least_time.replanning import PlannedBlock, by_block, with_remarks
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.motion import motion_at
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]

#: Part of the bound that is aimed at: the models and the simulated loops differ by some hundredths.
_AIM = 0.93
#: In each plan after the first: by which power of bound/error the speed is lowered (the error follows with the square of
#: the speed first, the steady state of a circle, then with less), and how far back in time, as a part of `_REACH`. Where
#: the error itself stands is enough in most places; not at stops, where the loops overshoot after the motion (a stop whose
#: speeds are scaled by k has k³ of the jerk).
_ROUNDS = ((0.5, 0.0), (0.7, 0.0), (0.35, 1.0), (0.5, 1.0), (1.0, 1.0), (2.0, 1.0))
#: Slower than this part of the speed is nothing asked for in one round.
_LEAST = 0.2
#: How far back in time a speed is lowered, in memories of the loops (`ErrorFilters.memory`).
_REACH = 2
#: Part of the bound over which the speed is lowered.
_MET = 0.998


@dataclass(frozen=True, slots=True)
class _Lowering:
    """How speeds are lowered in one round.

    Attributes:
        bound: Of the error, mm.
        power: Of the bound's part of the error, by which a speed is lowered.
        slowest: The lowest cap, mm/s.
        back: How many samples before an error it is lowered.
    """

    bound: float
    power: float
    slowest: float
    back: int


@dataclass(slots=True)
class _JudgedBlock:
    """A planned block with its samples: where, how fast, and how far the loops leave the path there."""

    toolpath: Toolpath
    s: Floats
    v: Floats
    error: Floats
    known: int = 0


class _Watch:
    """Runs the loops along a plan, and says of each block how far they leave the path.

    Attributes:
        memory: For how many samples the loops remember a speed, and as many again.
    """

    def __init__(self, period_s: float, model: ContourPrediction) -> None:
        self._period, self._model, self.memory = period_s, model, _REACH * model.loops.memory()
        self._tracker = ContourTracker(len(model.letters))
        self._open: deque[_JudgedBlock] = deque()
        self._tick = 0

    @classmethod
    def of(cls, machine: Machine, options: PlanOptions, letters: str) -> _Watch:
        """Start at rest."""
        return cls(machine.period_s, prediction(machine, options, letters))

    def slowest(self, bound: float) -> float:
        """Return the lowest cap: at that speed the path covers the bound while the loops remember it."""
        return _REACH * bound / (self.memory * self._period)

    def add(self, block: PlannedBlock) -> Iterator[tuple[_JudgedBlock, Floats]]:
        """Take a further block of the plan; yield those whose errors are known, and the errors that follow from them."""
        profile = block.profile
        ticks = np.arange(self._tick, np.ceil(profile.t[-1] / self._period - 1e-9))
        self._tick += len(ticks)
        motion = motion_at(profile, ticks * self._period)
        columns = [block.toolpath.axes.index(letter) for letter in self._model.letters]
        x = block.toolpath.path.evaluate(motion.s, 1)[:, :, columns]
        self._open.append(_JudgedBlock(block.toolpath, motion.s, motion.v, np.zeros(len(motion.s))))
        self._known(self._measured(x[0], x[1] * motion.v[:, None]))
        while len(self._open) > 1 and self._after_first() >= self.memory:
            yield self._first()

    def finish(self) -> Iterator[tuple[_JudgedBlock, Floats]]:
        """Let the loops settle at the end, and yield what is open; the end answers for all that comes after it."""
        if not self._open:
            return
        last = self._open[-1].toolpath
        end = last.path.evaluate(last.path.row_s[-1:], 0)[0]
        columns = [last.axes.index(letter) for letter in self._model.letters]
        hold = np.repeat(end[:, columns], 4 * self.memory, axis=0)
        self._known(np.concatenate([self._measured(hold, np.zeros_like(hold)), self._tracker.finish()]))
        while self._open:
            yield self._first()

    def _first(self) -> tuple[_JudgedBlock, Floats]:
        """Take out the first block, with the errors of the samples that follow it."""
        block = self._open.popleft()
        following = np.concatenate([np.zeros(0), *(other.error for other in self._open)])
        return block, following[: self.memory]

    def _measured(self, x: Floats, speed: Floats) -> Floats:
        """Return the distances that are known once the loops have run over further samples."""
        return self._tracker.push(
            np.ascontiguousarray(x), np.ascontiguousarray(x - self._model.loops.run(speed))
        )

    def _known(self, error: Floats) -> None:
        """Give distances, in the order of the samples, to the open blocks; any left over belong to the last sample."""
        for block in self._open:
            count = min(len(block.error) - block.known, len(error))
            block.error[block.known : block.known + count] = error[:count]
            block.known += count
            error = error[count:]
        last = self._open[-1]
        if len(error) and len(last.error):
            last.error[-1] = max(last.error[-1], float(error.max()))

    def _after_first(self) -> int:
        """Return how many samples after the first open block have known errors."""
        return sum(block.known for block in self._open) - len(self._open[0].error)


@dataclass(frozen=True, slots=True)
class _Slowness:
    """Caps of one block as slowness 1/v over the path, 0 without one: slowness can be interpolated."""

    s: Floats
    slowness: Floats

    def __call__(self, s: Floats, _x: Floats | None = None) -> Floats:
        """Return the largest speeds at s, whatever the path is there."""
        with np.errstate(divide="ignore"):
            out: Floats = 1.0 / np.interp(s, self.s, self.slowness)
        return out


_NO_CAP = _Slowness(np.zeros(1), np.zeros(1))


def plan_bounded(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions, bound: float
) -> Iterator[Trajectory]:
    """Plan the least time with the predicted contour error under a bound.

    The error is that of Tsai 2010, eqs 9 to 18; the rounds of lowering are ours.

    Args:
        chunks: Consecutive stretches of one program; drawn in another thread.
        machine: Limits, period, chord tolerance, servo data.
        options: Servo data that stand in for the machine's.
        bound: Of the error, mm.

    Yields:
        Trajectories, from rest to rest, as their speeds become final. Where the bound is not met after all rounds, the
        last one has a warning.

    Raises:
        UsageError: An axis of X Y Z has no servo data, or none that can be predicted.
        NoPlanError: No motion within the limits was found.
    """
    letters = "".join(letter for letter in "XYZ" if letter in machine.axes)
    per = prediction(machine, options, letters).per_centripetal_s2
    centripetal = _AIM * bound / per if per > 0.0 else np.inf
    plan = plan_blocks(smooth_blocks(chunks, machine), machine, centripetal)
    known: deque[_Slowness] = deque()
    # Below the speed that one period of full jerk or acceleration gives, no setpoint tells a cap from rest.
    pulse = float(AxisLimits.of(machine, letters).speed_step.min())
    for power, back in _ROUNDS:
        after: deque[_Slowness] = deque()
        watch = _Watch.of(machine, options, letters)
        floor = max(pulse, watch.slowest(bound))
        rule = _Lowering(bound, power, floor, round(back * watch.memory))
        caps = _lowered(plan, watch, rule, known, after)
        plan = plan_blocks(caps, machine, centripetal)
        known = after
    return _judged(plan, _Watch.of(machine, options, letters), bound)


def _lowered(
    plan: Iterator[Trajectory],
    watch: _Watch,
    rule: _Lowering,
    before: deque[_Slowness],
    after: deque[_Slowness],
) -> Iterator[tuple[Toolpath, SpeedCap]]:
    """Yield the blocks of a plan with the caps that its errors ask for.

    Args:
        plan: The plan.
        watch: Gives its errors.
        rule: How speeds are lowered.
        before: Caps that the plan was made under, block by block; empty for the first one. They are taken out.
        after: Takes the new ones.
    """
    for block, following in chain(chain.from_iterable(map(watch.add, by_block(plan))), watch.finish()):
        old = before.popleft() if before else _NO_CAP
        cap = _cap(block, following, old, rule)
        after.append(cap)
        yield block.toolpath, SpeedCap(cap, Limit.CONTOUR_ERROR)


def _cap(block: _JudgedBlock, following: Floats, old: _Slowness, rule: _Lowering) -> _Slowness:
    """Return the speed to which a block must be lowered.

    Args:
        block: Its samples.
        following: Errors of as many samples after it as the loops remember, fewer at the program's end.
        old: The cap that it was planned under.
        rule: How speeds are lowered.
    """
    n = len(block.error)
    if not n:
        return old
    error = np.concatenate([block.error, following])
    part = np.maximum(elementary.power(_AIM * rule.bound / np.maximum(error, rule.bound), rule.power), _LEAST)
    part = np.where(error > _MET * rule.bound, part, 1.0)
    spread = part[:n].copy()
    for back in range(1, min(rule.back, len(part) - 1) + 1):
        np.minimum(spread[: len(part) - back], part[back : back + n], out=spread[: len(part) - back])
    asked = np.where(spread < 1.0, 1.0 / np.maximum(block.v * spread, rule.slowest), 0.0)
    if not asked.any():
        return old
    # All places of both: where nothing more is asked, the cap stays what it was to the bit.
    s = np.union1d(old.s, block.s)
    return _Slowness(s, np.maximum(np.interp(s, old.s, old.slowness), np.interp(s, block.s, asked)))


def _judged(plan: Iterator[Trajectory], watch: _Watch, bound: float) -> Iterator[Trajectory]:
    """Hand a plan on, the last trajectory with a warning where the loops leave the path by more than the bound."""
    worst, where = bound, ""
    held: Trajectory | None = None

    def judge(blocks: Iterator[tuple[_JudgedBlock, Floats]]) -> None:
        nonlocal worst, where
        for block, _ in blocks:
            at = int(block.error.argmax()) if len(block.error) else 0
            if len(block.error) and block.error[at] > worst:
                row = block.toolpath.path.row_of(block.s[at : at + 1])[0]
                worst, where = float(block.error[at]), f"line {block.toolpath.line[row]}"

    for trajectory in plan:
        if held is not None:
            yield held
        held = trajectory
        judge(watch.add(PlannedBlock(trajectory.toolpath, trajectory.profile, ())))
    if held is None:
        return
    judge(watch.finish())
    yield with_remarks(held, (_remark(worst, bound, where),) if where else ())


def _remark(worst: float, bound: float, where: str) -> Diagnostic:
    return Diagnostic(
        "contour-error",
        f"the contour error is predicted to reach {1e3 * worst:.4g} µm near {where}, beyond the {1e3 * bound:.4g} µm "
        "asked for",
        severity=Severity.WARNING,
        hint="the speed was lowered as often as it is tried: tune the loops, or allow more",
        values={"predicted_mm": worst, "bound_mm": bound},
    )
