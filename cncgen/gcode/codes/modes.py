"""Modes that only change how later blocks are read: plane, units, distance, path, retraction.

Source: Kramer et al. (2000), sections 3.5.6, 3.5.7, 3.5.14, 3.5.17 and 3.5.20; P and Q of G64 as in LinuxCNC's manual.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import CHANGES_PATH_MODE, CHANGES_UNITS, STRICT_COMPENSATION, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import LENGTHS, PLANE_CODES, Stage
from cncgen.gcode.text import signs
from cncgen.gcode.text.built_patterns import compiled
from cncgen.toolpath.record import PathMode
from cncgen.units import INCH

#: No path tolerance of a part is meant to be wider, mm.
_WIDE_MM = 10.0


def _plane(ip: Interpreter, block: Block, number: int) -> None:
    ip.state.plane = number
    ip.sink.select_plane(number)


def _units(ip: Interpreter, block: Block, inches: bool) -> None:
    ip.sink.use_length_units(inches)
    state = ip.state
    used = state.moved or ip.parameters.shifted
    late = used and not ip.units_said and ip.options.units == "auto" and state.inches != inches
    first = _first_length(ip, block) if late else 0
    # Ways to the reference point, and coordinates of 0, are the same in both units.
    if late and (first or ip.parameters.shifted or any(state.position[index] for index in LENGTHS)):
        since = f", from line {first} on," if first else ""
        message = f"lengths before the first G20 or G21 of the run{since} are taken as mm, and those behind it are inches"
        hint = "write G20 before the first length, or --units inch"
        if not state.moved:
            hint += ", which is likelier here: they are origins and offsets alone, of a machine that is in inches already"
        ip.warn("units-doubtful", message, "G20", hint)
    ip.units_said = True
    if state.inches != inches:
        state.inches = inches
        factor = 1.0 / INCH if inches else INCH
        vectors = [state.position, state.origin, state.g92, state.local]
        if not ip.options.stand_alone:
            vectors.append(state.tool_offset)
        for vector in vectors:
            for index in LENGTHS:
                vector[index] *= factor


def is_unit(ip: Interpreter, block: Block, name: str, unit: int) -> bool:
    """Take G70 or G71 without words as inches or millimetres, and say so: Mach, Hurco, Siemens and DIN 66025 have them, as a cycle they lack all.

    With the dialect linuxcnc named they are refused, as its own interpreter refuses them.
    """
    if block.words or ip.options.stand_alone or ip.options.dialect == "linuxcnc":
        return False
    lengths = "inches" if unit == 200 else "millimetres"
    message = f"{name} without words is taken as the unit of lengths, {lengths}, as Mach, Hurco, Siemens and DIN 66025 have it"
    ip.warn("other-control", message, name, f"write G{unit // 10}")
    ip.codes["G", unit].run(ip, block)
    return True


def _first_length(ip: Interpreter, block: Block) -> int:
    """Return the line of the first length other than 0 above a block of the main program, 0 where there is none."""
    if ip.flow is None or block.source != 0:
        return 0
    above = compiled(signs.OUT_OF_CODE).sub(b"", ip.flow.subroutines.sources[0].data[: block.offset])
    lengths = compiled(signs.LENGTH).finditer(above)
    first = next((length for length in lengths if float(length["number"])), None)
    return above.count(b"\n", 0, first.start()) + 1 if first else 0


def _distance(ip: Interpreter, block: Block, mode: str, absolute: bool) -> None:
    name, said = ("arc_absolute", "IJK distance") if mode == "arc distance" else ("absolute", "distance")
    kind = "absolute" if absolute else "incremental"
    if getattr(ip.state, name) != absolute:
        setattr(ip.state, name, absolute)
        ip.sink.call(f'COMMENT("interpreter: {said} mode changed to {kind}")')


def _path(ip: Interpreter, block: Block, mode: PathMode) -> None:
    """G61, G61.1; and G62 and G63 of FANUC: continuous, with the machine's tolerance; their overrides are not modelled."""
    ip.state.path_mode, ip.state.tolerance = mode, None
    ip.sink.set_motion_control_mode(mode, None, None)


def continuous(ip: Interpreter, block: Block) -> None:
    """G64: P is the path tolerance, Q that of joining collinear lines (default: P)."""
    tolerance, naive = block.words.get("p"), block.words.get("q")
    for letter, value in (("P", tolerance), ("Q", naive)):
        if value is not None and value < 0.0:
            raise BlockError("negative-tolerance", f"{letter}{value:g} of G64 is negative", letter)
    state = ip.state
    wide = (tolerance or 0.0) * state.unit_mm
    if wide > _WIDE_MM:
        message = f"G64 P{tolerance:g} lets the motion be {wide:g} mm off the programmed path"
        ip.warn_once(
            "tolerance-wide", message, "P", "P is a length in the unit of the program, as in G64 P0.01"
        )
    state.path_mode, state.tolerance = PathMode.CONTINUOUS, tolerance
    state.naive = tolerance if naive is None else naive
    ip.sink.set_motion_control_mode(PathMode.CONTINUOUS, tolerance, naive)


