"""Codes of FANUC that change nothing in what is planned: look-ahead modes, checks and signals of the control."""

from __future__ import annotations

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.toolpath.record import Event

_FANUC = ("fanuc",)
_LOOK_AHEAD = "look-ahead mode: accepted, motions are always planned ahead"


def nothing(ip: Interpreter, block: Block) -> None:
    """Accept a code: motions are always planned with look-ahead, and rigid taps follow their pitch by F and S."""


def forbid(ip: Interpreter, block: Block) -> None:
    """G22: a zone that the tool must not enter, which is not checked here."""
    hint = "travel_mm of the machine file is checked"
    ip.warn(BlockError("zone-not-checked", "the zone of G22 is not checked", "G22", hint=hint), Severity.NOTE)


def rigid(ip: Interpreter, block: Block) -> None:
    """M29: the next tapping cycle turns the spindle in step with the feed."""
    ip.sink.call("", Event("user", values={"m": 29}))


CODES = (
    Code("G", 50, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD, "pqr", dialects=_FANUC),
    Code("G", 1030, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD + " (Haas)", "p", dialects=_FANUC),
    Code("G", 1870, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD + " (Haas)", "pe", dialects=_FANUC),
    Code("G", 51, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD, AXES + "pqr", "own", dialects=_FANUC),
    Code(
        "G",
        611,
        "path",
        Stage.PATH,
        nothing,
        _LOOK_AHEAD + " (Mazak's geometry compensation)",
        "pqr",
        dialects=_FANUC,
    ),
    Code("G", 80, "look-ahead", Stage.PATH, nothing, _LOOK_AHEAD, "pqr", dialects=_FANUC),
    Code(
        "G",
        220,
        "stroke check",
        Stage.PATH,
        forbid,
        "forbidden zone: accepted, not checked",
        "xyzijk",
        "own",
        dialects=_FANUC,
    ),
    Code("G", 230, "stroke check", Stage.PATH, nothing, "no forbidden zone", dialects=_FANUC),
    Code("M", 290, "rigid tapping", Stage.SPINDLE, rigid, "rigid tapping in the next cycle", dialects=_FANUC),
)
