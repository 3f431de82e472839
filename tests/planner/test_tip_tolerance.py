"""Where rotary axes carry the tip of the tool, the tolerance of continuous motion is the tip's, not that of the axes alone.

The tip comes from the axes by rotation matrices of this file: p = c + T (m - c - H L z), of the docstring of `cncgen.machine.kinematics`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import cncgen
from cncgen.machine import Axis, Machine
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]


def distance_to_polyline(points: Floats, vertices: Floats) -> Floats:
    """Return the distance of each point, shape (n, k), from the nearest of the lines between vertices, shape (m, k)."""
    a, way = vertices[:-1], np.diff(vertices, axis=0)
    on = np.clip(np.einsum("nmk,mk->nm", points[:, None] - a, way) / (way**2).sum(1), 0.0, 1.0)
    away = points[:, None] - (a + on[..., None] * way)
    return np.asarray(np.linalg.norm(away, axis=2).min(axis=1))


AXES = {letter: Axis(letter, 500.0, 3000.0, 5e4) for letter in "XYZ"} | {
    letter: Axis(letter, np.radians(180.0), np.radians(1000.0), np.radians(2e4)) for letter in "AC"
}
CENTRE = np.array([0.0, 0.0, -200.0])
LENGTH = 150.0
TABLES = {"model": "table-table", "axes": ["a", "c"], "centre_mm": CENTRE.tolist()}
HEADS = {"model": "head-head", "axes": ["c", "a"], "pivot_mm": 0.0}


def five_axes(kinematics: dict[str, object]) -> Machine:
    return Machine("five axes", AXES, period_s=0.001, settings={"kinematics": kinematics})


def corners(seed: int) -> Floats:
    """Shape (n, 5), mm and degrees: lines of some mm that turn sharply, in all five axes."""
    rng = np.random.default_rng(seed)
    start = np.array([30.0, 0.0, 0.0, 20.0, 0.0])
    return np.round(np.cumsum(rng.uniform(-6.0, 6.0, (12, 5)), axis=0) + start, 3)


def program(points: Floats) -> str:
    rows = ["O1", "G21 G90 G94", "G10 L10 P1 R150.", "G43.4 H1", "G61"]
    rows += [" ".join(["G1", *(f"{x}{v:.3f}" for x, v in zip("XYZAC", points[0], strict=True)), "F2000"])]
    rows += ["G64"]
    rows += [" ".join(f"{x}{v:.3f}" for x, v in zip("XYZAC", p, strict=True)) for p in points[1:]]
    return "\n".join([*rows, "G49", "M30", ""])


def tips(setpoints: Setpoints, heads: bool) -> Floats:
    """Return where the tip is on the workpiece, shape (n, 3)."""
    at = {letter: setpoints.position[:, k] for k, letter in enumerate(setpoints.axes)}
    slides = np.column_stack([at["X"], at["Y"], at["Z"]])
    if heads:
        # The spindle is turned by A, and A by C: H = R_C R_A.
        arm = Rotation.from_euler("xz", np.column_stack([at["A"], at["C"]]))
        return np.asarray(slides - arm.apply([0.0, 0.0, LENGTH]))
    table = Rotation.from_euler("xz", np.column_stack([at["A"], at["C"]]))
    return np.asarray(CENTRE + table.apply(slides - CENTRE - [0.0, 0.0, LENGTH]))


@pytest.mark.parametrize("effort", ["best", "fast"])
@pytest.mark.parametrize("heads", [False, True], ids=["tables", "heads"])
def test_the_tip_stays_within_the_tolerance(heads: bool, effort: str) -> None:
    """Beside it lines of the axes may be 1 µm from the tip's path. Without the lever the tip was up to 3 times the tolerance away."""
    machine = five_axes(HEADS if heads else TABLES)
    farthest = []
    for seed in range(3):
        points = corners(seed)
        read = cncgen.read_text(program(points), dialect="fanuc")
        setpoints = cncgen.sample(cncgen.plan(read, machine, effort=effort, path_tolerance_mm=0.05)).collect()
        assert cncgen.judge(setpoints, read, machine, tolerance_mm=0.05).holds
        tip = tips(setpoints, heads)
        first = int(np.argmin(np.linalg.norm(tip - points[0, :3], axis=1)))
        assert tip[-1] == pytest.approx(points[-1, :3], abs=1e-6)
        farthest.append(distance_to_polyline(tip[first:], points[:, :3]).max())
    assert max(farthest) <= 0.05 + 0.001 + 1e-6
    assert max(farthest) > 0.01