def stop_once(ip: Interpreter, block: Block) -> None:
    """G9 of FANUC: stop exactly at the end of this block."""
    ip.sink.set_motion_control_mode(PathMode.EXACT_STOP, None, None)


def go_on(ip: Interpreter, block: Block) -> None:
    """Take up the path mode in force after G9."""
    state = ip.state
    ip.sink.set_motion_control_mode(state.path_mode, state.tolerance, state.naive)


@contextmanager
def stopping(ip: Interpreter) -> Iterator[None]:
    """Stop exactly at the end of each motion, as where the spindle turns back with a tap; then take up the path mode in force."""
    ip.sink.set_motion_control_mode(PathMode.EXACT_STOP, None, None)
    yield
    ip.sink.set_motion_control_mode(ip.state.path_mode, ip.state.tolerance, ip.state.naive)


def _retract(ip: Interpreter, block: Block, old: bool) -> None:
    ip.state.retract_old = old
    ip.sink.call(f'COMMENT("interpreter: retract mode set to {"old_z" if old else "r_plane"}")')


_RETRACTS = ("changes how canned cycles retract", STRICT_COMPENSATION)
CODES = (
    *(
        Code("G", number, "plane", Stage.PLANE, partial(_plane, number=plane), f"plane {name}", plane=plane,
            restores=("plane", plane))
        for (number, plane), name in zip(
            PLANE_CODES.items(), ("XY", "ZX", "YZ", "UV", "WU", "VW"), strict=True
        )
    ),
    Code("G", 200, "units", Stage.UNITS, partial(_units, inches=True), "lengths in inches", refused=CHANGES_UNITS,
        restores=("inches", True)),
    Code("G", 210, "units", Stage.UNITS, partial(_units, inches=False), "lengths in millimetres", refused=CHANGES_UNITS,
        restores=("inches", False)),
    Code("G", 900, "distance", Stage.DISTANCE, partial(_distance, mode="distance", absolute=True), "axis words are coordinates",
        waits=True, without="lathes", restores=("absolute", True)),
    Code("G", 910, "distance", Stage.DISTANCE, partial(_distance, mode="distance", absolute=False),
        "axis words are distances from the last point", waits=True, without="lathes", restores=("absolute", False)),
    Code("G", 901, "arc distance", Stage.DISTANCE, partial(_distance, mode="arc distance", absolute=True), "I J K are coordinates",
        restores=("arc_absolute", True)),
    Code("G", 911, "arc distance", Stage.DISTANCE, partial(_distance, mode="arc distance", absolute=False),
        "I J K are distances from the start", restores=("arc_absolute", False)),
    Code("G", 610, "path", Stage.PATH, partial(_path, mode=PathMode.EXACT_PATH), "exact path", dialects=("linuxcnc",), waits=True,
        refused=CHANGES_PATH_MODE, restores=("path", PathMode.EXACT_PATH)),
    Code("G", 611, "path", Stage.PATH, partial(_path, mode=PathMode.EXACT_STOP), "exact stop at the end of each motion",
        dialects=("linuxcnc",), refused=CHANGES_PATH_MODE, restores=("path", PathMode.EXACT_STOP)),
    Code("G", 610, "path", Stage.PATH, partial(_path, mode=PathMode.EXACT_STOP), "exact stop at the end of each motion",
        dialects=("fanuc",)),
    Code("G", 620, "path", Stage.PATH, partial(_path, mode=PathMode.CONTINUOUS), "automatic corner override: as G64", dialects=("fanuc",)),
    Code("G", 630, "path", Stage.PATH, partial(_path, mode=PathMode.CONTINUOUS), "tapping mode: as G64", dialects=("fanuc",),
        pitched=True),
    Code("G", 90, "exact stop", Stage.PATH, stop_once, "exact stop at the end of this block", dialects=("fanuc",), after=go_on),
    Code("G", 640, "path", Stage.PATH, continuous, "continuous path within P", "pq", waits=True, refused=CHANGES_PATH_MODE,
        restores=("path", PathMode.CONTINUOUS)),
    Code("G", 980, "retract", Stage.RETRACT, partial(_retract, old=True), "canned cycles retract to where they began", waits=True,
        refused=_RETRACTS, without="lathes", restores=("retract_old", True)),
    Code("G", 990, "retract", Stage.RETRACT, partial(_retract, old=False), "canned cycles retract to R", waits=True,
        refused=_RETRACTS, without="lathes", restores=("retract_old", False)),
)  # fmt: skip
