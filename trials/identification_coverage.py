"""How often identified parameters lie within their stated uncertainty: python -m trials.identification_coverage [SEEDS].

A simulated axis is excited by a swept sine, its position read with 1 µm of white noise, and fitted, once for each seed.
Printed is the share of fits whose parameter is within one and two standard deviations of the true one (68 and 95 % of a
normal distribution) and the mean of the error over its standard deviation, whose own spread is 1/√SEEDS.
"""

from __future__ import annotations

import argparse

import numpy as np

from cncgen.machine import load_servos
from cncgen.machine.record import Axis, Servo
from cncgen.machine.servo_schema import closed_loop
from cncgen.servo.identification.excitation import swept_sine
from cncgen.servo.identification.fits import (
    COEFFICIENTS,
    Fit,
    fit_first_order,
    fit_fourth_order,
    fit_velocity_loop,
)
from cncgen.servo.simulate import simulate
from cncgen.setpoints.record import Setpoints

PERIOD = 0.001
NOISE_MM = 0.001


def run(servo: Servo) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return command, drive input and position of the excited axis."""
    axis = Axis("X", 250.0, 2450.0, 50000.0)
    rows = swept_sine(axis, PERIOD, duration_s=4.0, low_hz=1.0)[:, None]
    parts = list(simulate([Setpoints("X", PERIOD, 0, rows)], {"X": servo}))
    return tuple(
        np.concatenate([getattr(p, k)[:, 0] for p in parts]) for k in ("command", "force", "position")
    )  # type: ignore[return-value]


def report(name: str, truth: dict[str, float], fits: list[Fit]) -> None:
    """Print the coverage of each parameter."""
    for key, value in truth.items():
        z = np.array([(fit.parameters[key] - value) / fit.uncertainty[key] for fit in fits])
        one, two = (100.0 * np.mean(np.abs(z) <= k) for k in (1.0, 2.0))
        print(
            f"{name:14} {key:20} within 1 sigma {one:5.1f} %, 2 sigma {two:5.1f} %, mean {z.mean():+.2f} sigma"
        )


def main() -> None:
    """Run all three models."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seeds", type=int, nargs="?", default=100, help="noisy logs [default: %(default)s]")
    seeds = parser.parse_args().seeds
    draws = [np.random.default_rng(seed) for seed in range(seeds)]
    servo = load_servos("dyna-1007")["X"]
    values = {k: float(v) for k, v in servo.parameters.items()}
    command, drive, position = run(servo)
    noisy = [position + NOISE_MM * rng.standard_normal(len(position)) for rng in draws]
    truth = {"gain": 1.0, "time_constant_s": values["time_constant_s"],
             "coulomb": values["coulomb_lag_mm"] * values["position_gain_1_s"]}  # fmt: skip
    report("velocity-loop", truth, [fit_velocity_loop(drive, y, PERIOD) for y in noisy])
    report("first-order", values, [fit_first_order(command, y, PERIOD) for y in noisy])
    servo = load_servos("xy-table")["X"]
    command, _, position = run(servo)
    loop = closed_loop(servo)
    truth = dict(zip(COEFFICIENTS, [*loop.denominator[1:], *loop.numerator[:2]], strict=True))
    noisy = [position + 0.1 * NOISE_MM * rng.standard_normal(len(position)) for rng in draws]
    report("fourth-order", truth, [fit_fourth_order(command, y, PERIOD) for y in noisy])


if __name__ == "__main__":
    main()
