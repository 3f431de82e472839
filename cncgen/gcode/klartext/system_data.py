"""FN 18: SYSREAD, data of the control in a Q parameter (TNC 640, "FN 18 – Reading system data"), and FN 17: SYSWRITE, which writes them."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.block import AXES
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter

#: The data, by ID and NR: program, state of the machine, tool table, the values of TOOL CALL, lower and upper end of travel ("Traverse range":
#: negative and positive software limit switch), position in the machine's and in the program's coordinates. The index of ID50 is the tool,
#: of ID230, ID240 and ID270 the axis from 1 on (iTNC 530 HSCI technical manual, 9.5.4). Lengths are in
#: mm whatever the program's unit ("List of FN functions" of TNC 7).
_STATE: dict[tuple[int, int], Callable[[Interpreter, int], float]] = {
    (10, 1): lambda ip, index: float(ip.state.inches),
    (20, 1): lambda ip, index: float(ip.state.tool),
    (20, 2): lambda ip, index: float(ip.state.selected),
    (20, 3): lambda ip, index: 2.0,
    (20, 4): lambda ip, index: ip.state.speed,
    (20, 5): lambda ip, index: {1: 0.0, -1: 1.0, 0: 2.0}[ip.state.direction],
    (20, 8): lambda ip, index: float(ip.state.flood),
    (20, 9): lambda ip, index: ip.state.feed * ip.state.unit_mm,
    (20, 10): lambda ip, index: 0.0,
    (20, 11): lambda ip, index: 0.0,
    (50, 1): lambda ip, index: _size(ip, index or ip.state.tool)[0],
    (50, 2): lambda ip, index: _size(ip, index or ip.state.tool)[1],
    (60, 1): lambda ip, index: float(ip.state.tool),
    (60, 3): lambda ip, index: ip.state.speed,
    (230, 2): lambda ip, index: _end_of_travel(ip, index, 1),
    (230, 3): lambda ip, index: _end_of_travel(ip, index, 2),
    (240, 1): lambda ip, index: (
        ip.machine_position()[index - 1] * (1.0 if 4 <= index <= 6 else ip.state.unit_mm)
    ),
    (270, 1): lambda ip, index: ip.state.position[index - 1] * (1.0 if 4 <= index <= 6 else ip.state.unit_mm),
}
#: ID of the tool table, NR of its columns L, R, and of the last one that moves the tool (R2, DL, DR, DR2).
_TABLE, _LENGTH, _RADIUS, _LAST_SIZE = 50, 1, 2, 6


def _size(ip: Interpreter, number: int) -> tuple[float, float]:
    """Return length and radius of a tool in mm; zeros without one."""
    tool = ip.tools.find(number) if number else None
    if tool is None:
        return 0.0, 0.0
    # DL and DR of a call are not of the table.
    length, diameter = Plain.of(ip).sizes.get(number, (tool.offset[2], tool.diameter))
    scale = ip.table_scale() * ip.state.unit_mm
    return length * scale, diameter * scale / 2.0


def _end_of_travel(ip: Interpreter, index: int, end: int) -> float:
    """Return the lowest (1) or highest (2) machine position of an axis; where it is not known, the one that the axis has now."""
    letter = AXES[index - 1].upper()
    for bounds in ip.options.travel:
        if bounds[0].upper() == letter:
            return float(bounds[end])
    message = (
        f"where the travel of {letter} ends is not known here: FN 18 with ID230 reads where the axis stands"
    )
    hint = f"travel_mm of {letter} in the machine file gives it; a way to that place moves nothing"
    ip.warn_once("travel-unknown", message, "FN", hint)
    return _STATE[240, 1](ip, index)


def read(ip: Interpreter, group: int, number: int, index: int) -> float:
    """Return the value of ID, NR and IDX; raise where the data are not available."""
    told = _STATE.get((group, number))
    if told is None and group == _TABLE:
        _warn_of_column(ip, number, "0 is read from it")
        return 0.0
    if told is None or (group in (230, 240, 270) and not 1 <= index <= len(AXES)):
        message = f"FN 18 with ID{group} NR{number} IDX{index} is not read"
        hint = "ID10, ID20 (tool, speed, feed), ID50 (length and radius of a tool), ID60, ID230 (ends of travel), ID240 and ID270 (position) are"
        raise BlockError("unsupported-block", message, "FN", hint=hint)
    return told(ip, index)


def write(ip: Interpreter, group: int, number: int, index: int, value: float) -> None:
    """Write ID, NR and IDX; of the tool table length and radius in mm, which hold from the next call of the tool on.

    Raises:
        BlockError: The data are not kept here, and motions may depend on them.
    """
    if group != _TABLE or (_RADIUS < number <= _LAST_SIZE and value):
        message = f"FN 17 with ID{group} NR{number} IDX{index} = {value:g} is not read"
        hint = "ID50 (the tool table) is, but for R2, DL, DR and DR2"
        raise BlockError("unsupported-block", message, "FN", hint=hint)
    if number not in (_LENGTH, _RADIUS):
        _warn_of_column(ip, number, "writing it is passed over")
        return
    Plain.of(ip).sizes.pop(index, None)
    tool, scale = ip.tools.made(index), ip.table_scale() * ip.state.unit_mm
    if number == _LENGTH:
        tool.offset[2] = value / scale
    else:
        tool.diameter = 2.0 * value / scale


#: Columns of the tool table, by their names in FN 27, and their NR.
_COLUMNS = {"L": _LENGTH, "R": _RADIUS, "R2": 3, "DL": 4, "DR": 5, "DR2": 6}


def write_column(ip: Interpreter, table: str, row: int, columns: str, value: float | None) -> None:
    """Write a column of a row of the table that FN 26 opened, FN 27: TABWRITE 40/"L" = Q1: of TOOL.T the tool's length and radius.

    Args:
        table: Its file, without folders.
        row: The tool.
        columns: The name of a column, or of several.
        value: What is written, None for a text.

    Raises:
        BlockError: What is written is not kept here, and motions may depend on it.
    """
    names = [name.strip().upper() for name in columns.split(",")]
    kept = table == "TOOL.T" and any(name in _COLUMNS for name in names)
    if kept and len(names) == 1 and value is not None:
        write(ip, _TABLE, _COLUMNS[names[0]], row, value)
        return
    if kept:
        message = f"FN 27 with the columns {', '.join(names)} of {table} is not read"
        raise BlockError("unsupported-block", message, "FN", hint="a block for each of L and R is")
    message = f"FN 27 writes {columns} of {table or 'a table'}, which is not kept here: it is passed over"
    hint = "L and R of TOOL.T are kept; what the control reads from the table later is not what was written"
    ip.warn_once("variable-assumed", message, "FN", hint)


def _warn_of_column(ip: Interpreter, number: int, what: str) -> None:
    message = f"ID50 NR{number} is a column that the tool table here lacks: {what}"
    hint = f"length (NR1) and radius (NR2) are kept; the control's program may go another way by NR{number}"
    ip.warn_once("variable-assumed", message, "FN", hint)
