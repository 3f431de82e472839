"""The state of the machine while a program is executed, and the calls that change it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.execution.canon import Canon
from cncgen.stepnc.execution.linearize import with_axes
from cncgen.stepnc.execution.orientation import angles_along, angles_of
from cncgen.stepnc.execution.technology import Speeds
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.geometry.splines import ellipse_arc
from cncgen.stepnc.model import Functions, Tool

Floats = NDArray[np.float64]

#: Distance up to which a path begins where the last one ended, mm (four decimals in a rotated frame).
SAME_PLACE = 2e-3
#: Angle alike, rad.
SAME_ANGLE = 1e-6


class Machine:
    """Position, tool, spindle, coolant and feed, and a listener that hears what changes.

    Attributes:
        position: Tip of the tool, shape (3,), mm.
        angles: B and C, rad.
        tool: In the spindle, or None.
        feed: mm/s, None until one is set.
    """

    def __init__(self, canon: Canon, start: Floats, rotary: bool) -> None:
        self.canon = canon
        self.position = start.astype(float)
        self.rotary = rotary
        self.angles = (0.0, 0.0)
        self.tool: Tool | None = None
        self.feed: float | None = None
        self._direction = 0
        self._rpm: float | None = None
        self._coolant = (False, False, False)
        canon.begin(self._full(self.position))

    def _full(self, point: Floats) -> Floats:
        return np.concatenate([point, self.angles]) if self.rotary else point

    def _rows(self, points: Floats) -> Floats:
        if not self.rotary:
            return points
        return np.concatenate([points, np.tile(self.angles, (len(points), 1))], axis=1)

    # Functions

    def change_tool(self, tool: Tool) -> None:
        """Change to a tool unless it is in the spindle already; spindle and coolant go off."""
        if self.tool is not None and self.tool.name == tool.name:
            self.tool = tool
            return
        if self._direction:
            self._direction = 0
            self.canon.spindle(0, None)
        self.switch(Functions(0, False, False, False))
        self.tool = tool
        self.canon.change_tool(tool)

    def unload_tool(self) -> None:
        """Take the tool out: spindle and coolant off."""
        if self._direction:
            self._direction = 0
            self.canon.spindle(0, None)
        self.switch(Functions(0, False, False, False))
        self.tool = None

    def switch(self, functions: Functions) -> None:
        """Switch the coolant as functions say."""
        wanted = (functions.coolant, functions.mist, functions.through_spindle)
        now = tuple(b if w is None else w for w, b in zip(wanted, self._coolant, strict=True))
        if now != self._coolant:
            self._coolant = (now[0], now[1], now[2])
            self.canon.coolant(*self._coolant)

    def set_speeds(self, speeds: Speeds) -> None:
        """Set spindle and feed where they change."""
        if speeds.rpm is not None and (speeds.direction, speeds.rpm) != (self._direction, self._rpm):
            self._direction, self._rpm = speeds.direction, speeds.rpm
            self.canon.spindle(speeds.direction, speeds.rpm)
        if speeds.feed is not None and speeds.feed != self.feed:
            self.feed = speeds.feed
            self.canon.feed(speeds.feed)

    def stop_spindle(self) -> None:
        """Stop the spindle, keeping its speed."""
        if self._direction:
            self._direction = 0
            self.canon.spindle(0, None)

    # Motions

    def is_at(self, point: Floats) -> bool:
        """Tell whether the tool is at a point."""
        return float(np.abs(point - self.position).max()) <= SAME_PLACE

    def points_along(self, axis: Floats) -> bool:
        """Tell whether the tool has that direction already."""
        wanted = angles_of(axis, self.angles)
        return max(abs(wanted[0] - self.angles[0]), abs(wanted[1] - self.angles[1])) <= SAME_ANGLE

    def turn(self, axis: Floats) -> None:
        """Turn the tool into a direction, in rapid, its tip where it is."""
        if self.rotary and not self.points_along(axis):
            self.angles = angles_of(axis, self.angles)
            self.canon.traverse(self._full(self.position)[None, :])

    def traverse(self, point: Floats) -> None:
        """Move in a rapid straight line, if there is any way to go."""
        if not self.is_at(point):
            self.canon.traverse(self._rows(point[None, :]))
            self.position = point

    def link(self, point: Floats, axis: Floats, tool_axis: Floats, height: float) -> None:
        """Go to a point by way of a plane: up, over, down, in rapid.

        Args:
            point: Shape (3,), mm.
            axis: Shape (3,), the plane's normal, the direction of up and down.
            tool_axis: Shape (3,), the tool's direction at the point; it turns above.
            height: Of the plane along `axis` from the machine's origin, mm; the tool goes no lower than it is.
        """
        here = float(self.position @ axis)
        top = max(height, here, float(point @ axis))
        if here < top:
            self.traverse(self.position + (top - here) * axis)
        self.turn(tool_axis)
        self.traverse(point + (top - float(point @ axis)) * axis)
        self.traverse(point)

    def follow(self, pieces: list[Piece], rapid: bool) -> None:
        """Move along pieces; the first begins where the tool is."""
        for piece in pieces:
            if isinstance(piece, Polyline):
                self._follow_lines(piece, rapid)
            elif isinstance(piece, Arc):
                self._follow_arc(piece, rapid)
            else:
                control = self._rows(np.concatenate([self.position[None, :], piece.control[1:]]))
                self.position = piece.control[-1]
                self.canon.nurbs(piece, control, rapid)

    def _follow_lines(self, piece: Polyline, rapid: bool) -> None:
        points, axes = piece.points, piece.axes
        if axes is not None and self.rotary:
            points, axes = with_axes(points, axes)
            rows = np.concatenate([points, angles_along(axes, self.angles)], axis=1)
            self.angles = (float(rows[-1, 3]), float(rows[-1, 4]))
        else:
            rows = self._rows(points)
        if axes is None or not self.rotary:
            moved = np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-9
            rows = rows[1:][moved]
        if len(rows):
            (self.canon.traverse if rapid else self.canon.lines)(rows)
            self.position = points[-1]

    def _follow_arc(self, arc: Arc, rapid: bool) -> None:
        aligned = np.count_nonzero(np.abs(arc.normal) > 1e-12) == 1
        flat = abs(float((arc.end - arc.start) @ arc.normal)) < 1e-9
        self.position = arc.end
        if aligned or not flat or arc.sweep > 2 * np.pi + 1e-9:
            self.canon.arc(arc, self._full(arc.end), rapid)
            return
        # An arc across the main planes has no canonical call of its own: the same circle as a rational spline.
        u = arc.start - arc.centre
        curve = ellipse_arc(arc.centre, u, np.cross(arc.normal, u), 0.0, arc.sweep)
        self.canon.nurbs(curve, self._rows(curve.control), rapid)
