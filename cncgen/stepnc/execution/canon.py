"""The canonical machining functions (NISTIR 6556) as an interface, and a listener that prints them.

The executor of a program calls these functions of a listener, in machine coordinates, mm, s and rad; one listener
makes a `Toolpath` of the calls, another prints them as NIST's interpreters do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.geometry.pieces import Arc, Nurbs
from cncgen.stepnc.model import CuttingTool, Workingstep, WorkSetup

Floats = NDArray[np.float64]


class Canon:
    """A listener to an execution; this base class ignores every call.

    Positions have the columns X Y Z, then the rotary axes of the program.
    """

    def workingstep(self, step: Workingstep) -> None:
        """Say which workingstep the next calls belong to."""

    def setup(self, setup: WorkSetup) -> None:
        """Say that positions are those of another clamping from now on."""

    def probing(self, on: bool) -> None:
        """Say that the lines from now on end where the probe touches, or that they do so no longer."""

    def source(self, ident: int) -> None:
        """Say which entity the next calls come from."""

    def begin(self, position: Floats) -> None:
        """Begin at a position, shape (axes,)."""

    def lever(self, lever: float) -> None:
        """Say how far the tip goes as rotary axes turn that carry it, mm/rad, from now on (`Toolpath.lever`)."""

    def change_tool(self, tool: CuttingTool) -> None:
        """Change the tool; spindle and coolant are off."""

    def spindle(self, direction: int, rpm: float | None) -> None:
        """Turn the spindle: 1 with the clock, −1 against it, 0 stop; `rpm` None leaves the speed."""

    def coolant(self, flood: bool, mist: bool, through: bool) -> None:
        """Switch the coolant."""

    def feed(self, speed: float) -> None:
        """Set the feed, mm/s."""

    def deviation(self, distance: float | None) -> None:
        """Stay within a distance of the path from now on, mm; 0 is on it, None as close as the machine likes."""

    def traverse(self, points: Floats) -> None:
        """Move in rapid straight lines to points, shape (n, axes)."""

    def lines(self, points: Floats) -> None:
        """Feed in straight lines to points, shape (n, axes)."""

    def arc(self, arc: Arc, end: Floats, rapid: bool) -> None:
        """Move along an arc to `end`, shape (axes,)."""

    def nurbs(self, curve: Nurbs, control: Floats, rapid: bool) -> None:
        """Move along a spline with control points in all axes, shape (n, axes)."""

    def rigid_tap(self, end: Floats, pitch: float) -> None:
        """Go to `end`, shape (axes,), and back in step with the spindle, `pitch` mm a turn; it turns back at the end."""

    def synchronise(self, pitch: float | None) -> None:
        """Move in step with the spindle from now on, `pitch` mm a turn; None: no longer."""

    def dwell(self, seconds: float) -> None:
        """Wait."""

    def stop(self, optional: bool) -> None:
        """Stop the program until the operator goes on."""

    def message(self, text: str) -> None:
        """Show a text."""

    def function(self, name: str, value: object) -> None:
        """Do something that the canonical functions have no call for: a pallet, a table, a mark."""

    def end(self) -> None:
        """End the program."""


class Printer(Canon):
    """Prints the calls in the notation of NIST's interpreters, `lines` to be taken by `take`."""

    def __init__(self, axes: str, origin: Floats | None = None) -> None:
        self._axes = axes
        self._out: list[str] = []
        self._count = 0
        self._turning = 0
        self._rpm = -1.0
        self._flood = self._mist = self._through = False
        self._tool = False
        self._position = np.zeros(len(axes))
        self._plane = "XY"
        self._deviation: float | None = None
        self._print("USE_LENGTH_UNITS(CANON_UNITS_MM)")
        self._print(f"SET_ORIGIN_OFFSETS({self._numbers(np.zeros(len(axes)))})")
        self._print("SET_FEED_REFERENCE(CANON_XYZ)")
        for call in ("SPINDLE_RETRACT()", "STOP_SPINDLE_TURNING()", "USE_TOOL_LENGTH_OFFSET(0.0000)"):
            self._print(call)

    def _print(self, call: str) -> None:
        self._count += 1
        self._out.append(f"{self._count:5d} {call}")

    def take(self) -> Iterator[str]:
        """Yield the lines printed since the last time."""
        lines, self._out = self._out, []
        yield from lines

    def _numbers(self, position: Floats) -> str:
        values = [v if k < 3 else math.degrees(v) for k, v in enumerate(position.tolist())]
        return ", ".join(f"{v + 0.0 if abs(v) >= 5e-5 else 0.0:.4f}" for v in values)

    def begin(self, position: Floats) -> None:
        """Remember the position."""
        self._position = position

    def setup(self, setup: WorkSetup) -> None:
        """Print what rs274 prints of G54 to G59.3, the offset being zero."""
        self._print(f"SET_G5X_OFFSET({setup.number}, {self._numbers(np.zeros(len(self._axes)))})")

    def probing(self, on: bool) -> None:
        """Print that the probe is on or off."""
        self._print(f"TURN_PROBE_{'ON' if on else 'OFF'}()")

    def change_tool(self, tool: CuttingTool) -> None:
        """Print the calls of a tool change."""
        if self._tool:
            self._print("SPINDLE_RETRACT()")
            self._print("USE_TOOL_LENGTH_OFFSET(0.0000)")
        self._tool = True
        self._print(f"CHANGE_TOOL({tool.name})")
        self._print(f"USE_TOOL_LENGTH_OFFSET({tool.offset_length or 0.0:.4f})")

    def spindle(self, direction: int, rpm: float | None) -> None:
        """Print what changes of speed and sense."""
        if direction == 0 and self._turning:
            self._print("STOP_SPINDLE_TURNING()")
        if rpm is not None and rpm != self._rpm:
            self._rpm = rpm
            self._print(f"SET_SPINDLE_SPEED({rpm:.4f})")
        if direction and direction != self._turning:
            self._print(f"START_SPINDLE_{'CLOCKWISE' if direction > 0 else 'COUNTERCLOCKWISE'}()")
        self._turning = direction

    def coolant(self, flood: bool, mist: bool, through: bool) -> None:
        """Print what changes."""
        for now, before, name in (
            (flood, self._flood, "FLOOD"),
            (mist, self._mist, "MIST"),
            (through, self._through, "THROUGH_TOOL"),
        ):
            if now != before:
                self._print(f"{name}_{'ON' if now else 'OFF'}()")
        self._flood, self._mist, self._through = flood, mist, through

    def feed(self, speed: float) -> None:
        """Print the feed in mm/min."""
        self._print(f"SET_FEED_RATE({speed * 60.0:.4f})")

    def deviation(self, distance: float | None) -> None:
        """Print the mode of the motions that follow, where it changes."""
        if distance == self._deviation:
            return
        self._deviation = distance
        mode = "CANON_EXACT_PATH" if distance == 0 else f"CANON_CONTINUOUS, {distance or 0.0:.4f}"
        self._print(f"SET_MOTION_CONTROL_MODE({mode})")

    def traverse(self, points: Floats) -> None:
        """Print a STRAIGHT_TRAVERSE a point."""
        for point in points:
            self._print(f"STRAIGHT_TRAVERSE({self._numbers(point)})")
        self._position = points[-1]

    def lines(self, points: Floats) -> None:
        """Print a STRAIGHT_FEED a point."""
        for point in points:
            self._print(f"STRAIGHT_FEED({self._numbers(point)})")
        self._position = points[-1]

    def arc(self, arc: Arc, end: Floats, rapid: bool) -> None:
        """Print an ARC_FEED where the axis of the arc is a main one, else where its helix ends: no call has that."""
        axis = int(np.argmax(np.abs(arc.normal)))
        if abs(arc.normal[axis]) < 1.0 - 1e-12:
            self._print(f"ARC_FEED_IN_SPACE({self._numbers(end)})")
            self._position = end
            return
        first, second = ((1, 2), (2, 0), (0, 1))[axis]
        name = ("YZ", "XZ", "XY")[axis]
        if name != self._plane:
            self._plane = name
            self._print(f"SELECT_PLANE(CANON_PLANE_{name})")
        turns = max(1, math.ceil(arc.sweep / (2 * math.pi) - 1e-9))
        turns = turns if arc.normal[axis] > 0 else -turns
        e, c = arc.end, arc.centre
        inside = (
            self._numbers(np.array([e[first], e[second]]))
            + ", "
            + self._numbers(np.array([c[first], c[second]]))
        )
        rest = "".join(f", {math.degrees(v):.4f}" for v in end[3:].tolist())
        self._print(f"ARC_FEED({inside}, {turns}, {self._numbers(e[axis : axis + 1])}{rest})")
        self._position = end

    def nurbs(self, curve: Nurbs, control: Floats, rapid: bool) -> None:
        """Print a NURBS_FEED with degree, knots, and control points each with its weight."""
        knots = ", ".join(f"{k:.6f}" for k in curve.knots.tolist())
        points = ", ".join(
            f"({self._numbers(p)}, {w:.6f})" for p, w in zip(control, curve.weights.tolist(), strict=True)
        )
        self._print(f"NURBS_FEED({curve.degree}, [{knots}], [{points}])")
        self._position = control[-1]

    def rigid_tap(self, end: Floats, pitch: float) -> None:
        """Print what LinuxCNC's rs274 prints of G33.1; the position stays."""
        self.synchronise(pitch)
        self._print(f"RIGID_TAP({self._numbers(end[:3])})")
        self.synchronise(None)

    def synchronise(self, pitch: float | None) -> None:
        """Print what rs274 prints round the motions of G33."""
        self._print("STOP_SPEED_FEED_SYNCH()" if pitch is None else f"START_SPEED_FEED_SYNC({pitch:f},0)")

    def dwell(self, seconds: float) -> None:
        """Print a DWELL."""
        self._print(f"DWELL({seconds:.4f})")

    def stop(self, optional: bool) -> None:
        """Print the stop."""
        self._print("OPTIONAL_PROGRAM_STOP()" if optional else "PROGRAM_STOP()")

    def message(self, text: str) -> None:
        """Print the text."""
        self._print(f'MESSAGE("{text}")')

    def function(self, name: str, value: object) -> None:
        """Print it as a comment, a change of pallets as its call."""
        text = name if value is None else f"{name}: {value}"
        self._print("PALLET_SHUTTLE()" if name == "exchange pallet" else f'COMMENT("{text}")')

    def end(self) -> None:
        """Print the end."""
        self._print("PROGRAM_END()")
