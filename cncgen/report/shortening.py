"""Which limit shortens a program: the time's derivative to each limit, feed and tolerance, and the time of a plan with each changed.

Every quantity is planned 10 % and 5 % higher and lower. The derivative is the five-point difference of these plans (Abramowitz and
Stegun (1964), 25.3.6), whose error is below 10⁻⁴ where the time is smooth. It is not smooth everywhere: a rapid at 45° needs more jerk
of both axes, so one of them alone can only lengthen it, and plans of path and speed together jump by some 10⁻⁵ to 10⁻⁴ of the time.
Over the period the time is a sawtooth, since stops wait for a setpoint. Where the differences show an error of more than 0.5 % of the
derivative, and of more than 0.05 % of the cycle, the quantity is planned within 2.5 % too: where these plans change nothing, it does not bind; where the time is smooth so far, the
differences of 2.5 and 5 % count. Else the derivative is the least-squares one of eight, sixteen or 32 plans within 5 %, as many as make it
sure. It is missing where its distance from the differences of other plans may be above 2 %; `Slope.kind` says why. All is given for a
change of 10 % in the direction that shortens (a period falls, all others rise). Where events alone take another time, nothing is planned again (`waited_times`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Axis, Machine
from cncgen.machine.times import times_of
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.event_times import with_event_times
from cncgen.report.line_times import LineTimes
from cncgen.report.tables import duration, text_table
from cncgen.report.time_split import TimeSplit, part_of
from cncgen.toolpath.record import Event, FeedMode, Kind, Toolpath

#: The change that results are given for; differences take 32nds of it as their steps, so the plan of it is one of theirs.
CHANGE, WHOLE = 0.10, 32
#: No more plans are made where five or seven show that the error is below this part of the cycle: the ranking does not need it closer.
_ENOUGH = 5e-4
#: A derivative of five plans is given where the bound of its error is below this part of it: their scatter is seen by one difference.
_SURE = 0.005
#: Up to this part two more plans within 5 % may bring it down: a time inverse to the quantity makes 0.5 % of it.
_CURVED = 0.01
#: The same of five plans within 5 %, in which scatter counts twice.
_SURE_NEAR = 0.0025
#: The same of eight and sixteen plans, of whose scatter little is known, and of 32. The bound is that of the distance from
#: differences of sixteen other plans.
_KNOWN = {4: 0.01, 8: 0.01, 16: 0.02}
_OTHERS = 8
#: Sixteen more plans are made where sixteen scatter within this bound: they bring it down to four fifths or so.
_HOPED = 0.09
#: A kink is one where the derivatives to both sides differ by twice this part of the larger.
_KINK = 0.01
#: 97.5 and 99.95 % of Student's distribution, by degrees of freedom (Abramowitz and Stegun (1964), table 26.10).
_STUDENT = {3: 3.182, 6: 2.447, 7: 2.365, 14: 2.145, 15: 2.131}
_STUDENT_SURE = {1: 636.6, 2: 31.6, 3: 12.92, 4: 8.61, 5: 6.869, 6: 5.959, 7: 5.408}
_STUDENT_SURE |= {12: 4.318, 13: 4.221, 14: 4.14, 15: 4.073}
#: A pair of plans falls out of so many where its studentised residual is above this: one time in a thousand by chance, by
#: Bonferroni's inequality (Cook and Weisberg (1982), section 2.2).
_FALLS_OUT = {8: 8.729, 16: 5.626}
_Key = TypeVar("_Key")
#: An entry of ``[times]``: a number, seconds of M codes, or seconds to reach speeds.
_TimesEntry = float | Mapping[str, float] | Sequence[Sequence[float]]
Floats = NDArray[np.float64]
#: Where no tool is known.
_NO_TOOL = "–"
#: Entries of ``[times]`` that change feeds: all others are of events.
_OF_FEEDS = ("spindle_max_rpm", "block_s")
#: Lines and tools named for each quantity.
_PLACES = 3
#: A saving below this part of the cycle counts as none: two plans on the rows agree to so much. Two plans of path and speed together
#: may differ by more of their time where nothing that binds differs (docs/times.md).
_NOISE, _JUMPS = 1e-6, 1e-4


@dataclass(frozen=True, slots=True)
class Case:
    """A planning task: the program's chunks (see `cncgen.toolpath.record.Program`), the machine, the options."""

    chunks: Callable[..., Iterable[Toolpath]]
    machine: Machine
    options: PlanOptions


