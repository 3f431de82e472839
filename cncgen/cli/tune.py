"""`cncgen tune`: gains for a bandwidth and damping, or for the least contour error on a program."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.options import (
    machine_option,
    message_options,
    output_option,
    planning_options,
    program_options,
)


@click.command("tune")
@click.argument("program", metavar="[PROGRAM]", required=False)
@machine_option
@click.option(
    "--bandwidth",
    metavar="HZ",
    type=click.FloatRange(min=0, min_open=True),
    help="Place gains for this bandwidth.",
)
@click.option(
    "--damping",
    metavar="ZETA",
    type=click.FloatRange(min=0, min_open=True),
    default=1.0,
    show_default=True,
    help="Damping of the placed poles.",
)
@click.option(
    "--sets", metavar="N", type=click.IntRange(1, 1_000_000), default=1000, show_default=True,
    help="Gain sets tried on a program.",
)  # fmt: skip
@click.option(
    "--modulus",
    type=click.FloatRange(0.0, 0.99),
    default=0.5,
    show_default=True,
    help="Least distance of each loop from -1.",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the search.")
@click.option("--bode/--no-bode", default=True, show_default=True, help="Print a Bode table of each loop.")
@output_option
@planning_options
@program_options
@message_options
def command(
    program: str | None,
    machine: str,
    bandwidth: float | None,
    damping: float,
    sets: int,
    modulus: float,
    seed: int,
    bode: bool,
    output: str | None,
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> None:
    """Tune the servo gains of a machine.

    With --bandwidth gains are placed. With a PROGRAM random gain sets round those (or round the machine's own) are
    simulated on it, within the modulus margin, and the one with the least contour error is kept. The result is a file
    of [axes.x.servo] tables for --axis-params; margins and Bode tables go to standard error.
    """
    from cncgen import pipeline
    from cncgen.cli.reading import opened, plan_options
    from cncgen.files import write_text
    from cncgen.report.tuned import margin_text, servo_tables
    from cncgen.servo.tuning import placed, search

    where = pipeline.machine_of(machine)
    servos = dict(pipeline.servos_of(planning["axis_params"] or where))
    if bandwidth is None and program is None:
        raise click.UsageError("give --bandwidth, or a PROGRAM to tune on, or both")
    if bandwidth is not None:
        servos = {k: placed(servo, k, bandwidth, damping) for k, servo in servos.items()}
    if program is not None:
        with opened(program, reading, planning["path_tolerance"]) as read:
            setpoints = list(pipeline.sample(pipeline.plan(read, where, plan_options(planning))).chunks)
        if not setpoints:
            raise click.UsageError(f"{program} moves nothing")
        found = search(setpoints, servos, sets=sets, modulus=modulus, seed=seed)
        servos = dict(found.servos)
        messages.note(
            f"{found.tried} gain sets, {found.refused} refused: contour error rms {1e3 * found.start_rms_mm:.3f} ->"
            f" {1e3 * found.contour_rms_mm:.3f} µm"
        )
    for letter, servo in servos.items():
        messages.note(margin_text(servo, letter, where.period_s, bode))
    write_text(output, servo_tables(servos))
