"""Motion in step with the spindle: G33 and G33.1."""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lines import has_axis
from cncgen.gcode.codes.table import SYNCHRONISED, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.records import replace

_WORDS = "xyzabcuvwk$@^"


def _pitch(ip: Interpreter, block: Block, name: str) -> float:
    """Return K, after the conditions of synchronised motion were checked."""
    if "k" not in block.words:
        raise BlockError("pitch-missing", f"{name} has no pitch K", name)
    pitch = block.words["k"]
    if pitch <= 0.0:
        raise BlockError("pitch-missing", f"K{pitch:g} of {name}: the pitch must be above 0", "K")
    if ip.state.direction == 0:
        raise BlockError("spindle-stopped", f"{name} moves in step with a spindle that does not turn", name)
    return pitch


def thread(ip: Interpreter, block: Block) -> None:
    """G33 K: a line of K a revolution."""
    state = ip.state
    state.motion = 330
    if not has_axis(block):
        return
    pitch = _pitch(ip, block, "G33")
    in_step(ip, pitch, ip.end_point(block))


def in_step(ip: Interpreter, pitch: float, end: list[float]) -> None:
    """Feed to `end` in step with the spindle, and put the feed back."""
    sink = ip.sink
    sink.call(f"START_SPEED_FEED_SYNC({pitch:f},0)")
    sink.synchronise(pitch)
    sink.straight_feed(end)
    sink.synchronise(None)
    sink.call("STOP_SPEED_FEED_SYNCH()")
    ip.state.position, ip.state.moved = end, True


def thread_fanuc(ip: Interpreter, block: Block) -> None:
    """G33 F of FANUC: a line of F a revolution; F stays in force from thread to thread."""
    state = ip.state
    if state.motion != 330:
        state.pitch = 0.0
    state.motion = 330
    words = block.words
    state.pitch = words.get("f", words.get("k", state.pitch))
    if not has_axis(block):
        return
    if state.pitch <= 0.0:
        message = f"G33 has no pitch: F is {state.pitch:g}"
        hint = "F is the distance a revolution"
        raise BlockError("pitch-missing", message, "F" if "f" in words else "G33", hint=hint)
    thread(ip, replace(block, words={**words, "k": state.pitch}))


def tap(ip: Interpreter, block: Block) -> None:
    """G33.1 K: to the end and back, K a revolution, the spindle reversed at the end."""
    state = ip.state
    state.motion = 331
    if not has_axis(block):
        return
    pitch = _pitch(ip, block, "G33.1")
    end = ip.end_point(block)
    if end[3:] != state.position[3:]:
        raise BlockError("tapping-axes", "G33.1 moves X Y Z only", "G33.1")
    ip.sink.call(f"START_SPEED_FEED_SYNC({pitch:f},0)")
    ip.sink.rigid_tap(end, pitch)
    ip.sink.call("STOP_SPEED_FEED_SYNCH()")
    state.moved = True


CODES = (
    Code("G", 330, "motion", Stage.MOTION, thread, "line in step with the spindle, K a revolution", _WORDS, "motion",
        dialects=("linuxcnc",), pitched=True, waits=True,
        refused=SYNCHRONISED),
    Code("G", 330, "motion", Stage.MOTION, thread_fanuc, "line in step with the spindle, F a revolution", _WORDS + "fq", "motion",
        dialects=("fanuc",), takes="f", refused=SYNCHRONISED, without="lathes"),
    Code("G", 331, "motion", Stage.MOTION, tap, "rigid tapping, K a revolution", _WORDS + "i", "motion", pitched=True, refused=SYNCHRONISED,
        without="lathes"),
)  # fmt: skip
