"""Which limit shortens a program: the time's derivative to each limit, feed and tolerance, and the time of a plan with each changed.

A derivative is the central difference of two plans with the quantity 2 % higher and lower. It is given for a change of 10 % in the
direction that shortens (a period falls, all others rise), beside the time that a plan saves with that whole change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cncgen.machine.record import Axis, Machine
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.report.line_times import LineTimes
from cncgen.report.tables import duration, text_table
from cncgen.report.time_split import TimeSplit
from cncgen.toolpath.record import FeedMode, Toolpath

#: Relative step of the differences, and the change that results are given for.
STEP = 0.02
CHANGE = 0.10
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
    """

    name: str
    value: str
    sign: int
    scaled: Callable[[Case, float], Case]
    part: str = ""


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
        derivative_s: Seconds that the cycle gets shorter for the change, by the derivative.
        saved_s: Seconds that a plan with the whole change is shorter.
        lines: The lines that save most: file, line, seconds.
        tools: Seconds saved with each tool, the most first.
    """

    name: str
    value: str
    change: float
    derivative_s: float
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
        Quantity("period_s", f"{machine.period_s:g} s", -1, _scaled_top("period_s")),
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
        case: What is planned; its chunks are drawn three times a quantity.
        axes: Letters of the axes whose limits count.
        watch: Called with the number of plans that are done, and of all.

    Raises:
        NoPlanError, ProgramError: As `cncgen.planner.plan`, of the case as it is.
    """
    names = quantities(case, axes)
    total, done = 1 + 3 * len(names), 1
    now = planned_times(case)
    watch(done, total)
    found = []
    for quantity in names:
        plans = []
        for factor in (1 + STEP, 1 - STEP, 1 + quantity.sign * CHANGE):
            plans.append(planned_times(quantity.scaled(case, factor)))
            done += 1
            watch(done, total)
        found.append(_worth(quantity, now, plans))
    found.sort(key=lambda each: -each.saved_s)
    return now, found


def _worth(quantity: Quantity, now: PlannedTimes, plans: list[PlannedTimes]) -> Shortening:
    """Return what a quantity is worth by its plans: a little more, a little less, and the whole change."""
    time = [p.parts[quantity.part] if quantity.part else p.cycle_s for p in (*plans, now)]
    slope = (time[0] - time[1]) / (2 * STEP)
    saved = time[3] - time[2]
    if abs(saved) < _NOISE * now.cycle_s:
        return Shortening(
            quantity.name, quantity.value, quantity.sign * CHANGE, -quantity.sign * slope * CHANGE, saved
        )
    lines = sorted(
        ((*key, seconds - plans[2].lines.get(key, 0.0)) for key, seconds in now.lines.items()),
        key=lambda each: -each[2],
    )[:_PLACES]
    tools = sorted(
        ((name, seconds - plans[2].tools.get(name, 0.0)) for name, seconds in now.tools.items()),
        key=lambda each: -each[1],
    )[:_PLACES]
    return Shortening(
        quantity.name,
        quantity.value,
        quantity.sign * CHANGE,
        -quantity.sign * slope * CHANGE,
        saved,
        tuple(line for line in lines if line[2] > _NOISE * now.cycle_s),
        tuple(tools),
    )


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
            f"{each.derivative_s:z.4f}",
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
    return f"cycle time {duration(now.cycle_s)}\n{text_table(head, rows)}"
