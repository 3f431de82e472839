"""Cutter radius compensation: G40, G41, G42, G41.1, G42.1, and D of FANUC; `compensated_sink` does the work while it is on."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.table import COMPENSATION, INTERRUPTS, STRICT_COMPENSATION, TOOL_POINT, Code
from cncgen.gcode.codes.tools import known, of_the_spindle, tell_unknown, whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import PLAIN_MOTIONS, Stage, in_plane

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.codes.compensated_sink import CompensatedSink
    from cncgen.gcode.interpreter import Interpreter
    from cncgen.machine.tool_table import Tool

#: How much farther than programmed (rad) LinuxCNC lets a compensated arc sweep, in inches (G20) and in mm: measured on its
#: interpreter, for tools inside and outside of arcs, radii of 0.5 to 10 and sweeps of 0.1 to 1.5 rad.
_GROWTH = {True: 0.001, False: 0.0254}
_PLANES, _PLANES_OF_LINUXCNC = (17, 18, 19), (17, 18)
#: Dialects in which compensation is LinuxCNC's.
_STRICT = ("linuxcnc",)
ORIENTATIONS = 10
_G40 = 400
_CENTRE = "ijk"
_GROUP = "cutter compensation"
_LAST_DIGIT = 1e-12
#: From how far on the tool stands beside the path, program units.
_BESIDE = 1e-6


def _turn_on(ip: Interpreter, block: Block, left: bool, dynamic: bool) -> None:
    state = ip.state
    name = f"G{41 if left else 42}{'.1' if dynamic else ''}"
    planes = _PLANES_OF_LINUXCNC if ip.dialect in _STRICT else _PLANES
    if state.plane not in planes:
        message = f"{name} works in the planes {' and '.join(f'G{p}' for p in planes)}, not in G{state.plane}"
        raise BlockError("comp-plane", message, name)
    radius, orientation = (_programmed if dynamic else _of_the_tool)(ip, block, name)
    side = left == (radius >= 0.0)
    if (on := _sink_of(ip)) is not None and ip.dialect not in _STRICT:
        _renew(ip, on, radius, left)
        return
    start = in_plane(state.position, state.plane)
    unit = "inch" if state.inches else "mm"
    growth = _GROWTH[state.inches] if ip.dialect == "linuxcnc" else None
    # FANUC enters on a move of any length. LinuxCNC's radius of a table may be less by the last digit of a double.
    least = 0.0 if ip.dialect not in _STRICT else abs(radius) * (1.0 if dynamic else 1.0 - _LAST_DIGIT)
    from cncgen.gcode.codes.compensated_sink import CompensatedSink
    from cncgen.gcode.codes.tool_centre import ToolCentre

    centre = ToolCentre(
        *(radius, left, start, orientation, unit),
        growth=growth,
        least_entry=least,
        square_entry=ip.dialect not in _STRICT,
    )
    ip.sink.call(f'COMMENT("interpreter: cutter radius compensation on {"left" if side else "right"}")')
    state.compensation = 41 if side else 42
    sink = CompensatedSink(
        ip.sink,
        centre,
        state.plane,
        state.position,
        state.inches,
        ip.codes,
        ip.remark,
        tool_offset=list(state.tool_offset),
        lenient=ip.dialect not in _STRICT,
        on_roll=partial(_tell_roll, ip) if ip.dialect == "fanuc" else None,
        on_arc=partial(_tell_arc, ip) if ip.dialect.startswith("fanuc") else None,
        on_interrupt=partial(interrupt, ip) if ip.dialect.startswith("fanuc") and not dynamic else None,
        contour_feed=ip.contour_feed,
        feed=state.feed,
    )
    sink.left = left
    ip.sink, ip.compensated_position = sink, sink.beside


def _tell_roll(ip: Interpreter) -> None:
    """Say once that outside corners are rolled around, which a parameter of FANUC's controls decides (CCC, 19607#2)."""
    message = "the tool rolls around outside corners in arcs; with parameter CCC (19607#2) = 0, the control joins straight lines"
    hint = "the part is the same; arcs R in the program's corners leave no choice"
    ip.note_once("comp-corners", message, hint=hint)


def _tell_arc(ip: Interpreter) -> None:
    """Warn of an entry on an arc, which FANUC's controls refuse; Heidenhain's APPR CT is one."""
    message = "cutter compensation begins on an arc, which FANUC's controls refuse (alarm 34)"
    ip.warn("comp-entry", message, hint="enter on a G0 or G1")


def _sink_of(ip: Interpreter) -> CompensatedSink | None:
    """Return the sink of compensation where it is on; its module is imported with the first G41 or G42."""
    if ip.compensated_position is None:
        return None
    from cncgen.gcode.codes.compensated_sink import CompensatedSink

    return ip.sink if isinstance(ip.sink, CompensatedSink) else None


