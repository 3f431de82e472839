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
from numpy.typing import NDArray

from cncgen.servo.bank import Coupling
from cncgen.servo.frequency import response_to_drive
from cncgen.servo.loop import AxisLoop
from cncgen.servo.path_geometry import path_geometry
from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

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

    def over(self, block: SampleBlock) -> Coupling:
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


def contour_loop(loop: AxisLoop, proportional: float, integral: float, frequencies: Floats) -> Complexes:
    """Return W G of an axis at rad/s: the loop that the coupling closes where the path runs across that axis.

    G is the closed axis from drive input to position; W = P + I T z/(z − 1) in drive input a mm (and a mm·s).
    """
    z = np.exp(1j * np.asarray(frequencies) * loop.period)
    weight = proportional + integral * loop.period * z / (z - 1.0)
    return np.asarray(weight * response_to_drive(loop, frequencies), np.complex128)


def contour_modulus(loops: Sequence[AxisLoop], proportional: float, integral: float) -> float:
    """Return how far the contour loop stays from −1: min over axes and frequencies of |1 + W G|."""
    closest = np.inf
    for loop in loops:
        w = np.geomspace(1e-1, np.pi / loop.period, 600)
        closest = min(closest, float(np.abs(1.0 + contour_loop(loop, proportional, integral, w)).min()))
    return closest


def own_gain(loops: Sequence[AxisLoop]) -> float:
    """Return the axes' own stiffness, drive input a mm; the gains of CCC are multiples of it.

    It is the mean of 1/max |G| over the axes, G being the closed axis from drive input to position. Of a well damped P
    loop that is Kv, of PD and PD+ the proportional gain.
    """
    stiffness = []
    for loop in loops:
        w = np.geomspace(1e-3, np.pi / loop.period, 1000)
        stiffness.append(1.0 / float(np.abs(response_to_drive(loop, w)).max()))
    return float(np.mean(stiffness))


def coupling_of(loops: Sequence[AxisLoop], proportional: float, integral: float) -> CrossCoupling:
    """Return the coupling with P, and I in 1/s, as multiples of the axes' own gain."""
    own = own_gain(loops)
    return CrossCoupling(own * proportional, own * integral, loops[0].period)


def fitted(loops: Sequence[AxisLoop], proportional: float = 8.0, integral: float = 100.0) -> CrossCoupling:
    """Return a coupling in proportion to the axes' own gain, lowered until the contour loop keeps `MODULUS` from −1.

    Args:
        loops: The axes.
        proportional, integral: P, and I in 1/s, as multiples of the axes' own gain.

    Raises:
        ValueError: Even a thousandth of the gains comes too near.
    """
    own, share = own_gain(loops), 1.0
    while not keeps(loops, share * own * proportional, share * own * integral, MODULUS):
        share *= 0.9
        if share < 1e-3:
            raise ValueError(
                "the axes leave no room for a contour loop: they are near instability themselves"
            )
    return coupling_of(loops, share * proportional, share * integral)


def keeps(loops: Sequence[AxisLoop], proportional: float, integral: float, modulus: float) -> bool:
    """Tell whether the contour loop is stable and keeps a distance from −1.

    Every smaller gain must keep the distance too: gains grow from zero, so no encirclement of −1 is passed on the way.
    """
    return all(
        contour_modulus(loops, s * proportional, s * integral) >= modulus for s in (1.0, 0.75, 0.5, 0.25, 0.1)
    )
