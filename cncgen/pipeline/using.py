"""Uses of setpoints: write and read files, simulate the servo axes, judge."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any

from cncgen.arguments import (
    declared,
    expect,
    expect_axes,
    expect_number,
    expect_path,
    is_number,
    untouched,
    wrong,
)
from cncgen.pipeline.planning import (
    Plan,
    as_read,
    asked_for,
    drives_of,
    machine_of,
    metadata_of,
    output_axes,
    program_of,
    sample,
)
from cncgen.pipeline.reading import REPEATED, sound
from cncgen.ranges import RESOLUTION, TOLERANCE_MM
from cncgen.units import AXIS_LETTERS

if TYPE_CHECKING:
    from cncgen.machine import Machine, Servo
    from cncgen.machine.kinematics import Kinematics
    from cncgen.planner import PlanOptions
    from cncgen.report.shortening import PlannedTimes, Shortening
    from cncgen.servo.record import Response
    from cncgen.setpoints.columns import Layout
    from cncgen.setpoints.record import Setpoints
    from cncgen.setpoints.stream import SetpointStream
    from cncgen.toolpath.record import Program
    from cncgen.verify import Verdict


#: Longest time, s, that a simulation may go on after the last setpoint: these rows are held in memory.
LONGEST_SETTLE_S = 3600.0


@declared
def simulate(
    setpoints: Iterable[Setpoints] | Setpoints | Plan,
    machine: Machine | Mapping[str, Servo] | str | os.PathLike[str],
    *,
    controller: str = "p",
    settle_s: float = 0.0,
    kinematics: Kinematics | None = None,
) -> Iterator[Response]:
    """Simulate the servo axes of a machine under setpoints.

    Args:
        setpoints: From `sample` (a stream, or collected), from a file (`cncgen.setpoints.readers.open_setpoints`), your
            own (`Setpoints`), or a plan, which is sampled.
        machine: Gives the servo data: a machine, servos by letter, a profile's name, or a TOML file.
        controller: ``p`` (each axis under its own controller) or another of `cncgen.servo.named_schemes.NAMES`, with the gains
            of the machine's ``[coupling]`` table, if it has one.
        settle_s: How long the last setpoint is held at the end, s, up to `LONGEST_SETTLE_S`.
        kinematics: How rotary axes carry table or head; None: as `machine` has it. Of a plan, or of setpoints with the signal
            ``tool_length``, contour errors are those of the tool's tip on the workpiece then.

    Returns:
        `cncgen.servo.record.Response`, chunk by chunk as they are drawn: ``position``, ``force`` (n, axes) and
        ``contour_error_mm`` (n,), a row a setpoint.

    Raises:
        UsageError: An axis that the machine has, or that moves, has no servo data, the controller does not exist for these axes, or (as they are drawn) setpoints
            are wrong, or there are none: a generator was read before.
    """
    from cncgen.servo.loop_doubts import telling
    from cncgen.servo.named_schemes import scheme_maker, settings_of
    from cncgen.servo.simulate import simulate_scheme
    from cncgen.servo.stream import driven

    settle_s = expect_number(settle_s, "settle_s", high=LONGEST_SETTLE_S)
    servos = servos_of(machine)
    mechanism = kinematics or _kinematics_of(machine)
    if mechanism and isinstance(setpoints, Plan):
        setpoints = sample(setpoints, ["tool_length"])
    chunks = _some(_chunks_of(setpoints))
    made = telling(scheme_maker(controller, servos, settings_of(coupling_of(machine))))
    if not isinstance(machine, Mapping):
        chunks = driven(chunks, known_axes(machine, servos))
    return simulate_scheme(chunks, made, settle_s=settle_s, kinematics=mechanism)


def _kinematics_of(machine: Machine | Mapping[str, Servo] | str | os.PathLike[str]) -> Kinematics | None:
    """Return how the rotary axes of a machine carry table or head; None where that is not said, as of servo data alone."""
    from cncgen.machine.kinematics import mechanism_of
    from cncgen.machine.shipped import has_limits

    if isinstance(machine, Mapping) or (
        isinstance(machine, str | os.PathLike) and not has_limits(str(machine))
    ):
        return None
    return mechanism_of(machine_of(machine))


def known_axes(machine: Machine | str | os.PathLike[str], servos: Mapping[str, Servo]) -> frozenset[str]:
    """Return the axes that a machine, or a file of servo data alone, has."""
    from cncgen.machine.shipped import has_limits

    if isinstance(machine, str | os.PathLike):
        return frozenset(servos) | frozenset(machine_of(machine).axes if has_limits(str(machine)) else ())
    return frozenset(servos) | frozenset(machine.axes)


@declared
def fmu(
    machine: Machine | Mapping[str, Servo] | str | os.PathLike[str],
    *,
    controller: str = "p",
    axes: str | None = None,
    period_s: float | None = None,
    fmi: int = 2,
) -> bytes:
    """Return the servo axes of a machine as a co-simulation unit of FMI; see `cncgen.servo.fmu.fmu_bytes`.

    Args:
        machine: As for `simulate`.
        controller: ``p``, ``plain`` or ``h-infinity``: others need setpoints that are to come, or all axes at once.
        axes: Letters; None: all axes with servo data.
        period_s: Period of the setpoints; None: the machine's (1 ms of servo data alone).
        fmi: Version of the standard: 2 (FMI 2.0) or 3 (FMI 3.0).

    Raises:
        UsageError: An axis that the machine has, or that moves, has no servo data, the controller cannot be exported, or there is no C compiler.
    """
    from cncgen.machine import Machine
    from cncgen.servo.fmu import fmu_bytes
    from cncgen.servo.named_schemes import scheme_maker, settings_of

    if not is_number(fmi) or fmi not in (2, 3):
        raise wrong(f"fmi = {fmi!r} must be 2 or 3, the version of the standard")
    servos = servos_of(machine)
    if not servos:
        raise wrong("there are no axes with servo data")
    letters = expect_axes(axes, "axes") if axes else "".join(k for k in AXIS_LETTERS if k in servos)
    usual = machine.period_s if isinstance(machine, Machine) else 0.001
    period = usual if period_s is None else expect_number(period_s, "period_s", open_low=True)
    scheme = scheme_maker(controller, servos, settings_of(coupling_of(machine)))(letters, period)
    return fmu_bytes(scheme, controller, letters, period, int(fmi))


def _chunks_of(setpoints: Iterable[Setpoints] | Setpoints | Plan) -> Iterator[Setpoints]:
    """Return setpoints of any form as a stream of chunks, each checked when it is read."""
    import numpy as np

    from cncgen.setpoints.checking import FROM_ARRAY, checked_setpoints
    from cncgen.setpoints.record import Setpoints

    given: Any = sample(setpoints) if isinstance(setpoints, Plan) else setpoints
    if isinstance(given, Setpoints):
        given = (given,)
    wanted = "cncgen.Setpoints, or a stream of them"
    if isinstance(given, str | os.PathLike):
        expect(given, Setpoints, "setpoints", wanted, "cncgen.read_setpoints reads those of a file")
    if isinstance(given, np.ndarray):
        expect(given, Setpoints, "setpoints", wanted, FROM_ARRAY)
    return checked_setpoints(iter(expect(given, Iterable, "setpoints", wanted)))


def _stream_of(setpoints: Iterable[Setpoints] | Setpoints | Plan) -> SetpointStream:
    """Return setpoints of any form as a stream whose axes and period are those of its first chunk."""
    from cncgen.setpoints.stream import SetpointStream

    first, chunks = _first_of(setpoints)
    return SetpointStream(getattr(setpoints, "name", "setpoints"), first.axes, first.period_s, chunks)


def _some(chunks: Iterator[Setpoints]) -> Iterator[Setpoints]:
    """Yield chunks; raise UsageError at the end of a stream without a row."""
    rows = 0
    for chunk in chunks:
        rows += len(chunk)
        yield chunk
    if not rows:
        raise wrong("there are no setpoints", "a generator can be read once")


def _first_of(setpoints: Iterable[Setpoints] | Setpoints | Plan) -> tuple[Setpoints, Iterator[Setpoints]]:
    """Return the first chunk of setpoints of any form, and the stream of all."""
    chunks = _chunks_of(setpoints)
    first = next(chunks, None)
    if first is None:
        raise wrong("there are no setpoints", "a generator can be read once")
    return first, chain((first,), chunks)


def servos_of(machine: Machine | Mapping[str, Servo] | str | os.PathLike[str]) -> Mapping[str, Servo]:
    """Return servo data by axis letter.

    Raises:
        UsageError: They cannot be loaded, or a key is wrong.
    """
    from cncgen.machine import Machine, load_servos
    from cncgen.machine.checking import check_servos

    if isinstance(machine, str | os.PathLike):
        return load_servos(machine)
    if isinstance(machine, Machine):
        axes = machine_of(machine).axes
        found = {k: axis.servo for k, axis in axes.items() if axis.servo is not None}
    else:
        wanted = "a Machine, a profile's name, a TOML file, or servos by letter"
        found = dict(expect(machine, Mapping, "the machine", wanted))
    check_servos(found)
    return found


def coupling_of(machine: Machine | Mapping[str, Servo] | str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return the ``[coupling]`` table of the argument of `servos_of`; {} without one."""
    from cncgen.machine import Machine, load_coupling

    if isinstance(machine, Machine):
        found: Mapping[str, Any] = machine.settings.get("coupling", {})
        return found
    return load_coupling(machine) if isinstance(machine, str | os.PathLike) else {}


