"""Coordinate systems: G54 to G59.3, G10, G52, G92 to G92.3.

Source: Kramer et al. (2000), sections 3.5.5, 3.5.13 and 3.5.18; G52, and G10 L20, L1, L10 and L11, as in LinuxCNC's manual.
"""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.lines import need_axis
from cncgen.gcode.codes.table import BOTH, CHANGES_OFFSETS, CHANGES_ORIGIN, CHANGES_SYSTEM, Code, Handler
from cncgen.gcode.codes.tools import known, load_tool_parameters, whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import SYSTEM_CODES, Stage, to_machine, zeros
from cncgen.gcode.state.parameters import G92, G92_ON, SYSTEM_COUNT
from cncgen.gcode.state.systems import ROTATION, first_parameter, load_system
from cncgen.machine.tool_table import Tool, tools_of

_TABLE_WORDS = AXES + "plrijq"


def use_system(ip: Interpreter, system: int) -> None:
    """Change to a system, and tell the sink."""
    if system == ip.state.system:
        ip.sink.call('COMMENT("interpreter: continuing to use same coordinate system")')
        return
    load_system(ip, system)
    ip.sink.set_g5x_offset(system, ip.state.origin)
    ip.sink.set_g92_offset(ip.state.g92)
    ip.sink.set_xy_rotation(ip.state.rotation)


def _select(system: int) -> Handler:
    return lambda ip, block: use_system(ip, system)


def numbered_system(ip: Interpreter, block: Block) -> None:
    """G54.1 P of Tormach's PathPilot, a LinuxCNC: P1 is G54, P2 is G55, and so on (PathPilot's list of codes). LinuxCNC has none."""
    number = whole(block, "p", "G54.1") if "p" in block.words else 0
    if not 1 <= number <= SYSTEM_COUNT:
        given = f"P{number}" if number else "without P"
        message = f"G54.1 {given}: the systems that are kept are P1 (G54) to P{SYSTEM_COUNT} (G59.3)"
        raise BlockError("system-number", message, "P" if number else "G54.1", hint="write G54 to G59.3")
    message = f"G54.1 P{number} is system {number}, as on Tormach's PathPilot; P1 is G54"
    ip.warn_once("other-control", message, "G54.1", "LinuxCNC itself has G54 to G59.3")
    use_system(ip, number)


def table(ip: Interpreter, block: Block) -> None:
    """G10: L2 and L20 set a coordinate system, L1, L10 and L11 a tool, L0 reads the tool table again."""
    if "l" not in block.words:
        raise BlockError("g10-words", "G10 has no L: what should be set?", "G10")
    kind = whole(block, "l", "G10")
    if kind == 0:
        # What G10 has changed is forgotten.
        ip.tools = tools_of(ip.options.tool_table, ip.options.stand_alone)
        ip.sink.call("RELOAD_TOOLDATA()")
        return
    if "p" not in block.words:
        raise BlockError("g10-words", "G10 has no P: which one should be set?", "G10")
    if kind in (2, 20):
        _set_system(ip, block, kind)
    elif kind in (1, 10, 11):
        _set_tool(ip, block, kind)
    else:
        raise BlockError("g10-words", f"L{kind} of G10: L is 0, 1, 2, 10, 11 or 20", "L")


def _set_system(ip: Interpreter, block: Block, kind: int) -> None:
    """G10 L2 P: the origin; L20: such an origin that the position gets these coordinates."""
    number = whole(block, "p", "G10")
    if not 0 <= number <= SYSTEM_COUNT:
        raise BlockError("g10-words", f"P{number} of G10: coordinate systems are 1 to {SYSTEM_COUNT}", "P")
    state, parameters = ip.state, ip.parameters
    system = number or state.system
    scale = ip.table_scale()
    origin = parameters.offset(first_parameter(system), scale)
    if "r" in block.words:
        if kind == 20:
            raise BlockError("g10-words", "G10 L20 takes no R", "R")
        parameters.numbers[first_parameter(system) + ROTATION] = block.words["r"]
    rotation = parameters.numbers[first_parameter(system) + ROTATION]
    axes = block.axes()
    if kind == 2:
        for index, value in axes:
            origin[index] = value
    else:
        machine = [m - t for m, t in zip(ip.machine_position(), state.tool_offset, strict=True)]
        wanted = _in_system(machine, origin, rotation, state.g92)
        for index, value in axes:
            wanted[index] = value
        reached = to_machine(wanted, origin, rotation, state.g92, zeros())
        for index in _touched([index for index, _ in axes], rotation):
            origin[index] += machine[index] - reached[index]
    parameters.set_offset(first_parameter(system), origin, scale)
    if system != state.system:
        ip.sink.call('COMMENT("interpreter: setting coordinate system origin")')
        return
    load_system(ip, system)
    ip.sink.set_g5x_offset(system, state.origin)
    ip.sink.set_xy_rotation(state.rotation)


