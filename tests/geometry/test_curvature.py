"""Local extrema of curvature: the butterfly's published count, closed forms, plateaus."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.geometry.curvature import curvature_extrema
from cncgen.geometry.path import ARC, LINE, Path
from cncgen.geometry.tables import ArcTable, empty_arcs, empty_nurbs
from tests.geometry.curves import path_of_curve, program_curve


def test_butterfly_has_73_extrema() -> None:
    """37 maxima and 36 minima: the 73 of Tsai's paper; the largest 43.1355 /mm at u = 0.25634."""
    path = path_of_curve(program_curve("butterfly"))
    found = curvature_extrema(path)
    assert (len(found), np.count_nonzero(found.is_maximum)) == (73, 37)
    top = found.curvature.argmax()
    assert found.curvature[top] == pytest.approx(43.1355, abs=2e-4)
    assert path.parameter(0, found.s[[top]])[0] == pytest.approx(0.25634, abs=1e-5)


def test_extrema_are_those_of_dense_samples() -> None:
    path = path_of_curve(program_curve("trident"))
    found = curvature_extrema(path)
    for s, kappa, is_maximum in zip(found.s, found.curvature, found.is_maximum, strict=True):
        around = path.curvature(np.array([s - 1e-3, s + 1e-3]))
        assert np.all(around <= kappa + 1e-7) if is_maximum else np.all(around >= kappa - 1e-7)
    dense = path.curvature(np.linspace(0, path.length, 100001)).max()
    assert found.curvature.max() >= dense * (1 - 1e-9)


def test_arc_between_lines_is_one_maximum_at_its_middle() -> None:
    arc = ArcTable(np.array([[10.0, 5, 0]]), np.array([[0.0, 0, 1]]), np.array([np.pi / 2]))
    ends = [[10, 0, 0], [15, 5, 0], [15, 20, 0]]
    found = curvature_extrema(
        Path("XYZ", [0, 0, 0], [LINE, ARC, LINE], ends, [-1, 0, -1], arc, empty_nurbs(3))
    )
    assert len(found) == 1
    assert found.s[0] == pytest.approx(10 + 2.5 * np.pi / 2)
    assert found.curvature[0] == pytest.approx(0.2)


def test_a_circle_and_a_line_have_none() -> None:
    assert len(curvature_extrema(path_of_curve(program_curve("circle")))) == 0
    line = Path("XYZ", [0, 0, 0], [LINE], [[1, 0, 0]], [-1], empty_arcs(), empty_nurbs(3))
    assert len(curvature_extrema(line)) == 0