@dataclass(frozen=True, slots=True)
class Quantity:
    """A limit, a feed or a tolerance that can be changed.

    Attributes:
        name: Key of the machine file, or a word of the program (``feed``).
        value: Its present value with the unit; "" for many values.
        sign: +1 where a rise shortens, -1 where a fall does.
        scaled: Returns the case with the quantity multiplied by a factor.
        part: Part of the split that counts; "": the whole cycle.
        waits: Whether events alone take another time, while the motion between them stays.
    """

    name: str
    value: str
    sign: int
    scaled: Callable[[Case, float], Case]
    part: str = ""
    waits: bool = False


@dataclass(frozen=True, slots=True)
class PlannedTimes:
    """Times of one plan: the cycle, its parts, of each line, of each tool; and that of path and speed planned together."""

    cycle_s: float
    parts: dict[str, float]
    lines: dict[tuple[str, int], float]
    tools: dict[str, float]
    together_s: float

    @property
    def noise_s(self) -> float:
        """A saving below it counts as none."""
        return _NOISE * self.cycle_s

    @property
    def agreement_s(self) -> float:
        """Seconds to which plans agree that differ in nothing that binds."""
        return max(self.noise_s, _JUMPS * self.together_s)


class SlopeKind(StrEnum):
    """Kinds of derivatives, by the plans around a quantity's value."""

    SMOOTH = "smooth"
    NO_EFFECT = "no effect"
    #: It binds only where it is changed further: the derivative is 0.
    SLACK = "does not bind"
    #: Few plans know it to a bound that is a small part of the cycle.
    ENOUGH = "few plans"
    #: The plans scatter by more than a derivative may be off: it is known to a bound.
    SCATTER = "scatter"
    #: Differences of ±2 % and ±5 % differ by more than that: it is known to a bound.
    BEND = "bend"
    #: The derivatives to both sides differ.
    KINK = "kink"


@dataclass(frozen=True, slots=True)
class Slope:
    """A derivative, or the reason why it is missing.

    Attributes:
        kind: How far it is known.
        seconds: Saving of the whole change by it; the best estimate where it scatters or bends.
        bound: Of the error, in seconds: 97.5 % of one sign; 99.95 % where it scatters or bends. Of what has no effect or does not
            bind, to what plans agree.
        sides: The saving of the whole change by the derivative to its side, and what its opposite costs by the other, where they differ.
    """

    kind: SlopeKind
    seconds: float = 0.0
    bound: float = 0.0
    sides: tuple[float, float] | None = None

    @property
    def derivative(self) -> float | None:
        """The seconds where they are a derivative."""
        return self.seconds if self.kind in (SlopeKind.SMOOTH, SlopeKind.NO_EFFECT, SlopeKind.SLACK) else None


@dataclass(frozen=True, slots=True)
class Shortening:
    """The worth of a quantity.

    Attributes:
        name, value: The quantity, see `Quantity`.
        change: Relative change, signed.
        slope: Seconds that the cycle gets shorter for the change, by the derivative.
        sides_s: The same by the derivatives to either side: the saving of the change at first, the cost of its opposite.
        saved_s: Seconds that a plan with the whole change is shorter.
        lines: The lines that save most: file, line, seconds.
        tools: Seconds saved with each tool, the most first.
    """

    name: str
    value: str
    change: float
    slope: Slope
    sides_s: tuple[float, float]
    saved_s: float
    lines: tuple[tuple[str, int, float], ...] = ()
    tools: tuple[tuple[str, float], ...] = ()

    @property
    def derivative_s(self) -> float | None:
        """The slope where it is a derivative."""
        return self.slope.derivative

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            "name": self.name,
            "value": self.value,
            "change": self.change,
            "derivative_s": self.derivative_s,
            "kind": str(self.slope.kind),
            "estimate_s": self.slope.seconds,
            "bound_s": self.slope.bound,
            "sides_s": list(self.sides_s),
            "saved_s": self.saved_s,
            "lines": [{"source": s, "line": n, "saved_s": t} for s, n, t in self.lines],
            "tools": [{"tool": name, "saved_s": t} for name, t in self.tools],
        }


