"""`cncgen simulate`: the response of the servo axes to setpoints, or to a program that is planned first."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
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
    setpoint_options,
    settle_option,
    summary_option,
)
from cncgen.cli.types import FILE

if TYPE_CHECKING:
    from cncgen.machine.kinematics import Kinematics
    from cncgen.servo.record import Response
    from cncgen.servo.uncertainty import Perturbation
    from cncgen.servo.wanted_motion import WantedMotion
    from cncgen.setpoints.stream import SetpointStream


@click.command("simulate")
@click.argument("source", metavar="[SETPOINTS|PROGRAM]", type=FILE, default="-")
@machine_option
@output_option
@planning_options
@click.option(
    "--controller",
    metavar="NAME",
    default="p",
    show_default=True,
    help="Each axis's own controller (p), or plain, feedforward, zpetc, ccc, zpetc+ccc, tcf, mirror, h-infinity.",
)
@setpoint_options
@settle_option(0.0, "Hold the last setpoint so long at the end.")
@reference_option
@perturb_options
@click.option(
    "--fmu",
    metavar="OUT.fmu",
    type=FILE,
    help="Write the axes as a co-simulation unit of FMI instead (needs a C compiler); nothing is simulated.",
)
@click.option(
    "--fmi",
    type=click.Choice(["2", "3"]),
    help="Standard of the unit of --fmu: FMI 2.0 (where none is named) or FMI 3.0.",
)
@summary_option
@program_options
@message_options
def command(
    source: str,
    machine: str,
    output: str | None,
    planning: dict[str, Any],
    controller: str,
    format: str | None,
    axes: str | None,
    period: float | None,
    settle: float,
    reference: str | None,
    uncertainty: dict[str, Any],
    fmu: str | None,
    fmi: str | None,
    summary: str | None,
    reading: dict[str, Any],
) -> None:
    """Simulate the servo axes in closed loop.

    The argument is a setpoint file (standard input where it is - or missing), or a program, which is planned first.
    The response goes to the file of -o, else to standard output unless that is a terminal. With --reference errors are
    given against the wanted path and plan too, and with --perturb those of machines that are not quite the model.
    """
    from cncgen.cli.reading import is_setpoint_file, perturbation_of, reference_of, tell_of_unused
    from cncgen.cli.writing import check_response_name
    from cncgen.files import is_terminal, open_output
    from cncgen.machine.kinematics import mechanism_of
    from cncgen.pipeline import machine_of, simulate
    from cncgen.report.response import as_text
    from cncgen.servo.response_csv import written
    from cncgen.servo.summary import ResponseSummary, watched

    if fmi and not fmu:
        raise click.UsageError(
            "--fmi names the standard of the unit that --fmu writes, and there is no --fmu."
        )
    if fmu:
        if source != "-" or output or summary:
            raise click.UsageError(
                "--fmu exports the axes: it takes no setpoints, and neither -o nor --summary."
            )
        if not fmu.lower().endswith(".fmu"):
            raise click.UsageError(f"--fmu {fmu}: a unit of FMI is written as .fmu.")
        _export(fmu, machine, planning["axis_params"], controller, (axes, period), int(fmi or 2))
        return
    check_response_name(output)
    drawn = perturbation_of(uncertainty)
    kinematics = mechanism_of(machine_of(machine))
    wanted = None if reference is None else reference_of(reference, machine, planning, reading)
    kept: list[Response] | None = None if wanted is None and drawn is None else []
    servos = planning["axis_params"] or machine
    watch = ResponseSummary()
    if wanted is None and (format or source == "-" or is_setpoint_file(source)):
        tell_of_unused(source, planning, reading)
    with _setpoints(source, machine, planning, (format, axes, period), reading) as stream:
        responses = simulate(stream, servos, controller=controller, settle_s=settle, kinematics=kinematics)
        responses = watched(responses, watch)
        responses = _keeping(responses, kept)
        if output is None and is_terminal(sys.stdout):
            _draw(responses)
        else:
            # The first rows are drawn before anything is opened: a failed simulation leaves no file.
            head = next(responses, None)
            with open_output(output, outlives_reader=bool(summary)) as sink:
                _draw(written(sink, chain(() if head is None else (head,), responses)))
    result = {
        "schema_version": 1,
        "setpoints": source,
        "axis_params": servos,
        "controller": controller,
        **watch.as_dict(),
    }
    if kept:
        result |= _more(kept, wanted, drawn, (servos, controller), kinematics)
    write_summary(summary, result)
    messages.note(as_text(result))


def _keeping(responses: Iterator[Response], kept: list[Response] | None) -> Iterator[Response]:
    """Yield responses on, and keep them where a list is given."""
    for response in responses:
        if kept is not None:
            kept.append(response)
        yield response


def _more(
    kept: list[Response],
    wanted: WantedMotion | None,
    drawn: Perturbation | None,
    how: tuple[str, str],
    kinematics: Kinematics | None,
) -> dict[str, Any]:
    """Return errors against the wanted motion, and figures of drawn machines; `how` are servo data and controller."""
    from cncgen.pipeline import coupling_of, servos_of
    from cncgen.servo.named_schemes import settings_of
    from cncgen.servo.response_spread import drawn_figures, figures_of_response, spread_values
    from cncgen.servo.wanted_motion import judged_against
    from cncgen.setpoints.record import Setpoints

    found: dict[str, Any] = {}
    shift = 0
    if wanted is not None:
        found["reference"] = judged_against(wanted, kept)
        shift = round(found["reference"]["shift_s"] / kept[0].period_s)
    if drawn is None:
        return found

    def judge(responses: Sequence[Response]) -> dict[str, float]:
        figures = figures_of_response(responses)
        if wanted is not None:
            against = judged_against(wanted, responses, shift)
            figures |= {
                f"reference_{k}": v
                for k, v in against.items()
                if isinstance(v, float) and not k.endswith("_s")
            }
        return figures

    servos, controller = how
    rows = [Setpoints(r.axes, r.period_s, r.first, r.command, _length_of(r)) for r in kept]
    figures = drawn_figures(rows, servos_of(servos), drawn, controller=controller,
                            settings=settings_of(coupling_of(servos)), judge=judge,
                            kinematics=kinematics)  # fmt: skip
    found["perturbed"] = spread_values(figures, drawn)
    return found


def _length_of(response: Response) -> dict[str, Any]:
    """Return the signal of a response's setpoints by which the tip of the tool is followed, where it was."""
    lengths = response.tool_length_mm
    return {} if lengths is None else {"tool_length": lengths}


