"""Which limit shortens a program: the time's derivative to each limit, feed and tolerance, and the time of a plan with each changed.

Every quantity is planned 10 % and 5 % higher and lower. The derivative is the five-point difference of these plans (Abramowitz and
Stegun (1964), 25.3.6), whose error is below 10⁻⁴ where the time is smooth. It is not everywhere: a rapid at 45° needs more jerk
of both axes, so one of them alone can only lengthen it, and plans of path and speed together jump by some 10⁻⁵ of the time. The fourth
difference, and that of the central differences of both steps, bound what such places do to the derivative. Where a bound is
above 1.5 % there is none: what the change saves at first and what its opposite costs are told instead.
All is given for a change of 10 % in the direction that shortens (a period falls, all others rise).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from cncgen.machine.record import Axis, Machine
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.report.line_times import LineTimes
from cncgen.report.tables import duration, text_table
from cncgen.report.time_split import TimeSplit
from cncgen.toolpath.record import FeedMode, Toolpath

#: The change that results are given for. Differences take half of it as their step, so the plan of the whole change is one of theirs.
CHANGE = 0.10
#: A derivative is not given where one of the bounds of its error is above this part of it.
_KNOWN = 0.015
_Key = TypeVar("_Key")
#: Lines and tools named for each quantity.
_PLACES = 3
#: A saving below this part of the cycle counts as none: two plans of a program agree to so much.
_NOISE = 1e-6


@dataclass(frozen=True, slots=True)
class Case:
    """A planning task: the program's chunks, the machine, the options."""

    chunks: Callable[[], Iterable[Toolpath]]
    machine: Machine
    options: PlanOptions


@dataclass(frozen=True, slots=True)
class Quantity:
    """A limit, a feed or a tolerance that can be changed.

    Attributes:
        name: Key of the machine file, or a word of the program (``feed``).
        value: As it is, with its unit; "" where it is many values.
        sign: +1 where a rise shortens, -1 where a fall does.
        scaled: Returns the case with the quantity multiplied by a factor.
        part: Part of the split that counts; "": the whole cycle.
        jumps: The time jumps with it everywhere, so that it has no derivative.
    """

    name: str
    value: str
    sign: int
    scaled: Callable[[Case, float], Case]
    part: str = ""
    jumps: bool = False


@dataclass(frozen=True, slots=True)
class PlannedTimes:
    """Times of one plan: the cycle, its parts, of each line, of each tool."""

    cycle_s: float
    parts: dict[str, float]
    lines: dict[tuple[str, int], float]
    tools: dict[str, float]


@dataclass(frozen=True, slots=True)
class Shortening:
    """The worth of a quantity.

    Attributes:
        name, value: The quantity, see `Quantity`.
        change: Relative change, signed.
        derivative_s: Seconds that the cycle gets shorter for the change, by the derivative; None where there is none.
        sides_s: The same by the derivatives to either side: what the change saves at first, what its opposite costs.
        saved_s: Seconds that a plan with the whole change is shorter.
        lines: The lines that save most: file, line, seconds.
        tools: Seconds saved with each tool, the most first.
    """

    name: str
    value: str
    change: float
    derivative_s: float | None
    sides_s: tuple[float, float]
    saved_s: float
    lines: tuple[tuple[str, int, float], ...] = ()
    tools: tuple[tuple[str, float], ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            "name": self.name,
            "value": self.value,
            "change": self.change,
            "derivative_s": self.derivative_s,
            "sides_s": list(self.sides_s),
            "saved_s": self.saved_s,
            "lines": [{"source": s, "line": n, "saved_s": t} for s, n, t in self.lines],
            "tools": [{"tool": name, "saved_s": t} for name, t in self.tools],
        }


@dataclass(slots=True)
class _ToolTimes:
    """Adds up the time between tool changes; a change counts for the tool that it brings."""

    tool: str = "–"
    since_s: float = 0.0
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, trajectory: Trajectory) -> None:
        for t_s, _, event in trajectory.events:
            if event.name == "tool":
                self.end(t_s)
                self.tool = str(event.values.get("tool", "–"))

    def end(self, t_s: float) -> None:
        self.seconds[self.tool] = self.seconds.get(self.tool, 0.0) + t_s - self.since_s
        self.since_s = t_s


def planned_times(case: Case) -> PlannedTimes:
    """Plan a case, and return its times.

    Raises:
        NoPlanError, ProgramError: As `cncgen.planner.plan`.
    """
    split, lines, tools = TimeSplit(), LineTimes(), _ToolTimes()
    for trajectory in plan(case.chunks(), case.machine, case.options):
        split.add(trajectory)
        lines.add(trajectory)
        tools.add(trajectory)
    found = split.as_json()
    tools.end(found["cycle_time_s"])
    every = {(line.source, line.line): line.time_s for line in lines.longest(lines.lines)}
    return PlannedTimes(found["cycle_time_s"], found["cycle_time_split_s"], every, tools.seconds)


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
        # Stops wait for a setpoint: the time goes with the period as a sawtooth.
        Quantity("period_s", f"{machine.period_s:g} s", -1, _scaled_top("period_s"), jumps=True),
        Quantity("rapid velocity", "", 1, _scaled_velocities, part="rapid"),
    ]
    times = machine.settings.get("times", {})
    return found + [
        Quantity(f"times.{key}", f"{times[key]:g}", 1 if key.endswith("rpm_s") else -1, _scaled_time(key))
        for key in times
        if isinstance(times[key], int | float) and key != "pockets" and times[key]
    ]


