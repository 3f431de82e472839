"""Compensation on ten machines and five programs: python -m trials.compensation [MACHINES] [PROGRAMS], or --fresh SEED COUNT.

Each program is planned, learnt and simulated as `cncgen compensate PROGRAM` does. Printed is a row of the table of
docs/compensation.md for each pair: the largest contour error before (a plan to the whole limits) and after, what the room costs in
time, and the largest error of 16 machines whose every parameter is up to 10 % off. Then the median ratio, and refusals.
With --fresh every pair has a machine and a program of its own, drawn at random (`trials.generators.servo_axes`, `simple_paths`).
"""

from __future__ import annotations

import argparse
import math
import statistics
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cncgen.cli.compensate import ROOMS
from cncgen.diagnostics import NoPlanError
from cncgen.machine import Machine, Servo, load_machine
from cncgen.pipeline import output_axes, read, read_text, servos_of, sound
from cncgen.servo.compensation import compensated_plan
from cncgen.servo.uncertainty import Perturbation
from cncgen.toolpath.record import Program
from trials.generators.servo_axes import KINDS, drawn_axes
from trials.generators.simple_paths import drawn

PROGRAMS = ("circle", "square_r5", "star", "heart", "butterfly")
FOLDER = Path(__file__).resolve().parent.parent / "programs"
_LOOP: Mapping[str, Any] = {"position_gain_1_s": 60.0, "time_constant_s": 0.003}
#: P control of 20 Hz round two equal masses with a resonance of 123 Hz; 1.6 mm a radian.
_MASSES: Mapping[str, Any] = {
    "motor_inertia_kg_m2": 2e-3,
    "load_inertia_kg_m2": 2e-3,
    "stiffness_n_m_rad": 600.0,
    "damping_n_m_s_rad": 0.05,
    "motor_viscous_n_m_s_rad": 0.01,
    "travel_mm_rad": 1.6,
    "position_gain_n_m_mm": (40.0 * math.pi) ** 2 * 4e-3 / 1.6,
    "derivative_gain_n_m_s_mm": 2.0 * 0.8 * 40.0 * math.pi * 4e-3 / 1.6,
    "integral_gain_n_m_mm_s": (40.0 * math.pi) ** 2 * 4e-2 / 1.6,
}
_DELAYED: Mapping[str, Any] = {
    "numerator": [1.0],
    "denominator": [0.003, 1.0, 0.0],
    "position_gain_1_mm": 60.0,
    "drive_unit": "mm/s",
}
#: What a row is made of: its names, the machine, its servo data and the program.
Pair = tuple[str, Machine, Mapping[str, Servo], Program]
#: Name, model and values of both axes; limits are the xy-table's.
_MADE: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "first order, Coulomb and viscous friction": (
        "first-order",
        {**_LOOP, "coulomb_lag_mm": 0.02, "viscous_share": 0.02},
    ),
    "first order, backlash 2 µm, encoder 1 µm": (
        "first-order",
        {**_LOOP, "backlash_mm": 0.002, "encoder_resolution_mm": 0.001},
    ),
    "two masses, Coulomb friction": ("two-mass", {**_MASSES, "coulomb_n_m": 0.1}),
    "two masses, friction, backlash 2 µm, encoder 1 µm": (
        "two-mass",
        {**_MASSES, "coulomb_n_m": 0.1, "backlash_mm": 0.002, "encoder_resolution_mm": 0.001},
    ),
    "first order, delay of 0.5 samples": ("plant", {**_DELAYED, "delay_s": 0.0005}),
    "first order, zero at 200/s on the right, delay of 2 samples": (
        "transfer-function",
        {"numerator": [-1.0 / 200.0, 1.0], "denominator": [1.0 / 12000.0, 1.0 / 60.0 + 1.0 / 200.0, 1.0], "delay_s": 0.002},
    ),
}  # fmt: skip
SHIPPED = ("xy-table", "dyna-1007", "die-bonder", "generic-mill")
MACHINES = (*SHIPPED, *_MADE)


def made_servos(name: str) -> dict[str, Servo]:
    """Return the servo data of a machine that does not ship."""
    model, values = _MADE[name]
    return {letter: Servo(model, values) for letter in "XY"}


def row(
    label: str, where: Machine, servos: Mapping[str, Servo], program: Program
) -> tuple[str, float | None, bool]:
    """Return a row of the table, the ratio of the errors (None: refused), and whether a drawn machine gets worse."""
    try:
        found = compensated_plan(
            list(sound(program)), where, servos, axes=output_axes(program), rooms=ROOMS,
            perturbation=Perturbation(0.1, 16),
        )  # fmt: skip
    except NoPlanError as error:
        return f"| {label} | refused: {error.diagnostics[0].message} |", None, False
    after, spread = found.compensated.learnt.after, found.compensated.spread
    assert spread is not None
    ratio = found.full_error / after.contour_max
    slower = 100.0 * (found.time_s / found.full_time_s - 1.0)
    numbers = (1e3 * found.full_error, 1e3 * after.contour_max, ratio, slower)
    text = f"{numbers[0]:.1f} | {numbers[1]:.2f} | {numbers[2]:.0f} | {numbers[3]:.0f} | {1e3 * spread.after.max():.1f}"
    return f"| {label} | {text} |", ratio, spread.worse > 0


def known(machines: Iterable[str], programs: Iterable[str]) -> Iterator[Pair]:
    """Yield the pairs of machines and programs by their names."""
    for machine in machines:
        where = load_machine(machine if machine in SHIPPED else "xy-table")
        servos = servos_of(where) if machine in SHIPPED else made_servos(machine)
        for program in programs:
            yield f"{machine} | {program}", where, servos, read(str(FOLDER / f"{program}.nc"))


def fresh(seed: int, count: int) -> Iterator[Pair]:
    """Yield pairs of a machine and a program that are drawn."""
    for k in range(seed, seed + count):
        draw = np.random.default_rng(k)
        kind = KINDS[k % len(KINDS)]
        where, servos = drawn_axes(draw, kind)
        path = drawn(draw, "G64 P0.01")
        path = replace(path, feed=float(draw.uniform(0.2, 1.0)) * where.axes["X"].max_velocity)
        yield f"{kind} | {path.name} of seed {k}", where, servos, read_text(path.text)


def main() -> None:
    """Run them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split(":", maxsplit=1)[0])
    parser.add_argument("machines", nargs="?", help="names of machines, with ; between them")
    parser.add_argument("programs", nargs="?", help="names of programs, with commas between them")
    parser.add_argument("--fresh", nargs=2, type=int, metavar=("SEED", "COUNT"), help="drawn pairs instead")
    given = parser.parse_args()
    if given.fresh:
        pairs = fresh(*given.fresh)
    else:
        machines = given.machines.split(";") if given.machines else MACHINES
        pairs = known(machines, given.programs.split(",") if given.programs else PROGRAMS)
    ratios, refused, worse = [], 0, 0
    print("| machine | program | before µm | after µm | ratio | slower % | worst of 16, µm |", flush=True)
    for pair in pairs:
        text, ratio, harmed = row(*pair)
        print(text, flush=True)
        refused += ratio is None
        worse += harmed
        if ratio is not None:
            ratios.append(ratio)
    median = statistics.median(ratios) if ratios else math.nan
    least = min(ratios, default=math.nan)
    print(
        f"median ratio {median:.1f}, least {least:.2f}; {refused} refused; {worse} with a drawn machine that is worse"
    )


if __name__ == "__main__":
    main()
