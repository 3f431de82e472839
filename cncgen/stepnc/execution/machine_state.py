"""The state of the machine while a program is executed, and the calls that change it."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.execution.canon import Canon
from cncgen.stepnc.execution.rotary_axes import RotaryAxes
from cncgen.stepnc.execution.technology import Speeds
from cncgen.stepnc.geometry.chords import AXIS_STEP, MAX_POINTS, with_axes
from cncgen.stepnc.geometry.frames import apply
from cncgen.stepnc.geometry.pieces import Arc, Nurbs, Piece, Polyline
from cncgen.stepnc.geometry.splines import ellipse_arc
from cncgen.stepnc.model import CuttingTool, Functions

Floats = NDArray[np.float64]
_Curve = TypeVar("_Curve", Arc, Nurbs)

#: Distance up to which a path begins where the last one ended, mm (four decimals in a rotated frame).
SAME_PLACE = 2e-3
#: Angle alike, rad.
SAME_ANGLE = 1e-6
#: Way of the slides that counts as none beside a turn of the rotary axes, mm.
STILL = 1e-6
#: How often the lines of a path with a turning tool are made finer, each time into at most so many.
MAX_REFINEMENTS = 8
MAX_SPLIT = 16


class MachineState:
    """Position, tool, spindle, coolant and feed, and a listener that hears what changes.

    Attributes:
        position: Tip of the tool, seen from the workpiece, shape (3,), mm.
        kinematics: Of the rotary axes, or None where the program has none.
        angles: Of the rotary axes, rad.
        tool: In the spindle, or None.
        feed: mm/s, None until one is set.
        swing: Of the turning axis close by the pole, and how close, rad (`RotaryAxes.swing`), since it was last taken.
    """

    def __init__(self, canon: Canon, start: Floats, kinematics: RotaryAxes | None) -> None:
        self.canon = canon
        self.position = start.astype(float)
        self.kinematics = kinematics
        self.angles = (0.0, 0.0)
        self.tool: CuttingTool | None = None
        self.feed: float | None = None
        self.swing = (0.0, 0.0)
        self._direction = 0
        self._rpm: float | None = None
        self._coolant = (False, False, False)
        canon.begin(self._full(self.position))

    def _full(self, point: Floats) -> Floats:
        return self._rows(point[None, :])[0]

    def _rows(self, points: Floats) -> Floats:
        """Return the positions of all axes for tips, the rotary ones as they stand."""
        if self.kinematics is None:
            return points
        self._carry(self.kinematics, points, np.tile(self.angles, (len(points), 1)))
        seen = apply(self.kinematics.frame(self.angles, self._length), points)
        return np.concatenate([seen, np.tile(self.angles, (len(points), 1))], axis=1)

    def _carry(self, kinematics: RotaryAxes, points: Floats, angles: Floats, beside: float = 0.0) -> None:
        """Tell the longest lever of tips, shape (n, 3), at angles, shape (n, 2), and of places `beside` them, mm."""
        if kinematics.mechanism is not None:
            pairs = zip(points, angles.tolist(), strict=True)
            longest = max(kinematics.lever(p, (a, b), self._length) for p, (a, b) in pairs)
            self.canon.lever(longest + beside * math.sqrt(2.0))

    @property
    def rpm(self) -> float:
        """Return how fast the spindle turns, rev/min, 0 where it stands."""
        return (self._rpm or 0.0) if self._direction else 0.0

    # Functions

    def change_tool(self, tool: CuttingTool) -> None:
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

    # Motions

    def is_at(self, point: Floats) -> bool:
        """Tell whether the tool is at a point."""
        return float(np.abs(point - self.position).max()) <= SAME_PLACE

    def points_along(self, axes: Floats) -> bool:
        """Tell whether the tool has the direction already that it begins with, of the axes that follow, shape (n, 3)."""
        if self.kinematics is None:
            return True
        wanted = self.kinematics.angles_along(axes, self.angles)[0]
        return max(abs(wanted[0] - self.angles[0]), abs(wanted[1] - self.angles[1])) <= SAME_ANGLE

    def turn(self, axes: Floats) -> None:
        """Turn the tool into the first of the directions that follow, shape (n, 3), in rapid, its tip where it is."""
        if self.kinematics is None or self.points_along(axes):
            return
        first = self.kinematics.angles_along(axes, self.angles)[0]
        wanted = float(first[0]), float(first[1])
        count = 1
        if (
            self.kinematics.mechanism is not None
        ):  # a straight line of the slides would take the tip from its place
            count = math.ceil(max(abs(w - a) for w, a in zip(wanted, self.angles, strict=True)) / AXIS_STEP)
        angles = np.linspace(self.angles, wanted, count + 1)[1:]
        self.angles = wanted
        tips = np.tile(self.position, (count, 1))
        self._carry(self.kinematics, tips, angles)
        slides = self._slides(self.kinematics, tips, angles)
        self.canon.traverse(np.concatenate([slides, angles], axis=1))

    def traverse(self, point: Floats) -> None:
        """Move in a rapid straight line, if there is any way to go."""
        if not self.is_at(point):
            self.canon.traverse(self._rows(point[None, :]))
            self.position = point

    def link(self, point: Floats, axis: Floats, tool_axes: Floats, height: float) -> None:
        """Go to a point by way of a plane: up, over, down, in rapid.

        Args:
            point: Shape (3,), mm.
            axis: Shape (3,), the plane's normal, the direction of up and down.
            tool_axes: Shape (n, 3), the tool's directions from the point on; it turns above.
            height: Of the plane along `axis` from the machine's origin, mm; the tool goes no lower than it is.
        """
        here = float(elementary.product(self.position, axis))
        top = max(height, here, float(elementary.product(point, axis)))
        if here < top:
            self.traverse(self.position + (top - here) * axis)
        self.turn(tool_axes)
        self.traverse(point + (top - float(elementary.product(point, axis))) * axis)
        self.traverse(point)

    def tap(self, end: Floats, pitch: float) -> None:
        """Go to a point, shape (3,), and back in step with the spindle, `pitch` mm a turn."""
        self.canon.rigid_tap(self._rows(end[None, :])[0], pitch)

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
                self.canon.nurbs(self._seen(piece), control, rapid)

    def _follow_lines(self, piece: Polyline, rapid: bool) -> None:
        points, axes = piece.points, piece.axes
        if axes is not None and self.kinematics is not None:
            self._follow_turning(self.kinematics, points, axes, rapid)
            return
        moved = np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-9
        rows = self._rows(points)[1:][moved]
        if len(rows):
            (self.canon.traverse if rapid else self.canon.lines)(rows)
            self.position = points[-1]

    def _follow_turning(self, kinematics: RotaryAxes, points: Floats, axes: Floats, rapid: bool) -> None:
        """Move along points while the tool turns.

        With rows of slide positions, each line has the speed that gives the tip its feed.
        """
        points, axes = with_axes(points, axes)
        angles = kinematics.angles_along(axes, self.angles)
        reach, tolerance = self._reach(kinematics, points)
        for _ in range(MAX_REFINEMENTS if reach else 0):
            counts = _finer(points, angles, reach, tolerance)
            if (counts == 1).all() or len(points) > MAX_POINTS:
                break
            points, axes = with_axes(points, axes, counts)
            angles = kinematics.angles_along(axes, self.angles)
        self._carry(kinematics, points, angles)
        self.swing = max(self.swing, kinematics.swing(axes, angles))
        rows = np.concatenate([self._slides(kinematics, points, angles), angles], axis=1)
        if rapid or kinematics.mechanism is None or not self.feed:
            (self.canon.traverse if rapid else self.canon.lines)(rows)
        else:
            tip = np.linalg.norm(np.diff(np.concatenate([self.position[None, :], points]), axis=0), axis=1)
            self._lines_of_slides(rows, tip.tolist(), self.feed)
        self.angles = (float(angles[-1, 0]), float(angles[-1, 1]))
        self.position = points[-1]

    def _lines_of_slides(self, rows: Floats, tip: list[float], feed: float) -> None:
        """Feed along lines of all axes, shape (n, 5), each as fast as moves the tip, by `tip` mm, with the feed (mm/s).

        Slides that hardly move stand still, so that the rotary axes alone have the speed, rad/s.
        """
        last = self._full(self.position)
        for row, wanted in zip(rows, tip, strict=True):
            way = float(elementary.length(row[:3] - last[:3]))
            if way < STILL:
                row[:3] = last[:3]
                way = float(elementary.length(row[3:] - last[3:]))
            self.canon.feed(feed * way / wanted if wanted > 1e-9 and way > 0 else feed)
            self.canon.lines(row[None, :])
            last = row
        self.canon.feed(feed)

    def _seen(self, piece: _Curve) -> _Curve:
        """Return an arc or a spline as the slides see it."""
        if self.kinematics is None or self.kinematics.mechanism is None:
            return piece
        return piece.moved(self.kinematics.frame(self.angles, self._length))

    def _slides(self, kinematics: RotaryAxes, points: Floats, angles: Floats) -> Floats:
        """Return where the slides stand, shape (n, 3), for tips and angles, shape (n, 2)."""
        if kinematics.mechanism is None:
            return points
        pairs = zip(points, angles.tolist(), strict=True)
        return np.stack([kinematics.slides(p, (a, b), self._length) for p, (a, b) in pairs])

    def _reach(self, kinematics: RotaryAxes, points: Floats) -> tuple[float, float]:
        """Return how far the slides move for a turn by 1 rad, at most, mm, and how far they may be from the path, mm."""
        if kinematics.mechanism is None:
            return 0.0, 1.0
        upright = kinematics.frame((0.0, 0.0), self._length)
        level = kinematics.frame((math.pi / 2, math.pi / 2), self._length)
        moved = np.linalg.norm(apply(upright, points) - apply(level, points), axis=1)
        return float(moved.max()), kinematics.mechanism.tolerance

    @property
    def _length(self) -> float:
        """Return the length of the tool, mm, 0 if unknown."""
        return (self.tool.offset_length or 0.0) if self.tool else 0.0

    def _follow_arc(self, arc: Arc, rapid: bool) -> None:
        end, self.position = self._full(arc.end), arc.end
        if self.kinematics is not None:
            radius = float(elementary.length(arc.end - arc.centre))
            self._carry(self.kinematics, arc.end[None, :], np.array([self.angles]), 2.0 * radius)
        arc = self._seen(arc)
        aligned = np.count_nonzero(np.abs(arc.normal) > 1e-12) == 1
        flat = abs(float(elementary.product(arc.end - arc.start, arc.normal))) < 1e-9
        if aligned or not flat or arc.sweep > 2 * np.pi + 1e-9:
            self.canon.arc(arc, end, rapid)
            return
        # An arc across the main planes has no canonical call of its own: the same circle as a rational spline.
        u = arc.start - arc.centre
        curve = ellipse_arc(arc.centre, u, np.cross(arc.normal, u), 0.0, arc.sweep)
        control = curve.control
        if self.kinematics is not None:
            control = np.concatenate([control, np.tile(self.angles, (len(control), 1))], axis=1)
        self.canon.nurbs(curve, control, rapid)


def _finer(points: Floats, angles: Floats, reach: float, tolerance: float) -> NDArray[np.int64]:
    """Return into how many each line of all axes is to be cut for the tip to stay on its path, shape (n - 1,).

    A line goes a way D while the tool turns by the angle T. Cut into n straight lines of the axes, it leaves the path by
    (reach T² + 2 D T) / (8 n²) at most. The slides move by `reach` mm for a turn by 1 rad.
    """
    way = np.linalg.norm(np.diff(points, axis=0), axis=1)
    turn = np.abs(np.diff(angles, axis=0)).sum(axis=1)
    bulge = (reach * turn**2 + 2 * way * turn) / (8 * tolerance)
    return np.clip(np.ceil(np.sqrt(bulge) - 1e-9), 1, MAX_SPLIT).astype(np.int64)