def shortenings(
    case: Case, axes: str, watch: Callable[[int, int], None] = lambda done, of: None
) -> tuple[PlannedTimes, list[Shortening]]:
    """Return the times of a plan as it is, and what each quantity is worth, the most first.

    Args:
        case: What is planned; its chunks are drawn up to four times a quantity.
        axes: Letters of the axes whose limits count.
        watch: Called with the number of plans that are done, and of all.

    Raises:
        NoPlanError, ProgramError: As `cncgen.planner.plan`, of the case as it is.
    """
    names = quantities(case, axes)
    total, done = 1 + 4 * len(names), 1
    now = planned_times(case)
    watch(done, total)
    found = []
    for quantity in names:
        plans = {0: now}
        for step in _STEPS:
            # A quantity whose whole change changes nothing changes nothing by half of it.
            if abs(step) == 2 or any(_differ(quantity, now, plans[k]) for k in (2, -2)):
                plans[step] = planned_times(quantity.scaled(case, 1 + quantity.sign * step * CHANGE / 2))
            else:
                plans[step] = now
            done += 1
            watch(done, total)
        found.append(_worth(quantity, now, plans))
    found.sort(key=lambda each: -each.saved_s)
    return now, found


#: Half changes that are planned, in the direction that shortens where they are positive.
_STEPS = (2, -2, 1, -1)


def _time(quantity: Quantity, times: PlannedTimes) -> float:
    return times.parts[quantity.part] if quantity.part else times.cycle_s


def _differ(quantity: Quantity, one: PlannedTimes, other: PlannedTimes) -> bool:
    return abs(_time(quantity, one) - _time(quantity, other)) > _NOISE * one.cycle_s


def derivative(saved: Mapping[int, float], noise: float) -> float | None:
    """Return what a whole change saves by the derivative, or None where there is none.

    Args:
        saved: Seconds that -2, -1, 0, 1 and 2 half changes save.
        noise: A derivative below it is 0.
    """
    near, far = saved[1] - saved[-1], 0.5 * (saved[2] - saved[-2])
    slope = (4.0 * near - far) / 3.0
    if max(abs(slope), abs(near), abs(far)) <= noise:
        return 0.0
    # Where the derivatives to both sides differ by d, the fourth difference is d. A jump of the time by d between two of the plans
    # makes 3 d or d of it, and 7/6 d or d/6 of the slope. A jump of the second derivative it may miss: the slope is then off by
    # at most two thirds of what near and far differ by.
    fourth = saved[2] - 4.0 * saved[1] + 6.0 * saved[0] - 4.0 * saved[-1] + saved[-2]
    if max(0.4 * abs(fourth), abs(near - far) * 2.0 / 3.0) > _KNOWN * abs(slope):
        return None
    return slope


def _worth(quantity: Quantity, now: PlannedTimes, plans: Mapping[int, PlannedTimes]) -> Shortening:
    """Return what a quantity is worth by its plans, by half changes."""
    saved = {k: _time(quantity, now) - _time(quantity, times) for k, times in plans.items()}
    sides = (4.0 * saved[1] - saved[2], saved[-2] - 4.0 * saved[-1])
    slope = derivative(saved, _NOISE * now.cycle_s)
    found = Shortening(
        quantity.name,
        quantity.value,
        quantity.sign * CHANGE,
        None if quantity.jumps and slope else slope,
        sides,
        saved[2],
    )
    if abs(saved[2]) < _NOISE * now.cycle_s:
        return found
    lines = _most(now.lines, plans[2].lines)
    tools = _most(now.tools, plans[2].tools)
    return replace(
        found,
        lines=tuple((*key, seconds) for key, seconds in lines if seconds > _NOISE * now.cycle_s),
        tools=tuple(tools),
    )


def _most(before: Mapping[_Key, float], after: Mapping[_Key, float]) -> list[tuple[_Key, float]]:
    """Return what saves most, by its key."""
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
        settings["times"] = {**settings["times"], key: settings["times"][key] * factor}
        return replace(case, machine=replace(case.machine, settings=settings))

    return scaled


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


def as_text(now: PlannedTimes, found: list[Shortening]) -> str:
    """Return the ranking as a table, and where the three largest savings are."""
    rows = [
        [
            each.name,
            each.value,
            f"{100 * each.change:+.0f} %",
            by_derivative(each),
            f"{each.saved_s:z.4f}",
            f"{100 * each.saved_s / now.cycle_s:z.2f}" if now.cycle_s else "0",
            ", ".join(f"{number}: {seconds:z.4f}" for _, number, seconds in each.lines),
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
    note = "" if all(each.derivative_s is not None for each in found) else f"\n{NO_DERIVATIVE}"
    return f"cycle time {duration(now.cycle_s)}\n{text_table(head, rows)}{note}"


#: The meaning of two figures in place of one.
NO_DERIVATIVE = "a | b: the time has no derivative there; a change saves a at first, and its opposite costs b"


def by_derivative(each: Shortening) -> str:
    """Return the derivative, or those to either side where there is none."""
    if each.derivative_s is not None:
        return f"{each.derivative_s:z.4f}"
    return " | ".join(f"{side:z.4f}" for side in each.sides_s)
