"""System variables of FANUC's macros that read or set the control's state (B-63324EN, 15.2).

Positions, modal codes, tool data (geometry and wear apart: of mills length and radius, offset memory C; of lathes X, Z, radius and direction
of the tip, memory B) and the work coordinate systems, which take effect as soon as they are set. Axes count in the order X Y Z A B C U V W. Variables without
a meaning here (inputs, counters, date) are plain storage, which a note tells where they are read unset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import NO_MOTION
from cncgen.gcode.state.predefined import PROBE
from cncgen.gcode.state.systems import load_system
from cncgen.machine.tool_table import TIPS, Tool
from cncgen.toolpath.record import PathMode
from cncgen.units import AXIS_LETTERS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

Reader = Callable[["Interpreter"], float]
_AXIS_COUNT = 9
#: What a variable holds of a tool: length (Z), radius, X of lathes (each with its wear, by its place in `Tool.wear`), direction of the tip.
_LENGTH, _RADIUS, _CROSS, _TIP = range(4)
#: Where the variables of each kind begin, (what, is wear) by first number, and how many tools they know.
_TOOL_DATA = (
    ({10001: (_LENGTH, 1), 11001: (_LENGTH, 0), 12001: (_RADIUS, 1), 13001: (_RADIUS, 0)}, 400),
    ({2001: (_LENGTH, 1), 2201: (_LENGTH, 0)}, 200),
)
#: Radii by older numbers, of Haas's mills and of all: others have origins from #2501 and #2601 on (B-63324EN, 15.2; 96-8210).
_RADII_OF_HAAS, _RADII = ({2401: (_RADIUS, 0), 2601: (_RADIUS, 1)}, 200), ({2401: (_RADIUS, 0)}, 100)
#: The same of lathes (B-64304EN-1, system variables of offset memory B; the numbers are from memory).
_LATHE_DATA = tuple(
    (dict(zip(firsts, ((_CROSS, 1), (_LENGTH, 1), (_RADIUS, 1), (_TIP, 0), (_CROSS, 0), (_LENGTH, 0), (_RADIUS, 0)), strict=True)), count)
    for firsts, count in (
        ((10001, 11001, 12001, 13001, 15001, 16001, 17001), 400),
        ((2001, 2101, 2201, 2301, 2701, 2801, 2901), 64),
    )
)  # fmt: skip
#: Origins: shift of all, G54 to G59, G54.1 P1 to P48, P49 to P300; and a second number of P1 to P48, which is so much larger (B-64484EN, 15.2).
_ORIGINS = (range(5201, 5329), range(7001, 7961), range(14_961, 20_001))
_MORE_ORIGINS, _FROM_FIRST = range(14_001, 14_961), 7000
#: Variables that are numbered by axis. On lathes the second one is Z, as they have it (from memory: B-64304EN-1 numbers axes as they are controlled).
_BY_AXIS = (range(5001, 5101), *_ORIGINS)
_SECOND, _THIRD = 1, 2
_SKIPPED = range(PROBE, PROBE + _AXIS_COUNT)
_TIMER = 3001
#: Variables that tell of the control or the machine: signals, data of tools and origins by their older numbers, alarms, date, codes.
_OF_THE_CONTROL = (range(1000, 2001), range(2401, 5001))
#: Offsets of tools on some controls, and origins on others, by older numbers.
_OLD_DATA = range(2401, 2901)
#: General variables of Haas's newer controls: #10100 is #100 there, #10500 #500, and #10001 is no length of a tool.
_OF_HAAS = (range(10100, 10200), range(10500, 11000))
_ALL_OF_HAAS = range(10000, 11000)
_CYCLE_CODES = 100


def _motion(ip: Interpreter) -> float:
    """Group 1: in a canned cycle, the motion that G80 leads back to."""
    return (ip.state.under if ip.state.cycle is not None else ip.state.motion) / 10.0


def _cycle(ip: Interpreter) -> float:
    motion = ip.state.motion
    return motion / 10.0 if ip.state.cycle is not None and motion != NO_MOTION else 80.0


def _system(ip: Interpreter) -> float:
    number = ip.state.system
    if number > 9:
        return 54.1
    return 53.0 + number if number <= 6 else 59.0 + (number - 6) / 10.0


def _in_frame(ip: Interpreter, name: str, idle: dict[int, float] | list[float] | float) -> bool:
    """Tell whether a part of FANUC's frame in force, which cutter compensation may stand before, changes anything."""
    parts = getattr(ip.sink, "parts", None) or getattr(getattr(ip.sink, "inner", None), "parts", None)
    return bool(getattr(parts, name, idle) != idle)


