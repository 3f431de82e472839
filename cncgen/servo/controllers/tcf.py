"""Task coordinate frame control: tangential and normal error as two linear systems of their own.

Source: G. Chiu and M. Tomizuka; Hsu 1999, eqs 1 to 14. With F = [t n], R = [[0, 1], [−1, 0]] and ω = v κ the frame turns as
Ḟᵀ = ω R Fᵀ, so the errors in the frame are e_F = Fᵀ e, ė_F = Fᵀ ė + ω R Fᵀ e, and
ë_F = Fᵀ ë + 2 ω R Fᵀ ė + (ω̇ R − ω²) Fᵀ e. Asking for ë_F = −Kp e_F − Kd ė_F (eq. 11) gives the axis errors' acceleration

    ë = −F Kp Fᵀ e − F Kd (Fᵀ ė + ω R Fᵀ e) − 2 ω F R Fᵀ ė − F (ω̇ R − ω²) Fᵀ e

and a plant g/(s(τs + 1)) gives it for u = (τ/g)(ẍd − ë) + (ẋd − ė)/g. That is eqs 13 and 14 multiplied out; a test
compares with the matrices as printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.bank import Coupling
from cncgen.servo.path_geometry import path_geometry
from cncgen.servo.plants import Plant
from cncgen.servo.stream import Block

Floats = NDArray[np.float64]

_TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])


@dataclass(frozen=True, slots=True)
class TaskFrame:
    """The controller of two axes (`cncgen.servo.scheme.PathCoupling`).

    Attributes:
        gain, lag: Shape (2,): g and τ of each axis.
        stiffness, damping: Shape (2,): Kp and Kd, tangential and normal.
    """

    gain: Floats
    lag: Floats
    stiffness: Floats
    damping: Floats
    before: int = 2
    after: int = 3

    def over(self, block: Block) -> Coupling:
        """Return feedforward and feedback matrices at each setpoint of a block."""
        path = path_geometry(block)
        rates = [_turning_rate(block, shift) for shift in (-1, 0, 1)]
        feedback = self.feedback(path.tangent, rates[1], (rates[2] - rates[0]) / (2.0 * block.period_s))
        drive = (self.lag * path.acceleration + path.velocity) / self.gain
        none = np.zeros((0, 2))
        return Coupling(
            np.zeros(0), none, none, np.ascontiguousarray(np.stack([drive, path.velocity], axis=1)), feedback
        )

    def feedback(self, tangent: Floats, rate: Floats, change: Floats) -> Floats:
        """Return the gains on e and ė, shape (n, 2, 2, 2), for tangents (n, 2), ω (n,) and ω̇ (n,); at rest t is taken as x."""
        still = (tangent == 0.0).all(axis=1)
        t = np.where(still[:, None], [1.0, 0.0], tangent)
        frame = np.stack([t, np.column_stack([-t[:, 1], t[:, 0]])], axis=2)
        across = frame.transpose(0, 2, 1)
        w, dw = rate[:, None, None], change[:, None, None]
        stiffness, damping = np.diag(self.stiffness), np.diag(self.damping)
        position = frame @ (stiffness + damping @ (w * _TURN) + dw * _TURN - w**2 * np.eye(2)) @ across
        velocity = frame @ (damping + 2.0 * w * _TURN) @ across
        lag = (self.lag / self.gain)[:, None]
        return np.ascontiguousarray(
            np.stack([lag * position, lag * velocity - np.diag(1.0 / self.gain)], axis=1)
        )


def _turning_rate(block: Block, shift: int) -> Floats:
    """Return ω = t × ẍ/v, shape (n,), `shift` setpoints on."""
    path = path_geometry(block, shift)
    across = path.tangent[:, 0] * path.curvature[:, 1] - path.tangent[:, 1] * path.curvature[:, 0]
    return across * path.speed


def task_frame(plants: Sequence[Plant], poles: tuple[float, float] = (250.0, 350.0)) -> TaskFrame:
    """Return the controller that gives tangential and normal error these poles (−rad/s).

    Raises:
        ValueError: There are not two axes, or a plant is not g/(s(τs + 1)).
    """
    if len(plants) != 2:
        raise ValueError(f"the task frame is that of two axes, not {len(plants)}")
    if any(p.velocity != 1 or len(p.a) != 2 or p.a[1, 1] >= 0.0 for p in plants):
        raise ValueError("the task frame needs plants with a velocity state and a lag")
    lag = np.array([-1.0 / p.a[1, 1] for p in plants])
    gain = lag * np.array([p.b[1] for p in plants])
    return TaskFrame(gain, lag, np.full(2, poles[0] * poles[1]), np.full(2, poles[0] + poles[1]))
