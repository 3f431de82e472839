"""Options and arguments that several commands share, each declared once."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Any

import click

from cncgen.cli import memory, messages
from cncgen.cli.types import (
    AXES,
    FILE,
    FOLDER,
    MACHINE,
    SETPOINT_FORMAT,
    FiniteRange,
    NamedChoice,
    Uncertain,
    WholeRange,
)
from cncgen.extensions import DIALECT_GROUP
from cncgen.ranges import TOLERANCE_MM
from cncgen.toolpath.reading import DIALECTS, SPEED_UNITS, SPINDLE_SIGNS, UNITS

Command = Callable[..., Any]

TABLE_UNITS = ("mm", "inch")
# As the rooms have them whose import takes numpy; a test holds both together.
LANGUAGES = ("gcode", "stepnc")
FEEDRATES = ("optimal", "ild", "constant", "adaptive", "curvature")
INTERPOLATORS = (
    "arclength",
    "taylor1",
    "taylor2",
    "uniform",
    "stateline",
    "two-stage-linear",
    "two-stage-centred",
    "two-stage-causal",
)
SATURATIONS = ("off", "reactive", "predictive")
PROFILES = ("bell", "linear", "exponential")
CONTROLS = ("linuxcnc", "grbl", "exact-stop")
EFFORTS = ("best", "fast")
LEAST_CONTOUR_ERROR_MM = 1e-6


def _all_of(*decorators: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Join decorators into one; the first stands first in the help."""
    return lambda function: functools.reduce(lambda f, decorate: decorate(f), reversed(decorators), function)


