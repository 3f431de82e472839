"""Other kinds of processors that this one can be for OpenBLAS and NumPy, and tests run as each: ``python -m tests.processors TESTS``."""

from __future__ import annotations

import os
import re
import subprocess
import sys


def kinds() -> dict[str, dict[str, str]]:
    """Return the environment variables of each other kind of processor that this one can be, the plainest first.

    `OPENBLAS_CORETYPE` chooses the code of matrix products and decompositions; `NPY_DISABLE_CPU_FEATURES` takes from NumPy
    all code for this processor beyond the least one, which the plainest kind goes without.
    """
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

    needs = {"Prescott": "SSE3", "Haswell": "FMA3", "SkylakeX": "AVX512_SKX"}
    own = core({})
    cores = {
        name: {"OPENBLAS_CORETYPE": name}
        for name, need in needs.items()
        if __cpu_features__.get(need) and name != own
    }
    dispatched = " ".join(name for name in __cpu_dispatch__ if __cpu_features__[name])
    if dispatched:
        plainest = next(iter(cores), "NumPy-plain")
        cores[plainest] = cores.get(plainest, {}) | {"NPY_DISABLE_CPU_FEATURES": dispatched}
    return cores


def core(variables: dict[str, str]) -> str:
    """Return the name of the processor whose code OpenBLAS takes, "" if it does not say."""
    asked = os.environ | {"OPENBLAS_VERBOSE": "2"} | variables
    told = subprocess.run(
        [sys.executable, "-c", "import numpy"], env=asked, capture_output=True, text=True, check=True
    )
    found = re.search(r"Core: (\w+)", told.stderr)
    # Katmai is the plainest code, which a Prescott runs.
    return found[1].replace("Katmai", "Prescott") if found else ""


def main() -> int:
    """Run the tests named as each kind; return 1 if any fails."""
    failed = []
    for name, variables in kinds().items():
        print(f"as {name}: {variables}", flush=True)
        command = [sys.executable, "-m", "pytest", "-n", "2", "-q", *sys.argv[1:]]
        if subprocess.run(command, env=os.environ | variables, check=False).returncode:
            failed.append(name)
    print(f"processors: {len(failed)} of {len(kinds())} kinds fail {' '.join(failed)}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
