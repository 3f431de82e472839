"""The H-infinity controller of a servo table: designed from its weights, sampled, and held against its bounds.

The bounds are those of the appended paper (`cncgen.servo.controllers.hinf`): |S| ≤ α = 1/|W1| and |T| ≤ M_L at every frequency,
for every plant of a family: here natural frequencies and gains within a share of the nominal ones, as a payload changes them. They are
checked on the loop as it runs, with the sampled controller, the held input and the dead time.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.servo import plants
from cncgen.servo.controller import Controller
from cncgen.servo.controllers import hinf
from cncgen.servo.controllers.ratio import sampled
from cncgen.servo.frequency import open_loop
from cncgen.servo.loop import close_loop

Floats = NDArray[np.float64]

#: Entries of a servo table (model ``plant``) that the design depends on.
_DESIGN_KEYS = (
    "sensitivity_bandwidth_rad_s",
    "sensitivity_peak",
    "sensitivity_offset",
    "robustness_crossover_rad_s",
    "control_weight",
    "roll_off_rad_s",
)


def controller_of(values: Mapping[str, Any], period: float) -> Controller:
    """Return the sampled controller of a resolved ``plant`` table.

    Raises:
        ValueError: The weights are missing, the plant is not stable, or no controller exists.
    """
    found = _designed(_plant_of(values), tuple(values[key] for key in _DESIGN_KEYS)).controller
    return sampled(found.a, found.b[:, 0], found.c[0], 0.0, period)


def norm_of(values: Mapping[str, Any]) -> float:
    """Return the norm γ that the design reaches before its reshaping."""
    return _designed(_plant_of(values), tuple(values[key] for key in _DESIGN_KEYS)).gamma


def _plant_of(values: Mapping[str, Any]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the plant as a ratio in s, its viscous friction included."""
    above = np.array(values["numerator"], float)
    below = np.polyadd(values["denominator"], np.polymul([values["viscous_s_mm"], 0.0], above))
    return tuple(above.tolist()), tuple(np.asarray(below, float).tolist())


@lru_cache(maxsize=64)
def _designed(
    plant: tuple[tuple[float, ...], tuple[float, ...]], given: tuple[float | None, ...]
) -> hinf.Design:
    bandwidth, peak, offset, crossover, weight, corner = given
    if bandwidth is None or crossover is None or peak is None or offset is None or weight is None:
        raise ValueError(
            "an H-infinity design needs sensitivity_bandwidth_rad_s and robustness_crossover_rad_s"
        )
    at_rest = abs(plant[0][-1] / plant[1][-1]) if plant[1][-1] else math.inf
    if not math.isfinite(at_rest):
        raise ValueError("an H-infinity design needs a plant that stands by itself; this one integrates")
    design = hinf.mixed_sensitivity(
        plant,
        hinf.performance_weight(bandwidth, peak, offset),
        hinf.robustness_weight(crossover),
        weight * at_rest,
    )
    if corner is None:
        return design
    return hinf.Design(hinf.rolled_off(design.controller, corner), design.gamma)


@dataclass(frozen=True, slots=True)
class BoundCheck:
    """Bounds over frequencies (rad/s): the worst of all plants beside what is allowed; shapes (n,).

    Attributes:
        frequency: rad/s, up to half the control frequency.
        sensitivity, allowed: Largest |S|, and α = 1/|W1|.
        complementary, peak: Largest |T|, and M_L.
        stable: Whether every closed loop is stable.
        plants: How many there are.
    """

    frequency: Floats
    sensitivity: Floats
    allowed: Floats
    complementary: Floats
    peak: float
    stable: bool
    plants: int

    @property
    def holds(self) -> bool:
        """Tell whether every bound holds for every plant."""
        return self.stable and bool(
            (self.sensitivity <= self.allowed).all() and (self.complementary <= self.peak).all()
        )


def check(values: Mapping[str, Any], controller: Controller, period: float, count: int = 400) -> BoundCheck:
    """Hold a sampled controller of a resolved ``plant`` table against the table's bounds."""
    top = 0.999 * math.pi / period
    w = np.geomspace(min(1e-2 * values["sensitivity_bandwidth_rad_s"], 1e-2 * top), top, count)
    weight = hinf.performance_weight(
        values["sensitivity_bandwidth_rad_s"], values["sensitivity_peak"], values["sensitivity_offset"]
    )
    allowed = 1.0 / np.abs(np.polyval(weight[0], 1j * w) / np.polyval(weight[1], 1j * w))
    # Far above the bandwidth W1 falls for the sake of the design alone; the bound there is the peak.
    allowed = np.minimum(allowed, values["sensitivity_peak"])
    worst_s, worst_t, stable, number = np.zeros(count), np.zeros(count), True, 0
    for above, below in family(values):
        plant = plants.transfer_function(np.array(above), np.array(below), values["delay_s"])
        loop = close_loop(plant, controller, period)
        response = open_loop(loop, w)
        worst_s = np.maximum(worst_s, np.abs(1.0 / (1.0 + response)))
        worst_t = np.maximum(worst_t, np.abs(response / (1.0 + response)))
        stable = stable and bool(np.abs(loop.poles()).max() < 1.0)
        number += 1
    return BoundCheck(w, worst_s, allowed, worst_t, values["complementary_peak"], stable, number)


def family(values: Mapping[str, Any]) -> Iterator[hinf.Ratio]:
    """Yield the plants that the bounds hold for: g G(s/f) with f and g at the ends and the middle of their ranges."""
    above, below = (np.array(part) for part in _plant_of(values))
    spread, scatter = values["frequency_uncertainty"], values["gain_uncertainty"]
    for f, g in itertools.product((1.0 - spread, 1.0, 1.0 + spread), (1.0 - scatter, 1.0, 1.0 + scatter)):
        up, down = (part / f ** np.arange(len(part) - 1, -1, -1) for part in (above, below))
        yield (g * up).tolist(), down.tolist()