def _gathering(into: str, *options: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Join options into one decorator; the command receives their values as one mapping under the name `into`."""

    def carrier() -> None:
        pass

    names = [parameter.name for parameter in getattr(_all_of(*options)(carrier), "__click_params__", ())]

    def decorate(function: Command) -> Command:
        @functools.wraps(function)
        def gathered(*args: Any, **values: Any) -> Any:
            together = {name: values.pop(name) for name in names}
            return function(*args, **{into: together}, **values)

        return _all_of(*options)(gathered)

    return decorate


def _choice(
    flag: str, choices: tuple[str, ...], help: str, default: bool = True
) -> Callable[[Command], Command]:
    """Return an option that takes one of some words; the first is the default, if any."""
    usual = choices[0] if default else None
    return click.option(flag, type=click.Choice(choices), default=usual, show_default=default, help=help)


#: Parameters of commands that name input files, with their kinds, and options that name output files.
_INPUTS = {
    "program": "the program",
    "programs": "a program",
    "source": "what is read",
    "setpoints": "the setpoints",
    "reference": "the reference",
    "log": "the log",
    "machine": "the machine file",
    "axis_params": "the servo data",
    "tool_table": "the tool table",
    "parameters": "the parameter file",
    "stock": "the stock",
    "target": "the finished part",
    "compare": "what is compared",
}
_OUTPUTS = ("output", "picture", "summary", "events", "report", "save_parameters", "fmu", "wanted")
#: Those that may name folders, which their commands check.
_FOLDERS = (("plot", "--output"), ("run", "--output"))
#: Those of them of which ``-`` means standard output, and commands that print nothing there by themselves.
_TO_STANDARD_OUTPUT = ("events", "report", "save_parameters")
_SILENT = ("check", "verify")


def check_outputs(command: str, values: dict[str, Any]) -> None:
    """Refuse options of a command that would overwrite what it reads, or each other's file, or mix on standard output, and
    files that cannot be written.

    `--save-parameters` alone may name what it replaces, the file of `--parameters`.

    Args:
        command: Its name.
        values: Its parameters by name.

    Raises:
        UsageError: Naming the two, or the file.
    """
    from cncgen.files import STANDARD, check_distinct, check_writable, is_terminal

    read = []
    for key, what in _INPUTS.items():
        names = values.get(key) or ()
        read += [(name, what) for name in (names if isinstance(names, tuple) else (names,))]
    written = {f"--{key.replace('_', '-')}": values.get(key) for key in _OUTPUTS}
    check_distinct(read, written, {"--save-parameters": "the parameter file"})
    mixed = [f"--{key.replace('_', '-')}" for key in _TO_STANDARD_OUTPUT if values.get(key) == STANDARD]
    output = values.get("output")
    if output == STANDARD or (output is None and command not in _SILENT and not is_terminal(sys.stdout)):
        mixed.append("what the command writes")
    if len(mixed) > 1:
        raise click.UsageError(f"{' and '.join(mixed)} cannot both go to standard output.")
    for option, path in written.items():
        if path not in (None, STANDARD) and (command, option) not in _FOLDERS:
            check_writable(path)


def _checked(function: Command) -> Command:
    """Let a command check its files before it begins."""

    @functools.wraps(function)
    def checked(*args: Any, **values: Any) -> Any:
        context = click.get_current_context()
        check_outputs(str(context.info_name), context.params)
        return function(*args, **values)

    return checked


#: Options of every command, which then checks its files before it begins.
message_options = _all_of(
    click.option(
        "--json",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=messages.set_json,
        help="Print diagnostics as JSON lines, and no summary.",
    ),
    click.option(
        "-q",
        "--quiet",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=messages.set_quiet,
        help="Print diagnostics alone: no progress, no summary.",
    ),
    click.option(
        "--max-memory",
        metavar="MIB",
        type=WholeRange(64, 2**30),
        default=memory.DEFAULT_MIB,
        show_default=True,
        is_eager=True,
        expose_value=False,
        callback=memory.set_bound,
        help="Memory that the run may take.",
    ),
    _checked,
)

#: Options of reading a program; the command receives them together as `reading`.
program_options = _gathering(
    "reading",
    _choice(
        "--language", LANGUAGES, "Language of the program [default: by suffix and content].", default=False
    ),
    click.option(
        "--dialect",
        type=NamedChoice(DIALECTS, DIALECT_GROUP),
        default=DIALECTS[0],
        show_default=True,
        help="Control that the G-code is for, where controls differ.",
    ),
    _choice("--units", UNITS, "Unit of lengths until G20 or G21 says it; auto: mm, with a note."),
    click.option("--tool-table", metavar="FILE", type=FILE, help="Tool table in LinuxCNC's format."),
    click.option(
        "--parameters",
        metavar="FILE",
        type=FILE,
        help="Numbered parameters, and pins and INI entries by name; read, never rewritten.",
    ),
    _choice(
        "--table-units",
        TABLE_UNITS,
        "Lengths in the tool table and the parameters [default: mm; canon: inch, as rs274 has them].",
        default=False,
    ),
    click.option(
        "--save-parameters",
        metavar="FILE",
        type=FILE,
        help="Write the numbered parameters here after the program.",
    ),
    click.option(
        "--include",
        metavar="DIR",
        type=FOLDER,
        multiple=True,
        help="Search subprograms here too (may be repeated).",
    ),
    click.option(
        "--block-delete/--no-block-delete",
        default=None,
        help="Skip blocks that begin with / [default: skip; canon: run, as rs274 does].",
    ),
    _choice(
        "--speed-unit",
        SPEED_UNITS,
        "Unit of the cutting speeds of ISO 14649; in m/min they count before spindle speeds.",
    ),
    _choice(
        "--spindle-sign",
        SPINDLE_SIGNS,
        "Sense of rotation in STEP-NC: by the sign of the speed, or by the hand of the tool.",
    ),
    click.option(
        "--max-steps",
        metavar="N",
        type=WholeRange(min=1),
        help="Blocks executed before a program counts as endless [default: some seconds of work].",
    ),
)

machine_option = click.option(
    "-m",
    "--machine",
    metavar="NAME|FILE",
    type=MACHINE,
    default="generic-mill",
    show_default=True,
    help="Machine profile, or a TOML file.",
)

#: For commands that need a program's motions alone; None: no machine says how they are read.
control_option = click.option(
    "-m",
    "--machine",
    metavar="NAME|FILE",
    type=MACHINE,
    help="Machine whose control reads the program: its tables [interpreter] and [kinematics].",
)

axis_params_option = click.option(
    "--axis-params",
    metavar="NAME|FILE",
    type=MACHINE,
    help="Servo data of the axes: a profile or a TOML file [default: the machine's own].",
)

#: Options of planning; the command receives them together as `planning`.
planning_options = _gathering(
    "planning",
    _choice(
        "--feedrate",
        FEEDRATES,
        "Feedrate strategy: jerk-limited per axis near the least time (optimal), sharp corners and jerk-limited "
        "segments (ild), or a baseline of the papers [default: optimal].",
        default=False,
    ),
    _choice(
        "--interpolator",
        INTERPOLATORS,
        "How the next point on the path is found: exactly, by arc length (arclength); by Taylor steps of first or second order "
        "(taylor1, taylor2); by equal steps of a curve's parameter (uniform); exactly, all axes holding together while one falls "
        "behind (stateline); or between a master's points (two-stage-…).",
    ),
    _choice(
        "--saturation",
        SATURATIONS,
        "Keep the drives out of saturation: step by step (reactive) or in the look-ahead (predictive).",
    ),
    _choice("--profile", PROFILES, "Acceleration and deceleration of ild."),
    _choice(
        "--effort",
        EFFORTS,
        "Method of optimal: path and speed chosen together within the tolerance of G64 (best, docs/tube.md), or the speed alone "
        "along the smoothed path (fast).",
    ),
    click.option(
        "--path-tolerance",
        metavar="MM",
        type=FiniteRange(min=0, max=TOLERANCE_MM, min_open=True),
        help="How far continuous motion may leave the programmed path [default: the program's, else the machine's].",
    ),
    click.option(
        "--max-contour-error",
        metavar="MM",
        type=FiniteRange(min=LEAST_CONTOUR_ERROR_MM),
        help="Contour error, as the servo model predicts it, that the plan stays under "
        "[default: the machine's, for ild].",
    ),
    click.option(
        "--stateline-bound",
        metavar="MM",
        type=FiniteRange(min=1e-9),
        default=0.05,
        show_default=True,
        help="Following error of an axis, beyond that of its speed, at which the axes of the interpolator stateline hold.",
    ),
    click.option(
        "--master-period",
        metavar="SECONDS",
        type=FiniteRange(min=0, min_open=True),
        default=0.016,
        show_default=True,
        help="Time between the master's points of two-stage interpolation.",
    ),
    click.option(
        "--fit",
        metavar="MM",
        type=FiniteRange(min=1e-9),
        help="Plan runs of short lines as cubic NURBS curves within this distance of them.",
    ),
    click.option(
        "--kbar",
        metavar="1/MM",
        type=FiniteRange(min=0, min_open=True),
        default=1.0,
        show_default=True,
        help="Curvature at which ild (at sharp corners) and curvature halve the feed.",
    ),
    click.option(
        "--corner-distance",
        metavar="MM",
        type=FiniteRange(min=0),
        default=1.0,
        show_default=True,
        help="Least distance of a sharp corner of ild from the one before it and from the start of its curve.",
    ),
    axis_params_option,
)

#: Axes and period of a file of setpoints that lacks them.
unnamed_options = _all_of(
    click.option(
        "--axes",
        metavar="LETTERS",
        type=AXES,
        help="Axes of setpoints in a format that does not name them; else those that are wanted.",
    ),
    click.option(
        "--period",
        metavar="SECONDS",
        type=FiniteRange(min=0, min_open=True),
        help="Period of the setpoints [default: from their times].",
    ),
)

#: How to read a file of setpoints; with `format` None its content and suffix decide.
setpoint_options = _all_of(
    click.option(
        "--format",
        "format",
        type=SETPOINT_FORMAT,
        help="Format of the setpoints [default: by content and suffix, else csv].",
    ),
    unnamed_options,
)

format_option = click.option(
    "--format",
    "format",
    type=SETPOINT_FORMAT,
    help="Format of the setpoints [default: by suffix, else csv].",
)

#: Plans and setpoints that a page shows over its own plan.
compare_option = click.option(
    "--compare",
    metavar="WHAT",
    multiple=True,
    help="Show over it: a setpoint file, another machine, or feedrate=ild, tolerance=0.02 ... (may be repeated).",
)

#: Whether it shows the changes that would shorten the part.
why_option = click.option(
    "--why",
    "with_why",
    is_flag=True,
    help="Say on the page what would shorten the part (plans it many times).",
)

#: The motion that was wanted, which a simulation is judged by beside its command.
reference_option = click.option(
    "--reference",
    metavar="PROGRAM|SETPOINTS",
    type=FILE,
    help="Give contour and tracking error against this program's path and plan, or these setpoints, too.",
)

#: A part that is cut: its stock, the forms of its tools, and how finely.
stock_options = _all_of(
    click.option(
        "--stock",
        metavar="STOCK",
        help="box:X0,Y0,Z0,X1,Y1,Z1, cylinder:X,Y,DIAMETER,Z0,Z1, or an STL file, mm [default: the STEP-NC file's raw piece].",
    ),
    click.option(
        "--tool",
        "tools",
        metavar="NAME=FORM",
        multiple=True,
        help="A tool's form: flat:D, ball:D, bull:D,R, drill:D,POINT, chamfer:D,ANGLE,TIP; then ;length=L ;shank=D ;holder=D,HEIGHT. "
        "NAME * is the tool before the first change. Repeatable.",
    ),
    click.option(
        "--cell",
        metavar="MM",
        type=FiniteRange(min=0, min_open=True),
        help="Width of a column of the stock [default: some 500th of its longer side].",
    ),
)

#: Options for the contents of a page beside the plan; the command receives them together as `shown`.
page_options = _gathering("shown", compare_option, why_option, reference_option, stock_options)

#: Machines whose parameters are not quite the model's; the command receives them together as `uncertainty`.
perturb_options = _gathering(
    "uncertainty",
    click.option(
        "--perturb",
        metavar="SHARE|SUMMARY.json",
        type=Uncertain(0.0, 0.9),
        help="Draw every servo parameter within this share of its value, as 10%, and show worst and quantiles; axes of a "
        "summary of identify as their log leaves them open. Several by commas.",
    ),
    click.option(
        "--draws",
        metavar="N",
        type=WholeRange(1, 65536),
        help="Machines that --perturb draws [default: 512; tune, and compensate without --perturb: 64].",
    ),
    click.option(
        "--draw-seed",
        metavar="N",
        type=WholeRange(0),
        default=0,
        show_default=True,
        help="Seed of the draws.",
    ),
)

output_option = click.option(
    "-o", "--output", metavar="FILE", type=FILE, help="Where the result goes [default: standard output]."
)

summary_option = click.option(
    "--summary", metavar="FILE", type=FILE, help="Write the summary as JSON (- for standard error)."
)


def settle_option(default_s: float, help: str) -> Callable[[Command], Command]:
    """Return the option ``--settle``: how long the last position is held."""
    return click.option(
        "--settle",
        metavar="SECONDS",
        type=FiniteRange(0, 3600),
        default=default_s,
        show_default=True,
        help=help,
    )
