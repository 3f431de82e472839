"""Cycles of one pass on FANUC's lathes: G90 along Z, G94 along X, G92 a thread. Each leads back to where it began.

They stay in force: a block of X (U), Z (W) or R alone repeats the cycle with the new value (B-64304EN-1, 4.2).
"""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lathe_fanuc import (
    ONLY,
    Turning,
    check_spindle,
    cut_thread,
    go_to,
    lead_of,
    turning_of,
)
from cncgen.gcode.codes.lathe_words import X, Z
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.offsets_fanuc import preset_position
from cncgen.gcode.codes.table import IS_TURNING, SYNCHRONISED, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

_ALONG, _THREAD, _ACROSS = 900, 920, 940
_WORDS = "xzuwr"


def _words(ip: Interpreter, block: Block, number: int) -> Turning | None:
    """Take the words of a block; None where it only puts the cycle in force; raise where X or Z was not given yet."""
    kept, state, words = turning_of(ip), ip.state, block.words
    if state.motion != number:
        kept.x = kept.z = None
        kept.taper = 0.0
    state.motion = number
    if not words.keys() & set("xzrik"):
        return None
    kept.x, kept.z = words.get("x", kept.x), words.get("z", kept.z)
    # I and K of older controls (6T, 0T) are R of the cycle along Z and across.
    older = "k" if number == _ACROSS else "i"
    kept.taper = words.get("r", words.get(older, kept.taper))
    missing = [letter for letter, value in (("X", kept.x), ("Z", kept.z)) if value is None]
    if missing:
        name = f"G{number // 10}"
        hint = f"the first block of the cycle has X (U) and Z (W), as in {name} X40 Z-30"
        raise BlockError("cycle-words", f"{name} has no {missing[0]}", name, hint=hint)
    return kept


def go(ip: Interpreter, x: float, z: float, feed: bool) -> None:
    """Feed or traverse in X and Z."""
    go_to(ip, {X: x, Z: z}, feed)


def _pass(ip: Interpreter, block: Block, name: str, number: int) -> None:
    """G90: to X, along Z, out to where X was, and back; or G94: to Z, along X, out to where Z was. With R it begins R from there."""
    cut = _words(ip, block, number)
    if cut is None or cut.x is None or cut.z is None:
        return
    check_feed(ip, block, name)
    x, z = ip.state.position[X], ip.state.position[Z]
    begin, end = (
        ((cut.x + cut.taper, z), (x, cut.z)) if number == _ALONG else ((x, cut.z + cut.taper), (cut.x, z))
    )
    go(ip, *begin, False)
    go(ip, cut.x, cut.z, True)
    go(ip, *end, True)
    go(ip, x, z, False)


def thread(ip: Interpreter, block: Block) -> None:
    """G92 F: to X, a thread along Z, out and back; the spindle's angle Q that it begins at is not planned."""
    if "s" in block.words and block.words.keys().isdisjoint(_WORDS + "f"):
        message = "G92 S is taken as the largest speed of the spindle, as systems B and C of lathes' G codes have it"
        ip.warn("other-control", message, "G92", "system A has G50 S; --dialect fanuc-lathe-b reads system B")
        preset_position(ip, block, "G92")
        return
    lead = lead_of(ip, block, "G92", _THREAD)
    cut = _words(ip, block, _THREAD)
    if cut is None or cut.x is None or cut.z is None:
        return
    check_spindle(ip, "G92")
    if not cut.chamfer:
        message = "the thread of G92 ends without a chamfer; by its parameter 5130 a control leaves it at 45 degrees before its end"
        hint = "P of G76 sets the chamfer: G76 P011060 leaves over one lead, in threads of G92 too"
        ip.note_once("thread-chamfer", message, "G92", hint)
    start_x, start_z = ip.state.position[X], ip.state.position[Z]
    go(ip, cut.x + cut.taper, start_z, False)
    thread_pass(ip, cut.x, cut.z, lead, 0.1 * cut.chamfer * lead, start_x)
    go(ip, start_x, cut.z, False)
    go(ip, start_x, start_z, False)


def thread_pass(ip: Interpreter, x: float, z: float, lead: float, chamfer: float, out: float) -> None:
    """Cut a thread to X and Z; its last piece, `chamfer` along Z, leaves at 45 degrees up to X `out`.

    Raises:
        BlockError: The thread is shorter than its chamfer.
    """
    position = ip.state.position
    run = z - position[Z]
    if chamfer >= abs(run):
        message = f"the thread of {abs(run):g} along Z is no longer than its chamfer, {chamfer:g}"
        raise BlockError("thread-words", message, "Z", hint="the chamfer is P of G76, in tenths of the lead")
    end = position.copy()
    if chamfer:
        part = 1.0 - chamfer / abs(run)
        end[X], end[Z] = position[X] + part * (x - position[X]), position[Z] + part * run
        cut_thread(ip, end, lead)
        slant = min(chamfer, abs(out - end[X]))
        end = end.copy()
        end[X] += math.copysign(slant, out - end[X])
        if slant < chamfer:
            # Off the thread before its end: on along it from there.
            end[Z] += math.copysign(slant, run)
            cut_thread(ip, end, lead)
            end = end.copy()
        end[Z] = z
    else:
        end[X], end[Z] = x, z
    cut_thread(ip, end, lead)


CODES = (
    Code("G", _ALONG, "motion", Stage.MOTION, partial(_pass, name="G90", number=_ALONG), "cut along Z to X and Z, and back",
        _WORDS + "i", "motion", summons="xzuwr", dialects=ONLY, moves="XZ", refused=IS_TURNING),
    Code("G", _THREAD, "motion", Stage.MOTION, thread, "cut a thread of lead F to X and Z, and back", _WORDS + "fiq", "motion",
        summons="xzuwr", dialects=ONLY, takes="f", moves="XZ", refused=SYNCHRONISED),
    Code("G", _ACROSS, "motion", Stage.MOTION, partial(_pass, name="G94", number=_ACROSS), "cut along X to X and Z, and back",
        _WORDS + "k", "motion", summons="xzuwr", dialects=ONLY, moves="XZ", refused=IS_TURNING),
)  # fmt: skip