def feed_along_contour(ip: Interpreter, arcs: str) -> None:
    """Take F as the feed along the contour on compensated arcs from here on: ``all``, those ``inside``, or none (empty)."""
    ip.contour_feed = arcs
    if (sink := _sink_of(ip)) is not None:
        sink.feed_along_contour(arcs)


def _renew(ip: Interpreter, sink: CompensatedSink, radius: float, left: bool) -> None:
    """Take the radius and side of a G41 or G42 that stands while compensation is on; the same again changes nothing."""
    side = 1 if left == (radius >= 0.0) else -1
    if (abs(radius), side) != (sink.centre.radius, sink.centre.side):
        sink.centre.renew(radius, left)
        sink.left = left
        ip.state.compensation = 41 if side > 0 else 42


def _programmed(ip: Interpreter, block: Block, name: str) -> tuple[float, int]:
    """Return radius (program units) and orientation of G41.1 D L."""
    if "d" not in block.words:
        raise BlockError("comp-diameter", f"{name} has no D", name, hint="D is the tool's diameter")
    orientation = block.words.get("l", 0.0)
    if "l" in block.words and ip.state.plane != 18:
        raise BlockError("comp-orientation", f"L of {name} is for lathes: plane G18", "L")
    if orientation != round(orientation) or not 0 <= orientation < ORIENTATIONS:
        raise BlockError("comp-orientation", f"L{orientation:g} of {name}: an orientation is 0 to 9", "L")
    return block.words["d"] / 2.0, round(orientation)


def _of_the_tool(ip: Interpreter, block: Block, name: str) -> tuple[float, int]:
    """Return radius (program units) and orientation of the tool of D, or of the one in the spindle."""
    tool = tool_of_radius(ip, block, name)
    tell_unknown(ip, tool.number, "D")
    return tool.diameter * ip.table_scale() / 2.0, tool.orientation


def tool_of_radius(ip: Interpreter, block: Block, name: str) -> Tool:
    """Return the tool whose radius is in force; raise where the tool table does not have it."""
    number = radius_number_in_force(ip, block, name)
    return known(ip.tools.find(number), f"tool {number}", "D")


def radius_number_in_force(ip: Interpreter, block: Block, name: str) -> int:
    """Return the D of a block, else the tool in the spindle, which D0 of LinuxCNC is too.

    FANUC's D stays in force, and D0 names no tool.
    """
    number = whole(block, "d", name) if "d" in block.words else None
    if number is None and "h" in block.words and ip.dialect == "fanuc" and not {430, 440} & set(block.g):
        number = whole(block, "h", name)
        message = f"H{number} of {name} is read as the number of the radius, as controls without D have it"
        ip.note_once("radius-by-h", message, "H", "write D for the radius")
    if ip.dialect != "fanuc":
        return number or ip.state.tool
    if number is not None:
        ip.state.radius_number = number
    number = ip.state.radius_number
    return of_the_spindle(ip, name, "D") if number is None else number


def radius_number(ip: Interpreter, block: Block) -> None:
    """D of FANUC by itself: the offset of the next G41 or G42."""
    number = whole(block, "d", "")
    changed = number != ip.state.radius_number
    ip.state.radius_number = number
    if changed and (sink := _sink_of(ip)) is not None:
        radius, _ = _of_the_tool(ip, Block({}), "D")
        _renew(ip, sink, radius, ip.state.compensation == 41)


def turn_off(ip: Interpreter, block: Block) -> None:
    """G40; on FANUC's controls with I J K, the direction of a line that the last compensated move ends at as well."""
    sink = _sink_of(ip)
    leaves = sink is not None and sink.centre.moved
    if sink is not None and ip.dialect not in _STRICT:
        first, second, _ = ip.state.plane_axes()
        if way := complex(*(block.words.get(_CENTRE[axis], 0.0) for axis in (first, second))):
            sink.leave_towards(way)
    end(ip)
    ip.sink.call('COMMENT("interpreter: cutter radius compensation off")')
    if sink is not None and leaves:
        beside = abs(sink.centre.position - in_plane(ip.state.position, sink.plane))
        ip.guard = partial(_leave_straight, beside)
        _leave_straight(beside, ip, block)


def end(ip: Interpreter) -> None:
    """Pass on waiting motions and remove the compensating sink; the tool stays where it is until the next move."""
    sink = _sink_of(ip)
    ip.state.compensation = 40
    if sink is not None:
        try:
            sink.finish()
        finally:
            ip.sink, ip.compensated_position = sink.inner, None


