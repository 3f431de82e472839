"""Planning: a toolpath and a machine become a trajectory, s(t) with the machine's limits held.

`plan` is the only entry. It checks options and program (`checks`), runs the feedrate strategy (`strategies`), retimes the result
if another interpolator than the exact one is asked for (`interpolators`), and keeps the drives out of saturation: step by step
(`saturation`), or in the look-ahead (`drive_limits`). Each of these takes and yields `Trajectory`, chunk by chunk.

Rooms, the lower ones first:

    limits       what a machine and a program allow
    smoothing    G64: runs of lines and arcs become splines within the tolerance
    tube         path and speed together within the tolerance of G64, from a plan of the speed alone
    least_time   the strategy `optimal`, the product
    ild          the strategy `ild` of Tsai (2010), to compare with
    baselines    the feedrates of the papers: `constant`, `adaptive`, `curvature`
    controls     what other controls would take, by their own rules
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain, islice
from types import MappingProxyType

from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory
from cncgen.planner.strategies import Strategy
from cncgen.toolpath.record import Toolpath

__all__ = ["PlanOptions", "Trajectory", "plan"]


def plan(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions | None = None
) -> Iterator[Trajectory]:
    """Plan chunks of a toolpath on a machine.

    Args:
        chunks: Consecutive stretches of one program.
        machine: Limits, period and servo data.
        options: The options; by default `optimal`, exact interpolation, no saturation.

    Yields:
        `Trajectory` after `Trajectory`, without a gap in time or position, each as soon as it is final. Remarks for the user
        are in ``values["diagnostics"]``, a tuple of `Diagnostic`.

    Raises:
        UsageError: An option has an unknown value; servo data that it needs are missing.
        ProgramError: The program moves an axis that the machine does not have.
        NoPlanError: No plan exists within the limits; travel is one of them. Raised, as the one before it, as the
            trajectories are drawn.
    """
    from cncgen.planner.checks import checked
    from cncgen.planner.strategies import strategy

    asked = options or PlanOptions()
    asked.check()
    chosen, toolpaths = strategy(asked.feedrate), checked(chunks, machine, asked)
    if asked.fit_mm is not None:
        from cncgen.planner.smoothing.fitted import fit_runs

        toolpaths = fit_runs(toolpaths, asked.fit_mm)
    if "times" in machine.settings:
        from cncgen.machine.times import times_of
        from cncgen.planner.event_times import with_event_times

        toolpaths = with_event_times(toolpaths, times_of(machine))
    if asked.control is not None:
        from cncgen.planner.controls.strategy import plan_as

        return plan_as(toolpaths, machine, asked.control)
    if asked.saturation != "off":
        toolpaths, machine = _used(toolpaths, machine)
    if asked.saturation == "predictive":
        return _predictive(chosen, toolpaths, machine, asked)
    retimed = _retimed(chosen(toolpaths, machine, asked), machine, asked)
    if asked.saturation == "reactive":
        from cncgen.planner.saturation import limit_reactive

        return limit_reactive(retimed, machine, asked)
    return retimed


def _retimed(plan: Iterator[Trajectory], machine: Machine, asked: PlanOptions) -> Iterator[Trajectory]:
    """Return a plan retimed for the interpolator that was asked for; for ``arclength``, which is exact, the plan itself."""
    if asked.interpolator == "arclength":
        return plan
    from cncgen.planner.interpolators import retime

    return retime(plan, machine, asked)


def _used(toolpaths: Iterable[Toolpath], machine: Machine) -> tuple[Iterator[Toolpath], Machine]:
    """Return the toolpaths, and the machine with only their axes: drives of axes that do not move need no data."""
    rest = iter(toolpaths)
    begin = tuple(islice(rest, 1))
    letters = begin[0].axes if begin else ""
    axes = {letter: axis for letter, axis in machine.axes.items() if letter in letters}
    return chain(begin, rest), replace(machine, axes=MappingProxyType(axes))


def _predictive(
    chosen: Strategy, toolpaths: Iterable[Toolpath], machine: Machine, asked: PlanOptions
) -> Iterator[Trajectory]:
    """Plan on a machine with limits lowered to the abilities of its drives.

    Only `optimal` with exact interpolation holds these limits by itself; the plan of anything else becomes a bound of the speed,
    under which `optimal` plans again.
    """
    from cncgen.planner.drive_limits import drivable, named

    lowered = drivable(machine, asked)
    plan = _retimed(chosen(toolpaths, lowered, asked), lowered, asked)
    if asked.feedrate not in (None, "optimal") or asked.interpolator != "arclength":
        from cncgen.planner.least_time.replanning import replan

        plan = replan(plan, lowered)
    return named(plan, machine, lowered)
