"""Coolant: M7 mist, M8 flood, M9 off. Source: Kramer et al. (2000), section 3.6.4."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.toolpath.record import Event


def _event(ip: Interpreter) -> Event:
    return Event("coolant", values={"mist": ip.state.mist, "flood": ip.state.flood})


def _on(ip: Interpreter, block: Block, name: str) -> None:
    setattr(ip.state, name, True)
    ip.sink.call(f"{name.upper()}_ON()", _event(ip))


def off(ip: Interpreter, block: Block) -> None:
    """M9."""
    ip.state.mist = ip.state.flood = False
    ip.sink.call("MIST_OFF()", _event(ip))
    ip.sink.call("FLOOD_OFF()")


CODES = (
    *(
        Code("M", number, "coolant", Stage.COOLANT, partial(_on, name=name), f"{name} coolant on", waits=True,
            restores=(name, True))
        for number, name in ((70, "mist"), (80, "flood"))
    ),
    Code("M", 90, "coolant", Stage.COOLANT, off, "coolant off", waits=True, restores=("mist", False)),
)  # fmt: skip
