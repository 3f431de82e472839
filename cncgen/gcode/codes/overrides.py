"""Overrides: M48 to M53. Source: Kramer et al. (2000), section 3.6.5, and LinuxCNC's manual."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.spindle import spindle_of
from cncgen.gcode.codes.table import COMPENSATION, Code
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.toolpath.record import Event


def _call(ip: Interpreter, what: str, on: bool) -> None:
    """Switch one of them, and remember it in the state."""
    setattr(ip.state, what.lower(), on)
    argument = "0" if what == "SPEED_OVERRIDE" else ""
    text = f"{'ENABLE' if on else 'DISABLE'}_{what}({argument})"
    ip.sink.call(text, Event("override", values={"what": what.lower(), "on": on}))


def _both(ip: Interpreter, block: Block, on: bool) -> None:
    _call(ip, "FEED_OVERRIDE", on)
    _call(ip, "SPEED_OVERRIDE", on)


def _one(ip: Interpreter, block: Block, what: str) -> None:
    spindle_of(ip, block)
    _call(ip, what, block.words.get("p", 1.0) != 0.0)


_CHANGES = ("changes an override", COMPENSATION)
CODES = (
    Code("M", 480, "override", Stage.OVERRIDE, partial(_both, on=True), "feed and speed overrides on", refused=_CHANGES,
        restores=("overrides", True)),
    Code("M", 490, "override", Stage.OVERRIDE, partial(_both, on=False), "feed and speed overrides off", refused=_CHANGES),
    *(
        Code("M", number, "override", Stage.OVERRIDE, partial(_one, what=what.upper().replace(" ", "_")), f"{what} on, off with P0",
            words, dialects=("linuxcnc",), without="others", refused=_CHANGES, restores=(what.replace(" ", "_"), None))
        for number, what, words in (
            (500, "feed override", "p"), (510, "speed override", "p$"), (520, "adaptive feed", "p"), (530, "feed hold", "p"),
        )
    ),
)  # fmt: skip
