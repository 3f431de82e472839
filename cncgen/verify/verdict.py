"""The findings of a verification: figures, and where a limit is broken."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from cncgen.diagnostics import Diagnostic, Diagnostics
from cncgen.shown import html_of


@dataclass(frozen=True, slots=True)
class Peak:
    """The largest finite difference of one order on one axis, in the units of files.

    Attributes:
        axis: Letter.
        order: ``velocity``, ``acceleration`` or ``jerk``.
        value: The largest magnitude.
        limit: The machine's.
        t_s: When.
        line: Source line at that time, or 0.
        broken: How many samples are over the limit.
    """

    axis: str
    order: str
    value: float
    limit: float
    t_s: float
    line: int
    broken: int

    @property
    def of_limit(self) -> float:
        """The value as a fraction of the limit."""
        return self.value / self.limit


@dataclass(frozen=True, slots=True)
class Verdict:
    """The outcome.

    Attributes:
        samples: Number of setpoints.
        period_s: Their period.
        peaks: Three an axis.
        setpoints_to_path_mm: Largest distance of a setpoint, or of the chord between two, from the programmed path.
        path_to_setpoints_mm: Largest distance of a place of the programmed path from the setpoints' polyline.
        breaches: A diagnostic for each limit that is broken (code ``verify-…``).
    """

    samples: int
    period_s: float
    peaks: tuple[Peak, ...]
    setpoints_to_path_mm: float
    path_to_setpoints_mm: float
    breaches: Diagnostics = field(default_factory=Diagnostics)

    def __repr__(self) -> str:
        worst = 1e3 * max(self.setpoints_to_path_mm, self.path_to_setpoints_mm)
        return f"Verdict({self.samples} setpoints, at most {worst:.4g} µm from the path, {self.breaches!r})"

    def _repr_html_(self) -> str | None:
        return html_of(self)

    @property
    def holds(self) -> bool:
        """Tell whether nothing is broken."""
        return not self.breaches.has_errors

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            "holds": self.holds,
            "samples": self.samples,
            "period_s": self.period_s,
            "peaks": [
                {
                    "axis": p.axis,
                    "order": p.order,
                    "value": p.value,
                    "limit": p.limit,
                    "of_limit": p.of_limit,
                    "t_s": p.t_s,
                    "line": p.line,
                    "broken": p.broken,
                }
                for p in self.peaks
            ],
            "setpoints_to_path_mm": self.setpoints_to_path_mm,
            "path_to_setpoints_mm": self.path_to_setpoints_mm,
            "breaches": [item.as_json() for item in self.breaches],
        }


def breach(code: str, message: str, **values: Any) -> Diagnostic:
    """Return the diagnostic of a broken limit."""
    return Diagnostic(f"verify-{code}", message, values=values)


def on_line(line: int) -> str:
    """Return the source line for a message; 0 if unknown."""
    return f"(line {line})" if line else "(line unknown)"
