"""Plans are the same to the bit on every processor: with OpenBLAS's and NumPy's code for others than this one.

All of `programs/` is planned, in one process a kind of processor. `OPENBLAS_CORETYPE` chooses the code of matrix products
and decompositions. `NPY_DISABLE_CPU_FEATURES` takes from NumPy what it has for this processor beyond the least one.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.processors import core, kinds

KINDS = kinds()
ROOT = Path(__file__).resolve().parents[1]
PROGRAMS = sorted(
    path.relative_to(ROOT).as_posix()
    for pattern in ("*.nc", "lathe/*.nc", "stepnc/*.stp")
    for path in ROOT.glob(f"programs/{pattern}")
)
PLAN = """
import hashlib, sys
import cncgen
for name in sys.argv[1:]:
    program = cncgen.read(name)
    effort = "fast" if name.endswith(".stp") else "best"  # of whole parts the plan of the speed alone, which takes a tenth
    setpoints = cncgen.sample(cncgen.plan(program, effort=effort)).collect()
    print(name, len(setpoints), hashlib.sha256(setpoints.position.tobytes()).hexdigest())
"""


def run(*arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | variables,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=250,
        check=True,
    )


@pytest.fixture(scope="module")
def plans() -> str:
    """What this processor plans, by itself."""
    return run("-c", PLAN, *PROGRAMS).stdout


@pytest.mark.parametrize("kind", KINDS)
def test_setpoints_are_the_same_to_the_bit(kind: str, plans: str) -> None:
    variables = KINDS[kind]
    there = run("-c", PLAN, *PROGRAMS, **variables)
    if "OPENBLAS_CORETYPE" in variables:
        assert core(variables) in ("", kind)
    assert len(plans.splitlines()) == len(PROGRAMS) > 10
    assert there.stdout == plans
