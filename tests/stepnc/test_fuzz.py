"""A few hundred mutations of small files: no exception but those of the project (many more: benchmarks/stepnc_fuzz.py)."""

import importlib.util
import random
import warnings
from pathlib import Path

import pytest

from cncgen.diagnostics import CncgenError

ROOT = Path(__file__).parents[2]
spec = importlib.util.spec_from_file_location("stepnc_fuzz", ROOT / "benchmarks" / "stepnc_fuzz.py")
fuzz = importlib.util.module_from_spec(spec)
spec.loader.exec_module(fuzz)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("seed", range(4))
def test_mutations_are_diagnosed_not_raised(seed):
    chance = random.Random(seed)
    sources = fuzz.samples([])[:12]  # the small ones
    for _ in range(15):
        data = fuzz.mutate(chance.choice(sources), chance)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                fuzz.run(data)
            except CncgenError:
                continue