def _touched(axes: list[int], rotation: float) -> list[int]:
    """Return the columns that change: X and Y together where the system is turned."""
    return sorted({*axes, 0, 1}) if rotation and not {0, 1}.isdisjoint(axes) else axes


def _in_system(machine: list[float], origin: list[float], rotation: float, g92: list[float]) -> list[float]:
    """Return coordinates in a system of a point in machine coordinates."""
    x, y, *rest = [m - o for m, o in zip(machine, origin, strict=True)]
    c, s = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))
    turned = [x * c + y * s, -x * s + y * c, *rest]
    return [t - g for t, g in zip(turned, g92, strict=True)]


def _set_tool(ip: Interpreter, block: Block, kind: int) -> None:
    """G10 L1 P: offsets of a tool; L10, L11: such ones that the position gets these coordinates."""
    number = whole(block, "p", "G10")
    tool = known(ip.tools.entry(number) if number else None, f"tool {number}", "P")
    state = ip.state
    scale = ip.table_scale()
    machine = ip.machine_position()
    origin, rotation, g92 = state.origin, state.rotation, state.g92
    if kind == 11:
        # L11 measures in G59.3, whatever system is in force.
        origin = ip.parameters.offset(first_parameter(SYSTEM_COUNT), scale)
        rotation, g92 = ip.parameters.numbers[first_parameter(SYSTEM_COUNT) + ROTATION], zeros()
    axes = block.axes()
    if kind == 1:
        for index, value in axes:
            tool.offset[index] = value / ip.scale_of(index)
    else:
        # In a turned system X and Y of the table change together: a coordinate that the block does
        # not have keeps the value that the entry of the table gives it so far.
        bare = [m - t * ip.scale_of(k) for k, (m, t) in enumerate(zip(machine, tool.offset, strict=True))]
        wanted = _in_system(bare, origin, rotation, g92)
        for index, value in axes:
            wanted[index] = value
        reached = to_machine(wanted, origin, rotation, g92, zeros())
        for index in _touched([index for index, _ in axes], rotation):
            tool.offset[index] = (machine[index] - reached[index]) / ip.scale_of(index)
    words = block.words
    if "r" in words:
        tool.diameter = words["r"] * 2.0 / scale
    tool.front, tool.back = words.get("i", tool.front), words.get("j", tool.back)
    if "q" in words:
        tool.orientation = whole(block, "q", "G10")
        if tool.orientation > 9:
            raise BlockError("tool-orientation", f"Q{tool.orientation}: a tool orientation is 0 to 9", "Q")
    _tell_tool(ip, tool, ip.tools.place_of(number))
    if number == (state.fetched if ip.options.stand_alone else state.tool):
        state.tool = number
        _tell_tool(ip, tool, 0)
        load_tool_parameters(ip)


def _tell_tool(ip: Interpreter, tool: Tool, place: int) -> None:
    """Tell that an entry of the tool table has changed (entry 0 is the tool in the spindle)."""
    offset = " ".join(f"{value:.4f}" for value in tool.offset)
    angles = f"{tool.front:.4f}, {tool.back:.4f}, {tool.orientation}"
    ip.sink.call(f"SET_TOOL_TABLE_ENTRY({place}, {tool.number}, {offset}, {angles})")


def local(ip: Interpreter, block: Block) -> None:
    """G52: set the offset on top of the coordinate system."""
    need_axis(block, "G52", "G52 X0 Y0 Z0 ends it")
    offset = ip.state.g92.copy()
    for index, value in block.axes():
        offset[index] = value
    set_g92(ip, offset)


