"""G4: wait P seconds."""

from __future__ import annotations

import re

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.toolpath.record import Event

#: A P word with a decimal point, behind comments and other words.
_WITH_POINT = re.compile(r"(?:\([^)]*\)|[^(;])*?P[ \t]*[0-9]*\.", re.IGNORECASE)


def dwell(ip: Interpreter, block: Block) -> None:
    """G4 P."""
    seconds = block.words.get("p")
    if seconds is None:
        raise BlockError("dwell-time", "G4 has no time", "G4", hint="give it as P, in seconds")
    if seconds < 0.0:
        raise BlockError("dwell-time", f"P{seconds:g} of G4 is negative", "P")
    ip.sink.call(f"DWELL({seconds:.4f})", Event("dwell", True, seconds, {"seconds": seconds}))


def dwell_fanuc(ip: Interpreter, block: Block) -> None:
    """G04 of FANUC: X or U seconds, or P milliseconds."""
    words = block.words
    seconds = next((words[letter] for letter in "xu" if letter in words), None)
    if "p" in words:
        seconds = words["p"] / 1000.0
        _doubt_point(ip, block)
    if seconds is None:
        raise BlockError("dwell-time", "G4 has no time", "G4", hint="X seconds or P milliseconds")
    if seconds < 0.0:
        raise BlockError("dwell-time", f"a dwell of {seconds:g} s is negative", "P" if "p" in words else "X")
    ip.sink.call(f"DWELL({seconds:.4f})", Event("dwell", True, seconds, {"seconds": seconds}))


def _doubt_point(ip: Interpreter, block: Block) -> None:
    """Say that P counts milliseconds where it has a decimal point, with which other controls count seconds."""
    assert ip.flow is not None
    text = ip.flow.subroutines.sources[block.source].text_at(block.offset)
    if _WITH_POINT.match(text):
        number = block.words["p"]
        message = f"P{number:g} with a decimal point is read as {number:g} ms"
        hint = (
            f"X{number:g} waits {number:g} s; FANUC's controls refuse the point, others count seconds with it"
        )
        ip.warn(BlockError("dwell-point", message, "P", hint=hint), Severity.WARNING)


_OWN = ("fanuc",)
CODES = (
    Code("G", 40, "non-modal", Stage.DWELL, dwell, "dwell, P seconds", "p", dialects=("linuxcnc",)),
    Code(
        "G",
        40,
        "non-modal",
        Stage.DWELL,
        dwell_fanuc,
        "dwell, X seconds or P milliseconds",
        "pxu",
        "own",
        dialects=_OWN,
    ),
)
