"""Options of reading a program, the same for every language and every command."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """How a program is read.

    Attributes:
        dialect: ``auto``, ``linuxcnc`` or ``fanuc`` (G-code only).
        tool_table: LinuxCNC tool table, or None.
        parameters: File of numbered parameters, read and never rewritten, or None.
        kinematics: How the rotary axes carry table or head (`cncgen.gcode.kinematics.Kinematics`), or None.
        least_increment: What a number without a decimal point counts in where a FANUC control is set so, mm or degrees
            (inches: a tenth of it): 0.001 reads ``X10`` as 0.01 mm. None: it counts like ``X10.``.
        inch_tables: Whether lengths in the tool table and the parameter file are inches (else mm).
        stand_alone: Whether the machine is the one that LinuxCNC's stand-alone interpreter makes believe
            (`cncgen.gcode.standalone`); so are the calls that `canon` prints.
        save_parameters: Where to write the parameters after the program, or None.
        include: Directories searched for subprograms, after the program's own.
        block_delete: Whether blocks that begin with ``/`` are skipped.
        speed_unit: ``m/s`` or ``m/min``: what cutting speeds of ISO 14649 are in (the standard: m/s; some writers: m/min,
            and their cutting speeds count before their spindle speeds).
        spindle_sign: ``speed`` or ``tool``: whether the sign of a spindle speed of STEP-NC tells the sense of rotation, or
            the hand of the tool (for writers that give speeds without a sign).
        max_steps: Blocks executed before a program counts as endless.
        max_call_depth: Nested subprogram calls before recursion counts as endless.
        chunk_rows: Motions handed on at a time.
        tolerance_mm: Tolerance of G64 that overrides the program's, or None.
    """

    dialect: str = "auto"
    tool_table: Path | None = None
    parameters: Path | None = None
    inch_tables: bool = False
    stand_alone: bool = False
    least_increment: float | None = None
    kinematics: Any = None
    save_parameters: Path | None = None
    include: tuple[Path, ...] = field(default=())
    block_delete: bool = True
    speed_unit: str = "m/s"
    spindle_sign: str = "speed"
    max_steps: int = 50_000_000
    max_call_depth: int = 100
    chunk_rows: int = 65_536
    tolerance_mm: float | None = None
