"""`cncgen identify`: servo parameters from a logged excitation."""

from __future__ import annotations

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import message_options, output_option, summary_option
from cncgen.cli.types import FILE, FiniteRange

MODELS = ("velocity-loop", "first-order", "fourth-order", "etfe")
_POSITIVE = FiniteRange(min=0, min_open=True)


@click.command("identify")
@click.argument("log", metavar="LOG.csv", type=FILE)
@click.option(
    "--model",
    type=click.Choice(MODELS),
    default=MODELS[0],
    show_default=True,
    help="velocity-loop: gain, lag and friction from x_force to x_mm (also a torque-mode motor); first-order and "
    "fourth-order: the closed loop from x_cmd_mm to x_mm; etfe: frequency response with coherence.",
)
@click.option("--axis", metavar="LETTER", help="One axis [default: every axis of the log].")
@click.option("--friction/--no-friction", default=True, show_default=True, help="Fit Coulomb friction.")
@click.option(
    "--counts-per-mm",
    metavar="N",
    type=_POSITIVE,
    help="With --counts-per-rad: give Kc of a torque-mode motor.",
)
@click.option("--counts-per-rad", metavar="N", type=_POSITIVE, help="Encoder counts a radian of the motor.")
@output_option
@summary_option
@message_options
def command(
    log: str,
    model: str,
    axis: str | None,
    friction: bool,
    counts_per_mm: float | None,
    counts_per_rad: float | None,
    output: str | None,
    summary: str | None,
) -> None:
    """Fit axis parameters to a log.

    LOG.csv has t_s and columns like a response file of cncgen simulate: x_mm, and x_force or x_cmd_mm. The output is
    [axes.x.servo] tables (of a velocity loop: the plant with P control as a start; of etfe: CSV).
    """
    from cncgen.files import write_text
    from cncgen.report.identified import identified

    if (counts_per_mm is None) != (counts_per_rad is None):
        raise click.UsageError("--counts-per-mm and --counts-per-rad go together")
    scale = counts_per_mm / counts_per_rad if counts_per_mm and counts_per_rad else None
    result = identified(log, model, axis.upper() if axis else None, friction, scale)
    messages.show(result.remarks)
    messages.note(result.text)
    write_text(output, result.table)
    write_summary(summary, result.values)
