"""PD and PD+ control of a torque-mode motor. Source: Yeh and Sun 2008, eqs 2.4, 2.12 and 3.3.

The paper's law, with θ in counts and w in rad/s:

    u = Kp (θd − θ) + Kd (wd − w) + wd/Kc + (τ/Kc) ẇd

where every rate is a backward difference over the sampling period. Eq. 2.10's wd − Ke wd mixes units (θ̇d = Ke wd, so
the term vanishes) and is not here; docs/controllers.md says more.
"""

from __future__ import annotations

import numpy as np

from cncgen.servo.controller import Controller


def pd_plus(
    proportional: float,
    derivative: float,
    velocity_forward: float,
    acceleration_forward: float,
    period: float,
) -> Controller:
    """Return the sampled law in mm.

    Args:
        proportional: Drive input a mm: Kp times counts/mm.
        derivative: Drive input a mm/s: Kd times (counts/mm)/Ke.
        velocity_forward: The same of 1/Kc; 0 for PD.
        acceleration_forward: Drive input a mm/s²: τ/Kc times (counts/mm)/Ke; 0 for PD.
        period: Sampling period, s.

    The memory is r[k−1], r[k−2] and y[k−1].
    """
    d, v, f = derivative / period, velocity_forward / period, acceleration_forward / period**2
    return Controller(
        a=np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        b_setpoint=np.array([1.0, 0.0, 0.0]),
        b_position=np.array([0.0, 0.0, 1.0]),
        b_bound=np.zeros(3),
        c=np.array([-d - v - 2.0 * f, f, d]),
        d_setpoint=proportional + d + v + f,
        d_position=-proportional - d,
    )
