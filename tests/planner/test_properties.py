"""Properties of plans on a small fixed set of random programs; benchmarks/planner_properties.py tries thousands."""

from __future__ import annotations

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from cncgen.machine import load
from cncgen.pipeline import read
from cncgen.planner import plan
from cncgen.planner.motion import motion_at
from cncgen.planner.paths import path_of
from cncgen.planner.record import Limit

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


@pytest.mark.parametrize(
    ("program", "machine"), [("butterfly.nc", "xy-table"), ("butterfly_g1.nc", "generic-mill")]
)
def test_the_limit_that_is_named_is_reached(program: str, machine: str) -> None:
    """Pieces said to be held by jerk, acceleration or feed come within a twentieth of it, all but one in ten."""
    where = replace(load(machine), max_contour_error_mm=None)
    ratio: dict[Limit, list[np.ndarray]] = {Limit.JERK: [], Limit.ACCELERATION: [], Limit.FEED: []}
    for trajectory in plan(read(ROOT / "programs" / program).chunks(), where):
        profile = trajectory.profile
        for name, order in ((Limit.FEED, 0), (Limit.ACCELERATION, 1), (Limit.JERK, 2)):
            at = np.flatnonzero(profile.limit == name)
            share = np.linspace(0.0, 1.0, 9)
            t = (profile.t[at, None] + share * np.diff(profile.t)[at, None]).ravel()
            motion = motion_at(profile, t)
            if order == 0:
                rows = trajectory.toolpath.feed[path_of(trajectory.toolpath).row_of(motion.s)]
                found = motion.v / rows
            else:
                x = path_of(trajectory.toolpath).evaluate(motion.s, 3)[:, :, :2]
                v, a, j = motion.v[:, None], motion.a[:, None], motion.j[:, None]
                acceleration, jerk = x[2] * v**2 + x[1] * a, x[3] * v**3 + 3.0 * x[2] * v * a + x[1] * j
                axis = where.axes["X"]
                of = (acceleration / axis.max_acceleration, jerk / axis.max_jerk)[order - 1]
                found = np.abs(of).max(axis=1)
            ratio[name].append(found.reshape(len(at), len(share)).max(axis=1))
    for name, parts in ratio.items():
        reached = np.concatenate(parts)
        assert not len(reached) or np.mean(reached > 0.95) > 0.9, name
    assert sum(map(len, ratio[Limit.JERK])) > 100
