"""`cncgen excite`: a swept sine within an axis's limits, as a setpoint file."""

from __future__ import annotations

import click

from cncgen.cli import messages
from cncgen.cli.options import format_option, machine_option, message_options, output_option
from cncgen.cli.types import FiniteRange


@click.command("excite")
@machine_option
@click.option("--axis", metavar="LETTER", required=True, help="The axis that moves.")
@click.option(
    "--duration",
    metavar="SECONDS",
    default=20.0,
    show_default=True,
    type=FiniteRange(0.1, 3600.0),
    help="Length of the sweep.",
)
@click.option("--low", metavar="HZ", default=0.5, show_default=True, help="Lowest frequency.")
@click.option("--high", metavar="HZ", default=100.0, show_default=True, help="Highest frequency.")
@click.option(
    "--amplitude", metavar="MM", default=10.0, show_default=True, help="Largest swing either side, mm or deg."
)
@click.option(
    "--share", metavar="0..1", default=0.8, show_default=True, help="Share of the limits that is used."
)
@click.option(
    "--center", metavar="MM", default=0.0, show_default=True, help="Where the axis stands, mm or deg."
)
@format_option
@output_option
@message_options
def command(
    machine: str,
    axis: str,
    duration: float,
    low: float,
    high: float,
    amplitude: float,
    share: float,
    center: float,
    format: str | None,
    output: str | None,
) -> None:
    """Write setpoints that excite one axis for identification.

    The sweep keeps within the axis's velocity, acceleration, jerk and travel, and begins and ends at rest. Run it, log
    time, drive input and position, and give the log to cncgen identify.
    """
    from cncgen.cli.writing import write_setpoints
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.machine import load_machine
    from cncgen.servo.identification.excitation import swept_sine
    from cncgen.setpoints.record import Setpoints
    from cncgen.units import file_unit, to_file

    found = load_machine(machine)
    letter = axis.upper()
    if letter not in found.axes:
        known = ", ".join(found.axes)
        raise UsageError(Diagnostic("excite-axis", f"{found.name} has no axis {axis}; it has {known}"))
    unit = 1.0 / to_file(letter)
    rows = swept_sine(
        found.axes[letter],
        found.period_s,
        duration_s=duration,
        low_hz=low,
        high_hz=high,
        amplitude=amplitude * unit,
        share=share,
        center=center * unit,
    )
    messages.note(
        f"{len(rows)} setpoints of axis {letter}, {low:g} to {high:g} Hz in {duration:g} s,"
        f" from {rows.min() / unit:.4g} to {rows.max() / unit:.4g} {file_unit(letter)}"
    )
    write_setpoints([Setpoints(letter, found.period_s, 0, rows[:, None])], output, format, found)
