"""FANUC's lathes, system A of G codes: X is a diameter, U and W are distances, T has the tool and its offset.

G32 cuts threads, G50 bounds the spindle's speed or names the position, G98 and G99 set the meaning of F. The cycles are in
`simple_cycles_fanuc`, `turning_cycles_fanuc`, `pecking_cycles_fanuc`, `thread_cycles_fanuc` and `lathe_drilling_fanuc`.

Source: FANUC 0i-TD operator's manual B-64304EN-1, sections 4.1 (threads), 8.4 (diameters), 3 (G codes of system A).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.cutter_compensation import interrupt
from cncgen.gcode.codes.dwell import has_point
from cncgen.gcode.codes.feeds import set_mode
from cncgen.gcode.codes.lathe_words import X, Z
from cncgen.gcode.codes.lines import has_axis
from cncgen.gcode.codes.offsets_fanuc import preset_position
from cncgen.gcode.codes.offsets_fanuc import set_data as set_mill_data
from cncgen.gcode.codes.spindle import set_speed
from cncgen.gcode.codes.synchronised import in_step
from cncgen.gcode.codes.table import (
    CHANGES_OFFSETS,
    LATHE,
    LATHE_ABSOLUTE,
    LATHE_STEPS,
    LATHE_TO_R,
    LATHE_TO_START,
    LATHES,
    PROFILE,
    ROTARY_PATH,
    Code,
)
from cncgen.gcode.codes.tools import known, load_tool_parameters, table_offset, use_offset, whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage, zeros
from cncgen.gcode.text import signs
from cncgen.gcode.text.built_patterns import compiled
from cncgen.gcode.text.expressions import LEAST_INCREMENT
from cncgen.gcode.text.labels import Cursor
from cncgen.machine.tool_table import TIPS
from cncgen.records import dataclass, field, replace
from cncgen.toolpath.record import Event

ONLY = (LATHE,)
_OTHER_SYSTEMS = tuple(dialect for dialect, renamed in LATHES.items() if renamed)
_THREAD, _VARYING = 320, 340
_G40, _OFF = 400, 40
_STARTS = frozenset((30, 40))


@dataclass(slots=True)
class Turning:
    """Settings that the cycles keep, lengths in radius.

    Attributes:
        x, z, taper: Of G90, G92, G94.
        depth, escape: G71 U R, G72 W R.
        pattern: G73 U W R: the way of all passes in X and Z, and how many they are.
        back: G74 R, G75 R.
        passes, chamfer, angle, least, finish: G76 P Q R: passes at full depth, chamfer in tenths of the lead, angle of the
            tool in degrees, least depth of a pass, what the last pass takes.
        places: First and last line of the profiles by P and Q; G70 takes the roughed one.
        compensation: The code, in tenths, that a roughing cycle begins again, or 0.
    """

    x: float | None = None
    z: float | None = None
    taper: float = 0.0
    depth: float = 0.0
    escape: float = 0.0
    pattern: tuple[float, float, int] = (0.0, 0.0, 1)
    back: float = 0.0
    passes: int = 1
    chamfer: int = 0
    angle: float = 0.0
    least: float = 0.0
    finish: float = 0.0
    places: dict[tuple[int, int], tuple[Cursor, Cursor]] = field(default_factory=dict)
    compensation: int = 0


#: Lengths in mm from which on a whole number without a decimal point cannot be meant as a length: the depth of a cut and the way of all
#: passes, how far a tool lifts off, an allowance, and what the last pass of a thread takes.
DEEP, LIFT, ALLOWANCE, THREAD_FINISH = 50.0, 20.0, 10.0, 2.0
#: Words of which each form of the cycles G70 to G76 uses some; F, S and T act by themselves.
_WORDS_OF_CYCLES = "uwrpqikda"


def turning_of(ip: Interpreter) -> Turning:
    """Return the state of the cycles of this program."""
    state = ip.state
    if state.turning is None:
        state.turning = Turning()
    assert isinstance(state.turning, Turning)
    return state.turning


def increments(ip: Interpreter, block: Block, letter: str) -> float:
    """Return P or Q of a cycle, whose whole numbers count in least increments, as a length; others are lengths.

    So is a whole number with a decimal point, which FANUC's controls refuse, where it can be meant as one: ``P2.`` is not ``P4000.0``.
    """
    value = block.words[letter]
    scaled = letter == "q" and ip.options.least_increment is not None
    if scaled or value != round(value):
        return value
    short = abs(value) * ip.state.unit_mm < DEEP
    if short and has_point(ip, block, letter):
        return value
    return _of_increments(ip, value)


def _of_increments(ip: Interpreter, value: float) -> float:
    return value * (ip.options.least_increment or LEAST_INCREMENT) / (10.0 if ip.state.inches else 1.0)


def length_of(ip: Interpreter, block: Block, letter: str, name: str, least_mm: float) -> float:
    """Return a word of a cycle as a length.

    Controls count a number without a decimal point in least increments: ``G71 U1250 R500`` are 1.25 and 0.5 mm, 0.125 and 0.05 inch.
    A whole number below `least_mm` is a length all the same, as ``U2 R1``.
    """
    value = block.words[letter]
    size = abs(value) * ip.state.unit_mm
    if size < least_mm or value != round(value) or ip.options.least_increment is not None:
        return value
    if has_point(ip, block, letter) is not False:
        return value
    length, word = _of_increments(ip, value), letter.upper()
    message = f"{word}{value:g} of {name} is read as {length:g} (least increments), not as {value:g}"
    hint = f"a length has a decimal point: {word}{length:g}{'' if length % 1.0 else '.'}"
    ip.warn_once("profile-step", message, word, hint)
    return length


def check_idle(ip: Interpreter, block: Block, name: str, used: str, hint: str) -> None:
    """Warn of words of a cycle that this form of it has no use for."""
    idle = [letter.upper() for letter in _WORDS_OF_CYCLES if letter in block.words and letter not in used]
    if idle:
        message = f"{', '.join(idle)} of {name} change{'s' if len(idle) == 1 else ''} nothing here"
        ip.warn("unused-word", message, idle[0], hint)


def depth_of(ip: Interpreter, block: Block, name: str) -> float:
    """Return the depth D of a cut as a length."""
    return abs(length_of(ip, block, "d", name, DEEP))


def go_to(ip: Interpreter, places: dict[int, float], feed: bool) -> None:
    """Feed or traverse to places of axes, by column, unless the tool is there."""
    end = ip.state.position.copy()
    for axis, place in places.items():
        end[axis] = place
    if end != ip.state.position:
        ip.go(end, rapid=not feed)


def check_spindle(ip: Interpreter, name: str) -> None:
    """Raise where a thread would be cut with a spindle at rest."""
    if ip.state.direction == 0 or ip.state.speed == 0.0:
        raise BlockError("spindle-stopped", f"{name} cuts in step with a spindle that does not turn", name)


def cut_thread(ip: Interpreter, end: list[float], lead: float) -> None:
    """Feed to `end` in step with the spindle; the lead is along the axis that goes farther (B-64304EN-1, 4.1)."""
    run, rise = end[Z] - ip.state.position[Z], end[X] - ip.state.position[X]
    farther = max(abs(run), abs(rise))
    if farther:
        lead *= (run**2 + rise**2) ** 0.5 / farther
    in_step(ip, lead, end)


def lead_of(ip: Interpreter, block: Block, name: str, number: int) -> float:
    """Return F of a thread, which stays in force from thread to thread."""
    state = ip.state
    if state.motion != number:
        state.pitch = 0.0
    state.pitch = block.words.get("f", state.pitch)
    if state.pitch <= 0.0 and has_axis(block):
        at = "F" if "f" in block.words else name
        hint = "F is the distance a revolution"
        raise BlockError("pitch-missing", f"{name} has no lead: F is {state.pitch:g}", at, hint=hint)
    return state.pitch


def thread(ip: Interpreter, block: Block) -> None:
    """G32 F: a line in step with the spindle, along Z, X or both; Q is the spindle's angle that it begins at.

    The spindle's angle is not planned, so that Q moves the beginning by less than a turn.
    """
    lead = lead_of(ip, block, "G32", _THREAD)
    ip.state.motion = _THREAD
    if has_axis(block):
        check_spindle(ip, "G32")
        cut_thread(ip, ip.end_point(block), lead)


def thread_of_varying_lead(ip: Interpreter, block: Block) -> None:
    """G34 F K: as G32, with a lead of F at the start that grows by K each turn, or falls (B-64304EN-1, 4.2; M700V lathes, 6.6.3).

    After n turns the tool is F n + K n² / 2 along the axis that goes farther: each turn is a motion of its own, with its mean lead.

    Raises:
        BlockError: ``pitch-missing``: there is no K, or the lead falls to 0 before the end.
    """
    first = lead_of(ip, block, "G34", _VARYING)
    ip.state.motion = _VARYING
    if not has_axis(block):
        return
    check_spindle(ip, "G34")
    growth = block.words.get("k", 0.0)
    if not growth:
        hint = "K is how much the lead grows each turn; G32 has one lead"
        raise BlockError("pitch-missing", "G34 has no change K of the lead", "G34", hint=hint)
    start, end = list(ip.state.position), ip.end_point(block)
    way = max(abs(end[axis] - start[axis]) for axis in (X, Z))
    for share, lead in turns_of_varying_lead("G34", "K", first, growth, way):
        place = [a + share * (b - a) for a, b in zip(start, end, strict=True)] if share < 1.0 else end
        cut_thread(ip, place, lead)


def turns_of_varying_lead(
    name: str, word: str, first: float, growth: float, way: float
) -> Iterator[tuple[float, float]]:
    """Yield of each turn of a thread the part of the way at its end, and its mean lead: n turns go first n + growth n² / 2.

    Args:
        name, word: The code of the thread, and its word of the growth.
        first: The lead at the start.
        growth: How much it grows each turn, not 0.
        way: How far the thread goes along the axis of the lead.

    Raises:
        BlockError: ``pitch-missing``: the lead falls to 0 before the end.
    """
    last = first**2 + 2.0 * growth * way
    if last < 0.0:
        message = f"the lead of {name} falls from {first:g} by {-growth:g} a turn to 0 after {first**2 / (-2.0 * growth):.4g} of {way:.4g}"
        hint = f"a larger lead at the start, a smaller {word} or a shorter thread"
        raise BlockError("pitch-missing", message, word, hint=hint)
    turns = (last**0.5 - first) / growth
    number, gone = 0, 0.0
    while number < turns:
        done, number = number, number + 1
        until = min(float(number), turns)
        reached = first * until + growth * until**2 / 2.0
        yield (1.0 if until == turns else reached / way), (reached - gone) / (until - done)
        gone = reached


def name_position(ip: Interpreter, block: Block) -> None:
    """G50: S is the largest speed of G96; X Z name the position."""
    if ip.state.compensation != _OFF and has_axis(block):
        interrupt(ip, block, "G50", "names the position")
    if "s" in block.words and has_axis(block) and not _STARTS.isdisjoint(block.m):
        # A spindle that starts in the block has its speed in it: G50 X100 Z50 M3 S300 of GSK's manuals.
        message = f"S{block.words['s']:g} of G50 X Z M3 is taken as the speed that the spindle starts with"
        hint = (
            "FANUC's controls take S beside G50 as the largest speed of G96; write it in a block of its own"
        )
        ip.warn_once("other-control", message, "S", hint)
        set_speed(ip, block)
        block = block.without("s")
    preset_position(ip, block, "G50")


#: The largest T of two digits each for tool and offset.
_FOUR_DIGITS = 9999
#: T of five digits as it is written.
_FIVE_DIGITS = rb"(?<![A-Z])T[ \t]*(\d{5})(?![\d.])"


def turret(ip: Interpreter, block: Block) -> None:
    """T: the last two digits are the offset (0: none), those before it the tool, which the turret turns in.

    Of five digits, three are the offset: controls with more than 99 offsets count so (parameter 5028), T01001 is tool 1 with offset 1.
    """
    word = whole(block, "t", "")
    number, offset = divmod(word, 100)
    if _has_long_offset(ip, block):
        number, offset = divmod(word, 1000)
        message = (
            "five digits of T are two of the tool and three of its offset: T01002 is tool 1 with offset 2"
        )
        hint = "controls whose offsets have two digits read tool 10 with offset 2; four digits are beyond doubt: T0102"
        ip.warn_once("other-control", message, "T", hint)
    elif word > _FOUR_DIGITS:
        message = f"T{word} is read as tool {number} with offset {offset}; on Okuma's lathes T010203 is nose radius 1, tool 2, offset 3"
        ip.warn_once("other-control", message, "T", "T0203 is tool 2 with offset 3 here")
    state = ip.state
    if _G40 in block.g:
        ip.end_compensation()
    known(ip.tools.find(offset), f"tool offset {offset} of T{word}", "T")
    offsets = table_offset(ip, offset, "T") if offset else zeros()
    if state.compensation != _OFF and (
        offsets != state.tool_offset or _tip(ip, state.tool) != _tip(ip, offset)
    ):
        interrupt(ip, block, f"T{word}", "changes the tool's offset")
    if number and number != state.selected:
        state.selected = state.fetched = number
        event = Event("tool", True, values={"tool": number})
        ip.sink.call(f"CHANGE_TOOL({ip.tools.place_of(number)})", event)
    # Cutter compensation takes radius and direction of the tool's tip from the offset.
    state.tool = offset
    load_tool_parameters(ip)
    use_offset(ip, offsets, "T")


def _has_long_offset(ip: Interpreter, block: Block) -> bool:
    """Tell whether T of a block is written in five digits of which three are the offset.

    They are not where tool and offset of two digits have one number, or a tool of two digits would be 0: T01010, T00101.
    """
    if ip.flow is None:
        return False
    line = ip.flow.subroutines.sources[block.source].text_at(block.offset).upper().encode()
    found = compiled(_FIVE_DIGITS).search(compiled(signs.OUT_OF_CODE).sub(b"", line))
    return found is not None and found[1][:2] != b"00" and found[1][:3] != b"0" + found[1][3:]


def _tip(ip: Interpreter, offset: int) -> tuple[float, int]:
    """Return diameter and direction of a tool's tip."""
    tool = ip.tools.find(offset)
    return (0.0, 0) if tool is None else (tool.diameter, tool.orientation)


