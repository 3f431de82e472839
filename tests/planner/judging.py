"""Setpoints judged by their finite differences, for the tests of planning."""

from __future__ import annotations

import numpy as np

from cncgen.machine import Machine


def used(x: np.ndarray, machine: Machine) -> float:
    """Return the largest part of a limit among the differences of setpoints, rest before and after included.

    Args:
        x: Shape (n, 3), mm: X Y Z a period apart.
        machine: Limits and period.
    """
    limits = np.array(
        [[a.max_velocity, a.max_acceleration, a.max_jerk] for a in map(machine.axes.get, "XYZ")]
    )
    padded = np.concatenate([np.repeat(x[:1], 3, 0), x, np.repeat(x[-1:], 3, 0)])
    peaks = [np.abs(np.diff(padded, k, axis=0)).max(axis=0) / machine.period_s**k for k in (1, 2, 3)]
    return float((np.array(peaks).T / limits).max())
