"""Random servo tables through every scheme, by hand: python -m trials.servo_tables [SEED] [TABLES].

Whatever a table says, it ends in a simulation or in a diagnostic. Printed are the diagnostics by code, every other exception
with its table, and tables that take longer than two seconds.
"""

from __future__ import annotations

import random
import sys
import time
import warnings
from collections import Counter

import numpy as np

from cncgen.diagnostics import CncgenError
from cncgen.machine.reading import servos_from_toml
from cncgen.servo.named_schemes import NAMES, scheme_maker
from cncgen.servo.simulate import simulate_scheme
from cncgen.setpoints.record import Setpoints
from trials.generators.servo_data import table

SLOW_S = 2.0


def main() -> None:
    """Run them."""
    seed, count = (int(text) for text in (*sys.argv[1:3], "0", "500")[:2]) if len(sys.argv) > 2 else (0, 500)
    rng, codes, faults = random.Random(seed), Counter[str](), 0
    t = np.arange(300) * 0.001
    rows = np.column_stack([5.0 * np.sin(9.0 * t), 5.0 * np.cos(9.0 * t) - 5.0])
    for _ in range(count):
        text, scheme, start = table(rng), rng.choice(NAMES), time.perf_counter()
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                maker = scheme_maker(scheme, servos_from_toml(text.encode(), "table"))
                for _ in simulate_scheme([Setpoints("XY", 0.001, 0, rows)], maker):
                    pass
            codes["simulated"] += 1
        except CncgenError as error:
            codes[error.diagnostics[0].code] += 1
        except Exception as error:
            faults += 1
            print(f"{type(error).__name__}: {error} under {scheme} with\n{text}")
        if time.perf_counter() - start > SLOW_S:
            print(f"{time.perf_counter() - start:.1f} s under {scheme} with\n{text}")
    print(f"{count} tables from seed {seed}: {dict(codes)}, {faults} other exceptions")


if __name__ == "__main__":
    main()
