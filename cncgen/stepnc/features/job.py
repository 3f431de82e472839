"""The input of every strategy: the workingstep with its shape, and a record of the moves it makes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Severity
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.geometry.frames import translation
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.model import CutterPath, CuttingTool, Operation, Shape, Technology
from cncgen.stepnc.part21 import Exchange

Floats = NDArray[np.float64]

#: Height of the retract plane above the feature where none is given, mm (NIST's interpreter).
DEFAULT_RETRACT = 5.0
#: Walls steeper than this against the vertical are floors, rad.
MAX_SLOPE = math.radians(80.0)
#: The highest that a retract plane may be, mm.
MAX_HEIGHT = 1e5
#: More axial passes than this are a slip of the pen.
MAX_LEVELS = 10_000


@dataclass(slots=True)
class Job:
    """A feature to be machined: the values that strategies need. A missing one raises a fault.

    Attributes:
        ident: The workingstep.
        operation, shape: The work, and the shape that it makes.
        exchange: Takes the faults.
        raw: Lowest and highest point of the raw piece in the feature's frame, mm; None if not given.
    """

    ident: int
    operation: Operation
    shape: Shape
    exchange: Exchange
    raw: tuple[float, float] | None = None

    def fault(self, code: str, message: str, hint: str = "") -> Skip:
        """Report an error of the operation and return the exception to raise."""
        self.exchange.report(self.operation.ident, code, self._text(message), hint=hint)
        return Skip()

    def warn(self, code: str, message: str) -> None:
        """Report a warning of the operation."""
        self.exchange.report(self.operation.ident, code, self._text(message), severity=Severity.WARNING)

    def _text(self, message: str) -> str:
        return f"#{self.operation.ident} {self.operation.label!r}: {message}"

    @property
    def tool(self) -> CuttingTool:
        """Return the tool; raises `Skip` without one."""
        if self.operation.tool is None:
            raise self.fault("stepnc-missing", "a toolpath of the feature needs its_tool")
        return self.operation.tool

    @property
    def radius(self) -> float:
        """Return the tool's radius, mm; raises `Skip` if it is unknown."""
        diameter = self.tool.diameter
        if diameter is None:
            raise self.fault("stepnc-missing", f"tool {self.tool.name!r} has no diameter")
        return diameter / 2

    @property
    def depth(self) -> float:
        """Return the depth of the feature, mm; raises `Skip` without one."""
        if self.shape.depth is None or not self.shape.depth > 0:
            given = "none" if self.shape.depth is None else f"{self.shape.depth:g} mm"
            raise self.fault("stepnc-missing", f"the feature needs a depth below its origin, and has {given}")
        return self.shape.depth

    @property
    def technology(self) -> Technology:
        """Return the technology; raises `Skip` without one."""
        if self.operation.technology is None:
            raise self.fault("stepnc-missing", "a toolpath of the feature needs its_technology")
        return self.operation.technology

    @property
    def retract(self) -> float:
        """Return the height of the retract plane above the feature's origin, mm; raises `Skip` beyond `MAX_HEIGHT`."""
        given = self.operation.retract_plane
        if given is not None and not abs(given) <= MAX_HEIGHT:
            text = f"the retract plane is at {given:g} mm; it must lie between 0 and {MAX_HEIGHT:g} mm"
            raise self.fault("stepnc-range", text)
        if given is not None and given < 0:
            text = f"a retract plane {-given:g} mm below the feature's top: rapid moves would go through material"
            raise self.fault("stepnc-range", text)
        return DEFAULT_RETRACT if given is None else given

    def check_sizes(self) -> None:
        """Raise `Skip` where sizes of the operation cannot be: the tool would cut what is to stay, or leave walls standing.

        Depths of cut and allowances must not be negative, the radial depth not above the tool's diameter, and the feature not
        deeper than the raw piece.
        """
        for name in ("axial_cutting_depth", "radial_cutting_depth", "allowance_side", "allowance_bottom"):
            if self.value(name, 0.0) < 0:
                raise self.fault(
                    "stepnc-range", f"{name} is {self.value(name, 0.0):g} mm; it must not be negative"
                )
        radial, tool = self.value("radial_cutting_depth", 0.0), self.operation.tool
        if tool is not None and tool.diameter is not None and radial > tool.diameter + 1e-9:
            text = f"radial_cutting_depth is {radial:g} mm, and the tool has {tool.diameter:g} mm: walls would stay between passes"
            raise self.fault("stepnc-range", text, hint=f"at most {tool.diameter:g} mm")
        self._check_depths()
        if self.operation.technology is not None and self.operation.technology.spindle == 0.0:
            self.warn(
                "stepnc-no-spindle", "the feature is machined with the spindle standing: its speed is 0"
            )

    def _check_depths(self) -> None:
        """Raise `Skip` where the feature goes below the raw piece; warn where its depth is more than the tool's edge is long."""
        depth, tool = self.shape.depth, self.operation.tool
        if depth is None:
            return
        if self.raw is not None and self.shape.bottom != "through" and depth > -self.raw[0] + 1e-3:
            text = f"the feature is {depth:g} mm deep, and the raw piece ends {-self.raw[0]:g} mm below the feature's origin"
            raise self.fault("stepnc-depth", text)
        if tool is not None and tool.cutting_length and depth > tool.cutting_length + 1e-3:
            text = f"the feature is {depth:g} mm deep, and the tool's cutting edge is {tool.cutting_length:g} mm long"
            self.warn("stepnc-cutting-length", f"{text}; its shank may touch the wall")

    @property
    def top(self) -> float:
        """Return the height from which on material may stand in the way, mm: 0, or the top of the raw piece above it."""
        return 0.0 if self.raw is None else max(0.0, self.raw[1])

    def value(self, name: str, default: float) -> float:
        """Return a number among the operation's values."""
        found = self.operation.values.get(name)
        return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else default

    def strategy_value(self, name: str, default: float) -> float:
        """Return a number among the strategy's values."""
        strategy = self.operation.strategy
        found = strategy.values.get(name) if strategy else None
        return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else default

    def levels(self, total: float, stops: Sequence[float] = ()) -> list[float]:
        """Return the heights of axial passes down to `total` below the feature's origin, mm.

        The passes are equal from the origin to the bottom, and from one of the `stops` (heights between) to the next.
        """
        axial = self.value("axial_cutting_depth", 0.0)
        if not total > 0:
            raise self.fault(
                "stepnc-depth", f"nothing is left to cut: the depth less the allowance is {total:g} mm"
            )
        inner = sorted({-z for z in stops if 1e-9 < -z < total - 1e-9})
        out: list[float] = []
        for begin, end in pairwise([0.0, *inner, total]):
            count = max(1, math.ceil((end - begin) / axial - 1e-9)) if axial > 0 else 1
            if count > MAX_LEVELS:
                raise self.fault(
                    "stepnc-depth", f"passes {axial:g} mm deep are {count}; at most {MAX_LEVELS} are made"
                )
            out += [-begin - (end - begin) * (k + 1) / count for k in range(count)]
        return out

    def radial_step(self) -> float:
        """Return the distance between passes: the radial depth, else the diameter less the overlap, mm."""
        radial = self.value("radial_cutting_depth", 0.0)
        if radial > 0:
            return radial
        return 2 * self.radius * (1.0 - self.strategy_value("overlap", 0.5))

    @property
    def climb(self) -> bool:
        """Tell whether the tool cuts climb, by the strategy's cutmode, else by its sense of rotation."""
        strategy = self.operation.strategy
        values = strategy.values if strategy else {}
        mode = str(values.get("cutmode", values.get("spiral_cutmode", ""))).upper()
        if mode in ("CLIMB", "CONVENTIONAL"):
            return mode == "CLIMB"
        rotation = str(values.get("rotation_direction", "")).upper()
        return rotation != "CW" if self.clockwise_spindle else rotation == "CW"

    def stepover(self, along: Floats) -> Floats:
        """Return the unit vector from line to line of a strategy with lines along `along`, both of shape (3,).

        The strategy's stepover_direction says it, left by default. Unidirectional milling derives it from feed_direction and
        cutmode, conventional by default (ISO 14649-11): a tool that turns with the clock has what is still to be cut on its
        left then.
        """
        strategy = self.operation.strategy
        values = strategy.values if strategy else {}
        left = str(values.get("stepover_direction", "LEFT")).upper() == "LEFT"
        if strategy is not None and strategy.kind == "unidirectional" and "stepover_direction" not in values:
            left = (str(values.get("cutmode", "")).upper() != "CLIMB") == self.clockwise_spindle
        return np.array([-along[1], along[0], 0.0]) * (1.0 if left else -1.0)

    @property
    def clockwise_spindle(self) -> bool:
        """Tell whether the spindle turns with the clock."""
        technology = self.operation.technology
        if technology is not None and technology.spindle:
            return technology.spindle < 0
        return not (self.operation.tool is not None and self.operation.tool.left_handed)


