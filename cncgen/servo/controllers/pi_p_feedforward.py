"""The cascade of Tsai 2010, Fig. 2: P position loop, PI velocity loop, filtered velocity feedforward.

    command c = Kpp (r − y) + Kvff wn s/(s + wn) r
    u = b Kvp (1 + 1/(Ti s)) (c − ẏ)

The paper treats it as continuous (eq. 9), and so does this module. The memory is q1 = ∫ (c − ẏ) dt, which stands still while
the drive's bound is met, and q2, the low-pass of r: wn s/(s + wn) r = wn (r − q2).
"""

from __future__ import annotations

import numpy as np

from cncgen.servo.controller import Controller


def pi_p_feedforward(
    velocity_gain: float,
    integral_rate: float,
    position_gain: float,
    feedforward_gain: float,
    feedforward_filter: float,
) -> Controller:
    """Return the controller of a motor b/(s(s + a)) whose input is b times the drive's, an acceleration.

    Args:
        velocity_gain: b Kvp, 1/s.
        integral_rate: 1/Ti, 1/s.
        position_gain: Kpp, 1/s.
        feedforward_gain: Kvff.
        feedforward_filter: wn, rad/s.
    """
    forward = feedforward_gain * feedforward_filter
    return Controller(
        a=np.array([[0.0, -forward], [0.0, -feedforward_filter]]),
        b_setpoint=np.array([position_gain + forward, feedforward_filter]),
        b_position=np.array([-position_gain, 0.0]),
        b_velocity=np.array([-1.0, 0.0]),
        c=velocity_gain * np.array([integral_rate, -forward]),
        d_setpoint=velocity_gain * (position_gain + forward),
        d_position=-velocity_gain * position_gain,
        d_velocity=-velocity_gain,
        continuous=True,
        frozen=(0,),
    )
