"""The sink that prints: canonical calls as text, line by line as LinuxCNC's ``rs274 -g`` prints them."""

from __future__ import annotations

import re
from collections.abc import Callable

from cncgen.gcode.block import Block
from cncgen.gcode.budget import CALL, MOTION, Budget
from cncgen.gcode.sinks.sink import Curve, MotionBatch, Point
from cncgen.gcode.state.modal import PLANE_AXES
from cncgen.toolpath.record import Event, PathMode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_NUMBER = re.compile(r"[ \t/]*[nN]([0-9]*)")
#: Control characters of a message would reach the terminal; they are printed as escapes. Tabs and line ends stay.
_VISIBLE = {code: f"\\x{code:02x}" for code in (*range(32), *range(127, 160)) if chr(code) not in "\t\n"}
_PLANES = {17: "XY", 18: "XZ", 19: "YZ"}
_MODES = {PathMode.EXACT_PATH: "CANON_EXACT_PATH", PathMode.EXACT_STOP: "CANON_EXACT_STOP"}
_ALONE = MOTION - CALL


class PrintingSink:
    """Collects lines; `take` hands them on.

    `text_at` returns the line that begins at a byte offset of a source (index, offset).
    """

    wants_comments = True

    def __init__(self, text_at: Callable[[int, int], str]) -> None:
        self.block = Block({})
        self.budget = Budget()
        self._text_at = text_at
        self._lines: list[str] = []
        self._count = 0
        self._label_of: tuple[int, int] | None = None
        self._label = "N..... "

    def take(self) -> list[str]:
        """Return the lines printed since the last call."""
        lines, self._lines = self._lines, []
        return lines

    def call(self, text: str, event: Event | None = None) -> None:
        """Print a call literally; the text that a program prints becomes a line without a number."""
        self.budget.spend(CALL)
        if not text.isprintable():
            text = text.translate(_VISIBLE)
        if event is not None and event.values.get("print"):
            self._lines.append(text)
        elif text:
            self._count += 1
            self._lines.append(f"{self._count:5d} {self._number()}{text}")

    def _number(self) -> str:
        """Return the printed N word of the line that the block stands in."""
        block = self._numbered_by()
        if block.line == 0:
            return "N..... "
        if self._label_of != (block.source, block.offset):
            self._label_of = (block.source, block.offset)
            match = _NUMBER.match(self._text_at(block.source, block.offset))
            self._label = f"N{match.group(1):<6}" if match else "N..... "
        return self._label

    def _numbered_by(self) -> Block:
        """Return the block whose N word calls are printed with."""
        return self.block

    def motions(self, batch: MotionBatch) -> None:
        plane, self._alone = self._plane, 0
        ends: Any = batch.end.tolist()
        centres: Any = batch.centre.tolist()
        for row, motion in enumerate(batch.motion):
            self.block = Block({}, source=batch.source, line=batch.line[row], offset=batch.offset[row])
            if batch.feed_set[row]:
                self.set_feed_rate(batch.feed[row])
            end = ends[row]
            if motion == 0:
                self.straight_traverse(end)
            elif motion == 1:
                self.straight_feed(end)
            else:
                first, second = centres[row]
                self.arc_feed(end, first, second, batch.turns[row], plane)
        self._alone = _ALONE

    _plane = 17
    #: Units that a motion takes beside those of its print, as long as it is not one of a run.
    _alone = _ALONE

    def _motion(self, text: str, end: Point) -> None:
        self.budget.spend(self._alone)
        self.call(text)

    def straight_traverse(self, end: Point) -> None:
        self._motion(f"STRAIGHT_TRAVERSE({_six(end)})", end)

    def straight_feed(self, end: Point) -> None:
        self._motion(f"STRAIGHT_FEED({_six(end)})", end)

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Print ARC_FEED: end and centre in the plane's axes, turns, end along the normal, A B C."""
        a, b, n = PLANE_AXES[plane if plane in _PLANES else 17]
        rotary = ", ".join(f"{value:.4f}" for value in end[3:6])
        places = f"{end[a]:.4f}, {end[b]:.4f}, {first:.4f}, {second:.4f}, {turns}, {end[n]:.4f}, {rotary}"
        self._motion(f"ARC_FEED({places})", end)

    def straight_probe(self, end: Point) -> None:
        self.call(f"STRAIGHT_PROBE({_six(end)})")

    def rigid_tap(self, end: Point, pitch: float) -> None:
        self.call(f"RIGID_TAP({end[0]:.4f}, {end[1]:.4f}, {end[2]:.4f})")

    def _nothing(self, *told: float | Point | None) -> None:
        """Print nothing: other calls print it."""

    synchronise = set_spindle = set_surface_speed = set_lever = place = _nothing

    def nurbs_feed(self, curve: Curve) -> None:
        """Print NURBS_FEED, of which the peer prints the number of control points alone."""
        self.call(f"NURBS_FEED({len(curve.points)}, ...)")

    def use_length_units(self, inches: bool) -> None:
        self.call(f"USE_LENGTH_UNITS(CANON_UNITS_{'INCHES' if inches else 'MM'})")

    def select_plane(self, plane: int) -> None:
        self._plane = plane
        self.call(f"SELECT_PLANE(CANON_PLANE_{_PLANES.get(plane, 'UNKNOWN')})")

    def set_feed_rate(self, rate: float) -> None:
        self.call(f"SET_FEED_RATE({rate:.4f})")

    def set_inverse_time(self, rate: float, length: float) -> None:
        """Print the feed rate that the motion gets (the peer lets none be below 0.1)."""
        self.set_feed_rate(max(rate * length, 0.1))

    def set_feed_mode(self, mode: int, synched: bool) -> None:
        self.call(f"SET_FEED_MODE(0, {int(synched)})")

    def set_motion_control_mode(self, mode: PathMode, tolerance: float | None, naive: float | None) -> None:
        """Print SET_MOTION_CONTROL_MODE, and the tolerance of joining lines in continuous mode."""
        if mode is PathMode.CONTINUOUS:
            self.call(f"SET_MOTION_CONTROL_MODE(CANON_CONTINUOUS, {tolerance or 0.0:.6f})")
            self.call(f"SET_NAIVECAM_TOLERANCE({naive if naive is not None else tolerance or 0.0:.4f})")
        else:
            self.call(f"SET_MOTION_CONTROL_MODE({_MODES[mode]})")

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        self.call(f"SET_G5X_OFFSET({system}, {_six(offset)})")

    def set_g92_offset(self, offset: Point) -> None:
        self.call(f"SET_G92_OFFSET({_six(offset)})")

    def set_xy_rotation(self, degrees: float) -> None:
        self.call(f"SET_XY_ROTATION({degrees:.4f})")

    def use_tool_length_offset(self, offset: Point) -> None:
        """Print USE_TOOL_LENGTH_OFFSET: three groups of three."""
        groups = [" ".join(f"{value:.4f}" for value in offset[k : k + 3]) for k in (0, 3, 6)]
        self.call(f"USE_TOOL_LENGTH_OFFSET({', '.join(groups)})")

    def where(self, position: Point) -> Point:
        return position


def _six(point: Point) -> str:
    """Return X Y Z A B C as the peer prints them (it prints no U V W)."""
    return ", ".join(f"{value:.4f}" for value in point[:6])
