"""The summary of a simulation as the lines that a person reads."""

from __future__ import annotations

from typing import Any

from cncgen.report.tables import counted
from cncgen.units import file_unit


def as_text(summary: dict[str, Any]) -> str:
    """Return the lines of a summary (`cncgen.servo.summary.Summary.as_dict`, with ``axis_params``)."""
    lines = [f"{counted(summary['samples'], 'sample')} simulated with {summary['axis_params']}"]
    for letter, axis in summary["axes"].items():
        unit = file_unit(letter)
        thousandth = "µm" if unit == "mm" else "mdeg"
        lines.append(
            f"  {letter.upper()}: tracking error rms {1000 * axis[f'tracking_rms_{unit}']:.3f}, "
            f"max {1000 * axis[f'tracking_max_{unit}']:.3f} {thousandth} at {axis['tracking_max_t_s']:.4f} s; "
            f"force up to {axis['force_max']:.4g} {axis['force_unit']}, "
            f"{counted(axis['saturated_samples'], 'saturated sample')}"
        )
    if summary["contour_error_max_mm"] is not None:
        lines.append(
            f"contour error rms {1000 * summary['contour_error_rms_mm']:.3f}, "
            f"max {1000 * summary['contour_error_max_mm']:.3f} µm at {summary['contour_error_max_t_s']:.4f} s; "
            f"speed variation {summary['speed_variation_mm_s']:.4f} mm/s"
        )
    return "\n".join(lines)