#: Kinds of G10 that lathes share with mills: coordinate systems and data of the control.
_SHARED_DATA = (2, 3, 20, 50, 52)
#: P of G10 from which on it is the geometry of an offset, and below which its wear.
_GEOMETRY = 10_000
#: Words of an offset, and of a step of it: place in `Tool.wear`, or None for the tip's radius.
_OFFSET_WORDS = {"x": ("u", X, 2), "z": ("w", Z, 0)}


def set_data(ip: Interpreter, block: Block) -> None:
    """G10 P X Z R Q: the wear of offset P, or (P10000 and more, L10) its geometry; U W C are steps (B-64304EN-1, 7.2).

    P0 is the shift of the work coordinate systems. L2, L20 and data of the control are as on mills. An offset counts from the next T.

    Raises:
        BlockError: P is missing, or names no offset.
    """
    words = block.words
    kind = whole(block, "l", "G10") if "l" in words else 0
    number = whole(block, "p", "G10") if "p" in words else None
    if kind in _SHARED_DATA or (number == 0 and not kind):
        data = words if kind else {**words, "l": 2.0}
        set_mill_data(ip, replace(block, words=data))
        return
    if number is None or kind not in (0, 1, 10, 11):
        at, hint = (
            ("G10", "P is the number of the offset") if number is None else ("L", "L10 is geometry, L11 wear")
        )
        message = "G10 has no P" if number is None else f"L{kind} of G10 is not read"
        raise BlockError("g10-words", message, at, hint=hint)
    geometry = kind == 10 or number >= _GEOMETRY
    tool = known(ip.tools.entry(number % _GEOMETRY), f"tool offset {number % _GEOMETRY}", "P")
    scale = ip.table_scale()
    for letter, (step, axis, place) in _OFFSET_WORDS.items():
        worn = tool.wear[place]
        base, now = tool.offset[axis] - worn, worn
        if letter in words or step in words:
            half = 0.5 if step == "u" else 1.0
            value = words[letter] / scale if letter in words else half * words[step] / scale
            if geometry:
                base = value if letter in words else base + value
            else:
                now = value if letter in words else now + value
        tool.wear[place], tool.offset[axis] = now, base + now
    tool.diameter = 2.0 * (
        words["r"] / scale if "r" in words else tool.diameter / 2.0 + words.get("c", 0.0) / scale
    )
    if "q" in words:
        tip = whole(block, "q", "G10")
        if tip >= len(TIPS):
            raise BlockError("tool-orientation", f"Q{tip}: the direction of a tip is 0 to 9", "Q")
        tool.orientation = TIPS[tip]


