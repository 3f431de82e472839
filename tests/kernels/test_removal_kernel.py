"""The kernels of material removal beside slow references: the lowest of many places, every cell in turn, and half-spaces."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from cncgen.kernels import removal
from tests.kernels.plain import uncompiled

CELL, ROWS, COLUMNS = 0.5, 22, 30
GRID = np.array([-3.0, -2.0, CELL])
#: Radius, flat radius, radius of the edge, slope of the cone, length of the cutting edge.
TOOLS = {
    "flat": (3.0, 3.0, 0.0, 0.0, 8.0),
    "ball": (3.0, 0.0, 3.0, 0.0, 8.0),
    "bull": (3.0, 2.0, 1.0, 0.0, 8.0),
    "drill": (3.0, 0.0, 0.0, 0.6, 8.0),
    "chamfer": (3.0, 1.0, 0.0, 1.0, 8.0),
}
LINES = {
    "level": (0.0, 0.0, -1.0, 7.3, 4.1, -1.0),
    "down": (0.3, 1.1, -0.2, 6.7, 5.2, -2.4),
    "up": (7.0, 6.0, -3.0, 1.0, 3.0, -0.5),
    "plunge": (2.2, 3.1, 0.5, 2.2, 3.1, -1.5),
}


def lift(tool: tuple[float, ...], rho: np.ndarray) -> np.ndarray:
    """Return the height of the tool's surface above its tip at distances from its axis."""
    _, flat, edge, slope, _ = tool
    over = np.maximum(rho - flat, 0.0)
    if edge > 0.0:
        return edge - np.sqrt(edge**2 - np.minimum(over, edge) ** 2)
    return slope * over


def middles() -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of the middles of the cells."""
    return np.meshgrid(GRID[0] + CELL * np.arange(COLUMNS), GRID[1] + CELL * np.arange(ROWS))


def swept(tool: tuple[float, ...], line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest surface of the tool over each cell, and its least distance, over 6001 places of the line."""
    x, y = middles()
    lowest, nearest = np.full(x.shape, np.inf), np.full(x.shape, np.inf)
    for part in np.linspace(0.0, 1.0, 6001):
        tip = line[:3] + part * (line[3:] - line[:3])
        rho = np.hypot(x - tip[0], y - tip[1])
        nearest = np.minimum(nearest, rho)
        lowest = np.minimum(
            lowest, np.where(rho <= tool[0], tip[2] + lift(tool, np.minimum(rho, tool[0])), np.inf)
        )
    return lowest, nearest


