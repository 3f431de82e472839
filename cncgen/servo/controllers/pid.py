"""Sampled PID with a filtered derivative and back-calculation against wind-up.

Source: K. J. Åström and T. Hägglund, PID Controllers, 2nd ed., ISA 1995, sections 3.4 and 3.5:

    I[k+1] = I[k] + Ki T e[k] + (T/Tt)(bounded − wanted),   D[k] = α D[k−1] + Kd (1 − α)/T (e[k] − e[k−1])

with α = e^(−N T) of the derivative's low-pass, and Tt the tracking time.
"""

from __future__ import annotations

import math

import numpy as np

from cncgen.servo.controller import Controller


def pid(
    proportional: float,
    integral: float,
    derivative: float,
    period: float,
    derivative_filter: float | None = None,
    tracking_time: float | None = None,
) -> Controller:
    """Return PID.

    Args:
        proportional, integral, derivative: Drive input a mm, a mm·s and a mm/s.
        period: Sampling period, s.
        derivative_filter: Corner of the derivative's low-pass, rad/s; None: no filter.
        tracking_time: Tt of the anti-windup, s; None takes √(Ti Td), or Ti without derivative (the book's advice).

    The memory is I, D and e[k−1].
    """
    alpha = math.exp(-derivative_filter * period) if derivative_filter else 0.0
    rate = derivative * (1.0 - alpha) / period
    gain = proportional + rate
    return Controller(
        # Without integral action its memory stays 0: else it would be a pole at 1 that nothing reaches.
        a=np.array([[float(integral != 0.0), 0.0, 0.0], [0.0, alpha, -rate], [0.0, 0.0, 0.0]]),
        b_setpoint=np.array([integral * period, rate, 1.0]),
        b_position=-np.array([integral * period, rate, 1.0]),
        b_bound=np.array(
            [period / (tracking_time or _tracking(proportional, integral, derivative)), 0.0, 0.0]
        ),
        c=np.array([1.0, alpha, -rate]),
        d_setpoint=gain,
        d_position=-gain,
    )


def _tracking(proportional: float, integral: float, derivative: float) -> float:
    if integral == 0.0 or proportional == 0.0:
        return math.inf
    integral_time, derivative_time = proportional / integral, derivative / proportional
    return math.sqrt(integral_time * derivative_time) if derivative_time else integral_time
