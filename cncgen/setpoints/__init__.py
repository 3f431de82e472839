"""Setpoints: a `Trajectory` sampled once a period (`sample`), and the formats in which `Setpoints` are written and read.

`writers` and `readers` have a module a format; `columns` names the columns of a file, `checking` checks setpoints of a caller, and
`stream` has setpoints with their data before the first row.
"""

from __future__ import annotations

from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.sampling import SIGNALS, sample

__all__ = ["SIGNALS", "Setpoints", "sample"]
