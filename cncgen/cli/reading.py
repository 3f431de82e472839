"""Shared parts of the commands that read a program: the program from its options, and its remarks at the end."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from cncgen.cli import messages
from cncgen.diagnostics import CncgenError
from cncgen.extensions import FORMATS, SUFFIXES, is_format

if TYPE_CHECKING:
    from cncgen.pipeline import Plan
    from cncgen.planner import PlanOptions
    from cncgen.servo.identified_spread import IdentifiedSpread
    from cncgen.servo.uncertainty import Perturbation
    from cncgen.servo.wanted_motion import WantedMotion
    from cncgen.toolpath.reading import ReadOptions
    from cncgen.toolpath.record import Program


def is_setpoint_file(name: str) -> bool:
    """Tell whether a file, or a pipe that has a name, holds setpoints, by its suffix or how it begins.

    Any other one is a program; a reader names files that it cannot read.
    """
    from cncgen.files import head_of
    from cncgen.pipeline.file_kinds import SUFFIXES as PROGRAM_SUFFIXES
    from cncgen.pipeline.file_kinds import holds_setpoints

    suffix = os.path.splitext(name)[1].lower().lstrip(".")
    if suffix in (*FORMATS, *SUFFIXES):
        return True
    if suffix and f".{suffix}" not in chain.from_iterable(PROGRAM_SUFFIXES.values()) and is_format(suffix):
        return True
    return holds_setpoints(head_of(name, 64))


@contextmanager
def opened(
    name: str, reading: dict[str, Any], tolerance_mm: float | None = None, machine: str | None = None
) -> Iterator[Program]:
    """Open a program for a ``with`` block; remarks of the reader are shown when the block ends.

    Args:
        name: File, or ``-``.
        reading: The values gathered by `cncgen.cli.options.program_options`.
        tolerance_mm: Path tolerance that stands in for the program's.
        machine: The machine whose settings say how the program is read, where options do not.
    """
    from cncgen.kernels import warn_if_uncompiled
    from cncgen.pipeline import read

    warn_if_uncompiled()
    language, options = read_options(reading, tolerance_mm, machine)
    program = read(name, language=language, options=options)
    try:
        yield program
    except CncgenError as error:
        raised = {id(item) for item in error.diagnostics}
        others = [item for item in program.diagnostics if id(item) not in raised]
        # The program's own error says how many more there are.
        messages.show(others if len(others) < len(program.diagnostics) else program.diagnostics)
        raise
    messages.show(program.diagnostics)


@contextmanager
def planned(name: str, reading: dict[str, Any], planning: dict[str, Any], machine: str) -> Iterator[Plan]:
    """Open a program and plan it on a machine, for a ``with`` block in which the plan is drawn.

    Args:
        name: File, or ``-``.
        reading, planning: The values that `cncgen.cli.options.program_options` and `planning_options` gathered.
        machine: A profile's name or a TOML file.
    """
    from cncgen.pipeline import plan

    with opened(name, reading, planning["path_tolerance"], machine) as program:
        yield plan(program, machine, plan_options(planning))


def read_options(
    reading: dict[str, Any],
    tolerance_mm: float | None = None,
    machine: str | None = None,
    *,
    as_rs274: bool = False,
    tips_alone: bool = False,
) -> tuple[str | None, ReadOptions]:
    """Return language and options of reading from the values gathered by `cncgen.cli.options.program_options`.

    Other options come from the machine's tables, or with `as_rs274` from LinuxCNC's stand-alone interpreter. With `tips_alone` and
    without a machine, programs that control the tool's point are read as paths of the tip.

    Raises:
        UsageError: A folder to search is missing; the machine cannot be read.
    """
    from pathlib import Path

    from cncgen.files import check_folder
    from cncgen.toolpath.reading import ReadOptions

    values = dict(reading)
    language = values.pop("language")
    for key in ("tool_table", "parameters", "save_parameters"):
        values[key] = Path(values[key]) if values[key] else None
    if values["block_delete"] is None:
        values["block_delete"] = not as_rs274
    values["inch_tables"] = (values.pop("table_units") or ("inch" if as_rs274 else "mm")) == "inch"
    for folder in values["include"]:
        check_folder(folder)
    values["include"] = tuple(Path(folder) for folder in values["include"])
    options = ReadOptions(**values, tolerance_mm=tolerance_mm, tips_alone=tips_alone and machine is None)
    if machine is not None:
        from cncgen.pipeline import machine_of, options_on

        options = options_on(machine_of(machine), options)
    return language, options


def planning_machine(machine: str, planning: dict[str, Any]) -> str:
    """Return the machine that a program is planned on: that of ``-m``; by default that of ``--axis-params``.

    A file of servo data alone has no limits to plan with. The choice is noted.
    """
    from cncgen.machine.shipped import has_limits

    servos = planning["axis_params"]
    asked = click.get_current_context().get_parameter_source("machine") is not ParameterSource.DEFAULT
    if asked or servos is None:
        return machine
    if not has_limits(servos):
        messages.note(f"{servos} has no limits: planned on {machine}; -m names another machine")
        return machine
    messages.note(f"planned on {servos}, the machine of --axis-params; -m names another")
    return str(servos)


def reference_of(name: str, machine: str, planning: dict[str, Any], reading: dict[str, Any]) -> WantedMotion:
    """Return the wanted motion: setpoints as they are, or a program's plan with its path.

    Args:
        name: File of setpoints, or program.
        machine: A profile's name or a TOML file.
        planning, reading: The values that `planning_options` and `program_options` gathered.
    """
    from cncgen.pipeline import machine_of, plan, sample, sound
    from cncgen.servo.wanted_motion import reference_of, wanted_of_program
    from cncgen.setpoints.readers import open_setpoints

    if is_setpoint_file(name):
        with open_setpoints(name, default_period_s=machine_of(machine).period_s) as stream:
            return reference_of(name, stream.chunks)
    tolerance = planning["path_tolerance"]
    with opened(name, reading, tolerance, machine) as program:
        planned = sample(plan(program, machine, plan_options(planning)), ["tool_length"]).collect()
    with opened(name, reading, tolerance, machine) as again:
        return wanted_of_program(name, [planned], sound(again), machine_of(machine))


def _given(names: Iterable[str]) -> list[str]:
    """Return the flags of those options that stand on the command line."""
    context = click.get_current_context()
    return [
        f"--{name.replace('_', '-')}"
        for name in names
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]


def tell_of_unused(source: str, planning: Mapping[str, Any], reading: Mapping[str, Any]) -> None:
    """Warn of options of reading and planning where `source` holds setpoints, and no program is read beside."""
    named = _given(name for name in (*planning, *reading) if name != "axis_params")
    if named:
        text = f"no use for {', '.join(named)}: {source} holds setpoints, which are planned already"
        messages.warning("option-unused", text)


def perturbation_of(
    uncertainty: dict[str, Any], usual: float | None = None, draws: int | None = None
) -> Perturbation | None:
    """Return the drawn machines, from the values gathered by `cncgen.cli.options.perturb_options`; None without a share.

    Args:
        uncertainty: Their values.
        usual: Default share; few machines show its effect.
        draws: Their number where the options do not say it; None: enough for intervals.
    """
    from cncgen.servo.uncertainty import DRAWS, FEW_DRAWS, Perturbation

    share, files = uncertainty["perturb"] or (usual or 0.0, ())
    if not share and not files:
        if named := _given(("draws", "draw_seed")):
            messages.warning(
                "option-unused", f"no use for {', '.join(named)}: without --perturb no machines are drawn"
            )
        return None
    found = tuple(spread for name in files for spread in _identified(name))
    number = uncertainty["draws"] or draws or (DRAWS if uncertainty["perturb"] else FEW_DRAWS)
    return Perturbation(share, number, uncertainty["draw_seed"], found)


def _identified(name: str) -> Iterator[IdentifiedSpread]:
    """Yield the data of each axis in a summary of ``cncgen identify``."""
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.servo.identified_spread import read_summary, spread_of

    try:
        summary = read_summary(name)
        axes = summary.get("axes")
        if not isinstance(axes, dict) or not axes:
            raise ValueError("not a summary of cncgen identify: it has no axes")
        for letter in axes:
            yield spread_of(summary, letter.upper())
    except ValueError as error:
        hint = "cncgen identify LOG --model … --summary FILE.json writes one"
        raise UsageError(Diagnostic("perturb-summary", f"{name}: {error}", hint=hint)) from error


def plan_options(planning: dict[str, Any]) -> PlanOptions:
    """Return the planner's options from the values gathered by `cncgen.cli.options.planning_options`."""
    from cncgen.machine import load_servos
    from cncgen.planner import PlanOptions

    axis_params = planning["axis_params"]
    return PlanOptions(
        feedrate=planning["feedrate"],
        interpolator=planning["interpolator"],
        saturation=planning["saturation"],
        profile=planning["profile"],
        effort=planning["effort"],
        path_tolerance_mm=planning["path_tolerance"],
        max_contour_error_mm=planning["max_contour_error"],
        stateline_bound_mm=planning["stateline_bound"],
        master_period_s=planning["master_period"],
        fit_mm=planning["fit"],
        kbar_per_mm=planning["kbar"],
        corner_distance_mm=planning["corner_distance"],
        servos=load_servos(axis_params) if axis_params else None,
    )


def page_of(
    name: str,
    machine: str,
    shown: dict[str, Any],
    planning: dict[str, Any],
    reading: dict[str, Any],
) -> str:
    """Return the HTML page on a program's plan, and on those that it is compared with; the planner's remarks are shown.

    Args:
        name: File, or ``-``.
        machine: A profile's name or a TOML file.
        shown, planning, reading: The values that `page_options`, `planning_options` and `program_options` gathered.
    """
    from cncgen.pipeline import ShownPart, report_page, variant_of

    tolerance, how, reference = planning["path_tolerance"], plan_options(planning), shown["reference"]
    wanted = None if reference is None else reference_of(reference, machine, planning, reading)
    variants = [variant_of(what, how) for what in shown["compare"]]
    stock, tools, cell = shown["stock"], shown["tools"], shown["cell"]
    shown_part = ShownPart(stock, tools, cell) if stock or tools or cell else None
    with opened(name, reading, tolerance) as program:
        page = report_page(
            program,
            machine,
            how,
            compare=variants,
            with_why=shown["with_why"],
            reference=wanted,
            shown_part=shown_part,
        )
        messages.show(page.remarks)
    return page.html
