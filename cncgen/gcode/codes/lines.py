"""G0 and G1, straight motions; G53 and G80. Source: Kramer et al. (2000), sections 3.5.1, 3.5.2, 3.5.12 and 3.5.15."""

from __future__ import annotations

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.codes.table import IN_MACHINE, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import NO_MOTION, PLAIN_MOTIONS, Stage

_WORDS = "xyzabcuvw@^"
_FEEDS = frozenset(PLAIN_MOTIONS) - {0}


def check_feed(ip: Interpreter, block: Block, name: str) -> None:
    """Report where a feed motion has no feed, at the first one alone: those after it lack the same word, and all are made.

    Raises:
        BlockError: A block in inverse time mode (G93) has no F, or F0.
    """
    state = ip.state
    if state.feed_mode == 93:
        if "f" not in block.words:
            message = f"{name} in inverse time mode (G93) needs F in its own block"
            raise BlockError("feed-missing", message, name)
        if state.feed == 0.0:
            raise BlockError("feed-zero", "F0 in inverse time mode (G93) would take for ever", "F")
        return
    if state.feed == 0.0:
        message = f"{name} with no feed rate: F was not given or is 0"
        ip.fault_once("feed-missing", message, name, "add an F word")
    elif state.feed_mode == 95 and (
        state.speed == 0.0 or not (state.direction or state.driven or state.rigid or ip.options.stand_alone)
    ):
        message = f"{name} with feed per revolution (G95), but the spindle does not turn"
        ip.fault_once("spindle-stopped", message, name)


def check_cycle_feed(ip: Interpreter, block: Block, name: str) -> None:
    """As `check_feed`, of a cycle, whose F is a speed: its motions are many, and an inverse time would be of one (RS274/NGC, 3.5.16).

    Raises:
        BlockError: G93 is in force.
    """
    if ip.state.feed_mode == 93:
        raise BlockError("cycle-feed-mode", f"{name} needs G94 or G95, and G93 is in force", name)
    check_feed(ip, block, name)


def inverse_rate(ip: Interpreter) -> float | None:
    """Return the rate (1/min) of a motion in inverse time mode, None in the others."""
    return ip.state.feed if ip.state.feed_mode == 93 else None


def has_axis(block: Block) -> bool:
    """Tell whether the block has an axis word."""
    return not AXIS_INDEX.keys().isdisjoint(block.words) or "@" in block.words or "^" in block.words


def need_axis(block: Block, name: str, hint: str = "") -> None:
    """Raise where a code has no axis word."""
    if not has_axis(block):
        raise BlockError("axis-missing", f"{name} has no axis word", name, hint=hint)


def traverse(ip: Interpreter, block: Block) -> None:
    """G0."""
    ip.state.motion = 0
    end = ip.end_point(block)
    ip.sink.straight_traverse(end)
    ip.state.moved = ip.state.moved or end != ip.state.position
    ip.state.position = end


def feed(ip: Interpreter, block: Block) -> None:
    """G1."""
    state = ip.state
    state.motion = 10
    if state.feed_mode != 94 or state.feed == 0.0:
        check_feed(ip, block, "G1")
    ip.go(ip.end_point(block))


def cancel(ip: Interpreter, block: Block) -> None:
    """G80."""
    ip.state.motion = NO_MOTION
    ip.sink.call('COMMENT("interpreter: motion mode set to none")')


def cancel_cycle(ip: Interpreter, block: Block) -> None:
    """G80 of FANUC: end of a canned cycle, and of M29; the motion code before it is in force again."""
    state = ip.state
    state.rigid = 0
    if state.cycle is not None:
        state.motion, state.cycle = state.under, None


def machine_coordinates(ip: Interpreter, block: Block) -> None:
    """G53: told to the motion by its presence (`Interpreter.end_point`).

    FANUC's controls traverse in its block (B-63534EN, 7.1). G1 beside it feeds here, as the programs that have it mean it.
    """
    if ip.dialect != "fanuc" or AXIS_INDEX.keys().isdisjoint(block.words):
        return
    beside = not _FEEDS.isdisjoint(block.g)
    if beside or (ip.state.motion in _FEEDS and not {*PLAIN_MOTIONS} & {*block.g}):
        does, others = (
            ("feeds: G1 stands beside it", "the manuals of FANUC have it traverse")
            if beside
            else ("traverses, though G1 is in force", "controls that keep G1 beside G53 feed")
        )
        hint = "write G0 G53: all controls traverse by it"
        ip.warn_once("other-control", f"G53 {does}; {others}", "G53", hint)


CODES = (
    Code("G", 530, "non-modal", Stage.REFERENCE, machine_coordinates, "axis words are machine coordinates",
        axis_words="absolute", refused=IN_MACHINE),
    Code("G", 0, "motion", Stage.MOTION, traverse, "traverse at the machine's own speed", _WORDS, "motion", waits=True),
    Code("G", 10, "motion", Stage.MOTION, feed, "straight feed", _WORDS, "motion", waits=True),
    Code("G", 800, "motion", Stage.MOTION, cancel, "no motion mode: end of a canned cycle", "", "motion", dialects=("linuxcnc",),
        waits=True),
    Code("G", 800, "canned cycle", Stage.REFERENCE, cancel_cycle, "end of a canned cycle: G0 to G3 before it is in force again",
        dialects=("fanuc",)),
)  # fmt: skip
