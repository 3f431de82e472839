"""The command that makes servo axes follow a motion, learnt on their model: friction, backlash and bounds included.

Each pass simulates the axes under the current command, and adds the change that removes most of the error
(`cncgen.servo.norm_optimal`). The first pass inverts the smooth part of the model; friction and backlash are in the simulated error,
and so enter the command, as steeply as limits and learning filter allow. The drives' bounds are limits of the command: it is learnt
without them, and keeps the drive inputs within them. The model for learning leaves out encoder steps and measurement noise, since they
do not repeat.

Where limits leave no room to catch up in time, further passes take away the way from each position to the nearest point of the path
alone. The axes then stay behind along the path, which costs no contour error.

Iterative learning control with a model in the place of the machine: D. A. Bristow, M. Tharayil and A. G. Alleyne, A survey of
iterative learning control, IEEE Control Systems Magazine 26 (2006) 96. Loops of other gain than 1 at rest get the motion
divided by it first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Axis
from cncgen.servo.bank import LoopBank
from cncgen.servo.contour import contour_error, nearest_on_path
from cncgen.servo.loop import AxisLoop
from cncgen.servo.norm_optimal import (
    ROUNDS,
    LimitedUpdate,
    WindowedUpdate,
    cut,
    limit_shares,
    rise_time,
    smooth_rise,
)
from cncgen.servo.plants import Imperfections

Floats = NDArray[np.float64]

#: An impulse response counts as over where what is left of it is below this share of its size.
SETTLED = 1e-9
#: Shortest and longest impulse response that is looked at, periods.
SHORTEST, LONGEST = 1 << 11, 1 << 18
#: Of the inverse's impulse response so much may be left beyond the rests before and after the motion.
BEYOND = 1e-7
#: Longest rest before and after, s.
LONGEST_REST_S = 15.0
#: A command that differs by less than this share of the motion's size from where it begins or ends counts as standing, and
#: rises from there, or falls to it, within this time, s, or within that which the limits ask for.
STANDING, FADE_S = 1e-7, 0.05
#: Rest beside what the inverse asks for, at least: limits spread a command over more time than the inverse needs. It is so long, s,
#: and until this share of a loop's memory remains.
LEEWAY_S, HEARD = 0.3, 1e-2
#: A motion whose contour error is less is judged by its tracking error (a straight line, say), mm.
NO_CONTOUR_MM = 1e-6
#: A gain has to be more than this share of the error: noise alone can make less.
LEAST_GAIN = 0.05
#: A pass that takes less than this share of the error away is the last one.
LEAST_PROGRESS = 0.02
#: Most rounds of the splitting after the first pass, and in the last one, which brings the command within its limits.
LATER_ROUNDS, FINISHING_ROUNDS = 150, 3000
#: Work of learning an axis at most, in periods times rounds: of any motion, and for each of its rows; so many rows of a program
#: count anyway, and so many of each of its lines: few lines may take hours.
WORK, WORK_A_ROW = 2e8, 3e4
ROWS, ROWS_A_LINE = 10_000, 1_000
#: How far a difference may be over its limit, as `cncgen verify` has it.
TOLERATED = 1e-3


@dataclass(frozen=True, slots=True)
class Figures:
    """Errors of a simulated motion, mm (rad of rotary axes alone), and its largest drive inputs.

    Attributes:
        tracking_rms, tracking_max: Distance between wanted and actual position.
        contour_rms, contour_max: Distance of the actual position from the path; nan where no linear axis moves.
        effort: Largest drive input of each axis.
        saturated: Setpoints with a drive at its bound, all axes.
        by_contour: Whether the motion is judged by its contour error, and not by its tracking error.
        missed: Largest distance of the path from where the axes go; nan as `contour_max`.
    """

    tracking_rms: float
    tracking_max: float
    contour_rms: float
    contour_max: float
    effort: tuple[float, ...]
    saturated: int
    by_contour: bool
    missed: float = np.nan

    @property
    def judged(self) -> float:
        """Return the measure of a command: the largest contour error, or else tracking error."""
        return self.contour_max if self.by_contour else self.tracking_max

    def better(self, than: Figures) -> bool:
        """Tell whether the judged error is smaller by more than noise makes, its rms not larger, and no more drives at their bound.

        Axes that hardly move are near the path as well, so none of it may be farther from where they go than before.
        """
        rms, other = (f.contour_rms if f.by_contour else f.tracking_rms for f in (self, than))
        gains = self.judged < (1.0 - LEAST_GAIN) * than.judged and rms <= other
        return (
            gains and self.saturated <= than.saturated and not (self.by_contour and self.missed > than.missed)
        )


@dataclass(frozen=True, slots=True)
class Learnt:
    """A learnt command with what was wanted, rests before and after included.

    Attributes:
        wanted, command: Shape (n, axes).
        lead, tail: Rows before and after the motion.
        before, after: Of the unchanged motion, and of the command.
        passes: How many there were until the command was the best one.
        excess: How far the command is over a limit, as a share of it.
        tried: Errors of the best command within the limits, better or not; None: no pass came within them.
    """

    wanted: Floats
    command: Floats
    lead: int
    tail: int
    before: Figures
    after: Figures
    passes: int
    excess: float
    tried: Figures | None = None


@dataclass(slots=True)
class WorkBudget:
    """How much of the splitting learning may do, and has done, in periods times rounds.

    Usual loops need a part of it. Loops with a memory of many seconds are learnt on stretches of as many seconds.
    """

    most: float
    done: float = 0.0

    @classmethod
    def of(cls, wanted: Floats, lines: int | None = None) -> WorkBudget:
        """Return what a motion, shape (n, axes), may take; `lines` are those of its program, where it comes of one."""
        rows = len(wanted) if lines is None else min(len(wanted), ROWS + ROWS_A_LINE * lines)
        return cls(wanted.shape[1] * (WORK + WORK_A_ROW * rows))

    @property
    def over(self) -> bool:
        """Tell whether the bound of work is reached: the present pass is ended, and another one is not begun."""
        return self.done >= self.most


def smooth_part(loop: AxisLoop) -> AxisLoop:
    """Return a loop without friction, bound, backlash, encoder steps and noise."""
    return replace(loop, dead_band=0.0, imperfections=Imperfections())


def impulse_response(loop: AxisLoop, period_s: float, letter: str = "") -> tuple[Floats, Floats]:
    """Return the answers of position and drive input to a setpoint of 1 at row 0, as long as they last; shape (n,) each.

    `letter` names the axis in messages.

    Raises:
        UsageError: It does not settle within `LONGEST` periods (``servo-unstable``).
    """
    rows = SHORTEST
    while rows <= LONGEST:
        command = np.zeros((rows + 2, 1))
        command[1] = 1.0
        found, force, _ = LoopBank([smooth_part(loop)], period_s).run(command)
        size = np.abs(found[1:, 0])
        if np.isfinite(size).all() and size[-rows // 4 :].sum() <= SETTLED * size.sum():
            return found[1:, 0], force[1:, 0]
        rows *= 2
    largest = float(np.abs(smooth_part(loop).poles()).max())
    message = f"axis {letter}: the loop has not settled {LONGEST * period_s:g} s after an impulse (a pole at |z| = {largest:.6g})"
    raise UsageError(
        Diagnostic(
            "servo-unstable",
            message,
            hint="the closed loop is unstable, or hardly damped: cncgen tune shows its margins",
        )
    )


def follow(
    loops: Sequence[AxisLoop], period_s: float, command: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return position, drive input and whether it met its bound, each (n, axes), under a command (n, axes) that begins at rest."""
    bank = LoopBank(loops, period_s)
    position, force, bounded = bank.run(np.concatenate([command, command[-1:]]) - command[0])
    return position + command[0], force, bounded