def _tool(event: Event) -> str:
    return str(event.values.get("tool", _NO_TOOL))


@dataclass(slots=True)
class _ToolTimes:
    """Adds up the time between tool changes; a change counts for the tool that it brings."""

    tool: str = _NO_TOOL
    since_s: float = 0.0
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, trajectory: Trajectory) -> None:
        for t_s, _, event in trajectory.events:
            if event.name == "tool":
                self.end(t_s)
                self.tool = _tool(event)

    def end(self, t_s: float) -> None:
        self.seconds[self.tool] = self.seconds.get(self.tool, 0.0) + t_s - self.since_s
        self.since_s = t_s


def planned_times(case: Case) -> PlannedTimes:
    """Plan a case, and return its times.

    Raises:
        NoPlanError, ProgramError: As `cncgen.planner.plan`.
    """
    split, lines, tools, together_s = TimeSplit(), LineTimes(), _ToolTimes(), 0.0
    for trajectory in plan(case.chunks(), case.machine, case.options):
        if trajectory.cubics is not None:
            together_s += float(np.ptp(trajectory.profile.t))
        split.add(trajectory)
        lines.add(trajectory)
        tools.add(trajectory)
    found = split.as_json()
    tools.end(found["cycle_time_s"])
    every = {(line.source, line.line): line.time_s for line in lines.longest(lines.lines)}
    return PlannedTimes(found["cycle_time_s"], found["cycle_time_split_s"], every, tools.seconds, together_s)


def waited_times(now: PlannedTimes, case: Case, other: Case) -> PlannedTimes:
    """Return the times of another case in which only events take another time, from those of a planned one.

    Its motion is not planned again: setpoints that meet it elsewhere change rests in corners by less than a period.
    """
    parts, lines, tools = dict(now.parts), dict(now.lines), dict(now.tools)
    cycle_s, tool = now.cycle_s, _NO_TOOL
    for (line, one), (_, two) in zip(_events(case), _events(other), strict=True):
        tool = _tool(one) if one.name == "tool" else tool
        more = two.takes_s - one.takes_s
        if more:
            cycle_s += more
            parts[part_of(one)] += more
            lines[line] = lines.get(line, 0.0) + more
            tools[tool] = tools.get(tool, 0.0) + more
    return PlannedTimes(cycle_s, parts, lines, tools, now.together_s)


def _events(case: Case) -> Iterator[tuple[tuple[str, int], Event]]:
    """Yield the events of a case, with the place that `LineTimes` counts each at."""
    for chunk in with_event_times(case.chunks(), times_of(case.machine)):
        for row in np.flatnonzero(chunk.kind == Kind.EVENT):
            yield (chunk.sources[0], int(chunk.line[row])), chunk.events[int(chunk.curve[row])]


def quantities(case: Case, axes: str) -> list[Quantity]:
    """Return the quantities that a case has: limits of its axes, feed, tolerances, period, rapids, times."""
    machine = case.machine
    found = [
        _axis_limit(machine.axes[axis], limit)
        for axis in axes
        if axis in machine.axes
        for limit in ("max_velocity", "max_acceleration", "max_jerk")
    ]
    found += [
        Quantity("feed", "", 1, _scaled_feed),
        Quantity("path tolerance", "", 1, _scaled_tolerance),
        Quantity(
            "chord_tolerance_mm", f"{machine.chord_tolerance_mm:g} mm", 1, _scaled_top("chord_tolerance_mm")
        ),
        Quantity("period_s", f"{machine.period_s:g} s", -1, _scaled_top("period_s")),
        Quantity("rapid velocity", "", 1, _scaled_velocities, part="rapid"),
    ]
    times = machine.settings.get("times", {})
    return found + [
        Quantity(
            f"times.{key}",
            _time_text(key, value),
            1 if key.endswith(("rpm_s", "_rpm")) else -1,
            _scaled_time(key),
            waits=key not in _OF_FEEDS,
        )
        for key, value in times.items()
        if key != "pockets" and value
    ]


