"""The spindle: S, M3 M4 M5, M19, G96 and G97. Source: Kramer et al. (2000), sections 3.6.2 and 3.7.2, and LinuxCNC's manual."""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import LEAST_RADIUS_MM
from cncgen.gcode.state.modal import Stage, State
from cncgen.toolpath.record import Event

#: Spindles that ``$`` may name (the stand-alone machine has one).
_SPINDLES = 8
TURNS = {1: "START_SPINDLE_CLOCKWISE", -1: "START_SPINDLE_COUNTERCLOCKWISE", 0: "STOP_SPINDLE_TURNING"}
#: The largest speed in the canonical call where D is missing.
_NO_LIMIT = 1e30
#: Revolutions a minute that no spindle of a lathe makes.
_TOO_FAST = 100_000.0
_BOUND = "bound it before: G50 S or G92 S, in LinuxCNC D of G96, on SINUMERIK LIMS=; or spindle_max_rpm under [times] of the machine file"


def spindle_of(ip: Interpreter, block: Block) -> int:
    """Return the spindle that ``$`` names."""
    value = block.words.get("$", 0.0)
    count = 1 if ip.options.stand_alone else _SPINDLES
    if value != round(value) or not -1 <= value < count:
        raise BlockError("spindle-number", f"the machine has no spindle ${value:g}", "$")
    return max(round(value), 0)


def turns_a_minute(state: State) -> float:
    """Return the speed of the spindle in rev/min; with a constant surface speed, the one where the tool stands."""
    if not state.constant_surface:
        return state.speed
    around = 2.0 * math.pi * max(abs(state.position[0]), LEAST_RADIUS_MM / state.unit_mm)
    return min(state.speed * (12.0 if state.inches else 1000.0) / around, state.constant_surface)


def waited_s(state: State, time: float) -> float:
    """Return the seconds of a dwell that is negative where it counts revolutions; none where the spindle does not turn."""
    if time >= 0.0:
        return time
    turns = turns_a_minute(state)
    return -60.0 * time / turns if turns > 0.0 else 0.0


def _event(ip: Interpreter, rest: bool) -> Event:
    state = ip.state
    values = {"speed_rpm": state.speed, "direction": state.direction}
    if state.constant_surface:
        # The spindle's speed follows the tool from there.
        values["speed_rpm"] = turns = turns_a_minute(state)
        if rest and state.direction and state.constant_surface == _NO_LIMIT and turns > _TOO_FAST:
            # Where nothing has moved yet, X0 is no place that the program says.
            place = "beside X0" if state.moved else "where no move has said X yet, which counts as X0"
            message = f"a surface speed without a bound, {place}: {turns:.0f} rev/min, and the time to get there counts"
            ip.warn_once("speed-unbounded", message, "M", _BOUND)
        values["surface_ft_min" if state.inches else "surface_m_min"] = state.speed
    return Event("spindle", rest, values=values)


def set_speed(ip: Interpreter, block: Block) -> None:
    """S."""
    value = block.words["s"]
    if value < 0.0:
        raise BlockError("negative-speed", f"S{value:g} is negative", "S", hint="M4 turns the other way")
    _take_speed(ip, value, spindle_of(ip, block))


def _turn(ip: Interpreter, block: Block, direction: int) -> None:
    spindle = spindle_of(ip, block)
    if spindle == 0:
        ip.state.direction = direction
        ip.state.driven = False
        ip.sink.set_spindle(ip.state.speed, direction)
    ip.sink.call(f"{TURNS[direction]}({spindle})", _event(ip, True))


def _has_p(ip: Interpreter, block: Block) -> bool:
    """Tell whether P is the spindle's: beside another code that has a P, as G54.1, it is that one's."""
    others = (row for row in ip.codes.of(block) if row.group != "spindle")
    return "p" in block.words and all("p" not in row.words for row in others)


def _powered(ip: Interpreter, block: Block, direction: int) -> None:
    """M3 or M4, with P the power of a spindle or a laser in percent on Snapmaker's controls; LinuxCNC's own refuses it.

    Raises:
        BlockError: The program is to be read as LinuxCNC's own.
    """
    if _has_p(ip, block):
        if ip.options.stand_alone or ip.options.dialect == "linuxcnc":
            hint = "S is the spindle's speed; --dialect auto reads P as Snapmaker does, as power in percent"
            raise BlockError("unused-word", "P stands in a block with no code that uses it", "P", hint=hint)
        message = f"P{block.words['p']:g} is read as the power of a spindle or laser in percent, as on Snapmaker: it is no speed"
        ip.note_once("spindle-power", message, "P", "S gives the speed")
    _turn(ip, block, direction)


def turn_to(ip: Interpreter, spindle: int, angle: float, way: float) -> None:
    """Turn a spindle to an angle, degrees, by a way as LinuxCNC counts them."""
    event = Event("spindle", True, values={"orient_deg": angle})
    ip.sink.call(f"ORIENT_SPINDLE({spindle}, {angle:.4f}, {way:.0f})", event)


