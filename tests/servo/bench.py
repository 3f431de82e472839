"""What the servo tests share: setpoints from arrays, whole responses as arrays, profiles of the shipped machines."""

from functools import cache
from pathlib import Path

import numpy as np

from cncgen.machine.reading import servos_from_toml
from cncgen.servo.record import Response
from cncgen.servo.simulate import simulate, simulate_scheme
from cncgen.setpoints.record import Setpoints

ROOT = Path(__file__).resolve().parents[2]


@cache
def profile(name):
    """Servo data of a shipped profile."""
    content = (ROOT / "cncgen" / "machine" / "profiles" / f"{name}.toml").read_bytes()
    return servos_from_toml(content, name)


def stream(rows, axes="XY", period=0.001, chunk=1000):
    """Positions (n, axes) as chunks of a setpoint stream."""
    rows = np.asarray(rows, float).reshape(len(rows), len(axes))
    for first in range(0, len(rows), chunk):
        yield Setpoints(axes, period, first, rows[first : first + chunk])


def joined(responses):
    """One response of all its chunks; they must follow each other."""
    parts = list(responses)
    at = parts[0].first
    for part in parts:
        assert part.first == at
        at += len(part)
    names = ("command", "position", "force", "saturated", "contour_error_mm")
    whole = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
    head = parts[0]
    return Response(head.axes, head.period_s, head.first, force_unit=head.force_unit, **whole)


def run(rows, servos, axes="XY", period=0.001, chunk=1000, **options):
    """Simulate arrays."""
    return joined(simulate(stream(rows, axes, period, chunk), servos, **options))


def run_scheme(rows, scheme, axes="XY", period=0.001, chunk=1000):
    """Simulate arrays under a control scheme."""
    return joined(simulate_scheme(stream(rows, axes, period, chunk), scheme))


def circle(radius, speed, period=0.001, turns=2.0, ramp=0.2):
    """A circle at a speed that rises evenly over `ramp` seconds, mm."""
    t = np.arange(0.0, 2 * np.pi * turns * radius / speed + ramp, period)
    s = np.where(t < ramp, speed * t**2 / (2 * ramp), speed * (t - ramp / 2))
    return radius * np.column_stack([np.cos(s / radius), np.sin(s / radius)])
