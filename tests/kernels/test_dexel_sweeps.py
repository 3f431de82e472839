"""Dexels cut by a tool that leans: beside poses of the tool taken one by one; with what is known of gaps the same as without."""

import numpy as np
import pytest

from cncgen.kernels import dexel_sweeps as kernel

#: Radius, flat radius, radius of the edge, slope.
TOOLS = {
    "flat": (2.0, 2.0, 0.0, 0.0),
    "ball": (2.0, 0.0, 2.0, 0.0),
    "bull": (2.0, 1.2, 0.8, 0.0),
    "cone": (2.0, 0.0, 0.0, 0.7),
}
SIZE, CELL, LINES = 40, 0.25, 60


def motions(rng):
    """Return a way of short motions about a block, and the axes of a tool that leans and swings."""
    step = rng.choice([0.05, 0.3, 1.0]) * np.array([1.0, 1.0, 0.2])
    box = np.array([SIZE * CELL, SIZE * CELL, 4.0])
    points = np.cumsum(rng.normal(size=(LINES + 1, 3)) * step, axis=0) + box * rng.uniform(0.3, 0.8, 3)
    axis = np.array([*rng.normal(0, 0.4, 2), 1.0])[rng.permutation(3)] * rng.choice([-1.0, 1.0])
    axes = axis + rng.normal(0, 0.05, 3) * np.sin(np.arange(LINES) / 9)[:, None]
    return np.hstack([points[:-1], points[1:]]), axes / np.linalg.norm(axes, axis=1)[:, None]


def unknown():
    return np.full((-(-SIZE // kernel.SQUARE), -(-SIZE // kernel.SQUARE), kernel.GAP), 1e300)


def cut(lines, axes, tool, gaps):
    """Cut a block; `gaps` is called before each motion for what is known."""
    ends, counts = np.zeros((SIZE, SIZE, 32)), np.ones((SIZE, SIZE), np.int32)
    ends[..., 1] = 4.0
    out = np.zeros((len(lines), kernel.COLUMNS))
    for k in range(len(lines)):
        done = kernel.cut_lines(
            ends,
            counts,
            np.zeros((0, 0, 0)),
            np.zeros((0, 0), np.int32),
            gaps(),
            np.zeros((kernel.SQUARE, 2), np.int64),
            np.array([0.0, 0.0, CELL]),
            np.array([0.0, 4.0]),
            lines[k : k + 1].copy(),
            axes[k : k + 1].copy(),
            np.ones(1, np.uint8),
            np.array([*tool, np.inf]),
            np.full((1, 2), 0.01),
            False,
            0,
            out[k : k + 1],
        )
        assert done == 1
    there = np.arange(16) < counts[..., None]
    return counts, np.where(np.repeat(there, 2, axis=2), ends, 0.0), out


@pytest.mark.parametrize("form", TOOLS)
@pytest.mark.parametrize("seed", range(6))
def test_what_is_known_of_gaps_changes_nothing(form, seed):
    lines, axes = motions(np.random.default_rng(seed))
    kept = unknown()
    known = cut(lines, axes, TOOLS[form], lambda: kept)
    fresh = cut(lines, axes, TOOLS[form], unknown)
    for a, b in zip(known, fresh, strict=True):
        np.testing.assert_array_equal(a, b)
    assert fresh[2][:, 0].sum() > 0
    # Gaps were found at all.
    assert (kept[..., 0] < 1e299).any()


def sampled(lines, axes, tool):
    """Return how much of each dexel the tool takes, by its poses along a motion and places 0.01 mm apart."""
    radius, flat, edge, slope = tool
    w = np.arange(0.005, 4.0, 0.01)
    u, v = np.meshgrid(CELL * np.arange(SIZE), CELL * np.arange(SIZE))
    points = np.stack(np.broadcast_arrays(u[..., None], v[..., None], w), axis=-1)
    taken = np.zeros(points.shape[:3], bool)
    for line, axis in zip(lines, axes, strict=True):
        for t in np.linspace(0.0, 1.0, 41):
            beside = points - (line[:3] + t * (line[3:] - line[:3]))
            height = beside @ axis
            rho = np.sqrt(np.maximum((beside**2).sum(axis=-1) - height**2, 0.0))
            over = np.maximum(rho - flat, 0.0)
            lift = edge - np.sqrt(np.maximum(edge**2 - over**2, 0.0)) if edge else slope * over
            taken |= (rho <= radius) & (height >= lift)
    return 0.01 * taken.sum(axis=-1)


@pytest.mark.parametrize("form", TOOLS)
@pytest.mark.parametrize("seed", range(2))
def test_beside_poses_one_by_one(form, seed):
    rng = np.random.default_rng(seed)
    axis = np.array([*rng.normal(0, 0.5, 2), 1.0])
    axis /= np.linalg.norm(axis)
    start = np.array([*rng.uniform(3, 7, 2), rng.uniform(0.5, 3.0)])
    line = np.concatenate([start, start + rng.normal(0, 1, 3) * [1.0, 1.0, 0.4]])[None, :]
    counts, ends, _ = cut(line, axis[None, :], TOOLS[form], unknown)
    left = (ends[..., 1::2] - ends[..., ::2]).sum(axis=2)
    expected = sampled(line, axis[None, :], TOOLS[form])
    # Poses leave cusps, less than 0.05 mm high; beside the rim a dexel is met by some or by none.
    assert np.abs(4.0 - left - expected).mean() < 0.01
    assert np.mean(np.abs(4.0 - left - expected) < 0.05) > 0.98
    assert counts.max() >= 1
    assert expected.sum() > 0
