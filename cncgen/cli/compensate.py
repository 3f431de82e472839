"""`cncgen compensate`: a command file that makes the servo axes follow the wanted motion better."""

from __future__ import annotations

import click

from cncgen.cli import messages
from cncgen.cli.messages import write_summary
from cncgen.cli.options import format_option, message_options, output_option, summary_option


@click.command("compensate")
@click.argument("setpoints", metavar="[SETPOINTS]", default="-")
@click.option(
    "--axis-params",
    metavar="NAME|FILE",
    required=True,
    help="Servo data of the axes: a profile or a TOML file.",
)
@click.option(
    "-m",
    "--machine",
    metavar="NAME|FILE",
    help="Limits that the command must keep [default: those of --axis-params, if it has any].",
)
@click.option(
    "--passes",
    metavar="N",
    type=click.IntRange(1, 20),
    default=2,
    show_default=True,
    help="How many times the remaining error is added.",
)
@click.option(
    "--limits/--no-limits", default=True, show_default=True, help="Refuse a command that breaks limits."
)
@click.option(
    "--settle",
    metavar="SECONDS",
    type=click.FloatRange(min=0),
    default=0.1,
    show_default=True,
    help="Hold the last position so long, for the command to come to rest there.",
)
@format_option
@output_option
@summary_option
@message_options
def command(
    setpoints: str,
    axis_params: str,
    machine: str | None,
    passes: int,
    limits: bool,
    settle: float,
    format: str | None,
    output: str | None,
    summary: str | None,
) -> None:
    """Shape setpoints so that the axes, as the model knows them, follow the wanted motion.

    Writes the command to send to the machine and says what it gains. A command that would break a limit which the
    setpoints keep is refused with the place and the figure (exit 3), and nothing is written.
    """
    from cncgen.cli.writing import write_setpoints
    from cncgen.machine import load_servos
    from cncgen.servo.mirror import Compensation, limits_of
    from cncgen.setpoints.readers import open_setpoints

    bounds = limits_of(machine or axis_params, required=machine is not None) if limits else None
    if limits and bounds is None:
        messages.note(f"{axis_params} has no limits: none are checked; give the machine with -m")
    with open_setpoints(setpoints) as stream:
        work = Compensation(
            stream.chunks, load_servos(axis_params), passes=passes, limits=bounds, settle_s=settle
        )
        rows = write_setpoints(work.chunks(), output, format)
    gained = work.gained()
    before, after = gained["before"], gained["after"]
    messages.note(
        f"{rows} setpoints after {passes} passes: contour error max {1e3 * before['contour_max_mm']:.3f} ->"
        f" {1e3 * after['contour_max_mm']:.3f} µm, rms {1e3 * before['contour_rms_mm']:.3f} ->"
        f" {1e3 * after['contour_rms_mm']:.3f} µm; tracking error max {1e3 * before['tracking_max_mm']:.3f} ->"
        f" {1e3 * after['tracking_max_mm']:.3f} µm"
    )
    if after["contour_max_mm"] > before["contour_max_mm"]:
        messages.note("the command makes it worse: use fewer passes, or a plan with lower jerk")
    write_summary(summary, {"schema_version": 1, "setpoints": setpoints, **gained})
