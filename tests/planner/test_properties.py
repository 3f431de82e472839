"""Properties of plans on a small fixed set of random programs; benchmarks/planner_properties.py tries thousands."""

from __future__ import annotations

import importlib.util
import math
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings

ROOT = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location(
    "planner_properties", ROOT / "benchmarks" / "planner_properties.py"
)
assert _spec is not None
assert _spec.loader is not None
properties = importlib.util.module_from_spec(_spec)
sys.modules["planner_properties"] = properties
_spec.loader.exec_module(properties)

ALIKE = ((100.0, 1000.0, 1e4),) * 4


@pytest.mark.parametrize("name", ["limits", "continuous", "splitting", "reversing", "bounds"])
def test_random_programs(name: str) -> None:
    """Each property on a few random paths."""
    check, kinds = properties.PROPERTIES[name]

    @settings(max_examples=4)
    @given(properties.cases(**kinds))
    def tried(case: properties.Case) -> None:  # type: ignore[name-defined]
        check(case)

    tried()


@pytest.mark.parametrize("feed", [10.0, 100.0, 1000.0, 6000.0])
def test_lines_there_and_back_split(feed: float) -> None:
    """Rest-to-rest lines at any feed, cut in three (once up to 11 % apart where the feed is slow)."""
    moves = (properties.Line((1.0, 0.0, 0.0, 0.0)), properties.Line((-1.0, 0.0, 0.0, 0.0)))
    properties.splitting(properties.Case(moves, feed, False, "G61", ALIKE))


def test_arcs_by_inverse_time_in_another_unit() -> None:
    """Rows whose speeds differ by rounding alone count as one (once 1e-5 apart, with seven times the nodes)."""
    moves = (properties.Arc(1.0, 0.0, -1.0, 0.0), properties.Arc(1.0, 0.0, -1.0, 0.0))
    properties.units(properties.Case(moves, 10.0, True, "G61", ALIKE))


def test_full_circles_reversed_and_bounded() -> None:
    """Twice round, at a feed that the circle cannot be driven with."""
    moves = (properties.Arc(1.0, 0.0, -2.0 * math.pi, 0.0),) * 2
    case = properties.Case(moves, 10_000.0, False, "G61", ALIKE)
    properties.reversing(case)
    properties.bounds(case)
    properties.limits(case)
