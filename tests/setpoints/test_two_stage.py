"""Two-stage interpolation as setpoints: the closed forms of a circle, and both ends."""

import numpy as np
import pytest

from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.two_stage import two_stage


def circle(count: int = 1601) -> np.ndarray:
    """R = 20 mm at 100 mm/s, a row a millisecond."""
    angle = np.arange(count) * 0.1 / 20.0
    return 20.0 * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize(
    ("name", "radial_um"), [("linear", -16.0), ("centred", -0.0192), ("causal", -0.0256)]
)
def test_radial_error_of_a_circle(name: str, radial_um: float) -> None:
    """−a²R/8 of the chords, a = VΔt/R = 0.08; of the others by an independent script."""
    rows = circle()
    chunks = [Setpoints("XY", 0.001, at, rows[at : at + 700]) for at in range(0, len(rows), 700)]
    found = np.concatenate([chunk.position for chunk in two_stage(chunks, f"two-stage-{name}", 0.016)])
    off = np.hypot(*found[100:-100].T) - 20.0
    assert 1e3 * off[np.abs(off).argmax()] == pytest.approx(radial_um, rel=0.01)
    assert (found[0] == rows[0]).all()
    assert (found[-1] == rows[-1]).all()
    assert len(found) == len(rows)


def test_a_stream_shorter_than_a_master_period_keeps_its_ends() -> None:
    rows = circle(6)
    (found,) = two_stage([Setpoints("XY", 0.001, 0, rows)], "two-stage-causal", 0.016)
    assert (found.position[[0, -1]] == rows[[0, -1]]).all()
    assert list(two_stage([], "two-stage-causal", 0.016)) == []
