"""Coordinate systems and tool data of FANUC: G54.1, G10 and G11, G52, G92 and G92.1 (B-63324EN, 7.2, 7.3, 14.4)."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.lines import need_axis
from cncgen.gcode.codes.offsets import set_g92, use_system
from cncgen.gcode.codes.spindle import bound_surface_speed
from cncgen.gcode.codes.table import CHANGES_OFFSETS, CHANGES_ORIGIN, CHANGES_SYSTEM, OF_FANUC, Code
from cncgen.gcode.codes.tools import known, whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.state.systems import EXTERNAL, MORE_COUNT, SYSTEM_COUNT, first_parameter, load_system

#: Data of G10 L that have no use without the control.
_DATA = {3: "tool life data", 50: "parameters of the control", 52: "parameters of the control"}
FIRST_SYSTEM = 540
#: The column of U, that of X farther on.
_U = 6
_KINDS = "L2 P1 to P6 set G54 to G59, L20 P sets G54.1 P, L10 to L13 P R set a tool's length, its wear, radius, its wear"


def use_additional(ip: Interpreter, block: Block) -> None:
    """G54.1 P, which may be written G54 P."""
    number = whole(block, "p", "G54.1") if "p" in block.words else 1
    if not 1 <= number <= MORE_COUNT:
        message = f"G54.1 P{number}: additional coordinate systems are P1 to P{MORE_COUNT}"
        hint = f"the additional systems are G54.1 P1 to P{MORE_COUNT}"
        raise BlockError("system-number", message, "P", hint=hint)
    use_system(ip, SYSTEM_COUNT + number)


#: Systems of Haas's mills whose codes, G112 and G113, are others on lathes.
_POLAR_ON_LATHES = (3, 4)


def _of_haas(ip: Interpreter, block: Block, number: int) -> None:
    """G110 to G129 of Haas's mills, which are G154 P1 to P20."""
    if number in _POLAR_ON_LATHES:
        name = f"G{109 + number}"
        message = f"{name} is the coordinate system G154 P{number}, as on Haas's mills; on lathes it is polar coordinate interpolation"
        hint = "G12.1 and G13.1 are polar coordinate interpolation on mills"
        ip.warn_once("other-control", message, name, hint)
    use_system(ip, SYSTEM_COUNT + number)


def first_system(ip: Interpreter, block: Block) -> None:
    """G54; with a P that no other G code of the block takes (``G54 G82 Z-5. R2. P200``) it is G54.1."""
    if "p" not in block.words:
        use_system(ip, 1)
        return
    taker = next(
        (ip.codes["G", n] for n in block.g if n != FIRST_SYSTEM and "p" in ip.codes["G", n].words), None
    )
    if taker is None:
        use_additional(ip, block)
        return
    message = f"P{block.words['p']:g} is taken as that of {taker.name}, and G54 has none"
    ip.warn_once("system-number", message, "P", "an additional system is G54.1 P, in a block before")
    use_system(ip, 1)


def set_data(ip: Interpreter, block: Block) -> None:
    """G10: L2 P sets G54 to G59 or (P0) the shift of them all, L20 P sets G54.1 P, L10 to L13 (L1 is L11) a tool.

    L50 and other data of the control begin a table that G11 ends.
    """
    if "l" not in block.words:
        raise BlockError("g10-words", "G10 has no L: what should be set?", "G10", hint=_KINDS)
    kind = whole(block, "l", "G10")
    if kind in _DATA:
        _begin_data(ip, kind)
        return
    if kind not in (1, 2, 10, 11, 12, 13, 20):
        message = f"L{kind} of G10: L is 1, 2, 3, 10 to 13, 20, 50 or 52"
        raise BlockError("g10-words", message, "L", hint=_KINDS)
    if "p" not in block.words:
        raise BlockError("g10-words", "G10 has no P: which one should be set?", "G10", hint=_KINDS)
    number = whole(block, "p", "G10")
    taken = AXES.lower() if kind in (2, 20) else "r"
    idle = next(
        (letter.upper() for letter in block.words if letter in AXES.lower() + "rq" and letter not in taken),
        "",
    )
    if idle:
        hint = (
            "L2 and L20 have axis words, and turn nothing: G68 does"
            if kind in (2, 20)
            else "R is the value; L2 and L20 have axis words"
        )
        raise BlockError("g10-words", f"{idle} of G10 L{kind}, which has no use for it", idle, hint=hint)
    if kind in (2, 20):
        first, last = (1, MORE_COUNT) if kind == 20 else (0, 6)
        if not first <= number <= last:
            message = f"P{number} of G10 L{kind}: coordinate systems are {first} to {last}"
            raise BlockError("g10-words", message, "P", hint="P1 is G54; those of G54.1 are set by L20")
        _set_origin(ip, block, number + (SYSTEM_COUNT if kind == 20 else 0))
    else:
        _set_tool(ip, block, 11 if kind == 1 else kind, number)


def _begin_data(ip: Interpreter, kind: int) -> None:
    """Skip the blocks up to G11: they set data that this machine lacks."""
    message = f"G10 L{kind} sets {_DATA[kind]}: passed over up to G11"
    ip.note_once("control-data", message, "G10", "the machine file says what cncgen knows of the machine")
    ip.skipping = True


def end_data(ip: Interpreter, block: Block) -> None:
    """G11: the end of G10's data."""
    ip.skipping = False