def name_position(ip: Interpreter, block: Block) -> None:
    """G92: such an offset that the position gets these coordinates."""
    need_axis(block, "G92")
    state = ip.state
    offset = state.g92.copy()
    for index, value in block.axes():
        offset[index] += state.position[index] - value
    set_g92(ip, offset)


def place_by_hand(ip: Interpreter, block: Block, name: str, control: str) -> None:
    """G92.4 of Smoothieware (Makera's Carvera) and G28.3 of TinyG, which home axes by hand: the position has these coordinates from here on."""
    unread = (
        "; R and S, which take whole turns off on Carvera, are not" if {"r", "s"} & block.words.keys() else ""
    )
    message = (
        f"{name} tells the machine where its axes are ({control}): read as G92, for the program alone{unread}"
    )
    ip.warn_once("other-control", message, name, "write G92 for other controls")
    name_position(ip, block)


def set_g92(ip: Interpreter, offset: list[float]) -> None:
    ip.parameters.set_offset(G92, offset, ip.table_scale())
    _apply_g92(ip, offset, True)


def _apply_g92(ip: Interpreter, offset: list[float], on: bool) -> None:
    machine = ip.machine_position()
    ip.state.g92, ip.state.g92_on = offset, on
    ip.parameters.numbers[G92_ON] = float(on)
    ip.rebase(machine)
    ip.sink.set_g92_offset(offset)


def clear_position(ip: Interpreter, block: Block) -> None:
    """G92.1: no offset, and forget it."""
    ip.parameters.set_offset(G92, zeros(), 1.0)
    _apply_g92(ip, zeros(), False)


def suspend_position(ip: Interpreter, block: Block) -> None:
    """G92.2: no offset, but keep it for G92.3."""
    _apply_g92(ip, zeros(), False)


def resume_position(ip: Interpreter, block: Block) -> None:
    """G92.3: the offset that was kept."""
    _apply_g92(ip, ip.parameters.offset(G92, ip.table_scale()), True)


CODES = (
    *(
        Code("G", number, "coordinates", Stage.COORDINATES, _select(k + 1), f"work coordinate system {k + 1}",
            dialects=BOTH if k else ("linuxcnc",), refused=CHANGES_SYSTEM, restores=("system", k + 1))
        for k, number in enumerate(SYSTEM_CODES)
    ),
    Code("G", 541, "coordinates", Stage.COORDINATES, numbered_system, "work coordinate system P (PathPilot)", "p",
        dialects=("linuxcnc",), refused=CHANGES_SYSTEM),
    Code("G", 100, "non-modal", Stage.REFERENCE, table, "set a coordinate system or tool", _TABLE_WORDS, "own",
        dialects=("linuxcnc",), moves="XY", moves_with="r"),
    Code("G", 520, "non-modal", Stage.REFERENCE, local, "local coordinate system", AXES, "own", dialects=("linuxcnc",),
        refused=CHANGES_ORIGIN),
    Code("G", 920, "non-modal", Stage.REFERENCE, name_position, "name the position", AXES, "own", dialects=("linuxcnc",),
        refused=CHANGES_ORIGIN),
    *(
        Code("G", number, "non-modal", Stage.REFERENCE, partial(place_by_hand, name=f"G{number / 10:g}", control=control),
            f"name the position ({control})", AXES + "rs", "own", takes="s", dialects=("linuxcnc",), refused=CHANGES_ORIGIN)
        for number, control in ((283, "TinyG"), (924, "Smoothieware"))
    ),
    Code("G", 921, "non-modal", Stage.REFERENCE, clear_position, "forget the offset of G92", "", "own", dialects=("linuxcnc",)),
    Code("G", 922, "non-modal", Stage.REFERENCE, suspend_position, "suspend the offset of G92", "", "own", refused=CHANGES_OFFSETS,
        restores=("g92_on", False)),
    Code("G", 923, "non-modal", Stage.REFERENCE, resume_position, "take up the offset of G92", "", "own", refused=CHANGES_OFFSETS,
        restores=("g92_on", True)),
)  # fmt: skip
