"""Volumes and depths of cuts against closed forms, at a grid of 0.1 mm: 0.5 % and a cell."""

import math

import numpy as np
import pytest

from cncgen.pipeline.removing import cut_toolpaths
from cncgen.removal.cutters import cutter_of_option
from cncgen.removal.stock import box
from tests.removal.paths import arc, line, path_of

CELL = 0.1
TOP = 40.0
BOX = box((0, 0, -20), (TOP, 30, 0))


def cut(tool, *moves, start=(-20.0, 15.0, 5.0), stock=BOX):
    return cut_toolpaths(
        [path_of(start, *moves)], stock, cutters={"*": cutter_of_option(f"*={tool}")}, cell_mm=CELL
    )


def removed(removal):
    return removal.stock.raw_volume - removal.stock.volume


def close(removal, volume):
    assert removed(removal) == pytest.approx(volume, rel=5e-3)
    assert sum(o.volume_mm3 for o in removal.operations) == pytest.approx(removed(removal))


@pytest.mark.parametrize("width", [6.0, 7.3, 10.03])
@pytest.mark.parametrize("shift", [0.0, 0.037])
def test_a_slot_through_the_block(width, shift):
    y = 15.0 + shift
    out = cut(f"flat:{width}", line(-20, y, -4), line(60, y, -4))
    close(out, 40.0 * width * 4.0)
    assert out.stock.heights.min() == -4.0


@pytest.mark.parametrize("angle", [10.0, 33.0, 45.0])
def test_a_slot_with_round_ends_at_any_angle(angle):
    """Length times width, and a circle of both ends."""
    way = 8.0 * np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    a, b = np.array([20, 15]) - way, np.array([20, 15]) + way
    out = cut("flat:8", line(*a, 5), line(*a, -3), line(*b, -3))
    close(out, 3.0 * (16.0 * 8.0 + math.pi * 16.0))


def test_a_hole_of_a_drill():
    """A cylinder down to the end of the point's cone, less what stays beside the cone."""
    out = cut("drill:8,118", line(20, 15, 5), line(20, 15, -12))
    tip = 4.0 / math.tan(math.radians(59.0))
    close(out, math.pi * 16.0 * (12.0 - tip) + math.pi * 16.0 * tip / 3)
    assert out.stock.heights.min() == pytest.approx(-12.0, abs=CELL / math.tan(math.radians(59.0)))


def test_a_circular_pocket():
    """A ring of the tool about a circle: as large as the circle and the tool's radius together."""
    turns = [line(20, 15, -5)]
    for r in (2.0, 4.0, 6.0):
        turns += [line(20 + r, 15, -5), arc((20 + r, 15, -5), (20, 15, -5), 2 * math.pi)]
    close(cut("flat:6", line(20, 15, 5), *turns), math.pi * 81.0 * 5.0)


def test_a_helix_down_and_its_floor():
    turns = [
        line(23, 15, 0),
        arc((23, 15, -6), (20, 15, 0), 6 * math.pi),
        arc((23, 15, -6), (20, 15, -6), 2 * math.pi),
    ]
    close(cut("flat:8", line(23, 15, 5), *turns), math.pi * 49.0 * 6.0)


def test_a_chamfer_along_an_edge():
    """The cone of 90 degrees leaves a triangle of 2 mm by 2 mm along the block's edge."""
    out = cut("chamfer:20,90", line(-20, 30, -2), line(60, 30, -2))
    close(out, 40.0 * 2.0)


def test_a_bull_nose_in_a_slot():
    """A section of 10 mm by 4, less two corners (1 - π/4) r²."""
    close(cut("bull:10,2", line(-20, 15, -4), line(60, 15, -4)), 40.0 * (40.0 - 2 * (1 - math.pi / 4) * 4.0))


