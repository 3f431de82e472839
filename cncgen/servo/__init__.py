"""Servo axes: plants, controllers, closed-loop simulation, identification and design.

Names are imported from their modules; `simulate` and `Response` are the two that most callers need.
"""

from cncgen.servo.record import Response
from cncgen.servo.simulate import simulate

__all__ = ["Response", "simulate"]
