"""Codes of FANUC without effect on the plan: look-ahead modes, checks and signals of the control."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import AXES, AXIS_INDEX, Block
from cncgen.gcode.codes.corners import taps
from cncgen.gcode.codes.table import LATHE, OF_FANUC, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import ARMED, PLAIN_MOTIONS, Stage
from cncgen.toolpath.record import Event

_LOOK_AHEAD = "look-ahead mode: accepted, motions are always planned ahead"


def nothing(ip: Interpreter, block: Block) -> None:
    """Accept a code: motions are always planned with look-ahead, and rigid taps follow their pitch by F and S."""


def own_language(ip: Interpreter, block: Block) -> None:
    """G290 of SINUMERIK, which ends its ISO dialect: little stands behind it, mostly the end of the program."""
    message = "G290 switches to SINUMERIK's own language: what follows is read in the ISO dialect still"
    ip.warn_once("other-control", message, "G290", "a part in that language belongs into a file of its own")


def look_ahead(ip: Interpreter, block: Block) -> None:
    """G5 P and G8 P, which stand alone.

    Raises:
        BlockError: An axis word, which the motion in force would take, or R without P: the block is of another control.
    """
    axes = AXIS_INDEX.keys() if not {*PLAIN_MOTIONS} & {*block.g} else ()
    given = next(
        (letter for letter in block.words if letter in axes or (letter == "r" and "p" not in block.words)), ""
    )
    if given:
        message = f"{given.upper()} beside G5 or G8, which take P alone: G5 turns the spindle on Haas's lathes, and is a spline on LinuxCNC"
        hint = "G5 P stands in a block of its own, which is passed over"
        raise BlockError("other-control", message, given.upper(), hint=hint)


def forbid(ip: Interpreter, block: Block) -> None:
    """G22: a zone that the tool must not enter, which is not checked here."""
    hint = "travel_mm of the machine file is checked"
    ip.note_once("zone-not-checked", "the zone of G22 is not checked", "G22", hint)


def cancelled(ip: Interpreter, block: Block) -> None:
    """G15, G50, G69 of Mach and Tormach: the modes that they end are never on; LinuxCNC's own interpreter refuses them.

    Raises:
        BlockError: The program is to be read as LinuxCNC's own.
    """
    if ip.options.stand_alone or ip.options.dialect == "linuxcnc":
        name = next(f"G{number // 10}" for number in block.g if number in _ENDS)
        hint = "LinuxCNC has it not; --dialect auto reads it as Mach and Tormach do: it ends a mode that is never on"
        raise BlockError("unknown-code", f"{name} is not supported", name, hint=hint)


def no_offset(ip: Interpreter, block: Block, name: str, what: str) -> None:
    """G54.2 P0 and G54.4 P0, which end an offset that is never on; raise where one is asked for."""
    if block.words.get("p", 0.0):
        message = f"{name} P{block.words['p']:g} ({what}) is not supported"
        raise BlockError("unknown-code", message, name, hint=f"{name} P0 ends it, and is read")


def _sizes_of_x(ip: Interpreter, block: Block, diameters: int) -> None:
    """G10.9 of Mazak, which may say what X is here anyway: a length on mills, on lathes a diameter."""
    if block.words.get("x") != diameters:
        known = "X0 (lengths)" if not diameters else "X1 (diameters)"
        message = f"G10.9 is read with {known} alone"
        raise BlockError("not-read", message, "G10.9", hint="--dialect chooses between mills and lathes")


def of_mazatrol(ip: Interpreter, block: Block) -> None:
    """G53.5 of Mazak: places count from the origin of the MAZATROL program, which the control alone knows."""
    message = "G53.5 counts from the origin of MAZATROL, which is not known here: the origin in force stays"
    ip.warn_once("builders-point", message, "G53.5", "G54 and --parameters say where the part is")


def _in_position(ip: Interpreter, block: Block, name: str) -> None:
    """,I and ,J of Mitsubishi: how near the axes must be to their place before the next motion begins, which setpoints do not tell."""
    message = f"{name}{block.words[name.lower()]:g} is a width within which the axes count as in position (Mitsubishi): it changes nothing here"
    ip.note_once("other-control", message, name, "G61 and G9 stop exactly")


def _way_out(ip: Interpreter, block: Block) -> None:
    """,S of Mitsubishi: the speed at which a tap comes out.

    Raises:
        BlockError: No tap is in force.
    """
    name = f",S{block.words[',s']:g}"
    if not taps(ip, block):
        message = f"{name} stands in no block of a tap, of which it is the speed of the way out (Mitsubishi)"
        raise BlockError("unused-word", message, ",S", hint="the spindle's speed is S, without a comma")
    message = (
        f"{name} is the speed at which a tap comes out (Mitsubishi): it comes out as fast as it goes in here"
    )
    ip.warn_once("cycle-words", message, ",S", "the way out takes longer than on the machine")


def corner_arc(ip: Interpreter, block: Block) -> None:
    """G39: an arc around the corner under cutter compensation, up to where the next motion begins (B-63324EN, 14.4.9), or to the direction
    I J K (X Y of older controls). Each outside corner has that arc here.

    Raises:
        BlockError: Cutter compensation is off.
    """
    if ip.state.compensation == 40:
        hint = "G41 or G42 before it; G39 is the arc around a corner"
        raise BlockError("comp-refused", "G39 stands outside cutter compensation", "G39", hint=hint)
    given = next((letter for letter in "ijkxyz" if letter in block.words), "")
    if given:
        message = f"{given.upper()} of G39 is a direction that is passed over: the arc ends where the next motion begins"
        hint = "nothing differs where that is the direction of the next motion"
        ip.warn_once("other-control", message, given.upper(), hint)


def bar_feed(ip: Interpreter, block: Block) -> None:
    """G105 of Haas's lathes: the bar feeder pushes the bar, by motions of its own program."""
    message = "G105 feeds the bar by motions of the control's own program: they are not planned, and their time is not counted"
    ip.warn_once("builders-code", message, "G105", "the tool stays where it is")
    ip.sink.call("", Event("user", values={"g": 105}))


