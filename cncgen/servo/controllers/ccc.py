"""Cross-coupled control with variable gains.

Source: Y. Koren and C. C. Lo, Annals of the CIRP 40 (1991) 371; Hsu 1999, section 3. With the tangent at angle ψ, the
signed radius ρ and the axis errors E,

    ε = −Cx Ex + Cy Ey,   Cx = sin ψ − Ex/(2ρ),   Cy = cos ψ + Ey/(2ρ),
    ux −= Cx W ε,   uy += Cy W ε,   W = P + I/s (PI)

In three dimensions ε is the vector e − (e·t) t + κ |e|²/2, and each axis receives its component of W ε.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cncgen.servo.bank import Coupling
from cncgen.servo.frequency import response_to_drive
from cncgen.servo.loop import AxisLoop
from cncgen.servo.path_geometry import path_geometry
from cncgen.servo.stream import Block

#: Smallest distance of the contour loop from −1 that `fitted` leaves.
MODULUS = 0.25


@dataclass(frozen=True, slots=True)
class CrossCoupling:
    """The coupling (`cncgen.servo.scheme.PathCoupling`).

    Attributes:
        proportional: Drive input a mm of contour error.
        integral: Drive input a mm·s.
        control_period: s.
    """

    proportional: float
    integral: float
    control_period: float
    before: int = 1
    after: int = 2

    def over(self, block: Block) -> Coupling:
        """Return tangent and curvature of the block's path with the gains."""
        path = path_geometry(block)
        gains = np.array([self.proportional, self.integral * self.control_period])
        none = np.zeros((0, 2, 0))
        return Coupling(
            gains,
            np.ascontiguousarray(path.tangent),
            np.ascontiguousarray(path.curvature),
            none,
            np.zeros((0, 2, 0, 0)),
        )


def contour_modulus(loops: Sequence[AxisLoop], proportional: float, integral: float) -> float:
    """Return how far the contour loop stays from −1: min over axes and frequencies of |1 + W G|.

    G is the closed axis from drive input to position: what the coupling acts on where the path runs across that axis.
    """
    closest = np.inf
    for loop in loops:
        w = np.geomspace(1e-1, np.pi / loop.period, 600)
        z = np.exp(1j * w * loop.period)
        weight = proportional + integral * loop.period * z / (z - 1.0)
        closest = min(closest, float(np.abs(1.0 + weight * response_to_drive(loop, w)).min()))
    return closest


def fitted(loops: Sequence[AxisLoop], proportional: float = 8.0, integral: float = 100.0) -> CrossCoupling:
    """Return a coupling in proportion to the axes' own gain, lowered until the contour loop keeps `MODULUS` from −1.

    Args:
        loops: The axes.
        proportional, integral: P, and I in 1/s, as multiples of the axes' mean gain from position error to drive input.
    """
    own = float(np.mean([abs(loop.law_inputs[0]) for loop in loops]))
    share = 1.0
    while share > 1e-4 and not _sound(loops, share * own * proportional, share * own * integral):
        share *= 0.9
    return CrossCoupling(share * own * proportional, share * own * integral, loops[0].period)


def _sound(loops: Sequence[AxisLoop], proportional: float, integral: float) -> bool:
    """Tell whether the contour loop is stable with its modulus margin.

    Every smaller gain must keep the distance too: gains grow from zero, so no encirclement of −1 is passed on the way.
    """
    return all(
        contour_modulus(loops, s * proportional, s * integral) >= MODULUS for s in (0.1, 0.25, 0.5, 0.75, 1.0)
    )
