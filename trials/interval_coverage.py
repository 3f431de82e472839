"""How many machines lie in the intervals of --perturb: python -m trials.interval_coverage [MACHINES].

Of each profile a circle is simulated on 256 drawn machines, and the interval of 90 % is taken. Then 1,000 machines are drawn from
another seed, and those within it are counted.
"""

from __future__ import annotations

import sys

import numpy as np

from cncgen.machine import Servo, load_servos
from cncgen.servo.response_spread import drawn_figures, interval
from cncgen.servo.uncertainty import Perturbation
from cncgen.setpoints.record import Setpoints

DRAWS = 256
PROFILES = ("xy-table", "dyna-1007", "die-bonder", "generic-mill")


def main() -> None:
    """Run them."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    t = np.arange(600) * 0.001
    angle = 2.0 * np.pi * (t - np.sin(2.0 * np.pi * t / 0.6) * 0.6 / (2.0 * np.pi)) / 0.6
    rows = Setpoints("XY", 0.001, 0, 10.0 * np.column_stack([np.cos(angle), np.sin(angle)]))
    for name in PROFILES:
        servos: dict[str, Servo] = {k: s for k, s in load_servos(name).items() if k in "XY"}
        found = drawn_figures([rows], servos, Perturbation(0.1, DRAWS))
        others = drawn_figures([rows], servos, Perturbation(0.1, count, seed=987_654_321))
        shares = []
        for figure in ("contour_error_max_mm", "contour_error_rms_mm", "tracking_max_mm_x"):
            low, high = interval(found[figure])
            inside = float(((others[figure] >= low) & (others[figure] <= high)).mean())
            shares.append(f"{figure} {100.0 * inside:.1f} %")
        print(
            f"{name}: {', '.join(shares)} of {count} machines in the 90 % interval of {DRAWS} draws",
            flush=True,
        )


if __name__ == "__main__":
    main()
