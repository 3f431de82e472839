"""Plants: drives with their mechanics, as linear systems from drive input to position, and their nonlinear parts.

States are in mm (or rad) and seconds. Where a plant has a velocity, one of its states is the velocity, so that Coulomb friction can
detect a standstill.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Imperfections:
    """Friction, backlash and encoder of an axis, the parts that are not linear; each default leaves the part out.

    Attributes:
        bound: Largest drive input, either sign, in the plant's input unit.
        coulomb: Coulomb friction, in the plant's input unit.
        backlash: Play between motor and load, mm: the load follows half of it behind.
        encoder_step: Quantum of the measured position, mm.
        noise: Standard deviation of the measured position, mm.
        seed: Of the noise.
        load_feedback: True where the encoder is on the load's side of the play.
    """

    bound: float = np.inf
    coulomb: float = 0.0
    backlash: float = 0.0
    encoder_step: float = 0.0
    noise: float = 0.0
    seed: int = 0
    load_feedback: bool = False


@dataclass(frozen=True, slots=True)
class Plant:
    """ẋ = A x + B u(t − delay), y = C x.

    Attributes:
        a: Shape (n, n).
        b: Shape (n,).
        c: Shape (n,): the position that the axis is judged by, mm.
        velocity: Index of the state that is the motor's velocity, or None. Friction acts on it beside the drive input.
        measured: Shape (n,): the position that the encoder reads, where it is not `c`.
        delay_s: Dead time of the input.
        force_unit: Unit of u.
        sample_time_s: Where it is given, A and B are those of x[k+1] = A x[k] + B u[k] over this period.
        imperfections: Friction, backlash and encoder.
    """

    a: Floats
    b: Floats
    c: Floats
    velocity: int | None = None
    measured: Floats | None = None
    delay_s: float = 0.0
    force_unit: str = ""
    sample_time_s: float | None = None
    imperfections: Imperfections = field(default_factory=Imperfections)

    @property
    def encoder(self) -> Floats:
        """Shape (n,): row that the encoder reads."""
        return self.c if self.measured is None else self.measured

    def with_imperfections(self, **values: float) -> Plant:
        """Return the same plant with some imperfections set."""
        return replace(self, imperfections=replace(self.imperfections, **values))  # type: ignore[arg-type]

    def with_viscous(self, coefficient: float) -> Plant:
        """Return the same plant with viscous friction, in units of drive input a unit of speed.

        Raises:
            ValueError: The plant has no velocity state.
        """
        if coefficient == 0.0:
            return self
        if self.velocity is None:
            raise ValueError(
                "viscous friction needs a plant with a velocity state (relative degree two or more)"
            )
        a = self.a.copy()
        a[:, self.velocity] -= self.b * coefficient
        return replace(self, a=a)


def integrator(gain: float = 1.0, force_unit: str = "mm/s") -> Plant:
    """Return y' = gain u: a velocity loop so fast that its lag does not count."""
    return Plant(np.zeros((1, 1)), np.array([gain]), np.array([1.0]), force_unit=force_unit)


def velocity_loop(gain: float, time_constant: float, force_unit: str = "mm/s") -> Plant:
    """Return gain/(s (τ s + 1)): a first-order velocity loop (or torque-mode motor) and an integrator.

    States are position (mm) and velocity (mm/s). Hsu 1999 as fitted (gain 1, u in mm/s); Yeh and Sun 2008, eqs 2.1 and
    2.2, with gain = Kc Ke/counts_per_mm and u in V.
    """
    a = np.array([[0.0, 1.0], [0.0, -1.0 / time_constant]])
    return Plant(a, np.array([0.0, gain / time_constant]), np.array([1.0, 0.0]), 1, force_unit=force_unit)


def motor(pole: float, gain: float = 1.0, force_unit: str = "mm/s²") -> Plant:
    """Return gain/(s (s + pole)): the plant of Tsai 2010, Fig. 2; with gain 1 its input is an acceleration."""
    a = np.array([[0.0, 1.0], [0.0, -pole]])
    return Plant(a, np.array([0.0, gain]), np.array([1.0, 0.0]), 1, force_unit=force_unit)