def shortenings(
    case: Case, axes: str, watch: Callable[[int, int], None] = lambda done, of: None
) -> tuple[PlannedTimes, list[Shortening]]:
    """Return the times of the unchanged plan, and the savings of each quantity, the largest first.

    Args:
        case: The planned case; its chunks are read up to 34 times per quantity.
        axes: Letters of the axes whose limits count.
        watch: Called with the number of plans that are done, and of all.

    Raises:
        NoPlanError, ProgramError: As `cncgen.planner.plan`, of the unchanged case.
    """
    names = quantities(case, axes)
    total, done = 1 + _MOST_PLANS * len(names), 1
    now = planned_times(case)
    watch(done, total)
    found = []
    for quantity in names:

        def tell(plans: int, before: int = done) -> None:
            watch(before + plans, total)

        found.append(_Savings(case, quantity, now, tell).worth())
        done += _MOST_PLANS
        watch(done, total)
    found.sort(key=lambda each: -each.saved_s)
    return now, found


#: Plans of a quantity: two of the whole change, and 32 within half of it where fewer leave the derivative open.
_MOST_PLANS = 34


class _Savings:
    """Plans of a quantity by 32nds of the change, each made when it is first asked for.

    Args:
        case: The planned case.
        quantity: The changed quantity.
        now: Times of the unchanged case.
        watch: Called after each plan with their number.
    """

    def __init__(
        self, case: Case, quantity: Quantity, now: PlannedTimes, watch: Callable[[int], None]
    ) -> None:
        self.case, self.quantity, self.now, self.watch = case, quantity, now, watch
        self.plans = {0: now}

    def planned(self, steps: int) -> PlannedTimes:
        """Return the times of a plan with so many 32nds of the change."""
        if steps not in self.plans:
            factor = 1.0 + self.quantity.sign * steps * CHANGE / WHOLE
            other = self.quantity.scaled(self.case, factor)
            waits = self.quantity.waits
            self.plans[steps] = waited_times(self.now, self.case, other) if waits else planned_times(other)
            self.watch(len(self.plans) - 1)
        return self.plans[steps]

    def __call__(self, steps: int) -> float:
        """Return the seconds that so many 32nds of the change save."""
        part = self.quantity.part
        one, other = self.now, self.planned(steps)
        return one.parts[part] - other.parts[part] if part else one.cycle_s - other.cycle_s

    def worth(self) -> Shortening:
        """Return the savings of the quantity."""
        quantity, now, noise = self.quantity, self.now, self.now.noise_s
        whole = self(WHOLE)
        # If the whole change has no effect, a smaller one has none either.
        if max(abs(whole), abs(self(-WHOLE))) <= noise:
            slope, sides = Slope(SlopeKind.NO_EFFECT, bound=now.agreement_s), (0.0, 0.0)
        else:
            slope = derivative(self, noise, now.agreement_s, _ENOUGH * now.cycle_s)
            sides = slope.sides or (slope.seconds, slope.seconds)
        found = Shortening(quantity.name, quantity.value, quantity.sign * CHANGE, slope, sides, whole)
        if abs(whole) < noise:
            return found
        lines = _most(now.lines, self.planned(WHOLE).lines)
        tools = _most(now.tools, self.planned(WHOLE).tools)
        return replace(
            found,
            lines=tuple((*key, seconds) for key, seconds in lines if seconds > noise),
            tools=tuple(tools),
        )


