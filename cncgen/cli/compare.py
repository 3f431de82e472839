"""`cncgen compare`: strategies, interpolators and controllers side by side on one program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import (
    machine_option,
    message_options,
    output_option,
    perturb_options,
    planning_options,
    program_options,
    reference_option,
    summary_option,
)
from cncgen.cli.types import FILE

if TYPE_CHECKING:
    from cncgen.machine import Machine
    from cncgen.planner import PlanOptions
    from cncgen.servo.uncertainty import Perturbation
    from cncgen.servo.wanted_motion import WantedMotion
    from cncgen.toolpath.record import Program, Toolpath


@click.command("compare")
@click.argument("program", metavar="PROGRAM", type=FILE)
@machine_option
@click.option(
    "--feedrates", metavar="LIST", help="Strategies, by commas [default: adaptive,curvature,ild,optimal]."
)
@click.option(
    "--interpolators",
    metavar="LIST",
    help="Interpolators, by commas [default: arclength,taylor1,taylor2, and that of --interpolator].",
)
@click.option(
    "--controllers",
    metavar="LIST",
    help="Controllers instead: of p,plain,feedforward,zpetc,ccc,zpetc+ccc,tcf,mirror,h-infinity, by commas.",
)
@output_option
@summary_option
@reference_option
@perturb_options
@planning_options
@program_options
@message_options
def command(
    program: str,
    machine: str,
    feedrates: str | None,
    interpolators: str | None,
    controllers: str | None,
    output: str | None,
    summary: str | None,
    reference: str | None,
    uncertainty: dict[str, Any],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Compare strategies or controllers on a program.

    Without --controllers: each feedrate strategy's time, true and predicted contour error and peaks; then each
    interpolator's time, feedrate fluctuation, distance of its setpoints from the path, and contour error of the axes. With it: the servo axes'
    errors under each controller, on one plan; with --perturb on drawn machines too. With --reference
    distances are those from its path too. All rows have the largest drive inputs, how many setpoints met a drive's bound, and the limits
    that the setpoints break.
    """
    from cncgen.cli.reading import opened, perturbation_of, plan_options, planning_machine, reference_of
    from cncgen.files import write_text
    from cncgen.pipeline import machine_of, sound
    from cncgen.pipeline.reading import REPEATED

    drawn = perturbation_of(uncertainty)
    if drawn is not None and controllers is None:
        raise click.UsageError("--perturb draws servo parameters: it needs --controllers.")
    options, machine = plan_options(planning), planning_machine(machine, planning)
    wanted = None if reference is None else reference_of(reference, machine, planning, reading)
    with opened(program, reading, planning["path_tolerance"], machine) as read:
        where, toolpaths = machine_of(machine), list(sound(read, REPEATED))
        if controllers is not None:
            source = planning["axis_params"] or machine
            text, found = _controllers(
                read, toolpaths, where, options, source, _names(controllers) or [], drawn, wanted
            )
        else:
            text, found = _strategies(
                read, toolpaths, where, options, _names(feedrates), _names(interpolators), wanted
            )
    write_text(output, text)
    write_summary(summary, {"schema_version": 1, "program": program, "machine": where.name, **found})


def _names(text: str | None) -> list[str] | None:
    if text is None:
        return None
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise click.UsageError("the list names nothing: names go here, separated by commas")
    return names


def _strategies(
    program: Program,
    toolpaths: list[Toolpath],
    machine: Machine,
    options: PlanOptions,
    feedrates: list[str] | None,
    interpolators: list[str] | None,
    reference: WantedMotion | None,
) -> tuple[str, dict[str, Any]]:
    from cncgen.pipeline import driven_axes
    from cncgen.planner.options import INTERPOLATORS
    from cncgen.planner.strategies import FEEDRATES
    from cncgen.report.comparing import interpolator_table, strategy_table, strategy_values
    from cncgen.report.comparison import check_names, compare_interpolators, compare_strategies

    check_names("interpolator", interpolators or (), INTERPOLATORS)
    axes = driven_axes(program, machine)
    figures = compare_strategies(toolpaths, machine, options, feedrates, axes, reference)
    names = interpolators or list(dict.fromkeys(("arclength", "taylor1", "taylor2", options.interpolator)))
    fluctuations = compare_interpolators(toolpaths, machine, options, names, axes, reference)
    own = [g.time_s for g in figures if g.feedrate == (options.feedrate or FEEDRATES[0])]
    if own and fluctuations[0].fault is None and fluctuations[0].time_s != own[0]:
        messages.note(
            "interpolators are compared on a plan of the speed along the smoothed path (--effort fast): "
            "one of path and speed together has no path for them to follow"
        )
    messages.show(options.unused([g.feedrate for g in figures], names))
    text = strategy_table(figures) + "\n" + interpolator_table(fluctuations)
    return text, strategy_values(figures, fluctuations)


def _controllers(
    program: Program,
    toolpaths: list[Toolpath],
    machine: Machine,
    options: PlanOptions,
    source: str,
    names: list[str],
    drawn: Perturbation | None,
    reference: WantedMotion | None,
) -> tuple[str, dict[str, Any]]:
    from cncgen.machine import load_coupling, load_servos
    from cncgen.pipeline import driven_axes
    from cncgen.planner import plan
    from cncgen.report.comparing import compare_controllers, controller_table
    from cncgen.servo.named_schemes import scheme_maker, settings_of
    from cncgen.servo.wanted_motion import wanted_of_program
    from cncgen.setpoints import sample

    for name in names:
        scheme_maker(name, {})  # the names, before the plan
    settings = settings_of(load_coupling(source))
    axes = driven_axes(program, machine)
    setpoints = list(sample(plan(toolpaths, machine, options), machine, axes=axes, signals=["tool_length"]))
    wanted = reference or wanted_of_program(program.name, setpoints, toolpaths, machine)
    messages.show(options.unused())
    found = compare_controllers(setpoints, load_servos(source), names, settings, machine.axes, wanted, drawn)
    return controller_table(found, reference is None), {"controllers": found}
