"""How many machines lie in the intervals of --perturb: python -m trials.interval_coverage [DRAWS] [MACHINES].

On seven machines (those of `trials.compensation` among them) two programs are planned, and simulated on as many drawn machines as
`cncgen simulate --perturb 10%` takes; the intervals of 90 % of every error are taken. Then 1,000 machines are drawn from another
seed, and those within are counted. Last comes what two standard deviations of independent draws would be.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from cncgen.machine import load_servos
from cncgen.pipeline import plan, read, sample
from cncgen.servo.response_spread import INTERVAL, drawn_figures, interval
from cncgen.servo.uncertainty import DRAWS, Perturbation, share_error
from trials.compensation import FOLDER, SHIPPED, made_servos

MACHINES = (
    *SHIPPED,
    "first order, Coulomb and viscous friction",
    "first order, delay of 0.5 samples",
    "two masses, friction, backlash 2 µm, encoder 1 µm",
)
PROGRAMS = ("circle", "star")


def shares(machine: str, program: str, draws: int, count: int) -> Iterator[tuple[str, float]]:
    """Yield the name of each error, and the share of that many machines within its interval."""
    limits = machine if machine in SHIPPED else "xy-table"
    servos = load_servos(machine) if machine in SHIPPED else made_servos(machine)
    rows = list(sample(plan(read(str(FOLDER / f"{program}.nc")), limits)).chunks)
    found = drawn_figures(rows, servos, Perturbation(0.1, draws))
    others = drawn_figures(rows, servos, Perturbation(0.1, count, seed=987_654_321))
    for name, values in found.items():
        low, high = interval(values)
        yield name, float(((others[name] >= low) & (others[name] <= high)).mean())


def main() -> None:
    """Run them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split(":", maxsplit=1)[0])
    parser.add_argument("draws", nargs="?", type=int, default=DRAWS)
    parser.add_argument("machines", nargs="?", type=int, default=1000)
    given = parser.parse_args()
    draws, count = given.draws, given.machines
    every: list[float] = []
    for machine in MACHINES:
        for program in PROGRAMS:
            found = dict(shares(machine, program, draws, count))
            every += found.values()
            text = ", ".join(f"{name} {100.0 * share:.1f}" for name, share in found.items())
            print(f"{machine}, {program}: {text} %", flush=True)
    print(
        f"{draws} draws: {100.0 * min(every):.1f} to {100.0 * max(every):.1f} % of {count} machines are in the intervals of"
        f" {len(every)} errors; {100.0 * INTERVAL:g} ± {100.0 * share_error(INTERVAL, draws):.1f} % are stated"
    )


if __name__ == "__main__":
    main()
