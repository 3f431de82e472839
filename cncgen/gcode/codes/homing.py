"""G28 and G30: to the reference points, by way of the point in the block; G28.1 and G30.1 set them; G29 leads back.

Source: Kramer et al. (2000), section 3.5.8; G28.1 and G30.1 as in LinuxCNC's manual.
"""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.lines import has_axis, need_axis
from cncgen.gcode.codes.table import (
    COMPENSATION,
    GOES_HOME,
    IS_CYCLE,
    LATHE,
    OF_FANUC,
    OF_LINUXCNC,
    ROTARY_PATH,
    TOOL_POINT,
    Code,
)
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.state.parameters import HOME_28, HOME_30

#: FANUC's parameters of the reference points of G30.
_OTHERS = {2.0: 1241, 3.0: 1242, 4.0: 1243}


def _go(ip: Interpreter, block: Block, first: int) -> None:
    axes = {index for index, _ in block.axes()} if has_axis(block) else set(range(len(AXES)))
    _by_way(ip, block, axes, first)


def _by_way(ip: Interpreter, block: Block, axes: set[int], first: int) -> None:
    """Traverse to the point in the block, then these axes to the reference point that begins at a parameter.

    In a rotated coordinate system the axes are the machine's on a FANUC control, the program's in LinuxCNC.
    """
    between = ip.end_point(block)
    ip.go(between, rapid=True)
    home = ip.parameters.offset(first, ip.table_scale())
    if ip.dialect == "fanuc":
        machine = ip.machine_position()
        end = ip.from_machine([home[k] if k in axes else value for k, value in enumerate(machine)])
    else:
        end = [home_k if k in axes else between[k] for k, home_k in enumerate(ip.from_machine(home))]
    ip.go(end, rapid=True)


def _set(ip: Interpreter, block: Block, first: int) -> None:
    name = "G28.1" if first == HOME_28 else "G30.1"
    if has_axis(block):
        message = f"{name} stores where the machine stands, and its axis words are a move behind; Mach's {name} homes these axes"
        ip.warn_once("other-control", message, name, f"write {name} in a block of its own")
    ip.parameters.set_offset(first, ip.machine_position(), ip.table_scale())


def other_point(ip: Interpreter, block: Block) -> None:
    """G30 P of FANUC: the axes of the block to the second reference point; the third and fourth are taken to be there, too."""
    number = block.words.get("p", 2.0)
    if number not in _OTHERS:
        message = f"P{number:g} of G30 is no reference point: P2, P3 and P4 are"
        raise BlockError("reference-point", message, "P", hint="G30 P2 Z0 leads to the second one")
    _named_axes(ip, block, "G30", HOME_30)
    known = any(ip.parameters.offset(HOME_30, 1.0))
    if number == 2.0 and known:
        return
    place = "that of the second" if known else "machine zero"
    message = f"the place of reference point {number:g} is not known: it is taken to be {place}"
    hint = f"#{HOME_30} and after of --parameters have that of the second; the control has it in its parameter {_OTHERS[number]}"
    tell = ip.note_once if number == 2.0 else ip.warn_once
    tell("reference-point", message, "P" if "p" in block.words else "G30", hint)


def _named_axes(ip: Interpreter, block: Block, name: str, first: int) -> None:
    """G28 of FANUC: the axes of the block to the first reference point."""
    axes = {index for index, _ in block.axes()}
    if not axes:
        if name != "G28":
            need_axis(block, name, f"G91 {name} Z0 moves Z alone")
        message = "G28 without an axis word sends all axes, as on Haas's controls; FANUC's do not take it"
        ip.warn_once("axis-missing", message, name, "G91 G28 Z0 moves Z alone")
        axes = {0, 2} if ip.lathe else set(range(len(AXES)))
    ip.state.between = ip.end_point(block)
    _by_way(ip, block, axes, first)


def from_reference(ip: Interpreter, block: Block) -> None:
    """G29 of FANUC: the axes of the block to the point where the last G28 or G30 went by, and on to their words."""
    state = ip.state
    if state.between is None:
        message = "G29 with no G28 or G30 before it: the point on its way is not known"
        raise BlockError("reference-point", message, "G29", hint="use G0")
    need_axis(block, "G29", "G29 X10 leads X back to 10")
    between, end = state.position.copy(), state.position.copy()
    for index, value in block.axes():
        between[index] = state.between[index]
        end[index] = value if state.absolute else between[index] + value
    for point in (between, end):
        ip.go(point, rapid=True)


def from_one_side(ip: Interpreter, block: Block) -> None:
    """G60: traverse to the axis words, in a canned cycle to its hole; the way by which the control comes from one side (parameter 5440)
    is not made.
    """
    message = "G60 goes straight to its place: the overrun of parameter 5440 is not made"
    ip.note_once("reference-point", message, "G60", "it takes a few millimetres more")
    modal = ip.codes.row("G", ip.state.motion)
    if modal is not None and modal.refused == IS_CYCLE and has_axis(block):
        modal.run(ip, block)
    else:
        _placed(ip, block, "G60")


def _placed(ip: Interpreter, block: Block, name: str) -> None:
    """Traverse to the axis words once, whatever motion is in force.

    By G27 the control looks whether the axes stand at reference point 1 there.
    """
    need_axis(block, name, f"{name} X0 Y0")
    ip.go(ip.end_point(block), rapid=True)


_SETS_HOME = ("sets a reference point", COMPENSATION | ROTARY_PATH | TOOL_POINT)
CODES = (
    Code("G", 280, "non-modal", Stage.REFERENCE, partial(_go, first=HOME_28), "to reference point 1", AXES, "own",
        dialects=OF_LINUXCNC, moves="XYZ", moves_alone=True, refused=GOES_HOME),
    Code("G", 280, "non-modal", Stage.REFERENCE, partial(_named_axes, name="G28", first=HOME_28), "to reference point 1", AXES,
        "own", dialects=OF_FANUC, moves="XYZ", moves_alone=True, refused=GOES_HOME),
    Code("G", 280, "non-modal", Stage.REFERENCE, partial(_named_axes, name="G28", first=HOME_28), "to reference point 1", AXES,
        "own", dialects=(LATHE,), moves="XZ", moves_alone=True, refused=GOES_HOME),
    Code("G", 281, "non-modal", Stage.REFERENCE, partial(_set, first=HOME_28), "set reference point 1", refused=_SETS_HOME),
    Code("G", 290, "non-modal", Stage.REFERENCE, from_reference, "by way of the point of the last G28 or G30", AXES, "own",
        dialects=OF_FANUC),
    Code("G", 300, "non-modal", Stage.REFERENCE, partial(_go, first=HOME_30), "to reference point 2", AXES, "own",
        dialects=OF_LINUXCNC, moves="XYZ", moves_alone=True, refused=GOES_HOME),
    Code("G", 300, "non-modal", Stage.REFERENCE, other_point, "to reference point P (2 where it is left out)", AXES + "p", "own",
        dialects=OF_FANUC, refused=GOES_HOME),
    Code("G", 301, "non-modal", Stage.REFERENCE, partial(_set, first=HOME_30), "set reference point 2", refused=_SETS_HOME),
    Code("G", 270, "non-modal", Stage.REFERENCE, partial(_placed, name="G27"),
        "to the axis words, where reference point 1 should be", AXES, "own", dialects=OF_FANUC),
    Code("G", 600, "non-modal", Stage.REFERENCE, from_one_side, "to the axis words, which the control comes to from one side", AXES,
        "own", dialects=OF_FANUC),
)  # fmt: skip
