"""Stops and ends: M0 M1 M60, M2 M30. Source: Kramer et al. (2000), section 3.6.1."""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.state.systems import load_system
from cncgen.toolpath.record import Event


def _stop(ip: Interpreter, block: Block, text: str, kind: str) -> None:
    for line in text.split():
        event = Event("stop", True, values={"kind": kind}) if line.endswith("STOP()") else None
        ip.sink.call(line, event)


def _end(ip: Interpreter, block: Block, pallet: bool) -> None:
    reset(ip)
    if pallet:
        ip.sink.call("PALLET_SHUTTLE()")
    ip.sink.call("PROGRAM_END()", Event("end", True))
    ip.state.ended, ip.ended_in = True, block


def reset(ip: Interpreter) -> None:
    """Reset the modes that the end of a program resets (RS274/NGC, 3.6.1)."""
    ip.end_compensation()
    state, sink = ip.state, ip.sink
    load_system(ip, 1)
    sink.set_g5x_offset(1, state.origin)
    sink.set_xy_rotation(state.rotation)
    if state.plane != 17:
        state.plane = 17
        sink.select_plane(17)
    state.absolute, state.feed_mode, state.feed = True, 94, 0.0
    sink.set_feed_mode(94, synched=False)
    sink.set_feed_rate(0.0)
    if not state.feed_override:
        state.feed_override = True
        sink.call("ENABLE_FEED_OVERRIDE()")
    state.direction, state.motion = 0, 10
    sink.set_spindle(state.speed, 0)
    state.constant_surface = None
    sink.set_surface_speed(None)
    sink.call("STOP_SPINDLE_TURNING(0)")
    sink.call(f"SET_SPINDLE_MODE(0 {0.0:.4f})")
    if state.mist:
        sink.call("MIST_OFF()")
    if state.flood:
        sink.call("FLOOD_OFF()")
    state.mist = state.flood = False


CODES = (
    Code("M", 0, "stop", Stage.STOP, partial(_stop, text="PROGRAM_STOP()", kind="stop"), "stop"),
    Code("M", 10, "stop", Stage.STOP, partial(_stop, text="OPTIONAL_PROGRAM_STOP()", kind="optional"),
        "stop where the switch says so"),
    Code("M", 600, "stop", Stage.STOP, partial(_stop, text="PALLET_SHUTTLE() PROGRAM_STOP()", kind="pallet"),
        "change pallets and stop", dialects=("linuxcnc",), without="others"),
    Code("M", 20, "stop", Stage.STOP, partial(_end, pallet=False), "end of the program", ends="program"),
    Code("M", 300, "stop", Stage.STOP, partial(_end, pallet=True), "end of the program, change pallets", ends="program"),
)  # fmt: skip
