"""Options of reading a program, the same for every language and every command."""

from __future__ import annotations

import os
from collections.abc import Callable

from cncgen import extensions
from cncgen.arguments import is_number, mistyped
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.records import dataclass, field

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path
    from typing import TypedDict

    from cncgen.machine.kinematics import Kinematics

DIALECTS = ("auto", *extensions.DIALECTS)
UNITS = ("auto", "mm", "inch")
SPEED_UNITS = ("m/s", "m/min")
SPINDLE_SIGNS = ("speed", "tool")


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """How a program is read.

    Attributes:
        dialect: One of `DIALECTS` (G-code only).
        units: ``mm`` or ``inch``: the unit of lengths until G20 or G21 (G70, G71) says it. ``auto``: mm, with a note where the
            program does not say it (G-code of LinuxCNC and FANUC; SINUMERIK takes mm, Heidenhain says it).
        tool_table: LinuxCNC tool table, or None.
        parameters: File of numbered parameters, read and never rewritten, or None.
        travel: Lowest and highest position of the machine's axes that are bounded, each with its letter, mm or degrees (for programs that
            ask for them).
        kinematics: How the rotary axes carry table or head (`cncgen.machine.kinematics.Kinematics`), or None.
        tips_alone: Whether a program may control the tool's point without `kinematics`: it is read as the path of the tip, which is
            no path of a machine's axes (G-code).
        least_increment: Unit of a number without a decimal point where a FANUC control is set so, mm or degrees
            (inches: a tenth of it): 0.001 reads ``X10`` as 0.01 mm. None: it counts like ``X10.``.
        fastest_spindle: Revolutions a minute that the spindle does not exceed under a constant surface speed (G96), or None.
        inch_tables: Whether lengths in the tool table and the parameter file are inches (else mm).
        stand_alone: Whether the machine is the imaginary one of LinuxCNC's stand-alone interpreter (`cncgen.gcode.sinks.standalone`),
            as for the calls that `canon` prints.
        tool_tips: Whether positions are those of the tools' tips: offsets of tools (G43) are left out of them (G-code).
        workingsteps: Whether the beginning of each workingstep is an event, with its raw piece (STEP-NC).
        save_parameters: Where to write the parameters after the program, or None.
        include: Directories searched for subprograms, after the program's own.
        block_delete: Whether blocks that begin with ``/`` are skipped.
        speed_unit: ``m/s`` or ``m/min``: the unit of cutting speeds of ISO 14649 (the standard: m/s; some writers: m/min, and their
            cutting speeds count before their spindle speeds).
        spindle_sign: ``speed`` or ``tool``: whether the sign of a spindle speed of STEP-NC tells the sense of rotation, or
            the hand of the tool (for writers that give speeds without a sign).
        max_steps: Blocks executed before a program counts as endless. None: as much work as takes some seconds
            (`cncgen.gcode.budget`), and more for each line of its text.
        max_call_depth: Nested subprogram calls before recursion counts as endless.
        chunk_rows: Motions handed on at a time: the number that waits at each stage, on which the first setpoint waits too.
        tolerance_mm: Tolerance of G64 that overrides the program's, or None.
    """

    dialect: str = "auto"
    units: str = "auto"
    tool_table: Path | None = None
    parameters: Path | None = None
    inch_tables: bool = False
    stand_alone: bool = False
    tool_tips: bool = False
    workingsteps: bool = False
    tips_alone: bool = False
    least_increment: float | None = None
    fastest_spindle: float | None = None
    kinematics: Kinematics | None = None
    travel: tuple[tuple[str, float, float], ...] = ()
    save_parameters: Path | None = None
    include: tuple[Path, ...] = field(default=())
    block_delete: bool = True
    speed_unit: str = "m/s"
    spindle_sign: str = "speed"
    max_steps: int | None = None
    max_call_depth: int = 100
    chunk_rows: int = 16_384
    tolerance_mm: float | None = None

    def check(self) -> None:
        """Raise `UsageError` that names every option whose value is not one of those it may have."""
        kinds = ReadOptions.__annotations__
        faults = mistyped({name: getattr(self, name) for name in kinds}, kinds) or [
            Diagnostic("option-value", f"{name} = {getattr(self, name)!r} is not {wanted}{_brought(name)}")
            for names, holds, wanted in _RULES
            for name in names
            if not holds(getattr(self, name))
        ]
        if faults:
            raise UsageError(faults)


def _brought(name: str) -> str:
    """Return what packages add to the values of an option that are named: dialects."""
    names = extensions.foreign_names(extensions.DIALECT_GROUP) if name == "dialect" else ()
    return "".join(f", {each}" for each in names)


def _is_count(value: object) -> bool:
    return is_number(value) and hasattr(value, "__index__") and value.__index__() > 0


def _is_count_or_none(value: object) -> bool:
    return value is None or _is_count(value)


def _is_positive_or_none(value: object) -> bool:
    return value is None or (is_number(value) and value > 0.0)


def _is_file_or_none(value: object) -> bool:
    return isinstance(value, str | os.PathLike | None)


def _are_folders(value: object) -> bool:
    return isinstance(value, tuple | list) and all(isinstance(folder, str | os.PathLike) for folder in value)


def _is_of(choices: tuple[str, ...]) -> tuple[Callable[[object], bool], str]:
    return choices.__contains__, f"one of {', '.join(choices)}"


#: Options with what tells a right value, and what that is.
_RULES: tuple[tuple[tuple[str, ...], Callable[[object], bool], str], ...] = (
    (("dialect",), *_is_of(DIALECTS)),
    (("units",), *_is_of(UNITS)),
    (("speed_unit",), *_is_of(SPEED_UNITS)),
    (("spindle_sign",), *_is_of(SPINDLE_SIGNS)),
    (("tool_table", "parameters", "save_parameters"), _is_file_or_none, "the name of a file"),
    (("include",), _are_folders, "a sequence of names of folders"),
    (("max_call_depth", "chunk_rows"), _is_count, "a whole number greater than 0"),
    (("max_steps",), _is_count_or_none, "a whole number greater than 0"),
    (
        ("least_increment", "fastest_spindle", "tolerance_mm"),
        _is_positive_or_none,
        "a number greater than 0",
    ),
)


if TYPE_CHECKING:

    class ReadWords(TypedDict, total=False):
        """The fields of `ReadOptions` as keywords, for type checkers."""

        dialect: str
        units: str
        tool_table: Path | None
        parameters: Path | None
        inch_tables: bool
        stand_alone: bool
        tool_tips: bool
        workingsteps: bool
        tips_alone: bool
        least_increment: float | None
        fastest_spindle: float | None
        kinematics: Kinematics | None
        travel: tuple[tuple[str, float, float], ...]
        save_parameters: Path | None
        include: tuple[Path, ...]
        block_delete: bool
        speed_unit: str
        spindle_sign: str
        max_steps: int | None
        max_call_depth: int
        chunk_rows: int
        tolerance_mm: float | None
