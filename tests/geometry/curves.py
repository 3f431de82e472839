"""Curves for the geometry tests: the published ones of programs/ by number, random ones, and paths made of them."""

from __future__ import annotations

import re
from pathlib import Path as File

import numpy as np
from hypothesis import strategies as st

from cncgen.geometry import nurbs
from cncgen.geometry.path import NURBS, Path
from cncgen.geometry.tables import NurbsTable, empty_arcs

PROGRAMS = File(__file__).resolve().parents[2] / "programs"


def program_curve(name: str) -> NurbsTable:
    """Read the G6.2 curve of a program by a plain pattern, as a table of one curve in X Y Z."""
    text = (PROGRAMS / f"{name}.nc").read_text()
    block = text[text.index("G6.2") if "G6.2" in text else text.index("G06.2") :]
    degree = int(re.search(r"P(\d)", block).group(1)) - 1
    knots, points, weights = [], [], []
    for line in block.splitlines():
        words = dict(re.findall(r"([A-Z])(-?[\d.]+)", line))
        if "K" not in words:
            break
        knots.append(float(words["K"]))
        if "X" in words:
            points.append([float(words["X"]), float(words["Y"]), float(words.get("Z", 0))])
            weights.append(float(words.get("R", 1)))
    return nurbs.single(degree, knots, points, weights)


def path_of_curve(table: NurbsTable, axes: str = "XYZ") -> Path:
    """Return the path of a table of one curve."""
    ends = table.control_points[[0, -1]]
    return Path(axes, ends[0], [NURBS], [ends[1]], [0], empty_arcs(), table)


@st.composite
def curves(draw: st.DrawFn, axes: int = 3, max_degree: int = 9) -> NurbsTable:
    """Draw a rational curve: any degree, clamped, knots with multiplicities up to the degree, weights over decades."""
    degree = draw(st.integers(1, max_degree))
    inner: list[float] = []
    at = 0.0
    for _ in range(draw(st.integers(0, 6))):
        at += draw(st.sampled_from([0.01, 0.3, 1.0, 7.0]))
        inner += [at] * draw(st.integers(1, degree))
    knots = [0.0] * (degree + 1) + inner + [at + 1.0] * (degree + 1)
    count = len(knots) - degree - 1
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    points = random.uniform(-100, 100, (count, axes))
    weights = 10 ** random.uniform(-1, 1, count)
    return nurbs.single(degree, knots, points, weights)