class Axes:
    """Servo axes whose motion is learnt: full and smooth models, and how long their inverses last."""

    def __init__(
        self,
        loops: Sequence[AxisLoop],
        period_s: float,
        contour_columns: Sequence[int],
        regularisation: float,
        letters: str,
    ) -> None:
        self.loops, self.period_s, self.regularisation = tuple(loops), period_s, regularisation
        self._columns = list(contour_columns)
        self.by_contour = bool(self._columns)
        self._known = [
            replace(
                loop,
                imperfections=replace(loop.imperfections, encoder_step=0.0, noise=0.0, bound=np.inf),
            )
            for loop in loops
        ]
        answers = [
            impulse_response(loop, period_s, letter) for loop, letter in zip(loops, letters, strict=True)
        ]
        self._impulses, self._forces = ([pair[k] for pair in answers] for k in (0, 1))
        self.bounds = [loop.imperfections.bound for loop in loops]
        self.gains = [float(h.sum()) for h in self._impulses]
        still = [letter for gain, letter in zip(self.gains, letters, strict=True) if abs(gain) < 1e-6]
        if still:
            message = f"axis {', '.join(still)}: the position comes back to 0 whatever the setpoint; no command leads it elsewhere"
            hint = "the last coefficient of the closed loop's numerator is its gain at rest times that of the denominator"
            raise UsageError(Diagnostic("compensate-rest", message, hint=hint))
        extents = [
            _inverse_extent(h, regularisation * g**2) for h, g in zip(self._impulses, self.gains, strict=True)
        ]
        longest = round(LONGEST_REST_S / period_s)
        own, kept = (
            [_extent(np.abs(h), left * np.abs(h).sum()) for h in self._impulses] for left in (BEYOND, HEARD)
        )
        self._heard_s = max(kept) * period_s
        #: Rows that the inverse asks for before and after the motion.
        self.asked = (
            min(max(e[0] for e in extents), longest),
            min(max(*own, *(e[1] for e in extents)), longest),
        )

    def goes_across(self, wanted: Floats) -> bool:
        """Tell whether two or more axes of the contour move: of one alone the path is a line that it cannot leave."""
        return int((np.ptp(wanted[:, self._columns], axis=0) > 0.0).sum()) > 1

    def response(self, axis: int, length: int) -> NDArray[np.complex128]:
        """Return the smooth loop's response at the frequencies of `numpy.fft.rfft` over a length."""
        return np.fft.rfft(self._impulses[axis], length)

    def drive(self, axis: int, length: int) -> NDArray[np.complex128] | None:
        """Return the answer of the drive input over its bound, as `response`; None where it has no bound."""
        bound = self.bounds[axis]
        return np.fft.rfft(self._forces[axis] / bound, length) if np.isfinite(bound) else None

    def leeway(self, wanted: Floats, limits: Sequence[Axis | None]) -> int:
        """Return the rows of rest beside what the inverse asks for: in them the change that it makes can rise within the limits.

        Args:
            wanted: The motion, shape (n, axes).
            limits: Of each axis; None: it has none.
        """
        whole = np.concatenate([wanted, np.repeat(wanted[-1:], self.asked[1], axis=0)])
        error = whole - self.followed(whole, known=True)[0]
        seconds = [LEEWAY_S, self._heard_s]
        for i, limit in enumerate(limits):
            if limit is not None:
                length = self.length(len(whole))
                update = LimitedUpdate(
                    self.response(i, length),
                    length,
                    self.period_s,
                    None,
                    self.regularisation * self.gains[i] ** 2,
                )
                change = update.change(whole[:, i], error[:, i])
                seconds.append(rise_time(float(np.abs(change).max()), limit))
        return round(min(max(seconds), LONGEST_REST_S) / self.period_s)

    def length(self, rows: int) -> int:
        """Return a quick length of the transform for that many rows and the loops' memory."""
        needed = rows + max(len(h) for h in self._impulses)
        return min(n for n in (1 << k for k in range(1, 40)) if n >= needed)

    def followed(self, command: Floats, known: bool = False) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return position, drive input and whether it met its bound, each (n, axes), under a command (n, axes).

        Args:
            command: It begins at rest.
            known: Without encoder steps and noise, which are not the same the next time, and without the drives' bounds, which
                the command keeps.
        """
        return follow(self._known if known else self.loops, self.period_s, command)

    def tracking_error(self, wanted: Floats, position: Floats) -> Floats:
        """Return how far positions are from where they are wanted, shape (n, axes) all."""
        return wanted - position

    def contour_error(self, wanted: Floats, position: Floats) -> Floats:
        """Return how far positions are from the path, as `tracking_error`; of axes outside of the contour, from the wanted
        positions."""
        error = wanted - position
        columns = self._columns
        error[:, columns] = nearest_on_path(wanted[:, columns], position[:, columns]) - position[:, columns]
        return error

    def figures(self, wanted: Floats, command: Floats) -> Figures:
        """Return the errors of the full model under a command."""
        return figures_of(wanted, self.followed(command), self._columns, self.by_contour)


def figures_of(
    wanted: Floats,
    followed: tuple[Floats, Floats, NDArray[np.bool_]],
    columns: Sequence[int],
    by_contour: bool,
) -> Figures:
    """Return the errors of the result of `follow` against the wanted motion, shape (n, axes); `columns` are those of the contour."""
    position, force, bounded = followed
    contour = rms = missed = np.nan
    judged = list(columns) or list(range(wanted.shape[1]))
    distance = np.sqrt(((wanted - position)[:, judged] ** 2).sum(axis=1))
    if columns:
        errors = contour_error(wanted[:, judged], position[:, judged])
        contour, rms = float(errors.max()), float(np.sqrt((errors**2).mean()))
        missed = float(contour_error(position[:, judged], wanted[:, judged]).max())
    return Figures(
        float(np.sqrt((distance**2).mean())),
        float(distance.max()),
        rms,
        contour,
        tuple(float(v) for v in np.abs(force).max(axis=0)),
        int(bounded.sum()),
        by_contour,
        missed,
    )


def _inverse_extent(impulse: Floats, regularisation: float) -> tuple[int, int]:
    """Return how many periods before and after an error the filter G*/(|G|² + ε) responds to it, up to `BEYOND`."""
    length = 4 * max(len(impulse), SHORTEST)
    response = np.fft.rfft(impulse, length)
    answer = np.abs(np.fft.irfft(np.conj(response) / (np.abs(response) ** 2 + regularisation), length))
    after, before = answer[: length // 2], answer[: length // 2 : -1]
    left = BEYOND * answer.sum()
    return _extent(before, left), _extent(after, left)


def _extent(size: Floats, left: float) -> int:
    """Return the number of entries after which at most `left` of a sum of sizes remains."""
    return int((size[::-1].cumsum()[::-1] > left).sum())


def learn(
    wanted: Floats,
    axes: Axes,
    limits: Sequence[Axis | None],
    *,
    passes: int,
    settle_s: float = 0.0,
    enough: float = np.inf,
    work: WorkBudget | None = None,
) -> Learnt:
    """Return the best command of up to that many passes, which take the tracking error away.

    Where limits do not let them divide the contour error by `enough`, as many passes take the contour error alone away, and leave
    the axes behind along the path: from the last command, then from the motion itself.

    Args:
        wanted: The motion, shape (n, axes), at rest before and after.
        axes: The axes that follow it.
        limits: Of each axis; None: it has none.
        passes: At least 1.
        settle_s: Least rest at the end.
        enough: See above; at most 1: the tracking error alone is looked at.
        work: Counts it, over several motions say; None: `WorkBudget.of` this motion.
    """
    leeway = axes.leeway(wanted, limits)
    lead, tail = axes.asked[0] + leeway, max(axes.asked[1] + leeway, round(settle_s / axes.period_s))
    whole = np.concatenate(
        [np.repeat(wanted[:1], lead, axis=0), wanted, np.repeat(wanted[-1:], tail, axis=0)]
    )
    command = whole[:1] + (whole - whole[:1]) / np.array(axes.gains)
    unity = [abs(gain - 1.0) < 1e-6 for gain in axes.gains]
    command[:, unity] = whole[:, unity]
    resting = command.copy()
    before = axes.figures(whole, whole)
    if not axes.goes_across(wanted) or before.contour_max <= NO_CONTOUR_MM:
        axes.by_contour = False
        before = replace(before, by_contour=False)
    if before.judged <= NO_CONTOUR_MM:
        return _trimmed(
            Learnt(whole, whole, lead, tail, before, before, 0, 0.0, before), whole, settle_s, axes, limits
        )
    passes_of = _Passes(whole, axes, limits, leeway, work or WorkBudget.of(wanted))
    found = Learnt(whole, whole, lead, tail, before, before, 0, 0.0)
    if passes_of.least_work > passes_of.work.most:  # no pass would end: it is known before the first one
        passes_of.work.done = passes_of.least_work
        return _trimmed(found, whole, settle_s, axes, limits)
    found, last = passes_of.run(found, command, passes, axes.tracking_error)
    for start in (last, resting):
        if axes.by_contour and found.after.judged * enough > before.judged and not passes_of.work.over:
            found, _ = passes_of.run(found, start, passes, axes.contour_error)
    return _trimmed(found, resting if found.passes else whole, settle_s, axes, limits)


class _Passes:
    """Passes of learning on one motion, whose rests before and after are included: shape (n, axes)."""

    def __init__(
        self, whole: Floats, axes: Axes, limits: Sequence[Axis | None], leeway: int, work: WorkBudget
    ) -> None:
        self._whole, self._axes, self._limits, self.work = whole, axes, limits, work
        self._windows = cut(_busy(whole, limits, axes.period_s), sum(axes.asked) + 2 * leeway)
        self._fading = _fading(len(whole), leeway)
        self._done = 0

    @property
    def least_work(self) -> float:
        """Return what one pass may ask for that brings a command within its limits."""
        rows = self._axes.length(self._windows.rows) * (len(self._windows.seams) - 1)
        return float(sum(limit is not None for limit in self._limits) * rows * (ROUNDS + FINISHING_ROUNDS))

    def _updates(self) -> list[WindowedUpdate]:
        axes, length = self._axes, self._axes.length(self._windows.rows)
        found = []
        for i, limit in enumerate(self._limits):
            one = LimitedUpdate(axes.response(i, length), length, axes.period_s, limit,
                                axes.regularisation * axes.gains[i] ** 2, drive=axes.drive(i, length))  # fmt: skip
            found.append(WindowedUpdate(self._windows, [replace(one) for _ in self._windows.seams[1:]]))
        return found

    def run(
        self, best: Learnt, start: Floats, passes: int, error_of: Callable[[Floats, Floats], Floats]
    ) -> tuple[Learnt, Floats]:
        """Return the best command of up to that many passes, if it is better than the best so far, and the last command.

        Args:
            best: The best command so far.
            start: The first command, shape (n, axes).
            passes: At least 1.
            error_of: From wanted and actual positions to what is to be taken away, shape (n, axes) all.
        """
        axes, whole, command, updates = self._axes, self._whole, start.copy(), self._updates()
        before, judged = self.work.done, list[float]()
        for k in range(1, passes + 1):
            self._done += 1
            position, force, _ = axes.followed(command, known=True)
            error = error_of(whole, position) * self._fading
            ends = k == passes or self.work.over
            ends = ends or (len(judged) > 1 and judged[-1] > (1.0 - LEAST_PROGRESS) * judged[-2])
            rounds = FINISHING_ROUNDS if ends else ROUNDS if k == 1 else LATER_ROUNDS
            for i, update in enumerate(updates):
                command[:, i] += update.change(
                    command[:, i], error[:, i], rounds, force[:, i] / axes.bounds[i]
                )
            self.work.done = before + sum(update.work for update in updates)
            excess = max(update.excess for update in updates)
            after = axes.figures(whole, command)
            if excess <= TOLERATED and (best.tried is None or after.judged < best.tried.judged):
                best = replace(best, tried=after)
            if excess <= TOLERATED and after.better(best.before) and after.judged < best.after.judged:
                best = replace(best, after=after, command=command.copy(), passes=self._done, excess=excess)
            if ends:
                break
            judged.append(after.judged)
        return best, command


def _busy(rows: Floats, limits: Sequence[Axis | None], period_s: float) -> Floats:
    """Return the largest share of any axis's limits that each row of a motion, shape (n, axes), takes, shape (n,)."""
    shares = [
        limit_shares(rows[:, i], axis, period_s)[: len(rows)]
        for i, axis in enumerate(limits)
        if axis is not None
    ]
    return np.asarray(np.max(shares, axis=0)) if shares else np.zeros(len(rows))


