"""A verdict as the lines that a person reads."""

from __future__ import annotations

from itertools import groupby

from cncgen.diagnostics import Severity
from cncgen.report.tables import counted, duration
from cncgen.units import ORDERS, file_unit
from cncgen.verify.verdict import Verdict


def as_text(verdict: Verdict) -> str:
    """Return peaks of each axis, distances, and broken limits."""
    seconds = (verdict.samples - 1) * verdict.period_s
    lines = [
        f"{counted(verdict.samples, 'setpoint')} every {1000 * verdict.period_s:g} ms, {duration(seconds)}"
    ]
    powers = dict(ORDERS)
    for letter, peaks in groupby(verdict.peaks, key=lambda peak: peak.axis):
        parts = (
            f"{p.order} {p.value:.6g} {file_unit(letter)}/s{powers[p.order]} ({100 * p.of_limit:.2f} %)"
            for p in peaks
        )
        lines.append(f"  {letter}: " + ", ".join(parts))
    lines.append(
        f"distance: setpoints to path {1000 * verdict.setpoints_to_path_mm:.3f} µm, "
        f"path to setpoints {1000 * verdict.path_to_setpoints_mm:.3f} µm"
    )
    errors = (item for item in verdict.breaches if item.severity == Severity.ERROR)
    broken = sorted({item.code.removeprefix("verify-") for item in errors})
    lines.append(f"broken: {', '.join(broken) or 'none'}")
    return "\n".join(lines)
