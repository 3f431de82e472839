"""The stock as seen obliquely: what stands in front hides what is behind."""

import math

import numpy as np
import pytest

from cncgen.removal.stock import box
from cncgen.report.removed import AZIMUTH, ELEVATION, seen_obliquely


def test_a_block_shows_its_top_and_two_sides():
    """By their areas, seen under an angle; nothing of the hidden pocket in its middle is seen through a side."""
    field = box((0, 0, -20), (60, 40, 0)).field(0.25)
    met, shade, (width, height) = seen_obliquely(field)
    dot = width * height
    top = 60 * 40 * math.sin(ELEVATION)
    sides = 20 * math.cos(ELEVATION) * (60 * -math.sin(AZIMUTH) + 40 * math.cos(AZIMUTH))
    assert (met > -0.3).sum() * dot == pytest.approx(top, rel=0.03)
    assert (~np.isnan(met)).sum() * dot == pytest.approx(top + sides, rel=0.02)
    assert shade[met > -1e-9].min() == 1.0
    assert shade[met < -10].max() < 0.7
    # A pocket of 20 x 20 mm, 15 mm deep: its walls in front hide a part of its floor.
    field.heights[40:120, 80:160] = -15.0
    cut, _, _ = seen_obliquely(field)
    outside = ~np.isnan(met) & (met < -0.3)
    np.testing.assert_array_equal(cut[outside], met[outside])
    hidden = 15 / math.tan(ELEVATION)
    floor = (20 - hidden * math.cos(AZIMUTH)) * (20 - hidden * -math.sin(AZIMUTH)) * math.sin(ELEVATION)
    assert ((cut < -14.8) & ~outside).sum() * dot == pytest.approx(floor, rel=0.15)