@pytest.mark.parametrize("rise", [0.0, 0.3, -0.3])
def test_a_ball_over_a_slope(rise):
    """A ball along a slope leaves a cylinder about it: over the slope's length the section is that of the ball, upright.

    At the depth d of the axis' path below the top the section across is a half circle below it and two walls; what is
    taken at a place along X is (R² π / 2) / cos a, the ellipse of the inclined cylinder, and 2 R times the height above.
    """
    radius = 4.0
    low, high = -12.0 - 20.0 * rise, -12.0 + 20.0 * rise
    run = 80.0 * rise
    out = cut(
        "ball:8",
        line(-20, 15, low - 20 * rise),
        line(60, 15, high + 20 * rise),
        stock=box((0, 0, -40), (40, 30, 0)),
    )
    mean_axis = -12.0 + radius
    ellipse = math.pi * radius * radius * math.hypot(1.0, rise) / 2
    close(out, 40.0 * (2 * radius * -mean_axis + ellipse))
    # Straight below the axis the envelope is R (1 / cos a - 1) below the tip's line.
    middle = out.stock.heights[np.abs(out.stock.y - 15.05).argmin(), np.abs(out.stock.x - 20.05).argmin()]
    expected = -12.0 + 0.05 * rise + radius - radius * math.hypot(1.0, rise)
    assert middle == pytest.approx(expected, abs=0.01)
    assert run == 80.0 * rise


def test_a_ramp_of_a_flat_tool():
    """Straight down a slope the lowest point over a place is where the rear of the tool passes it, R tan a lower."""
    out = cut("flat:8", line(-20, 15, 0), line(60, 15, -16))
    k = np.abs(out.stock.x - 20.05).argmin()
    j = np.abs(out.stock.y - 15.05).argmin()
    reach = math.sqrt(16.0 - 0.05**2)
    assert out.stock.heights[j, k] == pytest.approx(-0.2 * (40.05 + reach), abs=1e-6)


def test_a_bull_nose_down_a_slope_is_the_lowest_of_its_places():
    """Against the least of 4,000 places along the way, cell by cell."""
    cutter = cutter_of_option("*=bull:10,2")
    out = cut("bull:10,2", line(5, 10, -1), line(35, 20, -9), start=(5.0, 10.0, 5.0))
    t = np.linspace(0, 1, 4001)
    places = np.array([5.0, 10.0, -1.0]) + t[:, None] * np.array([30.0, 10.0, -8.0])
    rng = np.random.default_rng()
    for _ in range(60):
        j, i = int(rng.integers(300)), int(rng.integers(400))
        x, y = out.stock.x[i], out.stock.y[j]
        heights = places[:, 2] + cutter.height(np.hypot(x - places[:, 0], y - places[:, 1]))
        expected = min(0.0, float(heights.min()))
        assert (
            out.stock.heights[j, i] == pytest.approx(expected, abs=2e-3)
            or abs(np.hypot(x - places[:, 0], y - places[:, 1]).min() - 5.0) < 0.05
        )


def test_a_cylinder_of_stock():
    from cncgen.removal.stock import stock_of_option

    field = stock_of_option("cylinder:20,15,20,-10,0").field(CELL)
    assert field.raw_volume == pytest.approx(math.pi * 100.0 * 10.0, rel=5e-3)


def test_a_cell_that_a_deep_cut_covered_in_part_is_cut_by_a_shallow_one():
    """The wall of a hole through the block lies 0.01 cells beyond the middle of cells; a slot over it has its floor there too."""
    out = cut(
        "flat:10.04",
        line(20, 15, 5),
        line(20, 15, -25),
        line(20, 15, 5),
        line(-20, 15, 5),
        line(-20, 15, -4),
        line(60, 15, -4),
    )
    x, y = np.meshgrid(out.stock.x, out.stock.y)
    slot = (np.abs(y - 15.0) < 5.0) & (np.hypot(x - 20.0, y - 15.0) > 5.1)
    assert (out.stock.heights[slot] == -4.0).all()
    ring = (np.abs(np.hypot(x - 20.0, y - 15.0) - 5.02) < 0.05) & (np.abs(y - 15.0) < 4.9)
    assert ring.sum() > 100
    assert out.stock.heights[ring].max() == -4.0
