"""Which ends of NURBS are rounded: between them and what they meet nothing else moves, in whatever parts it is written."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.geometry.nurbs import single
from cncgen.planner.smoothing.ends import opened
from cncgen.toolpath.record import Event, Kind, Toolpath
from tests.planner.smoothing.programs import chunked, toolpath


def beside_a_move(turned: list[float]) -> Toolpath:
    """A NURBS of 40 mm along X, moves of A to given places, rad, an event, and a line of 40 mm along Y."""
    points = np.zeros((4, 4))
    points[:, 0] = np.linspace(0.0, 40.0, 4)
    curve = single(3, np.repeat([0.0, 1.0], 4), points)
    ends = [points[-1], *([40.0, 0.0, 0.0, a] for a in turned)]
    ends += [ends[-1], [40.0, 40.0, 0.0, ends[-1][3]]]
    kind = [Kind.NURBS, *([Kind.LINE] * len(turned)), Kind.EVENT, Kind.LINE]
    index = [0, *([-1] * len(turned)), 0, -1]
    return toolpath(points[0], ends, kind, index, nurbs=curve, events=(Event("coolant"),), axes="XYZA")


@pytest.mark.parametrize("size", [1, 2, 100])
@pytest.mark.parametrize(
    ("turned", "rounded"),
    [([2e-9], False), ([5e-10, 1e-9, 1.5e-9, 2e-9], False), ([5e-10], True), ([5e-10, 0.0], True)],
)
def test_a_move_in_parts_below_a_standstill_stands_between(
    turned: list[float], rounded: bool, size: int
) -> None:
    """2 nrad of A are met exactly; in four, each as good as none, they once vanished, and the corner beside was rounded."""
    found = list(opened(chunked(beside_a_move(turned), size)))
    assert any(free.any() for _, free in found) == rounded
    assert sum(int((rows.kind == Kind.NURBS).sum()) for rows, _ in found) == 1 + rounded