def _set_tool(ip: Interpreter, block: Block, kind: int, number: int) -> None:
    """G10 L10 and L11: length and its wear; L12 and L13: radius and its wear; incremental ones are added."""
    if "r" not in block.words:
        message = f"G10 L{kind} has no value R"
        raise BlockError("g10-words", message, "G10", hint=f"G10 L{kind} P{number} R and the value")
    hint = "the tools are those of the file that --tool-table names"
    tool = known(ip.tools.entry(number), f"tool {number}", "P", hint)
    value = block.words["r"] / ip.table_scale()
    what, is_wear = divmod(kind - 10, 2)
    if what and value:
        message = "R of G10 L12 and L13 is taken as a radius; the control may count it as a diameter"
        hint = "setting 40 of Haas and parameter 5004 bit 2 of FANUC decide it"
        ip.note_once("offset-radius", message, "R", hint)
    sums = [tool.offset[2], tool.diameter / 2.0]
    geometry, wear = sums[what] - tool.wear[what], tool.wear[what]
    if is_wear:
        wear = value if ip.state.absolute else wear + value
    else:
        geometry = value if ip.state.absolute else geometry + value
    tool.wear[what] = wear
    if what == 0:
        tool.offset[2] = geometry + wear
    else:
        tool.diameter = 2.0 * (geometry + wear)


def _set_origin(ip: Interpreter, block: Block, system: int) -> None:
    """Set an origin, or shift it in incremental mode; the machine stays where it is. U V W of lathes shift it, U by a diameter."""
    scale = ip.table_scale()
    first = first_parameter(system) if system else EXTERNAL
    origin = ip.parameters.offset(first, scale)
    for index, value in block.axes():
        axis = index % _U if ip.lathe else index
        shift = value if index == axis or axis else 0.5 * value
        origin[axis] = value if index == axis and ip.state.absolute else origin[axis] + shift
    ip.parameters.set_offset(first, origin, scale)
    if system in (0, ip.state.system):
        system = ip.state.system
        load_system(ip, system)
        ip.sink.set_g5x_offset(system, ip.state.origin)


def local(ip: Interpreter, block: Block) -> None:
    """G52: a local system within the work coordinate systems, beside the shift of G92."""
    need_axis(block, "G52", "G52 X0 Y0 Z0 ends it")
    state = ip.state
    offset = state.g92.copy()
    for index, value in block.axes():
        offset[index] += value - state.local[index]
        state.local[index] = value
    set_g92(ip, offset)


def preset_position(ip: Interpreter, block: Block, name: str) -> None:
    """G92, which lathes call G50: all work coordinate systems move so that the position gets these coordinates; the local system ends.

    Without axes, S is the largest speed in G96.
    """
    state = ip.state
    axes = block.axes()
    if "s" in block.words:
        limit = block.words["s"]
        if limit < 0.0:
            message = f"S{limit:g} of {name} is negative"
            raise BlockError("negative-speed", message, "S", hint="it is the largest speed")
        state.speed_limit = limit
        if state.constant_surface is not None:
            bound_surface_speed(ip, limit)
    else:
        need_axis(block, name, f"{name} X0 names the position X0")
    offset = state.g92.copy()
    for index, value in axes:
        offset[index] += state.position[index] - value
        state.local[index] = 0.0
    if axes:
        set_g92(ip, offset)


def preset(ip: Interpreter, block: Block) -> None:
    """G92.1: remove the shifts of G92 and G52, in the axes of the block or in all."""
    state = ip.state
    offset = state.g92.copy()
    for index in [index for index, _ in block.axes()] or range(len(AXES)):
        offset[index] = state.local[index] = 0.0
    set_g92(ip, offset)


CODES = (
    Code("G", FIRST_SYSTEM, "coordinates", Stage.COORDINATES, first_system, "work coordinate system 1; with P as G54.1", "p",
        dialects=OF_FANUC, refused=CHANGES_SYSTEM),
    Code("G", 541, "coordinates", Stage.COORDINATES, use_additional, "additional system P", "p", dialects=OF_FANUC,
        refused=CHANGES_SYSTEM),
    Code("G", 1540, "coordinates", Stage.COORDINATES, use_additional, "additional system P (Haas)", "p", dialects=OF_FANUC,
        refused=CHANGES_SYSTEM),
    Code("G", 100, "non-modal", Stage.REFERENCE, set_data, "set a coordinate system, or a tool's length or radius", AXES + "lprq",
        "own", dialects=OF_FANUC, refused=CHANGES_OFFSETS, without="lathes"),
    Code("G", 110, "non-modal", Stage.REFERENCE, end_data, "end of the data of G10", dialects=OF_FANUC),
    Code("G", 520, "non-modal", Stage.REFERENCE, local, "local coordinate system", AXES, "own", dialects=OF_FANUC,
        refused=CHANGES_ORIGIN),
    Code("G", 920, "non-modal", Stage.REFERENCE, partial(preset_position, name="G92"), "name the position; S is the largest speed of G96", AXES + "s",
        "own", dialects=OF_FANUC, takes="s", refused=CHANGES_ORIGIN, without="lathes"),
    Code("G", 921, "non-modal", Stage.REFERENCE, preset, "forget the offsets of G92 and G52, of the axes given", AXES, "own",
        dialects=OF_FANUC, refused=CHANGES_OFFSETS),
    *(
        Code("G", 10 * (109 + n), "coordinates", Stage.COORDINATES, partial(_of_haas, number=n), f"additional system {n} (Haas)",
            dialects=OF_FANUC, refused=CHANGES_SYSTEM, without="lathes" * (n in _POLAR_ON_LATHES))
        for n in range(1, 21)
    ),
)  # fmt: skip
