"""G254 and G255 of Haas: the origin of the work offset goes along with the rotary table (dynamic work offset).

The axes of the coordinates stay parallel to those of the machine, unlike under G68.2; only their origin is where the table has carried
it, about the centre that ``[kinematics]`` names. G255 and the end of the program end it.

Source: Haas Automation, "UMC-750 Operator's Manual Supplement", G254; https://www.haascnc.com, "G254 Dynamic Work Offset".
"""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes import affine, carried_planes
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Point, Sink
from cncgen.gcode.state.modal import Stage

_NAME = "G254"


def _shift(ip: Interpreter) -> affine.Frame:
    """Return the frame whose origin the table has carried to where its axes stand; none without kinematics."""
    kinematics = ip.options.kinematics
    if kinematics is None:
        return affine.Frame()
    return affine.Frame(affine.UNIT, affine.carried(ip, carried_planes.positions(ip, kinematics)).shift)


class DynamicSink(affine.FramedSink):
    """Passes calls on with their positions from the work offset's own origin; the rotary axes rest meanwhile."""

    def renew(self, ip: Interpreter) -> None:
        """Carry another work offset."""
        self.frame = _shift(ip)

    def _led(self, end: Point) -> Point:
        if end[3:6] != self.at[3:6]:
            message = "a rotary axis turns under G254, which has carried the origin once"
            raise BlockError("dynamic-offset", message, "", hint="G255 before, and G254 again behind it")
        return super()._led(end)


def follow(ip: Interpreter, block: Block) -> None:
    """G254."""
    if not isinstance(ip.sink, DynamicSink) and ip.sink is not ip.base:
        message = "G254 does not go with G68, G51, G51.1, G68.2, G43.4, or cutter compensation"
        raise BlockError("frame-compensation", message, _NAME, hint="end them before")
    if ip.options.kinematics is None and any(ip.machine_position()[3:6]):
        message = "G254: the rotary table has turned, and where that carries the origin is not known"
        hint = "a machine with a table [kinematics] says it; X Y Z are read from the origin as it was"
        ip.warn_once("dynamic-offset", message, _NAME, hint)

    def sink(inner: Sink, at: Point) -> DynamicSink:
        return DynamicSink(inner, frame, at)

    frame = _shift(ip)
    affine.stand(ip, frame, sink)


def end(ip: Interpreter, block: Block) -> None:
    """G255."""
    if isinstance(ip.sink, DynamicSink):
        affine.stand(ip, affine.Frame(), None)


CODES = (
    Code("G", 2540, "dynamic work offset", Stage.COORDINATES, follow, "the origin goes along with the rotary table", dialects=("fanuc",)),
    Code("G", 2550, "dynamic work offset", Stage.COORDINATES, end, "end of G254", dialects=("fanuc",)),
)  # fmt: skip
