"""Two-stage interpolation as setpoints: the closed forms of a circle, and both ends."""

from collections.abc import Iterator

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics, UsageError
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.two_stage import second_stage, two_stage


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


@pytest.mark.parametrize("count", [6, 17])
def test_a_closed_path_within_a_master_period_is_refused(count: int) -> None:
    """It stood still: both of the master's points are the same one."""
    rows = 20.0 * np.column_stack([f(np.linspace(0.0, 2.0 * np.pi, count)) for f in (np.cos, np.sin)])
    with pytest.raises(
        UsageError, match=f"0.016 s is not shorter than the motion of {(count - 1) / 1000:g} s"
    ):
        list(two_stage([Setpoints("XY", 0.001, 0, rows)], "two-stage-causal", 0.016))
    still = [Setpoints("XY", 0.001, 0, np.ones((6, 2)))]
    assert (next(two_stage(still, "two-stage-causal", 0.016)).position == 1.0).all()
    assert list(two_stage([], "two-stage-causal", 0.016)) == []


def test_a_master_faster_than_the_setpoints_is_refused() -> None:
    """It was taken as one of their period, without a word."""
    rows = [Setpoints("XY", 0.001, 0, np.zeros((6, 2)))]
    with pytest.raises(UsageError, match=r"1e-12 s is shorter than that of the setpoints, 0\.001 s"):
        list(two_stage(rows, "two-stage-linear", 1e-12))


def test_distance_from_the_path_is_told() -> None:
    """The sagitta a²R/8 of the chords: 0.2 s of 100 mm/s on R 20 mm are 1 rad, R (1 − cos 0.5) = 2.448 mm."""
    remarks = Diagnostics()
    list(two_stage([Setpoints("XY", 0.001, 0, circle(1201))], "two-stage-linear", 0.2, remarks))
    (found,) = remarks
    assert found.code == "two-stage-distance"
    assert found.values["distance_mm"] == pytest.approx(20.0 * (1.0 - np.cos(0.5)), rel=1e-4)
    exact = Diagnostics()
    line = np.arange(500.0)[:, None]
    list(two_stage([Setpoints("X", 0.001, 0, line)], "two-stage-linear", 0.016, exact))
    assert not list(exact)


@pytest.mark.parametrize("name", ["linear", "centred", "causal"])
def test_the_last_stretch_keeps_its_speed(name: str) -> None:
    """At constant speed all steps are alike, except those of the bends at both ends: half a stretch was made in the last step."""
    rows = np.arange(500.0)[:, None] * 0.1
    (found,) = two_stage([Setpoints("X", 0.001, 0, rows)], f"two-stage-{name}", 0.016)
    steps = np.diff(found.position[:, 0])
    assert (steps > 0.0).all()
    assert steps.max() < 0.2
    assert steps[40:-40] == pytest.approx(0.1)
    if name == "linear":
        assert found.position == pytest.approx(rows)


@pytest.mark.parametrize("name", ["linear", "centred", "causal"])
@pytest.mark.parametrize("count", [18, 33, 500, 513])
def test_chunks_do_not_matter(name: str, count: int) -> None:
    """Against the equations on all master points at once, whatever the chunks."""
    rows = np.random.default_rng(count).standard_normal((count, 2))
    master = np.concatenate([rows[::16], *([rows[-1:]] if (count - 1) % 16 else [])])
    whole = second_stage(master, 16, {"linear": 2, "centred": 3, "causal": 4}[name], (count - 2) % 16 + 1)
    for size in (1, 7, 16, 50, count):
        chunks = [Setpoints("XY", 0.001, at, rows[at : at + size]) for at in range(0, count, size)]
        found = list(two_stage(iter(chunks), f"two-stage-{name}", 0.016))
        assert [(c.first, len(c)) for c in found] == [(c.first, len(c)) for c in chunks]
        assert np.concatenate([c.position for c in found]) == pytest.approx(whole, abs=1e-12)


def test_a_chunk_waits_for_two_master_points_alone() -> None:
    """Memory does not grow with the stream: of chunks of three master periods the next one is drawn, and no further one."""
    drawn = 0

    def chunks() -> Iterator[Setpoints]:
        nonlocal drawn
        for at in range(0, 4800, 48):
            drawn += 1
            yield Setpoints("XY", 0.001, at, circle(4800)[at : at + 48])

    for k, _ in enumerate(two_stage(chunks(), "two-stage-centred", 0.016)):
        assert drawn <= k + 2