def _group_12(ip: Interpreter) -> float:
    """The coordinate system, as on Mitsubishi's and Mazak's controls; FANUC's have G66 and G67 in group 12, which no macro that was found asks
    for, and the systems in group 14."""
    message = "#4012 is read as the coordinate system, G54 to G59, as on Mitsubishi's controls; on FANUC's it tells of G66 and G67"
    ip.warn_once("other-control", message, "#", "#4014 is the coordinate system of FANUC's controls")
    return _system(ip)


_PATHS = {PathMode.EXACT_STOP: 61.0, PathMode.EXACT_PATH: 61.0, PathMode.CONTINUOUS: 64.0}
#: Modal codes by group, and the words in force.
_MODAL: dict[int, Reader] = {
    4001: _motion,
    4002: lambda ip: float(ip.state.plane if ip.state.plane < _CYCLE_CODES else ip.state.plane / 10.0),
    4003: lambda ip: 90.0 if ip.state.absolute else 91.0,
    4005: lambda ip: float(ip.state.feed_mode),
    4006: lambda ip: 20.0 if ip.state.inches else 21.0,
    4007: lambda ip: float(ip.state.compensation),
    4008: lambda ip: float(ip.state.length_code),
    4009: _cycle,
    4010: lambda ip: 98.0 if ip.state.retract_old else 99.0,
    4011: lambda ip: 51.0 if _in_frame(ip, "scale", [1.0] * 3) else 50.0,
    4012: _group_12,
    4013: lambda ip: 97.0 if ip.state.constant_surface is None else 96.0,
    4014: _system,
    4015: lambda ip: _PATHS[ip.state.path_mode],
    4016: lambda ip: 68.0 if _in_frame(ip, "angle", 0.0) else 69.0,
    4017: lambda ip: 15.0 if ip.state.polar is None else 16.0,
    4022: lambda ip: 51.1 if _in_frame(ip, "mirror", {}) else 50.1,
    4107: lambda ip: float(ip.state.radius_number or 0),
    4109: lambda ip: ip.state.feed,
    4111: lambda ip: float(ip.state.length_number or 0),
    4119: lambda ip: ip.state.speed,
    4120: lambda ip: float(ip.state.selected),
    4130: lambda ip: float(max(ip.state.system - 9, 0)),
}
#: The same of lathes, whose codes are in other groups (B-64304EN-1, list of G codes; the numbers are from memory).
_LATHE_MODAL: dict[int, Reader] = {
    **{number: read for number, read in _MODAL.items() if number not in (4003, 4008, 4009, 4010, 4013, 4016, 4017, 4022, 4107, 4111)},
    4002: _MODAL[4013],
    4005: lambda ip: ip.state.feed_mode + (4.0 if ip.system == "fanuc-lathe" else 0.0),
    4010: _cycle,
    4011: _MODAL[4010],
    4016: _MODAL[4002],
}  # fmt: skip


def _timer(ip: Interpreter) -> float:
    """Count a millisecond each time the clock is read: reading a program takes no time, and loops that wait must end."""
    numbers = ip.parameters.numbers
    if not numbers[_TIMER]:
        message = f"#{_TIMER} counts a millisecond each time it is read, not the time of the machine"
        ip.note("timer", message, "#", "a wait of a known time is G4")
    numbers[_TIMER] += 1.0
    return numbers[_TIMER]


def _of_haas(ip: Interpreter) -> bool:
    return ip.flow is not None and ip.flow.of_haas