@dataclass(slots=True)
class Moves:
    """The moves of a strategy, in the feature's frame, one after the other from `position`."""

    ident: int
    position: Floats
    technology: Technology | None = None
    _paths: list[tuple[bool, Technology | None, list[Piece]]] = field(default_factory=list)
    _extra: list[tuple[int, CutterPath]] = field(default_factory=list)

    def at(self, technology: Technology | None) -> None:
        """Feed with another technology from now on (None: the operation's)."""
        self.technology = technology

    def _add(self, rapid: bool, piece: Piece) -> None:
        last = self._paths[-1] if self._paths else None
        if last is None or last[0] != rapid or last[1] is not self.technology or self._broken():
            self._paths.append((rapid, self.technology, [piece]))
        else:
            last[2].append(piece)
        self.position = piece.end

    def _broken(self) -> bool:
        return bool(self._extra) and self._extra[-1][0] == len(self._paths)

    def _line(self, rapid: bool, *points: Floats) -> None:
        for point in points:
            target = np.asarray(point, float)
            if np.abs(target - self.position).max() > 1e-9:
                self._add(rapid, Polyline(np.stack([self.position, target])))

    def feed(self, *points: Floats) -> None:
        """Feed in straight lines."""
        self._line(False, *points)

    def rapid(self, *points: Floats) -> None:
        """Go in rapid straight lines."""
        self._line(True, *points)

    def height(self, z: float, rapid: bool = False) -> None:
        """Go up or down."""
        self._line(rapid, np.array([self.position[0], self.position[1], z]))

    def follow(self, pieces: list[Piece]) -> None:
        """Feed along pieces, the first of which begins here."""
        for piece in pieces:
            self._add(False, piece)

    def arc(self, end: Floats, centre: Floats, clockwise: bool, sweep: float) -> None:
        """Feed along an arc about a vertical axis; helix where the heights differ."""
        normal = np.array([0.0, 0.0, -1.0 if clockwise else 1.0])
        middle = np.array([centre[0], centre[1], self.position[2]])
        self._add(False, Arc(self.position, np.asarray(end, float), middle, normal, sweep))

    def dwell(self, seconds: float) -> None:
        """Wait."""
        if seconds > 0:
            self._extra.append((len(self._paths), CutterPath(self.ident, "dwell", seconds=seconds)))

    def tap(self, z: float, pitch: float) -> None:
        """Go down to a height in step with the spindle, `pitch` mm a turn, and back up."""
        line: list[Piece] = [Polyline(np.stack([self.position, at_height(self.position, z)]))]
        path = CutterPath(self.ident, "tap", _giver(line), technology=self.technology, pitch=pitch)
        self._extra.append((len(self._paths), path))

    def thread(self, points: Sequence[Floats], pitch: float) -> None:
        """Go along straight lines in step with the spindle, `pitch` mm a turn."""
        line: list[Piece] = [Polyline(np.stack([self.position, *points]))]
        path = CutterPath(self.ident, "thread", _giver(line), technology=self.technology, pitch=pitch)
        self._extra.append((len(self._paths), path))
        self.position = line[-1].end

    def dwell_turns(self, turns: float) -> None:
        """Wait for turns of the spindle."""
        if turns > 0:
            self._extra.append((len(self._paths), CutterPath(self.ident, "dwell", turns=turns)))

    def stop_spindle(self, technology: Technology) -> None:
        """Stop the spindle; the moves after it keep it so."""
        self.at(replace(technology, spindle=0.0, cutting_speed=None, feed_per_tooth=None, feed_per_rev=None))

    def paths(self) -> tuple[CutterPath, ...]:
        """Return the moves as toolpaths."""
        out: list[CutterPath] = []
        extra = list(self._extra)
        for k, (rapid, technology, pieces) in enumerate(self._paths):
            while extra and extra[0][0] <= k:
                out.append(extra.pop(0)[1])
            kept = None if rapid else technology
            out.append(CutterPath(self.ident, "trajectory", _giver(pieces), rapid, technology=kept))
        out.extend(path for _, path in extra)
        return tuple(out)


def _giver(pieces: list[Piece]) -> Callable[[], list[Piece]]:
    """Return a function that gives the pieces."""
    return lambda: pieces


def at_height(point: Floats, z: float) -> Floats:
    """Return a point, shape (3,), at another height."""
    return np.array([point[0], point[1], z])


def raised(pieces: list[Piece], z: float) -> list[Piece]:
    """Return pieces at height 0 moved up to a height."""
    frame = translation(0.0, 0.0, z)
    return [p.moved(frame) for p in pieces]
