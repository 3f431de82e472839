"""Inputs and outputs of the machine: M62 to M68 of LinuxCNC (on FANUC's controls they are the builder's)."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import COMPENSATION, OF_LINUXCNC, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.state.parameters import INPUT
from cncgen.toolpath.record import Event

_DIGITAL = {620: ("SET_MOTION", 1), 630: ("CLEAR_MOTION", 0), 640: ("SET_AUX", 1), 650: ("CLEAR_AUX", 0)}


def _digital(ip: Interpreter, block: Block, tenths: int) -> None:
    call, value = _DIGITAL[tenths]
    name = f"M{tenths // 10}"
    if "p" not in block.words:
        raise BlockError("pin-missing", f"{name} has no output number P", name)
    pin = whole(block, "p", name)
    ip.sink.call(f"{call}_OUTPUT_BIT({pin})", Event("output", values={"pin": pin, "value": value}))


def _analog(ip: Interpreter, block: Block, tenths: int, call: str) -> None:
    name = f"M{tenths // 10}"
    for letter, what in (("e", "output number E"), ("q", "value Q")):
        if letter not in block.words:
            raise BlockError("pin-missing", f"{name} has no {what}", name)
    pin, value = whole(block, "e", name), block.words["q"]
    event = Event("output", values={"analog": pin, "value": value})
    ip.sink.call(f"{call}_OUTPUT_VALUE({pin},{value:f})", event)


def wait(ip: Interpreter, block: Block) -> None:
    """M66 P|E L Q: wait for an input; nothing answers here, so #5399 is 0 for an immediate look, else -1."""
    words = block.words
    if ("p" in words) == ("e" in words):
        raise BlockError("pin-missing", "M66 needs a digital input P or an analog one E, and not both", "M66")
    letter = "p" if "p" in words else "e"
    pin = whole(block, letter, "M66")
    mode = whole(block, "l", "M66") if "l" in words else 0
    if mode > 4:
        raise BlockError("wait-mode", f"L{mode} of M66: L is 0 to 4", "L")
    seconds = words.get("q", 0.0)
    if letter == "e" and mode:
        raise BlockError("wait-mode", "an analog input E can only be read at once (L0)", "L")
    if mode and seconds <= 0.0:
        raise BlockError("wait-time", "M66 that waits has no time limit Q above 0", "M66")
    ip.parameters.numbers[INPUT] = 0.0
    ip.sink.call("", Event("input", bool(mode), values={"pin": pin, "mode": mode, "timeout_s": seconds}))


CODES = tuple(
    Code("M", number, "pins", Stage.PINS, run, text, words, dialects=OF_LINUXCNC,
        refused=("waits for an input" if run is wait else "sets an output", COMPENSATION), without="others")
    for number, run, text, words in (
        (620, partial(_digital, tenths=620), "set output P with the next motion", "p"),
        (630, partial(_digital, tenths=630), "clear output P with the next motion", "p"),
        (640, partial(_digital, tenths=640), "set output P at once", "p"),
        (650, partial(_digital, tenths=650), "clear output P at once", "p"),
        (660, wait, "wait on input P or E", "pelq"),
        (670, partial(_analog, tenths=670, call="SET_MOTION"), "set analog output E with the next motion", "eq"),
        (680, partial(_analog, tenths=680, call="SET_AUX"), "set analog output E at once", "eq"),
    )
)  # fmt: skip