def _export(
    path: str,
    machine: str,
    axis_params: str | None,
    controller: str,
    given: tuple[str | None, float | None],
    fmi: int,
) -> None:
    """Write an FMU of the axes, whose letters and period may be `given`."""
    from cncgen.files import open_output
    from cncgen.pipeline import fmu, machine_of

    axes, period = given
    where = machine_of(machine)
    period_s = period or where.period_s
    content = fmu(axis_params or where, controller=controller, axes=axes, period_s=period_s, fmi=fmi)
    with open_output(path) as sink:
        sink.write(content)
    messages.note(f"{path}: {len(content)} bytes, FMI {fmi}.0 for co-simulation, steps of {period_s:g} s")


def _draw(chunks: Iterable[Response]) -> None:
    for _ in chunks:
        pass


@contextmanager
def _setpoints(
    source: str,
    machine: str,
    planning: dict[str, Any],
    given: tuple[str | None, str | None, float | None],
    reading: dict[str, Any],
) -> Iterator[SetpointStream]:
    """Open setpoints, whose format, axes and period may be `given`, or plan the program that `source` names."""
    from cncgen.cli.reading import is_setpoint_file, planned, planning_machine
    from cncgen.pipeline import machine_of, sample
    from cncgen.setpoints.readers import open_setpoints

    format, axes, period = given
    if format or source == "-" or is_setpoint_file(source):
        usual = machine_of(machine).period_s
        with open_setpoints(
            source, format=format, axes=axes, period_s=period, default_period_s=usual
        ) as stream:
            yield stream
        return
    with planned(source, reading, planning, planning_machine(machine, planning)) as plan:
        yield sample(plan, ["tool_length"])
