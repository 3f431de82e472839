"""Input and output of material removal. Lengths mm, volumes mm³, times s."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Cutter:
    """A tool that turns about Z, its tip at the origin: the part that cuts, and the parts that must not touch.

    Attributes:
        name: Called by a tool change.
        radius: Of the cut.
        flat: Radius of the level end.
        edge: Radius of the rounded edge: 0 of a sharp one, `radius` of a ball.
        slope: Rise over run of a cone outside of `flat`: of a drill's point or a chamfer; 0 without one.
        cutting_length: Above it the tool does not cut; infinite if unknown.
        left_handed: Whether it cuts turning against the clock.
        shank: Radius above `cutting_length`, None if unknown.
        holder: Radius of the holder and its height above the tip, None if unknown.
        steepest: Angle of the steepest way down from the plane across its axis, rad: less than 90 degrees if its edges do not
            reach its middle.
    """

    name: str
    radius: float
    flat: float
    edge: float = 0.0
    slope: float = 0.0
    cutting_length: float = np.inf
    left_handed: bool = False
    shank: float | None = None
    holder: tuple[float, float] | None = None
    steepest: float = math.pi / 2

    @property
    def values(self) -> Floats:
        """The tool as the kernel takes it, shape (5,)."""
        return np.array([self.radius, self.flat, self.edge, self.slope, self.cutting_length])

    def beside(self) -> Iterator[tuple[str, float, float]]:
        """Yield the parts that must not touch: name, radius, and begin above the tip, as far as known."""
        if self.holder is not None:
            yield "holder", *self.holder
        if self.shank is not None and self.shank > self.radius and math.isfinite(self.cutting_length):
            yield "shank", self.shank, self.cutting_length

    def height(self, rho: Floats) -> Floats:
        """Return how far the surface stands above the tip at distances from the axis, shape as given; infinite outside."""
        over = np.maximum(rho - self.flat, 0.0)
        if self.edge > 0:
            out = self.edge - np.sqrt(np.maximum(self.edge**2 - np.minimum(over, self.edge) ** 2, 0.0))
        else:
            out = over * self.slope
        return np.where(rho <= self.radius * (1 + 1e-12), out, np.inf)


@dataclass(frozen=True, slots=True)
class Insert:
    """A tool that stands while the work turns; the programmed point is its corner, as `cncgen.stepnc.features.turned_bar` has it.

    Attributes:
        name: Called by a tool change.
        nose: Radius of its corners.
        width: Of a tool for grooves, 0 of another.
        trailing: Angle of the edge that follows the corner from the axis of the work, rad.
        left: Whether the corner is at the higher Z.
        cutting_length, shank, holder: As of `Cutter`; not known.
    """

    name: str
    nose: float
    width: float = 0.0
    trailing: float = math.pi / 3
    left: bool = False
    cutting_length: float = np.inf
    shank: float | None = None
    holder: tuple[float, float] | None = None

    def edge(self, top: float) -> Floats:
        """Return the edge from low Z to high as corners (z, r) from the programmed point, shape (n, 2), convex, `top` mm high."""
        nose = min(self.nose, self.width / 2) if self.width else self.nose
        end = math.pi / 2 if self.width else self.trailing
        # Angles round the nose from its lowest point: the leading edge stands upright, the other as the tool has it.
        low, high = np.linspace(-math.pi / 2, 0.0, 65), np.linspace(0.0, end, 65)
        left = nose * np.column_stack([1 + np.sin(low), 1 - np.cos(low)])
        right = nose * np.column_stack([1 + np.sin(high), 1 - np.cos(high)])
        if self.width:
            right[:, 0] += self.width - 2 * nose
        rise = max(top - right[-1, 1], 0.0)
        last = [right[-1, 0] + (0.0 if self.width else rise / math.tan(end)), right[-1, 1] + rise]
        corners = np.concatenate([[[0.0, max(top, nose)]], left, right, [last]])
        corners = corners[np.append(True, np.abs(np.diff(corners, axis=0)).max(axis=1) > 1e-12)]
        return corners if not self.left or self.width else corners[::-1] * np.array([-1.0, 1.0])


class Target(Protocol):
    """The material of a stock that is to stay: known where features or a mesh say so."""

    def floor(self, x: Floats, y: Floats) -> Floats:
        """Return the lowest height that may be cut at places, shapes alike, mm; -inf where nothing is to stay."""

    def demanded(self, x: Floats, y: Floats) -> Floats:
        """Return the height above which nothing may be left, shapes alike, mm; +inf where no height is given."""

    def owner(self, x: float, y: float) -> tuple[str, int]:
        """Return the name and the source line of the feature that demands this height at a place; no name if unknown."""


@dataclass(frozen=True, slots=True)
class Field:
    """A stock as columns along Z on a square grid; all arrays of shape (rows, columns), row by row along X.

    Attributes:
        origin: x and y of the middle of the first column.
        cell: Width of a column.
        top, bottom: Of the raw piece; top below bottom where a column is empty.
        heights: At the middle of each column now.
        mean: Mean height in each column now.
    """

    origin: tuple[float, float]
    cell: float
    top: Floats
    bottom: Floats
    heights: Floats
    mean: Floats

    @property
    def x(self) -> Floats:
        """Shape (columns,): middles along X."""
        return self.origin[0] + self.cell * np.arange(self.top.shape[1], dtype=np.float64)

    @property
    def y(self) -> Floats:
        """Shape (rows,): middles along Y."""
        return self.origin[1] + self.cell * np.arange(self.top.shape[0], dtype=np.float64)

    @property
    def volume(self) -> float:
        """Volume that is left, mm³."""
        return float(np.maximum(self.mean - self.bottom, 0.0).sum()) * self.cell**2

    @property
    def raw_volume(self) -> float:
        """Volume of the raw piece, mm³."""
        return float(np.maximum(self.top - self.bottom, 0.0).sum()) * self.cell**2


@dataclass(frozen=True, slots=True)
class Clamping:
    """One of several setups of a program.

    Attributes:
        frame: Of the workpiece, seen from the machine, shape (4, 4).
        target: The material that its operations leave, None if unknown.
    """

    frame: Floats
    target: Target | None = None


@dataclass(frozen=True, slots=True)
class Turned:
    """A stock that is turned about X 0 Y 0: rings along Z, arrays of shape (rings,).

    Attributes:
        first: Z of the middle of the first ring.
        cell: Length of a ring.
        raw: Outer radius of the raw piece.
        radius: Outer radius now.
        bore: Inner radius now.
    """

    first: float
    cell: float
    raw: Floats
    radius: Floats
    bore: Floats

    @property
    def z(self) -> Floats:
        """Shape (rings,): middles along Z."""
        return self.first + self.cell * np.arange(len(self.raw), dtype=np.float64)

    @property
    def volume(self) -> float:
        """Volume that is left, mm³."""
        return float(np.maximum(self.radius**2 - self.bore**2, 0.0).sum()) * math.pi * self.cell

    @property
    def raw_volume(self) -> float:
        """Volume of the raw piece, mm³."""
        return float((self.raw**2).sum()) * math.pi * self.cell


class TurnedTarget(Protocol):
    """The material of a turned stock that is to stay."""

    def floor(self, z: Floats) -> Floats:
        """Return the smallest radius that may be cut at places along Z, mm; +inf where nothing may be."""

    def demanded(self, z: Floats) -> Floats:
        """Return the radius outside of which nothing may be left, mm; +inf where none is given."""

    def owner(self, z: float) -> tuple[str, int]:
        """Return the name and the source line of the feature that demands this radius at a place; no name if unknown."""


@dataclass(slots=True)
class DexelField:
    """Lines of material along one direction w, on a square grid over the two that follow it in X Y Z X Y.

    Attributes:
        ends: Shape (rows, columns, 2 k): where stretches of material begin and end, rising, mm.
        counts: Shape (rows, columns), int32: how many stretches there are.
    """

    ends: Floats
    counts: NDArray[np.int32]

    @property
    def lengths(self) -> Floats:
        """Shape (rows, columns): material on each line, mm."""
        there = np.arange(self.ends.shape[2] // 2) < self.counts[..., None]
        return np.asarray(np.where(there, self.ends[..., 1::2] - self.ends[..., ::2], 0.0).sum(axis=2))

    def grow(self) -> None:
        """Have twice as many places on each line."""
        self.ends = np.concatenate([self.ends, np.zeros_like(self.ends)], axis=2)

    def stretches(self) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Return all stretches: the number of the line (row by row), begin and end, mm; shapes (n,), by line and place."""
        there = np.arange(self.ends.shape[2] // 2) < self.counts[..., None]
        line = np.nonzero(there.reshape(-1, there.shape[2]))[0]
        return line, self.ends[..., ::2][there], self.ends[..., 1::2][there]


@dataclass(frozen=True, slots=True)
class Dexels:
    """A stock as lines along X, Y and Z through the nodes of one cubic grid.

    Attributes:
        origin: Shape (3,): the first node.
        cell: Distance of nodes.
        counts: Nodes along X, Y, Z.
        low, high: Shape (3,): bounds of the raw piece.
        fields: Lines along X, Y, Z.
    """

    origin: Floats
    cell: float
    counts: tuple[int, int, int]
    low: Floats
    high: Floats
    fields: tuple[DexelField, DexelField, DexelField]

    @property
    def volume(self) -> float:
        """Remaining volume, mm³: the mean of the three directions."""
        return sum(float(f.lengths.sum()) for f in self.fields) / 3 * self.cell**2

    def nodes(self, axis: int) -> Floats:
        """Return the places of the nodes along an axis."""
        return np.asarray(self.origin[axis] + self.cell * np.arange(self.counts[axis], dtype=np.float64))

    def seen(self) -> Field:
        """Return it as seen from above: top and underside of the material over each column."""
        field = self.fields[2]
        last = np.maximum(2 * field.counts - 1, 0)[..., None]
        there = field.counts > 0
        low = float(self.low[2])
        top = np.where(there, np.take_along_axis(field.ends, last, axis=2)[..., 0], low)
        bottom = np.where(there, field.ends[..., 0], low)
        return Field((float(self.origin[0]), float(self.origin[1])), self.cell, top, bottom, top, top)


class Met(NamedTuple):
    """The material and the faults that each of n motions meets.

    Attributes:
        volume: Shape (n,): removed.
        depth, at: Shapes (n,), (n, 3): the deepest bite, and where.
        gouge, gouge_at, gouged: The deepest cut into the finished part, where, and the volume.
        above: Shape (n,): how far material stands above the cutting edge, negative where none does.
    """

    volume: Floats
    depth: Floats
    at: Floats
    gouge: Floats
    gouge_at: Floats
    gouged: Floats
    above: Floats

    @classmethod
    def nothing(cls, count: int) -> Met:
        """Return that of motions that meet nothing."""
        flat, places = np.zeros(count), np.zeros((count, 3))
        return cls(flat, flat, places, flat, places, flat, np.full(count, -np.inf))


@dataclass(slots=True)
class OperationCut:
    """The material that an operation removes.

    Attributes:
        name: Its own, or that of its tool.
        line: Source line where it begins.
        tool: Name of the tool.
        volume_mm3: Removed.
        cutting_s: Time at the feed while it removes something, at the programmed speeds.
        deepest_mm: Largest height taken from a column in one motion.
    """

    name: str
    line: int
    tool: str
    volume_mm3: float = 0.0
    cutting_s: float = 0.0
    deepest_mm: float = 0.0


@dataclass(frozen=True, slots=True)
class Removal:
    """The material that a program cuts, with the faults of the cut.

    Attributes:
        stock: Afterwards, as it stands in the last setup.
        operations: In their order.
        findings: The faults.
        time_s, rate_mm3_s: Shapes (n,): when each motion ends at the programmed feeds, and how much it removes a second then.
        raw_volume_mm3: Of the stock before the first motion.
    """

    stock: Field | Turned | Dexels
    operations: tuple[OperationCut, ...]
    findings: tuple[Diagnostic, ...]
    time_s: Floats
    rate_mm3_s: Floats
    raw_volume_mm3: float

    @property
    def holds(self) -> bool:
        """Tell whether nothing is wrong."""
        return not any(f.severity == "error" for f in self.findings)

    def as_json(self) -> dict[str, Any]:
        """Return the numbers as plain values."""
        return {
            "schema_version": 1,
            "cell_mm": self.stock.cell,
            "raw_volume_mm3": self.raw_volume_mm3,
            "volume_mm3": self.stock.volume,
            "removed_mm3": sum(o.volume_mm3 for o in self.operations),
            "operations": [
                {
                    "name": o.name,
                    "line": o.line,
                    "tool": o.tool,
                    "removed_mm3": o.volume_mm3,
                    "cutting_s": o.cutting_s,
                    "deepest_mm": o.deepest_mm,
                    "mean_rate_mm3_s": o.volume_mm3 / o.cutting_s if o.cutting_s > 0 else None,
                }
                for o in self.operations
            ],
            "engagement": {"time_s": self.time_s.tolist(), "rate_mm3_s": self.rate_mm3_s.tolist()},
            "findings": [f.as_json() for f in self.findings],
        }
