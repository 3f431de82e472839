"""A single-axis controller: a linear system from setpoint and measured position to drive input."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def _none() -> Floats:
    return np.zeros(0)


@dataclass(frozen=True, slots=True)
class Controller:
    """u = C q + Dr r + Dy y + Dv ẏ with memory q.

    Sampled (`continuous` False): q[k+1] = A q[k] + Br r[k] + By y[k] + Bs s[k], where s is what the drive's bound took
    off the input (bounded minus wanted), for anti-windup; u is held between samples.
    Continuous: q' = A q + Br r + By y + Bv ẏ; while the bound is met the rows in `frozen` stand still.

    Attributes:
        a: Shape (m, m).
        b_setpoint, b_position, b_velocity, b_bound: Shape (m,); an empty array stands for zeros.
        c: Shape (m,).
        d_setpoint, d_position, d_velocity: Direct gains; the velocity is the plant's velocity state.
        continuous: Which of the two it is.
        frozen: Indices of integrators that stop at the bound (continuous controllers).
    """

    a: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    b_setpoint: Floats = field(default_factory=_none)
    b_position: Floats = field(default_factory=_none)
    b_velocity: Floats = field(default_factory=_none)
    b_bound: Floats = field(default_factory=_none)
    c: Floats = field(default_factory=_none)
    d_setpoint: float = 0.0
    d_position: float = 0.0
    d_velocity: float = 0.0
    continuous: bool = False
    frozen: tuple[int, ...] = ()

    def column(self, name: str) -> Floats:
        """Return an input column by the name of its attribute, zeros where it is empty."""
        values: Floats = getattr(self, name)
        return values if len(values) else np.zeros(len(self.a))