def orient(ip: Interpreter, block: Block) -> None:
    """M19 R P: turn to R degrees, P 0 the short way, 1 clockwise, 2 counter-clockwise."""
    angle = block.words.get("r", 0.0)
    way = block.words.get("p", 0.0)
    if way not in (0.0, 1.0, 2.0):
        raise BlockError("orient-way", f"P{way:g} of M19: P is 0, 1 or 2", "P")
    if not 0.0 <= angle <= 360.0:
        raise BlockError("orient-angle", f"R{angle:g} of M19 is not within 0 to 360 degrees", "R")
    wait = block.words.get("q")
    if wait is not None and wait <= 0.0:
        raise BlockError("orient-time", f"Q{wait:g} of M19: the time limit must be above 0", "Q")
    turn_to(ip, spindle_of(ip, block), angle, way)
    if wait is not None:
        ip.sink.call(f"SPINDLE.{spindle_of(ip, block)}.WAIT_ORIENT_COMPLETE({wait:.4f})")


def orient_fanuc(ip: Interpreter, block: Block) -> None:
    """M19 R or P: turn to so many degrees, as Haas's controls do; FANUC leaves the code to the machine's builder."""
    turn_to(ip, spindle_of(ip, block), block.words.get("r", block.words.get("p", 0.0)), 0)


def _selected(ip: Interpreter, block: Block, direction: int) -> None:
    """M3, M4 or M5 of FANUC, whose P names a spindle: the turning spindle is planned for."""
    if _has_p(ip, block):
        message = f"P{block.words['p']:g} names a spindle: feeds a revolution are taken with the speed of the one named last"
        ip.warn_once("spindle-number", message, "P", "one spindle is planned for")
    _turn(ip, block, direction)


def constant_surface(ip: Interpreter, block: Block) -> None:
    """G96 D S: constant surface speed S, at most D rev/min."""
    unless_given = _NO_LIMIT if ip.state.speed_limit is None else ip.state.speed_limit
    limit = block.words.get("d", unless_given)
    if limit < 0.0:
        raise BlockError("negative-speed", f"D{limit:g} of G96 is negative", "D")
    again = None
    if "s" not in block.words and ip.dialect != "linuxcnc":
        # FANUC and SINUMERIK take the last surface speed up again.
        again = ip.state.surface_speed if ip.state.constant_surface is None else ip.state.speed
    if "s" not in block.words and again is None:
        message = "G96 has no surface speed"
        raise BlockError("speed-missing", message, "G96", hint="give it as S in the same block")
    bound_surface_speed(ip, limit, spindle_of(ip, block))
    if again is not None:
        _take_speed(ip, again)


def _take_speed(ip: Interpreter, speed: float, spindle: int = 0) -> None:
    if spindle == 0:
        ip.state.speed = speed
        ip.sink.set_spindle(speed, ip.state.direction or ip.state.driven)
    ip.sink.call(f"SET_SPINDLE_SPEED({spindle}, {speed:.4f})", _event(ip, False))


def bound_surface_speed(ip: Interpreter, limit: float, spindle: int = 0) -> None:
    """Begin or go on with G96 at so many rev/min at most, and no more than the machine's spindle makes."""
    limit = min(limit, ip.options.fastest_spindle or limit)
    ip.state.constant_surface = limit
    # D0 leaves the mode in LinuxCNC: a limit of 0 is its sign of G97.
    ip.sink.set_surface_speed(limit or None)
    ip.sink.call(f"SET_SPINDLE_MODE({spindle} {limit:.4f})")


def constant_revolutions(ip: Interpreter, block: Block) -> None:
    """G97: S is rev/min. Without S the spindle keeps the speed that G96 gave it last; LinuxCNC takes the number of S on.

    "In the absence of a new spindle speed being specified, the last speed set with G96 is retained" (SINUMERIK ONE, Fundamentals,
    "Constant cutting rate"); FANUC converts the surface speed, too, and keeps it for the next G96.
    """
    state = ip.state
    kept = state.constant_surface is not None and ip.dialect != "linuxcnc"
    speed = turns_a_minute(state)
    if kept:
        state.surface_speed = state.speed
    state.constant_surface = None
    ip.sink.set_surface_speed(None)
    ip.sink.call(f"SET_SPINDLE_MODE({spindle_of(ip, block)} {0.0:.4f})")
    if kept and "s" not in block.words:
        _take_speed(ip, speed)


CODES = (
    Code("S", 0, "S", Stage.SPEED, set_speed, "spindle speed, rev/min", "s$"),
    *(
        row
        for number, direction, text in (
            (30, 1, "spindle clockwise"),
            (40, -1, "spindle counter-clockwise"),
            (50, 0, "spindle stop"),
        )
        for row in (
            Code("M", number, "spindle", Stage.SPINDLE, partial(_powered, direction=direction), text, "$p",
                dialects=("linuxcnc",), waits=True, restores=("direction", direction)),
            # The spindle of FANUC's machines stops once the motion of the block has been made.
            Code("M", number, "spindle", Stage.SPINDLE if direction else Stage.STOP, partial(_selected, direction=direction), text, "$p",
                dialects=("fanuc",)),
        )
    ),
    Code("M", 190, "spindle", Stage.SPINDLE, orient, "turn the spindle to R degrees", "rpq$", dialects=("linuxcnc",)),
    Code("M", 190, "spindle", Stage.SPINDLE, orient_fanuc, "turn the spindle to R or P degrees", "rp$", dialects=("fanuc",)),
    Code("G", 960, "spindle mode", Stage.SPINDLE_MODE, constant_surface, "constant surface speed S", "sd$", takes="d",
        restores=("constant_surface", True)),
    Code("G", 970, "spindle mode", Stage.SPINDLE_MODE, constant_revolutions, "S is rev/min", "$",
        restores=("constant_surface", False)),
)  # fmt: skip
