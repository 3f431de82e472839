"""A few hundred mutations of small files: no exception but those of the project (many more: trials/stepnc_fuzz.py)."""

import random
import warnings

import pytest

from cncgen.diagnostics import CncgenError
from trials.generators.stepnc_mutants import mutate, samples
from trials.stepnc_fuzz import run


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("seed", range(4))
def test_mutations_are_diagnosed_not_raised(seed):
    chance = random.Random(seed)
    sources = samples([])[:12]  # the small ones
    for _ in range(15):
        data = mutate(chance.choice(sources), chance)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                run(data)
            except CncgenError:
                continue
