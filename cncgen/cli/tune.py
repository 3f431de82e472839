"""`cncgen tune`: gains for a bandwidth and damping, or for the least contour error on a program."""

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
    summary_option,
)
from cncgen.cli.types import FILE, FiniteRange, WholeRange

if TYPE_CHECKING:
    from cncgen.servo.named_schemes import Settings

#: Schemes with gains of their own.
CONTROLLERS = ("p", "ccc", "zpetc+ccc", "tcf", "h-infinity")


@click.command("tune")
@click.argument("program", metavar="[PROGRAM]", type=FILE, required=False)
@machine_option
@click.option(
    "--controller",
    type=click.Choice(CONTROLLERS),
    default=CONTROLLERS[0],
    show_default=True,
    help="Whose gains: each axis's own (p), of cross coupling round them (ccc), of the task frame (tcf); or a design "
    "from weights (h-infinity).",
)
@click.option(
    "--bandwidth",
    metavar="HZ",
    type=FiniteRange(min=0, min_open=True),
    help="Place gains for this bandwidth.",
)
@click.option(
    "--damping",
    metavar="ZETA",
    type=FiniteRange(min=0, min_open=True),
    default=1.0,
    show_default=True,
    help="Damping of the placed poles.",
)
@click.option(
    "--sets", metavar="N", type=WholeRange(1, 1_000_000), default=1000, show_default=True,
    help="Gain sets tried on a program.",
)  # fmt: skip
@click.option(
    "--modulus",
    metavar="DISTANCE",
    type=FiniteRange(0.0, 0.99),
    default=0.5,
    show_default=True,
    help="Least distance of each loop from -1.",
)
@click.option(
    "--seed", metavar="N", type=WholeRange(0), default=0, show_default=True, help="Seed of the search."
)
@click.option(
    "--jobs", metavar="N", type=WholeRange(1, 1024), help="Processes of the search [default: one a core]."
)
@click.option("--bode/--no-bode", default=True, show_default=True, help="Print a Bode table of each loop.")
@output_option
@summary_option
@perturb_options
@planning_options
@program_options
@message_options
def command(
    program: str | None,
    machine: str,
    controller: str,
    bandwidth: float | None,
    damping: float,
    sets: int,
    modulus: float,
    seed: int,
    jobs: int | None,
    bode: bool,
    output: str | None,
    summary: str | None,
    uncertainty: dict[str, Any],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Tune the servo gains of a machine.

    With --bandwidth gains are placed. With a PROGRAM random gain sets round those (or round the machine's own) are
    simulated on it, within the modulus margin, and the one with the least contour error is kept. The result is a file of
    [axes.x.servo] tables (and a [coupling] table) for --axis-params; margins and Bode tables go to standard error.
    Margins are those of the sampled loops, with their hold and dead times. With --perturb the worst ones of the drawn machines
    are printed too, and gain sets are judged by the worst machine.
    """
    from cncgen import pipeline
    from cncgen.cli.reading import perturbation_of, planned
    from cncgen.files import write_text
    from cncgen.machine import load_coupling
    from cncgen.report.tuned import gain_tables, loop_texts, search_text, summary_of, worst_texts
    from cncgen.servo.named_schemes import settings_of
    from cncgen.servo.stream import driven
    from cncgen.servo.tuning.analysis import missed_targets, open_loops, worst_margins
    from cncgen.servo.tuning.search import search
    from cncgen.servo.uncertainty import FEW_DRAWS

    if bandwidth is None and program is None and controller != "h-infinity":
        raise click.UsageError("give --bandwidth, or a PROGRAM to tune on, or both")
    where, source = pipeline.machine_of(machine), planning["axis_params"] or machine
    servos, settings = dict(pipeline.servos_of(source)), settings_of(load_coupling(source))
    if controller == "h-infinity":
        if program is not None:
            raise click.UsageError("an H-infinity design has weights, and no gains to search on a program")
        _design(servos, where.period_s, bandwidth, output)
        return
    # Schemes couple linear axes; without a program they are those that the machine has.
    axes = "".join(k for k in servos if controller == "p" or k in "XYZ")
    setpoints = []
    if program is not None:
        with planned(program, reading, planning, machine) as plan:
            setpoints = list(driven(pipeline.sample(plan).chunks, {**where.axes, **servos}))
        if not any((chunk.position != setpoints[0].position[0]).any() for chunk in setpoints):
            raise click.UsageError(f"{program} moves nothing")
        axes = setpoints[0].axes
    drawn = perturbation_of(uncertainty, draws=FEW_DRAWS)
    if bandwidth is not None:
        servos, settings = _placed(controller, servos, axes, where.period_s, bandwidth, damping, settings)
    found = None
    if setpoints:
        found = search(setpoints, servos, controller=controller, settings=settings, sets=sets, modulus=modulus,
                       seed=seed, workers=jobs, perturbation=drawn)  # fmt: skip
        servos, settings = dict(found.servos), found.settings
        messages.note(search_text(found))
    for text in loop_texts(controller, servos, axes, where.period_s, settings, bode):
        messages.note(text)
    if bandwidth is not None and controller == "p" and found is None:
        messages.show(tuple(missed_targets(servos, axes, where.period_s, bandwidth, modulus)))
    worst = [] if drawn is None else worst_margins(controller, servos, axes, where.period_s, settings, drawn)
    if drawn is not None:
        for text in worst_texts(worst, drawn):
            messages.note(text)
    coupling = settings.as_table(controller)
    write_text(output, gain_tables(servos, coupling))
    if summary is not None:
        loops = open_loops(controller, servos, axes, where.period_s, settings)
        write_summary(summary, summary_of(controller, servos, coupling, loops, found, worst))


def _placed(
    controller: str,
    servos: dict[str, Any],
    axes: str,
    period_s: float,
    bandwidth: float,
    damping: float,
    settings: Settings,
) -> tuple[dict[str, Any], Settings]:
    """Return servos and settings with the gains of the controller placed."""
    from cncgen.servo.named_schemes import scheme_maker
    from cncgen.servo.tuning.placement import check_stable, placed, placed_settings

    if controller == "p":
        found = {k: placed(servo, k, bandwidth, damping) for k, servo in servos.items()}
        for letter, servo in found.items():
            check_stable(servo, letter, period_s, bandwidth)
        return found, settings
    loops = scheme_maker(controller, servos, settings)(axes, period_s).loops
    return servos, placed_settings(controller, loops, bandwidth, damping)


def _design(servos: dict[str, Any], period_s: float, bandwidth: float | None, output: str | None) -> None:
    """Design each axis's H-infinity controller, print its bounds, and write the tables if they hold."""
    from cncgen.diagnostics import Diagnostic, NoPlanError
    from cncgen.files import write_text
    from cncgen.report.tuned import bounds_text, gain_tables
    from cncgen.servo.tuning.placement import designed_h_infinity

    missed = []
    for letter, servo in servos.items():
        servos[letter], gamma, found = designed_h_infinity(servo, letter, period_s, bandwidth)
        messages.note(bounds_text(letter, gamma, found))
        if not found.holds:
            missed.append(letter)
    if missed:
        raise NoPlanError(
            Diagnostic(
                "tune-bounds",
                f"the bounds do not hold for every plant of {', '.join(missed)}",
                hint="ask for less bandwidth, or for less uncertainty in the servo table",
            )
        )
    write_text(output, gain_tables(servos, {}))