def test_verify_holds_the_tip_to_the_tolerance() -> None:
    """C turned by 0.1 degrees takes a tip that is 200 mm from it away by 0.35 mm, though the axes are off by 0.1."""
    machine = five_axes({**TABLES, "centre_mm": [-200.0, 0.0, -200.0]})
    points = corners(1)
    read = cncgen.read_text(program(points), dialect="fanuc")
    setpoints = cncgen.sample(cncgen.plan(read, machine, path_tolerance_mm=0.01)).collect()
    assert cncgen.judge(setpoints, read, machine, tolerance_mm=0.2).holds
    setpoints.position[:, setpoints.axes.index("C")] += np.radians(0.1)
    assert not cncgen.judge(setpoints, read, machine, tolerance_mm=0.2).holds


def test_the_tip_on_a_face_that_turns(tmp_path: Path) -> None:
    """G12.1 at 150 mm from the axis of C, where a degree is 2.6 mm."""
    machine = Machine("lathe", {letter: AXES[letter] for letter in "XZC"}, period_s=0.001)
    square = np.array([[150.0, 0.0], [150.0, 5.0], [140.0, 5.0], [140.0, -5.0], [150.0, -5.0], [150.0, 0.0]])
    # X is a diameter.
    rows = "\n".join(f"G1 X{2 * x:g} C{y:g} F3000" for x, y in square)
    text = f"O1\nG21 G98\nG0 X300. C0\nG12.1\n{rows}\nG13.1\nM30\n"
    read = cncgen.read_text(text, dialect="fanuc-lathe")
    setpoints = cncgen.sample(cncgen.plan(read, machine, path_tolerance_mm=0.05)).collect()
    radius, angle = (setpoints.position[:, setpoints.axes.index(letter)] for letter in "XC")
    tip = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    start = int(np.argmax(radius > 150.0 - 1e-6))
    off = distance_to_polyline(tip[start:], square)
    assert 0.01 < off.max() <= 0.05 + 0.001 + 1e-6


def test_a_degree_counts_as_the_machine_says() -> None:
    """Cauchy and Schwarz: |Δx| + R |Δθ| ≤ |(Δx, g Δθ)| (1 + (R/g)²)^½, with R in mm a degree; a degree is 2 mm with `[kinematics]`."""
    tables = {**TABLES, "degree_mm": 3.5}
    assert [five_axes(each).degree_mm for each in (TABLES, tables)] == [2.0, 3.5]
    assert Machine("three axes", AXES).degree_mm == 1.0
    points = corners(2)
    read = cncgen.read_text(program(points), dialect="fanuc")
    for machine in (five_axes({**TABLES, "degree_mm": 1.0}), five_axes(tables)):
        setpoints = cncgen.sample(cncgen.plan(read, machine, path_tolerance_mm=0.05)).collect()
        assert cncgen.judge(setpoints, read, machine, tolerance_mm=0.05).holds
        tip = tips(setpoints, heads=False)
        first = int(np.argmin(np.linalg.norm(tip - points[0, :3], axis=1)))
        assert 0.01 < distance_to_polyline(tip[first:], points[:, :3]).max() <= 0.05 + 0.001 + 1e-6


def test_verify_counts_a_degree_as_the_machine_says() -> None:
    """A is 0.006 degrees off a path along X alone: 0.006 mm, 0.012 mm with `[kinematics]`; P is 0.01 mm."""
    rows = np.linspace(0.0, 10.0, 2001)
    position = np.column_stack([rows, 0 * rows, 0 * rows, np.full(len(rows), np.radians(0.006))])
    position[[0, -1], 3] = 0.0
    read = cncgen.read_text("G21 G90 G64 P0.01\nG1 X10 A0 F300\nM2\n", dialect="linuxcnc")
    plain = Machine("four axes", {k: AXES[k] for k in "XYZA"}, period_s=0.001)
    verdicts = [
        cncgen.judge(Setpoints("XYZA", 0.001, 0, position), read, machine).setpoints_to_path_mm
        for machine in (plain, five_axes(TABLES))
    ]
    assert verdicts == [pytest.approx(0.006, rel=1e-6), pytest.approx(0.012, rel=1e-6)]
