"""P position control: u = Kv (r − y). Tracking error at constant velocity v is v/Kv.

Source: Y. Koren, Computer Control of Manufacturing Systems, McGraw-Hill 1983, ch. 7; the P rows of Hsu 1999, Table 1.
"""

from __future__ import annotations

from cncgen.servo.controller import Controller


def p(gain: float) -> Controller:
    """Return P control, `gain` in drive input a mm of error."""
    return Controller(d_setpoint=gain, d_position=-gain)
