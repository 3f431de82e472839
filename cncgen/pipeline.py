"""The stages in order: read, plan, sample, write, simulate, judge. The command line and the library both call this.

    import cncgen
    program = cncgen.read("programs/butterfly.nc")
    plan = cncgen.plan(program, "xy-table", feedrate="ild")
    setpoints = cncgen.sample(plan)
    response = cncgen.simulate(setpoints, "xy-table")

Each stage draws from the one before it as it is drawn itself, so that a program of any length streams through.
"""

from __future__ import annotations

import importlib
import io
import math
import os
import re
import stat
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path, PurePath
from types import ModuleType
from typing import TYPE_CHECKING, Any, BinaryIO

from cncgen.arguments import expect, expect_fields, expect_path, undrawn, wrong
from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, UsageError
from cncgen.files import STANDARD, open_input
from cncgen.toolpath.reading import ReadOptions

if TYPE_CHECKING:
    from cncgen.machine import Machine, Servo
    from cncgen.planner import PlanOptions, Trajectory
    from cncgen.report.line_times import LineTimes
    from cncgen.report.summary import Summary
    from cncgen.servo.record import Response
    from cncgen.setpoints.record import Setpoints
    from cncgen.setpoints.stream import SetpointStream
    from cncgen.toolpath.record import Program, Toolpath
    from cncgen.verify import Verdict

#: Suffixes by language.
SUFFIXES = {
    "gcode": (".nc", ".ngc", ".gcode", ".tap", ".cnc", ".txt"),
    "stepnc": (".stp", ".step", ".stpnc", ".p21", ".238"),
}
#: What a Part 21 file begins with, whatever its name: blanks and comments may stand before and within it.
_COMMENT = rb"/\*(?:[^*]|\*(?!/))*"
_PART21 = re.compile(
    rb"(?:\xef\xbb\xbf)?(?:\s|%b\*/)*(?:ISO-10303-21(?:\s|%b\*/)*;|%b\*?\Z)" % (_COMMENT, _COMMENT, _COMMENT),
    re.IGNORECASE,
)
#: Bytes that are looked at for it.
_HEAD_BYTES = 4096


def language_of(name: str, head: bytes) -> str:
    """Return ``stepnc`` or ``gcode``: by how the content begins, then by the suffix, else G-code."""
    if _PART21.match(head):
        return "stepnc"
    suffix = PurePath(name).suffix.lower()
    return "stepnc" if suffix in SUFFIXES["stepnc"] else "gcode"


def read(
    source: str | os.PathLike[str], *, language: str | None = None, options: ReadOptions | None = None
) -> Program:
    """Open a program; its toolpath is read as it is drawn (`Program.chunks`).

    Args:
        source: A file, or ``-`` for standard input.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read.

    Raises:
        UsageError: The file cannot be read.
    """
    with _opened(source, language) as (reader, file, name):
        program: Program = reader.read(file, name, _reading(options))
    return program


def check(
    source: str | os.PathLike[str],
    diagnostics: Diagnostics,
    *,
    language: str | None = None,
    options: ReadOptions | None = None,
    content: bytes | None = None,
) -> int:
    """Read and interpret a program, and keep nothing of it; return how many motions and events it has.

    Args:
        source: A file, or ``-`` for standard input.
        diagnostics: Takes all that is found.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read.
        content: What the file holds, where that is known already.

    Raises:
        UsageError: The file cannot be read.
    """
    with _opened(source, language, content) as (reader, file, name):
        if hasattr(reader, "check"):
            found: int = reader.check(file, name, _reading(options), diagnostics)
            return found
        program = reader.read(file, name, _reading(options))
    try:
        return sum(len(chunk) for chunk in program.chunks())
    finally:
        diagnostics.extend(program.diagnostics)


def read_text(
    text: str | bytes,
    name: str = "program",
    *,
    language: str | None = None,
    options: ReadOptions | None = None,
) -> Program:
    """Read a program from memory; see `read`."""
    given = expect(text, (str, bytes, bytearray, memoryview), "text", "str or bytes")
    content = given.encode(errors="replace") if isinstance(given, str) else bytes(given)
    reader = reader_of(language or language_of(name, content[:_HEAD_BYTES]))
    program: Program = reader.read(io.BytesIO(content), name, _reading(options))
    return program


def _reading(options: ReadOptions | None) -> ReadOptions:
    """Return the options, or the usual ones for None.

    Raises:
        UsageError: They are none, or a value is wrong.
    """
    if options is None:
        return ReadOptions()
    how: ReadOptions = expect(options, ReadOptions, "options", "cncgen.ReadOptions")
    how.check()
    return how