def _included(ip: Interpreter, axis: int) -> float:
    """Return what is in #5041 and #5061 beside the place of the tip: the tool's length (table of positions of B-63324EN, 15.2, "tool compensation
    value included"; Renishaw's and other public macros subtract it). On lathes it shifts the coordinates; Haas's tell of the tip."""
    offset = ip.state.tool_offset[axis]
    if offset and not ip.lathe and not _of_haas(ip):
        message = "#5041 and #5061 on have the tool's length in them, as on FANUC's controls; on Haas's they tell of its tip"
        ip.warn_once("other-control", message, "#", "#5001 on tell of the tip, and #5081 on of the length")
        return offset
    return 0.0


def _current(ip: Interpreter, axis: int) -> float:
    place = ip.to_work(ip.state.position)[axis]
    return 2.0 * place if axis == 0 and ip.state.diameter else place + _included(ip, axis)


def _positions() -> Iterator[tuple[int, Reader]]:
    """Yield ends of blocks, machine and work positions, and the tool offset in force."""

    def of(read: Callable[[Interpreter], list[float]], axis: int) -> Reader:
        # On lathes X is a diameter.
        return lambda ip: read(ip)[axis] * (2.0 if axis == 0 and ip.state.diameter else 1.0)

    for axis in range(_AXIS_COUNT):
        yield 5001 + axis, of(lambda ip: ip.state.position, axis)
        yield 5021 + axis, of(lambda ip: ip.machine_position(), axis)
        yield 5041 + axis, partial(_current, axis=axis)
        yield 5081 + axis, of(lambda ip: ip.state.tool_offset, axis)


_READERS = {**_MODAL, **dict(_positions()), _TIMER: _timer}
_LATHE_READERS = {**_LATHE_MODAL, **dict(_positions()), _TIMER: _timer}


def _readers(ip: Interpreter) -> dict[int, Reader]:
    return _LATHE_READERS if ip.lathe else _READERS


def _tool_datum(ip: Interpreter, index: int) -> tuple[int, int, int] | None:
    """Return which datum of which tool a variable is: (what, is wear, number), or None."""
    of_haas = _of_haas(ip)
    if of_haas and index in _ALL_OF_HAAS:
        return None
    data = _LATHE_DATA if ip.lathe else (*_TOOL_DATA, _RADII_OF_HAAS if of_haas else _RADII)
    for firsts, count in data:
        for first, (what, wear) in firsts.items():
            if first <= index < first + count:
                return what, wear, index - first + 1
    return None


def _is_origin(index: int) -> bool:
    return any(index in numbers for numbers in _ORIGINS) and (index - 1) % 20 < _AXIS_COUNT


def _parts(tool: Tool, what: int) -> tuple[float, float]:
    """Return geometry and wear of a tool's datum, in the table's units."""
    if what == _TIP:
        return float(TIPS[tool.orientation]), 0.0
    total = (tool.offset[2], tool.diameter / 2.0, tool.offset[0])[what]
    return total - tool.wear[what], tool.wear[what]


def _scale(ip: Interpreter, what: int) -> float:
    """Return what a datum is multiplied by for its variable: X is a diameter."""
    return 1.0 if what == _TIP else ip.table_scale() * (2.0 if what == _CROSS else 1.0)


def _by_axis(ip: Interpreter, index: int) -> int:
    """Return the number by which a variable is known here, where Z is the third axis and A the fourth."""
    if index in _MORE_ORIGINS and not ip.lathe:
        index -= _FROM_FIRST
    place = (index - 1) % 20
    if not _SECOND <= place < _AXIS_COUNT or not any(index in numbers for numbers in _BY_AXIS):
        return index
    if not ip.lathe:
        if place > _THIRD:
            message = (
                f"#{index} is read as that of {AXIS_LETTERS[place]}: axes count in the order X Y Z A B C"
            )
            ip.note_once(
                "other-control",
                message,
                "#",
                "where the fourth axis of a machine is B or C, #5044 tells of it",
            )
    elif place == _SECOND:
        message = f"#{index} is read as that of Z, the second axis of FANUC's lathes"
        ip.note_once("other-control", message, "#", "a control that has Y between X and Z tells of Y there")
        return index + 1
    elif place == _THIRD:
        message = (
            f"#{index} is read as that of Z; on FANUC's lathes it is that of the third axis, which is C or Y"
        )
        ip.warn_once("other-control", message, "#", f"#{index - 1} is that of Z on all of them")
    return index