def interrupt(ip: Interpreter, block: Block, name: str, what: str) -> None:
    """End compensation for a code that FANUC's controls cancel it for; it begins again with the next move.

    So it is with reference points, machine coordinates, preset positions, threads and tools of lathes; canned cycles ignore it.
    """
    sink = _sink_of(ip)
    if sink is None:
        return
    left, side = sink.left, ip.state.compensation
    end(ip)
    if _G40 in block.g:
        return
    message = (
        f"{name} {what}, and G{side} is on: it is cancelled for that, and begins again with the next move"
    )
    ip.warn_once("comp-interrupted", message, name, "write G40 before, and G41 or G42 where it begins again")
    ip.guard = partial(_begin_again, 410 if left else 420)


def _begin_again(code: int, ip: Interpreter, block: Block) -> None:
    """Begin the compensation that was cancelled with the first plain motion behind, unless the program says otherwise."""
    rows = ip.codes.of(block)
    if any(row.group == _GROUP for row in rows):
        ip.guard = None
        return
    motion = next((row.number for row in rows if row.group == "motion"), ip.state.motion)
    interrupts = any(row.refused[1] & INTERRUPTS for row in rows)
    if interrupts or motion not in PLAIN_MOTIONS or block.words.keys().isdisjoint("xyzuvw"):
        return
    ip.guard = None
    ip.execute(block.beside({}, (code,)))


def _leave_straight(beside: float, ip: Interpreter, block: Block) -> None:
    """Watch the blocks after G40 up to the first motion; warn of FANUC's that leaves the plane, and the path by a distance, at once."""
    if not _check_leaving(ip, block):
        return
    ip.guard = None
    first, second, normal = (AXES[axis] for axis in ip.state.plane_axes())
    alone = normal in block.words and block.words.keys().isdisjoint(first + second)
    if not alone or ip.dialect != "fanuc" or beside < _BESIDE:
        return
    unit = "inch" if ip.state.inches else "mm"
    move = f"this move along {normal.upper()}, the first one behind the compensation,"
    message = f"{move} takes the tool back onto the programmed path too, by {beside:.4g} {unit}"
    hint = f"G40 beside {first.upper()} or {second.upper()} leaves no choice: controls differ in whether the offset ends in a move along {normal.upper()}"
    ip.warn_once("comp-exit", message, normal.upper(), hint)


def _check_leaving(ip: Interpreter, block: Block) -> bool:
    """Tell whether a block moves; raise where it leaves compensation on an arc."""
    motions = [number for number in block.g if number in PLAIN_MOTIONS]
    if not motions and not block.words.keys() & set("xyz"):
        return False
    motion = motions[0] if motions else ip.state.motion
    if motion in (20, 30):
        ip.guard = None
        message = "the first move after cutter compensation is an arc; it must be straight"
        hint = "leave on a G0 or G1 longer than the tool's diameter"
        raise BlockError("comp-exit", message, "R" if "r" in block.words else "I", hint=hint)
    return True


_STAGE = Stage.RADIUS_COMPENSATION
_BEGINS = "begins cutter compensation"
CODES = (
    Code("G", 400, _GROUP, _STAGE, turn_off, "cutter compensation off", dialects=("linuxcnc",), restores=("compensation", 40)),
    Code("G", 400, _GROUP, _STAGE, turn_off, "cutter compensation off, at a line in the direction I J K", _CENTRE,
        dialects=("fanuc",), restores=("compensation", 40)),
    Code("G", 410, _GROUP, _STAGE, partial(_turn_on, left=True, dynamic=False), "cutter compensation, tool left of the path", "d",
        takes="d", moves="plane", restores=("compensation", 41), refused=(_BEGINS, STRICT_COMPENSATION | TOOL_POINT)),
    Code("G", 420, _GROUP, _STAGE, partial(_turn_on, left=False, dynamic=False), "cutter compensation, tool right of the path", "d",
        takes="d", moves="plane", restores=("compensation", 42), refused=(_BEGINS, STRICT_COMPENSATION | TOOL_POINT)),
    Code("G", 411, _GROUP, _STAGE, partial(_turn_on, left=True, dynamic=True), "as G41, for the diameter D", "dl", takes="d",
        moves="plane", refused=(_BEGINS, COMPENSATION | TOOL_POINT)),
    Code("G", 421, _GROUP, _STAGE, partial(_turn_on, left=False, dynamic=True), "as G42, for the diameter D", "dl", takes="d",
        moves="plane", refused=(_BEGINS, COMPENSATION | TOOL_POINT)),
    Code("D", 0, "D", _STAGE, radius_number, "number of the tool radius", "d", dialects=("fanuc",), without="lathes"),
)  # fmt: skip
