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
            f"contour error{_measured(summary, len(summary['axes']))} rms {1000 * summary['contour_error_rms_mm']:.3f}, "
            f"max {1000 * summary['contour_error_max_mm']:.3f} µm at {summary['contour_error_max_t_s']:.4f} s; "
            f"speed variation {summary['speed_variation_mm_s']:.4f} mm/s"
        )
    if "reference" in summary:
        lines.append(_reference_line(summary["reference"], len(summary["axes"])))
    if "perturbed" in summary:
        lines += _spread_lines(summary["perturbed"])
    return "\n".join(lines)


def _measured(found: dict[str, Any], axes: int) -> str:
    """Name what the contour error is measured of where other axes move too, whose errors a tool's tip may follow."""
    measured = found["contour_error_of"]
    if measured == "tip":
        return " of the tip on the workpiece"
    return f" of {' '.join(measured)} alone" if len(measured) < axes else ""


def _reference_line(found: dict[str, Any], axes: int) -> str:
    """Return the errors against the wanted motion."""
    unit = "mm" if "tracking_max_mm" in found else "deg"
    thousandth = "µm" if unit == "mm" else "mdeg"
    late = f", which begins at {found['shift_s']:.3f} s" if found["shift_s"] else ""
    parts = [f"against {found['name']}{late}:"]
    if found["contour_error_max_mm"] is not None:
        parts.append(
            f"contour error{_measured(found, axes)} rms {1000 * found['contour_error_rms_mm']:.3f}, max {1000 * found['contour_error_max_mm']:.3f} µm"
            f" at {found['contour_error_max_t_s']:.4f} s;"
        )
    rms, largest = 1000 * found[f"tracking_rms_{unit}"], 1000 * found[f"tracking_max_{unit}"]
    return " ".join([*parts, f"tracking error rms {rms:.3f}, max {largest:.3f} {thousandth}"])


def _spread_lines(found: dict[str, Any]) -> list[str]:
    """Return the figures on drawn machines."""
    unstable = f", {found['unstable']} of them UNSTABLE" if found["unstable"] else ""
    share, error = (100.0 * found[key] for key in ("interval_share", "interval_share_error"))
    lines = [
        f"on {found['draws']} machines with {found['of']}{unstable} ({share:g} ± {error:.1f} % of all such machines are within):"
    ]
    for name, values in found.items():
        if isinstance(values, dict) and "rms" not in name:
            low, median, high, worst = (
                "unstable" if values[key] is None else f"{1000 * values[key]:.3f}"
                for key in ("low", "median", "high", "worst")
            )
            unit = "mdeg" if "_deg" in name else "µm"
            words = name.replace("_mm", "").replace("_deg", "").replace("_", " ")
            lines.append(f"  {words}: from {low} to {high} {unit}, median {median}, worst {worst}")
    return lines