def read(ip: Interpreter, index: int) -> float:
    """Return a variable in the units of the program."""
    index = _by_axis(ip, index)
    reader = _readers(ip).get(index)
    if reader is not None:
        return reader(ip)
    datum = _tool_datum(ip, index)
    if datum is not None:
        what, wear, number = datum
        tool = ip.tools.find(number)
        return 0.0 if tool is None else _parts(tool, what)[wear] * _scale(ip, what)
    value = ip.parameters.numbers[index]
    if index in _SKIPPED:
        return value + _included(ip, index - _SKIPPED.start)
    if value == 0.0 and _is_untold(ip, index):
        ip.parameters.untold = index
        message = f"#{index} tells of the control or the machine, and is not known here: it counts as 0"
        hint = f"--parameters gives #{index} a value; the program may set it before it reads it"
        ip.note_once("variable-assumed", message, f"#{index}", hint)
    return value * _origin_scale(ip, (index - 1) % 20) if _is_origin(index) else value


def _origin_scale(ip: Interpreter, axis: int) -> float:
    """Return what a coordinate of an origin is multiplied by for its variable: X of lathes is a diameter, as that of G10 L2 is."""
    return ip.scale_of(axis) * (2.0 if axis == 0 and ip.state.diameter else 1.0)


def _is_untold(ip: Interpreter, index: int) -> bool:
    """Tell whether a variable of the control has been given no value."""
    return (
        any(index in numbers for numbers in _OF_THE_CONTROL)
        and index not in ip.parameters.listed
        and index not in ip.parameters.stored
    )


def store(ip: Interpreter, index: int, value: float) -> None:
    """Set a variable; raise where it can only be read, or its tool is not in the tool table."""
    index = _by_axis(ip, index)
    if any(index in numbers for numbers in _OF_HAAS):
        message = (
            f"#{index} is another variable than #{index - 10_000} here; on Haas's newer controls they are one"
        )
        ip.warn_once("other-control", message, "#", f"write #{index - 10_000} alone")
    datum = _tool_datum(ip, index)
    if datum is not None:
        _set_tool(ip, *datum, value)
    elif _is_origin(index):
        _set_origin(ip, index, value)
    elif index in _readers(ip) and index != _TIMER:
        message = f"#{index} tells the control's state: it cannot be set"
        raise BlockError("parameter-read-only", message, "#", hint="#100 to #199 and #500 to #999 are free")
    else:
        if index in _OLD_DATA:
            message = f"#{index} is an offset of a tool on some controls and an origin on others: here it is neither, and nothing moves by it"
            hint = "#12001 and #13001 on are radii of mills' tools, #5221 on origins"
            ip.warn_once("other-control", message, "#", hint)
        ip.parameters.numbers[index] = value
        ip.parameters.stored.add(index)


def _set_tool(ip: Interpreter, what: int, wear: int, number: int, value: float) -> None:
    """Set a datum of a tool (vacant: 0); the sum of geometry and wear counts."""
    tool = ip.tools.entry(number)
    if tool is None:
        # A control has all numbers of offsets, whatever tools there are.
        tool = ip.tools.tools[number] = Tool(number, number)
    value = value if value == value else 0.0
    if what == _TIP:
        if value not in range(len(TIPS)):
            raise BlockError("tool-orientation", f"{value:g}: the direction of a tip is 0 to 9", "#")
        tool.orientation = TIPS[int(value)]
        return
    parts = list(_parts(tool, what))
    parts[wear] = value / _scale(ip, what)
    tool.wear[what] = parts[1]
    if what == _RADIUS:
        tool.diameter = 2.0 * sum(parts)
    else:
        tool.offset[0 if what == _CROSS else 2] = sum(parts)


def _set_origin(ip: Interpreter, index: int, value: float) -> None:
    """Set a coordinate of an origin (vacant: 0), as the program's units have it; it takes effect at once."""
    axis = (index - 1) % 20
    ip.parameters.numbers[index] = (value if value == value else 0.0) / _origin_scale(ip, axis)
    load_system(ip, ip.state.system)
    ip.sink.set_g5x_offset(ip.state.system, ip.state.origin)
