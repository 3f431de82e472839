"""The example programs of STEP-NC, cut: no finding."""

from pathlib import Path

import pytest

from cncgen.pipeline.removing import cut

PROGRAMS = Path(__file__).parents[2] / "programs" / "stepnc"


@pytest.mark.parametrize("name", ["features.stp", "shaft.stp"])
def test_examples_are_cut_right(name):
    assert [f.code for f in cut(str(PROGRAMS / name)).findings] == []