def reader_of(language: str) -> ModuleType:
    """Return the package that reads a language: it has `read`, and `check` and `canon` where it has a way of its own.

    Raises:
        UsageError: There is no such language.
    """
    if language not in SUFFIXES:
        raise wrong(f"language = {language!r} is not one of {', '.join(SUFFIXES)}")
    return importlib.import_module(f"cncgen.{language}")


@contextmanager
def _opened(
    source: str | os.PathLike[str], language: str | None, content: bytes | None = None
) -> Iterator[tuple[ModuleType, Path | BinaryIO, str]]:
    """Open a program; give the package that reads it, what it reads (a path that can be mapped, or a stream), its name.

    It is not opened where its `content` is at hand.
    """
    name = expect_path(source, "the program", "the name of a file (cncgen.read_text reads a text)")
    if content is not None:
        yield reader_of(language or language_of(name, content[:_HEAD_BYTES])), io.BytesIO(content), name
        return
    with open_input(name) as file:
        reader = reader_of(language or language_of(name, _head(file)))
        regular = name != STANDARD and stat.S_ISREG(os.fstat(file.fileno()).st_mode)
        yield reader, Path(name) if regular else file, name


def _head(file: BinaryIO) -> bytes:
    """Return the first bytes of an open file and leave them to be read."""
    peek = getattr(file, "peek", None)
    return bytes(peek(_HEAD_BYTES)) if peek else b""


def canon(
    source: str | os.PathLike[str], *, language: str | None = None, options: ReadOptions | None = None
) -> Iterator[str]:
    """Yield the canonical motions of a program as text, a call a line; see `cncgen.gcode.canon`.

    Raises:
        UsageError: The file cannot be read, or its language has no such text.
        ProgramError: The program has errors; raised when all calls are drawn.
    """
    with _opened(source, language) as (reader, file, name):
        if not hasattr(reader, "canon"):
            raise UsageError(Diagnostic("no-canon", f"{name}: canonical motions are printed of G-code alone"))
        yield from reader.canon(file, name, _reading(options))


def sound(program: Program) -> Iterator[Toolpath]:
    """Yield a program's toolpaths; after an error, read on for the other errors, then raise them.

    Raises:
        ProgramError: With all that was found.
    """
    for chunk in program.chunks():
        if not program.diagnostics.has_errors:
            yield chunk
    if program.diagnostics.has_errors:
        raise ProgramError(program.diagnostics)


@dataclass(frozen=True, slots=True)
class Plan:
    """A plan as it is drawn: iterate over it for its trajectories, once.

    Attributes:
        program: What is planned.
        machine: On which machine.
        trajectories: The motion, stretch by stretch.
    """

    program: Program
    machine: Machine
    trajectories: Iterator[Trajectory]

    def __iter__(self) -> Iterator[Trajectory]:
        return undrawn(self.trajectories, repr(self))

    def __repr__(self) -> str:
        return f"Plan({self.program!r}, {self.machine!r})"


def machine_of(machine: Machine | str | os.PathLike[str]) -> Machine:
    """Return a machine, loaded by its name or from its file where it is not one yet."""
    from cncgen.machine import Machine, load

    if isinstance(machine, Machine):
        return machine
    return load(expect_path(machine, "the machine", "a profile's name, a TOML file, or a Machine"))


def options_on(machine: Machine, options: ReadOptions | None = None) -> ReadOptions:
    """Return options of reading with what a machine's tables ``[interpreter]`` and ``[kinematics]`` say.

    ``least_increment_mm`` is what a number without a decimal point counts in, ``dialect`` the control's language (an
    option that names one goes first); `cncgen.gcode.kinematics` has the other table.

    Raises:
        UsageError: A setting is wrong.
    """
    how = options or ReadOptions()
    if "kinematics" in machine.settings:
        from cncgen.gcode.kinematics import kinematics_of

        how = replace(how, kinematics=kinematics_of(machine.settings["kinematics"]))
    if "interpreter" in machine.settings:
        from cncgen.gcode.settings import interpreter_settings

        how = interpreter_settings(machine.settings["interpreter"], how)
    return how


def plan(
    program: Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str] = "generic-mill",
    options: PlanOptions | None = None,
    **asked: Any,
) -> Plan:
    """Plan a program on a machine.

    Args:
        program: From `read`, or a file.
        machine: A profile's name, a TOML file, or a machine.
        options: How; or its fields as keywords (``feedrate="ild"``).

    Raises:
        UsageError, ProgramError, NoPlanError: See `cncgen.planner.plan`; those of the program come as it is drawn.
    """
    from cncgen import planner

    where = machine_of(machine)
    if isinstance(program, str | os.PathLike):
        program = read(program, options=options_on(where))
    from cncgen.toolpath.record import Program

    expect(program, Program, "the program", "what cncgen.read returns, or the name of a file")
    if options is not None:
        expect(options, planner.PlanOptions, "options", "cncgen.PlanOptions (or its fields as keywords)")
    expect_fields(planner.PlanOptions, asked)
    how = replace(options or planner.PlanOptions(), **asked)
    return Plan(program, where, planner.plan(sound(program), where, how))


