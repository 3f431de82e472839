"""A control scheme: a loop for each axis, with prefilters and couplings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.bank import Coupling
from cncgen.servo.loop import AxisLoop
from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]


class Prefilter(Protocol):
    """Shapes the setpoints of all axes before the loops receive them (feedforward with preview)."""

    @property
    def before(self) -> int:
        """Setpoints that it looks back."""

    @property
    def after(self) -> int:
        """Setpoints that it looks ahead."""

    def started(self) -> Callable[[SampleBlock, Floats], Floats]:
        """Return a function of a block and the stream's first row that gives the n + 1 shaped setpoints.

        Both the shaped setpoints and the loops are relative to the first row. The function keeps its memory from
        block to block.
        """


class PathCoupling(Protocol):
    """Couples the axes along the path."""

    @property
    def before(self) -> int:
        """Setpoints that it looks back."""

    @property
    def after(self) -> int:
        """Setpoints that it looks ahead."""

    def over(self, block: SampleBlock) -> Coupling:
        """Return the coupling of the axes over a block."""


@dataclass(frozen=True, slots=True)
class Scheme:
    """Loops of all axes, in their order, with an optional prefilter and coupling."""

    loops: tuple[AxisLoop, ...]
    prefilter: Prefilter | None = None
    coupling: PathCoupling | None = None

    @property
    def before(self) -> int:
        """Return how many setpoints back the scheme looks."""
        return max((part.before for part in (self.prefilter, self.coupling) if part), default=0)

    @property
    def after(self) -> int:
        """Return how many setpoints ahead the scheme looks."""
        return max((part.after for part in (self.prefilter, self.coupling) if part), default=0)


#: Makes a scheme for axes (letters) and a setpoint period.
SchemeMaker = Callable[[str, float], Scheme]
