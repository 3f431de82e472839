"""`cncgen compare`: strategies, interpolators and controllers side by side on one program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from cncgen.cli.options import (
    machine_option,
    message_options,
    output_option,
    planning_options,
    program_options,
)

if TYPE_CHECKING:
    from cncgen.machine import Machine
    from cncgen.planner import PlanOptions
    from cncgen.toolpath.record import Program, Toolpath


@click.command("compare")
@click.argument("program", metavar="PROGRAM")
@machine_option
@click.option(
    "--feedrates", metavar="LIST", help="Strategies, by commas [default: adaptive,curvature,ild,optimal]."
)
@click.option(
    "--interpolators", metavar="LIST", help="Interpolators, by commas [default: arclength,taylor1,taylor2]."
)
@click.option(
    "--controllers", metavar="LIST", help="Controllers instead: of p,zpetc,ccc,zpetc+ccc,tcf, by commas."
)
@output_option
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
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Compare strategies or controllers on a program.

    Without --controllers: each feedrate strategy's time, true and predicted contour error and peaks; then each
    interpolator's feedrate fluctuation. With it: the servo axes' errors under each controller, on one plan.
    """
    from cncgen.cli.reading import opened, plan_options
    from cncgen.files import write_text
    from cncgen.pipeline import machine_of, sound

    options = plan_options(planning)
    with opened(program, reading, planning["path_tolerance"]) as read:
        where, toolpaths = machine_of(machine), list(sound(read))
        if controllers:
            text = _controllers(read, toolpaths, where, options, _names(controllers) or [])
        else:
            text = _strategies(read, toolpaths, where, options, _names(feedrates), _names(interpolators))
    write_text(output, text)


def _names(text: str | None) -> list[str] | None:
    return [name.strip() for name in text.split(",") if name.strip()] if text else None


def _strategies(
    program: Program,
    toolpaths: list[Toolpath],
    machine: Machine,
    options: PlanOptions,
    feedrates: list[str] | None,
    interpolators: list[str] | None,
) -> str:
    from cncgen.report.comparing import interpolator_table, strategy_table
    from cncgen.report.comparison import compare_strategies, feed_fluctuations

    text = strategy_table(compare_strategies(toolpaths, machine, options, feedrates, program.moving_axes))
    more = {"names": interpolators} if interpolators else {}
    return text + "\n" + interpolator_table(feed_fluctuations(toolpaths, machine, options, **more))


def _controllers(
    program: Program, toolpaths: list[Toolpath], machine: Machine, options: PlanOptions, names: list[str]
) -> str:
    from cncgen.pipeline import servos_of
    from cncgen.planner import plan
    from cncgen.report.comparing import compare_controllers, controller_table
    from cncgen.setpoints import sample

    setpoints = list(sample(plan(toolpaths, machine, options), machine, axes=program.moving_axes))
    servos = options.servos or servos_of(machine)
    return controller_table(compare_controllers(setpoints, servos, names))
