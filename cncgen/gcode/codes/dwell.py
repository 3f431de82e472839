"""G4: wait P seconds."""

from __future__ import annotations

import re

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import OF_FANUC, Code
from cncgen.gcode.errors import BlockError, locate
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.grammars.terminals import FANUC
from cncgen.toolpath.record import Event

#: From which number on a word P with a decimal point counts milliseconds in programs that no code shows to be Haas's, and below which
#: one without a point is doubtful.
_LEAST_MS, _LEAST_WAIT = 50.0, 10.0
#: From which whole number without a decimal point on X and U of a dwell count milliseconds.
_LONG = 100.0


def dwell(ip: Interpreter, block: Block) -> None:
    """G4 P, or S of Marlin where no sign tells the control."""
    seconds = block.words.get("p")
    if seconds is None and ip.plain and "s" in block.words and not block.m:
        seconds = block.words["s"]
        taken = f"S{seconds:g} of G4 is taken as {seconds:g} s"
        message = f"{taken}, as Marlin has it; LinuxCNC refuses G4 without P"
        ip.warn_once("other-control", message, "S", "P is seconds here, and milliseconds with Marlin")
    if seconds is None:
        of_marlin = "S counts seconds with Marlin alone: P3 is 3 s"
        hint = of_marlin if "s" in block.words else "give it as P, in seconds"
        raise BlockError("dwell-time", "G4 has no time", "G4", hint=hint)
    _wait(ip, seconds, "P" if "p" in block.words else "S")


def _wait(ip: Interpreter, seconds: float, word: str) -> None:
    if seconds < 0.0:
        raise BlockError("dwell-time", f"a dwell of {seconds:g} s is negative", word)
    ip.sink.call(f"DWELL({seconds:.4f})", Event("dwell", True, seconds, {"seconds": seconds}))


def dwell_fanuc(ip: Interpreter, block: Block) -> None:
    """G04 of FANUC: X or U seconds, or P milliseconds; without any of them a stop with an exact check of the position."""
    words = block.words
    seconds = next((_unhurried(ip, block, letter) for letter in "xu" if letter in words), None)
    if "p" in words:
        seconds = seconds_of(ip, block)
    if seconds is None:
        message = "G4 without a time is an exact stop, as FANUC's controls have it; others refuse it"
        ip.warn_once("dwell-time", message, "G4", "X seconds or P milliseconds")
        seconds = 0.0
    _wait(ip, seconds, "P" if "p" in words else "X")


def _unhurried(ip: Interpreter, block: Block, letter: str) -> float:
    """Return X or U of a dwell in seconds; a great whole number without a decimal point counts in milliseconds, as X1500.

    A smaller one is read in seconds: nobody waits for 2 ms. Controls that count least increments do, so a remark says it.
    """
    number = block.words[letter]
    if number <= 0.0 or ip.options.least_increment is not None or has_point(ip, block, letter) is not False:
        return number
    name = letter.upper()
    seconds, other = (number / 1000.0, number) if number >= _LONG else (number, number / 1000.0)
    message = f"{name}{number:g} of G4 without a decimal point is read as {seconds:g} s; by its parameters a control waits {other:g} s instead"
    hint = f"{name}1.5 of G4 waits one second and a half on every control"
    ip.warn_once("dwell-point", message, name, hint)
    return seconds


def has_point(ip: Interpreter, block: Block, letter: str) -> bool | None:
    """Tell whether the number of a word stands in the text with a decimal point; None where it is computed."""
    text = ip.flow_control().subroutines.sources[block.source].text_at(block.offset)
    column, length = locate(text, f"{letter.upper()}{block.words[letter]}")
    number = "".join(text[column : column - 1 + length].split()).lstrip("+-")
    return "." in number if re.fullmatch(FANUC["NUMBER"], number) else None


def seconds_of(ip: Interpreter, block: Block) -> float:
    """Return the time of a word P of FANUC in seconds: milliseconds, or with a decimal point and less than 50 seconds.

    FANUC's controls refuse the point. Haas's and most others count seconds with it, and other programs that have P500. mean
    milliseconds; either way a remark says it, as on less than 10 milliseconds, for which nobody waits.
    """
    number = block.words["p"]
    point = has_point(ip, block, "p")
    seconds = number if point and (number < _LEAST_MS or ip.flow_control().of_haas) else number / 1000.0
    if number > 0.0 and (point or number < _LEAST_WAIT):
        message = f"P{number:g} {'with' if point else 'without'} a decimal point is read as {seconds:g} s"
        hint = "X0.5 and P500 of G4 wait half a second; FANUC's controls refuse P with a point, Haas's count seconds with it"
        ip.warn_once("dwell-point", message, "P", hint)
    return seconds


CODES = (
    Code("G", 40, "non-modal", Stage.DWELL, dwell, "dwell, P seconds", "p", dialects=("linuxcnc",), waits=True),
    Code("G", 40, "non-modal", Stage.DWELL, dwell_fanuc, "dwell, X seconds or P milliseconds", "pxu", "own", dialects=OF_FANUC,
        axis_words="sizes"),
)  # fmt: skip