def squares(heights: np.ndarray, mean: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    """Return how high each square of cells is at most."""
    out = np.empty((-(-ROWS // removal.SQUARE), -(-COLUMNS // removal.SQUARE)))
    removal.bound_squares(heights, mean, bottom, out)
    return out


def cut(kernel: ModuleType, tool: tuple[float, ...], line: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return heights before, heights and means after, the part, and the result of cutting an uneven stock along a line."""
    rng = np.random.default_rng(3)
    before = rng.uniform(-0.6, 0.4, (ROWS, COLUMNS))
    part = rng.uniform(-2.5, -0.5, (ROWS, COLUMNS))
    heights, mean, out = before.copy(), before.copy(), np.zeros((1, removal.COLUMNS))
    bottom = np.full_like(before, -9.0)
    kernel.cut_lines(
        heights, mean, before.copy(), bottom, part, squares(heights, mean, bottom), GRID, line[None].copy(),
        np.array(tool), np.array([0.01, 0.005]), out,
    )  # fmt: skip
    return before, heights, mean, part, out[0]


@pytest.mark.parametrize("way", LINES)
@pytest.mark.parametrize("name", TOOLS)
def test_a_line_leaves_the_lowest_of_all_places_of_the_tool(name: str, way: str) -> None:
    """And volume, deepest bite and deepest gouge are those of the heights before and after."""
    tool, line = TOOLS[name], np.array(LINES[way])
    before, heights, mean, part, out = cut(removal, tool, line)
    lowest, nearest = swept(tool, line)
    # Whether a middle at the rim itself is covered is rounding.
    sure = np.abs(nearest - tool[0]) > 2e-3
    expected = np.where(nearest < tool[0], np.minimum(before, lowest), before)
    np.testing.assert_allclose(heights[sure], expected[sure], atol=2e-3)
    covered = nearest < tool[0] - 0.5 * CELL
    np.testing.assert_allclose(mean[covered], heights[covered], atol=1e-12)
    assert out[0] == pytest.approx((before - mean).sum() * CELL**2, rel=1e-12)
    bites = np.where(nearest <= tool[0] - 0.01, before - heights, 0.0)
    assert out[1] == bites.max()
    assert (out[3], out[2]) == np.unravel_index(bites.argmax(), bites.shape)
    gouges = np.where((bites > 0.0) & (heights < part - 0.005), part - heights, 0.0)
    assert out[4] == gouges.max()
    if gouges.any():
        assert (out[6], out[5]) == np.unravel_index(gouges.argmax(), gouges.shape)
    deep = (heights < before) & (heights < part - 0.005)
    assert out[7] == pytest.approx(((np.minimum(before, part) - heights)[deep]).sum() * CELL**2, abs=1e-12)


def test_how_far_material_stands_above_the_cutting_edge() -> None:
    """A wall of 20 mm that a level cut at −1 with an edge of 8 mm runs into stands 13 mm above it."""
    heights = np.full((ROWS, COLUMNS), 20.0)
    out, bottom = np.zeros((1, removal.COLUMNS)), np.full_like(heights, -9.0)
    removal.cut_lines(
        heights, heights.copy(), heights.copy(), bottom, np.full_like(heights, -np.inf),
        squares(heights, heights, bottom), GRID, np.array([LINES["level"]]), np.array(TOOLS["flat"]),
        np.array([0.01, 0.005]), out,
    )  # fmt: skip
    assert out[0, 8] == 13.0


@pytest.mark.parametrize("way", LINES)
@pytest.mark.parametrize("name", ["bull", "chamfer"])
def test_plain_python_cuts_the_same(name: str, way: str) -> None:
    tool, line = TOOLS[name], np.array(LINES[way])
    for ours, theirs in zip(cut(removal, tool, line), cut(uncompiled("removal"), tool, line), strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("way", LINES)
def test_what_stands_beside_a_shank_is_the_highest_of_all_cells(way: str) -> None:
    heights = np.random.default_rng(5).uniform(-2.0, 12.0, (ROWS, COLUMNS))
    line, radius, above, out = np.array(LINES[way]), 1.7, 4.0, np.zeros((1, 3))
    bottom = np.full_like(heights, -3.0)
    removal.highest_beside(
        heights, bottom, squares(heights, heights, bottom), GRID, line[None].copy(), radius, above, out
    )
    found, place = 0.0, (-1, -1)
    x, y = middles()
    way_xy, rise = line[3:5] - line[:2], line[5] - line[2]
    for row, column in np.ndindex(heights.shape):
        to = np.array([x[row, column], y[row, column]]) - line[:2]
        part = (
            float(np.clip(to @ way_xy / (way_xy @ way_xy), 0.0, 1.0)) if way_xy.any() else float(rise < 0.0)
        )
        over = heights[row, column] - (line[2] + part * rise) - above
        if np.hypot(*(to - part * way_xy)) <= radius and over > found:
            found, place = over, (row, column)
    assert out[0, 0] == pytest.approx(found, abs=1e-12)
    assert (out[0, 2], out[0, 1]) == place


@pytest.mark.parametrize("seed", range(5))
def test_columns_through_a_convex_mesh_end_where_its_half_spaces_do(seed: int) -> None:
    """The faces of the hull of some points are a ∙ x + b ≤ 0, which bound z over each middle from above and from below."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([-2.0, -1.0, 0.0], [9.0, 7.0, 5.0], (14, 3))
    hull = ConvexHull(points)
    top, bottom = np.full((ROWS, COLUMNS), -np.inf), np.full((ROWS, COLUMNS), np.inf)
    removal.mesh_columns(np.ascontiguousarray(points[hull.simplices]), GRID, top, bottom)
    x, y = middles()
    a = hull.equations[:, :, None, None]
    ends = -(a[:, 0] * x + a[:, 1] * y + a[:, 3]) / a[:, 2]
    upper = np.where(a[:, 2] > 0.0, ends, np.inf).min(axis=0)
    lower = np.where(a[:, 2] < 0.0, ends, -np.inf).max(axis=0)
    inside = upper > lower + 1e-2
    assert 100 < inside.sum() < inside.size
    for found, wanted in ((top[inside], upper[inside]), (bottom[inside], lower[inside])):
        assert np.median(np.abs(found - wanted)) < 1e-12
        # A triangle reaches 10⁻⁴ of its sides beyond them, so that no middle falls between two.
        np.testing.assert_allclose(found, wanted, atol=2e-3)
    outside = upper < lower - 1e-2
    assert np.isinf(top[outside]).all()
    assert np.isinf(bottom[outside]).all()


@pytest.mark.parametrize("name", TOOLS)
def test_squares_that_are_passed_over_have_nothing_to_cut(name: str) -> None:
    """Many short lines, up and down, leave the lowest of what each leaves alone, and squares are as high as their cells."""
    rng = np.random.default_rng(11)
    places = np.column_stack([rng.uniform(-4, 13, 40), rng.uniform(-3, 10, 40), rng.uniform(-3, 0.5, 40)])
    lines = np.concatenate([places, places + rng.normal(0.0, 0.4, (40, 3))], axis=1)
    before = rng.uniform(-0.6, 0.4, (ROWS, COLUMNS))
    bottom, part = np.full_like(before, -2.0), np.full_like(before, -np.inf)
    tool, limits, out = np.array(TOOLS[name]), np.array([0.01, 0.005]), np.zeros((1, removal.COLUMNS))
    expected = np.full((2, ROWS, COLUMNS), np.inf)
    for line in lines:
        heights, mean = before.copy(), before.copy()
        bounds = squares(heights, mean, bottom)
        removal.cut_lines(
            heights, mean, before, bottom, part, bounds, GRID, line[None].copy(), tool, limits, out
        )
        expected = np.minimum(expected, [heights, mean])
    heights, mean, out = before.copy(), before.copy(), np.zeros((len(lines), removal.COLUMNS))
    bounds = squares(heights, mean, bottom)
    removal.cut_lines(heights, mean, before, bottom, part, bounds, GRID, lines, tool, limits, out)
    np.testing.assert_array_equal([heights, mean], expected)
    volume = float((before - mean).sum() * CELL**2)
    assert out[:, 0].sum() == pytest.approx(volume, rel=1e-12)
    np.testing.assert_array_equal(squares(heights, mean, bottom), bounds)