def derivative(
    saved: Callable[[int], float], noise: float, agreement: float = 0.0, enough: float = 0.0
) -> Slope:
    """Return the saving of a whole change by the derivative, or the reason why it is missing.

    Args:
        saved: Returns the seconds that so many 32nds of the change save; asked for up to 32 of them to both sides.
        noise: A saving below it is 0.
        agreement: Seconds to which plans agree.
        enough: An error of the saving that is not worth more plans.
    """
    found = _five_point(saved, WHOLE // 2)
    if max(abs(found.seconds), found.bound) <= noise:
        return Slope(SlopeKind.SMOOTH, 0.0, found.bound)
    if found.bound <= _SURE * abs(found.seconds):
        return found
    # The derivative may lie anywhere between the differences to both sides: a limit that no longer binds 4 % higher up makes a bend that
    # a fourth difference does not show. Of plans that agree to a, it is up to 1.5 a off beside that.
    between = abs(saved(WHOLE // 2) + saved(-WHOLE // 2))
    rough = Slope(SlopeKind.ENOUGH, found.seconds, max(found.bound, between) + 1.5 * agreement)
    if rough.bound <= enough and found.bound > _CURVED * abs(found.seconds):
        return rough
    if all(max(abs(saved(k)), abs(saved(-k))) <= noise for k in (8, 6, 4, 2)):
        return Slope(SlopeKind.SLACK, bound=agreement)
    found = _five_point(saved, WHOLE // 4)
    if noise < abs(found.seconds) and found.bound <= _SURE_NEAR * abs(found.seconds):
        return found
    if rough.bound <= enough:
        return rough
    for pairs in _KNOWN:
        found = _fitted(saved, pairs)
        hopeless = pairs == _OTHERS and found.bound > _HOPED * abs(found.seconds)
        if found.kind not in (SlopeKind.SCATTER, SlopeKind.BEND) or hopeless:
            break
    return found


def _five_point(saved: Callable[[int], float], step: int) -> Slope:
    """Return the five-point difference of plans `step` sixteenths apart, and a bound of its error."""
    near, far = saved(step) - saved(-step), 0.5 * (saved(2 * step) - saved(-2 * step))
    # Where the derivatives to both sides differ by d, the fourth difference is d. A jump of the time by d between two of the plans
    # makes 3 d or d of it, and 7/6 d or d/6 of the slope. It may miss a jump of the second derivative: the error of the slope is then
    # at most two thirds of the difference between near and far.
    fourth = saved(2 * step) - 4.0 * saved(step) + 6.0 * saved(0) - 4.0 * saved(-step) + saved(-2 * step)
    bound = max(0.4 * abs(fourth), abs(near - far) * 2.0 / 3.0)
    whole = WHOLE / (2 * step)
    return Slope(SlopeKind.SMOOTH, whole * (4.0 * near - far) / 3.0, whole * bound)


def _fitted(saved: Callable[[int], float], pairs: int) -> Slope:
    """Return the slope of plans within half of the change by least squares, and whether it is a derivative.

    A straight line fits the odd parts of their savings: for a time that is proportional to the inverse of a quantity its error is 0.2
    %. In the even parts, |x| has half of the difference of the derivatives to both sides, and x² has the rest. Where the second
    derivative jumps, x |x| is in the odd parts, of which a difference of ±2 % takes 0.2 and one of ±5 % takes 0.5: then the slope is the
    middle between these, and their distance to it counts. One pair may fall out: a plan that jumped, and no other near by.

    Args:
        saved: As of `derivative`.
        pairs: Number of plans to either side.
    """
    x = np.arange(1, pairs + 1) / (2.0 * pairs)
    up, down = (np.array([saved(sign * int(WHOLE * each)) for each in x]) for sign in (1, -1))
    odd, even = (up - down) / 2.0, (up + down) / 2.0
    kept = _in_a_row(x, odd)
    x, odd, even = x[kept], odd[kept], even[kept]
    one, two, three = len(x) - 1, len(x) - 2, len(x) - 3
    (slope,), spread = _least_squares(x[:, None], odd)
    scatter, rest, away = np.sqrt(spread.item()), odd - slope * x, 0.0
    terms = np.stack([x, x**2], axis=1)
    (first, turn), spread = _least_squares(terms, odd)
    curved = odd - terms @ (first, turn)
    if abs(turn) > _STUDENT_SURE[two] * np.sqrt(spread[1, 1]) * _in_series(curved):
        middle = np.array([1.0, 0.35])
        slope, rest = first + 0.35 * turn, curved
        scatter, away = np.sqrt(middle @ spread @ middle), 0.15 * abs(turn)
    # The plan at the value scatters too, and all even parts with it.
    (_, bend, _), spread = _least_squares(np.stack([x**0, x, x**2], axis=1), even)
    bent = abs(bend) - _STUDENT_SURE[three] * np.sqrt(spread[1, 1])
    # Differences of other plans see the common part of neighbours too.
    scatter *= max(np.sqrt(1.0 + pairs / _OTHERS), _in_series(rest))
    bound = np.hypot(away, _STUDENT[one] * scatter)
    if bent > max(bound, _KINK * (abs(slope) + abs(bend))):
        (bend, _), _ = _least_squares(terms, even)
        return Slope(SlopeKind.KINK, float(slope), float(bound), (float(first + bend), float(first - bend)))
    if bound <= _KNOWN[pairs] * abs(slope):
        return Slope(SlopeKind.SMOOTH, float(slope), float(bound))
    kind = SlopeKind.BEND if away > _STUDENT[one] * scatter else SlopeKind.SCATTER
    return Slope(kind, float(slope), float(np.hypot(away, _STUDENT_SURE[one] * scatter)))


def _in_series(rest: Floats) -> float:
    """Return how much more values scatter than independent ones would, by their remainders: after a jump they are alike.

    √((1 + ρ)/(1 - ρ)), with the correlation ρ of neighbours (Bayley and Hammersley (1946), J. Royal Statistical Society Suppl. 8).
    """
    square = float(rest @ rest)
    alike = max(0.0, float(rest[1:] @ rest[:-1]) / square) if square else 0.0
    return float(np.sqrt((1.0 + alike) / (1.0 - alike)))


def _in_a_row(x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which points belong to a straight line through 0: all, or all but one that falls out."""
    every = np.ones(len(x), dtype=bool)
    if len(x) not in _FALLS_OUT:
        return every
    beyond = []
    for k in range(len(x)):
        others = every.copy()
        others[k] = False
        (slope,), spread = _least_squares(x[others, None], y[others])
        # A point's own scatter, and that of the line there.
        scatter = np.sqrt(spread.item() * (x[others] @ x[others] + x[k] ** 2))
        beyond.append(abs(y[k] - slope * x[k]) - _FALLS_OUT[len(x)] * scatter)
    # After the outermost, nothing tells whether the next ones fall out too.
    worst = int(np.argmax(beyond[:-1]))
    every[worst] = beyond[worst] <= 0.0
    return every


def _least_squares(terms: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients of the columns of `terms` that fit values best, and their covariance."""
    inverse = np.linalg.inv(terms.T @ terms)
    found = inverse @ terms.T @ values
    rest = values - terms @ found
    return found, rest @ rest / (len(values) - len(found)) * inverse


def _most(before: Mapping[_Key, float], after: Mapping[_Key, float]) -> list[tuple[_Key, float]]:
    """Return the largest saving, by its key."""
    saved = [(key, seconds - after.get(key, 0.0)) for key, seconds in before.items()]
    return sorted(saved, key=lambda each: -each[1])[:_PLACES]


def _axis_limit(axis: Axis, limit: str) -> Quantity:
    from cncgen.units import file_unit, to_file

    power = {"max_velocity": "", "max_acceleration": "²", "max_jerk": "³"}[limit]
    value = f"{getattr(axis, limit) * to_file(axis.letter):g} {file_unit(axis.letter)}/s{power}"

    def scaled(case: Case, factor: float) -> Case:
        axes = dict(case.machine.axes)
        axes[axis.letter] = replace(axis, **{limit: getattr(axis, limit) * factor})
        return replace(case, machine=replace(case.machine, axes=axes))

    return Quantity(f"{axis.letter} {limit.removeprefix('max_')}", value, 1, scaled)


def _scaled_top(name: str) -> Callable[[Case, float], Case]:
    def scaled(case: Case, factor: float) -> Case:
        value = getattr(case.machine, name) * factor
        return replace(case, machine=replace(case.machine, **{name: value}))

    return scaled


def _scaled_time(key: str) -> Callable[[Case, float], Case]:
    def scaled(case: Case, factor: float) -> Case:
        settings = dict(case.machine.settings)
        settings["times"] = {**settings["times"], key: _longer(settings["times"][key], factor)}
        # The program is read with the spindle's largest speed.
        chunks = partial(case.chunks, factor) if key == "spindle_max_rpm" else case.chunks
        return replace(case, machine=replace(case.machine, settings=settings), chunks=chunks)

    return scaled


def _longer(value: _TimesEntry, factor: float) -> _TimesEntry:
    """Return an entry of ``[times]`` multiplied: a number, the seconds of ``m_codes``, or those of ``spindle_ramp``."""
    if isinstance(value, Mapping):
        return {code: seconds * factor for code, seconds in value.items()}
    if isinstance(value, int | float):
        return value * factor
    return [[speed, seconds * factor] for speed, seconds in value]


def _time_text(key: str, value: _TimesEntry) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{code} {seconds:g}" for code, seconds in value.items())
    if isinstance(value, int | float):
        unit = "rpm/s" if key.endswith("rpm_s") else "rpm" if key.endswith("_rpm") else "s"
        return f"{value:g} {unit}"
    return f"{value[-1][1]:g} at {value[-1][0]:g} rpm"


def _scaled_velocities(case: Case, factor: float) -> Case:
    axes = {
        letter: replace(axis, max_velocity=axis.max_velocity * factor)
        for letter, axis in case.machine.axes.items()
    }
    return replace(case, machine=replace(case.machine, axes=axes))


def _scaled_feed(case: Case, factor: float) -> Case:
    def chunks() -> Iterator[Toolpath]:
        for chunk in case.chunks():
            yield replace(
                chunk, feed=np.where(chunk.feed_mode == FeedMode.RAPID, chunk.feed, chunk.feed * factor)
            )

    return replace(case, chunks=chunks)


def _scaled_tolerance(case: Case, factor: float) -> Case:
    given = case.options.path_tolerance_mm

    def chunks() -> Iterator[Toolpath]:
        for chunk in case.chunks():
            yield replace(chunk, tolerance=chunk.tolerance * factor)

    machine = replace(case.machine, path_tolerance_mm=case.machine.path_tolerance_mm * factor)
    options = replace(case.options, path_tolerance_mm=None if given is None else given * factor)
    return Case(chunks, machine, options)


def as_text(now: PlannedTimes, found: list[Shortening], program: str) -> str:
    """Return the ranking as a table, and where the three largest savings are; lines of other files than the program with their file."""
    rows = [
        [
            each.name,
            each.value,
            f"{100 * each.change:+.0f} %",
            by_derivative(each),
            f"{each.saved_s:z.4f}",
            f"{100 * each.saved_s / now.cycle_s:z.2f}" if now.cycle_s else "0",
            ", ".join(
                f"{number}{'' if source == program else f' of {source}'}: {seconds:z.4f}"
                for source, number, seconds in each.lines
            ),
        ]
        for each in found
    ]
    head = [
        "quantity",
        "now",
        "change",
        "by derivative, s",
        "planned, s",
        "of cycle, %",
        "lines that save most, s",
    ]
    kinds = {each.slope.kind for each in found}
    notes = [meaning.format(now.agreement_s) for kind, meaning in _MEANINGS.items() if kind in kinds]
    return "\n".join([f"cycle time {duration(now.cycle_s)}", text_table(head, rows), *notes])


#: What stands behind an estimate and its bound, by its kind.
_BOUNDED = {SlopeKind.SCATTER: "", SlopeKind.BEND: " bends", SlopeKind.ENOUGH: " (few plans)"}
#: Explanations of the entries in place of a derivative.
_MEANINGS = {
    SlopeKind.KINK: "a | b: the time has a kink there; a change saves a at first, and its opposite costs b",
    SlopeKind.ENOUGH: f"a ± b (few plans): b is less than {100 * _ENOUGH:g} % of the cycle, so no more plans were made",
    SlopeKind.SCATTER: "a ± b: plans scatter by b",
    SlopeKind.BEND: "a ± b bends: by differences of ±2 and ±5 % it differs by b",
    SlopeKind.NO_EFFECT: "no effect: 10 % up or down changes nothing, to {:.1g} s",
    SlopeKind.SLACK: "does not bind: a small change does nothing, to {:.1g} s; one of 10 % up or down does",
}


def by_derivative(each: Shortening) -> str:
    """Return the derivative, or its replacement."""
    slope = each.slope
    if slope.kind is SlopeKind.SMOOTH:
        return f"{slope.seconds:z.4f}"
    if slope.kind is SlopeKind.KINK:
        return " | ".join(f"{side:z.4f}" for side in each.sides_s)
    if slope.kind in _BOUNDED:
        # A bound has one digit at least.
        digits = max(4, math.ceil(-math.log10(slope.bound))) if slope.bound else 4
        return f"{slope.seconds:z.{digits}f} ± {slope.bound:.{digits}f}{_BOUNDED[slope.kind]}"
    return str(slope.kind)