@declared
def read_setpoints(
    source: str | os.PathLike[str],
    *,
    format: str | None = None,
    axes: str | None = None,
    period_s: float | None = None,
) -> Setpoints:
    """Read all of a setpoint file, written by cncgen or not; `cncgen.setpoints.readers.open_setpoints` streams it.

    Args:
        source: A file, or ``-`` for standard input.
        format: One of `cncgen.extensions.FORMATS`, or one that a package brings; None: by content and suffix.
        axes: Letters of the columns that are wanted; of npy, f64 and hal, which name no columns, those after the time.
        period_s: Time between rows; None: taken from the times in the file.

    Raises:
        UsageError: The file cannot be read, or does not hold setpoints; all its faulty rows are named.
    """
    from cncgen.setpoints.readers import open_setpoints

    name = expect_path(source, "the setpoint file", "the name of a file")
    if axes is not None:
        axes = expect_axes(axes.upper() if isinstance(axes, str) else axes, "axes")
    if period_s is not None:
        period_s = expect_number(period_s, "period_s", open_low=True)
    with open_setpoints(name, format=format, axes=axes, period_s=period_s) as stream:
        return stream.collect()


@declared
def write(
    setpoints: Iterable[Setpoints] | Setpoints | Plan,
    target: str | os.PathLike[str],
    *,
    format: str | None = None,
    machine: Machine | str | os.PathLike[str] | None = None,
) -> int:
    """Write setpoints to a file, with the signals that they have; return the number of rows.

    The file appears when all of it is written: none after an error.

    Args:
        setpoints: As for `simulate`.
        target: The file, or ``-`` for standard output.
        format: One of `cncgen.extensions.FORMATS`, or one that a package brings; None: by the suffix, csv without one.
        machine: Machine whose limits the file states, where the format has a place for them, and whose drives scale it (csp);
            None: that of the plan.

    Raises:
        UsageError: The file cannot be written, a format or suffix is unknown, the machine lacks drive data, or setpoints are wrong. Exceptions of drawing a plan
            are passed on.
    """
    from cncgen.files import open_output
    from cncgen.setpoints.stream import SetpointStream
    from cncgen.setpoints.writers import format_of, open_writer

    name = expect_path(target, "the target", "the name of a file")
    kind = format_of(name, format)
    setpoints = sample(setpoints) if isinstance(setpoints, Plan) else setpoints
    if isinstance(setpoints, SetpointStream):
        untouched(setpoints.chunks, repr(setpoints))
    # The first rows are drawn before the file is opened, so that a program that is refused leaves no file.
    first, chunks = _first_of(setpoints)
    rows = 0
    with open_output(name) as sink:
        writer = open_writer(kind, sink, _layout_of(setpoints, first, machine))
        for chunk in chunks:
            writer.write(chunk)
            rows += len(chunk)
        writer.close()
    return rows


