"""Zero phase error tracking: a prefilter that undoes a closed loop without shifting its phase.

Source: M. Tomizuka, ASME J. Dyn. Syst. Meas. Control 109 (1987) 65; Hsu 1999, section 3. For a closed loop
z^-d B⁺(z⁻¹) B⁻(z⁻¹)/A(z⁻¹), B⁻ holding the zeros that may not be cancelled,

    r(k) = A(z⁻¹) B⁻(z) / (B⁺(z⁻¹) B⁻(1)²) y*(k + d)

needs the wanted positions d + deg B⁻ samples ahead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels.filters import recursive
from cncgen.servo.frequency import ratio_in_z
from cncgen.servo.loop import AxisLoop
from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]

#: Zeros nearer to the origin than this are cancelled: their remainder dies away within some 20 samples.
CANCELLABLE = 0.9
#: Stable zeros further out are cancelled where their mode has at least this damping; others would ring.
DAMPED = 0.3


@dataclass(frozen=True, slots=True)
class AxisFilter:
    """r(k) = Σ taps[i] y*(k + ahead − i) − Σ poles[i] r(k − 1 − i)."""

    taps: Floats
    ahead: int
    poles: Floats


def design(loop: AxisLoop, parts: int = 1) -> AxisFilter:
    """Return the prefilter of a loop with that many control periods a setpoint, from its own linear model.

    Raises:
        ValueError: The loop does not answer its setpoint, or does not reach it at rest.
    """
    above, below = ratio_in_z(loop, parts)
    small = 1e-12 * np.abs(above).max()
    if not (np.isfinite(above).all() and np.isfinite(below).all() and small > 0.0):
        raise ValueError("the loop does not answer its setpoint, or only in numbers beyond range")
    delay = int(np.flatnonzero(np.abs(above) > small)[0])
    zeros = np.roots(above[delay:])
    away = _cancellable(zeros)
    kept, cancelled = zeros[~away], zeros[away]
    stable = np.atleast_1d(np.real(np.poly(cancelled))) * above[delay]
    other = np.atleast_1d(np.real(np.poly(kept)))
    if abs(other.sum()) < 1e-9:
        raise ValueError("the loop has a zero at z = 1 and cannot be inverted")
    taps = np.convolve(below, other[::-1]) / (other.sum() ** 2 * stable[0])
    return AxisFilter(taps, delay + len(other) - 1, stable[1:] / stable[0])


def _cancellable(zeros: NDArray[np.inexact]) -> NDArray[np.bool_]:
    """Tell which zeros go into B⁺: stable, and either fast or damped. ln z is the zero's place in s, times the period."""
    size = np.abs(zeros)
    place = np.log(np.where(size > 0.0, zeros, 0.5).astype(complex))
    damping = -place.real / np.maximum(np.abs(place), 1e-300)
    return (size < CANCELLABLE) | ((size < 1.0 - 1e-6) & (damping >= DAMPED))


class Zpetc:
    """The prefilter of all axes (`cncgen.servo.scheme.Prefilter`)."""

    def __init__(self, filters: Sequence[AxisFilter]) -> None:
        self._filters = tuple(filters)
        self.after = max(f.ahead for f in filters) + 1
        self.before = max(len(f.taps) - 1 - f.ahead for f in filters)

    def started(self) -> Callable[[SampleBlock, Floats], Floats]:
        """Return the filter with its memory at rest."""
        memories = [np.zeros(len(f.poles)) for f in self._filters]

        def over(block: SampleBlock, origin: Floats) -> Floats:
            columns = [
                _filtered(block, i, origin[i], f, memory)
                for i, (f, memory) in enumerate(zip(self._filters, memories, strict=True))
            ]
            return np.column_stack(columns)

        return over


def _filtered(block: SampleBlock, axis: int, origin: float, design: AxisFilter, memory: Floats) -> Floats:
    rows = block.values[:, axis] - origin
    first = block.before + design.ahead - (len(design.taps) - 1)
    moving = np.convolve(rows[first : first + len(block) + len(design.taps)], design.taps, "valid")
    if len(memory):
        above, below = np.zeros(len(memory) + 1), np.concatenate([[1.0], design.poles])
        above[0] = 1.0
        # The margin behind the block does not enter the memory: it comes again in the next block.
        for part, state in ((moving[: len(block)], memory), (moving[len(block) :], memory.copy())):
            recursive(above, below, part, part, state)
    return moving
