"""The sink of a check: counts motions and events, and keeps none of them."""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.sink import Curve, MotionBatch, Point
from cncgen.toolpath.record import Event, PathMode


class CountingSink:
    """Takes every call as `columns.ColumnsSink` does and counts what would be a row of the toolpath."""

    wants_comments = False

    def __init__(self) -> None:
        self.block = Block({})
        self.count = 0

    def motions(self, batch: MotionBatch) -> None:
        """Count a run of motions."""
        self.count += len(batch.motion)

    def straight_traverse(self, end: Point) -> None:
        """Count a motion."""
        self.count += 1

    def straight_feed(self, end: Point) -> None:
        """Count a motion."""
        self.count += 1

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Count a motion."""
        self.count += 1

    def straight_probe(self, end: Point) -> None:
        """Count a motion."""
        self.count += 1

    def rigid_tap(self, end: Point, pitch: float) -> None:
        """Count the way there and the way back."""
        self.count += 2

    def nurbs_feed(self, curve: Curve) -> None:
        """Count a motion."""
        self.count += 1

    def call(self, text: str, event: Event | None = None) -> None:
        """Count the event of a call."""
        if event is not None:
            self.count += 1

    def where(self, position: Point) -> Point:
        """Return where the machine stands: where it should."""
        return position

    # What only changes how a motion is made.

    def synchronise(self, pitch: float | None) -> None:
        """Count nothing."""

    def use_length_units(self, inches: bool) -> None:
        """Count nothing."""

    def select_plane(self, plane: int) -> None:
        """Count nothing."""

    def set_feed_rate(self, rate: float) -> None:
        """Count nothing."""

    def set_inverse_time(self, rate: float, length: float) -> None:
        """Count nothing."""

    def set_feed_mode(self, mode: int, synched: bool) -> None:
        """Count nothing."""

    def set_spindle(self, speed: float, direction: int) -> None:
        """Count nothing."""

    def set_motion_control_mode(self, mode: PathMode, tolerance: float | None, naive: float | None) -> None:
        """Count nothing."""

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        """Count nothing."""

    def set_g92_offset(self, offset: Point) -> None:
        """Count nothing."""

    def set_xy_rotation(self, degrees: float) -> None:
        """Count nothing."""

    def use_tool_length_offset(self, offset: Point) -> None:
        """Count nothing."""

    def place(self, position: Point) -> None:
        """Count nothing."""