def two_mass(
    motor_inertia: float,
    load_inertia: float,
    stiffness: float,
    damping: float = 0.0,
    motor_viscous: float = 0.0,
    load_viscous: float = 0.0,
    travel: float = 1.0,
    load_feedback: bool = False,
) -> Plant:
    """Return motor, spring and load; u is the motor's torque (N·m), the position the load's.

    Inertias kg·m², stiffness N·m/rad, damping N·m·s/rad, travel mm/rad. States: motor position (mm), motor
    velocity, load position, load velocity.
    J1 φ1'' = u − c1 φ1' − k(φ1 − φ2) − c(φ1' − φ2'), J2 φ2'' = k(φ1 − φ2) + c(φ1' − φ2') − c2 φ2'.
    """
    k, c = stiffness, damping
    a = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-k / motor_inertia, -(c + motor_viscous) / motor_inertia, k / motor_inertia, c / motor_inertia],
            [0.0, 0.0, 0.0, 1.0],
            [k / load_inertia, c / load_inertia, -k / load_inertia, -(c + load_viscous) / load_inertia],
        ]
    )
    b = np.array([0.0, travel / motor_inertia, 0.0, 0.0])
    motor_side, load_side = np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 0.0])
    return Plant(a, b, load_side, 1, load_side if load_feedback else motor_side, force_unit="N·m")


def transfer_function(
    numerator: Floats, denominator: Floats, delay_s: float = 0.0, force_unit: str = ""
) -> Plant:
    """Return a strictly proper ratio of polynomials in s as a plant; coefficients with the highest power first.

    Where the relative degree is two or more, the first two states are position and velocity, so friction can act.
    Raises ValueError where the ratio is not strictly proper.
    """
    a, b, c, feedthrough = companion(numerator, denominator)
    if feedthrough != 0.0:
        raise ValueError("a plant's numerator must have a lower degree than its denominator")
    velocity = None
    if len(a) > 1 and abs(c @ b) <= 1e-14 * np.abs(c).max() * np.abs(b).max():
        a, b, c = _with_velocity(a, b, c)
        velocity = 1
    return Plant(a, b, c, velocity, delay_s=delay_s, force_unit=force_unit)


def sampled_transfer_function(
    numerator: Floats, denominator: Floats, sample_time_s: float, delay_s: float = 0.0, force_unit: str = ""
) -> Plant:
    """Return a strictly proper ratio of polynomials in z (highest power first) as a plant with its input held.

    Raises:
        ValueError: The ratio is not strictly proper, or the dead time no whole number of sample times.
    """
    a, b, c, feedthrough = companion(numerator, denominator)
    if feedthrough != 0.0:
        raise ValueError("a plant's numerator must have a lower degree than its denominator")
    parts = delay_s / sample_time_s
    if abs(parts - round(parts)) > 1e-9:
        raise ValueError("the dead time of a plant in z must be a whole number of its sample times")
    delay = round(parts) * sample_time_s
    return Plant(a, b, c, delay_s=delay, force_unit=force_unit, sample_time_s=sample_time_s)


def companion(numerator: Floats, denominator: Floats) -> tuple[Floats, Floats, Floats, float]:
    """Return (A, B, C, D) of a proper ratio of polynomials in controllable form, time scaled to balance it.

    The states are those of the plain companion form divided by powers of ω = |a0|^(1/n): all of like size.
    Raises ValueError where the ratio is not proper.
    """
    below = np.trim_zeros(np.asarray(denominator, float), "f")
    above = np.trim_zeros(np.asarray(numerator, float), "f")
    n = len(below) - 1
    if len(above) > n + 1:
        raise ValueError("the numerator's degree is above the denominator's")
    above = np.concatenate([np.zeros(n + 1 - len(above)), above]) / below[0]
    below = below / below[0]
    feedthrough = float(above[0])
    rest = above[1:] - feedthrough * below[1:]
    speed = max(float(np.abs(np.roots(below)).max(initial=0.0)), 1e-300) if n else 1.0
    powers = speed ** np.arange(1, n + 1)
    a = np.eye(n, k=1) * speed
    if n:
        a[-1] = -(below[1:] / powers)[::-1] * speed
    b = np.zeros(n)
    b[-1:] = speed
    return a, b, (rest / powers)[::-1].copy(), feedthrough


def _with_velocity(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats, Floats]:
    """Change the basis so that the first two states are c x and its rate."""
    rows = np.array([c, c @ a])
    _, _, orthogonal = np.linalg.svd(rows)
    basis = np.vstack([rows, orthogonal[2:]])
    inverse = np.linalg.inv(basis)
    return basis @ a @ inverse, basis @ b, np.eye(len(a))[0]
