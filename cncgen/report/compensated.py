"""The gain of a compensated command, as the lines that a person reads."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from cncgen.servo.shaping import Shaped
from cncgen.servo.uncertainty import Perturbation, share_error


def gain_lines(gained: dict[str, Any], perturbation: Perturbation | None) -> Iterator[str]:
    """Yield the lines of `cncgen.servo.compensation.Compensated.gained`."""
    passes = gained["passes"]
    rests = (
        f"it begins {gained['lead_s']:.3f} s before the motion and ends {gained['settle_s']:.3f} s after it"
    )
    yield f"{gained['samples']} setpoints after {passes} {'pass' if passes == 1 else 'passes'}; {rests}"
    if "room" in gained:
        yield _room_line(gained)
    yield "; ".join(_changes(gained["before"], gained["after"]))
    if gained["perturbed"] is not None and perturbation is not None:
        yield from _spread_lines(gained["perturbed"], perturbation)


def _changes(before: dict[str, Any], after: dict[str, Any]) -> Iterator[str]:
    """Yield the errors before and after, in thousandths."""
    names = (
        ("contour error max", "contour_max_mm", "µm"),
        ("contour error rms", "contour_rms_mm", "µm"),
        ("tracking error max", "tracking_max_mm", "µm"),
        ("tracking error max", "tracking_max_deg", "mdeg"),
    )
    for name, key, unit in names:
        if after.get(key) is not None:
            yield f"{name} {1e3 * before[key]:.3f} -> {1e3 * after[key]:.3f} {unit}"
    yield f"saturated samples {before['saturated_samples']} -> {after['saturated_samples']}"


def _room_line(gained: dict[str, Any]) -> str:
    if gained["room"] == 1.0:
        return f"planned to the whole limits, {gained['time_s']:.3f} s"
    return (
        f"planned with {100 * gained['room']:.0f} % of acceleration and jerk, to leave room:"
        f" {gained['time_s']:.3f} s instead of {gained['full_time_s']:.3f} s"
    )


def _spread_lines(found: dict[str, Any], perturbation: Perturbation) -> Iterator[str]:
    unit = "mm" if "after_worst_mm" in found else "deg"
    shown = "µm" if unit == "mm" else "mdeg"

    def text(name: str, label: str) -> str:
        value = found[f"{name}_{label}_{unit}"]
        return "unstable" if value is None else f"{1e3 * value:.3f}"

    parts = [f"{label} {text('before', key)} -> {text('after', key)} {shown}"
             for label, key in (("median", "median"), (f"95 ± {100.0 * share_error(0.95, found['draws']):.1f} % below", "q95"), ("worst", "worst"))]  # fmt: skip
    yield (f"with {perturbation} ({found['draws']} draws): largest error " + "; ".join(parts))
    if found["worse"]:
        yield f"on {found['worse']} of {found['draws']} drawn machines the command is worse than the motion as it is"


def shaping_lines(found: Shaped, shaper: str, period_s: float) -> Iterator[str]:
    """Yield the effect of a shaper on a motion."""
    length = (len(found.taps) - 1) * period_s
    yield (
        f"{len(found.command)} setpoints, shaped by {shaper}: {1e3 * length:.3g} ms longer, {1e3 * found.delay_s:.3g} ms late"
        " in the mean"
    )
    if not math.isnan(found.path_max_mm):
        yield f"the command leaves the path by {found.path_max_mm:.6f} mm at most, {found.path_rms_mm:.6f} mm rms"