def in_step(ip: Interpreter, block: Block, code: int) -> None:
    """G199 and G198 of Haas's lathes: the second spindle turns in step with the first one, R degrees ahead; the slides do not move."""
    message = f"G{code} is for the second spindle of two in step: one spindle is planned for"
    ip.note_once("spindle-number", message, f"G{code}", "it moves no axis")
    ip.sink.call("", Event("user", values={"g": code}))


def rigid(ip: Interpreter, block: Block) -> None:
    """M29: the next row of holes turns the spindle in step with the feed, until G80 or a code of motion."""
    ip.state.rigid = ARMED
    ip.sink.call("", Event("user", values={"m": 29}))


#: Ends of polar coordinates, scaling and rotation: Tormach's and Mach's programs begin with them.
_ENDS = (150, 500, 690)
#: Ends of modes that are never on here, with which heads of programs make sure: normal direction control, polygon turning, mirror images of
#: turrets, synchronised axes; on lathes, of modes of mills too (polar coordinates, tool lengths, mirror images, rotations).
_NEVER_ON, _NEVER_ON_LATHES = (401, 502, 691, 804), (150, 490, 501, 690)
CODES = (
    *(
        Code("G", number, f"end {number}", Stage.COORDINATES, cancelled, "ends a mode that is never on: accepted",
            dialects=("linuxcnc",))
        for number in _ENDS
    ),
    *(
        Code("G", number, f"end {number}", Stage.COORDINATES, nothing, "ends a mode that is never on: accepted", "xyz",
            "own" if number == 501 else "none", dialects=dialects)
        for numbers, dialects in ((_NEVER_ON, OF_FANUC), (_NEVER_ON_LATHES, (LATHE,)))
        for number in numbers
    ),
    *(
        Code("G", number, "speed check", Stage.SPINDLE, nothing, text, "pqrid", dialects=OF_FANUC)
        for number, text in ((250, "the spindle's speed is not watched"), (260, "the spindle's speed is watched: accepted, not checked"))
    ),
    Code("G", 535, "MAZATROL", Stage.COORDINATES, of_mazatrol, "the origin of MAZATROL (Mazak): the one in force stays", dialects=OF_FANUC),
    Code("G", 525, "MAZATROL", Stage.COORDINATES, nothing, "end of G53.5 (Mazak)", dialects=OF_FANUC),
    *(
        Code("G", number, what, Stage.COORDINATES, partial(no_offset, name=f"G{number / 10:g}", what=f"a {what}"), f"no {what} (P0)",
            "p", dialects=OF_FANUC)
        for number, what in ((542, "dynamic fixture offset"), (544, "workpiece setting error compensation"))
    ),
    Code("G", 50, "look-ahead", Stage.PATH, look_ahead, _LOOK_AHEAD, "pqr", dialects=OF_FANUC),
    Code("G", 1030, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD + " (Haas)", "p", dialects=OF_FANUC),
    Code("G", 1870, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD + " (Haas)", "pe", dialects=OF_FANUC),
    Code("G", 51, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD, AXES + "pqr", "own", dialects=OF_FANUC),
    Code("G", 53, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD + " (Hurco)", "p", dialects=OF_FANUC),
    Code("G", 2910, "language", Stage.PATH, nothing, "SINUMERIK's ISO dialect: accepted", dialects=OF_FANUC),
    Code("G", 2900, "language", Stage.PATH, own_language, "SINUMERIK's own language: read on as FANUC's, with a warning", dialects=OF_FANUC),
    *(
        Code("G", 109, "diameters", Stage.PATH, partial(_sizes_of_x, diameters=diameters), text, "x", "own", dialects=dialects,
            axis_words="sizes")
        for diameters, text, dialects in ((0, "X is a radius (X0 of Mazak)", OF_FANUC), (1, "X is a diameter (X1 of Mazak)", (LATHE,)))
    ),
    Code("G", 611, "path", Stage.PATH, nothing, _LOOK_AHEAD + " (Mazak's geometry compensation)", "pqr", dialects=OF_FANUC,
        named=(",k",)),
    Code("G", 80, "look-ahead", Stage.PATH, look_ahead, _LOOK_AHEAD, "pqr", dialects=OF_FANUC),
    Code("G", 220, "stroke check", Stage.PATH, forbid, "forbidden zone: accepted, not checked", "xyzijk", "own", dialects=OF_FANUC),
    Code("G", 230, "stroke check", Stage.PATH, nothing, "no forbidden zone", dialects=OF_FANUC),
    *(
        Code("G", number, "blank", Stage.PATH, nothing, "the blank that MANUAL GUIDE i draws: passed over", AXES + "dehijklpqr",
            "own", takes="dh", dialects=OF_FANUC)
        for number in range(19_000, 19_080, 10)
    ),
    Code("G", 1050, "bar feed", Stage.MOTION, bar_feed, "the bar feeder pushes the bar (Haas): an event", "ijkpr", dialects=(LATHE,)),
    *(
        Code("G", 10 * code, "spindles in step", Stage.SPINDLE, partial(in_step, code=code), text, "r", dialects=(LATHE,))
        for code, text in ((198, "end of G199 (Haas): an event"), (199, "the second spindle turns in step with the first (Haas): an event"))
    ),
    Code("G", 390, "non-modal", Stage.PATH, corner_arc, "the arc around an outside corner under G41 and G42, as at any such corner",
        "ijkxyz", "own", dialects=OF_FANUC, without="lathes", axis_words="sizes"),
    *(
        Code(name, 0, "in position", Stage.PATH, partial(_in_position, name=name), text, dialects=OF_FANUC, named=(name.lower(),))
        for name, text in ((",I", "a width of the axes in position (Mitsubishi): passed over"),
            (",J", "that of the drilling axis (Mitsubishi): passed over"))
    ),
    Code(",S", 0, "way out", Stage.PATH, _way_out, "the speed at which a tap comes out (Mitsubishi): passed over", dialects=OF_FANUC,
        named=(",s",)),
    Code("M", 290, "rigid tapping", Stage.SPINDLE, rigid, "the next row of taps in step with the spindle", dialects=OF_FANUC),
)  # fmt: skip