def _layout_of(
    setpoints: Iterable[Setpoints] | Setpoints,
    first: Setpoints,
    machine: Machine | str | os.PathLike[str] | None,
) -> Layout:
    """Return the columns of setpoints whose first chunk is given, with data of their stream or of a machine."""
    from cncgen.setpoints.columns import Layout
    from cncgen.setpoints.stream import SetpointStream

    about, drives = {}, {}
    if isinstance(setpoints, SetpointStream):
        about, drives = dict(setpoints.metadata), dict(setpoints.drives)
    if machine is not None:
        where = machine_of(machine)
        about, drives = {**about, **metadata_of(about.get("program", ""), where)}, drives_of(where)
    return Layout(first.axes, first.period_s, tuple(first.signals), about, drives)


@declared
def judge(
    setpoints: Iterable[Setpoints] | Setpoints | Plan,
    program: Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str],
    *,
    tolerance_mm: float | None = None,
    resolution: float = 1e-9,
) -> Verdict:
    """Judge setpoints against a program and a machine, as ``cncgen verify`` does; see `cncgen.verify.verify`.

    Args:
        setpoints: As for `simulate`.
        program: From `read`, or a file.
        machine: A profile's name, a TOML file, or a machine.
        tolerance_mm: Tolerance of every continuous motion (G64), instead of the program's.
        resolution: Unit, mm and degrees, to which the positions are rounded; differences may exceed a limit by the effect of this
            rounding.

    Returns:
        A verdict: ``holds`` tells whether everything is kept, ``breaches`` has a diagnostic for each limit that is broken,
        ``peaks`` the largest differences of each axis; and the largest distances between setpoints and path (docs/verify.md).

    Raises:
        UsageError: Setpoints or numbers are wrong, or a file cannot be read.
        ProgramError: The program has errors.
    """
    from cncgen.verify import verify

    where = machine_of(machine)
    program = program_of(program, where)
    if tolerance_mm is not None:
        tolerance_mm = expect_number(tolerance_mm, "tolerance_mm", high=TOLERANCE_MM, open_low=True)
    resolution = expect_number(resolution, "resolution", high=RESOLUTION, open_low=True)
    return verify(
        _stream_of(setpoints),
        sound(program),
        where,
        tolerance_mm=tolerance_mm,
        named=program.moving_axes or None,
        resolution=resolution,
    )


@declared
def why(
    program: Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str] = "generic-mill",
    options: PlanOptions | None = None,
    *,
    watch: Callable[[int, int], None] | None = None,
) -> tuple[PlannedTimes, list[Shortening]]:
    """Rank the limits, feeds and tolerances that would shorten a program, as ``cncgen why`` does.

    Args:
        program: From `read`, or a file; it is read again for each plan.
        machine: A profile's name, a TOML file, or a machine.
        options: As for `plan`.
        watch: Called after each plan with the number of plans that are done, and of all.

    Returns:
        The times of the unchanged plan, and a `cncgen.report.shortening.Shortening` per quantity, the largest saving first.

    Raises:
        UsageError, ProgramError, NoPlanError: As `plan`.
    """
    from cncgen.report.shortening import Case, shortenings

    where = machine_of(machine)
    program = program_of(program, where)
    case = Case(
        lambda spindle=1.0: sound(program, REPEATED, spindle),
        where,
        as_read(asked_for(options, {}), program),
    )
    return shortenings(case, output_axes(program), watch or (lambda done, of: None))
