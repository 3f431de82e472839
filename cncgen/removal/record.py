"""The input and output of material removal. Lengths mm, volumes mm³, times s."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

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
        cutting_length: Above it the tool does not cut; infinite where it is not known.
        left_handed: Whether it cuts turning against the clock.
        shank: Radius of what is above `cutting_length`, None where it is not known.
        holder: Radius of the holder and its height above the tip, None where it is not known.
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

    @property
    def values(self) -> Floats:
        """The tool as the kernel takes it, shape (5,)."""
        return np.array([self.radius, self.flat, self.edge, self.slope, self.cutting_length])

    def height(self, rho: Floats) -> Floats:
        """Return how far the surface stands above the tip at distances from the axis, shape as given; infinite outside."""
        over = np.maximum(rho - self.flat, 0.0)
        if self.edge > 0:
            out = self.edge - np.sqrt(np.maximum(self.edge**2 - np.minimum(over, self.edge) ** 2, 0.0))
        else:
            out = over * self.slope
        return np.where(rho <= self.radius * (1 + 1e-12), out, np.inf)


class Target(Protocol):
    """The material of a stock that is to stay: known where features or a mesh say so."""

    def floor(self, x: Floats, y: Floats) -> Floats:
        """Return the lowest height that may be cut at places, shapes alike, mm; -inf where nothing is to stay."""

    def demanded(self, x: Floats, y: Floats) -> Floats:
        """Return the height above which nothing may be left, shapes alike, mm; +inf where no height is given."""


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
        stock: Afterwards.
        operations: In their order.
        findings: What is wrong.
        time_s, rate_mm3_s: Shapes (n,): when each motion ends at the programmed feeds, and how much it removes a second then.
    """

    stock: Field
    operations: tuple[OperationCut, ...]
    findings: tuple[Diagnostic, ...]
    time_s: Floats
    rate_mm3_s: Floats
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Tell whether nothing is wrong."""
        return not any(f.severity == "error" for f in self.findings)

    def as_json(self) -> dict[str, Any]:
        """Return the numbers as plain values."""
        return {
            "schema_version": 1,
            "cell_mm": self.stock.cell,
            "raw_volume_mm3": self.stock.raw_volume,
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