def nothing(ip: Interpreter, block: Block) -> None:
    """Do nothing: the words of a block say it (`lathe_words`), or it is so always."""


def _retract(ip: Interpreter, block: Block, old: bool) -> None:
    """G98 and G99 of systems B and C: cycles of holes end where they began, or at R."""
    ip.state.retract_old = old


CODES = (
    Code("T", 0, "T", Stage.TOOL, turret, "tool and its offset: T0102 is tool 1 with offset 2", "t", dialects=ONLY,
        refused=("changes the tool", ROTARY_PATH)),
    Code("M", 60, "tool change", Stage.CHANGE, nothing, "no more than T has done: the turret has turned", dialects=ONLY),
    Code("G", _THREAD, "motion", Stage.MOTION, thread, "line in step with the spindle, F a revolution", "xyzuvwfq", "motion",
        dialects=ONLY, takes="f", refused=("cuts a thread", ROTARY_PATH | PROFILE)),
    Code("G", _VARYING, "motion", Stage.MOTION, thread_of_varying_lead, "as G32, the lead F growing by K each turn", "xyzuvwfkq",
        "motion", dialects=ONLY, takes="f", refused=("cuts a thread", ROTARY_PATH | PROFILE)),
    Code("G", 100, "non-modal", Stage.REFERENCE, set_data, "set a tool's offset, or a coordinate system", "xyzuvwcrqlp", "own",
        dialects=ONLY, refused=CHANGES_OFFSETS),
    Code("G", 500, "non-modal", Stage.REFERENCE, name_position, "S is the largest speed of G96; X Z C U W name the position",
        "xyzuvwcs", "own", dialects=ONLY, axis_words="absolute", takes="s", refused=CHANGES_OFFSETS),
    Code("G", 980, "feed mode", Stage.FEED_MODE, partial(set_mode, mode=94), "F is units per minute", dialects=ONLY),
    Code("G", 990, "feed mode", Stage.FEED_MODE, partial(set_mode, mode=95), "F is units per revolution of the spindle",
        dialects=ONLY),
    *(
        Code("G", number, group, Stage.DISTANCE, run, text, dialects=_OTHER_SYSTEMS)
        for number, group, run, text in (
            (LATHE_ABSOLUTE, "distance", nothing, "axis words are coordinates"),
            (LATHE_STEPS, "distance", nothing, "axis words are distances"),
            (LATHE_TO_START, "retract", partial(_retract, old=True), "drilling cycles go back to where they began"),
            (LATHE_TO_R, "retract", partial(_retract, old=False), "drilling cycles go back to R"),
        )
    ),
)  # fmt: skip