def output_axes(program: Program) -> str:
    """Return the axes that setpoints of a program have: those that it names, X Y Z where it names none."""
    return program.moving_axes or program.axes


def sample(planned: Plan, signals: Sequence[str] = ()) -> SetpointStream:
    """Sample a plan once a period of its machine.

    Args:
        planned: From `plan`.
        signals: Further columns: ``vel``, ``acc``, ``jerk``, ``feed``, ``line``, ``limit`` (or their names by commas).

    Raises:
        UsageError: There is no such signal, or `planned` is no plan.
    """
    expect(planned, Plan, "what is sampled", "what cncgen.plan returns")
    if isinstance(signals, str):
        signals = [name.strip() for name in signals.split(",") if name.strip()]
    from cncgen import setpoints
    from cncgen.setpoints.stream import SetpointStream

    axes, machine = output_axes(planned.program), planned.machine
    chunks = setpoints.sample(iter(planned), machine, axes=axes, signals=signals)
    return SetpointStream(planned.program.name, axes, machine.period_s, chunks)


def plan_with_summary(
    program: Program,
    machine: Machine | str | os.PathLike[str],
    options: PlanOptions | None = None,
    signals: Sequence[str] = (),
    line_times: LineTimes | None = None,
) -> tuple[SetpointStream, Summary]:
    """Plan and sample a program under the eyes of a summary, which is complete when the stream is drawn.

    What each line takes is gathered into `line_times`, where it is given.
    """
    from cncgen import planner
    from cncgen.planner.strategies import available
    from cncgen.report.summary import Summary

    where, how = machine_of(machine), options or planner.PlanOptions()
    summary = Summary(program, where, how.feedrate or available()[0], line_times)
    trajectories = planner.plan(summary.over_toolpaths(sound(program)), where, how)
    stream = sample(Plan(program, where, summary.over_trajectories(trajectories)), signals)
    watched = replace(stream, chunks=summary.over_setpoints(stream.chunks))
    return watched, summary


def simulate(
    setpoints: Iterable[Setpoints] | Setpoints | Plan,
    machine: Machine | Mapping[str, Servo] | str | os.PathLike[str],
    *,
    controller: str = "p",
    settle_s: float = 0.0,
) -> Iterator[Response]:
    """Simulate the servo axes of a machine under setpoints.

    Args:
        setpoints: From `sample` (as it is, or collected), from a file (`cncgen.setpoints.readers.open_setpoints`), your
            own (`Setpoints`), or a plan, which is sampled.
        machine: Gives the servo data: a machine, servos by letter, a profile's name, or a TOML file.
        controller: ``p`` (each axis's own) or another of `cncgen.servo.named_schemes.NAMES`, with the gains of the
            machine's ``[coupling]`` table, if it has one.
        settle_s: The last setpoint is held so long at the end.

    Raises:
        UsageError: An axis has no servo data, or the controller cannot be had for the axes; setpoints are wrong (as they
            are drawn).
    """
    from cncgen.servo.named_schemes import scheme_maker, settings_of
    from cncgen.servo.simulate import simulate_scheme

    if not 0.0 <= settle_s < math.inf:
        raise wrong(f"settle_s = {settle_s} must be a finite time, not below 0")
    chunks = _chunks_of(setpoints)
    made = scheme_maker(controller, servos_of(machine), settings_of(coupling_of(machine)))
    return simulate_scheme(chunks, made, settle_s=settle_s)


def _chunks_of(setpoints: Iterable[Setpoints] | Setpoints | Plan) -> Iterator[Setpoints]:
    """Return setpoints of any form as a stream of chunks, each checked as it is drawn."""
    from cncgen.setpoints.checking import checked_setpoints
    from cncgen.setpoints.record import Setpoints

    given: Any = sample(setpoints) if isinstance(setpoints, Plan) else setpoints
    if isinstance(given, Setpoints):
        given = (given,)
    return checked_setpoints(
        iter(expect(given, Iterable, "setpoints", "cncgen.Setpoints, or a stream of them"))
    )


def _stream_of(setpoints: Iterable[Setpoints] | Setpoints | Plan) -> SetpointStream:
    """Return setpoints of any form with what the first chunk says of them."""
    from cncgen.setpoints.stream import SetpointStream

    first, chunks = _first_of(setpoints)
    return SetpointStream(getattr(setpoints, "name", "setpoints"), first.axes, first.period_s, chunks)


