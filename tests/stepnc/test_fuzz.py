"""A few hundred mutations of small files: no exception but those of the project (many more: trials/stepnc_fuzz.py)."""

import random
import warnings

import pytest

from cncgen.diagnostics import CncgenError
from trials import stepnc_fuzz as fuzz


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
