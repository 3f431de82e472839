"""Setpoints: a trajectory sampled once a period, and the formats it is written in."""

from __future__ import annotations

from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.sampling import SIGNALS, sample

__all__ = ["SIGNALS", "Setpoints", "sample"]