def _first_of(setpoints: Iterable[Setpoints] | Setpoints | Plan) -> tuple[Setpoints, Iterator[Setpoints]]:
    """Return the first chunk of setpoints of any form, and the stream of all."""
    chunks = _chunks_of(setpoints)
    first = next(chunks, None)
    if first is None:
        raise wrong("there are no setpoints")
    return first, chain((first,), chunks)


def servos_of(machine: Machine | Mapping[str, Servo] | str | os.PathLike[str]) -> Mapping[str, Servo]:
    """Return servo data by axis letter."""
    from cncgen.machine import Machine, load_servos

    if isinstance(machine, Machine):
        return {k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None}
    return load_servos(machine) if isinstance(machine, str | os.PathLike) else machine


def coupling_of(machine: Machine | Mapping[str, Servo] | str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return the ``[coupling]`` table of what `servos_of` takes; {} where there is none."""
    from cncgen.machine import Machine, load_coupling

    if isinstance(machine, Machine):
        found: Mapping[str, Any] = machine.settings.get("coupling", {})
        return found
    return load_coupling(machine) if isinstance(machine, str | os.PathLike) else {}


def read_setpoints(
    source: str | os.PathLike[str],
    *,
    format: str | None = None,
    axes: str | None = None,
    period_s: float | None = None,
) -> Setpoints:
    """Read a setpoint file of any origin whole; `cncgen.setpoints.readers.open_setpoints` streams it.

    Args:
        source: A file, or ``-`` for standard input.
        format: One of `cncgen.setpoints.writers.FORMATS`; None: by content and suffix.
        axes: Letters of the columns that are wanted, or that npy, f64 and hal have after the time.
        period_s: Time between rows; None: as the file's times say.

    Raises:
        UsageError: The file cannot be read, or is no setpoint file; all its faulty rows are named.
    """
    from cncgen.setpoints.readers import open_setpoints

    name = expect_path(source, "the setpoint file", "the name of a file")
    with open_setpoints(name, format=format, axes=axes, period_s=period_s) as stream:
        return stream.collect()


def write(
    setpoints: Iterable[Setpoints] | Setpoints | Plan,
    target: str | os.PathLike[str],
    *,
    format: str | None = None,
) -> int:
    """Write setpoints to a file, whole or not at all, with the signals that they have; return the number of rows.

    Args:
        setpoints: As for `simulate`.
        target: The file, or ``-`` for standard output.
        format: One of `cncgen.setpoints.writers.FORMATS`; None: by the suffix, else csv.

    Raises:
        UsageError: The file cannot be written, there is no such format, or setpoints are wrong; what drawing a plan
            raises comes as it is.
    """
    from cncgen.files import open_output
    from cncgen.setpoints.columns import Layout
    from cncgen.setpoints.writers import format_of, open_writer

    name = expect_path(target, "the target", "the name of a file")
    # The first rows are drawn before anything is opened: what is refused leaves no trace.
    first, chunks = _first_of(setpoints)
    rows = 0
    with open_output(name) as sink:
        layout = Layout(first.axes, first.period_s, tuple(first.signals))
        writer = open_writer(format_of(name, format), sink, layout)
        for chunk in chunks:
            writer.write(chunk)
            rows += len(chunk)
        writer.close()
    return rows


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
        tolerance_mm: Tolerance of every continuous motion, over what the program says.
        resolution: What positions are rounded to, mm and degrees.

    Raises:
        UsageError: Setpoints are wrong, or a file cannot be read.
        ProgramError: The program has errors.
    """
    from cncgen.verify import verify

    where = machine_of(machine)
    if isinstance(program, str | os.PathLike):
        program = read(program, options=options_on(where))
    return verify(
        _stream_of(setpoints),
        sound(program),
        where,
        tolerance_mm=tolerance_mm,
        named=program.moving_axes or None,
        resolution=resolution,
    )


def report_page(
    program: Program,
    machine: Machine | str | os.PathLike[str],
    options: PlanOptions | None = None,
    *,
    language: str | None = None,
    reading: ReadOptions | None = None,
) -> tuple[str, Diagnostics]:
    """Plan a program, judge the plan, and return the HTML page on it with the planner's remarks.

    A program from a file is read a second time for the verdict; one from standard input is not verified.
    """
    from cncgen.report.line_times import LineTimes
    from cncgen.report.page import page

    where, times = machine_of(machine), LineTimes()
    stream, summary = plan_with_summary(program, where, options, line_times=times)
    points = stream.collect()
    verdict = None
    if os.path.isfile(program.name) and len(points):
        again = read(program.name, language=language, options=options_on(where, reading))
        verdict = judge(points, again, where)
    return page(points, where, summary.as_json(), verdict, times), summary.remarks
