"""Coolant: M7 mist, M8 flood, M9 off. Source: Kramer et al. (2000), section 3.6.4."""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.toolpath.record import Event


def _event(ip: Interpreter) -> Event:
    return Event("coolant", values={"mist": ip.state.mist, "flood": ip.state.flood})


def mist(ip: Interpreter, block: Block) -> None:
    """M7."""
    ip.state.mist = True
    ip.sink.call("MIST_ON()", _event(ip))


def flood(ip: Interpreter, block: Block) -> None:
    """M8."""
    ip.state.flood = True
    ip.sink.call("FLOOD_ON()", _event(ip))


def off(ip: Interpreter, block: Block) -> None:
    """M9."""
    ip.state.mist = ip.state.flood = False
    ip.sink.call("MIST_OFF()", _event(ip))
    ip.sink.call("FLOOD_OFF()")


CODES = (
    Code("M", 70, "coolant", Stage.COOLANT, mist, "mist coolant on", waits=True, restores=("mist", True)),
    Code("M", 80, "coolant", Stage.COOLANT, flood, "flood coolant on", waits=True, restores=("flood", True)),
    Code("M", 90, "coolant", Stage.COOLANT, off, "coolant off", waits=True, restores=("mist", False)),
)
