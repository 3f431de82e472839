"""Task coordinate frame control: the errors along and across the path as linear systems of their own.

Source: G. Chiu and M. Tomizuka, IEEE Trans. Control Systems Technology 9 (2001); Hsu 1999, eqs 1 to 14, in the plane. Here it
stands without a frame's axes, so that it holds in two and three dimensions alike. With the unit tangent t and

    W = ṫ tᵀ − t ṫᵀ

(skew; W t = ṫ) a frame F = [t n …] that turns only as much as its tangent has Ḟ = W F. The errors in the frame are
e_F = Fᵀ e, ė_F = Fᵀ(ė − W e), ë_F = Fᵀ(ë − 2 W ė − Ẇ e + W² e). Asking for ë_F = −Kp e_F − Kd ė_F (eq. 11) gives

    ë = −K̃p e − K̃d (ė − W e) + 2 W ė + Ẇ e − W² e,   K̃ = k_t t tᵀ + k_n (I − t tᵀ)

where k_n is one gain for every direction across: so no normal has to be named, and a straight line, where Frenet's is not
defined, is like any other path. A plant ẍ = −a ẋ + b u gives it for u = (ẍd − ë + a (ẋd − ė))/b. In the plane
W = −ω R with Hsu's R = [[0, 1], [−1, 0]] and ω = v κ, and these are eqs 13 and 14 multiplied out; a test compares with the
matrices as printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.bank import Coupling
from cncgen.servo.discretise import held
from cncgen.servo.path_geometry import path_geometry
from cncgen.servo.plants import Plant
from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TaskFrame:
    """The controller of two or three axes (`cncgen.servo.scheme.PathCoupling`).

    Attributes:
        drag, strength: Shape (axes,): a (1/s) and b (mm/s² per unit of drive input) of each plant.
        stiffness, damping: Shape (2,): Kp (1/s²) and Kd (1/s), along and across the path.
    """

    drag: Floats
    strength: Floats
    stiffness: Floats
    damping: Floats
    before: int = 2
    after: int = 3

    def over(self, block: SampleBlock) -> Coupling:
        """Return feedforward and feedback matrices at each setpoint of a block."""
        path = path_geometry(block)
        turning = [_turning(block, shift) for shift in (-1, 0, 1)]
        feedback = self.feedback(path.tangent, turning[1], (turning[2] - turning[0]) / (2.0 * block.period_s))
        drive = (path.acceleration + self.drag * path.velocity) / self.strength
        none = np.zeros((0, len(self.drag)))
        return Coupling(
            np.zeros(0), none, none, np.ascontiguousarray(np.stack([drive, path.velocity], axis=1)), feedback
        )

    def feedback(self, tangent: Floats, turning: Floats, change: Floats) -> Floats:
        """Return the gains on e and ė, shape (n, 2, axes, axes).

        Args:
            tangent: Shape (n, axes); zero at rest, where every direction counts as one across.
            turning, change: Shape (n, axes, axes): W and Ẇ.
        """
        along = tangent[:, :, None] * tangent[:, None, :]
        across = np.eye(tangent.shape[1]) - along
        stiffness = self.stiffness[0] * along + self.stiffness[1] * across
        damping = self.damping[0] * along + self.damping[1] * across
        position = stiffness - damping @ turning - change + turning @ turning
        velocity = damping - 2.0 * turning - np.diag(self.drag)
        return np.ascontiguousarray(np.stack([position, velocity], axis=1) / self.strength[:, None])


def _turning(block: SampleBlock, shift: int) -> Floats:
    """Return W, shape (n, axes, axes), `shift` setpoints on."""
    path = path_geometry(block, shift)
    rate = path.curvature * path.speed[:, None]
    outer: Floats = rate[:, :, None] * path.tangent[:, None, :]
    return outer - outer.transpose(0, 2, 1)


def task_frame(
    plants: Sequence[Plant], tangential: tuple[float, float], normal: tuple[float, float]
) -> TaskFrame:
    """Return the controller that gives the errors along and across the path natural frequency (rad/s) and damping.

    Raises:
        ValueError: There are not two or three axes, or a plant is not b/(s(s + a)).
    """
    if len(plants) not in (2, 3):
        raise ValueError(f"the task frame is that of two or three axes, not {len(plants)}")
    if not all(_is_second_order(p) for p in plants):
        raise ValueError("the task frame needs plants with a position and a velocity state, and a lag")
    asked = np.array([tangential, normal])
    return TaskFrame(
        np.array([-p.a[1, 1] for p in plants]),
        np.array([p.b[1] for p in plants]),
        asked[:, 0] ** 2,
        2.0 * asked[:, 1] * asked[:, 0],
    )


def _is_second_order(plant: Plant) -> bool:
    return (
        plant.velocity == 1
        and len(plant.a) == 2
        and not plant.a[:, 0].any()
        and bool((plant.c == [1, 0]).all())
    )


def loop_on_a_line(
    plant: Plant, natural: float, damping: float, period: float, frequencies: Floats
) -> NDArray[np.complex128]:
    """Return the loop of one axis broken at its drive, on a straight path along it: sampled state feedback.

    Args:
        plant: b/(s(s + a)).
        natural, damping: rad/s and ratio of the error's dynamics.
        period: Control period, s.
        frequencies: rad/s.
    """
    drag, strength = -plant.a[1, 1], plant.b[1]
    law = np.array([natural**2, 2.0 * damping * natural - drag]) / strength
    phi, gamma = held(plant.a, plant.b[:, None], period)
    z = np.exp(1j * np.asarray(frequencies) * period)
    states = np.linalg.solve(z[:, None, None] * np.eye(2) - phi, np.broadcast_to(gamma, (len(z), 2, 1)))
    return np.asarray(states[:, :, 0] @ law, np.complex128)