def _fading(rows: int, rest: int) -> Floats:
    """Return 1 during the motion, falling to 0 over the outer half of the rests, shape (rows, 1).

    An axis that friction holds keeps an error at rest. A command that took it away for ever would not come back to the end.
    """
    half = max(rest // 2, 1)
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(half) / half)
    weights = np.ones(rows)
    weights[:half], weights[rows - half :] = rise, rise[::-1]
    return weights[:, None]


def _trimmed(
    learnt: Learnt, resting: Floats, settle_s: float, axes: Axes, limits: Sequence[Axis | None]
) -> Learnt:
    """Return the command without the part of its rests in which it stands still, except for the least rest at the end.

    `resting`, shape (n, axes), is a command that stands in both rests where this one comes to. Where this one still stands elsewhere at
    the end of its time (friction holds the axis), it goes there as slowly as the `limits` ask for.
    """
    command, period = learnt.command, axes.period_s
    small = STANDING * float(np.ptp(learnt.wanted, axis=0).max(initial=0.0))
    left = np.abs(command - resting)[[0, -1]].max(axis=0)
    times = [rise_time(float(d), limit) for d, limit in zip(left, limits, strict=True) if limit is not None]
    fade = round(max(FADE_S, *times) / period) if times else round(FADE_S / period)
    least = len(command) - learnt.tail + round(settle_s / period)
    away = np.abs(command - resting[0]).max(axis=1) > small
    late = np.abs(command - resting[-1]).max(axis=1) > small
    first = int(away.argmax()) if away.any() else learnt.lead
    last = len(late) - int(late[::-1].argmax()) if late.any() else least
    begin = max(min(first - fade, learnt.lead), 0)
    end = min(max(last + fade, least), len(command))
    rise = np.clip(np.arange(end - begin) / fade, 0.0, 1.0)
    weight = smooth_rise(rise) * smooth_rise(rise[::-1])
    wanted = learnt.wanted[begin:end]
    trimmed = resting[begin:end] + (command - resting)[begin:end] * weight[:, None]
    return replace(
        learnt,
        wanted=wanted,
        command=trimmed,
        lead=learnt.lead - begin,
        tail=learnt.tail - (len(command) - end),
        before=axes.figures(wanted, wanted),
        after=axes.figures(wanted, trimmed),
    )
