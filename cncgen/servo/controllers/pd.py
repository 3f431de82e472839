"""PD control, on the error's difference. Source: Yeh and Sun 2008, eq. 2.4."""

from __future__ import annotations

from cncgen.servo.controllers.base import Controller
from cncgen.servo.controllers.pd_plus import pd_plus


def pd(proportional: float, derivative: float, period: float) -> Controller:
    """Return sampled PD: drive input a mm, and a mm/s; the rates are backward differences."""
    return pd_plus(proportional, derivative, 0.0, 0.0, period)
