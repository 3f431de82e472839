"""An example program, planned and sampled: the start of the tables and figures of the papers."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from cncgen import gcode
from cncgen.diagnostics import Diagnostic, ProgramError, UsageError
from cncgen.machine import load_machine
from cncgen.machine.record import Machine, Servo
from cncgen.planner import PlanOptions, plan
from cncgen.planner.record import Trajectory
from cncgen.servo.record import Response
from cncgen.servo.simulate import simulate
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.sampling import sample
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]


#: Where the example programs are: beside the modules of an installed package, else in the checkout.
_PROGRAMS = (
    Path(__file__).resolve().parents[1] / "programs",
    Path(__file__).resolve().parents[2] / "programs",
)


@dataclass(frozen=True, slots=True)
class PlannedProgram:
    """A program with its plan and setpoints, as whole lists (the papers' curves are short)."""

    machine: Machine
    toolpaths: tuple[Toolpath, ...]
    trajectories: tuple[Trajectory, ...]
    setpoints: tuple[Setpoints, ...]

    @property
    def servos(self) -> dict[str, Servo]:
        """Servo data by axis."""
        return {k: axis.servo for k, axis in self.machine.axes.items() if axis.servo is not None}

    @property
    def time_s(self) -> float:
        """Time from the first to the last setpoint."""
        last = self.setpoints[-1]
        return (last.first + len(last) - 1) * last.period_s

    @property
    def corners(self) -> int:
        """Number of sharp corners that the planner found."""
        return sum(len(t.corners) for t in self.trajectories)

    def signal(self, name: str) -> Floats:
        """Return a signal of the setpoints as one array; ``position`` too."""
        get: Callable[[Setpoints], Floats] = (
            (lambda c: c.position) if name == "position" else (lambda c: c.signals[name])
        )
        return np.concatenate([get(chunk) for chunk in self.setpoints])

    def response(self) -> list[Response]:
        """Return the response of the machine's servo axes to the setpoints."""
        return list(simulate(iter(self.setpoints), self.servos))


def planned_program(
    name: str,
    machine_name: str,
    programs: str | None = None,
    feed_mm_min: float | None = None,
    options: PlanOptions | None = None,
    acceleration_mm_s2: float | None = None,
) -> PlannedProgram:
    """Plan an example program.

    Args:
        name: File name of the program.
        machine_name: Profile of the machine.
        programs: Folder of the programs; None: looked for.
        feed_mm_min: Stands in for the program's first F.
        options: How it is planned.
        acceleration_mm_s2: Stands in for the limit of every axis.

    Raises:
        UsageError: The program is not found.
        ProgramError: It has errors.
    """
    text = program_text(name, programs)
    if feed_mm_min is not None:
        text = with_feed(text, feed_mm_min)
    return planned_text(text, name, machine_name, options, acceleration_mm_s2)


def planned_text(
    text: bytes,
    name: str,
    machine_name: str,
    options: PlanOptions | None = None,
    acceleration_mm_s2: float | None = None,
) -> PlannedProgram:
    """Plan a program that is given as text; `planned_program` says the rest.

    Raises:
        ProgramError: It has errors.
    """
    machine = _changed(load_machine(machine_name), options, acceleration_mm_s2)
    program = gcode.read(io.BytesIO(text), name, ReadOptions())
    toolpaths = tuple(program.chunks())
    if program.diagnostics.has_errors:
        raise ProgramError(program.diagnostics)
    trajectories = tuple(plan(iter(toolpaths), machine, options))
    signals = ("vel", "acc", "jerk", "feed")
    setpoints = tuple(sample(iter(trajectories), machine, axes=program.moving_axes, signals=signals))
    return PlannedProgram(machine, toolpaths, trajectories, setpoints)


def _changed(machine: Machine, options: PlanOptions | None, acceleration_mm_s2: float | None) -> Machine:
    """Return the machine with the servo data of the options for simulation, and another acceleration."""
    given = (options.servos if options else None) or {}
    axes = {
        k: replace(
            axis,
            servo=given.get(k, axis.servo),
            max_acceleration=acceleration_mm_s2 or axis.max_acceleration,
        )
        for k, axis in machine.axes.items()
    }
    return replace(machine, axes=MappingProxyType(axes))


def with_feed(text: bytes, feed_mm_min: float) -> bytes:
    """Return a program with another feed in the place of its first F word outside comments."""
    import re

    lines = text.split(b"\n")
    for i, line in enumerate(lines):
        if not line.lstrip().startswith(b"(") and re.search(rb"F[0-9.]+", line):
            lines[i] = re.sub(rb"F[0-9.]+", f"F{feed_mm_min:g}".encode(), line, count=1)
            break
    return b"\n".join(lines)


def program_text(name: str, programs: str | None) -> bytes:
    """Return an example program: from the given folder, else the shipped one.

    Raises:
        UsageError: It is not there (``reproduce-programs``).
    """
    folders = [Path(programs)] if programs else _PROGRAMS
    for folder in folders:
        path = folder / name
        if path.is_file():
            return path.read_bytes()
    raise UsageError(
        Diagnostic(
            "reproduce-programs",
            f"{name} is not in {' or '.join(str(f) for f in folders)}",
            hint="give the folder of the example programs: --programs DIR",
        )
    )
