"""NIST's ex1E: explicit toolpaths against the canonical output of NIST's own interpreter."""

import re
from pathlib import Path

import numpy as np

from cncgen.diagnostics import Diagnostics
from cncgen.stepnc import canon, read
from cncgen.toolpath.record import Kind

PROGRAMS = Path(__file__).parents[2] / "programs" / "stepnc"
EXPECTED = (PROGRAMS / "nist_ex1.can").read_text().splitlines()


def test_every_call_is_that_of_nist():
    """All but the tool length offsets, which NIST's interpreter takes from a tool table."""
    found = Diagnostics()
    lines = list(canon(PROGRAMS / "nist_ex1E.stp", "nist_ex1E.stp", diagnostics=found))
    assert not found.has_errors
    assert len(lines) == len(EXPECTED) == 537
    offset = re.compile(r"USE_TOOL_LENGTH_OFFSET\(.*\)")
    for mine, theirs in zip(lines, EXPECTED, strict=True):
        assert offset.sub("OFFSET", mine) == offset.sub("OFFSET", theirs.rstrip())


def test_toolpath_has_the_motions_with_their_lines():
    program = read(PROGRAMS / "nist_ex1E.stp", "nist_ex1E.stp")
    chunks = list(program.chunks())
    assert program.axes == "XYZ"
    assert len(chunks) == 1
    path = chunks[0]
    motions = [line.split(None, 1)[1] for line in EXPECTED if "STRAIGHT" in line or "ARC_FEED" in line]
    rows = np.flatnonzero(path.kind != Kind.EVENT)
    assert len(rows) == len(motions) == 490
    for row, call in zip(rows, motions, strict=True):
        numbers = [float(v) for v in re.findall(r"-?\d+\.?\d*", call)]
        end = [numbers[0], numbers[1], numbers[5]] if "ARC" in call else numbers
        np.testing.assert_allclose(path.end[row], end, atol=5.1e-5)
        assert np.isnan(path.feed[row]) == ("TRAVERSE" in call)
    text = (PROGRAMS / "nist_ex1E.stp").read_text().splitlines()
    assert "CUTTER_LOCATION_TRAJECTORY" in text[path.line[rows[5]] - 1]
    turns = [float(c.split(",")[4]) for c in motions if "ARC" in c]
    np.testing.assert_array_equal(
        np.ceil(path.arcs.sweep / (2 * np.pi) - 1e-9) * path.arcs.normal[:, 2], turns
    )
